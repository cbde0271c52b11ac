"""A model on a page of TOML, read into a vehicle and its problems; docs/models.md describes the page.

[parameters]    name = number, text with a unit, or a table with value, meaning, source
[coordinates]   name = mass or inertia
[connections]   name = { between, stiffness, damping, inertance, admittance, on }
[places]        name = { between or ports, beside, behind, static_spring, bush, default, terminals, carried }
[inputs]        name = { quantity, on, density, filter, follows, delay }
[outputs]       name = { displacement, velocity, acceleration or force, unit }
[metrics]       name = { rms, gain, peak, damping_ratio or sum, unit, factor, to, corners }
[problem]       minimise, keep, limits, summary; several as [problems.NAME]
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

from posreal.errors import BadInput, hint, listed, plain, shown
from posreal.specification.goal import weighted_sum
from posreal.specification.model_text import admittance_text
from posreal.specification.toml_lines import line_of
from posreal.units import si_quantity
from posreal.vehicle.assembly import assembled
from posreal.vehicle.model import (
    METRICS,
    OUTPUTS,
    QUANTITIES,
    Connection,
    Excitation,
    Judged,
    Model,
    Named,
    Opening,
    Signal,
)
from posreal.vehicle.modelled import Modelled, modelled

SECTIONS = ("parameters", "coordinates", "connections", "places", "inputs", "outputs", "metrics")
_NAME = re.compile(r"[A-Za-z]\w*", re.ASCII)
_TAKEN = {"s", "pi", *(name for name in dir(Modelled) if name != "V")}
_MOST = 500  # entries of a section
_MOST_COORDINATES = 100


class ModelReader:
    """One file.

    Parameters
    ----------
    path : Path
    document : the tables of the file
    text : str
        For the lines of errors.
    """

    def __init__(self, path: Path, document: Mapping[str, Any], text: str) -> None:
        self.path, self.document, self.text = path, document, text

    def where(self, keys: tuple[Any, ...]) -> str:
        """The file, the line and the key."""
        line = line_of(self.text, keys)
        place = ".".join(plain(key, 40) for key in keys)
        return f"{plain(self.path)}{'' if line is None else f', line {line}'}: {place}"

    def wrong(self, keys: tuple[Any, ...], complaint: object) -> BadInput:
        """An error that names the place."""
        return BadInput(f"{self.where(keys)}: {complaint}")

    # --- the model -------------------------------------------------------------------------------------------

    def vehicle(self) -> Modelled:
        """The vehicle, with its parameters as the file has them, once all of it has been put together."""
        model = Model(
            name=self.path.stem,
            parameters=tuple(self.parameter(name, given) for name, given in self.section("parameters").items()),
            coordinates=tuple(
                (name, self.expression(("coordinates", name), given)) for name, given in self.required("coordinates")
            ),
            connections=tuple(
                self.connection(name, self.table("connections", name, given))
                for name, given in self.section("connections").items()
            ),
            places=tuple(
                self.opening(name, self.table("places", name, given)) for name, given in self.required("places")
            ),
            inputs=tuple(
                self.excitation(name, self.table("inputs", name, given)) for name, given in self.required("inputs")
            ),
            outputs=tuple(
                self.signal(name, self.table("outputs", name, given)) for name, given in self.required("outputs")
            ),
            metrics=tuple(
                self.judged(name, self.table("metrics", name, given)) for name, given in self.section("metrics").items()
            ),
        )
        if len(model.coordinates) > _MOST_COORDINATES:
            raise self.wrong(("coordinates",), f"up to {_MOST_COORDINATES} are taken; reduce the model")
        self.require_distinct(model)
        try:
            vehicle: Modelled = modelled(model)()
        except BadInput as error:
            raise BadInput(f"{plain(self.path)}: parameters: {error}") from None
        assembled(model, vehicle.values, self.where)
        for one in model.places:
            vehicle.place(one, self.where)
        self.require_metrics(model, vehicle)
        return vehicle

    def section(self, name: str) -> Mapping[str, Any]:
        found = self.document.get(name, {})
        if not isinstance(found, dict) or len(found) > _MOST:
            raise self.wrong((name,), f"a table [{name}] of up to {_MOST} entries is wanted")
        for key in found:
            if not _NAME.fullmatch(key) or len(key) > 60:
                raise self.wrong((name, key), "a name is a letter, followed by letters, digits or _, up to 60 in all")
        return found

    def required(self, name: str) -> Iterable[tuple[str, Any]]:
        found = self.section(name)
        if not found:
            raise BadInput(f"{plain(self.path)} has no [{name}]; a model needs coordinates, places, inputs and outputs")
        return found.items()

    def table(self, section: str, name: str, given: Any) -> dict[str, Any]:
        if not isinstance(given, dict):
            raise self.wrong((section, name), f"a table is wanted, such as {name} = {_EXAMPLE[section]}")
        return dict(given)

    def known(self, keys: tuple[Any, ...], given: Mapping[str, Any], accepted: Iterable[str]) -> None:
        names = list(accepted)
        for key in given:
            if key not in names:
                raise self.wrong((*keys, key), f"unknown key; {hint(key, names)}")

    def expression(self, keys: tuple[Any, ...], given: Any) -> str:
        """Text that is an expression, or a number as such."""
        if isinstance(given, int | float) and not isinstance(given, bool):
            return repr(given) if given >= 0 else f"({given!r})"
        return self.words(keys, given)

    def words(self, keys: tuple[Any, ...], given: Any) -> str:
        if not isinstance(given, str) or not given.strip() or len(given) > 2000:
            raise self.wrong(keys, f"text is wanted, and {shown(given)} is given")
        return given

    def optional(self, keys: tuple[Any, ...], table: Mapping[str, Any], *names: str) -> dict[str, str]:
        return {name: self.expression((*keys, name), table[name]) for name in names if name in table}

    # --- its entries -----------------------------------------------------------------------------------------

    def parameter(self, name: str, given: Any) -> Named:
        keys = ("parameters", name)
        if name in _TAKEN:
            raise self.wrong(keys, f"{name} has another meaning here; give the parameter another name")
        table = given if isinstance(given, dict) else {"value": given}
        self.known(keys, table, ("value", "meaning", "source", "unit"))
        value, said = table.get("value"), {key: self.words((*keys, key), table[key]) for key in table if key != "value"}
        if isinstance(value, str):
            try:
                number, unit = si_quantity(value if "unit" not in said else f"{value} {said['unit']}")
            except BadInput as error:
                raise self.wrong(keys, error) from None
        elif isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300:
            number, unit = Fraction(value), said.get("unit", "1")
        else:
            raise self.wrong(keys, f"a number or text with a unit is wanted, and {shown(value)} is given")
        return Named(name, float(number), unit, said.get("meaning", ""), said.get("source", self.path.name))

    def connection(self, name: str, table: Mapping[str, Any]) -> Connection:
        keys = ("connections", name)
        self.known(keys, table, ("between", "on", "stiffness", "damping", "inertance", "admittance"))
        if "between" not in table:
            raise self.wrong(keys, "between is wanted, the linear form that it stands across, such as 'z1 - z2'")
        found = self.optional(keys, table, "between", "on", "stiffness", "damping", "inertance")
        if "admittance" in table:
            found["admittance"] = self.admittance((*keys, "admittance"), table["admittance"])
        if not {"stiffness", "damping", "inertance", "admittance"} & set(found):
            raise self.wrong(keys, "one of stiffness, damping, inertance and admittance is wanted")
        return Connection(name, **found)

    def admittance(self, keys: tuple[Any, ...], given: Any) -> str:
        try:
            return admittance_text(self.expression(keys, given), self.section("parameters"))
        except BadInput as error:
            raise self.wrong(keys, error) if str(self.path) not in str(error) else error from None

    def opening(self, name: str, table: Mapping[str, Any]) -> Opening:
        keys = ("places", name)
        texts = ("beside", "behind", "default")
        roles = ("static_spring", "bush")
        self.known(keys, table, ("between", "ports", "terminals", "carried", "default_label", *texts, *roles))
        if ("between" in table) == ("ports" in table):
            raise self.wrong(keys, "give between, the form that the device stands across, or ports, a list of such")
        ports = [table["between"]] if "between" in table else table["ports"]
        if not isinstance(ports, list) or not 1 <= len(ports) <= 40:
            raise self.wrong((*keys, "ports"), "a list of forms is wanted, such as ['z1 - z2', 'z3 - z4']")
        found: dict[str, Any] = {key: self.admittance((*keys, key), table[key]) for key in texts if key in table}
        for role in roles:
            if role in table:
                if table[role] not in self.section("parameters"):
                    raise self.wrong(
                        (*keys, role), f"the name of a parameter is wanted, the stiffness, not {shown(table[role])}"
                    )
                found[role] = table[role]
        if "bush" in table and "behind" in table:
            raise self.wrong((*keys, "behind"), "a bush stands behind the device already; give one of the two")
        ends = table.get("terminals", ["+", "-"])
        if (
            not isinstance(ends, list)
            or len(ends) != 2
            or not all(isinstance(end, str) and 0 < len(end) < 40 for end in ends)
        ):
            raise self.wrong((*keys, "terminals"), "two names are wanted, such as ['body', 'wheel']")
        if "default_label" in table:
            found["default_label"] = self.words((*keys, "default_label"), table["default_label"])
        found |= self.optional(keys, table, "carried")
        return Opening(name, tuple(self.words(keys, port) for port in ports), terminals=(ends[0], ends[1]), **found)

    def excitation(self, name: str, table: Mapping[str, Any]) -> Excitation:
        keys = ("inputs", name)
        self.known(keys, table, ("quantity", "on", "follows", "delay", "density", "filter"))
        leader, inputs = table.get("follows"), self.section("inputs")
        if leader is not None:
            if leader == name or not isinstance(inputs.get(leader), dict) or "follows" in inputs[leader]:
                others = [other for other, one in inputs.items() if isinstance(one, dict) and "follows" not in one]
                raise self.wrong(
                    (*keys, "follows"), f"the name of an input of its own is wanted: {listed(others or ['–'])}"
                )
            if {"density", "filter"} & set(table):
                raise self.wrong(keys, f"density and filter are those of {leader}, which it follows")
        elif "delay" in table:
            raise self.wrong((*keys, "delay"), "a delay is of an input that follows another one")
        quantity = table.get("quantity", inputs[leader].get("quantity") if leader else None)
        if quantity not in QUANTITIES:
            raise self.wrong((*keys, "quantity"), f"accepted are {listed(QUANTITIES)}, not {shown(quantity)}")
        if (quantity == "force") != ("on" in table):
            raise self.wrong((*keys, "on"), "a force, and nothing else, acts on a form of the coordinates: on = 'x3'")
        if quantity == "displacement" and "filter" not in (inputs[leader] if leader else table):
            raise self.wrong(keys, "a displacement is white noise through a filter: filter = '1/(s^2 + 2*s + 10)'")
        found = self.optional(keys, table, "on", "delay", "density")
        if "filter" in table:
            found["filter"] = self.expression((*keys, "filter"), table["filter"])
        return Excitation(name, quantity, follows=leader, **found)

    def signal(self, name: str, table: Mapping[str, Any]) -> Signal:
        keys = ("outputs", name)
        self.known(keys, table, (*OUTPUTS, "unit"))
        kinds = [kind for kind in OUTPUTS if kind in table]
        if len(kinds) != 1:
            raise self.wrong(keys, f"one of {listed(OUTPUTS)} is wanted")
        unit = self.words((*keys, "unit"), table["unit"]) if "unit" in table else _UNITS.get(kinds[0], "1")
        return Signal(name, kinds[0], self.expression((*keys, kinds[0]), table[kinds[0]]), unit)

    def judged(self, name: str, table: Mapping[str, Any]) -> Judged:
        keys = ("metrics", name)
        self.known(keys, table, (*METRICS, "unit", "factor", "to", "corners"))
        kinds = [kind for kind in METRICS if kind in table]
        if len(kinds) != 1:
            raise self.wrong(keys, f"one of {listed(METRICS)} is wanted")
        kind, of = kinds[0], table[kinds[0]]
        given = self.optional(keys, table, "factor", "to")
        if "unit" in table:
            given["unit"] = self.words((*keys, "unit"), table["unit"])
        fits = {
            "rms": {"factor", "to"},
            "gain": set(),
            "peak": {"factor", "corners"},
            "damping_ratio": set(),
            "sum": set(),
        }
        for key in ("factor", "to", "corners"):
            if key in table and key not in fits[kind]:
                raise self.wrong((*keys, key), f"{kind} takes no {key}")
        if kind == "damping_ratio":
            if of is not True:
                raise self.wrong(keys, "damping_ratio = true is the least of all modes")
            return Judged(name, kind, unit="%")
        text = self.words((*keys, kind), of)
        if kind == "sum":
            return Judged(name, kind, parts=self.parts(keys, text))
        outputs = self.section("outputs")
        if text not in outputs:
            raise self.wrong((*keys, kind), f"there is no output {shown(text)}; {hint(text, outputs)}")
        own = self.signal(text, self.table("outputs", text, outputs[text])).unit
        if kind != "gain" and "factor" not in given and given.setdefault("unit", own) != own:
            raise self.wrong(keys, f"factor is wanted, how many {given['unit']} one {own} is: factor = '1000'")
        corners = self.corners((*keys, "corners"), table.get("corners")) if kind == "peak" else ()
        to = given.get("to")
        return Judged(name, kind, text, given.get("unit", "1"), given.get("factor", "1"), to, corners)

    def parts(self, keys: tuple[Any, ...], text: str) -> tuple[tuple[str, float], ...]:
        before = list(self.section("metrics"))[: list(self.section("metrics")).index(keys[1])]
        try:
            goal = weighted_sum(text)
        except BadInput as error:
            raise self.wrong((*keys, "sum"), error) from None
        for metric, _ in goal.parts:
            if metric not in before:
                raise self.wrong((*keys, "sum"), f"{shown(metric)} is no metric above this one; a sum is of such")
        return goal.parts

    def corners(self, keys: tuple[Any, ...], given: Any) -> tuple[tuple[float, float], ...]:
        good = isinstance(given, list) and 0 < len(given) <= 100
        good = good and all(
            isinstance(pair, list)
            and len(pair) == 2
            and all(isinstance(x, int | float) and abs(x) < 1e12 for x in pair)
            for pair in given
        )
        if not good or any(instant < 0 for instant, _ in given):
            raise self.wrong(keys, "a peak is after ramps: corners = [[instant in s, change of slope], …]")
        return tuple((float(instant), float(change)) for instant, change in given)

    # --- as a whole ------------------------------------------------------------------------------------------

    def require_distinct(self, model: Model) -> None:
        """Parameters, coordinates and inputs stand in one expression; connections and places are named by outputs."""
        for groups in (
            (
                ("parameters", [one.name for one in model.parameters]),
                ("coordinates", [name for name, _ in model.coordinates]),
                ("inputs", [one.name for one in model.inputs]),
            ),
            (("connections", [one.name for one in model.connections]), ("places", [one.name for one in model.places])),
        ):
            seen: dict[str, str] = {}
            for section, names in groups:
                for name in names:
                    if name in seen or (section != "parameters" and name in ("s", "pi")):
                        other = f"[{seen[name]}] has it too" if name in seen else "it has another meaning"
                        raise self.wrong((section, name), f"the name {name} is taken: {other}")
                    seen[name] = section

    def require_metrics(self, model: Model, vehicle: Modelled) -> None:
        """Every metric has a value in a vehicle as this is."""
        for one in model.metrics:
            if one.name in ("static_stiffness", "inertance"):
                raise self.wrong(("metrics", one.name), "every vehicle has a metric of that name; take another")
            if one.kind == "peak" and (
                len(model.inputs) != sum(x.follows is not None for x in model.inputs) + 1
                or any(x.filter for x in model.inputs)
            ):
                raise self.wrong(
                    ("metrics", one.name), "a peak is after one input and those that follow it, unfiltered"
                )
            try:
                metric = vehicle.metric(one, vehicle.metrics)
                norm = metric.norm()
                if norm is not None:
                    norm.factor(vehicle)
            except BadInput as error:
                raise self.wrong(("metrics", one.name), error) from None
            plant = vehicle.plant("load")
            white = one.kind == "rms" and one.to is None and plant.Dzw[plant.output(one.output)].any()
            if white:
                raise self.wrong(
                    ("metrics", one.name),
                    f"white noise passes straight through to {one.output}, so its mean square over all frequencies is "
                    "infinite; give an end, such as to = '20 Hz', or a filter to the input",
                )


_UNITS = {"acceleration": "m/s^2", "velocity": "m/s", "displacement": "m", "force": "N"}
_EXAMPLE = {
    "connections": '{ between = "z1 - z2", stiffness = "20 kN/m" }',
    "places": '{ between = "z1 - z2" }',
    "inputs": '{ quantity = "velocity", density = 1e-3 }',
    "outputs": '{ acceleration = "z1" }',
    "metrics": '{ rms = "acceleration" }',
}
