"""First derivatives of the outputs of any kind: exact ones, or central differences."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import Any

import numpy as np

from .. import kinds
from ..arguments import check_type
from ..errors import InvalidProblem, NoSteadyState, NotConverged, unwarned
from ..problems.paths import field_or_none
from ..results import Result
from ..sensitivity import Sensitivity

__all__ = ["derivatives"]

Array = np.ndarray

STEP = 1e-3  # relative; errors: its square, and the solver tolerance, 1e-8, divided by it


def derivatives(result: Any, *parameters: str, **options: Any) -> Sensitivity:
    """Return derivatives of a result's main outputs with respect to fields of its problem.

    Results with a method ``sensitivity`` (nips) differentiate their equations.  For all other
    kinds, and with options, the derivatives are central differences with a step of 0.1 % of the
    field; one-sided if the problem is invalid on one side.

    Parameters
    ----------
    result : Result
    parameters : str
        Dotted names (``"lower.material.prony.0.time"``).
    options
        Of the solver, for differences; by default the number of nodes of the result.

    Returns
    -------
    Sensitivity

    Raises
    ------
    InvalidProblem
        If the first argument is not a result, no field is named, or a field is not a number or 0.
    NoSteadyState, NotConverged
        If neither side can be solved.

    Examples
    --------
    >>> import woundon as wo
    >>> result = wo.solve(wo.RollerProblem.example(), nodes=33)
    >>> found = wo.derivatives(result, "load")
    >>> slope = found.derivatives[found.outputs.index("half_width"), 0]
    >>> round(float(slope * result.problem.load / result.half_width), 3)  # a varies as sqrt(P)
    0.5
    """
    check_type("result", result, Result)
    exact = getattr(result, "sensitivity", None)
    if exact is not None and not options:
        sensitivity: Sensitivity = exact(*parameters)
        return sensitivity
    fields = _fields(result.problem, parameters)
    if not options and isinstance(nodes := getattr(result, "nodes", None), int):
        options = {"nodes": nodes}
    known = {name: getattr(result, name, None) for name in (*result.MAIN, *result.errors)}
    outputs = tuple(n for n, value in known.items() if isinstance(value, float) and isfinite(value))

    def solved_outputs(problem: Any) -> Array:
        """Solve a problem; return its outputs."""
        with unwarned():
            solved = kinds.solve(problem, **options)
        return np.array([float(getattr(solved, name)) for name in outputs])

    values = np.array([float(getattr(result, name)) for name in outputs])
    columns = [
        _difference(solved_outputs, result.problem, name, value) for name, value in fields.items()
    ]
    point = np.array(list(fields.values()))
    return Sensitivity(outputs, tuple(fields), np.array(columns).T, values, point)


def _fields(problem: Any, names: tuple[str, ...]) -> dict[str, float]:
    """Return the values of named fields."""
    if not names:
        raise InvalidProblem.at("parameters", "missing; must be names of fields")
    fields = {name: field_or_none(problem, name) for name in names}
    for name, value in fields.items():
        if not isinstance(value, float):
            raise InvalidProblem.at(name, "is not a continuous field")
        if value == 0:
            raise InvalidProblem.at(name, "is 0, which has no scale for a difference")
    return fields


def _difference(outputs: Callable[[Any], Array], problem: Any, name: str, value: float) -> Array:
    """Return the difference quotient of the outputs by a field, central if possible."""
    sides: list[tuple[float, Array]] = []
    for place in ((1 + STEP) * value, (1 - STEP) * value, value):
        try:
            sides.append((place, outputs(problem.replace(**{name: place}))))
        except (InvalidProblem, NoSteadyState, NotConverged):
            if place == value or (len(sides) == 0 and place < value):
                raise
        if len(sides) == 2:
            break
    (x1, f1), (x2, f2) = sides
    return (f1 - f2) / (x1 - x2)
