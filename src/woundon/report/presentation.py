"""Text, HTML and figures of results, margins, sensitivities, fits and study tables, by class.

The base class in :mod:`woundon.results` calls these functions.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..results import Presented, Result
from ..sensitivity import Sensitivity
from ..studies.outcome import Outcome
from ..studies.run import Table
from ..winding.margins import Margins
from .html import frame_html, parts_html
from .margins_report import margins_parts
from .report_parts import Part
from .result_report import report_parts
from .sensitivity_report import sensitivity_parts
from .terminal import plain_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["figure_of", "html_of", "text_of"]

MOST_ROWS = 60  # of the cases of a study in a notebook


def text_of(thing: Presented) -> str:
    """Return a result, margins or a study as plain text; the cases of a study in one line."""
    if isinstance(thing, Outcome):
        return "\n".join(thing.lines())
    return repr(thing) if isinstance(thing, Table) else plain_text(_parts(thing))


def html_of(thing: Presented) -> str:
    """Return a result, margins or a study as HTML, for a notebook."""
    if isinstance(thing, Outcome):
        return frame_html(thing.heading(), thing.table_for_display(), thing.remarks())
    if isinstance(thing, Table):
        return str(thing.to_dataframe().to_html(max_rows=MOST_ROWS))
    return parts_html(_parts(thing))


def _parts(thing: Presented) -> list[Part]:
    """Return the parts of the report of a result, of margins or of sensitivities."""
    if isinstance(thing, Sensitivity):
        return sensitivity_parts(thing)
    if isinstance(thing, Margins):
        return margins_parts(thing)
    assert isinstance(thing, Result)
    return report_parts(thing)


def figure_of(thing: Presented, *options: Any) -> Figure | Axes:
    """Return the figure of a result or of a study; ``options`` are those of its ``plot``."""
    # drawing takes half a second to import, and text does not need it
    if isinstance(thing, Result):
        from .plots import plot

        return plot(thing, *options)
    if isinstance(thing, Table):
        from .sweep_panels import plot_sweep

        return plot_sweep(thing, *options)
    from .study_plots import plot_study

    assert isinstance(thing, Outcome)
    return plot_study(thing, *options)
