"""A network as a picture, PNG or SVG, with symbols of springs, dampers, inerters and levers.

The damper is a piston in an open cylinder, the inerter a rack that turns a flywheel in a closed case.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from posreal.errors import BadInput, listed, shown
from posreal.files import write_whole
from posreal.network.geometry import LENGTH, Beam, Geometry, Placed, geometry
from posreal.network.tree import Network
from posreal.units import engineering

FORMATS = ("png", "svg")

_ROW = 1.5  # height of a row, in the units in which an element is LENGTH long
_HALF = 0.22  # half the height of a symbol


def picture(
    network: Network,
    terminals: tuple[str, str] = ("body", "bogie"),
    *,
    format: str = "svg",
    values: bool = True,
    digits: int = 3,
    dpi: float = 120,
) -> bytes:
    """Draw a network; the bytes of an image file.

    Parameters
    ----------
    network : Network
    terminals : (str, str)
        What the device is fixed to: the left end and the right end.
    format : {"svg", "png"}
    values : bool
        Whether values stand beside the names.
    digits : int
        Significant digits of the values.
    dpi : float
        Dots per inch of a PNG.
    """
    if format not in FORMATS:
        raise BadInput(f"A picture cannot be made as {shown(format)}; give {listed(FORMATS)}.")
    plan = geometry(network)
    drawing = _drawn(plan, terminals, values, digits)
    if format == "svg":
        return bytes(drawing.get_imagedata("svg"))
    return _png(drawing, plan, max(len(label) for label in terminals), dpi)


def save_picture(network: Network, path: str | Path, **options: Any) -> None:
    """Write `picture` to a file; the format is the file's ending, .png or .svg."""
    write_whole(path, picture(network, format=Path(path).suffix.lower().lstrip("."), **options))


def _drawn(plan: Geometry, terminals: tuple[str, str], values: bool, digits: int) -> Any:
    import schemdraw
    from schemdraw import elements as elm

    drawing = schemdraw.Drawing(canvas="svg", show=False)
    drawing.config(unit=LENGTH, fontsize=10, lw=1.4)
    for (x0, y0), (x1, y1) in plan.wires:
        drawing.add(elm.Line().at((x0, -_ROW * y0)).to((x1, -_ROW * y1)))
    for x, y in plan.dots:
        drawing.add(elm.Dot(radius=0.06).at((x, -_ROW * y)))
    for placed in plan.elements:
        drawing.add(_symbol(placed, _label(placed, values, digits)))
    for beam in plan.beams:
        for part in _beam(beam, _label(beam, values, digits)):
            drawing.add(part)
    for x, label, side in ((0, terminals[0], "left"), (plan.width, terminals[1], "right")):
        drawing.add(elm.Dot(open=True, radius=0.08).at((x, 0)).theta(0).label(label, loc=side))
    return drawing


def _label(placed: Placed | Beam, values: bool, digits: int) -> str:
    element = placed.element if isinstance(placed, Placed) else placed.lever
    if not values or element.value is None:
        return placed.name
    return f"{placed.name}  {engineering(element.value, element.unit, digits)}"


def _symbol(placed: Placed, label: str) -> Any:
    from schemdraw import elements as elm
    from schemdraw.segments import Segment, SegmentCircle, SegmentPoly

    a, b, h = 0.55, LENGTH - 0.55, _HALF  # the symbol's ends
    parts: list[Any]
    if placed.element.letter == "k":
        teeth = 9
        step = (b - a) / teeth
        points = [(a + (i + 0.5) * step, h * (1 if i % 2 else -1)) for i in range(teeth)]
        parts = [Segment([(0, 0), (a, 0), *points, (b, 0), (LENGTH, 0)])]
    elif placed.element.letter == "c":
        piston = a + 0.55 * (b - a)
        parts = [
            Segment([(0, 0), (a, 0)]),
            Segment([(b, h), (a, h), (a, -h), (b, -h)]),
            Segment([(piston, 0.75 * h), (piston, -0.75 * h)], lw=2.6),
            Segment([(piston, 0), (LENGTH, 0)]),
        ]
    else:
        wheel, radius = (a + b) / 2, 0.62 * h
        parts = [
            Segment([(0, 0), (a, 0)]),
            SegmentPoly([(a, h), (b, h), (b, -h), (a, -h)], closed=True),
            SegmentCircle((wheel, 0.25 * h), radius),
            SegmentCircle((wheel, 0.25 * h), 0.035, fill="black"),
            Segment([(a + 0.12, 0.25 * h - radius), (b - 0.12, 0.25 * h - radius)]),
            Segment([(b, 0), (LENGTH, 0)]),
        ]
    symbol = elm.Element().at((placed.x, -_ROW * placed.y)).theta(0)
    symbol.segments.extend(parts)
    symbol.segments.append(_text((LENGTH / 2, h + 0.12), label))
    return symbol


def _beam(beam: Beam, label: str) -> list[Any]:
    """A thick bar with a triangle at the pivot and its arms marked 1 (near) and n (far)."""
    from schemdraw import elements as elm
    from schemdraw.segments import Segment, SegmentCircle, SegmentPoly

    y, points = -_ROW * beam.y, (beam.near, beam.pivot, beam.far)
    bar = elm.Element().at((0, 0)).theta(0)
    bar.segments.append(Segment([(min(points), y), (max(points), y)], lw=4.5))
    for x, mark in ((beam.near, "1"), (beam.far, "n")):
        bar.segments.append(SegmentCircle((x, y), 0.08, fill="white"))
        inward = 0.2 if x < max(points) else -0.2
        bar.segments.append(_text((x + inward, y + 0.1), mark))
    tip = beam.pivot
    bar.segments.append(
        SegmentPoly([(tip, y), (tip - 0.15, y - 0.28), (tip + 0.15, y - 0.28)], closed=True, fill="white")
    )
    left, right = sorted(points)[:2] if sorted(points)[1] != tip else (min(points), tip)
    bar.segments.append(_text(((left + right) / 2, y + 0.12), label))
    return [bar]


def _text(at: tuple[float, float], label: str) -> Any:
    from schemdraw.segments import SegmentText

    return SegmentText(at, label, align=("center", "bottom"), fontsize=9)


def _png(drawing: Any, plan: Geometry, letters: int, dpi: float) -> bytes:
    """Drawn on a figure of its own, so that no global state of pyplot is touched."""
    from io import BytesIO

    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    side, inch = 0.4 + 0.16 * letters, 0.5
    width, height = plan.width + 2 * side, _ROW * plan.rows
    figure = Figure(figsize=(inch * width, inch * height))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    drawing.draw(show=False, canvas=axes)
    axes.set_aspect("equal")
    axes.set_xlim(-side, plan.width + side)
    axes.set_ylim(-_ROW * plan.rows + 0.85, 0.85)
    file = BytesIO()
    figure.savefig(file, format="png", dpi=dpi, facecolor="white")
    return file.getvalue()
