"""A network in LaTeX: a circuitikz picture, and its admittance written as it is built.

The picture uses circuitikz's own ``spring``, ``damper`` and ``inerter``.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction

from posreal.network.geometry import LENGTH, Beam, geometry
from posreal.network.graph import Graph
from posreal.network.tree import Element, Network, Series
from posreal.units import engineering

_ROW = 1.6  # height of a row in the units of the geometry
_SYMBOL = {"k": "spring", "c": "damper", "b": "inerter"}
_DOCUMENT = r"""\documentclass[border=4pt]{standalone}
\usepackage[utf8]{inputenc}
\usepackage{circuitikz}
\begin{document}
%s\end{document}
"""


def latex(
    network: Network,
    terminals: tuple[str, str] = ("body", "bogie"),
    *,
    values: bool = True,
    digits: int = 3,
    document: bool = False,
) -> str:
    """A circuitikz picture.

    Parameters
    ----------
    network : Network
    terminals : (str, str)
        What the device is fixed to: the left end and the right end.
    values : bool
        Whether values stand beside the names.
    digits : int
        Significant digits of the values.
    document : bool
        Whether to write a whole document that compiles, or the picture alone.
    """
    plan = geometry(network)
    lines = [r"\begin{circuitikz}[x=1.1cm, y=1.1cm]"]
    lines += [rf"  \draw {_at(*start)} -- {_at(*end)};" for start, end in plan.wires]
    for part in plan.elements:
        label = _label(part.name, part.element, values, digits)
        ends = _at(part.x, part.y), _at(part.x + LENGTH, part.y)
        lines.append(rf"  \draw {ends[0]} to[{_SYMBOL[part.element.letter]}, l={{{label}}}] {ends[1]};")
    lines += [rf"  \fill {_at(*dot)} circle (1.5pt);" for dot in plan.dots]
    for beam in plan.beams:
        lines += _beam(beam, _label(beam.name, beam.lever, values, digits))
    lines.append(rf"  \draw {_at(0, 0)} node[ocirc] {{}} node[left] {{{_escaped(terminals[0])}}};")
    lines.append(rf"  \draw {_at(plan.width, 0)} node[ocirc] {{}} node[right] {{{_escaped(terminals[1])}}};")
    text = "\n".join([*lines, r"\end{circuitikz}"]) + "\n"
    return _DOCUMENT % text if document else text


def formula(network: Network) -> str:
    r"""Y(s) in symbols, in the form in which the network is put together.

    Examples
    --------
    >>> from posreal.network import parse
    >>> print(formula(parse("k | (c + b)")))
    Y = \frac{k}{s} + \cfrac{1}{\cfrac{1}{c} + \cfrac{1}{b\,s}}
    """
    return f"Y = {_admittance(network, iter(network.names))}"


def symbol(name: str) -> str:
    """The name as a symbol with its index: ``k_{1}``, ``c_{\\mathrm{e}}``."""
    index = name[1:].replace("_", r"\_")
    return name[0] + (f"_{{{index}}}" if index.isdigit() else rf"_{{\mathrm{{{index}}}}}" if index else "")


def _admittance(network: Network, names: Iterator[str]) -> str:
    if isinstance(network, Element):
        name = symbol(next(names))
        return {"k": rf"\frac{{{name}}}{{s}}", "c": name, "b": rf"{name}\,s"}[network.letter]
    if isinstance(network, Graph):
        inside = [symbol(next(names)) for _ in network.elements()]
        return rf"Y_{{\mathrm{{graph}}}}({', '.join(inside)})"
    parts = [_admittance(child, names) for child in network.children]
    if isinstance(network, Series):
        return r"\cfrac{1}{" + " + ".join(rf"\cfrac{{1}}{{{part}}}" for part in parts) + "}"
    return " + ".join(parts)


def _label(name: str, element: Element, values: bool, digits: int) -> str:
    text = f"${symbol(name)}$"
    if not values or element.value is None:
        return text
    value: Fraction = element.value
    number, _, unit = engineering(value, element.unit, digits).partition(" ")
    number = re.sub(r"e(-?\d+)", r"\\cdot 10^{\1}", number)
    unit = unit.replace("·", r"\,").replace("µ", r"\mu ")
    return text + rf"\ ${number}" + (rf"\,\mathrm{{{unit}}}$" if unit else "$")


def _beam(beam: Beam, label: str) -> list[str]:
    low, _, high = sorted((beam.near, beam.pivot, beam.far))
    left, right, tip = _at(low, beam.y), _at(high, beam.y), _at(beam.pivot, beam.y)
    return [
        rf"  \draw[line width=2.5pt] {left} -- {right} node[pos=0.25, above] {{{label}}};",
        rf"  \draw[fill=white] {tip} -- ++(-0.15,-0.28) -- ++(0.3,0) -- cycle;",
        rf"  \draw {_at(beam.near, beam.y)} node[ocirc] {{}} node[below right] {{\scriptsize 1}};",
        rf"  \draw {_at(beam.far, beam.y)} node[ocirc] {{}} node[below left] {{\scriptsize $n$}};",
    ]


def _at(x: float, y: float) -> str:
    return f"({x:g},{-_ROW * y:g})"


def _escaped(label: str) -> str:
    special = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
    return "".join(special.get(mark, "\\" + mark if mark in "&%$#_{}" else mark) for mark in label)
