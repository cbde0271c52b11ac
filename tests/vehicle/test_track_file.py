"""Measured tracks: drawn with a known spectrum, written in the formats that are read, faults in them, and read back."""

from __future__ import annotations

import numpy as np
import pytest

from posreal.errors import BadInput, Unsettled
from posreal.optimisation.evaluate import evaluate
from posreal.specification.conditions import cautions
from posreal.specification.named import problem
from posreal.study.cross_check import three_ways
from posreal.study.track_report import track_report
from posreal.vehicle.track import Track
from posreal.vehicle.track_file import BANDS, read_track

STEP = 0.25
ERRI = Track.erri("low")


def drawn(
    length: float, seed: int, band: tuple[float, float] = (1.0, 150.0), direction: str = "vertical"
) -> np.ndarray:
    """A profile of ERRI low between two wavelengths, m: cosines of random phase."""
    count = round(length / STEP)
    Omega = 2 * np.pi * np.fft.rfftfreq(count, STEP)
    S = np.zeros_like(Omega)
    inside = (Omega >= 2 * np.pi / band[1]) & (Omega <= 2 * np.pi / band[0])
    S[inside] = ERRI.density(Omega[inside], direction)
    phase = np.exp(2j * np.pi * np.random.default_rng(seed).random(len(Omega)))
    return np.fft.irfft(np.sqrt(2 * S * Omega[1]) * phase, count) * count / 2


def plain_file(
    path, profile, *, names=("distance [m]", "level left [mm]", "level right [mm]"), delimiter=",", scale=1e3
):
    place = STEP * np.arange(len(profile))
    lines = [delimiter.join(names)]
    lines += [
        delimiter.join(f"{x:.6g}" for x in (s, scale * y + 0.2, scale * y - 0.2))
        for s, y in zip(place, profile, strict=True)
    ]
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.fixture(scope="module")
def long_file(tmp_path_factory):
    return plain_file(tmp_path_factory.mktemp("track") / "plain.csv", drawn(24000.0, 3))


def test_bands_of_a_long_record(long_file):
    track = Track.from_file(long_file)
    for (short, long), tolerance in zip(BANDS.values(), (0.02, 0.03, 0.07), strict=True):  # which ends at 150 m
        assert track.rms(short, long) == pytest.approx(ERRI.rms(short, long), rel=tolerance)
    profile = track.measured.profiles["vertical"]
    assert profile.length == pytest.approx(24000 - STEP)
    assert profile.windows == pytest.approx(46, abs=1)
    assert track.lateral is None
    report = track_report(track, speed=55.0)
    assert report.rows[0].nearest == "erri-low"
    assert report.rows[0].apart_db < 0.7
    assert "windows: 90 % of a bin's estimates are from -" in str(report)


def test_ride_on_a_record_by_frequency_and_in_time(long_file):
    """The same figure from the density of the file and by running it through the vehicle, and from ERRI low itself."""
    design = evaluate(problem("vertical-comfort", track=Track.from_file(long_file), weighting="Wb"), None)
    ways = three_ways(design)
    assert ways.by_frequency == design.metrics["aw_T"].value
    assert ways.simulated == pytest.approx(ways.by_frequency, rel=0.02)
    assert abs(ways.simulated - ways.by_frequency) < 3 * ways.error
    expected = evaluate(problem("vertical-comfort", track="erri-low", weighting="Wb"), None).metrics["aw_T"].value
    assert ways.by_frequency == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(
    ("names", "delimiter", "scale"),
    [
        (("chainage [km]", "profile [m]", "profile right [m]"), ";", 1.0),
        (("x", "vertical", "vertical 2"), "\t", 1e3),
        (("Position (m)", "Longitudinal level left (mm)", "Longitudinal level right (mm)"), ",", 1e3),
    ],
)
def test_names_units_and_delimiters(tmp_path, names, delimiter, scale):
    profile = drawn(3000.0, 5)
    path = plain_file(tmp_path / "track.txt", profile, names=names, delimiter=delimiter, scale=scale)
    if "km" in names[0]:
        head, *rows = path.read_text().splitlines()
        moved = [
            delimiter.join([f"{float(row.split(delimiter)[0]) / 1e3:.6f}", *row.split(delimiter)[1:]]) for row in rows
        ]
        shifted = [row.replace(".", ",") for row in moved]  # a decimal comma, where semicolons part the cells
        path.write_text("\n".join([head, *shifted]))
    found = read_track(path).profiles["vertical"]
    assert found.step == pytest.approx(STEP)
    middle = found.pieces[0]
    np.testing.assert_allclose(middle - middle.mean(), profile - profile.mean(), atol=0.1 * profile.std())
    assert found.spectrum.rms(3, 25) == pytest.approx(ERRI.rms(3, 25), rel=0.15)


