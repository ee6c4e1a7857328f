"""Parameters -> predicted values and their derivatives, of all measured values.

Values with the same inputs belong to one case, which is solved once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, log
from typing import Any, NamedTuple

import numpy as np

from ..errors import InvalidProblem, NotConverged
from ..results import Result
from .model import KindModel
from .observations import Observable, Observations, predict
from .slopes import slopes, solve_case

__all__ = ["Case", "Parameter", "Predictor", "cases_of", "with_input_scatter"]

Array = np.ndarray
# Solutions that are kept for warm starts, those of at least three points u: one takes 5 to 30 MB.
KEPT, MIN_PLACES = 60, 3


@dataclass(frozen=True)
class Parameter:
    """A fitted parameter; its coordinate u is ln(value) if the bounds are positive.

    Attributes
    ----------
    name : str
        Dotted name of the field.
    low, high : float
        Bounds.
    base : float, optional
        First starting point; the middle of the bounds if None.

    Examples
    --------
    >>> Parameter("roll_friction", 0.1, 0.4, None).value(Parameter("f", 0.1, 0.4, None).start)
    0.2
    """

    name: str
    low: float
    high: float
    base: float | None

    @property
    def logarithmic(self) -> bool:
        """True if u is the logarithm of the value."""
        return self.low > 0

    def coordinate(self, value: float) -> float:
        """Return u."""
        return log(value) if self.logarithmic else value

    def value(self, u: float) -> float:
        """Return the value at u, within the bounds in spite of rounding."""
        return min(max(exp(u) if self.logarithmic else u, self.low), self.high)

    def slope(self, u: float) -> float:
        """Return d value/du."""
        return exp(u) if self.logarithmic else 1.0

    def scale(self, u: float) -> float:
        """Return the scale of the step of a difference: the value, or a tenth of the range."""
        return self.value(u) if self.logarithmic else max(abs(u), (self.high - self.low) / 10)

    @property
    def ends(self) -> tuple[float, float]:
        """Bounds of u."""
        return self.coordinate(self.low), self.coordinate(self.high)

    @property
    def start(self) -> float:
        """Coordinate of the first starting point."""
        if self.base is None:
            return sum(self.ends) / 2
        return self.coordinate(min(max(self.base, self.low), self.high))


class Case(NamedTuple):
    """A case, and the values that its solution predicts.

    Attributes
    ----------
    inputs : mapping
        Fields that differ from the base problem.
    rows : list of int
        Numbers of the values in the list of all values.
    observables : list of Observable
        Output and radius of each of them.
    """

    inputs: Mapping[str, Any]
    rows: list[int]
    observables: list[Observable]

    def predictions(self, result: Result) -> Array:
        """Return the predictions of a result of the case, (rows,)."""
        return np.array([predict(result, observable) for observable in self.observables])

    def slopes(self, model: KindModel, result: Result, names: Sequence[str]) -> Array:
        """Return the derivatives of the predictions, (rows, fields) [SI]; nan if not solved."""
        return slopes(model, result, self.observables, names, self.inputs, nan_if_unsolved=True)


def cases_of(inputs: Mapping[str, Array], observables: Sequence[Observable]) -> list[Case]:
    """Return the distinct cases of some values, sorted by their inputs.

    Parameters
    ----------
    inputs : mapping of str to (m,) array
        Fields of each value.
    observables : sequence of m Observable

    Examples
    --------
    >>> values = [Observable("nip_width"), Observable("approach"), Observable("nip_width")]
    >>> [case.rows for case in cases_of({"load": np.array([2.0, 1.0, 2.0])}, values)]
    [[1], [0, 2]]
    """
    rows_of: dict[tuple[Any, ...], list[int]] = {}
    for k in range(len(observables)):
        rows_of.setdefault(tuple(float(values[k]) for values in inputs.values()), []).append(k)
    return [
        Case(dict(zip(inputs, key, strict=True)), rows, [observables[k] for k in rows])
        for key, rows in sorted(rows_of.items())
    ]


class _Place(NamedTuple):
    """A point u of the parameters' coordinates, with the results of all cases there."""

    u: Array
    results: list[Result]


