"""Write tables for spreadsheets, CSV and Excel.

A spreadsheet computes a cell of a CSV file that starts like a formula, so texts that do are written
behind an apostrophe, which :mod:`.sheets` removes; in an Excel file they are cells of the type
text.  A spreadsheet in a language with decimal commas reads "3.502" in a CSV file as 3502; with
:func:`decimal_commas` every CSV file has semicolons between the cells and decimal commas.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import date, time, timedelta
from decimal import Decimal
from math import isfinite
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..problems.units import is_unit

if TYPE_CHECKING:
    import pandas as pd

__all__ = [
    "Percentage",
    "Thousands",
    "as_csv_cell",
    "decimal_commas",
    "in_csv_style",
    "is_number",
    "record_table",
    "without_apostrophe",
    "write_csv",
    "write_workbook",
]

MAX_WIDTH = 60  # characters
# the first characters of a formula; a lone one, such as "-" for no unit, is a text
_FORMULA = re.compile(r"[=+\-@\t\r].", re.DOTALL)
# a number of any locale, and the text behind it: "1.5", "1,5 kN", ".5e3"
_NUMBER = re.compile(r"[+-]?(?:\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d{1,3})?\s*(.*)", re.DOTALL)


class Percentage(float):
    """A number that a spreadsheet displays as a percentage: 0.2 as 20 %.

    >>> str(Percentage(0.07))
    '7.0 %'
    """

    def __str__(self) -> str:
        return f"{float(Decimal(float.__repr__(self)) * 100)!r} %"


class Thousands(float):
    """A number that a spreadsheet displays divided by thousands: 1900 as 1.9."""


def record_table(record: Mapping[str, Any]) -> pd.DataFrame:
    """Return the entries of a record as a table; values that are not texts are JSON."""
    import pandas as pd

    values = [value if isinstance(value, str) else json.dumps(value) for value in record.values()]
    return pd.DataFrame({"entry": list(record), "value": values})


def write_workbook(path: Path, sheets: Mapping[str, pd.DataFrame]) -> None:
    """Write tables to the sheets of an Excel file, with a bold and frozen header; nan is empty."""
    from openpyxl import Workbook
    from openpyxl.styles import Font
    from openpyxl.utils import get_column_letter

    book = Workbook()
    book.remove(book.active)
    for title, frame in sheets.items():
        sheet = book.create_sheet(title)
        sheet.freeze_panes = "A2"
        for k, (header, cells) in enumerate(frame.items(), 1):
            width = 8
            for row, value in enumerate((header, *cells), 1):
                _write_excel_cell(sheet.cell(row, k), value)
                if isinstance(value, str):  # numbers are rounded to the width, texts are not
                    width = max(width, len(value))
            sheet.cell(1, k).font = Font(bold=True)
            sheet.column_dimensions[get_column_letter(k)].width = min(width + 3, MAX_WIDTH)
    book.save(path)


def _write_excel_cell(cell: Any, value: Any) -> None:
    """Write a number, a date or a text, which is never a formula; nan and None are left out."""
    from openpyxl.cell.cell import ILLEGAL_CHARACTERS_RE

    if value is None or value != value:  # nan
        return
    if isinstance(value, Percentage):
        cell.number_format = "0.0###%"
    if isinstance(value, date | time | timedelta) or (isinstance(value, Real) and isfinite(value)):
        cell.value = value
        return
    text = ILLEGAL_CHARACTERS_RE.sub("\N{REPLACEMENT CHARACTER}", str(value))
    cell.value, cell.data_type = text, "s"
    cell.quotePrefix = _may_be_formula(text)  # the cell remains a text when it is edited


def write_csv(path: Path, frame: pd.DataFrame, gap: str = "") -> None:
    """Write a table as CSV with commas; ``gap`` stands for nan."""
    cells = frame.rename(columns=as_csv_cell)
    has_texts = [dtype.kind not in "fiub" for dtype in cells.dtypes]  # mask of the columns
    cells.loc[:, has_texts] = cells.loc[:, has_texts].map(as_csv_cell)
    text = cells.to_csv(index=False, na_rep=gap, lineterminator="\n")
    path.write_text(in_csv_style(text), encoding="utf-8", newline="")


_DECIMAL_COMMAS: ContextVar[bool] = ContextVar("decimal commas in CSV files", default=False)
_PLAIN_NUMBER = re.compile(r"[+-]?\d+(?:\.\d*)?(?:[eE][+-]?\d+)?")


@contextmanager
def decimal_commas() -> Iterator[None]:
    """Write every CSV file with decimal commas, and semicolons between the cells.

    Such files are read by spreadsheets in German, Finnish, French and other languages, and by the
    tables of this package.  Excel files (``.xlsx``) are read in every language without this.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import woundon as wo
    >>> result = wo.solve(wo.RollerProblem.example(), nodes=33)
    >>> path = pathlib.Path(tempfile.mkdtemp(), "rollers.csv")
    >>> with wo.decimal_commas():
    ...     result.save(path)
    >>> path.read_text().splitlines()[1]
    '# upper.radius [m];0,25'
    """
    token = _DECIMAL_COMMAS.set(True)
    try:
        yield
    finally:
        _DECIMAL_COMMAS.reset(token)


def in_csv_style(text: str) -> str:
    r"""Return a CSV text with commas and decimal points in the style of :func:`decimal_commas`.

    It is returned as it is outside of such a context.

    >>> with decimal_commas():
    ...     print(in_csv_style("name,T [N/m]\nx,3.5\n"))
    name;T [N/m]
    x;3,5
    <BLANKLINE>
    """
    if not _DECIMAL_COMMAS.get():
        return text
    out = io.StringIO()
    csv.writer(out, delimiter=";", lineterminator="\n").writerows(
        [cell.replace(".", ",") if _PLAIN_NUMBER.fullmatch(cell) else cell for cell in row]
        for row in csv.reader(io.StringIO(text))
    )
    return out.getvalue()


def as_csv_cell(value: Any) -> Any:
    """Return a value as a cell of CSV; a text that starts like a formula behind an apostrophe.

    >>> [as_csv_cell(value) for value in ("=1+1", "-2 kN/m", "@x", -2.0)]
    ["'=1+1", '-2 kN/m', "'@x", -2.0]
    """
    if isinstance(value, str) and _may_be_formula(value.lstrip("'")):
        return f"'{value}"
    return str(value) if isinstance(value, Percentage) else value


def without_apostrophe(text: str) -> str:
    """Return the text that :func:`as_csv_cell` has written."""
    is_quoted = text.startswith("'") and _FORMULA.match(text.lstrip("'"))
    return text[1:] if is_quoted else text


def _may_be_formula(text: str) -> bool:
    """Return True for a text that a spreadsheet may compute: "=1+1", but not "-2 kN/m"."""
    return bool(_FORMULA.match(text)) and not is_number(text)


def is_number(text: str) -> bool:
    """Return True for a number of any locale, with or without a unit.

    >>> [is_number(text) for text in ("1,5", "-.5e3 kN/m", "1.5 apples", "-")]
    [True, True, False, False]
    """
    match = _NUMBER.fullmatch(text)
    return match is not None and (not match[1] or is_unit(match[1]))
