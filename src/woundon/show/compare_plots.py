"""Figures of a comparison: measured against predicted values, and residuals with their budget."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from .figures import COLOURS, axis_label, unit_of
from .panels import Case, Panel, drawn

if TYPE_CHECKING:
    from ..quantities import Quantity
    from ..studies.compare import Comparison

__all__ = ["plot_comparison"]

RESIDUALS = "_residuals"


def plot_comparison(
    found: Comparison, path: Any = None, ax: Axes | None = None,
    panels: str | Sequence[str] | None = None,
) -> Any:  # fmt: skip
    """Draw measured against predicted values of each output, and below them the residuals.

    Parameters
    ----------
    found : Comparison
    path, ax, panels
        As of :func:`~woundon.show.panels.drawn`; a panel has its output's name, the residuals have
        "_residuals" behind it.
    """
    known = {}
    for output in found.outputs:
        known[output] = Panel(partial(_draw_agreement, output), output, 3.6, 3.2)
        # below the agreement, but along another quantity: a column of its own
        known[output + RESIDUALS] = Panel(
            partial(_draw_residuals, output), output + RESIDUALS, 3.8, 3.2
        )
    return drawn(known, [Case(found)], path, ax, panels, lettered=False)


def _draw_agreement(output: str, axes: Axes, cases: Sequence[Case]) -> list[Any]:
    found = cases[0].result
    rows, quantity = found.of(output), found.quantities[output]
    x, y = quantity.shown(found.predicted[rows]), quantity.shown(found.measured[rows])
    model = np.hypot(np.nan_to_num(found.error[rows]), found.spread[rows])
    axes.errorbar(
        x, y, xerr=_bars(quantity, model), yerr=_bars(quantity, found.deviation[rows]),
        fmt="o", color=COLOURS[0], markersize=4, elinewidth=0.9, label="two standard deviations",
    )  # fmt: skip
    ends = [min(x.min(), y.min()), max(x.max(), y.max())]
    axes.plot(ends, ends, color="#888888", linewidth=0.8)
    name = output.replace("_", " ")
    axes.set_xlabel(axis_label(f"predicted {name}", quantity))
    axes.set_ylabel(axis_label(f"measured {name}", quantity))
    return []


def _bars(quantity: Quantity, deviation: np.ndarray) -> np.ndarray:
    """Return two standard deviations in the unit for display."""
    return np.asarray(2 * np.abs(quantity.shown(np.nan_to_num(deviation))))


def _draw_residuals(output: str, axes: Axes, cases: Sequence[Case]) -> list[Any]:
    found = cases[0].result
    rows, quantity = found.of(output), found.quantities[output]
    at, text = _along(found, rows)
    residual = quantity.shown(found.residual[rows])
    bars = axes.errorbar(
        at, residual, yerr=_bars(quantity, found.total[rows]), fmt="o", color=COLOURS[0],
        markersize=4, elinewidth=0.9, label="two standard uncertainties",
    )  # fmt: skip
    axes.axhline(0.0, color="#888888", linewidth=0.8)
    bias = quantity.shown(found.agreement(output).bias)
    mean = axes.axhline(bias, color=COLOURS[1], linestyle="--", label="mean")
    axes.set_xlabel(text)
    axes.set_ylabel(f"measured - predicted [{unit_of(quantity)}]".replace(" []", ""))
    return [bars, mean]


def _along(found: Comparison, rows: np.ndarray) -> tuple[np.ndarray, str]:
    """Return what the residuals are drawn over: radius, the most varied input, or the row."""
    if np.isfinite(found.position[rows]).all():
        return 1e3 * found.position[rows], "radius [mm]"
    counts = {name: np.unique(values[rows]).size for name, values in found.inputs.items()}
    name = max(counts, key=lambda each: counts[each], default="")
    if counts.get(name, 0) < 2:
        return np.array(found.numbers)[rows], "row"
    quantity = found.quantities[name]
    return quantity.shown(found.inputs[name][rows]), axis_label(name.replace("_", " "), quantity)
