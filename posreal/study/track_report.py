"""A track in numbers: r.m.s. by band of wavelengths, beside the standard spectra, and what matters at a speed.

The bands are those of recording cars: D1 from 3 to 25 m, D2 to 70 m, D3 to 150 m [EN13848].
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from scipy.special import chdtri

from posreal.errors import BadInput, listed
from posreal.study.drawing import save, sheet
from posreal.text_table import table
from posreal.vehicle.spectrum import Spectrum
from posreal.vehicle.track import Track, standard

BANDS = ((3.0, 25.0), (25.0, 70.0), (70.0, 150.0))
RIDE = (0.4, 30.0)  # Hz, in which a body is shaken so that it is felt
_AT = 10.0  # m, of the wavelength whose density is printed
_DRAWN = ("erri-low", "erri-high", "fra-6", "fra-4", "china")
_LEAST = 0.01  # of a spread of levels in dB, below which two spectra are called the same

Direction = Literal["vertical", "lateral"]
TITLES: dict[Direction, str] = {"vertical": "profile", "lateral": "alignment"}


@dataclass(frozen=True)
class DirectionReport:
    """One direction of a track: r.m.s. of each band in mm, density at 10 m in m²/(rad/m)."""

    direction: Direction
    rms: tuple[float, ...]
    density: float
    nearest: str
    apart_db: float


@dataclass(frozen=True)
class TrackReport:
    """A track, and what of it matters at a speed.

    Attributes
    ----------
    track : Track
    rows : tuple of DirectionReport
    speed : float or None
        m/s.
    """

    track: Track
    rows: tuple[DirectionReport, ...]
    speed: float | None = None

    def __str__(self) -> str:
        header = ["", *(f"{low:g}–{high:g} m [mm]" for low, high in BANDS), f"S({_AT:g} m) [m²/(rad/m)]", "nearest", ""]
        rows = [
            [
                TITLES[row.direction],
                *(f"{value:#.4g}" for value in row.rms),
                f"{row.density:.5e}",
                row.nearest,
                f"{row.apart_db:.2g} dB apart",
            ]
            for row in self.rows
        ]
        lines = [f"{self.track.name}  [{self.track.source}]", "", table(header, rows, "lrrrrll")]
        return "\n".join([*lines, "", *(f"  {line}" for line in self.notes())])

    def notes(self) -> list[str]:
        """Bands for which it is stated, how a filter has it, and wavelengths that are missing at the speed."""
        said = ["Densities are one-sided: the variance is ∫ S dΩ over Ω > 0. S_n(n) = 2π S(2πn)."]
        for row in self.rows:
            spectrum = self.track.spectrum(row.direction)
            name, (shortest, longest) = TITLES[row.direction].capitalize(), spectrum.band
            fit = spectrum.fitted()
            how = (
                "a rational filter has it exactly"
                if spectrum.exact
                else "limited; covariances, inequalities and bounds take it without its limits"
                if fit.rms_db == 0
                else f"covariances, inequalities and bounds take a filter of {len(fit.law.poles)} poles, "
                f"{fit.rms_db:.2g} dB r.m.s. from it and {fit.max_db:.2g} dB at most"
            )
            ends = "nothing outside" if spectrum.ends else "its formula goes on"
            said.append(f"{name}: stated from {shortest:g} to {longest:g} m, {ends}; {how}.")
        if (measured := self.track.measured) is not None:
            said += [f"{note[:1].upper()}{note[1:]}." for note in measured.notes]
            for direction, profile in measured.profiles.items():
                fewer, more = (10 * math.log10(profile.freedom / chdtri(profile.freedom, p)) for p in (0.05, 0.95))
                columns = listed(profile.columns).replace(" or ", " and ")
                said.append(
                    f"{TITLES[direction].capitalize()} from {columns}, {profile.windows} windows: 90 % of a bin's "
                    f"estimates are from {fewer:.2g} to +{more:.2g} dB about it."
                )
        if self.speed is not None:
            low, high = (self.speed / f for f in RIDE[::-1])
            said.append(
                f"At {self.speed:g} m/s a body is shaken from {RIDE[0]:g} to {RIDE[1]:g} Hz by wavelengths of "
                f"{low:.3g} to {high:.3g} m."
            )
            said += [sentence for row in self.rows if (sentence := self._missing(row.direction, low, high))]
        return said

    def _missing(self, direction: Direction, low: float, high: float) -> str:
        shortest, longest = self.track.spectrum(direction).band
        parts = [f"{low:.3g} to {shortest:g} m"] if low < shortest else []
        parts += [f"{longest:g} to {high:.3g} m"] if high > longest else []
        if not parts:
            return ""
        name = TITLES[direction].capitalize()
        return f"{name}: not stated are those from {' and '.join(parts)}."

    def draw(self, path: str | Path) -> Path:
        """Densities beside standard ones, into a .png, .svg or .pdf."""
        figure, axes = sheet(6.0 * len(self.rows), 4.4, len(self.rows))
        for axis, row in zip(axes, self.rows, strict=True):
            for name in _DRAWN:
                other = _spectrum(standard()[name], row.direction)
                if other is not None and name != self.track.name:
                    _curve(axis, other, name, color=None, linewidth=0.9, alpha=0.7)
            _curve(axis, self.track.spectrum(row.direction), self.track.name, color="black", linewidth=1.8)
            axis.set(xscale="log", yscale="log", xlabel="wavelength [m]", ylabel="S(Ω) [m²/(rad/m)]")
            axis.set_title(TITLES[row.direction])
            axis.legend(fontsize=8)
        return save(figure, path)

    def to_dict(self) -> dict[str, Any]:
        """JSON-able."""
        return {
            "track": self.track.name,
            "source": self.track.source,
            "speed": self.speed,
            "directions": {row.direction: self._row(row) for row in self.rows},
            "notes": self.notes(),
        }

    def _row(self, row: DirectionReport) -> dict[str, Any]:
        spectrum = self.track.spectrum(row.direction)
        fit = spectrum.fitted()
        return {
            "rms_mm": [
                {"from": low, "to": high, "value": value} for (low, high), value in zip(BANDS, row.rms, strict=True)
            ],
            "density_at_10_m": row.density,
            "band": list(spectrum.band),
            "ends": spectrum.ends,
            "exact": spectrum.exact,
            "fit": {"rms_db": fit.rms_db, "max_db": fit.max_db, "poles": len(fit.law.poles)},
            "nearest": {"name": row.nearest, "apart_db": row.apart_db},
        }


def track_report(track: Track, *, speed: float | None = None) -> TrackReport:
    """Look at a track: each direction that it has.

    Raises
    ------
    BadInput
        For a speed that is none, or a track without any spectrum.
    """
    if speed is not None and not (math.isfinite(speed) and speed > 0):
        raise BadInput(f"speed is {speed:g} m/s; it must be finite and greater than 0")
    rows = []
    directions: tuple[Direction, ...] = ("vertical", "lateral")
    for direction in directions:
        spectrum = _spectrum(track, direction)
        if spectrum is not None:
            rms = tuple(1e3 * spectrum.rms(low, high) for low, high in BANDS)
            density = float(spectrum.density(np.array([2 * math.pi / _AT]))[0])
            nearest, apart = _nearest(spectrum, direction)
            rows.append(DirectionReport(direction, rms, density, nearest, apart))
    return TrackReport(track, tuple(rows), speed)


def _spectrum(track: Track, direction: Direction) -> Spectrum | None:
    return track.vertical if direction == "vertical" else track.lateral


def _nearest(spectrum: Spectrum, direction: Direction) -> tuple[str, float]:
    """The standard spectrum whose level is nearest in the band, r.m.s. in dB; one that is it does not count."""
    shortest, longest = max(spectrum.band[0], BANDS[0][0]), min(spectrum.band[1], BANDS[-1][1])
    Omega = np.geomspace(2 * math.pi / longest, 2 * math.pi / shortest, 200)[1:-1]
    mine = 10 * np.log10(spectrum.density(Omega))
    found = []
    for name, other in standard().items():
        theirs = _spectrum(other, direction)
        if theirs is not None:
            apart = float(np.sqrt(np.mean((10 * np.log10(theirs.density(Omega)) - mine) ** 2)))
            if apart > _LEAST:
                found.append((apart, name))
    apart, name = min(found)
    return name, apart


def _curve(axis: Any, spectrum: Spectrum, label: str, **style: Any) -> None:
    shortest, longest = spectrum.band
    wavelength = np.geomspace(shortest, longest, 300)[1:-1]
    axis.plot(wavelength, spectrum.density(2 * math.pi / wavelength), label=label, **style)
