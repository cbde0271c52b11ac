"""Every command line and file, however bad, against the rule: exit code 0, 1 or 2; what cannot be answered is one line
on standard error that begins with ``posreal:``; no traceback, no warning, no echo of long input, no endless run;
with ``--json`` one strict JSON document and nothing else.

Two parts: the kinds that are known to break such programs, one by one, and drawn ones: good command lines with words
replaced, dropped, doubled and added. Run and sized as :mod:`tests.fuzz.test_numbers`; failures print the command.
"""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.fuzz.runner import ROOT, Answer, Commands

pytestmark = pytest.mark.fuzz
LONGEST = 1000  # characters of a message after the name of the program
QUICK = 30  # CPU seconds that a bad command may take, at most


def breach(words: list[str], answer: Answer) -> str | None:
    """How an answer breaks the rule."""
    if answer.code is None:
        return f"does not end ({answer.cpu:.0f} s of CPU)"
    if answer.code not in (0, 1, 2):
        return f"exit code {answer.code}: {answer.err[-200:]!r}"
    if "Traceback" in answer.err + answer.out:
        return "traceback: " + answer.err.strip().splitlines()[-1][:200]
    if "Warning" in answer.err:
        return "warning: " + next(line for line in answer.err.splitlines() if "Warning" in line)[:200]
    lines = answer.err.splitlines()
    if answer.code == 0 and answer.err:
        return f"done, but says {answer.err[:200]!r}"
    if answer.code == 2 and not (len(lines) == 1 and answer.err.endswith("\n")) and words:
        return f"not one line: {answer.err[:200]!r}"
    if answer.code == 1 and not answer.err and not answer.out:
        return "no without a word"
    if lines and words and not (len(lines) == 1 and lines[0].startswith("posreal: ")):
        return f"not one line of its own: {answer.err[:200]!r}"
    if len(answer.err.removeprefix("posreal: ").rstrip()) > LONGEST:
        return f"a message of {len(answer.err)} characters: {answer.err[:100]!r}"
    if any(ord(c) < 32 and c != "\n" for c in answer.err):
        return f"control characters: {answer.err[:200]!r}"
    if "--json" in words and answer.code == 0 and "--help" not in words and "--version" not in words:
        try:
            json.loads(answer.out, parse_constant=_refuse)
        except ValueError as error:
            return f"not one JSON document: {error}"
    return None


def _refuse(constant: str) -> Any:
    raise ValueError(f"{constant} in JSON")


def hold(commands: Commands, folder: Path, cases: list[list[str]]) -> None:
    failures = []
    for words in cases:
        answer = commands(*words, folder=folder, cpu=QUICK, wall=120)
        wrong = breach(words, answer)
        if wrong:
            line = shlex.join(["posreal", *words])
            failures.append(f"{line if len(line) < 400 else line[:400] + '…'}\n    {wrong}")
    if failures:
        pytest.fail(f"{len(failures)} of {len(cases)} commands:\n" + "\n".join(failures), pytrace=False)


# --- the known kinds -----------------------------------------------------------------------------------------

NUMBERS = (
    "1e400",
    "-1e400",
    "1e-400",
    "nan",
    "inf",
    "-1",
    "0",
    "9" * 5000,
    "1e",
    "0x10",
    "١",
    "1_000",
    "",
    "1/0",
    "1e308 kg",
)
TEXTS = (
    "",
    " ",
    "x" * 300,
    "x" * 5000,
    "é" * 200,
    "\x1b[31m",
    "a\nb",
    "(" * 1000,
    "..",
    "/",
    "--",
    "-",
    "=",
    "s" * 4000,
)


def test_numbers_out_of_range(commands, tmp_path: Path):
    cases = []
    for x in NUMBERS:
        cases += [
            ["evaluate", "vertical-comfort", f"c={x}"],
            ["evaluate", "quarter-car", "S1", f"c={x}"],
            ["evaluate", "quarter-car", "c=2000", "--stiffness", x],
            ["evaluate", "lateral-comfort", "c=20000", f"V={x}"],
            ["evaluate", "quarter-car", "c=2000", "--limit", f"J1={x}"],
            ["evaluate", "quarter-car", "c=2000", "--worst-case", f"V={x}"],
            ["evaluate", "quarter-car", "c=2000", "--sweep", f"V=1:{x}:3"],
            ["evaluate", "quarter-car", "c=2000", "--seed", x],
            ["check", x],
            ["realise", f"{x}*s + 1"],
            ["optimise", "quarter-car", "S1", "--starts", x],
            ["search", "quarter-car", "--elements", x],
            ["search", "quarter-car", "--elements", "1", "--jobs", "1", "--starts", "1", "--k-min", x],
            ["synthesise", "quarter-car", "--order", x],
            ["bound", "quarter-car", "--order", x],
            ["compare", "quarter-car", "--orders", x],
            ["layouts", "S1", "--width", x],
        ]
    cases += [["search", "quarter-car", "--elements", "1", "--jobs", j] for j in ("0", "-5", "1e20", "x")]
    cases += [
        ["evaluate", "quarter-car", "c=2000", "--sweep", s] for s in ("V=1e-300:1e300:3", "V", "V=1:2", "V=1:2:0")
    ]
    hold(commands, tmp_path, cases)


