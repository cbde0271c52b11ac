"""Y(s) = n(s)/d(s): what a one-port device does, as coprime polynomials over the rationals.

Force over relative velocity, so a spring is k/s, a damper c, an inerter b·s [Smith2002]. Devices combine
as networks do: ``a | b`` in parallel (admittances add), ``a + b`` in series (impedances add).
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import Any, TypeAlias, overload

import numpy as np
from flint import fmpq, fmpq_poly
from numpy.typing import ArrayLike, NDArray

from posreal.admittance import control_systems, exact
from posreal.admittance.exact import Number
from posreal.admittance.parse import read
from posreal.errors import BadDevice, shown

S = fmpq_poly([0, 1])
MOST_COEFFICIENTS = 101  # of a numerator or denominator that comes from a file

_Mantissas: TypeAlias = tuple[NDArray[np.float64], NDArray[np.int64]]


class Rational:
    """A rational function of s with exact coefficients, coprime, its denominator monic.

    Parameters
    ----------
    numerator, denominator : sequence of number, or flint.fmpq_poly
        Coefficients in **ascending** powers of s (`descending` takes the other order). Floats are taken as the exact
        rationals they are; text such as ``"2.5e5"`` or ``"1/3"`` as what it says.

    Raises
    ------
    BadDevice
        If a coefficient is not a finite real number or the denominator is zero.

    Examples
    --------
    >>> y = Rational([1, 1, 1], [4, 1, 1])
    >>> str(y), y.degree, y(0)
    ('(s^2 + s + 1)/(s^2 + s + 4)', 2, (0.25+0j))
    >>> str(Rational.spring(2) | Rational.damper(3))
    '(3*s + 2)/s'
    """

    __slots__ = ("_scaled", "d", "n")

    n: fmpq_poly
    d: fmpq_poly
    _scaled: tuple[_Mantissas, _Mantissas] | None

    def __init__(
        self, numerator: fmpq_poly | Iterable[Number], denominator: fmpq_poly | Iterable[Number] = (1,)
    ) -> None:
        n, d = exact.polynomial(numerator), exact.polynomial(denominator)
        if d.degree() < 0:
            raise BadDevice("The denominator of an admittance is zero; give at least one nonzero coefficient.")
        common = n.gcd(d)
        if common.degree() > 0:
            n, d = n // common, d // common
        lead = d.leading_coefficient()
        object.__setattr__(self, "n", n / lead)
        object.__setattr__(self, "d", d / lead)
        object.__setattr__(self, "_scaled", None)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError("a Rational does not change; make a new one")

    def __delattr__(self, name: str) -> None:
        raise AttributeError("a Rational does not change; make a new one")

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.to_dict(),)

    @classmethod
    def descending(cls, numerator: Iterable[Number], denominator: Iterable[Number] = (1,)) -> Rational:
        """The same from coefficients in **descending** powers, as MATLAB, scipy.signal and python-control have them.

        Examples
        --------
        >>> str(Rational.descending([1, 0], [1, 2, 3]))
        's/(s^2 + 2*s + 3)'
        """
        return cls(list(numerator)[::-1], list(denominator)[::-1])

    # -- one element ----------------------------------------------------------------------------

    @classmethod
    def spring(cls, stiffness: Number) -> Rational:
        """k/s, in N/m."""
        return cls([_element("stiffness", stiffness)], [0, 1])

    @classmethod
    def damper(cls, damping: Number) -> Rational:
        """c, in N s/m."""
        return cls([_element("damping", damping)])

    @classmethod
    def inerter(cls, inertance: Number) -> Rational:
        """b·s, in kg."""
        return cls([0, _element("inertance", inertance)])

    @classmethod
    def zero(cls) -> Rational:
        """No device: no force at any velocity."""
        return cls([0])

    @classmethod
    def parse(cls, text: str) -> Rational:
        """Read a rational function of s.

        Parameters
        ----------
        text : str
            Algebra in ``s`` with ``+ - * / ^ **`` and parentheses. Here ``+`` is the ordinary sum of two
            functions (in the notation of networks it means series).

        Raises
        ------
        BadDevice
            With the position and what would be accepted there.

        Examples
        --------
        >>> str(Rational.parse("2.5e5/s + 2e4"))
        '(20000*s + 250000)/s'
        """
        return read(text, cls)

    # -- what it is -----------------------------------------------------------------------------

    @property
    def numerator(self) -> tuple[Fraction, ...]:
        """Coefficients in ascending powers; ``(0,)`` for the zero function."""
        return tuple(exact.to_fraction(c) for c in self.n.coeffs()) or (Fraction(0),)

    @property
    def denominator(self) -> tuple[Fraction, ...]:
        """Coefficients in ascending powers, the last of them 1."""
        return tuple(exact.to_fraction(c) for c in self.d.coeffs())

    @property
    def degree(self) -> int:
        """McMillan degree: the number of poles, those at infinity counted; elements that store energy."""
        return max(self.n.degree(), self.d.degree(), 0)

    @property
    def static_stiffness(self) -> Fraction:
        """lim s·Y(s) at s = 0: the spring felt at rest (0 without a pole at 0)."""
        if self.d[0] != 0 or self.n.degree() < 0:
            return Fraction(0)
        return exact.to_fraction(self.n[0] / self.d[1]) if self.d[1] != 0 else _unbounded("s·Y", "0")

    @property
    def inertance(self) -> Fraction:
        """lim Y(s)/s at infinity: the mass felt at high frequency (0 without a pole there)."""
        excess = self.n.degree() - self.d.degree()
        if excess > 1:
            return _unbounded("Y/s", "infinity")
        return exact.to_fraction(self.n.leading_coefficient()) if excess == 1 else Fraction(0)

    def is_zero(self) -> bool:
        """Whether there is no device at all."""
        return self.n.degree() < 0

    # -- its values -----------------------------------------------------------------------------

    @overload
    def __call__(self, s: complex) -> complex: ...

    @overload
    def __call__(self, s: ArrayLike) -> complex | NDArray[np.complex128]: ...

    def __call__(self, s: Any) -> Any:
        """Y(s) in floats, for a number or an array of any shape; infinite at poles.

        Each term is scaled by the largest at that s before it is summed, so nothing overflows however
        large the coefficients, the degree or the frequency.
        """
        top, bottom = self._scaled or (_mantissas(self.n), _mantissas(self.d))
        object.__setattr__(self, "_scaled", (top, bottom))
        points = np.asarray(s, dtype=complex)
        n, up = _scaled_value(*top, points.ravel())
        d, down = _scaled_value(*bottom, points.ravel())
        with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
            ratio = n / d
            value = np.ldexp(ratio.real, up - down) + 1j * np.ldexp(ratio.imag, up - down)
        value[(d == 0) & (n != 0)] = complex(np.inf)
        value[n == 0] = 0
        return complex(value[0]) if points.ndim == 0 else value.reshape(points.shape)

    def exact_value(self, s: Number) -> Fraction:
        """Y(s) exactly, at a real rational s.

        Raises
        ------
        ZeroDivisionError
            At a pole.
        """
        point = exact.to_fmpq(s)
        if self.d(point) == 0:
            raise ZeroDivisionError(f"Y has a pole at s = {point}")
        return exact.to_fraction(self.n(point) / self.d(point))

    def exact_response(self, omega: Number) -> tuple[Fraction, Fraction]:
        """Real and imaginary part of Y(jω) exactly, at a rational ω.

        Raises
        ------
        ZeroDivisionError
            At a pole.
        """
        w = exact.to_fmpq(omega)
        a, b = exact.even_part(self.n)(-w * w), w * exact.odd_part(self.n)(-w * w)
        c, d = exact.even_part(self.d)(-w * w), w * exact.odd_part(self.d)(-w * w)
        size = c * c + d * d
        if size == 0:
            raise ZeroDivisionError(f"Y has a pole at s = {w}j")
        return exact.to_fraction((a * c + b * d) / size), exact.to_fraction((b * c - a * d) / size)

    # -- algebra --------------------------------------------------------------------------------

    def __or__(self, other: Rational) -> Rational:
        """In parallel: Y1 + Y2."""
        if not isinstance(other, Rational):
            return NotImplemented
        return Rational(self.n * other.d + other.n * self.d, self.d * other.d)

    def __add__(self, other: Rational) -> Rational:
        """In series: 1/(1/Y1 + 1/Y2)."""
        if not isinstance(other, Rational):
            return NotImplemented
        if self.is_zero() or other.is_zero():
            return Rational.zero()
        return Rational(self.n * other.n, self.n * other.d + other.n * self.d)

    def without(self, other: Rational) -> Rational:
        """Y1 − Y2: what is left when a device in parallel is taken out."""
        return Rational(self.n * other.d - other.n * self.d, self.d * other.d)

    def times(self, other: Rational) -> Rational:
        """The product of the two functions."""
        return Rational(self.n * other.n, self.d * other.d)

    def inverse(self) -> Rational:
        """1/Y: the impedance, velocity over force.

        Raises
        ------
        BadDevice
            For the zero function.
        """
        if self.is_zero():
            raise BadDevice("The zero admittance has no impedance; add an element to it first.")
        return Rational(self.d, self.n)

    @property
    def dual(self) -> Rational:
        """The device whose admittance is this one's impedance: k and b swap, and series with parallel."""
        return self.inverse()

    def scaled(self, factor: Number) -> Rational:
        """factor·Y(s): every stiffness, damping and inertance multiplied."""
        return Rational(self.n * exact.to_fmpq(factor), self.d)

    def time_scaled(self, omega: Number) -> Rational:
        """Y(ω s): the same device on a clock that ticks 1/ω seconds."""
        w = exact.to_fmpq(omega)
        return Rational(self.n(fmpq_poly([0, w])), self.d(fmpq_poly([0, w])))

    def rounded(self, digits: int) -> Rational:
        """Every coefficient (denominator monic) rounded to so many significant decimal digits."""
        if digits < 1:
            raise BadDevice(f"Coefficients cannot have {digits} digits; ask for at least one.")
        return Rational(
            [exact.rounded(c, digits) for c in self.n.coeffs()],
            [exact.rounded(c, digits) for c in self.d.coeffs()],
        )

    # -- identity and text ----------------------------------------------------------------------

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Rational):
            return NotImplemented
        return bool(self.n == other.n and self.d == other.d)

    def __hash__(self) -> int:
        return hash((Rational, *self.n.coeffs(), None, *self.d.coeffs()))

    def __str__(self) -> str:
        n, d = _polynomial_text(self.n), _polynomial_text(self.d)
        if d == "1":
            return n
        n = f"({n})" if any(mark in n[1:] for mark in "+-/") else n
        return f"{n}/({d})" if any(mark in d[1:] for mark in "+-*/") else f"{n}/{d}"

    def __repr__(self) -> str:
        return f"Rational.parse({str(self)!r})"

    def _repr_latex_(self) -> str:
        n, d = (_polynomial_text(p).replace("*", r"\,") for p in (self.n, self.d))
        braced = [_braced(text) for text in (n, d)]
        return f"${braced[0]}$" if d == "1" else rf"$\frac{{{braced[0]}}}{{{braced[1]}}}$"

    # -- other forms ----------------------------------------------------------------------------

    def to_dict(self) -> dict[str, list[str]]:
        """``{"numerator": [...], "denominator": [...]}``: exact numbers as text, ascending powers."""
        return {
            "numerator": [exact.to_text(c) for c in self.n.coeffs()] or ["0"],
            "denominator": [exact.to_text(c) for c in self.d.coeffs()],
        }

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Rational:
        """What `to_dict` wrote; plain numbers are accepted too, and ``"powers": "descending"`` for the other order."""
        try:
            numerator, denominator = data["numerator"], data.get("denominator", ["1"])
        except (KeyError, TypeError, AttributeError):
            raise BadDevice("A device is {'numerator': [...], 'denominator': [...]} in ascending powers.") from None
        if not isinstance(numerator, list | tuple) or not isinstance(denominator, list | tuple):
            raise BadDevice("A device's numerator and denominator are lists of numbers in ascending powers.")
        if max(len(numerator), len(denominator)) > MOST_COEFFICIENTS:
            raise BadDevice(f"A device with more than {MOST_COEFFICIENTS} coefficients is not read; reduce its order.")
        powers = data.get("powers", "ascending")
        if powers not in ("ascending", "descending"):
            raise BadDevice(f"The powers of a device are {shown(powers)}; accepted are ascending and descending.")
        return cls(numerator, denominator) if powers == "ascending" else cls.descending(numerator, denominator)

    @classmethod
    def from_control(cls, system: Any) -> Rational:
        """From a python-control ``TransferFunction`` (improper ones too) or ``StateSpace``, exactly."""
        return cls(*control_systems.coefficients(system))

    def to_control(self) -> Any:
        """A ``control.TransferFunction`` with float coefficients."""
        return control_systems.transfer_function(self.n, self.d)


