"""Checks of solver arguments: types, integers, tolerances."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any, NamedTuple

import numpy as np

from .errors import InvalidProblem, one_of
from .problems.messages import quote

__all__ = [
    "Option",
    "check_seed",
    "check_type",
    "nodes_or_rtol",
    "optional_mapping",
    "tolerance",
    "whole_number",
]


class Option(NamedTuple):
    """Description of a solver's option, as metadata of its annotation.

    ``Annotated[int | None, Option("Nodes on the last mesh.", "7 to 2049.")]``

    Attributes
    ----------
    help : str
        The sentence that the help of the command line shows.
    details : str
        Range, default and conditions, which differ between kinds of problem.
    """

    help: str
    details: str = ""


def check_type(name: str, value: Any, *types: type[Any]) -> None:
    """Raise an error unless a value has one of the types."""
    if not isinstance(value, types):
        must = one_of(kind.__name__ for kind in types)
        raise InvalidProblem.at(name, f"{quote(value)} is out of place; must be a {must}")


def optional_mapping(name: str, value: Any) -> dict[str, Any]:
    """Return a mapping as a dictionary, an empty one for None; reject other values."""
    if value is None:
        return {}
    check_type(name, value, Mapping)
    return dict(value)


def nodes_or_rtol(nodes: Any, rtol: Any) -> None:
    """Raise an error if both are given: one fixes the grid, the other chooses it."""
    if nodes is not None and rtol is not None:
        text = f"{quote(nodes)} is given together with rtol, which chooses the nodes; omit one"
        raise InvalidProblem.at("nodes", text)


def whole_number(name: str, value: Any, low: int, high: int) -> int:
    """Return an integer; raise an error unless it is from ``low`` to ``high``."""
    _check_range(name, value, (int, np.integer), low, high, f"a whole number, {low} to {high}")
    return int(value)


def tolerance(name: str, value: Any, low: float, high: float) -> float:
    """Return a relative tolerance; raise an error unless it is from ``low`` to ``high``."""
    types = (int, float, np.floating)
    _check_range(name, value, types, low, high, f">= {low:g} and <= {high:g}")
    return float(value)


def check_seed(seed: Any) -> None:
    """Raise an error unless a value is a seed of a random generator, an integer from 0."""
    _check_range("seed", seed, (int, np.integer), 0, inf, "a whole number >= 0")


def _check_range(
    name: str, value: Any, types: tuple[type[Any], ...], low: float, high: float, must: str
) -> None:
    """Raise an error unless a value has one of the types and is from ``low`` to ``high``."""
    if isinstance(value, bool) or not isinstance(value, types) or not low <= value <= high:
        raise InvalidProblem.at(name, f"{quote(value)} is out of range: must be {must}")
