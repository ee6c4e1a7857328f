"""Read tables: text files of any locale, Excel and instrument files, columns in memory.

A sheet has a header and rows, which keep the row numbers of the spreadsheet.  The header is the row
with known names above the longest block of rows with numbers; without known names, the last row
without numbers above this block.  Rows above the header (titles, results of a test), a row of units
below it, blank rows, columns without a header and lines that start with # are no rows of the table.

:mod:`.table_files` reads the rows of files, :mod:`.instruments` the channels of instrument files;
:mod:`.tables` interprets the headers, :mod:`.cells` the cells.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from ..errors import InputWarning, InvalidProblem, one_of, warn
from ..problems.messages import quote
from ..problems.units import is_unit
from .files import read_whole
from .instruments import ENDINGS as INSTRUMENTS
from .instruments import need_reader, read_channels
from .spreadsheets import is_number
from .table_files import (
    ColumnCells,
    Rows,
    check_column,
    excel_rows,
    need_openpyxl,
    text_rows,
)

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["BINARY", "TABLES", "Sheet", "TableFile", "find_table", "read_sheet"]

MAX_BYTES = 200_000_000  # of a file
MAX_HEADER = 200  # characters; the time to search names is proportional to the square of it
MAX_LISTED = 12  # headers in an error message
MAX_UNIT = 20  # characters of a cell in a row of units
MAX_CANDIDATES = 200  # rows that are examined as headers
MAX_BELOW = 3  # rows from a header to the first row with numbers
SCANNED = 5000  # first rows, in which a header with known names is searched
EXCEL = (".xlsx", ".xlsm")
BINARY = (*EXCEL, ".tdms")  # formats that are no text
TABLES = (".csv", ".txt", ".tsv", *EXCEL, *INSTRUMENTS)


class Sheet(NamedTuple):
    """A table before its headers and cells are interpreted.

    Attributes
    ----------
    where : str
        Path of the file with the name of its sheet, or the name of the columns in memory.
    columns : mapping of str to list or (rows,) array
        The cells below each header.
    numbers : sequence of int
        Row numbers, as a spreadsheet shows them; of an instrument file those of the samples.
    units : mapping of str to str
        Units in a row below the header, by header.
    in_si : bool
        Whether numbers without a unit are in SI, as columns in memory are.
    separator : str
        Character between the cells of a text file; empty for other tables.
    header : int
        Row number of the header; 0 if the table has none, as columns in memory.
    others : str
        Text on the other tables of the file, for error messages.
    remarks : tuple of str
        What was left out, and how channels were joined.
    """

    where: str
    columns: Mapping[str, ColumnCells]
    numbers: Sequence[int]
    units: Mapping[str, str] = MappingProxyType({})
    in_si: bool = False
    separator: str = ""
    header: int = 0
    others: str = ""
    remarks: tuple[str, ...] = ()

    @property
    def headers(self) -> str:
        """The first headers as a text, for error messages."""
        return ", ".join(map(repr, list(self.columns)[:MAX_LISTED]))

    @property
    def origin(self) -> str:
        """Where the headers are from and what to do if that is wrong; empty for memory."""
        if not self.header:
            return self.others
        text = f"row {self.header} is taken for the header; if another row is, delete those above"
        return f"{text} it{f'; {self.others}' if self.others else ''}"


class TableFile(NamedTuple):
    """A file that was sent: its name, whose ending is that of its format, and its content."""

    name: str
    content: bytes


IsKnown = Callable[[str], bool]
# A path, a file that was sent, columns by name, or a table that was read.
TableSource: TypeAlias = (
    "str | os.PathLike[str] | TableFile | Mapping[str, Any] | pd.DataFrame | Sheet"
)


def _nothing_known(header: str) -> bool:
    """Return False: no name is known."""
    return False


def read_sheet(data: TableSource, name: str, is_known: IsKnown = _nothing_known) -> Sheet:
    """Read a table as :func:`find_table`; remarks are issued as warnings.

    Examples
    --------
    >>> sheet = read_sheet({"nip_load [N/m]": [1000.0, 2000.0]}, "measured")
    >>> sheet.columns
    {'nip_load [N/m]': [1000.0, 2000.0]}
    """
    sheet = find_table(data, name, is_known)
    warn([f"{sheet.where}: {remark}" for remark in sheet.remarks], InputWarning)
    return sheet


def find_table(
    data: TableSource, name: str, is_known: IsKnown = _nothing_known, sheet: str = ""
) -> Sheet:
    r"""Read a table.

    Parameters
    ----------
    data : path, TableFile, mapping, pandas.DataFrame or Sheet
        Text file with commas, semicolons or tabs, ``.xlsx``, ``.lvm`` or ``.tdms`` file; or
        columns.  ``"file.xlsx#Sheet"`` names a sheet of an Excel file, a segment or a group of an
        instrument file.  A sheet is returned as it is.
    name : str
        Name of columns in memory in error messages.
    is_known : callable
        Whether a header, with its unit, is a known name.
    sheet : str
        Name of a sheet, in place of that behind the ``#``.

    Raises
    ------
    InvalidProblem
        If it cannot be read or is not a table; names the row.

    Examples
    --------
    >>> content = b"Test 7\nResult;12,3\n\nnip_load [kN/m];nip_width [mm]\n3,5;4,9"
    >>> sheet = find_table(TableFile("rig.csv", content), "measured")
    >>> sheet.header, sheet.columns
    (4, {'nip_load [kN/m]': ['3,5'], 'nip_width [mm]': ['4,9']})
    """
    if isinstance(data, Sheet):
        return data
    if isinstance(data, TableFile):
        return _sheet_of_file(data, sheet, is_known)
    if isinstance(data, Mapping) or (hasattr(data, "iloc") and not isinstance(data, type)):
        return _in_memory(data, name)
    if not isinstance(data, (str, os.PathLike)):
        text = "is not a table; must be columns by name, or the path of a .csv or .xlsx file"
        raise InvalidProblem.at(name, f"{quote(data)} {text}")
    path, fragment = _split_path(os.fspath(data))
    _need_packages(path)  # before a file that may be missing is read
    file = TableFile(path, read_whole(path, MAX_BYTES))
    return _sheet_of_file(file, sheet or fragment, is_known)


def _split_path(path: str) -> tuple[str, str]:
    """Return the path of a file, and the name of a sheet behind the last ``#``; '' without one."""
    if "#" not in path or os.path.exists(path):
        return path, ""
    file, _, sheet = path.rpartition("#")
    return file, sheet


