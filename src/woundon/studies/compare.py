"""Compare a measured table with predictions, and find what may explain the differences.

Steps: the rows of the table, the cases that they belong to, predictions with error estimates and
the effects of uncertain inputs, explanations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import isfinite, isnan, nan
from typing import Any, NamedTuple

import numpy as np

from ..arguments import check_arguments, check_type
from ..errors import InvalidProblem, NotConverged, unwarned
from ..io.sheets import TableSource
from ..problems.paths import get_field, number_in_si, varied_number
from ..problems.problem import Problem
from .compare_result import Comparison
from .explanations import InputEffects, SolvedCase, explain
from .model import KindModel, model_of, solver_options
from .observations import (
    TAB,
    Observations,
    definitions,
    error_at,
    predict,
    read_deviation,
    read_observations,
)
from .predict import Case, cases_of, with_input_scatter
from .progress import Progress, progress_reporter
from .pull_tab import PullTab
from .slopes import solve_case
from .winder_log import WinderLog

__all__ = ["compare"]

Array = np.ndarray


def compare(
    problem: Problem,
    measured: TableSource | WinderLog,
    *,
    tab: PullTab | None = None,
    spread: Mapping[str, float | str] | None = None,
    columns: Mapping[str, str | None] | None = None,
    tie: Mapping[str, str] | None = None,
    nodes: int | None = None,
    rtol: float | None = None,
    options: Mapping[str, Any] | None = None,
    progress: bool | Progress = False,
) -> Comparison:
    """Compare measured values with the predictions for a problem of any kind.

    Parameters
    ----------
    problem : Problem
        The base case, with the fields that are not columns of the table.
    measured : path, mapping or pandas.DataFrame
        CSV or Excel file with units in its header, or columns by name, SI if they have no unit:
        inputs ("nip_load [kN/m]"), outputs ("wound_on_tension [N/m]", "nip_width [mm]") and the
        standard deviations of both ("nip_width +- [mm]").  Of a roll or a winding also arrays over
        the radius ("pressure [kPa]", "wound_on_tension [N/m]"), "pull_tab_force [N]" and
        "length [m]", with a column "measured_radius [mm]", "measured_diameter [mm]" or
        "diameter [mm]".  Or the log of a winder, from :func:`woundon.read_log`.
    tab : PullTab, optional
        Calibration of the pull tab.
    spread : mapping of str to float or str, optional
        Dotted name of a field -> its standard deviation, SI or a text: "1 MPa", or "10 %" of the
        value.
    columns, tie, nodes, rtol, options
        As of :func:`woundon.fit` and :func:`woundon.sweep`.
    progress : bool or callable
        Show the fraction that is done, or call with (states done, expected).

    Returns
    -------
    Comparison

    Raises
    ------
    InvalidProblem
        For invalid names, units or values, or if no row has a steady state.
    NotConverged
        If no row was solved, and the solver did not converge at one of them.

    Examples
    --------
    >>> import woundon as wo
    >>> rows = {"load [kN/m]": [50.0, 89.0], "nip_width [mm]": [0.54, 0.72]}
    >>> check = wo.compare(wo.RollerProblem.example(), rows, spread={"upper.radius": "1 %"})
    >>> [round(float(value) * 1e3, 2) for value in check.predicted]  # mm
    [0.53, 0.71]
    """
    check_arguments(spread=spread)
    if tab is not None:
        check_type("tab", tab, PullTab)
    data = read_observations(problem, measured, columns, tab)
    scalars = dict.fromkeys(name for name, radius in data.observables if isnan(radius))
    options = solver_options(nodes, rtol, options)
    # a model needs an output; arrays over the radius are none
    model = model_of(problem, tuple(scalars) or ("residual",), tie, options)
    deviations = {name: _deviation(problem, name, value) for name, value in (spread or {}).items()}
    model.check_varied([*data.inputs, *deviations])
    data = with_input_scatter(model, data)
    repeated = sorted(set(data.inputs) & set(deviations))
    if repeated:
        raise InvalidProblem.at(f"spread: {repeated[0]}", "is measured in a column of the table")
    covariates = _covariates(problem, data)
    with progress_reporter(progress, "comparing") as report:
        predictions = _predictions(model, data, covariates, deviations, report)
    sources, effects = tuple(deviations), predictions.effects
    if data.common.any():  # the calibration of a pull tab is a further uncertain input
        sources, effects = (*sources, TAB), np.column_stack([effects, data.common])
    comparison = Comparison(
        names=data.names,
        numbers=data.numbers,
        position=data.position,
        measured=data.measured,
        predicted=predictions.predicted,
        deviation=data.deviation,
        error=predictions.error,
        sources=sources,
        effects=effects,
        failures=predictions.failures,
        quantities=data.quantities,
        problem=problem,
        inputs=data.inputs_of_values,
        covariates=covariates,
        notes=tuple(definitions(predictions.solved[0].result, data.names)),
    )
    inputs = InputEffects(model, data.inputs, len(data.names), predictions.solved)
    return replace(comparison, explanations=explain(comparison, inputs))


class _Predictions(NamedTuple):
    """Predictions of the m values of a table, SI units.

    Attributes
    ----------
    predicted, error : (m,) arrays
        Predictions and their estimated discretisation errors; nan where a case has no solution.
    effects : (m, inputs) array
        Changes of the predictions by one standard deviation of each uncertain input.
    failures : tuple of str
        Why a value has no prediction, '' if it has one.
    solved : list of SolvedCase
        With the values that have a prediction only.
    """

    predicted: Array
    error: Array
    effects: Array
    failures: tuple[str, ...]
    solved: list[SolvedCase]


def _predictions(
    model: KindModel,
    data: Observations,
    covariates: Sequence[str],
    deviations: Mapping[str, float],
    report: Progress,
) -> _Predictions:
    """Solve the cases of a table, each with a warm start from the one before.

    Parameters
    ----------
    model : KindModel
    data : Observations
    covariates : sequence of str
        Columns that the problem does not depend on.
    deviations : mapping of str to float
        Standard deviations of the uncertain inputs, SI.
    report : callable
        Is called with the numbers of solved and of all cases.

    Raises
    ------
    InvalidProblem, NotConverged
        If there is no prediction at all.
    """
    m, names, sizes = len(data.names), list(deviations), np.array(list(deviations.values()))
    predicted, error, effects = np.full(m, nan), np.full(m, nan), np.zeros((m, len(names)))
    failures, converged, start = [""] * m, True, None  # converged: until one case does not
    solved: list[SolvedCase] = []
    varied = {name: v for name, v in data.inputs_of_values.items() if name not in covariates}
    cases = cases_of(varied, data.observables)
    for done, case in enumerate(cases):
        report(done, len(cases))
        try:
            start = result = solve_case(model, case.inputs, start)
        except (InvalidProblem, NotConverged) as fault:
            converged = converged and not isinstance(fault, NotConverged)
            for k in case.rows:
                failures[k] = str(fault).replace("\n", "; ")
            continue
        known = []  # (number of the value, observable) of those with a prediction
        for k, observable in zip(case.rows, case.observables, strict=True):
            try:
                predicted[k] = predict(result, observable)
                error[k] = error_at(result, observable)
            except InvalidProblem as fault:  # outside the roll, for example
                failures[k] = str(fault)
            if isfinite(predicted[k]):
                known.append((k, observable))
        if known:
            rows, observables = map(list, zip(*known, strict=True))
            predicted_case = Case(case.inputs, rows, observables)
            solved.append(SolvedCase(predicted_case, result))
            if names:
                effects[rows] = predicted_case.slopes(model, result, names) * sizes
    if not solved:
        reason = next((failure for failure in failures if failure), "the predictions are nan")
        text = f"no row of the table has a prediction; the first reason: {reason}"
        raise InvalidProblem.at(data.where, text) if converged else NotConverged(text)
    return _Predictions(predicted, error, effects, tuple(failures), solved)


def _covariates(problem: Problem, data: Observations) -> tuple[str, ...]:
    """Return the columns of optional fields that this problem does not use or admit."""
    names = []
    for name, values in data.inputs.items():
        if get_field(problem, name) is not None:
            continue
        try:
            with unwarned():
                texts = problem.replace(**{name: float(values[0])}).input_warnings
            # a remark says that nothing depends on the field
            if any(text.startswith(name) for text in texts if text not in problem.input_warnings):
                names.append(name)
        except InvalidProblem as fault:
            if any(path == name for path, _ in fault.faults):  # the field is not admitted
                names.append(name)
    return tuple(names)


def _deviation(problem: Problem, name: str, value: float | str) -> float:
    """Return the standard deviation of a field in SI."""
    where = f"spread: {name}"
    base = varied_number(problem, name, where)
    in_si = partial(number_in_si, problem, name, where=where)
    deviation, is_relative = read_deviation(value, in_si, where)
    return deviation * abs(base) if is_relative else deviation
