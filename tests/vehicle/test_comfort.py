"""Weighted acceleration: the filters against their formulas and published values, the figures against the vehicles'
equations solved one frequency at a time, against each other, and against figures computed elsewhere."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from scipy.stats import chi2

from posreal.admittance import Rational, random_port_hamiltonian
from posreal.bounds.certificate import NotProven
from posreal.bounds.compute import bound
from posreal.bounds.file import load_bound
from posreal.cli.options import read_speeds
from posreal.errors import BadInput
from posreal.metric import ClosedVehicle
from posreal.optimisation.evaluate import evaluate
from posreal.optimisation.layout_values import optimise
from posreal.plant.quadrature import gauss
from posreal.specification.conditions import cautions, conditions, in_words
from posreal.specification.layout import layout
from posreal.specification.named import problem
from posreal.vehicle import PlanView, SideView
from posreal.vehicle.weighting import NAMES, WEIGHTED, Weighting, sperling
from tests.vehicle import naive

THIRD_OCTAVES = 10 ** (np.array([-10, -4, -3, 0, 2, 4, 6, 7, 8, 9, 10, 12, 13, 16, 19]) / 10)
GAINS = {
    "Wb": ".0249 .2807 .3359 .3911 .4063 .5094 .8183 .9581 1.0312 1.0557 1.0484 .9227 .7993 .4163 .1760",
    "Wb-iso": ".0249 .2800 .3347 .3853 .3916 .4960 .8850 1.0261 1.0545 1.0264 .9745 .8144 .7088 .3950 .1734",
    "Wd": ".0624 .7097 .8540 1.0110 .9707 .7733 .5143 .4081 .3226 .2550 .2017 .1266 .1004 .0496 .0213",
    "Wk": ".0312 .3504 .4188 .4825 .4935 .6335 .9648 1.0392 1.0544 1.0374 .9884 .7743 .6373 .3160 .1339",
    "Wc": ".0624 .7042 .8442 .9910 1.0064 1.0173 1.0239 1.0126 .9739 .8941 .7762 .5166 .4098 .2002 .0854",
}
# ISO 2631-1, table 3: nominal frequency in Hz and a thousand times the weighting
WK = {0.5: 418, 1: 482, 2: 531, 4: 967, 5: 1039, 6.3: 1054, 8: 1036, 10: 988, 16: 768, 20: 636, 40: 314, 80: 132}
WD = {0.5: 853, 1: 1011, 2: 890, 4: 512, 8: 253, 16: 125, 20: 100, 40: 49.4, 80: 21.1}


def formula(name: str, s: np.ndarray) -> np.ndarray:
    """W(s) written down from the standards' form, once more."""
    f3, f4, Q4, f5, Q5, f6, Q6, kappa = {
        "Wb": (16, 16, 0.63, 2.5, 0.8, 4, 0.8, 0.4),
        "Wb-iso": (16, 16, 0.55, 2.5, 0.9, 4, 0.95, 0.4),
        "Wk": (12.5, 12.5, 0.63, 2.37, 0.91, 3.35, 0.91, (2.37 / 3.35) ** 2),
        "Wd": (2, 2, 0.63, 0, 1, 0, 1, 1),
        "Wc": (8, 8, 0.63, 0, 1, 0, 1, 1),
        "We": (1, 1, 0.63, 0, 1, 0, 1, 1),
    }[name]
    p = s / (2 * np.pi)
    high = 1 / (1 + math.sqrt(2) * 0.4 / p + (0.4 / p) ** 2)
    low = 1 / (1 + math.sqrt(2) * p / 100 + (p / 100) ** 2)
    transition = (1 + p / f3) / (1 + p / (Q4 * f4) + (p / f4) ** 2)
    if not f5:
        return high * low * transition
    step = kappa * (1 + p / (Q5 * f5) + (p / f5) ** 2) / (1 + p / (Q6 * f6) + (p / f6) ** 2)
    return high * low * transition * step


