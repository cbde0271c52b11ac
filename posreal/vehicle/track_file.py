"""Measured track: columns of a text file as profiles over the distance, and their spectra.

Read are tables with a header, delimited by comma, semicolon, tab or blanks: a distance (m, km, or km+m) and
longitudinal levels or alignments of the left and the right rail (mm or m), whose mean is taken; a recording car's bands
D1 (3–25 m), D2 (25–70 m) and D3 (70–150 m) are added, phases kept [EN13848]. Or any columns by name or number. Cells
that are no number (NaN, inv, nothing) and stations that jump or come twice end a piece; short gaps are bridged.

The density is Welch's: pieces at an even step, straight lines taken off, windows of Hann half over each other, and the
bins of a twelfth of an octave averaged [Welch1967]. Of K windows it has about ν = 2K/(1 + 2(1 − 1/K)/36) degrees of
freedom a bin.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from posreal.errors import BadInput, listed, plain, shown
from posreal.files import read_text
from posreal.plant.plant import Real
from posreal.vehicle.spectrum import Spectrum, TableLaw

Direction = Literal["vertical", "lateral"]

BANDS = {"D1": (3.0, 25.0), "D2": (25.0, 70.0), "D3": (70.0, 150.0)}
_LARGEST_FILE = 200_000_000  # bytes
_MOST_ROWS = 5_000_000
_BRIDGED = 3  # samples: a gap over which a line is drawn
_WINDOW = 600.0  # m: four times the longest wavelength of D3
_USED = 0.6  # of all values, in pieces that are no shorter than a window
_SHORTEST = 32  # samples of a window
_PERIODS = 4.0  # of the longest wavelength in a window
_SAMPLES = 4.0  # of the shortest wavelength
_PER_OCTAVE = 12
_MILLIMETRES = 0.1  # r.m.s. of numbers that are millimetres rather than metres
_KILOMETRES = 0.02  # median step of numbers that are kilometres rather than metres

_PLACE = re.compile(r"location|distance|chainage|station|kilomet|position|sijainti|^\s*(s|x|km|m)\s*($|[\[(])", re.I)
_VERTICAL = re.compile(r"longitudinal|vertical|profile|level|(?<!nuoli)korkeus|pysty|^\s*z", re.I)
_LATERAL = re.compile(r"alignment|lateral|nuolikorkeus|sivu|^\s*y", re.I)
_NOT_A_PROFILE = re.compile(r"keskihajonta|std|deviation|muutos|cross|cant|kallistus|gauge|leveys|twist|kierous", re.I)
_UNIT = re.compile(r"[\[(]\s*(km\+m|km|mm|cm|m)\s*[\])]", re.I)
_SCALES = {"m": 1.0, "mm": 1e-3, "cm": 1e-2}


@dataclass(frozen=True)
class Profile:
    """One direction of a measured track.

    Attributes
    ----------
    step : m
    pieces : arrays of the profile in m, each even over the distance
    spectrum : Spectrum
    windows : int
        Of the estimate.
    columns : tuple of str
    """

    step: float
    pieces: tuple[Real, ...] = field(repr=False)
    spectrum: Spectrum
    windows: int
    columns: tuple[str, ...]

    @property
    def length(self) -> float:
        """Of all pieces together, m."""
        return self.step * sum(len(piece) - 1 for piece in self.pieces)

    @property
    def freedom(self) -> float:
        """Degrees of freedom of one bin of the density."""
        return 2 * self.windows / (1 + 2 * (1 - 1 / self.windows) / 36)


@dataclass(frozen=True)
class MeasuredTrack:
    """What a file holds, by direction, and what was made of it, in sentences."""

    profiles: Mapping[Direction, Profile]
    notes: tuple[str, ...]


def read_track(path: str | Path, column: str | None = None) -> MeasuredTrack:
    """Read a file.

    Parameters
    ----------
    path : path
    column : str, optional
        Columns by name or number, from 1 and parted by commas, whose mean is both the profile and the alignment.

    Raises
    ------
    BadInput
        If it is no table, has no distance or no column of that name, or too little of it is numbers.
    """
    where = plain(path)
    header, rows = _table(read_text(path, _LARGEST_FILE), where)
    place = _place_column(header)
    distance, said = _distances(header, rows, place, where)
    wanted: dict[Direction, dict[str, list[int]]] = {}
    if column is None:
        for direction, pattern, other in (("vertical", _VERTICAL, _LATERAL), ("lateral", _LATERAL, None)):
            found = _columns(header, pattern, other, place)
            if found:
                wanted[direction] = found  # type: ignore[index]
        if not wanted:
            raise BadInput(
                f"{where} has no column that is a longitudinal level or an alignment by its name; name one as in "
                f"FILE:column, of {listed(shown(name) for name in header[:20])}"
            )
    else:
        chosen = {"": [_chosen(header, part.strip(), where) for part in column.split(",")]}
        wanted = {"vertical": chosen, "lateral": chosen}
    profiles, notes = {}, [said]
    for direction, parts in wanted.items():
        profile, more = _profile(header, rows, distance, parts, where)
        profiles[direction] = profile
        notes += [one for one in more if one not in notes]
    return MeasuredTrack(profiles, tuple(notes))


# --- the table --------------------------------------------------------------------------------------------------------


def _table(text: str, where: str) -> tuple[list[str], list[list[str]]]:
    """Names of the columns and rows of cells."""
    lines = text.splitlines()
    if lines and lines[0].lower().lstrip('"').startswith("running date"):
        lines = lines[1:]
    lines = [line for line in lines if line.strip() and not line.lstrip().startswith("#")]
    if len(lines) < _SHORTEST:
        raise BadInput(f"{where} has {len(lines)} lines; a track is a table of at least {_SHORTEST}")
    if len(lines) > _MOST_ROWS:
        raise BadInput(f"{where} has more than {_MOST_ROWS} lines; give a part of it")
    middle = lines[len(lines) // 2]
    delimiter = next((mark for mark in (";", "\t", ",") if mark in middle), None)
    if delimiter is None:
        rows = [line.split() for line in lines]
    else:
        rows = [
            [cell.strip() for cell in row] for row in csv.reader(io.StringIO("\n".join(lines)), delimiter=delimiter)
        ]
    if delimiter == ";":
        rows = [rows[0], *([cell.replace(",", ".") for cell in row] for row in rows[1:])]
    if all(_number(cell) is not None or not cell for cell in rows[0]):
        return [f"column {k}" for k in range(1, len(rows[0]) + 1)], rows
    return rows[0], rows[1:]


def _number(cell: str) -> float | None:
    try:
        value = float(cell)
    except ValueError:
        return None
    return value if math.isfinite(value) else None


def _values(rows: list[list[str]], column: int) -> Real:
    """A column as numbers, NaN where there is none."""
    cells = (row[column] if column < len(row) else "" for row in rows)
    return np.array([math.nan if (value := _number(cell)) is None else value for cell in cells])


def _place_column(header: Sequence[str]) -> int:
    """Which column is the distance; the first where none says so."""
    return next((k for k, name in enumerate(header) if _PLACE.search(name)), 0)


def _unit(name: str) -> str | None:
    found = _UNIT.search(name)
    return None if found is None else found[1].lower()


def _distances(header: Sequence[str], rows: list[list[str]], place: int, where: str) -> tuple[Real, str]:
    """Distance of every row in m."""
    unit = _unit(header[place])
    cells = [row[place] if place < len(row) else "" for row in rows]
    if unit == "km+m" or any("+" in cell[1:] for cell in cells[:20]):
        parts = [cell.split("+") for cell in cells]
        km = np.array([_number(part[0]) if len(part) == 2 else None for part in parts], dtype=float)
        metres = np.array([_number(part[1]) if len(part) == 2 else None for part in parts], dtype=float)
        found, said = 1e3 * km + metres, "km+m"
    else:
        found = _values(rows, place)
        steps = np.abs(np.diff(found[np.isfinite(found)]))
        median = float(np.median(steps[steps > 0])) if np.any(steps > 0) else 0.0
        said = unit or ("km" if median < _KILOMETRES else "m")
        found = found * (1e3 if said == "km" else _SCALES.get(said, 1.0))
    good = int(np.isfinite(found).sum())
    if good < _SHORTEST:
        raise BadInput(
            f"the column {shown(header[place])} of {where} has {good} distances; a track needs at least {_SHORTEST}"
        )
    return found, f"distance from {shown(header[place])}, in {said}"


def _columns(
    header: Sequence[str], pattern: re.Pattern[str], other: re.Pattern[str] | None, place: int
) -> dict[str, list[int]]:
    """Columns of a direction by band, '' where their names tell none; of bands all, or what has none."""
    found: dict[str, list[int]] = {}
    for k, name in enumerate(header):
        if k == place or _NOT_A_PROFILE.search(name) or not pattern.search(name) or (other and other.search(name)):
            continue
        band = re.search(r"\bD([0-3])\b", name)
        found.setdefault("" if band is None else f"D{band[1]}", []).append(k)
    bands = {band: found[band] for band in BANDS if band in found}
    return bands or ({"": found[""]} if "" in found else {})


def _chosen(header: Sequence[str], text: str, where: str) -> int:
    """A column by its name or its number."""
    if text in header:
        return list(header).index(text)
    if text.isdigit() and 1 <= int(text) <= len(header):
        return int(text) - 1
    raise BadInput(
        f"{where} has no column {shown(text)}; it has {len(header)}, by number or by name: "
        f"{listed(shown(name) for name in header[:20])}"
    )


# --- profiles ---------------------------------------------------------------------------------------------------------


def _profile(
    header: Sequence[str], rows: list[list[str]], distance: Real, parts: Mapping[str, list[int]], where: str
) -> tuple[Profile, list[str]]:
    total, names = np.zeros(len(rows)), []
    for columns in parts.values():
        sides = np.array([_values(rows, k) * _scale(header[k], _values(rows, k)) for k in columns])
        total = total + sides.mean(axis=0)
        names += [header[k] for k in columns]
    step, pieces, notes = _pieces(distance, total, where)
    spectrum, windows = _welch(pieces, step, [band for band in parts if band], where)
    if windows < 8:
        notes.append(f"the density rests on {windows} window{'s' if windows > 1 else ''}: a longer record is surer")
    return Profile(step, tuple(pieces), spectrum, windows, tuple(names)), notes


def _scale(name: str, values: Real) -> float:
    """Metres in a column's unit: as its name says, or by the size of its numbers."""
    unit = _unit(name)
    if unit in _SCALES:
        return _SCALES[unit]
    finite = values[np.isfinite(values)]
    return 1e-3 if len(finite) and float(np.std(finite)) > _MILLIMETRES else 1.0


