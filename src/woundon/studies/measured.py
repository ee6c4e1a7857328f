"""Measured data from CSV or Excel, units in the header, to SI columns of known names.

    nip_load [kN/m], web_tension [N/m], wound_on_tension [N/m], wound_on_tension +- [N/m]

A column's name is that of an input or an output of the model; "+-" (or "±") holds an output's
standard deviations.  Semicolons between and commas within numbers are read too, lines that open
with # are left out.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from ..errors import InvalidProblem
from ..io.units import parse
from ..quantities import Quantity

__all__ = ["Measured", "need_openpyxl", "read_measured"]

Array = np.ndarray
_HEADER = re.compile(r"\s*([^\[\(]*?)\s*(?:[\[\(]\s*(.*?)\s*[\]\)])?\s*")
_DEVIATION = re.compile(r"(.*?)\s*(?:\+-|\N{PLUS-MINUS SIGN}|\+/-)")


@dataclass(frozen=True, eq=False)
class Measured:
    """Measured rows, in SI.

    Attributes
    ----------
    inputs : mapping of str to (rows,) array
        What was set.
    outputs : mapping of str to (rows,) array
        What was measured; nan where it was not.
    deviations : mapping of str to (rows,) array
        Standard deviations of the outputs that have them.
    """

    inputs: Mapping[str, Array]
    outputs: Mapping[str, Array]
    deviations: Mapping[str, Array]


def read_measured(
    data: Any,
    outputs: Mapping[str, Quantity],
    quantity: Callable[[str], Quantity | None],
    columns: Mapping[str, str | None] | None = None,
) -> Measured:
    """Return measured data.

    Parameters
    ----------
    data : path, mapping or pandas.DataFrame
        ``.csv`` or ``.xlsx`` file; or columns by name, in SI unless the name ends in a [unit].
    outputs : mapping of str to Quantity
        The outputs that a column may hold; every other column is an input.
    quantity : callable
        Name of an input -> what it is, None if it is not a number; raises InvalidProblem if there
        is no such input.
    columns : mapping, optional
        Name in the data -> name of the model, None for a column to leave out.

    Raises
    ------
    InvalidProblem
        Naming the file's column or row at fault.
    """
    if hasattr(data, "items"):
        where, table = "measured", {str(name): list(values) for name, values in data.items()}
    else:
        where, table = str(data), _read(Path(data))
    found: dict[str, dict[str, Array]] = {"inputs": {}, "outputs": {}, "deviations": {}}
    renames = dict(columns or {})
    for header, cells in table.items():
        match = _HEADER.fullmatch(header)
        name, unit = match.groups() if match else (header, None)
        target = renames.pop(name, name)
        if target is None:
            continue
        kind, target, of = _role(target, outputs, quantity, where)
        if target in found[kind]:
            raise InvalidProblem([(where, f"two columns are {target}")])
        gap = kind != "inputs"
        found[kind][target] = _si(cells, unit, of, f"{where}: {name}", gap)
    _check(found, renames, where)
    return Measured(**found)


def _role(
    name: str, outputs: Mapping[str, Quantity], quantity: Callable[[str], Quantity | None],
    where: str,
) -> tuple[str, str, Quantity | None]:  # fmt: skip
    """Tell what a column is: kind, name in the model, quantity."""
    match = _DEVIATION.fullmatch(name)
    plain = match.group(1) if match else name
    if plain in outputs:
        return "deviations" if match else "outputs", plain, outputs[plain]
    try:
        return "inputs", plain, quantity(plain)
    except InvalidProblem as fault:
        raise InvalidProblem.at(f"{where}: {plain}", fault.faults[0][1]) from None


def _check(found: dict[str, dict[str, Array]], renames: dict[str, Any], where: str) -> None:
    for name in renames:
        raise InvalidProblem([(where, f"has no column {name!r}")])
    if not found["outputs"]:
        raise InvalidProblem([(where, "has no column that is an output of the model")])
    sizes = {len(column) for kind in found.values() for column in kind.values()}
    if len(sizes) > 1:
        raise InvalidProblem([(where, f"columns differ in length: {sorted(sizes)}")])
    for name, deviation in found["deviations"].items():
        known = np.isfinite(found["outputs"].get(name, deviation))
        if name not in found["outputs"] or not np.all(deviation[known] > 0):
            text = f"the standard deviations of {name} must be > 0 wherever it was measured"
            raise InvalidProblem([(where, text)])


def _si(cells: list[Any], unit: str | None, of: Quantity | None, where: str, gap: bool) -> Array:
    """Return a column in SI; an empty cell, or nan, is nan where a ``gap`` is allowed."""
    if of is None:
        raise InvalidProblem([(where, "is not a number, so it cannot be a column")])
    factor = parse(f"1 {unit}", of.unit, where) if unit and unit != "1" else 1.0
    values = np.full(len(cells), np.nan)
    for row, cell in enumerate(cells):
        text = cell.strip().replace(",", ".") if isinstance(cell, str) else cell
        if gap and (text in (None, "") or (isinstance(text, float) and text != text)):
            continue
        try:
            values[row] = factor * float(text)
        except (TypeError, ValueError):
            raise InvalidProblem([(where, f"row {row + 1}: {cell!r} is not a number")]) from None
        if not np.isfinite(values[row]):
            raise InvalidProblem([(where, f"row {row + 1}: {cell!r} is not a finite number")])
    return values


def _read(path: Path) -> dict[str, list[Any]]:
    """Return a file's columns by header; an empty cell is ''."""
    try:
        header, *rows = _excel_rows(path) if path.suffix == ".xlsx" else _csv_rows(path)
    except OSError as fault:
        raise InvalidProblem([(str(path), f"cannot be read: {fault.strerror}")]) from None
    if not rows:
        raise InvalidProblem([(str(path), "holds no header with rows below it")])
    for number, row in enumerate(rows, 1):
        if len(row) != len(header):
            text = f"row {number} has {len(row)} cells, the header {len(header)}"
            raise InvalidProblem([(str(path), text)])
    names = [str(cell).strip() for cell in header]
    if len(set(names)) < len(names):
        raise InvalidProblem([(str(path), "two columns have the same header")])
    return {name: list(cells) for name, *cells in zip(names, *rows, strict=True) if name}


