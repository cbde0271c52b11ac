"""From an admittance to a network that provably has it."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from html import escape
from typing import Any

from flint import fmpq

from posreal.admittance import Device, Rational, as_rational
from posreal.errors import BadDevice, BadInput, DoesNotApply, Infeasible, PosrealError, Unproven, listed
from posreal.network import Network
from posreal.realisation import reza_pantell
from posreal.realisation.approximate import LARGEST, close_network
from posreal.realisation.digits import shortest
from posreal.realisation.fit import Limits
from posreal.realisation.idle_dampers import without_negligible
from posreal.realisation.lift import lifted, typical_size
from posreal.realisation.methods import METHODS, WITH_LEVERS, Method
from posreal.realisation.multiprecision import Long
from posreal.realisation.preamble import CycleMethod
from posreal.realisation.proof import Proof, corners, require_proof
from posreal.realisation.small import Few

PRECISIONS = (1024, 3072, 9216)  # bits, tried in turn until the proof holds
OVERSHOOT = fmpq(1, 10**14)
LEAST_SIZE = 1e-297  # of element values, with the margin that `corners` adds
SETTLED = 5  # elements of a device of degree 2, up to which the methods themselves give the fewest
LARGEST_DEGREE = 20  # a minute; and beyond, nobody would build it


@dataclass(frozen=True)
class Realisation:
    """A network, the device it stands for, and the proof.

    Attributes
    ----------
    network : Network
        Every element valued and positive.
    method : str
        How it was found.
    device : Rational
        What was asked for.
    target : Rational
        What was realised: the device, or the device with the lift.
    proof : Proof
        Relative residuals of the network's admittance, from its graph, against the target.
    lift : float
        Damper (N s/m) added in parallel to a device that missed positive real by rounding; 0 if none.
    notes : tuple of str
        What the user should know: the lift, the misfit.
    misfit : float
        For a network within a tolerance, the largest |Y_network − Y|/|Y| over the band; 0 for the device
        itself.
    """

    network: Network
    method: str
    device: Rational
    target: Rational
    proof: Proof
    lift: float = 0.0
    notes: tuple[str, ...] = ()
    misfit: float = 0.0

    @property
    def residual(self) -> float:
        """The relative residual of the proof."""
        return self.proof.residual

    @property
    def springs(self) -> int:
        """Number of springs."""
        return self.network.counts.springs

    @property
    def dampers(self) -> int:
        """Number of dampers."""
        return self.network.counts.dampers

    @property
    def inerters(self) -> int:
        """Number of inerters."""
        return self.network.counts.inerters

    @property
    def levers(self) -> int:
        """Number of levers."""
        return self.network.counts.levers

    @property
    def spread(self) -> float:
        """The largest over the smallest value of one kind of element, for the kind where that is worst."""
        worst = 1.0
        for letter in "kcb":
            values = [float(part.exact) for part in self.network.elements() if part.letter == letter]
            if values:
                worst = max(worst, max(values) / min(values))
        return worst

    @property
    def rank(self) -> tuple[int, int, float]:
        """What `auto` minimises: elements, then those that store energy, then the spread."""
        return len(self.network), self.springs + self.inerters, self.spread

    def check(self) -> Proof:
        """Prove the network again from scratch.

        Raises
        ------
        Unproven
            If its admittance differs from the target by more than 1e-9.
        """
        return require_proof(self.network, self.target)

    def __str__(self) -> str:
        """One line: method, elements, residual; then the notes and the network."""
        head = f"{self.method}: {len(self.network)} elements, relative residual {self.residual:.1e}"
        return "\n".join([head, *(f"  {note}" for note in self.notes), str(self.network)])

    def _repr_html_(self) -> str:
        head = "".join(f"<p>{escape(line)}</p>" for line in str(self).splitlines()[:-1])
        return f"<div>{head}{self.network._repr_html_()}</div>"

    def to_dict(self) -> dict[str, Any]:
        """JSON-able form."""
        counts = {"springs": self.springs, "dampers": self.dampers, "inerters": self.inerters}
        return {
            "notation": str(self.network),
            "elements": {**counts, "levers": self.levers},
            "residual": self.residual,
            "method": self.method,
            "spread": self.spread,
            "lift": self.lift,
            "misfit": self.misfit,
            "notes": list(self.notes),
            "rational": self.target.to_dict(),
        }


def realise(
    device: Device,
    method: str = "auto",
    *,
    levers: bool = False,
    tolerance: float | None = None,
    band: tuple[float, float] | None = None,
    limits: Limits | None = None,
    largest: int = LARGEST,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> Realisation:
    """A network of springs, dampers and inerters with this admittance.

    Parameters
    ----------
    device : object
        Anything `as_rational` reads. One that misses positive real by rounding is lifted by the smallest
        parallel damper that repairs it, and the result says so.
    method : str
        A name in `METHODS`, or "auto": the fewest elements any of them gives, or :class:`.small.Few` finds for the
        device or for what is left of it after a step of the preamble.
    levers : bool
        Let "auto" use levers (Brune), which cost an element of another kind but save many.
    tolerance : float, optional
        Let "auto" take a smaller network whose admittance is within this part of |Y| over the band; then
        `target` is the network's own admittance and `misfit` says how far it is from the device.
    band : (float, float), optional
        In rad/s, for the tolerance; about the device's corners if not given.
    limits : Limits, optional
        Least and greatest values that can be built; networks beyond them are rejected.
    largest : int
        Elements up to which smaller networks are looked for.
    seed : int
        Of the starts of that search.
    progress : function of str, optional
        Called with a line for each size of small networks that is tried.

    Returns
    -------
    Realisation
        Its `residual` is recomputed from the network's graph and is below 1e-9.

    Raises
    ------
    NotPositiveReal
        If no such network exists, with the witness.
    Infeasible
        If no network found stays within the limits.
    DoesNotApply
        If the method does not serve this device, with the reason.
    BadDevice
        If there is no device at all, or one of degree above 20.
    Unproven
        If the network's admittance is not the device's; a fault of the program.
    """
    if method == "auto":
        found = realise_all(device, [name for name in METHODS if levers or name not in WITH_LEVERS], progress)
        buildable = [r for r in found if limits is None or limits.broken_by(r.network) is None]
        smaller = min(largest, len(buildable[0].network) - 1) if buildable else largest
        if tolerance is None or smaller == 0:
            return _within(found, limits)
        try:
            close = _close(device, tolerance, band, limits, smaller, seed)
        except Infeasible as failure:
            if not buildable:
                raise Infeasible(f"No realisation found can be built within the limits, and {failure}.") from None
            note = f"this is the device itself, not an approximation: {failure}"
            return replace(buildable[0], notes=(*buildable[0].notes, note))
        return _within([close, *found], limits)
    if tolerance is not None:
        raise BadInput(f"A tolerance needs method auto; {method} gives the device exactly.")
    if method not in METHODS:
        raise BadInput(f"There is no method {method!r}; take auto, {listed(METHODS)}.")
    y, repaired, lift, notes = _prepared(device)
    return _within([_realised(method, METHODS[method], y, repaired, lift, notes)], limits)


def realise_all(
    device: Device, methods: Iterable[str] | None = None, progress: Callable[[str], None] | None = None
) -> list[Realisation]:
    """Every realisation there is a method for, fewest elements first; methods that do not apply are left out.

    A network with fewer elements than any method leads to stands among them as "few", where one is found: of up to six
    elements, or the preamble with such a network for what is left.
    Parameters and errors are those of `realise`.
    """
    y, repaired, lift, notes = _prepared(device)
    found, refusals = [], []
    for method in METHODS if methods is None else methods:
        try:
            found.append(_realised(method, METHODS[method], y, repaired, lift, notes))
        except DoesNotApply as refusal:
            refusals.append(refusal)
    if not found:
        raise refusals[-1]
    fewest = min(len(r.network) for r in found)
    if repaired.degree > 2 or (repaired.degree == 2 and fewest > SETTLED):

        def few(target: Rational, arithmetic: Long) -> Network:
            small = Few(arithmetic, progress or (lambda text: None))
            network = small(target, fewest - 1)
            if network is None and fewest > small.largest and not lift:
                network = CycleMethod(reza_pantell.cycle, arithmetic, small)(target)
            if network is None or len(network) >= fewest:
                raise DoesNotApply("No network was found that is smaller than those of the methods.")
            return network

        with contextlib.suppress(DoesNotApply, Unproven):
            # a lift makes a network larger and its device another one: what has few elements is passive without
            found.append(_realised("few", few, y, y if lift else repaired, 0.0, ()))
    return sorted(found, key=lambda r: r.rank)


def _close(
    device: Device,
    tolerance: float,
    band: tuple[float, float] | None,
    limits: Limits | None,
    largest: int,
    seed: int,
) -> Realisation:
    """A network smaller than the device's own and within the tolerance; Infeasible if none is found."""
    y = as_rational(device)
    network, misfit = close_network(y, tolerance, band, limits, largest, seed)
    target = network.admittance()
    note = f"differs from the device by up to {misfit:.2g} of its admittance over the band"
    return Realisation(network, "fit", y, target, require_proof(network, target), 0.0, (note,), misfit)


