"""The figure of an inverse problem: the output over the field, the target and the solutions."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from .figures import COLOURS, axis_label, wrapped_text
from .panels import Case, Panel, draw_panels

if TYPE_CHECKING:
    from ..studies.find import FindResult

__all__ = ["plot_find"]

DECADE = 10.0  # from this ratio of the ends the field has a logarithmic axis


def plot_find(
    outcome: FindResult,
    path: str | Path | None = None,
    ax: Axes | None = None,
    panels: str | Sequence[str] | None = None,
) -> Any:
    """Plot the output over the field with the target and the solutions.

    Parameters
    ----------
    outcome : FindResult
    path, ax, panels
        As of :func:`~woundon.report.panels.draw_panels`.
    """
    known = {"scan": Panel(_draw_scan, "scan", 5.2, 3.4)}
    return draw_panels(known, [Case(outcome)], path, ax, panels, lettered=False)


def _draw_scan(axes: Axes, cases: Sequence[Case]) -> list[Any]:
    """Plot the points of the search, the target and the solutions."""
    outcome = cases[0].result
    field, output = outcome.quantities[outcome.name], outcome.quantities[outcome.output]
    x, y = field.shown(outcome.values), output.shown(outcome.outputs)
    (curve,) = axes.plot(x, y, ".-", color=COLOURS[0], label="scan")
    handles = [curve]
    failed = ~np.isfinite(outcome.outputs)
    if failed.any():
        at = np.full(int(failed.sum()), 0.02)
        handles += axes.plot(
            x[failed],
            at,
            "x",
            color=COLOURS[6],
            transform=axes.get_xaxis_transform(),
            label="no solution of the problem",
        )
    target = axes.axhline(
        output.shown(outcome.target), color=COLOURS[1], linestyle="--", label="target"
    )
    values = [field.shown(value) for value, _ in outcome.solutions]
    handles.append(target)
    handles += axes.plot(
        values,
        [output.shown(outcome.target)] * len(values),
        "o",
        color=COLOURS[1],
        markerfacecolor="white",
        label="solution",
    )
    if outcome.values[0] > 0 and outcome.values[-1] / outcome.values[0] >= DECADE:
        axes.set_xscale("log")
    axes.set_xlabel(axis_label(wrapped_text(field.meaning, 60), field))
    axes.set_ylabel(axis_label(wrapped_text(output.meaning, 36), output))
    return handles
