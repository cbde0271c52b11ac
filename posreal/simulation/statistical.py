"""Coulomb friction in the frequency domain by statistical linearisation [RobertsSpanos1990].

Of all dampers c the one whose force is nearest to F_c sgn v in the mean square, for a Gaussian v of variance σ², is

    c_eq = E[v F_c sgn v]/E[v²] = √(2/π) F_c/σ.

σ is that of the vehicle with these dampers in place, so c_eq is iterated. Of several devices σ² is the mean.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from posreal.admittance import state_space
from posreal.network import Network
from posreal.network.substitution import with_dampers_across
from posreal.plant import quadrature
from posreal.plant.mounting import Copy, Mounting
from posreal.plant.plant import Plant, close
from posreal.simulation.strut import element_velocities

ROUNDS, SETTLED = 200, 1e-6
LOCKED = 1e8  # N s/m: at 10 µm/s a kilonewton; friction that asks for more holds its element still
TOP = 10 * quadrature.BAND  # rad/s, up to which velocities count: 200 Hz


def velocities(
    plant: Plant, mounting: Mounting, network: Network, copies: Sequence[Copy], dampers: Mapping[str, float]
) -> dict[str, float]:
    """R.m.s. velocity (m/s) of every element on random track, with dampers beside some; the mean of all devices."""
    damped = with_dampers_across(network, dampers)
    port = mounting.port(damped.admittance())
    groups = dict.fromkeys(plant.groups, port)
    poles = close(plant, {name: state_space(one) for name, one in groups.items()}, shaped=False).poles()
    if plant.shaping is not None:
        poles = np.concatenate([poles, np.linalg.eigvals(plant.shaping.rational.A)])
    rule = quadrature.placed(poles, float(plant.delays.max(initial=0.0)), 0.0, TOP)
    s = 1j * rule.omega
    open_ports = plant.responses(rule.omega, plant.outputs[0])
    Y, p, shares = np.asarray(port(s)), len(plant.groups), len(plant.shares)
    loop = np.eye(p) + open_ports.Pvf[: len(s)] * Y[:, None, None]
    own = element_velocities_with(network, dampers, s)
    total = np.zeros(len(own))
    count = sum(copy.count for copy in copies)
    for i, share in enumerate(plant.shares):
        v = np.linalg.solve(loop, open_ports.Pvw[i * len(s) : (i + 1) * len(s), :, None])[:, :, 0]
        for copy in copies:
            square = np.abs(v @ np.array(copy.rows)) ** 2 * rule.weight
            total += share * plant.density * copy.count / count * (np.abs(own) ** 2 @ square)
    assert shares
    return dict(zip(network.names, np.sqrt(total).tolist(), strict=True))


def element_velocities_with(network: Network, dampers: Mapping[str, float], s: np.ndarray) -> np.ndarray:
    """Velocity of every element of `network` for one between its terminals, dampers beside some of them: (E, N)."""
    damped = with_dampers_across(network, dampers)
    rows, at = element_velocities(damped, s), 0
    found = []
    for name in network.names:
        found.append(rows[at])
        at += 2 if dampers.get(name) else 1
    return np.array(found)


def equivalent_dampers(
    plant: Plant, mounting: Mounting, network: Network, copies: Sequence[Copy], friction: Mapping[str, float]
) -> dict[str, float]:
    """c_eq (N s/m) of every element that rubs, by name.

    Parameters
    ----------
    plant : Plant
    mounting : Mounting
        What stands beside the strut.
    network : Network
        The strut.
    copies : how devices sit in the ports
    friction : mapping of element to N

    Returns
    -------
    mapping of element to float
        At most :data:`LOCKED`, where friction is so large that the element does not move.
    """
    found = dict.fromkeys(friction, 0.0)
    for _ in range(ROUNDS):
        sigma = velocities(plant, mounting, network, copies, found)
        least = 1e-300
        fresh = {
            name: min(math.sqrt(2 / math.pi) * F / max(sigma[name], least), LOCKED) for name, F in friction.items()
        }
        # the geometric mean with the last: a damper beside an element makes it slower, and c_eq larger
        step = {name: math.sqrt(value * found[name]) if found[name] else value for name, value in fresh.items()}
        if all(abs(step[name] / found[name] - 1) <= SETTLED for name in step if found[name]) and all(found.values()):
            return step
        found = step
    return found
