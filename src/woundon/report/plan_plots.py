"""The figure of a plan: expected standard errors of the parameters after each measurement."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from .figures import COLOURS, wrapped_text
from .panels import Case, Panel, draw_panels

if TYPE_CHECKING:
    from ..studies.experiment import NextExperiment

__all__ = ["plot_plan"]


def plot_plan(
    plan: NextExperiment,
    path: Any = None,
    ax: Axes | None = None,
    panels: str | Sequence[str] | None = None,
) -> Any:
    """Plot the expected relative standard errors against the measurements, best first.

    Parameters
    ----------
    plan : NextExperiment
    path, ax, panels
        As of :func:`~woundon.report.panels.draw_panels`; the only panel is "plan".
    """
    height = 2.0 + 0.45 * len(plan.measurements)
    known = {"plan": Panel(_draw_plan, "plan", 7.0, height)}
    return draw_panels(known, [Case(plan)], path, ax, panels, lettered=False)


def _draw_plan(axes: Axes, cases: Sequence[Case]) -> list[Any]:
    """Plot the expected standard errors after each measurement of a plan."""
    plan = cases[0].result
    steps = np.arange(len(plan.measurements) + 1)
    handles: list[Any] = []
    for j, name in enumerate(plan.names):
        errors = 100 * plan.standard_errors[:, j]
        colour = COLOURS[j % len(COLOURS)]
        handles += axes.plot(errors, steps, "o-", color=colour, markersize=4, label=name)
    if plan.output_value:
        errors = 100 * plan.output_errors / abs(plan.output_value)
        handles += axes.plot(
            errors,
            steps,
            "s--",
            color="black",
            markersize=4,
            markerfacecolor="white",
            label=f"{plan.output} at the operating point",
        )
    names = ["now", *(wrapped_text(measurement.name, 34) for measurement in plan.measurements)]
    axes.set_yticks(steps, names)
    axes.set_ylim(steps[-1] + 0.4, -0.4)
    axes.set_xscale("log")
    axes.set_xlabel("expected relative standard error after the measurement [%]")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.grid(axis="x", which="both", alpha=0.3)
    # names of fields are too long for the row of the figure's own legend
    axes.legend(handles=handles, loc="lower center", bbox_to_anchor=(0.3, 1.0), fontsize="small")
    return []
