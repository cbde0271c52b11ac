"""The command line as a user meets it: right answers, JSON and nothing else, one sentence for bad input."""

from __future__ import annotations

import json
import math
import os
import shlex
import subprocess
import sys

import pytest

from posreal import __version__, cli


@pytest.fixture
def posreal(monkeypatch, capsys):
    """Run the command in this process: ``posreal("check", "s")`` is (exit code, stdout, stderr)."""

    def run(*words: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["posreal", *words])
        code = 0
        try:
            cli.main()
        except SystemExit as leave:
            code = int(leave.code or 0)
        captured = capsys.readouterr()
        return code, captured.out, captured.err

    return run


def test_it_is_installed():
    command = os.path.join(os.path.dirname(sys.executable), "posreal")
    run = subprocess.run([command, "--version"], capture_output=True, text=True, check=True)
    assert run.stdout == f"posreal {__version__}\n"


def test_help_names_every_command(posreal):
    code, out, _ = posreal("--help")
    assert code == 0
    for command in (
        "problems",
        "layouts",
        "evaluate",
        "optimise",
        "synthesise",
        "realise",
        "check",
        "search",
        "bound",
        "check-bound",
        "compare",
        "design",
    ):
        assert command in out
        assert posreal(command, "--help")[0] == 0


def test_problems_and_layouts(posreal):
    assert "vertical-comfort" in posreal("problems")[1]
    assert json.loads(posreal("problems", "--json")[1])["problems"][0]["name"] == "lateral-comfort"
    assert [row["name"] for row in json.loads(posreal("layouts", "--json")[1])["layouts"]][-1] == "S7"
    drawn = posreal("layouts", "S7")[1]
    assert "body ─┬─[ ke ]─┬─┬────[ b ]────┬─ bogie" in drawn
    assert posreal("layouts", "S7", "--ascii")[1].split("Table")[0].replace("→", "").isascii()


def test_evaluate_prints_every_metric(posreal):
    code, out, err = posreal("evaluate", "lateral-comfort", "S3", "c=2.1025e4", "b=1.53e4")
    assert (code, err) == (0, "")
    for name in ("Macc", "J1y", "Ldmp", "max_yv", "static_stiffness"):
        assert name in out
    document = json.loads(posreal("evaluate", "lateral-comfort", "S3", "c=21025 N s/m", "b=15.3 t", "--json")[1])
    assert document["problem"] == "lateral-comfort"
    assert document["metrics"]["Macc"]["value"] == pytest.approx(0.21726, abs=1e-5)
    assert document["metrics"]["Macc"]["unit"] == "m/s^2"
    assert document["device"]["network"].startswith("k=245000 | ")


@pytest.mark.parametrize("device", ["c=17965 + b=4115", "(17965*4115*s)/(17965+4115*s)", "S5 c=17965 b=4115"])
def test_every_form_of_a_device(posreal, device):
    words = device.split() if device.startswith("S5") else [device]
    code, out, _ = posreal("evaluate", "vertical-comfort", *words, "--json")
    assert code == 0
    assert json.loads(out)["metrics"]["J1z_T"]["value"] == pytest.approx(1.96127, abs=1e-5)


def test_a_device_from_a_file_of_json_or_text(posreal, tmp_path):
    (tmp_path / "device.txt").write_text("c=17965 + b=4115\n")
    plain = json.loads(posreal("evaluate", "vertical-comfort", str(tmp_path / "device.txt"), "--json")[1])
    (tmp_path / "device.json").write_text(json.dumps(plain))
    again = json.loads(posreal("evaluate", "vertical-comfort", str(tmp_path / "device.json"), "--json")[1])
    assert again == plain


def test_sweep(posreal):
    out = posreal("evaluate", "vertical-comfort", "S5", "c=17965", "b=4115", "--sweep", "V=30:55:2", "--json")[1]
    rows = json.loads(out)["sweep"]["rows"]
    assert [row["value"] for row in rows] == [30.0, 55.0]
    assert rows[1]["metrics"] == json.loads(out)["metrics"]
    assert rows[0]["metrics"]["J1z_T"]["value"] < rows[1]["metrics"]["J1z_T"]["value"]


