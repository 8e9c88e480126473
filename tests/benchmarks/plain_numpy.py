"""Geometric Jacobians of batches as one would write them in numpy, in two layouts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def batch_first(screws: Array, home: Array, q: Array) -> Array:
    """Jacobians (N, 6, n) by products of exponentials with the batch in front.

    Rotations multiply as stacks of matrices; what does not depend on q is worked out once a joint.
    """
    R, p = np.eye(3), np.zeros(3)
    linear, angular = np.empty((2, len(screws), len(q), 3))
    for i, (screw, value) in enumerate(zip(screws, q.T, strict=True)):
        v, omega = screw[:3], screw[3:]
        angular[i] = R @ omega
        linear[i] = R @ v + cross(p, angular[i])
        if omega.any():
            W, s, c = np.cross(np.eye(3), omega), np.sin(value)[:, None, None], np.cos(value)[:, None, None]
            nearest = np.cross(omega, v)  # point of the axis, which the motion leaves where it is
            p = p + R @ nearest
            R = R @ (np.eye(3) + s * W + (1 - c) * (W @ W))
            p = p - R @ nearest
        else:
            p = p + value[:, None] * (R @ v)
    linear += cross(angular, p + R @ home[:3, 3])
    return np.concatenate([linear, angular], axis=-1).transpose(1, 2, 0)


def batch_last(screws: Array, home: Array, q: Array) -> Array:
    """Return the same with the batch last, so that each operation runs over contiguous memory."""
    N = len(q)
    R, p = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, N)), np.zeros((3, N))
    linear, angular = np.empty((2, 3, len(screws), N))
    for i, (screw, value) in enumerate(zip(screws, np.ascontiguousarray(q.T), strict=True)):
        v, omega = screw[:3], screw[3:]
        angular[:, i] = np.einsum("rcN,c->rN", R, omega)
        linear[:, i] = np.einsum("rcN,c->rN", R, v) + cross(p.T, angular[:, i].T).T
        if omega.any():
            W, s, c = np.cross(np.eye(3), omega), np.sin(value), np.cos(value)
            nearest = np.cross(omega, v)
            p = p + np.einsum("rcN,c->rN", R, nearest)
            turn = np.eye(3)[:, :, None] + s * W[:, :, None] + (1 - c) * (W @ W)[:, :, None]
            R = np.einsum("rkN,kcN->rcN", R, turn)
            p = p - np.einsum("rcN,c->rN", R, nearest)
        else:
            p = p + value * np.einsum("rcN,c->rN", R, v)
    tool = p + np.einsum("rcN,c->rN", R, home[:3, 3])
    linear += cross(angular.transpose(1, 2, 0), tool.T).transpose(2, 0, 1)
    return np.concatenate([linear, angular]).transpose(2, 0, 1)


def cross(a: Array, b: Array) -> Array:
    """Cross product over the last axis; faster on batches than numpy's, and laid out as its arguments."""
    (ax, ay, az), (bx, by, bz) = np.moveaxis(a, -1, 0), np.moveaxis(b, -1, 0)
    return np.moveaxis(np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]), 0, -1)
