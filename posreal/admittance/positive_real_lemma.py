"""The positive-real lemma, and a positive-real function in the coordinates of its stored energy.

    −[[AᵀP + PA, PB − Cᵀ], [BᵀP − C, −D − Dᵀ]] ⪰ 0        (A, B, C, D: device)

holds for some P ≻ 0 [Willems1972]. With P = TᵀT and x → Tx the stored energy is ½xᵀx, P becomes I, and J, G and the
factor of the dissipation can be read off.
"""

from __future__ import annotations

import numpy as np

from posreal.admittance import PortHamiltonian, Rational, StateSpace, state_space
from posreal.numerics.sdp import Affine, Shape, minimise

Real = np.ndarray


def port_hamiltonian(H: Rational) -> PortHamiltonian | None:
    """A port-Hamiltonian form near `H`; None if the solver finds no storage (H is not positive real).

    On the boundary of the positive-real functions the storage is found to the solver's accuracy only, so this is a
    start for a search, not another way to write H.
    """
    form = state_space(H)
    n = form.order
    if n == 0:
        D = max(float(form.D[0, 0]), 0.0)
        return PortHamiltonian(np.zeros((0, 0)), np.zeros((0, 1)), np.full((1, 1), np.sqrt(D)), form.k, form.b)
    outcome = minimise(
        {"P": Shape(n, n, symmetric=True)},
        Affine(("P",), lambda u: np.trace(u["P"], axis1=-2, axis2=-1)),
        [
            Affine(("P",), lambda u: positive_real(form.A, form.B, form.C, form.D, u["P"])),
            Affine(("P",), lambda u: u["P"] - 1e-9 * np.eye(n)),
        ],
    )
    if outcome.unknowns is None:
        return None
    values, vectors = np.linalg.eigh(outcome.unknowns["P"])
    if values[0] <= 0:
        return None
    T = (vectors * np.sqrt(values)).T
    inverse = vectors / np.sqrt(values)
    return factored(StateSpace(T @ form.A @ inverse, T @ form.B, form.C @ inverse, form.D, form.k, form.b))


def factored(form: StateSpace) -> PortHamiltonian:
    """The nearest device whose storage is ½xᵀx: what is negative in the positive-real inequality is cut off."""
    dissipation = positive_real(form.A, form.B, form.C, form.D) / 2
    values, vectors = np.linalg.eigh(dissipation)
    L = vectors * np.sqrt(np.clip(values, 0.0, None))
    return PortHamiltonian((form.A - form.A.T) / 2, (form.B + form.C.T) / 2, L, form.k, form.b)


def positive_real(A: Real, B: Real, C: Real, D: Real, P: Real | None = None) -> Real:
    """The positive-real lemma; P = I unless given, which is what makes it linear in the device."""
    if P is None:
        P = np.eye(A.shape[-1])
    off = P @ B - transposed(C)
    return -blocks([[transposed(A) @ P + P @ A, off], [transposed(off), -D - transposed(D)]])


def blocks(rows: list[list[Real]]) -> Real:
    """A matrix of blocks, leading axes broadcast."""
    batch = np.broadcast_shapes(*(part.shape[:-2] for row in rows for part in row))
    full = [[np.broadcast_to(part, (*batch, *part.shape[-2:])) for part in row] for row in rows]
    return np.concatenate([np.concatenate(row, axis=-1) for row in full], axis=-2)


def transposed(M: Real) -> Real:
    """Of each matrix of a stack."""
    return np.swapaxes(M, -1, -2)
