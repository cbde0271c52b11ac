"""A design as something to build: the network of the whole strut, and its own figures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from posreal.network import Network
from posreal.realisation import Realisation, realise
from posreal.realisation.proof import require_proof
from posreal.specification.design import Design
from posreal.specification.mounted import mounted
from posreal.specification.problem import Problem
from posreal.study.prune import PRUNE, pruned
from posreal.study.robust import made_robust

PRINTED = 1e-6  # relative difference of figures that shows


def realised(
    design: Design,
    *,
    method: str = "auto",
    prune: float = PRUNE,
    progress: Callable[[str], None] = lambda text: None,
) -> tuple[Design, Realisation]:
    """The design with a network in its device's place, without the parts that it hardly needs, and measured from it.

    Parameters
    ----------
    design : Design
        With a device.
    method : str
        A realisation method of :func:`posreal.realise`.
    prune : float
        Fraction of the objective that leaving out parts may cost in all (:mod:`.prune`); with 0 every part stays.
    progress : function of str
        Called with a line at each event worth one.

    Returns
    -------
    Design
        With the network, and the metrics that its own admittance gives; where parts were left out the network's
        admittance is the device, and a note says what it was made from.
    Realisation
    """
    assert design.device is not None
    if design.problem.tolerances is not None:
        return _robustly(design, method, prune, progress)
    realisation = realise(design.device, method, progress=progress)
    found = {**design.found, "realised_by": realisation.method, "residual": realisation.residual}
    metrics = design.problem.metrics(design.problem.port(realisation.network.admittance(), whole=design.whole))
    built = replace(design, network=realisation.network, metrics=metrics, found=found)
    smaller = pruned(built, prune, progress) if prune > 0 else None
    if smaller is None:
        off = metrics[design.problem.objective].value / design.objective.value - 1
        if abs(off) > PRINTED:
            said = f"the network's {design.problem.objective} differs from the device's by {off:+.1e} of it"
            built = replace(built, found={**found, "notes": [*design.found.get("notes", ()), said]})
        return built, realisation
    assert smaller.network is not None
    assert smaller.device is not None
    note = _left_out(design, realisation, smaller)
    proof = require_proof(smaller.network, smaller.device)
    notes = [*design.found.get("notes", ()), note]
    return (
        replace(smaller, found={**found, "realised_by": "pruning", "residual": proof.residual, "notes": notes}),
        Realisation(smaller.network, "pruned", design.device, smaller.device, proof, notes=(note,)),
    )


def _robustly(design: Design, method: str, prune: float, progress: Callable[[str], None]) -> tuple[Design, Realisation]:
    """The network of the device, its values then chosen so that the constraints hold within tolerances."""
    plain = replace(design, problem=replace(design.problem, tolerances=None))
    built, realisation = realised(plain, method=method, prune=prune, progress=progress)
    progress("looking for values that keep the constraints within tolerances")
    robust = made_robust(replace(built, problem=replace(built.problem, tolerances=design.problem.tolerances)))
    assert robust.network is not None
    assert robust.device is not None
    assert built.device is not None
    before, after, objective = built.objective, robust.objective, design.problem.objective
    note = (
        f"values changed so that the constraints hold within tolerances: {objective} {after.value:.6g} {after.unit}, "
        f"{before.value:.6g} as drawn"
    )
    proof = require_proof(robust.network, robust.device)
    notes = [*built.found.get("notes", ()), note]
    return (
        replace(robust, found={**built.found, "residual": proof.residual, "notes": notes}),
        Realisation(robust.network, realisation.method, built.device, robust.device, proof, notes=(note,)),
    )


def _left_out(design: Design, realisation: Realisation, smaller: Design) -> str:
    """What pruning did, and what it costs."""
    network, objective = smaller.network, design.problem.objective
    assert network is not None
    before, after = design.objective, smaller.objective
    change = 100 * (after.value / before.value - 1)
    worth = f"{abs(change):.2g} % {'better' if change < 0 else 'worse'}" if change else "the same"
    whole, gone = len(realisation.network), len(realisation.network) - len(network)
    return (
        f"{gone} of the {whole} elements of the device ({realisation.method}) left out, the values improved: "
        f"{objective} {after.value:.6g} {after.unit}, {worth}; "
        f"the device of order {design.order} has {before.value:.6g}"
    )


def terminals(problem: Problem) -> tuple[str, str]:
    """What a strut stands between."""
    return problem.place.terminals


def degree(design: Design) -> int:
    """McMillan degree of the whole strut, bush or static spring included."""
    if design.device is None:
        return 0
    if design.whole:
        return design.device.degree
    mounting = design.problem.mounting
    return (design.device if mounting.behind is None else mounting.behind + design.device).degree + (
        mounting.behind is None
    )


def strut(design: Design) -> Network | None:
    """The network of the whole strut, bush or static spring included; None where there is no network."""
    if design.network is None:
        return None
    return design.network if design.whole else mounted(design.problem, design.network)
