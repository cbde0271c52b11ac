"""The vehicles written down equation by equation, solved one frequency at a time: slow, plain, and on purpose not the
code under test. Complex amplitudes at s = jω; Y is a function of s."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import simpson

Admittance = Callable[[complex], complex]


def lateral_acceleration(v, Y: Admittance, omega: float, which: str) -> complex:
    """ÿv per unit track *velocity* under the leading ("front") or trailing ("rear") wheelset."""
    s = 1j * omega
    yw1, a1, yw2, a2, yg, ag, yv = range(7)
    D = np.zeros((7, 7), dtype=complex)
    r = np.zeros(7, dtype=complex)
    p = 2 * (v.Kpy + v.Cpy * s)
    px = 2 * v.lx**2 * (v.Kpx + v.Cpx * s)
    sec = 2 * Y(s) * s
    conicity = 2 * v.f11 * v.conicity * v.lwy / v.r0
    for yw, a, arm in ((yw1, a1, v.lwx), (yw2, a2, -v.lwx)):
        # wheelset lateral
        D[yw, yw] += v.mw * s**2 + 2 * v.f22 / v.V * s + p
        D[yw, a] += -2 * v.f22
        D[yw, yg] += -p
        D[yw, ag] += -p * arm
        # wheelset yaw
        D[a, a] += v.Iw * s**2 + 2 * v.f11 * v.lwy**2 / v.V * s + px
        D[a, ag] += -px
        D[a, yw] += conicity
        # bogie
        D[yg, yw] += -p
        D[yg, yg] += p
        D[yg, ag] += p * arm
        D[ag, yw] += -p * arm
        D[ag, yg] += p * arm
        D[ag, ag] += p * arm**2 + px
        D[ag, a] += -px
    D[yg, yg] += v.mg * s**2 + sec
    D[yg, yv] += -sec
    D[ag, ag] += v.Ig * s**2
    D[yv, yv] += v.mv * s**2 + sec
    D[yv, yg] += -sec
    r[a1 if which == "front" else a2] = conicity / s  # track displacement = velocity / s
    return complex(s**2 * np.linalg.solve(D, r)[yv])


def lateral_sum(v, Y: Admittance, omegas: np.ndarray, step: float) -> float:
    """The paper's J1y² sum over the given frequencies."""
    total = 0.0
    for omega in omegas:
        s = 1j * omega
        H = (21.69 * s**2 + 105.6 * s + 14.42) / (s**3 + 30.64 * s**2 + 24.07 * s)
        front = lateral_acceleration(v, Y, omega, "front")
        rear = lateral_acceleration(v, Y, omega, "rear")
        total += abs(front * H + rear * H * np.exp(-s * 2 * v.lwx / v.V)) ** 2
    return step * 2 * math.pi * v.Al * v.V**2 * total


def vertical(v, G0: Admittance, omega: float) -> dict[str, complex]:
    """Accelerations at L, M, T and secondary deflections per unit track velocity δ̇1."""
    s = 1j * omega
    gk = (v.Krz * (v.Ksz + v.Kaz) + v.Ksz * v.Kaz) / v.Crz
    gc, alpha = v.Ksz + v.Kaz, (v.Ksz + v.Krz) / v.Crz
    G2 = (gk / s + gc) / (s + alpha) + G0(s)
    G1 = 2 * v.Kpz / s + 2 * v.Cpz
    z, t, b1, t1, b2, t2 = range(6)
    D = np.zeros((6, 6), dtype=complex)
    r = np.zeros(6, dtype=complex)
    delta = [np.exp(-s * L / v.V) / s for L in (0, 2 * v.lbx, 2 * v.lvx, 2 * (v.lvx + v.lbx))]
    D[z, z] = v.mv * s**2 + 2 * G2 * s
    D[z, b1] = D[z, b2] = -G2 * s
    D[t, t] = v.Iv * s**2 + 2 * v.lvx**2 * G2 * s
    D[t, b1], D[t, b2] = -v.lvx * G2 * s, v.lvx * G2 * s
    for b, tb, sign, da, db in ((b1, t1, 1, delta[0], delta[1]), (b2, t2, -1, delta[2], delta[3])):
        D[b, b] = v.mb * s**2 + 2 * G1 * s + G2 * s
        D[b, z] = -G2 * s
        D[b, t] = -G2 * s * sign * v.lvx
        r[b] = G1 * s * (da + db)
        D[tb, tb] = v.Ib * s**2 + 2 * v.lbx**2 * G1 * s
        r[tb] = v.lbx * G1 * s * (da - db)
    q = np.linalg.solve(D, r)
    front, rear = q[b1] - q[z] - v.lvx * q[t], q[b2] - q[z] + v.lvx * q[t]
    return {
        "acceleration_L": s**2 * (q[z] + v.lvx * q[t]),
        "acceleration_M": s**2 * q[z],
        "acceleration_T": s**2 * (q[z] - v.lvx * q[t]),
        "deflection_front": front,
        "deflection_rear": rear,
        "deflection_velocity_front": s * front,
        "deflection_velocity_rear": s * rear,
    }


