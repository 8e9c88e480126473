"""Networks under torch's tools: each gives what the plain call gives. Case 9 of the library review.

pytorch_kinematics#66 and its pull request #26 are users' threads on vmap, compile and export.
"""

from pathlib import Path

import pytest
import torch

from dexterity import networks
from example_networks import examples, random_configurations
from warm_process import WarmProcess

NETWORKS = examples()
ALL = pytest.mark.parametrize("network", NETWORKS.values(), ids=NETWORKS)


@ALL
def test_vmap(rng, network):
    q = random_configurations(rng, 5)
    torch.testing.assert_close(torch.func.vmap(network)(q), network(q), rtol=1e-13, atol=0)
    slopes = torch.func.vmap(torch.func.grad(network))(q)
    q.requires_grad_()
    (expected,) = torch.autograd.grad(network(q).sum(), q)
    torch.testing.assert_close(slopes, expected, rtol=1e-12, atol=1e-15)


@pytest.mark.filterwarnings("ignore:.torch.jit.script. is deprecated:DeprecationWarning")
@ALL
def test_second_and_forward_derivatives(rng, network):
    q = random_configurations(rng, 1)[0]
    jacobian = torch.func.jacrev(network)(q)
    torch.testing.assert_close(torch.func.jacfwd(network)(q), jacobian, rtol=1e-10, atol=1e-13)
    hessian = torch.func.hessian(network)(q)
    step = 1e-5 * torch.eye(len(q), dtype=torch.float64)
    slope = torch.func.jacrev(network)
    differences = torch.stack([(slope(q + s) - slope(q - s)) / 2e-5 for s in step])
    torch.testing.assert_close(hessian, differences, rtol=1e-4, atol=1e-6)


TRACED = """
import sys, numpy as np, torch
sys.path.insert(0, {folder!r})
from example_networks import examples, random_configurations

networks, rng = examples(), np.random.default_rng(0)
q = random_configurations(rng, 5)
for name in ("triple, origin and joints", "radial basis, joints"):
    network = networks[name]
    compiled = torch.compile(network, fullgraph=True, backend="eager")
    torch.testing.assert_close(compiled(q), network(q), rtol=1e-13, atol=0)
    batch = torch.export.Dim("batch", min=2)
    exported = torch.export.export(network, (q,), dynamic_shapes=({{0: batch}},)).module()
    for rows in (2, 5, 1000):
        more = random_configurations(rng, rows)
        torch.testing.assert_close(exported(more), network(more), rtol=1e-13, atol=0)
"""


def test_compile_and_export():
    """In a process whose annotations nobody checks: torch cannot trace the checks of tests."""
    code = TRACED.format(folder=str(Path(__file__).parents[1]))
    ended, printed = WarmProcess(code).end()
    assert ended == 0, printed


@ALL
def test_single_precision_is_raised(rng, network):
    q = random_configurations(rng, 3).float()
    assert network(q).dtype == torch.float64
    assert torch.equal(network(q), network(q.double()))


def test_another_default_device_changes_nothing(rng):
    """pytorch_kinematics#39: constants on the CPU, inputs elsewhere. The meta device stands for a GPU."""
    name, q = "uvms-manipulability-feed-forward", random_configurations(rng, 3)
    expected = networks.load_shipped(name)(q)
    with torch.device("meta"):
        network = networks.load_shipped(name)
        answers = network(q)
    assert torch.equal(answers, expected)
    assert network.to("meta").answer(torch.zeros(4, network.view.width, device="meta")).shape == (4,)