def test_a_sweep_of_two_parameters_and_the_worst_case_beside_the_nominal(posreal):
    words = ("evaluate", "quarter-car", "c=2000", "--sweep", "ms=200:300:3", "--sweep", "k=5e4:7e4:2")
    swept = json.loads(posreal(*words, "--json")[1])["sweep"]
    assert [row["values"] for row in swept["rows"]][1] == {"ms": 200.0, "k": 7e4}
    assert swept["robustness"]["J1"]["worst"] == max(row["metrics"]["J1"]["value"] for row in swept["rows"])
    assert "nominal" in posreal(*words)[1]


def test_operating_points_and_limits_show_their_constraints(posreal):
    words = ("evaluate", "lateral-comfort", "S3", "c=2.1025e4", "b=1.53e4", "--worst-case", "mv=20 t")
    code, out, err = posreal(*words, "--limit", "max_yv=80")
    assert (code, err) == (0, "")
    assert "max_yv at mv=20000 <= 80 (a limit): VIOLATED" in out
    assert "Ldmp at mv=20000 >= 6.45437 (the default's): holds" in out
    bound = json.loads(posreal("optimise", "quarter-car", "S3", "--limit", "inertance=5", "--starts", "1", "--json")[1])
    assert {row["verdict"] for row in bound["designs"][0]["constraints"]} == {"holds"}  # behind a damper: none shows


def test_a_synthesised_design_is_read_back_with_the_parameters_that_were_free(posreal, tmp_path):
    path = tmp_path / "design.json"
    words = ("lateral-comfort-primary", "--order", "0", "--starts", "2", "--sweep", "mv=16e3:18e3:2", "--json")
    text = posreal("synthesise", *words)[1]
    path.write_text(text)
    made = json.loads(text)
    again = json.loads(posreal("evaluate", "lateral-comfort-primary", str(path), "--json")[1])
    assert again["metrics"] == made["design"]["metrics"]
    assert len(made["sweep"]["rows"]) == 2
    other = json.loads(posreal("evaluate", "lateral-comfort-primary", str(path), "Kpy=4.71e6", "--json")[1])
    assert other["metrics"] != again["metrics"]


def test_compare_draws_what_it_prints(posreal, tmp_path):
    path = tmp_path / "rows.png"
    code, out, _ = posreal("compare", "quarter-car", "--orders", "0", "--plot", str(path), "--objective", "J3")
    assert code == 0
    assert f"wrote {path}" in out
    assert path.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "words", [("lateral-comfort", "S1", "c=2e4"), ("vertical-comfort", "default"), ("quarter-car", "S1", "c=2615")]
)
def test_three_ways(posreal, words):
    out = posreal("evaluate", *words, "--three-ways", "--seed", "3", "--json")[1]
    ways = json.loads(out)["three_ways"]
    assert ways["by_frequency"] == pytest.approx(json.loads(out)["metrics"][ways["metric"]]["value"], rel=1e-9)
    assert ways["by_covariance"] == pytest.approx(ways["by_frequency"], rel=4e-3)
    assert abs(ways["simulated"] - ways["by_covariance"]) < 4 * ways["error"]
    assert posreal("evaluate", *words, "--three-ways", "--seed", "3", "--json")[1] == out


def test_vehicle_file(posreal, tmp_path):
    path = tmp_path / "light.toml"
    path.write_text('[side-view]\nmv = "30 t"\n')
    changed = json.loads(posreal("evaluate", "vertical-comfort", "default", "--vehicle", str(path), "--json")[1])
    nominal = json.loads(posreal("evaluate", "vertical-comfort", "default", "--json")[1])
    assert changed["metrics"]["J1z_M"]["value"] > nominal["metrics"]["J1z_M"]["value"]