@pytest.mark.parametrize("name", NAMES)
def test_a_weighting_is_its_formula(name):
    s = 2j * np.pi * np.geomspace(1e-3, 1e4, 200)
    np.testing.assert_allclose(Weighting(name)(s), formula(name, s), rtol=1e-9)
    rational = Weighting(name).rational
    np.testing.assert_allclose(rational(s), formula(name, s), rtol=1e-9)
    assert rational.degree == (8 if name in ("Wb", "Wb-iso", "Wk") else 6)


@pytest.mark.parametrize("name", GAINS)
def test_weightings_at_third_octaves(name):
    expected = [float(text) for text in GAINS[name].split()]
    np.testing.assert_allclose(Weighting(name).gain(THIRD_OCTAVES), expected, atol=2e-4)


def test_published_weightings():
    for name, at_100 in (("Wb-iso", 0.8126), ("Wc", 0.5145), ("Wd", 0.1261), ("We", 0.06287)):
        assert abs(Weighting(name)(np.array([100j]))[0]) == pytest.approx(at_100, abs=6e-5)  # ISO 8041, 100 rad/s
    for name, table in (("Wk", WK), ("Wd", WD)):
        np.testing.assert_allclose(Weighting(name).gain(np.array(list(table))) * 1e3, list(table.values()), rtol=4e-3)


@pytest.mark.parametrize("factor", [0.588, 0.737])
def test_sperling_s_weighting_is_its_fraction(factor):
    f = np.array([0.5, 1, 2, 5.4, 10, 30])
    top, bottom = 1.911 * f**2 + (0.25 * f**2) ** 2, (1 - 0.277 * f**2) ** 2 + (1.563 * f - 0.0368 * f**3) ** 2
    np.testing.assert_allclose(np.abs(sperling(factor)(2j * np.pi * f)), factor * np.sqrt(top / bottom), rtol=1e-12)


def test_an_unknown_weighting_names_what_is_known():
    with pytest.raises(BadInput, match="no weighting is called 'Wz'; accepted are Wb, Wb-iso, Wk, Wd, Wc or We"):
        Weighting("Wz")


# --- figures of whole vehicles --------------------------------------------------------------------------------------

DEVICES = {
    "default": "default",
    "S4": "S4 c=11048.8 b=91.7",
    "S5": "S5 c=17965 b=4115",
    "S7": "S7 c=13931.8 b=164.8 k=1.502e6 ke=5e6 ce=8e3",
}
ROWS = [  # weighting, cut-off in Hz, and %g at L, M, T for the default and S5
    ("Wb", 20, "0.8274 0.4837 0.9994", "1.0285 0.5758 1.0988"),
    ("Wb-iso", 20, "0.8275 0.4833 0.9967", "1.0174 0.5683 1.0878"),
    ("Wk", 20, "0.9613 0.5707 1.1862", "1.1137 0.6320 1.2131"),
    ("Wb", 80, "0.8362 0.4890 1.0067", "1.0885 0.6125 1.1553"),
]


@pytest.mark.parametrize(("name", "end", "default", "s5"), ROWS)
def test_weighted_ride_of_the_side_view(name, end, default, s5):
    posed = problem("vertical-comfort", weighting=name, cut_off=end)
    for device, row in ((None, default), (DEVICES["S5"], s5)):
        found = evaluate(posed, device).metrics
        for point, value in zip("LMT", row.split(), strict=True):
            metric = found[f"aw_{point}"]
            assert metric.value * 100 / 9.8 == pytest.approx(float(value), abs=6e-5)
            assert metric.unit == "m/s^2"
            assert f"{metric.value * 100 / 9.8:.6g} %g" in metric.at


def test_a_cut_off_ends_the_unweighted_ride_too():
    found = evaluate(problem("vertical-comfort", cut_off=80), None).metrics
    for point, value in zip("LMT", (1.6754, 1.0522, 2.2270), strict=True):
        assert found[f"J1z_{point}"].value == pytest.approx(value, abs=6e-5)


