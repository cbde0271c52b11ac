"""Springs, dampers and inerters in series and in parallel: what a device is made of.

``a | b`` is parallel (admittances add), ``a + b`` series (impedances add); + binds tighter, as in Python:

    Y(k) = k/s,  Y(c) = c,  Y(b) = b·s,  Y(a | b) = Y(a) + Y(b),  1/Y(a + b) = 1/Y(a) + 1/Y(b)  [Smith2002]

Values are exact; a float is taken as the decimal it prints as (see `posreal.network.value`).
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from flint import fmpq
from numpy.typing import ArrayLike, NDArray

from posreal.admittance.rational import Rational
from posreal.errors import BadDevice, BadInput, listed, shown
from posreal.network.response import JointStep, ParallelStep, Response, SeriesStep, compiled
from posreal.network.value import Value, read_value, write_value
from posreal.units import exact_quantity

DEEPEST = 200  # levels of series in parallel in series …, so that recursion cannot run out of stack

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,31}")


class Counts(NamedTuple):
    """How many elements of each kind a network has."""

    springs: int
    dampers: int
    inerters: int
    levers: int

    @property
    def total(self) -> int:
        """All elements, levers included."""
        return sum(self)


class Element(ABC):
    """What one element has: a kind, a value (None while it is free) and a name (None: numbered)."""

    value: Fraction | None
    name: str | None
    kind: ClassVar[str]
    letter: ClassVar[str]
    unit: ClassVar[str]

    def _check(self) -> None:
        if self.name is not None:
            if not isinstance(self.name, str) or not _NAME.fullmatch(self.name) or self.name[0] != self.letter:
                raise BadDevice(
                    f"{shown(self.name)} cannot name a {self.kind}; take {self.letter}, then letters, digits or _."
                )
            if self.name == self.letter:
                object.__setattr__(self, "name", None)
        if self.value is not None:
            number = read_value(self.value, self._title)
            self._accept(number)
            object.__setattr__(self, "value", number)

    def _accept(self, number: Fraction) -> None:
        if number <= 0:
            raise BadDevice(f"{self._title} is {float(number):g} {self.unit}; give a value above zero.")

    def _text(self, name: str) -> str:
        return name if self.value is None else f"{name}={write_value(self.value)}"

    def altered(self, value: Any, name: str | None) -> Self:
        """An element of the same kind with another value and name."""
        return type(self)(value, name)  # type: ignore[call-arg]

    @property
    def _title(self) -> str:
        return f"The {self.kind} {self.name}" if self.name else f"A {self.kind}"

    @property
    def exact(self) -> Fraction:
        """The value, or BadDevice while there is none."""
        if self.value is None:
            raise BadDevice(f"{self._title} has no value yet; give it one, in {self.unit or 'units of one'}.")
        return self.value


class Network(ABC):
    """A two-terminal network; base of `Spring`, `Damper`, `Inerter`, `Series`, `Parallel` and `Graph`.

    Networks never change. Two are equal when they have the same form, the same values and the same names.

    Attributes
    ----------
    children : tuple of Network
        What it joins; empty for an element.
    branches : tuple of (node, node, Network)
        The children between numbered nodes: terminals 1 and 0, inner nodes 2, 3, …
    levers : tuple of (near, pivot, far, Lever)
    size : int
        The number of nodes.
    """

    children: tuple[Network, ...]
    branches: tuple[tuple[int, int, Network], ...]
    levers: tuple[tuple[int, int, int, Any], ...] = ()
    size: int

    # What draws stands outside the mathematics: the room hangs these on.
    _repr_html_: ClassVar[Callable[[Any], str]]
    _repr_svg_: ClassVar[Callable[[Any], str]]
    _repr_latex_: ClassVar[Callable[[Any], str]]

    # -- what it is made of ---------------------------------------------------------------------

    @abstractmethod
    def elements(self) -> tuple[Element, ...]:
        """The elements in the order in which the notation writes them."""

    @abstractmethod
    def admittance(self) -> Rational:
        """Y(s) = F/v, exactly.

        Raises
        ------
        BadDevice
            If an element has no value.
        """

    @abstractmethod
    def _rebuilt(self, elements: Iterable[Element]) -> Self:
        """The same form with other elements, drawn from an iterator in order."""

    @abstractmethod
    def _form(self) -> tuple[Any, ...]:
        """What equality compares, names apart."""

    @abstractmethod
    def _written(self, names: Iterator[str]) -> str:
        """Its text in the notation (see `posreal.network.notation`), its elements called by the next names."""

    @abstractmethod
    def _step(self, slot: int, children: slice, first_lever: int) -> JointStep | None:
        """What it does to its children's admittances in a `Response`; None for an element."""

    @property
    @abstractmethod
    def depth(self) -> int:
        """Levels of nesting; 1 for an element."""

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The elements' names in order: given ones kept, the others k1, k2, … (just k where there is one)."""
        return _resolved(self.elements())

    @cached_property
    def counts(self) -> Counts:
        """How many springs, dampers, inerters and levers."""
        letters = [element.letter for element in self.elements()]
        return Counts(*(letters.count(letter) for letter in "kcbn"))

    def __len__(self) -> int:
        return len(self.elements())

    # -- its values -----------------------------------------------------------------------------

    @property
    def is_valued(self) -> bool:
        """Whether every element has a value; if not, this is a topology (a layout)."""
        return all(element.value is not None for element in self.elements())

    def values(self) -> dict[str, float]:
        """The values there are, by name, as floats in N/m, N s/m and kg."""
        return {name: float(value) for name, value in self.exact_values().items()}

    def exact_values(self) -> dict[str, Fraction]:
        """The values there are, by name, as the exact rationals they are."""
        pairs = zip(self.names, self.elements(), strict=True)
        return {name: element.value for name, element in pairs if element.value is not None}

    def with_values(self, values: Mapping[str, Value | None]) -> Self:
        """The same network with some values replaced; None frees an element.

        Text is read with its unit (``{"c": "21 kN s/m"}``), a bare number in N/m, N s/m or kg.

        Raises
        ------
        BadDevice
            For a name that no element has, or a value that is not positive.
        """
        unknown = [name for name in values if name not in self.names]
        if unknown:
            raise BadDevice(f"There is no element {shown(unknown[0])} here; give {listed(self.names)}.")
        return self._rebuilt(
            _valued(element, name, values[name]) if name in values else element
            for name, element in zip(self.names, self.elements(), strict=True)
        )

    def topology(self) -> Self:
        """The same network with every value taken out."""
        return self._rebuilt(element.altered(None, element.name) for element in self.elements())

    def unnamed(self) -> Self:
        """The same network with every name taken out, so that it can be combined with others."""
        return self._rebuilt(element.altered(element.value, None) for element in self.elements())

    # -- its response in floats -----------------------------------------------------------------

    @cached_property
    def response(self) -> Response:
        """The compiled form of this topology, for loops that evaluate it at many values."""
        return compiled(self)

    def evaluate(self, values: ArrayLike, s: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
        """Y(s) and its derivatives for values given as an array, without touching the exact ones.

        Parameters
        ----------
        values : array_like, shape (len(self),)
            In the order of `names`, in N/m, N s/m and kg.
        s : array_like of complex
            Any shape.

        Returns
        -------
        y : ndarray, the shape of `s`
        dy : ndarray, shape (len(self), *s.shape)
            ∂Y/∂(log value) of each element.
        """
        return self.response.evaluate(values, s)

    def __call__(self, s: ArrayLike) -> Any:
        """Y(s) in floats: a complex for a number, an array for an array; infinite at poles."""
        y = np.asarray(self.response(self._floats(), s))
        lost = ~np.isfinite(y)
        if lost.any():
            # A part has a pole or a zero there; the exact function of the whole still has a value.
            y = y.copy()
            y[lost] = self.admittance()(np.asarray(s, dtype=complex)[lost])
        return y if y.ndim else complex(y)

    def sensitivities(self, s: ArrayLike) -> NDArray[Any]:
        """∂Y/∂(log value) of each element at s, shape (len(self), *s.shape), in the order of `names`."""
        return self.response.evaluate(self._floats(), s)[1]

    def _floats(self) -> list[float]:
        return [float(element.exact) for element in _titled(self)]

    # -- combining and showing ------------------------------------------------------------------

    def __add__(self, other: Network) -> Series:
        return Series((self, other)) if isinstance(other, Network) else NotImplemented

    def __or__(self, other: Network) -> Parallel:
        return Parallel((self, other)) if isinstance(other, Network) else NotImplemented

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Network):
            return NotImplemented
        return self._form() == other._form() and self.names == other.names

    def __hash__(self) -> int:
        return hash((self._form(), self.names))

    def __str__(self) -> str:
        return self._written(iter(self.names))

    def __repr__(self) -> str:
        return f"parse({str(self)!r})"