def test_optimise(posreal):
    code, out, err = posreal("optimise", "vertical-comfort", "S5", "S4", "--starts", "2", "--json")
    assert (code, err) == (0, "")
    first, second = json.loads(out)["designs"]
    assert first["objective"] == {"name": "J1z_T", "value": pytest.approx(1.96127, abs=1e-5), "unit": "%g"}
    assert first["feasible"]
    assert first["parameters"]["c"] == pytest.approx(17965, rel=1e-3)
    assert second["label"] == "S4"
    assert "k at its upper bound" in posreal("optimise", "vertical-comfort", "S5", "--starts", "2")[1]


def test_search(posreal):
    code, out, err = posreal("search", "vertical-comfort", "--elements", "2", "--json")
    assert (code, err) == (0, "")
    front = json.loads(out)["front"]
    assert [point["elements"] for point in front] == [1, 2]
    assert front[1]["objective"] <= 1.9614
    assert set(front[0]) >= {"elements", "objective", "notation", "metrics", "equivalent"}


def test_the_front_of_a_whole_band_figure_has_its_bound(posreal):
    document = json.loads(posreal("search", "quarter-car", "--elements", "1", "--json")[1])
    assert 1.40 < document["bound"] < document["front"][0]["objective"]
    banded = json.loads(posreal("search", "vertical-comfort", "--elements", "1", "--json")[1])
    assert banded["bound"] is None  # J1z ends at 20 Hz, and bounds are over the whole band


def test_bound_and_its_certificate(posreal, tmp_path):
    path = tmp_path / "proof.json"
    words = ("quarter-car", "--points", "21", "--omega0", "20", "--device", "S3 c=3224 b=333", "--save", str(path))
    code, out, err = posreal("bound", *words, "--json")
    assert (code, err) == (0, "")
    document = json.loads(out)
    assert 1.3 < document["bound"]["value"] < 1.4097
    assert document["gap_percent"] > 0
    assert posreal("check-bound", str(path))[0] == 0
    claim = document["bound"]["value"]
    path.write_text(path.read_text().replace(f"{claim}", f"{claim + 0.01}"))
    code, _, err = posreal("check-bound", str(path))
    assert code in (1, 2)
    assert err.count("\n") == 1


def test_check(posreal):
    code, out, _ = posreal("check", "(s^2+s+1)/(s^2+s+4)")
    assert code == 0
    assert "positive real" in out
    code, out, _ = posreal("check", "(s^2+s+1)/(s^2+0.999999999999*s+4)", "--json")
    assert code == 1
    assert json.loads(out)["positive_real"] is False
    assert posreal("check", "-1/s")[0] == 1


