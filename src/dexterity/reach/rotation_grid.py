r"""Grids of rotations that leave no rotation far from all of them.

The largest grids take the directions of HEALPix, which have equal areas on the sphere, for the tool's z axis,
and for each of them evenly spaced rolls about it. The smallest two are the rotations of a cube and of an
icosahedron. How far a rotation can be from the nearest of a grid is its covering radius:

=========== ===== ===== ===== ====== ====== ====== ======
rotations      24    60    72    576   1944   4608   9000
radius [°]   62.8  44.5  49.6   26.4   17.9   13.5   10.8
=========== ===== ===== ===== ====== ====== ====== ======

Examples
--------
>>> import math
>>> from dexterity import reach
>>> grid = reach.rotations(500)
>>> len(grid), round(math.degrees(reach.covering_radius(grid)), 1)
(576, 26.4)
>>> len(reach.rotations(spacing=math.radians(45)))
60

References
----------
Yershova, Jain, LaValle & Mitchell (2010), Generating uniform incremental grids on SO(3) using the Hopf
fibration, IJRR 29(7). Górski et al. (2005), HEALPix, ApJ 622, section 5.1. Conway & Sloane (1999).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import numpy as np
import torch
from jaxtyping import Float64
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation
from torch import Tensor

from dexterity import spatial
from dexterity.spatial import TensorLike
