"""Interpret the headers of a table: names of fields and outputs, with their units.

    nip_load [kN/m]    Nip load (kN/m)    nip load, kN/m    NIP LOAD kN/m    P [kN/m]

are all the input ``nip_load``, as are "Linienlast [kN/m]" and other words of four languages
(:mod:`.words`).  "+-" (or "±") after the name of an output denotes its standard
deviations.  All errors of the headers are reported together; :mod:`.cells` reads the cells.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from typing import NamedTuple

from ..arguments import check_arguments
from ..errors import InvalidProblem, mapping_of, nearest, one_of
from ..problems.units import is_unit
from ..quantities import Quantity, pattern
from .sheets import Sheet, TableSource, find_table
from .table_files import ColumnCells
from .words import names_of_word

__all__ = ["Column", "Names", "find_columns", "is_known_header", "match_columns", "missing_column"]

Faults = list[tuple[str, str]]
Renaming = dict[str, tuple[str, str | None]]  # normalised header -> header as requested, its target

NO_UNIT = ("1", "-", "\N{EN DASH}")  # in headers of columns of pure numbers
MAX_SUGGESTED = 4  # names
MAX_REPORTED = 6  # columns with errors
MIN_WORD = 3  # characters of a word by which a name is suggested
_BETWEEN = re.compile(r"[\s_.\-]+")
_BRACKETS = re.compile(r"(.*?)[\s,/]*[\[(]\s*([^\[\]()]*)\s*[\])]")
_SEPARATOR = re.compile(r"\s*,\s*|\s+/\s+|\s+in\s+|[\s_]+")
_DEVIATION = re.compile(r"\s*(?:\+/?-|\N{PLUS-MINUS SIGN})\s*")

OTHERS = "*"  # in place of the header: all columns without a known name
_HELP = (
    "to name a column write --column {0}, and to ignore it --column {1}, or --column '*=' for all "
    "columns without a known name (in Python columns={{{2!r}: ..., '*': None}}, in a study file "
    "[columns])"
)


def _help(header: str) -> str:
    """Return the text on the assignment of a column with an unknown name."""
    assigned = shlex.quote(f"{header}=NAME [UNIT]")
    return _HELP.format(assigned, shlex.quote(f"{header}="), header)


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
            if quantity is not None and not name.startswith("errors."):  # shares its value's symbol
                self._by_symbol.setdefault(quantity.symbol, []).append(name)

    def find(self, text: str) -> list[str]:
        """Return the names that a text may denote, ignoring case, spaces and underscores.

        Symbols are recognised too, if they are spelled exactly, and words of several languages.
        """
        # numbers in the text say which items of a list are meant: they replace the stars of a name
        # in order; a star without a number denotes the first item
        numbers = iter(part for part in _BETWEEN.split(text) if part.isdigit())
        names = (
            self._by_key.get(_normalise(text))
            or self._by_symbol.get(text.strip(), [])
            or names_of_word(text, self.known)
        )
        return [re.sub(r"\*", lambda _: next(numbers, "0"), name) for name in names]

    def quantity(self, name: str) -> Quantity | None:
        """Return the quantity of a name, whose items may be numbered; None if it is no number."""
        return self.known[pattern(name)]

    def suggestions(self, text: str) -> list[str]:
        """Return the names that an unknown header may mean, the shortest first.

        These have all words of the text, or their beginnings ("Dia"), or another form of this name
        ("Basis weight"); otherwise the most similar name.

        >>> from woundon.quantities import velocity
        >>> Names({"web_speed": velocity("")}).suggestions("Speed")
        ['web_speed']
        """
        words = [word.casefold() for word in _BETWEEN.split(text) if len(word) >= MIN_WORD]

        def has_words(name: str) -> bool:
            parts = _BETWEEN.split(name)
            return all(any(part.startswith(word) for part in parts) for word in words)

        known = {name: q for name, q in self.known.items() if not name.startswith("errors.")}
        similar = [name for name in known if has_words(name)]
        # "drum" suffices, without "drum.radius"
        similar = [name for name in similar if name.rpartition(".")[0] not in similar]
        similar += [
            f"{name} [gsm]"
            for name, q in known.items()
            if q is not None and q.other_form == "basis weight" and has_words(q.other_form)
        ]
        if words and similar:
            return sorted(similar, key=lambda name: (name.count("."), len(name)))[:MAX_SUGGESTED]
        most_similar = nearest("_".join(_BETWEEN.split(text)), self.known)
        return [most_similar] if most_similar else []


def _normalise(text: str) -> str:
    """Return a text without case, spaces and underscores, and with * for numbers."""
    parts = _BETWEEN.split(text.strip())
    return "".join("*" if part.isdigit() else part.casefold() for part in parts)


class Column(NamedTuple):
    """A column with a known name.

    Attributes
    ----------
    header, name : str
        As in the table, and the name that it denotes.
    unit : str
        Empty if there is none, as for pure numbers.
    deviation : bool
        Whether it has the standard deviations of an output.
    cells : list or (rows,) array
    """

    header: str
    name: str
    unit: str
    deviation: bool
    cells: ColumnCells


# ---- headers ------------------------------------------------------------------------------------


def is_known_header(
    names: Names, columns: Mapping[str, str | None] | None = None
) -> Callable[[str], bool]:
    """Return a function that tells whether a header denotes one of the names, or is assigned.

    A word behind the name that is no unit makes a title of the header: "nip load test 3".

    Parameters
    ----------
    names, columns
        As of :func:`match_columns`.

    Examples
    --------
    >>> from woundon.quantities import length
    >>> is_known = is_known_header(Names({"nip_width": length("b", "nip width")}))
    >>> is_known("Nip width [mm]"), is_known("nip width test 3"), is_known("mm")
    (True, False, False)
    """
    check_arguments(columns=columns)
    assigned = {_normalise(header) for header in columns or {} if header != OTHERS}

    @cache
    def is_known(header: str) -> bool:
        if assigned and any(_normalise(name) in assigned for name, _ in _splits(header)):
            return True
        try:
            interpreted = _interpret_header(header, names)
        except InvalidProblem:  # the name of several quantities
            return True
        return interpreted is not None and (
            not interpreted[1] or interpreted[1] in NO_UNIT or is_unit(interpreted[1])
        )

    return is_known


def find_columns(
    data: TableSource,
    what: str,
    names: Names,
    columns: Mapping[str, str | None] | None = None,
    sheet: str = "",
) -> tuple[Sheet, list[Column]]:
    """Read a table; return it with its columns of known names, without standard deviations.

    Parameters
    ----------
    data, sheet
        As of :func:`~.sheets.find_table`.
    what : str
        Name of columns in memory in error messages.
    names, columns
        As of :func:`match_columns`; columns without a known name are ignored.
    """
    table = find_table(data, what, is_known_header(names, columns), sheet)
    matched = match_columns(table, names, {**(columns or {}), OTHERS: None})
    return table, [column for column in matched if not column.deviation]


def missing_column(table: Sheet, needed: str, remedy: str = "") -> InvalidProblem:
    """Return the error for a table without a column that is needed; it lists those that it has.

    Parameters
    ----------
    table : Sheet
    needed : str
        Names of the columns, in words.
    remedy : str
        Advice at the end of the message.
    """
    text = f"has no column {needed}; its columns are {table.headers}"
    return InvalidProblem.at(table.where, f"{text}; {remedy}" if remedy else text)


def match_columns(
    sheet: Sheet,
    names: Names,
    columns: Mapping[str, str | None] | None = None,
    *,
    help_text: str = "",
) -> list[Column]:
    """Return the columns of a sheet with the names that their headers denote.

    Parameters
    ----------
    sheet : Sheet
    names : Names
    columns : mapping
        Header, with or without its unit -> name, with or without a unit; None or an empty name
        omits the column, and that of ``"*"`` all columns without a known name.
    help_text : str
        What is said about columns with an unknown name; by default how they are assigned.

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
    check_arguments(columns=columns)
    renaming = _renaming_of(columns or {})
    ignores_others = renaming.pop(OTHERS, None) is not None
    faults: Faults = []
    matched: list[Column] = []
    unknown: list[str] = []
    for header, cells in sheet.columns.items():
        target, unit = _rename_header(header, renaming)
        if target is None:
            continue
        try:
            interpreted = _interpret_header(target, names)
        except InvalidProblem as fault:
            faults.append((sheet.where, f"column {header!r}: {fault}"))
            continue
        if interpreted is not None:
            name, explicit, deviation = interpreted
            # a unit that the user assigns precedes that of the header, then that of the row below
            unit = explicit or unit or sheet.units.get(header, "")
            unit = "" if unit in NO_UNIT else unit
            matched.append(Column(header, name, unit, deviation, cells))
        elif not (ignores_others and target == header):
            faults.append((sheet.where, f"column {header!r}: {_unknown(target, names)}"))
            unknown.append(header)
    if unknown:
        faults = [*faults[:MAX_REPORTED], *_further(len(faults) - MAX_REPORTED, sheet.where)]
        faults.append((sheet.where, help_text or _help(unknown[0])))
        if sheet.origin:
            faults.append((sheet.where, sheet.origin))
    # entries that were used have been removed
    faults += [(sheet.where, f"has no column {header!r}") for header, _ in renaming.values()]
    faults += _duplicate_columns(matched, sheet.where)
    if faults:
        raise InvalidProblem(faults)
    return matched