def test_over_all_frequencies_by_default():
    posed = problem("vertical-comfort", weighting="Wb")
    whole = evaluate(posed, DEVICES["S5"]).metrics["aw_T"].value
    cut = evaluate(problem("vertical-comfort", weighting="Wb", cut_off=100), DEVICES["S5"]).metrics["aw_T"].value
    assert cut < whole < cut * (1 + 1e-4)


@pytest.mark.parametrize(
    ("speed", "layout_and_values", "value"),
    [
        (55, "S1 c=2e4", 0.158525),
        (55, "S2 c=2.04e4 b=11.5", None),
        (55, "S3 c=2.1025e4 b=1.53e4", 0.149512),
        (20, "S1 c=2e4", 0.063143),
        (45, "S3 c=2.1025e4 b=1.53e4", 0.118781),
    ],
)
def test_weighted_ride_of_the_plan_view(speed, layout_and_values, value):
    posed = problem("lateral-comfort", weighting="Wd", vehicle={"V": speed})
    found = evaluate(posed, layout_and_values).metrics
    if value is not None:
        assert found["aw_y"].value == pytest.approx(value, abs=6e-7)
    if speed == 55:
        assert found["max_aw_y"].value == pytest.approx(found["aw_y"].value, rel=1e-6)
        assert found["max_aw_y"].at == "at 55 m/s"


def vertical_densities(
    vehicle: SideView, port: Rational, omega: np.ndarray, filters: np.ndarray
) -> dict[str, np.ndarray]:
    """Of every acceleration by the vehicle's equations, one frequency at a time, times |filter|², per rad/s."""
    responses = [naive.vertical(vehicle, lambda s: port(np.array([s]))[0], w) for w in omega]
    density = math.pi * vehicle.Av * vehicle.V * np.abs(filters) ** 2
    return {point: density * np.abs(np.array([z[f"acceleration_{point}"] for z in responses])) ** 2 for point in "LMT"}


@pytest.mark.parametrize("seed", range(2))
def test_weighted_accelerations_are_those_of_the_equations(seed):
    """A random device, the formula of the weighting, and every figure of comfort by its definition."""
    device = random_port_hamiltonian(2, np.random.default_rng(seed)).rational().time_scaled(1 / 6).scaled(1.5e4)
    vehicle = SideView(weighting=Weighting("Wk"), V=40.0, cut_off=100.0)
    rule = gauss(0.6, stop=200 * math.pi, per_decade=12)
    port = Rational.spring(vehicle.bush) + device
    closed = ClosedVehicle(vehicle, {"secondary": vehicle.airspring() | port})
    found = {name: vehicle.metrics[name].measure(closed).value for name in vehicle.comfort}
    a95 = {}
    for point, S in vertical_densities(vehicle, port, rule.omega, formula("Wk", 1j * rule.omega)).items():
        variance = rule.weight @ S
        assert found[f"aw_{point}"] == pytest.approx(math.sqrt(variance), rel=1e-7)
        freedom = 2 * variance**2 * 5 / (2 * np.pi * (rule.weight @ S**2))
        a95[point] = math.sqrt(variance * chi2.ppf(0.95, freedom) / freedom)
        assert found[f"a95_{point}"] == pytest.approx(a95[point], rel=2e-3)  # which has no end at 100 Hz
    assert found["NMV_z"] == pytest.approx(6 * max(a95.values()), rel=2e-3)


def test_a95_is_what_a_long_ride_has():
    """σ, the degrees of freedom, a95 and N_MV of the default and of S5 on the paper's track."""
    default = evaluate(problem("vertical-comfort", weighting="Wb"), None).metrics
    assert default["a95_T"].value == pytest.approx(0.12324, abs=6e-6)
    assert "20.67 degrees of freedom" in default["a95_T"].at
    assert default["NMV_z"].value == pytest.approx(0.7395, abs=6e-5)
    assert default["NMV_z"].at == "over the trailing bogie, very comfortable"
    s5 = evaluate(problem("vertical-comfort", weighting="Wb", cut_off=100), DEVICES["S5"]).metrics
    assert s5["NMV_z"].value == pytest.approx(0.7628, abs=2e-4)


