"""Write tables of cases: netCDF, CSV and Excel with units in the header, Parquet."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InvalidProblem, one_of
from ..io.files import replaced_file
from ..io.spreadsheets import record_table, write_csv, write_workbook
from ..io.table_files import MAX_ROWS, need_openpyxl
from ..quantities import Quantity, header
from .cases import is_numeric
from .run import Table

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["EXPORTS", "TABLES", "check_export", "export", "in_units", "write_table"]

EXPORTS = (".nc", ".csv", ".xlsx", ".parquet")
TABLES = (".csv", ".xlsx")  # formats of tables of cases that are not studies


def check_export(path: str | Path, endings: tuple[str, ...] = EXPORTS) -> Path:
    """Return the path of a file that can be written.

    Raises
    ------
    InvalidProblem
        For another ending, or one whose package is not installed.
    """
    path = Path(path)
    if path.suffix not in endings:
        text = f"the ending {path.suffix!r} is not a known format; must be {one_of(endings)}"
        raise InvalidProblem.at(str(path), text)
    if path.suffix == ".xlsx":
        need_openpyxl()
    if path.suffix == ".parquet" and find_spec("pyarrow") is None:
        raise InvalidProblem.at(str(path), "needs pyarrow: pip install 'woundon[parquet]'")
    return path


def export(table: Table, path: str | Path) -> None:
    """Write a study to ``.nc``, ``.csv``, ``.xlsx`` or ``.parquet``.

    Raises
    ------
    InvalidProblem
        For another ending, more rows than an Excel sheet has, or a package that is not installed.
    OSError
        If the file cannot be written.
    """
    path = check_export(path)
    if path.suffix == ".xlsx" and len(table.cases) + 1 > MAX_ROWS:
        text = f"{len(table.cases)} cases are more than an Excel sheet's rows"
        raise InvalidProblem.at(str(path), text)
    with replaced_file(path) as temporary:
        if path.suffix == ".nc":
            # the classic format can be read everywhere, needs SciPy only and is reproducible
            table.to_dataset().to_netcdf(temporary, engine="scipy")
        elif path.suffix == ".csv":
            write_csv(temporary, _with_units(table), gap="nan")
        elif path.suffix == ".xlsx":
            record = record_table({"design": table.cases.design, **table.record})
            write_workbook(temporary, {"study": _with_units(table), "about": record})
        else:
            import pyarrow
            from pyarrow import parquet

            # pandas would write nan as null
            columns = {name: column.to_numpy() for name, column in table.to_dataframe().items()}
            parquet.write_table(pyarrow.table(columns), temporary)


def write_table(frame: pd.DataFrame, path: str | Path) -> None:
    """Write the table of :func:`woundon.solve_table` to ``.csv`` or ``.xlsx``.

    Raises
    ------
    InvalidProblem
        For another ending.
    OSError
        If the file cannot be written.
    """
    path = check_export(path, TABLES)
    with replaced_file(path) as temporary:
        if path.suffix == ".csv":
            write_csv(temporary, frame)
        else:
            about = record_table(frame.attrs.get("about", {}))
            write_workbook(temporary, {"results": frame, "about": about})


def _with_units(table: Table) -> pd.DataFrame:
    """Return the columns of a study in units for tables, which are in the headers.

    Bodies are written as JSON, so that the file can be used as the cases of another study.
    """
    frame = table.to_dataframe()
    for name, values in table.cases.frame.items():
        if not is_numeric(values.to_numpy()):
            frame[name] = [_as_text(value) for value in values]
    return in_units(frame, table.quantities)


def in_units(frame: pd.DataFrame, quantities: Mapping[str, Quantity]) -> pd.DataFrame:
    """Return a table with columns of SI values in units for tables, which are in the headers.

    Columns without a quantity, and those of a field that is a number but has schedules here, stay.
    """
    frame, headers = frame.copy(), {}
    for name in frame.columns.intersection(list(quantities)):
        values = frame[name].to_numpy()
        if is_numeric(values):
            unit, frame[name] = quantities[name].in_table(values)
            headers[name] = header(name, unit)
    return frame.rename(columns=headers)


def _as_text(value: Any) -> str:
    """Return a body as JSON, and other values as text."""
    if hasattr(value, "model_dump"):
        return json.dumps(value.model_dump(mode="json"))
    return str(value)
