"""Samples of the three papers' systems: docking, workspace, crane."""

from __future__ import annotations

from functools import cache

import numpy as np
import torch
from good_values import VECTOR, Arguments, Q, draws, elbow, folder, of, puma

import dexterity as dx
from dexterity import collision, crane, docking, search, store
from dexterity.crane import positioning, shape
from dexterity.workspace import (
    archive,
    closed_form,
    compiled,
    dataset,
    dynamics,
    export,
    jacobian_net,
    maps,
    reachability,
    resolved_rate,
    training,
)

LINKS = np.array([0.15, 0.4318, 0.4318, 0.0203])
STROKES = np.array([[0.25, 0.5, 1.0], [0.2, 0.3, 0.4]])
PAYLOAD = np.array([100.0, 200.0])
POSE = np.array([0.0, 0.0, 0.3, 0.0])
EPOCHS = 2
SMALL = jacobian_net.Architecture(confidence=(4,), estimation=(4,))
CIRCLE = resolved_rate.Circle(
    (0.3, 0.0, 0.2), 0.05, 10.0, 0.0, ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
)


def tensor(array: np.ndarray) -> torch.Tensor:
    return torch.tensor(array)


@cache
def T_of_links() -> np.ndarray:
    return reachability.forward(LINKS, Q).numpy()


@cache
def docking_problem() -> docking.DockingProblem:
    return docking.DockingProblem(elbow())


@cache
def docked() -> collision.Bodies:
    return docking.block_and_vehicle(elbow())


def points() -> np.ndarray:
    return docking.square(0.2).numpy()


# ---- workspace ---------------------------------------------------------------------------------------


@cache
def jacobians() -> dataset.JacobianData:
    return dataset.jacobian_data(40, 0)


@cache
def confidences() -> dataset.ConfidenceData:
    return dataset.confidence_data(40, 0)


@cache
def plain_jacobians() -> dataset.JacobianData:
    return dataset.jacobian_data(20, 0, dynamics=False)


def one_dynamics() -> dynamics.DynamicParameters:
    return jacobians().samples.dynamics.rows(torch.arange(1))


@cache
def network() -> jacobian_net.JacobianNet:
    return training.network_for(SMALL, "plane", "plane", plain_jacobians(), 0)


@cache
def scaling() -> dataset.Scaling:
    return dataset.Scaling.to_unit_deviation(torch.tensor(STROKES))


@cache
def answer() -> maps.ByClosedForm:
    return maps.ByClosedForm(LINKS)


@cache
def grid() -> maps.Grid:
    return maps.Grid.cube(0.4, 2)


@cache
def net_file() -> str:
    path = folder() / "net.npz"
    network().save(path)
    return str(path)


@cache
def archive_file() -> str:
    path = folder() / "archive.npz"
    archive.write_archive(path, "some numbers", {"a": 1}, {"x": torch.ones(2)})
    return str(path)


@cache
def csv_folder() -> str:
    path = folder() / "csv"
    dataset.write_csv(path, jacobians(), jacobians())
    return str(path)


def rotations() -> np.ndarray:
    return maps.rotations(5).numpy()


# ---- crane -------------------------------------------------------------------------------------------


@cache
def task() -> positioning.Task:
    return positioning.thesis_task(points=[[4.0, 0.0], [5.0, 2.0]], payloads=[100.0])


@cache
def rows() -> crane.TrainingSet:
    return crane.training_set()


@cache
def correction() -> dx.networks.FeedForward:
    return positioning.correction_network(rows(), draws(), 2, EPOCHS)


@cache
def direct() -> dx.networks.FeedForward:
    return positioning.direct_network(rows(), draws(), 2, EPOCHS)


@cache
def inverse() -> dx.networks.FeedForward:
    return positioning.inverse_network(rows(), draws(), 2, EPOCHS)


@cache
def existing() -> crane.ExistingCrane:
    return crane.existing_crane(crane.Differences(), draws())


