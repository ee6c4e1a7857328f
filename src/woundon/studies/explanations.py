"""Possible causes of systematic differences between measurement and prediction.

A difference is systematic if it is a mean difference (more than two standard uncertainties) or a
trend of the differences with a varied input (p < 0.01 of the regression line, larger than the error
budget, and neither an offset nor a factor).  Two kinds of causes are stated:

- inputs of the problem, with the change that would be needed by the derivatives D = dQ/d ln(input)
  of the predictions: mean(residual)/mean(D), or the ratio of the slopes of the regression lines.
  A solution with this change corrects it where the residual is largest.  An input that would have
  to change by more than a factor of two, or whose effect saturates, is no cause;
- effects that the problem does not contain, from a table.

The data alone do not decide between them, and the cause may be another one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from ..problems.paths import parts_of
from ..quantities import in_chosen_units, length, pure
from .measurements import TAB, TAB_FORCE

__all__ = ["Explanation", "explain"]

Array = np.ndarray

SIGNIFICANT = 2.0  # standard uncertainties of a mean difference
P_VALUE = 0.01  # of a trend
FEWEST = 5  # values of a trend
LEAST_TREND = 0.01  # of the mean prediction, without standard deviations
OUTLYING = 4.0  # standard uncertainties of a single value
CONSTANT = 0.1  # relative scatter of a constant ratio
SMALLEST_CHANGE, LARGEST_CHANGE = -0.5, 1.0  # of an input, relative: a factor of two
SMALLEST_SHARE = (
    0.5  # of the change of a prediction by its derivative: below it the effect saturates
)
RADIUS = length("r", "radius of the measurement")

WIDTH, TENSION, PRESSURE, LENGTH = "width", "tension", "pressure", "length"
_CLASSES = {
    "half_width": WIDTH,
    "nip_width": WIDTH,
    "pressure": PRESSURE,
    "core_pressure": PRESSURE,
    "mid_pressure": PRESSURE,
    "wound_length": LENGTH,
}

_AIR = "entrained air, which this problem does not contain"  # only without air
_SLIPPING = (
    "the layers of the roll slip on each other, which the model of the roll does not contain"
)
_LOAD_CELL = "the load cell has an offset: check its zero"
_GAIN = "the gain of a load cell is wrong"

# Effects outside the problem: class of the output, varied input ("" for the mean difference), sign.
_EFFECTS: dict[tuple[str, str, int], tuple[str, ...]] = {
    (WIDTH, "", 1): (
        _SLIPPING,
        "a film or paper that records the width widens the print by its own thickness",
    ),
    (WIDTH, "", -1): (
        "a pressure-sensitive film does not show the low pressure at the edges of the nip",
    ),
    (TENSION, "", 1): (_LOAD_CELL,),
    (TENSION, "", -1): (
        _AIR,
        "bearings or idler rollers take tension between nip and load cell",
        _LOAD_CELL,
    ),
    (PRESSURE, "", 1): (
        "the tab disturbs the layers: extrapolate to a thinner tab, or calibrate it in a stack",
    ),
    (PRESSURE, "", -1): (_AIR, "the web or the stack relaxed between winding and measurement"),
    (LENGTH, "", 1): ("the diameter was read at a low place of an uneven roll",),
    (LENGTH, "", -1): (_AIR, "the length counter slips, or counts at a lower tension"),
    (TENSION, "web_speed", -1): (_AIR, "friction falls with the sliding speed"),
    (TENSION, "web_speed", 1): (
        "tension of centrifugal force (mass per area times speed squared) is in the reading",
    ),
    (TENSION, "web_tension", -1): (
        "tension is lost between its measurement and the nip: bearings, wraps, idler rollers",
        _GAIN,
    ),
    (TENSION, "web_tension", 1): (_GAIN,),
    (WIDTH, "nip_load", 1): (_SLIPPING,),
    (PRESSURE, "radius", -1): (_AIR,),
    (LENGTH, "radius", -1): (_AIR,),
}


class Explanation(NamedTuple):
    """A systematic difference and its possible causes.

    Attributes
    ----------
    output : str
    finding : str
        What the data show, with numbers.
    causes : tuple of str
        Possible causes, in no order; empty if the finding needs none.

    The texts have the usual units; :meth:`lines` converts them to the chosen ones.
    """

    output: str
    finding: str
    causes: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """Return finding and causes as lines of text."""
        head = f"{self.output}: {in_chosen_units(self.finding)}"
        if not self.causes:
            return [head]
        return [
            f"{head}. Possible causes:",
            *(f"  - {in_chosen_units(cause)}" for cause in self.causes),
        ]


class Inputs(NamedTuple):
    """Inputs of a problem that may explain differences.

    Attributes
    ----------
    derivatives : mapping of str to (m,) array
        Change of each prediction per relative change of an input, dQ/d ln(input).
    response : callable
        (name, relative change, k) -> change of the prediction k, from a solution; nan if the
        problem with the changed input has none.
    change_text : callable
        (name, relative change) -> the change as a text.
    note : str
        Why there are none; empty otherwise.
    """

    derivatives: Mapping[str, Array]
    response: Callable[[str, float, int], float]
    change_text: Callable[[str, float], str]
    note: str = ""


def explain(comparison: Any, inputs: Callable[[], Inputs]) -> tuple[Explanation, ...]:
    """Return the findings on all outputs with their possible causes.

    Parameters
    ----------
    comparison : Comparison
    inputs : callable
        Returns the inputs; called only for a systematic difference.
    """
    return tuple(
        entry for output in comparison.outputs for entry in _of_output(comparison, output, inputs)
    )


def _of_output(comparison: Any, output: str, inputs: Callable[[], Inputs]) -> Iterator[Explanation]:
    """Yield the findings on one output."""
    agreement = comparison.agreement(output)
    if agreement.size < 2:
        return
    rows = comparison.of(output)
    trends = list(_trends(comparison, output, rows, inputs))
    yield from trends
    significant = abs(agreement.bias) > SIGNIFICANT * agreement.bias_uncertainty
    if significant:
        yield _bias(comparison, output, rows, inputs)
    yield from _budget(comparison, output, rows, significant)
    yield from _outliers(comparison, output, rows)
    if not significant and not trends and agreement.bias_uncertainty == agreement.bias_uncertainty:
        yield Explanation(output, "no systematic difference beyond the error budget")


def _causes(
    comparison: Any,
    output: str,
    varied: str,
    needed: float,
    inputs: Inputs,
    measure: Callable[[Array], float],
) -> tuple[str, ...]:
    """Return the inputs that explain a difference, and the effects outside the problem.

    Parameters
    ----------
    varied : str
        Name of the varied input of a trend; empty for the mean difference.
    needed : float
        The mean difference, or the slope of the trend.
    measure : callable
        The same measure of an (m,) array: its mean, or its slope.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        changes = {
            name: float(np.divide(needed, measure(derivative)))
            for name, derivative in inputs.derivatives.items()
        }
    rows = np.nonzero(comparison.of(output))[0]
    k = int(rows[np.argmax(np.abs(comparison.residual[rows]))])
    texts = []
    for name, change in sorted(changes.items(), key=lambda item: abs(item[1])):
        if SMALLEST_CHANGE <= change <= LARGEST_CHANGE:
            share = inputs.response(name, change, k) / (change * inputs.derivatives[name][k])
            if share >= SMALLEST_SHARE and SMALLEST_CHANGE <= change / share <= LARGEST_CHANGE:
                texts.append(inputs.change_text(name, change / share))
    none = inputs.note or "no input alone: each would have to change by more than a factor of two"
    has_air = getattr(comparison.problem, "air", None) is not None
    effects = _EFFECTS.get((_class_of(output), parts_of(varied)[-1], 1 if needed > 0 else -1), ())
    outside = [effect for effect in effects if effect != _AIR or not has_air]
    return (*(texts or [none]), *outside)