class _Leaf(Element, Network):
    """An element standing between two terminals."""

    children, branches, size = (), (), 2

    def __post_init__(self) -> None:
        self._check()

    def elements(self) -> tuple[Element, ...]:
        return (self,)

    def _rebuilt(self, elements: Iterable[Element]) -> Any:
        return next(iter(elements))

    def _form(self) -> tuple[Any, ...]:
        return (self.letter, self.value)

    def _written(self, names: Iterator[str]) -> str:
        return self._text(next(names))

    def _step(self, slot: int, children: slice, first_lever: int) -> None:
        return None

    @property
    def depth(self) -> int:
        return 1


@dataclass(frozen=True, eq=False, repr=False)
class Spring(_Leaf):
    """A spring: F = k∫v dt, Y = k/s, k in N/m."""

    value: Any = None
    name: str | None = None

    kind, letter, unit = "spring", "k", "N/m"

    def admittance(self) -> Rational:
        return Rational.spring(self.exact)


@dataclass(frozen=True, eq=False, repr=False)
class Damper(_Leaf):
    """A damper: F = c v, Y = c, c in N s/m."""

    value: Any = None
    name: str | None = None

    kind, letter, unit = "damper", "c", "N s/m"

    def admittance(self) -> Rational:
        return Rational.damper(self.exact)


