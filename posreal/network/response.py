"""Y(s) and its gradient in floats, by one sweep up the tree and one back down.

Going up, admittances add in parallel and impedances in series. Going down, a = ∂Y/∂Y_node starts at 1 and

    parallel   a_child = a_node
    series     a_child = a_node (Y_node/Y_child)²
    graph      a_child = a_node (v_child/v_port)²          (reciprocity)

and an element, being linear in its value θ, ends it with ∂Y/∂log θ = a Y_element.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from posreal.errors import BadDevice
from posreal.network.tree import Element, Network, Parallel, Series

Array = NDArray[Any]

_POWER = {"k": -1, "c": 0, "b": 1}  # of s in an element's admittance


class Step(Protocol):
    """One joint of the tree: fills its own slot from its children's, and passes adjoints back."""

    def up(self, y: Array, levers: Array) -> None: ...

    def down(self, y: Array, a: Array, levers: Array, d_levers: Array) -> None: ...


@dataclass(frozen=True)
class _Parallel:
    slot: int
    children: slice

    def up(self, y: Array, levers: Array) -> None:
        np.sum(y[self.children], axis=0, out=y[self.slot])

    def down(self, y: Array, a: Array, levers: Array, d_levers: Array) -> None:
        a[self.children] = a[self.slot]


@dataclass(frozen=True)
class _Series:
    slot: int
    children: slice

    def up(self, y: Array, levers: Array) -> None:
        y[self.slot] = 1 / np.sum(1 / y[self.children], axis=0)

    def down(self, y: Array, a: Array, levers: Array, d_levers: Array) -> None:
        a[self.children] = a[self.slot] * (y[self.slot] / y[self.children]) ** 2


class Response:
    """A topology made ready for evaluation at many values; `Network.response` makes and keeps it.

    Call it for Y alone; `evaluate` adds the gradient.
    """

    def __init__(self, elements: tuple[Element, ...], slots: list[int], steps: list[Step], size: int) -> None:
        self._steps = steps  # from the leaves to the root, which is slot 0
        self._size = size
        kinds = [element.letter for element in elements]
        self._branches = np.array([i for i, kind in enumerate(kinds) if kind in _POWER], dtype=int)
        self._levers = np.array([i for i, kind in enumerate(kinds) if kind not in _POWER], dtype=int)
        self._slots = np.array([slots[i] for i in self._branches], dtype=int)
        self._powers = np.array([_POWER[kinds[i]] + 1 for i in self._branches], dtype=int)
        self._count = len(elements)

    def __call__(self, values: ArrayLike, s: ArrayLike) -> Any:
        """Y at s, for values in the order of the network's names."""
        theta, points = self._read(values, s)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            y = self._up(self._admittances(theta, points.ravel()), theta)[0]
        return y.reshape(points.shape) if points.ndim else y[0]

    def evaluate(self, values: ArrayLike, s: ArrayLike) -> tuple[Array, Array]:
        """Y at s and ∂Y/∂(log value) of every element; shapes as in `Network.evaluate`."""
        theta, points = self._read(values, s)
        y, gradient = self._swept(self._admittances(theta, points.ravel()), theta)
        return y.reshape(points.shape), gradient.reshape(self._count, *points.shape)

    def joined(self, branches: Array) -> tuple[Array, Array]:
        """Y and ∂Y/∂(log admittance) of every element, for elements of any kind but levers.

        Parameters
        ----------
        branches : (len(network), P) complex
            The elements' admittances, at P points that may differ in frequency, in values and in kinds.

        Returns
        -------
        y : (P,) complex
        dy : (len(network), P) complex
        """
        return self._swept(branches, np.empty(0))

    def _swept(self, branches: Array, theta: Array) -> tuple[Array, Array]:
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            y = self._up(branches, theta)
            a = np.empty_like(y)
            a[0] = 1
            d_levers = np.zeros((self._count, y.shape[1]), dtype=complex)
            for step in reversed(self._steps):
                step.down(y, a, theta, d_levers)
            gradient = np.empty((self._count, y.shape[1]), dtype=complex)
            gradient[self._branches] = a[self._slots] * y[self._slots]
            gradient[self._levers] = d_levers[self._levers] * theta[self._levers, None]
        return y[0], gradient

    def _up(self, branches: Array, theta: Array) -> Array:
        y = np.empty((self._size, branches.shape[1]), dtype=complex)
        y[self._slots] = branches
        for step in self._steps:
            step.up(y, theta)
        return y

    def _admittances(self, theta: Array, s: Array) -> Array:
        powers = np.stack([1 / s, np.ones_like(s), s])
        return np.asarray(theta[self._branches, None] * powers[self._powers])

    def _read(self, values: ArrayLike, s: ArrayLike) -> tuple[Array, Array]:
        theta = np.asarray(values, dtype=float)
        if theta.shape != (self._count,):
            raise BadDevice(f"This network takes {self._count} values and got an array of shape {theta.shape}.")
        return theta, np.asarray(s, dtype=complex)


def compiled(network: Network) -> Response:
    """Number the joints breadth first, so that the children of each stand side by side in memory."""
    from posreal.network.graph import Graph, NodalStep

    elements = network.elements()
    slots = [-1] * len(elements)
    steps: list[Step] = []
    queue = deque([(network, 0, 0)])  # node, its slot, index of its first element
    size = 1
    while queue:
        node, slot, first = queue.popleft()
        if not isinstance(node, Series | Parallel | Graph):
            slots[first] = slot
            continue
        inside: tuple[Network, ...] = node.children
        children = slice(size, size + len(inside))
        size += len(inside)
        for offset, child in enumerate(inside):
            queue.append((child, children.start + offset, first))
            first += len(child)
        if isinstance(node, Series):
            steps.append(_Series(slot, children))
        elif isinstance(node, Parallel):
            steps.append(_Parallel(slot, children))
        else:
            steps.append(NodalStep(slot, children, node, first))
    return Response(elements, slots, steps[::-1], size)