def flexible(v, G0: Admittance, omega: float, f1: float, zeta: float, count: int) -> dict[str, complex]:
    """The side view with a body that is a uniform free–free beam, as one system of all its coordinates.

    Accelerations at L, M, T and secondary deflections per unit track velocity. Modes are normalised to 1 in the r.m.s.
    over the length, X²m/L integrated numerically: another scale than the code under test has.
    """
    s, length = 1j * omega, math.sqrt(12 * v.Iv / v.mv)
    x = np.linspace(-length / 2, length / 2, 4001)
    roots = (4.730040744862704, 7.853204624095838, 10.99560783800167, 14.13716549125746)
    places = np.array([v.lvx, -v.lvx, 0.0])
    shapes, modal = [], []
    for n in range(1, count + 1):
        b = roots[n - 1] / length
        if n % 2:
            X = lambda y, b=b: np.cosh(b * length / 2) * np.cos(b * y) + np.cos(b * length / 2) * np.cosh(b * y)  # noqa: E731
        else:
            X = lambda y, b=b: np.sinh(b * length / 2) * np.sin(b * y) + np.sin(b * length / 2) * np.sinh(b * y)  # noqa: E731
        shapes.append(X(places))
        modal.append(v.mv / length * simpson(X(x) ** 2, x=x))
    gk = (v.Krz * (v.Ksz + v.Kaz) + v.Ksz * v.Kaz) / v.Crz
    gc, alpha = v.Ksz + v.Kaz, (v.Ksz + v.Krz) / v.Crz
    G2 = (gk / s + gc) / (s + alpha) + G0(s)
    G1 = 2 * v.Kpz / s + 2 * v.Cpz
    size = 6 + count
    D, r = np.zeros((size, size), dtype=complex), np.zeros(size, dtype=complex)
    D[0, 0], D[1, 1] = v.mv * s**2, v.Iv * s**2
    for n in range(count):
        w = 2 * math.pi * f1 * (roots[n] / roots[0]) ** 2
        D[6 + n, 6 + n] = modal[n] * (s**2 + 2 * zeta * w * s + w**2)
    rows = []
    for place in range(3):  # displacement of the body over each bogie and in the middle
        row = np.zeros(size, dtype=complex)
        row[0], row[1] = 1.0, places[place]
        row[6:] = [shape[place] for shape in shapes]
        rows.append(row)
    delta = [np.exp(-s * L / v.V) / s for L in (0, 2 * v.lbx, 2 * v.lvx, 2 * (v.lvx + v.lbx))]
    for i, (b, da, db) in enumerate(((2, delta[0], delta[1]), (4, delta[2], delta[3]))):
        stretch = -rows[i]
        stretch[b] += 1.0
        D += G2 * s * np.outer(stretch, stretch)
        D[b, b] += v.mb * s**2 + 2 * G1 * s
        D[b + 1, b + 1] += v.Ib * s**2 + 2 * v.lbx**2 * G1 * s
        r[b], r[b + 1] = G1 * s * (da + db), v.lbx * G1 * s * (da - db)
    q = np.linalg.solve(D, r)
    at = [row @ q for row in rows]
    return {
        "acceleration_L": s**2 * at[0],
        "acceleration_M": s**2 * at[2],
        "acceleration_T": s**2 * at[1],
        "deflection_front": q[2] - at[0],
        "deflection_rear": q[4] - at[1],
    }
