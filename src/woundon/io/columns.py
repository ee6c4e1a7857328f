"""Columns of a CSV file in the place of a case's lists: ``csv = "test.csv"`` in a table.

    pressure [kPa], strain [%]
    10,             0.9
    25,             1.6

The names are those of the table's fields; semicolons between and commas within numbers are read
too, empty lines and lines that open with # are left out.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InvalidProblem
from .files import read_whole
from .sheets import check_cells, check_header, check_lines, split_rows

__all__ = ["with_columns"]

LARGEST = 10_000_000  # bytes
MOST_ROWS = 100_000
_HEADER = re.compile(r"\s*([^\[]*?)\s*(?:\[\s*([^\]]*?)\s*\])?\s*")


def with_columns(part: Any, folder: Path) -> Any:
    """Return a case's tables with the columns of the CSV files that they name put in.

    Parameters
    ----------
    part : mapping, list or value
    folder : path
        Where the files are, if not named by a whole path.

    Raises
    ------
    InvalidProblem
        If a file cannot be read, is no table, or has a column that is given already.
    """
    if isinstance(part, list):
        return [with_columns(item, folder) for item in part]
    if not isinstance(part, Mapping):
        return part
    table = {name: with_columns(value, folder) for name, value in part.items() if name != "csv"}
    if not isinstance(part.get("csv"), str):
        return table | ({"csv": part["csv"]} if "csv" in part else {})
    path = folder / part["csv"]
    columns = _columns(path)
    for name in columns.keys() & table.keys():
        raise InvalidProblem.at(str(path), f"has a column {name!r}, which the case gives too")
    return table | columns


def _columns(path: Path) -> dict[str, list[str | float]]:
    try:
        text = read_whole(path, LARGEST).decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        why = f"is no UTF-8 text, from byte {fault.start}; save it as UTF-8"
        raise InvalidProblem.at(str(path), why) from None
    if max(map(text.count, "\r\n")) > MOST_ROWS:
        raise InvalidProblem.at(str(path), f"has too many rows; must be at most {MOST_ROWS}")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    between = next((sign for sign in ";\t" if sign in "".join(lines[:1])), ",")
    check_lines(lines, str(path))
    header, *rows = split_rows(lines, between, str(path)) if lines else ([],)
    for column, title in enumerate(header, 1):
        check_header(title, column, str(path), 1)
    if not rows:
        raise InvalidProblem.at(str(path), "holds no header with rows below it")
    for number, row in enumerate(rows, 1):
        check_cells(row, number, str(path))
        if len(row) != len(header):
            text = f"row {number} has {len(row)} cells, the header {len(header)}"
            raise InvalidProblem.at(str(path), text)
    found: dict[str, list[str | float]] = {}
    for title, *cells in zip(header, *rows, strict=True):
        match = _HEADER.fullmatch(title)
        name, unit = match.groups() if match else (title.strip(), None)
        if name in found:
            raise InvalidProblem.at(str(path), f"two columns are {name!r}")
        found[name] = [_value(cell, unit) for cell in cells]
    return found


def _value(cell: str, unit: str | None) -> str | float:
    """Return a cell as a case file has it: a text with its unit, or a number in SI."""
    number = cell.strip().replace(",", ".")
    if unit and unit != "1":
        return f"{number} {unit}"
    try:
        return float(number)
    except ValueError:
        return cell
