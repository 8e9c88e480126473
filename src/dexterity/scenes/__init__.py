"""Three-dimensional scenes in a page: chains, mechanisms, ellipsoids and paths that the reader can turn.

A :class:`~dexterity.scenes.scene.Scene` keeps simple shapes on a tree of frames. Showing it draws the same
shapes twice: as meshcat's commands, which the page replays in meshcat's viewer, and as a still picture, for a
page without WebGL, for print, and for the moment before the viewer starts. No server is involved, and the
same scene gives the same bytes.

The page is ``scene.html`` in this folder: an iframe with everything in it but the viewer's script, which all
scenes of a book share. :func:`~dexterity.scenes.viewer.copy_viewer` puts it where they look for it, and
:func:`~dexterity.scenes.page.standalone` into the scenes themselves, for a notebook.

Examples
--------
>>> import dexterity as dx
>>> scene = dx.scenes.Scene("A PUMA 560")
>>> scene.add_chain(dx.robots.puma560(), [0.0, 0.5, 0.25, 0.0, 0.5, 0.0], name="arm")
>>> scene.add_sliders("arm")
>>> scene.title
'A PUMA 560'
"""

from typing import TYPE_CHECKING

from dexterity import lazy
from dexterity.scenes.mechanisms import Body, Slider
from dexterity.scenes.page import standalone
from dexterity.scenes.scene import Scene, side_by_side
from dexterity.scenes.viewer import copy_viewer

__all__ = ["Body", "Scene", "Slider", "copy_viewer", "side_by_side", "standalone"]

# Hidden from type checkers, for whom every name would otherwise be a module.
if not TYPE_CHECKING:
    __getattr__, __dir__ = lazy.submodules(__name__, __all__)
