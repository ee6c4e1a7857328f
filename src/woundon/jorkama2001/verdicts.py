"""Statements of the thesis as numbers in a range: each holds, fails, or cannot be tested."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass, replace
from enum import Enum
from math import inf
from typing import TYPE_CHECKING, SupportsFloat

if TYPE_CHECKING:
    import xarray as xr

__all__ = [
    "Outcome",
    "Range",
    "Verdict",
    "accurate",
    "at_least",
    "at_most",
    "exactly",
    "falls",
    "grows",
    "untested",
    "verdict",
    "whether",
]


class Outcome(Enum):
    """Outcome of a statement; the value is the word for it."""

    HOLDS = "holds"
    FAILS = "does not hold"
    UNTESTED = "cannot be tested"


@dataclass(frozen=True)
class Range:
    """Numbers from ``low`` to ``high``, ends included, in a unit."""

    low: float
    high: float
    unit: str = ""

    def contains(self, value: float) -> bool:
        """Return True if a number lies in the range; nan lies outside."""
        return self.low <= value <= self.high

    def with_unit(self, number: str) -> str:
        """Return a number as text with the unit."""
        return f"{number} {self.unit}".strip()

    def __str__(self) -> str:
        """Return the range as text, e.g. ``at most 3 %``."""
        if self.low == self.high:
            return self.with_unit(f"{self.low:.4g}")
        if self.high == inf:
            return self.with_unit(f"at least {self.low:.4g}")
        if self.low == -inf:
            return self.with_unit(f"at most {self.high:.4g}")
        return self.with_unit(f"{self.low:.4g} to {self.high:.4g}")


def at_most(high: float, unit: str = "") -> Range:
    """Return the range up to ``high``."""
    return Range(-inf, high, unit)


def at_least(low: float, unit: str = "") -> Range:
    """Return the range from ``low`` on."""
    return Range(low, inf, unit)


def exactly(value: float, unit: str = "") -> Range:
    """Return the range of a single number."""
    return Range(value, value, unit)


@dataclass(frozen=True)
class Verdict:
    """A statement of the thesis about a figure, as a number that must lie in a range.

    Attributes
    ----------
    statement : str
        What the text says, in other words.
    value : float or None
        The computed number, in the unit of the range; None if the statement cannot be tested.
    asked : Range
        The range in which the statement holds.
    note : str
        What the number is, why the statement does not hold, or why it cannot be tested.
    logical : bool
        Whether the number stands for yes (1) or no (0).
    accurate : bool
        Whether it is always solved accurately, as wraps are.
    """

    statement: str
    value: float | None
    asked: Range
    note: str = ""
    logical: bool = False
    accurate: bool = False

    @property
    def outcome(self) -> Outcome:
        """Outcome of the comparison of the number with the range."""
        if self.value is None:
            return Outcome.UNTESTED
        return Outcome.HOLDS if self.asked.contains(self.value) else Outcome.FAILS

    @property
    def expected(self) -> str:
        """The range as text, or ``yes``."""
        return "yes" if self.logical else str(self.asked)

    @property
    def measured(self) -> str:
        """The number as text."""
        if self.value is None:
            return "-"
        if self.logical:
            return "yes" if self.value == 1 else "no"
        digits = f"{self.value:.3g}" if abs(self.value) < 100 else f"{self.value:.1f}"
        return self.asked.with_unit(digits)


def verdict(statement: str, value: SupportsFloat, asked: Range, note: str = "") -> Verdict:
    """Return the verdict on a statement by a number."""
    return Verdict(statement, float(value), asked, note)


def untested(statement: str, note: str) -> Verdict:
    """Return the verdict on a statement that cannot be tested, with the reason."""
    return Verdict(statement, None, Range(-inf, inf), note)


def whether(statement: str, fact: bool, note: str = "") -> Verdict:
    """Return the verdict on a statement that is right or wrong, without a number."""
    return Verdict(statement, float(fact), exactly(1.0), note, logical=True)


def accurate(verdicts: Iterable[Verdict]) -> list[Verdict]:
    """Mark verdicts whose numbers are always solved accurately."""
    return [replace(one, accurate=True) for one in verdicts]


def grows(
    statement: str, tension: xr.DataArray, along: Hashable, note: str = "smallest step"
) -> Verdict:
    """Return the verdict on a statement that a tension grows in every step along a dimension."""
    return verdict(statement, tension.diff(along).min(), at_least(0.0, "N/m"), note)


def falls(
    statement: str, tension: xr.DataArray, along: Hashable, note: str = "largest step"
) -> Verdict:
    """Return the verdict on a statement that a tension falls in every step along a dimension."""
    return verdict(statement, tension.diff(along).max(), at_most(0.0, "N/m"), note)
