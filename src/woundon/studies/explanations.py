"""Rules that name possible causes of systematic differences between measurement and prediction.

A rule applies if a pattern is significant: a mean difference (more than two standard uncertainties)
or a trend of the differences with a varied input (p < 0.01 of the regression line, larger than the
error budget, and neither an offset nor a factor).  A rule names causes that are known to produce
the pattern; the data alone do not decide between them, and the cause may be another one.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from ..quantities import length, pure
from .measurements import TAB, TAB_FORCE

__all__ = ["Explanation", "explain"]

Array = np.ndarray

SIGNIFICANT = 2.0  # standard uncertainties of a mean difference
P_VALUE = 0.01  # of a trend
FEWEST = 5  # values of a trend
LEAST_TREND = 0.01  # of the mean prediction, without standard deviations
OUTLYING = 4.0  # standard uncertainties of a single value
CONSTANT = 0.1  # relative scatter of a constant ratio
RADIUS = length("r", "radius of the measurement")

WIDTH, TENSION, PRESSURE, LENGTH = "width", "tension", "pressure", "length"
_CLASSES = {
    "half_width": WIDTH,
    "nip_width": WIDTH,
    "pressure": PRESSURE,
    "core_pressure": PRESSURE,
    "mid_pressure": PRESSURE,
    "length": LENGTH,
}

# class of the output, sign of measured - predicted -> possible causes
_BIAS: dict[tuple[str, int], tuple[str, ...]] = {
    (WIDTH, 1): (
        "the roll is softer than assumed: a smaller radial modulus, or less pressure in the roll",
        "the layers of the roll slip on each other, which the model of the roll does not contain",
        "the cover of the drum is softer than assumed",
        "a film or paper that records the width widens the print by its own thickness",
    ),
    (WIDTH, -1): (
        "the roll or the cover of the drum is stiffer than assumed",
        "a pressure-sensitive film does not show the low pressure at the edges of the nip",
    ),
    (TENSION, 1): (
        "the friction between web and roll, or between the layers, is larger than assumed",
        "the shear modulus of the roll differs from the assumed one",
        "the load cell has an offset: check its zero",
    ),
    (TENSION, -1): (
        "the friction between web and roll, or between the layers, is smaller than assumed",
        "entrained air reduces the friction in the nip",
        "bearings or idler rollers take tension between nip and load cell",
        "the load cell has an offset: check its zero",
    ),
    (PRESSURE, 1): (
        "the wound-on tension is larger than assumed",
        "the stack is stiffer in the radial direction than assumed",
        "the tab disturbs the layers: extrapolate to a thinner tab, or calibrate it in a stack",
    ),
    (PRESSURE, -1): (
        "the wound-on tension is smaller than assumed",
        "entrained air between the layers, or a stack that is softer than assumed",
        "the web or the stack relaxed between winding and measurement",
    ),
    (LENGTH, 1): (
        "the web is thinner than assumed, or its layers are more compressed",
        "the diameter was read at a low place of an uneven roll",
    ),
    (LENGTH, -1): (
        "entrained air between the layers, or a web that is thicker than assumed",
        "the length counter slips, or counts at a lower tension",
    ),
}

# class, end of the input's name, sign of the trend -> possible causes
_TRENDS: dict[tuple[str, str, int], tuple[str, ...]] = {
    (TENSION, "web_speed", -1): (
        "entrained air reduces the friction in the nip at high speed",
        "friction falls with the sliding speed",
    ),
    (TENSION, "web_speed", 1): (
        "the model contains more entrained air than there is: check the roughness of the web",
        "tension of centrifugal force (mass per area times speed squared) is in the reading",
    ),
    (TENSION, "nip_load", -1): (
        "the friction is smaller than assumed: the nip-induced tension saturates earlier",
        "the roll becomes stiffer under load than in the model",
    ),
    (TENSION, "nip_load", 1): (
        "the friction between web and roll is larger than assumed",
        "the shear modulus of the roll differs from the assumed one",
    ),
    (TENSION, "web_tension", -1): (
        "tension is lost between its measurement and the nip: bearings, wraps, idler rollers",
        "the gain of a load cell is wrong",
    ),
    (TENSION, "web_tension", 1): ("the gain of a load cell is wrong",),
    (WIDTH, "nip_load", 1): (
        "the layers of the roll begin to slip on each other under load",
        "the assumed stiffness of roll or cover is too large at high load",
    ),
    (WIDTH, "nip_load", -1): (
        "roll or cover harden under load, which a linear body does not describe",
    ),
    (PRESSURE, "radius", 1): (
        "the core is softer than assumed, so that the pressure near it is lower",
        "the taper of the wound-on tension is smaller than assumed",
    ),
    (PRESSURE, "radius", -1): (
        "the core is stiffer than assumed, so that the pressure near it is higher",
        "the taper of the wound-on tension is larger than assumed, or air enters as the roll grows",
    ),
    (LENGTH, "radius", 1): ("the web becomes thinner, or the layers more compressed, outwards",),
    (LENGTH, "radius", -1): ("more air is entrained as the roll grows",),
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
    """

    output: str
    finding: str
    causes: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """Return finding and causes as lines of text."""
        head = f"{self.output}: {self.finding}"
        if not self.causes:
            return [head]
        return [f"{head}. Possible causes:", *(f"  - {cause}" for cause in self.causes)]


