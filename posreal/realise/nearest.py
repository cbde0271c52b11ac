"""The nearest positive-real device: repairs for what misses by rounding or by a little.

- ``parallel``: Y + c with the smallest damper c, which is −min Re Y(jω);
- ``series``: 1/(1/Y + 1/c) with the stiffest damper c;
- ``projection``: poles kept (those in the right half plane mirrored), C and D of the state space changed least,

      minimise ‖ΔC W^½‖² + ΔD²   subject to   [[−AᵀP − PA, Cᵀ − PB], [C − BᵀP, D + Dᵀ]] ⪰ 0,  P ⪰ 0,

  with W the controllability Gramian, so that ‖ΔC W^½‖ is the H2 norm of the change [GrivetTalocia2004]. What the
  solver leaves open, a last and smallest parallel damper closes; the answer is positive real by the exact test.

[GrivetTalocia2004] S. Grivet-Talocia, Passivity enforcement via perturbation of Hamiltonian matrices, IEEE Trans.
Circuits and Systems I 51 (2004) 1755–1769.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from flint import fmpq
from numpy.typing import NDArray

from posreal.admittance import Device, Rational, StateSpace, as_rational, is_positive_real, state_space
from posreal.admittance.exact import to_float, to_fmpq
from posreal.errors import BadInput, Infeasible, listed
from posreal.realise.lift import smallest_damper, typical_size
from posreal.realise.proof import corners

WAYS = ("parallel", "series", "projection")
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
    """

    device: Rational
    original: Rational
    way: str
    damper: float | None
    change: float

    def __str__(self) -> str:
        if self.device == self.original:
            return "already positive real; nothing was changed"
        what = {
            "parallel": f"a damper of {self.damper:.6g} N s/m in parallel" if self.damper else "",
            "series": f"a damper of {self.damper:.6g} N s/m in series" if self.damper else "",
            "projection": "the least change of the residues"
            + (f", with a damper of {self.damper:.3g} N s/m in parallel," if self.damper else ""),
        }[self.way]
        return f"{what} makes it positive real; the admittance changes by up to {self.change:.2g} of itself"

    def to_dict(self) -> dict[str, Any]:
        """JSON-able form."""
        return {
            "way": self.way,
            "damper": self.damper,
            "relative_change": self.change,
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
        If a damper cannot repair it because a pole (for series, a zero) is to blame; the text says what can.
    BadInput
        For an unknown way.
    """
    y = as_rational(device)
    if way not in WAYS:
        raise BadInput(f"There is no way {way!r} to repair a device; take {listed(WAYS)}.")
    if is_positive_real(y):
        return Repair(y, y, way, None, 0.0)
    if way == "projection":
        repaired, damper = _projected(y)
        step = smallest_damper(y)  # a point of the same problem, and better where the solver's digits end
        if step is not None and relative_change(y | Rational([step]), y) < relative_change(repaired, y):
            repaired, damper = y | Rational([step]), to_float(step)
    else:
        side = y if way == "parallel" else y.inverse()
        step = smallest_damper(side)
        if step is None:
            blame = "pole" if way == "parallel" else "zero"
            raise Infeasible(f"No damper in {way} repairs this device, because a {blame} is to blame; try projection.")
        lifted = side | Rational([step])
        repaired = lifted if way == "parallel" else lifted.inverse()
        damper = to_float(step if way == "parallel" else 1 / step)
    return Repair(repaired, y, way, damper, relative_change(repaired, y))


def relative_change(new: Rational, old: Rational) -> float:
    """The largest |Y_new − Y_old|/|Y_old| on the imaginary axis about the device's corners."""
    s = 1j * np.geomspace(*corners(old), POINTS)
    before, after = np.asarray(old(s)), np.asarray(new(s))
    usable = np.isfinite(before) & (before != 0)
    return float(np.max(np.abs(after[usable] - before[usable]) / np.abs(before[usable])))


def _projected(y: Rational) -> tuple[Rational, float | None]:
    """Least change of C and D at fixed poles, on the device's own scales of time and force."""
    low, high = corners(y)
    clock, size = float(np.sqrt(low * high)), typical_size(y)
    excess = y.n.degree() - y.d.degree()
    if excess > 1 or (y.d[0] == 0 and y.d[1] == 0):
        raise Infeasible("This device has a multiple pole at 0 or infinity, which no small change repairs.")
    form = state_space(y.time_scaled(to_fmpq(clock)).scaled(1 / to_fmpq(size)))
    A = _stable(form.A)
    C, D = _least_change(A, form.B, form.C, form.D)
    beside = Rational([max(form.k, 0.0), 0, max(form.b, 0.0)], [0, 1])
    repaired = (StateSpace(A, form.B, C, D).rational() | beside).scaled(to_fmpq(size))
    repaired = repaired.time_scaled(1 / to_fmpq(clock))
    step = fmpq(0) if is_positive_real(repaired) else smallest_damper(repaired)
    if step is None:
        raise Infeasible("The projection did not come close to a positive-real device; check the poles and residues.")
    if step == 0:
        return repaired, None
    return repaired | Rational([step]), to_float(step)


def _stable(A: NDArray[np.float64]) -> NDArray[np.float64]:
    """Poles mirrored into the left half plane; those on the axis are put a little to the left of it."""
    poles = np.linalg.eigvals(A)
    if np.all(poles.real < -1e-12 * np.abs(poles)):
        return A
    from scipy.linalg import schur

    T, Z = schur(A, output="complex")
    values = np.diag(T)
    moved = -np.maximum(np.abs(values.real), 1e-9 * np.maximum(np.abs(values), 1e-9)) + 1j * values.imag
    return np.real(Z @ (T + np.diag(moved - values)) @ Z.conj().T)


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