def _need_packages(path: str) -> None:
    """Reject a file whose reader is not installed."""
    ending = Path(path).suffix.lower()
    if ending in EXCEL:
        need_openpyxl()
    elif ending in INSTRUMENTS:
        need_reader(ending)


def _sheet_of_file(file: TableFile, sheet: str, is_known: IsKnown) -> Sheet:
    """Return the table in a file; ``sheet`` is the name of one of its sheets, '' for the first."""
    ending = Path(file.name).suffix.lower()
    _need_packages(file.name)
    if ending in INSTRUMENTS:
        channels = read_channels(file.content, file.name, ending, sheet, is_known)
        return Sheet(
            channels.where,
            channels.columns,
            range(1, 1 + channels.rows),
            channels.units,
            others=channels.others,
            remarks=channels.remarks,
        )
    if ending in EXCEL:
        return _table_in(excel_rows(file.content, file.name, sheet), file.name, is_known)
    if sheet:
        raise InvalidProblem.at(file.name, f"is a text file, which has no sheet {sheet!r}")
    return _table_in(text_rows(file.content, file.name), file.name, is_known)


def _in_memory(data: Any, name: str) -> Sheet:
    """Return the sheet of a mapping or a DataFrame."""
    columns: dict[str, ColumnCells] = {}
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
    if isinstance(cells, np.ndarray) and cells.ndim == 1 and cells.dtype.kind in "iuf":
        return list(cells.tolist())  # as numbers of Python
    no_cells = isinstance(cells, (str, bytes, bytearray, Mapping, set, frozenset, type))
    if not no_cells and getattr(cells, "ndim", 1) == 1:
        try:
            return list(cells)
        except TypeError:
            pass
    raise InvalidProblem.at(where, f"{quote(cells)} is not a column; must be a list of its cells")


# ---- the table among the rows of a file ---------------------------------------------------------


