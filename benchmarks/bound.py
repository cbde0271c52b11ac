"""The bound on J1 of the quarter-car: along the central path, and by the semidefinite program written down in cvxpy.

    minimise ‖τ + O x‖²   subject to   [[4I + 2 X W + 2 (X W)ᵀ, X R], [Rᵀ Xᵀ, I]] ⪰ 0,   R Rᵀ = I − W Wᵀ

cvxpy's value is a solver's word; the certificate's is proven, and the time of its proof is shown too. A second table
has the vehicles' figures by the forms side by side: lifted or plain, points repeated at three places; and by values at
distinct points.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import cvxpy as cp
import numpy as np

from posreal.bounds.compute import bound
from posreal.bounds.figure import enclosed, figure
from posreal.bounds.objectives import Squares
from posreal.bounds.one_passive_port import solve
from posreal.bounds.points import PLAIN, VALUE, certify, choose_form, cycled, size_for
from posreal.bounds.sampled import Sampled
from posreal.specification.named import problem

SIZES = (10, 20, 40, 60)
LARGEST_NAIVE = 40
FIGURES: tuple[tuple[str, dict[str, str]], ...] = (
    ("quarter-car", {}),
    ("lateral-comfort", {}),
    ("vertical-comfort", {"position": "M"}),
    ("vertical-comfort", {"position": "L"}),
    ("vertical-comfort", {"position": "T"}),
)


def naive(data: Sampled) -> float:
    """The program as one would write it down."""
    W, F, m = data.W[0], data.F, len(data.F)
    values, vectors = np.linalg.eigh(np.eye(m) - W @ W.T)
    R = vectors * np.sqrt(np.clip(values, 0.0, None))
    x = cp.Variable(m)
    X = sum(x[k] * F[k] for k in range(m))
    block = cp.bmat([[4 * np.eye(m) + 2 * X @ W + 2 * (X @ W).T, X @ R], [(X @ R).T, np.eye(m)]])
    residual = data.tau.ravel() + data.O[0].reshape(-1, m) @ x
    posed = cp.Problem(cp.Minimize(cp.sum_squares(residual)), [block >> 0])
    return float(np.sqrt(posed.solve(solver=cp.CLARABEL)))


def timed(work: Callable[[], float]) -> tuple[float, float]:
    """Value and seconds of one run."""
    begun = time.perf_counter()
    value = work()
    return value, time.perf_counter() - begun


def main() -> None:
    """Both ways must agree to 1e-4 where both get through."""
    about = figure(problem("quarter-car"))
    print(f"{'L':>4} {'bound':>12} {'path, s':>9} {'proof, s':>9} {'cvxpy, s':>9} {'ratio':>7}")
    for L in SIZES:
        points = cycled([20.0], L + 1)
        certificate = certify(about, PLAIN, points)
        data = Sampled.of(enclosed(about, points, certificate.damper))

        def path(data: Sampled = data) -> float:
            return solve(data, Squares(data)).value

        value, seconds = timed(path)
        proof, checking = timed(lambda: certificate.lower_bound(about))  # noqa: B023
        assert abs(proof - value) < 1e-6 * value
        row = f"{L:>4} {proof:>12.8f} {seconds:>9.3f} {checking:>9.3f}"
        if L <= LARGEST_NAIVE:
            try:
                other, slow = timed(lambda: naive(data))  # noqa: B023
            except cp.error.SolverError:
                row += "     fails"
            else:
                assert abs(other - value) < 1e-4 * value
                row += f" {slow:>9.2f} {slow / seconds:>6.0f}×"
        print(row)
    compare_forms()


def compare_forms() -> None:
    """Proven value and seconds of processor time, from nothing to proof, old form and value form."""
    print(
        f"\n{'figure':>26} {'old form':>10} {'points':>7} {'proven':>11} {'s':>7} {'points':>7} {'values':>11} {'s':>7}"
    )
    for name, options in FIGURES:
        posed = problem(name, **options)
        about = figure(posed)
        old = choose_form(about, "auto", places=True)
        row = f"{name + ' ' + options.get('position', ''):>26} {old:>10}"
        for form in (old, VALUE):
            begun = time.process_time()
            found = bound(posed, form=form)
            row += f" {size_for(about, form, 1):>7} {found.value:>11.6f} {time.process_time() - begun:>7.1f}"
        print(row, flush=True)
