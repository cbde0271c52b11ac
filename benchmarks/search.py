"""The topology search: one batch against its members one by one, and whole searches behind the bush.

A search is one call that takes seconds to minutes, so it is timed once: ``python -m benchmarks search``.
"""

from __future__ import annotations

import numpy as np

from benchmarks.timing import medians, report, seconds
from posreal.network.topologies import forms, key, letters, network
from posreal.specification.named import problem
from posreal.topology.result import Search
from posreal.topology.search import search
from posreal.topology.values import coarse

_LARGEST = 5


def main() -> None:
    """A batch must agree with its members to 1e-10; then times, and the front with the seconds that it took."""
    posed = problem("vertical-comfort")
    ground = coarse(posed)
    form = forms(5)[100]
    theta = np.log(ground.scale.units(letters(form))) + np.random.default_rng(0).normal(size=(16, 5))
    compiled, s = network(form).response, ground.grid.s

    def at_once() -> np.ndarray:
        return ground.value_and_gradient(form, theta)[0]

    def one_by_one() -> np.ndarray:
        return np.array([ground.value_and_gradient(form, row[None, :])[0][0] for row in theta])

    def responses_one_by_one() -> None:
        for row in theta:
            compiled.evaluate(np.exp(row), s)

    assert np.allclose(at_once(), one_by_one(), rtol=1e-10)
    calls = {
        f"figures and gradients of {len(theta)} starts of {key(form)}, {len(s)} points": at_once,
        "the same, one start at a time": one_by_one,
        "the network's responses and gradients alone, one at a time": responses_one_by_one,
    }
    report(medians(calls, rounds=20), next(iter(calls)))
    for elements in range(3, _LARGEST + 1):
        found: list[Search] = []
        took = seconds(lambda n=elements, found=found: found.append(search(posed, n)))  # type: ignore[misc]
        best = found[0].best
        print(f"  up to {elements} elements: {took:6.1f} s, {best.objective} by {best.network.topology()}")  # type: ignore[union-attr]


if __name__ == "__main__":
    main()
