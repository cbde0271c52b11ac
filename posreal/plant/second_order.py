"""From M q̈ + C q̇ + K q = N₀ y + N₁ ẏ − E f to a plant driven by the *velocity* of the track.

The track displacement y is an integrated process with no finite variance, and so are the coordinates q. What
stays finite is the displacement relative to the vehicle standing still on the displaced track,

    q̃ = q − S y,      K S = N₀,   Eᵀ S = 0      (S: static shape, one column a wheel, device ports unloaded)

and with x = (q̃, q̇), w = ẏ

    q̃˙ = q̇ − S w,      M q̈ = −K q̃ − C q̇ + N₁ w − E f.

No integrator of the track is left, so covariances are well posed. K and C are those without the devices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from posreal.plant.plant import Real


@dataclass(frozen=True)
class SecondOrder:
    """M q̈ + C q̇ + K q = inputs − E f with the names of its coordinates.

    Attributes
    ----------
    M, C, K : (n, n) mass, damping and stiffness without the devices
    E : (n, p) relative displacement at the ports is Eᵀ q
    coordinates : names of q
    """

    M: Real
    C: Real
    K: Real
    E: Real
    coordinates: tuple[str, ...]

    def row(self, **weights: float) -> Real:
        """The row vector that picks a combination of coordinates, e.g. ``row(zv=1, thv=9.5)``."""
        picked = np.zeros(len(self.coordinates))
        for name, weight in weights.items():
            picked[self.coordinates.index(name)] = weight
        return picked

    def free(self) -> Real:
        """A of ẋ = A x for x = (q, q̇)."""
        n = len(self.M)
        return np.block(
            [
                [np.zeros((n, n)), np.eye(n)],
                [-np.linalg.solve(self.M, self.K), -np.linalg.solve(self.M, self.C)],
            ]
        )

    def device_force(self) -> Real:
        """Bf of ẋ = A x + Bf f."""
        return np.vstack([np.zeros_like(self.E), -np.linalg.solve(self.M, self.E)])

    def applied_force(self, shape: Real) -> Real:
        """B of ẋ = A x + B u for generalised forces `shape` u."""
        return np.vstack([np.zeros_like(shape), np.linalg.solve(self.M, shape)])

    def static_shape(self, N0: Real) -> Real:
        """S with K S = N₀ and Eᵀ S = 0: the vehicle standing on a displaced track."""
        p = self.E.shape[1]
        S = np.linalg.lstsq(
            np.vstack([self.K / np.abs(self.K).max(), self.E.T]),
            np.vstack([N0 / np.abs(self.K).max(), np.zeros((p, N0.shape[1]))]),
            rcond=None,
        )[0]
        return np.asarray(S)

    def track_velocity(self, N0: Real, N1: Real) -> Real:
        """Bw of ẋ = A x + Bw w for x = (q̃, q̇) and w the track velocity at each wheel."""
        return np.vstack([-self.static_shape(N0), np.linalg.solve(self.M, N1)])
