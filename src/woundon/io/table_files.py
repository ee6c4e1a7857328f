"""Read the rows of table files: text in any locale, and Excel.

openpyxl skips the rest of merged blocks, reads formulas without a value as empty cells and creates
all cells up to a distant one.  The XML is checked for this before.  The value of a merged cell is
repeated in all cells of the block.  :mod:`.sheets` finds the table in the rows, and
:mod:`.spreadsheets` writes tables.
"""

from __future__ import annotations

import csv
import io
import re
import zipfile
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.util import find_spec
from typing import Any, NamedTuple
from xml.etree.ElementTree import iterparse

import numpy as np

from ..errors import InvalidProblem, one_of
from .spreadsheets import Percentage, Thousands, without_apostrophe

__all__ = [
    "MAX_COLUMNS",
    "MAX_ROWS",
    "ColumnCells",
    "Rows",
    "check_column",
    "decoded",
    "excel_rows",
    "need_openpyxl",
    "sheet_name",
    "text_rows",
]

MAX_EXCEL_BYTES = 50_000_000  # of the unpacked parts of an Excel file
MAX_EXCEL_CELLS = 2_000_000  # of a sheet, empty cells included
MAX_TEXT_CELLS = 20_000_000  # of a text file
MAX_COLUMNS = 500
MAX_ROWS = 1_048_576  # the limit of Excel
MAX_CELL = 32_767  # characters, the limit of Excel
MAX_BLANK_ROWS = 1000  # between rows of an Excel table
MAX_MERGED = 1000  # blocks of merged cells
PART = 1_000_000  # characters of a text that are divided into lines at once
SAMPLE = 1000  # lines from which the separator is determined
BEGINNING = 4096  # bytes of a file that show whether it is text
_BINARY = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0", b"\x89HDF")  # zip archives, Excel before 2007, HDF5

# parts of a number format of Excel that are displayed as they are (ECMA-376 part 1, 18.8.31)
_LITERAL = re.compile(r'"[^"]*"|\\.|[_*].|\[[^\]]*\]')
_THOUSANDS = re.compile("[0#?],+(?![0#?,])")  # commas that separate no digits divide by 1000 each

Cells = list[Any]  # of a row
ColumnCells = list[Any] | np.ndarray


class Rows(NamedTuple):
    """The rows of a file, from the first one, empty ones included.

    Attributes
    ----------
    cells : list of list
        Texts of a text file; numbers, dates and texts of an Excel file; "" for an empty cell.
    separator : str
        Character between the cells of a text file; empty for Excel.
    sheet : str
        Name of the sheet of an Excel file.
    sheets : tuple of str
        Names of all sheets of the file.
    """

    cells: list[Cells]
    separator: str = ""
    sheet: str = ""
    sheets: tuple[str, ...] = ()


def check_column(column: int, where: str, row: int = 0) -> None:
    """Reject a column beyond the maximum number; ``row`` is 0 for columns in memory."""
    if column > MAX_COLUMNS:
        place = f"row {row}, column {column}" if row else f"column {column}"
        text = f"{place}: the table has too many columns; must be at most {MAX_COLUMNS}"
        raise InvalidProblem.at(where, text)


# ---- text ---------------------------------------------------------------------------------------


def decoded(content: bytes, where: str) -> str:
    """Return the text of a file in UTF-8, UTF-16 (Excel's Unicode text) or Windows-1252.

    Raises
    ------
    InvalidProblem
        If it is not text.
    """
    if content.startswith((b"MDF     ", b"UnFinMF ")):
        text = "is an MDF file, whose signals have different times; export them as .tdms or .csv"
        raise InvalidProblem.at(where, f"{text} with one time base")
    has_mark = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    # only UTF-16 has zeros; those of a binary file are among its first bytes
    if content[:4] in _BINARY or (not has_mark and b"\0" in content[:BEGINNING]):
        raise InvalidProblem.at(where, "is not a text file; save it as .xlsx or .csv")
    # Windows-1252 matters for µ and ± in headers only
    for code in ["utf-16"] if has_mark else ["utf-8-sig", "cp1252"]:  # "-sig": drops the mark
        try:
            return content.decode(code)
        except UnicodeDecodeError:
            continue
    raise InvalidProblem.at(where, "is not a text file; save it as .xlsx or as CSV in UTF-8")


