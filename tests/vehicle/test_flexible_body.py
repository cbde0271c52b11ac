"""A body that bends: the beam's roots and shapes, the whole system solved one frequency at a time, figures computed
elsewhere, and searches and bound that take it as any other vehicle."""

from __future__ import annotations

import math

import numpy as np
import pytest

from posreal.admittance import Rational, random_port_hamiltonian, state_space
from posreal.bounds.compute import bound
from posreal.bounds.file import load_bound
from posreal.errors import BadInput
from posreal.optimisation.evaluate import evaluate
from posreal.optimisation.layout_values import optimise
from posreal.plant.plant import close
from posreal.specification.conditions import cautions, conditions, in_words
from posreal.specification.layout import layout
from posreal.specification.named import problem
from posreal.vehicle import SideView
from posreal.vehicle.flexible_body import FlexibleBody, MeasuredMode, beam_root, beam_shape, read_body
from posreal.vehicle.manchester import ManchesterCoach
from tests.vehicle import naive

S4, S5 = "S4 c=11048.8 b=91.7", "S5 c=17965 b=4115"


def test_roots_and_shapes_of_a_free_beam():
    np.testing.assert_allclose(
        [beam_root(n) for n in range(1, 5)], [4.730041, 7.853205, 10.995608, 14.137165], atol=1e-6
    )
    place = 9.5 / math.sqrt(12 * 2.31e6 / 38000)
    expected = {(1, place): 0.639349, (1, 0): -1.215644, (2, place): -0.212872, (3, place): -0.861639}
    expected |= {(3, 0): 1.422381, (4, place): -1.243676, (1, 0.5): 2, (4, -0.5): -2}
    for (n, at), value in expected.items():
        assert beam_shape(n, at) == pytest.approx(value, abs=6e-6)


@pytest.mark.parametrize("count", [1, 2, 4])
def test_the_two_loops_are_the_whole_system(count):
    """6 + N coordinates with delays, modes scaled otherwise, against the port map."""
    body = FlexibleBody(7.3, 0.02, count)
    vehicle = SideView(body=body, V=42.0)
    port = Rational.spring(vehicle.bush) + random_port_hamiltonian(2, np.random.default_rng(1)).rational().time_scaled(
        1 / 6
    ).scaled(1.5e4)
    omega = np.array([0.7, 3.0, 9.0, 44.0, 46.0, 90.0, 120.0, 270.0, 480.0])
    whole = vehicle.airspring() | port
    for output in ("acceleration_L", "acceleration_M", "acceleration_T", "deflection_front", "deflection_rear"):
        expected = [
            naive.flexible(vehicle, lambda s: port(np.array([s]))[0], w, body.frequency, body.damping, count)[output]
            for w in omega
        ]
        z, _ = vehicle.plant("track").responses(omega, output).closed({"secondary": whole(1j * omega)})
        np.testing.assert_allclose(z, expected, rtol=1e-9)


@pytest.mark.parametrize("make", [SideView, ManchesterCoach])
def test_bounce_and_pitch_stay_apart_and_passive(make):
    plant = make(body=FlexibleBody(count=4)).plant("track")
    P = plant.responses(np.geomspace(0.1, 1000, 300), "acceleration_M").Pvf
    assert np.abs(P[:, 0, 1]).max() <= 1e-12 * np.abs(P).max()
    assert P[:, [0, 1], [0, 1]].real.min() >= -1e-12 * np.abs(P).max()


@pytest.mark.parametrize("make", [SideView, ManchesterCoach])
def test_a_stiff_body_is_a_rigid_one(make):
    rigid, stiff = make(), make(body=FlexibleBody(900.0, 0.02))
    omega = np.array([1.0, 8.0, 60.0])
    Y = {"secondary": (rigid.places["secondary"].around.port(Rational.damper(2e4)))(1j * omega)}
    for output in ("acceleration_M", "deflection_rear"):
        one, other = (v.plant("track").responses(omega, output).closed(Y)[0] for v in (rigid, stiff))
        np.testing.assert_allclose(other, one, rtol=1e-2)


ROWS = [  # modes, weighting, cut-off, device, %g at L, M, T
    (1, "none", 20, None, "1.7409 1.4836 2.2828"),
    (1, "none", 20, S5, "1.8515 1.7894 2.1298"),
    (1, "Wb", 20, S4, "1.1139 1.3132 1.2140"),
    (1, "Wk", 20, None, "1.0905 1.2155 1.3038"),
    (1, "Wb", 80, S5, "1.3853 1.6632 1.4622"),
    (2, "Wb", 20, S5, "1.3136 1.6631 1.3943"),
]


@pytest.mark.parametrize(("modes", "weighting", "end", "device", "expected"), ROWS)
def test_ride_of_a_flexible_body(modes, weighting, end, device, expected):
    posed = problem("vertical-comfort", body=FlexibleBody(count=modes), weighting=weighting, cut_off=end)
    found = evaluate(posed, device).metrics
    for point, value in zip("LMT", expected.split(), strict=True):
        measured = found[f"J1z_{point}"].value if weighting == "none" else found[f"aw_{point}"].value / 0.098
        assert measured == pytest.approx(float(value), abs=6e-5)


