"""Possible causes of systematic differences between measurement and prediction.

A difference is systematic if it is a mean difference (more than two standard uncertainties) or a
trend of the differences with a varied input (p < 0.01 of the regression line, larger than the error
budget, and neither an offset nor a factor).  Two kinds of causes are stated:

- inputs of the problem, with the change that would be needed by the derivatives D = dQ/d ln(input)
  of the predictions: mean(residual)/mean(D), or the ratio of the slopes of the regression lines.
  A solution with this change corrects it where the residual is largest.  An input that would have
  to change by more than a factor of two, or whose effect saturates, is no cause;
- effects that the problem does not contain, from ``explanations.toml``.

The data alone do not decide between them, and the cause may be another one.
"""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Iterator, Sequence
from functools import cache, cached_property
from math import isfinite, nan, sqrt
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import InvalidProblem, NotConverged
from ..problems.paths import get_field, is_part_of, parts_of
from ..problems.problem import Problem
from ..quantities import numbers_of, pure
from ..results import Result
from .compare_result import Comparison, Explanation
from .model import KindModel, quantities_of
from .observations import PRESSURE, RADIUS, TAB, TAB_FORCE, predict
from .predict import Case
from .slopes import on_mesh_of, solve_case

__all__ = ["InputEffects", "SolvedCase", "explain"]

Array = np.ndarray

SIGNIFICANT = 2.0  # standard uncertainties of a mean difference
P_VALUE = 0.01  # of a trend
FEWEST = 5  # values of a trend
LEAST_TREND = 0.01  # of the mean prediction, without standard deviations
OUTLYING = 4.0  # standard uncertainties of a single value
CONSTANT = 0.1  # relative scatter of a constant ratio
SMALLEST_CHANGE, LARGEST_CHANGE = -0.5, 1.0  # of an input, relative: a factor of two
# share of the change of a prediction by its derivative, below which the effect saturates
SMALLEST_SHARE = 0.5


class SolvedCase(NamedTuple):
    """A solved case, with the values that its result predicts."""

    case: Case
    result: Result


class InputEffects:
    """The effects of inputs that are not measured on all predictions of a comparison.

    Radii are left out, because they are known better than any other input.

    Parameters
    ----------
    model : KindModel
    measured : collection of str
        Inputs that are columns of the table.
    size : int
        Number m of measured values.
    solved : sequence of SolvedCase

    Attributes
    ----------
    quantities : dict of str to Quantity
        Of the inputs that are examined: all numbers of the problem except 0, measured and tied
        fields, and radii.
    """

    def __init__(
        self, model: KindModel, measured: Collection[str], size: int, solved: Sequence[SolvedCase]
    ) -> None:
        self.model, self.size, self.solved = model, size, solved
        left_out = (*measured, *model.tie)
        names = [
            path
            for path, value in numbers_of(model.problem).items()
            if value and not path.endswith("radius")
            if not any(is_part_of(path, name) for name in left_out)
        ]
        self.quantities = quantities_of(model, names)

    @cached_property
    def derivatives(self) -> dict[str, Array]:
        """Changes of the predictions per relative change of each input, dQ/d ln(input), (m,)."""
        names = list(self.quantities)
        values = np.array([get_field(self.model.problem, name) for name in names])
        changes = np.full((self.size, len(names)), nan)
        for case, result in self.solved:
            changes[case.rows] = case.slopes(self.model, result, names) * values
        return dict(zip(names, changes.T, strict=True))

    def causes(self, rows: Array, weights: Array, residual: Array) -> list[str]:
        """Return the changes of single inputs that would remove a difference, smallest first.

        Parameters
        ----------
        rows : (k,) int array
            Numbers of the compared values.
        weights : (k,) array
            The difference is ``weights @ residual``: a mean value, or the slope of a line.
        residual : (k,) array
            Measured minus predicted.
        """
        if self.model.kind.name == "winding":  # a derivative costs two of them
            return [
                "inputs are not examined for windings; spread= states the effect of one of them"
            ]
        with np.errstate(divide="ignore", invalid="ignore"):
            changes = {
                name: float(np.divide(weights @ residual, weights @ derivative[rows]))
                for name, derivative in self.derivatives.items()
            }
        largest = int(rows[np.argmax(np.abs(residual))])
        texts = []
        for name, change in sorted(changes.items(), key=lambda item: abs(item[1])):
            if not SMALLEST_CHANGE <= change <= LARGEST_CHANGE:
                continue
            linear = change * self.derivatives[name][largest]
            # nan if it cannot be solved, which fails both comparisons
            share = self._response(name, change, largest) / linear
            if share >= SMALLEST_SHARE and SMALLEST_CHANGE <= change / share <= LARGEST_CHANGE:
                texts.append(self._change_text(name, change / share))
        none = "no input alone: each would have to change by more than a factor of two"
        return texts or [none]

    def _response(self, name: str, change: float, k: int) -> float:
        """Return the change of prediction k by a relative change of an input; nan if unsolved."""
        case, result = next(each for each in self.solved if k in each.case.rows)
        observable = case.observables[case.rows.index(k)]
        inputs = {**case.inputs, name: (1 + change) * get_field(self.model.problem, name)}
        try:
            changed = solve_case(on_mesh_of(self.model, result), inputs, result)
            return predict(changed, observable) - predict(result, observable)
        except (InvalidProblem, NotConverged):
            return nan

    def _change_text(self, name: str, change: float) -> str:
        """Return a relative change of an input as text."""
        value = get_field(self.model.problem, name)
        ends = (value, (1 + change) * value)
        old, new = (self.quantities[name].stored_text(end) for end in ends)
        return f"{name} {100 * change:+.2g} %: {new} instead of {old}"