parse_rational = Rational.parse


def _restored(data: dict[str, Any]) -> Rational:
    return Rational.from_dict(data)


def _element(quantity: str, value: Number) -> fmpq:
    number = exact.to_fmpq(value)
    if number < 0:
        raise BadDevice(f"An element cannot have a negative {quantity} ({exact.to_float(number):g}); give 0 or more.")
    return number


def _unbounded(what: str, where: str) -> Fraction:
    raise BadDevice(f"{what} grows without limit at s = {where}, so this is no spring, damper and inerter network.")


def _mantissas(p: fmpq_poly) -> _Mantissas:
    pairs = [exact.mantissa(c) for c in p.coeffs()] or [(0.0, 0)]
    return np.array([m for m, _ in pairs]), np.array([e for _, e in pairs], dtype=np.int64)


def _scaled_value(
    m: NDArray[np.float64], e: NDArray[np.int64], s: NDArray[np.complex128]
) -> tuple[NDArray[np.complex128], NDArray[np.int32]]:
    """(value, t) with p(s) = value·2^t, by Horner on s/2^(its exponent)."""
    _, size = np.frexp(np.maximum(np.abs(s.real), np.abs(s.imag)))
    power = e[:, None] + np.arange(len(m))[:, None] * size.astype(np.int64)
    power = np.where(m[:, None] == 0, np.iinfo(np.int32).min, power)
    top = np.max(np.where((np.arange(len(m))[:, None] > 0) & (s == 0), np.iinfo(np.int32).min, power), axis=0)
    terms = np.ldexp(m[:, None], np.clip(power - top, -2100, 1000).astype(np.int32))
    unit = np.ldexp(s.real, -size) + 1j * np.ldexp(s.imag, -size)
    value = np.zeros(len(s), dtype=complex)
    for row in terms[::-1]:
        value = value * unit + row
    return value, np.clip(top, -(2**30), 2**30).astype(np.int32)


def _polynomial_text(p: fmpq_poly) -> str:
    words = []
    for power in range(p.degree(), -1, -1):
        c = p[power]
        if c == 0:
            continue
        variable = "" if power == 0 else "s" if power == 1 else f"s^{power}"
        size = exact.to_text(abs(c))
        body = size if not variable else variable if size == "1" else f"{size}*{variable}"
        words.append(("- " if c < 0 else "+ ") + body)
    if not words:
        return "0"
    first = words[0][2:] if words[0][0] == "+" else "-" + words[0][2:]
    return " ".join([first, *words[1:]])


def _braced(text: str) -> str:
    """s^12 as LaTeX wants it, s^{12}."""
    return " ".join(
        word if "^" not in word else word[: word.index("^") + 1] + "{" + word[word.index("^") + 1 :] + "}"
        for word in text.split(" ")
    )
