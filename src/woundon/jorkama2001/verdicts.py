"""Statements of the thesis as numbers in a range: each holds, fails, or cannot be tested."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass, replace
from enum import Enum
from math import inf
from typing import TYPE_CHECKING, SupportsFloat

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["Outcome", "Verdict", "accurate", "falls", "grows", "verdict", "whether"]


class Outcome(Enum):
    """Outcome of a statement; the value is the word for it."""

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
    accurate : bool
        Whether it is always solved accurately, as wraps are.
    """

    statement: str
    value: float | None
    low: float = -inf
    high: float = inf
    unit: str = ""
    note: str = ""
    logical: bool = False
    accurate: bool = False

    @property
    def outcome(self) -> Outcome:
        """Outcome of the comparison of the number with the range; nan lies outside."""
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


def verdict(
    statement: str,
    value: SupportsFloat | None,
    *,
    low: float = -inf,
    high: float = inf,
    unit: str = "",
    note: str = "",
) -> Verdict:
    """Return the verdict on a statement by a number; None: it cannot be tested."""
    return Verdict(statement, None if value is None else float(value), low, high, unit, note)


def whether(statement: str, fact: bool, note: str = "") -> Verdict:
    """Return the verdict on a statement that is right or wrong, without a number."""
    return Verdict(statement, float(fact), 1.0, 1.0, note=note, logical=True)


def accurate(verdicts: Iterable[Verdict]) -> list[Verdict]:
    """Mark verdicts whose numbers are always solved accurately."""
    return [replace(one, accurate=True) for one in verdicts]


def grows(
    statement: str,
    values: xr.DataArray,
    along: Hashable,
    unit: str = "",
    note: str = "smallest step",
) -> Verdict:
    """Return the verdict on a statement that values grow in every step along a dimension."""
    return verdict(statement, values.diff(along).min(), low=0.0, unit=unit, note=note)


def falls(
    statement: str,
    values: xr.DataArray,
    along: Hashable,
    unit: str = "",
    note: str = "largest step",
) -> Verdict:
    """Return the verdict on a statement that values fall in every step along a dimension."""
    return verdict(statement, values.diff(along).max(), high=0.0, unit=unit, note=note)
