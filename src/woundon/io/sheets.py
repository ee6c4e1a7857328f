"""Read tables: CSV of any locale, Excel files, columns in memory.

A sheet has a header and rows, which keep the row numbers of the spreadsheet.  Titles above the
header, blank rows, columns without a header and lines that start with # are ignored; a title is the
only filled cell of its row.  The value of a merged cell is repeated in all cells of the block.
:mod:`.tables` interprets the headers, :mod:`.cells` the cells.

openpyxl skips the rest of merged blocks, reads formulas without a value as empty cells and creates
all cells up to a distant one.  The XML is checked for this before.  :mod:`.spreadsheets` writes
tables.
"""

from __future__ import annotations

import csv
import io
import os
import re
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple
from xml.etree.ElementTree import iterparse

import numpy as np

from ..errors import InvalidProblem
from ..problems.messages import quote
from ..problems.units import is_unit
from .files import read_whole
from .spreadsheets import Percentage, Thousands, without_apostrophe

__all__ = ["Sheet", "need_openpyxl", "read_sheet", "sheet_of_content"]

MAX_BYTES = 50_000_000  # bytes of a file, and of the unpacked parts of an Excel file
MAX_CELLS = 2_000_000  # of a table, empty cells included
MAX_COLUMNS = 500
MAX_ROWS = 1_048_576  # the limit of Excel
MAX_HEADER = 200  # characters; the time to search names is proportional to the square of it
MAX_CELL = 32_767  # characters, the limit of Excel
MAX_BLANK_ROWS = 1000  # between rows of an Excel table
MAX_MERGED = 1000  # blocks of merged cells
EXCEL = (".xlsx", ".xlsm")
_BINARY = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")  # zip archives, Excel before 2007

# parts of a number format of Excel that are displayed as they are (ECMA-376 part 1, 18.8.31)
_LITERAL = re.compile(r'"[^"]*"|\\.|[_*].|\[[^\]]*\]')
_THOUSANDS = re.compile("[0#?],+(?![0#?,])")  # commas that separate no digits divide by 1000 each

Rows = list[list[Any]]


class Sheet(NamedTuple):
    """A table before its headers and cells are interpreted.

    Attributes
    ----------
    where : str
        Path of the file, or the name of the columns in memory.
    columns : mapping of str to list
        The cells below each header.
    numbers : sequence of int
        Row numbers, as a spreadsheet shows them.
    units : mapping of str to str
        Units in a row below the header, by header.
    in_si : bool
        Whether numbers without a unit are in SI, as columns in memory are.
    separator : str
        Character between the cells of a text file; empty for other tables.
    """

    where: str
    columns: dict[str, list[Any]]
    numbers: Sequence[int]
    units: Mapping[str, str] = MappingProxyType({})
    in_si: bool = False
    separator: str = ""


def read_sheet(data: Any, name: str) -> Sheet:
    """Read a table.

    Parameters
    ----------
    data : path, mapping, pandas.DataFrame or Sheet
        ``.xlsx`` file (its first sheet), text file with commas, semicolons or tabs; or columns.
        A sheet is returned as it is.
    name : str
        Name of columns in memory in error messages.

    Raises
    ------
    InvalidProblem
        If it cannot be read or is not a table; names the row.

    Examples
    --------
    >>> sheet = read_sheet({"nip_load [N/m]": [1000.0, 2000.0]}, "measured")
    >>> sheet.columns
    {'nip_load [N/m]': [1000.0, 2000.0]}
    """
    if isinstance(data, Sheet):
        return data
    if isinstance(data, Mapping) or (hasattr(data, "iloc") and not isinstance(data, type)):
        return _in_memory(data, name)
    if not isinstance(data, (str, os.PathLike)):
        text = "is not a table; must be columns by name, or the path of a .csv or .xlsx file"
        raise InvalidProblem.at(name, f"{quote(data)} {text}")
    excel = Path(data).suffix.lower() in EXCEL
    if excel:
        need_openpyxl()  # before a file that may be missing is read
    where = os.fspath(data)
    return sheet_of_content(read_whole(where, MAX_BYTES), where, excel=excel)


def sheet_of_content(content: bytes, where: str, *, excel: bool) -> Sheet:
    r"""Return the table of the bytes of a file; ``where`` names it in error messages.

    >>> content = b"nip_load [kN/m];nip_width [mm]\n3,5;4,9"
    >>> sheet_of_content(content, "the table", excel=False).columns
    {'nip_load [kN/m]': ['3,5'], 'nip_width [mm]': ['4,9']}
    """
    if excel:
        need_openpyxl()
        return _sheet(where, _excel_rows(content, where))
    if content[:4] in _BINARY:
        raise InvalidProblem.at(where, "is not a text file; save it as .xlsx or .csv")
    rows, separator = _text_rows(_decode(content, where), where)
    rows = [[without_apostrophe(cell) for cell in row] for row in rows]
    return _sheet(where, rows)._replace(separator=separator)


