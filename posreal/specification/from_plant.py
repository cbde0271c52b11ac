"""A plant from anywhere, given as a python-control state space with named signals, as a design problem.

    ẋ = A x + Σᵢ Bᵢ wᵢ(t − τᵢ) + B_f f,     z = C_z x + D_z w + D_f f,     v = C_v x,     f = Y v

The device answers the relative velocity v of its terminals with the force f, and f is what the device does to the
plant with the sign that takes energy out of it: with f = −c v on a mass (f an input, v the velocity) the mass has to be
given as v̇ = −f/m. A plant of passive parts then has −v/f positive real, and any positive-real device keeps it stable.
In other fields v is the across variable and f the through variable of the port: a voltage and a current, say, and the
device is then the admittance of an RLC one-port.

Every disturbance is white noise of its own, and the mean squares that they cause add; one process may reach several
inputs, each after its own delay (the wheels on one road). The performance may be several outputs: then it is the H2
norm of the vector, √Σ (weight · rms)².
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from posreal.admittance import Rational
from posreal.admittance.device import as_rational
from posreal.admittance.positive_real import require
from posreal.errors import BadInput, listed, shown
from posreal.network.read_device import read_device
from posreal.plant.plant import Plant
from posreal.specification.goal import Goal
from posreal.specification.limits import limited
from posreal.specification.problem import Problem
from posreal.vehicle import UserPlant

_LARGEST = 200  # states: beyond that a search is hours, and the plant wants a reduction first


def problem_from_plant(
    system: Any,
    *,
    disturbances: Sequence[str | Sequence[str]] | str,
    force: Sequence[str] | str,
    performance: Sequence[str] | str,
    velocity: Sequence[str] | str,
    delays: Mapping[str, float] | None = None,
    density: float | Mapping[str, float] = 1.0,
    objective: str = "rms",
    weights: Mapping[str, float] | None = None,
    limits: Mapping[str, float] | None = None,
    beside: Any = None,
    behind: Any = None,
    units: Mapping[str, str] | None = None,
    terminals: Sequence[str] = ("+", "-"),
    name: str = "plant",
) -> Problem:
    """A design problem from a python-control state space.

    Parameters
    ----------
    system : control.StateSpace
        Continuous, inputs and outputs named. All outputs but the velocities become metrics ``rms_OUTPUT`` (over all
        frequencies) and, where asked for, ``gain_OUTPUT`` (the H∞ norm).
    disturbances : str, or sequence of str and of sequences of str
        Each entry is a white process of its own; an entry of several inputs is one process that drives them all, each
        after its own delay: ``[["front", "rear"], "wind"]``.
    force, velocity : str or sequence of str
        Input and output of each port. Several ports hold copies of the same device.
    performance : str or sequence of str
        The output that is minimised; of several, the root of the sum of the (weighted) mean squares.
    delays : mapping of disturbance to seconds, optional
        Of inputs that share a process.
    density : float, or mapping of disturbance to float
        Single-sided spectral density of the white processes, per rad/s: of all, or of each by one of its inputs.
    objective : {"rms", "gain"}
        Root mean square; or largest gain of one output over all frequencies, of several processes the largest singular
        value, into which densities do not enter.
    weights : mapping of output to float, optional
        With one performance output, minimise Σ weight · rms over these instead (that output among them); with several,
        the weight of each in √Σ (weight · rms)², 1 where none is given.
    limits : mapping of metric to float, optional
        Upper limits, such as ``{"rms_stroke": 0.02}``.
    beside, behind : device, optional
        What stands in parallel, in series with the device whatever it is; positive real, `behind` a spring.
    units : mapping of output to str, optional
        In which the outputs are, for tables.
    terminals : (str, str)
        What the device stands between, for diagrams.
    name : str
        Of the problem.

    Returns
    -------
    Problem
        For :func:`posreal.synthesise`.

    Raises
    ------
    BadInput
        For a discrete or too large system, a name it does not have, a velocity that answers a force at once, or an
        objective that is unbounded.
    NotPositiveReal
        If `beside` or `behind` is not.
    """
    A, B, C, D = _matrices(system)
    inputs, outputs = list(system.input_labels), list(system.output_labels)
    entries = [disturbances] if isinstance(disturbances, str) else list(disturbances)
    groups = [_indices("input", inputs, entry) for entry in entries]
    w = [i for group in groups for i in group]
    f = _indices("input", inputs, force)
    v = _indices("output", outputs, velocity)
    wanted = [performance] if isinstance(performance, str) else list(performance)
    _indices("output", outputs, wanted)
    if len(f) != len(v):
        raise BadInput(f"{len(f)} forces and {len(v)} velocities; give one of each for every port")
    for kind, names, chosen in (("input", inputs, w), ("input", inputs, f), ("output", outputs, v)):
        for i in chosen:
            if chosen.count(i) > 1:
                raise BadInput(f"the {kind} {shown(names[i])} is given twice")
    if not w:
        raise BadInput(f"give at least one disturbance of {listed(inputs)}")
    if set(w) & set(f):
        raise BadInput(f"{listed(inputs[i] for i in sorted(set(w) & set(f)))} is both a disturbance and a force")
    if np.any(D[np.ix_(v, [*w, *f])] != 0):
        raise BadInput(
            "the velocity of a port answers an input at once; add the mass or the compliance at the port that it lacks"
        )
    z = [i for i in range(len(outputs)) if i not in v]
    if not z:
        raise BadInput("every output is the velocity of a port; add the one whose mean square or gain is minimised")
    processes = tuple(number for number, group in enumerate(groups) for _ in group)
    named = [[inputs[i] for i in group] for group in groups]
    densities = _densities(named, density)
    A, B, C, displacement = _with_displacements(A, B, C, v, [*w, *f])
    plant = Plant(
        A=A,
        Bw=B[:, w],
        Bf=B[:, f],
        Cz=C[z],
        Dzw=D[np.ix_(z, w)],
        Dzf=D[np.ix_(z, f)],
        Cd=displacement,
        Cv=C[v],
        delays=_delays(named, delays or {}),
        outputs=tuple(outputs[i] for i in z),
        groups=("secondary",) * len(f),
        density=densities[0],
        processes=processes,
        shares=tuple(value / densities[0] for value in densities),
    )
    around = [None if part is None else require(as_rational(_read(part))) for part in (beside, behind)]
    if around[1] is not None and around[1] != Rational.spring(around[1].static_stiffness):
        raise BadInput("behind the device stands a spring or nothing; make anything else a part of the plant")
    if units:
        _indices("output", plant.outputs, list(units))
    own = UserPlant(plant, around[0], around[1], name, dict(units or {}), (terminals[0], terminals[1]))
    if objective not in ("rms", "gain"):
        raise BadInput(f"unknown objective {shown(objective)}; accepted are rms or gain")
    goal = _goal(plant, objective, wanted, weights)
    metric = f"{objective}_{wanted[0]}" if goal is None else goal.name
    for output in wanted if goal is None else [part.removeprefix("rms_") for part, _ in goal.parts]:
        if objective == "rms" and np.any(plant.Dzw[plant.output(output)] != 0):
            raise BadInput(f"white noise passes straight through to {output}, so its mean square is infinite")
    made = Problem(name, f"least {metric} of a plant of the user's own", own, metric, goal=goal)
    return made if not limits else limited(made, limits)


def _goal(plant: Plant, objective: str, wanted: Sequence[str], weights: Mapping[str, float] | None) -> Goal | None:
    """What the objective is made of, where it is not one output's metric."""
    if len(wanted) == 1 and weights is None:
        _indices("output", plant.outputs, wanted)
        return None
    given = dict(weights or {})
    _indices("output", plant.outputs, [*wanted, *given])
    if not all(np.isfinite(x) and x > 0 for x in given.values()):
        raise BadInput("weights are finite and above 0")
    if len(wanted) == 1:
        if wanted[0] not in given:
            raise BadInput("weights are of outputs whose sum is minimised, and one of them is the performance output's")
        return Goal("sum", tuple((f"{objective}_{output}", float(x)) for output, x in given.items()))
    if objective == "gain":
        raise BadInput("a largest gain is of one performance output; give one, or the weights of a sum of gains")
    stray = [output for output in given if output not in wanted]
    if stray:
        raise BadInput(f"{listed(stray)} has a weight and is not among the performance outputs {listed(wanted)}")
    return Goal("norm", tuple((f"rms_{output}", float(given.get(output, 1.0))) for output in wanted))