@cache
def sag() -> positioning.TableSag:
    return positioning.TableSag.of([3, 3, 3])


def crane_file() -> str:
    return str(store.data_path("robots", "patu655.toml"))


SAMPLES: dict[str, Arguments] = {
    # ---- docking ----
    "docking.area_manipulability": of(
        arm=elbow, pose=POSE, points=points, tool=np.array(docking.TOOL_UP), bodies=docked
    ),
    "docking.largest_manipulability": of(
        arm=elbow, pose=POSE, points=points, tool=np.array(docking.TOOL_UP), bodies=docked
    ),
    "docking.configurations": of(arm=elbow, pose=POSE, points=points, tool=np.array(docking.TOOL_UP)),
    "docking.base_pose": of(pose=POSE),
    "docking.block_and_vehicle": of(
        arm=elbow,
        block=(2.0, 2.0, 2.0),
        vehicle=(1.5, 1.2, 1.0),
        bottom=-0.2,
        radius=0.01,
        hand=0.1,
        excluded=[("hand", "block")],
    ),
    "docking.inverse_kinematics": of(arm=elbow, T_base_tool=lambda: elbow().forward(Q).numpy()),
    "docking.on_base": of(arm=elbow, pose=POSE),
    "docking.square": of(half_width=0.2, per_side=2, height=0.1, face="top"),
    "docking.DockingProblem": of(arm=elbow, region="and", face="top", area=0.4, points=points, bodies=docked),
    **{
        f"docking.DockingProblem.{name}": of(self=docking_problem, pose=POSE)
        for name in ("allows", "distance", "area_manipulability", "objective", "fitness")
    },
    "docking.evaluations": of(problem=docking_problem, options=search.ZoomOptions(stages=1)),
    "docking.genetic_docking": of(
        problem=docking_problem,
        seed=0,
        options=search.GeneticOptions(population=4, generations=2),
        precision=0.01,
    ),
    "docking.global_docking": of(
        problem=docking_problem,
        steps=np.ones(4),
        options=search.ZoomOptions(starts=1, levels=3, stages=1),
        progress=False,
    ),
    "docking.export.javascript_module": of(problem=docking_problem),
    # ---- workspace ----
    "workspace.reachable": of(links=LINKS, position=VECTOR),
    "workspace.reachability.inverse": of(links=LINKS, T_base_tool=T_of_links),
    **{
        f"workspace.reachability.{name}": of(links=LINKS, q=Q)
        for name in ("forward", "frames", "geometric_jacobian", "body_jacobian")
    },
    "workspace.reachability.arm": of(links=LINKS, name="arm"),
    **{
        f"workspace.dynamics.{name}": of(links=LINKS, dynamics=one_dynamics, q=Q)
        for name in ("asada_ratio", "cartesian_inertia", "joint_inertia")
    },
    "workspace.archive.read_archive": of(path=archive_file, kind="some numbers"),
    "workspace.archive.write_archive": of(
        path=lambda: folder() / "other.npz",
        kind="some numbers",
        header=lambda: {"a": 1},
        tensors=lambda: {"x": torch.ones(2)},
    ),
    "workspace.closed_form.derive": of(branch=reachability.NAMED_BRANCH),
    "workspace.closed_form.in_torch": of(branch=reachability.NAMED_BRANCH, names="cosines"),
    "workspace.closed_form.part": of(program=closed_form.derive, names="cosines"),
    "workspace.compiled.CompiledArm": of(links=LINKS),
    "workspace.compiled.CompiledArm.solve": of(
        self=lambda: compiled.CompiledArm(LINKS), T_base_tool=T_of_links
    ),
    "workspace.compiled.CompiledArm.manipulability": of(
        self=lambda: compiled.CompiledArm(LINKS), T_base_tool=T_of_links
    ),
    "workspace.compiled.c_source": of(name="arm", outputs=("cosines",)),
    "workspace.compiled.in_c": of(branch=reachability.NAMED_BRANCH, names="manipulability"),
    "workspace.dataset.confidence_data": of(count=5, seed=0, dynamics=False, redraw=0.5, workers=1),
    "workspace.dataset.jacobian_data": of(
        count=3, seed=0, dynamics=False, poses=5, threshold=0.03, workers=1
    ),
    "workspace.dataset.JacobianData.in_frame": of(self=jacobians, frame="tool"),
    "workspace.dataset.Scaling.to_unit_deviation": of(train=lambda: tensor(STROKES)),
    "workspace.dataset.Scaling.to_range": of(train=lambda: tensor(STROKES)),
    "workspace.dataset.features": of(samples=lambda: jacobians().samples),
    "workspace.dataset.rotation": of(angles=VECTOR),
    "workspace.dataset.read_csv": of(folder=csv_folder, name="jacob"),
    "workspace.dataset.write_csv": of(
        folder=lambda: folder() / "again", train=jacobians, test=jacobians, frame="tool"
    ),
    "workspace.export.Confidence.of": of(network=lambda: network()),
    "workspace.export.Confidence.__call__": of(
        self=lambda: export.Confidence.of(network()), links=LINKS, T_base_tool=T_of_links
    ),
    "workspace.export.confidence_module": of(confidence=lambda: export.Confidence.of(network())),
    "workspace.export.javascript_module": of(branch=reachability.NAMED_BRANCH),
    "workspace.export.origins": of(branch=reachability.NAMED_BRANCH),
    "workspace.jacobian_net.Architecture": of(
        encoder=(3,), confidence=(4,), estimation=(4,), normalised=(0, 0), dropout=0.1
    ),
    "workspace.jacobian_net.JacobianNet": of(
        architecture=SMALL,
        inputs="plane",
        entries="plane",
        scaling_in=lambda: network().scaling("in"),
        scaling_out=lambda: network().scaling("out"),
        random=draws,
        threshold=0.5,
    ),
    "workspace.jacobian_net.JacobianNet.answer": of(
        self=lambda: network(), links=LINKS, T_base_tool=T_of_links
    ),
    "workspace.jacobian_net.JacobianNet.estimate": of(
        self=lambda: network(), samples=lambda: plain_jacobians().samples
    ),
    "workspace.jacobian_net.JacobianNet.scaled_inputs": of(
        self=lambda: network(), samples=lambda: plain_jacobians().samples
    ),
    "workspace.jacobian_net.JacobianNet.scaling": of(self=lambda: network(), side="in"),
    "workspace.jacobian_net.JacobianNet.save": of(self=lambda: network(), path=lambda: folder() / "n.npz"),
    "workspace.jacobian_net.JacobianNet.load": of(path=net_file),
    "workspace.jacobian_net.inputs_of": of(samples=lambda: jacobians().samples, kind="plane"),
    "workspace.maps.ByBranches": of(arm=puma, limit_tolerance=1e-9),
    "workspace.maps.ByClosedForm": of(
        links=LINKS,
        lower=-3 * np.ones(6),
        upper=3 * np.ones(6),
        T_flange_tool=np.eye(4),
        backend="torch",
        limit_tolerance=1e-9,
    ),
    "workspace.maps.ByNetwork": of(network=lambda: network(), links=LINKS),
    "workspace.maps.ByNetwork.in_training_range": of(
        self=lambda: maps.ByNetwork(network(), LINKS), position=VECTOR
    ),
    "workspace.maps.Grid": of(x=np.array([0.0, 1.0]), y=np.array([0.0, 1.0]), z=np.array([0.0, 1.0])),
    "workspace.maps.Grid.cube": of(half_side=0.4, per_side=2),
    "workspace.maps.around": of(orientations=rotations, direction=np.array([0.0, 0.0, 1.0]), half_angle=1.0),
    "workspace.maps.constant_orientation": of(
        answer=answer, grid=grid, orientation=np.eye(3), poses_at_once=100
    ),
    "workspace.maps.in_training_range": of(links=LINKS, position=VECTOR),
    "workspace.maps.orientation_workspace": of(answer=answer, position=VECTOR, orientations=rotations),
    "workspace.maps.rotations": of(count=5),
    "workspace.maps.survey": of(answer=answer, grid=grid, orientations=rotations, poses_at_once=100),
    "workspace.resolved_rate.Circle": of(
        centre=(0.3, 0.0, 0.2), radius=0.05, period=10.0, lean=0.0, orientation=CIRCLE.orientation
    ),
    "workspace.resolved_rate.track": of(
        path=lambda: CIRCLE,
        forward=lambda: puma().forward,
        geometric_jacobian=lambda: puma().geometric_jacobian,
        q=Q,
        duration=0.02,
        step=0.01,
        gain=1.0,
        method="euler",
        largest_rate=10.0,
    ),
    "workspace.training.Options": of(
        schedule=training.epochs(1),
        optimiser="Adam",
        rate=0.1,
        decay=True,
        batch=8,
        validation=0.2,
        patience=3,
    ),
    "workspace.training.confidence_rows": of(network=lambda: network(), data=confidences),
    "workspace.training.cycles": of(pretraining=1, count=2),
    "workspace.training.epochs": of(confidence=1, estimation=1),
    "workspace.training.estimation_rows": of(network=lambda: network(), data=plain_jacobians),
    "workspace.training.network_for": of(
        architecture=SMALL, inputs="plane", entries="plane", data=jacobians, seed=0, validation=0.2
    ),
    "workspace.training.train": of(
        network=lambda: training.network_for(SMALL, "plane", "plane", plain_jacobians(), 0),
        rows=lambda: {"estimation": training.estimation_rows(network(), plain_jacobians())},
        options=training.Options(training.epochs(0, 1), batch=8),
        seed=0,
        progress=False,
    ),
    # ---- the crane ----
    **{
        f"crane.{name}": of(strokes=STROKES, crane=crane.patu655)
        for name in ("tip_position", "tip_jacobian", "posture", "load_response", "within_limits")
    },
    **{
        f"crane.{name}": of(strokes=STROKES, payload=PAYLOAD, crane=crane.patu655)
        for name in ("deflection", "flexible_tip", "joint_forces", "corotational_deflection")
    },
    "crane.inverse": of(position=np.array([3.7, -0.7]), extension=1.0, crane=crane.patu655),
    "crane.least_extension": of(position=np.array([3.7, -0.7]), crane=crane.patu655),
    "crane.read_crane": of(path=crane_file),
    "crane.scaled": of(crane=crane.patu655, factor=0.5),
    "crane.Crane": of(
        name="crane",
        source="ours",
        licence="MIT",
        lower=lambda: crane.patu655().lower,
        upper=lambda: crane.patu655().upper,
        rating=100.0,
        linkage=lambda: crane.patu655().linkage,
        structure=lambda: crane.patu655().structure,
    ),
    "crane.Differences": of(misalignment=0.001, play=0.001, stiffness=0.1, stroke_step=0.0, reading_step=0.0),
    "crane.ExistingCrane": of(built=crane.patu655, play=(0.001,) * 9, stroke_step=0.01, reading_step=0.01),
    **{
        f"crane.ExistingCrane.{name}": of(
            self=existing, strokes=lambda: tensor(STROKES), payload=lambda: tensor(PAYLOAD)
        )
        for name in ("tip", "reading", "seating")
    },
    "crane.ExistingCrane.zeroed": of(self=existing, strokes=lambda: tensor(STROKES[0]), payload=0.0),
    "crane.NewtonOptions": of(load_steps=1, iterations=5, tolerance=1e-9),
    "crane.TrainingSet": of(rows=lambda: rows().rows),
    "crane.existing_crane": of(differences=crane.Differences(), generator=draws, model=crane.patu655),
    "crane.training_set": of(crane=crane.patu655),
    "crane.shape.bars": of(strokes=STROKES, crane=crane.patu655),
    "crane.shape.Bars.loaded": of(self=lambda: shape.bars(STROKES), payload=PAYLOAD, magnified=10.0),
    "crane.shape.nodal_response": of(strokes=STROKES, crane=crane.patu655),
    # ---- its positioning ----
    "crane.positioning.AngleNetworkSag.fit": of(data=rows, neurons=2, generator=draws, epochs=EPOCHS),
    "crane.positioning.TableSag.of": of(nodes=(3, 3, 3), crane=crane.patu655),
    "crane.positioning.TrigonometricSag.fit": of(data=rows, degree=2, crane=crane.patu655),
    "crane.positioning.DescentOptions": of(tolerance=1e-3, rate=0.1, iterations=2),
    "crane.positioning.GaussNewtonOptions": of(tolerance=1e-3, iterations=2, damping=0.1),
    "crane.positioning.GeneticInverseOptions": of(
        population=6, given=2, generations=2, tolerance=0.1, bits=4, crossover=0.6, mutation=0.1
    ),
    "crane.positioning.Task": of(
        targets=lambda: task().targets,
        payload=lambda: task().payload,
        starts=lambda: task().starts,
        crane=crane.patu655,
    ),
    "crane.positioning.Task.allows": of(self=task, strokes=lambda: task().starts),
    "crane.positioning.by_inverse_network": of(task=task, network=lambda: inverse()),
    "crane.positioning.compensate": of(task=task, sag=lambda: sag(), corrections=2, tolerance=1e-3),
    "crane.positioning.corotational_sag": of(crane=crane.patu655),
    "crane.positioning.linear_sag": of(crane=crane.patu655),
    **{
        f"crane.positioning.{name}": of(data=rows, generator=draws, neurons=2, epochs=EPOCHS)
        for name in ("correction_network", "direct_network", "inverse_network")
    },
    "crane.positioning.modular_network": of(data=rows, generator=draws, neurons=(2, 2), epochs=EPOCHS),
    "crane.positioning.descend": of(
        task=task, network=lambda: direct(), options=positioning.DescentOptions(rate=1e-3, iterations=2)
    ),
    "crane.positioning.errors": of(
        task=task, placement=lambda: positioning.uncompensated(task()), sag=lambda: sag(), end_stops=True
    ),
    "crane.positioning.exact_inverse": of(task=task, positions=lambda: task().targets.numpy()),
    "crane.positioning.gauss_newton": of(
        task=task,
        tip=lambda: positioning.sagging_tip(task(), sag()),
        options=positioning.GaussNewtonOptions(iterations=2),
    ),
    "crane.positioning.genetic": of(generator=draws),
    "crane.positioning.genetic_inverse": of(
        task=task,
        positions=lambda: task().targets.numpy(),
        generator=draws,
        options=positioning.GeneticInverseOptions(generations=2),
    ),
    "crane.positioning.network_sag": of(network=lambda: correction()),
    "crane.positioning.network_tip": of(network=lambda: direct()),
    "crane.positioning.safe_rate": of(network=lambda: direct(), task=task, points=2),
    "crane.positioning.sagging_tip": of(task=task, sag=lambda: sag()),
    "crane.positioning.thesis_task": of(points=np.array([[4.0, 0.0]]), payloads=np.array([100.0])),
    "crane.positioning.trigonometric_features": of(strokes=lambda: tensor(STROKES), degree=2),
    "crane.positioning.uncompensated": of(task=task),
    "crane.positioning.export.task_at": of(
        strokes=lambda: tensor(STROKES), payload=lambda: tensor(PAYLOAD), crane=crane.patu655
    ),
}
