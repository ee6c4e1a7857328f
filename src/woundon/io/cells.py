"""Read the cells of the columns of a table: numbers in SI, or texts with units.

A cell is a number in the unit of its column, or a number with its own unit, with a decimal point or
comma.  Totals, stresses and basis weights are converted with the width, thickness and density of
their row.  All errors are reported together, by row and column.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from datetime import date, time
from fractions import Fraction
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from pydantic import BaseModel

from ..errors import InvalidProblem
from ..problems.inputs import Inputs, other_units, read_number
from ..problems.messages import quote
from ..problems.units import factor, has_dimension, is_unit, parse
from ..quantities import Quantity
from .sheets import Sheet
from .spreadsheets import Percentage, Thousands
from .table_files import ColumnCells
from .tables import Column, Names

__all__ = [
    "MAX_COUNTED",
    "Conversion",
    "Fault",
    "as_plain_number",
    "decimal_sign",
    "numbers",
    "numbers_by_name",
    "raise_faults",
    "texts",
]

Array = np.ndarray

MAX_REPORTED = 9  # errors of a table
MAX_COUNTED = 1000  # errors of a table
MAX_NUMBER = 60  # characters, with the unit
LONG = 2000  # rows above which columns of plain numbers are converted as arrays
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?")  # with a decimal point
# numbers of text files that a spreadsheet holds exactly: whole ones, and decimal ones
_WHOLE = re.compile(r"[+-]?(?:0|[1-9]\d{0,14})")
_DECIMAL = re.compile(r"[+-]?(?=\.?\d)(?:0|[1-9]\d{0,14})?(?:\.\d*)?(?:[eE][+-]?\d{1,2})?")
# numbers with commas, and those whose commas may separate thousands, with or without a unit
_COMMA = re.compile(r"[+-]?\d*,[\d,]+(?:[eE][+-]?\d{1,3})?\D*")
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+\D*")


# Texts of plain numbers, one in a line, by decimal sign; "nan" of an empty cell.
_PLAIN = {sign: re.compile(rf"[\d\n\r {sign}eEna+-]*") for sign in ".,"}


class Fault(NamedTuple):
    """An error of a table: where it is, its text, and its row; row 0 is the header."""

    where: str
    text: str
    row: int = 0


class Conversion(NamedTuple):
    """Values with which totals, stresses and basis weights are converted.

    Attributes
    ----------
    inputs : Inputs
        Values of the case; a column replaces its value in each row.
    helpers : mapping of str to Quantity
        Columns that convert others and are no fields, such as the density of a web.
    """

    inputs: Inputs = Inputs(BaseModel, {})
    helpers: Mapping[str, Quantity] = MappingProxyType({})


def numbers(
    sheet: Sheet,
    columns: Sequence[Column],
    names: Names,
    faults: list[Fault],
    *,
    gaps: Callable[[Column], bool],
    conversion: Conversion = Conversion(),  # noqa: B008
    most_faults: float = MAX_COUNTED,
) -> list[Array]:
    """Return columns in SI, a (rows,) array each; invalid cells are nan and added to ``faults``.

    Parameters
    ----------
    sheet, columns : Sheet, sequence of Column
    names : Names
        Gives the quantities of the columns.
    faults : list of Fault
        Errors are appended.
    gaps : callable
        Whether cells of a column may be empty, or nan.
    conversion : Conversion
    most_faults : float
        Number of errors after which reading stops.
    """
    sign, count = decimal_sign(sheet), len(sheet.numbers)
    values = np.full((len(columns), count), np.nan)
    web_columns = [column for column in columns if _web_value(column)]
    # 1.0 stands for the values of the rows: whether a conversion is possible depends on names only
    possible = _with_columns(conversion.inputs, {_web_value(column): 1.0 for column in web_columns})
    readers: dict[int, _Reader] = {}  # of the columns without an error in the header
    for k, column in enumerate(columns):
        try:
            quantity = _number_of(column, names)
            scale = _scale(column, quantity, possible, sheet.in_si, exact=count <= LONG)
            readers[k] = _Reader(column.unit, scale, quantity, sign)
        except InvalidProblem as fault:
            faults.append(_column_fault(sheet, column, fault))
    # in a long table, columns of plain numbers are converted as a whole, without the loop over rows
    for k, reader in list(readers.items()):
        plain = reader.plain_numbers(columns[k].cells, gaps(columns[k])) if count > LONG else None
        if plain is not None and columns[k] not in web_columns:
            values[k] = plain
            del readers[k]
    for row in range(count if readers else 0):
        inputs = _inputs_of_row(conversion.inputs, web_columns, row, sign)
        for k, reader in readers.items():
            cell = columns[k].cells[row]
            if gaps(columns[k]) and _is_empty(cell):
                continue
            if len(faults) >= most_faults:
                return list(values)
            try:
                values[k, row] = reader.number(cell, inputs)
            except InvalidProblem as fault:
                faults.append(_cell_fault(sheet, columns[k], row, fault))
    return list(values)


class _Reader(NamedTuple):
    """Converts the cells of a column to SI.

    Attributes
    ----------
    unit : str
        Of cells that are plain numbers.
    scale : Fraction, optional
        Size of the unit in SI; None if it depends on the other values of a row.
    quantity : Quantity
    sign : str
        Decimal sign of texts.
    """

    unit: str
    scale: Fraction | None
    quantity: Quantity
    sign: str

    def plain_numbers(self, cells: ColumnCells, gaps: bool) -> Array | None:
        """Return a column of plain numbers in SI, (rows,); None if a cell is anything else.

        The numbers are rounded twice, by the conversion of the text and of the unit; those of
        :meth:`number` are exact.

        Parameters
        ----------
        cells : list or (rows,) array
        gaps : bool
            Whether cells may be empty; their values are nan.
        """
        if self.scale is None:
            return None
        if isinstance(cells, np.ndarray):
            if cells.dtype.kind not in "iuf":
                return None
            values = cells.astype(float)
        elif set(map(type, cells)) <= {str, int, float}:
            # A search in one long text is faster than one in each cell.  It admits some texts that
            # are no numbers, which float rejects.
            text = "\n".join(cells if set(map(type, cells)) == {str} else map(str, cells))
            if not _PLAIN[self.sign].fullmatch(text):
                return None
            try:
                values = np.array(
                    [float(cell or "nan") for cell in text.replace(self.sign, ".").split("\n")]
                )
            except ValueError:
                return None
        else:
            return None
        is_number = np.isfinite(values) | (gaps & np.isnan(values))
        return values * float(self.scale) if is_number.all() else None

    def number(self, cell: Any, inputs: Inputs) -> float:
        """Return a cell in SI; ``inputs`` are the values of its row.

        Raises
        ------
        InvalidProblem
            Describes the error of the cell, without naming the field.
        """
        text = _plain_text(cell, self.sign)
        try:
            if _NUMBER.fullmatch(text) and self.scale is not None:
                return float(Fraction(text) * self.scale)
            # without a name: errors name the row and the column
            return read_number(_with_unit(text, self.unit), self.quantity, "", inputs)
        except OverflowError:
            raise InvalidProblem(f"{quote(cell)} is not a finite number") from None


def _web_value(column: Column) -> str:
    """Return the name of the value of the web in a column; '' for other columns.

    It is "width", "thickness" or "density": values that convert the cells of other columns.
    """
    name = column.name.removeprefix("web.").removeprefix("web_")
    return name if name in ("width", "thickness", "density") and not column.deviation else ""


def _with_columns(inputs: Inputs, fields: Mapping[str, Any]) -> Inputs:
    """Return the values of the case, those of the names in ``fields`` replaced."""
    return Inputs(inputs.model, fields, inputs)


def _inputs_of_row(inputs: Inputs, columns: Sequence[Column], row: int, sign: str) -> Inputs:
    """Return the values with which the cells of a row are converted.

    They are those of the case, except for the values of the web that the row contains.

    Parameters
    ----------
    inputs : Inputs
        Values of the case.
    columns : sequence of Column
        Those that contain a value of the web.
    row : int
        From 0.
    sign : str
        Decimal sign of texts.
    """
    fields: dict[str, str | float] = {}
    for column in columns:
        with suppress(InvalidProblem):  # it is reported when the cell itself is read
            text = _with_unit(_plain_text(column.cells[row], sign), column.unit)
            fields[_web_value(column)] = float(text) if _NUMBER.fullmatch(text) else text
    return _with_columns(inputs, fields)


def texts(
    sheet: Sheet, columns: Sequence[Column], names: Names, faults: list[Fault]
) -> list[list[str]]:
    """Return columns as a case file holds them: numbers with units as texts, not yet converted.

    Parameters as of :func:`numbers`; no cell may be empty.
    """
    sign = decimal_sign(sheet)
    lists: list[list[str]] = []
    for column in columns:
        lists.append([])
        try:
            quantity = _number_of(column, names)
            _check_unit(column, quantity, assignable=False)
            if column.unit and not _has_unit_of(f"1 {column.unit}", quantity):
                factor(column.unit, quantity.unit, "")  # raises the error
        except InvalidProblem as fault:
            faults.append(_column_fault(sheet, column, fault))
            continue
        for row, cell in enumerate(column.cells):
            if len(faults) >= MAX_COUNTED:
                break
            try:
                text = _plain_text(cell, sign)
                if not _NUMBER.fullmatch(text) and not _has_unit_of(text, quantity):
                    parse(text, quantity.unit, "")  # raises the error
                lists[-1].append(_with_unit(text, column.unit))
            except InvalidProblem as fault:
                faults.append(_cell_fault(sheet, column, row, fault))
    return lists


def _column_fault(sheet: Sheet, column: Column, fault: InvalidProblem) -> Fault:
    """Return the error of a column, at its header."""
    return Fault(sheet.where, f"column {column.header!r}: {fault}")


def _cell_fault(sheet: Sheet, column: Column, row: int, fault: InvalidProblem) -> Fault:
    """Return the error of a cell with its row number in the spreadsheet; ``row`` is from 0."""
    number = sheet.numbers[row]
    return Fault(sheet.where, f"row {number}, column {column.header!r}: {fault}", number)


def _number_of(column: Column, names: Names) -> Quantity:
    """Return the quantity of a column; reject a field that is not a number."""
    quantity = names.quantity(column.name)
    if quantity is None:
        raise InvalidProblem("is not a number, so it cannot be a column here")
    return quantity


def _check_unit(column: Column, quantity: Quantity, *, assignable: bool = True) -> None:
    """Reject a column without a unit, unless it is a pure number or all cells have units.

    ``assignable`` tells whether the user can assign names and units to columns.
    """
    if column.unit or quantity.unit == "1":
        return
    if all(_has_unit(cell) for cell in column.cells if not _is_empty(cell)):
        return
    header = f"{column.name} [{quantity.unit}]"
    in_file = f"has no unit; write it into the header, as in {header!r}"
    if not assignable:
        raise InvalidProblem(f"{in_file}, or into a row below the headers")
    raise InvalidProblem(
        f"{in_file}, into a row below the headers, or into columns, as in "
        f"{{{column.header!r}: {header!r}}} or "
        f"--column {shlex.quote(f'{column.header}={header}')}"
    )


def _has_unit_of(text: str, quantity: Quantity) -> bool:
    """Return True if a number has a unit in which a quantity may be entered."""
    units = (quantity.unit, *other_units(quantity))
    return any(has_dimension(text, unit) for unit in units)


def _scale(
    column: Column, quantity: Quantity, inputs: Inputs, in_si: bool, *, exact: bool
) -> Fraction | None:
    """Return the size in SI of the unit of a column; None if each cell is converted by itself.

    Parameters
    ----------
    column, quantity : Column, Quantity
    inputs : Inputs
        All values that the case or other columns contain.
    in_si : bool
        Whether a column without a unit is in SI.
    exact : bool
        Whether totals, stresses and basis weights are converted cell by cell; otherwise their size
        is that of one unit, unless the values of the web are columns.
    """
    if not column.unit:
        if not in_si:
            _check_unit(column, quantity)
        return Fraction(1)
    one = f"1 {column.unit}"
    # no name of a field is passed: the error names the column
    if not any(has_dimension(one, unit) for unit in other_units(quantity)):
        return factor(column.unit, quantity.unit, "")
    size = read_number(one, quantity, "", inputs)  # is rejected if its conversion is not known
    return None if exact or inputs.fields else Fraction(size)


def _is_empty(cell: Any) -> bool:
    """Return True for an empty cell."""
    if isinstance(cell, int):  # Python limits the digits of the text of one
        return False
    return cell is None or str(cell).strip() in ("", "nan", "<NA>")  # of pandas too


def _has_unit(cell: Any) -> bool:
    """Return True for a text that consists of a number and a unit, or a percentage."""
    if isinstance(cell, Percentage):
        return True
    short = isinstance(cell, str) and len(cell) <= MAX_NUMBER
    number = _NUMBER.match(cell.strip().replace(",", ".")) if short else None
    return number is not None and is_unit(cell.strip()[number.end() :].strip())


def _plain_text(cell: Any, sign: str) -> str:
    """Return a number, with or without a unit, as text with a decimal point.

    Raises
    ------
    InvalidProblem
        For a cell that is empty or is not a number.
    """
    if _is_empty(cell):
        raise InvalidProblem("the cell is empty")
    if isinstance(cell, Thousands):
        limit = "must have a number format without a comma after the last digit"
        reason = f"{cell:g} is displayed in thousands by its number format; {limit}"
        raise InvalidProblem(reason)
    if isinstance(cell, date | time):
        hint = "a unit in a number format needs quotes, as m, h and s are parts of a date"
        raise InvalidProblem(f'{cell} is a date, not a number; {hint}: write 0 "mm"')
    # no float is as large, and Python limits the digits of the text of a whole number
    overflows = isinstance(cell, int) and cell.bit_length() > 1024
    text = "inf" if overflows else str(cell).strip()
    if len(text) > MAX_NUMBER:
        limit = f"must have at most {MAX_NUMBER} characters"
        raise InvalidProblem(f"{quote(cell)} is not a number; {limit}")
    if isinstance(cell, str):
        text = _with_point(text, sign)
    if _NUMBER.fullmatch(text) or _has_unit(text):
        return text
    finite = " finite" if text in ("inf", "-inf") else ""
    raise InvalidProblem(f"{quote(cell)} is not a{finite} number; correct it or delete the row")


def _with_unit(text: str, unit: str) -> str:
    """Return the text of a cell with the unit of its column, unless it has its own."""
    return f"{text} {unit}".strip() if _NUMBER.fullmatch(text) else text


def _with_point(text: str, sign: str) -> str:
    """Return a text with a decimal point in place of ``sign``; reject thousands separators."""
    if sign == "," and _COMMA.fullmatch(text) and text.count(",") == 1:
        return text.replace(",", ".")
    if "," in text:
        hint = "write a decimal point and no thousands separator"
        raise InvalidProblem(f"{text!r} is not a number; {hint}")
    if sign == "," and "." in text:
        reason = f"{text!r} has a point where other cells have decimal commas"
        raise InvalidProblem(f"{reason}; write one decimal sign")
    return text


def decimal_sign(sheet: Sheet) -> str:
    """Return the decimal sign of a table's texts, "." or ",".

    If the separator is a semicolon, a comma is the decimal sign; if it is a comma, it is not.  In
    other tables it is, if a number has a comma that cannot separate thousands: "1,900" is rejected.
    """
    if sheet.separator == ",":
        return "."
    short = (
        cell.strip()
        for cells in sheet.columns.values()
        if not isinstance(cells, np.ndarray)
        for cell in cells
        if isinstance(cell, str) and "," in cell and len(cell) <= MAX_NUMBER
    )
    with_comma = (text for text in short if _COMMA.fullmatch(text))
    has_decimal_comma = any(
        sheet.separator == ";" or not _THOUSANDS.fullmatch(text) for text in with_comma
    )
    return "," if has_decimal_comma else "."


def as_plain_number(cell: Any, sign: str) -> Any:
    """Return a cell of a text file as a number if it is a plain one; other cells unchanged.

    Whole numbers with leading zeros, or more digits than a spreadsheet holds, are identifiers.

    >>> [as_plain_number(cell, ",") for cell in ("-3,5", "12", "007", "2 kN")]
    [-3.5, 12, '007', '2 kN']
    """
    if not isinstance(cell, str) or (sign == "," and "." in cell):
        return cell
    text = cell.strip().replace(sign, ".")
    if _WHOLE.fullmatch(text):
        return int(text)
    return float(text) if _DECIMAL.fullmatch(text) else cell


def numbers_by_name(
    sheet: Sheet,
    columns: Sequence[Column],
    names: Names,
    *,
    gaps: bool,
    conversion: Conversion = Conversion(),  # noqa: B008
) -> dict[str, Array]:
    """Return columns in SI by name, a (rows,) array each, nan where a cell is empty.

    Parameters as of :func:`numbers`; ``gaps`` holds for all columns.

    Raises
    ------
    InvalidProblem
        For invalid cells, and empty ones without ``gaps``.
    """
    faults: list[Fault] = []
    arrays = numbers(sheet, columns, names, faults, gaps=lambda _: gaps, conversion=conversion)
    raise_faults(faults)
    return dict(zip([column.name for column in columns], arrays, strict=True))


def raise_faults(faults: Sequence[Fault]) -> None:
    """Raise InvalidProblem with the first errors of a table, if there are any."""
    if not faults:
        return
    reported = [(fault.where, fault.text) for fault in faults[:MAX_REPORTED]]
    if len(faults) > MAX_REPORTED:
        at_least = "at least " if len(faults) >= MAX_COUNTED else ""  # reading stopped there
        text = f"{at_least}{len(faults) - MAX_REPORTED} more errors"
        reported.append((faults[0].where, text))
    raise InvalidProblem(reported)
