"""The figure of an optimised schedule: the roll or winding before and after."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.axes import Axes

from .margin_plots import Bars
from .panels import Panel, cases_of, draw_panels
from .plots import panels_of

if TYPE_CHECKING:
    from ..studies.schedule import OptimisedSchedule

__all__ = ["plot_schedule"]


def plot_schedule(
    optimised: OptimisedSchedule,
    path: str | Path | None = None,
    ax: Axes | None = None,
    panels: str | Sequence[str] | None = None,
) -> Any:
    """Plot a winding before and after the optimisation of its schedule.

    Parameters
    ----------
    optimised : OptimisedSchedule
    path, ax, panels
        As of :func:`~woundon.report.panels.draw_panels`; the panels are those of the result and
        "reserves".
    """
    cases = cases_of([optimised.before, optimised.after], ["before", "after"])
    known = panels_of(optimised.after)
    known["reserves"] = Panel(Bars(optimised), "reserves", width=4.2, height=3.2)
    return draw_panels(known, cases, path, ax, panels)