# ---- effects that the problem does not contain --------------------------------------------------


@cache
def _data_file() -> dict[str, Any]:
    """Return the classes of outputs and the effects of ``explanations.toml``."""
    path = Path(__file__).with_name("explanations.toml")
    return tomllib.loads(path.read_text(encoding="utf-8"))


def _class_of(output: str) -> str:
    """Return the class of an output: tension, width, pressure or length; '' for others."""
    if output.endswith("tension") or "tension_" in output:
        return "tension"
    classes = _data_file()["classes"].items()
    return next((name for name, outputs in classes if output in outputs), "")


def _effects_outside(problem: Problem, output: str, difference: str) -> list[str]:
    """Return the effects outside the problem that cause a difference of an output.

    Parameters
    ----------
    problem : Problem
        An effect is part of it if its field ``unless`` is set.
    output : str
    difference : str
        "larger", "smaller", or a trend: "falls with web_speed".  With the class of the output in
        front, "tension larger", it is an entry of ``explains``.
    """
    texts = []
    for effect in _data_file()["effects"]:
        is_contained = "unless" in effect and getattr(problem, effect["unless"], None) is not None
        if f"{_class_of(output)} {difference}" in effect["explains"] and not is_contained:
            texts.append(effect["text"])
    return texts


# ---- findings -----------------------------------------------------------------------------------


def explain(comparison: Comparison, inputs: InputEffects) -> tuple[Explanation, ...]:
    """Return the findings on all outputs with their possible causes."""
    findings: list[Explanation] = []
    for output in comparison.outputs:
        agreement = comparison.agreement(output)
        if agreement.size < 2:
            continue
        rows = np.nonzero(comparison.of(output))[0]
        trends = list(_trends(comparison, output, rows, inputs))
        findings += trends
        is_biased = abs(agreement.bias) > SIGNIFICANT * agreement.bias_uncertainty
        if is_biased:
            findings.append(_bias(comparison, output, rows, inputs))
        findings += _budget(comparison, output, rows)
        if not is_biased:
            findings += _common_sources(comparison, output, rows)
        findings += _outliers(comparison, output, rows)
        if not trends and not is_biased and isfinite(agreement.bias_uncertainty):
            findings.append(Explanation(output, "no systematic difference beyond the error budget"))
    return tuple(findings)


def _bias(comparison: Comparison, output: str, rows: Array, inputs: InputEffects) -> Explanation:
    """Return the explanation of a mean difference; ``rows`` (n,) are the values of the output."""
    agreement, residual = comparison.agreement(output), comparison.residual[rows]
    n = rows.size
    word = "larger" if agreement.bias > 0 else "smaller"
    count = int(np.sum(np.sign(residual) == np.sign(agreement.bias)))
    share = f"by {100 * abs(agreement.relative_bias):.2g} % of the mean"
    mean_weights = np.full(n, 1 / n)
    causes = [
        *inputs.causes(rows, mean_weights, residual),
        *_effects_outside(comparison.problem, output, word),
    ]
    ratio = comparison.measured[rows] / comparison.predicted[rows]
    is_constant = np.std(ratio) < CONSTANT * abs(np.mean(ratio))
    if _class_of(output) == "pressure" and is_constant and n >= FEWEST:
        text = f"the ratio is nearly constant ({np.mean(ratio):.2g}): the calibration of the tab"
        causes.insert(0, f"{text}, its coefficient of friction or area")
    finding = f"measured {word} than predicted {share}, in {count} of {n} values"
    return Explanation(output, finding, tuple(causes))


