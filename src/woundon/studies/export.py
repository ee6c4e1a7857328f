"""Export the table of a study: netCDF, CSV and Excel with units in the header, Parquet."""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InvalidProblem
from ..io.files import replaced_file
from ..io.sheets import need_openpyxl
from ..io.spreadsheets import record_table, write_csv, write_workbook
from .table import Table

__all__ = ["check_export", "export"]

EXCEL_ROWS = 1_048_576


def export(table: Table, path: str | Path) -> None:
    """Write a table to ``.nc``, ``.csv``, ``.xlsx`` or ``.parquet``.

    Raises
    ------
    InvalidProblem
        For another ending, more rows than an Excel sheet has, or a package that is not installed.
    OSError
        If the file cannot be written.
    """
    path = Path(path)
    write = check_export(path)
    if path.suffix == ".xlsx" and table.design.size + 1 > EXCEL_ROWS:
        text = f"{table.design.size} cases are more than an Excel sheet's rows"
        raise InvalidProblem.at(str(path), text)
    with replaced_file(path) as temporary:
        write(table, temporary)


def check_export(path: str | Path) -> Callable[[Table, Path], None]:
    """Return the function that writes the format of the suffix of a path; reject others."""
    ending = Path(path).suffix
    if ending not in _WRITERS:
        text = f"the ending {ending!r} is not a known format; must be {', '.join(_WRITERS)}"
        raise InvalidProblem.at(str(path), text)
    if ending == ".xlsx":
        need_openpyxl()
    if ending == ".parquet" and find_spec("pyarrow") is None:
        raise InvalidProblem.at(str(path), "needs pyarrow: pip install 'woundon[parquet]'")
    return _WRITERS[ending]


def _columns(table: Table) -> dict[str, Any]:
    """Return the columns with units in the header.

    Bodies are written as JSON, so that the file can be used as the cases of another study.
    """
    objects = {column.name: column for column in table.design.columns if not column.numeric}
    columns: dict[str, Any] = {}
    for name, values in table.columns().items():
        unit, converted = (
            table.quantities[name].in_table(values) if name in table.quantities else ("", values)
        )
        columns[f"{name} [{unit}]" if unit else name] = converted
    cases = np.arange(table.design.size)
    columns |= {
        name: [_text(body) for body in table.design.inputs(cases)[name]] for name in objects
    }
    return columns


def _text(value: Any) -> str:
    """Return a body as JSON, and other objects as text."""
    if hasattr(value, "model_dump"):
        return json.dumps(value.model_dump(mode="json"))
    return str(value)


def _netcdf(table: Table, path: Path) -> None:
    # the classic format can be read everywhere, needs SciPy only and is reproducible
    table.to_dataset().to_netcdf(path, engine="scipy")


def _csv(table: Table, path: Path) -> None:
    """Write the cases to a CSV file."""
    import pandas

    write_csv(path, pandas.DataFrame(_columns(table)), "nan")


def _excel(table: Table, path: Path) -> None:
    """Write the cases to a sheet of an Excel file, and the design to a second sheet."""
    import pandas

    record = record_table({"design": table.design.kind, **table.record})
    write_workbook(path, {"study": pandas.DataFrame(_columns(table)), "about": record})


def _parquet(table: Table, path: Path) -> None:
    """Write the cases to a Parquet file."""
    import pyarrow
    from pyarrow import parquet

    # pandas would write nan as null
    parquet.write_table(pyarrow.table(table.columns()), path)


_WRITERS: dict[str, Callable[[Table, Path], None]] = {
    ".nc": _netcdf,
    ".csv": _csv,
    ".xlsx": _excel,
    ".parquet": _parquet,
}
