"""Tables of cases: each row is a problem; its outputs and its failure become further columns.

    table --> rows: fields in SI, faults of cells --> one study of all rows without faults --> table

Reader of tables, model, order of the cases and processes are those of sweeps.  In contrast to a
sweep, a faulty row does not reject the table, and an empty cell stands for the value of the case.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import __version__, kinds
from ..errors import InvalidProblem, one_of
from ..io.case_files import SCHEMA, load_case, make_problem
from ..io.cells import Fault, as_plain_number, decimal_sign, numbers, raise_faults
from ..io.files import replaced_file
from ..io.sheets import Sheet, need_openpyxl, read_sheet
from ..io.spreadsheets import record_table, write_csv, write_workbook
from ..io.tables import Column, Names, match_columns
from ..problems.family import field_from_table
from ..problems.paths import get_field, nest_tables
from ..problems.problem import Problem
from ..quantities import Quantity, is_on_request, pattern, scalar_outputs
from . import design as designs
from .engine import run_study
from .kind_model import KindModel, columns_of, conversion_of, kind_of, model_of
from .measured import ANNOTATIONS
from .model import quantities_of
from .progress import Progress
from .runners import runner_for

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["check_table_path", "solve_table", "write_table"]

Array = np.ndarray
FORMATS = (".csv", ".xlsx")
GIVEN = " (given)"  # behind the header of a column that has the name of an output


def solve_table(
    table: Any,
    case: Problem | str | Path | None = None,
    outputs: Sequence[str] | None = None,
    *,
    kind: str | None = None,
    columns: Mapping[str, str | None] | None = None,
    tie: Mapping[str, str] | None = None,
    workers: int | None = None,
    chunk: int | None = None,
    progress: bool | Progress = False,
    nodes: int | None = None,
    rtol: float | None = None,
    options: Mapping[str, Any] | None = None,
) -> pd.DataFrame:
    """Solve the cases of a table, one in each row.

    Parameters
    ----------
    table : path, mapping or pandas.DataFrame
        CSV or Excel file, or columns by name.  A column is a field by its dotted name, with its
        unit in the header ("nip_load [kN/m]"), in a row below it or in the cells; columns in memory
        are SI where they state no unit.
    case : Problem or path, optional
        Values of all fields that have no column, and of empty cells.  Without it the columns
        describe the complete problem.
    outputs : sequence of str, optional
        Any scalars of the result, or ``"errors.<output>"`` for an estimated error; by default all
        scalar outputs and the errors of the main ones.
    kind : str, optional
        Kind of problem of a table without case; by default the one that the columns fit.
    columns : mapping
        Header in the table -> name of the field, with or without unit; None for a column that is no
        field, such as a number or a remark: it is copied.
    tie : mapping of str to str
        Field -> field that it follows, e.g. ``{"web.material": "roll.material"}``.
    workers, chunk, progress, nodes, rtol, options
        As of :func:`woundon.sweep`.

    Returns
    -------
    pandas.DataFrame
        The columns of the table, the outputs with their units in the header, and ``failure`` and
        ``warnings``: why a row was not solved, and where it leaves the validity of the model.

    Raises
    ------
    InvalidProblem
        For a table that cannot be read, a header that is no field, or an output that does not
        exist.  Faults of a row are in its ``failure``.

    Examples
    --------
    >>> import woundon as wo
    >>> cases = {"load [kN/m]": [89.0, 178.0, -1.0]}
    >>> solved = wo.solve_table(cases, wo.RollerProblem.example(), ["half_width"])
    >>> [round(a * 1e6) for a in solved["half_width [m]"][:2]]
    [354, 500]
    >>> solved["failure"][2]
    'load: -1000 is out of range; must be >= 1e-12 and <= 1e+09 [N/m]'
    """
    sheet = read_sheet(table, "table")
    problem = load_case(case) if isinstance(case, (str, Path)) else case
    if problem is None:
        known = _kind_of_columns(sheet, columns) if kind is None else _named(kind)
        problem, complete = known.example(), True
    else:
        if kind is not None:
            raise InvalidProblem.at("kind", "is given together with a case, which has its own kind")
        known, complete = kind_of(problem), False
    matched = match_columns(sheet, _names(problem), columns)
    inputs = [c for c in matched if _is_field(c.name, problem) and not c.deviation]
    if not inputs:
        raise InvalidProblem.at(sheet.where, "has no column that is an input of the model")
    names = _default_outputs(problem) if outputs is None else outputs
    base = model_of(problem, names, tie, {"nodes": nodes, "rtol": rtol, **(options or {})})
    cells, failure = _values(sheet, problem, inputs, complete)
    if not complete:
        base.check_varied(cells)
    model = _RowModel(**vars(base), complete=complete)
    values, warnings = _solve_rows(
        model,
        cells,
        failure,
        {} if complete else _base_values(problem, cells),
        runner_for(workers, None),
        chunk,
        progress,
    )
    frame = _join_outputs(sheet, matched, problem, model, values, outputs is None)
    frame["failure"], frame["warnings"] = failure, warnings
    frame.index = getattr(table, "index", frame.index)
    frame.attrs["about"] = {
        "version": __version__,
        "kind": known.name,
        "case": None if complete else problem.model_dump(mode="json"),
    }
    return frame


# ---- rows ---------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _RowModel(KindModel):
    """A model whose cases may leave out fields.

    Attributes
    ----------
    complete : bool
        Whether the fields of a row describe the problem, without the base problem.
    """

    complete: bool = False

    def variant(self, inputs: Mapping[str, Any]) -> Any:
        """Return the problem of one row; None and nan stand for a field without a value."""
        fields = {name: value for name, value in inputs.items() if not _is_missing(value)}
        if not self.complete:
            return super().variant(fields)
        problem = make_problem({"schema": SCHEMA, **nest_tables(fields)}, self.kind.name)
        ties = {follower: get_field(problem, leader) for follower, leader in self.tie.items()}
        return problem.replace(**ties) if ties else problem


class _RowDesign(designs.Design):
    """A table of cases with gaps."""

    def chunks(self, size: int | None = None) -> list[Array]:
        """Divide the cases into chunks of neighbours; missing values count as column means."""
        filled = []
        for column in self.columns:
            values = column.values
            if isinstance(values, np.ndarray) and np.isnan(values).any():
                known = values[~np.isnan(values)]
                values = np.where(np.isnan(values), known.mean() if known.size else 0.0, values)
            filled.append(designs.Column(column.name, values))
        return designs.Design(self.kind, tuple(filled)).chunks(size)


def _is_missing(value: Any) -> bool:
    return value is None or (isinstance(value, float) and isnan(value))


def _is_field(name: str, problem: Problem) -> bool:
    return pattern(name) in {**columns_of(problem), **conversion_of(problem).helpers}


def _names(problem: Problem) -> Names:
    """Return all names that a header may have: fields, outputs and the columns of studies."""
    known = scalar_outputs(kind_of(problem).result)
    errors = {f"errors.{name}": quantity for name, quantity in known.items()}
    helpers = conversion_of(problem).helpers
    fields = columns_of(problem)
    return Names({**dict.fromkeys(ANNOTATIONS), **known, **errors, **fields, **helpers})


def _named(kind: str) -> kinds.Kind:
    return kinds.named(str(kind).replace("-", "_"))


def _kind_of_columns(sheet: Sheet, columns: Mapping[str, str | None] | None) -> kinds.Kind:
    """Return the kind of problem whose fields the headers are, with the fewest fields missing."""
    candidates: list[tuple[int, int, kinds.Kind]] = []
    faults: list[InvalidProblem] = []
    for kind in kinds.every():
        try:
            example = kind.example()
            matched = match_columns(sheet, _names(example), columns)
        except InvalidProblem as fault:
            faults.append(fault)
            continue
        fields = kind.problem.model_fields
        heads = {column.name.partition(".")[0] for column in matched}
        missing = sum(field.is_required() and name not in heads for name, field in fields.items())
        candidates.append((missing, len(fields), kind))
    if not candidates:
        known = one_of(kind.name for kind in kinds.every())
        text = f"without a case the columns must be fields of one kind of problem: {known}"
        raise InvalidProblem([(sheet.where, text), *faults[0].faults])
    return min(candidates, key=lambda entry: entry[:2])[2]


def _values(
    sheet: Sheet, problem: Problem, inputs: Sequence[Column], complete: bool
) -> tuple[dict[str, list[Any]], list[str]]:
    """Return the values of each column in SI, gaps as nan or None, and the faults of each row."""
    conversion = conversion_of(problem, complete)
    names = Names({**columns_of(problem), **conversion.helpers})
    numeric = [column for column in inputs if names.quantity(column.name) is not None]
    reasons: list[Fault] = []
    values = numbers(
        sheet,
        numeric,
        names,
        reasons,
        gaps=lambda _: True,
        conversion=conversion,
        most_faults=inf,
    )
    raise_faults([fault for fault in reasons if not fault.row])  # of headers
    faults: dict[int, list[str]] = {number: [] for number in sheet.numbers}
    for fault in reasons:
        faults[fault.row].append(fault.text.removeprefix(f"row {fault.row}, "))
    read = {c.name: of_rows.tolist() for c, of_rows in zip(numeric, values, strict=True)}
    fields: dict[str, list[Any]] = {}
    for column in inputs:
        if column.name not in read:
            fields[column.name] = [
                _read_cell(problem, column, k, faults[number])
                for k, number in enumerate(sheet.numbers)
            ]
        elif column.name not in conversion.helpers:
            fields[column.name] = read[column.name]
    return fields, ["; ".join(texts) for texts in faults.values()]


def _read_cell(problem: Problem, column: Column, row: int, faults: list[str]) -> Any:
    """Convert a cell to a word, the name of a material, or a body (JSON); an empty cell to None."""
    cell = column.cells[row]
    if not isinstance(cell, str):
        if _is_missing(cell):
            return None
        faults.append(f"column {column.header!r}: {cell!r} is out of place; must be a text")
        return None
    text = cell.strip()
    if not text.startswith("{"):
        return text or None
    try:
        return field_from_table(problem, column.name, json.loads(text))
    except (
        ValueError,
        RecursionError,
    ) as fault:  # InvalidProblem and JSONDecodeError are ValueErrors
        faults.append(f"column {column.header!r}: {fault}".replace("\n", "; "))
        return None


def _base_values(problem: Problem, cells: Mapping[str, Sequence[Any]]) -> dict[str, Any]:
    """Return the numbers of the base case that replace empty cells of a column."""
    known: dict[str, Any] = {}
    for name in cells:
        try:
            value = get_field(problem, name)
        except InvalidProblem:  # of another body or material, which has a column too
            continue
        if isinstance(value, float):
            known[name] = value
    return known


# ---- solutions ----------------------------------------------------------------------------------


def _solve_rows(
    model: _RowModel,
    cells: Mapping[str, list[Any]],
    failure: list[str],
    present: Mapping[str, Any],
    runner: Any,
    chunk: int | None,
    progress: bool | Progress,
) -> tuple[dict[str, Array], list[str]]:
    """Return the outputs and warnings of all rows; store the reasons of failures."""
    rows = [k for k, reason in enumerate(failure) if not reason]
    values = {name: np.full(len(failure), np.nan) for name in model.outputs}
    warnings = [""] * len(failure)
    if not rows:
        return values, warnings
    columns = []
    for name, column in cells.items():
        entries = [column[k] for k in rows]
        entries = [present.get(name, entry) if _is_missing(entry) else entry for entry in entries]
        columns.append(designs.Column.of(name, entries))
    design = _RowDesign("table", tuple(columns))
    solved = run_study(model, design, runner, chunk=chunk, progress=progress)
    for name, of_rows in solved.outputs.items():
        values[name][rows] = of_rows
    for k, reason, warning in zip(rows, solved.failure, solved.warnings, strict=True):
        failure[k], warnings[k] = _reason_text(reason), warning
    return values, warnings


def _reason_text(reason: str) -> str:
    """Return the reason of a failure without the name of the exception."""
    for name, text in (
        ("InvalidProblem: ", ""),
        ("NoSteadyState: ", ""),
        ("NotConverged: ", "not converged: "),
    ):
        if reason.startswith(name):
            return text + reason.removeprefix(name)
    return reason


def _default_outputs(problem: Problem) -> tuple[str, ...]:
    """Return the main outputs with their errors, then all other scalars of every result."""
    result = kind_of(problem).result
    errors = [f"errors.{name}" for name in result.MAIN]
    left_out = {*result.ESTIMATES, *type(problem).model_fields, "residual"}
    others = [
        name
        for name in scalar_outputs(result)
        if not (name in left_out or name.endswith("_error") or is_on_request(result, name))
    ]
    return tuple(dict.fromkeys((*result.MAIN, *errors, *others)))


def _join_outputs(
    sheet: Sheet,
    matched: Sequence[Column],
    problem: Problem,
    model: _RowModel,
    values: Mapping[str, Array],
    drop_empty: bool,
) -> pd.DataFrame:
    """Return the columns of the table with the outputs next to them."""
    import pandas as pd

    names = {column.header: column for column in matched}
    # a table written by this function or by a sweep has outputs, which are replaced
    written = any(column.name in ANNOTATIONS for column in matched)
    sign = decimal_sign(sheet)
    cells_of: dict[str, Any] = {}
    for header, cells in sheet.columns.items():
        column = names.get(header)
        text = f"{header} [{sheet.units[header]}]" if header in sheet.units else header
        if column is not None and not _is_field(column.name, problem):
            if written:
                continue
            text += GIVEN
        is_text = bool(sheet.separator)  # of a file whose cells have no types
        cells_of[text] = [as_plain_number(cell, sign) for cell in cells] if is_text else cells
    quantities: Mapping[str, Quantity] = quantities_of(model, model.outputs)
    units: dict[str, str] = {}
    for name, column_values in values.items():
        if drop_empty and np.isnan(column_values).all():
            continue
        unit, converted = quantities[name].in_table(column_values)
        header = name if unit == "1" else f"{name} [{unit}]"
        cells_of[header], units[header] = converted, unit
    frame = pd.DataFrame(cells_of)
    frame.attrs["units"] = units
    return frame


# ---- files --------------------------------------------------------------------------------------


def check_table_path(path: str | Path) -> Path:
    """Return the path of a table that can be written; reject other formats."""
    path = Path(path)
    if path.suffix not in FORMATS:
        text = f"the ending {path.suffix!r} is not a known format; must be {one_of(FORMATS)}"
        raise InvalidProblem.at(str(path), text)
    if path.suffix == ".xlsx":
        need_openpyxl()
    return path


def write_table(frame: pd.DataFrame, path: str | Path) -> None:
    """Write a solved table to ``.csv`` or ``.xlsx``, by the path's ending.

    Raises
    ------
    InvalidProblem
        For another ending.
    OSError
        If the file cannot be written.
    """
    path = check_table_path(path)
    with replaced_file(path) as temporary:
        if path.suffix == ".csv":
            write_csv(temporary, frame)
            return
        record = record_table(frame.attrs.get("about", {}))
        write_workbook(temporary, {"results": frame, "about": record})
