"""A study's table to files: netCDF for xarray, CSV and Excel with units in the header, Parquet."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from ..errors import InvalidProblem
from .store import write_parquet
from .table import Table

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
        openpyxl()
    return _WRITERS[ending]


def openpyxl() -> Any:
    """Return the module that reads and writes Excel, or say how to install it."""
    try:
        import openpyxl
    except ImportError:
        raise InvalidProblem(
            [("xlsx", "Excel files need openpyxl: pip install 'woundon[excel]'")]
        ) from None
    return openpyxl


def _rows(table: Table) -> Iterable[tuple[Any, ...]]:
    """Yield the header, then the rows."""
    columns = table.columns()
    yield tuple(_header(table, name) for name in columns)
    yield from zip(*(values.tolist() for values in columns.values()), strict=True)


def _header(table: Table, name: str) -> str:
    label = table.labels.get(name)
    return name if label is None or not label.unit else f"{name} [{label.unit}]"


def _netcdf(table: Table, path: Path) -> None:
    # the classic format: read everywhere, written by SciPy alone, the same bytes every time
    table.to_dataset().to_netcdf(path, engine="scipy")


def _csv(table: Table, path: Path) -> None:
    with path.open("w", encoding="utf-8", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(_rows(table))


def _excel(table: Table, path: Path) -> None:
    if table.design.size + 1 > EXCEL_ROWS:
        raise InvalidProblem(
            [(str(path), f"{table.design.size} cases are more than an Excel sheet's rows")]
        )
    book = openpyxl().Workbook(write_only=True)
    sheet = book.create_sheet("study")
    for row in _rows(table):
        # Excel knows no nan: a failed case has empty cells
        sheet.append([None if value != value else value for value in row])
    about = book.create_sheet("about")
    for name, value in {"design": table.design.kind, **table.record}.items():
        about.append([name, value if isinstance(value, str) else json.dumps(value)])
    content = io.BytesIO()
    book.save(content)
    path.write_bytes(content.getvalue())


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
