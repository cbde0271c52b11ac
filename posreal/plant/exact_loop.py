"""A closed loop over the rationals, for what floats cannot decide.

Every float of the plant and every coefficient of a device is a rational number, so the closed loop's transfer functions

    zᵢ(s) = Nᵢ(s)/D(s),     D = det(sI − A),     Nᵢ = det(sI − A + Bᵢ C) − D + dᵢ D

are polynomials without any error, and modes that an output does not see, or that cancel, leave them by a greatest
common divisor. Mean squares follow in two ways that share no formula, both in ball arithmetic, so that the digits they
have are proven:

- over all frequencies, with N_i(s) N_j(−s) = X(s) D(−s) + (…) D(s): the autocorrelation at Δ is the impulse response of
  X/D, by the exponential of D's companion matrix; and by residues at isolated roots of D;
- on a band, by residues and exponential integrals; and by the sum of a quadrature rule without rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from flint import acb, acb_poly, arb, arb_mat, fmpq, fmpq_mat, fmpq_poly
from scipy.optimize import minimize_scalar

from posreal.admittance import Rational, exact, roots
from posreal.errors import Unsettled
from posreal.plant.modes import Corners, Modes
from posreal.plant.plant import Plant, Real, channels

_FIRST, _LAST = 192, 3072  # bits tried
_DIGITS = 1e-12  # relative radius of a ball that is fine enough
_LOOKS = 3  # points of a grid beside which the largest gain is looked for


@dataclass(frozen=True)
class Transfer:
    """One output of a closed loop: for each process the numerators of its channels, over one denominator.

    Attributes
    ----------
    denominator : fmpq_poly
        Coprime to the numerators' common divisor: hidden and cancelling modes are gone.
    numerators : tuple over processes of tuples of (fmpq_poly, delay in s)
        Channels of equal delay are added up.
    weights : density of each process, per rad/s
    """

    denominator: fmpq_poly
    numerators: tuple[tuple[tuple[fmpq_poly, float], ...], ...]
    weights: tuple[float, ...]

    @cached_property
    def stable(self) -> bool:
        """Whether every mode that the output sees decays."""
        return roots.is_hurwitz(self.denominator)

    def decays(self, share: float) -> bool:
        """Whether every mode that the output sees decays, none more slowly than `share` of the fastest pole."""
        if not self.stable:
            return False
        with roots.precision(_FIRST):
            poles = [complex(pole.real.mid(), pole.imag.mid()) for pole in self.poles()]
        return not poles or min(-pole.real for pole in poles) > share * max(abs(pole) for pole in poles)

    @property
    def strictly_proper(self) -> bool:
        """Whether white noise does not pass straight through."""
        degree = self.denominator.degree()
        return all(top.degree() < degree for driven in self.numerators for top, _ in driven)

    def poles(self) -> list[acb]:
        """The poles as balls, at the precision in force."""
        return [root for root, _ in roots.complex_roots(self.denominator)]

    def modes(self, output: str) -> Modes:
        """The sum over modes, whose floats have all their digits however far apart the modes are; simple poles.

        Raises
        ------
        Unsettled
            If poles are double.
        """
        D, slope = self.denominator, self.denominator.derivative()
        degree = D.degree()
        if D.gcd(slope).degree() > 0:
            raise Unsettled("a double pole has no residue")
        late: list[float] = []
        processes, residues, direct = [], [], []
        with roots.precision(2 * _FIRST):
            poles = self.poles()
            below = [roots.value(slope, pole) for pole in poles]
            for driven in self.numerators:
                processes.append(tuple(range(len(late), len(late) + len(driven))))
                for top, delay in driven:
                    late.append(delay)
                    direct.append(exact.to_float(top[degree] / D[degree]))
                    residues.append(
                        [complex((roots.value(top, p) / b).mid()) for p, b in zip(poles, below, strict=True)]
                    )
            floats = [complex(pole.mid()) for pole in poles]
        return Modes(
            np.array(floats, dtype=complex),
            np.array(residues, dtype=complex).reshape(1, len(late), len(floats)),
            np.array(direct)[None, :],
            np.array(late),
            (output,),
            tuple(processes),
            self.weights,
        )

    # --- over all frequencies ----------------------------------------------------------------------------------

    def mean_square(self) -> float:
        """∫₀^∞ Σ |z|² S dω by autocorrelations: exact polynomials and the exponential of a companion matrix."""
        return _settled(self._by_correlation)

    def mean_square_by_residues(self) -> float:
        """The same by residues at the poles."""
        return _settled(self._by_residues)

    def _by_correlation(self) -> arb:
        D = self.denominator
        mirrored = exact.at_minus_s(D)
        inverse = _inverse(mirrored, D)
        total = arb(0)
        for weight, driven in zip(self.weights, self.numerators, strict=True):
            for i, (top, early) in enumerate(driven):
                for k, (other, late) in enumerate(driven):
                    if late < early or (late == early and k < i):
                        continue
                    X = (top * exact.at_minus_s(other) * inverse) % D
                    term = _impulse(X, D, exact.to_fmpq(late) - exact.to_fmpq(early))
                    total += arb(exact.to_fmpq(weight)) * (term if i == k else 2 * term)
        return arb.pi() * total

    def _by_residues(self) -> arb:
        D = self.denominator
        slope, mirrored = D.derivative(), exact.at_minus_s(D)
        total = acb(0)
        for pole in self.poles():
            at = acb(0)
            for weight, driven in zip(self.weights, self.numerators, strict=True):
                here = [roots.value(top, pole) for top, _ in driven]
                there = [roots.value(top, -pole) for top, _ in driven]
                for i, (_, early) in enumerate(driven):
                    for k, (_, late) in enumerate(driven):
                        if late < early or (late == early and k < i):
                            continue
                        ahead = (pole * acb(exact.to_fmpq(late) - exact.to_fmpq(early))).exp()
                        term = here[i] * there[k] * ahead
                        at += acb(exact.to_fmpq(weight)) * (term if i == k else 2 * term)
            total += at / (roots.value(slope, pole) * roots.value(mirrored, pole))
        return arb.pi() * total.real

    # --- on a band ----------------------------------------------------------------------------------------------

    def band_mean_square(self, start: float, stop: float) -> float:
        """∫ Σ |z|² S dω from `start` to `stop` (rad/s) by residues and exponential integrals; simple poles."""
        return _settled(lambda: self._by_exponential_integrals(start, stop))

    def _by_exponential_integrals(self, start: float, stop: float) -> arb:
        D = self.denominator
        slope, mirrored = D.derivative(), exact.at_minus_s(D)
        degree = D.degree()
        direct = [[top[degree] / D[degree] for top, _ in driven] for driven in self.numerators]
        j, total = acb(0, 1), arb(0)
        for weight, driven, passed in zip(self.weights, self.numerators, direct, strict=True):
            for (top, early), d in zip(driven, passed, strict=True):
                for (other, later), e in zip(driven, passed, strict=True):
                    late = exact.to_fmpq(early) - exact.to_fmpq(later)
                    part = acb(0)
                    for pole in self.poles():
                        residue = roots.value(top, pole) / roots.value(slope, pole)
                        there = roots.value(exact.at_minus_s(other), pole) / roots.value(mirrored, pole)
                        part += residue * there * _exponential_integral(pole, late, start, stop, j)
                    straight = (
                        d * e * (fmpq(1) if late == 0 else fmpq(0)) * (exact.to_fmpq(stop) - exact.to_fmpq(start))
                    )
                    if late != 0 and d * e != 0:
                        turn = arb(late)
                        wave = (
                            (arb(exact.to_fmpq(stop)) * turn).sin() - (arb(exact.to_fmpq(start)) * turn).sin()
                        ) / turn
                        part += acb(d * e) * acb(wave) / 2
                    total += arb(exact.to_fmpq(weight)) * (2 * part.real + arb(straight))
        return total

    # --- at points ----------------------------------------------------------------------------------------------

    def weighted_sum(self, omega: Real, weight: Real) -> float:
        """Σ |z|² S weight over the points `omega` (rad/s): the sum of a quadrature rule without rounding."""

        def attempt() -> arb:
            bottom, tops = acb_poly(self.denominator), self._numerators()
            total = arb(0)
            for point, part in zip(omega.tolist(), weight.tolist(), strict=True):
                total += arb(part) * self._square(acb(0, point), bottom, tops, self.weights)
            return total

        return _settled(attempt)

    def gain(self, omega: float) -> float:
        """The largest singular value at one frequency, rad/s; densities do not enter."""

        def attempt() -> arb:
            ones = (1.0,) * len(self.weights)
            return self._square(acb(0, omega), acb_poly(self.denominator), self._numerators(), ones).sqrt()

        return _settled(attempt)

    def largest_gain(self) -> tuple[float, float]:
        """The largest gain without delays and its frequency, rad/s: where its derivative in ω² vanishes, at 0 or at ∞.

        Raises
        ------
        Unsettled
            With channels of several delays: the gain is no fraction then.
        """
        if any(len(driven) != 1 for driven in self.numerators):
            raise Unsettled("with several delays the largest gain has no polynomial")
        N = sum((_square_in_x(driven[0][0]) for driven in self.numerators), fmpq_poly([0]))
        D = _square_in_x(self.denominator)
        found = [(exact.to_float(N[0] / D[0]), 0.0)]
        if N.degree() == D.degree():
            found.append((exact.to_float(N.leading_coefficient() / D.leading_coefficient()), math.inf))
        slope = N.derivative() * D - N * D.derivative()
        if slope != 0:
            with roots.precision(2 * _FIRST):
                for x, _ in roots.positive_roots(slope):
                    ball = roots.value(N, x) / roots.value(D, x)
                    found.append((float(ball.mid()), math.sqrt(float(x.mid()))))
        square, omega = max(found)
        return math.sqrt(square), omega

    def largest_gain_on(self, omega: Real) -> tuple[float, float]:
        """The largest gain found on a grid (rad/s) and beside its best points, exact at each; and its frequency."""
        gains = np.array([self.gain(point) for point in omega.tolist()])
        best = (float(gains.max()), float(omega[int(gains.argmax())]))
        for i in np.argsort(-gains)[:_LOOKS]:
            low, high = np.log(omega[max(i - 1, 0)]), np.log(omega[min(i + 1, len(omega) - 1)])
            found = minimize_scalar(
                lambda x: -self.gain(math.exp(x)), bounds=(low, high), method="bounded", options={"xatol": 1e-10}
            )
            best = max(best, (-float(found.fun), math.exp(found.x)))
        return best

    def _numerators(self) -> list[list[tuple[acb_poly, acb]]]:
        return [[(acb_poly(top), acb(exact.to_fmpq(late))) for top, late in driven] for driven in self.numerators]

    @staticmethod
    def _square(s: acb, bottom: acb_poly, tops: list[list[tuple[acb_poly, acb]]], weights: tuple[float, ...]) -> arb:
        """Σ S |z|² over the processes."""
        below, total = bottom(s), arb(0)
        for weight, driven in zip(weights, tops, strict=True):
            z = acb(0)
            for top, late in driven:
                z += top(s) * (-s * late).exp()
            z /= below
            total += arb(weight) * (z.real * z.real + z.imag * z.imag)
        return total

    def ramp(self, time: float, corners: Corners) -> float:
        """Response at `time` (s) to w(t) = Σ change · max(0, t − instant) in every channel, by residues."""
        D = self.denominator
        slope = D.derivative()

        def attempt() -> arb:
            poles, total = self.poles(), arb(0)
            apart = [roots.value(slope, pole) * pole * pole for pole in poles]
            for top, late, instant, change in self._ramps(corners):
                t = exact.to_fmpq(time) - exact.to_fmpq(instant) - exact.to_fmpq(late)
                if t > 0:
                    static, drift = top[0] / D[0], (top[1] * D[0] - top[0] * D[1]) / (D[0] * D[0])
                    value = arb(static * t + drift)
                    for pole, below in zip(poles, apart, strict=True):
                        value += (roots.value(top, pole) / below * (pole * acb(t)).exp()).real
                    total += arb(change) * value
            return total

        return _settled(attempt, absolute=1e-15)

    def ramp_by_exponential(self, time: float, corners: Corners) -> float:
        """The same by the exponential of the companion matrix, for poles that are not simple."""
        D = self.denominator * fmpq_poly([0, 0, 1])

        def attempt() -> arb:
            total = arb(0)
            for top, late, instant, change in self._ramps(corners):
                t = exact.to_fmpq(time) - exact.to_fmpq(instant) - exact.to_fmpq(late)
                if t > 0:
                    total += arb(change) * _impulse(top, D, t)
            return total

        return _settled(attempt, absolute=1e-15)

    def _ramps(self, corners: Corners) -> Iterator[tuple[fmpq_poly, float, float, float]]:
        for driven in self.numerators:
            for top, late in driven:
                for instant, change in corners:
                    yield top, late, instant, change


def _square_in_x(p: fmpq_poly) -> fmpq_poly:
    """|p(jω)|² as a polynomial in x = ω²."""
    return exact.at_minus_s(exact.even_part(p * exact.at_minus_s(p)))


def transfer(plant: Plant, devices: Mapping[str, Rational], output: str) -> Transfer:
    """The exact transfer functions from every channel to `output`, devices in place and shaping filter included.

    Of a sampled density the square root is left out: no fraction has it.
    """
    A, B, C, D = _closed(plant, devices, plant.output(output))
    denominator = A.charpoly()
    n = A.nrows()
    before = fmpq_poly([1]), fmpq_poly([1])
    if plant.shaping is not None and (H := plant.shaping.filter) is not None:
        before = exact.transfer_function(
            exact.matrix(H.A), exact.matrix(H.B), exact.matrix(H.C), exact.to_fmpq(float(H.D[0, 0]))
        )
    processes = []
    for driven in channels(plant):
        merged: dict[float, fmpq_poly] = {}
        for i in driven:
            column = fmpq_mat(n, 1, [B[row, i] for row in range(n)])
            top = (A - column * C).charpoly() - denominator + D[0, i] * denominator
            late = float(plant.delays[i])
            merged[late] = merged.get(late, fmpq_poly([0])) + top * before[0]
        processes.append(tuple((top, late) for late, top in merged.items()))
    bottom = denominator * before[1]
    common = bottom
    for merged_channels in processes:
        for top, _ in merged_channels:
            common = common.gcd(top) if top != 0 else common
    return Transfer(
        bottom // common,
        tuple(tuple((top // common, late) for top, late in driven) for driven in processes),
        tuple(plant.density * share for share in plant.shares),
    )


def least_damping(plant: Plant, devices: Mapping[str, Rational]) -> float:
    """The least −Re p/|p| over the poles of the closed loop without its shaping filter, from isolated roots."""
    characteristic = _closed(plant, devices, 0)[0].charpoly()

    def attempt() -> arb:
        ratios = [-root.real / abs(root) for root, _ in roots.complex_roots(characteristic) if root != 0]
        return min(ratios, key=lambda ratio: float(ratio.mid()))

    return _settled(attempt)


def _closed(plant: Plant, devices: Mapping[str, Rational], j: int) -> tuple[fmpq_mat, fmpq_mat, fmpq_mat, fmpq_mat]:
    """A, B, C, D of output j over the rationals, devices in controllable form."""
    n, m = plant.Bw.shape
    parts = [_companion(devices[group]) for group in plant.groups]
    ports = len(parts)
    orders = [len(part.row) for part in parts]
    starts = [n + sum(orders[:p]) for p in range(ports)]
    total = n + sum(orders)
    Ap, Bw, Bf = exact.matrix(plant.A), exact.matrix(plant.Bw), _matrix(plant.Bf, n, ports)
    Cd, Cv = _matrix(plant.Cd, ports, n), _matrix(plant.Cv, ports, n)
    CvA, CvB = Cv * Ap, Cv * Bw
    loop = Cv * Bf
    left = fmpq_mat(ports, ports, [(p == q) - parts[p].b * loop[p, q] for p in range(ports) for q in range(ports)])
    Fx, Fw = fmpq_mat(ports, total), fmpq_mat(ports, m)
    for p, part in enumerate(parts):
        for i in range(n):
            Fx[p, i] = part.k * Cd[p, i] + part.d * Cv[p, i] + part.b * CvA[p, i]
        for i, value in enumerate(part.row):
            Fx[p, starts[p] + i] = value
        for i in range(m):
            Fw[p, i] = part.b * CvB[p, i]
    if ports:
        Fx, Fw = left.solve(Fx), left.solve(Fw)
    A, B, C = fmpq_mat(total, total), fmpq_mat(total, m), fmpq_mat(1, total)
    force, force_w = Bf * Fx, Bf * Fw
    Cz, Dzf, Dzw = exact.matrix(plant.Cz[j : j + 1]), _matrix(plant.Dzf[j : j + 1], 1, ports), plant.Dzw[j]
    seen, seen_w = Dzf * Fx, Dzf * Fw
    for i in range(n):
        for k in range(total):
            A[i, k] = force[i, k] + (Ap[i, k] if k < n else 0)
        for k in range(m):
            B[i, k] = Bw[i, k] + force_w[i, k]
    for k in range(total):
        C[0, k] = seen[0, k] + (Cz[0, k] if k < n else 0)
    for p, part in enumerate(parts):
        order = orders[p]
        for i in range(order):
            for k in range(order):
                A[starts[p] + i, starts[p] + k] = part.A[i, k]
        if order:
            for k in range(n):
                A[starts[p] + order - 1, k] = Cv[p, k]
    D = fmpq_mat(1, m, [exact.to_fmpq(float(Dzw[k])) + seen_w[0, k] for k in range(m)])
    return A, B, C, D


@dataclass(frozen=True)
class _Part:
    """A device as k d + row·ξ + D v + b v̇, ξ̇ = A ξ + e_n v."""

    k: fmpq
    b: fmpq
    d: fmpq
    A: fmpq_mat
    row: list[fmpq]


def _companion(device: Rational) -> _Part:
    k, b = exact.to_fmpq(device.static_stiffness), exact.to_fmpq(device.inertance)
    rest = device.without(Rational([k], [0, 1])).without(Rational([0, b]))
    order = rest.d.degree()
    lead = rest.d.leading_coefficient()
    d = rest.n[order] / lead if rest.n.degree() == order else fmpq(0)
    strict = rest.n - d * rest.d
    A = fmpq_mat(order, order)
    for i in range(order):
        if i + 1 < order:
            A[i, i + 1] = 1
        else:
            for column in range(order):
                A[i, column] = -rest.d[column] / lead
    return _Part(k, b, d, A, [strict[i] / lead for i in range(order)])


def _matrix(entries: np.ndarray, rows: int, columns: int) -> fmpq_mat:
    return exact.matrix(entries) if rows and columns else fmpq_mat(rows, columns)


def _inverse(p: fmpq_poly, modulus: fmpq_poly) -> fmpq_poly:
    """1/p modulo a coprime polynomial."""
    divisor, inverse, _ = p.xgcd(modulus)
    return inverse / divisor[0]


def _impulse(top: fmpq_poly, bottom: fmpq_poly, time: fmpq) -> arb:
    """Impulse response of top/bottom (strictly proper) at `time` ≥ 0 s, in units that make the companion tame."""
    n = bottom.degree()
    lead = bottom.leading_coefficient()
    if time == 0:
        return arb(top[n - 1] / lead)
    # s = σ p makes the companion's entries of a size
    size = max((abs(float(bottom[i] / lead)) ** (1 / (n - i)) for i in range(n) if bottom[i] != 0), default=1.0)
    scale = exact.to_fmpq(2.0 ** round(math.log2(size)))
    A = arb_mat(n, n)
    for i in range(n - 1):
        A[i, i + 1] = arb(scale * time)
    for i in range(n):
        A[n - 1, i] = arb(-bottom[i] / lead * scale ** (i - n) * scale * time)
    column = A.exp() * arb_mat(n, 1, [arb(i == n - 1) for i in range(n)])
    value = arb(0)
    for i in range(n):
        value += arb(top[i] / lead * scale ** (i - n)) * column[i, 0]
    return value * arb(scale)


def _cosine(late: arb, start: float, stop: float) -> arb:
    """∫ cos ωΔ dω from `start` to `stop`."""
    return arb(stop) - arb(start) if late == 0 else ((stop * late).sin() - (start * late).sin()) / late


def _exponential_integral(pole: acb, late: fmpq, start: float, stop: float, j: acb) -> acb:
    """∫ e^{−jωΔ}/(jω − λ) dω from `start` to `stop`."""
    if late == 0:
        return -j * ((j * acb(stop) - pole).log() - (j * acb(start) - pole).log())
    if late > 0:
        ends = [((j * acb(omega) - pole) * acb(late)).expint(1) for omega in (start, stop)]
        return -j * (-pole * acb(late)).exp() * (ends[0] - ends[1])
    # Re (jω − λ)Δ < 0: Ei avoids the cut of E₁ but for the sign of its imaginary part, which the crossing settles
    z = [(j * acb(omega) - pole) * acb(late) for omega in (start, stop)]
    e = [_exp1_from_below(part) if not (part.imag > 0) else part.expint(1) for part in z]
    crossed = z[0].imag > 0 and not (z[1].imag > 0)
    jump = 2 * acb.pi() * acb(0, 1) if crossed else acb(0)
    return -j * (-pole * acb(late)).exp() * (e[0] - e[1] + jump)


def _exp1_from_below(z: acb) -> acb:
    """E₁(z) for Re z < 0, Im z ≤ 0: −Ei(−z) + iπ, continuous on the cut."""
    return -(-z).ei() + acb(0, 1) * acb.pi()


def _settled(attempt: Callable[[], arb], absolute: float = 0.0) -> float:
    """The value of a ball that is fine enough, at as many bits as it takes.

    Raises
    ------
    Unsettled
        If the highest precision leaves it open.
    """
    bits = _FIRST
    while bits <= _LAST:
        with roots.precision(bits):
            ball = attempt()
            middle, radius = float(ball.mid()), float(ball.rad())
            if math.isfinite(middle) and radius <= max(_DIGITS * abs(middle), absolute):
                return middle
        bits *= 2
    raise Unsettled(f"a figure is still open with {_LAST} bits; the vehicle or the device is degenerate")
