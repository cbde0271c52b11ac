"""The nearest positive-real device: repairs for what misses by rounding or by a little.

- ``parallel``: Y + c with the smallest damper c, which is −min Re Y(jω);
- ``series``: 1/(1/Y + 1/c) with the stiffest damper c;
- ``projection``: poles kept, C and D of the state space changed least,

      minimise ‖ΔC W^½‖² + ΔD²   subject to   [[−AᵀP − PA, Cᵀ − PB], [C − BᵀP, D + Dᵀ]] ⪰ 0,  P ⪰ 0,

  with W the controllability Gramian, so that ‖ΔC W^½‖ is the H2 norm of the change [GrivetTalocia2004]. What the
  solver leaves open, a last and smallest parallel damper closes; the answer is positive real by the exact test.
  Poles on the imaginary axis, 0 and ∞ included, keep what is real and positive of their residues. Lightly undamped
  poles, a little to the right of the axis, are mirrored first, s − p to s + p̄, which leaves |Y(jω)| as it is. A device
  with poles further to the right, or multiple ones on the axis, is not taken for one that misses, and is refused.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import fmpq, fmpq_poly
from numpy.typing import NDArray

from posreal.admittance import (
    AxisPole,
    Device,
    Rational,
    RightHalfPlanePole,
    StateSpace,
    as_rational,
    check,
    is_positive_real,
    roots,
    state_space,
)
from posreal.admittance.exact import rounded, to_float, to_fmpq
from posreal.admittance.rational import S
from posreal.errors import BadInput, Infeasible, listed
from posreal.realisation.lift import smallest_damper, typical_size
from posreal.realisation.multiprecision import Long
from posreal.realisation.preamble import without_resonance
from posreal.realisation.proof import corners

WAYS = ("parallel", "series", "projection")
FAR = 0.1  # of a pole's size: how far to the right of the axis it may be and still be mirrored
DIGITS = 17  # of what a repair adds and of a projection's coefficients: as many as tell floats apart
ROUNDED = 1e-13  # of a device's size: the damper that may make up for coefficients of so many digits
POINTS = 200  # frequencies at which the change is measured


@dataclass(frozen=True)
class Repair:
    """A positive-real device close to one that is not.

    Attributes
    ----------
    device : Rational
        Exactly positive real.
    original : Rational
        What was given.
    way : str
        "parallel", "series" or "projection".
    damper : float or None
        The damper added, N s/m (for a projection, the small one that finishes it; None for none).
    change : float
        The largest |Y_new − Y|/|Y| on the imaginary axis, from two decades under the lowest corner to two
        over the highest.
    mirrored : tuple of complex
        Poles that a projection moved from the right half plane into the left one; one of each pair.
    """

    device: Rational
    original: Rational
    way: str
    damper: float | None
    change: float
    mirrored: tuple[complex, ...] = ()

    def __str__(self) -> str:
        if self.device == self.original:
            return "already positive real; nothing was changed"
        what = {
            "parallel": f"a damper of {self.damper:.6g} N s/m in parallel" if self.damper else "",
            "series": f"a damper of {self.damper:.6g} N s/m in series" if self.damper else "",
            "projection": "the least change of the residues"
            + (f", with a damper of {self.damper:.3g} N s/m in parallel," if self.damper else ""),
        }[self.way]
        if self.mirrored:
            poles = ", ".join(f"{p.real:.3g} ± {p.imag:.3g}j" for p in self.mirrored)
            what = f"mirroring the poles at s = {poles} into the left half plane, and then {what},"
        much = ", which makes it another device" if self.change > 1 else ""
        return f"{what} makes it positive real; the admittance changes by up to {self.change:.2g} of itself{much}"

    def to_dict(self) -> dict[str, Any]:
        """JSON-able form."""
        return {
            "way": self.way,
            "damper": self.damper,
            "relative_change": self.change,
            "mirrored": [{"real": p.real, "imag": p.imag} for p in self.mirrored],
            "rational": self.device.to_dict(),
            "text": str(self),
        }

    def check(self) -> bool:
        """Whether the device is positive real, decided again from scratch."""
        return is_positive_real(self.device)


def nearest_positive_real(device: Device, way: str = "parallel") -> Repair:
    """Repair a device that misses positive real.

    Parameters
    ----------
    device : object
        Anything `as_rational` reads.
    way : str
        "parallel", "series" or "projection"; see the module.

    Raises
    ------
    Infeasible
        If a damper cannot repair it because a pole (for series, a zero) is to blame, or if the device is too far
        from any positive-real one for a projection to mean anything; the text says which.
    BadInput
        For an unknown way.
    """
    y = as_rational(device)
    if way not in WAYS:
        raise BadInput(f"There is no way {way!r} to repair a device; take {listed(WAYS)}.")
    if is_positive_real(y):
        return Repair(y, y, way, None, 0.0)
    if way == "projection":
        return _projected(y)
    side = y if way == "parallel" else y.inverse()
    step = smallest_damper(side)
    if step is None:
        blame = "pole" if way == "parallel" else "zero"
        raise Infeasible(f"No damper in {way} repairs this device, because a {blame} is to blame; try projection.")
    damper = _decimal(step, 1) if way == "parallel" else _decimal(1 / step, -1)
    lifted = side | Rational([damper if way == "parallel" else 1 / damper])
    repaired = lifted if way == "parallel" else lifted.inverse()
    return Repair(repaired, y, way, to_float(damper), relative_change(repaired, y))


def _decimal(value: fmpq, side: int, digits: int = DIGITS) -> fmpq:
    """A decimal of few digits next to the value, no less (`side` 1) or no more (-1) than it."""
    near = rounded(value, digits)
    return near if side * (near - value) >= 0 else rounded(value * (1 + side * fmpq(1, 10 ** (digits - 1))), digits)


def _in_decimals(device: Rational, poles: fmpq_poly) -> Rational:
    """The device with coefficients of few digits over the `poles` that it was to keep, still exactly positive real.

    Where rounding costs that, a damper of rounding's size makes up for it; the device as it is, where none does.
    """
    top = device.n * (poles.leading_coefficient() / device.d.leading_coefficient())
    kept = device.d.degree() == poles.degree()
    short = Rational([rounded(c, DIGITS) for c in top.coeffs()], poles) if kept else device.rounded(DIGITS)
    step = smallest_damper(short)
    if step is None or to_float(step) > ROUNDED * typical_size(device):
        return device
    return short | Rational([_decimal(step, 1, 3)]) if step else short


def relative_change(new: Rational, old: Rational) -> float:
    """The largest |Y_new − Y_old|/|Y_old| on the imaginary axis about the device's corners."""
    s = 1j * np.geomspace(*corners(old), POINTS)
    before, after = np.asarray(old(s)), np.asarray(new(s))
    usable = np.isfinite(before) & (before != 0)
    return float(np.max(np.abs(after[usable] - before[usable]) / np.abs(before[usable])))


