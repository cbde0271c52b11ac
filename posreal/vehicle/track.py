"""Standard track irregularity, one-sided, with the wavelengths for which it is stated.

| name | vertical (profile) and lateral (alignment) | source |
|---|---|---|
| erri-low, erri-high | A Ωc²/((Ω² + Ωr²)(Ω² + Ωc²)) | [ERRI1989] |
| fra-1 … fra-6 | S_n = A n2² (n² + n1²)/(n⁴ (n² + n2²)) | [Hamid1983] |
| aar-1 … aar-6 | k A Ωc²/(Ω² (Ω² + Ωc²)) | [Fries1990] |
| china | S_n = A n^−k by pieces, ballastless | [TBT3352] |
| uk | S_n = Av/n² | [Jiang2012] |
| sncf, sncf-rough | S_n = A/(1 + n/n0)³ | [Fryba1996] |

Densities are one-sided without exception: the ½ in the J1z² of [Jiang2012] belongs to its own track, ``paper``, alone,
which is uk with half of it. The ERRI densities reproduce the nodes that multibody programs print for B176.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from posreal.errors import BadInput, hint, plain, shown
from posreal.plant.plant import Plant, Real
from posreal.plant.sampled import SampledDensity
from posreal.plant.shaping_filter import ShapingFilter
from posreal.vehicle.spectrum import ERRI, HyperbolicLaw, PowerLaw, RationalLaw, Spectrum
from posreal.vehicle.track_file import Direction, MeasuredTrack, read_track

_TURN = 2 * math.pi
_AV = 2.5e-7  # m
PAPER = "paper"


@dataclass(frozen=True)
class Track:
    """Track irregularity by name: its profile and its alignment, each None where nothing is known.

    Attributes
    ----------
    name : str
    vertical, lateral : Spectrum or None
    source : str
    lateral_of_the_paper : bool
        Whether the alignment is the filter of [Jiang2012], which is one of time and has no density over the wavelength.
    measured : MeasuredTrack or None
        The profiles themselves, where they come from a file.
    """

    name: str
    vertical: Spectrum | None
    lateral: Spectrum | None
    source: str
    lateral_of_the_paper: bool = False
    measured: MeasuredTrack | None = field(default=None, compare=False, repr=False)

    def __str__(self) -> str:
        return self.name

    @classmethod
    def named(cls, name: str) -> Track:
        """A standard one: ``erri-low``, ``fra-4``, …, or ``paper``.

        Raises
        ------
        BadInput
            Naming what there is.
        """
        tracks = {PAPER: paper(), **standard()}
        if name not in tracks:
            raise BadInput(f"no track is called {shown(name)}; {hint(name, tracks)}")
        return tracks[name]

    @classmethod
    def erri(cls, level: str) -> Track:
        """ERRI B176 ``low`` or ``high``."""
        return cls.named(f"erri-{level}")

    @classmethod
    def from_file(cls, path: str | Path, column: str | None = None) -> Track:
        """A measured one; see :mod:`.track_file` for what is read.

        Parameters
        ----------
        path : path
        column : str, optional
            Columns by name or number, parted by commas, if not those that the header tells.

        Raises
        ------
        BadInput
            If it cannot be read, or too little of it is numbers.
        """
        found = read_track(path, column)
        parts = [found.profiles[way].spectrum if way in found.profiles else None for way in ("vertical", "lateral")]
        name = Path(path).name + ("" if column is None else f":{column}")
        return cls(plain(name), parts[0], parts[1], "measured", measured=found)

    @classmethod
    def read(cls, text: str) -> Track:
        """A standard track by name, or ``FILE`` or ``FILE:column``.

        Raises
        ------
        BadInput
        """
        if text in standard() or text == PAPER:
            return cls.named(text)
        if Path(text).exists():
            return cls.from_file(text)
        path, colon, column = text.rpartition(":")
        if colon and Path(path).exists():
            return cls.from_file(path, column)
        if any(mark in text for mark in "./:"):
            raise BadInput(f"cannot read {plain(text)}: there is no such file, and no track of that name")
        return cls.named(text)

    def spectrum(self, direction: Direction) -> Spectrum:
        """The profile or the alignment.

        Raises
        ------
        BadInput
            Where it has none.
        """
        found = self.vertical if direction == "vertical" else self.lateral
        if found is None:
            what = "profile" if direction == "vertical" else "alignment"
            raise BadInput(f"the track {self.name} has no {what}, which this vehicle runs over; give another track")
        return found

    def stored(self, direction: Direction) -> bool:
        """Whether its name is enough to have its filter again, to the last digit."""
        if standard().get(self.name) != self:
            return False
        return (direction == "lateral" and self.lateral_of_the_paper) or self.spectrum(direction).exact

    def density(self, Omega: Real, direction: Direction = "vertical") -> Real:
        """One-sided density, m²/(rad/m), at each Ω > 0, rad/m."""
        return self.spectrum(direction).density(Omega)

    def rms(self, shortest: float, longest: float, direction: Direction = "vertical") -> float:
        """Root mean square, m, between two wavelengths, m."""
        return self.spectrum(direction).rms(shortest, longest)

    def between(self, shortest: float, longest: float) -> Track:
        """The same track between two wavelengths, m, and nothing else."""
        parts = [None if one is None else one.between(shortest, longest) for one in (self.vertical, self.lateral)]
        name = f"{self.name}, {shortest:g} to {longest:g} m"
        return replace(self, name=name, vertical=parts[0], lateral=parts[1], measured=None)


@lru_cache(maxsize=1)
def standard() -> Mapping[str, Track]:
    """Every standard track by name."""
    tracks = [*_erri(), *_fra(), *_aar(), _china(), _uk(), *_sncf()]
    return {track.name: track for track in tracks}


def paper(Av: float = _AV) -> Track:
    """The profile of [Jiang2012] as its J1z² has it: half of the one-sided density."""
    law = RationalLaw(math.pi * Av, (), (0.0,))
    return Track(PAPER, Spectrum(law, _ANY), None, "Jiang2012, with the ½ of its J1z²", True)


_ANY = (1.0, 200.0)  # m, of a law that is stated for no band


def _erri() -> list[Track]:
    Omega_r, Omega_c = ERRI
    levels = {"low": (4.032e-7, 2.119e-7), "high": (1.080e-6, 6.125e-7)}

    def spectrum(A: float) -> Spectrum:
        return Spectrum(RationalLaw(A * Omega_c**2, (), (Omega_r, Omega_c)), (3.0, 150.0))

    return [
        Track(f"erri-{level}", spectrum(profile), spectrum(alignment), "ERRI1989, B176")
        for level, (profile, alignment) in levels.items()
    ]


def _fra() -> list[Track]:
    profiles, alignments = (7.9, 4.5, 2.5, 1.4, 0.79, 0.45), (5.0, 2.8, 1.6, 0.89, 0.5, 0.28)  # 1e-4 in² cycle/ft
    inch, foot = 0.0254, 0.3048

    def spectrum(A: float, n1: float, n2: float) -> Spectrum:
        Omega1, Omega2 = _TURN * n1, _TURN * n2
        gain = _TURN * 1e-4 * A * inch**2 / foot * Omega2**2
        return Spectrum(RationalLaw(gain, (Omega1,), (0.0, 0.0, Omega2)), (1.524, 304.8))

    return [
        Track(
            f"fra-{number}",
            spectrum(profile, 0.0071 / foot, 0.04 / foot),
            spectrum(alignment, 0.01 / foot, 0.056 / foot),
            "Hamid1983, FRA class",
        )
        for number, (profile, alignment) in enumerate(zip(profiles, alignments, strict=True), 1)
    ]


def _aar() -> list[Track]:
    Omega_c, k = 0.8245, 0.25
    profiles = (1.2107, 1.0181, 0.6816, 0.5376, 0.2095, 0.0339)  # cm² rad/m
    alignments = (3.3634, 1.2107, 0.4128, 0.3027, 0.0762, 0.0339)

    def spectrum(A: float) -> Spectrum:
        return Spectrum(RationalLaw(k * A * 1e-4 * Omega_c**2, (), (0.0, Omega_c)), (1.5, 300.0))

    return [
        Track(f"aar-{number}", spectrum(profile), spectrum(alignment), "Fries1990, American grade")
        for number, (profile, alignment) in enumerate(zip(profiles, alignments, strict=True), 1)
    ]


def _china() -> Track:
    profile = PowerLaw(
        (0.0187, 0.0474, 0.1533),
        (1.0544e-5, 3.5588e-3, 1.9784e-2, 3.9488e-4),
        (3.3891, 1.9271, 1.3643, 3.4516),
    )
    alignment = PowerLaw((0.0450, 0.1234), (3.9513e-3, 1.1047e-2, 7.5633e-4), (1.8670, 1.5354, 2.8171))
    return Track("china", Spectrum(profile, (2.0, 200.0)), Spectrum(alignment, (2.0, 200.0)), "TBT3352, ballastless")


def _uk() -> Track:
    return Track("uk", Spectrum(RationalLaw(_TURN * _AV, (), (0.0,)), _ANY), None, "Jiang2012, read one-sided", True)


def _sncf() -> list[Track]:
    return [
        Track(name, Spectrum(HyperbolicLaw(factor * 308e-6, 0.0489), (2.0, 40.0)), None, "Fryba1996")
        for name, factor in (("sncf", 0.509), ("sncf-rough", 1.790))
    ]


# --- under a vehicle ------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class MovingDensity:
    """One-sided density, per rad/s, of a derivative of a profile that is run over at a speed, m/s."""

    spectrum: Spectrum
    speed: float
    derivative: int

    def __call__(self, omega: Real) -> Real:
        """At each ω > 0, rad/s."""
        omega = np.asarray(omega, dtype=float)
        safe = np.where(omega > 0, omega, 1.0)
        value = safe ** (2 * self.derivative) * self.spectrum.density(safe / self.speed) / self.speed
        return np.where(omega > 0, value, 0.0)


def shaken(plant: Plant, spectrum: Spectrum, speed: float, derivative: int) -> Plant:
    """A plant whose input is a derivative of the profile, on a spectrum at a speed, m/s.

    Raises
    ------
    ValueError
        If that derivative has no proper filter.
    """
    fit = spectrum.fitted()
    near, density = fit.law.filter(speed, derivative)
    if spectrum.exact:
        return replace(plant, shaping=near, density=density)
    low, high = (Omega * speed for Omega in spectrum.support)
    sampled = SampledDensity(
        MovingDensity(spectrum, speed, derivative),
        low,
        high,
        tuple(corner * speed for corner in spectrum.law.corners),
        near if near is not None else _constant(math.sqrt(density)),
        fit.rms_db,
        fit.max_db,
        spectrum.ends,
    )
    return replace(plant, shaping=sampled, density=1.0)


def _constant(gain: float) -> ShapingFilter:
    return ShapingFilter(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.array([[gain]]))


def driven_by_acceleration(plant: Plant, at_rest: Real) -> Plant:
    """A plant driven by the profile's velocity w, driven by ẇ instead; outputs do not feel a steady w.

    With x₀ = x − R w, where R w is the vehicle that climbs a steady slope without shaking (A R + Bw = 0),

        ẋ₀ = A x₀ + Bf f − R ẇ,     z = Cz x₀ + Dzf f,

    so no integrator is left between the two.

    Parameters
    ----------
    plant : Plant
    at_rest : (n, m)
        R.
    """
    return replace(plant, Bw=-at_rest, Dzw=np.zeros_like(plant.Dzw))
