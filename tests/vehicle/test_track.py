"""Standard tracks: their densities against nodes and figures computed elsewhere, their filters against the densities,
the fits against the laws, and whole vehicles on them against the equations solved one frequency at a time."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from posreal.admittance import Rational
from posreal.bounds.certificate import NotProven
from posreal.bounds.compute import bound
from posreal.bounds.file import load_bound
from posreal.errors import BadInput
from posreal.metric import ClosedVehicle
from posreal.optimisation.evaluate import evaluate
from posreal.optimisation.layout_values import optimise
from posreal.optimisation.scaling import reference
from posreal.plant.figures import ClosedPlant
from posreal.plant.quadrature import gauss
from posreal.specification.conditions import cautions, conditions, in_words
from posreal.specification.layout import layout
from posreal.specification.named import problem
from posreal.synthesis.generalised_plant import generalised_plant
from posreal.vehicle import PlanView, SideView
from posreal.vehicle.spectrum import RationalLaw, Spectrum, fitted
from posreal.vehicle.track import Track, standard
from tests.vehicle import naive

RMS = [  # mm over 3–25, 25–70, 70–150 m
    ("erri-low", "vertical", 0.9843, 1.6507, 2.1225),
    ("erri-high", "vertical", 1.6109, 2.7016, 3.4737),
    ("erri-low", "lateral", 0.7135, 1.1967, 1.5387),
    ("erri-high", "lateral", 1.2131, 2.0345, 2.6160),
    ("fra-4", "vertical", 2.2764, 5.4819, 13.614),
    ("fra-6", "vertical", 1.2906, 3.1080, 7.7184),
    ("fra-5", "lateral", 1.5398, 4.1189, 11.104),
    ("aar-6", "vertical", 1.4291, 2.4243, 3.2759),
    ("china", "vertical", 0.2864, 0.3623, 0.7647),
    ("china", "lateral", 0.2609, 0.3272, 0.4120),
    ("uk", "vertical", 2.3452, 3.3541, 4.4721),
]
# nodes of B176 high in m²/(1/m) at n = 0.02, 0.1, 0.2 1/m, as a multibody program prints them
B176_HIGH = {"lateral": (2.3194e-4, 6.1608e-6, 7.3333e-7), "vertical": (4.0897e-4, 1.0863e-5, 1.2931e-6)}


@pytest.mark.parametrize(("name", "direction", "short", "middle", "long"), RMS)
def test_root_mean_squares(name, direction, short, middle, long):
    track = Track.named(name)
    for (low, high), expected in zip(((3, 25), (25, 70), (70, 150)), (short, middle, long), strict=True):
        assert 1e3 * track.rms(low, high, direction) == pytest.approx(expected, rel=7e-5, abs=6e-5)


@pytest.mark.parametrize(("direction", "nodes"), B176_HIGH.items())
def test_nodes_of_b176(direction, nodes):
    """One-sided over the wave number: 2π S(2πn)."""
    n = np.array([0.02, 0.1, 0.2])
    np.testing.assert_allclose(2 * np.pi * Track.erri("high").density(2 * np.pi * n, direction), nodes, rtol=1e-4)


@pytest.mark.parametrize("name", standard())
def test_a_filter_has_the_density_of_its_spectrum(name):
    """|F(jω)|² of white noise of density 1 is ω^2k S(ω/V)/V, at any speed; of a fit within its stated error."""
    track, speed = Track.named(name), 41.0
    for direction in ("vertical", "lateral"):
        spectrum = track.vertical if direction == "vertical" else track.lateral
        if spectrum is None:
            continue
        fit = spectrum.fitted()
        derivative = 2 if direction == "lateral" else max(1, fit.law.least_derivative())
        F, error = spectrum.shaping(speed, derivative=derivative)
        shortest, longest = spectrum.band
        omega = np.geomspace(2 * np.pi / longest, 2 * np.pi / shortest, 60) * speed
        expected = omega ** (2 * derivative) * spectrum.density(omega / speed) / speed
        off = 10 * np.log10(np.abs(F(1j * omega)) ** 2 / expected)
        assert error == fit.rms_db
        if spectrum.exact:
            assert np.abs(off).max() < 1e-9
        else:
            assert 0 < fit.rms_db < 0.35
            assert np.abs(off).max() <= fit.max_db * 1.001


def test_fits_are_as_good_as_another_program_s():
    china, sncf = Track.named("china"), Track.named("sncf")
    assert fitted(china.lateral.law, (2, 200), 3).rms_db == pytest.approx(0.25, abs=5e-3)
    assert fitted(china.lateral.law, (2, 200), 3).max_db == pytest.approx(0.78, abs=5e-3)
    assert fitted(china.vertical.law, (2, 200), 4).rms_db == pytest.approx(0.32, abs=5e-3)
    assert fitted(china.vertical.law, (2, 200), 4).max_db == pytest.approx(1.15, abs=5e-3)
    assert fitted(sncf.vertical.law, (2, 40), 3).rms_db < 0.10


def test_a_fit_of_a_fraction_is_the_fraction():
    law = RationalLaw(3e-7, (0.2,), (0.05, 0.6, 1.1))
    found = fitted(law, (1.0, 300.0), 3)
    assert found.rms_db < 1e-5
    np.testing.assert_allclose(found.law.poles, law.poles, rtol=1e-4)


# --- whole vehicles ---------------------------------------------------------------------------------------------------

S5 = "S5 c=17965 b=4115"
RIDES = [  # none to 20 Hz, then Wb over all frequencies, %g at L, M, T
    ("erri-low", None, "1.1244 .7041 1.5166", ".5239 .3084 .6525"),
    ("erri-low", S5, "1.0628 .6368 1.2764", ".5829 .3297 .6415"),
    ("fra-4", None, "4.3034 3.4698 6.1192", "1.6803 1.2305 2.3574"),
    ("fra-6", S5, "2.2085 1.7352 2.8446", ".9401 .6373 1.1565"),
    ("aar-6", None, "1.6598 1.0556 2.2472", ".7680 .4568 .9617"),
    ("china", None, ".2838 .2074 .3845", ".1412 .0897 .1723"),
]


@pytest.mark.parametrize(("name", "device", "plain", "weighted"), RIDES)
def test_ride_of_the_side_view(name, device, plain, weighted):
    found = evaluate(problem("vertical-comfort", track=name, weighting="Wb"), device).metrics
    for point, unweighted, with_wb in zip("LMT", plain.split(), weighted.split(), strict=True):
        assert found[f"J1z_{point}"].value == pytest.approx(float(unweighted), abs=1.1e-4)
        assert found[f"aw_{point}"].value / 0.098 == pytest.approx(float(with_wb), abs=1.1e-4)


@pytest.mark.parametrize(
    ("name", "speed", "device", "plain", "weighted"),
    [
        ("erri-low", 45, "S1 c=2e4", 0.112941, 0.089774),
        ("erri-low", 45, "S3 c=2.1025e4 b=1.53e4", 0.108960, 0.083509),
        ("fra-5", 45, "S1 c=2e4", 0.335914, 0.288563),
        ("fra-5", 45, "S3 c=2.1025e4 b=1.53e4", 0.323472, 0.271477),
    ],
)
def test_ride_of_the_plan_view(name, speed, device, plain, weighted):
    posed = problem("lateral-comfort", track=name, weighting="Wd", vehicle={"V": speed})
    vehicle = posed.vehicle
    closed = ClosedVehicle(vehicle, {"secondary": evaluate(problem("lateral-comfort"), device).port})
    assert vehicle.metrics["J1y"].measure(closed).value == pytest.approx(plain, rel=3e-5)
    assert vehicle.metrics["aw_y"].measure(closed).value == pytest.approx(weighted, rel=1e-5)


@pytest.mark.parametrize("name", ["fra-3", "china", "sncf"])
def test_a_side_view_on_a_track_is_its_equations(name):
    """The equations one frequency at a time, with the density of the profile under the first wheel."""
    vehicle, track = SideView(V=37.0), Track.named(name)
    port = Rational.spring(vehicle.bush) + Rational.damper(1.2e4)
    start = 0.0 if track.vertical.exact else track.vertical.support[0] * vehicle.V
    rule = gauss(0.7, start=start, stop=40 * math.pi, per_decade=10)
    S = track.density(rule.omega / vehicle.V) / vehicle.V
    z = [naive.vertical(vehicle, lambda s: port(np.array([s]))[0], w)["acceleration_M"] * 1j * w for w in rule.omega]
    expected = math.sqrt(float(rule.weight @ (S * np.abs(np.array(z)) ** 2)))
    posed = problem("vertical-comfort", track=name, vehicle={"V": 37.0}).vehicle
    closed = ClosedVehicle(posed, {"secondary": posed.airspring() | port})
    found = closed.on("track").band_rms("acceleration_M").value
    assert found == pytest.approx(expected, rel=2e-4 if name == "china" else 1e-6)  # whose law has corners


def test_the_paper_s_half_is_its_own():
    """uk is the paper's profile read one-sided, so twice the variance; laterally it is the paper's filter."""
    mine, theirs = problem("vertical-comfort", track="uk"), problem("vertical-comfort", track="paper")
    ratio = evaluate(mine, S5).metrics["J1z_T"].value / evaluate(theirs, S5).metrics["J1z_T"].value
    assert ratio == pytest.approx(math.sqrt(2), rel=1e-9)
    assert theirs == problem("vertical-comfort")
    across = problem("lateral-comfort", track="uk")
    assert evaluate(across, "S1 c=2e4").metrics["J1y"].value == pytest.approx(0.220375, abs=6e-7)


@pytest.mark.parametrize(
    ("weighting", "entry", "best"),
    [("none", "S5", 1.25170), ("none", "S4", 1.33680), ("Wb", "S4", 0.62008 * 0.098), ("Wb", "S5", 0.62060 * 0.098)],
)
def test_optima_on_erri_low(weighting, entry, best):
    design = optimise(
        problem("vertical-comfort", weighting=weighting, track="erri-low"), layout(entry), starts=2, any_values=True
    )
    assert best * (1 - 1e-3) < design.objective.value <= best * (1 + 5e-5)


def test_wavelengths_that_are_left_out():
    """Bands of ERRI low at 55 m/s: those of a recording car's D1 alone lose the body's own motion."""
    expected = {(3, 25): (0.4286, 0.3294), (25, 70): (1.1827, 0.4669), (70, 150): (0.8407, 0.3122)}
    expected |= {(3, 150): (1.5130, 0.6511)}
    for band, (plain, weighted) in expected.items():
        posed = problem("vertical-comfort", track="erri-low", wavelengths=band, weighting="Wb")
        found = evaluate(posed, None).metrics
        assert found["J1z_T"].value == pytest.approx(plain, abs=7e-5)
        assert found["aw_T"].value / 0.098 == pytest.approx(weighted, abs=1.1e-4)


@pytest.mark.parametrize("name", ["paper", "uk"])
def test_a_part_of_a_white_track(name):
    """Whose velocity is white, so that the filter near it is a number."""
    posed = problem("vertical-comfort", track=name, wavelengths=(0.5, 3000.0))
    whole = evaluate(problem("vertical-comfort", track=name), S5).metrics["J1z_T"].value
    assert evaluate(posed, S5).metrics["J1z_T"].value == pytest.approx(whole, rel=1e-3)
    scale = reference(posed)
    plant = generalised_plant(posed, scale)
    assert np.isfinite(plant.A).all()
    assert bound(posed, L=8, omega0=10.0).value > 0


def test_a_sampled_density_and_a_filter_give_the_same():
    """A limited ERRI spectrum goes by frequency, the whole one by covariance: with wide limits they agree."""
    limited = problem("vertical-comfort", track="erri-low", wavelengths=(0.02, 30000.0), weighting="Wb")
    whole = problem("vertical-comfort", track="erri-low", weighting="Wb")
    first, second = (evaluate(posed, S5).metrics for posed in (limited, whole))
    for name in ("aw_L", "aw_T", "a95_T", "J1z_T", "Wz_M", "deflection_rms_rear"):
        assert first[name].value == pytest.approx(second[name].value, rel=2e-5)


def test_search_on_a_track_without_a_filter():
    """A search needs no fraction; the design is measured on the track itself, and a caution says what a bound takes."""
    posed = problem("vertical-comfort", track="china", weighting="Wb")
    design = optimise(posed, layout("S5"), starts=2, any_values=True)
    assert design.objective.value < evaluate(posed, None).objective.value
    design.check()
    (said,) = cautions(posed)
    assert "0.32 dB" in said


def test_a_bound_on_a_track_is_proven_and_its_file_says_what_of(tmp_path):
    posed = problem("vertical-comfort", track="fra-6", weighting="Wb")
    found = bound(posed, L=12, omega0=(8.0, 25.0, 60.0))
    assert 0.5 * 1.1565 * 0.098 < found.value < 1.1565 * 0.098
    found.save(tmp_path / "bound.json")
    again = load_bound(tmp_path / "bound.json")
    assert again.check() >= found.value
    assert again.problem is not None
    assert again.problem.vehicle == posed.vehicle
    assert any("fra-6" in line for line in again.described())
    document = json.loads((tmp_path / "bound.json").read_text())
    document["about"]["track"] = "aar-6"
    (tmp_path / "other.json").write_text(json.dumps(document))
    with pytest.raises(NotProven):
        load_bound(tmp_path / "other.json").check()


def test_a_bound_on_a_fitted_track_is_stored_as_a_plant(tmp_path):
    posed = problem("vertical-comfort", track="china", weighting="Wb")
    found = bound(posed, L=12, omega0=(8.0, 25.0, 60.0))
    found.save(tmp_path / "bound.json")
    again = load_bound(tmp_path / "bound.json")
    assert again.problem is None
    assert again.check() >= found.value
    assert in_words(posed, whole_band=True).startswith("on the filter near china at 55 m/s")


def test_gains_are_of_the_profile_and_not_of_the_track():
    name = "gain_acceleration_T"
    plain = evaluate(problem("vertical-comfort", objective=name), None).metrics[name].value
    other = evaluate(problem("vertical-comfort", objective=name, track="fra-4"), None).metrics[name].value
    assert other == plain


def test_a_track_driven_by_acceleration_is_the_same_vehicle():
    """ERRI by the velocity of the profile and by its acceleration: the same figures."""
    from posreal.vehicle.side_view import from_acceleration
    from posreal.vehicle.track import shaken

    vehicle = SideView()
    spectrum, plant = Track.erri("low").vertical, vehicle.plant("slope")
    ports = {"secondary": vehicle.airspring() | (Rational.spring(vehicle.bush) + Rational.damper(1e4))}
    one = ClosedPlant(shaken(plant, spectrum, vehicle.V, 1), ports)
    other = ClosedPlant(shaken(from_acceleration(plant), spectrum, vehicle.V, 2), ports)
    for output in plant.outputs:
        if output.startswith(("acc", "deflection_f")):
            assert other.band_rms(output).value == pytest.approx(one.band_rms(output).value, rel=1e-8)


# --- what is said, and what is refused --------------------------------------------------------------------------------


def test_conditions_name_the_track():
    posed = problem("vertical-comfort", track="erri-low", weighting="Wb")
    assert conditions(posed)["track"] == "erri-low"
    assert in_words(posed) == "on erri-low at 55 m/s, weighted by Wb, over all frequencies"
    assert in_words(problem("vertical-comfort")) == "on the paper's track at 55 m/s, unweighted, up to 20 Hz"
    limited = problem("vertical-comfort", track="erri-low", wavelengths=(3, 25))
    assert in_words(limited).startswith("on erri-low, 3 to 25 m, at 55 m/s")


@pytest.mark.parametrize(
    ("name", "options", "says"),
    [
        ("vertical-comfort", {"track": "erri"}, "no track is called 'erri'"),
        ("lateral-comfort", {"track": "sncf"}, "the track sncf has no alignment"),
        ("quarter-car", {"track": "erri-low"}, "a track does not fit quarter-car"),
        ("vertical-comfort", {"wavelengths": (25, 3)}, "wavelengths 25 to 3 m are none"),
        (
            "vertical-comfort",
            {"track": Track.named("sncf").between(3, 30), "wavelengths": (50, 90)},
            "nothing is left between 50 and 90 m",
        ),
        ("vertical-comfort", {"speed": -3.0}, "V"),
        ("lateral-comfort", {"track": "uk", "wavelengths": (3, 90)}, "has no alignment"),
    ],
)
def test_bad_input(name, options, says):
    with pytest.raises(BadInput, match=says):
        problem(name, **options)


def test_a_spectrum_that_ends_is_nothing_outside():
    spectrum = Spectrum(RationalLaw(1e-6, (), (0.1, 0.9)), (3.0, 150.0)).between(3.0, 25.0)
    inside, outside = spectrum.density(2 * np.pi / np.array([10.0, 30.0]))
    assert inside > 0
    assert outside == 0
    assert spectrum.rms(30.0, 100.0) == 0.0


def test_the_lateral_track_of_a_plan_view_is_its_alignment():
    bare = PlanView(irregularity=Track.erri("high"))
    assert bare.plant("track").shaping is not None
    s = 2j * np.pi * np.geomspace(0.1, 20, 30)
    expected = np.abs(s) ** 4 * Track.erri("high").density(np.abs(s) / bare.V, "lateral") / bare.V
    np.testing.assert_allclose(np.abs(bare.plant("track").shaping(s)) ** 2, expected, rtol=1e-9)
