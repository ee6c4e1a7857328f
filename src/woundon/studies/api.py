"""``wo.sweep``, ``wo.fit``, ``wo.global_sensitivity``: the engine over problems of any kind."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InvalidProblem, NoSteadyState
from ..problems.messages import not_one_of, quote
from ..problems.paths import field_quantity, get_field, number_in_si
from ..problems.problem import Problem
from ..quantities import Quantity
from .case_table import read_cases
from .cases import Cases, make_cases
from .columns import columns_of, conversion_of, measurable_outputs
from .fit import FitResult, fit_parameters
from .measured import Measured, read_measured
from .model import KindModel, kind_of, model_of, options_of, quantities_of
from .predict import Parameter, Predictor
from .progress import Progress, progress_reporter
from .run import Workers, run_study
from .sobol import SobolIndices, saltelli_cases, sobol_indices_of

if TYPE_CHECKING:
    import xarray

__all__ = ["fit", "global_sensitivity", "in_si", "solver_options", "study_of", "sweep"]

FIT_NODES = 65


def sweep(
    problem: Problem,
    over: Any,
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
    over: Any,
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

    >>> import woundon as wo
    >>> over = {"load": [1e4, 2e4], "friction": [0.3]}
    >>> _, cases = study_of(wo.RollerProblem.example(), over, ["half_width"])
    >>> cases.shape
    (2, 1)
    """
    if columns is not None or isinstance(over, (str, Path)) or hasattr(over, "iloc"):
        if design not in ("grid", "table"):
            text = f"{design!r} draws samples, which cannot be combined with a table"
            raise InvalidProblem.at("design", text)
        over, design = read_cases(over, problem, columns), "table"
    return (
        _model_of_study(problem, over, outputs, tie, options or {}),
        make_cases(in_si(problem, over), design, samples, seed),
    )


def _model_of_study(
    problem: Problem,
    over: Any,
    outputs: Sequence[str] | None,
    tie: Mapping[str, str] | None,
    options: Mapping[str, Any],
) -> KindModel:
    """Return the model of a study, its inputs checked."""
    model = model_of(problem, outputs, tie, options)
    model.check_varied(over if isinstance(over, Mapping) else ())
    return model


