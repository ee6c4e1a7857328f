"""Arguments of the solvers, checked in one place: the kind of thing, counts, tolerances."""

from __future__ import annotations

from typing import Any

import numpy as np

from .description import shown
from .errors import InvalidProblem, one_of

__all__ = ["check_kind", "tolerance", "whole_number"]


def check_kind(name: str, value: Any, *kinds: type[Any]) -> None:
    """Refuse a value that is none of the kinds, e.g. the path of a case in place of a problem."""
    if not isinstance(value, kinds):
        must = one_of(kind.__name__ for kind in kinds)
        raise InvalidProblem.at(name, f"{shown(value)} is out of place; must be a {must}")


def whole_number(name: str, value: Any, low: int, high: int) -> int:
    """Return a whole number from low to high."""
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, np.integer))
        or not low <= value <= high
    ):
        text = f"{shown(value)} is out of range: must be a whole number, {low} to {high}"
        raise InvalidProblem.at(name, text)
    return int(value)


def tolerance(name: str, value: Any, low: float, high: float) -> float:
    """Return a relative tolerance from low to high."""
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float, np.floating))
        or not low <= value <= high
    ):
        text = f"{shown(value)} is out of range: must be >= {low:g} and <= {high:g}"
        raise InvalidProblem.at(name, text)
    return float(value)