def _pieces(distance: Real, value: Real, where: str) -> tuple[float, list[Real], list[str]]:
    """Even pieces between gaps and jumps, and what was left out."""
    steps = np.diff(distance)
    forward = steps[np.isfinite(steps) & (steps != 0)]
    if not len(forward):
        raise BadInput(f"the distances of {where} do not move")
    direction = 1.0 if np.median(forward) > 0 else -1.0
    step = float(np.median(np.abs(forward)))
    place = direction * distance
    good = np.isfinite(place) & np.isfinite(value)
    at = np.flatnonzero(good)
    pieces: list[Real] = []
    jumps, gaps, bridged, lost = 0, 0, 0, 0
    start = 0
    for k in range(1, len(at) + 1):
        if k < len(at):
            apart, missing = float(place[at[k]] - place[at[k - 1]]), int(at[k] - at[k - 1] - 1)
            even = 0.5 * step < apart / (missing + 1) < 1.5 * step
            if even and missing <= _BRIDGED:
                bridged += missing
                continue
            if missing > _BRIDGED:
                gaps += 1
            else:
                jumps += 1
        x, y = place[at[start:k]], value[at[start:k]]
        if len(x) >= _SHORTEST:
            even_x = np.arange(x[0], x[-1] + 0.5 * step, step)
            line = np.interp(even_x, x, y)
            pieces.append(line - np.polyval(np.polyfit(even_x - x[0], line, 1), even_x - x[0]))
        else:
            lost += len(x)
        start = k
    if not pieces:
        raise BadInput(
            f"no piece of {where} has {_SHORTEST} numbers that follow each other; nothing is left to look at"
        )
    notes = [f"{len(pieces)} piece{'s' if len(pieces) > 1 else ''} of {step * sum(map(len, pieces)):.6g} m in all"]
    invalid = int((~np.isfinite(value)).sum())
    notes += (
        [f"{invalid} of {len(value)} values are no numbers: {gaps} gaps, {bridged} values bridged"] if invalid else []
    )
    notes += [f"at {jumps} place{'s' if jumps > 1 else ''} the stations jump or come twice"] if jumps else []
    notes += [f"{lost} values in pieces shorter than {_SHORTEST} are left out"] if lost else []
    return step, pieces, notes


