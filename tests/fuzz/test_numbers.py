"""Every printed number of drawn devices, vehicles and plants against :mod:`tests.fuzz.independent`.

Held: each metric in the JSON of ``evaluate`` to 2e-6 (1e-6 for resonances), Macc at the speed it names, and the text
table to its six digits. A refusal is right only if the exact characteristic polynomial says so; where the program says
that a figure cannot be told, that is counted, and one draw in a hundred may end so.
A decay below 1e-13 of the fastest pole may be called the edge of stability.
"""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import control
import numpy as np
import pytest

import posreal
from posreal.errors import PosrealError
from tests.fuzz import draws, independent
from tests.fuzz.draws import Draw, OwnPlant
from tests.fuzz.runner import Answer

pytestmark = pytest.mark.fuzz
DECLINED = "cannot be told"
EDGE = 1e-13  # of the fastest pole: a decay that doubles do not carry
RESONANCES = ("resonance", "side_branch", "lone_resonance", "tuned", "plant_pole")


def right_figures(draw: Draw) -> dict[str, float]:
    """Every figure that the command may print for this draw."""
    if draw.vehicle_name == "plan-view":
        return independent.plan_view(draw.device, draw.vehicle)
    if draw.vehicle_name == "side-view":
        return independent.side_view(draw.device, draw.vehicle)
    found = independent.quarter_car(draw.device, draw.vehicle, gains="gain" in " ".join(draw.options))
    if "--objective" in draw.options:
        parts = re.split(r" \+ ", draw.options[draw.options.index("--objective") + 1])
        if len(parts) > 1:
            weights = [part.split("*") if "*" in part else ["1", part] for part in parts]
            found["sum"] = sum(float(weight) * found[name] for weight, name in weights)
    return found


def default_is_stable(draw: Draw) -> bool:
    try:
        vehicle = draw.vehicle
        independent.plan_view(independent.element("c", vehicle["Csy"]), vehicle)
    except independent.NotStable:
        return False
    return True


def judged(draw: Draw, answer: Answer, tolerance: float) -> str | None:
    """What is wrong with an answer; ``unconfirmed`` where a figure was declined."""
    if answer.code is None:
        return "does not end"
    if "Traceback" in answer.err:
        return "traceback: " + answer.err.strip().splitlines()[-1][:200]
    if "Warning" in answer.err:
        return "warning: " + answer.err.strip().splitlines()[0][:200]
    try:
        right = right_figures(draw)
    except independent.NotStable as reason:
        return (
            None if answer.code == 1 else f"answered though not stable ({reason}): {answer.err or answer.out[:200]!r}"
        )
    if answer.code != 0:
        if DECLINED in answer.err:
            return "unconfirmed"
        if "edge of stability" in answer.err and right["decay"] < EDGE:
            return None
        if "default suspension" in answer.err and not default_is_stable(draw):
            return None
        return f"refused a stable vehicle (code {answer.code}): {answer.err.strip()[:300]}"
    metrics = json.loads(answer.out)["metrics"]
    if not metrics:
        return "no metric"
    wrong = []
    for name, metric in metrics.items():
        if name in ("Macc", "Macc_whole"):  # the largest over the range of speeds, not only of the integers
            speed = float(metric["at"].split()[1])
            alone = independent.plan_view_at(draw.device, {**draw.vehicle, "V": speed}, whole=name != "Macc")
            near = tolerance if speed == int(speed) else 1e-4  # the speed is said to six digits
            if metric["value"] < right[name] * (1 - tolerance) or not math.isclose(
                metric["value"], alone, rel_tol=near
            ):
                wrong.append(
                    f"{name} {metric['value']:.9g} at {speed:g} m/s for {alone:.9g}, of integers {right[name]:.9g}"
                )
            continue
        expected = right["sum" if " + " in name else name]
        error = abs(metric["value"] - expected) / max(abs(expected), 1e-300)
        if not error <= tolerance and metric["value"] != expected:
            wrong.append(f"{name} {metric['value']:.9g} for {expected:.9g} ({error:.1e})")
    return "; ".join(wrong) or None


def report(failures: list[str], unconfirmed: list[str], count: int) -> None:
    if failures:
        pytest.fail(f"{len(failures)} of {count} draws:\n" + "\n".join(failures), pytrace=False)
    allowed = math.ceil(count / 100)
    if len(unconfirmed) > allowed:
        pytest.fail(f"{len(unconfirmed)} of {count} not confirmed:\n" + "\n".join(unconfirmed), pytrace=False)


