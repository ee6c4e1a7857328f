"""Read study files: a base case of any kind and what is varied; units as in case files.

Of ``woundon sweep`` they have varied fields and outputs, of ``woundon plan`` unknown fields,
measurements and candidates.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InvalidProblem, did_you_mean
from ..io.case_files import load_case, make_problem, read_case
from ..problems.paths import field_quantity, number_in_si
from ..problems.problem import Problem
from .cases import DESIGNS
from .planned import Measurement

__all__ = [
    "SCHEMA",
    "StudyFile",
    "load_plan",
    "load_study",
    "study_of_tables",
]

SCHEMA = 1
_KNOWN = ("schema", "case", "outputs", "over", "columns", "tie", "design", "solver")
_SPACING = ("linear", "log")


@dataclass(frozen=True)
class StudyFile:
    """The content of a study file, in SI.

    Attributes
    ----------
    problem : Problem
    over : mapping or path
        Field -> values, or range (low, high[, "log"]) of a drawn design; or the table of cases.
    outputs : tuple of str, optional
        None for the main outputs of the kind.
    columns : mapping, optional
        Header in the table -> name; None omits a column.
    tie : mapping
    design : mapping
        Keywords ``design``, ``samples``, ``seed`` of :func:`~woundon.studies.api.sweep`.
    options : mapping
        Keywords of the solver.
    """

    problem: Problem
    over: Mapping[str, Any] | Path
    outputs: tuple[str, ...] | None = None
    columns: Mapping[str, str | None] | None = None
    tie: Mapping[str, str] = field(default_factory=dict)
    design: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def arguments(self) -> dict[str, Any]:
        """Keywords of :func:`~woundon.studies.api.study_of`."""
        others = {name: value for name, value in vars(self).items() if name != "design"}
        return {**others, **self.design}


def load_study(path: str | Path, *, ranges: bool = False) -> StudyFile:
    """Return the study that a file describes.

    Parameters
    ----------
    path : path
    ranges : bool
        Read every entry of [over] as a range, as for the global sensitivity.

    Raises
    ------
    InvalidProblem
        For a file that cannot be read, or invalid fields, values or units.
    """
    path = Path(path)
    return study_of_tables(read_case(path), path.parent, ranges=ranges)


def study_of_tables(
    content: Mapping[str, Any], folder: Path | None, *, ranges: bool = False
) -> StudyFile:
    """Return the study that the tables of a file describe; without ``folder`` they name no files.

    Raises
    ------
    InvalidProblem
        As of :func:`load_study`.
    """
    _check_tables(content, _KNOWN)
    problem = _base_case(content.get("case"), folder)
    design = _design(_table_of(content, "design"))
    is_drawn = ranges or design.get("design", "grid") not in ("grid", "table")
    over: Mapping[str, Any] | Path
    if isinstance(content.get("over"), str) and not is_drawn and folder is not None:
        over = folder / content["over"]
    else:
        over = {
            name: _values(problem, name, entry, is_drawn)
            for name, entry in _flat_names(_table_of(content, "over")).items()
        }
    return StudyFile(
        problem=problem,
        over=over,
        outputs=_outputs(content.get("outputs")),
        columns=_columns(content),
        tie=_table_of(content, "tie"),
        design=design,
        options=_table_of(content, "solver"),
    )


def _columns(content: Mapping[str, Any]) -> dict[str, str | None] | None:
    """Return the names of the columns of the table of cases; an empty name omits one."""
    if "columns" not in content:
        return None
    columns = _table_of(content, "columns")
    if not isinstance(content.get("over"), str):
        raise InvalidProblem.at("columns", "there is no table; write over = 'FILE'")
    for header, name in columns.items():
        if not isinstance(name, str):
            raise InvalidProblem.at(f"columns.{header}", f"{name!r} is not a name, as text")
    return {header: name or None for header, name in columns.items()}


def _base_case(case: Any, folder: Path | None) -> Problem:
    """Return the base case: the path of a case file, or the case as a table."""
    if isinstance(case, str) and folder is not None:
        return load_case(folder / case)
    if isinstance(case, Mapping):
        return make_problem(case)
    raise InvalidProblem.at("case", "missing; give the path of a case file, or the case as [case]")


def _check_tables(content: Mapping[str, Any], known: Sequence[str]) -> None:
    """Reject a study file with unknown tables, or of another schema."""
    _check_names(content, known)
    if content.get("schema") != SCHEMA:
        raise InvalidProblem.at("schema", f"write 'schema = {SCHEMA}' at the top of the file")


def _check_names(table: Mapping[str, Any], known: Sequence[str], prefix: str = "") -> None:
    """Reject unknown names in a table of a study file."""
    for name in table:
        if name not in known:
            raise InvalidProblem.at(f"{prefix}{name}", f"no such field{did_you_mean(name, known)}")


def _table_of(content: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Return a table of a file, empty if it is missing."""
    table = content.get(name, {})
    if not isinstance(table, Mapping):
        raise InvalidProblem.at(name, f"{table!r} is not a table; write it under [{name}]")
    return dict(table)


def _outputs(outputs: Any) -> tuple[str, ...] | None:
    """Return the names of outputs in a study file as a tuple; None if there are none."""
    if outputs is None:
        return None
    names = [outputs] if isinstance(outputs, str) else outputs
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise InvalidProblem.at("outputs", f"{outputs!r} is not a list of names")
    return tuple(names)


def _design(table: dict[str, Any]) -> dict[str, Any]:
    """Return the design of a study file as keyword arguments of a sweep."""
    _check_names(table, ("kind", "samples", "seed"), "design.")
    kind = table.pop("kind", "grid")
    if kind not in DESIGNS:
        text = f"{kind!r} is unknown{did_you_mean(kind, DESIGNS)}"
        raise InvalidProblem.at("design.kind", text)
    return {"design": kind, **table}


