"""Figures of a comparison: measured against predicted values, and residuals with their budget."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from ..roll.result import RollResult
from .figures import COLOURS, axis_label, quantity_of
from .panels import Case, Panel, draw_panels

if TYPE_CHECKING:
    from ..quantities import Quantity
    from ..studies.compare import Comparison

__all__ = ["plot_comparison"]

RESIDUALS = "_residuals"


def plot_comparison(
    comparison: Comparison,
    path: Any = None,
    ax: Axes | None = None,
    panels: str | Sequence[str] | None = None,
) -> Any:
    """Plot measured against predicted values of each output, and the residuals below.

    Parameters
    ----------
    comparison : Comparison
    path, ax, panels
        As of :func:`~woundon.report.panels.draw_panels`; a panel has the name of its output,
        and the panel of its residuals that name with "_residuals" appended.
    """
    known = {}
    for output in comparison.outputs:
        known[output] = Panel(partial(_draw_agreement, output), output, 3.6, 3.2)
        # below the agreement, but along another quantity: a column of its own
        known[output + RESIDUALS] = Panel(
            partial(_draw_residuals, output), output + RESIDUALS, 3.8, 3.2
        )
    return draw_panels(known, [Case(comparison)], path, ax, panels, lettered=False)


def _draw_agreement(output: str, axes: Axes, cases: Sequence[Case]) -> list[Any]:
    """Plot measured over predicted values of an output, with error bars."""
    comparison = cases[0].result
    rows, quantity = comparison.of(output), comparison.quantities[output]
    x, y = quantity.shown(comparison.predicted[rows]), quantity.shown(comparison.measured[rows])
    model = np.hypot(np.nan_to_num(comparison.error[rows]), comparison.spread[rows])
    axes.errorbar(
        x,
        y,
        xerr=_error_bars(quantity, model),
        yerr=_error_bars(quantity, comparison.deviation[rows]),
        fmt="o",
        color=COLOURS[0],
        markersize=4,
        elinewidth=0.9,
        label="two standard deviations",
    )
    ends = [min(x.min(), y.min()), max(x.max(), y.max())]
    axes.plot(ends, ends, color="#888888", linewidth=0.8)
    name = quantity.meaning.partition(",")[0]
    axes.set_xlabel(axis_label(f"predicted {name}", quantity))
    axes.set_ylabel(axis_label(f"measured {name}", quantity))
    return []


def _error_bars(quantity: Quantity, deviation: np.ndarray) -> np.ndarray:
    """Return two standard deviations in the unit for display."""
    return np.asarray(2 * np.abs(quantity.shown(np.nan_to_num(deviation))))


def _draw_residuals(output: str, axes: Axes, cases: Sequence[Case]) -> list[Any]:
    """Plot the residuals of an output with their uncertainty and mean."""
    comparison = cases[0].result
    rows, quantity = comparison.of(output), comparison.quantities[output]
    at, text = _abscissa(comparison, rows)
    residual = quantity.shown(comparison.residual[rows])
    bars = axes.errorbar(
        at,
        residual,
        yerr=_error_bars(quantity, comparison.total[rows]),
        fmt="o",
        color=COLOURS[0],
        markersize=4,
        elinewidth=0.9,
        label="two standard uncertainties",
    )
    axes.axhline(0.0, color="#888888", linewidth=0.8)
    bias = quantity.shown(comparison.agreement(output).bias)
    mean = axes.axhline(bias, color=COLOURS[1], linestyle="--", label="mean")
    axes.set_xlabel(text)
    axes.set_ylabel(axis_label("measured - predicted", quantity))
    return [bars, mean]


def _abscissa(comparison: Comparison, rows: np.ndarray) -> tuple[np.ndarray, str]:
    """Return the abscissa of the residuals: radius, the most varied input, or the row."""
    if np.isfinite(comparison.position[rows]).all():
        radius = quantity_of(RollResult, "radius")
        return radius.shown(comparison.position[rows]), axis_label("radius", radius)
    counts = {name: np.unique(values[rows]).size for name, values in comparison.inputs.items()}
    name = max(counts, key=lambda key: counts[key], default="")
    if counts.get(name, 0) < 2:
        return np.array(comparison.numbers)[rows], "row"
    quantity = comparison.quantities[name]
    return quantity.shown(comparison.inputs[name][rows]), axis_label(
        name.replace("_", " "), quantity
    )
