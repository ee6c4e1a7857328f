"""Columns of a CSV file in place of lists in a case file: ``csv = "test.csv"`` in a table.

    pressure [kPa], strain [%]
    10,             0.9
    25,             1.6

The names are those of the fields of the table; the file is read like any table (:mod:`.sheets`).
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InvalidProblem
from .sheets import read_sheet
from .tables import decimal_sign

__all__ = ["with_columns"]

MAX_ROWS = 100_000
_HEADER = re.compile(r"\s*([^\[]*?)\s*(?:\[\s*([^\]]*?)\s*\])?\s*")


def with_columns(part: Any, folder: Path) -> Any:
    """Return the tables of a case with the columns of the CSV files that they name.

    Parameters
    ----------
    part : mapping, list or value
    folder : path
        Folder of files with a relative path.

    Raises
    ------
    InvalidProblem
        If a file cannot be read, is not a table, or has a column that the case contains too.
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
        raise InvalidProblem.at(str(path), f"has a column {name!r}, which the case contains too")
    return table | columns


def _columns(path: Path) -> dict[str, list[str | float]]:
    """Return the cells of each column by name, as texts with units or numbers in SI."""
    sheet = read_sheet(path, "csv")
    if len(sheet.numbers) > MAX_ROWS:
        raise InvalidProblem.at(str(path), f"has too many rows; must be at most {MAX_ROWS}")
    sign = decimal_sign(sheet)
    columns: dict[str, list[str | float]] = {}
    for header, cells in sheet.columns.items():
        match = _HEADER.fullmatch(header)
        name, unit = match.groups() if match else (header, None)
        if name in columns:
            raise InvalidProblem.at(str(path), f"two columns are {name!r}")
        columns[name] = [_value(cell, unit or sheet.units.get(header), sign) for cell in cells]
    return columns


def _value(cell: Any, unit: str | None, sign: str) -> str | float:
    """Return a cell as in a case file: a text with its unit, or a number in SI."""
    number = str(cell).strip().replace(sign, ".")
    if unit and unit != "1":
        return f"{number} {unit}"
    try:
        return float(number)
    except ValueError:
        return str(cell)
