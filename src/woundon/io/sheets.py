"""Read tables: CSV of any locale, Excel files, columns in memory; and write Excel files.

A sheet has a header and rows, which keep the row numbers of the spreadsheet.  Titles above the
header, blank rows, columns without a header and lines that start with # are ignored; the value of a
merged cell is repeated in all cells of the block.  :mod:`.tables` interprets headers and cells.
"""

from __future__ import annotations

import csv
import io
import itertools
import os
import re
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple
from xml.parsers import expat

from ..errors import InvalidProblem
from ..problems.messages import quote
from ..problems.units import is_unit
from .files import read_whole

__all__ = [
    "Sheet",
    "check_cells",
    "check_header",
    "check_lines",
    "need_openpyxl",
    "read_sheet",
    "split_rows",
    "write_workbook",
]

MAX_BYTES = 50_000_000  # bytes of a file, and of the unpacked parts of an Excel file
MAX_CELLS = 2_000_000
MAX_SPANNED_CELLS = 5 * MAX_CELLS  # of an Excel sheet, empty cells included
MAX_COLUMNS = 500
MAX_ROWS = 1_048_576  # the limit of Excel
MAX_BLANK_ROWS = 1000  # between rows of a table; a cell farther down is not part of it
MAX_MERGED_BLOCKS = 1000  # blocks of merged cells
MAX_HEADER = 200  # characters; the time to search names is proportional to the square of it
MAX_CELL = 32_767  # characters, the limit of Excel
MAX_LINE = 100_000  # characters of a text file; the limit of the csv module is 131 072 in a cell
MAX_WIDTH = 60  # characters
EXCEL = (".xlsx", ".xlsm")
_BINARY = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")  # zip archives, Excel before 2007

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
    data : path, mapping or pandas.DataFrame
        ``.xlsx`` file (its first sheet), text file with commas, semicolons or tabs; or columns.
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
    if isinstance(data, Mapping) or (hasattr(data, "iloc") and not isinstance(data, type)):
        return _in_memory(data, name)
    if not isinstance(data, (str, os.PathLike)):
        text = "is not a table; must be columns by name, or the path of a .csv or .xlsx file"
        raise InvalidProblem.at(name, f"{quote(data)} {text}")
    excel = Path(data).suffix.lower() in EXCEL
    if excel:
        need_openpyxl()
    where = os.fspath(data)
    content = read_whole(where, MAX_BYTES)
    if excel:
        return _sheet(where, _excel_rows(content, where))
    if content[:4] in _BINARY:
        raise InvalidProblem.at(where, "is not a text file; save it as .xlsx or .csv")
    rows, separator = _text_rows(_decoded(content, where), where)
    return _sheet(where, rows)._replace(separator=separator)


def _in_memory(data: Any, name: str) -> Sheet:
    """Return the sheet of a mapping or a DataFrame."""
    columns: dict[str, list[Any]] = {}
    for label, cells in data.items():  # a DataFrame may have two columns of one name
        header = str(label)
        check_header(header, len(columns) + 1, name)
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


def _sheet(where: str, rows: Rows) -> Sheet:
    filled = [(number, cells) for number, cells in enumerate(rows, 1) if _filled(cells)]
    wide = any(len(_filled(cells)) > 1 for _, cells in filled)
    while wide and len(_filled(filled[0][1])) == 1:  # a title
        del filled[0]
    if len(filled) < 2:
        raise InvalidProblem.at(where, "has no header with rows below it")
    (number, header), *below = filled
    names = [" ".join(str(cell).split()) for cell in header]
    while not names[-1]:
        names.pop()
    found: set[str] = set()
    for k, name in enumerate(names, 1):
        check_header(name, k, where, number)
        if name and name in found:
            text = f"row {number}: two columns have the same header {name!r}"
            raise InvalidProblem.at(where, text)
        found.add(name)
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