@pytest.mark.parametrize(
    ("speed", "expected"), [(20, "1.0295 1.6519 .9543"), (40, ".8021 .4532 .8809"), (70, "1.1763 1.4972 1.2525")]
)
def test_geometric_filtering(speed, expected):
    found = evaluate(problem("vertical-comfort", body="flexible", weighting="Wb", speed=speed), None).metrics
    for point, value in zip("LMT", expected.split(), strict=True):
        assert found[f"aw_{point}"].value / 0.098 == pytest.approx(float(value), abs=1.1e-4)


def test_the_bush_has_an_optimum_of_its_own():
    """With a flexible body the series spring matters [Jiang2012, conclusions]: 0.23 MN/m, not as stiff as can be."""
    design = optimise(problem("vertical-comfort", body="flexible"), layout("S5"), starts=6, any_values=True)
    assert design.objective.value <= 2.09710 * (1 + 5e-5)
    assert design.parameters["k"] == pytest.approx(0.2336e6, rel=0.05)


def test_the_bound_holds_for_a_flexible_body(tmp_path):
    posed = problem("vertical-comfort", body="9 Hz,2%", weighting="Wb")
    found = bound(posed, L=12, omega0=(8.0, 25.0, 60.0))
    assert 0 < found.value < evaluate(posed, "c=2000 | b=50").objective.value
    found.save(tmp_path / "bound.json")
    again = load_bound(tmp_path / "bound.json")
    assert again.check() >= found.value
    assert again.problem is not None
    assert again.problem.vehicle == posed.vehicle
    measured = problem("vertical-comfort", body=FlexibleBody(measured=(MeasuredMode(9.1),)))
    bound(measured, L=8, omega0=10.0).save(tmp_path / "own.json")
    assert load_bound(tmp_path / "own.json").problem is None  # its matrices are stored
    assert load_bound(tmp_path / "own.json").check() > 0


def test_modes_of_a_vehicle_file(tmp_path):
    path = tmp_path / "coach.toml"
    path.write_text(
        '[side-view]\nmv = "40 t"\n[[side-view.modes]]\nf = "8.5 Hz"\nzeta = 0.02\n'
        "[[side-view.modes]]\nf = 14\nsymmetric = false\nat_bogie = -0.3\n"
    )
    vehicle = problem("vertical-comfort", vehicle_file=path).vehicle
    assert vehicle.mv == 40e3
    first, second = vehicle.bending()
    assert (first.omega / 2 / math.pi, first.damping) == pytest.approx((8.5, 0.02))
    assert first.front == pytest.approx(beam_shape(1, 9.5 / math.sqrt(12 * 2.31e6 / 40e3)))
    assert (second.front, second.rear, second.middle) == (-0.3, 0.3, 0.0)
    loop = close(vehicle.plant("track"), {"secondary": state_space(vehicle.airspring())})
    assert loop.poles().real.max() < 0


def test_what_is_said_of_the_body():
    posed = problem("vertical-comfort", body="8.5 Hz,1.5%,2")
    assert conditions(posed)["body"] == "flexible, 8.5 Hz, 1.5 %, 2 modes"
    assert "body flexible, 8.5 Hz" in in_words(posed)
    assert cautions(posed) == []
    (said,) = cautions(problem("vertical-comfort", body="8.5 Hz,1.5%,3"))
    assert "above 25 Hz" in said
    assert conditions(problem("vertical-comfort"))["body"] == "rigid"
    assert problem("vertical-comfort", body="rigid") == problem("vertical-comfort")
    assert read_body("9") == FlexibleBody(9.0)
    body = FlexibleBody(8.7, 0.013, 2)
    assert read_body(body.text or "") == body


@pytest.mark.parametrize(
    ("name", "body", "says"),
    [
        ("lateral-comfort", "flexible", "a flexible body does not fit lateral-comfort"),
        ("vertical-comfort", "soft", "body 'soft' is none"),
        ("vertical-comfort", "8.5 Hz,150%", "damping ratio 1.5"),
        ("vertical-comfort", "8.5 Hz,1%,9", "from 1 to 6 modes, not 9"),
        ("vertical-comfort", "1e9", "a body mode at 1e\\+09 Hz"),
        ("vertical-comfort", "nan", "a body mode at nan Hz"),
    ],
)
def test_bad_bodies(name, body, says):
    with pytest.raises(BadInput, match=says):
        problem(name, body=body)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[[side-view.modes]]\nzeta = 0.1\n", "needs its frequency"),
        ("[[side-view.modes]]\nf = 8\nq = 1\n", "has no 'q'"),
        ("[side-view]\nmodes = 3\n", "modes are tables of their own"),
        ("[[side-view.modes]]\nf = 8\nsymmetric = false\nat_middle = 1.0\n", "nothing in the middle"),
        ("[[side-view.modes]]\nf = 8\nsymmetric = 3\n", "symmetric is 3"),
        ("[[side-view.modes]]\nf = true\n", "not a number"),
    ],
)
def test_bad_modes_of_a_file(tmp_path, text, says):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(BadInput, match=says):
        problem("vertical-comfort", vehicle_file=path)


def test_bogies_beyond_the_body():
    with pytest.raises(BadInput, match="give measured modes"):
        SideView(Iv=1e5, body=FlexibleBody()).plant("track")
