"""Groups of options that several subcommands share, as dataclasses whose fields are the options.

:func:`grouped` gives a function of such groups the signature that typer reads, with an option for each field.

Examples
--------
>>> import inspect
>>> from dexterity.command.options import RobotOptions, grouped
>>> @grouped
... def joints(*, robot: RobotOptions) -> int:
...     return robot.chain().joints
>>> list(inspect.signature(joints).parameters)
['robot', 'base', 'tip']
>>> joints(robot="puma560")
6
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer

from dexterity.command.reports import Form, Report, check_output

if TYPE_CHECKING:
    from torch import Tensor

    from dexterity.chain import Chain
    from dexterity.indices import Index

__all__ = [
    "Configurations",
    "Frame",
    "IndexOptions",
    "Language",
    "Poses",
    "ReportOptions",
    "RobotOptions",
    "grouped",
]


def grouped(function: Callable[..., Any]) -> Callable[..., Any]:
    """Replace each argument whose type is a dataclass by the fields of that dataclass.

    Parameters
    ----------
    function
        A function of keywords. It gets each group as an object, made from the options given.
    """
    parameters: list[inspect.Parameter] = []
    groups: dict[str, Any] = {}
    for parameter in inspect.signature(function, eval_str=True).parameters.values():
        kind = parameter.annotation
        if not is_dataclass(kind):
            parameters.append(parameter)
            continue
        groups[parameter.name] = kind
        hints = get_type_hints(kind, include_extras=True)
        parameters += [
            inspect.Parameter(
                field.name,
                inspect.Parameter.KEYWORD_ONLY,
                default=inspect.Parameter.empty if field.default is MISSING else field.default,
                annotation=hints[field.name],
            )
            for field in fields(kind)
        ]

    @functools.wraps(function)
    def ungrouped(**values: Any) -> Any:
        made = {
            name: kind(
                **{field.name: values.pop(field.name) for field in fields(kind) if field.name in values}
            )
            for name, kind in groups.items()
        }
        return function(**values, **made)

    ungrouped.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    ungrouped.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    return ungrouped


@dataclass(frozen=True)
class RobotOptions:
    """A robot: a name of the package, a URDF with its base and tip, or a robot file."""

    robot: Annotated[
        str,
        typer.Argument(
            help="Name of a robot, a URDF, or a robot file (.toml, or .csv with Denavit–Hartenberg rows).",
            show_default=False,
        ),
    ]
    base: Annotated[
        str | None,
        typer.Option("--base", help="Link of the URDF where the chain begins; the root by default."),
    ] = None
    tip: Annotated[
        str | None,
        typer.Option("--tip", help="Link of the URDF where the chain ends; its only leaf by default."),
    ] = None

    def chain(self) -> Chain:
        """Read the robot; errors are those of :func:`dexterity.robots.load`."""
        import dexterity as dx

        return dx.robots.load(self.robot, base=self.base, tip=self.tip)


class Frame(Enum):
    """Jacobian of which an index is taken."""

    GEOMETRIC = "geometric"
    BODY = "body"
    SPATIAL = "spatial"


class Language(Enum):
    """Language of exported files."""

    C = "c"
    JAVASCRIPT = "javascript"
    ONNX = "onnx"


_INDEX = "Index"


@dataclass(frozen=True)
class IndexOptions:
    """Frame, rows and limits that give an index its meaning."""

    frame: Annotated[
        Frame, typer.Option("--frame", help="Jacobian of the index.", rich_help_panel=_INDEX)
    ] = Frame.GEOMETRIC
    rows: Annotated[
        str,
        typer.Option(
            "--rows",
            help="full, translational, rotational, or rows such as vx,vy,wz.",
            rich_help_panel=_INDEX,
        ),
    ] = "full"
    direction: Annotated[
        str | None,
        typer.Option(
            "--direction", help="Direction of a ratio: a number for each row.", rich_help_panel=_INDEX
        ),
    ] = None
    length: Annotated[
        str | None,
        typer.Option(
            "--length", help="Characteristic length (m) of the linear rows.", rich_help_panel=_INDEX
        ),
    ] = None
    joint_rates: Annotated[
        str | None,
        typer.Option(
            "--joint-rates", help="Largest joint rates; the robot's by default.", rich_help_panel=_INDEX
        ),
    ] = None
    tool_rates: Annotated[
        str | None,
        typer.Option("--tool-rates", help="Six largest tool rates; 1 by default.", rich_help_panel=_INDEX),
    ] = None
    joint_noise: Annotated[
        str | None,
        typer.Option(
            "--joint-noise", help="Standard deviations of the joints (rad, m).", rich_help_panel=_INDEX
        ),
    ] = None

    def index(self, name: str, joints: int) -> Index:
        """Return the index of that name with these options.

        Raises
        ------
        ValueError
            If the index or an option is unknown, or does not fit the number of joints.
        """
        from dexterity.command import inputs

        return inputs.index(self, name, joints)


@dataclass(frozen=True)
class Configurations:
    """Configurations from words and from a file."""

    q: Annotated[
        list[str] | None,
        typer.Option("--q", help="Joint values (rad, m) between commas, such as 0,-pi/4,90deg. Repeatable."),
    ] = None
    file: Annotated[
        Path | None,
        typer.Option("--file", "-f", help="Configurations as CSV, .npy or JSON; - is standard input."),
    ] = None

    def read(self, chain: Chain) -> Tensor:
        """Read them; errors are those of :func:`dexterity.command.inputs.configurations`."""
        from dexterity.command import inputs

        return inputs.configurations(chain, self.q or [], self.file)


@dataclass(frozen=True)
class Poses:
    """Tool poses from words and from a file."""

    pose: Annotated[
        list[str] | None,
        typer.Option(
            "--pose",
            help="Tool pose: x,y,z (m), then roll,pitch,yaw (rad) or quaternion qx,qy,qz,qw. Repeatable.",
        ),
    ] = None
    poses: Annotated[
        Path | None,
        typer.Option(
            "--poses", help="Tool poses: CSV with x,y,z,roll,pitch,yaw, .npy or JSON; - is standard input."
        ),
    ] = None

    def read(self) -> Tensor:
        """Read them; errors are those of :func:`dexterity.command.inputs.poses`."""
        from dexterity.command import inputs

        return inputs.poses(self.pose or [], self.poses)


_OUTPUT = "Output"


@dataclass(frozen=True)
class ReportOptions:
    """Form of the answer, and the file that it goes to."""

    as_csv: Annotated[
        bool, typer.Option("--csv", help="Print CSV with all digits.", rich_help_panel=_OUTPUT)
    ] = False
    as_json: Annotated[
        bool, typer.Option("--json", help="Print one JSON object.", rich_help_panel=_OUTPUT)
    ] = False
    output: Annotated[
        Path | None,
        typer.Option(
            "--output", "-o", help="Write a .csv or .json file, whole or not at all.", rich_help_panel=_OUTPUT
        ),
    ] = None

    def __post_init__(self) -> None:
        if self.as_csv + self.as_json + (self.output is not None) > 1:
            raise ValueError("--csv, --json and --output exclude each other; give one of them")
        check_output(self.output)

    def give(self, report: Report) -> None:
        """Print the report, or write it."""
        form = Form.CSV if self.as_csv else Form.JSON if self.as_json else Form.TABLE
        report.give(form, self.output)
