"""First derivatives of any kind's outputs: exact where the result has them, else by differences."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import kinds
from ..arguments import check_type
from ..errors import InvalidProblem, NoSteadyState, NotConverged, unwarned
from ..nip.sensitivity import Sensitivity
from ..quantities import walk
from ..results import Result

if TYPE_CHECKING:
    from ..nip.sensitivity import Sensitivity

__all__ = ["derivatives"]

Array = np.ndarray

STEP = 1e-3  # of a field: its square is left of an output, and what solves leave, 1e-8, over it


def derivatives(result: Any, *parameters: str, **options: Any) -> Sensitivity:
    """Return derivatives of a result's main outputs with respect to fields of its problem.

    Nips and wrapped nips tell them by differentiation of their equations; of all other kinds, and
    with options, they are central differences of the outputs told, two solves a field, over a
    thousandth of it; one-sided where one of the two is refused.

    Parameters
    ----------
    result : Result
    parameters : str
        Dotted names (``"lower.material.prony.0.time"``).
    options
        Of the solver, where differences are taken; by default as many nodes as the result has.

    Returns
    -------
    Sensitivity

    Raises
    ------
    InvalidProblem
        For what is no result, if no field is named, for a name that is not a number, or a field
        that is 0.
    NoSteadyState, NotConverged
        If neither side can be solved.
    """
    check_type("result", result, Result)
    exact = getattr(result, "sensitivity", None)
    if exact is not None and not options:
        found: Sensitivity = exact(*parameters)
        return found
    fields = _fields(result.problem, parameters)
    if not options and isinstance(nodes := getattr(result, "nodes", None), int):
        options = {"nodes": nodes}
    known = {name: getattr(result, name, None) for name in (*result.MAIN, *result.errors)}
    outputs = tuple(n for n, value in known.items() if isinstance(value, float) and isfinite(value))

    def told(problem: Any) -> Array:
        with unwarned():
            solved = kinds.solve(problem, **options)
        return np.array([float(getattr(solved, name)) for name in outputs])

    values = np.array([float(getattr(result, name)) for name in outputs])
    columns = [_difference(told, result.problem, name, value) for name, value in fields.items()]
    where = np.array(list(fields.values()))
    return Sensitivity(outputs, tuple(fields), np.array(columns).T, values, where)


def _fields(problem: Any, names: tuple[str, ...]) -> dict[str, float]:
    """Return the values of named fields."""
    known: dict[str, Any] = {}
    for place in walk(problem):
        items = place.value if isinstance(place.value, tuple) else ()
        known |= {place.path: place.value} | {f"{place.path}.{k}": x for k, x in enumerate(items)}
    if not names:
        raise InvalidProblem.at("parameters", "missing; must be names of fields, two solves each")
    for name in names:
        if not isinstance(known.get(name), float):
            raise InvalidProblem.at(name, "is not a continuous field")
        if known[name] == 0:
            raise InvalidProblem.at(name, "0 has no scale to take a difference over")
    return {name: known[name] for name in names}


def _difference(told: Callable[[Any], Array], problem: Any, name: str, value: float) -> Array:
    sides: list[tuple[float, Array]] = []
    for place in ((1 + STEP) * value, (1 - STEP) * value, value):
        try:
            sides.append((place, told(problem.replace(**{name: place}))))
        except (InvalidProblem, NoSteadyState, NotConverged):
            if place == value or (len(sides) == 0 and place < value):
                raise
        if len(sides) == 2:
            break
    (one, above), (two, below) = sides
    return (above - below) / (one - two)
