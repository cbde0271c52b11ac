"""The space on which bounds look at functions: its defining identities, in balls."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flint import arb, fmpq

from posreal.admittance import Rational, state_space
from posreal.admittance.roots import precision
from posreal.bounds.interpolation_space import Space, floats
from posreal.errors import BadInput

SPREAD = (fmpq(3), fmpq(20), (fmpq(5), fmpq(1, 4)), fmpq(3), (fmpq(5), fmpq(1, 4)), fmpq(20))
SIZE = 8


@pytest.fixture(autouse=True)
def _balls():
    with precision(300):
        yield


def overlap(a, b):
    return all(x.overlaps(y) for x, y in zip(a.entries(), b.entries(), strict=True))


def test_S_plus_its_transpose_has_rank_one():
    space = Space(SPREAD)
    both = space.S + space.S.transpose()
    assert all(both[j, k].overlaps(space.v[j] * space.v[k]) for j in range(SIZE) for k in range(SIZE))


def test_the_functions_are_orthonormal():
    # φ(s) = (s + S)⁻¹ v; the Gram matrix G obeys S G + G Sᵀ = v vᵀ, which has one solution, I
    space = Space(SPREAD)
    S, v = floats(space.S), np.array([float(part) for part in space.v])
    omega = np.tan(np.linspace(-np.pi / 2, np.pi / 2, 40001)[1:-1]) * 10
    values = np.linalg.solve(
        1j * omega[:, None, None] * np.eye(SIZE) + S, np.broadcast_to(v[:, None], (len(omega), SIZE, 1))
    )
    gram = np.trapezoid(values * values.conj().swapaxes(1, 2), omega, axis=0) / (2 * np.pi)
    np.testing.assert_allclose(gram, np.eye(SIZE), atol=2e-3)
    # and the points are the eigenvalues: 5 (1/4 ± j √15/4) twice
    pair = 5 * (0.25 + 1j * math.sqrt(15) / 4)
    expected = np.poly([3, 3, 20, 20, pair, pair, pair.conjugate(), pair.conjugate()])
    np.testing.assert_allclose(np.poly(S), expected.real, rtol=1e-9)


def test_equal_points_give_taylor_coefficients():
    # 1/(s + 3) at s = 5 (1 + η)/(1 − η), η = (s − 5)/(s + 5): (1 − η)/(8 + 2η)
    column = floats(Space((fmpq(5),) * 6).rational(Rational([1], [3, 1])))[:, 0]
    series = np.zeros(6)
    for k in range(6):
        series[k] = ((-0.25) ** k - (0 if k == 0 else (-0.25) ** (k - 1))) / 8
    np.testing.assert_allclose(column, series, rtol=1e-14)


def test_functions_multiply_as_their_operators_do():
    space = Space(SPREAD)
    f, g = Rational([1, 2], [3, 1, 4]), Rational([5, 0, 1], [1, 1, 1])
    product = space.operator(space.rational(f)) * space.rational(g)
    assert overlap(product, space.rational(f.times(g)))
    assert overlap(space.over(product, space.rational(g)), space.rational(f))


def test_the_basis_starts_with_each_unit_vector():
    space = Space(SPREAD)
    first_columns = floats(space.basis).T.reshape(SIZE, SIZE, SIZE)[:, :, 0]
    np.testing.assert_allclose(first_columns, np.eye(SIZE), atol=1e-30)


def test_a_state_space_and_its_rational_function_agree():
    f = Rational([1, 2, 7], [3, 1, 4, 1])
    form = state_space(f)
    column = Space(SPREAD).state_space(form.A, form.B, form.C, form.D)[0][0]
    np.testing.assert_allclose(floats(column), floats(Space(SPREAD).rational(f)), rtol=1e-12)


def test_a_pole_at_a_point_is_refused():
    with pytest.raises(BadInput, match="pole"):
        Space((fmpq(3),)).state_space(np.array([[3.0]]), np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)))
    A = np.array([[0.0, 1.0], [-4.0, 2.0]])  # s² − 2s + 4
    with pytest.raises(BadInput, match=r"damped 0\.5, is a pole"):
        Space((fmpq(1), (fmpq(2), fmpq(1, 2)))).state_space(A, np.ones((2, 1)), np.ones((1, 2)), np.zeros((1, 1)))
    for points in ((fmpq(0),), ((fmpq(3), fmpq(0)),), ()):
        with pytest.raises(BadInput, match="open right half plane"):
            Space(points)


def test_delays_compose_and_start_at_their_value():
    space = Space(SPREAD)
    late = space.delay(0.25)
    assert late[0, 0].overlaps((arb(-3) / 4).exp())
    assert overlap(space.operator(late) * late, space.delay(0.5))
    assert np.linalg.norm(floats(space.operator(late)), 2) <= 1  # |e^{−sτ}| ≤ 1


def test_projection_keeps_the_norm_of_what_lies_in_the_space():
    # ‖1/(s + 3)‖² = 1/6; the point 3 puts it into the space, without that point something is lost
    inside, outside = Space((fmpq(20), fmpq(3))), Space((fmpq(20), fmpq(5)))
    f = Rational([1], [3, 1])
    found = [
        float(sum(x * x for x in (space.operator(space.measure) * space.rational(f)).entries()))
        for space in (inside, outside)
    ]
    assert found[0] == pytest.approx(1 / 6, rel=1e-14)
    assert found[1] < 1 / 6 - 1e-4
    assert math.isclose(float(inside.v[0]) ** 2, 40)
