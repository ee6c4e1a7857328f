"""What every figure of the thesis comes to: data, a drawing, and verdicts on what the text says."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import Enum
from math import inf
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing

__all__ = ["Figure", "Outcome", "Scheme", "Table", "Verdict"]

Array = np.ndarray
Scheme = Literal["graded", "thesis"]


class Outcome(Enum):
    """What has become of a statement; the value is how it is said."""

    HOLDS = "holds"
    FAILS = "does not hold"
    UNTESTED = "cannot be tested"


@dataclass(frozen=True)
class Verdict:
    """A statement of the thesis about a figure, as a number that must lie in a range.

    Attributes
    ----------
    statement : str
        What the text says, in other words.
    value : float or None
        What was computed, in ``unit``; None if the statement cannot be tested.
    low, high : float
        The range in which the statement holds, ends included.
    unit : str
    note : str
        What the number is, why the statement does not hold, or why it cannot be tested.
    logical : bool
        Whether the number stands for yes (1) or no (0).
    """

    statement: str
    value: float | None
    low: float = -inf
    high: float = inf
    unit: str = ""
    note: str = ""
    logical: bool = False

    @classmethod
    def whether(cls, statement: str, fact: bool, note: str = "") -> Verdict:
        """Return the verdict on a statement that is right or wrong, without a number."""
        return cls(statement, float(fact), 1.0, 1.0, note=note, logical=True)

    @classmethod
    def untested(cls, statement: str, note: str) -> Verdict:
        """Return the verdict on a statement that cannot be tested, and say why."""
        return cls(statement, None, note=note)

    @property
    def outcome(self) -> Outcome:
        """Whether the number lies in the range; nan does not."""
        if self.value is None:
            return Outcome.UNTESTED
        return Outcome.HOLDS if self.low <= self.value <= self.high else Outcome.FAILS

    @property
    def expected(self) -> str:
        """The range as text, e.g. ``at most 3 %``."""
        if self.logical:
            return "yes"
        if self.low == self.high:
            return self._with_unit(f"{self.low:.4g}")
        if self.high == inf:
            return self._with_unit(f"at least {self.low:.4g}")
        if self.low == -inf:
            return self._with_unit(f"at most {self.high:.4g}")
        return self._with_unit(f"{self.low:.4g} to {self.high:.4g}")

    @property
    def measured(self) -> str:
        """The number as text."""
        if self.value is None:
            return "-"
        if self.logical:
            return "yes" if self.value == 1 else "no"
        return self._with_unit(
            f"{self.value:.3g}" if abs(self.value) < 100 else f"{self.value:.1f}"
        )

    def _with_unit(self, text: str) -> str:
        return f"{text} {self.unit}".strip()


@dataclass(frozen=True, eq=False)
class Table:
    """Numbers with named columns, one row a case or a point.

    Attributes
    ----------
    header : tuple of str
        Names with SI units, e.g. ``nip_load [N/m]``.
    rows : (n, k) array
    """

    header: tuple[str, ...]
    rows: Array

    @classmethod
    def of(cls, columns: Mapping[str, Array | Iterable[float]]) -> Table:
        """Make a table of columns by their names with units."""
        values = [np.asarray(list(column), dtype=float) for column in columns.values()]
        return cls(tuple(columns), np.column_stack(values))

    def __getitem__(self, name: str) -> Array:
        """Return a column by its name without the unit, (n,)."""
        names = [head.split(" [")[0] for head in self.header]
        return self.rows[:, names.index(name)]

    def where(self, **values: float) -> Table:
        """Return the rows in which the named columns have the given values."""
        keep = np.ones(len(self.rows), dtype=bool)
        for name, value in values.items():
            keep &= np.isclose(self[name], value, rtol=1e-9, atol=0)
        return Table(self.header, self.rows[keep])

    def within(self, name: str, low: float, high: float = inf) -> Table:
        """Return the rows in which a column lies in a range, ends included."""
        slack = 1e-9 * abs(low)
        keep = (self[name] >= low - slack) & (self[name] <= high * (1 + 1e-9))
        return Table(self.header, self.rows[keep])

    def stacked(self, other: Table) -> Table:
        """Return the rows of both; the headers must agree."""
        if self.header != other.header:
            raise ValueError(f"headers differ: {self.header}, {other.header}")
        return Table(self.header, np.vstack([self.rows, other.rows]))

    def csv(self) -> str:
        """Return the table as text, comma separated, ten digits."""
        lines = [",".join(self.header)]
        lines += [",".join(f"{value:.10g}" for value in row) for row in self.rows]
        return "\n".join(lines) + "\n"


@dataclass(frozen=True, eq=False)
class Figure:
    """A figure or table of the thesis, recomputed.

    Attributes
    ----------
    name : str
        ``fig16``, ``table3``.
    title : str
    scheme : str
        How it was solved: ``graded`` (accurate) or ``thesis`` (M = 200 even nodes).
    table : Table
        The data.
    verdicts : tuple of Verdict
    draw : callable
        Makes the matplotlib figure; None for a table.
    text : str
        A table as the thesis has it, or what there is to say about the figure's case.
    one_scheme : bool
        Whether the choice of scheme makes no difference: measured data, closed forms.
    """

    name: str
    title: str
    scheme: Scheme
    table: Table
    verdicts: tuple[Verdict, ...]
    draw: Callable[[], Drawing] | None = None
    text: str = ""
    one_scheme: bool = False

    @property
    def label(self) -> str:
        """The name as the thesis writes it: ``Fig. 16``, ``Table 3``."""
        kind, number = ("Fig.", self.name[3:]) if self.name[0] == "f" else ("Table", self.name[5:])
        return f"{kind} {number}"

    def count(self, outcome: Outcome) -> int:
        """Count the statements with this outcome."""
        return sum(verdict.outcome is outcome for verdict in self.verdicts)
