"""Numbers with units: read with their dimension checked, written as an engineer would.

Units are read by pint, which is imported only when a text has a unit in it.
"""

from __future__ import annotations

import re
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from typing import Any

from posreal.admittance import exact
from posreal.errors import BadDevice, BadInput, listed

LONGEST = 60  # characters of a unit

_QUANTITY = re.compile(
    r"\s*(?P<number>[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,4})?(?:/[0-9]+)?)\s*(?P<unit>.*?)\s*",
    re.S,
)
_UNIT = re.compile(r"{0}(?:[*/]{0})*".format(r"[A-Za-zµ°%]+(?:\*\*-?[0-9])?"))  # no nested powers, no brackets

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
}
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
    if not isinstance(text, str):
        if isinstance(text, bool) or not isinstance(text, int | float | Fraction):
            raise BadInput(f"{text!r} is not a number with a unit; write for example {_example(unit)}.")
        return _number(repr(text) if isinstance(text, float) else str(text), unit)
    match = _QUANTITY.fullmatch(text) if len(text) < 25_000 else None
    if match is None:
        raise BadInput(f"{_shown(text)!r} is not a number with a unit; write for example {_example(unit)}.")
    number = _number(match["number"], unit)
    given = match["unit"]
    return number * _factor(given, unit) if given else number


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


def _number(text: str, unit: str) -> Fraction:
    try:
        return exact.to_fraction(exact.to_fmpq(text))
    except BadDevice:
        raise BadInput(f"{_shown(text)!r} is not a finite number; write for example {_example(unit)}.") from None


@lru_cache(maxsize=1024)
def _factor(given: str, unit: str) -> Fraction:
    """How many of `unit` one of `given` is."""
    import pint

    if len(given) > LONGEST or not _UNIT.fullmatch(_spelled(given)):
        raise BadInput(f"{_shown(given)!r} is not a unit; give {_accepted(unit)}.")
    registry = _registry()
    try:
        source = registry.parse_units(_spelled(given))
    except (pint.errors.PintError, ValueError, TypeError, AttributeError, SyntaxError):
        raise BadInput(f"The unit {given!r} is not known; give {_accepted(unit)}.") from None
    target = registry.parse_units(_spelled(unit))
    if source.dimensionality != target.dimensionality:
        raise BadInput(f"The unit {given!r} measures something else; give {_accepted(unit)}.")
    try:
        factor = registry.Quantity(Fraction(1), source).to(target).magnitude
        if registry.Quantity(Fraction(2), source).to(target).magnitude != 2 * factor:
            raise BadInput(f"The unit {given!r} has a zero of its own; give {_accepted(unit)}.")
    except pint.errors.PintError:
        raise BadInput(f"The unit {given!r} cannot be converted; give {_accepted(unit)}.") from None
    return Fraction(factor)


@lru_cache(maxsize=1)
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(non_int_type=Fraction, cache_folder=None)


def _spelled(unit: str) -> str:
    """As pint writes it: ``kN·s/m²`` is ``kN*s/m**2``."""
    text = unit.strip().replace("μ", "µ").replace("·", "*").replace("⋅", "*").replace("^", "**")
    text = re.sub(r"\s*(\*\*|[*/])\s*", r"\1", text.replace("²", "**2").replace("³", "**3"))
    return re.sub(r"\s+", "*", text)


def _accepted(unit: str) -> str:
    spelled = unit.replace(" ", "*").replace("·", "*").replace("^", "**")
    return listed(_EXAMPLES.get(spelled, (unit or "a plain number",)))


def _example(unit: str) -> str:
    return f"'2.5 {unit.replace('*', ' ')}'" if unit else "'2.5'"


def _shown(text: str) -> str:
    return text if len(text) <= 40 else text[:37] + "..."
