"""No input breaks the program: exit code 0, 1 or 2 and one short sentence, whatever is typed or lies in a file."""

from __future__ import annotations

import hashlib
import json
import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest

from posreal import cli
from posreal.admittance import check, parse_rational
from posreal.errors import BadInput, plain, shown
from posreal.files import read_json, read_text, read_toml, require_writable, write_whole
from posreal.network import parse
from posreal.topology.checkpoint import Checkpoint

DEEP = 1000


@pytest.fixture
def posreal(monkeypatch, capsys):
    """Run the command in this process; its exit code, and what it says in one sentence."""

    def run(*words: str) -> tuple[int, str]:
        monkeypatch.setattr(sys, "argv", ["posreal", *words])
        with pytest.raises(SystemExit) as leave:
            cli.main()
        captured = capsys.readouterr()
        code = int(leave.value.code or 0)
        assert code in (0, 1, 2)
        assert captured.err.count("\n") == (code == 2)
        assert len(captured.err) < 1100
        assert captured.err.replace("\n", "").isprintable()
        return code, captured.err

    return run


def refused(posreal, *words: str, says: str = "") -> None:
    code, sentence = posreal(*words)
    assert code == 2
    assert sentence.startswith("posreal: ")
    assert says in sentence


# --- devices ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("length", [200, 255, 256, 1000, 4095, 4096])
def test_a_device_may_be_longer_than_a_name_of_a_file(posreal, length):
    assert posreal("check", "s+" + "1".rjust(length - 2, "0"))[0] == 0
    refused(posreal, "check", "x" * length, says="is not known; the only variable is s")


def test_the_program_reads_its_own_long_notation(posreal, tmp_path):
    network = parse(" | ".join(f"(k{i}=123456.789 + c{i}=1234.5)" for i in range(16)))
    path = tmp_path / "long.net"
    path.write_text(f"{network}\n")
    assert len(str(network)) > 425
    assert posreal("evaluate", "quarter-car", str(path))[0] == 0
    assert posreal("evaluate", "quarter-car", str(network))[0] == 0


@pytest.mark.parametrize(
    "text", ["s/(s^2+1) - 1", "s/(s^2+4) + s/(s^2+1) - 2", "-(s^2+1)^2/(s+1)^4", "-(s^2+1)^2*(s^2+4)^2/(s+1)^8"]
)
def test_a_function_negative_almost_everywhere_has_a_witness(text):
    """Re Y ≤ 0 everywhere, with double zeros where a band is sampled first, or none at all."""
    y = parse_rational(text)
    witness = check(y).witness
    assert y.exact_response(witness.omega)[0] == witness.value < 0


@pytest.mark.parametrize("number", ["1e400", "9" * 400, "9" * 5000, "1" + "0" * 310, "nan", "-inf"])
@pytest.mark.parametrize(
    "words",
    [
        ("evaluate", "quarter-car", "c=1e3", "--stiffness", "{}"),
        ("evaluate", "quarter-car", "S1", "c={}"),
        ("evaluate", "quarter-car", "c=1e3", "ms={}"),
        ("evaluate", "vertical-comfort", "c=1e3", "V={}"),
        ("evaluate", "quarter-car", "c=1e3", "--sweep", "ms={}:1:3"),
        ("evaluate", "quarter-car", "c=1e3", "--worst-case", "ms={}"),
        ("evaluate", "quarter-car", "c=1e3", "--limit", "J3={}"),
        ("evaluate", "quarter-car", "c=1e3", "--objective", "{}*J1 + J3"),
        ("realise", "(s^2+s+1)/(s^2+s+4)", "--k-min", "{}"),
        ("realise", "(s^2+s+1)/(s^2+s+4)", "--band", "0.1:{}", "--tolerance", "0.1"),
        ("bound", "quarter-car", "--omega0", "{}"),
        ("optimise", "quarter-car", "S1", "--jobs", "{}"),
        ("optimise", "quarter-car", "S1", "--seed", "{}"),
        ("search", "quarter-car", "--elements", "1", "--jobs", "{}"),
        ("search", "quarter-car", "--elements", "1", "--bounds", "k=1:{}"),
    ],
)
def test_a_number_that_no_float_holds_is_refused_everywhere(posreal, words, number):
    refused(posreal, *(word.format(number) for word in words))


