"""What the commands print: JSON documents, designs, networks, and progress on standard error."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from posreal.admittance import Rational
    from posreal.network import Network
    from posreal.network.usual import Outside
    from posreal.realisation import Realisation
    from posreal.specification.design import Design
    from posreal.specification.problem import Problem


def print_json(document: Any) -> None:
    """One JSON document; infinities have no place in it."""
    print(json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False))


TERMINALS = ("body", "bogie")  # of a network by itself, whatever it will stand between


def drawn(network: Network, ascii: bool = False, width: int = 100, terminals: tuple[str, str] = TERMINALS) -> str:
    """The text diagram."""
    from posreal.network.diagram import diagram

    return diagram(network, terminals, ascii=ascii, width=width)


def network_dict(
    realisation: Realisation,
    ascii: bool,
    width: int = 100,
    terminals: tuple[str, str] = TERMINALS,
    *,
    beyond: Sequence[Outside] = (),
) -> dict[str, Any]:
    """NETWORK of the JSON interface."""
    return realisation.to_dict() | {
        "outside_usual": [one.to_dict() for one in beyond],
        "inertance_built": _inertance_built(realisation.network),
        "diagram": drawn(realisation.network, ascii, width, terminals),
    }


def _inertance_built(network: Network) -> float:
    """All inerters of a network together, kg: what has to be made, not what shows at the port."""
    return float(sum(element.exact for element in network.elements() if element.letter == "b"))


def print_network(
    realisation: Realisation,
    ascii: bool,
    width: int,
    *,
    shown: Network | None = None,
    terminals: tuple[str, str] = TERMINALS,
    beyond: str = "",
) -> None:
    """Diagram (of `shown`, the network in its mounting, if given), element table, notation, what of it lies `beyond`
    what can be bought, and proof."""
    from posreal.network.table import table as elements
    from posreal.text_table import counted
    from posreal.units import engineering

    counts = realisation.network.counts
    together = f" of {engineering(_inertance_built(realisation.network), 'kg')} in all" if counts.inerters else ""
    kinds = [f"{counted(counts.springs, 'spring')}, {counted(counts.dampers, 'damper')}"]
    kinds += [counted(counts.inerters, "inerter") + together]
    kinds += [counted(counts.levers, "lever")] if counts.levers else []
    print(f"{realisation.method}: {counted(counts.total, 'element')} ({', '.join(kinds)})")
    for note in realisation.notes:
        print(f"  {note}")
    print(f"\n{drawn(shown or realisation.network, ascii, width, terminals)}\n")
    print(f"{elements(realisation.network, digits=4)}\n")
    print(f"{realisation.network}\n")
    if beyond:
        print(f"{beyond}\n")
    print(f"relative residual of its admittance, recomputed from its graph: {realisation.residual:.1e}")


def write_network(
    network: Network,
    paths: Sequence[Path] | None,
    *,
    strut: Network | None = None,
    terminals: tuple[str, str] = TERMINALS,
) -> list[str]:
    """Write the files asked for and say which, as lines; `strut` is drawn, where there is one."""
    from posreal.study.export import export

    for path in paths or ():
        export(network, path, strut=strut, terminals=terminals)
    return [f"wrote {path}" for path in paths or ()]


def check_paths(paths: Sequence[Path] | None) -> None:
    """Refuse files that cannot be written before any work is done."""
    from posreal.study.export import checked

    for path in paths or ():
        checked(path)


def titled(heading: str, problem: Problem) -> list[str]:
    """A heading with what its figures hold under, and what has to be known before they are believed."""
    from posreal.specification.conditions import cautions, in_words

    words = in_words(problem)
    return [heading, *([f"  {words}"] if words else []), *(f"  Caution: {one}." for one in cautions(problem))]


def print_design(design: Design, *, heading: str, draw: bool = False, ascii: bool = False, usual: bool = True) -> None:
    """Every metric of a design, its constraints, how it was found, and (`usual`) what of it cannot be bought."""
    from posreal.study.metric_table import metric_table
    from posreal.text_table import table
    from posreal.units import engineering

    for line in titled(heading, design.problem):
        print(line)
    if draw and design.bought is not None:
        print(f"\n{drawn(design.bought, ascii, terminals=design.problem.place.terminals)}")
    tuned = [
        f"{name} = {engineering(design.parameters[name], 'N/m' if name[0] == 'K' else 'N*s/m', 5)}"
        for name in design.problem.free
        if name in design.parameters
    ]
    if tuned:
        print("  vehicle: " + ", ".join(tuned))
    print(f"\n{table(*metric_table(design))}")
    if design.ideal is not None:
        print(f"  real elements: {design.problem.elements}")
    for constraint in design.problem.constraints:
        print(f"  {constraint}: {constraint.verdict(design.metrics)}")
    how = [_finding(key, value) for key, value in design.found.items() if key != "notes" and value not in ([], ())]
    if how:
        print("  found by: " + ", ".join(how))
    for note in design.found.get("notes", ()):
        print(f"  note: {note}")
    if usual and design.usual_sentence:
        print(f"  {design.usual_sentence}")


def _finding(key: str, value: Any) -> str:
    parts = value if isinstance(value, list | tuple) else [value]
    text = "; ".join(f"{part:.7g}" if isinstance(part, float) else str(part) for part in parts)
    return text if key == "method" else f"{key.replace('_', ' ')} {text}"


def readable(device: Rational, digits: int = 8) -> str:
    """An admittance with coefficients that a person can read (the JSON has them exactly)."""

    def polynomial(coefficients: Sequence[Any]) -> str:
        terms = []
        for power in range(len(coefficients) - 1, -1, -1):
            if coefficients[power] != 0:
                variable = "" if power == 0 else "*s" if power == 1 else f"*s^{power}"
                terms.append(f"{float(coefficients[power]):.{digits}g}{variable}")
        return " + ".join(terms) or "0"

    return f"({polynomial(device.numerator)}) / ({polynomial(device.denominator)})"


@contextmanager
def progress() -> Iterator[Callable[[str], None]]:
    """A line of progress on standard error, if somebody is looking at it."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.console import Console

    with Console(stderr=True).status("working") as status:
        yield lambda text: status.update(text)
