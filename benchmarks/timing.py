"""Median time of a call, and two calls in turn so that a drifting machine spoils neither."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable


def seconds(call: Callable[[], object]) -> float:
    """Wall seconds of one call."""
    began = time.perf_counter()
    call()
    return time.perf_counter() - began


def medians(calls: dict[str, Callable[[], object]], rounds: int = 5) -> dict[str, float]:
    """Median seconds of each call over so many rounds, the calls taking turns, after one warm-up."""
    for call in calls.values():
        call()
    runs: dict[str, list[float]] = {name: [] for name in calls}
    for _ in range(rounds):
        for name, call in calls.items():
            runs[name].append(seconds(call))
    return {name: statistics.median(times) for name, times in runs.items()}


def report(times: dict[str, float], base: str) -> None:
    """Print each time and its ratio to `base`."""
    for name, value in times.items():
        print(f"  {name:<52} {1e3 * value:10.2f} ms   {value / times[base]:9.1f} ×")