def _delays(groups: Sequence[Sequence[str]], given: Mapping[str, float]) -> np.ndarray:
    """Seconds of every channel, in the order of the groups."""
    names = [name for group in groups for name in group]
    _indices("disturbance", names, list(given))
    if any(not (np.isfinite(value) and value >= 0) for value in given.values()):
        raise BadInput("delays are seconds, finite and not negative")
    for group in groups:
        if len(group) == 1 and given.get(group[0]):
            raise BadInput(
                f"{group[0]} has a delay and a process of its own, which nothing can tell from one without; "
                'inputs that share a process are a list of their own, such as [["front", "rear"]]'
            )
    return np.array([given.get(name, 0.0) for name in names])


def _densities(groups: Sequence[Sequence[str]], given: float | Mapping[str, float]) -> tuple[float, ...]:
    """The density of each process."""
    if not isinstance(given, Mapping):
        given = {group[0]: given for group in groups}
    _indices("disturbance", [name for group in groups for name in group], list(given))
    for name, value in given.items():
        if not (np.isfinite(value) and value > 0):
            raise BadInput(f"the density of {name} is {value:g}; it must be finite and greater than 0")
    found: list[float] = []
    for group in groups:
        values = {float(given[name]) for name in group if name in given}
        if len(values) != 1:
            raise BadInput(f"density must name each process once, and {listed(group)} has {len(values)}")
        found += values
    return tuple(found)


