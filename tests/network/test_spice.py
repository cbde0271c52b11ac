import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings

from posreal.errors import BadDevice, BadInput
from posreal.network import parse
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
}


def run(deck, folder):
    file = folder / "deck.cir"
    file.write_text(deck, encoding="utf-8")
    done = subprocess.run(["ngspice", "-b", str(file)], capture_output=True, text=True, timeout=60, check=False)
    cells = [line.split() for line in done.stdout.splitlines()]
    table = np.array([[float(x) for x in row] for row in cells if len(row) == 4 and row[0].isdigit()])
    assert len(table), done.stdout + done.stderr
    return table[:, 1], table[:, 2] + 1j * table[:, 3]


@ngspice
@pytest.mark.parametrize("text", SAMPLE.values(), ids=SAMPLE.keys())
def test_ngspice_finds_the_admittance_over_six_decades(text, tmp_path):
    network = parse(text)
    frequency, y = run(spice(network, frequencies=(1e-3, 1e3), per_decade=7), tmp_path)
    assert len(frequency) >= 42
    assert frequency[-1] / frequency[0] == pytest.approx(1e6)
    assert np.max(np.abs(y / network(2j * np.pi * frequency) - 1)) < 1e-6


@ngspice
@settings(max_examples=12)
@given(networks(8, decades=3))
def test_ngspice_agrees_on_drawn_networks(network):
    """Over three decades: within them SPICE's own sums at the nodes keep their digits."""
    with TemporaryDirectory() as folder:
        frequency, y = run(spice(network, frequencies=(0.01, 10), per_decade=5), Path(folder))
    assert np.max(np.abs(y / network(2j * np.pi * frequency) - 1)) < 1e-6


def test_the_deck_reads_well():
    assert (
        spice(parse("k=2e5 | (c=2e4 + b=300)"), title="A strut")
        == """\
* A strut
* A mechanical network by the force-current analogy:
*   volt = m/s (velocity), ampere = N (force), so admittance I/V = F/v in N s/m
*   inductor L = 1/k (spring, N/m)   resistor R = 1/c (damper, N s/m)   capacitor C = b (inerter, kg)
* Node 1 is the first terminal, node 0 the second. One volt drives node 1: V(y) is Y(j omega).

Vport 1 0 DC 0 AC 1
Hport y 0 Vport -1
Lk 1 0 5e-06
Rc 1 2 5e-05
Cb 2 0 300.0
* Linear and driven by AC alone: no operating point is needed, and none need exist.
* Values spread over many decades: without strict pivoting, digits are lost.
.options noopac pivrel=0.9 pivtol=1e-30
.ac dec 20 0.001 1000.0
.print ac vr(y) vi(y)
.control
set numdgt=15
.endc
.end
"""
    )


def test_what_makes_no_deck():
    with pytest.raises(BadDevice, match="has no value yet"):
        spice(parse("k | c=1"))
    with pytest.raises(BadInput, match="no range of frequencies"):
        spice(parse("k=1"), frequencies=(10, 1))
    with pytest.raises(BadInput, match="not one line"):
        spice(parse("k=1"), title="a\n.control\nshell rm")
