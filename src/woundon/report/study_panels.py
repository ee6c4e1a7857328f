"""The panels of studies: find, fits, comparisons, plans, Sobol' indices and operating windows."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ..problems.paths import get_field
from ..problems.winding import SCHEDULES
from ..quantities import Quantity
from ..roll.result import RollResult
from ..studies.window_result import LEVELS, OperatingWindow
from ..winding.margins import TITLES
from .panels import SERIES, Axis, Bars, Contour, Curve, Map, Mark, Panel, Regions, axis_of_names
from .report_parts import quantity_of

if TYPE_CHECKING:
    from ..studies.compare_result import Comparison
    from ..studies.find import FindResult
    from ..studies.fit_result import FitResult
    from ..studies.plan_result import NextExperiment
    from ..studies.profiles import ProfileLikelihood
    from ..studies.sobol import SobolIndices

__all__ = [
    "comparison_panels",
    "find_panels",
    "fit_panels",
    "in_words",
    "indices_panels",
    "is_logarithmic",
    "named_axis",
    "plan_panels",
    "window_panels",
]

Array = np.ndarray
LINES = ("dotted", "dashed", "solid")  # of the levels of the probability in a window
MARKERS = ("circle", "square", "triangle", "diamond", "point")  # of the outputs of a fit


def is_logarithmic(values: Array) -> bool:
    """Return True if values are spaced by factors rather than by steps."""
    if values.size < 3 or values.min() <= 0 or values.max() / values.min() < 10:
        return False
    # evenly spaced values have their median in the middle; by factors, it lies well below
    middle = 0.5 * (values.min() + values.max())
    return bool(np.median(values) < middle * 0.7)


def in_words(name: str, quantity: Quantity | None) -> str:
    """Return the meaning of a field or output, of a field of a part with that part.

    >>> from woundon.quantities import length
    >>> in_words("upper.radius", length("R", "outer radius, without web")), in_words("a_b", None)
    ('outer radius (upper)', 'a b')
    """
    part, _, last = name.replace("_", " ").rpartition(".")
    words = last if quantity is None else quantity.meaning.partition(",")[0]
    return f"{words} ({part.replace('.', ' ')})" if part else words


def named_axis(name: str, quantity: Quantity | None, values: Array | None = None) -> Axis:
    """Return the axis of a field or output; logarithmic if values along it are spaced by factors.

    Parameters
    ----------
    name : str
        Dotted name.
    quantity : Quantity or None
        None if it is not a number.
    values : array, optional
        Along the axis.
    """
    log = values is not None and is_logarithmic(values)
    return Axis(in_words(name, quantity), quantity, log=log)


def _diagonal(*values: Array) -> Curve:
    """Return the line of equal values on both axes, from the smallest to the largest value."""
    ends = np.array([min(each.min() for each in values), max(each.max() for each in values)])
    return Curve("equal", ends, ends, colour="soft", width=0.8, in_legend=False)


# ---- find ---------------------------------------------------------------------------------------


def find_panels(outcome: FindResult) -> list[Panel]:
    """Return the panel of the output over the field, with the target and the solutions.

    Points of the scan that have no solution are crosses at the lower edge of the curve.
    """
    field, output = outcome.quantities[outcome.name], outcome.quantities[outcome.output]
    values, target = outcome.values, outcome.target
    failed = ~np.isfinite(outcome.outputs)
    lowest = min(float(np.nanmin(outcome.outputs)), target)
    solutions = np.array([value for value, _ in outcome.solutions])
    curves = [Curve(outcome.output, values, outcome.outputs, label="scan", marker="point")]
    if failed.any():
        label = "no solution of the problem"
        at = np.full(int(failed.sum()), lowest)
        curves.append(
            Curve("", values[failed], at, label=label, colour="ink", line="none", marker="cross")
        )
    reached = np.full(solutions.size, target)
    curves.append(
        Curve("", solutions, reached, label="solution", colour="drum", line="none", marker="ring")
    )
    return [
        Panel(
            "scan",
            named_axis(outcome.name, field, values),
            named_axis(outcome.output, output),
            curves=tuple(curves),
            marks=(Mark("x", target, "target", colour="drum", line="dashed"),),
            width=5.2,
            height=3.4,
        )
    ]


# ---- fits and comparisons -----------------------------------------------------------------------


def fit_panels(fit: FitResult) -> list[Panel]:
    """Return the panel of fitted against measured values, and a profile of each parameter."""
    return [_agreement(fit), *(_profile(fit, profile) for profile in fit.profiles)]


def _agreement(fit: FitResult) -> Panel:
    """Return the panel of fitted over measured values; all outputs of a fit have one SI unit."""
    outputs = list(dict.fromkeys(fit.row_outputs))
    curves = []
    for k, output in enumerate(outputs):
        rows = np.array([name == output for name in fit.row_outputs])
        curves.append(
            Curve(
                output,
                fit.measured[rows],
                fit.fitted[rows],
                label=in_words(output, fit.quantities.get(output)),
                colour=SERIES[k % len(SERIES)],
                line="none",
                marker=MARKERS[k % len(MARKERS)],
            )
        )
    first = fit.quantities.get(outputs[0])
    return Panel(
        "agreement",
        Axis("measured", first),
        Axis("fitted", first),
        curves=(*curves, _diagonal(fit.measured, fit.fitted)),
        width=3.3,
        legend="inside",
    )


def _profile(fit: FitResult, profile: ProfileLikelihood) -> Panel:
    """Return the panel of the profile likelihood of a parameter."""
    quantity = fit.quantities.get(fit.row_outputs[0])
    label, rms = "RMS of the fit", None if fit.weighted else quantity
    if fit.weighted:
        label += " [standard deviations]"
    return Panel(
        profile.name,
        named_axis(profile.name, fit.quantities.get(profile.name), profile.values),
        Axis(label, rms),
        curves=(
            Curve(
                profile.name,
                profile.values,
                profile.rms,
                label="others refitted" if len(fit.names) > 1 else "profile",
                marker="point",
            ),
        ),
        marks=(Mark("x", profile.rms_limit, "95 % limit", colour="drum", line="dashed"),),
        width=3.3,
        legend="inside",
    )


def comparison_panels(comparison: Comparison) -> list[Panel]:
    """Return the panels of measured against predicted values of each output, and residuals."""
    return [
        panel(comparison, output)
        for output in comparison.outputs
        for panel in (_measured_and_predicted, _residuals)
    ]


def _measured_and_predicted(comparison: Comparison, output: str) -> Panel:
    """Return the panel of measured over predicted values of an output, with error bars."""
    rows, quantity = comparison.of(output), comparison.quantities[output]
    predicted, measured = comparison.predicted[rows], comparison.measured[rows]
    # an unknown error or deviation counts as zero
    model = np.hypot(np.nan_to_num(comparison.error[rows]), comparison.spread[rows])
    deviation = np.nan_to_num(comparison.deviation[rows])
    points = _with_error_bars(output, predicted, measured, 2 * deviation, 2 * model)
    name = in_words(output, quantity)
    return Panel(
        output,
        Axis(f"predicted {name}", quantity),
        Axis(f"measured {name}", quantity),
        curves=(points, _diagonal(predicted, measured)),
        width=3.6,
    )


def _with_error_bars(
    name: str, x: Array, y: Array, y_error: Array, x_error: Array | None = None
) -> Curve:
    """Return points with error bars, two standard uncertainties long, where some are known.

    Lengths that are all zero are not known: such points have no bars.  All arrays are (n,).
    """
    known = y_error.any() or (x_error is not None and x_error.any())
    points = Curve(name, x, y, line="none", marker="circle")
    if not known:
        return points
    label = "two standard uncertainties"
    return replace(points, label=label, x_error=x_error, y_error=y_error)


def _residuals(comparison: Comparison, output: str) -> Panel:
    """Return the panel of the residuals of an output with their mean.

    Bars are two standard uncertainties; there is none where that is not known.
    """
    rows, quantity = comparison.of(output), comparison.quantities[output]
    x, axis = _abscissa(comparison, rows)
    total = np.nan_to_num(comparison.total[rows])
    points = _with_error_bars(output, x, comparison.residual[rows], 2 * total)
    bias = comparison.agreement(output).bias
    # no column is named: the x axis is not that of the measured and predicted values
    return Panel(
        f"{output}_residuals",
        axis,
        Axis("measured - predicted", quantity),
        curves=(points,),
        marks=(
            Mark(along="x", value=0.0),
            Mark(along="x", value=bias, label="mean", colour="drum", line="dashed"),
        ),
        width=3.8,
    )


def _abscissa(comparison: Comparison, rows: Array) -> tuple[Array, Axis]:
    """Return the abscissa of the residuals and its axis.

    It is the radius, else the input with the most different values, else the number of the row.
    ``rows`` is the mask of the rows that measure the output.
    """
    if np.isfinite(comparison.position[rows]).all():
        return comparison.position[rows], Axis("radius", quantity_of(RollResult, "radius"))
    counts = {name: np.unique(values[rows]).size for name, values in comparison.inputs.items()}
    name = max(counts, key=lambda key: counts[key], default="")
    if counts.get(name, 0) < 2:
        return np.array(comparison.numbers)[rows], Axis("row")
    return comparison.inputs[name][rows], named_axis(name, comparison.quantities[name])


# ---- plans and indices --------------------------------------------------------------------------


def plan_panels(plan: NextExperiment) -> list[Panel]:
    """Return the panel of the relative standard errors expected after each measurement."""
    steps = np.arange(len(plan.measurements) + 1.0)  # 0 is the state before the first measurement
    curves = [
        Curve(
            name,
            100 * plan.standard_errors[:, k],
            steps,
            label=in_words(name, plan.quantities.get(name)),
            colour=SERIES[k % len(SERIES)],
            marker="circle",
        )
        for k, name in enumerate(plan.names)
    ]
    if plan.output_value:
        errors = 100 * plan.output_errors / abs(plan.output_value)
        output = in_words(plan.output, plan.quantities.get(plan.output))
        label = f"{output} at the operating point"
        look = Curve(plan.output, errors, steps, label=label, colour="ink", line="dashed")
        curves.append(replace(look, marker="square"))
    names = ["now", *(measurement.name for measurement in plan.measurements)]
    x = Axis("expected relative standard error after the measurement [%]", log=True)
    return [
        Panel(
            "plan",
            x,
            axis_of_names(names, room=0.4),
            curves=tuple(curves),
            width=7.0,
            height=2.0 + 0.45 * len(plan.measurements),
            legend="stacked",
        )
    ]


def indices_panels(indices: SobolIndices) -> list[Panel]:
    """Return a panel per output of first-order and total indices as bars with intervals.

    The input that explains most, with its interactions, stands on top.
    """
    panels, known = [], indices.table.quantities
    for k, output in enumerate(indices.outputs):
        # arrays of indices are (outputs, inputs), those of intervals (2, outputs, inputs)
        order = np.argsort(-indices.total_order[k], kind="stable")
        alone, total = indices.first_order[k, order], indices.total_order[k, order]
        inputs = [indices.inputs[j] for j in order]
        names = [in_words(name, known.get(name)) for name in inputs]
        words = in_words(output, known.get(output))
        bars = (
            Bars(
                "alone (first order)",
                alone,
                shift=-0.2,
                colour="roll",
                interval=indices.first_interval[:, k, order],
            ),
            Bars(
                "with interactions (total)",
                total,
                shift=0.2,
                colour="sky",
                interval=indices.total_interval[:, k, order],
            ),
        )
        panels.append(
            Panel(
                output,
                Axis("share of the variance, with 95 % intervals"),
                axis_of_names(names),
                bars=bars,
                heading=words,
                height=0.42 * len(names) + 1.0,
                column="indices",
                legend="figure below",
            )
        )
    return panels


# ---- operating windows --------------------------------------------------------------------------


def window_panels(window: OperatingWindow) -> list[Panel]:
    """Return the panel of the probability over the regions of the binding margins.

    With a third set point, it shows the level of the best point.
    """
    best, heading = window.best, ""
    # of (x, y[, level]), turned to ([level, ]y, x): maps have y before x
    probability, binding = window.probability.T, window.binding.T
    if len(window.names) == 3:
        name = window.names[2]
        level = int(np.argmin(np.abs(window.axes[2] - best.values[name])))
        probability, binding = probability[level], binding[level]
        value = window.quantities[name].text(float(window.axes[2][level]), ".3g")
        heading = f"{in_words(name, window.quantities[name])} {value}"
    x, y = window.axes[0], window.axes[1]
    # the last region is that without a solution
    margins = [f"binding: {TITLES.get(name, name)}" for name in window.margins]
    regions = Regions(
        x,
        y,
        np.where(binding < 0, len(margins), binding),
        (*margins, "no steady state, or not solved"),
        # six colours: the seventh, ink, is that of the point
        (*(SERIES[k % 6] for k in range(len(margins))), "soft"),
    )
    contours = tuple(
        Contour(level, f"probability {level:g}", line)
        for level, line in zip(LEVELS, LINES, strict=True)
    )
    best_x, best_y = (np.array([best.values[name]]) for name in window.names[:2])
    point = Curve(
        "",
        best_x,
        best_y,
        label=f"largest probability, {best.probability:.2f}",
        colour="ink",
        line="none",
        marker="ring",
    )
    return [
        Panel(
            "window",
            _set_point_axis(window, 0),
            _set_point_axis(window, 1),
            curves=(point,),
            map=Map(x, y, probability, contours),
            regions=regions,
            heading=heading,
            width=7.2,
            height=4.2,
            legend="right",
        )
    ]


def _set_point_axis(window: OperatingWindow, k: int) -> Axis:
    """Return the axis of a set point; the values of a schedule are those at the core.

    A field that is one number has the same value at every radius.
    """
    name, values = window.names[k], window.axes[k]
    quantity = window.quantities[name]
    is_schedule = name in SCHEDULES and not isinstance(get_field(window.problem, name), float)
    place = ", at the core" if is_schedule else ""
    return Axis(f"{quantity.meaning}{place}", quantity, limits=(values[0], values[-1]))