def _class_of(output: str) -> str:
    """Return the class of an output: width, tension, pressure or length; empty for others."""
    return (
        TENSION if output.endswith("tension") or "tension_" in output else _CLASSES.get(output, "")
    )


def _bias(comparison: Any, output: str, rows: Array, inputs: Callable[[], Inputs]) -> Explanation:
    """Return the explanation of a mean difference."""
    agreement, residual = comparison.agreement(output), comparison.residual[rows]
    sign = 1 if agreement.bias > 0 else -1
    count = int(np.sum(np.sign(residual) == sign))
    word = "larger" if sign > 0 else "smaller"
    share = f"by {100 * abs(agreement.relative_bias):.2g} % of the mean"
    share += f", in {count} of {agreement.size} values"
    causes = _causes(
        comparison, output, "", agreement.bias, inputs(), lambda y: float(np.mean(y[rows]))
    )
    ratio = comparison.measured[rows] / comparison.predicted[rows]
    constant = np.std(ratio) < CONSTANT * abs(np.mean(ratio))
    if _class_of(output) == PRESSURE and constant and agreement.size >= FEWEST:
        text = f"the ratio is nearly constant ({np.mean(ratio):.2g}): the calibration of the tab"
        causes = (f"{text}, its coefficient of friction or area", *causes)
    return Explanation(output, f"measured {word} than predicted {share}", causes)