@dataclass(frozen=True, eq=False, repr=False)
class Inerter(_Leaf):
    """An inerter: F = b dv/dt, Y = b·s, b in kg."""

    value: Any = None
    name: str | None = None

    kind, letter, unit = "inerter", "b", "kg"

    def admittance(self) -> Rational:
        return Rational.inerter(self.exact)


@dataclass(frozen=True, eq=False, repr=False)
class _Joined(Network):
    """Two or more networks joined one way; a child joined the same way is taken apart into this one."""

    children: tuple[Network, ...]

    sign: ClassVar[str]

    def __post_init__(self) -> None:
        flat: list[Network] = []
        for child in self.children:
            if not isinstance(child, Network):
                raise BadDevice(
                    f"{shown(child)} is not a network; give Spring, Damper, Inerter, or what is made of them."
                )
            flat.extend(child.children if isinstance(child, type(self)) else (child,))
        if len(flat) < 2:
            raise BadDevice(f"{type(self).__name__} joins two networks or more and got {len(flat)}.")
        object.__setattr__(self, "children", tuple(flat))
        if self.depth > DEEPEST:
            raise BadDevice(f"This network is nested more than {DEEPEST} levels deep; write it flatter.")
        refuse_twins(self.elements())

    def elements(self) -> tuple[Element, ...]:
        return self._elements

    @cached_property
    def _elements(self) -> tuple[Element, ...]:
        return tuple(element for child in self.children for element in child.elements())

    @cached_property
    def depth(self) -> int:
        return 1 + max(child.depth for child in self.children)

    def _rebuilt(self, elements: Iterable[Element]) -> Self:
        source = iter(elements)
        return type(self)(tuple(child._rebuilt(source) for child in self.children))

    def _form(self) -> tuple[Any, ...]:
        return (self.sign, *(child._form() for child in self.children))

    def _written(self, names: Iterator[str]) -> str:
        texts = [(child, child._written(names)) for child in self.children]
        return f" {self.sign} ".join(f"({text})" if isinstance(child, Parallel) else text for child, text in texts)