def test_realise(posreal):
    code, out, _ = posreal("realise", "(s^2+s+1)/(s^2+s+4)", "--json")
    assert code == 0
    network = json.loads(out)["network"]
    assert network["residual"] < 1e-9
    assert set(network) >= {"notation", "elements", "residual", "method", "diagram"}
    text = posreal("realise", "(s^2+s+1)/(s^2+s+4)")[1]
    assert "body" in text
    assert "bogie" in text


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("evaluate", "vertical", "S5"), "unknown problem 'vertical'"),
        (("evaluate", "vertical-comfort", "S8"), "unknown layout 'S8'"),
        (("evaluate", "vertical-comfort", "S5", "c=1", "q=3"), "unknown parameter 'q'"),
        (("evaluate", "vertical-comfort", "S5", "c=1"), "needs a value for b"),
        (("evaluate", "vertical-comfort", "S5", "c=-1", "b=2"), "c is -1"),
        (("evaluate", "vertical-comfort", "S5", "c=0", "b=2"), "c is 0"),
        (("evaluate", "vertical-comfort", "S5", "c=nan", "b=2"), "nan"),
        (("evaluate", "vertical-comfort", "S5", "c=inf", "b=2"), "inf"),
        (("evaluate", "vertical-comfort", "S5", "c=3 kg", "b=2"), "kg"),
        (("evaluate", "vertical-comfort", "S5", "c=3 furlong", "b=2"), "furlong"),
        (("evaluate", "vertical-comfort", "S5", "c", "b=2"), "'c' is not an assignment"),
        (("evaluate", "vertical-comfort", "k=2 | "), "up to the end"),
        (("evaluate", "vertical-comfort", "nothing.json"), "cannot read nothing.json"),
        (("evaluate", "lateral-comfort", "S5", "c=1", "b=1"), "S5 contains the bush"),
        (("evaluate", "quarter-car", "S1", "c=1e3", "--stiffness", "-5"), "k (static suspension stiffness)"),
        (("evaluate", "quarter-car", "S1", "c=1e3", "--stiffness", "5 kg"), "--stiffness"),
        (
            ("evaluate", "vertical-comfort", "S5", "c=1", "b=1", "--vehicle", "none.toml"),
            "cannot read none.toml",
        ),
        (("evaluate", "vertical-comfort", "S5", "c=1", "b=1", "--sweep", "V=1"), "is not a range"),
        (("evaluate", "vertical-comfort", "S5", "c=1", "b=1", "--sweep", "W=1:2:3"), "unknown parameter 'W'"),
        (("evaluate", "vertical-comfort", "S5", "--bogus"), "no such option --bogus"),
        (("evaluate", "vertical-comfort"), "DEVICE"),
        (("bogus",), "bogus"),
        (("optimise", "quarter-car", "S1", "--starts", "0"), "--starts"),
        (("optimise", "quarter-car", "S1", "--limit", "J3"), "is not a limit"),
        (("optimise", "quarter-car", "S1", "--limit", "J9=3"), "cannot be limited"),
        (("optimise", "quarter-car", "S1", "--worst-case", "mass=3"), "unknown parameter 'mass'"),
        (("optimise", "lateral-gauging", "S1", "--worst-case", "Ksy=1e5"), "Ksy is free"),
        (("synthesise", "quarter-car", "--order", "13"), "--order"),
        (("synthesise", "quarter-car"), "--order"),
        (("compare", "quarter-car", "--plot", "x.gif"), "accepted are .png, .svg or .pdf"),
        (("compare", "quarter-car", "--plot", "/nowhere/x.png"), "/nowhere"),
        (("evaluate", "quarter-car", "c=1e3", "--three-ways", "--objective", "J1 + J3"), "J1 + J3 is none"),
        (("evaluate", "quarter-car", "c=1e3", "--sweep", "ms=1:2:3", "--sweep", "ms=1:2:3"), "swept twice"),
        (("search", "vertical-comfort", "--elements", "1", "--limit", "J1=1"), "'J1' cannot be limited"),
        (("optimise", "vertical-comfort", "S1"), "S1 contains the static spring"),
        (("optimise", "vertical-comfort", "S5", "--jobs", "0"), "--jobs 0"),
        (("realise", "default"), "no device by itself"),
        (("realise", "(s+1)/(s+2)", "--method", "magic"), "magic"),
        (("compare", "vertical-comfort", "--orders", "1,x"), "not a list of whole numbers"),
        (("bound", "lateral-gauging"), "no valid bound"),
        (("check-bound", "none.json"), "cannot read none.json"),
        (
            ("search", "vertical-comfort", "--elements", "2", "--at-most", "levers=1"),
            "unknown kind of element 'levers'",
        ),
        (("search", "vertical-comfort", "--elements", "2", "--plot", "/nowhere/x.png"), "/nowhere"),
        (("reproduce", "--figures", "/proc/nowhere/figures"), "cannot write figures"),
    ],
)
def test_bad_input_is_one_sentence_and_exit_code_2(posreal, words, says):
    code, out, err = posreal(*words)
    assert code == 2
    assert out == ""
    assert err.startswith("posreal: ")
    assert says in err
    assert err.count("\n") == 1
    assert "Traceback" not in err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("evaluate", "vertical-comfort", "(s^2+s+1)/(s^2+0.9*s+4)"), "not positive real"),
        (("evaluate", "lateral-comfort", "S1", "c=1"), "not stable"),
        (("realise", "-s"), "not positive real"),
    ],
)
def test_no_for_an_answer_is_exit_code_1(posreal, words, says):
    code, out, err = posreal(*words)
    assert (code, out) == (1, "")
    assert says in err
    assert err.count("\n") == 1


