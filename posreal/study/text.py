"""Plain-text tables: columns aligned, numbers to the right, no wider than they need to be."""

from __future__ import annotations

from collections.abc import Sequence


def table(header: Sequence[str], rows: Sequence[Sequence[str]], *, left: int = 1, indent: str = "  ") -> str:
    """Lines of a table whose first `left` columns are text and whose others are numbers."""
    everything = [header, *rows]
    widths = [max(len(row[i]) for row in everything) for i in range(len(header))]
    rule = ["─" * width for width in widths]

    def line(row: Sequence[str]) -> str:
        cells = [
            cell.ljust(width) if i < left else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        return (indent + "  ".join(cells)).rstrip()

    return "\n".join([line(header), line(rule), *(line(row) for row in rows)])


def percent(value: float | None, digits: int = 2) -> str:
    """A signed percentage, or a dash."""
    return "–" if value is None else f"{round(value, digits) + 0.0:.{digits}f} %"  # + 0.0: no "−0.00"