def explain(comparison: Any) -> tuple[Explanation, ...]:
    """Return the findings on all outputs with their possible causes, by rules."""
    return tuple(entry for output in comparison.outputs for entry in _of_output(comparison, output))


def _of_output(comparison: Any, output: str) -> Iterator[Explanation]:
    """Yield the findings on one output."""
    agreement = comparison.agreement(output)
    if agreement.size < 2:
        return
    rows = comparison.of(output)
    causes = list(_trends(comparison, output, rows))
    yield from causes
    significant = abs(agreement.bias) > SIGNIFICANT * agreement.bias_uncertainty
    if significant:
        yield _bias(comparison, output, rows)
    yield from _budget(comparison, output, rows, significant)
    yield from _outliers(comparison, output, rows)
    if not significant and not causes and agreement.bias_uncertainty == agreement.bias_uncertainty:
        yield Explanation(output, "no systematic difference beyond the error budget")


def _class_of(output: str) -> str:
    """Return the class of an output: width, tension, pressure or length; empty for others."""
    return (
        TENSION if output.endswith("tension") or "tension_" in output else _CLASSES.get(output, "")
    )


def _bias(comparison: Any, output: str, rows: Array) -> Explanation:
    """Return the explanation of a mean difference."""
    agreement, residual = comparison.agreement(output), comparison.residual[rows]
    sign = 1 if agreement.bias > 0 else -1
    count = int(np.sum(np.sign(residual) == sign))
    word = "larger" if sign > 0 else "smaller"
    share = f"by {100 * abs(agreement.relative_bias):.2g} % of the mean"
    share += f", in {count} of {agreement.size} values"
    causes = list(_BIAS.get((_class_of(output), sign), ()))
    if getattr(comparison.problem, "air", None) is not None:
        causes = [c.replace("entrained air", "more entrained air than assumed") for c in causes]
    ratio = comparison.measured[rows] / comparison.predicted[rows]
    constant = np.std(ratio) < CONSTANT * abs(np.mean(ratio))
    if _class_of(output) == PRESSURE and constant and agreement.size >= FEWEST:
        text = f"the ratio is nearly constant ({np.mean(ratio):.2g}): the calibration of the tab"
        causes.insert(0, f"{text}, its coefficient of friction or area")
    return Explanation(output, f"measured {word} than predicted {share}", tuple(causes))


def _trends(comparison: Any, output: str, rows: Array) -> Iterator[Explanation]:
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
        ends = " to ".join(quantity.text(end) for end in (x.min(), x.max()))
        text = comparison.quantities[output].text(abs(changes[0]))
        finding = f"measured - predicted {word} by {text} with {name} from {ends}"
        causes = _TRENDS.get((_class_of(output), name.rpartition(".")[2], sign), ())
        yield Explanation(output, finding, causes)


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