@pytest.mark.parametrize(
    "words",
    [
        ("evaluate", "quarter-car", "c=1e3", "--objective", "1e300*J1 + J3"),
        ("evaluate", "quarter-car", "c=1e3", "--objective", "J3 + 1e-300*J1"),
        ("evaluate", "quarter-car", "c=1e3", "--stiffness", "1e20"),
        ("evaluate", "quarter-car", "c=1e3", "--stiffness", "1e-20"),
        ("bound", "quarter-car", "--omega0", "1e-300", "--points", "3"),
        ("bound", "quarter-car", "--omega0", "1e300", "--points", "3"),
        ("check", "\u0663"),
    ],
)
def test_numbers_at_which_the_arithmetic_breaks_down_are_refused(posreal, words):
    refused(posreal, *words)


@pytest.mark.parametrize("words", [("V=1e-300:1e300:3",), ("ms=1e-300:1e300:3",), ("ms=1:2:1e9",)])
def test_a_sweep_beyond_all_reason_is_refused(posreal, words):
    refused(posreal, "evaluate", "quarter-car", "c=1e3", "--sweep", *words)


# --- files ------------------------------------------------------------------------------------------------------

NO_FILES = ("fifo", "device", "endless", "loop", "folder")


@pytest.fixture
def no_file(tmp_path):
    """Names of things that are no regular files, by kind and ending."""

    def make(kind: str, ending: str) -> str:
        path = tmp_path / f"{kind}{ending}"
        if kind == "fifo":
            os.mkfifo(path)
        elif kind == "folder":
            path.mkdir()
        else:
            path.symlink_to({"device": "/dev/null", "endless": "/dev/zero", "loop": path}[kind])
        return str(path)

    return make


@pytest.mark.parametrize("kind", NO_FILES)
def test_what_is_no_regular_file_is_refused_at_once(posreal, no_file, kind):
    toml, text = no_file(kind, ".toml"), no_file(kind, ".json")
    for words in (
        ("evaluate", "quarter-car", text),
        ("realise", text),
        ("check-bound", text),
        ("layouts", toml),
        ("evaluate", "quarter-car", "c=1e3", "--vehicle", toml),
        ("search", "quarter-car", "--elements", "1", "--checkpoint", text),
        ("bound", "quarter-car", "--effort", "3", "--save", text),
        ("check", no_file(kind, "")) if kind in ("fifo", "device", "endless") else ("check", text),
    ):
        refused(posreal, *words)


@pytest.mark.parametrize("size", [1_000_001, 3_000_000])
def test_files_are_read_to_a_limit(tmp_path, size):
    path = tmp_path / "large.json"
    path.write_bytes(b" " * size)
    with pytest.raises(BadInput, match="is larger than 1000000 bytes"):
        read_text(path)


@pytest.mark.parametrize(
    "text",
    [
        "[" * DEEP + "]" * DEEP,
        '{"a":' * DEEP + "1" + "}" * DEEP,
        "[" * 200_000,
        "9" * 5000,
        "[1e400]",
        "[NaN]",
        "{",
        "",
    ],
)
def test_json_that_is_none_here_is_a_sentence(tmp_path, text):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(BadInput) as caught:
        read_json(path)
    assert str(path) in str(caught.value)
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * DEEP + "]" * DEEP,
        "a = " + "{a = " * DEEP + "1" + "}" * DEEP,
        "a = " + "9" * 5000,
        ".".join(["a"] * 20_000) + " = 1",
        " . ".join(['"a b"'] * 20_000) + " = 1",
        "[" + ".".join(["'a'"] * 20_000) + "]",
    ],
)
def test_toml_that_is_none_here_is_a_sentence(tmp_path, text):
    path = tmp_path / "a.toml"
    path.write_text(text)
    with pytest.raises(BadInput) as caught:
        read_toml(path)
    assert str(path) in str(caught.value)
    assert len(str(caught.value)) < 400