def _flat_names(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return a table with dotted names instead of nested tables; ranges { from, to } stay tables.

    >>> _flat_names({"web": {"thickness": [1.0]}})
    {'web.thickness': [1.0]}
    """
    flat: dict[str, Any] = {}
    for name, value in table.items():
        if isinstance(value, Mapping) and not {"from", "to"} & set(value):
            flat |= _flat_names(value, f"{prefix}{name}.")
        else:
            flat[f"{prefix}{name}"] = value
    return flat


def _values(problem: Problem, name: str, entry: Any, is_drawn: bool) -> Any:
    """Return an entry of [over] in SI: a list of values, or a range to draw from."""
    quantity = field_quantity(problem, name)
    unit = "" if quantity is None else quantity.unit  # "1" of a pure number, "" of other fields
    where, number = f"over.{name}", partial(_finite, problem, name)
    if isinstance(entry, Mapping):
        if not unit:
            text = "is not a number, so it has no range; write a list of values"
            raise InvalidProblem.at(where, text)
        return _spread(entry, number, where, is_drawn)
    if not isinstance(entry, list) or is_drawn:
        expected = "{ from = ..., to = ... }" if is_drawn else "a list, or { from, to, count }"
        raise InvalidProblem.at(where, f"{entry!r} is not a set of values; write {expected}")
    return [number(v, where) if unit else v for v in entry]


def _finite(problem: Problem, name: str, value: Any, where: str) -> float:
    """Return a finite number of a study file in SI."""
    number = float(number_in_si(problem, name, value, where))
    if not np.isfinite(number):
        raise InvalidProblem.at(where, f"{value!r} is not a finite number")
    return number


def _spread(
    entry: Mapping[str, Any], number: Callable[[Any, str], float], where: str, is_drawn: bool
) -> Any:
    """Return a range: a grid of ``count`` values, or (low, high[, "log"]) to draw samples from.

    Parameters
    ----------
    entry : mapping
        With ``from``, ``to``, ``spacing`` and, unless samples are drawn, ``count``.
    number : callable
        (value, name in error messages) -> finite number in SI.
    where : str
        Name of the entry in error messages.
    is_drawn : bool
        Whether samples are drawn from the range.
    """
    known = ("from", "to", "spacing", *(() if is_drawn else ("count",)))
    _check_names(entry, known, f"{where}.")
    for name in set(known) - {"spacing"}:
        if name not in entry:
            raise InvalidProblem.at(f"{where}.{name}", "missing")
    low, high = (number(entry[end], f"{where}.{end}") for end in ("from", "to"))
    spacing = entry.get("spacing", "linear")
    if spacing not in _SPACING:
        text = f"{spacing!r} is unknown; must be linear or log"
        raise InvalidProblem.at(f"{where}.spacing", text)
    if is_drawn:
        return (low, high, "log") if spacing == "log" else (low, high)
    count = entry["count"]
    if isinstance(count, bool) or not isinstance(count, int) or not 2 <= count <= 1_000_000:
        raise InvalidProblem.at(f"{where}.count", f"{count!r} is not a whole number, 2 to 1000000")
    if spacing == "linear":
        return np.linspace(low, high, count)
    if low <= 0 or high <= 0:
        raise InvalidProblem.at(where, "a logarithmic range must lie above 0")
    return np.geomspace(low, high, count)


# ---- plans of measurements ---------------------------------------------------------------------

_BY_FIELD = ("unknown", "tie", "operating_point")  # tables of values by names of fields
_KNOWN_IN_PLAN = ("schema", "case", "candidate", "completed", "plan", "solver", *_BY_FIELD)
_PLAN = ("count", "criterion", "output", "draws", "seed")
_MEASUREMENT = ("case", *(field.name for field in fields(Measurement) if field.name != "problem"))


def load_plan(path: str | Path) -> dict[str, Any]:
    """Return the keywords of :func:`~woundon.studies.plan.next_experiment` in a study file.

    Raises
    ------
    InvalidProblem
        For a file that cannot be read, or invalid fields.
    """
    path = Path(path)
    content = read_case(path)
    _check_tables(content, _KNOWN_IN_PLAN)
    settings = _table_of(content, "plan")
    _check_names(settings, _PLAN, "plan.")
    return {
        "problem": _base_case(content.get("case"), path.parent),
        "candidates": _measurements(content, "candidate", path.parent),
        "completed": _measurements(content, "completed", path.parent),
        "options": _table_of(content, "solver"),
        **{name: _flat_names(_table_of(content, name)) for name in _BY_FIELD},
        **settings,
    }


def _measurements(content: Mapping[str, Any], name: str, folder: Path) -> list[Measurement]:
    """Return the measurements in an array of tables of a study file."""
    tables = content.get(name, [])
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
        raise InvalidProblem.at(name, f"must be tables; write [[{name}]] above each")
    return [_measurement(table, f"{name}.{k}", folder) for k, table in enumerate(tables)]


def _measurement(table: Mapping[str, Any], where: str, folder: Path) -> Measurement:
    """Return the measurement that a table of a study file describes."""
    _check_names(table, _MEASUREMENT, f"{where}.")
    if "quantity" not in table:
        raise InvalidProblem.at(f"{where}.quantity", "missing; give the name of an output")
    keywords = {name: value for name, value in table.items() if name != "case"}
    for name in ("at", "fields"):
        keywords[name] = _flat_names(_table_of(table, name))
    if "case" in table:
        keywords["problem"] = _base_case(table["case"], folder)
    return Measurement(**keywords)
