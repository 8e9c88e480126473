"""Training data and test points of paper D.

Sections 3.3 and 4 of Rouvinen (1999): a grid of strokes and payloads with the tip of the flexible crane, and
25 points to be reached with five payloads.

Examples
--------
>>> import dexterity as dx
>>> len(dx.crane.TEST_POINTS), len(dx.crane.TEST_PAYLOADS)
(25, 5)
>>> data = dx.crane.training_set()
>>> data.rows.shape, data.columns[:4]
(torch.Size([3670, 8]), ('s1', 's2', 's3', 'payload'))
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from jaxtyping import Float64
from torch import Tensor

from dexterity import checks
from dexterity.crane.description import Crane, given_crane, stroke_values
from dexterity.crane.kinematics import tip_position
from dexterity.crane.structure import load_response
from dexterity.spatial.values import on_cpu

__all__ = ["COLUMNS", "TEST_PAYLOADS", "TEST_POINTS", "TrainingSet", "training_set"]

COLUMNS = ("s1", "s2", "s3", "payload", "x", "y", "dx", "dy")
"""Columns of the training set, strokes and tip and its deflection in [m], the payload in [kg]."""

TEST_PAYLOADS = (30.0, 120.0, 260.0, 310.0, 470.0)
"""Payloads of the test [kg]."""

_EVEN_ROWS = {
    6: range(1, 5),
    4: range(3, 6),
    2: range(2, 7),
    0: range(2, 7),
    -2: range(1, 6),
    -4: range(2, 3),
}

TEST_POINTS: tuple[tuple[float, float], ...] = (
    (1.0, 7.0),
    (2.0, 7.0),
    *((float(x), float(y)) for y, columns in _EVEN_ROWS.items() for x in columns),
)
"""The 25 points of the test (x, y) [m].

They are drawn in Fig. 4.2 and listed nowhere. Taken are whole x and even y in the working area, with (1, 7)
and (2, 7), which the text names, and without (1, 2) and (1, 0).
"""

_STROKE_VALUES = (9, 9, 5)
_PAYLOADS = tuple(range(50, 501, 50))


@dataclass(frozen=True)
class TrainingSet:
    """What the networks learn from, one row an analysis.

    Attributes
    ----------
    rows
        (N, 8) values of `COLUMNS`; ``pandas.DataFrame(rows, columns=columns)`` is a table of them.
    columns
        `COLUMNS`.
    """

    rows: Float64[Tensor, "N 8"]
    columns: tuple[str, ...] = COLUMNS

    def __post_init__(self) -> None:
        rows = on_cpu(self.rows, "rows")
        columns = checks.Each(checks.name)(self.columns, "columns")
        if rows.ndim != 2 or rows.shape[1] != len(COLUMNS) or columns != COLUMNS:
            raise ValueError(f"rows has shape {tuple(rows.shape)}; columns {', '.join(COLUMNS)} are needed")
        object.__setattr__(self, "rows", rows)

    @property
    def strokes(self) -> Float64[Tensor, "N 3"]:
        """Strokes s1, s2, s3 [m]."""
        return self.rows[:, :3]

    @property
    def payload(self) -> Float64[Tensor, " N"]:
        """Payload [kg]."""
        return self.rows[:, 3]

    @property
    def tip(self) -> Float64[Tensor, "N 2"]:
        """Tip of the flexible crane [m]."""
        return self.rows[:, 4:6]

    @property
    def deflection(self) -> Float64[Tensor, "N 2"]:
        """Flexible tip less rigid one [m]."""
        return self.rows[:, 6:8]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.rows)


def training_set(crane: Crane | None = None) -> TrainingSet:
    """Compute the thesis's training data by linear statics: 3 670 rows for its crane.

    The strokes take 9, 9 and 5 values from their lower to their upper limits, the payload ten, from 50 kg to
    500 kg. Of these 4 050 vectors those are left out whose rigid tip has a negative x.

    References
    ----------
    Rouvinen (1999), section 3.3 and Table 4.1 there.
    """
    crane = given_crane(crane)
    strokes = torch.cartesian_prod(*stroke_values(crane, _STROKE_VALUES))
    rigid = tip_position(strokes, crane)
    strokes, rigid = strokes[rigid[:, 0] >= 0], rigid[rigid[:, 0] >= 0]
    response = load_response(strokes, crane)
    payload = torch.tensor(_PAYLOADS, dtype=torch.float64)[:, None]
    sag = response.own_weight[:, None] + payload * response.per_kilogram[:, None]
    strokes, rigid = strokes[:, None].expand(-1, len(payload), -1), rigid[:, None]
    rows = torch.cat([strokes, payload.expand(len(strokes), -1, -1), rigid + sag, sag], dim=-1)
    return TrainingSet(rows.flatten(0, 1))