def solver_options(nodes: Any, rtol: Any, options: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the options of the solver that are not None.

    >>> solver_options(65, None, {"progress": None})
    {'nodes': 65, 'progress': None}
    """
    explicit = {
        name: value for name, value in (("nodes", nodes), ("rtol", rtol)) if value is not None
    }
    for name in explicit.keys() & (options or {}).keys():
        raise InvalidProblem.at(name, "is given twice, also among the options")
    return {**explicit, **(options or {})}


def in_si(problem: Problem, over: Any) -> Any:
    """Return values, ranges or bounds by field, with texts with units converted to SI.

    >>> import woundon as wo
    >>> in_si(wo.RollerProblem.example(), {"load": ("50 kN/m", 1e5)})
    {'load': [50000.0, 100000.0]}
    """
    if not isinstance(over, Mapping):
        return over
    return {name: _numbers(problem, name, entry) for name, entry in over.items()}


def _numbers(problem: Problem, name: str, entry: Any) -> Any:
    """Return one value or the values of a field, with texts with units converted to SI."""
    if isinstance(entry, str) or not hasattr(entry, "__len__"):
        return entry
    texts = [isinstance(value, str) and value != "log" for value in entry]
    quantity = field_quantity(problem, name) if any(texts) else None
    if quantity is None:
        return entry
    values = zip(entry, texts, strict=True)
    return [number_in_si(problem, name, value) if text else value for value, text in values]


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
    model = _model_of_study(problem, over, outputs, tie, solver_options(nodes, rtol, options))
    cases = saltelli_cases(in_si(problem, over), samples, seed)
    table = run_study(
        model, cases, Workers(workers, scheduler), out=out, resume=resume, progress=progress
    )
    return sobol_indices_of(table, samples, seed)


def fit(
    problem: Problem,
    measured: Any,
    vary: Mapping[str, tuple[float | str, float | str] | None] | Sequence[str],
    *,
    tie: Mapping[str, str] | None = None,
    columns: Mapping[str, str | None] | None = None,
    starts: int | None = None,
    seed: int = 0,
    profiles: bool | Sequence[str] = True,
    workers: int | None = None,
    progress: bool | Progress = False,
    nodes: int | None = None,
    rtol: float | None = None,
    options: Mapping[str, Any] | None = None,
) -> FitResult:
    """Fit fields of a problem of any kind to measured data by least squares.

    Parameters
    ----------
    problem : Problem
        The base case, with the fields that are neither measured nor fitted.
    measured : path, mapping or pandas.DataFrame
        CSV or Excel file with units in its header, or columns by name, SI if they have no unit:
        inputs ("nip_load [kN/m]"), outputs ("wound_on_tension [N/m]"), and standard deviations of
        these ("wound_on_tension +- [N/m]").
    vary : mapping or sequence of str
        Dotted name -> bounds (low, high), SI or texts with units; without bounds, a tenth to ten
        times the value.
    tie : mapping of str to str
        Field -> field that it follows, e.g. ``{"web.material": "roll.material"}``.
    columns : mapping
        Header in the data -> name of the quantity, with or without unit; None omits a column.
    starts, seed : int
        Number of starting points, the values of the problem and drawn ones, and seed of these.  By
        default until two starts converge to the best minimum, at most 6.
    profiles : bool or sequence of str
        Compute profile-likelihood intervals: of all fitted fields, or of the named ones.
    workers : int
        Processes for profiles if they take long; by default one for each core.
    progress : bool or callable
        Show the fraction that is done, or call with (evaluations done, expected).
    nodes, rtol, options
        As of :func:`sweep`; by default 65 nodes if the solver chooses the mesh.  ``rtol`` is not
        recommended: outputs are continuous in the parameters on one mesh, and jump by the
        discretisation error where the mesh changes.

    Returns
    -------
    FitResult
        Its ``problem`` contains the estimates.

    Raises
    ------
    InvalidProblem
        For invalid names, bounds or data.
    NotConverged
        If no start can be solved.

    Examples
    --------
    >>> import woundon as wo
    >>> data = {"load [kN/m]": [50, 89, 120], "half_width [um]": [265, 354, 411]}
    >>> found = wo.fit(
    ...     wo.RollerProblem.example(), data, {"upper.radius": (0.1, 1.0)}, starts=1, nodes=17
    ... )
    >>> round(found.estimate("upper.radius"), 2)  # m
    0.25
    """
    outputs = measurable_outputs(problem)
    data = read_measured(
        measured,
        columns_of(problem),
        outputs,
        columns,
        kind_of(problem).result.REPLACED,
        conversion_of(problem),
    )
    settings = _on_one_mesh(problem, solver_options(nodes, rtol, options))
    model = model_of(problem, tuple(data.outputs), tie, settings)
    bounds = in_si(problem, _bounds(vary))
    parameters = tuple(_parameter(problem, name, ends) for name, ends in bounds.items())
    model.check_varied([*(p.name for p in parameters), *data.inputs])
    for parameter in parameters:
        _check_bounds(problem, parameter)
    _check_rows(problem, data)
    quantities = quantities_of(model, (*(p.name for p in parameters), *data.outputs))
    _check_units(quantities, data)
    predictor, profiled = Predictor(model, data, parameters), _names_of_profiles(profiles, bounds)
    with progress_reporter(progress, "fitting") as report:
        result = fit_parameters(
            predictor,
            starts=starts,
            seed=seed,
            profiles=profiled,
            quantities=quantities,
            workers=Workers(workers).count,
            progress=report,
        )
    estimates = dict(zip(result.names, result.estimates, strict=True))
    return replace(result, problem=model.variant(estimates))


def _on_one_mesh(problem: Problem, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options with a fixed number of nodes and without error estimates."""
    known = options_of(problem)
    defaults: dict[str, Any] = {"errors": False} if "errors" in known else {}
    if known.get("nodes", ...) is None and not options.keys() & {"nodes", "rtol"}:
        defaults["nodes"] = FIT_NODES
    return defaults | dict(options)


def _bounds(vary: Any) -> dict[str, Any]:
    """Return the fields to fit with their bounds; None for default bounds."""
    names = [vary] if isinstance(vary, str) else vary
    if not isinstance(names, (Mapping, Sequence)) or not all(isinstance(n, str) for n in names):
        text = f"{quote(vary)} is out of place; must be names of fields, or {{name: (low, high)}}"
        raise InvalidProblem.at("vary", text)
    bounds = dict(names) if isinstance(names, Mapping) else dict.fromkeys(names)
    if not bounds:
        raise InvalidProblem.at("vary", "nothing to fit: give fields and their bounds")
    return bounds


def _names_of_profiles(
    profiles: bool | Sequence[str], varied: Mapping[str, Any]
) -> tuple[str, ...]:
    """Return the names of the parameters that get a profile."""
    if isinstance(profiles, bool):
        return tuple(varied) if profiles else ()
    names = (profiles,) if isinstance(profiles, str) else tuple(profiles)
    for name in names:
        if name not in varied:
            raise InvalidProblem.at("profiles", not_one_of(name, varied))
    return names


def _parameter(problem: Problem, name: str, bounds: Any) -> Parameter:
    """Return a parameter of a fit; its default bounds are a tenth and ten times its value."""
    base = get_field(problem, name)
    if field_quantity(problem, name) is None or not isinstance(base, float | None):
        raise InvalidProblem.at(name, f"{quote(base)} is not a number, so it cannot be fitted")
    if bounds is None:
        if base is None or base <= 0:
            raise InvalidProblem.at(name, f"is {quote(base)}: give bounds for it")
        bounds = (base / 10, base * 10)
    try:
        low, high = (float(end) for end in bounds)
    except (TypeError, ValueError):
        raise InvalidProblem.at(name, f"{bounds!r} are not bounds; write (low, high)") from None
    return Parameter(name, low, high, base)


def _check_bounds(problem: Problem, parameter: Parameter) -> None:
    """Reject bounds outside the permitted range of the field."""
    for end in (parameter.low, parameter.high):
        try:
            problem.replace(**{parameter.name: end})
        except NoSteadyState:
            continue
        except InvalidProblem as fault:
            reasons = [text for field, text in fault.faults if field == parameter.name]
            if reasons:
                raise InvalidProblem.at(parameter.name, f"bounds: {reasons[0]}") from None


def _check_rows(problem: Problem, data: Measured) -> None:
    """Reject rows with invalid inputs; rows without a steady state are left to the fit."""
    columns = [values.tolist() for values in data.inputs.values()]
    for number, *row in zip(data.numbers, *columns, strict=bool(columns)):
        try:
            problem.replace(**dict(zip(data.inputs, row, strict=True)))
        except NoSteadyState:
            continue
        except InvalidProblem as fault:
            raise fault.under(f"{data.where}: row {number}") from None


def _check_units(quantities: Mapping[str, Quantity], data: Measured) -> None:
    """Reject outputs of different units without standard deviations."""
    units = {quantities[name].unit for name in data.outputs}
    if len(units) > 1 and set(data.deviations) != set(data.outputs):
        text = f"outputs of different units ({', '.join(sorted(units))}) need standard deviations"
        raise InvalidProblem.at("measured", text)