def _trends(
    comparison: Comparison, output: str, rows: Array, inputs: InputEffects
) -> Iterator[Explanation]:
    """Yield the explanations of trends with the varied inputs, and with the radius.

    ``rows`` (n,) are the numbers of the values of the output.
    """
    from scipy.stats import linregress

    varied = {name: values[rows] for name, values in comparison.inputs.items()}
    if np.isfinite(comparison.position[rows]).all():
        varied["radius"] = comparison.position[rows]
    residual, predicted = comparison.residual[rows], comparison.predicted[rows]
    mean = float(np.mean(predicted))
    budget = sqrt(float(np.mean(comparison.total[rows] ** 2)))
    threshold = budget if budget > 0 else LEAST_TREND * abs(mean)
    # neither an offset nor a wrong factor is a trend: it must show in y and in y/predicted
    measures = [residual]
    if np.all(predicted * mean > 0):
        measures.append(residual * mean / predicted)
    quantities = {**comparison.quantities, "radius": RADIUS}
    for name, x in varied.items():
        if x.size < FEWEST or np.unique(x).size < 3:
            continue
        lines = [linregress(x, values) for values in measures]
        changes = np.array([line.slope * np.ptp(x) for line in lines])
        sign = 1 if changes[0] > 0 else -1
        is_significant = all(line.pvalue < P_VALUE for line in lines)
        if not is_significant or min(sign * changes) <= threshold:
            continue
        word = "rises" if sign > 0 else "falls"
        ends = [quantities.get(name, pure("", name)).stored_text(end) for end in (min(x), max(x))]
        change = comparison.quantities[output].stored_text(abs(changes[0]))
        slope_weights = (x - x.mean()) / np.sum((x - x.mean()) ** 2)
        leaf = parts_of(name)[-1]  # explanations.toml has no dotted names
        yield Explanation(
            output,
            f"measured - predicted {word} by {change} with {name} from {ends[0]} to {ends[1]}",
            (
                *inputs.causes(rows, slope_weights, residual),
                *_effects_outside(comparison.problem, output, f"{word} with {leaf}"),
            ),
        )


def _budget(comparison: Comparison, output: str, rows: Array) -> Iterator[Explanation]:
    """Yield a finding on the error budget, if a part of it is unknown or mainly discretisation.

    The standard deviations of the measurement are unknown, or discretisation errors cause more than
    half of the squared budget.  ``rows`` (n,) are the numbers of the values of the output.
    """
    if np.isnan(comparison.deviation[rows]).any():
        readings = "no standard deviations of the measurement"
        if TAB in comparison.sources and output == PRESSURE:
            readings = (
                "that of the calibration is known, but the single readings of the pull tab have no "
                f"standard deviations (column '{TAB_FORCE} +-')"
            )
        yield Explanation(output, f"{readings}: the scatter of the rows stands in for them")
    elif np.nansum(comparison.error[rows] ** 2) > 0.5 * np.sum(comparison.total[rows] ** 2):
        text = (
            "the discretisation error is the largest part of the error budget: use a smaller rtol"
        )
        yield Explanation(output, text)


def _common_sources(comparison: Comparison, output: str, rows: Array) -> Iterator[Explanation]:
    """Yield the finding that only the uncertain inputs cover the mean difference.

    ``rows`` (n,) are the numbers of the values of the output.
    """
    if not comparison.sources:
        return
    agreement, common = comparison.agreement(output), comparison.effects[rows].mean(axis=0)
    # squared uncertainty of the mean difference from all other sources; < 0 only by rounding
    others = max(agreement.bias_uncertainty**2 - float(np.sum(common**2)), 0.0)
    if abs(agreement.bias) > SIGNIFICANT * sqrt(others):
        largest = comparison.sources[int(np.argmax(np.abs(common)))]
        text = (
            "the mean difference lies within the spread of the inputs; the largest contribution is "
            f"that of {largest}"
        )
        yield Explanation(output, text)


def _outliers(comparison: Comparison, output: str, rows: Array) -> Iterator[Explanation]:
    """Yield single values far outside the error budget while the others are inside.

    At most a fifth of the values are far outside, and four fifths of the others inside.  ``rows``
    (n,) are the numbers of the values of the output.
    """
    ratio = np.abs(comparison.ratio[rows])  # nan, which is neither, without standard deviations
    far = ratio > OUTLYING
    if ratio.size < FEWEST or not far.any() or far.sum() > 0.2 * ratio.size:
        return
    if np.mean(ratio[~far] <= SIGNIFICANT) < 0.8:
        return
    numbers = np.array(comparison.numbers)[rows][far]
    text = f"row {', '.join(map(str, numbers))}: more than {OUTLYING:g} standard uncertainties off"
    yield Explanation(output, text, ("the reading or the setting of this row is wrong",))
