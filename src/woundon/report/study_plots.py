"""Figures of studies, from their panels."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..studies.compare import Comparison
from ..studies.experiment import NextExperiment
from ..studies.find import FindResult
from ..studies.fit_result import FitResult
from ..studies.schedule import OptimisedSchedule
from ..studies.sobol import SobolIndices
from ..studies.window_result import OperatingWindow
from .drawing import check_axes, show_panels
from .panels import Axis, Bars, Mark, Panel
from .result_panels import chosen, named_panels
from .study_panels import (
    comparison_panels,
    find_panels,
    fit_panels,
    indices_panels,
    plan_panels,
    window_panels,
)
from .sweep_panels import plot_sweep

if TYPE_CHECKING:
    from ..winding.margins import Margins

__all__ = ["plot_study"]

PANELS: Mapping[type[Any], Callable[[Any], list[Panel]]] = {
    Comparison: comparison_panels,
    FindResult: find_panels,
    FitResult: fit_panels,
    NextExperiment: plan_panels,
    OperatingWindow: window_panels,
    SobolIndices: indices_panels,
}


def plot_study(study: Any, *options: Any) -> Figure | Axes:
    """Plot a study; options as of its method ``plot``."""
    if isinstance(study, OptimisedSchedule):
        return _plot_schedule(study, *options)
    if type(study) not in PANELS:
        return plot_sweep(study, *options)
    return _plot(PANELS[type(study)](study), *options)


def _plot(
    panels: list[Panel],
    path: str | Path | None = None,
    ax: Axes | None = None,
    choice: str | Sequence[str] | None = None,
) -> Figure | Axes:
    """Plot the panels of a study, or those that are chosen by name."""
    check_axes(ax, choice)
    known = {panel.name: panel for panel in panels}
    names = known if choice is None else chosen(choice, list(known))
    return show_panels([[known[name]] for name in names], path=path, ax=ax, lettered=False)


def _plot_schedule(
    study: OptimisedSchedule,
    path: str | Path | None = None,
    ax: Axes | None = None,
    choice: str | Sequence[str] | None = None,
) -> Figure | Axes:
    """Plot a roll or winding before and after the optimisation of its schedule."""
    check_axes(ax, choice)
    makers = named_panels(study.after)
    default = [name for name, maker in makers.items() if maker.by_default and name != "reserves"]
    names = [*default, "reserves"] if choice is None else chosen(choice, [*makers, "reserves"])
    panels = [
        _reserves(study.margins_before, study.margins_after)
        if name == "reserves"
        else [makers[name].make(result) for result in (study.before, study.after)]
        for name in names
    ]
    return show_panels(panels, ["before", "after"], path, ax)


def _reserves(before: Margins, after: Margins) -> list[Panel]:
    """Return the panel of the reserves of both schedules, as bars next to each other."""
    names = tuple(margin.name for margin in after if margin.checked)
    panel = Panel(
        "reserves",
        "Reserves of the margins",
        Axis("Reserve, share of the limit, at most 100 [%]"),
        Axis("", limits=(len(names) - 0.4, -0.6), names=names),
        marks=(Mark("y", 0.0, colour="alarm", alone=False),),
        column="reserves",
        width=4.2,
    )
    shares = [
        100 * np.clip([margins[name].reserve for name in names], -1, 1)
        for margins in (before, after)
    ]
    bars = [Bars("", shares[0], -0.2, "roll"), Bars("", shares[1], 0.2, "drum")]
    return [replace(panel, bars=(each,)) for each in bars]
