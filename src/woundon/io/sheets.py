"""Tables as spreadsheets hold them: CSV as Excel writes it anywhere, .xlsx, columns in memory.

A sheet is a header and the rows below it, which keep the numbers that a spreadsheet shows beside
them.  Titles above the header, blank rows, columns without a header and lines that open with # are
left out; a merged cell counts for all that it covers.  What they mean is told in :mod:`.tables`.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import InvalidProblem
from .files import read_whole
from .units import is_unit

if TYPE_CHECKING:
    from openpyxl.worksheet.worksheet import Worksheet

__all__ = ["Sheet", "need_openpyxl", "read_sheet", "write_workbook"]

LARGEST = 200_000_000  # bytes of a file
MOST_CELLS = 10_000_000
WIDEST = 60  # characters of a column
EXCEL = (".xlsx", ".xlsm")
_BINARY = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")  # zip archives, Excel before 2007

Rows = list[list[Any]]


class Sheet(NamedTuple):
    """A table as it was given.

    Attributes
    ----------
    where : str
        The file's path, or what the columns in memory are.
    columns : mapping of str to list
        The cells below each header.
    numbers : sequence of int
        Of the rows.
    units : mapping of str to str
        From a row of units below the header.
    in_si : bool
        Whether numbers without a unit are SI: columns in memory are, as all of Python is.
    between : str
        The sign between the cells of a text; empty of others.
    """

    where: str
    columns: dict[str, list[Any]]
    numbers: Sequence[int]
    units: Mapping[str, str] = MappingProxyType({})
    in_si: bool = False
    between: str = ""


def read_sheet(data: Any, name: str) -> Sheet:
    """Return a table.

    Parameters
    ----------
    data : path, mapping or pandas.DataFrame
        ``.xlsx`` file (its first sheet), text file with commas, semicolons or tabs; or columns.
    name : str
        What columns in memory are called in error texts.

    Raises
    ------
    InvalidProblem
        If it cannot be read or is no table, naming the row at fault.
    """
    if hasattr(data, "items"):
        columns = {str(header): list(cells) for header, cells in data.items()}
        sizes = {len(cells) for cells in columns.values()}
        if len(sizes) > 1:
            raise InvalidProblem.at(name, f"columns differ in length: {sorted(sizes)}")
        return Sheet(name, columns, range(1, 1 + max(sizes, default=0)), in_si=True)
    excel = Path(data).suffix.lower() in EXCEL
    if excel:
        need_openpyxl()
    where, content = str(data), read_whole(data, LARGEST)
    if excel:
        return _sheet(where, _excel_rows(content, where))
    if content[:4] in _BINARY:
        raise InvalidProblem.at(where, "is no text; save it as .xlsx or .csv")
    rows, between = _text_rows(_decoded(content, where), where)
    return _sheet(where, rows)._replace(between=between)


# ---- from rows to a sheet -----------------------------------------------------------------------


def _sheet(where: str, rows: Rows) -> Sheet:
    told = [(number, cells) for number, cells in enumerate(rows, 1) if _filled(cells)]
    wide = any(len(_filled(cells)) > 1 for _, cells in told)
    while wide and len(_filled(told[0][1])) == 1:  # a title
        del told[0]
    if len(told) < 2:
        raise InvalidProblem.at(where, "holds no header with rows below it")
    (number, header), *below = told
    names = [" ".join(str(cell).split()) for cell in header]
    while not names[-1]:
        names.pop()
    twice = [name for name in dict.fromkeys(names) if name and names.count(name) > 1]
    if twice:
        text = f"row {number}: two columns have the same header {twice[0]!r}"
        raise InvalidProblem.at(where, text)
    for number, cells in below:
        if len(cells) < len(names) or _filled(cells[len(names) :]):
            text = f"row {number} has {len(cells)} cells, the header {len(names)}"
            raise InvalidProblem.at(where, text)
    units: dict[str, str] = {}
    first = below[0][1]
    if len(below) > 1 and _are_units(first[: len(names)]):
        units = {name: str(unit).strip("[]() ") for name, unit in zip(names, first, strict=False)}
        del below[0]
    columns = {name: [cells[k] for _, cells in below] for k, name in enumerate(names) if name}
    return Sheet(where, columns, [number for number, _ in below], units)


def _filled(cells: Iterable[Any]) -> list[str]:
    """Return the texts of the cells that are not empty."""
    return [text for cell in cells if (text := str(cell).strip())]


def _are_units(cells: Sequence[Any]) -> bool:
    units = [text.strip("[]() ") for text in _filled(cells) if text != "-"]
    return bool(units) and all(map(is_unit, units))


# ---- text ---------------------------------------------------------------------------------------


def _decoded(content: bytes, where: str) -> str:
    """Return a file's text: UTF-8, what Excel calls Unicode (UTF-16), or Windows' own code."""
    marked = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    # Windows' code matters for a header's µ or ± alone, which would match nothing if read wrongly
    for code in ["utf-16"] if marked else ["utf-8-sig", "cp1252"]:
        try:
            return content.decode(code)
        except UnicodeDecodeError:
            continue
    raise InvalidProblem.at(where, "is no text; save it as .xlsx or as CSV in UTF-8")


def _text_rows(text: str, where: str) -> tuple[Rows, str]:
    """Return the lines as cells, and what stands between these.

    By the standard library: pandas.read_csv would fill short rows up, and take the first column
    for an index where a row is longer than the header.
    """
    # comments become blank lines, so that the rows keep their numbers
    lines = ["\n" if line.startswith("#") else line for line in text.splitlines(keepends=True)]
    told = re.fullmatch(r"sep=(.)\s*", lines[0]) if lines else None
    if told:  # as Excel reads it
        lines[0] = "\n"

    def cells(between: str, lines: list[str]) -> Rows:
        return list(csv.reader(lines, delimiter=between, skipinitialspace=True))

    def alike(between: str) -> int:
        """Return how many of the first rows have as many cells as most of them."""
        sizes = [len(row) for row in cells(between, lines[:100]) if len(row) > 1]
        return max(map(sizes.count, sizes), default=0)

    try:
        # the first of equals: "1,5;2,5" could be three cells too
        between = told[1] if told else max(";\t,", key=alike)
        return cells(between, lines), between
    except csv.Error as fault:
        raise InvalidProblem.at(where, f"is no table: {fault}") from None


# ---- Excel --------------------------------------------------------------------------------------


def _excel_rows(content: bytes, where: str) -> Rows:
    import openpyxl

    try:
        sheet = openpyxl.load_workbook(io.BytesIO(content), data_only=True).worksheets[0]
        rows = _cells(sheet, where)
        if any(cell == "" for row in rows for cell in row):
            formulas = openpyxl.load_workbook(io.BytesIO(content)).worksheets[0]
            _mark_unknown(rows, formulas)
    except InvalidProblem:
        raise
    except Exception as fault:  # whatever damage makes the readers of zip archives and XML raise
        raise InvalidProblem.at(where, f"is not an Excel file: {fault}") from None
    return rows


def _cells(sheet: Worksheet, where: str) -> Rows:
    """Return the cells, merged ones repeated."""
    if sheet.max_row * sheet.max_column > MOST_CELLS:
        raise InvalidProblem.at(where, f"has more than {MOST_CELLS} cells")
    rows = [["" if cell is None else cell for cell in row]
            for row in sheet.iter_rows(values_only=True)]  # fmt: skip
    for block in sheet.merged_cells.ranges:
        value = rows[block.min_row - 1][block.min_col - 1]
        for row in rows[block.min_row - 1 : block.max_row]:
            if len(_filled(row)) > (row[block.min_col - 1] != ""):  # else it is a title
                row[block.min_col - 1 : block.max_col] = [value] * block.size["columns"]
    return rows


def _mark_unknown(rows: Rows, formulas: Worksheet) -> None:
    """Put formulas that no spreadsheet has calculated yet in place of their missing values."""
    for row, told in zip(rows, formulas.iter_rows(values_only=True), strict=False):
        for k, formula in enumerate(told):
            if row[k] == "" and str(formula).startswith("="):
                row[k] = formula


def need_openpyxl() -> None:
    """Say how to install what reads and writes Excel files, where it is missing."""
    if find_spec("openpyxl") is None:
        text = "Excel files need openpyxl: pip install 'woundon[excel]'"
        raise InvalidProblem.at("xlsx", text)


def write_workbook(path: Path, sheets: dict[str, Iterable[Sequence[Any]]]) -> None:
    """Write rows to the sheets of an Excel file, the first row of each bold and always in sight.

    Parameters
    ----------
    path : path
    sheets : mapping of str to iterable of rows
        nan and None are empty cells, for Excel knows no nan.
    """
    from openpyxl import Workbook
    from openpyxl.styles import Font
    from openpyxl.utils import get_column_letter

    book = Workbook()
    book.remove(book.worksheets[0])
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        for cells in rows:
            sheet.append([None if cell != cell else cell for cell in cells])
        sheet.freeze_panes = "A2"
        for k, column in enumerate(sheet.iter_cols(), 1):
            column[0].font = Font(bold=True)
            # numbers are shown to what fits; of texts the longest
            longest = max(len(str(c.value)) for c in column if isinstance(c.value, str))
            sheet.column_dimensions[get_column_letter(k)].width = min(max(longest, 8) + 3, WIDEST)
    book.save(path)
