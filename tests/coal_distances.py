"""Distances of the same bodies by coal, pair by pair."""

from __future__ import annotations

import coal
import numpy as np
import torch
from numpy.typing import NDArray

from dexterity import spatial
from dexterity.collision import Bodies, Body, Box, Sphere

Poses = NDArray[np.float64]


def coal_distances(bodies: Bodies, q: torch.Tensor, T_world_base: torch.Tensor) -> NDArray[np.float64]:
    """Signed distances (N, pairs) at configurations (N, n) and poses of the base (N, 4, 4)."""
    moved = _displacements(bodies, q, T_world_base)
    names, shapes = bodies.names, [_shape(body) for body in bodies.bodies]
    pairs = [(names.index(a), names.index(b)) for a, b in bodies.pairs]
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = 1e-12
    request.gjk_max_iterations = request.epa_max_iterations = 1000
    found = np.empty((len(q), len(pairs)))
    for i in range(len(q)):
        placed = [
            coal.Transform3s(T[i, :3, :3] @ own[:3, :3], T[i, :3, :3] @ own[:3, 3] + T[i, :3, 3])
            for T, (_, own) in zip(moved, shapes, strict=True)
        ]
        for k, (a, b) in enumerate(pairs):
            result = coal.DistanceResult()
            found[i, k] = coal.distance(shapes[a][0], placed[a], shapes[b][0], placed[b], request, result)
    return found


def _displacements(bodies: Bodies, q: torch.Tensor, T_world_base: torch.Tensor) -> list[Poses]:
    """Where each body's home frame is in the world, (N, 4, 4) each."""
    chain = bodies.chain
    home = chain.joint_frames(torch.zeros(chain.joints, dtype=torch.float64))
    links = T_world_base[:, None] @ chain.joint_frames(q) @ spatial.inverse(home)
    still = torch.eye(4, dtype=torch.float64).expand(len(q), 4, 4)
    return [
        (
            still if body.link == "world" else T_world_base if body.link == 0 else links[:, body.link - 1]
        ).numpy()
        for body in bodies.bodies
    ]


def _shape(body: Body) -> tuple[coal.ShapeBase, Poses]:
    """Return a shape of coal, and its pose at home."""
    shape, T = body.shape, np.eye(4)
    if isinstance(shape, Box):
        T[:3, 3] = shape.centre
        if shape.rotation is not None:
            T[:3, :3] = shape.rotation
        return coal.Box(*shape.size), T
    if isinstance(shape, Sphere):
        T[:3, 3] = shape.centre
        return coal.Sphere(shape.radius), T
    start, end = np.array(shape.start), np.array(shape.end)
    T[:3, 3] = (start + end) / 2
    z = (end - start) / np.linalg.norm(end - start)
    x = np.cross(z, np.eye(3)[np.abs(z).argmin()])
    x /= np.linalg.norm(x)
    T[:3, :3] = np.column_stack([x, np.cross(z, x), z])
    return coal.Capsule(shape.radius, float(np.linalg.norm(end - start))), T
