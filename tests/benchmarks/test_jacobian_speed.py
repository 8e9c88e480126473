"""How long geometric Jacobians of the UVMS take, beside what one would write or use otherwise.

All are first compared with each other. ``make bench`` prints the table.
"""

from __future__ import annotations

import numpy as np
import pinocchio
import plain_numpy
import torch
from alone import PEERS, results, run_alone

import dexterity as dx
from dexterity import timing
from dexterity.timing import Way
from peer_models import pinocchio_model, pytorch_kinematics_chain, roboticstoolbox_transforms
from serial_chains import paper_uvms

BATCH = 100_000
FEW = 1_000  # the time of one configuration does not depend on how many more are worked out alike
TITLE = "Geometric Jacobians of the 12-joint UVMS, float64, per configuration"


def test_geometric_jacobians_are_faster_than_plain_numpy_and_pytorch_kinematics():
    ratio = run_alone(__file__, "jacobians").set_index("way")["ratio"]
    assert ratio["numpy"] >= 1.5
    assert ratio["pytorch_kinematics"] > 1
    assert ratio["pytorch_kinematics, 1,000 at a time"] > 1


def ways_to_compute() -> list[Way]:
    chain, robot = dx.robots.uvms(), paper_uvms()
    screws, home = chain.screws.numpy(), chain.home.numpy()
    peer, transforms = pytorch_kinematics_chain(robot), roboticstoolbox_transforms(robot)
    model, tool = pinocchio_model(robot)
    data, frame = model.createData(), pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
    q = torch.from_numpy(np.random.default_rng(0).uniform(-1, 1, (BATCH, 12)))
    few = q[:FEW].numpy()
    return [
        Way("dexterity", lambda: chain.geometric_jacobian(q), BATCH),
        Way("numpy", lambda: plain_numpy.batch_first(screws, home, q.numpy()), BATCH),
        Way("numpy, batch axis last", lambda: plain_numpy.batch_last(screws, home, q.numpy()), BATCH),
        Way("pytorch_kinematics", lambda: peer.jacobian(q), BATCH),
        Way("pytorch_kinematics, 1,000 at a time", lambda: peer.jacobian(q[:FEW]), FEW),
        Way(
            "pinocchio, one by one",
            lambda: [pinocchio.computeFrameJacobian(model, data, one, tool, frame) for one in few],
            FEW,
        ),
        Way("roboticstoolbox, one by one", lambda: [transforms.jacob0(one) for one in few], FEW),
    ]


def check_that_they_agree(ways: list[Way]) -> None:
    expected = np.asarray(ways[0].compute())
    for way in ways:
        J = np.asarray(way.compute())
        np.testing.assert_allclose(J, expected[: way.configurations], rtol=0, atol=1e-12, err_msg=way.name)


if __name__ == "__main__":
    ways = ways_to_compute()
    check_that_they_agree(ways)
    table = timing.table(timing.measure(ways, rounds=3, seconds=0.3), "dexterity")
    timing.write(results("jacobians"), table, timing.conditions(*PEERS), TITLE)
