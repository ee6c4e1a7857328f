"""Measured tables against predictions: residuals with their error budget.

    residual = measured - predicted
    total^2 = deviation^2 + error^2 + spread^2

deviation: standard deviation of the measurement; error: estimated discretisation error; spread:
standard deviation of the prediction from those of uncertain inputs, s dQ/dx for each input x with
the standard deviation s.
Deviations are independent; errors and spreads are common to all rows, and do not average out.

Reference: Evaluation of measurement data - Guide to the expression of uncertainty in measurement,
JCGM 100:2008, sec. 5.1.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from math import isfinite, nan, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import InvalidProblem, NotConverged, unwarned
from ..problems.messages import quote
from ..problems.paths import field_quantity, get_field
from ..problems.problem import Problem
from ..problems.units import parse
from ..quantities import Quantity, in_chosen_units, walk
from .explanations import Explanation, Inputs, explain
from .measurements import (
    TAB,
    Observable,
    Observations,
    definitions,
    error_at,
    predict,
    read_observations,
)
from .model import KindModel, model_of
from .outcome import Outcome
from .predict import Case, cases_of
from .progress import Progress, progress_reporter
from .pull_tab import PullTab
from .slopes import on_mesh_of, slopes, solve_case

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Agreement", "Comparison", "compare"]

Array = np.ndarray


class Agreement(NamedTuple):
    """Agreement of a measured output with its predictions, SI units.

    Attributes
    ----------
    size : int
        Values that could be compared.
    bias, bias_uncertainty : float
        Mean residual and its standard uncertainty.
    relative_bias : float
        Mean residual over the mean of the predictions.
    rms, expected_rms : float
        Root mean square of the residuals, and of their total standard uncertainties.
    coverage : float
        Share of the residuals within two standard uncertainties, 0.95 is expected; nan without the
        standard deviations of the measurement.
    """

    size: int
    bias: float
    bias_uncertainty: float
    relative_bias: float
    rms: float
    expected_rms: float
    coverage: float


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Outcome):
    """Measured values, predictions and the error budget; m values, SI units.

    Attributes
    ----------
    names : tuple of str
        The output of each value.
    numbers : tuple of int
        Row of each value, as a spreadsheet shows it.
    position : (m,) array
        Radius [m]; nan of a value that belongs to no radius.
    measured, predicted : (m,) arrays
        The latter nan where the case has no solution.
    deviation, error : (m,) arrays
        Standard deviation of the measurement and estimated discretisation error; nan if not known.
    sources : tuple of str
        The uncertain inputs.
    effects : (m, sources) array
        What one standard deviation of each changes in the predictions.
    inputs : mapping of str to (m,) array
        The varied inputs of each value.
    covariates : tuple of str
        Those of them that the problem does not contain, such as the web speed of a nip without air:
        they are used for trends only.
    failures : tuple of str
        Why a value has no prediction, '' if it has one.
    notes : tuple of str
        Definitions of measured quantities that have two.
    quantities : mapping of str to Quantity
    explanations : tuple of Explanation
        Possible causes of systematic differences; the data do not decide between them.
    problem : Problem

    Examples
    --------
    >>> import woundon as wo
    >>> rows = {"load [kN/m]": [50.0, 89.0], "nip_width [mm]": [0.54, 0.72]}
    >>> check = wo.compare(wo.RollerProblem.example(), rows, nodes=33)
    >>> round(check.agreement("nip_width").bias * 1e3, 2)  # mm
    0.01
    """

    names: tuple[str, ...]
    numbers: tuple[int, ...]
    position: Array
    measured: Array
    predicted: Array
    deviation: Array
    error: Array
    sources: tuple[str, ...]
    effects: Array
    inputs: Mapping[str, Array]
    failures: tuple[str, ...]
    quantities: Mapping[str, Quantity]
    problem: Any
    covariates: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    explanations: tuple[Explanation, ...] = field(default=())

    @property
    def outputs(self) -> tuple[str, ...]:
        """The measured outputs."""
        return tuple(dict.fromkeys(self.names))

    @property
    def residual(self) -> Array:
        """Measured minus predicted, (m,)."""
        return self.measured - self.predicted

    @property
    def spread(self) -> Array:
        """Standard deviation of the predictions from that of the inputs, (m,)."""
        return np.asarray(np.sqrt(np.sum(self.effects**2, axis=1)))

    @property
    def total(self) -> Array:
        """Standard uncertainty of the residuals, (m,); unknown parts count as zero."""
        known = [np.nan_to_num(self.deviation), np.nan_to_num(self.error), self.spread]
        return np.asarray(np.sqrt(np.sum(np.square(known), axis=0)))

    @property
    def ratio(self) -> Array:
        """Residual over its standard uncertainty, (m,); nan without that of the measurement."""
        return np.asarray(self.residual / np.where(np.isnan(self.deviation), nan, self.total))

    def of(self, output: str) -> Array:
        """Return the mask of the values of an output that have a prediction, (m,) of bool.

        Raises
        ------
        InvalidProblem
            If it is none of the measured outputs.
        """
        if output not in self.names:
            known = ", ".join(self.outputs)
            raise InvalidProblem.at(output, f"not a measured output; known: {known}")
        return np.array([name == output for name in self.names]) & np.isfinite(self.predicted)

    def agreement(self, output: str) -> Agreement:
        """Return the agreement of an output with its predictions."""
        rows = self.of(output)
        n = int(rows.sum())
        if n == 0:
            return Agreement(0, *[nan] * 6)
        residual, total = self.residual[rows], self.total[rows]
        bias = float(residual.mean())
        deviation = self.deviation[rows]
        scatter = float(residual.std(ddof=1)) if n > 1 else nan
        # the scatter of the rows stands in for deviations that are not known
        random = np.where(np.isnan(deviation), np.nan_to_num(scatter), deviation)
        common = self.effects[rows].mean(axis=0)
        error = float(np.nan_to_num(self.error[rows]).mean())
        uncertainty = sqrt(float(np.sum(random**2)) / n**2 + float(np.sum(common**2)) + error**2)
        mean = float(np.mean(self.predicted[rows]))
        coverage = nan if np.isnan(deviation).any() else np.mean(np.abs(residual) <= 2 * total)
        return Agreement(
            n,
            bias,
            uncertainty,
            bias / mean if mean else nan,
            _rms(residual),
            _rms(total),
            float(coverage),
        )

    def __repr__(self) -> str:
        texts = []
        for output in self.outputs:
            agreement = self.agreement(output)
            texts.append(
                f"{output}: {agreement.size} values, {100 * agreement.relative_bias:+.2g} %"
            )
        return f"Comparison({'; '.join(texts)})"

    def answer(self) -> list[str]:
        """Return the agreement of the first output as a line of text."""
        return [self._agreement_text(self.outputs[0])]

    def remarks(self) -> list[str]:
        """Return the agreement of further outputs, failures, notes and possible explanations."""
        texts = [self._agreement_text(output) for output in self.outputs[1:]]
        failed = [pair for pair in zip(self.numbers, self.failures, strict=True) if pair[1]]
        if failed:
            number, reason = failed[0]
            count = "1 value" if len(failed) == 1 else f"{len(failed)} values"
            why = in_chosen_units(reason)
            texts.append(f"{count} without a prediction, e.g. row {number}: {why}")
        for name in self.covariates:
            texts.append(f"{name} is not part of this problem: it is used for trends only")
        texts += [in_chosen_units(note) for note in self.notes]
        return [*texts, *(line for entry in self.explanations for line in entry.lines())]

    def _agreement_text(self, output: str) -> str:
        """Return the agreement of an output as a line."""
        agreement, quantity = self.agreement(output), self.quantities[output]
        if agreement.size == 0:
            return f"{output}: no value with a prediction"

        uncertainty = agreement.bias_uncertainty  # zero if no part of it is known
        parts = [
            f"{output}: {agreement.size} {'value' if agreement.size == 1 else 'values'}",
            f"measured - predicted {quantity.text(agreement.bias, '+.3g')} "
            + (f"± {quantity.text(uncertainty, '.3g')} " if uncertainty else "")
            + f"({100 * agreement.relative_bias:+.2g} %)",
            f"RMS {quantity.text(agreement.rms, '.3g')}",
        ]
        if agreement.coverage == agreement.coverage:
            parts.append(f"expected {quantity.text(agreement.expected_rms, '.3g')}")
            parts.append(f"{100 * agreement.coverage:.0f} % within two standard uncertainties")
        return ", ".join(parts)

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each measured value: prediction, residual and its budget, SI units."""
        import pandas as pd

        columns: dict[str, Any] = {"row": self.numbers, "output": self.names}
        if np.isfinite(self.position).any():
            columns["measured_radius"] = self.position
        columns |= dict(self.inputs)
        columns |= {
            "measured": self.measured,
            "predicted": self.predicted,
            "residual": self.residual,
            "deviation": self.deviation,
            "error": self.error,
            "spread": self.spread,
            "total": self.total,
            "ratio": self.ratio,
            "failure": self.failures,
        }
        frame = pd.DataFrame(columns)
        frame.insert(2, "unit", [self.quantities[name].unit for name in self.names])
        return frame

    def table(self) -> list[str]:
        """Return all values as lines of text, in units for display."""
        head = f"{'row':>5}  {'output':20} {'measured':>11} {'predicted':>11} {'residual':>11}"
        texts = [f"{head} {'uncertainty':>11}  unit"]
        columns = (self.measured, self.predicted, self.residual)
        for k, (number, name) in enumerate(zip(self.numbers, self.names, strict=True)):
            quantity = self.quantities[name]
            cells = " ".join(f"{quantity.shown(column[k]):11.5g}" for column in columns)
            # zero if no part of it is known
            total = float(self.total[k])
            cells += f" {quantity.shown(total):11.5g}" if total else f" {'-':>11}"
            note = f"  {in_chosen_units(self.failures[k])}" if self.failures[k] else ""
            texts.append(f"{number:5}  {name:20} {cells}  {quantity.display}{note}")
        return texts

    def _record(self) -> dict[str, Any]:
        return {
            "values": self.to_dataframe().to_dict(orient="records"),
            "agreement": {name: self.agreement(name)._asdict() for name in self.outputs},
            "sources": list(self.sources),
            "explanations": [entry._asdict() for entry in self.explanations],
        }