def _within(found: list[Realisation], limits: Limits | None) -> Realisation:
    """The first that can be built, fewest elements first."""
    ranked = sorted(found, key=lambda r: r.rank)
    broken = [None if limits is None else limits.broken_by(r.network) for r in ranked]
    for result, complaint in zip(ranked, broken, strict=True):
        if complaint is None:
            return result
    raise Infeasible(
        f"No realisation found can be built within the limits: in the smallest, {broken[0]}; "
        "allow a tolerance, or wider limits."
    )


def _prepared(device: Device) -> tuple[Rational, Rational, float, tuple[str, ...]]:
    y = as_rational(device)
    if y.is_zero():
        raise BadDevice("The admittance is zero, which is no device at all; there is nothing to build.")
    if y.degree > LARGEST_DEGREE:
        raise BadDevice(f"This device has degree {y.degree}; networks are made up to degree {LARGEST_DEGREE}.")
    size = typical_size(y)
    needed = (value for w in corners(y) for value in (w, size, size * w, size / max(w, LEAST_SIZE)))
    if not all(LEAST_SIZE < value < 1 / LEAST_SIZE for value in needed):
        raise BadDevice("This device is beyond what element values can be, 1e-300 to 1e300; scale it first.")
    repaired, lift = lifted(y)
    notes = () if lift == 0 else (f"lifted by a parallel damper of {lift:.3g} N s/m to be positive real",)
    return y, repaired, lift, notes


def _realised(
    method: str, make: Method, y: Rational, target: Rational, lift: float, notes: tuple[str, ...]
) -> Realisation:
    attempts = [Long(bits) for bits in PRECISIONS]
    if lift:  # what the lift overshoots by is no damper to build
        attempts.insert(0, Long(PRECISIONS[0], negligible=OVERSHOOT))
    problem: PosrealError = Unproven(f"The method {method} was not tried.")
    for attempt in attempts:
        arithmetic = attempt.around(target)
        try:
            network = shortest(make(target, arithmetic), target, arithmetic)
            network, left_out = without_negligible(network, target)
            proof = require_proof(network, target)
            return Realisation(network, method, y, target, proof, lift, (*notes, *left_out))
        except Unproven as failure:
            problem = failure
        except DoesNotApply:
            raise
        except (ArithmeticError, IndexError, BadDevice) as failure:
            problem = Unproven(f"The method {method} broke down on this device ({failure}); try another one.")
    raise problem


__all__ = ["Realisation", "realise", "realise_all"]