def _in_memory(data: Any, name: str) -> Sheet:
    """Return the sheet of a mapping or a DataFrame."""
    columns: dict[str, list[Any]] = {}
    for label, cells in data.items():  # a DataFrame may have two columns of one name
        header = str(label)
        _check_header(header, len(columns) + 1, name)
        if header in columns:
            raise InvalidProblem.at(name, f"two columns have the same header {header!r}")
        columns[header] = _listed(cells, f"{name}: column {header!r}")
    sizes = {len(cells) for cells in columns.values()}
    if len(sizes) > 1:
        raise InvalidProblem.at(name, f"columns differ in length: {sorted(sizes)}")
    return Sheet(name, columns, range(1, 1 + max(sizes, default=0)), in_si=True)


def _listed(cells: Any, where: str) -> list[Any]:
    """Return the cells of a column; reject values that are not one-dimensional sequences."""
    no_cells = isinstance(cells, (str, bytes, bytearray, Mapping, set, frozenset, type))
    if not no_cells and getattr(cells, "ndim", 1) == 1:
        try:
            return list(cells)
        except TypeError:
            pass
    raise InvalidProblem.at(where, f"{quote(cells)} is not a column; must be a list of its cells")


# ---- from rows to a sheet -----------------------------------------------------------------------


class _Row(NamedTuple):
    """A row with its number in the spreadsheet and the texts of the cells that are not empty."""

    number: int
    cells: list[Any]
    texts: list[str]


def _sheet(where: str, rows: Rows) -> Sheet:
    """Return the table of rows of cells: title rows are skipped, then header, units and values."""
    filled = _filled_rows(rows, where)
    if any(len(row.texts) > 1 for row in filled):
        while len(filled[0].texts) == 1:  # a title; a table of one column has none
            del filled[0]
    if len(filled) < 2:
        raise InvalidProblem.at(where, "has no header with rows below it")
    header, *body = filled
    names = _headers(header, where)
    for row in body:
        if len(row.cells) < len(names) or _nonempty_cells(row.cells[len(names) :]):
            # cells without a header may only be empty
            text = f"row {row.number} has {len(row.cells)} cells, the header {len(names)}"
            raise InvalidProblem.at(where, text)
    units: dict[str, str] = {}
    below_header = body[0].cells[: len(names)]
    if len(body) > 1 and _are_units(below_header):
        units = {n: str(unit).strip("[]() ") for n, unit in zip(names, below_header, strict=True)}
        del body[0]
    columns = {name: [row.cells[k] for row in body] for k, name in enumerate(names) if name}
    return Sheet(where, columns, [row.number for row in body], units)


def _filled_rows(rows: Rows, where: str) -> list[_Row]:
    """Return the rows that are not blank; reject cells that are too long."""
    filled = []
    for number, cells in enumerate(rows, 1):
        texts = _nonempty_cells(cells)
        if texts:
            filled.append(_Row(number, cells, texts))
            if max(map(len, texts)) > MAX_CELL:
                column, cell = max(enumerate(cells, 1), key=lambda place: len(str(place[1])))
                text = f"the cell has {len(cell)} characters; must be at most {MAX_CELL}"
                raise InvalidProblem.at(where, f"row {number}, column {column}: {text}")
    return filled


def _headers(row: _Row, where: str) -> list[str]:
    """Return the headers of all columns, '' for none, up to the last; reject equal ones."""
    names = [" ".join(str(cell).split()) for cell in row.cells]
    while not names[-1]:
        names.pop()
    for k, name in enumerate(names):
        _check_header(name, k + 1, where, row.number)
        if name and name in names[:k]:
            text = f"row {row.number}: two columns have the same header {name!r}"
            raise InvalidProblem.at(where, text)
    return names


def _check_header(header: str, column: int, where: str, row: int = 0) -> None:
    """Reject a header that is too long, or a column beyond the maximum number."""
    place = f"row {row}, column {column}" if row else f"column {column}"
    if column > MAX_COLUMNS:
        text = f"{place}: the table has too many columns; must be at most {MAX_COLUMNS}"
        raise InvalidProblem.at(where, text)
    if len(header) > MAX_HEADER:
        text = f"the header has {len(header)} characters; must be at most {MAX_HEADER}"
        raise InvalidProblem.at(where, f"{place}: {text}")


