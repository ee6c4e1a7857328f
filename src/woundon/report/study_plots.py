"""Figures of studies, from their panels."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..studies.compare_result import Comparison
from ..studies.find import FindResult
from ..studies.fit_result import FitResult
from ..studies.master_curve import MasterCurve
from ..studies.outcome import Outcome
from ..studies.plan_result import NextExperiment
from ..studies.schedule import OptimisedSchedule
from ..studies.sobol import SobolIndices
from ..studies.stack_fit import StackFit
from ..studies.winder_log import WinderLog
from ..studies.window_result import OperatingWindow
from .drawing import check_axes, show_panels
from .measured_panels import log_panels, stack_panels
from .moduli_panels import master_curve_panels
from .panels import Axis, Bars, Mark, Panel, axis_of_names
from .result_panels import chosen, named_panels
from .study_panels import (
    comparison_panels,
    find_panels,
    fit_panels,
    indices_panels,
    plan_panels,
    window_panels,
)

if TYPE_CHECKING:
    from ..winding.margins import Margins

__all__ = ["plot_study"]

PANELS: Mapping[type[Any], Callable[[Any], list[Panel]]] = {
    Comparison: comparison_panels,
    FindResult: find_panels,
    FitResult: fit_panels,
    MasterCurve: master_curve_panels,
    NextExperiment: plan_panels,
    OperatingWindow: window_panels,
    SobolIndices: indices_panels,
    StackFit: stack_panels,
    WinderLog: log_panels,
}


def plot_study(
    study: Outcome,
    path: str | Path | None = None,
    ax: Axes | None = None,
    choice: str | Sequence[str] | None = None,
) -> Figure | Axes:
    """Plot the panels of a study, or those that are chosen by name."""
    check_axes(ax, choice)
    if isinstance(study, OptimisedSchedule):
        return show_panels(_schedule_panels(study, choice), ["before", "after"], path, ax)
    known = {panel.name: panel for panel in PANELS[type(study)](study)}
    names = known if choice is None else chosen(choice, list(known))
    return show_panels([[known[name]] for name in names], path=path, ax=ax, lettered=False)


def _schedule_panels(
    study: OptimisedSchedule, choice: str | Sequence[str] | None
) -> list[list[Panel]]:
    """Return the panels of a roll or winding, each before and after the optimisation."""
    makers = named_panels(study.after)
    default = [name for name, maker in makers.items() if maker.by_default and name != "reserves"]
    names = [*default, "reserves"] if choice is None else chosen(choice, [*makers, "reserves"])
    return [
        _reserves(study.margins_before, study.margins_after)
        if name == "reserves"
        else [makers[name].make(result) for result in (study.before, study.after)]
        for name in names
    ]


def _reserves(before: Margins, after: Margins) -> list[Panel]:
    """Return the panel of the reserves before and after, whose bars are next to each other."""
    names = [margin.name for margin in after if margin.checked]
    panel = Panel(
        "reserves",
        Axis("Reserve, share of the limit, at most 100 [%]"),
        axis_of_names([after[name].title for name in names]),
        marks=(Mark("y", 0.0, colour="alarm", alone=False),),
        width=5.2,
    )
    shares = [
        100 * np.clip([margins[name].reserve for name in names], -1, 1)
        for margins in (before, after)
    ]
    bars = [
        Bars("", shares[0], shift=-0.2, colour="roll"),
        Bars("", shares[1], shift=0.2, colour="drum"),
    ]
    return [replace(panel, bars=(each,)) for each in bars]