def _projected(y: Rational) -> Repair:
    """Least change of C and D at fixed poles, on the device's own scales of time and force."""
    stable, mirrored = _mirrored(y)
    rest, beside = _without_resonances(stable)
    low, high = corners(stable)
    clock, size = float(np.sqrt(low * high)), typical_size(stable)
    form = state_space(rest.time_scaled(to_fmpq(clock)).scaled(1 / to_fmpq(size)))
    C, D = _least_change(form.A, form.B, form.C, form.D)
    ends = Rational([max(form.k, 0.0), 0, max(form.b, 0.0)], [0, 1])
    repaired = (StateSpace(form.A, form.B, C, D).rational() | ends).scaled(to_fmpq(size))
    repaired = repaired.time_scaled(1 / to_fmpq(clock)) | beside
    steps = [(repaired, smallest_damper(repaired)), (stable, smallest_damper(stable))]
    found = [(device if step == 0 else device | Rational([step]), step) for device, step in steps if step is not None]
    if not found:
        raise Infeasible("The projection did not come close to a positive-real device; check the poles and residues.")
    # The smallest damper is a point of the same problem, and the better one where the solver's digits end.
    device, step = min(found, key=lambda pair: relative_change(pair[0], y))
    if device.is_zero():
        raise Infeasible("The nearest positive-real device is none at all, so there is nothing to repair; check signs.")
    device = _in_decimals(device, stable.d)
    return Repair(device, y, "projection", to_float(step) or None, relative_change(device, y), mirrored)


