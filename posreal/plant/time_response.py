"""Time responses: exact for piecewise-linear inputs, and a seeded Monte-Carlo run on the random track.

Between the samples of a piecewise-linear input the response of ẋ = A x + B u is known in closed form
(first-order hold), so deterministic profiles whose corners fall on the grid carry no discretisation error.
Sampling of white noise: a zero-order hold of step h with variance π S/h has the single-sided density S per rad/s
as long as ω h ≪ 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.linalg import expm

from posreal.plant.plant import ClosedLoop, Real


def _modal(loop: ClosedLoop) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues and eigenvectors of A."""
    poles, vectors = np.linalg.eig(loop.A)
    return poles.astype(complex), vectors.astype(complex)


def corner_response(loop: ClosedLoop, output: str, corners: list[tuple[float, float]], time: Real) -> Real:
    """Response to an input made of ramps, exact at every instant of `time`.

    Parameters
    ----------
    loop : ClosedLoop
    output : str
    corners : list of (instant, change of slope)
        w(t) = Σ change · max(0, t − instant): a ramp from 0 to 1 in 3 s is ``[(0, 1/3), (3, −1/3)]``.
    time : (N,) seconds

    Returns
    -------
    (N,) response of the output, from rest, all channels with their delays.
    """
    j = loop.output(output)
    poles, vectors = _modal(loop)
    left = loop.C[j] @ vectors
    right = np.linalg.solve(vectors, loop.B.astype(complex))
    z = np.zeros(len(time))
    for channel, delay in enumerate(loop.delays):
        gain = left * right[:, channel]
        for instant, change in corners:
            t = np.maximum(time - instant - delay, 0.0)
            phase = np.multiply.outer(t, poles)
            # ∫∫ e^{λt}: (e^{λt} − 1 − λt)/λ², by its series where λt is small
            small = np.abs(phase) < 1e-4
            safe = np.where(small, 1.0, phase)
            ramp = np.where(small, 0.5 + phase / 6, (np.exp(safe) - 1.0 - safe) / safe**2) * t[:, None] ** 2
            z += change * ((ramp @ gain).real + loop.D[j, channel] * t)
    return z


def peak(response: Callable[[Real], Real], stop: float, *, step: float = 1e-2) -> tuple[float, float]:
    """Largest absolute value of a smooth response on [0, stop] and its instant, refined between samples.

    Parameters
    ----------
    response : function of an (N,) array of instants
    stop, step : seconds
    """
    time = np.arange(0.0, stop + step, step)
    z = np.abs(response(time))
    top = int(np.argmax(z))
    for _ in range(3):
        fine = np.linspace(time[max(top - 1, 0)], time[min(top + 1, len(time) - 1)], 41)
        z = np.abs(response(fine))
        time, top = fine, int(np.argmax(z))
    return float(z[top]), float(time[top])


def monte_carlo(
    loop: ClosedLoop, output: str, *, seed: int, duration: float = 600.0, step: float = 2e-3
) -> tuple[float, float]:
    """Root mean square of an output on a simulated random track, and its standard error.

    One white sequence drives all channels, each late by its own whole number of samples (the step is shortened so
    that the delays are close to whole numbers). The response is the sum of the modes, each a first-order recursion.

    Parameters
    ----------
    loop : ClosedLoop
    output : str
    seed : int
    duration : seconds of track that are averaged, after the transients have died out
    step : seconds, the longest hold of the noise

    Returns
    -------
    rms, standard error (from the spread over 20 blocks of the run)
    """
    from scipy.signal import lfilter  # slow to import, and only this needs it

    rng = np.random.default_rng(seed)
    poles, vectors = _modal(loop)
    settle = 12.0 / float(-poles.real.max()) + float(loop.delays.max())
    step = _step_for(loop.delays, step)
    count = math.ceil((settle + duration) / step)
    noise = rng.normal(scale=math.sqrt(math.pi * loop.density / step), size=count)
    j = loop.output(output)
    left = loop.C[j] @ vectors
    right = np.linalg.solve(vectors, loop.B.astype(complex))
    z = np.zeros(count)
    for channel, delay in enumerate(loop.delays):
        shift = round(delay / step)
        late = np.concatenate([np.zeros(shift), noise[: count - shift]])
        for pole, gain in zip(poles, left * right[:, channel], strict=True):
            decay = np.exp(pole * step)
            z += lfilter([0.0, gain * (decay - 1.0) / pole], [1.0, -decay], late).real
        z += loop.D[j, channel] * late
    squares = z[math.ceil(settle / step) :] ** 2
    blocks = np.array([block.mean() for block in np.array_split(squares, 20)])
    value = math.sqrt(float(squares.mean()))
    return value, float(blocks.std(ddof=1) / math.sqrt(len(blocks)) / (2 * value))


def _step_for(delays: Real, longest: float) -> float:
    """A step at most `longest` of which the delays are multiples, as nearly as can be had."""
    positive = delays[delays > 0]
    if len(positive) == 0:
        return longest
    first = math.ceil(float(positive.min()) / longest)
    steps = float(positive.min()) / np.arange(first, 2 * first + 1)
    miss = [np.abs(positive / step - np.round(positive / step)).max() for step in steps]
    return float(steps[int(np.argmin(np.round(miss, 9)))])


def stepped(loop: ClosedLoop, output: str, inputs: Real, step: float) -> Real:
    """First-order-hold simulation sample by sample: the slow, plain way, for one input (N, m) already delayed."""
    n, m = loop.B.shape
    block = np.zeros((n + 2 * m, n + 2 * m))
    block[:n, :n], block[:n, n : n + m] = loop.A * step, loop.B * step
    block[n : n + m, n + m :] = np.eye(m)
    transition = expm(block)
    Ad, G1, G2 = transition[:n, :n], transition[:n, n : n + m], transition[:n, n + m :]
    j = loop.output(output)
    x, z = np.zeros(n), np.empty(len(inputs))
    for i in range(len(inputs)):
        z[i] = loop.C[j] @ x + loop.D[j] @ inputs[i]
        if i + 1 < len(inputs):
            x = Ad @ x + G1 @ inputs[i] + G2 @ (inputs[i + 1] - inputs[i])
    return z
