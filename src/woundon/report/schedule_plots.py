"""The figure of an optimised schedule: the roll or winding before and after."""

from __future__ import annotations

from typing import Any

from .margin_plots import Bars
from .panels import Panel, cases_of, draw_panels
from .plots import panels_of

__all__ = ["plot_schedule"]


def plot_schedule(optimised: Any, path: Any = None, choice: Any = None) -> Any:
    """Plot a winding before and after the optimisation of its schedule."""
    cases = cases_of([optimised.before, optimised.after], ["before", "after"])
    panels = panels_of(optimised.after)
    panels["reserves"] = Panel(Bars(optimised), "reserves", width=4.2, height=3.2)
    return draw_panels(panels, cases, path, choice=choice)
