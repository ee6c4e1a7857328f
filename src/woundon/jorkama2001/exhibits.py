"""Figures and tables: data, verdicts and a drawing of each, and the module that computes it.

A module has a function ``exhibits(solver)`` that returns what it makes; a new one is a line here.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from importlib import import_module
from typing import TYPE_CHECKING

import woundon as wo

from .verdicts import Outcome, Verdict

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["NAMES", "Exhibit", "chosen", "made_by", "modules"]


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


# in the order of the thesis
_MODULES = {
    "fig5": "fig5",
    "fig15": "fig15",
    "fig16": "fig16_18",
    "fig17": "fig16_18",
    "fig18": "fig16_18",
    "fig19": "fig19",
    "fig20": "fig20",
    "fig21": "fig21_22",
    "fig22": "fig21_22",
    "fig23": "fig23_24",
    "fig24": "fig23_24",
    "fig25": "fig25",
    "fig26": "fig26",
    "fig27": "fig27",
    "fig28": "fig28_29",
    "fig29": "fig28_29",
    "fig30": "fig30",
    "fig33": "fig33",
    "fig34": "fig34",
    "fig35": "fig35",
    "table3": "table3",
    "fig37": "table3",
    "table4": "table4",
}
NAMES = tuple(_MODULES)

# the ones that take longest, longest first: processes that start with them end sooner
_LONG = ("fig28_29", "table3", "fig19", "fig16_18", "fig21_22", "fig23_24", "fig26", "fig33")


def chosen(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names, checked, in the order of the thesis.

    Raises
    ------
    InvalidProblem
        For a name that is no figure or table here.
    """
    for name in names:
        if name not in _MODULES:
            near = get_close_matches(name, NAMES, 1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            text = f"unknown{hint}; there are {', '.join(NAMES)}"
            raise wo.InvalidProblem([(name, text)])
    return tuple(name for name in NAMES if name in names)


def modules(names: Sequence[str]) -> tuple[str, ...]:
    """Return the modules that make these figures and tables, the longest first."""
    needed = dict.fromkeys(_MODULES[name] for name in names)
    return tuple(sorted(needed, key=lambda m: _LONG.index(m) if m in _LONG else len(_LONG)))


def made_by(module: str, solver: str) -> tuple[Exhibit, ...]:
    """Compute all figures of a module, "accurate" or by the procedure of the "thesis"."""
    made: tuple[Exhibit, ...] = import_module(f".{module}", __package__).exhibits(solver)
    return made