def test_json_has_no_infinities(posreal):
    code, out, _ = posreal("check", "s", "--json")
    assert code == 0
    json.loads(out, parse_constant=lambda text: pytest.fail(text))


def test_interruption_is_not_a_traceback(posreal, monkeypatch):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("posreal.specification.named.problems", interrupted)
    code, out, err = posreal("problems")
    assert (code, out) == (130, "")
    assert "Traceback" not in err


def test_synthesise_gives_a_device_and_its_network(posreal):
    code, out, err = posreal("synthesise", "vertical-comfort", "--order", "1", "--json")
    assert (code, err) == (0, "")
    document = json.loads(out)
    assert document["design"]["objective"]["value"] <= 1.9614
    assert document["network"]["residual"] < 1e-9
    assert document["design"]["device"]["rational"]["numerator"]
    assert math.isfinite(document["design"]["metrics"]["J1z_L"]["value"])


def test_a_search_over_operating_points_and_one_without_a_bound(posreal):
    code, out, _ = posreal("search", "vertical-comfort", "--elements", "1", "--worst-case", "Crz=40e3", "--starts", "2")
    assert code == 0
    assert "worst-case J1z_T" in out
    words = ("search", "quarter-car", "--elements", "1", "--objective", "J1 + 0.001*gain_acceleration", "--starts", "2")
    code, out, err = posreal(*words)
    assert (code, err) == (0, "")
    assert "No passive device is better" not in out
    code, _, err = posreal("bound", "quarter-car", "--objective", "J1 + 0.001*gain_acceleration")
    assert code == 2
    assert "times its weight is one on the sum" in err


@pytest.mark.parametrize(("problem", "ends"), [("quarter-car", "wheel"), ("vertical-comfort", "bogie")])
def test_a_strut_is_drawn_between_what_it_stands_between(posreal, problem, ends):
    layout = {"quarter-car": "S3", "vertical-comfort": "S5"}[problem]
    for words in (("optimise", problem, layout, "--starts", "1"), ("synthesise", problem, "--order", "0")):
        _, out, _ = posreal(*words)
        assert f"─ {ends}" in out
        assert ends == "bogie" or "bogie" not in out


def test_a_network_that_brings_the_static_spring_again_is_said(posreal):
    out = posreal("evaluate", "quarter-car", "k=60e3 | c=1500")[1]
    assert "own spring of 60 kN/m comes on top of what stands beside it, 60 kN/m" in out
    note = json.loads(posreal("evaluate", "vertical-comfort", "k=5e6 + c=1.8e4 + b=4110", "--json")[1])["notes"]
    assert len(note) == 1
    assert "behind it, 5 MN/m" in note[0]
    for device in (["c=1500"], ["k=25e3 | c=1500"], ["S3", "c=1500", "b=50"]):
        assert "on top of" not in posreal("evaluate", "quarter-car", *device)[1]
    assert json.loads(posreal("evaluate", "quarter-car", "c=1500", "--json")[1])["notes"] == []


def test_an_impedance_is_a_device(posreal):
    mobility = json.loads(posreal("evaluate", "quarter-car", "Z(s) = (s+2)/(1500s)", "--json")[1])
    assert mobility["metrics"] == json.loads(posreal("evaluate", "quarter-car", "1500*s/(s+2)", "--json")[1])["metrics"]


def test_a_network_goes_out_as_a_deck_and_comes_back(posreal, tmp_path):
    deck = str(tmp_path / "strut.cir")
    network = "k=1000 | c=20 + b=3"
    assert posreal("realise", network, "--write", deck)[0] == 0
    assert "1 spring, 1 damper, 1 inerter of 3 kg" in posreal("realise", deck)[1]
    assert json.loads(posreal("evaluate", "quarter-car", deck, "--json")[1])["device"]["network"] == network