def _renaming_of(columns: Mapping[str, str | None]) -> Renaming:
    """Return the assigned headers and their targets, by the normalised header.

    Raises
    ------
    InvalidProblem
        For a target of ``"*"``, and two spellings of one header.
    """
    if columns.get(OTHERS):
        text = f"{OTHERS!r} stands for all columns without a known name; they can only be ignored"
        raise InvalidProblem.at("columns", text)
    return mapping_of(((_normalise(header), (header, to)) for header, to in columns.items()))


def _further(count: int, where: str) -> Faults:
    """Return the line that states the number of errors that are not listed, if there are any."""
    return [(where, f"{count} more errors")] if count > 0 else []


class _Renamed(NamedTuple):
    """A header after renaming.

    Attributes
    ----------
    target : str or None
        The name that replaces the header, with or without a unit; None omits the column.
    unit : str
        The unit in a header that was replaced; empty without one.
    """

    target: str | None
    unit: str


def _rename_header(header: str, renaming: Renaming) -> _Renamed:
    """Return the name that replaces a header; the header itself if none does.

    An entry that is used is removed from ``renaming``.
    """
    for name, rest in _splits(header):
        if _normalise(name) not in renaming:
            continue
        _, target = renaming.pop(_normalise(name))
        # The rest is no unit if the name contains the unit, or further words precede it: then take
        # the first end of the header that is a unit.
        ends = [rest, *(end for _, end in _splits(header))]
        unit = next((end for end in ends if is_unit(end)), rest)
        return _Renamed(target or None, unit)
    return _Renamed(header, "")