def _nonempty_cells(cells: Iterable[Any]) -> list[str]:
    """Return the texts of the cells that are not empty."""
    return [text for cell in cells if (text := str(cell).strip())]


def _are_units(cells: Sequence[Any]) -> bool:
    """Return True if all cells that are not empty are units, in brackets or not, or "-"."""
    units = [text.strip("[]() ") for text in _nonempty_cells(cells) if text != "-"]
    return bool(units) and all(map(is_unit, units))


# ---- text ---------------------------------------------------------------------------------------


def _decode(content: bytes, where: str) -> str:
    """Return the text of a file in UTF-8, UTF-16 (Excel's Unicode text) or Windows-1252."""
    has_mark = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    # Windows-1252 matters for µ and ± in headers only
    for code in ["utf-16"] if has_mark else ["utf-8-sig", "cp1252"]:  # "-sig": drops the mark
        try:
            return content.decode(code)
        except UnicodeDecodeError:
            continue
    raise InvalidProblem.at(where, "is not a text file; save it as .xlsx or as CSV in UTF-8")


def _text_rows(text: str, where: str) -> tuple[Rows, str]:
    """Return the cells of the lines of a text, and their separator."""
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if text.count("\n") >= MAX_ROWS:
        raise InvalidProblem.at(where, f"has too many rows; must be at most {MAX_ROWS}")
    # comments become blank lines, so that the rows keep their numbers
    text = re.sub("^#.*", "", text, flags=re.MULTILINE).rstrip("\n")
    declaration = re.match("sep=(.) *$", text, flags=re.MULTILINE)  # a line that Excel understands
    if declaration:
        text = text[declaration.end() :]  # its line remains, blank
    separator = declaration[1] if declaration else _separator(text)
    lines = csv.reader(io.StringIO(text), delimiter=separator, skipinitialspace=True, strict=True)
    rows: Rows = []
    widest = 1
    try:
        for row in lines:
            rows.append(row)
            widest = max(widest, len(row))
            if len(row) > MAX_COLUMNS:
                _check_header("", len(row), where, len(rows))
            if len(rows) * widest > MAX_CELLS:
                raise InvalidProblem.at(where, f"has more than {MAX_CELLS} cells")
    except csv.Error as fault:
        text = f"row {1 + len(rows)}: is not a table: {_csv_reason(str(fault))}"
        raise InvalidProblem.at(where, text) from None
    return rows, separator


def _csv_reason(fault: str) -> str:
    """Return the reason for which the csv module rejects a row, from the message of its error."""
    if fault.startswith("field larger"):
        limit = csv.field_size_limit()
        return f"a quote has no end, or a cell has more than {limit} characters"
    if "expected after" in fault:
        return f"in a cell in quotes, {fault}; a quote inside of it must be doubled"
    return "a quote has no end"


def _separator(text: str) -> str:
    """Return the character that separates the cells: the one that most of the first lines have."""
    first = text.split("\n", 100)[:100]
    # the first one of equals: "1,5;2,5" could be three cells too
    return max(";\t,", key=lambda sign: sum(sign in line for line in first))


# ---- Excel --------------------------------------------------------------------------------------


def _excel_rows(content: bytes, where: str) -> Rows:
    """Return the rows of the first sheet of an Excel file, merged cells repeated."""
    from openpyxl import load_workbook

    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            size = sum(part.file_size for part in archive.infolist())
            if size > MAX_BYTES:
                limit = f"must be at most {MAX_BYTES / 1e6:g} MB"
                text = f"has {size / 1e6:.0f} MB when it is unpacked; {limit}"
                raise InvalidProblem.at(where, text)
            book = load_workbook(io.BytesIO(content), read_only=True, data_only=True)
            sheet = book.worksheets[0]
            blocks = _checked_layout(archive.read(sheet._worksheet_path), where)
            sheet.reset_dimensions()  # those that the file states may be wrong
            rows = [[_excel_cell(cell) for cell in row] for row in sheet.rows]
            book.close()
        cells = np.full((len(rows), max(map(len, rows), default=0)), "", dtype=object)
        for row, values in zip(cells, rows, strict=True):
            row[: len(values)] = values
        _repeat_merged(cells, blocks, where)
    except InvalidProblem:
        raise
    except Exception as fault:  # zip and XML readers raise many types
        raise InvalidProblem.at(where, f"is not an Excel file: {fault}") from None
    return cells.tolist()


