"""Text, HTML and figures of results, margins, sensitivities, fits and study tables, by class.

The base class in :mod:`woundon.results` calls these functions.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ..results import Result
from ..sensitivity import Sensitivity
from ..studies.outcome import Outcome
from ..winding.margins import Margins
from .html import parts_html, table_html
from .margins_report import margins_parts
from .report_parts import Part
from .result_report import report_parts
from .sensitivity_report import print_sensitivity
from .terminal import plain_text, print_parts

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["figure_of", "html_of", "html_of_table", "text_of"]


def text_of(thing: Any) -> str:
    """Return a result, margins or a sensitivity as plain text; the lines of all others."""
    if isinstance(thing, Result | Margins):
        return plain_text(lambda console: print_parts(_parts(thing), console))
    if isinstance(thing, Sensitivity):
        return plain_text(lambda console: print_sensitivity(thing, console))
    return "\n".join(thing.lines()) if hasattr(thing, "lines") else repr(thing)


def html_of(thing: Any) -> str:
    """Return a result, margins or a study as HTML, for a notebook."""
    if isinstance(thing, Outcome):
        return table_html(thing.answer()[0], thing.table_for_display(), thing.remarks())
    if isinstance(thing, Result | Margins):
        return parts_html(_parts(thing))
    raise TypeError(f"a {type(thing).__name__} has no report")


def _parts(thing: Result | Margins) -> list[Part]:
    """Return the parts of the report of a result or of margins."""
    return margins_parts(thing) if isinstance(thing, Margins) else report_parts(thing)


def html_of_table(head: str, frame: pd.DataFrame, remarks: Iterable[str] = ()) -> str:
    """Return a table of numbers between its heading and remarks as HTML."""
    return table_html(head, frame, remarks)


def figure_of(thing: Any, *options: Any) -> Any:
    """Return the figure of a result or of a study."""
    # drawing takes half a second to import, and text does not need it
    if isinstance(thing, Result):
        from .plots import plot

        return plot(thing, *options)
    from .study_plots import plot_study

    return plot_study(thing, *options)
