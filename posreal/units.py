"""Numbers with units: read exactly and with their dimension checked, written as an engineer would.

A unit is a product of powers of symbols, such as ``kN s/m``, ``kg·m²`` or ``lbf*s/in``, read from left to right; each
stroke divides by the one symbol behind it. A symbol is an exact number of other units, down to the metre, kilogram,
second, radian and ampere, and many take a decimal prefix. The radian counts as a base unit, so that an angle is no
plain number and a hertz is 2π rad/s; only there is a factor (π, to sixty digits) not exact.
"""

from __future__ import annotations

import re
from collections import Counter
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from numbers import Real

from posreal.admittance import exact
from posreal.errors import BadDevice, BadInput, listed, shown

LONGEST = 60  # characters of a unit

_QUANTITY = re.compile(
    r"\s*(?P<number>[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,6})?(?:/[0-9]+)?)\s*(?P<unit>.*?)\s*",
    re.S,
)
_FACTOR = re.compile(r"(?P<symbol>[A-Za-zµΩ°%]+|1)\^?(?P<power>-?[0-9])?")  # no brackets, no nested powers
_AS_TYPED = str.maketrans("μ·⋅Ω−⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "µ**Ω--0123456789")

_PI = "314159265358979323846264338327950288419716939937510582097494"
_UNITS = {  # a number, or a quotient of two, of other units; a base unit is one of itself
    "m": ("1", "m"),
    "kg": ("1", "kg"),
    "s": ("1", "s"),
    "rad": ("1", "rad"),
    "A": ("1", "A"),
    "1": ("1", ""),
    "%": ("1/100", ""),
    "in": ("0.0254", "m"),
    "inch": ("1", "in"),
    "ft": ("12", "in"),
    "g": ("1/1000", "kg"),
    "t": ("1000", "kg"),
    "lb": ("0.45359237", "kg"),
    "slug": ("1", "lbf s^2/ft"),
    "min": ("60", "s"),
    "h": ("3600", "s"),
    "deg": (f"{_PI}/180{59 * '0'}", "rad"),
    "°": ("1", "deg"),
    "rpm": ("6", "deg/s"),
    "Hz": ("360", "deg/s"),
    "kph": ("1", "km/h"),
    "mph": ("5280", "ft/h"),
    "N": ("1", "kg m/s^2"),
    "kgf": ("9.80665", "N"),
    "lbf": ("9.80665", "lb m/s^2"),
    "Ns": ("1", "N s"),
    "Nm": ("1", "N m"),
    "Nms": ("1", "N m s"),
    "J": ("1", "N m"),
    "W": ("1", "J/s"),
    "Pa": ("1", "N/m^2"),
    "V": ("1", "W/A"),
    "ohm": ("1", "V/A"),
    "Ω": ("1", "ohm"),
    "H": ("1", "V s/A"),
    "F": ("1", "A s/V"),
}
_PREFIXED = ("m", "g", "s", "rad", "A", "Hz", "N", "Ns", "Nm", "Nms", "J", "W", "Pa", "V", "ohm", "Ω", "H", "F")
_TENS = {"n": -9, "µ": -6, "u": -6, "m": -3, "c": -2, "d": -1, "k": 3, "M": 6, "G": 9}

_EXAMPLES = {
    "N/m": ("N/m", "kN/m", "MN/m", "N/mm"),
    "N*s/m": ("N s/m", "kN·s/m", "N s/mm"),
    "kg": ("kg", "t", "g"),
    "m": ("m", "mm", "cm"),
    "m/s": ("m/s", "km/h"),
    "rad": ("rad", "deg"),
    "kg*m**2": ("kg m²", "t m²"),
    "N": ("N", "kN"),
    "s": ("s", "ms"),
    "": ("a plain number",),
    "1": ("a plain number",),
}
_NAMED = ("N/m", "N*s/m", "N", "N*m/rad", "N*m*s/rad", "N*m", "N*s", "m/s", "m/s^2", "kg*m^2", "rad/s", "Pa", "W", "J")
_PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


def quantity(text: str | float, unit: str) -> float:
    """The number meant by ``"21 kN s/m"``, in `unit`; a bare number is in `unit` already.

    Parameters
    ----------
    text : str or number
    unit : str
        What to convert to: ``"N*s/m"``, ``"kg"``, ``"m/s^2"``; ``""`` for a plain number.

    Raises
    ------
    BadInput
        If this is no number, the unit is not known or it measures something else.

    Examples
    --------
    >>> quantity("21 kN s/m", "N*s/m"), quantity("1.5 t", "kg"), quantity(3, "m")
    (21000.0, 1500.0, 3.0)
    """
    return float(exact_quantity(text, unit))


def exact_quantity(text: str | float, unit: str) -> Fraction:
    """As `quantity`, exactly: ``"0.3 t"`` is 300 kg, not 299.99999999999994."""
    if isinstance(text, Real) and not isinstance(text, bool):
        return _number(repr(float(text)) if isinstance(text, float) else text, unit)
    match = _QUANTITY.fullmatch(text) if isinstance(text, str) and len(text) <= exact.LONGEST_NUMBER else None
    if match is None:
        raise BadInput(f"{shown(text)} is not a number with a unit; write for example {_example(unit)}.")
    number = _number(match["number"], unit)
    return _number(number * _factor(match["unit"], unit), unit) if match["unit"] else number


def si_quantity(text: str) -> tuple[Fraction, str]:
    """The number meant by text with any unit, in SI base units, and the name of that unit.

    Examples
    --------
    >>> si_quantity("150 kN/m"), si_quantity("20 Hz")[1], si_quantity("3")
    ((Fraction(150000, 1), 'N/m'), 'rad/s', (Fraction(3, 1), '1'))

    Raises
    ------
    BadInput
        If this is no number with a unit.
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= exact.LONGEST_NUMBER else None
    if match is None:
        raise BadInput(f"{shown(text)} is not a number with a unit; write for example '2.5 kN/m'.")
    number = _number(match["number"], "")
    if not match["unit"]:
        return number, "1"
    factor, powers = _product(match["unit"], "")
    return _number(number * factor, ""), _name_of(powers)


def _name_of(powers: Counter[str]) -> str:
    """A common name of the SI unit with these powers of the base units, or their product."""
    powers = Counter({symbol: power for symbol, power in powers.items() if power})
    for name in _NAMED:
        if _product(name, name) == (Fraction(1), powers):
            return name
    return "*".join(symbol if power == 1 else f"{symbol}^{power}" for symbol, power in sorted(powers.items())) or "1"


def engineering(value: float | Fraction, unit: str = "", digits: int = 3, ascii: bool = False) -> str:
    """The value with a prefix that leaves one to three digits before the point.

    Parameters
    ----------
    value : float or Fraction
    unit : str
        ``"N/m"``, ``"N*s/m"`` or ``"N s/m"``, ``"kg"``, …; ``""`` for a plain number.
    digits : int
        Significant digits; trailing zeros are dropped.
    ascii : bool
        ``*`` and ``u`` for · and µ.

    Examples
    --------
    >>> engineering(1.41e6, "N/m"), engineering(57_800, "N s/m"), engineering(312, "kg")
    ('1.41 MN/m', '57.8 kN·s/m', '312 kg')
    """
    number = exact.to_fraction(exact.to_fmpq(repr(float(value)) if isinstance(value, float) else value))
    shown = unit.replace("**", "^").replace("*", " ").replace(" ", "·").replace("^2", "²").replace("^3", "³")
    if ascii:
        shown = shown.replace("·", "*").replace("²", "^2").replace("³", "^3")
    prefixes, power = dict(_PREFIXES), 0
    if shown in ("", "rad", "deg", "%", "%g"):
        prefixes = {0: ""}
    if shown == "kg":  # grams below a kilogram, kilograms from there on
        prefixes = {0: "kg", -3: "g", -6: "mg"}
        shown = ""
    mantissa = _rounded(number, digits)
    if number:
        power = 3 * (mantissa.adjusted() // 3)
        if not min(prefixes) <= power <= max(prefixes) + 3:
            power = 0  # beyond every prefix: a power of ten and the bare unit
        power = min(power, max(prefixes))
    text = _plain(mantissa.scaleb(-power), digits)
    prefix = prefixes[power].replace("µ", "u") if ascii else prefixes[power]
    return f"{text} {prefix}{shown}".rstrip()


def _rounded(number: Fraction, digits: int) -> Decimal:
    if digits < 1:
        raise BadInput(f"A value cannot be shown with {digits} digits; ask for one or more.")
    rounded = exact.to_fraction(exact.rounded(exact.to_fmpq(abs(number)), digits))
    p, q = rounded.numerator, rounded.denominator
    places = 0
    while q != 1 and p * 10**places % q:
        places += 1
    return Decimal(p * 10**places // q).scaleb(-places) * (-1 if number < 0 else 1)


def _plain(mantissa: Decimal, digits: int) -> str:
    if mantissa and not -5 <= mantissa.adjusted() <= 5:
        head, _, power = f"{mantissa:.{digits - 1}e}".partition("e")
        return f"{head.rstrip('0').rstrip('.') if '.' in head else head}e{int(power)}"
    text = f"{mantissa:f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def _number(given: str | Real, unit: str) -> Fraction:
    """Zero, or a number that a float holds with room for a product."""
    try:
        number = exact.to_fraction(exact.to_fmpq(given))  # type: ignore[arg-type]
    except BadDevice:
        raise BadInput(f"{shown(given)} is not a finite number; write for example {_example(unit)}.") from None
    size = abs(exact.to_float(number))
    if number and not 1e-300 <= size <= 1e300:
        named = shown(given) if isinstance(given, str) else f"A number {'above 1e300' if size > 1 else 'below 1e-300'}"
        raise BadInput(f"{named} is out of range; give one from 1e-300 to 1e300, for example {_example(unit)}.")
    return number


@lru_cache(maxsize=1024)
def _factor(given: str, unit: str) -> Fraction:
    """How many of `unit` one of `given` is."""
    factor, powers = _product(given, unit)
    accepted, wanted = _product(unit, unit)
    if powers != wanted:
        raise BadInput(f"The unit {shown(given)} measures something else; give {_accepted(unit)}.")
    return factor / accepted


def _product(text: str, unit: str) -> tuple[Fraction, Counter[str]]:
    """A unit as a number and the powers of the base units."""
    factor, powers = Fraction(1), Counter[str]()
    typed = text.strip().translate(_AS_TYPED).replace("**", "^") if len(text) <= LONGEST else "!"
    spelled = re.sub(r"\s+", "*", re.sub(r"\s*([*/^])\s*", r"\1", typed))
    for stroke, part in re.findall(r"(^|[*/])([^*/]*)", spelled) if text else ():
        match = _FACTOR.fullmatch(part)
        if match is None:
            raise BadInput(f"{shown(text)} is not a unit; give {_accepted(unit)}.")
        symbol, power, ten = match["symbol"], int(match["power"] or 1), 0
        if symbol not in _UNITS and symbol[0] in _TENS and symbol[1:] in _PREFIXED:
            symbol, ten = symbol[1:], _TENS[symbol[0]]
        if symbol not in _UNITS:
            raise BadInput(f"The unit {shown(text)} is not known; give {_accepted(unit)}.")
        number, of = _UNITS[symbol]
        value, base = (Fraction(1), Counter({symbol: 1})) if of == symbol else _product(of, unit)
        power = -power if stroke == "/" else power
        factor *= (value * Fraction(number) * Fraction(10) ** ten) ** power
        powers.update({name: count * power for name, count in base.items()})
    return factor, powers


def _accepted(unit: str) -> str:
    spelled = unit.replace(" ", "*").replace("·", "*").replace("^", "**")
    return listed(_EXAMPLES.get(spelled, (unit,)))


def _example(unit: str) -> str:
    return f"'2.5 {unit.replace('*', ' ')}'" if unit else "'2.5'"