def _table_in(rows: Rows, path: str, is_known: IsKnown) -> Sheet:
    """Return the table among the rows of a file: header, units and values."""
    where, others = path, ""
    if len(rows.sheets) > 1:
        names = [f"{path}#{name}" for name in rows.sheets if name != rows.sheet]
        where, others = f"{path}#{rows.sheet}", f"other sheets are {one_of(names, 'and')}"
    # indices of the rows that are not blank
    text_of = str.strip if rows.separator else _text  # all cells of a text file are texts
    filled = [k for k, row in enumerate(rows.cells) if any(map(text_of, row))]
    place = _position_of_header(rows, filled, is_known, where)
    if place is None or place + 1 == len(filled):
        text = "has no header with rows below it"
        if filled and place is None:
            text = f"has numbers in row {1 + filled[0]}, but no header above them; write one"
        raise InvalidProblem.at(where, f"{text}{f'; {others}' if others else ''}")
    header, *body = filled[place:]
    names = _headers(rows.cells[header], 1 + header, where)  # rows are numbered from 1
    units: dict[str, str] = {}
    below_header = rows.cells[body[0]][: len(names)]
    if len(body) > 1 and _are_units(below_header):
        del body[0]
        units = {
            name: _text(unit).strip("[]() ")
            for name, unit in zip(names, below_header, strict=False)
        }
    for k in body:
        row = rows.cells[k]
        # cells without a header may only be empty
        if len(row) != len(names) and (len(row) < len(names) or any(map(_text, row[len(names) :]))):
            _reject_length(rows, k, header, len(names), where)
    # longer rows end with empty cells
    transposed = zip(*(rows.cells[k] for k in body), strict=False)
    columns: dict[str, ColumnCells] = {
        name: list(cells) for name, cells in zip(names, transposed, strict=False) if name
    }
    numbers = [1 + k for k in body]
    # a row with several cells and a number may be one of another table
    skipped = [1 + k for k in filled[:place] if _is_row_of_table(rows.cells[k])]
    remarks: tuple[str, ...] = ()
    if skipped:
        text = f"rows {skipped[0]} to {skipped[-1]} above the header in row {1 + header} are"
        remarks = (f"{text} not read",)
    return Sheet(
        where,
        columns,
        numbers,
        units,
        separator=rows.separator,
        header=1 + header,
        others=others,
        remarks=remarks,
    )


def _reject_length(rows: Rows, row: int, header: int, expected: int, where: str) -> None:
    """Raise the error for a row that is longer or shorter than the header.

    Parameters
    ----------
    rows : Rows
    row, header : int
        Indices of the rows.
    expected : int
        Number of the headers.
    where : str
    """
    count = len(rows.cells[row])
    text = f"row {1 + row} has {count} cells, the header in row {1 + header} has {expected}"
    remedy = "delete or complete this row"
    if count > expected and rows.separator == ",":
        remedy = "if the commas are decimal signs, write semicolons between the cells"
    raise InvalidProblem.at(where, f"{text}; {remedy}")


def _position_of_header(
    rows: Rows, filled: Sequence[int], is_known: IsKnown, where: str
) -> int | None:
    """Return the position in ``filled`` of the row with the headers; None if there is none.

    The first rows are searched for a header with known names, and then all rows for any header.

    Raises
    ------
    InvalidProblem
        If two rows have the same headers: there are two tables.
    """
    place, is_known_place = _header_among([rows.cells[k] for k in filled[:SCANNED]], is_known)
    if not is_known_place and len(filled) > SCANNED:
        place, _ = _header_among([rows.cells[k] for k in filled], is_known)
    if place is None:
        return None
    header = [_text(cell) for cell in rows.cells[filled[place]]]
    for other, k in enumerate(filled[:SCANNED]):
        same = other != place and rows.cells[k][0] == rows.cells[filled[place]][0]
        if same and [_text(cell) for cell in rows.cells[k]] == header and not _are_units(header):
            first, second = sorted((1 + k, 1 + filled[place]))
            text = f"rows {first} and {second} have the same headers; save each table as a file"
            raise InvalidProblem.at(where, text)
    return place


class _Candidate(NamedTuple):
    """A row that may be the header; the largest candidate is, by its first items that differ.

    Attributes
    ----------
    has_known_name : bool
    length : int
        Number of rows below it up to the next row without numbers.
    known : int
        Number of its cells that are known names.
    is_no_row_of_units : bool
    place : int
        Position of the row.
    """

    has_known_name: bool
    length: int
    known: int
    is_no_row_of_units: bool
    place: int