def test_texts(commands, tmp_path: Path):
    cases = []
    for x in TEXTS:
        cases += [
            [x],
            ["check", x],
            ["realise", x],
            ["layouts", x],
            ["check-bound", x],
            ["evaluate", x, "c=1"],
            ["evaluate", "quarter-car", x],
            ["evaluate", "quarter-car", "c=2000", x],
            ["evaluate", "quarter-car", "c=2000", "--vehicle", x],
            ["evaluate", "quarter-car", "c=2000", "--objective", x],
            ["evaluate", "quarter-car", "c=2000", "--limit", x],
            ["evaluate", "quarter-car", "c=2000", "--worst-case", x],
            ["evaluate", "vertical-comfort", "c=2000", "--position", x],
            ["optimise", "quarter-car", x],
            ["reproduce", "--figures", x, "--nothing"],
        ]
    for n in (256, 1000, 4095, 4096, 60_000):
        cases += [
            ["check", " | ".join(["c=1"] * (n // 6))],
            ["check", "+".join(["s"] * (n // 2))],
            ["check", "k=" + "1" * n],
        ]
    cases += [["check", "(" * n + "s" + ")" * n] for n in (99, 101, 1000, 20_000)]
    cases += [["check", "s^99999999999"], ["check", "s^40*s^40"], ["check", "2**9999*s"], ["check", "s/(s^2+1) - 1"]]
    cases += [
        ["check", text] for text in ("-s", "1/s^2", "s-s", "0", "1/(s-s)", "c", "k=1 | ", "k=1 c=2", "2s", "(s+1)(s+2)")
    ]
    cases += [["evaluate", "quarter-car", "c=2000", "--objective", sum_] for sum_ in OBJECTIVES]
    hold(commands, tmp_path, cases)


OBJECTIVES = (
    "J1 + 0.001*J3",
    "gain_tyre_force + J1",
    "J1 + gain_tyre_force",
    "J1 + J1",
    "J1 + ",
    "1e400*J1 + J3",
    "-1*J1 + J3",
    "0*J1 + J3",
    "J1 + J9",
    "nan*J1 + J3",
)

DEEP = 2000
FILES = {
    "empty": "",
    "broken.toml": "[side-view\nmv = 1",
    "huge.toml": "[side-view]\nmv = 1e400",
    "long.toml": "[side-view]\nmv = " + "9" * 6000,
    "nan.toml": "[side-view]\nmv = nan",
    "list.toml": "[side-view]\nmv = [1, 2]",
    "deep.toml": "[side-view]\nmv = " + "[" * DEEP + "]" * DEEP,
    "dotted.toml": ".".join(["a"] * 20_000) + " = 1",
    "table.toml": "side-view = 5",
    "date.toml": "[side-view]\nmv = 2020-01-01",
    "name.toml": "[side-view]\n" + "x" * 3000 + " = 1",
    "escape.toml": '[side-view]\n"\\u001b[31m" = 1',
    "role.toml": 'name = "L"\nnetwork = "k | c"\n[roles]\nk = "bush"',
    "published.toml": 'name = "L"\nnetwork = "k | c"\npublished = 5',
    "layout.toml": 'network = "k | c"',
    "lever.toml": 'network = "lever(2, c)"',
    "number.json": '{"numerator": [1e400], "denominator": [1]}',
    "digits.json": '{"numerator": [' + "7" * 5000 + '], "denominator": [1]}',
    "zero.json": '{"numerator": [1], "denominator": [0]}',
    "many.json": '{"numerator": [' + ",".join(["1"] * 60_000) + '], "denominator": [1]}',
    "deep.json": "[" * 100_000,
    "broken.json": '{"numerator": [1',
    "shape.json": '{"numerator": {"a": 1}, "denominator": "s"}',
    "text.net": "c=1 | " * 70 + "c=1",
    "bytes": "\x00\x01\x02",
    "certificate.json": '{"version": 1, "best": {"value": 0}}',
    "checkpoint": '{"a": 1}\n',
}


def test_files(commands, tmp_path: Path):
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "latin").write_bytes(b"c=\xe91000")
    (tmp_path / "folder").mkdir()
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "endless").symlink_to("/dev/zero")
    cases = []
    for name in (*FILES, "latin", "folder", "pipe", "endless", "missing", "n" * 300):
        path = str(tmp_path / name)
        cases += [
            ["evaluate", "vertical-comfort", "c=2000", "--vehicle", path],
            ["evaluate", "vertical-comfort", path],
            ["evaluate", "quarter-car", path, "--json"],
            ["check", path],
            ["realise", path],
            ["layouts", path],
            ["check-bound", path],
            ["optimise", "quarter-car", path, "--starts", "1"],
            ["search", "quarter-car", "--elements", "1", "--starts", "1", "--jobs", "1", "--checkpoint", path],
            ["realise", "c=1", "--write", path],
        ]
    hold(commands, tmp_path, cases)


@pytest.mark.parametrize(
    "words", [["problems"], ["problems", "--json"], ["evaluate", "quarter-car", "c=2000", "--json"]]
)
def test_a_full_disk(words: list[str]):
    """Exit code 2 and a sentence: nothing was answered, and 1 would mean no."""
    with open("/dev/full", "w") as full:
        run = subprocess.run(
            [sys.executable, "-m", "posreal", *words],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            cwd=ROOT,
            timeout=300,
        )
    answer = Answer(run.returncode, "", run.stderr, 0.0)
    assert breach(words, answer) is None
    assert run.returncode == 2


def test_a_closed_pipe():
    """As every filter: quietly."""
    line = f"{shlex.quote(sys.executable)} -m posreal problems | true; exit ${{PIPESTATUS[0]}}"
    run = subprocess.run(["bash", "-c", line], capture_output=True, text=True, cwd=ROOT, timeout=300)
    assert run.stderr == ""
    assert run.returncode in (0, 1, 2)


# --- drawn command lines -------------------------------------------------------------------------------------

GOOD = (
    ["check", "(s^2 + s + 1)/(s^2 + s + 4)"],
    ["check", "k=2e5 | (c=2e4 + b=300)", "--json"],
    ["realise", "2.5e5/s + 2e4", "--json"],
    ["realise", "c=1 | (k=2 + b=3)", "--ascii", "--width", "60"],
    ["layouts", "S7", "--ascii"],
    ["problems", "--json"],
    ["evaluate", "quarter-car", "S1", "c=2000", "--stiffness", "60 kN/m", "--json"],
    ["evaluate", "vertical-comfort", "c=1.1e4 | b=92", "--position", "M", "--json"],
    ["evaluate", "quarter-car", "c=2000", "V=30", "--limit", "J3=600", "--json"],
    ["evaluate", "quarter-car", "c=2000", "--sweep", "V=10:30:3", "--json"],
    ["evaluate", "quarter-car", "c=2000", "--worst-case", "V=40", "--objective", "J1 + 0.001*J3"],
    ["optimise", "quarter-car", "S1", "--starts", "1", "--json"],
)
PIECES = (
    *(x for x in NUMBERS if len(x) < 100),
    *(x for x in TEXTS if len(x) < 400 and x != "/"),
    "--json", "--ascii", "--width", "--seed", "--limit", "--sweep", "--position", "--vehicle", "--help", "--nothing",
    "-x", "S1", "S3", "c=1", "k=1e4", "b=1e-9", "V=1e9", "ms=1e-9", "quarter-car", "lateral-comfort", "default",
    "none", "s", "1/s", "s^2", "k | c", "(c + b)", "c=1 kN s/m", "k=1 parsec", "J1=5", "J1 + J3", "gain_acceleration",
    "0:1:2",
)  # fmt: skip


def mutated(rng: np.random.Generator) -> list[str]:
    words = list(GOOD[int(rng.integers(len(GOOD)))])
    for _ in range(int(rng.integers(1, 4))):
        at, piece = int(rng.integers(1, len(words) + 1)), PIECES[int(rng.integers(len(PIECES)))]
        match int(rng.integers(5)):
            case 0 if at < len(words):
                words[at] = piece
            case 1:
                words.insert(at, piece)
            case 2 if at < len(words) and len(words) > 2:
                del words[at]
            case 3 if at < len(words):
                cut = int(rng.integers(len(words[at]) + 1))
                words[at] = words[at][:cut] + piece + words[at][cut:]
            case _ if at < len(words):
                words.insert(at, words[at])
    return [word.replace("\x00", "") for word in words]


def test_drawn_command_lines(fuzz, commands, tmp_path: Path):
    """Twenty times `size` of them."""
    hold(
        commands,
        tmp_path,
        [mutated(np.random.default_rng([7, seed])) for s in fuzz.seeds for seed in range(20 * s, 20 * s + 20)],
    )
