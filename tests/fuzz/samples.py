"""Good arguments of the public functions, by the function's name; brackets tell samples apart."""

from __future__ import annotations

import samples_drawn
import samples_exact
import samples_learned
import samples_systems
from good_values import Arguments

SAMPLES: dict[str, Arguments] = {
    **samples_exact.SAMPLES,
    **samples_learned.SAMPLES,
    **samples_drawn.SAMPLES,
    **samples_systems.SAMPLES,
}
