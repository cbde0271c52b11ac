"""Where local searches begin: faces of the set of devices of an order, random devices, and lower orders lifted.

A device of order n is a proper one with n states, or has a pole at 0 or at infinity in place of a state. These faces
are limits of proper devices (a state that becomes infinitely slow or fast), and a search that has to go there crawls;
a search that begins on the face is there already. Best devices are often on one: an inerter at the device's end.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import cycle, product

import numpy as np

from posreal.admittance import PortHamiltonian, random_port_hamiltonian
from posreal.optimisation.coordinates import Chart

Real = np.ndarray

LOSSES = ((0.0, 0.0), (-1.0, 0.25))  # range of powers of ten on their damping: resonant devices in the second
DECADES = (1.0, 3.0)  # spread of the time scales of random devices
FAST = 300.0  # rate, in ω0, of a state that stands for one at infinity; 1/FAST for one at 0
RESONANCES = (-0.25, 1.25)  # powers of ten of ω0


def faces(order: int, *, spring: bool, inerter: bool) -> tuple[Chart, ...]:
    """Charts that together hold all devices of an order; `spring` and `inerter` come on top of it if asked for."""
    if (spring and inerter) or order == 0:
        return (Chart(order, spring, inerter),)
    found = [Chart(order, spring, inerter)]
    if not spring:
        found.append(Chart(order - 1, True, inerter))
    if not inerter:
        found.append(Chart(order - 1, spring, True))
    if not spring and not inerter and order >= 2:
        found.append(Chart(order - 2, True, True))
    return tuple(found)


def random_starts(charts: tuple[Chart, ...], rng: np.random.Generator) -> Iterator[tuple[Chart, PortHamiltonian]]:
    """Random devices on every face in turn, without end; every second round with other losses."""
    for losses, decades in cycle(product(LOSSES, DECADES)):
        for chart in charts:
            device = random_port_hamiltonian(chart.order, rng, decades)
            L = device.L * 10 ** rng.uniform(*losses)
            yield chart, PortHamiltonian(device.J, device.G, L, 1.0 * chart.spring, 1.0 * chart.inerter)


def lifted(device: PortHamiltonian, order: int, rng: np.random.Generator, coupling: float = 0.1) -> PortHamiltonian:
    """The device with as many more states, each weakly coupled to the rest and to the port."""
    n, m = order, device.order
    rates = 10.0 ** rng.uniform(-1, 1, n - m)
    J, G, L = np.zeros((n, n)), np.zeros((n, 1)), np.zeros((n + 1, max(device.L.shape[1], 1) + n - m))
    J[:m, :m], G[:m] = (device.J - device.J.T) / 2, device.G
    L[:m, : device.L.shape[1]], L[n, : device.L.shape[1]] = device.L[:m], device.L[m]
    new = np.arange(m, n)
    L[new, L.shape[1] - (n - m) + np.arange(n - m)] = np.sqrt(rates)
    G[new, 0] = coupling * np.sqrt(rates) * rng.standard_normal(n - m)
    J[m:, :m] = coupling * rng.standard_normal((n - m, m))
    J[:m, m:] = -J[m:, :m].T
    return PortHamiltonian(J, G, L, device.k, device.b)


def inside(device: PortHamiltonian, chart: Chart) -> PortHamiltonian:
    """A device on a face as one with all its states proper: k/s as k/(s + ε), b·s as bp s/(s + p)."""
    slow, fast = [], []
    if device.k and not chart.spring:
        slow, device = [device.k], PortHamiltonian(device.J, device.G, device.L, 0.0, device.b)
    if device.b and not chart.inerter:
        fast, device = [device.b], PortHamiltonian(device.J, device.G, device.L, device.k, 0.0)
    n, m, wide = device.order + len(slow) + len(fast), device.order, device.L.shape[1]
    J, G, L = np.zeros((n, n)), np.zeros((n, 1)), np.zeros((n + 1, wide + n - m))
    J[:m, :m], G[:m] = device.J, device.G
    L[:m, :wide], L[n, :wide] = device.L[:m], device.L[m]
    for k in slow:
        G[m, 0], L[m, wide] = np.sqrt(k), np.sqrt(1 / FAST)
    for b in fast:
        L[n - 1, -1], L[n, -1] = np.sqrt(FAST), -np.sqrt(b * FAST)
    return PortHamiltonian(J, G, L, device.k, device.b)


def shaken(chart: Chart, device: PortHamiltonian, rng: np.random.Generator, strength: float = 0.4) -> PortHamiltonian:
    """A device with every number of its chart multiplied by a random factor and moved a little."""
    theta = chart.vector(device)
    factor = np.exp(strength * rng.standard_normal(len(theta)))
    return chart.device(theta * factor + 0.1 * strength * rng.standard_normal(len(theta)))


def resonant(
    device: PortHamiltonian, order: int, rng: np.random.Generator, band: tuple[float, float] = RESONANCES
) -> PortHamiltonian:
    """The device with resonators beside it or in series with its damper, up to an order.

        beside:     J = [[0, −ω], [ω, 0]],  R = diag(2ζω, 0),  G = (√(2ζω g), 0):   adds 2ζω g s/(s² + 2ζω s + ω²)
        in series:  the column of L that holds √S goes on as √(2ζω) in the state:   S → S (s² + ω²)/(s² + 2ζω s + ω²)

    Vehicles that hunt or bounce at a frequency ask for a device that is stiff there, or soft; states coupled weakly at
    random rates (:func:`lifted`) rarely become one. If an odd state is left over, it is such a one. Their frequencies
    are in `band`, powers of ten of ω0.
    """
    if (order - device.order) % 2:
        device = lifted(device, device.order + 1, rng)
    n, m = order, device.order
    wide = device.L.shape[1]
    J, G, L = np.zeros((n, n)), np.zeros((n, 1)), np.zeros((n + 1, wide + n - m))
    J[:m, :m], G[:m] = (device.J - device.J.T) / 2, device.G
    L[:m, :wide], L[n, :wide] = device.L[:m], device.L[m]
    direct = int(np.argmax(np.abs(L[n])))
    for i in range(m, n, 2):
        omega, zeta, gain = 10.0 ** rng.uniform((band[0], -1.5, -1.5), (band[1], 0.5, 0.5))
        J[i, i + 1], J[i + 1, i] = -omega, omega
        if rng.random() < 0.5:
            L[i, direct] = np.sqrt(2 * zeta * omega)
            L[i, wide + i - m] = 0.1
        else:
            L[i, wide + i - m] = np.sqrt(2 * zeta * omega)
            G[i, 0] = np.sqrt(2 * zeta * omega * gain)
        L[i + 1, wide + i + 1 - m] = 0.01
    return PortHamiltonian(J, G, L, device.k, device.b)
