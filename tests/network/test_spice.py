import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from flint import acb, arb, ctx
from hypothesis import given, settings
from hypothesis import strategies as st

from posreal.errors import BadDevice, BadInput
from posreal.network import nodal_value, parse
from posreal.network.spice import spice
from tests.strategies import networks

ngspice = pytest.mark.skipif(
    shutil.which("ngspice") is None,
    reason="ngspice is not on PATH, so no deck was run; 'apt-get install ngspice' brings it",
)

SAMPLE = {
    "three elements": "k=2.45e5 | (c=2.1e4 + b=1.53e4)",
    "series capacitors, no path for direct current": "b=300 + (b=20 | (k=1e5 + c=3e3))",
    "a loop of springs": "k=1e5 | (k=3e4 + c=10) | (k=2 + c=1)",
    "ten decades of values": "k=1e7 | (c=1e3 + b=0.01) | (k=1e-2 + c=1e-3)",
    "a bridge": "{1-2: k=2e5, 1-3: c=3e3, 2-3: b=100, 2-0: c=4e3, 3-0: k=7e4}",
    "a lever": "{1-2: k=1, 2-0: b=1, 3-0: c=4, 1-2-3: n=1/2}",
    "a lever about its middle": "c=0.1 | {1-2: c=1, 2-0: k=3 | c=2, 3-0: b=4 + c=1, 1-2-3: n=-3.5} + b=2",
    "two levers": "{1-2: b=2, 2-0: k=3, 3-0: {1-2: b=2, 2-0: k=3, 3-0: c=7, 1-2-3: n=0.5}, 1-2-3: n=0.7}",
    "names that SPICE cannot tell apart": "kA=3 | (ka=5 + c=1)",
    "Bott–Duffin": "(c=4 | (k=6 + b=3) | b=2) + ((c=1 + (k=4/3 | b=2/3)) | k=2)",
    # These lose all digits, or all but a few, where admittances are added up at the nodes.
    "weak dampers behind heavy inerters": "b=20100 + b=28 + (c=0.00378 | b=0.000221) + c=0.001",
    "springs and inerters, weak and strong": "((k=105 | b=217) + (k=0.03 | b=0.08) + b=22700 | k=105) + k=0.01",
    "nested": "b=230 + (c=223 | (k=5e-5 + c=0.06) | c=7300) + b=31500 + k=7e-4 + (c=1e-4 | b=1e-3) + k=1e-5",
    "a lever over ten decades": "(b=144 + k=0.004 | c=5e-5) + {1-2: k=0.066, 2-0: b=9e-5, 3-0: k=3e-5, 1-2-3: n=-7}",
    "levers over ten decades": "{1-2: k=3e-5, 2-0: b=2e4, 3-0: c=2e4, 1-2-3: n=-3} + {1-2: k=3e-5, 2-0: c=2e4, "
    "3-0: k=3e-5, 1-2-3: n=-3}",
    "a bridge over ten decades": "{1-2: b=4e4, 1-3: c=7e-4, 2-3: c=774, 2-0: c=4, 3-0: c=2e-3 | k=1e-3 + c=1} + c=0.07",
}


def run(deck, folder):
    file = folder / "deck.cir"
    file.write_text(deck, encoding="utf-8")
    done = subprocess.run(["ngspice", "-b", str(file)], capture_output=True, text=True, timeout=60, check=True)
    cells = [line.split() for line in done.stdout.splitlines()]
    table = np.array([[float(x) for x in row] for row in cells if len(row) == 4 and row[0].isdigit()])
    assert len(table), done.stdout + done.stderr
    return table[:, 1], table[:, 2] + 1j * table[:, 3]


def error(network, frequency, y):
    """The largest relative difference from nodal analysis in balls of 300 bits."""
    worst = 0.0
    with ctx.workprec(300):
        for f, found in zip(frequency, y, strict=True):
            wanted = nodal_value(network, acb(0, 2 * arb.pi() * arb(float(f))), 80)
            worst = max(worst, float(abs(acb(complex(found)) / wanted - 1)))
    return worst


