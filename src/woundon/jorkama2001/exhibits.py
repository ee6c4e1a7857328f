"""A figure or table of the thesis, recomputed: data, verdicts and drawing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .verdicts import Outcome, Verdict

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["Exhibit"]


@dataclass(frozen=True, eq=False)
class Exhibit:
    """A figure or table of the thesis, recomputed.

    Attributes
    ----------
    name : str
        ``fig16``, ``table3``.
    title : str
    data : xarray.Dataset
        What has a unit in its ``attrs`` is a column of the CSV file.
    verdicts : sequence of Verdict
    draw : callable
        Makes the matplotlib figure; None for a table.
    text : str
        A table as the thesis has it.
    one_solver : bool
        Whether the choice of solver makes no difference: measured data, closed forms.
    """

    name: str
    title: str
    data: xr.Dataset
    verdicts: Sequence[Verdict]
    draw: Callable[[], Figure] | None = None
    text: str = ""
    one_solver: bool = False

    @property
    def label(self) -> str:
        """The name as the thesis writes it: ``Fig. 16``, ``Table 3``."""
        kind, number = ("Fig.", self.name[3:]) if self.name[0] == "f" else ("Table", self.name[5:])
        return f"{kind} {number}"

    def count(self, outcome: Outcome) -> int:
        """Count the statements with this outcome."""
        return sum(verdict.outcome is outcome for verdict in self.verdicts)

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
