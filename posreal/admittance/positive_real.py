"""Positive real or not, decided exactly [Brune1931].

Y = n/d, coprime over the rationals, is positive real if and only if

1. d has no root in Re s > 0, and roots on the imaginary axis (0 and ∞ included) are simple, with
   residue real and positive;
2. Re Y(jω) = E(ω²)/|d(jω)|² is nowhere negative: E has no root of odd multiplicity in x > 0 and its
   leading sign is positive.

Routh's test, square-free factors and certified root isolation over the rationals answer both, so a
device one part in 1e30 short of positive real is told from one that is exactly on the boundary.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from html import escape
from typing import Any

from flint import arb, fmpq_poly

from posreal.admittance import exact, resistance, roots
from posreal.admittance.device import Device, as_rational
from posreal.admittance.rational import Rational
from posreal.admittance.witness import AxisPole, NegativeReal, RightHalfPlanePole, Witness, as_dict
from posreal.errors import NotPositiveReal


@dataclass(frozen=True)
class Verdict:
    """Whether a device is positive real, and how far it is from the other answer.

    Attributes
    ----------
    device : Rational
        What was judged.
    positive_real : bool
        The answer; also the truth value of the verdict.
    witness : NegativeReal, RightHalfPlanePole, AxisPole or None
        What breaks it.
    margin : float
        The least value of Re Y(jω), 0 ≤ ω ≤ ∞, in N s/m; −inf where it falls without limit.
    margin_at : float
        Where it is attained, rad/s; 0 and inf included.
    touches : tuple of float
        For a positive-real device, the finite ω > 0 where Re Y(jω) is exactly zero.
    lossless : bool
        Positive real with Re Y(jω) = 0 throughout: springs and inerters alone.
    minimum_function : bool
        Positive real, no pole or zero on the axis (0 and ∞ included), yet Re Y(jω) = 0 somewhere.
    degree : int
        McMillan degree.
    static_stiffness, inertance : float
        lim s·Y at 0 (N/m) and lim Y/s at infinity (kg); inf if the pole there is multiple.
    regular : bool or None
        For positive-real functions of degree 2: whether the least Re Y or the least Re 1/Y is at 0 or ∞.
    """

    device: Rational
    positive_real: bool
    witness: Witness | None
    margin: float
    margin_at: float
    touches: tuple[float, ...]
    lossless: bool
    minimum_function: bool
    degree: int
    static_stiffness: float
    inertance: float
    regular: bool | None

    def __bool__(self) -> bool:
        return self.positive_real

    def __str__(self) -> str:
        if not self.positive_real:
            return f"not positive real: {self.witness}"
        if self.lossless:
            return f"positive real, lossless, degree {self.degree}"
        return f"positive real, degree {self.degree}; least Re Y(jω) is {self.margin:.6g} N s/m at {self._place}"

    def facts(self) -> tuple[str, ...]:
        """What else is known, a sentence each, as far as it applies."""
        said = []
        if not self.positive_real and not isinstance(self.witness, NegativeReal):
            said.append(f"degree {self.degree}")
        elif not self.positive_real:
            said.append(f"degree {self.degree}; least Re Y(jω) is {self.margin:.6g} N s/m at {self._place}")
        if self.minimum_function:
            said.append("a minimum function: no pole or zero on the axis, and yet Re Y(jω) falls to zero")
        if self.touches:
            said.append("Re Y(jω) is exactly zero at ω = " + ", ".join(f"{w:.12g}" for w in self.touches) + " rad/s")
        if 0 < self.static_stiffness < math.inf:
            said.append(f"static stiffness {self.static_stiffness:.6g} N/m (lim s·Y at 0)")
        if 0 < self.inertance < math.inf:
            said.append(f"inertance at high frequency {self.inertance:.6g} kg (lim Y/s at infinity)")
        if self.regular is not None and not self.lossless:
            said.append(
                "regular: least Re Y or least Re 1/Y is at 0 or infinity"
                if self.regular
                else "not regular: neither least Re Y nor least Re 1/Y is at 0 or infinity"
            )
        return tuple(said)

    def _repr_html_(self) -> str:
        return "<div>" + "<br>".join(map(escape, (str(self), *self.facts()))) + "</div>"

    @property
    def _place(self) -> str:
        return "ω = ∞" if math.isinf(self.margin_at) else f"ω = {self.margin_at:.12g} rad/s"

    def to_dict(self) -> dict[str, Any]:
        """JSON-able form; infinities are the text "inf" or "-inf"."""
        return {
            "positive_real": self.positive_real,
            "witness": None if self.witness is None else as_dict(self.witness),
            "margin": _json(self.margin),
            "margin_at": _json(self.margin_at),
            "touches": list(self.touches),
            "lossless": self.lossless,
            "minimum_function": self.minimum_function,
            "degree": self.degree,
            "static_stiffness": _json(self.static_stiffness),
            "inertance": _json(self.inertance),
            "regular": self.regular,
            "facts": list(self.facts()),
            "text": str(self),
        }

    def check(self) -> Verdict:
        """Judge the device again from scratch."""
        return check(self.device)


def check(device: Device) -> Verdict:
    """Decide whether a device is positive real, exactly.

    Parameters
    ----------
    device : object
        Anything `as_rational` reads: a Rational, text in s, coefficient lists, a network, a python-control
        system.

    Returns
    -------
    Verdict
        True or false, with a witness or the margin.

    Examples
    --------
    >>> check("(s^2 + s + 1)/(s^2 + s + 4)").minimum_function
    True
    >>> print(check("(s^2 + s + 1)/(s^2 + 0.9*s + 4)"))
    not positive real: Re Y(jω) = -0.0332651 at ω = 1.5 rad/s
    """
    y = as_rational(device)
    E, D = resistance.real_part(y)
    witness = _pole_witness(y) or _real_part_witness(y, E)
    good = witness is None
    E, D = resistance.coprime(E, D)
    least = resistance.minimum(E, D)
    margin = least.value if isinstance(least.value, float) else exact.to_float(least.value)
    touching = resistance.touches(E) if good else ()
    return Verdict(
        device=y,
        positive_real=good,
        witness=witness,
        margin=0.0 if touching else max(margin, 0.0) if good else margin,
        margin_at=least.omega,
        touches=touching,
        lossless=good and E.degree() < 0,
        minimum_function=bool(touching) and not _has_axis_root(y),
        degree=y.degree,
        static_stiffness=_limit(y, "static_stiffness"),
        inertance=_limit(y, "inertance"),
        regular=is_regular(y) if good and y.degree == 2 else None,
    )


def is_positive_real(device: Device) -> bool:
    """The bare answer of `check`, without the margin; faster where only yes or no is needed."""
    y = as_rational(device)
    return _pole_witness(y) is None and resistance.is_nonnegative(resistance.real_part(y)[0])


def require(device: Device) -> Rational:
    """The device's admittance, if it is positive real.

    Raises
    ------
    NotPositiveReal
        Carrying the witness.
    """
    y = as_rational(device)
    witness = _pole_witness(y) or _real_part_witness(y, resistance.real_part(y)[0])
    if witness is not None:
        raise NotPositiveReal(
            f"The admittance is not positive real: {witness}; nearest_positive_real (--repair) mends small misses.",
            witness,
        )
    return y


def is_regular(device: Device) -> bool:
    """Whether the least Re Y, or the least Re 1/Y, is attained at ω = 0 or ∞ [JiangSmith2011].

    The device must be positive real.
    """
    y = as_rational(device)
    sides = [y] if y.is_zero() else [y, y.inverse()]
    return any(resistance.is_regular(*resistance.coprime(*resistance.real_part(side))) for side in sides)


# -- poles --------------------------------------------------------------------------------------


def _pole_witness(y: Rational) -> Witness | None:
    axis, power_at_zero, rest = _axis_poles(y.d)
    mirrored = [factor for factor, _ in axis if _real_negative_count(factor) < factor.degree()]
    if mirrored or not roots.is_hurwitz(rest):
        return _right_half_plane_pole(y.d)
    if power_at_zero > 1:
        return AxisPole(0.0, power_at_zero, None)
    if power_at_zero == 1 and (residue := y.n[0] / y.d[1]) < 0:
        return AxisPole(0.0, 1, complex(exact.to_float(residue)))
    excess = y.n.degree() - y.d.degree()
    if excess > 1:
        return AxisPole(math.inf, excess, None)
    if excess == 1 and y.n.leading_coefficient() < 0:
        return AxisPole(math.inf, 1, complex(exact.to_float(y.n.leading_coefficient())))
    for factor, power in axis:
        if power > 1:
            (root, _), *_ = _negative_roots(factor)
            return AxisPole(float((-root).sqrt()), power, None)
        if bad := _bad_residue(y, factor):
            return bad
    return None


def _axis_poles(d: fmpq_poly) -> tuple[list[tuple[fmpq_poly, int]], int, fmpq_poly]:
    """What d shares with d(−s) as square-free factors in z = s² and a power of s, and what is left of d."""
    mirrored = d.gcd(exact.at_minus_s(d))
    rest = d // mirrored
    power = 0
    while mirrored.degree() > 0 and mirrored[0] == 0:
        mirrored, power = mirrored.right_shift(1), power + 1
    return roots.square_free(exact.even_part(mirrored)), power, rest


def _real_negative_count(factor: fmpq_poly) -> int:
    return len(roots.positive_roots(factor(fmpq_poly([0, -1]))))


def _negative_roots(factor: fmpq_poly) -> list[tuple[arb, int]]:
    return [(-x, power) for x, power in roots.positive_roots(factor(fmpq_poly([0, -1])))]


def _bad_residue(y: Rational, factor: fmpq_poly) -> AxisPole | None:
    """A root z = −ω² of a simple factor f where Y's residue is not positive.

    With d = f(s²) q(s) the residue is n s q(−s)/(2 z f'(z) q(s) q(−s)).
    """
    q = y.d // exact.of_square(factor)
    top = y.n * exact.at_minus_s(q)
    size = exact.even_part(q * exact.at_minus_s(q))
    # top·s at s² = z: the part even in s is real there, the odd part has to vanish.
    real, imaginary = exact.odd_part(top), exact.even_part(top)
    if (imaginary % factor).degree() < 0:
        quotient = (real % factor, (2 * factor.derivative() * size) % factor)
        # Positive at every root z of the factor? n·s·q(−s) = z·real, and z cancels against the z below.
        if _positive_at_roots(quotient[0] * quotient[1], factor):
            return None

    def attempt() -> AxisPole | None:
        for z, _ in _negative_roots(factor):
            omega = (-z).sqrt()
            bottom = 2 * roots.value(factor.derivative(), z) * roots.value(size, z)
            re = roots.value(real, z) / bottom
            im = -roots.value(imaginary, z) / (omega * bottom)
            known_real = (imaginary % factor).degree() < 0
            if (known_real and re < 0) or (not known_real and not im.contains(0)):
                return AxisPole(float(omega), 1, complex(float(re), 0.0 if known_real else float(im)))
        return None

    return roots.settle(attempt)


def _positive_at_roots(p: fmpq_poly, factor: fmpq_poly) -> bool:
    """Whether p > 0 at every (real, negative) root of the factor; p is nonzero there."""

    def attempt() -> bool | None:
        values = [roots.value(p, z) for z, _ in _negative_roots(factor)]
        return None if any(value.contains(0) for value in values) else all(value > 0 for value in values)

    return roots.settle(attempt)


def _right_half_plane_pole(d: fmpq_poly) -> RightHalfPlanePole:
    """The pole furthest to the right; its real part is certified positive."""

    def attempt() -> RightHalfPlanePole | None:
        right = [root for root, _ in roots.complex_roots(d) if root.real > 0]
        if not right:
            return None
        root = max(right, key=lambda ball: float(ball.real.mid()))
        return RightHalfPlanePole(complex(float(root.real.mid()), abs(float(root.imag.mid()))))

    return roots.settle(attempt)


# -- the real part ------------------------------------------------------------------------------


def _real_part_witness(y: Rational, E: fmpq_poly) -> NegativeReal | None:
    if resistance.is_nonnegative(E):
        return None
    omega = exact.to_fraction(resistance.negative_frequency(E))
    return NegativeReal(omega, y.exact_response(omega)[0])


def _has_axis_root(y: Rational) -> bool:
    if y.n.degree() != y.d.degree():
        return True
    for p in (y.n, y.d):
        axis, power_at_zero, _ = _axis_poles(p)
        if power_at_zero or any(_real_negative_count(factor) for factor, _ in axis):
            return True
    return False


def _limit(y: Rational, name: str) -> float:
    multiple = y.n.degree() - y.d.degree() > 1 if name == "inertance" else bool(y.d[0] == 0 and y.d[1] == 0)
    return math.inf if multiple else exact.to_float(Fraction(getattr(y, name)))


def _json(value: float) -> float | str:
    return value if math.isfinite(value) else ("inf" if value > 0 else "-inf")
