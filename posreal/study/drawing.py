"""Plots on sheets of their own: no pyplot, so whatever backend the user draws with stays as it is."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from posreal.files import require_writable, write_whole

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = (".png", ".svg", ".pdf")


def sheet(width: float, height: float, panels: int = 1, *, grid: str = "both") -> tuple[Figure, Any]:
    """A figure of so many inches and its axes, side by side.

    Parameters
    ----------
    width, height : float
    panels : int
    grid : str
        Lines of which axis: ``"x"``, ``"y"`` or ``"both"``.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots(1, panels, squeeze=False)[0]
    for axis in axes:
        axis.grid(True, axis=grid, color="0.92", linewidth=0.6)
    return figure, axes


def save(figure: Figure, path: str | Path, dpi: float = 150) -> Path:
    """Write a figure in the format of the file's ending.

    Raises
    ------
    BadInput
        For another ending, or if it cannot be written.
    """
    path = require_writable(path, FORMATS)
    content = BytesIO()
    figure.savefig(content, format=path.suffix.lower().lstrip("."), dpi=dpi)
    return write_whole(path, content.getvalue())


def svg(figure: Figure) -> bytes:
    """A figure as SVG, the same bytes for the same figure."""
    from matplotlib import rc_context

    content = BytesIO()
    with rc_context({"svg.hashsalt": "posreal"}):
        figure.savefig(content, format="svg", metadata={"Date": None})
    return content.getvalue()
