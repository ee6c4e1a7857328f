"""Base class of what a study returns: text, HTML, JSON, table and figure.

A subclass states its answer, remarks on the answer, and a table; a terminal, a notebook and a file
show these.  Its figure is found in :mod:`woundon.report.presentation`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

from ..io.json_texts import json_text
from ..results import Presented, ReadOnly

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Outcome"]


class Outcome(Presented, ReadOnly, ABC):
    """Result of a study, shown and saved in the same way for all studies."""

    @abstractmethod
    def answer(self) -> list[str]:
        """Return the answer as lines of text, the most important one first."""

    def remarks(self) -> list[str]:
        """Return remarks on the answer as lines of text."""
        return []

    def lines(self) -> list[str]:
        """Return answer and remarks as lines of text."""
        return [*self.answer(), *self.remarks()]

    @abstractmethod
    def to_dataframe(self) -> pd.DataFrame:
        """Return the result as a table, SI units."""

    def heading(self) -> str:
        """Return the heading of the table in a notebook; by default the first line."""
        return self.answer()[0]

    def table_for_display(self) -> pd.DataFrame:
        """Return the table that a notebook shows between the heading and the remarks."""
        return self.to_dataframe()

    def to_json(self) -> str:
        """Return the result as JSON, SI units; nan and infinity are null."""
        return json_text(self._record())

    def _record(self) -> Mapping[str, Any]:
        """Return the content of :meth:`to_json`, by name; by default the rows of the table."""
        return {"rows": self.to_dataframe().reset_index().to_dict(orient="records")}

    def plot(
        self,
        path: str | PathLike[str] | None = None,
        ax: Axes | None = None,
        panels: str | Sequence[str] | None = None,
    ) -> Figure | Axes:
        """Draw the result.

        Parameters
        ----------
        path, ax
            As of :func:`woundon.plot`.
        panels : str or sequence of str, optional
            Names of the panels to draw; the error message for a wrong name lists all names.

        Returns
        -------
        matplotlib.figure.Figure, or ``ax`` where it is given
        """
        return self._figure(path, ax, panels)
