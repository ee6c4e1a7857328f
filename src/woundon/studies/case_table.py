"""Tables of cases: each row is a problem; its outputs and its failure become further columns.

    table --> inputs in SI, faults of cells --> one study of all rows without faults --> table

Workers and the order of the cases are those of sweeps.  In contrast to a sweep over a table, a
faulty row does not reject the table, and an empty cell stands for the value of the case.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import __version__, kinds
from ..arguments import check_type
from ..errors import InvalidProblem, one_of
from ..io.case_files import check_like_a_case, load_case, make_problem
from ..io.cells import MAX_COUNTED, Fault, as_plain_number, decimal_sign, numbers, raise_faults
from ..io.sheets import Sheet, TableSource, read_sheet
from ..io.tables import Column, Names, is_known_header, match_columns
from ..problems.description import Description
from ..problems.family import field_from_table
from ..problems.paths import field_or_none, is_part_of, nest_tables
from ..problems.problem import Problem
from ..quantities import header, is_on_request, pattern, scalar_outputs
from .cases import Solved, table_of_cases
from .column_names import (
    ANNOTATIONS,
    column_names,
    columns_of,
    conversion_of,
    input_columns,
    output_columns,
)
from .model import KindModel, kind_of, model_of, quantities_of, solver_options
from .progress import Progress
from .run import Workers, run_study

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["read_cases", "solve_table"]

Array = np.ndarray
GIVEN = " (given)"  # behind the header of a copied column that has the name of an output


def solve_table(
    table: TableSource,
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
    sheet = read_sheet(table, "table", _is_known_to_any(case, kind, columns))
    problem, complete = _base_problem(sheet, case, kind, columns)
    fields = input_columns(problem)
    matched = match_columns(sheet, column_names(problem), columns)
    # "+-" columns of standard deviations are copied only
    inputs = [c for c in matched if pattern(c.name) in fields and not c.deviation]
    if not inputs:
        raise InvalidProblem.at(sheet.where, "has no column that is an input of the model")
    names = _default_outputs(problem) if outputs is None else outputs
    base = model_of(problem, names, tie, solver_options(nodes, rtol, options))
    cells, faults = _read_inputs(sheet, inputs, problem, complete=complete, gaps=True)
    raise_faults([fault for fault in faults if not fault.row])  # of headers
    if not complete:
        base.check_varied(cells)
        cells = _without_gaps(problem, cells)
    model = _RowModel(**vars(base), complete=complete)
    rows = _solve_rows(
        model, cells, _reasons(sheet, faults), workers=workers, chunk=chunk, progress=progress
    )
    frame = _copied_columns(sheet, {c.header: c for c in matched}, fields)
    _add_outputs(frame, model, rows.values, drop_empty=outputs is None)
    frame["failure"], frame["warnings"] = rows.failure, rows.warnings
    if isinstance(table, type(frame)):  # a DataFrame
        frame.index = table.index
    frame.attrs["about"] = {
        "version": __version__,
        "kind": model.kind.name,
        "case": None if complete else problem.model_dump(mode="json"),
    }
    return frame


def _base_problem(
    sheet: Sheet,
    case: Problem | str | Path | None,
    kind: str | None,
    columns: Mapping[str, str | None] | None,
) -> tuple[Problem, bool]:
    """Return the case, and False; without a case the example of the kind of problem, and True.

    The flag states whether the columns describe the complete problem: the example supplies the
    names of fields only, not their values.
    """
    if case is None:
        kind_of_table = _kind_of_columns(sheet, columns) if kind is None else kinds.named(kind)
        return kind_of_table.example(), True
    check_type("case", case, Problem, str, Path)
    if kind is not None:
        raise InvalidProblem.at("kind", "is given together with a case, which has its own kind")
    return (case if isinstance(case, Problem) else load_case(case)), False


def read_cases(
    data: Any, problem: Problem, columns: Mapping[str, str | None] | None = None
) -> dict[str, list[Any]]:
    """Read the cases of a sweep: for each input a list of values, in SI.

    Outputs and further columns of the tables of studies are ignored.

    Parameters
    ----------
    data : path, mapping or pandas.DataFrame
        As of :func:`solve_table`.
    problem : Problem
        The base case of the sweep.
    columns : mapping, optional
        As of :func:`solve_table`.

    Raises
    ------
    InvalidProblem
        Lists all invalid columns or cells.

    Examples
    --------
    >>> import woundon as wo
    >>> read_cases({"load [kN/m]": [89.0, 178.0]}, wo.RollerProblem.example())
    {'load': [89000.0, 178000.0]}
    """
    names = column_names(problem)
    sheet = read_sheet(data, "over", is_known_header(names, columns))
    fields, outputs = input_columns(problem), output_columns(problem)
    matched = match_columns(sheet, names, columns)
    # a quantity that is both input and output, such as the creepage of rollers, is an output in the
    # table of a study, and an input in other tables
    written = any(column.name in ANNOTATIONS for column in matched)
    inputs = [
        column
        for column in matched
        if not (column.name in outputs and (written or column.name not in fields))
        and not (column.deviation or column.name in ANNOTATIONS)
    ]
    values, faults = _read_inputs(sheet, inputs, problem, complete=False, gaps=False)
    raise_faults(faults)
    if not values:
        raise InvalidProblem.at(sheet.where, "has no column that is an input of the model")
    return values


# ---- rows ---------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _RowModel(KindModel):
    """A model whose cases may leave out fields.

    Attributes
    ----------
    complete : bool
        Whether the fields of a row describe the complete problem; otherwise those without a value
        have that of the base problem.
    """

    complete: bool = False

    def variant(self, inputs: Mapping[str, Any]) -> Problem:
        """Return the problem of one row; None and nan stand for a field without a value."""
        fields = {name: value for name, value in inputs.items() if not _is_missing(value)}
        if not self.complete:  # fields without a value have that of the base problem
            return super().variant(fields)
        # the fields of the row are the problem: others have their default, or are reported missing
        problem = make_problem(nest_tables(fields), self.kind.name)
        return self.with_ties(problem)


def _solve_rows(
    model: _RowModel,
    cells: Mapping[str, list[Any]],
    faults: Sequence[str],
    *,
    workers: int | None,
    chunk: int | None,
    progress: bool | Progress,
) -> Solved:
    """Solve the rows without faults in one study; return the results of all rows.

    Parameters
    ----------
    model : _RowModel
    cells : mapping of str to list
        Input -> its value in each row, in SI.
    faults : sequence of str
        Faults of the cells of each row, '' without.
    workers, chunk, progress
        As of :func:`woundon.sweep`.
    """
    failure, warnings = list(faults), [""] * len(faults)
    values = np.full((len(faults), len(model.outputs)), np.nan)
    rows = [k for k, fault in enumerate(faults) if not fault]
    if rows:
        cases = table_of_cases(
            {name: [of_rows[k] for k in rows] for name, of_rows in cells.items()}
        )
        solved = run_study(model, cases, Workers(workers), chunk=chunk, progress=progress)
        values[rows] = np.column_stack(list(solved.outputs.values()))
        for k, reason, warning in zip(rows, solved.failure, solved.warnings, strict=True):
            failure[k], warnings[k] = _reason_text(reason), warning
    return Solved(values, failure, warnings)


def _is_missing(value: Any) -> bool:
    """Return True for an empty cell: None or nan."""
    return value is None or (isinstance(value, float) and isnan(value))


# ---- columns ------------------------------------------------------------------------------------


def _is_known_to_any(
    case: Problem | str | Path | None, kind: str | None, columns: Mapping[str, str | None] | None
) -> Callable[[str], bool]:
    """Return a function that tells whether a header is known, of the case or of any kind."""
    if isinstance(case, Problem):
        examples = [case]
    else:
        kinds_of_table = kinds.every() if kind is None else [kinds.named(kind)]
        examples = [each.example() for each in kinds_of_table]
    known = [is_known_header(column_names(example), columns) for example in examples]
    return lambda header: any(is_known(header) for is_known in known)


def _kind_of_columns(sheet: Sheet, columns: Mapping[str, str | None] | None) -> kinds.Kind:
    """Return the kind of problem whose fields the headers are, with the fewest fields missing."""
    # (required fields without a column, number of fields, kind)
    candidates: list[tuple[int, int, kinds.Kind]] = []
    faults: list[InvalidProblem] = []
    for kind in kinds.every():
        try:
            example = kind.example()
            matched = match_columns(sheet, column_names(example), columns)
        except InvalidProblem as fault:  # a header is no field of this kind
            faults.append(fault)
            continue
        fields = kind.problem.model_fields
        required = [name for name, field in fields.items() if field.is_required()]
        missing = sum(not any(is_part_of(c.name, name) for c in matched) for name in required)
        candidates.append((missing, len(fields), kind))
    if not candidates:
        known = one_of(kind.name for kind in kinds.every())
        text = f"without a case the columns must be fields of one kind of problem: {known}"
        raise InvalidProblem([(sheet.where, text), *faults[0].faults])  # those of the first kind
    return min(candidates, key=lambda entry: entry[:2])[2]  # of equal ones, the smallest kind


def _read_inputs(
    sheet: Sheet, inputs: Sequence[Column], problem: Problem, *, complete: bool, gaps: bool
) -> tuple[dict[str, list[Any]], list[Fault]]:
    """Read columns of inputs.

    Parameters
    ----------
    sheet, inputs : Sheet, sequence of Column
    problem : Problem
        Gives width, thickness and density, unless the table is ``complete``.
    complete : bool
        Whether the columns describe the complete problem.
    gaps : bool
        Whether cells may be empty; their values are nan or None.

    Returns
    -------
    values : dict of str to list
        By field, in SI.
    faults : list of Fault
        Of headers and cells.
    """
    conversion = conversion_of(problem, complete)
    names = Names({**columns_of(problem), **conversion.helpers})
    numeric = [column for column in inputs if names.quantity(column.name) is not None]
    faults: list[Fault] = []
    of_columns = numbers(
        sheet,
        numeric,
        names,
        faults,
        gaps=lambda _: gaps,
        conversion=conversion,
        most_faults=inf if gaps else MAX_COUNTED,  # with gaps every row states its own faults
    )
    read = {c.name: of_rows.tolist() for c, of_rows in zip(numeric, of_columns, strict=True)}
    values: dict[str, list[Any]] = {}
    for column in inputs:
        if column.name not in read:
            values[column.name] = _words_and_bodies(sheet, column, problem, faults, gaps)
        elif column.name not in conversion.helpers:
            values[column.name] = read[column.name]
    return values, faults


def _words_and_bodies(
    sheet: Sheet, column: Column, problem: Problem, faults: list[Fault], gaps: bool
) -> list[Any]:
    """Return the cells of a column that is not numeric: words, names of materials, bodies.

    With ``gaps`` cells may be empty, None.  Errors are added to ``faults``.
    """
    values: list[Any] = []
    for number, cell in zip(sheet.numbers, column.cells, strict=True):
        value = None
        try:
            value = _word_or_body(problem, column.name, cell)
            if value is None and not gaps:
                raise InvalidProblem("the cell is empty")
        except (ValueError, RecursionError) as fault:  # InvalidProblem too; both of JSON
            reason = str(fault).replace("\n", "; ")
            text = f"row {number}, column {column.header!r}: {reason}"
            faults.append(Fault(sheet.where, text, number))
        values.append(value)
    return values


def _word_or_body(problem: Problem, name: str, cell: Any) -> Any:
    """Return a cell as a word or, from a table in JSON, as a body or material; None if empty.

    Booleans, bodies and materials, which columns in memory may have, are returned as they are.
    """
    if isinstance(cell, (bool, Description)):
        return cell
    if _is_missing(cell):
        return None
    if not isinstance(cell, str):
        raise InvalidProblem(f"{cell!r} is out of place; must be a text")
    text = cell.strip()
    if not text.startswith("{"):
        return text or None
    table = json.loads(text)
    check_like_a_case(table, "a table of fields")
    return field_from_table(problem, name, table)


def _reasons(sheet: Sheet, faults: Sequence[Fault]) -> list[str]:
    """Return the faults of each row as one text, '' for a row without faults.

    The faults are those of cells only.
    """
    texts: dict[int, list[str]] = {number: [] for number in sheet.numbers}
    for fault in faults:
        texts[fault.row].append(fault.text.removeprefix(f"row {fault.row}, "))
    return ["; ".join(of_row) for of_row in texts.values()]


def _without_gaps(problem: Problem, cells: Mapping[str, list[Any]]) -> dict[str, list[Any]]:
    """Return the inputs of rows with the numbers of the base case in place of empty cells.

    Cells of a field that is not a number in the base case stay empty.
    """
    filled: dict[str, list[Any]] = {}
    for name, of_rows in cells.items():
        present = field_or_none(problem, name)  # None also of another body, which has a column too
        is_number = isinstance(present, float)
        filled[name] = [present if is_number and _is_missing(v) else v for v in of_rows]
    return filled


# ---- outputs ------------------------------------------------------------------------------------


def _reason_text(reason: str) -> str:
    """Return the reason of a failure without the name of the exception."""
    words = {"InvalidProblem": "", "NoSteadyState": "", "NotConverged": "not converged: "}
    name, separator, text = reason.partition(": ")
    return f"{words[name]}{text}" if separator and name in words else reason


def _default_outputs(problem: Problem) -> tuple[str, ...]:
    """Return the main outputs with their errors, then all other scalars of every result."""
    result = kind_of(problem).result
    errors = [f"errors.{name}" for name in result.MAIN]
    # estimates and records of the solution, quantities that are inputs too, residuals, errors, and
    # outputs that are computed only if they are asked for
    left_out = {*result.ESTIMATES, *type(problem).model_fields, "residual"}
    others = [
        name
        for name in scalar_outputs(result)
        if not (name in left_out or name.endswith("_error") or is_on_request(result, name))
    ]
    return tuple(dict.fromkeys((*result.MAIN, *errors, *others)))


def _copied_columns(
    sheet: Sheet, matched: Mapping[str, Column], fields: Mapping[str, Any]
) -> pd.DataFrame:
    """Return the columns of a table with their units, without outputs of an earlier solution.

    Parameters
    ----------
    sheet : Sheet
    matched : mapping of str to Column
        The columns with a known name, by header.
    fields : mapping
        Names of the inputs.
    """
    import pandas as pd

    # a table written by this function or by a sweep has outputs, which are replaced
    written = any(column.name in ANNOTATIONS for column in matched.values())
    sign = decimal_sign(sheet)
    copied: dict[str, Any] = {}
    for name, cells in sheet.columns.items():
        text = header(name, sheet.units.get(name, ""))
        if name in matched and pattern(matched[name].name) not in fields:
            if written:
                continue
            text += GIVEN
        is_text = bool(sheet.separator)  # of a file whose cells have no types
        copied[text] = [as_plain_number(cell, sign) for cell in cells] if is_text else cells
    return pd.DataFrame(copied)


def _add_outputs(frame: pd.DataFrame, model: KindModel, values: Array, drop_empty: bool) -> None:
    """Add the outputs of a model, (rows, outputs) in SI, with their units in the headers.

    With ``drop_empty`` outputs that are nan in all rows are left out.
    """
    quantities = quantities_of(model, model.outputs)
    units: dict[str, str] = {}
    for name, of_rows in zip(model.outputs, values.T, strict=True):
        if drop_empty and np.isnan(of_rows).all():
            continue
        unit, converted = quantities[name].in_table(of_rows)
        column = header(name, unit)
        frame[column], units[column] = converted, unit
    frame.attrs["units"] = units