def _header_among(cells: Sequence[Sequence[Any]], is_known: IsKnown) -> tuple[int | None, bool]:
    """Return the position of the row with the headers, and whether it has a known name.

    Parameters
    ----------
    cells : sequence of rows
        Rows that are not blank.
    is_known : callable
        Whether a text is a known name.
    """
    has_number = np.fromiter((any(map(_is_number, row)) for row in cells), bool, len(cells))
    if not has_number.any():
        return _header_without_numbers(cells, is_known)
    without = np.flatnonzero(~has_number)  # positions of the rows without numbers
    best: _Candidate | None = None
    examined = 0
    for place in without.tolist():
        below = has_number[place + 1 : place + 1 + MAX_BELOW]
        if examined == MAX_CANDIDATES:
            break
        if not below.any():
            continue
        first = place + 1 + int(np.argmax(below))  # the first row with numbers
        texts = [text for cell in cells[place] if (text := _text(cell))]
        if 2 * len(texts) < np.count_nonzero([_text(cell) for cell in cells[first]]):
            continue  # a title, which has fewer cells than the rows below it
        examined += 1
        end = np.searchsorted(without, first)
        length = int((without[end] if end < without.size else len(cells)) - first)
        units = _are_units(cells[place])
        known = 0 if units else sum(map(is_known, texts))
        candidate = _Candidate(known > 0, length, known, not units, place)
        best = candidate if best is None else max(best, candidate)
    return (None, False) if best is None else (best.place, best.has_known_name)


def _header_without_numbers(
    cells: Sequence[Sequence[Any]], is_known: IsKnown
) -> tuple[int | None, bool]:
    """Return the position of the header among rows that have no numbers, and whether it is known.

    It is the first row with a known name, otherwise the first one that is not a title: a title is
    the only filled cell of its row.
    """
    for place, row in enumerate(cells[:MAX_CANDIDATES]):
        if any(is_known(text) for cell in row if (text := _text(cell))):
            return place, True
    several = (place for place, row in enumerate(cells) if sum(map(bool, map(_text, row))) > 1)
    return next(several, 0 if cells else None), False


def _text(cell: Any) -> str:
    """Return the text of a cell without spaces around it."""
    return str(cell).strip()


def _is_number(cell: Any) -> bool:
    """Return True for a number of any locale, with or without a unit."""
    if not isinstance(cell, str):
        return isinstance(cell, int | float) and not isinstance(cell, bool)
    return len(cell) <= MAX_HEADER and is_number(cell.strip())


def _is_row_of_table(cells: Sequence[Any]) -> bool:
    """Return True for a row with a number and another cell."""
    return any(map(_is_number, cells)) and sum(map(bool, map(_text, cells))) > 1


def _headers(cells: Sequence[Any], row: int, where: str) -> list[str]:
    """Return the headers of all columns, '' for none, up to the last; reject equal ones."""
    names = [" ".join(str(cell).split()) for cell in cells]
    while not names[-1]:
        names.pop()
    for k, name in enumerate(names):
        _check_header(name, k + 1, where, row)
        if name and name in names[:k]:
            text = f"row {row}: two columns have the same header {name!r}"
            raise InvalidProblem.at(where, text)
    return names


def _check_header(header: str, column: int, where: str, row: int = 0) -> None:
    """Reject a header that is too long, or a column beyond the maximum number."""
    check_column(column, where, row)
    if len(header) > MAX_HEADER:
        place = f"row {row}, column {column}" if row else f"column {column}"
        text = f"the header has {len(header)} characters; must be at most {MAX_HEADER}"
        raise InvalidProblem.at(where, f"{place}: {text}")


def _are_units(cells: Sequence[Any]) -> bool:
    """Return True for a row of units: no number, and units in most cells, or brackets in all.

    Units that are not known matter only in columns that are used.  "-" stands for no unit.
    """
    texts = [text for cell in cells if (text := _text(cell)) and text != "-"]
    if not texts or any(len(text) > MAX_UNIT or _is_number(text) for text in texts):
        return False
    units = sum(is_unit(text.strip("[]() ")) for text in texts)
    in_brackets = all(text[0] + text[-1] in ("[]", "()") for text in texts)
    return 2 * units > len(texts) or (in_brackets and units > 0)
