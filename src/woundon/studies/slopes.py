r"""First derivatives of predicted values with respect to fields of the problem.

They are exact where the result differentiates its equations (nips, rollers).  Otherwise they are
difference quotients of solutions on the mesh of the base solution, from which they start:

    central      (Q(x + h) - Q(x - h)) / 2h      error  h^2/6 Q'''
    one-sided    (Q(x + h) - Q(x)) / h           error  h/2 Q''

A central difference becomes one-sided where one side is not permitted or has no solution.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import isfinite, nan
from typing import Any

import numpy as np

from ..arguments import check_type
from ..errors import InvalidProblem, NotConverged, unwarned
from ..problems.paths import get_field, varied_number
from ..problems.problem import Problem
from ..quantities import numbers_of, scalar_outputs, value_of
from ..results import Result
from ..sensitivity import Sensitivity
from .model import KindModel, model_of, options_of
from .observations import Observable, predict

__all__ = ["derivatives", "on_mesh_of", "slopes", "solve_case"]

Array = np.ndarray

# Step h relative to the value of the field.  It minimises h^2/6 + e/h, the relative error of a
# central difference, for the tolerance e = 1e-8 of a contact on one mesh.  The tolerance of
# windings, up to 1e-5, contributes up to 0.3 %.  One-sided differences have an error of h/2 and
# take a shorter step, 0.05 %, to which windings add up to 1 %.
STEP, ONE_SIDED_STEP = 3e-3, 1e-3


def solve_case(model: KindModel, inputs: Mapping[str, Any], start: Result | None) -> Result:
    """Return the result for the base problem with other inputs; warnings are kept in it only."""
    with unwarned():
        return model.solve(model.variant(inputs), start)


def slopes(
    model: KindModel,
    result: Result,
    observables: Sequence[Observable],
    names: Sequence[str],
    inputs: Mapping[str, Any] | None = None,
    *,
    scales: Sequence[float] | None = None,
    exact: bool = True,
    central: bool = True,
    nan_if_unsolved: bool = False,
    solve: Callable[[KindModel, Mapping[str, Any], Result | None], Result] = solve_case,
) -> Array:
    """Return the derivatives of predicted values with respect to fields, (values, fields) [SI].

    Parameters
    ----------
    model : KindModel
        Base problem, tied fields and options of the solver.
    result : Result
        Its solution for ``inputs``.
    observables : sequence of Observable
        The predicted values.
    names : sequence of str
        Dotted names of the fields.
    inputs : mapping, optional
        Fields of the result's problem that differ from the base problem.
    scales : sequence of float, optional
        Of the fields, for the steps of differences; by default the magnitudes of their values.
    exact : bool
        False for differences also where exact derivatives exist.
    central : bool
        False for one-sided differences, which take half the solutions.
    nan_if_unsolved : bool
        Whether a derivative that cannot be solved on either side is nan, or an error.
    solve : callable
        Solves a neighbouring case, for a caller that counts them; arguments of :func:`solve_case`.

    Raises
    ------
    InvalidProblem, NotConverged
        If a derivative cannot be solved on either side.

    Examples
    --------
    >>> import woundon as wo
    >>> from woundon.studies.model import model_of
    >>> roll = wo.RollProblem.example()
    >>> model = model_of(roll, "length", None, {})
    >>> [[slope]] = slopes(model, wo.solve(roll), [Observable("length")], ["radius"])
    >>> round(float(slope * roll.web_thickness / (2 * np.pi * roll.radius)), 4)  # dL/dR = 2 pi R/h
    1.0
    """
    known = _exact_slopes(model, result, observables, names) if exact else None
    if known is not None:
        return known
    fixed, state = on_mesh_of(model, result), dict(inputs or {})

    def predictions(solved: Result) -> Array:
        """Return the predicted values of a result, (values,)."""
        return np.array([predict(solved, observable) for observable in observables])

    def predictions_at(name: str, value: float) -> Array:
        """Solve the case with another value of a field; return its predictions, (values,)."""
        return predictions(solve(fixed, {**state, name: value}, result))

    base = predictions(result)
    columns = np.full((len(names), len(observables)), nan)
    for k, name in enumerate(names):
        value = state[name] if name in state else get_field(model.variant(state), name)
        scale = abs(value) if scales is None else scales[k]
        step = (STEP if central else ONE_SIDED_STEP) * scale
        try:
            columns[k] = _difference_quotient(
                partial(predictions_at, name), value, step, base, central
            )
        except (InvalidProblem, NotConverged, ArithmeticError):
            if not nan_if_unsolved:
                raise
    return columns.T


def _exact_slopes(
    model: KindModel, result: Result, observables: Sequence[Observable], names: Sequence[str]
) -> Array | None:
    """Return exact derivatives, (values, fields); None if one of them has none.

    The derivative with respect to a field is the sum over this field and those tied to it.
    """
    if not hasattr(result, "sensitivity") or any(isfinite(o.radius) for o in observables):
        return None
    followers = {name: model.followers(name) for name in names}
    paths = dict.fromkeys(path for name in names for path in (name, *followers[name]))
    outputs = tuple(dict.fromkeys(observable.output for observable in observables))
    try:
        sensitivity = result.sensitivity(*paths, outputs=outputs)
    except InvalidProblem:  # not of this problem, this field or this output
        return None
    by_path = dict(zip(sensitivity.parameters, sensitivity.derivatives.T, strict=True))
    columns = [sum(by_path[path] for path in (name, *followers[name])) for name in names]
    rows = [outputs.index(observable.output) for observable in observables]
    return np.column_stack(columns)[rows]


def _difference_quotient(
    values_at: Callable[[float], Array], x: float, step: float, base: Array, central: bool
) -> Array:
    """Return the difference quotient of values (n,) at x, where they are ``base``.

    One side is sufficient; without ``central`` the second one is solved only if the first cannot
    be.

    Raises
    ------
    InvalidProblem, NotConverged, ArithmeticError
        The reason, if neither side can be solved.
    """
    points: list[tuple[float, Array]] = []
    reason: Exception | None = None
    for end in (x + step, x - step):
        try:
            points.append((end, values_at(end)))
        except (InvalidProblem, NotConverged, ArithmeticError) as fault:
            reason = fault
            continue
        if not central:
            break
    if reason is not None and not points:
        raise reason
    # two sides, or the only one that was solved and x
    (x1, y1), (x2, y2) = [*points, (x, base)][:2]
    return (y1 - y2) / (x1 - x2)


def on_mesh_of(model: KindModel, *results: Result) -> KindModel:
    """Return the model with the nodes of the finest of some results, if the solver chooses them.

    On one mesh outputs are continuous functions of the fields, and discretisation errors cancel in
    differences.  The model itself is returned if the number of nodes is an option that is set, or
    if the solver has no such number.
    """
    nodes: list[Any] = [getattr(result, "nodes", None) for result in results]
    has_nodes = all(isinstance(number, int) for number in nodes)
    # the default None of the option lets the solver choose; ... stands for no such option
    is_chosen = has_nodes and options_of(model.problem).get("nodes", ...) is None
    if not is_chosen or "nodes" in model.options:
        return model
    options = {name: value for name, value in model.options.items() if name != "rtol"}
    return replace(model, options={**options, "nodes": max(nodes)})


def derivatives(result: Result, *parameters: str, **options: Any) -> Sensitivity:
    """Return derivatives of a result's main outputs with respect to fields of its problem.

    Results with a method ``sensitivity`` (nips, rollers) differentiate their equations.  For all
    other kinds, and with options, the derivatives are central differences with a step of 0.3 % of
    the field; one-sided if the problem is invalid on one side.

    Parameters
    ----------
    result : Result
    parameters : str
        Dotted names (``"lower.material.prony.0.time"``); by default all numbers of the problem, of
        differences those that are not 0 and for which one side can be solved.
    options
        Of the solver, for differences; by default the number of nodes of the result.

    Returns
    -------
    Sensitivity

    Raises
    ------
    InvalidProblem
        If the first argument is not a result, or a named field is not a number or 0.
    NoSteadyState, NotConverged
        If neither side can be solved for a named field.

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
    for name in parameters:
        check_type("parameters", name, str)
    if not options and hasattr(result, "sensitivity"):
        sensitivity: Sensitivity = result.sensitivity(*parameters)
        return sensitivity
    # main outputs and those with an error estimate, if they are numbers in this result
    outputs = _finite_numbers(result, (*result.MAIN, *result.errors))
    outputs = outputs or _finite_numbers(result, scalar_outputs(result))
    fields = {name: _continuous_field(result.problem, name) for name in parameters}
    fields = fields or {name: value for name, value in numbers_of(result.problem).items() if value}
    model = model_of(result.problem, outputs, None, options)
    if options:  # the base of the differences needs them too
        result = solve_case(model, {}, result)
    observables = [Observable(name) for name in outputs]
    columns = slopes(
        model, result, observables, list(fields), exact=False, nan_if_unsolved=not parameters
    )
    is_known = np.full(len(fields), True) if parameters else np.isfinite(columns).any(axis=0)
    return Sensitivity(
        outputs=outputs,
        parameters=tuple(np.array(list(fields))[is_known].tolist()),
        derivatives=columns[:, is_known],
        values=np.array([predict(result, observable) for observable in observables]),
        fields=np.array(list(fields.values()))[is_known],
    )


def _finite_numbers(result: Result, names: Iterable[str]) -> tuple[str, ...]:
    """Return those of some outputs that are finite numbers in this result."""
    known = scalar_outputs(result)
    values = {name: value_of(result, name) for name in names if name in known}
    return tuple(n for n, value in values.items() if isinstance(value, float) and isfinite(value))


def _continuous_field(problem: Problem, name: str) -> float:
    """Return the value of a field that can be varied by a share of its value: a number, not 0."""
    value = varied_number(problem, name)
    if value == 0:
        raise InvalidProblem.at(name, "is 0, which has no scale for a difference")
    return value
