"""A study's table to files: netCDF for xarray, CSV and Excel with units in the header, Parquet."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import InvalidProblem
from .measured import need_openpyxl
from .store import write_parquet
from .table import Table

if TYPE_CHECKING:
    import pandas

__all__ = ["check_export", "export"]

EXCEL_ROWS = 1_048_576


def export(table: Table, path: str | Path) -> None:
    """Write a table to ``.nc``, ``.csv``, ``.xlsx`` or ``.parquet``, by the path's ending.

    Raises
    ------
    InvalidProblem
        For another ending, or more rows than an Excel sheet has.
    OSError
        If the file cannot be written.
    """
    path = Path(path)
    write = check_export(path)
    aside = path.with_name(f".{path.name}.{os.getpid()}.part{path.suffix}")
    try:
        write(table, aside)
        os.replace(aside, path)
    finally:
        aside.unlink(missing_ok=True)


def check_export(path: str | Path) -> Callable[[Table, Path], None]:
    """Return what writes the format that a path's ending names; refuse others."""
    ending = Path(path).suffix
    if ending not in _WRITERS:
        raise InvalidProblem(
            [(str(path), f"the ending {ending!r} names no format; must be {', '.join(_WRITERS)}")]
        )
    if ending == ".xlsx":
        need_openpyxl()
    return _WRITERS[ending]


def _frame(table: Table) -> pandas.DataFrame:
    """Return the table with units in its header."""
    import pandas

    header = {name: f"{name} [{about.unit}]" for name, about in table.quantities.items()}
    return pandas.DataFrame(table.columns()).rename(columns=header)


def _netcdf(table: Table, path: Path) -> None:
    # the classic format: read everywhere, written by SciPy alone, the same bytes every time
    table.to_dataset().to_netcdf(path, engine="scipy")


def _csv(table: Table, path: Path) -> None:
    _frame(table).to_csv(path, index=False, na_rep="nan", lineterminator="\n")


def _excel(table: Table, path: Path) -> None:
    import pandas

    if table.design.size + 1 > EXCEL_ROWS:
        raise InvalidProblem(
            [(str(path), f"{table.design.size} cases are more than an Excel sheet's rows")]
        )
    record = {"design": table.design.kind, **table.record}
    about = {k: v if isinstance(v, str) else json.dumps(v) for k, v in record.items()}
    with pandas.ExcelWriter(path, engine="openpyxl") as book:
        # Excel knows no nan: a failed case has empty cells
        _frame(table).to_excel(book, sheet_name="study", index=False, freeze_panes=(1, 0))
        pandas.Series(about).to_excel(book, sheet_name="about", header=False)


def _parquet(table: Table, path: Path) -> None:
    import duckdb

    with duckdb.connect() as connection:
        write_parquet(connection, table.columns(), path)


_WRITERS: dict[str, Callable[[Table, Path], None]] = {
    ".nc": _netcdf,
    ".csv": _csv,
    ".xlsx": _excel,
    ".parquet": _parquet,
}
