"""Interpret the columns of a table: names of fields and outputs, numbers in SI.

    nip_load [kN/m]    Nip load (kN/m)    nip load, kN/m    NIP LOAD kN/m    P [kN/m]

are all the input ``nip_load``.  "+-" (or "±") after the name of an output denotes its standard
deviations.  All errors of a table, in headers and cells, are reported together.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from types import NoneType
from typing import Any, NamedTuple

import numpy as np

from ..errors import InvalidProblem, nearest, one_of
from ..problems.messages import quote
from ..problems.units import factor, has_dimension, is_unit, parse
from ..quantities import Quantity, pattern
from .sheets import Sheet

__all__ = [
    "Column",
    "Names",
    "as_plain_number",
    "decimal_sign",
    "match_columns",
    "numbers",
    "raise_faults",
]

Array = np.ndarray
Faults = list[tuple[str, str]]

MAX_REPORTED = 10  # errors of a table
MAX_COUNTED = 1000  # errors of a table
MAX_NUMBER = 60  # characters, with the unit
NO_UNIT = ("", "1", "-", "\N{EN DASH}")  # units in headers of dimensionless columns
_BETWEEN = re.compile(r"[\s_.\-]+")
_BRACKETS = re.compile(r"(.*?)[\s,/]*[\[(]\s*([^\[\]()]*)\s*[\])]")
_SEPARATOR = re.compile(r"\s*,\s*|\s+/\s+|\s+in\s+|[\s_]+")
_DEVIATION = re.compile(r"\s*(?:\+/?-|\N{PLUS-MINUS SIGN})\s*")
_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?")
_WHOLE = re.compile(r"[+-]?(?:0|[1-9]\d{0,14})")
_DECIMAL = re.compile(r"[+-]?(?=\.?\d)(?:0|[1-9]\d{0,14})?(?:\.\d*)?(?:[eE][+-]?\d{1,2})?")
_COMMA = re.compile(r"[+-]?\d*,[\d,]+(?:[eE][+-]?\d{1,3})?\D*")
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+\D*")

_HELP = (
    "to name a column write --column '{0}=NAME [UNIT]', and to ignore it --column '{0}=' "
    "(in Python columns={{{0!r}: ...}}, in a study file [columns])"
)


class Names:
    """Names that a column may have, independent of their spelling.

    Parameters
    ----------
    known : mapping of str to Quantity
        Dotted names, ``*`` for the number of an item; None if it is not a number.

    Examples
    --------
    >>> from woundon.quantities import length
    >>> Names({"nip_width": length("b", "nip width")}).find("Nip Width")
    ['nip_width']
    """

    def __init__(self, known: Mapping[str, Quantity | None]) -> None:
        self.known = known
        self._by_key: dict[str, list[str]] = {}
        self._by_symbol: dict[str, list[str]] = {}
        for name, quantity in known.items():
            self._by_key.setdefault(_normalise(name), []).append(name)
            if quantity is not None:
                self._by_symbol.setdefault(quantity.symbol, []).append(name)

    def find(self, text: str) -> list[str]:
        """Return the names that a text may denote, ignoring case, spaces and underscores.

        Symbols are recognised too, if they are spelled exactly.
        """
        numbers = iter(part for part in _BETWEEN.split(text) if part.isdigit())
        names = self._by_key.get(_normalise(text)) or self._by_symbol.get(text.strip(), [])
        return [re.sub(r"\*", lambda _: next(numbers, "0"), name) for name in names]

    def quantity(self, name: str) -> Quantity | None:
        """Return the quantity of a name."""
        return self.known[pattern(name)]

    def nearest(self, text: str) -> str:
        """Return the name that is most similar to a text; '' if none is."""
        return nearest("_".join(_BETWEEN.split(text)), self.known)


def _normalise(text: str) -> str:
    """Return a text without case, spaces and underscores, and with * for numbers."""
    parts = _BETWEEN.split(text.strip())
    return "".join("*" if part.isdigit() else part.casefold() for part in parts)


class Column(NamedTuple):
    """A column with a known name: header, name, unit, and cells."""

    header: str
    name: str
    unit: str
    deviation: bool
    cells: list[Any]


# ---- headers ------------------------------------------------------------------------------------


def match_columns(
    sheet: Sheet, names: Names, columns: Mapping[str, str | None] | None = None
) -> list[Column]:
    """Return the columns of a sheet with the names that their headers denote.

    Parameters
    ----------
    sheet : Sheet
    names : Names
    columns : mapping
        Header, with or without its unit -> name, with or without a unit; None or an empty name
        omits the column.

    Raises
    ------
    InvalidProblem
        Lists all columns with an unknown name, or with the name of another column.

    Examples
    --------
    >>> from woundon.io.sheets import read_sheet
    >>> from woundon.quantities import length
    >>> sheet = read_sheet({"Nip width in mm": [4.0]}, "measured")
    >>> [(c.name, c.unit) for c in match_columns(sheet, Names({"nip_width": length("b", "")}))]
    [('nip_width', 'mm')]
    """
    _check_renaming(columns)
    faults: Faults = []
    matched: list[Column] = []
    unknown: list[str] = []
    renaming = {_normalise(header): (header, target) for header, target in (columns or {}).items()}
    for header, cells in sheet.columns.items():
        target, unit = _rename_header(header, renaming)
        if target is None:
            continue
        try:
            name, explicit, deviation = _interpret_header(target, names)
        except InvalidProblem as fault:
            faults.append((sheet.where, f"column {header!r}: {fault}"))
            unknown.append(header)
            continue
        unit = explicit or unit or sheet.units.get(header, "")
        matched.append(Column(header, name, unit, deviation, cells))
    if unknown:
        faults.append((sheet.where, _HELP.format(unknown[0])))
    faults += [(sheet.where, f"has no column {header!r}") for header, _ in renaming.values()]
    faults += _duplicate_columns(matched, sheet.where)
    if faults:
        raise InvalidProblem(faults)
    return matched


def _check_renaming(columns: Any) -> None:
    """Reject values that are not a mapping of headers to names."""
    if columns is None:
        return
    if not isinstance(columns, Mapping):
        text = f"{quote(columns)} is not a mapping; must be {{header: name or None}}"
        raise InvalidProblem.at("columns", text)
    for header, target in columns.items():
        if not isinstance(header, str) or not isinstance(target, (str, NoneType)):
            text = f"{quote(header)}: {quote(target)}: header and name must be texts"
            raise InvalidProblem.at("columns", text)


def _rename_header(
    header: str, renaming: dict[str, tuple[str, str | None]]
) -> tuple[str | None, str]:
    """Return the name that replaces a header, and its unit; remove it from ``renaming``."""
    for text, unit in _splits(header):
        if _normalise(text) in renaming:
            return renaming.pop(_normalise(text))[1] or None, unit
    return header, ""


def _interpret_header(text: str, names: Names) -> tuple[str, str, bool]:
    """Return the name, the unit, and True for standard deviations.

    Raises
    ------
    InvalidProblem
        If it is not the name of exactly one quantity.
    """
    for deviation, header in ((False, text), (True, _DEVIATION.sub(" ", text).strip())):
        if deviation and header == text:
            break
        for name, unit in _splits(header):
            matches = [] if _DEVIATION.search(unit) else names.find(name)
            if matches and unit and not is_unit(unit) and names.quantity(matches[0]) is None:
                continue  # "web tenson" is not the field web
            if len(matches) > 1:
                raise InvalidProblem(f"is ambiguous: {one_of(matches)}")
            if matches:
                return matches[0], _without_symbol(unit, names.quantity(matches[0])), deviation
    name = next((name for name, unit in _splits(text) if is_unit(unit)), text)
    suggestion = names.nearest(_DEVIATION.sub("", name))
    raise InvalidProblem(
        f"no field or output{f'; did you mean {suggestion!r}?' if suggestion else ''}"
    )


def _without_symbol(unit: str, quantity: Quantity | None) -> str:
    """Return the unit of "nip load P [kN/m]", whose name is followed by its symbol."""
    if quantity is None:
        return unit
    return re.sub(rf"{re.escape(quantity.symbol)}(?![\w/*])[\s,]*", "", unit).strip("[]() ")


def _splits(header: str) -> Iterator[tuple[str, str]]:
    """Yield the ways to split a header into name and unit, the longest name first."""
    yield header, ""
    match = _BRACKETS.fullmatch(header.strip())
    if match:
        yield match[1].strip(), match[2].strip()
    for match in reversed(list(_SEPARATOR.finditer(header))):
        yield header[: match.start()], header[match.end() :]


def _duplicate_columns(columns: list[Column], where: str) -> Faults:
    """Return the error for two columns with the same meaning."""
    kinds = [(column.name, column.deviation) for column in columns]
    return [
        (where, f"two columns are {name}{' +-' * deviation}")
        for name, deviation in dict.fromkeys(kinds)
        if kinds.count((name, deviation)) > 1
    ]


# ---- cells --------------------------------------------------------------------------------------


def numbers(
    sheet: Sheet,
    column: Column,
    quantity: Quantity | None,
    faults: Faults,
    *,
    gaps: bool,
    sign: str,
    width: float | None = None,
) -> Array:
    """Return a column in SI; invalid cells are nan, and are added to ``faults``.

    Parameters
    ----------
    sheet, column : Sheet, Column
    quantity : Quantity
        Quantity of the column; None if it is not a number.
    faults : list of (where, text)
        Errors of the column are appended.
    gaps : bool
        Whether cells may be empty, or nan.
    sign : str
        The table's :func:`decimal_sign`.
    width : float, optional
        Width of the web [m], by which a column of forces is divided if the quantity is a force per
        width.
    """
    values = np.full(len(column.cells), np.nan)
    if quantity is None:
        text = "is not a number, so it cannot be a column here"
        faults.append((sheet.where, f"column {column.header!r}: {text}"))
        return values
    if width and quantity.unit == "N/m" and has_dimension(f"1 {column.unit}", "N"):
        forces = replace(quantity, unit="N")
        return numbers(sheet, column, forces, faults, gaps=gaps, sign=sign) / width
    try:
        scale = _scale(column, quantity, sheet.in_si)
    except InvalidProblem as fault:
        faults.append((sheet.where, f"column {column.header!r}: {fault}"))
        return values
    for row, cell in enumerate(column.cells):
        if len(faults) >= MAX_COUNTED:
            break
        if gaps and _is_empty(cell):
            continue
        try:
            values[row] = _number(cell, scale, quantity.unit, sign)
        except InvalidProblem as fault:
            text = f"row {sheet.numbers[row]}, column {column.header!r}: {fault}"
            faults.append((sheet.where, text))
    return values


def _scale(column: Column, quantity: Quantity, in_si: bool) -> Fraction | None:
    """Return the size of the unit of a column in SI; None if the cells have their own units."""
    if column.unit in NO_UNIT:
        if in_si or quantity.unit == "1":
            return Fraction(1)
        if all(_has_unit(cell) for cell in column.cells if not _is_empty(cell)):
            return None
        header = f"{column.name} [{quantity.unit}]"
        raise InvalidProblem(
            f"has no unit; write it into the header, as in {header!r}, into a row below the "
            f"headers, or into columns, as in {{{column.header!r}: {header!r}}} or "
            f"--column {f'{column.header}={header}'!r}"
        )
    return factor(column.unit, quantity.unit, "")


def _is_empty(cell: Any) -> bool:
    """Return True for an empty cell."""
    if isinstance(cell, int):  # Python limits the digits of the text of one
        return False
    return cell is None or str(cell).strip() in ("", "nan", "<NA>")  # of pandas too


def _has_unit(cell: Any) -> bool:
    """Return True for a text that consists of a number and a unit."""
    short = isinstance(cell, str) and len(cell) <= MAX_NUMBER
    number = _NUMBER.match(cell.strip()) if short else None
    return number is not None and is_unit(cell.strip()[number.end() :].strip())


def _number(cell: Any, scale: Fraction | None, unit: str, sign: str) -> float:
    """Return a cell in SI.

    Raises
    ------
    InvalidProblem
        Describes the error of the cell, without naming the field.
    """
    if _is_empty(cell):
        raise InvalidProblem("the cell is empty")
    overflows = isinstance(cell, int) and cell.bit_length() > 1024
    text = "inf" if overflows else str(cell).strip()
    if len(text) > MAX_NUMBER:
        limit = f"must have at most {MAX_NUMBER} characters"
        raise InvalidProblem(f"{quote(cell)} is not a number; {limit}")
    if isinstance(cell, str):
        text = _with_point(text, sign)
    try:
        if _NUMBER.fullmatch(text) and scale is not None:
            return float(Fraction(text) * scale)
        if _has_unit(text):
            return parse(text, unit)
    except OverflowError:
        text = "inf"
    finite = " finite" if text in ("inf", "-inf") else ""
    raise InvalidProblem(f"{quote(cell)} is not a{finite} number")


def _with_point(text: str, sign: str) -> str:
    """Return a number with a decimal point; reject thousands separators."""
    if sign == "," and _COMMA.fullmatch(text) and text.count(",") == 1:
        return text.replace(",", ".")
    if "," in text:
        hint = "write a decimal point and no thousands separator"
        raise InvalidProblem(f"{text!r} is not a number; {hint}")
    if sign == "," and "." in text:
        raise InvalidProblem(f"{text!r} has a point where other cells have decimal commas")
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
        for cell in cells
        if isinstance(cell, str) and len(cell) <= MAX_NUMBER
    )
    with_comma = [text for text in short if _COMMA.fullmatch(text)]
    decimal_commas = (
        with_comma
        if sheet.separator == ";"
        else [text for text in with_comma if not _THOUSANDS.fullmatch(text)]
    )
    return "," if decimal_commas else "."


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


def raise_faults(faults: Faults) -> None:
    """Raise InvalidProblem with the first errors of a table, if there are any."""
    if not faults:
        return
    at_least = "at least " if len(faults) >= MAX_COUNTED else ""
    remaining = [(faults[0][0], f"{at_least}{len(faults) - MAX_REPORTED} more errors")]
    raise InvalidProblem(faults[:MAX_REPORTED] + remaining * (len(faults) > MAX_REPORTED))
