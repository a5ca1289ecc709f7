"""What plot methods need: matplotlib, imported at the first plot, and the types of their results."""
from __future__ import annotations

import importlib
import typing

from ._optional import optional

if typing.TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
else:
    Axes = Figure = typing.Any


def plots() -> typing.Any:
    """Returns the module that draws objects. ImportError without matplotlib."""
    optional("matplotlib", "plots")
    return importlib.import_module(".report.objects", __package__)