@pytest.mark.parametrize("kind", draws.KINDS)
@pytest.mark.parametrize("group", draws.VEHICLES)
def test_devices(group: str, kind: str, fuzz, commands, tmp_path: Path):
    """`size` devices of a kind in a vehicle, some of them in another vehicle of its sort."""
    failures, unconfirmed = [], []
    for seed in fuzz.seeds:
        draw = draws.draw(kind, group, seed)
        (tmp_path / "v.toml").write_text(draw.toml)
        answer = commands(*draw.words("v.toml"), folder=tmp_path)
        wrong = judged(draw, answer, 1e-6 if kind in RESONANCES else 2e-6)
        if wrong == "unconfirmed":
            unconfirmed.append(f"{draw.command}\n    {answer.err.strip()}")
        elif wrong:
            failures.append(f"{draw.command}\n    {wrong}")
    report(failures, unconfirmed, len(fuzz.seeds))


@pytest.mark.parametrize("group", draws.VEHICLES)
def test_tables(group: str, fuzz, commands, tmp_path: Path):
    """The table says the document's values to its six digits."""
    failures = []
    for seed in fuzz.seeds[: max(1, len(fuzz.seeds) // 3)]:
        draw = draws.draw("network", group, seed)
        (tmp_path / "v.toml").write_text(draw.toml)
        words = draw.words("v.toml")
        document, table = commands(*words, folder=tmp_path), commands(*words[:-1], folder=tmp_path)
        if document.code != table.code or document.err != table.err:
            failures.append(
                f"{draw.command}\n    table {table.code} {table.err}, document {document.code} {document.err}"
            )
        elif document.code == 0:
            for name, metric in json.loads(document.out)["metrics"].items():
                row = name.removesuffix("_whole")
                line = next(line for line in table.out.splitlines() if line.strip().startswith(row + "  "))
                numbers = [text for text in line[line.index(row) + len(row) :].split() if text[0].isdigit()]
                shown = float(numbers[1 if row != name and row in json.loads(document.out)["metrics"] else 0])
                if not math.isclose(shown, metric["value"], rel_tol=5.001e-6):
                    failures.append(
                        f"{draw.command}\n    {name}: {shown} in the table, {metric['value']} in the document"
                    )
    report(failures, [], len(fuzz.seeds))


def figures_of(own: OwnPlant, gains: bool) -> dict[str, float]:
    """What posreal prints for a plant of one's own."""
    A, B, C, D = own.matrices
    inputs = [f"w{i}" for i in range(B.shape[1] - 1)] + ["f"]
    outputs = [f"z{i}" for i in range(C.shape[0] - 1)] + ["v"]
    problem = posreal.problem_from_plant(
        control.StateSpace(A, B, C, D, inputs=inputs, outputs=outputs, remove_useless_states=False),
        disturbances=[[inputs[i] for i in group] for group in own.groups],
        force="f",
        velocity="v",
        performance="z0",
        objective="gain" if gains else "rms",
        delays={inputs[i]: delay for i, delay in own.delays.items()},
        density={inputs[group[0]]: share for group, share in zip(own.groups, own.densities, strict=True)},
    )
    return {name: metric.value for name, metric in posreal.evaluate(problem, own.device).metrics.items()}


def test_plants_of_ones_own(fuzz):
    """Weighted quarter-cars and chains of masses in raw, balanced, other coordinates, with delays, several inputs."""
    failures, unconfirmed = [], []
    seeds = [seed + i * 10**6 for i in range(4) for seed in fuzz.seeds]
    for seed in seeds:
        own = draws.own_plant(seed)
        gains = not own.delays and bool(seed % 2)
        repeat = f"tests.fuzz.test_numbers.figures_of(tests.fuzz.draws.own_plant({seed}), {gains})  # {own.device}"
        try:
            right: dict[int, tuple[float, float | None]] | None = independent.own_plant(
                own.matrices,
                own.exact,
                processes=[[(i, own.delays.get(i, 0.0)) for i in group] for group in own.groups],
                densities=own.densities,
                force=own.matrices[1].shape[1] - 1,
                velocity=own.matrices[2].shape[0] - 1,
                outputs=range(own.matrices[2].shape[0] - 1),
                gains=gains,
            )
        except independent.NotStable:
            right = None
        try:
            found = figures_of(own, gains)
        except PosrealError as error:
            if right is not None:
                (unconfirmed if DECLINED in str(error) else failures).append(f"{repeat}\n    {error}")
            continue
        except Exception as error:  # whatever it is, it is the failure
            failures.append(f"{repeat}\n    {type(error).__name__}: {error}")
            continue
        if right is None:
            failures.append(f"{repeat}\n    answered though not stable: {found}")
            continue
        for output, (rms, gain) in right.items():
            for name, expected in ((f"rms_z{output}", rms), (f"gain_z{output}", gain)):
                value = found.get(name)
                if value is None or expected is None or np.isclose(value, expected, rtol=2e-6, atol=0):
                    continue
                failures.append(
                    f"{repeat}\n    {name} {value:.9g} for {expected:.9g} ({abs(value / expected - 1):.1e})"
                )
    report(failures, unconfirmed, len(seeds))