def check_header(header: str, column: int, where: str, row: int = 0) -> None:
    """Reject a header that is too long, or a column beyond the maximum number."""
    place = f"row {row}, column {column}" if row else f"column {column}"
    if column > MAX_COLUMNS:
        text = f"{place}: the table has too many columns; must be at most {MAX_COLUMNS}"
        raise InvalidProblem.at(where, text)
    if len(header) > MAX_HEADER:
        text = f"the header has {len(header)} characters; must be at most {MAX_HEADER}"
        raise InvalidProblem.at(where, f"{place}: {text}")


def check_cells(cells: Sequence[Any], row: int, where: str) -> None:
    """Reject a row that has too many cells, or a cell that is too long."""
    if len(cells) > MAX_COLUMNS and (filled := _last_filled(cells)) > MAX_COLUMNS:
        text = f"the row has too many cells; must be at most {MAX_COLUMNS}"
        raise InvalidProblem.at(where, f"row {row}, column {filled}: {text}")
    for column, cell in enumerate(cells, 1):
        if isinstance(cell, str) and len(cell) > MAX_CELL:
            text = f"the cell has {len(cell)} characters; must be at most {MAX_CELL}"
            raise InvalidProblem.at(where, f"row {row}, column {column}: {text}")


def _last_filled(cells: Sequence[Any]) -> int:
    """Return the number of the last cell of a row that is not empty; 0 if all are empty."""
    return next((k for k in range(len(cells), 0, -1) if cells[k - 1] not in (None, "")), 0)


def _filled(cells: Iterable[Any]) -> list[str]:
    """Return the texts of the cells that are not empty."""
    return [text for cell in cells if (text := str(cell).strip())]


def _are_units(cells: Sequence[Any]) -> bool:
    units = [text.strip("[]() ") for text in _filled(cells) if text != "-"]
    return bool(units) and all(map(is_unit, units))


# ---- text ---------------------------------------------------------------------------------------


def _decoded(content: bytes, where: str) -> str:
    """Return the text of a file in UTF-8, UTF-16 (Excel's Unicode text) or Windows-1252."""
    marked = content[:2] in (b"\xff\xfe", b"\xfe\xff")
    # Windows-1252 matters for µ and ± in headers only
    for code in ["utf-16"] if marked else ["utf-8-sig", "cp1252"]:
        try:
            return content.decode(code)
        except UnicodeDecodeError:
            continue
    raise InvalidProblem.at(where, "is not a text file; save it as .xlsx or as CSV in UTF-8")


def _text_rows(text: str, where: str) -> tuple[Rows, str]:
    """Return the cells of the lines, and their separator.

    The csv module is used, because pandas.read_csv fills short rows and takes the first column for
    an index if a row is longer than the header.
    """
    if max(map(text.count, "\r\n")) > MAX_ROWS:
        raise InvalidProblem.at(where, f"has too many rows; must be at most {MAX_ROWS}")
    # comments become blank lines, so that the rows keep their numbers
    lines = ["\n" if line.startswith("#") else line for line in text.splitlines(keepends=True)]
    declared = re.fullmatch(r"sep=(.)\s*", lines[0]) if lines and len(lines[0]) < 20 else None
    if declared:  # a line that Excel understands
        lines[0] = "\n"

    def consistency(separator: str) -> int:
        """Return the number of the first rows that have the most frequent number of cells."""
        sizes = [len(row) for row in split_rows(lines[:100], separator, where) if len(row) > 1]
        return max(map(sizes.count, sizes), default=0)

    check_lines(lines, where)
    # the first one of equals: "1,5;2,5" could be three cells too
    separator = declared[1] if declared else max(";\t,", key=consistency)
    rows, size = [], 0
    for number, row in enumerate(split_rows(lines, separator, where), 1):
        check_cells(row, number, where)
        rows.append(row)
        size += len(row)
        if size > MAX_CELLS:
            raise InvalidProblem.at(where, f"row {number}: has more than {MAX_CELLS} cells so far")
    return rows, separator


