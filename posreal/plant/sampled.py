"""A random input whose density is known by its values only: no filter has it, so figures go by frequency.

    z(jω) = G(jω) W(jω) √S(ω),     variance = ∫ |G W|² S dω

over the frequencies on which S is anything. What needs a rational spectrum, covariances and matrix inequalities and
bounds, takes a filter that comes near it instead, and says so.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from posreal.plant.shaping_filter import Complex, Real, ShapingFilter


@dataclass(frozen=True, eq=False)
class SampledDensity:
    """Stands where a shaping filter would.

    Attributes
    ----------
    density : function of ω > 0 (rad/s)
        One-sided density of the input, per rad/s.
    start, stop : float
        rad/s, between which it is anything.
    corners : tuple of float
        rad/s, where it is not smooth.
    near : ShapingFilter
        Whose density comes near it, of white noise of density 1.
    rms_db, max_db : float
        How near, over the band.
    ends : bool
        Whether it stops short at `start` and `stop`; otherwise these are so far out that nothing is left there.
    behind : ShapingFilter or None
        A weighting of the output.
    """

    density: Callable[[Real], Real]
    start: float
    stop: float
    corners: tuple[float, ...]
    near: ShapingFilter
    rms_db: float
    max_db: float
    ends: bool = False
    behind: ShapingFilter | None = None

    def __call__(self, s: Complex) -> Complex:
        """√S W at s = jω.

        Raises
        ------
        ValueError
            Off the imaginary axis, where a density has no value.
        """
        s = np.asarray(s, dtype=complex)
        if np.any(s.real != 0):
            raise ValueError("a density is known on the imaginary axis only")
        root = np.sqrt(self.squares(np.abs(s.imag))).astype(complex)
        return root if self.behind is None else root * self.behind(s)

    def squares(self, omega: Real) -> Real:
        """S at each ω, rad/s; nothing outside of where it is anything."""
        omega = np.asarray(omega, dtype=float)
        inside = (omega >= self.start) & (omega <= self.stop)
        return np.where(inside, self.density(np.where(inside, omega, self.start or 1.0)), 0.0)

    def then(self, after: ShapingFilter) -> SampledDensity:
        """The same with an output's filter behind."""
        return replace(self, behind=after if self.behind is None else self.behind.then(after))

    @property
    def filter(self) -> ShapingFilter | None:
        """The part of it that is a filter."""
        return self.behind

    @property
    def rational(self) -> ShapingFilter:
        """The filter that comes near it, with what stands behind."""
        return self.near if self.behind is None else self.near.then(self.behind)
