"""The figures of the vehicles once more, by a program that shares no line with posreal.

Everything is a rational function with exact coefficients. The equations of motion are solved by determinants over Q[s]
(Bareiss), so a closed loop is its exact characteristic polynomial P = b P₀ + a P₁ with s Y = a/b, and a response is
N/P. FLINT isolates the roots of P in ball arithmetic. With F(s) = Nᵢ(s) Nₖ(−s)/(P(s) P(−s)) in partial fractions,

    ∫₀^∞ Re F(jω) e^{jωΔ} dω = π Σ_{Re p < 0} res_p F · e^{pΔ}                       (whole band)
    ∫₀^Ω e^{jωΔ}/(jω − p) dω = −j e^{pΔ} [E₁(−u₁) − E₁(−u₂)] (+ 2π e^{pΔ} round a pole), u = (jω − p)Δ   (to Ω)

and responses to ramps are Σ N(p)/P'(p) (e^{pt} − 1 − pt)/p². No quadrature, no Lyapunov equation, no eigenvalue: a
resonance is as good as any other however sharp it is. Precision is doubled until the balls say that 12 digits are
right. Only the sum of [Jiang2012] for J1y is in floating point, since it is defined as one: Δω Σ over ω = 0.01, 0.02, …
with P in factors, so that it is right near its roots.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cache, cached_property, lru_cache

import numpy as np
from flint import acb, arb, ctx, fmpq, fmpq_mat, fmpq_poly

Polynomial = fmpq_poly
S = fmpq_poly([0, 1])
DIGITS = 1e-12
TRACK = ([14.42, 105.6, 21.69], [24.07, 30.64, 1.0])  # of s H(s): [Jiang2012]'s track filter without its integrator
CORNERS = {"curve": ((0, Fraction(1, 3)), (3, Fraction(-1, 3))), "slope": ((0, Fraction(2, 5)), (1, Fraction(-2, 5)))}

PLAN_VIEW = {
    "mw": 1376.0, "Iw": 766.0, "mg": 3477.0, "Ig": 3200.0, "mv": 17230.0, "r0": 0.445, "conicity": 0.3, "f11": 1e7,
    "f22": 1e7, "lwx": 1.225, "lwy": 0.75, "lx": 1.2, "Kpx": 3.766e7, "Cpx": 1.017e4, "Kpy": 4.71e6, "Cpy": 1.2e4,
    "Ksy": 2.45e5, "Csy": 2e4, "R": 1000.0, "cant": 6 * math.pi / 180, "g": 9.8, "Al": 1.886e-9, "V": 55.0,
}  # fmt: skip
SIDE_VIEW = {
    "mv": 38000.0, "mb": 2500.0, "Iv": 2.31e6, "Ib": 1500.0, "lvx": 9.5, "lbx": 1.25, "Kaz": 0.0, "Ksz": 1.016e6,
    "Krz": 0.508e6, "Crz": 64.11e3, "Kpz": 4.935e6, "Cpz": 50.74e3, "bush": 5e6, "g": 9.8, "Av": 2.5e-7, "V": 55.0,
}  # fmt: skip
QUARTER_CAR = {"ms": 250.0, "mu": 35.0, "kt": 150e3, "k": 60e3, "kappa": 5e-7, "V": 25.0}


class NotStable(Exception):
    """A root of the exact characteristic polynomial has no negative real part."""


def exact(value: float | int | str | Fraction) -> fmpq:
    """The number itself: a float is the binary fraction that it is, a text the decimal that it says."""
    ratio = Fraction(value)
    return fmpq(ratio.numerator, ratio.denominator)


def polynomial(coefficients: Iterable[float | int | str | Fraction]) -> Polynomial:
    """From coefficients of ascending powers."""
    return fmpq_poly([exact(c) for c in coefficients])


# --- devices -------------------------------------------------------------------------------------------------


Device = tuple[Polynomial, Polynomial]
"""Y = numerator/denominator, coprime."""


def fraction(numerator: Polynomial, denominator: Polynomial) -> Device:
    """In lowest terms."""
    common = numerator.gcd(denominator)
    return (numerator // common, denominator // common) if common.degree() > 0 else (numerator, denominator)


def element(letter: str, value: float | int | str | Fraction) -> Device:
    """k/s, c or b s."""
    constant = polynomial([value])
    return {"k": (constant, S), "c": (constant, S**0), "b": (constant * S, S**0)}[letter]


def parallel(*parts: Device) -> Device:
    """Admittances add."""
    total = parts[0]
    for n, d in parts[1:]:
        total = fraction(total[0] * d + n * total[1], total[1] * d)
    return total


def series(*parts: Device) -> Device:
    """Impedances add; an end that carries no force makes the whole nothing."""
    if any(n == 0 for n, _ in parts):
        return fmpq_poly([0]), fmpq_poly([1])
    n, d = parallel(*((d, n) for n, d in parts))
    return d, n


def stiffness_form(device: Device) -> Device:
    """s Y = a/b, which has no pole at 0."""
    return fraction(S * device[0], device[1])


# --- closed loops --------------------------------------------------------------------------------------------


def settled(compute: Callable[[], arb], scale: float = 0.0) -> float:
    """The value of a ball, at the precision that makes it 12 digits of itself (or of `scale`)."""
    for bits in (128, 256, 512, 1024, 2048, 4096, 8192, 16384):
        with ctx.workprec(bits):
            ball = compute()
            middle = float(ball.mid())
            if math.isfinite(middle) and float(ball.rad()) <= DIGITS * max(abs(middle), scale):
                return middle
    raise ArithmeticError(f"16384 bits do not settle {ball}")


def even_part(N: Polynomial) -> Polynomial:
    """N(s) N(−s) as a polynomial in x = −s² = ω²."""
    product = N * N(-S)
    return fmpq_poly([(-1) ** i * c for i, c in enumerate(product.coeffs()[::2])])


class Loop:
    """What all responses of a closed vehicle share: the polynomial P, its roots, and integrals at them."""

    def __init__(self, *factors: Polynomial) -> None:
        P = fmpq_poly([1])
        for factor in factors:
            P = P * (factor // P.gcd(factor))
        self.exact = P
        if P.gcd(P.derivative()).degree() > 0:  # roots that coincide: moved apart, 90 digits down
            P = fmpq_poly([c * (1 + fmpq(i * i + 1, 2**300)) for i, c in enumerate(P.coeffs())])
        self.P = P / P.leading_coefficient()
        self._roots: dict[int, list[acb]] = {}
        self._integrals: dict[tuple[int, int, int, Fraction], acb] = {}

    @property
    def roots(self) -> list[acb]:
        """At the precision of the moment."""
        if ctx.prec not in self._roots:
            self._roots[ctx.prec] = [root for root, _ in self.P.complex_roots()]
        return self._roots[ctx.prec]

    @cached_property
    def poles(self) -> np.ndarray:
        """Rounded, each part to its last bit."""
        even, odd = fmpq_poly(self.exact.coeffs()[::2]), fmpq_poly(self.exact.coeffs()[1::2])
        on_axis = even.gcd(odd).degree() > 0 and any(
            r.imag == 0 and not r.real > 0 for r, _ in even.gcd(odd).complex_roots()
        )
        if on_axis:
            raise NotStable("a pole on the imaginary axis")
        for bits in (128, 256, 512, 1024, 2048, 4096, 8192):
            with ctx.workprec(bits):
                sharp = all(float(r.real.rad()) <= 1e-16 * abs(float(r.real.mid())) for r in self.roots)
                if sharp:
                    return np.array([complex(float(r.real.mid()), float(r.imag.mid())) for r in self.roots])
        raise NotStable("a real part that 8192 bits cannot tell from 0")

    def require_stable(self) -> float:
        """The slowest decay as a share of the fastest pole."""
        if not len(self.poles):
            return 1.0
        worst = self.poles[int(np.argmax(self.poles.real))]
        if worst.real >= 0:
            raise NotStable(f"a pole at {worst:.6g}")
        return -worst.real / float(np.abs(self.poles).max())

    # --- mean squares ------------------------------------------------------------------------------------------

    def mean_square(self, numerators: Sequence[Polynomial], delays: Sequence[Fraction], band: int | None) -> float:
        """∫₀^Ω |Σᵢ Nᵢ/P e^{−jωτᵢ}|² dω with Ω = `band` times π rad/s, or without end."""
        scaled = [N / self.exact.leading_coefficient() for N in numerators]
        if band is None and any(N.degree() >= self.P.degree() for N in scaled):
            return math.inf
        return settled(lambda: self._mean_square(scaled, delays, band))

    def _mean_square(self, numerators: Sequence[Polynomial], delays: Sequence[Fraction], band: int | None) -> arb:
        # a pair in both orders is twice the real part; equal delays are put together first
        merged: dict[Fraction, Polynomial] = {}
        for N, delay in zip(numerators, delays, strict=True):
            merged[delay] = merged.get(delay, fmpq_poly([0])) + N
        slope = self.P.derivative()
        at = [[value_at(f, p) for p in self.roots] for f in (slope, self.P(-S))]
        values = {delay: [(value_at(N, p), value_at(N, -p)) for p in self.roots] for delay, N in merged.items()}
        through = {delay: leading(N, self.P.degree()) for delay, N in merged.items()}
        total = arb(0)
        for early, late in itertools.combinations_with_replacement(sorted(merged), 2):
            delta, weight = late - early, 1 if early == late else 2
            for k, p in enumerate(self.roots):
                (first, mirrored_first), (second, mirrored_second) = values[early][k], values[late][k]
                residue = first * mirrored_second / (at[0][k] * at[1][k])
                if band is None:
                    total += weight * (residue * acb(ball(delta) * p).exp()).real * arb.pi()
                    continue
                mirrored = -mirrored_first * second / (at[0][k] * at[1][k])
                total += weight * (residue * self._integral(k, 1, delta, band)).real
                total += weight * (mirrored * self._integral(k, -1, delta, band)).real
            if band is not None and through[early] * through[late] != 0:
                top = band * arb.pi()
                flat = top if delta == 0 else (top * ball(delta)).sin() / ball(delta)
                total += weight * ball(through[early] * through[late]) * flat
        return total

    def _integral(self, k: int, sign: int, delta: Fraction, band: int) -> acb:
        """∫₀^Ω e^{jωΔ}/(jω − p) dω for p = ± a root of P."""
        key = (ctx.prec, sign * (k + 1), band, delta)
        if key not in self._integrals:
            self._integrals[key] = pole_integral(sign * self.roots[k], band * arb.pi(), ball(delta))
        return self._integrals[key]

    # --- largest gain --------------------------------------------------------------------------------------------

    def gain(self, numerators: Sequence[Polynomial]) -> float:
        """√ of the largest Σ |N/P|² over ω: at a root of its derivative, which is a polynomial in ω², at 0 or at ∞."""
        top = sum((even_part(N) for N in numerators), fmpq_poly([0]))
        bottom = even_part(self.exact)
        common = top.gcd(bottom)
        top, bottom = top // common, bottom // common
        slope = top.derivative() * bottom - top * bottom.derivative()
        if bottom[0] == 0:
            return math.inf
        found = [float_of(top[0] / bottom[0])]
        if top.degree() == bottom.degree():
            found.append(float_of(top.leading_coefficient() / bottom.leading_coefficient()))
        if slope != 0:
            slope = slope // slope.gcd(slope.derivative())
            with ctx.workprec(256):
                count = [root.real > 0 and root.imag == 0 for root, _ in slope.complex_roots()]
            found += [
                settled(
                    lambda i=i: (lambda x: value_at(top, x) / value_at(bottom, x))(slope.complex_roots()[i][0]).real
                )
                for i, wanted in enumerate(count)
                if wanted
            ]
        return math.sqrt(max(found))

    # --- peaks in time -------------------------------------------------------------------------------------------

    def peak(
        self,
        numerators: Sequence[Polynomial],
        delays: Sequence[Fraction],
        corners: Sequence[tuple[int, Fraction]],
        stop: float | None = None,
    ) -> float:
        """Largest |response| to Σ change · max(0, t − instant) in every channel, from rest, over t ≥ 0 or to `stop`."""
        with ctx.workprec(256):
            terms = []  # (instant, factor of ramp response of channel)
            for N, delay in zip(numerators, delays, strict=True):
                terms += [
                    (Fraction(instant) + delay, change, N / self.exact.leading_coefficient())
                    for instant, change in corners
                ]
            slope = self.P.derivative()
            residue = {id(N): [value_at(N, p) / value_at(slope, p) for p in self.roots] for _, _, N in terms}
            begins = np.array([float(t) for t, _, _ in terms])
            change = np.array([float(c) for _, c, _ in terms])
            r = np.array([[to_complex(x) for x in residue[id(N)]] for _, _, N in terms])
        p = self.poles

        def response(time: np.ndarray) -> np.ndarray:
            z = np.zeros(len(time))
            for begin, factor, gain in zip(begins, change, r, strict=True):
                t = np.maximum(time - begin, 0.0)
                z += factor * (ramp(np.multiply.outer(t, p)) @ gain).real * t**2
            return z

        def sharply(time: float) -> float:
            def compute() -> arb:
                total = acb(0)
                for begin, factor, N in terms:
                    t = ball(Fraction(time) - begin)
                    if Fraction(time) > begin:
                        for root in self.roots:
                            change_of = value_at(N, root) / value_at(slope, root)
                            total += ball(factor) * change_of * ((root * t).exp() - 1 - root * t) / root**2
                return total.real

            return settled(compute, 1e-9)

        # c + Σ aₖ e^{pₖ t} once all corners are past: where this stays below the largest so far, none is missed
        last = float(begins.max())
        amplitude = np.abs((change[:, None] * r * np.exp(-np.outer(begins - last, p))).sum(axis=0) / p**2)
        rest = sum(
            c * float_of(first_order(N, self.P)) - c * b * float_of(N[0] / self.P[0])
            for b, c, N in zip(begins, change, (N for _, _, N in terms), strict=True)
        )
        relevant = amplitude > 1e-10 * (np.abs(rest) + amplitude.max())
        step = min(0.01, 0.2 / max(1.0, float(np.abs(p.imag[relevant]).max(initial=1.0))))
        best, when, start = abs(rest) if stop is None else 0.0, math.inf, 0.0
        end = 8.0 if stop is None else stop
        for _ in range(200):
            time = np.linspace(start, end, max(200, min(100_000, math.ceil((end - start) / step))))
            z = np.abs(response(time))
            for i in np.argsort(-z)[:200]:
                if z[i] < 0.98 * z.max() or not (z[max(i - 1, 0)] <= z[i] >= z[min(i + 1, len(z) - 1)]):
                    continue
                low, high = time[max(i - 1, 0)], time[min(i + 1, len(time) - 1)]
                for _ in range(4):
                    fine = np.linspace(low, high, 41)
                    values = np.abs(response(fine))
                    j = int(np.argmax(values))
                    low, high = fine[max(j - 1, 0)], fine[min(j + 1, 40)]
                if values[j] > best * (1 + 1e-12):
                    best, when = float(values[j]), float(fine[j])
            remaining = abs(rest) + float((amplitude * np.exp(p.real * (end - last))).sum())
            if stop is not None or remaining <= best * (1 + 1e-9) or (remaining - abs(rest)) <= 1e-9 * best:
                break
            start, end = end, end + 20_000 * step
        return best if math.isinf(when) else abs(sharply(when))


def ramp(x: np.ndarray) -> np.ndarray:
    """(e^x − 1 − x)/x², by its series where x is small."""
    small = np.abs(x) < 0.1
    safe = np.where(small, 1.0, x)
    found = (np.exp(safe) - 1.0 - safe) / safe**2
    found[small] = np.polyval([1 / math.factorial(i + 2) for i in reversed(range(10))], x[small])
    return found


def first_order(N: Polynomial, P: Polynomial) -> fmpq:
    """c₁ of N/P = c₀ + c₁ s + …"""
    c0 = N[0] / P[0]
    return (N[1] - c0 * P[1]) / P[0]


def pole_integral(p: acb, top: arb, delta: arb) -> acb:
    """∫₀^top e^{jωΔ}/(jω − p) dω; Re p ≠ 0."""
    j = acb(0, 1)
    begin, end = -p, j * top - p
    if delta == 0:
        # the segment is vertical and passes right of 0 (Re p < 0) or left of it; turn the cut of the logarithm away
        turn = 1 if p.real < 0 else -1
        return -j * ((turn * end).log() - (turn * begin).log())
    u1, u2 = begin * delta, end * delta
    if p.imag == 0 and p.real < 0:
        first = acb(-u1.real.ei(), arb.pi())  # E₁ below its cut
        round_pole = acb(0)
    else:
        first = e1(-u1)
        inside = p.real < 0 and p.imag > 0 and p.imag < top
        round_pole = 2 * arb.pi() * j if inside else acb(0)
    return -j * (p * delta).exp() * (first - e1(-u2) + round_pole)


def e1(z: acb) -> acb:
    return acb(1).expint(z) if _EXPINT_ORDER_FIRST else z.expint(acb(1))


with ctx.workprec(64):
    _EXPINT_ORDER_FIRST = bool(abs(acb(1).expint(acb(2)).real - arb("0.0489005107080611")) < 1e-9)


def ball(value: Fraction | fmpq) -> arb:
    return arb(value if isinstance(value, fmpq) else exact(value))


def to_complex(value: acb) -> complex:
    return complex(float(value.real.mid()), float(value.imag.mid()))


def value_at(f: Polynomial, x: acb) -> acb:
    total = acb(0)
    for c in reversed(f.coeffs()):
        total = total * x + c
    return total


def leading(N: Polynomial, degree: int) -> fmpq:
    return N[degree] if N.degree() == degree else fmpq(0)


# --- quarter-car -----------------------------------------------------------------------------------------------


def quarter_car(device: Device, vehicle: Mapping[str, float] = QUARTER_CAR, gains: bool = False) -> dict[str, float]:
    """J1, J3 over all frequencies; SI units."""
    v = {name: exact(value) for name, value in vehicle.items()}
    ms, mu, kt = v["ms"], v["mu"], v["kt"]
    a, b = stiffness_form(parallel(element("k", Fraction(vehicle["k"])), device))
    loop = Loop(b * (mu * S**2 + kt) * ms * S**2 + a * ((ms + mu) * S**2 + kt))
    decay = loop.require_stable()
    outputs = {"acceleration": S * a * kt, "tyre_force": -kt * S * (mu * ms * S**2 * b + a * (ms + mu))}
    density = 4 * math.pi * vehicle["V"] * vehicle["kappa"]
    zero = Fraction(0)
    found = {
        name: math.sqrt(density * loop.mean_square([outputs[output]], [zero], None))
        for name, output in (("J1", "acceleration"), ("J3", "tyre_force"))
    }
    if gains:
        found |= {f"gain_{name}": loop.gain([N]) for name, N in outputs.items()}
    return found | {"static_stiffness": static_stiffness(a, b), "decay": decay}


def static_stiffness(a: Polynomial, b: Polynomial) -> float:
    return float_of(a[0] / b[0])


# --- side view -------------------------------------------------------------------------------------------------


def side_view(
    device: Device | None,
    vehicle: Mapping[str, float] = SIDE_VIEW,
    until: float | None = None,
) -> dict[str, float]:
    """J1z at L, M, T (%g), secondary deflections (mm), r.m.s. to 20 Hz and over all; the device behind its bush.

    With the sums and differences of the bogies the body's bounce and pitch obey the same two equations,
    J s² ψ = y (z − ψ) and mb s² z = g₁ (δ − 2 z) − y (z − ψ), with J = mv/2 and Iv/(2 lvx²), y = s G₂, g₁ = s G₁.
    """
    v = {name: exact(value) for name, value in vehicle.items()}
    gk = (v["Krz"] * (v["Ksz"] + v["Kaz"]) + v["Ksz"] * v["Kaz"]) / v["Crz"]
    gc, alpha = v["Ksz"] + v["Kaz"], (v["Ksz"] + v["Krz"]) / v["Crz"]
    port = (fmpq_poly([gk, gc]), fmpq_poly([0, alpha, 1]))
    if device is not None:
        port = parallel(port, series(element("k", Fraction(vehicle["bush"])), device))
    a, b = stiffness_form(port)
    g1 = fmpq_poly([2 * v["Kpz"], 2 * v["Cpz"]])
    inertia = {"bounce": v["mv"] / 2, "pitch": v["Iv"] / (2 * v["lvx"] ** 2)}
    P = {
        name: b * J * S**2 * (v["mb"] * S**2 + 2 * g1) + a * (J * S**2 + v["mb"] * S**2 + 2 * g1)
        for name, J in inertia.items()
    }
    loop = Loop(*P.values())
    Loop(v["Ib"] * S**2 + 2 * v["lbx"] ** 2 * g1).require_stable()
    decay = loop.require_stable()
    to_common = {name: loop.exact // P[name] for name in P}
    acceleration = {name: S * a * g1 * to_common[name] / 2 for name in P}
    deflection = {name: J * S * g1 * b * to_common[name] / 2 for name, J in inertia.items()}
    lbx, lvx, V = (Fraction(vehicle[name]) for name in ("lbx", "lvx", "V"))
    delays = [Fraction(0), 2 * lbx / V, 2 * lvx / V, 2 * (lvx + lbx) / V]

    def channels(of: dict[str, Polynomial], pitch: int) -> list[Polynomial]:
        front, rear = of["bounce"] + pitch * of["pitch"], of["bounce"] - pitch * of["pitch"]
        return [front, front, rear, rear]

    density = math.pi * vehicle["Av"] * vehicle["V"]
    found = {}
    for position, pitch in (("L", 1), ("M", 0), ("T", -1)):
        for suffix, band in (("", 40), ("_whole", None)):
            square = loop.mean_square(channels(acceleration, pitch), delays, band)
            found[f"J1z_{position}{suffix}"] = 100 * math.sqrt(density * square) / vehicle["g"]
    for end, pitch in (("front", 1), ("rear", -1)):
        numerators = channels(deflection, pitch)
        top = 1e3 * loop.peak(numerators, delays, CORNERS["slope"], until)
        spread, beyond = (1e3 * math.sqrt(density * loop.mean_square(numerators, delays, band)) for band in (40, None))
        found |= {
            f"deflection_rms_{end}_whole": beyond,
            f"deflection_{end}": top,
            f"deflection_rms_{end}": spread,
            f"deflection_overall_{end}": top + 3 * spread,
        }
    return found | {"static_stiffness": static_stiffness(a, b), "decay": decay}


# --- plan view -------------------------------------------------------------------------------------------------


def determinant(matrix: Sequence[Sequence[Polynomial]]) -> Polynomial:
    """Bareiss: every division is exact."""
    rows, sign, before = [list(row) for row in matrix], 1, fmpq_poly([1])
    n = len(rows)
    for k in range(n - 1):
        pivot = next((i for i in range(k, n) if rows[i][k] != 0), None)
        if pivot is None:
            return fmpq_poly([0])
        if pivot != k:
            rows[k], rows[pivot], sign = rows[pivot], rows[k], -sign
        for i in range(k + 1, n):
            for j in range(k + 1, n):
                rows[i][j] = (rows[k][k] * rows[i][j] - rows[i][k] * rows[k][j]) // before
        before = rows[k][k]
    return sign * rows[-1][-1]


@lru_cache(maxsize=256)
def _plan_view(items: tuple[tuple[str, float], ...]) -> dict[str, tuple[Polynomial, Polynomial]]:
    """Determinant and Cramer numerators of yv as f₀ + y f₁ in y = s Y, at one speed."""
    raw = dict(items)
    v = {name: exact(value) for name, value in raw.items()}
    yw1, a1, yw2, a2, yg, ag, yv = range(7)
    conicity = 2 * v["f11"] * v["conicity"] * v["lwy"] / v["r0"]

    def matrix(y: int) -> list[list[Polynomial]]:
        D = [[fmpq_poly([0])] * 7 for _ in range(7)]

        def spring(shape: dict[int, fmpq | int], dynamic: Polynomial) -> None:
            for i, j in itertools.product(shape, shape):
                D[i][j] += shape[i] * shape[j] * dynamic

        for mass, i in zip(("mw", "Iw", "mw", "Iw", "mg", "Ig", "mv"), range(7), strict=True):
            D[i][i] += v[mass] * S**2
        for yw, a, arm in ((yw1, a1, v["lwx"]), (yw2, a2, -v["lwx"])):
            spring({yw: 1, yg: -1, ag: -arm}, 2 * fmpq_poly([v["Kpy"], v["Cpy"]]))
            spring({a: 1, ag: -1}, 2 * v["lx"] ** 2 * fmpq_poly([v["Kpx"], v["Cpx"]]))
            D[yw][yw] += 2 * v["f22"] / v["V"] * S
            D[yw][a] -= 2 * v["f22"]
            D[a][a] += 2 * v["f11"] * v["lwy"] ** 2 / v["V"] * S
            D[a][yw] += conicity
        spring({yg: 1, yv: -1}, fmpq_poly([2 * y]))
        return D

    side = v["V"] ** 2 / v["R"] - v["g"] * v["cant"]
    turn = 2 * v["f11"] * v["lwy"] ** 2 / v["R"]
    body = {yg: v["mg"] * side / 2, yv: v["mv"] * side / 2}
    loads = {
        "track_front": {a1: conicity},
        "track_rear": {a2: conicity},
        "curve_front": {yw1: v["mw"] * side, a1: turn, **body},
        "curve_rear": {yw2: v["mw"] * side, a2: turn, **body},
    }
    found = {}
    for name, load in [("P", None), *loads.items()]:
        values = []
        for y in (0, 1):
            D = matrix(y)
            if load is not None:
                for i in range(7):
                    D[i][yv] = fmpq_poly([load.get(i, 0)])
            values.append(determinant(D))
        found[name] = (values[0], values[1] - values[0])
    return found


def _plan_view_loop(vehicle: Mapping[str, float], a: Polynomial, b: Polynomial) -> tuple[Loop, dict[str, Polynomial]]:
    parts = _plan_view(tuple(sorted(vehicle.items())))
    closed = {name: b * f0 + a * f1 for name, (f0, f1) in parts.items()}
    return Loop(closed["P"]), closed


OMEGA = 0.01 * np.arange(1, math.floor(40 * math.pi / 0.01) + 1)


def lateral_sum(
    loop: Loop, closed: Mapping[str, Polynomial], a: Polynomial, b: Polynomial, vehicle: Mapping[str, float]
) -> float:
    """J1y: the sum of [Jiang2012], term by term."""
    s = 1j * OMEGA
    parts = _plan_view(tuple(sorted(vehicle.items())))
    # numerator and denominator of the device in factors too: near its own resonances they nearly vanish
    factors = [in_factors(f, s) for f in (a, b)]
    sides = []
    for name in ("track_front", "track_rear"):
        f0, f1 = (np.polyval([float_of(c) for c in reversed(f.coeffs())] or [0.0], s) for f in parts[name])
        sides.append(factors[1] * f0 + factors[0] * f1)
    P = float_of(loop.exact.leading_coefficient()) * np.prod(s[:, None] - loop.poles, axis=1)
    filtered = np.polyval(TRACK[0][::-1], s) / np.polyval(TRACK[1][::-1], s)
    z = (sides[0] + sides[1] * np.exp(-s * 2 * vehicle["lwx"] / vehicle["V"])) * filtered / P
    return math.sqrt(0.01 * 2 * math.pi * vehicle["Al"] * vehicle["V"] ** 2 * float((np.abs(z) ** 2).sum()))


def lateral_whole(closed: Mapping[str, Polynomial], vehicle: Mapping[str, float]) -> float:
    """J1y over all frequencies."""
    over, under = (polynomial(map(str, coefficients)) for coefficients in TRACK)
    loop = Loop(closed["P"] * under)
    tops = [closed[name] * over for name in ("track_front", "track_rear")]
    delays = [Fraction(0), 2 * Fraction(vehicle["lwx"]) / Fraction(vehicle["V"])]
    return math.sqrt(2 * math.pi * vehicle["Al"] * vehicle["V"] ** 2 * loop.mean_square(tops, delays, None))


def in_factors(f: Polynomial, s: np.ndarray) -> np.ndarray:
    value = np.full(len(s), complex(float_of(f.leading_coefficient())))
    with ctx.workprec(128):
        for root, times in f.complex_roots() if f.degree() > 0 else ():
            value *= (s - to_complex(root)) ** times
    return value


def float_of(value: fmpq) -> float:
    return float(Fraction(int(value.p), int(value.q)))


def plan_view(device: Device, vehicle: Mapping[str, float] = PLAN_VIEW, until: float | None = None) -> dict[str, float]:
    """Macc and J1y (m/s²), Ldmp (%) over 1, 2, … 55 m/s, the peak on entering the curve (mm), the device beside Ksy."""
    a, b = stiffness_form(parallel(element("k", Fraction(vehicle["Ksy"])), device))
    speeds = [{**vehicle, "V": float(V)} for V in range(1, 56)]
    loops = [_plan_view_loop(at, a, b) for at in speeds]
    here, closed = _plan_view_loop(vehicle, a, b)
    decay = min(loop.require_stable() for loop in [here, *(loop for loop, _ in loops)])
    damping = [float((-loop.poles.real / np.abs(loop.poles)).min()) for loop, _ in loops]
    sums = [lateral_sum(loop, parts, a, b, at) for (loop, parts), at in zip(loops, speeds, strict=True)]
    delays = [Fraction(0), 2 * Fraction(vehicle["lwx"]) / Fraction(vehicle["V"])]
    top = here.peak([closed["curve_front"], closed["curve_rear"]], delays, CORNERS["curve"], until)
    return {
        "Macc": max(sums),
        "Macc speed": float(1 + int(np.argmax(sums))),
        "J1y": lateral_sum(here, closed, a, b, vehicle),
        "J1y_whole": lateral_whole(closed, vehicle),
        "Macc_whole": max(lateral_whole(parts, at) for (_, parts), at in zip(loops[::9], speeds[::9], strict=True)),
        "Ldmp": 100 * min(damping),
        "max_yv": 1e3 * top,
        "decay": decay,
        "static_stiffness": static_stiffness(a, b),
    }


# --- plants of one's own ---------------------------------------------------------------------------------------


def own_plant(
    matrices: Sequence[np.ndarray],
    device: Device,
    *,
    processes: Sequence[Sequence[tuple[int, float]]],
    densities: Sequence[float],
    force: int,
    velocity: int,
    outputs: Sequence[int],
    gains: bool = False,
) -> dict[int, tuple[float, float | None]]:
    """R.m.s. (and largest gain) of every output of ẋ = A x + B u, y = C x + D u with u[force] = Y y[velocity].

    Parameters
    ----------
    matrices : A, B, C, D, every entry taken as the exact fraction that the float is
    processes : for each white process its inputs and their delays in s
    densities : single-sided, per rad/s, of each
    """
    A, B, C, D = (fmpq_mat([[exact(float(x)) for x in row] for row in np.atleast_2d(m).tolist()]) for m in matrices)
    open_loop = A.charpoly()

    @cache
    def transfer(i: int, j: int) -> Polynomial:
        """Numerator of y_i/u_j: c adj(sI − A) b = det(sI − A + b c) − det(sI − A)."""
        n = A.nrows()
        outer = fmpq_mat(n, n, [B[k, j] * C[i, m] for k in range(n) for m in range(n)])
        return (A - outer).charpoly() - open_loop + D[i, j] * open_loop

    a, b = device
    loop_gain = transfer(velocity, force)
    P = b * open_loop - a * loop_gain
    hidden = fmpq_poly([1])
    if (
        b[0] == 0 and loop_gain[0] == 0
    ):  # a spring in the device and a velocity that is a rate of change: one state too many
        hidden = S
        P = P // S
    loop = Loop(P)
    loop.require_stable()
    found = {}
    for z in outputs:
        square, each = 0.0, []
        for inputs, density in zip(processes, densities, strict=True):
            numerators = []
            for j, _ in inputs:
                crossed = transfer(z, force) * transfer(velocity, j) - transfer(z, j) * loop_gain
                numerators.append((b * transfer(z, j) + a * (crossed // open_loop)) // hidden)
            square += density * loop.mean_square(numerators, [Fraction(t) for _, t in inputs], None)
            each += numerators
        found[z] = (math.sqrt(square), loop.gain(each) if gains else None)
    return found


def plan_view_at(device: Device, vehicle: Mapping[str, float], *, whole: bool = False) -> float:
    """J1y at the vehicle's own speed, to 20 Hz or over all frequencies."""
    a, b = stiffness_form(parallel(element("k", Fraction(vehicle["Ksy"])), device))
    loop, closed = _plan_view_loop(vehicle, a, b)
    return lateral_whole(closed, vehicle) if whole else lateral_sum(loop, closed, a, b, vehicle)
