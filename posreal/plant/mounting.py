"""What stays at the secondary suspension whatever the device is: an admittance beside it and a bush behind it.

Y_port = Y_beside + 1/(1/Y_behind + 1/Y_device)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from posreal.admittance import Rational


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

    def response(self, Y: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Y_port and ∂Y_port/∂Y_device at the points `s`, for a device given by its values `Y` there."""
        if self.behind is None:
            inner, slope = Y, np.ones_like(Y)
        else:
            bush = np.asarray(self.behind(s))
            slope = (bush / (bush + Y)) ** 2
            inner = bush * Y / (bush + Y)
        return (inner if self.beside is None else np.asarray(self.beside(s)) + inner), slope