def test_what_is_written_shows_the_strut_and_the_device_is_read_back(posreal, tmp_path):
    drawn, device = tmp_path / "strut.txt", tmp_path / "device.net"
    words = [
        "synthesise",
        "quarter-car",
        "--order",
        "1",
        "--starts",
        "2",
        "--write",
        str(drawn),
        "--write",
        str(device),
    ]
    code, out, _ = posreal(*words)
    assert code == 0
    assert "k_static" in drawn.read_text()
    assert drawn.read_text().split("\n")[0].strip() == next(line for line in out.split("\n") if "body" in line).strip()
    assert "k_static" not in device.read_text()
    assert posreal("evaluate", "quarter-car", str(device))[0] == 0


def test_every_parameter_of_a_vehicle_is_listed(posreal, tmp_path):
    out = posreal("vehicle", "vertical-comfort")[1]
    for word in ("Crz", "64110", "N s/m", "airspring orifice damping", "[Jiang2012, Table 4]", "J1z_T [%g]"):
        assert word in out
    mine = tmp_path / "mine.toml"
    mine.write_text('[side-view]\nmv = "42 t"\n')
    listed = json.loads(posreal("vehicle", "side-view", "--vehicle", str(mine), "--json")[1])
    assert listed["parameters"]["mv"] == {
        "value": 42e3,
        "unit": "kg",
        "default": 38e3,
        "meaning": "body mass",
        "source": "Jiang2012, Table 4",
    }
    assert "did you mean side-view" in posreal("vehicle", "sideview")[2]


def test_every_help_ends_with_examples_that_name_their_command(posreal):
    from posreal.cli import app
    from posreal.cli.examples import EXAMPLES

    names = {command.name or command.callback.__name__ for command in app.registered_commands}
    assert set(EXAMPLES) == names
    for command in names:
        out = posreal(command, "--help")[1]
        assert "Examples:" in out
        for line in EXAMPLES[command]:
            assert f"\n    {line}\n" in f"{out}\n"
        assert EXAMPLES[command][0].startswith(f"posreal {command}")


@pytest.mark.parametrize("command", ["problems", "layouts", "vehicle", "evaluate", "check", "realise"])
def test_the_examples_work(posreal, command, tmp_path, monkeypatch):
    from posreal.cli.examples import EXAMPLES

    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text('network = "k | c"\n' if command == "layouts" else "[quarter-car]\nms = 300\n")
    (tmp_path / "device.json").write_text('{"numerator": [1, 1, 1], "denominator": [4, 1, 1]}')
    for line in EXAMPLES[command]:
        code, out, _ = posreal(*shlex.split(line)[1:])
        assert (code, bool(out)) == (1 if command == "check" else 0, True), line


# --- what can be bought --------------------------------------------------------------------------------------


def test_ranges_are_printed_as_the_file_that_other_commands_take(posreal, tmp_path):
    code, out, err = posreal("ranges", "vertical-comfort")
    assert (code, err) == (0, "")
    path = tmp_path / "mine.toml"
    path.write_text(out.replace("5000 kg", "1 t"))
    words = ("optimise", "vertical-comfort", "S5", "--starts", "2", "--ranges", str(path), "--json")
    design = json.loads(posreal(*words)[1])["designs"][0]
    assert design["parameters"]["b"] == pytest.approx(1000.0)
    assert design["outside_usual"] == []
    assert "--any-values lifts that: 1.96127 %g" in " ".join(design["found"]["notes"])
    code, out, _ = posreal("optimise", "vertical-comfort", "S6", "--starts", "3", "--any-values")
    assert "Outside what can usually be bought (judgement): c1" in out
    assert posreal("ranges", "lateral-comfort", "--at", "primary", "--json")[1].count("500.0") == 2


