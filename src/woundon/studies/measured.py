"""Tables that people make in spreadsheets: measured data of a fit, the cases of a sweep.

    nip_load [kN/m], web_tension [N/m], wound_on_tension [N/m], wound_on_tension +- [N/m]

A column's name is that of an input or an output of the model, however it is written; "+-" (or "±")
holds an output's standard deviations (:mod:`woundon.io.tables`).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InvalidProblem
from ..io.case_files import check_like_a_case
from ..io.sheets import Sheet, read_sheet
from ..io.tables import (
    MAX_COUNTED,
    Column,
    Names,
    decimal_sign,
    match_columns,
    numbers,
    raise_faults,
)
from ..quantities import Quantity

__all__ = ["BESIDE", "Measured", "read_cases", "read_measured"]

Array = np.ndarray
BESIDE = ("case", "failure", "warnings")  # what tables of studies hold beside inputs and outputs


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
    where : str
        The file, for error texts.
    numbers : sequence of int
        Of the rows, as a spreadsheet shows them.
    """

    inputs: Mapping[str, Array]
    outputs: Mapping[str, Array]
    deviations: Mapping[str, Array]
    where: str = "measured"
    numbers: Sequence[int] = ()


def read_measured(
    data: Any,
    inputs: Mapping[str, Quantity | None],
    outputs: Mapping[str, Quantity],
    columns: Mapping[str, str | None] | None = None,
    replaced: Mapping[str, str] | None = None,
) -> Measured:
    """Return measured data.

    Parameters
    ----------
    data : path, mapping or pandas.DataFrame
        ``.csv`` or ``.xlsx`` file; or columns by name, in SI unless the name has a unit.
    inputs, outputs : mapping of str to Quantity
        What a column may hold; an input that is no number is None.
    columns : mapping, optional
        Header in the data -> name of the model, maybe with its unit; None for one to leave out.
    replaced : mapping of str to str, optional
        Names that people may look for in vain, with what there is instead.

    Raises
    ------
    InvalidProblem
        Naming all the file's columns, or rows, at fault.
    """
    sheet = read_sheet(data, "measured")
    instead = replaced or {}
    names = Names({**dict.fromkeys((*BESIDE, *instead)), **inputs, **outputs})
    matched = [c for c in match_columns(sheet, names, columns) if c.name not in BESIDE]
    found: dict[str, dict[str, Array]] = {"inputs": {}, "outputs": {}, "deviations": {}}
    faults: list[tuple[str, str]] = []
    sign = decimal_sign(sheet)
    for column in matched:
        if column.name in instead:
            text = f"{column.name}: no such output: {instead[column.name]}"
            raise InvalidProblem.at(sheet.where, text)
        output = column.name in outputs
        kind = "deviations" if column.deviation else "outputs" if output else "inputs"
        quantity = names.quantity(column.name)
        values = numbers(sheet, column, quantity, faults, gaps=output, sign=sign)
        found[kind][column.name] = values
    raise_faults(faults)
    _check(found, sheet.where)
    return Measured(**found, where=sheet.where, numbers=sheet.numbers)


def _check(found: dict[str, dict[str, Array]], where: str) -> None:
    if not found["outputs"]:
        raise InvalidProblem.at(where, "has no column that is an output of the model")
    for name, deviation in found["deviations"].items():
        known = np.isfinite(found["outputs"].get(name, deviation))
        if name not in found["outputs"] or not np.all(deviation[known] > 0):
            text = f"the standard deviations of {name} must be > 0 wherever it was measured"
            raise InvalidProblem.at(where, text)


def read_cases(
    data: Any,
    inputs: Mapping[str, Quantity | None],
    outputs: Mapping[str, Quantity],
    made: Callable[[str, Any], Any],
    columns: Mapping[str, str | None] | None = None,
) -> dict[str, list[Any]]:
    """Return the cases of a sweep: a value of each input a row, in SI.

    Parameters
    ----------
    data, inputs, outputs, columns
        As of :func:`read_measured`; outputs, and what else a study's table holds, are left out.
    made : callable
        (name, table) -> body or material, of a cell that holds one as JSON.
    """
    sheet = read_sheet(data, "over")
    names = Names({**dict.fromkeys(BESIDE), **outputs, **inputs})
    faults: list[tuple[str, str]] = []
    over: dict[str, list[Any]] = {}
    sign = decimal_sign(sheet)
    matched = match_columns(sheet, names, columns)
    # what is both, the creepage of rollers, was found where a study wrote the table, else given
    written = any(column.name in BESIDE for column in matched)
    for column in matched:
        quantity = names.quantity(column.name)
        if column.name in outputs and (written or column.name not in inputs):
            continue
        if column.deviation or column.name in BESIDE:
            continue
        if quantity is not None:
            values = numbers(sheet, column, quantity, faults, gaps=False, sign=sign)
            over[column.name] = values.tolist()
        else:
            over[column.name] = _things(sheet, column, made, faults)
    raise_faults(faults)
    if not over:
        raise InvalidProblem.at(sheet.where, "has no column that is an input of the model")
    return over


def _things(
    sheet: Sheet, column: Column, made: Callable[[str, Any], Any], faults: list[tuple[str, str]]
) -> list[Any]:
    """Return what is no number: words, names of materials, bodies as JSON."""
    things: list[Any] = []
    for number, cell in zip(sheet.numbers, column.cells, strict=True):
        thing = cell.strip() if isinstance(cell, str) else cell
        if len(faults) >= MAX_COUNTED:
            break
        try:
            if thing in ("", None):
                raise InvalidProblem("the cell is empty")
            if isinstance(thing, str) and thing.startswith("{"):
                table = json.loads(thing)
                check_like_a_case(table, "a table of fields")
                thing = made(column.name, table)
        except (InvalidProblem, ValueError, RecursionError) as fault:
            told = str(fault).replace("\n", "; ")
            faults.append((sheet.where, f"row {number}, column {column.header!r}: {told}"))
        things.append(thing)
    return things
