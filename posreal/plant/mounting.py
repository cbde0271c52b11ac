"""What stays at the secondary suspension whatever the device is: an admittance beside it and a bush behind it.

Y_port = Y_beside + 1/(1/Y_behind + 1/Y_device)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from posreal.admittance import Rational, state_space
from posreal.admittance.state_space import StateSpace
from posreal.errors import BadInput


@dataclass(frozen=True)
class Copy:
    """One of the devices that the ports of a group hold: its deflection is `rows` · the ports', `count` are alike.

    Ports are what is convenient (bounce and pitch; two struts side by side as one): with t the rows of every device,
    Σ count t tᵀ = 1, so that the same admittance in every device is that admittance in every port.
    """

    rows: tuple[float, ...]
    count: int = 1


@dataclass(frozen=True)
class Mounting:
    """What the port holds besides the device: `beside` in parallel, `behind` in series with the device."""

    beside: Rational | None
    behind: Rational | None

    def port(self, device: Rational | None) -> Rational:
        """The admittance of the whole port, exactly; ``None`` is no device."""
        inner = Rational.zero() if device is None else device
        if self.behind is not None and not inner.is_zero():
            inner = self.behind + inner
        return inner if self.beside is None else self.beside | inner

    def device(self, port: Rational) -> Rational:
        """The device of a whole port, exactly: :meth:`port` backwards."""
        inner = port if self.beside is None else port.without(self.beside)
        if self.behind is None or inner.is_zero():
            return inner
        return inner.inverse().without(self.behind.inverse()).inverse()

    def around(self, device: StateSpace) -> StateSpace:
        """:meth:`port` for a device without spring and inerter, in floats, by state spaces instead of polynomials.

        With x the device's states and d what the bush is compressed, f = k d + D_b (v − v_d) + C_b ξ in the bush is
        C x + D v_d in the device, which gives v_d.
        """
        A, B, C, D, k = device.A, device.B, device.C, float(device.D[0, 0]), 0.0
        if self.behind is not None:
            bush = state_space(self.behind)
            n, h, stiff = len(A), len(bush.A), float(bush.D[0, 0])
            if bush.b:
                raise BadInput("a bush with an inerter across it cannot be put in front of a state space")
            # v_d = (pull · (x, ξ, d) + stiff v)/(D + stiff)
            pull = np.concatenate([-C[0], bush.C[0], [bush.k]]) / (D + stiff)
            through = stiff / (D + stiff)
            whole = np.zeros((n + h + 1, n + h + 1))
            whole[:n, :n], whole[n : n + h, n : n + h] = A, bush.A
            entry = np.concatenate([B[:, 0], -bush.B[:, 0], [-1.0]])
            whole += np.outer(entry, pull)
            drive = entry * through + np.concatenate([np.zeros(n), bush.B[:, 0], [1.0]])
            out = np.concatenate([C[0], np.zeros(h + 1)]) + D * pull
            A, B, C, D = whole, drive[:, None], out[None, :], D * through
        b = 0.0
        if self.beside is not None:
            other = state_space(self.beside)
            n, h = len(A), len(other.A)
            A = np.block([[A, np.zeros((n, h))], [np.zeros((h, n)), other.A]])
            B, C, D = np.vstack([B, other.B]), np.hstack([C, other.C]), D + float(other.D[0, 0])
            k, b = other.k, other.b
        return StateSpace(A, B, C, np.array([[D]]), k, b)

    def response(self, Y: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Y_port and ∂Y_port/∂Y_device at the points `s`, for a device given by its values `Y` there."""
        if self.behind is None:
            inner, slope = Y, np.ones_like(Y)
        else:
            bush = np.asarray(self.behind(s))
            slope = (bush / (bush + Y)) ** 2
            inner = bush * Y / (bush + Y)
        return (inner if self.beside is None else np.asarray(self.beside(s)) + inner), slope
