"""A plant from anywhere, given as a python-control state space with named signals, as a design problem.

    ẋ = A x + B_w w(t − τ) + B_f f,     z = C_z x + D_z w + D_f f,     v = C_v x,     f = Y v

The device answers the relative velocity v of its terminals with the force f, and f is what the device does to the
plant with the sign that takes energy out of it: with f = −c v on a mass (f an input, v the velocity) the mass has to be
given as v̇ = −f/m. A plant of passive parts then has −v/f positive real, and any positive-real device keeps it stable.
In other fields v is the across variable and f the through variable of the port: a current and a voltage, say.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from posreal.admittance import Rational
from posreal.admittance.device import as_rational
from posreal.admittance.positive_real import require
from posreal.design.device import read_device
from posreal.design.goal import Goal
from posreal.design.named import limited
from posreal.design.problem import Problem
from posreal.errors import BadInput, listed
from posreal.vehicle import Plant, UserPlant

_LARGEST = 200  # states: beyond that a search is hours, and the plant wants a reduction first


def problem_from_plant(
    system: Any,
    *,
    disturbances: Sequence[str] | str,
    force: Sequence[str] | str,
    performance: str,
    velocity: Sequence[str] | str,
    delays: Mapping[str, float] | None = None,
    density: float = 1.0,
    objective: str = "rms",
    weights: Mapping[str, float] | None = None,
    limits: Mapping[str, float] | None = None,
    beside: Any = None,
    behind: Any = None,
    name: str = "plant",
) -> Problem:
    """A design problem from a python-control state space.

    Parameters
    ----------
    system : control.StateSpace
        Continuous, inputs and outputs named. All outputs but the velocities become metrics ``rms_OUTPUT`` (over all
        frequencies) and, where asked for, ``gain_OUTPUT`` (the H∞ norm).
    disturbances : str or sequence of str
        Inputs that one white process drives, each after its own delay.
    force, velocity : str or sequence of str
        Input and output of each port. Several ports hold copies of the same device.
    performance : str
        The output that is minimised.
    delays : mapping of disturbance to seconds, optional
    density : float
        Single-sided spectral density of the white process, per rad/s.
    objective : {"rms", "gain"}
        Root mean square, or largest gain over all frequencies.
    weights : mapping of output to float, optional
        Minimise the weighted sum of the outputs' root mean squares instead; `performance` is then among them.
    limits : mapping of metric to float, optional
        Upper limits, such as ``{"rms_stroke": 0.02}``.
    beside, behind : device, optional
        What stands in parallel, in series with the device whatever it is; positive real, `behind` a spring.
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
    w, f = _indices("input", inputs, disturbances), _indices("input", inputs, force)
    v = _indices("output", outputs, velocity)
    _indices("output", outputs, performance)
    if len(f) != len(v):
        raise BadInput(f"{len(f)} forces and {len(v)} velocities; give one of each for every port")
    if set(w) & set(f):
        raise BadInput(f"{listed(inputs[i] for i in sorted(set(w) & set(f)))} is both a disturbance and a force")
    if np.any(D[np.ix_(v, [*w, *f])] != 0):
        raise BadInput(
            "the velocity of a port answers an input at once; add the mass or the compliance at the port that it lacks"
        )
    z = [i for i in range(len(outputs)) if i not in v]
    late = dict(delays or {})
    _indices("disturbance", [inputs[i] for i in w], list(late))
    if any(not (np.isfinite(value) and value >= 0) for value in late.values()):
        raise BadInput("delays are seconds, finite and not negative")
    if not (np.isfinite(density) and density > 0):
        raise BadInput(f"density is {density:g}; it must be finite and greater than 0")
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
        delays=np.array([late.get(inputs[i], 0.0) for i in w]),
        outputs=tuple(outputs[i] for i in z),
        groups=("secondary",) * len(f),
        density=density,
    )
    around = [None if part is None else require(as_rational(_read(part))) for part in (beside, behind)]
    if around[1] is not None and around[1] != Rational.spring(around[1].static_stiffness):
        raise BadInput("behind the device stands a spring or nothing; make anything else a part of the plant")
    own = UserPlant(plant, around[0], around[1], name)
    if objective not in ("rms", "gain"):
        raise BadInput(f"unknown objective {objective!r}; accepted are rms or gain")
    goal = None
    metric = f"{objective}_{performance}"
    if weights is not None:
        _indices("output", list(plant.outputs), list(weights))
        if performance not in weights or not all(np.isfinite(x) and x > 0 for x in weights.values()):
            raise BadInput("weights are above 0, and one of them is the performance output's")
        goal = Goal("sum", tuple((f"{objective}_{output}", float(x)) for output, x in weights.items()))
        metric = goal.name
    direct = plant.Dzw[plant.output(performance)]
    if objective == "rms" and np.any(direct != 0):
        raise BadInput(f"white noise passes straight through to {performance}, so its mean square is infinite")
    made = Problem(name, f"least {metric} of a plant of the user's own", own, metric, goal=goal)
    return made if not limits else limited(made, limits)


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
            raise BadInput(f"the plant has no {kind} {one!r}; it has {listed(known)}")
    if not names and kind in ("input", "output"):
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