def _csv_rows(path: Path) -> list[list[Any]]:
    """Return a file's lines as cells.

    By the standard library: pandas.read_csv would fill short rows up, and take the first column
    for an index where a row is longer than the header.
    """
    try:
        text = path.read_text("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise InvalidProblem([(str(path), f"is not UTF-8 text, from byte {fault.start}")]) from None
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    between = next((sign for sign in ";\t" if sign in "".join(lines[:1])), ",")
    return list(csv.reader(lines, delimiter=between, skipinitialspace=True)) or [[]]


def _excel_rows(path: Path) -> list[list[Any]]:
    """Return the rows of the first sheet that are not empty."""
    import pandas

    need_openpyxl()
    try:
        table = pandas.read_excel(
            path, header=None, dtype=object, keep_default_na=False, engine="openpyxl"
        )
    except (KeyError, ValueError, EOFError, BadZipFile) as fault:
        raise InvalidProblem([(str(path), f"is not an Excel file: {fault}")]) from None
    # nan is a formula that ended in an error
    table = table.where(table.notna(), "#N/A")
    return table[(table != "").any(axis=1)].to_numpy().tolist() or [[]]


def need_openpyxl() -> None:
    """Say how to install what pandas reads and writes Excel with, where it is missing."""
    if find_spec("openpyxl") is None:
        text = "Excel files need openpyxl: pip install 'woundon[excel]'"
        raise InvalidProblem([("xlsx", text)])