def test_realise_says_what_cannot_be_bought(posreal, tmp_path):
    device = "b=3e4 + (c=2e4 | k=3e5)"
    code, out, _ = posreal("realise", device, "--for", "vertical-comfort")
    assert code == 0
    assert "Outside what can usually be bought (judgement): b = 30000 kg, above 5000 kg." in out
    found = json.loads(posreal("realise", device, "--json")[1])["network"]["outside_usual"]
    assert [one["name"] for one in found] == ["b"]
    mine = tmp_path / "mine.toml"
    mine.write_text('b = ["10 t", "40 t"]\nsource = "a ship"\n')
    assert "Outside" not in posreal("realise", device, "--ranges", str(mine))[1]


def test_ranges_that_cannot_be_used(posreal, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('b = ["5 t", "1 t"]\n')
    code, _, err = posreal("optimise", "vertical-comfort", "S5", "--ranges", str(path))
    assert code == 2
    assert "mine.toml: b: the least, '5 t', is not below the greatest, '1 t'" in err
    path.write_text('b = ["1 t", "5 t"]\n')
    code, _, err = posreal("search", "vertical-comfort", "--elements", "1", "--ranges", str(path), "--any-values")
    assert (code, "give one of the two" in err) == (2, True)


# --- real elements -------------------------------------------------------------------------------------------


def test_real_elements_stand_beside_ideal_ones(posreal, tmp_path):
    code, out, _ = posreal("evaluate", "vertical-comfort", "S4", "c=11049", "b=91.667", "--elements", "real")
    assert code == 0
    assert next(line for line in out.split("\n") if "J1z_T" in line).split()[:3] == ["J1z_T", "2.04425", "2.03215"]
    assert "real elements: damper with ends of 5 MN/m; inerter with 1 kN·s/m beside it" in out
    path = tmp_path / "soft.toml"
    path.write_text('[inerter]\nend_stiffness = "1 MN/m"\n')
    words = ("S4", "c=11049", "b=91.667", "--parts", str(path), "--json")
    document = json.loads(posreal("evaluate", "vertical-comfort", *words)[1])
    assert document["metrics"]["J1z_T"]["value"] == pytest.approx(2.584, abs=1e-3)
    assert document["ideal"]["metrics"]["J1z_T"]["value"] == pytest.approx(2.03215, abs=1e-5)
    assert document["elements"]["inerter"]["end_stiffness"] == 1e6
    found = json.loads(posreal("search", "quarter-car", "--elements", "1", "--parts", "real", "--json")[1])
    assert found["front"][0]["ideal"]["J1"]["value"] < found["front"][0]["objective"]


def test_a_synthesised_network_is_shown_of_real_elements_too(posreal):
    words = ("synthesise", "quarter-car", "--order", "1", "--starts", "2", "--parts", "real")
    code, out, _ = posreal(*words)
    assert code == 0
    row = next(line for line in out.split("\n") if line.strip().startswith("J1 ")).split()
    assert float(row[2]) == pytest.approx(1.58509, abs=1e-5)
    assert float(row[1]) > float(row[2])
    document = json.loads(posreal(*words, "--json")[1])
    assert document["real"]["metrics"]["J1"]["value"] == pytest.approx(float(row[1]), abs=1e-5)
    assert document["design"]["metrics"]["J1"]["value"] == pytest.approx(float(row[2]), abs=1e-5)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("evaluate", "quarter-car", "c=2000", "--parts", "ideal"), "give real, or a path ending in .toml"),
        (("evaluate", "quarter-car", "100*s/(s+1)", "--parts", "real"), "an admittance has no elements"),
        (("synthesise", "quarter-car", "--order", "0", "--parts", "real", "--no-realise"), "leave out --no-realise"),
        (("search", "lateral-comfort", "--elements", "1", "--parts", "real", "--robust"), "leave out --parts"),
    ],
)
def test_real_elements_that_cannot_be(posreal, words, says):
    code, _, err = posreal(*words)
    assert (code, says in err) == (2, True), err