@ngspice
@pytest.mark.parametrize("text", SAMPLE.values(), ids=SAMPLE.keys())
def test_ngspice_finds_the_admittance_over_six_decades(text, tmp_path):
    network = parse(text)
    frequency, y = run(spice(network, frequencies=(1e-3, 1e3), per_decade=7), tmp_path)
    assert len(frequency) >= 42
    assert np.all(np.diff(frequency) >= 0)
    assert frequency[-1] / frequency[0] == pytest.approx(1e6)
    assert error(network, frequency, y) < 1e-6


@ngspice
@pytest.mark.parametrize("decades", [3, 10])
@settings(deadline=None, max_examples=25)
@given(st.data())
def test_ngspice_agrees_on_drawn_networks_over_six_decades(decades, data):
    network = data.draw(networks(8, decades=decades))
    with TemporaryDirectory() as folder:
        frequency, y = run(spice(network, per_decade=5), Path(folder))
    assert error(network, frequency, y) < 1e-6


@ngspice
def test_a_narrow_range_has_both_its_ends(tmp_path):
    """ngspice never returns from a range that is shorter than its step."""
    network = parse("k=2e5 | (c=2e4 + b=300)")
    frequency, y = run(spice(network, frequencies=(999.0, 1000.0), per_decade=5), tmp_path)
    assert (frequency[0], frequency[-1]) == pytest.approx((999, 1000))
    assert error(network, frequency, y) < 1e-6


def test_the_deck_reads_well():
    assert (
        spice(parse("k=2e5 | (c=2e4 + b=300)"), title="A strut", frequencies=(0.01, 1))
        == """\
* A strut
* A mechanical network by the force-current analogy:
*   volt = m/s (velocity), ampere = N (force), so admittance I/V = F/v in N s/m
*   inductor L = 1/k (spring, N/m)   resistor R = 1/c (damper, N s/m)   capacitor C = b (inerter, kg)
* Node 1 is the first terminal, node 0 the second. One volt drives node 1: V(y) is Y(j omega).
* As posreal writes it: k=200000 | c=20000 + b=300

Vport 1 0 DC 0 AC 1
Hport y 0 Vport -1
Lk 1 0 5e-06
Rc 1 2 5e-05
Cb 2 0 300.0
* Linear and driven by AC alone: no operating point is needed, and none need exist.
* An analysis for each decade: pivots are chosen anew in each, and strictly, or digits are lost.
.options noopac pivrel=0.9 pivtol=1e-30
.control
set numdgt=15
ac dec 20 0.01 0.1
print vr(y) vi(y)
ac dec 20 0.1 1.0
print vr(y) vi(y)
quit 0
.endc
.end
"""
    )


def test_parts_in_series_stand_apart_where_digits_would_be_lost():
    deck = spice(parse("b1=1e5 + (k=1e-4 | c1=1e-5) + c2=1e-4"), frequencies=(1.0, 10.0), per_decade=5)
    assert (
        "\n".join(deck.splitlines()[6:20])
        == """\
* The values spread too far to be added up at nodes in doubles. So parts in series stand apart:
*   V(m1), V(m2) ... are the forces through them, 1 V = 1 N; an element there is a mobility to ground,
*   R = c, C = 1/k or L = b, and a pair of sources G ties the force to the velocity across the parts.

Vport 1 0 DC 0 AC 1
Hport y 0 Vport -1
Gm11 1 0 m1 0 1
Gm11v m1 0 1 0 -1
Lb1 m1 0 100000.0
Gm1m2 m2 0 m1 0 -1
Gm1m2v m1 0 m2 0 1
Lk m2 0 10000.0
Rc1 m2 0 100000.0
Rc2 m1 0 0.0001"""
    )


def test_what_makes_no_deck():
    with pytest.raises(BadDevice, match="has no value yet"):
        spice(parse("k | c=1"))
    with pytest.raises(BadInput, match="no range of frequencies"):
        spice(parse("k=1"), frequencies=(10, 1))
    with pytest.raises(BadInput, match="not one line"):
        spice(parse("k=1"), title="a\n.control\nshell rm")