def _interpret_header(text: str, names: Names) -> tuple[str, str, bool] | None:
    """Return the name, the unit, and True for standard deviations; None if the name is unknown.

    Raises
    ------
    InvalidProblem
        If it is the name of several quantities.
    """
    for deviation, header in ((False, text), (True, _DEVIATION.sub(" ", text).strip())):
        if deviation and header == text:  # the text has no "+-"
            break
        for name, unit in _splits(header):
            matches = [] if _DEVIATION.search(unit) else names.find(name)
            if matches and unit and not is_unit(unit) and names.quantity(matches[0]) is None:
                continue  # "web tenson" is not the field web
            if len(matches) > 1:
                raise InvalidProblem(f"is ambiguous: {one_of(matches)}")
            if matches:
                return matches[0], _without_symbol(unit, names.quantity(matches[0])), deviation
    return None


def _unknown(text: str, names: Names) -> str:
    """Return the error for an unknown header, with the names that it may mean."""
    name = next((name for name, unit in _splits(text) if is_unit(unit)), text)
    list_name, _, item = name.strip().rpartition(".")
    if item.isdigit() and names.find(list_name):
        text = f"one number of the list {list_name}, which no column can be; write the numbers"
        return f"{text} under [over] of a study file (in Python over={{{name.strip()!r}: [...]}})"
    suggested = [repr(name) for name in names.suggestions(_DEVIATION.sub("", name))]
    return f"no field or output{f'; did you mean {one_of(suggested)}?' if suggested else ''}"


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
    meanings = [(column.name, column.deviation) for column in columns]
    return [
        (where, f"two columns are {name}{' +-' if deviation else ''}")
        for name, deviation in dict.fromkeys(meanings)
        if meanings.count((name, deviation)) > 1
    ]
