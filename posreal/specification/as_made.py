"""Layouts and designs of real elements (:mod:`posreal.real_elements`) in place of ideal ones."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from posreal.errors import Infeasible
from posreal.metric import Measured
from posreal.network import Network
from posreal.network.as_made import companions, made
from posreal.specification.layout import ElementRule, Layout
from posreal.specification.problem import Problem


@dataclass(frozen=True)
class Ideal:
    """What a design of real elements would be if they were ideal.

    Attributes
    ----------
    network : Network
        The elements by the values that are bought.
    metrics : mapping of metric name to Measured
        Empty where the vehicle is not stable with it.
    """

    network: Network
    metrics: Mapping[str, Measured]


def ideal_beside(problem: Problem, network: Network, *, whole: bool = False) -> Ideal | None:
    """The figures of a network of ideal elements; None where a problem's elements are ideal anyway."""
    if problem.elements is None:
        return None
    try:
        return Ideal(network, problem.metrics(problem.port(network.admittance(), whole=whole)))
    except Infeasible:
        return Ideal(network, {})


def layout_as_made(layout: Layout, problem: Problem) -> Layout:
    """The layout with each element replaced by what is bought for it.

    What a layout fixes, or has from the vehicle (its static spring, its bush), is the part that is there already, and
    stays as it is.
    """
    if problem.elements is None:
        return layout
    keep = {name for name, rule in layout.rules.items() if rule.role is not None or rule.fixed is not None}
    added = companions(layout.network, problem.elements, keep=keep)
    rules: dict[str, Any] = {name: ElementRule(fixed=value) for name, value in added.items()}
    network = made(layout.network, problem.elements, keep=keep).topology()
    return dataclasses.replace(layout, network=network, rules={**layout.rules, **rules})