def check_lines(lines: Sequence[str], where: str) -> None:
    """Reject lines, and cells between any of the separators, that are too long."""
    for number, line in enumerate(lines, 1):
        if len(line) <= MAX_CELL:
            continue
        end = 0
        for cell in re.split("[;\t,]", line[:MAX_LINE]):
            end += len(cell) + 1
            if len(cell) > MAX_CELL:
                text = f"the cell has too many characters; must be at most {MAX_CELL}"
                break
        else:
            text = f"the line has {len(line)} characters; must be at most {MAX_LINE}"
            if len(line) <= MAX_LINE:
                continue
        column = 1 + max(line.count(sign, 0, end - 1) for sign in ";\t,")
        raise InvalidProblem.at(where, f"row {number}, column {column}: {text}")


def split_rows(lines: Sequence[str], separator: str, where: str) -> Iterator[list[str]]:
    """Yield the cells of each row of a text."""
    reader = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    try:
        yield from reader
    except csv.Error as fault:
        raise InvalidProblem.at(where, f"row {reader.line_num}: is not a table: {fault}") from None


# ---- Excel --------------------------------------------------------------------------------------


def _excel_rows(content: bytes, where: str) -> Rows:
    """Return the rows of the first sheet of an Excel file, merged cells repeated.

    The sheet is read as a stream, because openpyxl would otherwise create all cells that a merged
    block or a single distant cell spans.
    """
    try:
        _check_unpacked(content, where)
        with _first_sheet(content, formulas=False) as sheet:
            # the number of blocks is checked before openpyxl reads them
            blocks, calculated = _merged_and_calculated(content, sheet._worksheet_path, where)
            rows = _streamed(sheet, where)
        if calculated:
            with _first_sheet(content, formulas=True) as sheet:
                rows = _with_uncalculated_formulas(rows, _streamed(sheet, where))
        rows = _even(rows, where)
        _repeat_merged(rows, blocks, where)
    except InvalidProblem:
        raise
    except Exception as fault:  # zip and XML readers raise many types
        raise InvalidProblem.at(where, f"is not an Excel file: {fault}") from None
    return rows


def _check_unpacked(content: bytes, where: str) -> None:
    """Reject an archive whose parts are too large when they are unpacked."""
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        size = sum(part.file_size for part in archive.infolist())
    if size > MAX_BYTES:
        text = (
            f"has {size / 1e6:.0f} MB when it is unpacked; must be at most {MAX_BYTES / 1e6:g} MB"
        )
        raise InvalidProblem.at(where, text)


@contextmanager
def _first_sheet(content: bytes, *, formulas: bool) -> Iterator[Any]:
    """Provide the first sheet of an Excel file as a stream of formulas or of values."""
    import openpyxl

    book = openpyxl.load_workbook(
        io.BytesIO(content), read_only=True, data_only=not formulas, keep_links=False
    )
    with closing(book):
        sheet: Any = book.worksheets[0]
        sheet.reset_dimensions()  # those stated in the file may be wrong
        yield sheet


def _streamed(sheet: Any, where: str) -> Rows:
    """Return the rows of a sheet, each up to its last cell that is not empty."""
    rows: Rows = []
    blank = size = spanned = 0
    for number, cells in enumerate(sheet.iter_rows(values_only=True), 1):
        spanned += len(cells)
        if spanned > MAX_SPANNED_CELLS:
            text = f"more than {MAX_SPANNED_CELLS} cells are spanned so far, empty ones included"
            raise InvalidProblem.at(where, f"row {number}, column {len(cells)}: {text}")
        filled = _last_filled(cells)
        if number > MAX_ROWS or (filled and blank > MAX_BLANK_ROWS and rows):
            text = f"{blank} rows above it are blank; must be at most {MAX_BLANK_ROWS}"
            raise InvalidProblem.at(where, f"row {number}, column {max(filled, 1)}: {text}")
        if not filled:
            blank += 1
            continue
        row = ["" if cell is None else cell for cell in cells[:filled]]
        check_cells(row, number, where)
        rows += [[] for _ in range(number - 1 - len(rows))]
        rows.append(row)
        blank, size = 0, size + len(row)
        if size > MAX_CELLS:
            text = f"row {number}: has more than {MAX_CELLS} cells so far"
            raise InvalidProblem.at(where, text)
    return rows


class Block(NamedTuple):
    """First and last row and column of a block of merged cells, counted from 1."""

    top: int
    first: int
    bottom: int
    last: int


