"""Good arguments of the public functions: each entry is a function, and arguments with which it works."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import numpy as np
import torch

import dexterity as dx
from dexterity import (
    crane,
    docking,
    indices,
    inverse_kinematics,
    networks,
    reach,
    robots,
    sampling,
    scenes,
    search,
    spatial,
    symbolic,
    tasks,
    timing,
)
from dexterity.crane import positioning, shape
from dexterity.search import box
from dexterity.workspace import (
    compiled,
    dataset,
    dynamics,
    jacobian_net,
    maps,
    reachability,
    resolved_rate,
    training,
)

Arguments = Mapping[str, Callable[[], Any]]

Q = np.array([0.3, -0.5, 0.7, 0.2, 0.9, -0.4])
LINKS = np.array([0.15, 0.4318, 0.4318, 0.0203])
STROKES = np.array([[0.25, 0.5, 1.0], [0.2, 0.3, 0.4]])
PAYLOAD = np.array([100.0, 200.0])
VECTOR = np.array([0.1, 0.2, 0.3])
TWIST = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
UNIT = np.array([0.0, 0.0, 1.0])


@cache
def puma() -> dx.Chain:
    return robots.puma560()


@cache
def ur5e() -> dx.Chain:
    return robots.ur5e()


@cache
def elbow() -> dx.Chain:
    return robots.docking_arm()


@cache
def T() -> np.ndarray:
    return puma().forward(Q).numpy()


@cache
def T_of_links() -> np.ndarray:
    return reachability.forward(LINKS, Q).numpy()


@cache
def J() -> np.ndarray:
    return puma().geometric_jacobian(Q).numpy()


@cache
def task() -> positioning.Task:
    return positioning.thesis_task(points=[[4.0, 0.0], [5.0, 2.0]], payloads=[100.0])


@cache
def rows() -> crane.TrainingSet:
    return crane.training_set()


@cache
def jacobians() -> dataset.JacobianData:
    return dataset.jacobian_data(40, 0)


@cache
def answer() -> maps.ByClosedForm:
    return maps.ByClosedForm(LINKS)


def draws() -> torch.Generator:
    return torch.Generator().manual_seed(0)


def hill(x: torch.Tensor) -> torch.Tensor:
    return -(x - 0.3).square().sum(-1)


def of(**values: Any) -> Arguments:
    """Arguments by name; a function of no arguments is called for its value."""
    return {name: value if callable(value) else lambda value=value: value for name, value in values.items()}


SPACE = sampling.Box([-0.5] * 6, [0.5] * 6, 3)
CIRCLE = resolved_rate.Circle(
    (0.3, 0.0, 0.2), 0.05, 10.0, 0.0, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
)
SMALL = jacobian_net.Architecture(confidence=(4,), estimation=(4,))
FEW = search.ZoomOptions(stages=3)
SHORT = search.GeneticOptions(population=4, generations=3)

EXAMPLES: tuple[tuple[str, Callable[..., Any], Arguments], ...] = (
    ("Chain", dx.Chain, of(screws=lambda: puma().screws.numpy(), home=lambda: puma().home.numpy())),
    *(
        (f"Chain.{name}", lambda q, name=name: getattr(puma(), name)(q), of(q=Q))
        for name in ("forward", "spatial_jacobian", "body_jacobian", "geometric_jacobian", "joint_frames")
    ),
    ("Chain.on_vehicle", lambda T_vehicle_arm: puma().on_vehicle(T_vehicle_arm).home, of(T_vehicle_arm=T)),
    # ---- spatial ----
    *(
        (f"spatial.{name}", getattr(spatial, name), of(T=T))
        for name in ("adjoint", "compose", "inverse", "inverse_adjoint", "log", "nearest_rigid", "rpy")
        if name != "compose"
    ),
    ("spatial.compose", lambda T: spatial.compose(T, T), of(T=T)),
    ("spatial.exp", spatial.exp, of(twist=TWIST)),
    ("spatial.hat", spatial.hat, of(vector=TWIST)),
    ("spatial.vee", spatial.vee, of(matrix=lambda: spatial.hat(TWIST).numpy())),
    ("spatial.apply", spatial.apply, of(T=T, p=VECTOR)),
    ("spatial.pose", spatial.pose, of(rotation=lambda: T()[:3, :3], translation=VECTOR)),
    ("spatial.quaternion", spatial.quaternion, of(T=T, order="wxyz")),
    (
        "spatial.from_quaternion",
        spatial.from_quaternion,
        of(quaternion=np.array([1.0, 0, 0, 0]), order="wxyz"),
    ),
    ("spatial.from_rpy", spatial.from_rpy, of(angles=VECTOR, translation=VECTOR)),
    ("spatial.nearest_rotation", spatial.nearest_rotation, of(matrix=lambda: T()[:3, :3], largest_miss=0.01)),
    ("spatial.rotation_miss", spatial.rotation_miss, of(matrix=lambda: T()[:3, :3])),
    ("spatial.translation", spatial.translation, of(x=0.1, y=0.2, z=0.3)),
    ("spatial.wrap_to_pi", spatial.wrap_to_pi, of(angle=np.array([0.1, 4.0]))),
    # ---- indices and tasks ----
    *(
        (f"indices.{name}", getattr(indices, name), of(J=J))
        for name in ("manipulability", "kinematic_conditioning")
    ),
    ("indices.normalise", indices.normalise, of(J=J, joint_rates=np.ones(6), tool_rates=np.ones(6))),
    ("indices.velocity_ellipsoid", indices.velocity_ellipsoid, of(J=J, part="translational")),
    ("indices.force_ellipsoid", indices.force_ellipsoid, of(J=J, part="translational")),
    ("indices.describe", indices.describe, of(name="isotropy")),
    ("indices.Index", dx.Index, of(name="manipulability", frame="geometric", joint_rates=np.ones(6))),
    *(
        (f"indices.Index({name})", lambda q, name=name: dx.Index(name, "geometric").bind(puma())(q), of(q=Q))
        for name in ("manipulability", "kinematic_conditioning", "isotropy", "smallest_singular_value")
    ),
    (
        "symbolic.compile_index",
        symbolic.compile_index,
        of(chain=puma, index=lambda: dx.Index("manipulability"), backend="torch"),
    ),
    ("tasks.find", tasks.find, of(task="welding")),
    ("tasks.index_for", tasks.index_for, of(task="welding", frame="geometric", joint_rates=np.ones(6))),
    (
        "tasks.rank",
        lambda **more: tasks.rank(**more).values,
        of(chain=puma, q=np.stack([Q, 2 * Q]), task="welding"),
    ),
    # ---- inverse kinematics ----
    ("inverse_kinematics.closed_form", inverse_kinematics.closed_form, of(chain=puma)),
    ("inverse_kinematics.copies_within_limits", inverse_kinematics.copies_within_limits, of(chain=puma, q=Q)),
    ("inverse_kinematics.nearest_copy", inverse_kinematics.nearest_copy, of(chain=puma, q=Q, near=Q)),
    ("inverse_kinematics.within_limits", inverse_kinematics.within_limits, of(chain=puma, q=Q)),
    (
        "inverse_kinematics.damped_pseudo_inverse",
        inverse_kinematics.damped_pseudo_inverse,
        of(J=J, damping=0.1, weights=np.ones(6)),
    ),
    (
        "inverse_kinematics.null_space_projector",
        inverse_kinematics.null_space_projector,
        of(J=lambda: J()[:3], weights=np.ones(6)),
    ),
    (
        "inverse_kinematics.solve",
        lambda **more: inverse_kinematics.solve(**more).residual,
        of(chain=puma, T_world_tool=T, rows="full", seeds=4, near=Q, limit_tolerance=1e-9, tolerance=1e-9),
    ),
    ("inverse_kinematics.spherical_wrist", inverse_kinematics.spherical_wrist, of(arm=puma, T_base_tool=T)),
    (
        "inverse_kinematics.three_parallel_axes",
        inverse_kinematics.three_parallel_axes,
        of(arm=ur5e, T_base_tool=lambda: ur5e().forward(Q).numpy()),
    ),
    # ---- sampling and search ----
    ("sampling.Box", sampling.Box, of(lower=-np.ones(3), upper=np.ones(3), levels=3)),
    ("sampling.sobol", sampling.sobol, of(space=SPACE, count=4, seed=0, overhang=0.0)),
    ("sampling.uniform", sampling.uniform, of(space=SPACE, count=4, random=draws)),
    ("sampling.on_grid", sampling.on_grid, of(space=SPACE, count=4, random=draws)),
    ("sampling.grid", sampling.grid, of(space=SPACE, start=0, stop=5)),
    ("search.box.limits", box.limits, of(lower=np.zeros(2), upper=np.ones(2))),
    (
        "search.zoom_search",
        lambda **more: search.zoom_search(**more, options=FEW).point,
        of(objective=lambda: hill, lower=np.zeros(2), upper=np.ones(2), steps=np.full(2, 0.5)),
    ),
    (
        "search.genetic_search",
        lambda **more: search.genetic_search(**more, options=SHORT).point,
        of(
            objective=lambda: hill,
            lower=np.zeros(2),
            upper=np.ones(2),
            precision=np.full(2, 0.01),
            generator=draws,
        ),
    ),
    ("search.ZoomOptions", search.ZoomOptions, of(starts=2, levels=3, shrink=0.5, stages=3)),
    (
        "search.GeneticOptions",
        search.GeneticOptions,
        of(population=4, generations=3, crossover=0.1, mutation=0.1, patience=3),
    ),
    # ---- robots ----
    ("robots.describe", robots.describe, of(name="puma560")),
    ("robots.load", robots.load, of(name_or_path="puma560")),
    ("robots.docking_arm", robots.docking_arm, of(variant="stated")),
    ("robots.uvms", lambda **more: robots.uvms(**more).screws, of(l1=0.0, l2=0.6, l3=0.4, rates=np.ones(12))),
    # ---- docking ----
    (
        "docking.area_manipulability",
        docking.area_manipulability,
        of(arm=elbow, pose=np.array([0.0, 0.0, 0.3, 0.0]), points=lambda: docking.square(0.2).numpy()),
    ),
    ("docking.base_pose", docking.base_pose, of(pose=np.array([0.0, 0.0, 0.3, 0.0]))),
    (
        "docking.inverse_kinematics",
        docking.inverse_kinematics,
        of(arm=elbow, T_base_tool=lambda: elbow().forward(Q).numpy()),
    ),
    (
        "docking.configurations",
        lambda **more: docking.configurations(**more).q,
        of(arm=elbow, pose=np.array([0.0, 0.0, 0.3, 0.0]), points=lambda: docking.square(0.2).numpy()),
    ),
    (
        "docking.on_base",
        lambda **more: docking.on_base(**more).home,
        of(arm=elbow, pose=np.array([0.0, 0.0, 0.3, 0.0])),
    ),
    (
        "inverse_kinematics.null_space_step",
        inverse_kinematics.null_space_step,
        of(chain=ur5e, q=Q, objective=np.ones(6), gain=0.1, rows="translational", weights=np.ones(6)),
    ),
    ("inverse_kinematics.geometric_miss", inverse_kinematics.geometric_miss, of(chain=puma)),
    ("sampling.grid_size", sampling.grid_size, of(space=SPACE)),
    (
        "sampling.data_sets",
        lambda **more: sampling.data_sets(**more).train.values,
        of(f=lambda: hill, space=SPACE, train=3, test=2, validation=2, seed=0, method="uniform"),
    ),
    (
        "sampling.uvms_space",
        lambda **more: sampling.uvms_space(**more).dimensions,
        of(index_name="manipulability", half_range_deg=15.0, step_deg=5.0),
    ),
    ("docking.square", docking.square, of(half_width=0.2, per_side=2, height=0.1)),
    ("docking.DockingProblem", docking.DockingProblem, of(arm=elbow, region="and", face="top", area=0.4)),
    # ---- workspaces ----
    ("workspace.reachable", reachability.reachable, of(links=LINKS, position=VECTOR)),
    ("workspace.inverse", reachability.inverse, of(links=LINKS, T_base_tool=T_of_links)),
    *(
        (f"workspace.{name}", getattr(reachability, name), of(links=LINKS, q=Q))
        for name in ("forward", "frames", "geometric_jacobian", "body_jacobian")
    ),
    ("workspace.arm", lambda **more: reachability.arm(**more).screws, of(links=LINKS, name="arm")),
    (
        "workspace.asada_ratio",
        dynamics.asada_ratio,
        of(links=lambda: LINKS, dynamics=lambda: jacobians().samples.dynamics.rows(torch.arange(1)), q=Q),
    ),
    (
        "workspace.confidence_data",
        dataset.confidence_data,
        of(count=5, seed=0, dynamics=False, redraw=0.5, workers=1),
    ),
    (
        "workspace.jacobian_data",
        dataset.jacobian_data,
        of(count=3, seed=0, dynamics=False, poses=5, threshold=0.03),
    ),
    ("workspace.rotation", dataset.rotation, of(angles=VECTOR)),
    ("workspace.features", dataset.features, of(samples=lambda: jacobians().samples)),
    ("workspace.inputs_of", jacobian_net.inputs_of, of(samples=lambda: jacobians().samples, kind="plane")),
    (
        "workspace.Architecture",
        jacobian_net.Architecture,
        of(encoder=(3,), confidence=(4,), estimation=(4,), dropout=0.1),
    ),
    (
        "workspace.network_for",
        lambda **more: training.network_for(**more).parameter_count,
        of(architecture=SMALL, inputs="plane", entries="plane", data=jacobians, seed=0, validation=0.2),
    ),
    (
        "workspace.Options",
        training.Options,
        of(
            schedule=training.epochs(1),
            optimiser="Adam",
            rate=0.1,
            decay=True,
            batch=8,
            validation=0.2,
            patience=3,
        ),
    ),
    ("workspace.cycles", training.cycles, of(pretraining=1, count=2)),
    ("workspace.CompiledArm", compiled.CompiledArm, of(links=LINKS)),
    ("workspace.c_source", compiled.c_source, of(name="arm")),
    (
        "workspace.track",
        lambda **more: resolved_rate.track(CIRCLE, puma().forward, puma().geometric_jacobian, **more).time,
        of(q=Q, duration=0.02, step=0.01, gain=1.0, method="euler", largest_rate=10.0),
    ),
    (
        "workspace.Circle",
        resolved_rate.Circle,
        of(centre=(0.3, 0.0, 0.2), radius=0.05, period=10.0, lean=0.0, orientation=CIRCLE.orientation),
    ),
    ("workspace.rotations", maps.rotations, of(count=5)),
    (
        "workspace.ByClosedForm",
        maps.ByClosedForm,
        of(links=LINKS, lower=-3 * np.ones(6), upper=3 * np.ones(6)),
    ),
    (
        "workspace.orientation_workspace",
        lambda **more: maps.orientation_workspace(**more).reached,
        of(answer=answer, position=VECTOR, orientations=lambda: maps.rotations(5).numpy()),
    ),
    # ---- the crane ----
    *(
        (f"crane.{name}", getattr(crane, name), of(strokes=STROKES))
        for name in ("tip_position", "tip_jacobian", "posture", "load_response", "within_limits")
    ),
    *(
        (f"crane.{name}", getattr(crane, name), of(strokes=STROKES, payload=PAYLOAD))
        for name in ("deflection", "flexible_tip", "joint_forces", "corotational_deflection")
    ),
    ("crane.inverse", crane.inverse, of(position=np.array([3.7, -0.7]), extension=1.0)),
    ("crane.least_extension", crane.least_extension, of(position=np.array([3.7, -0.7]))),
    ("crane.scaled", crane.scaled, of(crane=crane.patu655, factor=0.5)),
    (
        "crane.Differences",
        crane.Differences,
        of(misalignment=0.001, play=0.001, stiffness=0.1, stroke_step=0.0, reading_step=0.0),
    ),
    (
        "crane.existing_crane",
        lambda **more: crane.existing_crane(**more).play,
        of(differences=crane.Differences(), generator=draws),
    ),
    ("crane.NewtonOptions", crane.NewtonOptions, of(load_steps=1, iterations=5, tolerance=1e-9)),
    ("crane.bars", lambda **more: shape.bars(**more).ends, of(strokes=STROKES)),
    (
        "crane.Bars.loaded",
        lambda **more: shape.bars(STROKES).loaded(**more),
        of(payload=PAYLOAD, magnified=10.0),
    ),
    (
        "crane.thesis_task",
        lambda **more: positioning.thesis_task(**more).starts,
        of(points=np.array([[4.0, 0.0]]), payloads=np.array([100.0])),
    ),
    (
        "crane.compensate",
        lambda **more: positioning.compensate(task(), positioning.linear_sag(), **more).strokes,
        of(corrections=2, tolerance=1e-3),
    ),
    ("crane.trigonometric_features", positioning.trigonometric_features, of(strokes=STROKES, degree=2)),
    ("crane.TableSag.of", lambda nodes: positioning.TableSag.of(nodes).entries, of(nodes=[3, 3, 3])),
    (
        "crane.genetic_inverse",
        lambda **more: positioning.genetic_inverse(task(), **more).strokes,
        of(positions=lambda: task().targets.numpy(), generator=draws),
    ),
    # ---- reach ----
    ("reach.ball", reach.ball, of(centre=VECTOR, radius=0.3, spacing=0.2)),
    ("reach.box", reach.box, of(lower=np.zeros(3), upper=np.ones(3), spacing=0.5)),
    ("reach.rotations", lambda count: reach.rotations(count), of(count=20)),
    (
        "reach.panel",
        reach.panel,
        of(
            centre=VECTOR,
            normal=UNIT,
            width=0.2,
            height=0.3,
            columns=2,
            rows=2,
            up=np.array([1.0, 0, 0]),
            standoff=0.1,
        ),
    ),
    (
        "reach.planar_bases",
        reach.planar_bases,
        of(x=np.array([0.0, 1.0]), y=np.array([0.0, 1.0]), yaw=np.array([0.0]), height=0.1),
    ),
    ("reach.pointing", reach.pointing, of(direction=np.array([1.0, 0, 0]), roll=0.1)),
    ("reach.seam", reach.seam, of(start=VECTOR, end=2 * VECTOR, count=3, tool_rotation=np.eye(3))),
    # ---- scenes ----
    ("scenes.Scene", scenes.Scene, of(title="An arm", height=300, view_from=np.array([1.0, 0.5, 0.5]))),
    (
        "scenes.Scene.add_chain",
        lambda **more: scenes.Scene("An arm").add_chain(**more),
        of(chain=puma, q=Q, name="arm", axes=False, color="blue"),
    ),
    (
        "scenes.Scene.add_box",
        lambda **more: scenes.Scene("A box").add_box(**more),
        of(size=np.ones(3), pose=np.eye(4), name="box", color="blue"),
    ),
    (
        "scenes.Scene.add_path",
        lambda **more: scenes.Scene("A path").add_path(**more),
        of(points=np.eye(3), name="path", color="blue"),
    ),
    (
        "scenes.Scene.add_points",
        lambda **more: scenes.Scene("Points").add_points(**more),
        of(points=np.eye(3), name="points", size=0.1, color="blue"),
    ),
    (
        "scenes.Scene.add_bars",
        lambda **more: scenes.Scene("Bars").add_bars(**more),
        of(name="bars", ends=np.arange(12.0).reshape(2, 2, 3), radius=0.1, color="blue"),
    ),
    (
        "scenes.Scene.look_at",
        lambda **more: scenes.Scene("A box").look_at(**more),
        of(low=np.zeros(3), high=np.ones(3)),
    ),
    (
        "scenes.Scene.add_remark",
        lambda text: scenes.Scene("A remark").add_remark(text),
        of(text="Drawn larger"),
    ),
    # ---- networks ----
    ("networks.View", networks.View, of(joints=6, inputs=(0, 1, 2))),
    (
        "networks.Recipe",
        networks.Recipe,
        of(neurons=4, readout="identity", rows=100, overhang=0.1, epochs=10),
    ),
    ("networks.Search", networks.Search, of(samples=100, corners=8, starts=4, steps=5)),
    ("networks.load_shipped", networks.load_shipped, of(name="uvms-manipulability-feed-forward")),
    (
        "networks.Network.__call__",
        lambda q: networks.load_shipped("uvms-manipulability-feed-forward")(q),
        of(q=np.zeros(12)),
    ),
    # ---- timing ----
    ("timing.Timing", timing.Timing.from_times, of(name="exact", configurations=1, times=[1.0, 2.0, 3.0])),
    (
        "timing.measure",
        lambda **more: timing.measure([timing.Way("nothing", lambda: None, 1)], **more)[0].configurations,
        of(rounds=1, seconds=0.001),
    ),
)