def _trends(
    comparison: Any, output: str, rows: Array, inputs: Callable[[], Inputs]
) -> Iterator[Explanation]:
    """Yield the explanations of trends with the varied inputs, and with the radius."""
    from scipy.stats import linregress

    places = {name: values[rows] for name, values in comparison.inputs.items()}
    if np.isfinite(comparison.position[rows]).all():
        places["radius"] = comparison.position[rows]
    y, predicted = comparison.residual[rows], comparison.predicted[rows]
    mean = float(np.mean(predicted))
    budget = sqrt(float(np.mean(comparison.total[rows] ** 2)))
    threshold = budget if budget > 0 else LEAST_TREND * abs(mean)
    # neither an offset nor a wrong factor is a trend: it must show in y and in y/predicted
    measures = [y, y * mean / predicted] if np.all(predicted * mean > 0) else [y]
    quantities = {**comparison.quantities, "radius": RADIUS}
    for name, x in places.items():
        if x.size < FEWEST or np.unique(x).size < 3:
            continue
        lines = [linregress(x, values) for values in measures]
        changes = [float(line.slope) * float(np.ptp(x)) for line in lines]
        sign = 1 if changes[0] > 0 else -1
        if not all(
            line.pvalue < P_VALUE and sign * change > threshold
            for line, change in zip(lines, changes, strict=True)
        ):
            continue
        word = "rises" if sign > 0 else "falls"
        quantity = quantities.get(name, pure("", name))
        ends = " to ".join(quantity.stored_text(end) for end in (x.min(), x.max()))
        text = comparison.quantities[output].stored_text(abs(changes[0]))
        finding = f"measured - predicted {word} by {text} with {name} from {ends}"
        slope = float(lines[0].slope)
        yield Explanation(
            output,
            finding,
            _causes(
                comparison,
                output,
                name,
                slope,
                inputs(),
                lambda y, x=x: float(linregress(x, y[rows]).slope),  # type: ignore[misc]
            ),
        )


def _budget(comparison: Any, output: str, rows: Array, significant: bool) -> Iterator[Explanation]:
    """Yield findings from the parts of the error budget."""
    agreement = comparison.agreement(output)
    if np.isnan(comparison.deviation[rows]).any():
        calibrated = TAB in comparison.sources and output == PRESSURE
        readings = (
            "that of the calibration is known, but the single readings of the pull tab have no "
            f"standard deviations (column '{TAB_FORCE} +-')"
            if calibrated
            else "no standard deviations of the measurement"
        )
        yield Explanation(output, f"{readings}: the scatter of the rows stands in for them")
    elif np.nansum(comparison.error[rows] ** 2) > 0.5 * np.sum(comparison.total[rows] ** 2):
        text = (
            "the discretisation error is the largest part of the error budget: use a smaller rtol"
        )
        yield Explanation(output, text)
    common = comparison.effects[rows].mean(axis=0) if comparison.sources else np.zeros(0)
    if common.size and not significant:
        rest2 = max(agreement.bias_uncertainty**2 - float(np.sum(common**2)), 0.0)
        if abs(agreement.bias) > SIGNIFICANT * sqrt(rest2):
            largest = comparison.sources[int(np.argmax(np.abs(common)))]
            text = (
                "the mean difference lies within the spread of the inputs; the largest "
                f"contribution is that of {largest}"
            )
            yield Explanation(output, text)


def _outliers(comparison: Any, output: str, rows: Array) -> Iterator[Explanation]:
    """Yield single values far outside the error budget while the others are inside."""
    ratio = np.abs(comparison.ratio[rows])
    far = ratio > OUTLYING
    if ratio.size < FEWEST or not far.any() or far.sum() > 0.2 * ratio.size:
        return
    if np.mean(ratio[~far] <= SIGNIFICANT) < 0.8:
        return
    numbers = np.array(comparison.numbers)[rows][far]
    text = f"row {', '.join(map(str, numbers))}: more than {OUTLYING:g} standard uncertainties off"
    yield Explanation(output, text, ("the reading or the setting of this row is wrong",))
