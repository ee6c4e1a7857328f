"""The figure of an optimised schedule: the roll or winding before and after."""

from __future__ import annotations

from typing import Any

from .margin_plots import Bars
from .panels import Panel, cases_of, drawn
from .plots import panels_of

__all__ = ["plot_schedule"]


def plot_schedule(found: Any, path: Any = None, choice: Any = None) -> Any:
    """Plot a winding before and after the optimisation of its schedule."""
    cases = cases_of([found.before, found.after], ["before", "after"])
    panels = panels_of(found.after)
    panels["reserves"] = Panel(Bars(found), "reserves", width=4.2, height=3.2)
    return drawn(panels, cases, path, choice=choice)
