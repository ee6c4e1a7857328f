r"""Planned measurements: predicted values and their derivatives by the logarithms of parameters.

    y(theta; state),     S = d y / d ln theta,     information  sum S^T S / sigma^2

Predictions and derivatives are those of a fit (:mod:`.predict`, :mod:`.slopes`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import nan
from typing import Any

import numpy as np

from .. import kinds
from ..arguments import check_arguments
from ..errors import InvalidProblem, did_you_mean
from ..io.logs import POSITIONS
from ..problems.messages import quote
from ..problems.paths import find_places, get_field, number_in_si
from ..problems.problem import Problem
from ..problems.units import parse
from ..quantities import Quantity
from ..results import Result
from .column_names import columns_of, measurable_outputs
from .measured_tables import MEASURED_AS
from .model import KindModel, kind_of, model_of
from .observations import PRESSURE, RADIUS, Observable, arrays_over_radius, read_deviation
from .predict import Case, cases_of
from .slopes import slopes, solve_case

__all__ = ["Measurement", "PlannedMeasurement", "SolvedStates", "plan_measurement"]

Array = np.ndarray
PULL_TAB = "pull_tab_pressure"
SolvedStates = dict[Any, Result]  # by problem and values of its varied fields


@dataclass(frozen=True, eq=False)
class Measurement:
    """A measurement that is planned or completed: one value, or a series of values.

    Parameters
    ----------
    quantity : str
        Any scalar output of the problem's result: ``wound_on_tension``, ``nip_width``,
        ``approach``.  Of a roll or a winding also ``pull_tab_pressure`` and other arrays over the
        radius, with ``at={"radius": ...}``, and ``length``, with ``at={"diameter": ...}``.
    at : mapping of str to float, str or sequence of these
        State: dotted name of a field -> value, SI or a text with unit; a sequence of values
        for a series, in which single values hold for all.  Of a roll or a winding ``radius`` and
        ``diameter`` are the position of the measurement.
    standard_deviation : float or str
        Of each value, independent of the others: SI, a text with unit, or "20 %" of the predicted
        value.
    cost : float
        Of the complete series, in any unit that is common to all candidates.
    problem : Problem, optional
        The problem that predicts the quantity; by default that of the study.
    fields : mapping of str to str, optional
        Fields of this other problem -> unknown field of the study that they are equal to, e.g.
        ``{"stack.radial.K2": "roll.stack.radial.K2"}``.
    label : str, optional
        Name in tables.

    Raises
    ------
    InvalidProblem
        For a cost that is not positive, or sequences of different lengths.

    Examples
    --------
    >>> import woundon as wo
    >>> series = wo.Measurement("nip_width", {"nip_load": ["1 kN/m", "3 kN/m"]}, "0.1 mm")
    >>> series.size
    2
    """

    quantity: str
    at: Mapping[str, Any] = field(default_factory=dict)
    standard_deviation: Any = None
    cost: float = 1.0
    problem: Problem | None = None
    fields: Mapping[str, str] = field(default_factory=dict)
    label: str = ""

    def __post_init__(self) -> None:
        """Check the fields of the measurement."""
        check_arguments(quantity=self.quantity, at=self.at, fields=self.fields, label=self.label)
        is_number = isinstance(self.cost, (int, float)) and not isinstance(self.cost, bool)
        if not is_number or not 0 < self.cost < 1e300:
            raise InvalidProblem.at("cost", f"{quote(self.cost)} is out of range; must be > 0")
        if self.standard_deviation is None:
            raise InvalidProblem.at(f"{self.quantity}: standard_deviation", "missing")
        sizes = {name: len(value) for name, value in self.at.items() if _is_series(value)}
        if len(set(sizes.values())) > 1 or 0 in sizes.values():
            text = ", ".join(f"{name} has {size} values" for name, size in sizes.items())
            raise InvalidProblem.at(f"{self.quantity}: at", f"{text}; must have the same number")

    @property
    def size(self) -> int:
        """Number of values."""
        return next((len(value) for value in self.at.values() if _is_series(value)), 1)

    @property
    def name(self) -> str:
        """The label, or quantity and state in the units for display."""
        return self._name(Quantity.text)

    @property
    def stored_name(self) -> str:
        """The name in the usual units, for tables and for texts that a plan keeps."""
        return self._name(Quantity.stored_text)

    def _name(self, format_value: Callable[[Quantity, float], str]) -> str:
        """Return the label, or quantity and state: "nip_width at nip_load 3 kN/m".

        Parameters
        ----------
        format_value : callable
            (quantity, value in SI) -> text with a unit.
        """
        if self.label:
            return self.label
        texts_of_state = []
        for name, value in self.at.items():
            ends = (value[0], value[-1]) if _is_series(value) else (value,)
            quantity = self._quantity_of(name)
            texts = [_end_text(end, quantity, format_value) for end in ends]
            texts_of_state.append(f"{name} {' to '.join(texts)}")
        series = f"{self.size} values of " if self.size > 1 else ""
        state = f" at {', '.join(texts_of_state)}" if texts_of_state else ""
        return f"{series}{self.quantity}{state}"

    def _quantity_of(self, name: str) -> Quantity | None:
        """Return the quantity of a field of the state.

        Without a problem it is that of any kind which has the field: the same name has the same
        unit in all of them.
        """
        if name in POSITIONS:
            return RADIUS
        owners: list[Any] = [kind.problem for kind in kinds.every()]
        if self.problem is not None:
            owners = [self.problem]
        places = (place for owner in owners for place in find_places(owner, name))
        return next((place.quantity for place in places if place.quantity is not None), None)


def _is_series(value: Any) -> bool:
    """Return True for a sequence of values, False for a number or a text."""
    return not isinstance(value, str) and hasattr(value, "__len__")


def _end_text(
    value: Any, quantity: Quantity | None, format_value: Callable[[Quantity, float], str]
) -> str:
    """Return a value of a state with its unit; as it was entered if it cannot be converted."""
    if quantity is None:
        return str(value)
    try:
        return format_value(quantity, float(parse(value, quantity.unit, "at")))
    except InvalidProblem:  # another form of the quantity: a web tension as a stress
        return str(value)


@dataclass(frozen=True, eq=False)
class PlannedMeasurement:
    """A measurement whose names and units are checked; n values, SI.

    Attributes
    ----------
    measurement : Measurement
    model : KindModel
    cases : list of Case
        The states, and the values that each of them predicts.
    quantity : Quantity
        Of the values.
    deviation : float
        Standard deviation; SI, or relative to the predicted values if ``is_relative``.
    is_relative : bool
    paths : mapping of str to tuple of str
        Unknown -> fields of this problem that follow it.
    """

    measurement: Measurement
    model: KindModel
    cases: list[Case]
    quantity: Quantity
    deviation: float
    is_relative: bool
    paths: Mapping[str, tuple[str, ...]]

    @property
    def output(self) -> str:
        """Name of the output that predicts the values."""
        return self.cases[0].observables[0].output

    def predict(self, theta: Mapping[str, float], solved: SolvedStates) -> tuple[Array, Array]:
        """Return predictions (n,) and their derivatives by ln(theta), (n, p), SI units.

        Parameters
        ----------
        theta : mapping of str to float
            The p unknown fields of the study and their values.
        solved : dict
            Results that measurements at the same states share; it is extended.

        Raises
        ------
        InvalidProblem, NotConverged
            If a state has no solution.
        """
        fields = {path: theta[name] for name, paths in self.paths.items() for path in paths}
        # d field / d ln(theta), (fields, p): the value of the unknown that the field follows
        chain = np.array(
            [[theta[name] * (path in self.paths[name]) for name in theta] for path in fields]
        )
        values = np.empty(self.measurement.size)
        derivatives = np.zeros((values.size, len(theta)))
        start: Result | None = None
        for case in self.cases:
            inputs = {**fields, **case.inputs}
            # measurements of one problem share the object, which lives as long as the models
            key = (id(self.model.problem), tuple(sorted(inputs.items())))
            if key not in solved:
                solved[key] = solve_case(self.model, inputs, start)
            start = solved[key]
            values[case.rows] = case.predictions(start)
            if fields:
                columns = slopes(self.model, start, case.observables, list(fields), inputs)
                derivatives[case.rows] = columns @ chain
        return values, derivatives

    def information(self, theta: Mapping[str, float], solved: SolvedStates) -> Array:
        """Return the Fisher information on ln(theta), (p, p); arguments as of :meth:`predict`."""
        values, derivatives = self.predict(theta, solved)
        sigma = self.deviation * (np.abs(values) if self.is_relative else np.ones(values.shape))
        if not np.all(sigma > 0):
            text = f"{quote(self.measurement.standard_deviation)} of a predicted value of 0"
            raise InvalidProblem.at(f"{self.measurement.name}: standard_deviation", text)
        rows = derivatives / sigma[:, None]
        return np.asarray(rows.T @ rows)


def plan_measurement(
    measurement: Measurement,
    problem: Problem,
    unknown: Sequence[str],
    tie: Mapping[str, str],
    options: Mapping[str, Any],
) -> PlannedMeasurement:
    """Return a measurement with the model and the states that predict its values.

    All names, values and units are checked; nothing is solved.

    Parameters
    ----------
    measurement : Measurement
    problem : Problem
        Of the study.
    unknown : sequence of str
        Dotted names of the unknown fields of the study.
    tie, options : mapping
        Of the study; they do not apply to a measurement with a problem of its own.

    Raises
    ------
    InvalidProblem
        For invalid names, values or units.
    """
    is_separate = measurement.problem is not None
    base = problem if measurement.problem is None else measurement.problem
    kind = kind_of(base)
    scalars = measurable_outputs(base)
    arrays = arrays_over_radius(kind.result, columns_of(base))
    known = {**arrays, **scalars}
    output = _output_of(measurement.quantity, known, kind.name)
    where = measurement.quantity
    state, position = _state(measurement, base, bool(arrays))
    if output not in scalars and np.isnan(position).any():
        raise InvalidProblem.at(f"{where}: at", 'missing; write at={"radius": ...}')
    paths = _followers_of_unknowns(measurement, base, unknown)
    _check_state(state, paths, where)
    # a model needs an output; arrays over the radius are none
    outputs = (output,) if output in scalars else ("residual",)
    model = model_of(base, outputs, {} if is_separate else tie, {} if is_separate else options)
    model.check_varied([*state, *(path for group in paths.values() for path in group)])
    cases = cases_of(state, [Observable(output, radius) for radius in position.tolist()])
    quantity = known[output]
    of_deviation = f"{where}: standard_deviation"
    in_si = partial(parse, unit=quantity.unit, field=of_deviation)
    deviation, is_relative = read_deviation(measurement.standard_deviation, in_si, of_deviation)
    return PlannedMeasurement(measurement, model, cases, quantity, deviation, is_relative, paths)


def _output_of(name: str, known: Mapping[str, Quantity], kind_name: str) -> str:
    """Return the output that predicts a measured quantity, which may have another name.

    Parameters
    ----------
    name : str
        The measured quantity, such as ``pull_tab_pressure``, which the pressure predicts.
    known : mapping
        Outputs of the problem, scalars and arrays over the radius.
    kind_name : str
        Kind of the problem, for the error.

    Raises
    ------
    InvalidProblem
        If the problem has no such output.
    """
    aliases = {PULL_TAB: PRESSURE} | {a: b for a, b in MEASURED_AS.items() if b in known}
    output = aliases.get(name, name)
    if output not in known:
        names = (*known, *([PULL_TAB] if PRESSURE in known else []))
        text = f"is not an output of a {kind_name}{did_you_mean(name, names)}"
        raise InvalidProblem.at(name, text)
    return output


def _check_state(
    state: Mapping[str, Array], paths: Mapping[str, Sequence[str]], where: str
) -> None:
    """Reject a state with the value of a field that follows an unknown.

    Parameters
    ----------
    state : mapping of str to array
        Fields of the state.
    paths : mapping of str to sequence of str
        Unknown -> fields that follow it.
    where : str
        The measured quantity, for the error.
    """
    for name in state:
        for unknown_name, group in paths.items():
            if name in group:
                text = f"is unknown ({unknown_name}), so it cannot be part of a state"
                raise InvalidProblem.at(f"{where}: at: {name}", text)


def _state(
    measurement: Measurement, base: Problem, has_radius: bool
) -> tuple[dict[str, Array], Array]:
    """Return the fields of all values by name, (n,) arrays, and their radii, (n,).

    Radii are nan if there are none; ``has_radius`` states whether the problem has results over the
    radius, so that "radius" and "diameter" are positions in a roll.
    """
    state: dict[str, Array] = {}
    position = np.full(measurement.size, nan)
    for name, entry in measurement.at.items():
        values = list(entry) if _is_series(entry) else [entry] * measurement.size
        where = f"{measurement.quantity}: at: {name}"
        if has_radius and name in POSITIONS:
            position = POSITIONS[name] * np.array([parse(value, "m", where) for value in values])
            continue
        state[name] = np.array([number_in_si(base, name, value, where) for value in values])
    return state, position


def _followers_of_unknowns(
    measurement: Measurement, base: Problem, unknown: Sequence[str]
) -> dict[str, tuple[str, ...]]:
    """Return the fields of the measurement's problem that follow each unknown.

    Raises
    ------
    InvalidProblem
        For fields that follow no unknown or do not exist, or without a problem of its own.
    """
    if measurement.problem is None:
        if measurement.fields:
            text = "needs problem=...; fields of the study's problem are tied by tie=..."
            raise InvalidProblem.at(f"{measurement.quantity}: fields", text)
        return {name: (name,) for name in unknown}
    for path, name in measurement.fields.items():
        if name not in unknown:
            text = f"{name!r} is not unknown{did_you_mean(name, unknown)}"
            raise InvalidProblem.at(f"{measurement.quantity}: fields: {path}", text)
        get_field(base, path)  # raises an error if the field does not exist
    return {
        name: tuple(path for path, target in measurement.fields.items() if target == name)
        for name in unknown
    }