def text_rows(content: bytes, where: str) -> Rows:
    r"""Return the rows of a text file with semicolons, tabs or commas between the cells.

    Lines that start with # are empty rows.

    Raises
    ------
    InvalidProblem
        If it is not text, is too large, or has quotes that do not match; names the row.

    Examples
    --------
    >>> text_rows(b"a;b\n1,5;2\n", "rig.csv")[:2]
    ([['a', 'b'], ['1,5', '2']], ';')
    """
    text = decoded(content, where).replace("\r\n", "\n").replace("\r", "\n")
    if text.count("\n") >= MAX_ROWS:
        raise InvalidProblem.at(where, f"has too many rows; must be at most {MAX_ROWS}")
    # comments become blank lines, so that the rows keep their numbers
    text = re.sub("^#.*", "", text, flags=re.MULTILINE).rstrip("\n")
    declaration = re.match("sep=(.) *$", text, flags=re.MULTILINE)  # a line that Excel understands
    if declaration:
        text = text[declaration.end() :]  # its line remains, blank
    separator = declaration[1] if declaration else _separator(text)
    if text.count(separator) > MAX_TEXT_CELLS:
        raise InvalidProblem.at(where, f"has more than {MAX_TEXT_CELLS} cells")
    lines = csv.reader(_lines(text), delimiter=separator, skipinitialspace=True, strict=True)
    rows: list[Cells] = []
    try:
        rows.extend(lines)  # the rows before an error are kept
    except csv.Error as fault:
        reason = f"row {1 + len(rows)}: is not a table: {_csv_reason(str(fault))}"
        raise InvalidProblem.at(where, reason) from None
    if max(map(len, rows), default=0) > MAX_COLUMNS:
        number = next(k for k, row in enumerate(rows, 1) if len(row) > MAX_COLUMNS)
        check_column(len(rows[number - 1]), where, number)
    # without quotes a cell is not longer than its line
    ends = np.flatnonzero(np.frombuffer(content, np.uint8) == ord("\n"))  # of the lines
    longest = np.diff(ends, prepend=-1, append=len(content)).max()  # bytes
    if '"' in text or longest > MAX_CELL:
        for number, row in enumerate(rows, 1):
            if max(map(len, row), default=0) > MAX_CELL:
                raise _long_cell(row, where, number)
    if "'" in text:
        rows = [[without_apostrophe(cell) for cell in row] for row in rows]
    return Rows(rows, separator)


def _lines(text: str) -> Iterator[str]:
    """Yield the lines of a text with their ends; a StringIO would hold it with 4 bytes a letter."""
    start = 0
    while start <= len(text):
        end = text.find("\n", start + PART)  # a part ends with a line
        end = len(text) if end < 0 else end
        yield from (f"{line}\n" for line in text[start:end].split("\n"))
        start = end + 1


def _long_cell(row: Cells, where: str, number: int) -> InvalidProblem:
    """Return the error for a row with a cell that is too long."""
    column, cell = max(enumerate(row, 1), key=lambda place: len(str(place[1])))
    text = f"the cell has {len(str(cell))} characters; must be at most {MAX_CELL}"
    return InvalidProblem.at(where, f"row {number}, column {column}: {text}")


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
    first = text.split("\n", SAMPLE)[:SAMPLE]
    # the first one of equals: "1,5;2,5" could be three cells too
    return max(";\t,", key=lambda sign: sum(sign in line for line in first))


# ---- Excel --------------------------------------------------------------------------------------


def excel_rows(content: bytes, where: str, sheet: str = "") -> Rows:
    """Return the rows of a sheet of an Excel file, by default the first, merged cells repeated.

    Raises
    ------
    InvalidProblem
        If it is not an Excel file, is too large, has no sheet of this name, or has a formula
        without a value; names the row.
    """
    need_openpyxl()
    from openpyxl import load_workbook

    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            size = sum(part.file_size for part in archive.infolist())
            if size > MAX_EXCEL_BYTES:
                limit = f"must be at most {MAX_EXCEL_BYTES / 1e6:g} MB"
                text = f"has {size / 1e6:.0f} MB when it is unpacked; {limit}"
                raise InvalidProblem.at(where, text)
            book = load_workbook(io.BytesIO(content), read_only=True, data_only=True)
            by_name = {page.title: page for page in book.worksheets}  # without charts
            page = by_name[sheet_name(sheet, tuple(by_name), where)]
            blocks = _checked_layout(archive.read(page._worksheet_path), where)
            page.reset_dimensions()  # those that the file states may be wrong
            rows = [[_excel_cell(cell) for cell in row] for row in page.rows]
            book.close()
        cells = np.full((len(rows), max(map(len, rows), default=0)), "", dtype=object)
        for k, values in enumerate(rows):
            cells[k, : len(values)] = values
        _repeat_merged(cells, blocks, where)
    except InvalidProblem:
        raise
    except Exception as fault:  # zip and XML readers raise many types
        raise InvalidProblem.at(where, f"is not an Excel file: {fault}") from None
    for number, row in enumerate(rows, 1):
        if any(isinstance(cell, str) and len(cell) > MAX_CELL for cell in row):
            raise _long_cell(row, where, number)
    return Rows(cells.tolist(), sheet=page.title, sheets=tuple(by_name))


def sheet_name(requested: str, names: tuple[str, ...], where: str) -> str:
    """Return the name of the requested table of a file; of the first one if none is requested.

    Raises
    ------
    InvalidProblem
        If there is no such name.

    Examples
    --------
    >>> sheet_name("raw data", ("Results", "Raw data"), "rig.xlsx")
    'Raw data'
    """
    if not requested and names:
        return names[0]
    found = [name for name in names if name.casefold() == requested.casefold()]
    if not found:
        known = f"; its sheets are {one_of(map(repr, names), 'and')}" if names else ""
        raise InvalidProblem.at(where, f"has no sheet {requested!r}{known}")
    return found[0]


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
            if max(row * widest, spanned + column) > MAX_EXCEL_CELLS:
                limit = f"{MAX_EXCEL_CELLS} cells so far, empty ones included"
                text = f"the table has more than {limit}"
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
        elif repeated > max(MAX_EXCEL_CELLS, cells.size):  # more than the table has
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