def recording_car(path, bands, *, start=130_100.25, spoil=()):
    """The format of the Finnish recording car: a date, quoted names, km+m, NaN and inv."""
    sides, kinds = ("Vasen", "Oikea"), {"vertical": "Korkeuspoikkeama", "lateral": "Nuolikorkeuspoikkeama"}
    names = ["SSCount", "Track", "Location [km+m]", "Ajonopeus [Km/h]", "TG Master.Kallistus [mm]"]
    columns = []
    for direction, kind in kinds.items():
        for band in BANDS:
            for side in sides:
                names.append(f"TG Master.{side} {kind} {band} [mm]")
                columns.append(1e3 * bands[direction, band] + (0.1 if side == "Vasen" else -0.1))
    names.append("TG Master.Vasen Korkeuspoikkeama D1 Keskihajonta [mm]")
    lines = ['"Running Date","22/11/2022 7:44:40 AM"', ",".join(f'"{name}"' for name in names)]
    for k, values in enumerate(np.array(columns).T):
        place = start + STEP * k
        cells = [f"{value:.4f}" for value in values]
        for first, last, cell in spoil:
            if first <= k < last:
                cells[0] = cell
        lines.append(f'{k},"006 LHRI 1","{int(place // 1000)}+{place % 1000:07.2f}",86.1,1.2,{",".join(cells)},9.99')
    path.write_text("\r\n".join(lines) + "\r\n")
    return lines


def car_bands(length, seed):
    return {
        (direction, band): drawn(length, seed + 7 * k, limits, direction)
        for direction in ("vertical", "lateral")
        for k, (band, limits) in enumerate(BANDS.items())
    }


def test_a_recording_car_s_bands_add_up(tmp_path):
    bands = car_bands(6000.0, 11)
    recording_car(tmp_path / "car.csv", bands)
    found = read_track(tmp_path / "car.csv")
    for direction in ("vertical", "lateral"):
        profile = found.profiles[direction]
        total = sum(bands[direction, band] for band in BANDS)
        np.testing.assert_allclose(
            profile.pieces[0],
            total - np.polyval(np.polyfit(np.arange(len(total)), total, 1), np.arange(len(total))),
            atol=2e-7,
        )
        assert profile.spectrum.band == (3.0, 150.0)
        assert len(profile.columns) == 6
        assert not any("Keskihajonta" in name for name in profile.columns)
    assert any("km+m" in note for note in found.notes)


def test_faults_end_pieces_and_are_said(tmp_path):
    """Three gaps, one of two cells; a station that jumps ahead, and one that comes twice."""
    bands = car_bands(5000.0, 23)
    spoil = [(3000, 3200, "NaN"), (9000, 9002, "inv"), (12000, 12400, "")]
    lines = recording_car(tmp_path / "car.csv", bands, spoil=spoil)
    cells = [line.split(",") for line in lines[2:]]
    for k, row in enumerate(cells):  # the second part is 37 m further on, the last begins again 10 m before its end
        km, metres = row[2].strip('"').split("+")
        place = 1e3 * float(km) + float(metres) + (37.0 if k >= 6000 else 0.0) - (10.0 if k >= 15000 else 0.0)
        row[2] = f'"{int(place // 1000)}+{place % 1000:07.2f}"'
    (tmp_path / "faults.csv").write_text("\r\n".join([*lines[:2], *(",".join(row) for row in cells)]))
    found = read_track(tmp_path / "faults.csv")
    profile = found.profiles["vertical"]
    assert [round(len(piece), -1) for piece in profile.pieces] == [3000, 2800, 6000, 2600, 5000]
    text = "; ".join(found.notes)
    assert "602 of 20000 values are no numbers: 2 gaps, 2 values bridged" in text
    assert "at 2 places the stations jump or come twice" in text
    assert len(found.profiles["lateral"].pieces) == 3  # whose cells are all there
    assert profile.spectrum.rms(3, 25) == pytest.approx(ERRI.rms(3, 25), rel=0.1)


