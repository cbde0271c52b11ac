"""Y(s) and its gradient in floats, by one sweep up the tree and one back down.

Going up, admittances add in parallel and impedances in series. Going down, a = ∂Y/∂Y_node starts at 1 and

    parallel   a_child = a_node
    series     a_child = a_node (Y_node/Y_child)²
    graph      a_child = a_node (v_child/v_port)²          (reciprocity)

and an element, being linear in its value θ, ends it with ∂Y/∂log θ = a Y_element.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from posreal.errors import BadDevice

Array = NDArray[Any]

_POWER = {"k": -1, "c": 0, "b": 1}  # of s in an element's admittance


class JointStep(Protocol):
    """One joint of the tree: fills its own slot from its children's, and passes adjoints back."""

    def up(self, y: Array, levers: Array) -> None: ...

    def down(self, y: Array, a: Array, levers: Array, d_levers: Array) -> None: ...


class Joined(Protocol):
    """What is compiled: a network of networks, down to elements, which take no step."""

    @property
    def children(self) -> Sequence[Joined]: ...

    def elements(self) -> Sequence[Any]: ...

    def _step(self, slot: int, children: slice, first_lever: int) -> JointStep | None: ...


@dataclass(frozen=True)
class ParallelStep:
    slot: int
    children: slice

    def up(self, y: Array, levers: Array) -> None:
        np.sum(y[self.children], axis=0, out=y[self.slot])

    def down(self, y: Array, a: Array, levers: Array, d_levers: Array) -> None:
        a[self.children] = a[self.slot]


@dataclass(frozen=True)
class SeriesStep:
    slot: int
    children: slice

    def up(self, y: Array, levers: Array) -> None:
        y[self.slot] = 1 / np.sum(1 / y[self.children], axis=0)

    def down(self, y: Array, a: Array, levers: Array, d_levers: Array) -> None:
        a[self.children] = a[self.slot] * (y[self.slot] / y[self.children]) ** 2


class NodalStep:
    """A graph of `size` nodes: one small linear system per frequency, all solved in one call."""

    def __init__(
        self,
        slot: int,
        children: slice,
        size: int,
        branches: Sequence[tuple[int, int]],
        levers: Sequence[tuple[int, int, int]],
        first_lever: int,
    ) -> None:
        self.slot, self.children = slot, children
        size, bars = size - 1, len(levers)  # node 0 is held and left out
        self._incidence = np.zeros((len(branches), size))
        for row, (u, v) in enumerate(branches):
            for node, sign in ((u, 1), (v, -1)):
                if node:
                    self._incidence[row, node - 1] = sign
        self._triples = levers
        self._levers = slice(first_lever, first_lever + bars)
        self._size, self._bars = size, bars

    def up(self, y: Array, levers: Array) -> None:
        y[self.slot] = 1 / self._solution(y, levers)[:, 0]

    def down(self, y: Array, a: Array, levers: Array, d_levers: Array) -> None:
        x, forces = self.motion(y, levers)
        drop = x[:, 1:] @ self._incidence.T
        a[self.children] = a[self.slot] * drop.T**2
        for j, (near, pivot, _) in enumerate(self._triples):
            d_levers[self._levers.start + j] = a[self.slot] * 2 * forces[:, j] * (x[:, pivot] - x[:, near])

    def motion(self, y: Array, levers: Array) -> tuple[Array, Array]:
        """The nodes' velocities and the levers' forces per unit of velocity at terminal 1, a row for each frequency."""
        solution = self._solution(y, levers)
        x = np.zeros((len(solution), self._size + 1), dtype=complex)
        x[:, 1:] = solution[:, : self._size] / solution[:, :1]
        return x, solution[:, self._size :] / solution[:, :1]

    def _solution(self, y: Array, levers: Array) -> Array:
        n, total = self._size, self._size + self._bars
        matrix = np.zeros((y.shape[1], total, total), dtype=complex)
        matrix[:, :n, :n] = np.einsum("ei,ef,ej->fij", self._incidence, y[self.children], self._incidence)
        scale = np.abs(matrix[:, :n, :n]).max(axis=(1, 2))
        for j, ((near, pivot, far), ratio) in enumerate(zip(self._triples, levers[self._levers], strict=True)):
            for node, weight in ((far, 1.0), (pivot, ratio - 1), (near, -ratio)):
                if node:
                    matrix[:, n + j, node - 1] = matrix[:, node - 1, n + j] = weight * scale
        rhs = np.zeros((y.shape[1], total, 1), dtype=complex)
        rhs[:, 0, 0] = 1
        solution = _solve(matrix, rhs)
        solution[:, n:] *= scale[:, None]
        return solution


def _solve(matrix: Array, rhs: Array) -> Array:
    """The solution, with nan where a matrix is singular or not finite: a pole of the whole or of a branch."""
    try:
        return np.linalg.solve(matrix, rhs)[..., 0]
    except np.linalg.LinAlgError:
        rows = []
        for one, right in zip(matrix, rhs, strict=True):
            try:
                rows.append(np.linalg.solve(one, right)[:, 0])
            except np.linalg.LinAlgError:
                rows.append(np.full(len(one), np.nan, dtype=complex))
        return np.array(rows)


class Response:
    """A topology made ready for evaluation at many values; `Network.response` makes and keeps it.

    Call it for Y alone; `evaluate` adds the gradient.
    """

    def __init__(self, kinds: Sequence[str], slots: Sequence[int], steps: Sequence[JointStep], size: int) -> None:
        self._steps = steps  # from the leaves to the root, which is slot 0
        self._size = size
        self._branches = np.array([i for i, kind in enumerate(kinds) if kind in _POWER], dtype=int)
        self._levers = np.array([i for i, kind in enumerate(kinds) if kind not in _POWER], dtype=int)
        self._slots = np.array([slots[i] for i in self._branches], dtype=int)
        self._powers = np.array([_POWER[kinds[i]] + 1 for i in self._branches], dtype=int)
        self._count = len(kinds)

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


def compiled(network: Joined) -> Response:
    """Number the joints breadth first, so that the children of each stand side by side in memory."""
    kinds = [element.letter for element in network.elements()]
    slots = [-1] * len(kinds)
    steps: list[JointStep] = []
    queue = deque([(network, 0, 0)])  # node, its slot, index of its first element
    size = 1
    while queue:
        node, slot, first = queue.popleft()
        children = slice(size, size + len(node.children))
        here = first
        for offset, child in enumerate(node.children):
            queue.append((child, size + offset, here))
            here += len(child.elements())
        step = node._step(slot, children, here)
        if step is None:
            slots[first] = slot
        else:
            steps.append(step)
        size = children.stop
    return Response(kinds, slots, steps[::-1], size)
