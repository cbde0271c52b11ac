"""A simulation as text: each metric by frequency, linear and real in time; what the elements did."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from posreal.simulation.statistical import LOCKED
from posreal.text_table import percent, table
from posreal.units import engineering

if TYPE_CHECKING:
    from posreal.study.simulate_result import InMotion, InTime, Simulation


def text(of: Simulation) -> str:
    """Tables of metrics and elements."""
    lines = [
        f"{of.strut}",
        f"{of.records} records of {of.duration:g} s of random track (seed {of.seed}), steps of {1e3 * of.step:.3g} ms; "
        "every column but the first and the last on the same track:",
        "",
        table(
            ["metric", "exact, linear", "linear", "real", "change", "± (1σ)", "default", "gain kept", "statistical"],
            [_row(name, one) for name, one in of.metrics.items()],
            "lrrrrrrrr",
        ),
        "",
    ]
    if of.elements:
        header = ["element", "friction", "backlash", "stop", "stuck", "stroke", "r.m.s. velocity", "as a damper"]
        rows = [_element(name, one) for name, one in of.elements.items()]
        lines += [table(header, rows, "lrrrrrrr"), ""]
    lines.append(f"  Force of a strut: {of.force[0]:.4g} N r.m.s., {of.force[1]:.4g} N peak, on the random track.")
    lines.append("  Exact: by frequency. Statistical: friction as its equivalent damper, by frequency.")
    return "\n".join(lines)


def _row(name: str, one: InTime) -> list[str]:
    kept = one.kept
    return [
        f"{name} [{one.unit}]",
        f"{one.exact:#.5g}",
        f"{one.linear:#.4g}",
        f"{one.real:#.4g}",
        percent(100 * (one.real / one.linear - 1)) if one.linear else "–",
        "–" if one.error is None else f"{100 * one.error:.2f} %",
        "–" if one.default is None else f"{one.default:#.4g}",
        "–" if kept is None else f"{kept:.2f}",
        "–" if one.statistical is None else f"{one.statistical:#.5g}",
    ]


def _element(name: str, one: InMotion) -> list[str]:
    law = one.law
    return [
        name,
        f"{law.friction:g} N" if law.friction else "–",
        f"{1e3 * law.backlash:g} mm" if law.backlash else "–",
        "–" if math.isinf(law.stop) else f"±{1e3 * law.stop:g} mm",
        f"{100 * one.stuck:.0f} %" if law.friction else "–",
        f"±{1e3 * one.stroke:.3g} mm",
        f"{1e3 * one.velocity:.3g} mm/s",
        "–" if one.damper is None else "locked" if one.damper > 0.99 * LOCKED else engineering(one.damper, "N s/m"),
    ]
