"""From a model as data to its plant, all places open.

With q the coordinates, y the displacement inputs, e q + r y the form of a connection and a the form that it acts on,

    M q̈ = − Σ a (k (e q + r y) + c (e q̇ + r ẏ) + b e q̈ + C_ξ ξ) + G u − Σ E f,    ξ̇ = A_ξ ξ + B_ξ (e q̇ + r ẏ)

A displacement input has no finite variance where its velocity or acceleration is white, and neither have the
coordinates. As in :mod:`posreal.plant.second_order` the state is therefore q̃ = q − S y, with S the static shape,
K S = N₀, Eᵀ S = 0, and

    velocity given       q̃˙ = q̇ − S w,    with w = ẏ and q̇ in the state
    acceleration given   q̃˙ = v,          with v = q̇ − S ẏ in the state and M v̇ = … − M S w, w = ÿ: for this nothing
                                          but S may move with the ground (e S + r = 0 where there is a damper)
    displacement given   y = H(s)·white, whose velocity is s H(s)·white

Outputs that contain y itself, where it has no finite variance, are refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from posreal.admittance import Rational, StateSpace, state_space
from posreal.errors import BadInput, hint, shown
from posreal.plant.plant import Plant, Real
from posreal.plant.second_order import SecondOrder
from posreal.vehicle.expression import Names, admittance, linear, number
from posreal.vehicle.model import Connection, Excitation, Model, Opening, Signal

EXACT = 1e-9  # of a row's own size: a part of it that rounding has left of nothing
MOST_STATES = 200
Where = Callable[[tuple[Any, ...]], str]


def unplaced(path: tuple[Any, ...]) -> str:
    """Where in a file a key stands, for who has no file."""
    return ".".join(str(part) for part in path)


def assembled(model: Model, names: Names, where: Where = unplaced) -> Plant:
    """The plant of a model; each place is a group of ports, of its name.

    Parameters
    ----------
    model : Model
    names : mapping of parameter to exact value
    where : function of a path of keys
        How an error names the place in the file.

    Raises
    ------
    BadInput
    """
    return _Assembly(model, names, where).plant()


@dataclass
class _Stiff:
    """A connection in numbers: its form on coordinates `e` and inputs `r`, on what it acts, and its parts."""

    e: Real
    r: Real
    a: Real
    k: float
    c: float
    b: float
    inner: StateSpace | None


class _Assembly:
    def __init__(self, model: Model, names: Names, where: Where) -> None:
        self.model, self.names, self.where = model, names, where
        self.coordinates = [name for name, _ in model.coordinates]
        self.ground = [one.name for one in model.inputs if one.quantity != "force"]
        self.columns = {one.name: i for i, one in enumerate(model.inputs)}

    @contextmanager
    def at(self, *path: Any) -> Iterator[None]:
        """Errors within name this key."""
        try:
            yield
        except BadInput as error:
            raise BadInput(f"{self.where(path)}: {error}") from None

    def form(self, text: str) -> tuple[Real, Real]:
        """Coefficients on the coordinates, and on the inputs (columns of all, zero where they are forces)."""
        row = linear(text, [*self.coordinates, *self.ground], self.names)
        r = np.zeros(len(self.model.inputs))
        for name, value in zip(self.ground, row[len(self.coordinates) :], strict=True):
            r[self.columns[name]] = value
        return np.array(row[: len(self.coordinates)]), r

    def on_coordinates(self, text: str) -> Real:
        """A form in which no input may stand."""
        e, r = self.form(text)
        if np.any(r):
            raise BadInput(f"{shown(text)} has an input in it; give a form of the coordinates alone")
        return e

    # --- the parts -------------------------------------------------------------------------------------------

    def connection(self, one: Connection) -> _Stiff:
        path = ("connections", one.name)
        with self.at(*path, "between"):
            e, r = self.form(one.between)
        with self.at(*path, "on"):
            a = e if one.on is None else self.on_coordinates(one.on)
        parts = {}
        for key in ("stiffness", "damping", "inertance"):
            text = getattr(one, key)
            with self.at(*path, key):
                parts[key] = 0.0 if text is None else number(text, self.names)
        k, c, b = parts.values()
        inner = None
        if one.admittance is not None:
            with self.at(*path, "admittance"):
                found = state_space(admittance(one.admittance, self.names))
            k, c, b = k + found.k, c + float(found.D[0, 0]), b + found.b
            inner = found if len(found.A) else None
        if b and np.any(r):
            with self.at(*path):
                raise BadInput("an inerter to an input feels the input's acceleration; put a mass between them")
        return _Stiff(e, r, a, k, c, b, inner)

    def body(self, parts: list[_Stiff]) -> tuple[SecondOrder, Real, Real]:
        """M, C, K with the ports, and N₀ and N₁ of the inputs."""
        n, m = len(self.coordinates), len(self.model.inputs)
        M, C, K = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
        N0, N1 = np.zeros((n, m)), np.zeros((n, m))
        for i, (name, text) in enumerate(self.model.coordinates):
            with self.at("coordinates", name):
                M[i, i] = number(text, self.names)
                if M[i, i] < 0:
                    raise BadInput(f"the mass or inertia of {name} is {M[i, i]:g}; it is at least 0")
        for one in parts:
            K += one.k * np.outer(one.a, one.e)
            C += one.c * np.outer(one.a, one.e)
            M += one.b * np.outer(one.a, one.e)
            N0 -= one.k * np.outer(one.a, one.r)
            N1 -= one.c * np.outer(one.a, one.r)
        if not np.allclose(M, M.T) or np.linalg.eigvalsh(M / np.abs(M).max(initial=1e-300)).min() <= 1e-14:
            massless = [name for i, name in enumerate(self.coordinates) if M[i, i] <= 0]
            with self.at("coordinates", *massless[:1]):
                raise BadInput(
                    f"{massless[0] if massless else 'a combination of coordinates'} has no mass; give every coordinate "
                    "a mass or inertia above 0, or leave it out and give its connections as one admittance"
                )
        ports = [self.port(one, j, text) for one in self.model.places for j, text in enumerate(one.ports)]
        return SecondOrder(M, C, K, np.column_stack(ports), tuple(self.coordinates)), N0, N1

    def port(self, one: Opening, j: int, text: str) -> Real:
        with self.at("places", one.name, "between" if len(one.ports) == 1 else "ports"):
            return self.on_coordinates(text)

    # --- the plant -------------------------------------------------------------------------------------------

    def plant(self) -> Plant:
        model = self.model
        parts = [self.connection(one) for one in model.connections]
        body, N0, N1 = self.body(parts)
        n, inner = len(self.coordinates), [one for one in parts if one.inner is not None]
        S = self.static_shape(body, N0)
        sizes = [len(one.inner.A) for one in inner if one.inner is not None]
        total = 2 * n + sum(sizes)
        A = np.zeros((total, total))
        A[: 2 * n, : 2 * n] = body.free()
        Bw = np.zeros((total, len(model.inputs)))
        at = 2 * n
        for one, size in zip(inner, sizes, strict=True):
            assert one.inner is not None
            here = slice(at, at := at + size)
            A[here, here] = one.inner.A
            A[here, n : 2 * n] = np.outer(one.inner.B[:, 0], one.e)
            A[n : 2 * n, here] = -np.linalg.solve(body.M, np.outer(one.a, one.inner.C[0]))
            Bw[here] = np.outer(one.inner.B[:, 0], one.r)
        for i, given in enumerate(model.inputs):
            if given.quantity == "force":
                with self.at("inputs", given.name, "on"):
                    push = self.on_coordinates(given.on or "")
                Bw[n : 2 * n, i] = np.linalg.solve(body.M, push)
            elif given.quantity == "acceleration":
                self.require_carried(given, i, S, [one for one in parts if one.c or one.inner is not None])
                Bw[:n, i], Bw[n:, i] = 0.0, 0.0
                Bw[n : 2 * n, i] = -S[:, i]
            else:
                Bw[:n, i] = -S[:, i]
                Bw[n : 2 * n, i] = np.linalg.solve(body.M, N1[:, i])
        Bf = np.vstack([body.device_force(), np.zeros((total - 2 * n, body.E.shape[1]))])
        E = np.hstack([body.E.T, np.zeros((body.E.shape[1], total - n))])
        Ev = np.hstack([np.zeros((body.E.shape[1], n)), body.E.T, np.zeros((body.E.shape[1], total - 2 * n))])
        rows = _Rows(self, S, A, Bw, Bf, parts)
        Cz, Dzw, Dzf = (np.array(part) for part in zip(*map(rows.row, model.outputs), strict=True))
        made = Plant(
            A=A,
            Bw=Bw,
            Bf=Bf,
            Cz=Cz,
            Dzw=Dzw,
            Dzf=Dzf,
            Cd=E,
            Cv=Ev,
            delays=self.delays(),
            outputs=tuple(one.name for one in model.outputs),
            groups=tuple(one.name for one in model.places for _ in one.ports),
            **self.spectrum(),
        )
        return self.coloured(made, rows)

    def static_shape(self, body: SecondOrder, N0: Real) -> Real:
        S = np.zeros_like(N0)
        for i, given in enumerate(self.model.inputs):
            if given.quantity == "force":
                continue
            if np.any(N0[:, i]):
                S[:, i] = body.static_shape(N0[:, [i]])[:, 0]
            size = max(np.abs(N0[:, i]).max(), np.abs(body.K).max() * np.abs(S[:, i]).max(), 1e-300)
            left = max(np.abs(body.K @ S[:, i] - N0[:, i]).max(), np.abs(body.E.T @ S[:, i]).max() * size)
            if left > EXACT * size:
                with self.at("inputs", given.name):
                    raise BadInput(
                        f"the model cannot stand on a displaced {given.name} with nothing in its places, so its "
                        "coordinates have no finite variance; give the input as a force, or the springs that carry it"
                    )
        return S

    def require_carried(self, given: Excitation, i: int, S: Real, parts: list[_Stiff]) -> None:
        """Nothing with a damper may feel an accelerated ground but by the motion relative to the static shape."""
        for one in parts:
            if abs(one.e @ S[:, i] + one.r[i]) > EXACT * max(1.0, np.abs(one.e).max()):
                with self.at("inputs", given.name, "quantity"):
                    raise BadInput(
                        f"a damper feels the velocity of {given.name}, which has no finite variance where its "
                        "acceleration is white; give its velocity or its displacement"
                    )

    def delays(self) -> Real:
        found = []
        for one in self.model.inputs:
            with self.at("inputs", one.name, "delay"):
                delay = number(one.delay, self.names)
                if delay < 0:
                    raise BadInput(f"the delay of {one.name} is {delay:g} s; it is at least 0")
            found.append(delay)
        return np.array(found)

    def spectrum(self) -> dict[str, Any]:
        """Density of the first process, shares of the others, and which channel each drives."""
        leaders = [one for one in self.model.inputs if one.follows is None]
        densities = []
        for one in leaders:
            with self.at("inputs", one.name, "density"):
                value = number(one.density, self.names)
                if not value > 0:
                    raise BadInput(f"the density of {one.name} is {value:g}; it is above 0")
            densities.append(value)
        order = [one.name for one in leaders]
        processes = tuple(order.index(one.follows or one.name) for one in self.model.inputs)
        if len(order) == 1:
            return {"density": densities[0]}
        return {
            "density": densities[0],
            "processes": processes,
            "shares": tuple(value / densities[0] for value in densities),
        }

    def coloured(self, plant: Plant, rows: _Rows) -> Plant:
        """The filters put before their channels, a copy each (delays commute with them)."""
        for i, given in enumerate(self.model.inputs):
            leader = next(one for one in self.model.inputs if one.name == (given.follows or given.name))
            if leader.filter is None:
                continue
            with self.at("inputs", leader.name, "filter"):
                H = state_space(self.filter(leader, given))
                if H.k or H.b or (given.quantity == "displacement" and H.D[0, 0]):
                    what = "has an integrator" if H.k else "does not fall off at high frequency"
                    raise BadInput(f"the filter {shown(leader.filter)} {what}, so {given.name} has no finite variance")
            plant = _filtered(plant, i, H, rows.seen[:, i], displacement=given.quantity == "displacement")
        if len(plant.A) > MOST_STATES:
            raise BadInput(f"the model has {len(plant.A)} states; reduce it to {MOST_STATES} at most")
        return plant

    def filter(self, leader: Excitation, given: Excitation) -> Rational:
        assert leader.filter is not None
        return admittance(leader.filter, self.names)


class _Rows:
    """Rows of the outputs on state, inputs and port forces.

    `seen` collects what of each displacement input itself, an output contains: (outputs, inputs).
    """

    def __init__(self, made: _Assembly, S: Real, A: Real, Bw: Real, Bf: Real, parts: list[_Stiff]) -> None:
        self.made, self.S, self.A, self.Bw, self.Bf, self.parts = made, S, A, Bw, Bf, parts
        self.n = len(made.coordinates)
        self.seen = np.zeros((len(made.model.outputs), Bw.shape[1]))

    def row(self, one: Signal) -> tuple[Real, Real, Real]:
        with self.made.at("outputs", one.name, one.kind):
            z, w, f, y = self.force(one) if one.kind == "force" else self.motion(one)
            self.seen[[out.name for out in self.made.model.outputs].index(one.name)] = y
            for i, given in enumerate(self.made.model.inputs):
                if y[i] and given.quantity != "displacement":
                    raise BadInput(
                        f"{one.name} contains the displacement of {given.name} itself, which has no finite variance; "
                        "take it relative to the ground, or give the input as a displacement with a filter"
                    )
            return z, w, f

    def part(self, kind: str, e: Real, r: Real) -> tuple[Real, Real, Real, Real]:
        """Displacement, velocity or acceleration of e q + r y, as rows on (x, w, f) and on y."""
        n, total = self.n, len(self.A)
        row, rest = np.zeros(total), e @ self.S + r
        rest[np.abs(rest) <= EXACT * max(1.0, np.abs(e).max(initial=0.0))] = 0.0
        none = np.zeros(self.Bw.shape[1])
        still = np.zeros(self.Bf.shape[1])
        accelerated = np.array([one.quantity == "acceleration" for one in self.made.model.inputs])
        if kind == "displacement":
            row[:n] = e
            return row, none, still, rest
        row[n : 2 * n] = e
        if kind == "velocity":
            if np.any(rest[accelerated]):
                raise BadInput("it contains the velocity of an accelerated ground, which has no finite variance")
            return row, np.where(accelerated, 0.0, r), still, none
        if np.any(r[~accelerated]):
            raise BadInput("the acceleration of an input that is given as a velocity or displacement is infinite")
        return row @ self.A, row @ self.Bw + np.where(accelerated, rest, 0.0), row @ self.Bf, none

    def motion(self, one: Signal) -> tuple[Real, Real, Real, Real]:
        return self.part(one.kind, *self.made.form(one.of))

    def force(self, one: Signal) -> tuple[Real, Real, Real, Real]:
        """Of a connection or of one port of a place, on the form that it acts on."""
        model = self.made.model
        ports = [(place.name, j + 1, len(place.ports)) for place in model.places for j in range(len(place.ports))]
        names = [name if count == 1 else f"{name}.{j}" for name, j, count in ports]
        own = [given.name for given in model.connections]
        if one.of in names:
            f = np.zeros(self.Bf.shape[1])
            f[names.index(one.of)] = 1.0
            zero = np.zeros(self.Bw.shape[1])
            return np.zeros(len(self.A)), zero, f, zero
        if one.of not in own:
            raise BadInput(f"there is no connection or place {shown(one.of)}; {hint(one.of, [*own, *names])}")
        part = self.parts[own.index(one.of)]
        found: list[Any] = [np.zeros(len(self.A)), *(np.zeros(self.Bw.shape[1]) for _ in range(3))]
        found[2] = np.zeros(self.Bf.shape[1])
        for size, kind in ((part.k, "displacement"), (part.c, "velocity"), (part.b, "acceleration")):
            if size:
                found = [sum_ + size * more for sum_, more in zip(found, self.part(kind, part.e, part.r), strict=True)]
        at = 2 * self.n
        for other in self.parts:
            if other.inner is not None:
                here = slice(at, at := at + len(other.inner.A))
                if other is part:
                    found[0][here] += other.inner.C[0]
        return tuple(found)


def _filtered(plant: Plant, i: int, H: StateSpace, seen: Real, *, displacement: bool) -> Plant:
    """The plant with w of channel `i` made by H from white noise; H is of the displacement where that is given."""
    n, h = len(plant.A), len(H.A)
    gives = (H.C[0] @ H.A, float(H.C[0] @ H.B[:, 0])) if displacement else (H.C[0], float(H.D[0, 0]))
    A = np.zeros((n + h, n + h))
    A[:n, :n], A[n:, n:], A[:n, n:] = plant.A, H.A, np.outer(plant.Bw[:, i], gives[0])
    Bw = np.vstack([plant.Bw, np.zeros((h, plant.Bw.shape[1]))])
    Bw[:, i] = np.concatenate([plant.Bw[:, i] * gives[1], H.B[:, 0]])
    Dzw = plant.Dzw.copy()
    read = np.outer(plant.Dzw[:, i], gives[0]) + (np.outer(seen, H.C[0]) if displacement else 0.0)
    Dzw[:, i] *= gives[1]
    ports = np.zeros((len(plant.Cd), h))
    return replace(
        plant,
        A=A,
        Bw=Bw,
        Bf=np.vstack([plant.Bf, np.zeros((h, plant.Bf.shape[1]))]),
        Cz=np.hstack([plant.Cz, read]),
        Dzw=Dzw,
        Cd=np.hstack([plant.Cd, ports]),
        Cv=np.hstack([plant.Cv, ports]),
    )