def _read(device: Any) -> Any:
    return read_device(device) if isinstance(device, str) else device


def _matrices(system: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    if not all(hasattr(system, part) for part in ("A", "B", "C", "D", "input_labels", "output_labels")):
        raise BadInput(f"{type(system).__name__} is not a state space with named signals; give control.ss(…, inputs=…)")
    if getattr(system, "dt", 0) not in (0, None):
        raise BadInput("the plant is sampled; give a continuous one")
    A, B, C, D = (np.atleast_2d(np.asarray(getattr(system, part), dtype=float)) for part in "ABCD")
    if len(A) > _LARGEST:
        raise BadInput(f"the plant has {len(A)} states; reduce it to {_LARGEST} at most")
    if not all(np.all(np.isfinite(part)) for part in (A, B, C, D)):
        raise BadInput("the plant's matrices have entries that are not finite")
    return A, B, C, D


def _indices(kind: str, known: Sequence[str], wanted: Sequence[str] | str) -> list[int]:
    names = [wanted] if isinstance(wanted, str) else list(wanted)
    for one in names:
        if one not in known:
            raise BadInput(f"the plant has no {kind} {shown(one)}; it has {listed(known)}")
    if not names and kind != "disturbance":
        raise BadInput(f"give at least one {kind} of {listed(known)}")
    return [list(known).index(one) for one in names]


def _with_displacements(
    A: np.ndarray, B: np.ndarray, C: np.ndarray, ports: Sequence[int], inputs: Sequence[int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The displacement of every port as a row on the state; a state is added where the plant has none.

    Cd with Cd A = Cv and Cd B = 0 is the displacement, if there is one; otherwise ḋ = v becomes a state.
    """
    rows = []
    for port in ports:
        n = len(A)
        system = np.hstack([A, B[:, inputs]]).T
        wanted = np.concatenate([C[port], np.zeros(len(inputs))])
        scale = np.maximum(np.abs(system).max(axis=1), 1e-300)
        row = np.linalg.lstsq(system / scale[:, None], wanted / scale, rcond=None)[0]
        if np.abs(system @ row - wanted).max() <= 1e-9 * max(np.abs(wanted).max(), 1e-300):
            rows.append(row)
            continue
        A = np.block([[A, np.zeros((n, 1))], [C[port][None, :], np.zeros((1, 1))]])
        B = np.vstack([B, np.zeros((1, B.shape[1]))])
        C = np.hstack([C, np.zeros((len(C), 1))])
        rows.append(np.concatenate([np.zeros(n), [1.0]]))
    return A, B, C, np.array([np.concatenate([row, np.zeros(len(A) - len(row))]) for row in rows])