_BLOCK = re.compile(r"\$?([A-Z]{1,3})\$?(\d{1,7})(?::\$?([A-Z]{1,3})\$?(\d{1,7}))?")


def _even(rows: Rows, where: str) -> Rows:
    """Return rows of equal length."""
    width = max(map(len, rows), default=0)
    if width * len(rows) > MAX_CELLS:
        raise InvalidProblem.at(where, f"has more than {MAX_CELLS} cells")
    return [row + [""] * (width - len(row)) for row in rows]


def _merged_and_calculated(content: bytes, part: str, where: str) -> tuple[list[Block], bool]:
    """Return the merged blocks of a sheet and, as a bool, if the sheet has formulas."""
    from openpyxl.utils import column_index_from_string as column

    blocks: list[Block] = []
    formulas: list[str] = []

    def start(name: str, attributes: dict[str, str]) -> None:
        local = name.rpartition(" ")[2]
        if local == "f" and not formulas:
            formulas.append(local)
        if local != "mergeCell":
            return
        ends = _BLOCK.fullmatch(attributes.get("ref", ""))
        if ends is None or len(blocks) == MAX_MERGED_BLOCKS:
            text = f"merged cells: must be at most {MAX_MERGED_BLOCKS} blocks, each as A1:B2"
            raise InvalidProblem.at(where, text)
        first, top, last, bottom = ends.groups()
        block = Block(int(top), column(first), int(bottom or top), column(last or first))
        blocks.append(block)

    parser = expat.ParserCreate(namespace_separator=" ")
    parser.StartElementHandler = start
    with zipfile.ZipFile(io.BytesIO(content)) as archive:
        parser.Parse(archive.read(part), True)
    return blocks, bool(formulas)


def _repeat_merged(rows: Rows, blocks: Iterable[Block], where: str) -> None:
    """Repeat the value of each merged block in all its cells, except in titles."""
    repeated = 0
    for top, first, bottom, last in blocks:
        block = rows[top - 1 : bottom]
        width = len(block[0][first - 1 : last]) if block else 0
        repeated += sum(map(len, block))
        if bottom > len(rows) + MAX_BLANK_ROWS or repeated > MAX_CELLS:
            text = f"merged cells reach down to row {bottom}, far below the table"
            raise InvalidProblem.at(where, f"row {top}, column {first}: {text}")
        if not width:  # outside the table
            continue
        value = block[0][first - 1]
        for row in block:  # Excel shows the first cell only
            row[first - 1 : last] = [""] * width
        block[0][first - 1] = value
        for row in block:
            if len(_filled(row)) > (row[first - 1] != ""):  # otherwise it is a title
                row[first - 1 : last] = [value] * width


def _with_uncalculated_formulas(rows: Rows, formulas: Rows) -> Rows:
    """Return the rows with the text of each formula whose value is not in the file."""
    marked: Rows = []
    empty: list[Any] = []
    for row, texts in itertools.zip_longest(rows, formulas, fillvalue=empty):
        pairs = itertools.zip_longest(row, texts, fillvalue="")
        marked.append(
            [
                formula if cell == "" and str(formula).startswith("=") else cell
                for cell, formula in pairs
            ]
        )
    return marked


def need_openpyxl() -> None:
    """Reject the use of Excel files if openpyxl is not installed."""
    if find_spec("openpyxl") is None:
        text = "Excel files need openpyxl: pip install 'woundon[excel]'"
        raise InvalidProblem.at("xlsx", text)


def write_workbook(path: Path, sheets: dict[str, Iterable[Sequence[Any]]]) -> None:
    """Write rows to the sheets of an Excel file, with a bold and frozen first row.

    Parameters
    ----------
    path : path
    sheets : mapping of str to iterable of rows
        nan and None become empty cells.
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
            # numbers are rounded to the width, texts are not
            longest = max(len(str(c.value)) for c in column if isinstance(c.value, str))
            sheet.column_dimensions[get_column_letter(k)].width = min(
                max(longest, 8) + 3, MAX_WIDTH
            )
    book.save(path)