class Series(_Joined):
    """Networks end to end: one force goes through all, velocities add."""

    sign = "+"

    @property
    def branches(self) -> tuple[tuple[int, int, Network], ...]:  # type: ignore[override]
        nodes = (1, *range(2, self.size), 0)
        return tuple((*ends, child) for ends, child in zip(pairwise(nodes), self.children, strict=True))

    @property
    def size(self) -> int:  # type: ignore[override]
        return len(self.children) + 1

    def _step(self, slot: int, children: slice, first_lever: int) -> JointStep:
        return SeriesStep(slot, children)

    def admittance(self) -> Rational:
        impedance = _sum(child.admittance().inverse() for child in self.children)
        return impedance.inverse()


class Parallel(_Joined):
    """Networks side by side: one velocity, forces add."""

    sign, size = "|", 2

    @property
    def branches(self) -> tuple[tuple[int, int, Network], ...]:  # type: ignore[override]
        return tuple((1, 0, child) for child in self.children)

    def _step(self, slot: int, children: slice, first_lever: int) -> JointStep:
        return ParallelStep(slot, children)

    def admittance(self) -> Rational:
        return _sum(child.admittance() for child in self.children)


def series(*networks: Network) -> Network:
    """Networks end to end; a single one is itself."""
    return networks[0] if len(networks) == 1 else Series(networks)


def parallel(*networks: Network) -> Network:
    """Networks side by side; a single one is itself."""
    return networks[0] if len(networks) == 1 else Parallel(networks)


def refuse_twins(elements: Iterable[Element]) -> None:
    """BadDevice if two elements were given the same name."""
    seen: set[str] = set()
    for name in (element.name for element in elements if element.name):
        if name in seen:
            raise BadDevice(f"Two elements are called {shown(name)}; rename one, or drop names with .unnamed().")
        seen.add(name)


def _sum(terms: Iterable[Rational]) -> Rational:
    """Rationals added in pairs of like size, so that products stay small."""
    level = list(terms)
    while len(level) > 1:
        level = [a | b for a, b in zip(level[::2], level[1::2], strict=False)] + level[len(level) & ~1 :]
    return level[0]


def _resolved(elements: tuple[Element, ...]) -> tuple[str, ...]:
    taken = {element.name for element in elements}
    unnamed = [element.letter for element in elements if element.name is None]
    last = dict.fromkeys(unnamed, 0)
    names = []
    for element in elements:
        name = element.name
        if name is None and unnamed.count(element.letter) == 1:
            name = element.letter
        while name is None:
            last[element.letter] += 1
            candidate = f"{element.letter}{last[element.letter]}"
            name = None if candidate in taken else candidate
        names.append(name)
    return tuple(names)


def _titled(network: Network) -> tuple[Element, ...]:
    """The elements under their resolved names, so that an error can say which."""
    pairs = zip(network.names, network.elements(), strict=True)
    return tuple(element.altered(element.value, name) for name, element in pairs)


def read_quantity(text: str, kind: type[Element]) -> Fraction:
    """The value in N/m, N s/m or kg of text such as ``"245 kN/m"`` for an element of this kind."""
    try:
        return exact_quantity(text, kind.unit)
    except BadDevice:
        raise
    except BadInput as error:
        raise BadDevice(str(error)) from None


def _valued(element: Element, name: str, value: Any) -> Element:
    if isinstance(value, str):
        value = read_quantity(value, type(element))
    return element.altered(element.altered(value, name).value, element.name)


def exact_value(element: Element) -> fmpq:
    """An element's value for exact arithmetic."""
    value = element.exact
    return fmpq(value.numerator, value.denominator)
