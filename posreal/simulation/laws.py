"""What an element does besides its value: Coulomb friction, backlash, an end stop.

Over a step with the mean velocity v̄ and the mean elongation ē = e + h v̄/2 an element has, beside the force of its own
value, the force λ of its law

    λ ∈ F_c Sgn(v̄) + ψ(ē),     Sgn(0) = [−1, 1],

with ψ piecewise linear: inside a play of total width g a spring k has no force, ψ = −k ē, and beyond it k g/2 less than
without; beyond an elongation ±s a stop pushes back with its own stiffness. Friction is set-valued: what sticks has
exactly the force that keeps it still [AcaryBrogliato2008].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Real = np.ndarray
STOP = 1e7  # N/m, of an end stop: twice a bush (judgement)


@dataclass(frozen=True)
class ElementLaw:
    """A law of one element.

    Attributes
    ----------
    friction : float
        N, either way.
    stiffness : float
        N/m, of the spring that has the play.
    backlash : float
        m, total play in series with that spring.
    stop : float
        m, elongation either way at which it ends; infinite for none.
        It lies beyond the play.
    stop_stiffness : float
        N/m.
    """

    friction: float = 0.0
    stiffness: float = 0.0
    backlash: float = 0.0
    stop: float = np.inf
    stop_stiffness: float = STOP

    @property
    def nothing(self) -> bool:
        """Whether the element does what its value says."""
        return not (self.friction or self.backlash or np.isfinite(self.stop))

    def force(self, free: Real, elongation: Real, give: Real, step: float) -> Real:
        """λ where v̄ + give·λ = free: by how much the element would move without it, and how it gives way to it.

        Parameters
        ----------
        free : (R, D) m/s
        elongation : (R, D) m, at the begin of the step
        give : (D,)
            m/s per N, above 0.
        step : float
            s.
        """
        F = self.friction
        still = free / give
        if not (self.backlash or np.isfinite(self.stop)):
            return np.minimum(np.maximum(still, -F), F)
        wanted = still - self._psi(elongation)
        side = F * np.sign(wanted)
        mean = self._mean_elongation(elongation + step / 2 * (free - give * side), step / 2 * give)
        moving = side + self._psi(mean)
        return np.where(np.abs(wanted) <= F, still, moving) if F else moving

    def _psi(self, e: Real) -> Real:
        found = np.zeros_like(e)
        if self.backlash:
            half = self.backlash / 2
            found -= self.stiffness * np.minimum(np.maximum(e, -half), half)
        if np.isfinite(self.stop):
            found += self.stop_stiffness * (e - np.minimum(np.maximum(e, -self.stop), self.stop))
        return found

    def _mean_elongation(self, right: Real, give: Real) -> Real:
        """ē with ē + give ψ(ē) = right: the left side rises, a line from the play to the stop and beyond."""
        size, half = np.abs(right), self.backlash / 2
        found = size + give * self.stiffness * half
        if half:
            left = 1 - give * self.stiffness  # above 0: the spring itself is one of the ways to give
            found = np.where(size <= left * half, size / np.maximum(left, 1e-12), found)
        if np.isfinite(self.stop):
            over = found - self.stop
            found = np.where(over > 0, self.stop + over / (1 + give * self.stop_stiffness), found)
        return np.asarray(np.copysign(found, right))
