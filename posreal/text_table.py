"""Plain-text tables: columns aligned, numbers to the right, no wider than they need to be."""

from __future__ import annotations

from collections.abc import Sequence


def table(header: Sequence[str], rows: Sequence[Sequence[str]], align: str = "", *, indent: str = "  ") -> str:
    """Lines of a table.

    Parameters
    ----------
    header, rows : texts, all of one length
    align : str
        One letter a column, l or r; what is left out is r after a first l.
    """
    columns = len(header)
    align = align + "l"[len(align) :] + "r" * (columns - max(len(align), 1))
    everything = [header, *rows]
    widths = [max(len(row[i]) for row in everything) for i in range(columns)]

    def line(row: Sequence[str]) -> str:
        cells = [
            cell.ljust(width) if side == "l" else cell.rjust(width)
            for cell, width, side in zip(row, widths, align, strict=True)
        ]
        return (indent + "  ".join(cells)).rstrip()

    return "\n".join([line(header), line(["─" * width for width in widths]), *(line(row) for row in rows)])


def percent(value: float | None, digits: int = 2) -> str:
    """A signed percentage, or a dash."""
    return "–" if value is None else f"{round(value, digits) + 0.0:.{digits}f} %"  # + 0.0: no "−0.00"


def counted(count: int, noun: str) -> str:
    """``1 spring``, ``2 springs``."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
