"""Columns of a file in place of lists in a case file: ``csv = "test.csv"`` in a table.

    pressure [kPa], strain [%]
    10,             0.9
    25,             1.6

The names are those of the fields of the table; the file, CSV or Excel, is read like any table
(:mod:`.tables`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from ..errors import InvalidProblem, one_of
from ..problems.messages import quote
from ..problems.paths import counterpart, find_places
from ..quantities import Quantity, is_list, members_of
from .cells import Fault, raise_faults, texts
from .sheets import read_sheet
from .tables import Names, is_known_header, match_columns

__all__ = ["read_columns", "with_columns"]

MAX_ROWS = 100_000


def with_columns(part: Any, folder: Path, problem: Callable[[], type], path: str = "") -> Any:
    """Return the tables of a case with the columns of the files that they name.

    Parameters
    ----------
    part : mapping, list or value
        The tables of a case, or a part of them.
    folder : path
        Folder of files with a relative path.
    problem : callable
        Returns the class of the problem, whose fields the columns are.
    path : str
        Dotted name of the part.

    Raises
    ------
    InvalidProblem
        If a file cannot be read, is not a table, or has a column that the case contains too, that
        is no field of its table, or that has no unit.
    """
    if isinstance(part, list):
        return [with_columns(item, folder, problem, f"{path}.{k}") for k, item in enumerate(part)]
    if not isinstance(part, Mapping):
        return part
    table = {
        # the tables themselves have no name: theirs begin without a dot
        name: with_columns(value, folder, problem, f"{path}.{name}".lstrip("."))
        for name, value in part.items()
        if name != "csv"
    }
    if not isinstance(part.get("csv"), str):
        return table | ({"csv": part["csv"]} if "csv" in part else {})
    file = folder / part["csv"]
    known = _lists(problem(), path, table.get("kind"))
    if not known:
        kind = f" with kind = {quote(table['kind'])}" if "kind" in table else ""
        text = f"is named in [{path}], which has no lists of numbers{kind}"
        raise InvalidProblem.at(str(file), text)
    columns = read_columns(file, known)
    for name in columns.keys() & table.keys():
        raise InvalidProblem.at(str(file), f"has a column {name!r}, which the case contains too")
    return table | columns


def _lists(problem: type, path: str, kind: Any) -> dict[str, Quantity]:
    """Return the quantities of the fields of a table that are lists of numbers.

    Parameters
    ----------
    problem : type
        Class of the problem.
    path : str
        Dotted name of the table.
    kind : str, optional
        Kind of the description in the table, if the table states it.
    """
    known: dict[str, Quantity] = {}
    for place in find_places(problem, path):
        for member in members_of(place.field.annotation):
            if kind is not None and kind != _kind_of(member):
                continue
            fields: Mapping[str, Any] = getattr(member, "model_fields", {})
            lists = [name for name, field in fields.items() if is_list(field.annotation)]
            # a column of diameters may stand for one of radii; None for other names
            diameters = [counterpart(name, "radius") for name in lists]
            for name in filter(None, (*lists, *diameters)):
                for field in find_places(member, name, place.quantity):
                    if field.quantity is not None:
                        known[name] = field.quantity
    return known


def _kind_of(member: Any) -> str | None:
    """Return the kind of a member of a family, such as "cylinder"; None for other descriptions."""
    return str(member.member_name()) if hasattr(member, "member_name") else None


def read_columns(path: Path, known: Mapping[str, Quantity]) -> dict[str, list[str]]:
    """Return the cells of each column by the name of its field, as texts with units.

    Raises
    ------
    InvalidProblem
        For a file that is not a table, an unknown column, and one without a unit.
    """
    names = Names(known)
    sheet = read_sheet(path, "csv", is_known_header(names))
    if len(sheet.numbers) > MAX_ROWS:
        raise InvalidProblem.at(str(path), f"has too many rows; must be at most {MAX_ROWS}")
    columns = match_columns(sheet, names, help_text=f"the columns are {one_of(known, 'and')}")
    for column in columns:
        if column.deviation:
            text = f"column {column.header!r}: standard deviations have no field in a case"
            raise InvalidProblem.at(str(path), text)
    faults: list[Fault] = []
    cells = texts(sheet, columns, names, faults)
    raise_faults(faults)
    return {column.name: list_ for column, list_ in zip(columns, cells, strict=True)}