def test_ordinary_toml_is_read(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text('[a.b.c]\nd.e = 1.5\ntext = "one. two. three."\nlist = [[1], [2]]\n')
    assert read_toml(path) == {"a": {"b": {"c": {"d": {"e": 1.5}, "text": "one. two. three.", "list": [[1], [2]]}}}}


@pytest.mark.parametrize(
    "document",
    [
        {"numerator": [1] * 60_000},
        {"numerator": [1], "denominator": [1] * 102},
        {"numerator": [[1]]},
        {"numerator": [True]},
        {"numerator": ["٣"]},
        {"numerator": ["1e99999"]},
        {"design": {"network": 5}},
        {"network": "k=1e400"},
        [],
    ],
)
def test_documents_that_hold_no_device(posreal, tmp_path, document):
    path = tmp_path / "a.json"
    path.write_text(json.dumps(document))
    refused(posreal, "evaluate", "quarter-car", str(path))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('network = "k | c"\n[elements.k]\nrole = "bush"', "contains the bush"),
        ('network = "k | c"\n[elements.k]\nfixed = "bush"', "contains the bush"),
        ('network = "k | c"\n[elements.k]\nbounds = ["1 N/m", "bush"]', "contains the bush"),
        ('network = "k | c"\n[elements.c]\nrole = "static spring"', "c is none"),
        ('network = "k | c"\n[elements.k]\nbounds = ["static spring", 1]', "is not below"),
        ('network = "k | c"\n[elements.k]\nfixed = 1e400', "is not a value"),
        ('network = "k | c"\n[elements.k]\nrole = ["bush"]', "unknown role"),
        ('network = "k | c"\npublished = 5', "[[published]]"),
        ('network = "k | c"\npublished = [5]', "[[published]]"),
        ('network = "{1-2: k, 2-0: c, 1-2-0: n}"', "lever"),
        ("network = 5", "has no network"),
    ],
)
def test_layouts_that_do_not_fit(posreal, tmp_path, text, says):
    path = tmp_path / "own.toml"
    path.write_text(text)
    refused(posreal, "optimise", "quarter-car", str(path), says=says)


def test_a_published_row_of_no_numbers(posreal, tmp_path):
    path = tmp_path / "own.toml"
    for row in ('values = {k = "x"}, figures = {J1 = 1}', 'values = {k = 1}, figures = {J1 = "x"}', "values = 5"):
        path.write_text(f'network = "k | c"\npublished = [{{table = 1, problem = "quarter-car", {row}}}]')
        refused(posreal, "layouts", str(path), says="[[published]]")


def test_names_of_three_hundred_characters(posreal):
    name = "n" * 300
    for words in (
        ("evaluate", "quarter-car", f"{name}.json"),
        ("evaluate", "quarter-car", "c=1", "--vehicle", f"{name}.toml"),
        ("layouts", f"{name}.toml"),
        ("check-bound", name),
        ("bound", "quarter-car", "--effort", "3", "--save", name),
        ("search", "quarter-car", "--elements", "1", "--checkpoint", name),
        ("synthesise", "quarter-car", "--order", "2", "--write", f"{name}.net"),
        ("compare", "quarter-car", "--plot", f"{name}.svg"),
        ("evaluate", name, "c=1"),
        ("optimise", "quarter-car", name),
    ):
        refused(posreal, *words)


@pytest.mark.parametrize(
    "words",
    [
        ("check", "{}"),
        ("evaluate", "quarter-car", "{}"),
        ("evaluate", "{}", "c=1"),
        ("evaluate", "quarter-car", "c=1", "--objective", "{}"),
        ("evaluate", "quarter-car", "c=1", "--{}"),
        ("realise", "s", "--method", "{}"),
        ("{}",),
        ("search", "quarter-car", "--elements", "1", "--at-most", "{}"),
        ("problems", "{}"),
    ],
)
@pytest.mark.parametrize("text", ["x" * 50_000, "\x1b[2Jx\ny\u202e", "x'\"\\" * 300])
def test_input_is_quoted_short_and_escaped(posreal, words, text):
    refused(posreal, *(word.format(text) for word in words))


def test_quoting():
    assert plain("0123456789", 6) == "012…89"
    assert plain("a\n\x1b\u202e") == r"a\n\x1b\u202e"
    assert shown("it's") == '"it\'s"'
    assert shown(10**5000) == "a very large int"
    assert len(shown(["x"] * 10_000)) == 60
    nested: list[object] = []
    for _ in range(100_000):
        nested = [nested]
    assert shown(nested) == "a very large list"


