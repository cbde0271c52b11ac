"""The matrix inequalities (:mod:`.bmi`) on a problem: its plant, its sectors, and devices to begin with.

[Jiang2012] J.Z. Jiang, A.Z. Matamoros-Sanchez, R.M. Goodall, M.C. Smith, Passive suspensions incorporating inerters
for railway vehicles, Vehicle System Dynamics 50 (2012) 263–276.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from posreal.admittance import PortHamiltonian, random_port_hamiltonian
from posreal.design.synthesis import bmi
from posreal.design.synthesis.criterion import Candidate
from posreal.design.synthesis.generalised_plant import damped_plant, generalised_plant
from posreal.design.synthesis.judge import damper
from posreal.design.synthesis.progress import Search
from posreal.design.synthesis.starts import lifted
from posreal.vehicle import PlanView

SLACK = 1.01  # a drawn device that near the best may be preferred for its damping
DRAWN = 100  # devices looked at for the start
SECTOR_SPEEDS = (1.0, 55.0)  # m/s, where the damping of [Jiang2012]'s vehicle binds


def programs(
    search: Search,
    order: int,
    starts: int,
    settings: bmi.Settings,
    known: Sequence[Candidate],
    fixed: Mapping[str, float],
    rng: np.random.Generator,
    *,
    asked: bool,
) -> Candidate | None:
    """The matrix inequalities from the best of many drawn devices, `starts` times over.

    Parameters
    ----------
    search : Search
        Its objective a mean-square figure.
    order, starts : int
    settings : bmi.Settings
    known : sequence of Candidate
        Among those drawn.
    fixed : mapping
        Free vehicle parameters, which the inequalities leave alone.
    rng : numpy.random.Generator
    asked : bool
        Whether this is the order that was asked for: then where it ends counts.

    Returns
    -------
    Candidate or None
        None if no device was found to start from.
    """
    judge = search.judge
    criterion = judge.smooth
    assert criterion is not None
    problem = judge.problem.with_vehicle(fixed)
    plant = generalised_plant(problem, judge.scale)
    sectors = []
    if judge.least_damping is not None:
        assert isinstance(problem.vehicle, PlanView)
        sectors = [
            bmi.Sector(damped_plant(problem.vehicle.at(v), problem.mounting, judge.scale), judge.least_damping)
            for v in SECTOR_SPEEDS
        ]
    best: tuple[float, Candidate] | None = None
    for number in range(starts):
        start = _drawn(search, order, known, fixed, rng)
        if start is None:
            return None
        search.offer("start", start, judge.measure(start))
        outcome = bmi.iterate(
            plant,
            start.device,
            lambda device: judge.measure(Candidate(device, fixed)),
            lambda device: criterion.slope(Candidate(device, fixed)),
            sectors=sectors,
            settings=settings,
            taken=lambda device, value: search.offer("bmi", Candidate(device, fixed), value),
        )
        if asked:
            search.landed.append(outcome.value)
        search.progress(
            f"matrix inequalities {number + 1} of {starts}: {outcome.value:.6g} after {outcome.taken} steps, "
            f"{outcome.refused} refused"
        )
        if best is None or outcome.value < best[0]:
            best = outcome.value, Candidate(outcome.device, fixed)
    return None if best is None else best[1]


def _drawn(
    search: Search, order: int, known: Sequence[Candidate], fixed: Mapping[str, float], rng: np.random.Generator
) -> Candidate | None:
    """The best feasible of many devices: drawn at random, or known ones with weak states added."""
    judge = search.judge
    vehicle = judge.problem.vehicle
    default = damper(vehicle.Csy / judge.scale.damper if isinstance(vehicle, PlanView) else 1.0)
    bases = [default, *(c.device for c in known if c.device.order <= order and not c.device.k + c.device.b)]
    devices: list[PortHamiltonian] = []
    if judge.least_damping is None:
        devices += [random_port_hamiltonian(order, rng, 1.0) for _ in range(DRAWN // 2)]
    for coupling in (0.3, 0.1, 0.03, 0.01, 0.001, 0.0):
        devices += [lifted(base, order, rng, coupling) for base in bases for _ in range(DRAWN // 2)]
        candidates = sorted((Candidate(device, fixed) for device in devices), key=judge.value)
        if judge.least_damping is not None:  # well inside: at the sector's edge the first step goes nowhere
            best = judge.value(candidates[0])
            near = [candidate for candidate in candidates if judge.value(candidate) <= best * SLACK]
            candidates = sorted(near, key=judge.spare, reverse=True)
        for candidate in candidates:
            if math.isfinite(judge.measure(candidate)):  # dear where damping has to be kept, so in this order
                return candidate
        devices = []
    return None
