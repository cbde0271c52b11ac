"""Functions of two element kinds into Foster's and Cauer's forms: here, with its proof, and by lcapy in one run.

lcapy is no dependency: ``pip install lcapy`` beside posreal. Its network must have the device's admittance before it
is timed. The last two lines time what has no counterpart there.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np

from benchmarks.timing import medians, report, seconds
from posreal import Rational, check, realise
from posreal.admittance import random_port_hamiltonian

FORMS = {"foster-1": "fosterI", "foster-2": "fosterII", "cauer-1": "cauerI", "cauer-2": "cauerII"}
LOSSLESS = Rational.parse("(s^2 + 1)*(s^2 + 9)*(s^2 + 25)/(s*(s^2 + 4)*(s^2 + 16))")
DAMPED = Rational.parse("(s + 1)*(s + 3)*(s + 5)/((s + 2)*(s + 4)*(s + 6))")


PROBE = Fraction(7, 3)  # a point at which lcapy's network must have the device's admittance


def main() -> None:
    """Two kinds of element by four forms; then the verdict and Bott–Duffin at degree six."""
    installed = find_spec("lcapy") is not None
    if not installed:
        print("  lcapy is NOT installed, so these are posreal's times alone; 'pip install lcapy' to compare")
    for title, y in (("lossless, degree 6", LOSSLESS), ("springs and dampers, degree 3", DAMPED)):
        for ours, theirs in FORMS.items():
            calls: dict[str, Callable[[], object]] = {f"posreal {ours}, proven; {title}": partial(realise, y, ours)}
            if installed and (complaint := fault(y, theirs)):
                print(f"  lcapy {theirs}: {complaint}")
            elif installed:
                calls[f"lcapy {theirs}, unproven"] = partial(lcapy_network, y, theirs)
            report(medians(calls, rounds=3), next(iter(calls)))
    six = random_port_hamiltonian(6, np.random.default_rng(0)).rational()
    slow = {"verdict, degree 6": lambda: check(six), "bott-duffin, degree 6": lambda: realise(six, "bott-duffin")}
    for name, call in slow.items():
        print(f"  {name:<52} {1e3 * seconds(call):10.2f} ms")


def lcapy_network(y: Rational, form: str) -> Any:
    """What lcapy makes of the same text."""
    import lcapy

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return lcapy.admittance(str(y).replace("^", "**")).network(form)


def fault(y: Rational, form: str) -> str | None:
    """Why lcapy's network is no match, or None: it must be there and have the device's admittance."""
    import lcapy

    try:
        found = lcapy_network(y, form).Y(lcapy.s).sympy.subs(lcapy.s.sympy, PROBE)
    except (ValueError, AttributeError, NotImplementedError, TypeError, RuntimeError) as error:
        return f"no network ({error})"
    wanted = y.exact_value(PROBE)
    return (
        None if abs(float(found) / float(wanted) - 1) < 1e-9 else f"another device ({float(found / wanted):.4g} of it)"
    )


if __name__ == "__main__":
    main()
