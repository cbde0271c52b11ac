"""A measured track: a record drawn with a known spectrum, spoilt as records are, read back, and ridden over.

    profile = Σ √(2 S(Ω) ΔΩ) cos(Ω x + φ),   S of ERRI low between 1 and 150 m, φ random

No public record of useful length with a free licence was found, so this one is drawn; a seed makes it the same each
time.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

import posreal as pr
from posreal.study.cross_check import three_ways
from posreal.study.track_report import track_report

STEP = 0.25  # m


def draw(length: float, seed: int) -> np.ndarray:
    """A profile, m."""
    count = round(length / STEP)
    Omega = 2 * np.pi * np.fft.rfftfreq(count, STEP)
    S = np.zeros_like(Omega)
    inside = (Omega > 2 * np.pi / 150) & (Omega < 2 * np.pi)
    S[inside] = pr.Track.erri("low").density(Omega[inside])
    phase = np.exp(2j * np.pi * np.random.default_rng(seed).random(len(Omega)))
    return np.fft.irfft(np.sqrt(2 * S * Omega[1]) * phase, count) * count / 2


def write(path: Path, profile: np.ndarray) -> None:
    """Kilometre and metre, left and right rail in mm; a gap of 50 m, single invalid cells, a station that jumps."""
    lines = ["Location [km+m],Longitudinal level left [mm],Longitudinal level right [mm]"]
    for k, value in enumerate(profile):
        place = 12_000 + STEP * k + (20.0 if k > 20_000 else 0.0)
        left = "NaN" if 9_000 <= k < 9_200 else "inv" if k % 5_000 == 77 else f"{1e3 * value + 0.3:.4f}"
        lines.append(f"{int(place // 1000)}+{place % 1000:07.2f},{left},{1e3 * value - 0.3:.4f}")
    path.write_text("\n".join(lines) + "\n")


def main() -> dict[str, float]:
    """Print what is read and what a ride on it is like."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "record.csv"
        write(path, draw(10_000.0, seed=1))
        track = pr.Track.from_file(path)
    print(track_report(track, speed=55.0))
    ways = three_ways(pr.evaluate(pr.problem("vertical-comfort", track=track, weighting="Wb"), None))
    print(f"\n{ways}")
    standard = pr.evaluate(pr.problem("vertical-comfort", track="erri-low", weighting="Wb"), None)
    return {
        "by frequency": ways.by_frequency,
        "in time": ways.simulated,
        "on erri-low": standard.metrics["aw_T"].value,
        "D1": 1e3 * track.rms(3, 25),
    }


if __name__ == "__main__":
    main()
