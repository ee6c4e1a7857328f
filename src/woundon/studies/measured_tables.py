"""Read tables of measured data for a fit.

    nip_load [kN/m], web_tension [N/m], wound_on_tension [N/m], wound_on_tension +- [N/m]

The name of a column is that of an input or an output of the model; "+-" (or "±") denotes the
standard deviations of an output (:mod:`woundon.io.tables`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import InvalidProblem
from ..io.cells import Conversion, Fault, numbers, raise_faults
from ..io.sheets import read_sheet
from ..io.tables import Column, Names, is_known_header, match_columns
from ..quantities import Quantity
from .column_names import ANNOTATIONS

__all__ = ["MEASURED_AS", "Measured", "read_measured"]

Array = np.ndarray
Groups = dict[str, dict[str, Array]]  # "inputs", "outputs", "deviations" -> name -> values
# Measured quantity -> the output with which it is compared.  A counter measures the length of web
# with its layers as they are, compressed.
MEASURED_AS = {"length": "wound_length"}


@dataclass(frozen=True, eq=False)
class Measured:
    """Measured rows, in SI.

    Attributes
    ----------
    inputs : mapping of str to (rows,) array
        Settings of each row.
    outputs : mapping of str to (rows,) array
        Measured values; nan where there is none.
    deviations : mapping of str to (rows,) array
        Standard deviations of the outputs and inputs that have them.
    where : str
        Path of the file, for error messages.
    numbers : sequence of int
        Row numbers, as a spreadsheet shows them.
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
    conversion: Conversion = Conversion(),  # noqa: B008
) -> Measured:
    """Read measured data.

    Parameters
    ----------
    data, columns
        As ``measured`` and ``columns`` of :func:`woundon.fit`.
    inputs, outputs : mapping of str to Quantity
        Quantities that a column may contain; None for an input that is not a number.
    replaced : mapping of str to str, optional
        Names of outputs that do not exist, with a hint to existing ones.  A column with such a name
        is an error whose text contains the hint; it is not renamed.
    conversion : Conversion, optional
        Converts total forces, stresses and basis weights.

    Raises
    ------
    InvalidProblem
        Lists all invalid columns or cells.

    Examples
    --------
    >>> from woundon.quantities import length
    >>> outputs = {"nip_width": length("b", "nip width")}
    >>> read_measured({"nip_width [mm]": [4.0]}, {}, outputs).outputs["nip_width"]
    array([0.004])
    """
    replacements = replaced or {}
    known = {**inputs, **outputs, **conversion.helpers}
    names = Names({**dict.fromkeys((*ANNOTATIONS, *replacements)), **known})
    sheet = read_sheet(data, "measured", is_known_header(names, columns))
    matched = [c for c in match_columns(sheet, names, columns) if c.name not in ANNOTATIONS]
    for column in matched:
        if column.name in replacements and column.name not in inputs:
            text = f"{column.name}: no such output: {replacements[column.name]}"
            raise InvalidProblem.at(sheet.where, text)
    faults: list[Fault] = []
    values = numbers(
        sheet, matched, names, faults, gaps=lambda c: c.name in outputs, conversion=conversion
    )
    # helpers, such as a basis weight, serve the conversion of other columns only
    quantities = [
        (column, of_rows)
        for column, of_rows in zip(matched, values, strict=True)
        if column.name not in conversion.helpers
    ]
    groups = _grouped(quantities, outputs, sheet.where)
    raise_faults(faults)
    _check(groups, sheet.where)
    return Measured(**groups, where=sheet.where, numbers=sheet.numbers)


def _grouped(
    quantities: Sequence[tuple[Column, Array]], outputs: Mapping[str, Quantity], where: str
) -> Groups:
    """Return the columns as inputs, outputs and deviations of outputs, each by name.

    A quantity of ``MEASURED_AS`` has the name of the output with which it is compared, if the model
    has that output.

    Raises
    ------
    InvalidProblem
        If two columns are the same quantity.
    """
    groups: Groups = {"inputs": {}, "outputs": {}, "deviations": {}}
    for column, of_rows in quantities:
        role = "outputs" if column.name in outputs else "inputs"
        group = groups["deviations" if column.deviation else role]
        compared = MEASURED_AS.get(column.name, "")
        name = compared if compared in outputs else column.name
        if name in group:
            text = f"has columns {column.name} and {name}; must be one of them"
            raise InvalidProblem.at(where, text)
        group[name] = of_rows
    return groups


def _check(groups: Groups, where: str) -> None:
    """Reject measured data without outputs or with invalid standard deviations."""
    if not groups["outputs"]:
        text = "has no column that is an output of the model; write its name into the header, or "
        raise InvalidProblem.at(where, f"{text}assign a column: --column 'HEADER=NAME [UNIT]'")
    for name, deviation in groups["deviations"].items():
        values = groups["outputs"].get(name, groups["inputs"].get(name))
        if values is None:
            text = f"has standard deviations of {name}, but no column of its values"
            raise InvalidProblem.at(where, text)
        is_measured = np.isfinite(values)
        if not np.all(deviation[is_measured] > 0):
            text = f"the standard deviations of {name} must be > 0 wherever it was measured"
            raise InvalidProblem.at(where, text)