class Predictor:
    """Predicts every measured value from the parameters' coordinates u, from ``low`` to ``high``.

    Each case is solved once at each u, with a warm start from the nearest recent point.

    Attributes
    ----------
    measured, deviation : (m,) arrays
        Measured values and their standard deviations, 1 where these are not known.
    weighted : bool
        Whether all standard deviations are known.
    low, high : (p,) arrays
        Bounds of u.
    solves : int
        Number of solutions so far.
    fault : str
        Reason of the last failure.
    report : callable
        Is called after each evaluation.
    """

    def __init__(
        self, model: KindModel, data: Observations, parameters: tuple[Parameter, ...]
    ) -> None:
        self.model, self.data, self.parameters = model, data, parameters
        for parameter in parameters:
            if parameter.name in data.inputs:
                raise InvalidProblem.at(parameter.name, "is measured, so it cannot be fitted")
        self.cases = cases_of(data.inputs_of_values, data.observables)
        self.measured = data.measured
        self.weighted = bool(np.isfinite(data.deviation).all())
        self.deviation = np.where(np.isfinite(data.deviation), data.deviation, 1.0)
        self.low, self.high = np.transpose([p.ends for p in parameters])
        self.solves, self.fault = 0, ""
        self.report: Callable[[], None] = _no_report
        self._values: dict[bytes, Array] = {}
        self._places: deque[_Place] = deque(maxlen=max(MIN_PLACES, KEPT // len(self.cases)))

    def values(self, u: Array) -> Array:
        """Return the predictions, (m,); all are nan if a case fails.

        Those of each u are computed once.
        """
        key = u.tobytes()
        if key not in self._values:
            values = self._values[key] = np.full(self.measured.size, np.nan)
            try:
                for case, result in zip(self.cases, self._results(u), strict=True):
                    values[case.rows] = case.predictions(result)
            except (ValueError, RuntimeError, ArithmeticError) as fault:
                values[:] = np.nan
                self.fault = f"{type(fault).__name__}: {fault}"
            self.report()
        return self._values[key]

    def residuals(self, u: Array) -> Array:
        """Return (predicted - measured) / deviation, (m,)."""
        return (self.values(u) - self.measured) / self.deviation

    def jacobian(self, u: Array, fixed: int | None = None) -> Array:
        """Return the residuals' derivatives with respect to u, (m, p).

        Differences are one-sided: they direct the minimisation, and take half the solutions.

        Parameters
        ----------
        u : (p,) array
        fixed : int, optional
            Parameter whose column is left zero.

        Raises
        ------
        ValueError
            If a derivative cannot be solved on either side.
        """
        J = np.zeros((self.measured.size, u.size))
        free = [k for k in range(u.size) if k != fixed]
        if not free:
            return J
        names = [self.parameters[k].name for k in free]
        fitted = self.inputs(u)
        scales = [self.parameters[k].scale(float(u[k])) for k in free]
        try:
            for case, result in zip(self.cases, self._results(u), strict=True):
                J[np.ix_(case.rows, free)] = slopes(
                    self.model,
                    result,
                    case.observables,
                    names,
                    {**case.inputs, **fitted},
                    scales=scales,
                    central=False,
                    solve=self._solve,
                )
        except (ValueError, RuntimeError, ArithmeticError) as fault:
            raise ValueError(f"no derivative of the predictions: {fault}") from fault
        for _ in free:
            self.report()
        slope = np.array([p.slope(float(v)) for p, v in zip(self.parameters, u, strict=True)])
        return J * slope / self.deviation[:, None]

    def variance(self, S: float) -> float:
        """Return the variance of the residuals for their squared sum S.

        At most 1 if their deviations are known.
        """
        s2 = S / max(self.measured.size - len(self.parameters), 1)
        return min(s2, 1.0) if self.weighted else s2

    def keep_for_workers(self, u: Array) -> None:
        """Move the point nearest to u (p,), with its results, to the end.

        A pickled predictor contains the results of the last point only, for warm starts; all of
        them would be large.
        """
        nearest = self._nearest(u)
        if nearest is not None:
            self._places = deque(
                [*(place for place in self._places if place is not nearest), nearest],
                self._places.maxlen,
            )

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for a worker: the results of the last point only, and no report."""
        last = deque([*self._places][-1:], self._places.maxlen)
        return {**self.__dict__, "_values": {}, "_places": last, "report": _no_report}

    def inputs(self, u: Array) -> dict[str, float]:
        """Return the parameters' values at the coordinates u (p,), by name."""
        return {p.name: p.value(float(v)) for p, v in zip(self.parameters, u, strict=True)}

    def _results(self, u: Array) -> list[Result]:
        """Return the results of all cases at u (p,), with warm starts from the nearest point."""
        nearest = self._nearest(u)
        if nearest is not None and np.array_equal(nearest.u, u):
            return nearest.results
        fitted = self.inputs(u)
        results: list[Result] = []
        for k, case in enumerate(self.cases):
            # at the first point from the case before
            start = nearest.results[k] if nearest else results[-1] if results else None
            results.append(self._solve(self.model, {**case.inputs, **fitted}, start))
        self._places.append(_Place(u.copy(), results))
        return results

    def _solve(self, model: KindModel, inputs: Mapping[str, Any], start: Result | None) -> Result:
        """Solve a case and count it."""
        result: Result = solve_case(model, inputs, start)
        self.solves += 1
        return result

    def _nearest(self, u: Array) -> _Place | None:
        """Return the recent point nearest to u (p,), None at first.

        The distance is the largest change of a parameter as a share of its range.
        """
        width = self.high - self.low
        return min(
            self._places, key=lambda place: float(np.max(np.abs(place.u - u) / width)), default=None
        )


def _no_report() -> None:
    """Report nothing; a lambda could not be sent to a worker."""


def with_input_scatter(model: KindModel, data: Observations) -> Observations:
    """Return measured values whose standard deviations contain the scatter of the inputs.

    The difference between a prediction Q(x) and a measured value y with the deviation s_y has the
    variance

        s_y^2 + sum_j (dQ/dx_j s_j)^2

    to first order (method of effective variance, Orear 1982), with the derivatives of the base
    problem and the standard deviations s_j of the inputs x_j of its row, which a column
    "nip_load +- [kN/m]" states.

    Values without a standard deviation of their own remain without one: their scatter, which
    contains that of the inputs, follows from the residuals.

    Parameters
    ----------
    model : KindModel
        The base problem.
    data : Observations
    """
    if not data.input_deviations or not np.isfinite(data.deviation).any():
        return data
    names = list(data.input_deviations)
    scatter = np.column_stack([data.input_deviations[name][data.rows] for name in names])  # (m, j)
    variance, start = np.zeros(len(data.names)), None
    for case in cases_of(data.inputs_of_values, data.observables):
        try:
            start = result = solve_case(model, case.inputs, start)
            derivatives = case.slopes(model, result, names)
        except (InvalidProblem, NotConverged):  # reported where the value is predicted
            continue
        effects = np.nan_to_num(derivatives) * scatter[case.rows]
        variance[case.rows] = np.sum(effects**2, axis=1)
    return replace(data, deviation=np.hypot(data.deviation, np.sqrt(variance)))
