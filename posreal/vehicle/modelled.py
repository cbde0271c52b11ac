"""The vehicle that a model of the user's own is: its parameters are its fields, as of any other vehicle."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property, lru_cache
from typing import Any, ClassVar

import numpy as np

from posreal.admittance import Rational, state_space
from posreal.errors import BadInput
from posreal.metric import (
    ClosedVehicle,
    DampingRatio,
    Inertance,
    LargestGain,
    Metric,
    PeakInTime,
    RootMeanSquare,
    StaticStiffness,
    WeightedSum,
)
from posreal.plant.mounting import Mounting
from posreal.plant.plant import Plant, absorbed
from posreal.vehicle.assembly import Where, assembled, unplaced
from posreal.vehicle.expression import admittance, number
from posreal.vehicle.flexible_body import FlexibleBody
from posreal.vehicle.model import Judged, Model, Opening
from posreal.vehicle.parameters import parameter, validated
from posreal.vehicle.place import Place
from posreal.vehicle.track import Direction, Track
from posreal.vehicle.user_plant import EDGE, ports_are_passive
from posreal.vehicle.weighting import Weighting

FIRST = "secondary"  # what every vehicle calls the place that is designed for
_COLUMNS = 5  # metrics that have a column where designs stand side by side


@dataclass(frozen=True)
class Factor:
    """How many of a metric's unit the SI unit is, as an expression in the vehicle's parameters."""

    text: str

    def __call__(self, vehicle: Any) -> float:
        return number(self.text, vehicle.values)


class Modelled:
    """A vehicle read from a file; :func:`modelled` makes the class that has its parameters as fields."""

    model: ClassVar[Model]
    name: ClassVar[str]
    random: ClassVar[str] = "load"
    body: ClassVar[FlexibleBody | None] = None
    direction: ClassVar[Direction | None] = None
    irregularity: ClassVar[Track | None] = None
    weighting: ClassVar[Weighting | None] = None
    weighted: ClassVar[Mapping[str, str]] = {}
    comfort: ClassVar[tuple[str, ...]] = ()
    free: ClassVar[Mapping[str, tuple[str, int]]] = {}
    pade_band: ClassVar[float | None] = None
    V: float = 0.0  # of a model without a parameter of that name

    def __post_init__(self) -> None:
        validated(self)

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.model, tuple(getattr(self, one.name) for one in self.model.parameters))

    @cached_property
    def values(self) -> Mapping[str, Fraction]:
        """Every parameter exactly."""
        return {one.name: Fraction(getattr(self, one.name)) for one in self.model.parameters}

    # --- places ----------------------------------------------------------------------------------------------

    @cached_property
    def places(self) -> Mapping[str, Place]:
        """Where devices go; the first is designed for and called ``secondary``."""
        return {FIRST if i == 0 else one.name: self.place(one) for i, one in enumerate(self.model.places)}

    @property
    def called(self) -> Mapping[str, str]:
        """The file's own name of every place, and what it is called here."""
        return dict(zip((one.name for one in self.model.places), self.places, strict=True))

    def place(self, one: Opening, where: Where = unplaced) -> Place:
        """A place in numbers."""
        path = ("places", one.name)

        def read(key: str) -> Rational | None:
            text = getattr(one, key)
            try:
                return None if text is None else admittance(text, self.values)
            except BadInput as error:
                raise BadInput(f"{where((*path, key))}: {error}") from None

        beside, behind = read("beside"), read("behind")
        roles = {}
        for role, key in (("static spring", "static_spring"), ("bush", "bush")):
            name = getattr(one, key)
            if name is None:
                continue
            spring = Rational.spring(self.values[name])
            roles[role] = name
            if key == "static_spring":
                beside_strut, beside = beside, spring if beside is None else beside | spring
            else:
                behind = spring
        if "static spring" not in roles:
            beside_strut = beside
        return Place(
            Mounting(beside, behind),
            beside_strut=beside_strut,
            roles=roles,
            terminals=one.terminals,
            default=None if (default := read("default")) is None or default.is_zero() else default,
            has_default=one.default is not None,
            default_label=one.default_label,
            carried=number(one.carried, self.values),
        )

    # --- metrics ---------------------------------------------------------------------------------------------

    @cached_property
    def metrics(self) -> Mapping[str, Metric]:
        """Those of the file, and of every output its r.m.s. over all frequencies and its largest gain."""
        found: dict[str, Metric] = {}
        for one in self.model.metrics:
            found[one.name] = self.metric(one, found)
        for output in self.model.outputs:
            found.setdefault(f"rms_{output.name}", RootMeanSquare("load", output.name, output.unit))
        found |= {"static_stiffness": StaticStiffness(), "inertance": Inertance()}
        for output in self.model.outputs:
            found.setdefault(f"gain_{output.name}", LargestGain("load", output.name))
        return found

    def metric(self, one: Judged, known: Mapping[str, Metric]) -> Metric:
        """A metric of the file."""
        factor = Factor(one.factor)
        if one.kind == "rms":
            stop = math.inf if one.to is None else number(one.to, self.values)
            return RootMeanSquare("load", one.output, one.unit, stop, factor)
        if one.kind == "gain":
            return LargestGain("load", one.output, one.unit)
        if one.kind == "peak":
            return PeakInTime("load", one.output, one.corners, one.unit, factor(self))
        if one.kind == "damping_ratio":
            return DampingRatio("load", (self.V,))
        return WeightedSum(tuple((weight, known[name]) for name, weight in one.parts))

    @cached_property
    def headline(self) -> tuple[str, ...]:
        """The metrics of the file; without any, the root mean squares that are finite."""
        shown = tuple(one.name for one in self.model.metrics)
        if not shown:
            plant = self.plant("load")
            shown = tuple(f"rms_{name}" for i, name in enumerate(plant.outputs) if not np.any(plant.Dzw[i])) or tuple(
                f"gain_{name}" for name in plant.outputs
            )
        return (*shown, "static_stiffness")

    @property
    def columns(self) -> tuple[str, ...]:
        """The first few of them."""
        return self.headline[:-1][:_COLUMNS]

    @property
    def compared(self) -> tuple[str, ...]:
        """All columns, where there is a default to compare with."""
        better = [name for name in self.columns if self.metrics[name].better == "less"]
        return tuple(better) if self.places[FIRST].has_default else ()

    @cached_property
    def ride(self) -> str:
        """The first root mean square."""
        norms = {name: metric.norm() for name, metric in self.metrics.items()}
        return next(name for name in (*self.headline, *norms) if (norm := norms[name]) and norm.kind == "H2")

    @cached_property
    def passive(self) -> bool:
        """Whether the open model is stable and its ports are passive, on a grid of its own frequencies."""
        return ports_are_passive(self.plant("load"))

    # --- what a solver asks ----------------------------------------------------------------------------------

    def at(self, speed: float) -> Any:
        """The same at another speed, m/s; a model without a speed is the same at any."""
        if "V" not in self.values:
            return self
        if not (math.isfinite(speed) and speed > 0):
            raise BadInput(f"speed is {speed:g} m/s; it must be finite and greater than 0")
        return dataclasses.replace(self, V=float(speed))  # type: ignore[type-var]

    def plant(self, load: str, *, opened: bool = False) -> Plant:
        """The plant on its one load: the first place open, the others with their defaults; `opened`: all of them."""
        return _plant(self, opened)

    def require_stable(self, closed: ClosedVehicle) -> None:
        """Every mode that an output sees decays."""
        closed.on("load").require_stable(self.name, share=EDGE)


@lru_cache(maxsize=256)
def _plant(vehicle: Modelled, opened: bool) -> Plant:
    whole = assembled(vehicle.model, vehicle.values)
    whole = dataclasses.replace(whole, groups=tuple(vehicle.called[name] for name in whole.groups))
    others = {name: place for name, place in vehicle.places.items() if name != FIRST}
    if opened or not others:
        return whole
    inside = {name: state_space(place.around.port(place.default)) for name, place in others.items()}
    return absorbed(whole, inside, group=FIRST)


@cache
def modelled(model: Model) -> type[Any]:
    """The class of a model's vehicles: a frozen dataclass whose fields are the parameters."""
    fields = [
        (one.name, float, parameter(one.value, one.unit, one.meaning, source=one.source, may_be_zero=True))
        for one in model.parameters
    ]
    return dataclasses.make_dataclass(
        "ModelledVehicle", fields, bases=(Modelled,), frozen=True, namespace={"model": model, "name": model.name}
    )


def _restored(model: Model, values: tuple[float, ...]) -> Any:
    return modelled(model)(*values)
