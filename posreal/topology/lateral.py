"""Damping ratios of the plan view with a network in its port, and their gradients, without rebuilding the
vehicle.

A vehicle's matrix is affine in 1/V, Kpy and Cpy, so it is put together from four samples. A pole p of the
closed vehicle solves 1 + P(s) Y(s) = 0 with P = −Cv (sI − A)⁻¹ Bf the port's mobility, whence

    dp = −(P dY + Y dP)/(P′Y + P Y′),      ζ = −Re p/|p|,      dζ = −Re dp/|p| + Re p · Re(p̄ dp)/|p|³,

and s Y′ = Σ ∂Y/∂log b − Σ ∂Y/∂log k, since scaling s is scaling inerters up and springs down.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from posreal.admittance.state_space import StateSpace
from posreal.network.topologies import Form, letters, network
from posreal.plant.plant import close
from posreal.plant.time_response import corner_response
from posreal.specification.problem import Problem
from posreal.topology.batch import Array
from posreal.topology.fraction import matrices
from posreal.topology.ground import Scale
from posreal.vehicle import PlanView, damping

MODES = 3  # least damped modes of each speed that are watched: enough that two can change places
_RAMP = 3.0  # seconds from the straight into the full curve, as in posreal.vehicle.metrics


class LateralLoop:
    """A lateral problem's vehicle around any network; θ as in :class:`posreal.topology.ground.Ground`."""

    def __init__(self, problem: Problem, scale: Scale) -> None:
        assert isinstance(problem.vehicle, PlanView)
        self.vehicle, self.scale = problem.vehicle, scale
        self.names = tuple(problem.free)
        base = dataclasses.replace(self.vehicle, V=1.0)
        plant = base.random_track()
        self._Bf, self._Cv, self._Cd = plant.Bf, plant.Cv, plant.Cd
        one = plant.A
        self._slow = 2 * (one - base.at(2.0).random_track().A)  # what goes with 1/V
        self._primary = {
            name: dataclasses.replace(base, **{name: getattr(base, name) + 1e6}).random_track().A - one
            for name in ("Kpy", "Cpy")
        }
        self._rest = (
            one - self._slow - sum(getattr(base, name) / 1e6 * change for name, change in self._primary.items())
        )

    def split(self, form: Form, theta: Array) -> tuple[Array, dict[str, float]]:
        """Element values, and all three vehicle parameters that a problem may free."""
        count = len(letters(form))
        values = np.exp(theta)
        tuned = {name: float(getattr(self.vehicle, name)) for name in ("Kpy", "Cpy", "Ksy")}
        return values[:count], tuned | dict(zip(self.names, values[count:].tolist(), strict=True))

    def device(self, form: Form, theta: Array) -> tuple[StateSpace, dict[str, float]]:
        """What stands in the port, static spring included, and the vehicle parameters."""
        values, tuned = self.split(form, theta)
        return matrices(form, values, self.scale, beside=tuned["Ksy"]), tuned

    def _open(self, tuned: dict[str, float], speeds: Array) -> Array:
        """A of the vehicle without its secondary suspension at each speed."""
        fixed = self._rest + sum(tuned[name] / 1e6 * change for name, change in self._primary.items())
        return np.asarray(fixed + self._slow / speeds[:, None, None])

    def poles(self, form: Form, theta: Array, speeds: Array) -> Array:
        """Poles of the closed vehicle, speeds × modes."""
        inside, tuned = self.device(form, theta)
        A = self._open(tuned, speeds)
        n, m = A.shape[-1], inside.order
        F = np.zeros((len(speeds), 1, n + m))  # port force as a row on the state
        F[:, :, :n] = inside.k * self._Cd + inside.D[0, 0] * self._Cv + inside.b * (self._Cv @ A)
        F[:, :, n:] = inside.C
        F /= 1.0 - inside.b * float((self._Cv @ self._Bf)[0, 0])
        closed = np.zeros((len(speeds), n + m, n + m))
        closed[:, :n, :n] = A
        closed[:, :n] += self._Bf @ F
        closed[:, n:, n:] = inside.A
        closed[:, n:, :n] = inside.B @ self._Cv
        return np.linalg.eigvals(closed).astype(complex)

    def least_ratios(self, form: Form, theta: Array, speeds: Array) -> Array:
        """The least damping ratio at each speed."""
        return np.asarray(damping.ratios(self.poles(form, theta, speeds)).min(axis=1))

    def ratios(self, form: Form, theta: Array, speeds: Array) -> tuple[Array, Array]:
        """The `MODES` least damping ratios of each speed in ascending order, and their gradients in θ."""
        poles = self.poles(form, theta, speeds)
        size = damping.ratios(poles)
        size = np.where(poles.imag >= 0, size, np.inf)
        order = np.argsort(size, axis=1)[:, :MODES]
        chosen = np.take_along_axis(poles, order, axis=1)
        zeta = np.take_along_axis(size, order, axis=1)
        slopes = self._pole_slopes(form, theta, speeds, chosen)
        p = chosen[..., None]
        gradient = -slopes.real / np.abs(p) + p.real * (p.conj() * slopes).real / np.abs(p) ** 3
        return zeta.ravel(), np.nan_to_num(gradient.reshape(-1, len(theta)))

    def _pole_slopes(self, form: Form, theta: Array, speeds: Array, poles: Array) -> Array:
        """∂p/∂θ of chosen poles, speeds × modes × unknowns."""
        values, tuned = self.split(form, theta)
        Y, dY = network(form).response.evaluate(values, poles)
        kinds = np.array(list(letters(form)))
        with np.errstate(all="ignore"):
            slope = (dY[kinds == "b"].sum(axis=0) - dY[kinds == "k"].sum(axis=0)) / poles
            static = tuned["Ksy"] / poles
            Y, slope = Y + static, slope - static / poles
            n = self._Bf.shape[0]
            resolvent = poles[..., None, None] * np.eye(n) - self._open(tuned, speeds)[:, None]
            x = np.linalg.solve(resolvent, np.broadcast_to(self._Bf.astype(complex), (*poles.shape, n, 1)))
            left = np.linalg.solve(
                np.swapaxes(resolvent, -1, -2),
                np.broadcast_to(self._Cv.T.astype(complex), (*poles.shape, n, 1)),
            )
            P = -(self._Cv @ x)[..., 0, 0]
            dP = np.sum(left * x, axis=(-2, -1))  # Cv (sI − A)⁻² Bf
            back = -1 / (dP * Y + P * slope)
            parts = [P * part for part in dY]
            for name in self.names:
                if name == "Ksy":
                    parts.append(P * static)
                else:
                    change = tuned[name] / 1e6 * self._primary[name]
                    parts.append(-np.sum(left * (change @ x), axis=(-2, -1)) * Y)
            return np.stack([back * part for part in parts], axis=-1)

    def peak(self, form: Form, theta: Array) -> tuple[float, float]:
        """Max(yv) in m on entering the curve, signed, and its instant."""
        time = np.arange(0.0, 10.02, 0.05)
        for _ in range(4):
            z = self.displacement(form, theta, time)
            top = int(np.argmax(np.abs(z)))
            best = float(z[top]), float(time[top])
            time = np.linspace(time[max(top - 1, 0)], time[min(top + 1, len(time) - 1)], 41)
        return best

    def displacement(self, form: Form, theta: Array, time: Array) -> Array:
        """Lateral displacement of the body on entering the curve, m."""
        inside, tuned = self.device(form, theta)
        vehicle = dataclasses.replace(self.vehicle, **tuned)
        loop = close(vehicle.curve_entry(), {"secondary": inside})
        return corner_response(loop, "body_displacement", [(0.0, 1 / _RAMP), (_RAMP, -1 / _RAMP)], time)

    def peak_gradient(self, form: Form, theta: Array, *, step: float = 1e-5) -> tuple[float, Array]:
        """|Max(yv)| and its gradient: the instant of a peak may be held, so only the response there is differenced."""
        top, when = self.peak(form, theta)
        here = np.array([when])
        slope = np.empty_like(theta)
        for i in range(len(theta)):
            d = np.zeros_like(theta)
            d[i] = step
            up, down = (self.displacement(form, theta + sign * d, here)[0] for sign in (1.0, -1.0))
            slope[i] = (up - down) / (2 * step)
        return abs(top), np.sign(top) * slope
