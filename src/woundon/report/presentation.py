"""Text, HTML and figures of results, margins, sensitivities, fits and study tables, by class.

The base class in :mod:`woundon.results` calls these functions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import singledispatch
from typing import TYPE_CHECKING, Any

from ..results import Result
from ..sensitivity import Sensitivity
from ..studies.outcome import Outcome
from ..winding.margins import Margins
from .html import parts_html, table_html
from .margins_report import margins_html, margins_text
from .result_report import report_parts, report_text
from .sensitivity_report import sensitivity_text

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["figure_of", "html_of", "html_of_table", "text_of"]


@singledispatch
def text_of(thing: Any) -> str:
    """Return a result, margins or a sensitivity as plain text; the lines of all others."""
    return "\n".join(thing.lines()) if hasattr(thing, "lines") else repr(thing)


text_of.register(Result, report_text)
text_of.register(Sensitivity, sensitivity_text)
text_of.register(Margins, margins_text)


@singledispatch
def html_of(thing: Any) -> str:
    """Return the same as HTML, for a notebook."""
    raise TypeError(f"a {type(thing).__name__} has no report")


html_of.register(Result, lambda result: parts_html(report_parts(result)))
html_of.register(Margins, margins_html)


@html_of.register
def _html_of_outcome(outcome: Outcome) -> str:
    """Return the first line, the table and the remarks of a study."""
    return table_html(outcome.answer()[0], outcome.table_for_display(), outcome.remarks())


def html_of_table(head: str, frame: pd.DataFrame, remarks: Iterable[str] = ()) -> str:
    """Return a table of numbers between its heading and remarks as HTML."""
    return table_html(head, frame, remarks)


def figure_of(thing: Any, *options: Any) -> Any:
    """Return the figure of a result or of a study."""
    # drawing takes half a second to import, and text does not need it
    if isinstance(thing, Result):
        from .plots import plot

        return plot(thing, *options)
    from ..studies.compare import Comparison
    from ..studies.experiment import NextExperiment
    from ..studies.find import FindResult
    from ..studies.fit_result import FitResult
    from ..studies.schedule import OptimisedSchedule
    from ..studies.sobol import SobolIndices
    from ..studies.window_result import OperatingWindow
    from .compare_plots import plot_comparison
    from .find_plots import plot_find
    from .plan_plots import plot_plan
    from .schedule_plots import plot_schedule
    from .study_plots import plot_fit, plot_indices, plot_sweep
    from .window_plots import plot_window

    plots: dict[type[Any], Callable[..., Any]] = {
        Comparison: plot_comparison,
        FindResult: plot_find,
        FitResult: plot_fit,
        NextExperiment: plot_plan,
        OperatingWindow: plot_window,
        OptimisedSchedule: plot_schedule,
        SobolIndices: plot_indices,
    }
    return plots.get(type(thing), plot_sweep)(thing, *options)