@pytest.mark.long
def test_a95_of_a_simulated_ride():
    """Sums of cosines of random phase with the densities of the default: 4000 values of five seconds each."""
    vehicle = SideView(weighting=Weighting("Wb"))
    closed = ClosedVehicle(vehicle, {"secondary": vehicle.airspring()})
    step, count = 0.005, 2**22
    omega = 2 * np.pi * np.fft.rfftfreq(count, step)
    S = closed.on(WEIGHTED).density("acceleration_T", np.maximum(omega[::64], 1e-6))
    amplitude = np.sqrt(2 * np.interp(omega, omega[::64], S) * (omega[1] - omega[0]))
    phase = np.exp(2j * np.pi * np.random.default_rng(7).random(len(omega)))
    z = np.fft.irfft(amplitude * phase, count) * count / 2
    block = round(5 / step)
    rms = np.sqrt((z[: count // block * block].reshape(-1, block) ** 2).mean(axis=1))
    expected = vehicle.metrics["a95_T"].measure(closed).value
    assert np.quantile(rms, 0.95) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(
    ("name", "weighting", "device", "expected"),
    [
        ("vertical-comfort", "Wb", None, {"Wz_L": 2.1285, "Wz_M": 1.7777, "Wz_T": 2.2662}),
        ("vertical-comfort", "Wb", DEVICES["S5"], {"Wz_L": 2.1605, "Wz_M": 1.7986, "Wz_T": 2.2240}),
        ("lateral-comfort", "Wd", "S1 c=2e4", {"Wz_y": 2.6513}),
        ("lateral-comfort", "Wd", "S3 c=2.1025e4 b=1.53e4", {"Wz_y": 2.6551}),
    ],
)
def test_sperling_s_index(name, weighting, device, expected):
    found = evaluate(problem(name, weighting=weighting), device).metrics
    for metric, value in expected.items():
        assert found[metric].value == pytest.approx(value, abs=6e-5)
        assert found[metric].at == (
            "more pronounced but not unpleasant"
            if value > 2.5
            else "clearly noticeable"
            if value > 2
            else "just noticeable"
        )


# --- searches, bound, conditions ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "weighting", "entry", "best"),
    [
        ("vertical-comfort", "Wb", "S4", 0.97340 * 0.098),
        ("vertical-comfort", "Wb", "S5", 0.96754 * 0.098),
        ("lateral-comfort", "Wd", "S1", 0.155861),
        ("lateral-comfort", "Wd", "S2", 0.154049),
        ("lateral-comfort", "Wd", "S3", 0.144696),
    ],
)
def test_optima_of_layouts(name, weighting, entry, best):
    """As good as what another optimiser found; weighting reverses what the vertical layouts of [Jiang2012] gain."""
    design = optimise(problem(name, weighting=weighting), layout(entry), starts=2, any_values=True)
    assert design.objective.value <= best * (1 + 5e-5)
    assert design.objective.value >= best * (1 - 1e-3)


@pytest.mark.parametrize(("name", "weighting"), [("vertical-comfort", "Wb"), ("lateral-comfort", "Wd")])
def test_a_weighting_before_the_vehicle_is_one_behind_it(name, weighting):
    """What the closed loop answers to white noise through the weighting is W times what it answers without."""
    posed = problem(name, weighting=weighting)
    omega = np.geomspace(0.1, 600, 40)
    vehicle, output = posed.vehicle, posed.vehicle.plant(WEIGHTED).outputs[-1]
    plain, through = (posed.vehicle.plant(load).responses(omega, output) for load in ("track", WEIGHTED))
    W = formula(weighting, 1j * omega)
    np.testing.assert_allclose(through.Tzw, W * plain.Tzw, rtol=1e-9)
    np.testing.assert_allclose(through.Tzf[:, 0] * through.Pvw[:, 0], W * plain.Tzf[:, 0] * plain.Pvw[:, 0], rtol=1e-9)
    assert vehicle.weighting == Weighting(weighting)


def test_the_weighted_bound_is_proven_and_its_file_says_what_of(tmp_path):
    posed = problem("vertical-comfort", weighting="Wb")
    found = bound(posed, L=14, omega0=(8.0, 25.0, 60.0))
    best = evaluate(posed, "c=20030 + b=58.48")
    assert 0.6 * best.objective.value < found.value < best.objective.value
    found.beside(best).save(tmp_path / "bound.json")
    again = load_bound(tmp_path / "bound.json")
    assert again.check() >= found.value
    assert again.problem is not None
    assert again.problem.vehicle == posed.vehicle
    assert any("weighted by Wb" in line for line in again.described())
    document = json.loads((tmp_path / "bound.json").read_text())
    document["about"]["weighting"] = "Wk"
    (tmp_path / "other.json").write_text(json.dumps(document))
    with pytest.raises(NotProven):
        load_bound(tmp_path / "other.json").check()


def test_metrics_of_two_inputs_have_no_common_bound():
    with pytest.raises(BadInput, match="are of different inputs"):
        bound(problem("vertical-comfort"), weights={"J1z_T_whole": 1.0, "aw_T": 1.0})


def test_a_weighting_takes_the_place_of_every_ride_figure():
    assert problem("vertical-comfort", weighting="Wb").objective == "aw_T"
    assert problem("vertical-comfort", weighting="Wb", position="M").objective == "aw_M"
    assert problem("vertical-comfort", weighting="Wb", position="worst").objective == "worst of aw_L, aw_M, aw_T"
    assert problem("vertical-comfort", weighting="Wb", objective="whole-band").objective == "aw_T"
    assert problem("vertical-comfort", weighting="Wb", objective="J1z_T").objective == "J1z_T"
    assert problem("vertical-comfort", weighting="none") == problem("vertical-comfort")
    assert problem("vertical-comfort", objective="aw_T").vehicle.weighting is None
    gauging = problem("lateral-gauging", weighting="Wd")
    assert (gauging.objective, gauging.keep) == ("max_yv", ("Ldmp", "max_aw_y"))


def test_what_figures_hold_under():
    posed = problem("vertical-comfort", weighting="Wb", vehicle={"V": 40.0})
    assert conditions(posed) == {
        "track": "paper",
        "speed": 40.0,
        "body": "rigid",
        "weighting": "Wb",
        "band": [0.0, None],
    }
    assert cautions(posed) == []
    assert in_words(problem("vertical-comfort")) == "on the paper's track at 55 m/s, unweighted, up to 20 Hz"
    (said,) = cautions(problem("vertical-comfort", weighting="Wb", cut_off=20))
    assert "cut at 20 Hz" in said
    assert cautions(problem("vertical-comfort", cut_off=15)) == []


@pytest.mark.parametrize(
    ("name", "options", "says"),
    [
        ("quarter-car", {"weighting": "Wb"}, "a weighting does not fit quarter-car"),
        ("vertical-comfort", {"weighting": "Wx"}, "no weighting is called 'Wx'"),
        ("vertical-comfort", {"cut_off": math.nan}, "the cut-off is nan Hz; give from 0.1 to 1000 Hz"),
        ("quarter-car", {"cut_off": 20}, "a cut-off does not fit quarter-car"),
        ("lateral-comfort", {"cut_off": 30}, "Macc ends at 20 Hz"),
        ("vertical-comfort", {"limits": {"NMV_z": 1.0}}, "'NMV_z' cannot be limited"),
        ("vertical-comfort", {"objective": "a95_T"}, "objective 'a95_T' does not fit"),
    ],
)
def test_bad_input(name, options, says):
    with pytest.raises(BadInput, match=says):
        problem(name, **options)


def test_the_weighting_of_the_lateral_default_is_that_of_the_standard():
    bare = PlanView()
    closed = ClosedVehicle(bare, {"secondary": Rational.spring(bare.Ksy) | Rational.damper(bare.Csy)})
    assert bare.metrics["aw_y"].measure(closed).value == pytest.approx(0.158525, abs=6e-7)


def test_a_range_of_speeds_counts_by_its_worst():
    posed = problem("vertical-comfort", standard="en12299", body="flexible", speed=[20, 60, 70])
    assert posed.objective == "worst-case aw_T"
    assert "worst of 3 speeds from 20 to 70 m/s" in in_words(posed)
    found = evaluate(posed, None).metrics
    for name, value in (("aw_T", 0.9543), ("aw_T at V=60", 1.1946), ("worst-case aw_T", 1.2525)):
        assert found[name].value / 0.098 == pytest.approx(value, abs=1.1e-4)


def test_a_standard_brings_its_weighting():
    assert problem("vertical-comfort", standard="en12299") == problem("vertical-comfort", weighting="Wb")
    assert problem("lateral-comfort", standard="EN 12299") == problem("lateral-comfort", weighting="Wd")
    with pytest.raises(BadInput, match="leave out Wk"):
        problem("vertical-comfort", standard="en12299", weighting="Wk")
    with pytest.raises(BadInput, match="no standard is called 'iso'"):
        problem("vertical-comfort", standard="iso")
    with pytest.raises(BadInput, match="0 speeds are too few"):
        problem("vertical-comfort", speed=[])


@pytest.mark.parametrize(("text", "found"), [("200 km/h", 200 / 3.6), ("30:40:5", [30, 35, 40]), ("41", 41)])
def test_speeds_as_they_are_written(text, found):
    assert read_speeds(text) == pytest.approx(found)


@pytest.mark.parametrize("text", ["30:70:7", "70:30:5", "30:x:5", "30:70", "30:70:0", "0:1e9:1e-9"])
def test_bad_ranges_of_speeds(text):
    with pytest.raises(BadInput, match="no range such as 30:70:5"):
        read_speeds(text)


@pytest.mark.parametrize(
    ("ks", "plain", "weighted", "damping"),
    [("1e7", 0.218018, 0.150301, 6.7566), ("2e6", 0.219077, 0.153096, 7.6227), ("5e5", 0.214225, 0.162395, 6.2479)],
)
def test_an_end_stiffness_of_the_lateral_device_is_a_spring_in_series(ks, plain, weighted, damping):
    found = evaluate(problem("lateral-comfort", weighting="Wd"), f"c=2.1025e4 + b=1.53e4 + k={ks}").metrics
    assert found["J1y"].value == pytest.approx(plain, abs=6e-7)
    assert found["aw_y"].value == pytest.approx(weighted, abs=6e-7)
    assert found["Ldmp"].value == pytest.approx(damping, abs=6e-5)


def test_a_free_end_stiffness_is_a_layout_of_one_s_own(tmp_path):
    """Freed, it is worth more than the inerter by itself: 4.4 % with both, unweighted."""
    path = tmp_path / "S3s.toml"
    path.write_text(
        'network = "k | (ks + c + b)"\nsource = "own"\ndescription = "S3 with an end stiffness"\n'
        '[elements.k]\nrole = "static spring"\nbounds = ["50 kN/m", "1 MN/m"]\n'
        '[elements.ks]\nbounds = ["100 kN/m", "10 MN/m"]\n[elements.c]\nbounds = ["100 N s/m", "1 MN s/m"]\n'
        '[elements.b]\nbounds = ["1 kg", "100 t"]\n'
    )
    design = optimise(problem("lateral-comfort", band_only=True), layout(str(path)), starts=4, any_values=True)
    assert design.objective.value <= 0.210589 * (1 + 5e-6)
    assert design.parameters["ks"] == pytest.approx(5.243e5, rel=0.02)
