"""A network's admittance from its graph, by nodal analysis: the proof that it is the device it stands for.

With node 0 held, L(s) the Laplacian of the elements over the free nodes and L₁₁ the same without node 1,

    Y = det L / det L₁₁.

Each element enters L as a matrix of rank one, so det L is a Laurent polynomial in s with powers from
−(springs) to +(inerters). It is computed exactly at that many positive rational points, where L is positive
definite and elimination needs no pivoting, and interpolated. Nothing here uses that admittances add in
parallel and impedances in series, so agreement with the tree's own answer is evidence for both.
"""

from __future__ import annotations

from typing import Any

import flint
from flint import acb, acb_mat, fmpq, fmpq_poly

from posreal.admittance.rational import Rational
from posreal.errors import BadDevice
from posreal.network.circuit import Circuit, Edge, circuit
from posreal.network.tree import Network, exact_value

Row = dict[int, Any]


def nodal_admittance(network: Network) -> Rational:
    """Y(s) by nodal analysis on the graph, exactly.

    Parameters
    ----------
    network : Network
        Every element valued; bridges and levers allowed.

    Raises
    ------
    BadDevice
        If an element has no value, or a lever leaves a node free to move without force.
    """
    flat = circuit(network)
    directions = _directions(flat)
    values = [exact_value(edge.element) for edge in flat.edges]
    letters = [edge.element.letter for edge in flat.edges]
    free = len({node for row in directions for node in row})
    low, high = (min(free, letters.count(letter)) for letter in "kb")
    order: list[int] = []
    points = [fmpq(i) for i in range(1, low + high + 2)]
    whole, minor = [], []
    for s in points:
        admittances = [theta * s ** _power(letter) for theta, letter in zip(values, letters, strict=True)]
        y, rest = _eliminated(directions, admittances, order)
        whole.append(y * rest * s**low)
        minor.append(rest * s**low)
    return Rational(_interpolated(points, whole), _interpolated(points, minor))


def nodal_value(network: Network, s: complex | acb, digits: int = 50) -> acb:
    """Y(s) by nodal analysis in ball arithmetic: the radius of the answer bounds its error.

    Parameters
    ----------
    s : complex or flint.acb
        Anything but 0; give an acb where a float is not the point meant.
    digits : int
        Decimal digits to work with.
    """
    flat = circuit(network)
    directions = _directions(flat)
    nodes = sorted({node for row in directions for node in row})
    place = {node: i for i, node in enumerate(nodes)}
    with flint.ctx.workprec(int(digits * 3.33) + 16):
        point = s if isinstance(s, acb) else acb(complex(s).real, complex(s).imag)
        cells = [[acb(0)] * len(nodes) for _ in nodes]
        for edge, row in zip(flat.edges, directions, strict=True):
            y = acb(exact_value(edge.element)) * point ** _power(edge.element.letter)
            for i, a in row.items():
                for j, b in row.items():
                    cells[place[i]][place[j]] += y * acb(a * b)
        rhs = acb_mat(len(nodes), 1, [acb(node == 1) for node in nodes])
        try:
            motion = acb_mat(cells).solve(rhs)
        except ZeroDivisionError:
            raise BadDevice(
                f"s = {s} is a zero of this network's impedance to {digits} digits; move it a little."
            ) from None
        return 1 / motion[place[1], 0]


def _power(letter: str) -> int:
    return "kcb".index(letter) - 1


def _directions(flat: Circuit) -> list[Row]:
    """For each edge, how its stretch depends on the free nodes once the levers are obeyed."""
    motion: dict[int, Row] = {node: {node: fmpq(1)} for node in range(1, flat.size)} | {0: {}}
    for bar in flat.bars:
        ratio = exact_value(bar.lever)
        tie = _combined([(fmpq(1), motion[bar.far]), (ratio - 1, motion[bar.pivot]), (-ratio, motion[bar.near])])
        given_up = max((node for node in tie if node != 1), default=None)
        if given_up is None:
            if tie:
                raise BadDevice(f"The lever {bar.name} holds the two terminals together; give it another node.")
            continue
        rule = {node: -weight / tie[given_up] for node, weight in tie.items() if node != given_up}
        for node, row in motion.items():
            if given_up in row:
                weight = row[given_up]
                motion[node] = _combined([(fmpq(1), {k: v for k, v in row.items() if k != given_up}), (weight, rule)])
    return [_stretch(motion, edge) for edge in flat.edges]


def _stretch(motion: dict[int, Row], edge: Edge) -> Row:
    return _combined([(fmpq(1), motion[edge.start]), (fmpq(-1), motion[edge.end])])


def _combined(terms: list[tuple[fmpq, Row]]) -> Row:
    total: Row = {}
    for weight, row in terms:
        for node, value in row.items():
            total[node] = total.get(node, 0) + weight * value
    return {node: value for node, value in total.items() if value != 0}


def _eliminated(directions: list[Row], admittances: list[fmpq], order: list[int]) -> tuple[fmpq, fmpq]:
    """Y and det L₁₁ at one point; the order of elimination is found at the first and kept in `order`."""
    rows: dict[int, Row] = {1: {}}
    for y, direction in zip(admittances, directions, strict=True):
        for i, a in direction.items():
            row = rows.setdefault(i, {})
            for j, b in direction.items():
                row[j] = row.get(j, 0) + y * a * b
    known = bool(order)
    rest = fmpq(1)
    for step in range(len(rows) - 1):
        node = order[step] if known else min((n for n in rows if n != 1), key=lambda n: (len(rows[n]), n))
        if not known:
            order.append(node)
        row = rows.pop(node)
        pivot = row.pop(node, 0)
        if pivot == 0:
            raise BadDevice(f"Node {node} can move without any force, so this is no device; join it up.")
        rest *= pivot
        for i, a in row.items():
            target = rows[i]
            del target[node]
            for j, b in row.items():
                target[j] = target.get(j, 0) - a * b / pivot
    return rows[1].get(1, fmpq(0)), rest


def _interpolated(points: list[fmpq], values: list[fmpq]) -> fmpq_poly:
    """The polynomial of least degree through the points, by Newton's divided differences."""
    differences = list(values)
    for level in range(1, len(points)):
        for i in range(len(points) - 1, level - 1, -1):
            differences[i] = (differences[i] - differences[i - 1]) / (points[i] - points[i - level])
    result = fmpq_poly([differences[-1]])
    for point, difference in zip(points[-2::-1], differences[-2::-1], strict=True):
        result = result * fmpq_poly([-point, 1]) + difference
    return result
