"""The best positive-real device of an order, as a design."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from posreal.design.problem import Problem
from posreal.design.result import Design
from posreal.design.synthesis import synthesise as search


def synthesise(
    problem: Problem,
    order: int,
    *,
    method: str = "auto",
    starts: int | None = None,
    seed: int = 0,
    warm: Sequence[Any] = (),
    progress: Callable[[str], None] | None = None,
) -> Design:
    """The best positive-real admittance of McMillan degree `order` that was found for the device's place.

    See :func:`posreal.design.synthesis.synthesise` for the method and what is raised.
    """
    raise NotImplementedError((problem, order, method, starts, seed, warm, progress, search, Design))