def _mirrored(y: Rational) -> tuple[Rational, tuple[complex, ...]]:
    """The device with poles just right of the axis mirrored, and which they were; Infeasible for hopeless ones."""
    witness = check(y).witness
    if isinstance(witness, AxisPole) and witness.multiplicity > 1:
        raise Infeasible(f"This device has a {witness}, which no small change repairs.")
    if not isinstance(witness, RightHalfPlanePole):
        return y, ()
    at_zero = 1 if y.d[0] == 0 else 0
    poles, bottom = [], y.d.right_shift(at_zero)
    with roots.precision(Long().bits):
        for root, power in roots.complex_roots(y.d):
            if not root.real > 0 or root.imag < 0:
                continue
            if root.real > FAR * abs(root):
                raise Infeasible(
                    f"This device has a {RightHalfPlanePole(complex(root))}, too far from the axis for a least change "
                    "to mean anything; check the signs of the model and the order of its coefficients."
                )
            poles += [complex(root)] * power
            real, size = roots.midpoint(root.real), roots.midpoint(abs(root) ** 2)
            for _ in range(power):
                bottom = bottom // (S * S - 2 * real * S + size) * (S * S + 2 * real * S + size)
    return Rational(y.n, bottom.left_shift(at_zero)), tuple(poles)


def _without_resonances(y: Rational) -> tuple[Rational, Rational]:
    """The device without its poles ±jω on the axis, and what may stay of them beside it."""
    arithmetic, beside = Long(), Rational.zero()
    for pair in arithmetic.axis_pairs(y.d):
        alpha, y = without_resonance(y, pair.x, arithmetic)
        if alpha > 0:
            beside = beside | Rational([0, alpha], [pair.x, 0, 1])
    return y, beside


def _least_change(
    A: NDArray[np.float64], B: NDArray[np.float64], C0: NDArray[np.float64], D0: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    import cvxpy as cp
    from scipy.linalg import cholesky, solve_continuous_lyapunov

    n = len(A)
    if n == 0:
        return C0, np.maximum(D0, 0.0)
    gramian = solve_continuous_lyapunov(A, -B @ B.T)
    gramian = (gramian + gramian.T) / 2 + 1e-13 * np.trace(gramian) * np.eye(n)
    root = cholesky(gramian, lower=True)  # states scaled so that the Gramian is I: well conditioned
    inside = np.linalg.inv(root)
    A, B, C0 = inside @ A @ root, inside @ B, C0 @ root
    P, C, D = cp.Variable((n, n), symmetric=True), cp.Variable((1, n)), cp.Variable((1, 1))
    inequality = cp.bmat([[-A.T @ P - P @ A, C.T - P @ B], [C - B.T @ P, 2 * D]])
    problem = cp.Problem(
        cp.Minimize(cp.sum_squares(C - C0) + cp.sum_squares(D - D0)),
        [P >> 0, (inequality + inequality.T) / 2 >> 0],
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about accuracy; the exact test judges what comes out
        problem.solve(solver=cp.CLARABEL, tol_gap_abs=1e-13, tol_gap_rel=1e-13, tol_feas=1e-13)
    if C.value is None or D.value is None:
        raise Infeasible(f"The projection found no positive-real device ({problem.status}); try a damper.")
    return np.asarray(C.value) @ inside, np.asarray(D.value)