def _welch(pieces: list[Real], step: float, bands: list[str], where: str) -> tuple[Spectrum, int]:
    """One-sided density over Ω, and the number of windows."""
    longest = max(len(piece) for piece in pieces)
    size = 2 ** math.ceil(math.log2(_WINDOW / step))
    lengths = np.array([len(piece) for piece in pieces])
    while size > _SHORTEST and lengths[lengths >= size].sum() < _USED * lengths.sum():
        size //= 2
    window = np.hanning(size + 1)[:-1]
    norm = step / float((window**2).sum())
    total, count = np.zeros(size // 2 + 1), 0
    for piece in pieces:
        for begin in range(0, len(piece) - size + 1, size // 2):
            part = piece[begin : begin + size]
            total += np.abs(np.fft.rfft(window * (part - part.mean()))) ** 2
            count += 1
    n = np.fft.rfftfreq(size, step)
    S = 2 * norm * total / count / (2 * np.pi)
    reach = size * step / _PERIODS
    low, high = _SAMPLES * step, reach
    if bands:
        low = max(low, min(BANDS[band][0] for band in bands))
        high = min(high, max(BANDS[band][1] for band in bands))
    inside = (n >= 1 / high) & (n <= 1 / low)
    if inside.sum() < 3 or not np.all(S[inside] > 0):
        raise BadInput(
            f"{where} is too short, too coarse or all zero: its longest piece is {longest * step:.4g} m in steps of "
            f"{step:g} m"
        )
    group = np.floor(_PER_OCTAVE * np.log2(n[inside] * high)).astype(int)
    nodes, means = [], []
    for one in np.unique(group):
        chosen = group == one
        nodes.append(float(np.exp(np.log(2 * np.pi * n[inside][chosen]).mean())))
        means.append(float(S[inside][chosen].mean()))
    return Spectrum(TableLaw(tuple(nodes), tuple(means)), (low, high), ends=True), count
