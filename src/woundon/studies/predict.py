"""Fitted parameters -> predicted values and their derivatives, over the measured rows."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import dataclass
from math import exp, log
from typing import Any, NamedTuple

import numpy as np

from ..errors import InvalidProblem
from .measured import Measured
from .model import Model

__all__ = ["Parameter", "Predictor"]

Array = np.ndarray
# Outputs are smooth except for kinks where a node changes its zone.  The step is so long that the
# solver's tolerance (1e-8 of the output) does not matter, and so short that curvature does not.
STEP = 1e-3
# Solutions that are kept for warm starts, those of at least three places: one takes 5 to 30 MB.
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

    def __post_init__(self) -> None:
        if not self.low < self.high or not np.isfinite([self.low, self.high]).all():
            text = f"bounds {self.low!r} to {self.high!r} must be finite, and low < high"
            raise InvalidProblem.at(self.name, text)

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


class _Place(NamedTuple):
    """The states of all cases at u."""

    u: Array
    states: list[Any]


class Predictor:
    """Predicts every measured value from the parameters' coordinates u, from ``low`` to ``high``.

    Each distinct row is solved once at each u, with a warm start from the nearest recent place.
    """

    def __init__(self, model: Model, measured: Measured, parameters: tuple[Parameter, ...]) -> None:
        self.model, self.parameters = model, parameters
        for parameter in parameters:
            if parameter.name in measured.inputs:
                raise InvalidProblem.at(parameter.name, "is measured, so it cannot be fitted")
        names = tuple(measured.inputs)
        rows = list(zip(*(measured.inputs[n].tolist() for n in names), strict=True))
        if not names:
            rows = [()] * len(next(iter(measured.outputs.values())))
        # rows with the same inputs are one case
        distinct = sorted(set(rows))
        self.cases: list[Mapping[str, Any]] = [dict(zip(names, r, strict=True)) for r in distinct]
        number_of = {row: k for k, row in enumerate(distinct)}
        entries = [
            (row, output)
            for output, values in measured.outputs.items()
            for row in np.nonzero(np.isfinite(values))[0].tolist()
        ]
        self.row_outputs = tuple(output for _, output in entries)
        self.row_numbers = tuple(row for row, _ in entries)
        # case and output of each measured value
        self.of_case = np.array([number_of[rows[row]] for row, _ in entries], dtype=np.intp)
        self.of_output = np.array([model.outputs.index(o) for _, o in entries], dtype=np.intp)
        self.measured = np.array([measured.outputs[o][row] for row, o in entries])
        deviations = [measured.deviations.get(o) for _, o in entries]
        self.weighted = all(d is not None for d in deviations)
        self.deviation = np.array(
            [1.0 if d is None else d[row] for (row, _), d in zip(entries, deviations, strict=True)]
        )
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
            try:
                self._values[key] = self._solve_all(u)
            except (ValueError, RuntimeError, ArithmeticError) as fault:
                self._values[key] = np.full(self.of_case.size, np.nan)
                self.fault = f"{type(fault).__name__}: {fault}"
            self.report()
        return self._values[key]

    def residuals(self, u: Array) -> Array:
        """Return (predicted - measured) / deviation, (m,)."""
        return (self.values(u) - self.measured) / self.deviation

    def jacobian(self, u: Array, fixed: int | None = None) -> Array:
        """Return the residuals' derivatives with respect to u by forward differences, (m, p).

        They cost one warm-started solution for each parameter and case; exact derivatives of a nip
        cost as much, and more with tied fields.

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
        base = self.values(u)
        J = np.zeros((base.size, u.size))
        for k, parameter in enumerate(self.parameters):
            if k == fixed:
                continue
            low, high = parameter.ends
            step = STEP * (1.0 if parameter.logarithmic else max(abs(u[k]), (high - low) / 10))
            step = min(step, (high - low) / 2)
            for end in (u[k] + step, u[k] - step):
                if low <= end <= high:
                    shifted = self.values(np.where(np.arange(u.size) == k, end, u))
                    J[:, k] = (shifted - base) / (end - u[k]) / self.deviation
                    if np.isfinite(J[:, k]).all():
                        break
            else:
                raise ValueError(f"no derivative with respect to {parameter.name}: {self.fault}")
        return J

    def variance(self, S: float) -> float:
        """Return the variance of the residuals, at most 1 if their deviations are known."""
        s2 = S / max(self.measured.size - len(self.parameters), 1)
        return min(s2, 1.0) if self.weighted else s2

    def remembering(self, u: Array) -> Predictor:
        """Return a copy that knows the states of one place only, to be sent to a process."""
        other = copy(self)
        nearest = self._nearest(u)
        other._values = {}
        other._places = deque(() if nearest is None else (nearest,), self._places.maxlen)
        other.report = _no_report
        return other

    def inputs(self, u: Array) -> dict[str, float]:
        """Return the parameters' values by name."""
        return {p.name: p.value(float(v)) for p, v in zip(self.parameters, u, strict=True)}

    def _solve_all(self, u: Array) -> Array:
        """Solve all cases, with warm starts from the nearest place; return the predictions."""
        nearest = self._nearest(u)
        fitted, out = self.inputs(u), np.empty((len(self.cases), len(self.model.outputs)))
        states: list[Any] = []
        for k, case in enumerate(self.cases):
            start = nearest.states[k] if nearest else states[-1] if states else None
            answer = self.model.run({**case, **fitted}, start)
            out[k] = answer.values
            states.append(answer.state)
            self.solves += 1
        self._places.append(_Place(u.copy(), states))
        return out[self.of_case, self.of_output]

    def _nearest(self, u: Array) -> _Place | None:
        """Return the nearest recent place."""
        width = self.high - self.low
        return min(
            self._places, key=lambda place: float(np.max(np.abs(place.u - u) / width)), default=None
        )


def _no_report() -> None:
    """Report nothing; a lambda could not be sent to a process."""
