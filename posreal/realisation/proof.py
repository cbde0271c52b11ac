"""The proof that a network is the device: its admittance from the graph by nodal analysis, and the target.

Two residuals, and the larger counts. In values: the largest |Y_network − Y|/|Y| over points of the closed
right half plane, from two decades under the lowest corner of Y to two above the highest. In coefficients,
for networks small enough to be computed exactly: the largest |n₁d₂ − n₂d₁|ₖ against what its terms amount
to, which no common factor can hide; infinite where the network has fewer poles than the device.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

from flint import acb, acb_mat, arb, fmpq_poly

from posreal.admittance import Rational, roots
from posreal.admittance.exact import to_float, to_fmpq
from posreal.errors import BadDevice, Unproven
from posreal.network import Graph, Network, Parallel, Series, nodal_admittance, nodal_value

LARGEST_RESIDUAL = 1e-9
EXACT_UP_TO = 30  # elements
DIGITS = 120  # for values: deep networks cancel many
POINTS = 24  # frequencies; three points each
LARGE = 40  # elements, above which nodal matrices are large and
FEW_POINTS = 8  # frequencies have to do
ASIDE = 100  # bits between a resonance of a branch and the point taken instead: closer than dampers of 1e-30 are felt
UNDAMPED = 1e-60  # damping ratio below which synthesis in long arithmetic takes a resonance for undamped


@dataclass(frozen=True)
class Proof:
    """How far a network's admittance is from its target, relatively.

    Attributes
    ----------
    values : float
        Over the closed right half plane.
    coefficients : float or None
        Of numerator and denominator; None for networks too large for exact analysis.
    """

    values: float
    coefficients: float | None

    @property
    def residual(self) -> float:
        """The larger of the two."""
        return max(self.values, self.coefficients or 0.0)


def prove(network: Network, target: Rational, exact_up_to: int = EXACT_UP_TO) -> Proof:
    """Compare a network with a target admittance by nodal analysis of its graph.

    Parameters
    ----------
    network : Network
        Every element valued.
    target : Rational
        Not zero.
    exact_up_to : int
        Most elements for which the rational function itself is computed.
    """
    if len(network) <= exact_up_to:
        found = nodal_admittance(network)
        if found == target:
            return Proof(0.0, 0.0)
        lost = found.degree < target.degree
        return Proof(values_residual(found, target), math.inf if lost else coefficients_residual(found, target))
    return Proof(values_residual(network, target), None)


def require_proof(network: Network, target: Rational, exact_up_to: int = EXACT_UP_TO) -> Proof:
    """The same, and an error where the residual is above 1e-9.

    Raises
    ------
    Unproven
        With the residual.
    """
    proof = prove(network, target, exact_up_to)
    if not proof.residual <= LARGEST_RESIDUAL:
        raise Unproven(
            f"The synthesised network differs from the device by {proof.residual:.1e} of its admittance; "
            "please report the device, and try another method meanwhile."
        )
    return proof


def values_residual(found: Rational | Network, target: Rational) -> float:
    """The largest relative difference over points of the closed right half plane."""
    if isinstance(found, Rational):
        return _worst(partial(value, found), target, POINTS)
    return _worst(partial(nodal_value, found, digits=DIGITS), target, POINTS if len(found) <= LARGE else FEW_POINTS)


def _finite(evaluate: Callable[[acb], acb], s: acb) -> acb | None:
    try:
        got = evaluate(s)
    except (ZeroDivisionError, BadDevice):
        return None
    return got if got.is_finite() else None


def branch_residual(found: Network, target: Rational) -> float:
    """The same with admittances combined branch by branch: no proof, but quick for large networks."""
    return _worst(partial(branch_value, found), target, FEW_POINTS)


def _worst(evaluate: Callable[[acb], acb], target: Rational, count: int) -> float:
    worst = 0.0
    with roots.precision(int(DIGITS * 3.33)):
        for s in points(target, count):
            wanted = value(target, s)
            if wanted.contains(0) or not wanted.is_finite():
                continue
            got = _finite(evaluate, s)
            if got is None:  # a branch resonates there: close by it does not, and the device still has to agree
                s *= 1 + arb(2) ** -ASIDE
                wanted, got = value(target, s), _finite(evaluate, s)
            worst = math.inf if got is None else max(worst, float((abs(got - wanted) / abs(wanted)).upper()))
    return worst if worst > 10.0 ** (10 - DIGITS) else 0.0


def coefficients_residual(found: Rational, target: Rational) -> float:
    """The largest coefficient of n₁d₂ − n₂d₁, each against the sum of the sizes of its terms."""
    difference = found.n * target.d - target.n * found.d
    size = _sizes(found.n) * _sizes(target.d) + _sizes(target.n) * _sizes(found.d)
    return max((to_float(abs(c) / size[k]) for k, c in enumerate(difference.coeffs()) if c != 0), default=0.0)


def branch_value(network: Network, s: acb) -> acb:
    """Y(s) in ball arithmetic, by adding admittances in parallel and impedances in series."""
    if isinstance(network, Parallel):
        return _sum(branch_value(child, s) for child in network.children)
    if isinstance(network, Series):
        return 1 / _sum(1 / branch_value(child, s) for child in network.children)
    if isinstance(network, Graph):
        if network.levers:
            return nodal_value(network, s, DIGITS)
        y = [[acb(0)] * network.size for _ in range(network.size)]
        for u, v, part in network.branches:
            branch = branch_value(part, s)
            for i, j, sign in ((u, u, 1), (v, v, 1), (u, v, -1), (v, u, -1)):
                y[i][j] += sign * branch
        held = acb_mat([row[1:] for row in y[1:]])
        push = acb_mat(network.size - 1, 1, [acb(i == 0) for i in range(network.size - 1)])
        return 1 / held.solve(push)[0, 0]
    (element,) = network.elements()
    return acb(to_fmpq(element.exact)) * s ** ("kcb".index(element.letter) - 1)


def _sum(terms: Iterable[acb]) -> acb:
    total = acb(0)
    for term in terms:
        total += term
    return total


def points(target: Rational, count: int = POINTS) -> list[acb]:
    """On the axis, on the bisector and on the real line, two decades beyond the corners of Y; and its resonances."""
    low, high = corners(target)
    steps = [low * (high / low) ** (i / (count - 1)) for i in range(count)]
    spread = [acb(arb(w) * a, arb(w) * b) for w in steps for a, b in ((0, 1), (1, 1), (1, 0))]
    damped = [root for p in (target.n, target.d) for root, _ in roots.complex_roots(p) if root.imag > 0]
    return spread + [acb(0, abs(root)) for root in damped if abs(root.real) > abs(root) * UNDAMPED]


def corners(target: Rational) -> tuple[float, float]:
    """Two decades under the smallest and over the largest of the poles' and zeros' sizes, in rad/s."""
    sizes = []
    for p in (target.n, target.d):
        coefficients = [(i, c) for i, c in enumerate(p.coeffs()) if c != 0]
        if len(coefficients) > 1:
            with roots.precision(64):
                sizes += [float(abs(root)) for root, _ in roots.complex_roots(p) if not abs(root).contains(0)]
    sizes = [size for size in sizes if 0 < size < math.inf] or [1.0]
    return min(sizes) / 100, max(sizes) * 100


def value(device: Rational, s: acb) -> acb:
    """Y(s) in ball arithmetic."""
    return roots.value(device.n, s) / roots.value(device.d, s)


def _sizes(p: fmpq_poly) -> fmpq_poly:
    return fmpq_poly([abs(c) for c in p.coeffs()])
