"""Tables: as plain text, with columns aligned and no wider than they need to be; as HTML; as a pandas frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

from posreal.errors import BadInput


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


def html(header: Sequence[str], rows: Sequence[Sequence[str]], caption: str = "") -> str:
    """The same as an HTML table, for notebooks."""
    head = "".join(f"<th>{escape(cell)}</th>" for cell in header)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    title = f"<caption>{escape(caption)}</caption>" if caption else ""
    return f"<table>{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def frame(records: Sequence[Mapping[str, Any]], index: str) -> Any:
    """A ``pandas.DataFrame`` of records, a row each.

    Parameters
    ----------
    records : sequence of mapping of column to value
    index : str
        The column that names the rows.

    Raises
    ------
    BadInput
        If pandas is not installed; nothing else needs it.
    """
    try:
        from pandas import DataFrame
    except ImportError:
        raise BadInput(
            "to_frame() makes a pandas.DataFrame, and pandas is not installed here; pip install 'posreal[pandas]' "
            "brings it, and to_dict() needs nothing"
        ) from None
    return DataFrame(list(records)).set_index(index)
