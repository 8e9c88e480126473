"""w, KCI and their gradients by each of the libraries and styles that the package is compared with.

Jacobians of the other libraries are geometric ones, and so is the KCI here. Each takes q (N, 12), or one
(12,) where it knows no batches, and returns values (N,), or values and gradients (N, 12).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import pinocchio
import plain_numpy
import torch
from torch import Tensor

from dexterity.chain import Chain
from dexterity.indices import Index
from dexterity.symbolic import compile_index
from peer_models import pinocchio_model, pytorch_kinematics_chain, roboticstoolbox_transforms
from serial_chains import SerialRobot

Function: TypeAlias = Callable[[Any], Any]
STEP = 1e-6  # of the finite differences


@dataclass(frozen=True)
class Peer:
    """A way to compute an index.

    Attributes
    ----------
    value, value_and_gradient
        Functions of q; None where it is not for that.
    takes
        ``"tensors"``, ``"arrays"``, or ``"rows"``: arrays of one configuration.
    most
        Configurations that it is given at most, so that slow ways do not take minutes.
    """

    name: str
    value: Function | None
    value_and_gradient: Function | None
    takes: str
    most: int = 100_000

    def given(self, q: Tensor) -> Callable[[Function], Any]:
        """Return how to call a function of this way on as many of the configurations as it is given."""
        inputs: Any = q[: self.most] if self.takes == "tensors" else q[: self.most].numpy()
        if self.takes != "rows":
            return lambda function: function(inputs)
        if len(inputs) == 1:
            return lambda function: function(inputs[0])
        return lambda function: [function(row) for row in inputs]


def ours(chain: Chain, index: Index) -> list[Peer]:
    peers = []
    for backend, name in (("c", "C"), ("torch", "generated torch")):
        f = compile_index(chain, index, backend=backend)
        peers.append(Peer(f"dexterity, {name}", f, f.value_and_gradient, "tensors"))
    single, shared = compile_index(chain, index, "c"), compile_index(chain, index, "c", threads=2)
    peers.append(Peer("dexterity, C, two threads", shared, shared.value_and_gradient, "tensors"))
    peers.append(Peer("dexterity, C, numpy in and out", single, None, "rows", most=1))
    return peers


def others(chain: Chain, robot: SerialRobot, index: Index) -> list[Peer]:
    return [
        torch_compile(chain, index),
        *batched_torch(chain, index),
        *batched_numpy(chain, index.name),
        pinocchio_and_numpy(robot, index.name),
        roboticstoolbox(robot, index.name),
        pytorch_kinematics(robot, index.name),
    ]


# ---- from a Jacobian to the index ------------------------------------------------------------------


def tensor_measure(name: str) -> Function:
    def manipulability(J: Tensor) -> Tensor:
        return torch.linalg.det(J @ J.mT).sqrt()

    def kinematic_conditioning(J: Tensor) -> Tensor:
        sigma = torch.linalg.svdvals(J)
        return sigma[..., -1] / sigma[..., 0]

    return {"manipulability": manipulability, "kinematic_conditioning": kinematic_conditioning}[name]


def array_measure(name: str) -> Function:
    def manipulability(J: np.ndarray) -> Any:
        return np.sqrt(np.linalg.det(J @ J.swapaxes(-1, -2)))

    def kinematic_conditioning(J: np.ndarray) -> Any:
        sigma = np.linalg.svd(J, compute_uv=False)
        return sigma[..., -1] / sigma[..., 0]

    return {"manipulability": manipulability, "kinematic_conditioning": kinematic_conditioning}[name]


def by_autograd(function: Function) -> Function:
    def value_and_gradient(q: Tensor) -> tuple[Tensor, Tensor]:
        q = q.detach().requires_grad_()
        value = function(q)
        (gradient,) = torch.autograd.grad(value.sum(), q)
        return value.detach(), gradient

    return value_and_gradient


# ---- the others ------------------------------------------------------------------------------------


def torch_compile(chain: Chain, index: Index) -> Peer:
    """Return the generated torch code through ``torch.compile``, which takes half a minute."""
    return Peer("dexterity, torch.compile", compile_index(chain, index, "inductor"), None, "tensors")


def batched_torch(chain: Chain, index: Index) -> Sequence[Peer]:
    """For w the determinant is faster than the singular values of `Index.bind`; KCI needs these anyway."""
    bound = index.bind(chain)
    peers = [Peer("batched torch, svd (Index.bind)", bound, by_autograd(bound), "tensors")]
    if index.name == "manipulability":
        measure = tensor_measure(index.name)

        def value(q: Tensor) -> Tensor:
            return measure(chain.geometric_jacobian(q))

        peers.append(Peer("batched torch, determinant", value, by_autograd(value), "tensors"))
    return peers


def batched_numpy(chain: Chain, name: str) -> Sequence[Peer]:
    measure, screws, home = array_measure(name), chain.screws.numpy(), chain.home.numpy()

    def batch_first(q: np.ndarray) -> Any:
        return measure(plain_numpy.batch_first(screws, home, q))

    def batch_last(q: np.ndarray) -> Any:
        return measure(plain_numpy.batch_last(screws, home, q))

    def by_differences(q: np.ndarray) -> tuple[Any, Any]:
        steps = STEP * np.concatenate([np.eye(12), -np.eye(12)])
        moved = batch_last((q[:, None] + steps).reshape(-1, 12)).reshape(-1, 2, 12)
        return batch_last(q), (moved[:, 0] - moved[:, 1]) / (2 * STEP)

    return (
        Peer("batched numpy", batch_first, None, "arrays"),
        Peer("batched numpy, batch axis last", batch_last, None, "arrays"),
        Peer("batched numpy, central differences", None, by_differences, "arrays", most=1_000),
    )


def pinocchio_and_numpy(robot: SerialRobot, name: str) -> Peer:
    model, tool = pinocchio_model(robot)
    data, frame = model.createData(), pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED

    def manipulability(q: np.ndarray) -> float:
        J = pinocchio.computeFrameJacobian(model, data, q, tool, frame)
        return math.sqrt(np.linalg.det(J @ J.T))

    def kinematic_conditioning(q: np.ndarray) -> float:
        J = pinocchio.computeFrameJacobian(model, data, q, tool, frame)
        sigma = np.linalg.svd(J, compute_uv=False)
        return sigma[-1] / sigma[0]

    def jacobian_and_hessian(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return J (6, 12) and its derivatives (6, 12, 12), the joint that moves last."""
        pinocchio.computeJointKinematicHessians(model, data, q)
        J = pinocchio.getFrameJacobian(model, data, tool, frame)
        # The numbers come column by column under a shape and strides that say row by row (pin 4.1).
        return J, pinocchio.getFrameKinematicHessian(model, data, tool, frame).reshape(12, 12, 6).T

    def manipulability_and_gradient(q: np.ndarray) -> tuple[float, np.ndarray]:
        J, H = jacobian_and_hessian(q)
        JJt = J @ J.T
        w = math.sqrt(np.linalg.det(JJt))
        return w, w * (np.linalg.solve(JJt, J).ravel() @ H.reshape(72, 12))

    def conditioning_and_gradient(q: np.ndarray) -> tuple[float, np.ndarray]:
        J, H = jacobian_and_hessian(q)
        U, sigma, Vt = np.linalg.svd(J, full_matrices=False)
        kci = sigma[-1] / sigma[0]
        weights = (np.outer(U[:, -1], Vt[-1]) - kci * np.outer(U[:, 0], Vt[0])) / sigma[0]
        return kci, weights.ravel() @ H.reshape(72, 12)

    functions = {
        "manipulability": (manipulability, manipulability_and_gradient),
        "kinematic_conditioning": (kinematic_conditioning, conditioning_and_gradient),
    }
    return Peer("pinocchio + numpy, one by one", *functions[name], "rows", most=1_000)


def roboticstoolbox(robot: SerialRobot, name: str) -> Peer:
    transforms = roboticstoolbox_transforms(robot)

    def manipulability(q: np.ndarray) -> float:
        return transforms.manipulability(q, method="yoshikawa")

    def kinematic_conditioning(q: np.ndarray) -> float:
        return transforms.manipulability(q, method="invcondition")

    def manipulability_and_gradient(q: np.ndarray) -> tuple[float, np.ndarray]:
        return manipulability(q), transforms.jacobm(q)[:, 0]

    functions = {
        "manipulability": (manipulability, manipulability_and_gradient),
        "kinematic_conditioning": (kinematic_conditioning, None),
    }
    return Peer("roboticstoolbox, one by one", *functions[name], "rows", most=200)


def pytorch_kinematics(robot: SerialRobot, name: str) -> Peer:
    chain, measure = pytorch_kinematics_chain(robot), tensor_measure(name)

    def value(q: Tensor) -> Tensor:
        return measure(chain.jacobian(q))

    return Peer("pytorch_kinematics", value, by_autograd(value), "tensors", most=10_000)