def test_d1_alone_loses_the_ride_and_is_said_to(tmp_path):
    plain_file(
        tmp_path / "d1.csv",
        drawn(6000.0, 2, (3.0, 25.0)),
        names=("distance [m]", "level D1 left [mm]", "level D1 right [mm]"),
    )
    posed = problem("vertical-comfort", track=str(tmp_path / "d1.csv"))
    assert posed.vehicle.irregularity.vertical.band == (3.0, 25.0)
    said = " ".join(cautions(posed))
    assert "the track has 3 to 25 m and nothing else, which at 55 m/s are 2.2 to 18.3 Hz" in said
    larger = float(said.split(" % larger")[0].split()[-1])
    assert larger == pytest.approx(100 * (1.5166 / 0.4286 - 1), rel=0.1)
    assert evaluate(posed, None).metrics["J1z_T"].value == pytest.approx(0.4286, rel=0.05)


def test_columns_by_number_and_name(tmp_path):
    """Numbered columns without names, and another column of a table by its name, taken for either direction."""
    profile, other = drawn(2000.0, 1), drawn(2000.0, 9)
    table = np.column_stack([STEP * np.arange(len(profile)), 3.0 + 0 * profile, profile, other])
    np.savetxt(tmp_path / "numbers.txt", table, fmt="%.7g")
    by_number = Track.read(f"{tmp_path / 'numbers.txt'}:3")
    assert by_number.name == "numbers.txt:3"
    both = Track.from_file(tmp_path / "numbers.txt", column="3,4")
    mean = both.measured.profiles["lateral"].pieces[0]
    np.testing.assert_allclose(np.diff(mean), np.diff((profile + other) / 2), atol=2e-7)
    np.savetxt(
        tmp_path / "named.csv",
        table,
        fmt="%.7g",
        delimiter=",",
        header="s [m],gauge [m],dips [m],bends [m]",
        comments="",
    )
    assert Track.from_file(tmp_path / "named.csv", column="dips [m]").vertical == by_number.vertical


@pytest.mark.parametrize(
    ("text", "column", "says"),
    [
        ("a,b\n" * 3, None, "has 3 lines"),
        ("s [m],level [mm]\n" + "1,2\n" * 60, None, "do not move"),
        ("s [m],level [mm]\n" + "".join(f"{k},nan\n" for k in range(60)), None, "no piece of"),
        ("s [m],colour\n" + "".join(f"{k},2\n" for k in range(60)), None, "no column that is a longitudinal level"),
        ("s [m],level [mm]\n" + "".join(f"{k},0\n" for k in range(400)), None, "all zero"),
        ("s [m],level [mm]\n" + "".join(f"{k},2\n" for k in range(60)), "7", "no column '7'; it has 2"),
        ("s [m],level [mm]\n" + "".join(f"x,{k}\n" for k in range(60)), None, "has 0 distances"),
    ],
)
def test_bad_files(tmp_path, text, column, says):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    with pytest.raises(BadInput, match=says):
        Track.from_file(path, column)


def test_a_file_that_is_not_there():
    with pytest.raises(BadInput, match="there is no such file"):
        problem("vertical-comfort", track="nowhere/track.csv:2")


def test_a_short_record_is_not_run_through_in_time(tmp_path):
    path = plain_file(tmp_path / "short.csv", drawn(900.0, 4))
    track = Track.from_file(path)
    assert any("rests on" in note for note in track.measured.notes)
    with pytest.raises(Unsettled, match="too short"):
        three_ways(evaluate(problem("vertical-comfort", track=track), None))
