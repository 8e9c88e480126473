"""Which closed form a chain has, if any, and by how much its description misses the conditions of it.

Examples
--------
>>> import dexterity as dx
>>> from dexterity.inverse_kinematics import closed_form, geometric_miss
>>> closed_form(dx.robots.load("ur5e")), closed_form(dx.robots.puma560())
('three parallel axes', 'spherical wrist')
>>> closed_form(dx.robots.load("panda")) is None
True
>>> geometric_miss(dx.robots.puma560()) < 1e-12
True
"""

from __future__ import annotations

import functools

from dexterity import checks
from dexterity.chain import Chain
from dexterity.inverse_kinematics.branches import Form
from dexterity.inverse_kinematics.parallel_axes import PARALLEL_AXES
from dexterity.inverse_kinematics.wrists import SHOULDER, WRIST

__all__ = ["closed_form", "form_of", "geometric_miss", "reasons"]

_FORMS = (WRIST, PARALLEL_AXES, SHOULDER)


def closed_form(chain: Chain) -> str | None:
    """Return the name of the closed form that finds every configuration of a chain at a pose.

    Returns
    -------
    ``"spherical wrist"`` (the axes of the last three of six revolute joints meet), ``"three parallel axes"``
    (those of joints 2, 3 and 4 are parallel and 5 and 6 meet, or the same seen from the tool),
    ``"spherical shoulder"`` (the first three meet), or None: only a search finds configurations. Axes that
    meet or are parallel to six digits count; :func:`.geometric_miss` says by how much they miss.
    """
    form = form_of(checks.instance(chain, "chain", Chain))
    return None if form is None else form.name


def geometric_miss(chain: Chain) -> float:
    """Largest distance [m] and sine of an angle by which axes miss meeting or being parallel.

    Configurations are improved by Newton's method on the chain as it is described, so that they have all
    their digits whatever the miss.

    Raises
    ------
    ValueError
        If the chain has no closed form.
    """
    form = form_of(checks.instance(chain, "chain", Chain))
    if form is None:
        raise ValueError(f"chain {chain.name!r} has no closed form, and so no condition to miss")
    return form.miss(chain)


def form_of(chain: Chain) -> Form | None:
    """First closed form whose conditions a chain fulfils."""
    return next((form for form in _FORMS if _reason(form, chain) is None), None)


def reasons(chain: Chain) -> str:
    """Why a chain has none of the closed forms, in words."""
    return "; ".join(dict.fromkeys(filter(None, (_reason(form, chain) for form in _FORMS))))


@functools.lru_cache(maxsize=128)
def _reason(form: Form, chain: Chain) -> str | None:
    """Why a chain does not fulfil the conditions of a closed form; None if it does."""
    try:
        form.miss(chain)
    except ValueError as error:
        return str(error)
    return None
