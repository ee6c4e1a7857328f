"""Figures and tables of the thesis: their list, and one recomputed with data, verdicts, panels."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING, NamedTuple

from .verdicts import Outcome, Verdict

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from ..report.panels import Panel

__all__ = ["Entry", "Exhibit", "listed"]


class Entry(NamedTuple):
    """A figure or table in the list.

    Attributes
    ----------
    label : str
        As the thesis writes it: ``Fig. 16``, ``Table 3``.
    title : str
    module : str
        The module that computes it, perhaps with others.
    counts : tuple of int
        Known numbers of statements that hold, fail and cannot be tested, by the accurate solver.
        The exhibit states why a statement fails.
    """

    label: str
    title: str
    module: str
    counts: tuple[int, ...]


@cache
def listed() -> Mapping[str, Entry]:
    """Return all figures and tables by name (``fig16``, ``table3``), in the order of the thesis.

    The modules that compute them, and the libraries they need, are not imported.
    """
    text = (resources.files(__package__) / "exhibits.toml").read_text("utf-8")
    return {
        name: Entry(_label(name), entry["title"], entry["module"], tuple(entry["counts"]))
        for name, entry in tomllib.loads(text).items()
    }


def _label(name: str) -> str:
    """Return the label of a name, ``Fig. 16`` of ``fig16``."""
    if name.startswith("fig"):
        return f"Fig. {name.removeprefix('fig')}"
    return f"Table {name.removeprefix('table')}"


@dataclass(frozen=True, eq=False)
class Exhibit:
    """A figure or table of the thesis, recomputed.

    Attributes
    ----------
    name : str
        A name in the list: ``fig16``, ``table3``.
    data : xarray.Dataset
        Variables and coordinates with a unit in their ``attrs`` are columns of the CSV file.
    verdicts : sequence of Verdict
    panels : sequence of Panel
        Of a figure.
    lettered : bool
        Whether several panels are lettered (a), (b), ...
    text : str
        A table as the thesis has it.
    one_solver : bool
        Whether the choice of solver makes no difference: measured data, closed forms.
    """

    name: str
    data: xr.Dataset
    verdicts: Sequence[Verdict]
    panels: Sequence[Panel] = ()
    lettered: bool = True
    text: str = ""
    one_solver: bool = False

    @property
    def label(self) -> str:
        """The name as the thesis writes it."""
        return listed()[self.name].label

    @property
    def title(self) -> str:
        """The title in the list."""
        return listed()[self.name].title

    def count(self, outcome: Outcome) -> int:
        """Count the statements with this outcome."""
        return sum(verdict.outcome is outcome for verdict in self.verdicts)

    def figure(self) -> Figure:
        """Return the figure of the panels."""
        from ..report.drawing import draw_figure  # here, because the list draws nothing

        return draw_figure([[panel] for panel in self.panels], lettered=self.lettered)

    def csv(self) -> str:
        """Return the data as text, comma separated, ten digits, names with units."""
        units = {name: of.attrs.get("units") for name, of in self.data.variables.items()}
        data = self.data.drop_vars([name for name, unit in units.items() if unit is None])
        rows = data.to_dataframe().dropna(how="all").reset_index()
        heads = {name: f"{name} [{units[name]}]" for name in rows if name in data.variables}
        return str(
            rows[list(heads)]
            .rename(columns=heads)
            .to_csv(index=False, float_format="%.10g", na_rep="nan", lineterminator="\n")
        )