# --- what is written --------------------------------------------------------------------------------------------


def test_a_planted_link_is_not_followed(tmp_path, monkeypatch):
    victim = tmp_path / "victim"
    victim.write_text("precious")
    for name in (".a.net.part", f".{'ab' * 8}.part"):
        (tmp_path / name).symlink_to(victim)
    write_whole(tmp_path / "a.net", b"new")
    assert (tmp_path / "a.net").read_bytes() == b"new"
    monkeypatch.setattr("secrets.token_hex", lambda n: "ab" * n)  # even where the name is guessed
    with pytest.raises(BadInput, match="File exists"):
        write_whole(tmp_path / "a.net", b"other")
    assert victim.read_text() == "precious"


def test_devices_and_pipes_are_not_replaced(no_file):
    for kind in ("fifo", "device", "endless", "folder"):
        path = Path(no_file(kind, ".net"))
        with pytest.raises(BadInput, match="cannot write"):
            write_whole(path, b"x")
        with pytest.raises(BadInput, match="cannot write"):
            require_writable(path, (".net",))
        assert not stat.S_ISREG(path.stat().st_mode)


def test_a_link_stays_and_what_it_leads_to_is_replaced(tmp_path):
    (tmp_path / "real").write_text("old")
    (tmp_path / "link").symlink_to(tmp_path / "real")
    write_whole(tmp_path / "link", b"new")
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real").read_bytes() == b"new"


def test_a_missing_folder_is_noticed_before_the_work(posreal, monkeypatch):
    monkeypatch.setattr("posreal.bounds.compute.bound", lambda *_, **__: pytest.fail("it computed"))
    refused(posreal, "bound", "quarter-car", "--save", "/nowhere/proof.json", says="/nowhere")


def test_a_full_disk_under_a_checkpoint(tmp_path, monkeypatch):
    """What the disk did not take is not written again when the file is closed."""
    with Checkpoint(tmp_path / "a", {"problem": "x"}) as file:
        monkeypatch.setattr(os, "fsync", lambda _: (_ for _ in ()).throw(OSError(28, "No space left on device")))
        with pytest.raises(BadInput, match="No space left on device"):
            file.add([{"a": 1}])
    assert file._file.closed


def run(command: str) -> subprocess.CompletedProcess[str]:
    """A shell line with ``posreal`` in it, in processes of its own."""
    shell = f'posreal() {{ {sys.executable} -m posreal "$@"; }}; {command}'
    return subprocess.run(["bash", "-c", f"set -o pipefail; {shell}"], capture_output=True, text=True, check=False)


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
@pytest.mark.parametrize("words", ["problems --json", "check s --json", "check -1/s", "layouts S1", "--help"])
def test_a_full_disk_under_the_output(words):
    done = run(f"posreal {words} > /dev/full")
    assert done.returncode == 2
    assert done.stderr == "posreal: cannot write the output: No space left on device\n"


@pytest.mark.parametrize("words", ["layouts", "problems --json"])
def test_a_reader_that_has_seen_enough(words):
    done = run(f"posreal {words} | head -c 1")
    assert (done.returncode, done.stderr, len(done.stdout)) == (0, "", 1)
    done = run(f"posreal {words} | true")
    assert (done.returncode, done.stderr) == (0, "")


# --- checkpoints ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("objective", "x"),
        ("objective", -1.0),
        ("objective", float("nan")),
        ("values", []),
        ("values", ["x"]),
        ("values", [float("inf")]),
        ("values", [-1.0]),
        ("values", 5),
        ("agreed", "x"),
        ("starts", None),
        ("network", []),
    ],
)
def test_a_line_with_a_good_checksum_and_a_bad_value(posreal, tmp_path, key, value):
    path = tmp_path / "checkpoint"
    words = ("search", "quarter-car", "--elements", "1", "--checkpoint", str(path))
    assert posreal(*words)[0] == 0
    first, second, *rest = path.read_text().splitlines()
    record = json.loads(second)
    del record["checksum"]
    record[key] = value
    record["checksum"] = hashlib.sha256(json.dumps(record, sort_keys=True).encode()).hexdigest()[:16]
    path.write_text("\n".join([first, json.dumps(record), *rest]) + "\n")
    refused(posreal, *words, says="line 2 of the checkpoint")
