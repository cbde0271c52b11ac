"""Time to within 0.1 % of the best known J1 of the quarter-car: the combination, and three plainer ways, in one run.

    minimise J1 over positive-real devices of order 2, k = 60 kN/m: 1.542673 is the best known

- plain alternation: with X fixed the inequalities are linear in the device, with the device fixed X is Lyapunov's;
- path following [HassibiHowBoyd1999], each step written in cvxpy anew and solved by Clarabel, without the second-order
  term and the faces of :mod:`posreal.synthesis.path_following`;
- differential evolution of scipy over the same port-Hamiltonian parametrisation.

All four measure a device by the same figure, so the times differ by what they do between measurements. A way that does
not get there within `LIMIT` seconds is shown with how near it came.

[HassibiHowBoyd1999] A. Hassibi, J. How, S. Boyd, "A path-following method for solving BMI problems in control",
American Control Conference 1999, 1385–1389.
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable

import cvxpy as cp
import numpy as np
from scipy.linalg import LinAlgError, solve_continuous_lyapunov
from scipy.optimize import differential_evolution

from posreal.admittance import StateSpace, random_port_hamiltonian
from posreal.admittance.positive_real_lemma import factored
from posreal.optimisation.coordinates import Chart
from posreal.optimisation.criterion import Candidate, Criterion
from posreal.optimisation.scaling import reference
from posreal.specification.named import problem
from posreal.synthesis.combination import synthesise
from posreal.synthesis.generalised_plant import generalised_plant

ORDER, BEST, LIMIT = 2, 1.542673, 90.0
ENOUGH = BEST * 1.001
QUARTER = problem("quarter-car")
SCALE = reference(QUARTER)
CRITERION = Criterion(QUARTER, SCALE)
PLANT = generalised_plant(QUARTER, SCALE)


class Watch:
    """Remembers the best measured figure and when it was good enough."""

    def __init__(self) -> None:
        self.began, self.best = time.perf_counter(), np.inf

    @property
    def seconds(self) -> float:
        return time.perf_counter() - self.began

    @property
    def over(self) -> bool:
        return self.best <= ENOUGH or self.seconds > LIMIT

    def saw(self, value: float) -> float:
        self.best = min(self.best, value)
        return value


def combination(watch: Watch) -> None:
    """What :func:`posreal.synthesis.combination.synthesise` does."""
    watch.saw(synthesise(QUARTER, ORDER, starts=4).value)


def start(rng: np.random.Generator) -> StateSpace:
    """The best of a hundred random devices, as for the combination."""
    drawn = [random_port_hamiltonian(ORDER, rng, 1.0) for _ in range(100)]
    return min(drawn, key=lambda device: CRITERION.measure(Candidate(device))).state_space()


def step(form: StateSpace, radius: float | None) -> StateSpace | None:
    """One semidefinite program written in cvxpy: X fixed (no radius), or X Acl linearised inside a ball."""
    loop = PLANT.closed(form.A, form.B, form.C, form.D)
    A0, Bw, C0, n = loop.A, loop.B, loop.C, len(loop.A)
    X0 = solve_continuous_lyapunov(A0.T, -C0.T @ C0)
    T = np.linalg.cholesky(X0 + 1e-9 * np.trace(X0) / n * np.eye(n)).T
    Ti = np.linalg.inv(T)
    A, B = cp.Variable((ORDER, ORDER)), cp.Variable((ORDER, 1))
    C, D = cp.Variable((1, ORDER)), cp.Variable((1, 1))
    Acl = T @ cp.bmat([[PLANT.A + PLANT.Bu @ D @ PLANT.Cy, PLANT.Bu @ C], [B @ PLANT.Cy, A]]) @ Ti
    Ccl = cp.hstack([PLANT.Cz + PLANT.Dzu @ D @ PLANT.Cy, PLANT.Dzu @ C]) @ Ti
    K = [(A, form.A), (B, form.B), (C, form.C), (D, form.D)]
    pr = cp.bmat([[A.T + A, B - C.T], [B.T - C, -D - D.T]])
    if radius is None:
        gamma = cp.Variable()  # with X fixed: how far inside the inequality can the device get
        M, objective, extra = Acl, cp.Maximize(gamma), [cp.norm(cp.hstack([cp.vec(v - k, "F") for v, k in K])) <= 1]
    else:
        gamma, X = 0.0, cp.Variable((n, n), symmetric=True)
        M = Acl + (X - np.eye(n)) @ (T @ A0 @ Ti)
        objective = cp.Minimize(cp.trace((T @ Bw).T @ X @ (T @ Bw)))
        extra = [cp.norm(cp.hstack([cp.vec(v - k, "F") for v, k in K])) <= radius]
    h2 = cp.bmat([[M + M.T, Ccl.T], [Ccl, -np.eye(1)]]) + gamma * np.eye(n + 1)
    constraints = [(h2 + h2.T) / 2 << 0, (pr + pr.T) / 2 << 0, *extra]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an inaccurate proposal is measured like any other
            cp.Problem(objective, constraints).solve(solver=cp.CLARABEL)
    except cp.SolverError:
        return None
    if A.value is None:
        return None
    return factored(StateSpace(A.value, B.value, C.value, D.value)).state_space()


def iterated(watch: Watch, following: bool) -> None:
    """Alternation or path following from drawn starts until good enough or out of time."""
    rng = np.random.default_rng(0)
    while not watch.over:
        form, radius = start(rng), 0.5
        value = watch.saw(CRITERION.measure(Candidate(factored(form))))
        while radius > 1e-3 and not watch.over:
            try:
                proposal = step(form, radius if following else None)
            except LinAlgError:
                break
            new = np.inf if proposal is None else watch.saw(CRITERION.measure(Candidate(factored(proposal))))
            if proposal is not None and new < value * (1 - 1e-6):
                form, value, radius = proposal, new, 1.5 * radius
            else:
                radius = radius / 4 if following else 0.0


def evolution(watch: Watch) -> None:
    """scipy's differential evolution over the chart's vector, each entry within ±6."""
    chart = Chart(ORDER)

    def figure(theta: np.ndarray) -> float:
        value = CRITERION.value_and_slope(chart.values(theta, CRITERION.s))[0]
        return watch.saw(value if np.isfinite(value) else 1e9)

    differential_evolution(
        figure, [(-6.0, 6.0)] * chart.size, rng=0, maxiter=10_000, tol=0, callback=lambda *_: watch.over
    )


def main() -> None:
    """Each way once; times as ratios to the combination's."""
    ways: dict[str, Callable[[Watch], None]] = {
        "synthesise (inequalities, then quasi-Newton)": combination,
        "path following, rebuilt by cvxpy at each step": lambda watch: iterated(watch, following=True),
        "plain alternation": lambda watch: iterated(watch, following=False),
        "differential evolution": evolution,
    }
    combination(Watch())  # warm-up: imports and caches
    base = 0.0
    for name, way in ways.items():
        watch = Watch()
        way(watch)
        seconds = watch.seconds
        base = base or seconds
        reached = watch.best <= ENOUGH
        said = f"{seconds / base:8.1f} ×" if reached else f"> {seconds / base:6.1f} ×, at {watch.best:.5f}"
        print(f"  {name:<52} {seconds:8.2f} s   {said}")


if __name__ == "__main__":
    main()
