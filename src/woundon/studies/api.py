"""``wo.sweep``, ``wo.global_sensitivity``: the engine over problems of any kind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import check_arguments
from ..errors import InvalidProblem
from ..io.sheets import TableSource
from ..problems.messages import quote
from ..problems.paths import field_quantity, number_in_si
from ..problems.problem import Problem
from .case_table import read_cases
from .cases import Cases, check_number, make_cases
from .model import KindModel, model_of, solver_options
from .progress import Progress
from .run import Workers, run_study
from .sobol import SobolIndices, saltelli_cases, sobol_indices_of

if TYPE_CHECKING:
    import xarray

__all__ = ["global_sensitivity", "in_si", "range_in_si", "study_of", "sweep"]


def sweep(
    problem: Problem,
    over: TableSource,
    outputs: Sequence[str] | None = None,
    *,
    columns: Mapping[str, str | None] | None = None,
    design: str = "grid",
    samples: int | None = None,
    seed: int = 0,
    tie: Mapping[str, str] | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    out: str | Path | None = None,
    resume: bool = False,
    chunk: int | None = None,
    progress: bool | Progress = False,
    nodes: int | None = None,
    rtol: float | None = None,
    options: Mapping[str, Any] | None = None,
) -> xarray.Dataset:
    """Solve a problem of any kind for many values of its fields.

    Parameters
    ----------
    problem : Problem
        The base case, of any kind.
    over : mapping, path or pandas.DataFrame
        Dotted name of any field, ``"drum.layers.0.thickness"``, -> its values, SI or texts with
        units; for a drawn design (low, high) or (low, high, "log").  Values may also be bodies or
        names of materials.  Or a table with one case in each row: a CSV or Excel file with units in
        its header, or a DataFrame (SI if its columns have no unit).
    outputs : sequence of str
        Any scalars of the result, or ``"errors.<output>"`` for an error estimate; by default the
        main outputs of the kind.
    columns : mapping
        Header in the table -> name of the field, with or without unit; None omits a column.
    design : {"grid", "table", "latin-hypercube", "sobol"}
        All combinations (default); the rows of a table; drawn samples.
    samples, seed : int
        Of a drawn design: number of cases (a power of 2 for "sobol") and seed of the generator.
    tie : mapping of str to str
        Field -> field that it follows, e.g. ``{"web.material": "roll.material"}``.
    workers : int
        Processes; by default one for each core if the study takes more than some seconds.
    scheduler : str
        Address of a Dask scheduler, "tcp://...", whose workers solve the cases.
    out : path
        Folder of the file to which solved chunks are added; ``resume=True`` continues the study.
    chunk : int
        Number of successive cases, each of which starts from the solution of the previous one.
    progress : bool or callable
        Show rate and remaining time, or call with (cases done, all cases).
    nodes, rtol : int, float
        Of the solver: the number of nodes, or the error to which the mesh is refined.
    options : mapping
        Further options of the solver, e.g. ``{"rtol": 1e-4}``.

    Returns
    -------
    xarray.Dataset
        With a dimension for each input of a grid, or ``case``.  Failed cases are nan; the variable
        ``failure`` has the reason.  Results depend neither on workers nor on interruptions.

    Raises
    ------
    InvalidProblem
        For a name that does not exist, a folder that contains another study or a damaged one, or
        if all values are invalid.
    NotConverged
        If no case was solved, with the reasons; has the dataset.
    OSError
        If ``out`` cannot be written, e.g. on a full disk; chunks in the file remain valid.

    Examples
    --------
    >>> import woundon as wo
    >>> loads = {"load": ["50 kN/m", 89e3]}
    >>> table = wo.sweep(wo.RollerProblem.example(), loads, ["half_width"], workers=1)
    >>> (1e6 * table.half_width).round().values.tolist()
    [265.0, 354.0]
    """
    model, cases = study_of(
        problem,
        over,
        outputs,
        columns=columns,
        design=design,
        samples=samples,
        seed=seed,
        tie=tie,
        options=solver_options(nodes, rtol, options),
    )
    table = run_study(
        model,
        cases,
        Workers(workers, scheduler),
        out=out,
        resume=resume,
        chunk=chunk,
        progress=progress,
    )
    return table.check_any_solved().to_dataset()


def study_of(
    problem: Problem,
    over: TableSource | None,
    outputs: Sequence[str] | None = None,
    *,
    columns: Mapping[str, str | None] | None = None,
    design: str = "grid",
    samples: int | None = None,
    seed: int = 0,
    tie: Mapping[str, str] | None = None,
    options: Mapping[str, Any] | None = None,
) -> tuple[KindModel, Cases]:
    """Return the model and the cases of a :func:`sweep`, for :func:`~.run.run_study`.

    Parameters as of :func:`sweep`; ``options`` are all options of the solver.

    >>> import woundon as wo
    >>> over = {"load": [1e4, 2e4], "friction": [0.3]}
    >>> _, cases = study_of(wo.RollerProblem.example(), over, ["half_width"])
    >>> cases.shape
    (2, 1)
    """
    check_arguments(design=design)
    is_table = isinstance(over, (str, Path)) or hasattr(over, "iloc")  # a file or a DataFrame
    if columns is not None or is_table:
        if design not in ("grid", "table"):
            text = f"{design!r} draws samples, which cannot be combined with a table"
            raise InvalidProblem.at("design", text)
        over, design = read_cases(over, problem, columns), "table"
    check_arguments(over=over)
    assert over is None or isinstance(over, Mapping)
    values = in_si(problem, over or {})
    return (
        _model_of_study(problem, values, outputs, tie, options or {}),
        make_cases(values, design, samples, seed),
    )


def _model_of_study(
    problem: Problem,
    over: Mapping[str, Any],
    outputs: Sequence[str] | None,
    tie: Mapping[str, str] | None,
    options: Mapping[str, Any],
) -> KindModel:
    """Return the model of a study, its inputs checked."""
    model = model_of(problem, outputs, tie, options).without_estimates()
    model.check_varied(over)
    return model


def in_si(problem: Problem, over: Mapping[str, Any]) -> dict[str, Any]:
    """Return values or ranges by field, with texts with units converted to SI.

    >>> import woundon as wo
    >>> in_si(wo.RollerProblem.example(), {"load": ("50 kN/m", 1e5)})
    {'load': [50000.0, 100000.0]}
    """
    return {name: _numbers(problem, name, entry) for name, entry in over.items()}


def range_in_si(problem: Problem, name: str, ends: Any, where: str = "") -> tuple[float, float]:
    """Return the ends of a range of a field in SI; they may be texts with units.

    Parameters
    ----------
    problem : Problem
    name : str
        Dotted name of the field.
    ends : (low, high)
    where : str
        Name of the range in an error message; by default that of the field.

    Raises
    ------
    InvalidProblem
        If they are not two finite numbers low < high.

    Examples
    --------
    >>> import woundon as wo
    >>> range_in_si(wo.RollerProblem.example(), "load", ("50 kN/m", 1e5))
    (50000.0, 100000.0)
    """
    where = where or name
    pair = list(ends) if isinstance(ends, (list, tuple, np.ndarray)) else []
    if len(pair) != 2:
        raise InvalidProblem.at(where, f"{quote(ends)} is not a range; write (low, high)")
    low, high = (
        number_in_si(problem, name, end.item() if isinstance(end, np.generic) else end, where)
        for end in pair
    )
    if not -inf < low < high < inf:
        raise InvalidProblem.at(where, f"{quote(ends)} is not a range; must be low < high")
    return low, high


def _numbers(problem: Problem, name: str, entry: Any) -> Any:
    """Return one value or the values of a field, with texts with units converted to SI."""
    if isinstance(entry, str) or not hasattr(entry, "__len__"):
        return entry
    check_number(len(entry))
    # "log" at the end of a range is no value
    are_texts = [isinstance(value, str) and value != "log" for value in entry]
    quantity = field_quantity(problem, name) if any(are_texts) else None
    if quantity is None:  # numbers in SI, or words and names of materials
        return entry
    values = zip(entry, are_texts, strict=True)
    return [number_in_si(problem, name, value) if is_text else value for value, is_text in values]


def global_sensitivity(
    problem: Problem,
    over: Mapping[str, Any],
    outputs: Sequence[str] | None = None,
    *,
    samples: int = 256,
    seed: int = 0,
    tie: Mapping[str, str] | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    out: str | Path | None = None,
    resume: bool = False,
    progress: bool | Progress = False,
    nodes: int | None = None,
    rtol: float | None = None,
    options: Mapping[str, Any] | None = None,
) -> SobolIndices:
    """Compute Sobol' indices: the share of the variance of each output due to each input.

    Parameters
    ----------
    problem : Problem
        Of any kind.
    over : mapping
        Dotted name -> range (low, high), or (low, high, "log") for a uniform distribution of the
        logarithm; SI or texts with units.
    outputs : sequence of str
    samples : int
        Base samples, a power of 2; samples * (inputs + 2) cases are solved.
    seed, tie, workers, scheduler, out, resume, progress, nodes, rtol, options
        As of :func:`sweep`.

    Raises
    ------
    InvalidProblem
        Also if a case cannot be solved: the indices need all cases.

    Examples
    --------
    >>> import woundon as wo
    >>> ranges = {"load": (50e3, 100e3), "friction": (0.3, 0.5)}
    >>> indices = wo.global_sensitivity(
    ...     wo.RollerProblem.example(), ranges, ["half_width"], samples=16, nodes=17, workers=1
    ... )
    >>> bool(indices.total_order[0, 0] > indices.total_order[0, 1])
    True
    """
    check_arguments(over=over)
    ranges = in_si(problem, over or {})
    model = _model_of_study(problem, ranges, outputs, tie, solver_options(nodes, rtol, options))
    cases = saltelli_cases(ranges, samples, seed)
    table = run_study(
        model, cases, Workers(workers, scheduler), out=out, resume=resume, progress=progress
    )
    return sobol_indices_of(table, seed)