def _excel_cell(cell: Any) -> Any:
    """Return the value of a cell of Excel with the scale of its format; "" if it is empty."""
    value = cell.value
    if value is None:
        return ""
    if cell.data_type == "n" and isinstance(value, int | float):
        percent, literal, thousands = _scales(cell.number_format)
        if thousands:
            return Thousands(value)
        if percent or literal:
            return Percentage(value / 100 if literal else value)
    return value


@cache
def _scales(number_format: str) -> tuple[bool, bool, bool]:
    """Return flags of a format: multiplies by 100, only displays "%", divides by thousands."""
    code = _LITERAL.sub("", number_format)
    return "%" in code, "%" not in code and "%" in number_format, bool(_THOUSANDS.search(code))


def _checked_layout(part: bytes, where: str) -> list[tuple[int, int, int, int]]:
    """Return the merged blocks of a sheet: first column and row, last column and row.

    Rejects formulas without a value, and cells so far out that the table would be too large.
    """
    from openpyxl.utils.cell import coordinate_to_tuple, range_boundaries

    blocks = []
    row = column = 0  # of the cell that is read
    last = widest = 0  # last row and column with contents
    spanned = 0  # cells of all rows above, each up to its last one
    for event, element in iterparse(io.BytesIO(part), ("start", "end")):
        kind = event, element.tag.rpartition("}")[2]
        if kind == ("start", "row"):
            row, column = int(element.get("r", row + 1)), 0
        elif kind == ("end", "c"):
            place = element.get("r")
            column = coordinate_to_tuple(place)[1] if place else column + 1
            contents = {child.tag.rpartition("}")[2]: child.text for child in element}
            text = ""
            # a formula "f" without a value "v"; of type "str", its value is an empty text
            if "f" in contents and not contents.get("v") and element.get("t") != "str":
                text = "the formula has no value; open and save the file in a spreadsheet"
            if contents:
                if row > last + MAX_BLANK_ROWS:
                    text = f"the rows above are blank; must be at most {MAX_BLANK_ROWS} of them"
                last, widest = row, max(widest, column)
            if widest > MAX_COLUMNS:
                text = f"the table has too many columns; must be at most {MAX_COLUMNS}"
            # pandas makes all rows as wide as the widest one, openpyxl as their last cell
            if max(row * widest, spanned + column) > MAX_CELLS:
                text = f"the table has more than {MAX_CELLS} cells so far, empty ones included"
            if text:
                raise InvalidProblem.at(where, f"row {row}, column {column}: {text}")
            element.clear()
        elif kind == ("end", "row"):
            spanned += column
            element.clear()
        elif kind == ("end", "mergeCell"):
            blocks.append(range_boundaries(element.get("ref")))
            if len(blocks) > MAX_MERGED:
                text = f"has too many blocks of merged cells; must be at most {MAX_MERGED}"
                raise InvalidProblem.at(where, text)
    return blocks


def _repeat_merged(cells: Any, blocks: Iterable[tuple[int, int, int, int]], where: str) -> None:
    """Repeat the value of each merged block in the rows that have other contents.

    A block alone in its rows is a title and is not repeated.

    Parameters
    ----------
    cells : (rows, columns) array of object
        "" in empty cells; it is changed.
    blocks : iterable of (int, int, int, int)
        First column and row, last column and row, from 1.
    where : str
        Names the file in error messages.
    """
    filled = np.count_nonzero(cells != "", axis=1)  # number of cells of each row
    repeated = 0
    for first, top, last, bottom in blocks:
        rows, columns = slice(top - 1, bottom), slice(first - 1, last)
        block = cells[rows, columns]
        repeated += block.size
        text = ""
        if bottom > len(cells) + MAX_BLANK_ROWS:
            text = f"merged cells reach down to row {bottom}, far below the table"
        elif repeated > max(MAX_CELLS, cells.size):  # more than the table has
            text = "merged cells overlap"
        if text:
            raise InvalidProblem.at(where, f"row {top}, column {first}: {text}")
        if not block.size:  # outside the table
            continue
        others = filled[rows] - np.count_nonzero(block != "", axis=1)  # next to the block
        value = block[0, 0]
        block[:] = ""  # Excel shows the first cell only
        block[0, 0] = value
        block[others > 0] = value
        filled[rows] = others + np.count_nonzero(block != "", axis=1)


def need_openpyxl() -> None:
    """Reject the use of Excel files if openpyxl is not installed."""
    if find_spec("openpyxl") is None:
        text = "Excel files need openpyxl: pip install 'woundon[excel]'"
        raise InvalidProblem.at("xlsx", text)
