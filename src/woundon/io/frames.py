"""Results as tables: pandas DataFrames, and CSV files for spreadsheets."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import __version__, kinds
from ..quantities import Quantity, header, outputs, scalar_outputs, value_of, walk
from ..results import Result
from .records import saved_values
from .spreadsheets import as_csv_cell, in_csv_style

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["to_csv", "to_frame"]


def to_frame(result: Result) -> pd.DataFrame:
    """Return the arrays of a result as columns, or its numbers as one row if it has no arrays.

    Arrays of another length than the first one are omitted.  SI units; the frame has the attributes
    ``units`` and ``long_names``, by column.

    >>> import woundon as wo
    >>> to_frame(wo.solve(wo.RollerProblem.example(), nodes=33)).attrs["units"]["pressure"]
    'Pa'

    """
    import pandas as pd

    known = {p.path: p.quantity for p in outputs(result) if p.quantity is not None}
    values = {name: value_of(result, name) for name in known}
    columns = _columns(values)
    frame = pd.DataFrame(columns) if columns else pd.DataFrame([values])
    frame.attrs = {
        "units": {name: known[name].unit for name in frame},
        "long_names": {name: known[name].meaning for name in frame},
    }
    return frame


def to_csv(result: Result) -> bytes:
    """Return scalars as comments, ``# name [unit],value``, followed by the arrays in columns.

    A list of numbers, such as the positions of a profile, has a cell for each of them.  Fields of
    the problem come first, then outputs and their error estimates.  Arrays of another length than
    the first one are omitted; ``pandas.read_csv(path, comment="#")`` reads the columns.
    """
    known = {place.path: place.quantity for place in outputs(result)}
    scalars: list[tuple[str, Quantity | None, Any]] = [
        (place.path, place.quantity, place.value)
        for place in walk(result.problem)
        if place.value is not None
    ]
    scalars += [
        (n, quantity, value_of(result, n)) for n, quantity in scalar_outputs(result).items()
    ]
    scalars += [
        (f"{name}_error", known.get(name), error)
        for name, error in result.errors.items()
        if f"{name}_error" not in known
    ]
    arrays = _columns(saved_values(result))
    columns = dict(_in_table(name, known.get(name), array) for name, array in arrays.items())
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([f"# woundon {__version__}", kinds.of(result).name])
    for scalar in scalars:
        label, value = _in_table(*scalar)
        table.writerow([f"# {label}", *map(as_csv_cell, _cells(value))])
    for note in result.warnings:
        table.writerow(["# warning", as_csv_cell(note)])
    table.writerow(columns)
    table.writerows(zip(*(array.tolist() for array in columns.values()), strict=True))
    return in_csv_style(text.getvalue()).encode("utf-8")


def _cells(value: Any) -> Sequence[Any]:
    """Return the items of a list of numbers, or another value as the only item."""
    if isinstance(value, tuple) and value and all(isinstance(item, float) for item in value):
        return value
    return (value,)


def _columns(values: Mapping[str, Any]) -> dict[str, np.ndarray]:
    """Return the arrays of a result that have the shape (n,), n being the length of the first."""
    arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray)}
    shape = next((array.shape[:1] for array in arrays.values()), None)  # (n,)
    return {name: array for name, array in arrays.items() if array.shape == shape}


def _in_table(name: str, quantity: Quantity | None, value: Any) -> tuple[str, Any]:
    """Return a header with its unit, and a number, an array or a tuple, SI, in this unit."""
    if quantity is None:
        return name, value
    if isinstance(value, tuple):
        unit, converted = quantity.in_table(np.array(value))
        return header(name, unit), tuple(converted.tolist())
    unit, converted = quantity.in_table(value)
    return header(name, unit), converted
