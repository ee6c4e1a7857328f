"""Files in place of lists in a case file: ``csv = "test.csv"`` and ``log = "winder.csv"``.

    pressure [kPa], strain [%]
    10,             0.9
    25,             1.6

The names of the columns are those of the fields of the table, for ``log`` that of the field, with
the radius or the diameter; ``columns = {"Header" = "name [unit]"}`` assigns others.  The files are
read like any table (:mod:`.sheets`).  A log is averaged over the radius (:mod:`.logs`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from pydantic.fields import FieldInfo

from ..arguments import whole_number
from ..errors import InputWarning, InvalidProblem, one_of, warn
from ..problems.inputs import Inputs
from ..problems.messages import quote
from ..problems.paths import counterpart, find_places
from ..problems.problem import Problem
from ..problems.schedules import schedule_fields
from ..quantities import Quantity, is_list, members_of
from .case_texts import FILE_KEYS
from .cells import Conversion, Fault, raise_faults, texts
from .compression import read_compression_test, rising_means
from .logs import MOST_BINS, read_binned
from .sheets import read_sheet
from .tables import Names, is_known_header, match_columns

__all__ = ["read_columns", "with_columns"]

MAX_ROWS = 100_000
OF_STUDIES = ("case", "over")  # tables of study files, the values of which are not in files
TEST_ARGUMENTS = ("area", "height", "offset", "preload", "branch")  # of a compression test


def with_columns(
    case: Mapping[str, Any], folder: Path, problem: Callable[[], type[Problem]]
) -> dict[str, Any]:
    """Return the tables of a case with the columns of the files that they name.

    Parameters
    ----------
    case : mapping
    folder : path
        Folder of files with a relative path.
    problem : callable
        Returns the class of the problem, whose fields the columns are.

    Raises
    ------
    InvalidProblem
        If a file cannot be read, is not a table, or has a column that the case contains too, that
        is no field of its table, or that has no unit.
    """
    return dict(_Files(case, folder, problem).replaced(case, ""))


class _Files(NamedTuple):
    """The files of a case; attributes as the parameters of :func:`with_columns`."""

    case: Mapping[str, Any]
    folder: Path
    problem: Callable[[], type[Problem]]

    def replaced(self, part: Any, path: str) -> Any:
        """Return a part of the case, whose dotted name is ``path``, with columns for files.

        Files are replaced in all tables and lists of the part; the name of the case itself is "".
        """
        if isinstance(part, list):
            return [self.replaced(item, f"{path}.{k}") for k, item in enumerate(part)]
        if not isinstance(part, Mapping):
            return part
        # the case itself has fields, but no lists that a file may contain
        keys = [key for key in FILE_KEYS if path and key in part]
        table: dict[str, Any] = {}
        for name, value in part.items():
            if keys and name == "columns":
                table[name] = value  # its names are headers of the file, and may be csv or log
            else:
                # names in the case itself begin without a dot
                table[name] = self.replaced(value, f"{path}.{name}".lstrip("."))
        if len(keys) > 1:
            raise InvalidProblem.at(path, "has csv and log; must have one of them")
        return self._with_file(table, path, keys[0]) if keys else table

    def _with_file(self, table: dict[str, Any], path: str, key: str) -> dict[str, Any]:
        """Return a table with the columns of the file that it names.

        Parameters
        ----------
        table : dict
            Its fields; those about the file are removed.
        path : str
            Dotted name of the table.
        key : "csv" or "log"
            The field that names the file.
        """
        name_of_file = table.pop(key)
        if not isinstance(name_of_file, str) or not name_of_file.strip():
            text = f"{quote(name_of_file)} is out of place; must be the name of a file"
            raise InvalidProblem.at(f"{path}.{key}", text)
        if path.partition(".")[0] in OF_STUDIES:
            text = f"{quote(name_of_file)} is out of place; must be lists of numbers"
            raise InvalidProblem.at(f"{path}.{key}", f"{text}: only a case file names files")
        file = self.folder / name_of_file
        columns = table.pop("columns", None)
        if columns is not None and not isinstance(columns, Mapping):
            must = "must be a table, {'Header' = 'name [unit]'}"
            raise InvalidProblem.at(f"{path}.columns", f"{quote(columns)} is out of place; {must}")
        read = self._log if key == "log" else self._lists
        lists = read(file, path, table, columns)
        for name in lists.keys() & table.keys():
            text = f"has a column {name!r}, which the case contains too"
            raise InvalidProblem.at(str(file), text)
        return table | lists

    def _lists(
        self, file: Path, path: str, table: dict[str, Any], columns: Mapping[str, str] | None
    ) -> dict[str, Any]:
        """Return the lists of a table from the columns of a file, as texts with units.

        A table of pressure and strain may have a compression test, whose lists are numbers in SI.
        """
        known = _quantities_of_lists(self.problem(), path, table.get("kind"))
        if known.keys() >= {"pressure", "strain"}:
            return self._stack_test(file, path, table, columns)
        if not known:
            kind = f" with kind = {quote(table['kind'])}" if "kind" in table else ""
            text = f"is named in [{path}], which has no lists of numbers{kind}"
            raise InvalidProblem.at(str(file), text)
        lists = read_columns(file, known, columns)
        missing = _missing_lists(self.problem(), path, table.get("kind"), {*lists, *table})
        if missing:
            text = f"has no column {one_of(missing, 'and')}, which [{path}] needs"
            raise InvalidProblem.at(str(file), text)
        return lists

    def _stack_test(
        self, file: Path, path: str, table: dict[str, Any], columns: Mapping[str, str] | None
    ) -> dict[str, Any]:
        """Return pressure and strain of a compression test; what was left out is a warning.

        Entries of the table such as area, height and branch are arguments of the reader, and are
        removed from it.
        """
        arguments = {name: table.pop(name) for name in TEST_ARGUMENTS if name in table}
        try:
            test = read_compression_test(file, columns=columns, **arguments)
        except InvalidProblem as fault:
            # errors of the arguments have their names as their field
            raise InvalidProblem(
                (f"{path}.{field}" if field in TEST_ARGUMENTS else field, text)
                for field, text in fault.faults
            ) from None
        # a test of which every row is used needs no warning
        if any(not text.startswith("used: ") for text in test.account):
            warn([f"{test.where}: {text}" for text in test.account], InputWarning)
        pressure, strain = rising_means(*test.used)
        return {"pressure": pressure.tolist(), "strain": strain.tolist()}

    def _log(
        self, file: Path, path: str, table: dict[str, Any], columns: Mapping[str, str] | None
    ) -> dict[str, Any]:
        """Return the profile of a field from the log of a winder; its account is a warning."""
        fields = schedule_fields(self.problem())
        if path not in fields:
            text = f"is named in [{path}]; must be in the table of {one_of(fields)}"
            raise InvalidProblem.at(str(file), text)
        bins = table.pop("bins", None)
        if bins is not None:  # here, so that the error names the table
            bins = whole_number(f"{path}.bins", bins, 2, MOST_BINS)
        log = read_binned(
            file,
            {path: fields[path]},
            columns=columns,
            bins=bins,
            conversion=Conversion(Inputs(self.problem(), self.case)),
        )
        radius, values = log.profile(path)
        remarks = [f"{log.where}: {text}" for text in (log.account(), *log.remarks)]
        warn(remarks, InputWarning)
        return {"radius": radius.tolist(), "value": values.tolist()}


def _quantities_of_lists(problem: type, path: str, kind: Any) -> dict[str, Quantity]:
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
    for member, lists, quantity in _members_with_lists(problem, path, kind):
        # a column of diameters may stand for one of radii; None for other names
        diameters = [counterpart(name, "radius") for name in lists]
        for name in filter(None, (*lists, *diameters)):
            for field in find_places(member, name, quantity):
                if field.quantity is not None:
                    known[name] = field.quantity
    return known


def _missing_lists(problem: type, path: str, kind: Any, given: set[str]) -> list[str]:
    """Return the required lists of a table that are not given; [] if one of its kinds needs none.

    Parameters as of :func:`_quantities_of_lists`; ``given`` are the names in the table and in its
    file.
    """
    of_kinds = [
        [
            name
            for name, field in lists.items()
            if field.is_required() and not given & {name, counterpart(name, "radius")}
        ]
        for _, lists, _ in _members_with_lists(problem, path, kind)
    ]
    return of_kinds[0] if of_kinds and all(of_kinds) else []


def _members_with_lists(
    problem: type, path: str, kind: Any
) -> Iterator[tuple[type, dict[str, FieldInfo], Quantity | None]]:
    """Yield the descriptions that a table may be and that have lists of numbers.

    A table may be one of several descriptions if its field admits them, such as the laws of a
    stack.  With each come its fields that are lists, by name, and the quantity of the field that
    holds the description, which is that of the values of a profile.
    """
    for place in find_places(problem, path):
        for member in members_of(place.field.annotation):
            if kind is not None and kind != _kind_of(member):
                continue
            fields: Mapping[str, FieldInfo] = getattr(member, "model_fields", {})
            lists = {name: field for name, field in fields.items() if is_list(field.annotation)}
            if lists:
                yield member, lists, place.quantity


def _kind_of(member: Any) -> str | None:
    """Return the kind of a member of a family, such as "cylinder"; None for other descriptions."""
    return str(member.member_name()) if hasattr(member, "member_name") else None


def read_columns(
    path: Path, known: Mapping[str, Quantity], columns: Mapping[str, str] | None = None
) -> dict[str, list[str]]:
    """Return the cells of each column by the name of its field, as texts with units.

    Parameters
    ----------
    path : path
    known : mapping of str to Quantity
        Quantities that a column may contain.
    columns : mapping of str to str
        Header -> name, with or without unit; an empty name omits a column.

    Raises
    ------
    InvalidProblem
        For a file that is not a table, an unknown column, and one without a unit.
    """
    names = Names(known)
    sheet = read_sheet(path, "csv", is_known_header(names, columns))
    if len(sheet.numbers) > MAX_ROWS:
        raise InvalidProblem.at(str(path), f"has too many rows; must be at most {MAX_ROWS}")
    help_text = (
        f"the columns are {one_of(known, 'and')}; in a case file columns = {{'Header' = "
        "'name [unit]'} assigns others, and {'*' = ''} ignores them"
    )
    matched = match_columns(sheet, names, columns, help_text=help_text)
    for column in matched:
        if column.deviation:
            text = f"column {column.header!r}: standard deviations have no field in a case"
            raise InvalidProblem.at(str(path), text)
    faults: list[Fault] = []
    cells = texts(sheet, matched, names, faults)
    raise_faults(faults)
    return {column.name: list_ for column, list_ in zip(matched, cells, strict=True)}
