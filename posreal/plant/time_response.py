"""Time responses: exact for piecewise-linear inputs, and a seeded Monte-Carlo run on the random track.

Between the samples of a piecewise-linear input the response of ẋ = A x + B u is known in closed form
(first-order hold), so deterministic profiles whose corners fall on the grid carry no discretisation error.
Sampling of white noise: a zero-order hold of step h with variance π S/h has the single-sided density S per rad/s
as long as ω h ≪ 1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.linalg import expm

from posreal.errors import Unsettled
from posreal.plant.modes import Corners, Modes, modes
from posreal.plant.plant import ClosedLoop, Real

_PART = 10.0  # s, over which a mean square is taken to see how they scatter
_WINDOW = 8.0  # s, looked at in any case
_STEP = 1e-2  # s, between samples where no mode needs a closer look
_PER_RADIAN = 0.4  # of the fastest mode that can be seen: its peak is missed by 2 % of its size at most
_NEAR = 0.95  # of the largest sample: a local maximum that may be the largest
_BLOCK = 2000  # samples at a time
_LONGEST = 1e5  # s, more than a day: what creeps in later is of no train's concern
_MOST = 3_000_000  # samples, some seconds
_UNSEEN = 1e-7  # of the largest mode: what cannot move a peak's digits
_SETTLED = 1e-9  # of a peak


def peak(of: Modes, output: str, corners: Corners) -> tuple[float, float]:
    """The largest |z(t)| of the first day and its instant, infinite where it is a limit that is never reached.

    The samples are as close as the fastest mode that can still be seen needs, and go on until what is left of the
    transients cannot bring anything larger: behind the last corner the response is its limit and modes that decay.

    Parameters
    ----------
    of : Modes
        Of a stable loop.
    output : str
    corners : sequence of (instant, change of slope)
        The changes add up to 0, so that the input becomes constant.

    Raises
    ------
    Unsettled
        If it rings for so long that nobody can look.
    """
    j = of.outputs.index(output)
    changes = sum(abs(change) for _, change in corners)
    last = max(instant for instant, _ in corners) + float(of.delays.max())
    limit = -float(of.at(np.zeros(1, complex))[j, :, 0].real.sum()) * sum(
        change * instant for instant, change in corners
    )
    ramps = np.abs(of.residues[j]).sum(axis=0) * changes / np.abs(of.poles) ** 2  # of each mode, behind its corners
    decay = -of.poles.real
    start, stop, best, samples = 0.0, max(_WINDOW, last + _STEP), 0.0, 0
    candidates: list[tuple[float, float, float]] = []  # value, instant, step
    while True:
        faded = ramps * np.exp(-decay * max(start - last, 0.0))
        seen = faded > _UNSEEN * max(float(ramps.max()), abs(limit))
        step = _PER_RADIAN / float(np.abs(of.poles[seen]).max(initial=1.0 / stop))
        step = min(step, _STEP) if start == 0 else step
        samples += math.ceil((stop - start) / step)
        if samples > _MOST:
            raise Unsettled(f"the peak of {output} cannot be told: {start:.3g} s after its load it still rings")
        for low in np.arange(start, stop, step * _BLOCK):
            time = low + step * np.arange(-1, _BLOCK + 1)
            z = np.abs(of.ramp(time, corners, output))
            best = max(best, float(z.max()))
            tops = (z[1:-1] >= z[:-2]) & (z[1:-1] >= z[2:]) & (z[1:-1] >= _NEAR * best)
            for k in np.union1d(np.flatnonzero(tops) + 1, np.argmax(z)):
                candidates.append((float(z[k]), float(time[k]), step))
        left = float(ramps @ np.exp(-decay * (stop - last)))
        if abs(limit) + left <= best * (1 + _SETTLED):
            break
        if stop > _LONGEST:
            break
        if left <= _SETTLED * abs(limit):
            candidates.append((abs(limit), math.inf, step))
            break
        start, stop = stop, 1.5 * stop
    return max(
        (value, at) if math.isinf(at) else _refined(of, output, corners, at, step)
        for value, at, step in candidates
        if value >= _NEAR * best
    )


def _refined(of: Modes, output: str, corners: Corners, at: float, step: float) -> tuple[float, float]:
    """The local maximum of |z| about `at`, and its instant."""
    for _ in range(3):
        fine = np.linspace(at - step, at + step, 41)
        z = np.abs(of.ramp(fine, corners, output))
        at, step = float(fine[int(np.argmax(z))]), step / 20
    return float(z.max()), at


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
    of = modes(loop)
    poles = of.poles
    settle = 12.0 / float(-poles.real.max()) + float(loop.delays.max())
    step = _step_for(loop.delays, step)
    count = math.ceil((settle + duration) / step)
    noise = rng.normal(scale=math.sqrt(math.pi * loop.density / step), size=count)
    j = loop.output(output)
    z = np.zeros(count)
    for channel, delay in enumerate(loop.delays):
        shift = round(delay / step)
        late = np.concatenate([np.zeros(shift), noise[: count - shift]])
        for pole, gain in zip(poles, of.residues[j, channel], strict=True):
            decay = np.exp(pole * step)
            z += lfilter([0.0, gain * (decay - 1.0) / pole], [1.0, -decay], late).real
        z += loop.D[j, channel] * late
    squares = z[math.ceil(settle / step) :] ** 2
    blocks = np.array([block.mean() for block in np.array_split(squares, 20)])
    value = math.sqrt(float(squares.mean()))
    return value, float(blocks.std(ddof=1) / math.sqrt(len(blocks)) / (2 * value))


def run_through(
    of: Modes, output: str, pieces: Sequence[Real], spacing: float, speed: float, derivative: int
) -> tuple[float, float]:
    """Root mean square of an output while a profile is run over, and its standard error from parts of a few seconds.

    A cubic spline goes through the profile; its derivative is held over steps of at most 2 ms, in each channel late by
    its own delay. What the vehicle does before it has settled is left out of every piece.

    Parameters
    ----------
    of : Modes
        Of the vehicle driven by that derivative.
    output : str
    pieces : arrays of the profile, m
    spacing : between its values, m
    speed : m/s
    derivative : 1 or 2

    Raises
    ------
    Unsettled
        If the pieces are too short for the vehicle to settle on them.
    """
    from scipy.interpolate import CubicSpline
    from scipy.signal import lfilter  # slow to import, and only this needs it

    settle = 8.0 / float(-of.poles.real.max()) + float(of.delays.max())
    step = min(2e-3, spacing / speed / 2)
    j, means = of.outputs.index(output), []
    for piece in pieces:
        count = math.floor((len(piece) - 1) * spacing / speed / step)
        if count * step < settle + _PART:
            continue
        time = step * (np.arange(count) + 0.5)
        rate = CubicSpline(spacing / speed * np.arange(len(piece)), piece).derivative(derivative)
        z = np.zeros(count)
        for channel, delay in enumerate(of.delays):
            late = np.where(time >= delay, rate(np.maximum(time - delay, 0.0)), 0.0)
            for pole, gain in zip(of.poles, of.residues[j, channel], strict=True):
                decay = np.exp(pole * step)
                z += lfilter([0.0, gain * (decay - 1.0) / pole], [1.0, -decay], late).real
            z += of.direct[j, channel] * late
        squares = z[math.ceil(settle / step) :] ** 2
        means += [float(part.mean()) for part in np.array_split(squares, max(1, int(len(squares) * step / _PART)))]
    if len(means) < 2:
        raise Unsettled(
            f"the pieces of the track are too short: the vehicle settles in {settle:.3g} s, and two times {_PART:g} s "
            "more are looked at"
        )
    value = math.sqrt(sum(means) / len(means))
    return value, float(np.std(means, ddof=1)) / math.sqrt(len(means)) / (2 * value)


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
