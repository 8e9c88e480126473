"""Samples of what is exact: chains, poses, indices, compilation, inverse kinematics, URDF, operations."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import sympy
import torch
from good_values import (
    TWIST,
    UNIT,
    VECTOR,
    Arguments,
    J,
    Q,
    T,
    folder,
    of,
    planar,
    puma,
    ur5e,
    w,
)

import dexterity as dx
from dexterity import codegen, collision, inverse_kinematics, robots, spatial, store, symbolic, tasks, urdf
from dexterity.codegen import ecmascript, recorded_functions
from dexterity.program import Program

URDF = """<robot name="arm"><link name="base"/><link name="tool"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="tool"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>"""


@cache
def derivation() -> symbolic.Derivation:
    return symbolic.derive(planar(), dx.Index("manipulability", "geometric", rows=[0, 1]))


@cache
def symbolic_chain() -> symbolic.SymbolicChain:
    return symbolic.SymbolicChain.from_chain(planar())


@cache
def program() -> Program:
    x, y = sympy.symbols("x y", real=True)
    return Program((x, y), (), (x + y, x * y))


@cache
def compiled() -> symbolic.CompiledIndex:
    return symbolic.compile_index(puma(), w())


@cache
def ball() -> collision.Body:
    return collision.Body(collision.Sphere((0.5, 0.5, 0.5), 0.1), "world", "ball")


@cache
def bodies() -> collision.Bodies:
    return collision.Bodies(puma(), [*collision.capsules(puma(), 0.01), ball()])


@cache
def bodies_in_c() -> collision.CompiledBodies:
    return collision.in_c(bodies())


@cache
def model() -> urdf.Model:
    return urdf.read(URDF)


@cache
def solutions() -> inverse_kinematics.Solutions:
    return inverse_kinematics.solve(puma(), T())


@cache
def recording() -> codegen.tape.Recording:
    return codegen.recording.record(torch.sin, torch.ones(2, dtype=torch.float64))


@cache
def dh_rows() -> tuple[object, ...]:
    return ({"theta": 0, "d": 0.5, "a": 0, "alpha": 0.1}, {"theta": 0, "d": 0.3, "a": 0.1, "alpha": 0})


@cache
def shoulder() -> dx.Chain:
    """Return an arm whose first three axes meet: a PUMA seen from its tool."""
    home = spatial.inverse(puma().home)
    return dx.Chain(-(puma().screws @ spatial.inverse_adjoint(puma().home).mT).flip(0), home)


@cache
def robot_file() -> Path:
    """Return the path of a robot file."""
    return store.data_path("robots") / "puma560.toml"


@cache
def urdf_file() -> Path:
    """Return the path of a URDF."""
    path = folder() / "arm.urdf"
    path.write_text(URDF)
    return path


LINE = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
ACROSS = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
MOUNTED = of(self=puma, rates=np.ones(6), lower=-np.ones(6), upper=np.ones(6), prefix="base_", name="both")

SAMPLES: dict[str, Arguments] = {
    "Chain": of(
        screws=lambda: planar().screws.numpy(),
        home=lambda: planar().home.numpy(),
        name="arm",
        joint_names=("a", "b"),
        lower=-np.ones(2),
        upper=np.ones(2),
        rates=np.ones(2),
        inertias=(np.ones(2), np.zeros((2, 3)), np.stack([np.eye(3)] * 2)),
    ),
    "Chain.from_dh": of(
        rows=dh_rows,
        modified=False,
        base=np.eye(4),
        tool=np.eye(4),
        name="arm",
        joint_names=("a", "b"),
        lower=-np.ones(2),
        upper=np.ones(2),
        rates=np.ones(2),
    ),
    "Chain.from_urdf": of(source=lambda: model(), base="base", tip="tool", name="arm"),
    **{
        f"Chain.{name}": of(self=puma, q=Q)
        for name in ("forward", "spatial_jacobian", "body_jacobian", "geometric_jacobian", "joint_frames")
    },
    "Chain.mass_matrix": of(self=robots.panda, q=np.full(7, 0.3)),
    "Chain.on_vehicle": of(
        T_vehicle_arm=T, joints=("surge", "sway", "heave", "roll", "pitch", "yaw"), **MOUNTED
    ),
    "Chain.on_planar_base": of(T_base_arm=T, **MOUNTED)
    | of(rates=np.ones(3), lower=-np.ones(3), upper=np.ones(3)),
    "Chain.on_wheels": of(T_base_arm=T, **MOUNTED)
    | of(rates=np.ones(2), lower=-np.ones(3), upper=np.ones(3)),
    "Chain.with_base": of(self=puma, T_world_base=T, name="arm"),
    "Chain.with_tool": of(self=puma, T_tool_new=T, name="arm"),
    "Chain.with_limits": of(self=puma, lower=-np.ones(6), upper=np.ones(6), rates=np.ones(6)),
    "Chain.lock": of(self=planar, joints=lambda: {"joint 1": 0.3}, name="arm"),
    # ---- spatial ----
    **{
        f"spatial.{name}": of(T=T)
        for name in ("adjoint", "inverse", "inverse_adjoint", "log", "nearest_rigid", "rpy")
    },
    "spatial.compose": of(poses=T),
    "spatial.exp": of(twist=TWIST),
    "spatial.hat": of(vector=TWIST),
    "spatial.vee": of(matrix=lambda: spatial.hat(TWIST).numpy()),
    "spatial.apply": of(T=T, p=VECTOR),
    "spatial.pose": of(rotation=lambda: T()[:3, :3], translation=VECTOR),
    "spatial.quaternion": of(T=T, order="wxyz"),
    "spatial.from_quaternion": of(quaternion=np.array([1.0, 0, 0, 0]), translation=VECTOR, order="wxyz"),
    "spatial.from_rpy": of(angles=VECTOR, translation=VECTOR),
    "spatial.nearest_rotation": of(matrix=lambda: T()[:3, :3], largest_miss=0.01),
    "spatial.rotation_miss": of(matrix=lambda: T()[:3, :3]),
    "spatial.translation": of(x=0.1, y=0.2, z=0.3),
    "spatial.wrap_to_pi": of(angle=np.array([0.1, 4.0])),
    "spatial.to_float64": of(value=VECTOR, name="value"),
    "spatial.to_extended_float64": of(value=VECTOR, name="value"),
    "spatial.require_rigid": of(T=T, name="T"),
    "spatial.require_rotation": of(R=lambda: T()[:3, :3], name="R"),
    "spatial.batch_of": of(value=VECTOR, name="value", shape=(3,)),
    # ---- indices and tasks ----
    "indices.manipulability": of(J=J),
    "indices.kinematic_conditioning": of(J=J),
    "indices.normalise": of(J=J, joint_rates=np.ones(6), tool_rates=np.ones(6)),
    "indices.velocity_ellipsoid": of(J=J, part="translational"),
    "indices.force_ellipsoid": of(J=J, part="translational"),
    "indices.describe": of(name="isotropy"),
    "indices.require_not_zero_everywhere": of(index=w, chain=puma),
    "Index": of(
        name="force_ratio",
        frame="geometric",
        joint_rates=np.ones(6),
        tool_rates=np.ones(6),
        rows="translational",
        direction=UNIT,
    ),
    "Index (with a length)": of(name="kinematic_conditioning", frame="geometric", characteristic_length=0.3),
    "Index (with noise)": of(
        name="tool_deviation", frame="geometric", rows="translational", joint_noise=np.ones(6)
    ),
    "Index.column_weights": of(self=w, rates=np.ones(6)),
    "Index.normalised_jacobian": of(self=w, chain=puma, q=Q, rows=(0, 1, 2, 3, 4, 5)),
    "Index.bind": of(self=w, chain=puma),
    **{
        f"Index.__call__ ({name})": of(self=lambda name=name: dx.Index(name, "geometric"), chain=puma, q=Q)
        for name in ("manipulability", "kinematic_conditioning", "isotropy", "smallest_singular_value")
    },
    "tasks.Task": of(name="mine", index="isotropy", comment="so", where="here", aliases=("my",), rows="full"),
    "tasks.find": of(task="welding"),
    "tasks.index_for": of(task="welding", frame="geometric", joint_rates=np.ones(6), tool_rates=np.ones(6)),
    "tasks.rank": of(chain=puma, q=np.stack([Q, 2 * Q]), task="welding", joint_rates=np.ones(6)),
    "tasks.Ranking.best": of(self=lambda: tasks.rank(puma(), np.stack([Q, 2 * Q]), "welding"), k=1),
    # ---- compilation ----
    "symbolic.compile_index": of(chain=puma, index=w, backend="torch", threads=1),
    "symbolic.CompiledIndex.__call__": of(self=compiled, q=Q),
    "symbolic.CompiledIndex.value_and_gradient": of(self=compiled, q=Q),
    "symbolic.derive": of(chain=planar, index=lambda: derivation().index),
    "symbolic.cached_c_source": of(chain=planar, index=lambda: derivation().index),
    "symbolic.SymbolicChain.of": of(chain=planar),
    "symbolic.SymbolicChain.from_chain": of(chain=planar),
    "symbolic.SymbolicChain.from_description": of(description=lambda: robots.describe("puma560")),
    "codegen.javascript_module": of(derivation=derivation),
    "codegen.c_files": of(subject=planar, name="arm", precision="double"),
    "codegen.c_source": of(derivation=derivation, name="arm", precision="double"),
    "codegen.write_c": of(folder=lambda: folder() / "c", subject=planar, name="arm", precision="double"),
    "codegen.pose.javascript_module": of(chain=planar),
    "codegen.pose.kinematics": of(chain=planar),
    "codegen.ecmascript.exports": of(
        name="sums", exported=lambda: ecmascript.Exported(program(), (2,), "Sum and product.")
    ),
    "codegen.ecmascript.program_module": of(
        lines=("Sums.",),
        about=lambda: {"robot": "arm"},
        functions=lambda: {"sums": ecmascript.Exported(program(), (2,), "Sum and product.")},
        code="",
    ),
    "codegen.recorded_functions.recorded_module": of(
        lines=("Sines.",),
        about=lambda: {"robot": "arm"},
        functions=lambda: {"sines": recorded_functions.Recorded(recording(), "Two sines.")},
        code="",
    ),
    "codegen.recording.record": of(
        function=lambda: torch.sin, samples=lambda: torch.ones(2, dtype=torch.float64)
    ),
    # ---- collision ----
    "collision.Sphere": of(centre=(0.1, 0.2, 0.3), radius=0.1),
    "collision.Capsule": of(start=(0.1, 0.2, 0.3), end=(0.4, 0.5, 0.6), radius=0.1),
    "collision.Box": of(size=(0.1, 0.2, 0.3), centre=(0.4, 0.5, 0.6), rotation=np.eye(3)),
    "collision.Body": of(shape=lambda: ball().shape, link=1, name="ball"),
    "collision.capsules": of(chain=puma, radius=0.01, hand=0.1, along=(0.0, 0.0, 1.0)),
    "collision.Bodies": of(
        chain=puma,
        bodies=lambda: [*collision.capsules(puma(), 0.01), ball()],
        excluded=lambda: [("ball", bodies().names[0])],
    ),
    **{
        f"collision.Bodies.{name}": of(self=bodies, q=Q, T_world_base=np.eye(4))
        for name in ("checked", "clearance", "distances")
    },
    "collision.Bodies.collides": of(self=bodies, q=Q, T_world_base=np.eye(4), margin=0.1),
    "collision.CompiledBodies": of(bodies=bodies),
    "collision.CompiledBodies.clearance": of(self=bodies_in_c, q=Q, T_world_base=np.eye(4)),
    "collision.CompiledBodies.collides": of(self=bodies_in_c, q=Q, T_world_base=np.eye(4), margin=0.1),
    "collision.in_c": of(bodies=bodies),
    "collision.c_source": of(bodies=bodies, name="arm"),
    # ---- inverse kinematics ----
    "inverse_kinematics.closed_form": of(chain=puma),
    "inverse_kinematics.geometric_miss": of(chain=puma),
    "inverse_kinematics.copies_within_limits": of(chain=puma, q=Q, limit_tolerance=1e-9),
    "inverse_kinematics.nearest_copy": of(chain=puma, q=Q, near=Q, limit_tolerance=1e-9),
    "inverse_kinematics.within_limits": of(chain=puma, q=Q, limit_tolerance=1e-9),
    "inverse_kinematics.damped_pseudo_inverse": of(J=J, damping=0.1, weights=np.ones(6)),
    "inverse_kinematics.null_space_projector": of(J=lambda: J()[:3], weights=np.ones(6)),
    "inverse_kinematics.null_space_step": of(
        chain=ur5e, q=Q, objective=np.ones(6), gain=0.1, rows="translational", weights=np.ones(6)
    ),
    "inverse_kinematics.solve": of(
        chain=puma,
        T_world_tool=T,
        rows="full",
        seeds=4,
        near=Q,
        limit_tolerance=1e-9,
        tolerance=1e-9,
        method="auto",
        seed=0,
    ),
    "inverse_kinematics.solve (search)": of(
        chain=planar,
        T_world_tool=lambda: planar().forward([0.3, 0.4]).numpy(),
        rows=(0, 1),
        seeds=4,
        method="search",
        enough=1,
        seed=0,
    ),
    "inverse_kinematics.slices": of(chain=robots.panda, count=2),
    "inverse_kinematics.Solutions.nearest": of(self=solutions, q=Q),
    "inverse_kinematics.spherical_shoulder": of(
        arm=shoulder, T_base_tool=lambda: shoulder().forward(Q).numpy()
    ),
    "inverse_kinematics.spherical_wrist": of(arm=puma, T_base_tool=T),
    "inverse_kinematics.three_parallel_axes": of(arm=ur5e, T_base_tool=lambda: ur5e().forward(Q).numpy()),
    "inverse_kinematics.subproblem_1": of(axis=LINE, p=VECTOR, q=VECTOR[::-1].copy()),
    "inverse_kinematics.subproblem_2": of(first=LINE, second=ACROSS, p=VECTOR, q=VECTOR),
    "inverse_kinematics.subproblem_3": of(axis=LINE, p=VECTOR, q=VECTOR, distance=0.1),
    "inverse_kinematics.subproblem_4": of(axis=LINE, p=VECTOR, normal=np.array([1.0, 0, 0]), offset=0.1),
    # ---- robots and files ----
    **{f"robots.{name}": of(arm=planar) for name in ("bluerov2", "girona500")},
    "robots.build": of(
        description=lambda: robots.describe("uvms"),
        lengths=lambda: {"l1": 0.1},
        rates=np.ones(12),
    ),
    "robots.describe": of(name="puma560"),
    "robots.docking_arm": of(variant="stated"),
    "robots.load": of(name_or_path="puma560"),
    "robots.read_description": of(path=robot_file),
    "robots.uvms": of(l1=0.0, l2=0.6, l3=0.4, y_MB=0.0, rates=np.ones(12)),
    "urdf.read": of(source=urdf_file),
    "urdf.Model.leaves": of(self=model, base="base"),
    "urdf.Model.path": of(self=model, base="base", tip="tool"),
    # ---- numbers of operations ----
    "operations.count": of(expressions=lambda: (sympy.Symbol("x") + 1,)),
    "operations.count_program": of(program=program),
    "operations.count_shared": of(expressions=lambda: (sympy.Symbol("x") + 1,)),
    "operations.determinant": of(size=3, method="terms"),
    "operations.feed_forward": of(inputs=3, neurons=4, form="printed"),
    "operations.gram": of(rows=3, columns=6, symmetric=False),
    "operations.radial_basis": of(inputs=3, neurons=4, form="norm"),
    "operations.singular_values": of(rows=3, columns=6),
    "command.main": of(arguments=("indices", "--json")),
}