def compare(
    problem: Problem,
    measured: Any,
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
        inputs ("nip_load [kN/m]"), outputs ("wound_on_tension [N/m]", "nip_width [mm]") and their
        standard deviations ("nip_width +- [mm]").  Of a roll or a winding also arrays over the
        radius ("pressure [kPa]", "wound_on_tension [N/m]"), "pull_tab_force [N]" and "length [m]",
        with a column "measured_radius [mm]", "measured_diameter [mm]" or "diameter [mm]".
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
    data = read_observations(problem, measured, columns, tab)
    settings = {"nodes": nodes, "rtol": rtol, **(options or {})}
    scalars = tuple(
        dict.fromkeys(
            name for name, place in zip(data.names, data.position, strict=True) if place != place
        )
    )
    model = model_of(problem, scalars or ("residual",), tie, settings)
    deviations = {name: _deviation(problem, name, value) for name, value in (spread or {}).items()}
    model.check_varied([*data.inputs, *deviations])
    repeated = sorted(set(data.inputs) & set(deviations))
    if repeated:
        raise InvalidProblem.at(f"spread: {repeated[0]}", "is measured in a column of the table")
    covariates = _covariates(problem, data)
    with progress_reporter(progress, "comparing") as report:
        predicted, error, effects, failures, solved = _predictions(
            model, data, covariates, deviations, report
        )
    effects[np.isnan(predicted)] = 0.0
    sources = (*deviations, *([TAB] if data.common.any() else []))
    if data.common.any():
        effects = np.column_stack([effects, data.common])
    comparison = Comparison(
        names=data.names,
        numbers=data.numbers,
        position=data.position,
        measured=data.measured,
        predicted=predicted,
        deviation=data.deviation,
        error=error,
        sources=sources,
        effects=effects,
        failures=failures,
        quantities=data.quantities,
        problem=problem,
        inputs={name: values[data.rows] for name, values in data.inputs.items()},
        covariates=covariates,
        notes=tuple(definitions(solved[0].result, data.names)) if solved else (),
    )
    inputs = cache(lambda: _inputs(model, data, solved))
    return replace(comparison, explanations=explain(comparison, inputs))


def _predictions(
    model: KindModel,
    data: Observations,
    covariates: Sequence[str],
    deviations: Mapping[str, float],
    report: Progress,
) -> tuple[Array, Array, Array, tuple[str, ...], list[_Solved]]:
    """Return predictions, their errors, effects of the input spreads, failures, and results.

    Raises
    ------
    InvalidProblem, NotConverged
        If there is no prediction at all.
    """
    m = len(data.names)
    predicted, error, effects = np.full(m, nan), np.full(m, nan), np.zeros((m, len(deviations)))
    failures, converged, start = [""] * m, True, None
    solved: list[_Solved] = []
    varied = {k: v for k, v in data.inputs_of_values.items() if k not in covariates}
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
        for k, observable in zip(case.rows, case.observables, strict=True):
            try:
                predicted[k] = predict(result, observable)
                error[k] = error_at(result, observable)
            except InvalidProblem as fault:
                failures[k] = str(fault)
        effects[case.rows] = _effects(model, case, result, deviations)
        solved.append(_Solved(case, result))
    if np.isnan(predicted).all():
        reason = next((failure for failure in failures if failure), "the predictions are nan")
        text = f"no row of the table has a prediction; the first reason: {reason}"
        raise InvalidProblem.at(data.where, text) if converged else NotConverged(text)
    return predicted, error, effects, tuple(failures), solved


def _inputs(model: KindModel, data: Observations, solved: Sequence[_Solved]) -> Inputs:
    """Return the inputs that are not measured, with the derivatives of all predictions.

    Radii are left out, because they are known better than any other input.
    """
    problem = model.problem
    known = "|".join(re.escape(name) for name in (*data.inputs, *model.tie))
    left_out = re.compile(rf"(.*radius|({known or '(?!)'})(\..*)?)")
    quantities = {
        place.path: place.quantity
        for place in walk(problem)
        if isinstance(place.value, float) and place.value and place.quantity is not None
        if not left_out.fullmatch(place.path)
    }

    def change_text(name: str, change: float) -> str:
        value = get_field(problem, name)
        old, new = (quantities[name].stored_text(end) for end in (value, (1 + change) * value))
        return f"{name} {100 * change:+.2g} %: {new} instead of {old}"

    def response(name: str, change: float, k: int) -> float:
        case, result = next(each for each in solved if k in each.case.rows)
        value = (1 + change) * get_field(problem, name)
        observable = data.observables[k]
        try:
            changed = solve_case(on_mesh_of(model, result), {**case.inputs, name: value}, result)
            return predict(changed, observable) - predict(result, observable)
        except (InvalidProblem, NotConverged):
            return nan

    if hasattr(model.kind.result, "roll"):  # each derivative costs two windings
        note = "inputs are not examined for windings; spread= states the effect of one of them"
        return Inputs({}, response, change_text, note)
    derivatives = {name: np.full(len(data.names), nan) for name in quantities}
    values = {name: get_field(problem, name) for name in quantities}
    for case, result in solved:
        effects = _effects(model, case, result, values)
        for name, column in zip(quantities, effects.T, strict=True):
            derivatives[name][case.rows] = column
    return Inputs(derivatives, response, change_text)


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
            if any(path == name for path, _ in fault.faults):
                names.append(name)
    return tuple(names)


class _Solved(NamedTuple):
    """A solved case."""

    case: Case
    result: Any


def _deviation(problem: Problem, name: str, value: float | str) -> float:
    """Return the standard deviation of a field in SI."""
    base = get_field(problem, name)
    quantity = field_quantity(problem, name)
    if quantity is None or not isinstance(base, float):
        raise InvalidProblem.at(f"spread: {name}", f"{quote(base)} is not a number")
    if isinstance(value, str) and value.strip().endswith("%"):
        deviation = parse(value, "1", f"spread: {name}") * abs(base)
    else:
        deviation = parse(value, quantity.unit, f"spread: {name}")
    if not 0 < deviation < np.inf:
        text = f"{quote(value)} is out of range; must be a standard deviation > 0"
        raise InvalidProblem.at(f"spread: {name}", text)
    return deviation


def _effects(model: KindModel, case: Case, result: Any, deviations: Mapping[str, float]) -> Array:
    """Return the changes of the predictions by one standard deviation of each input.

    Returns
    -------
    (values of the case, inputs) array
        Zero for values that the result does not predict, such as those outside the roll.
    """
    effects = np.zeros((len(case.rows), len(deviations)))
    known = [j for j, observable in enumerate(case.observables) if _is_known(result, observable)]
    if known and deviations:
        observables, names = [case.observables[j] for j in known], list(deviations)
        effects[known] = slopes(
            model, result, observables, names, case.inputs, nan_if_unsolved=True
        )
    return effects * np.array(list(deviations.values()))


def _is_known(result: Any, observable: Observable) -> bool:
    """Return True if a result predicts an observable."""
    try:
        return isfinite(predict(result, observable))
    except InvalidProblem:
        return False


def _rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))
