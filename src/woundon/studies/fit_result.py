"""The result of a fit: estimates with their uncertainties, and its texts and tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from math import expm1, isfinite, log, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidProblem
from ..problems.messages import not_one_of
from ..quantities import Quantity, pure
from .outcome import Outcome
from .profiles import ProfileLikelihood

if TYPE_CHECKING:
    import pandas as pd
    import xarray

__all__ = ["FitResult"]

Array = np.ndarray
MOST_SHOWN = 3  # parameters in one line
_SAVED = (  # attributes in the record for JSON
    *("names", "estimates", "standard_errors", "covariance", "correlation", "rms", "weighted"),
    *("direction", "condition", "effects", "joint_effect", "at_bound", "not_identified"),
    *("minima", "reached", "starts", "solves", "measured", "fitted", "row_outputs", "row_numbers"),
)


@dataclass(frozen=True, eq=False, repr=False)
class FitResult(Outcome):
    """Result of :func:`woundon.fit`, of m measured values and p parameters.

    Attributes
    ----------
    names : tuple of str
    estimates, standard_errors : (p,) arrays
        SI.
    covariance, correlation : (p, p) arrays
    rms : float
        Root mean square of the residuals, in the unit of the outputs, or in standard deviations if
        ``weighted``.
    profiles : tuple of ProfileLikelihood
        Profiles with 95 % intervals; empty if not requested.
    direction : (p,) array
        The direction to which the predictions are least sensitive, in ln(value), or in value /
        range if a bound is not positive; the largest entry is 1.
    condition : float
        Ratio of the largest to the smallest singular value of the scaled Jacobian.
    effects : (p,) array
        RMS change of the predictions for +10 % of each parameter (or 10 % of the range), in the
        unit of ``rms``.
    joint_effect : float
        The same for a change along ``direction`` with +10 % of the leading parameter.
    at_bound : tuple of str
        Parameters whose estimates are at a bound.
    minima : tuple of (S, estimates)
        Minima of all starts, best first.
    reached : int
        Number of starts, of ``starts``, that converged to the best minimum.
    solves : int
        Number of cases that were solved.
    measured, fitted : (m,) arrays
        SI.
    row_outputs, row_numbers : tuples
        Output and row of each measured value; rows are counted from 0.
    weighted : bool
        Whether the standard deviations of all measured values are known.
    quantities : mapping of str to Quantity
        Of parameters and outputs.
    problem : object
        The base problem with the estimates.

    Examples
    --------
    >>> import woundon as wo
    >>> rows = {"load": [50e3, 120e3], "half_width": [265e-6, 411e-6]}  # SI
    >>> found = wo.fit(wo.RollerProblem.example(), rows, "lower.radius", starts=1, nodes=17)
    >>> found.problem.lower.radius == found.estimate("lower.radius")
    True
    >>> found.to_dataframe().loc["lower.radius", "unit"]
    'm'
    """

    names: tuple[str, ...]
    estimates: Array
    standard_errors: Array
    covariance: Array
    correlation: Array
    rms: float
    direction: Array
    condition: float
    effects: Array
    joint_effect: float
    at_bound: tuple[str, ...]
    minima: tuple[tuple[float, tuple[float, ...]], ...]
    reached: int
    starts: int
    solves: int
    measured: Array
    fitted: Array
    row_outputs: tuple[str, ...]
    row_numbers: tuple[int, ...]
    weighted: bool
    profiles: tuple[ProfileLikelihood, ...] = ()
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    problem: Any = None

    @property
    def degrees_of_freedom(self) -> int:
        """Number of measured values less that of the parameters."""
        return self.measured.size - len(self.names)

    @property
    def not_identified(self) -> tuple[str, ...]:
        """Names of the parameters that the data do not identify: standard error above 100 %."""
        errors = zip(self.names, self.estimates, self.standard_errors, strict=True)
        return tuple(n for n, value, error in errors if value and not error < abs(value))

    def estimate(self, name: str) -> float:
        """Return the estimate of one parameter.

        Raises
        ------
        InvalidProblem
            If it is none of the fitted parameters.
        """
        if not isinstance(name, str) or name not in self.names:
            raise InvalidProblem.at("name", not_one_of(name, self.names))
        return float(self.estimates[self.names.index(name)])

    # ---- texts ----------------------------------------------------------------------------------

    def __repr__(self) -> str:
        texts = [f"{name}={self._quantity(name).text(self.estimate(name))}" for name in self.names]
        hidden = len(texts) - MOST_SHOWN
        texts[MOST_SHOWN:] = [f"{hidden} more"] if hidden > 0 else []
        rms = f"RMS {self._rms_text(self.rms)} of {self.measured.size} measured values"
        return f"FitResult({', '.join(texts)}; {rms})"

    def answer(self) -> list[str]:
        """Return the size of the residuals, and a line for each parameter."""
        m, p = self.measured.size, len(self.names)
        head = (
            f"{m} measured values, {p} fitted {'parameter' if p == 1 else 'parameters'}, "
            f"RMS {self._rms_text(self.rms)}; {self.reached} of {self.starts} starts converged "
            "to this minimum"
        )
        return [head, *(self._estimate_text(k) for k in range(p))]

    def remarks(self) -> list[str]:
        """Return remarks on other minima, correlations and combinations that are not identified."""
        return [*self._other_minimum(), *self._trade_offs()]

    def _quantity(self, name: str) -> Quantity:
        """Return the quantity of a parameter or an output; a pure number if it has none."""
        return self.quantities.get(name, pure("", name))

    def _rms_text(self, value: float, form: str = ".4g") -> str:
        """Return a root mean square of residuals with its unit."""
        if self.weighted:
            return f"{value:{form}} standard deviations"
        return self._quantity(self.row_outputs[0]).text(value, form)

    def _estimate_text(self, k: int) -> str:
        """Return estimate, standard error and profile interval of a parameter."""
        name, value, error = self.names[k], self.estimates[k], self.standard_errors[k]
        is_known = isfinite(error) and name not in self.not_identified
        with_error = self._quantity(name).text(value, error=error if is_known else nan)
        text = f"{name:<{max(map(len, self.names))}}  {with_error}"
        if name in self.not_identified:
            text += "; not identified by the data (standard error above 100 %)"
        elif is_known:
            relative = f" {100 * error / abs(value):.2g} %" if value else ""
            text += f" (standard error{relative})"
        interval = self._intervals().get(name)
        if interval is not None:
            ends = [self._quantity(name).text(end) if isfinite(end) else "open" for end in interval]
            text += f"; 95 % profile interval {' to '.join(ends)}"
            if ends == ["open", "open"]:
                text += ": the data do not determine it within its bounds"
        if name in self.at_bound:
            text += "; at its bound: widen the bounds, or the data do not determine it"
        return text

    def _intervals(self) -> dict[str, tuple[float, float]]:
        """Return the 95 % intervals of the parameters that have a profile."""
        return {profile.name: (profile.low, profile.high) for profile in self.profiles}

    def _other_minimum(self) -> Iterator[str]:
        """Yield a line on the second-best local minimum, if there is one."""
        # sorted by the sum of squared residuals; the first ones are the best minimum
        for sum_of_squares, values in self.minima[self.reached :][:1]:
            pairs = zip(self.names, values, strict=True)
            place = ", ".join(f"{name} {self._quantity(name).text(value)}" for name, value in pairs)
            rms = self._rms_text((sum_of_squares / self.measured.size) ** 0.5)
            yield f"second-best local minimum: RMS {rms} at {place}"

    def _trade_offs(self) -> Iterator[str]:
        """Yield correlations and the least identified combination of parameters."""
        p = len(self.names)
        for j in range(p):
            for k in range(j):
                if abs(r := self.correlation[j, k]) > 0.9:
                    yield f"correlation of {self.names[k]} and {self.names[j]}: {r:.4f}"
        if p == 1:
            change = self._rms_text(self.effects[0], ".3g")
            yield f"+10 % of {self.names[0]} changes the fitted values by {change} (RMS)"
            return
        leading = int(np.argmax(np.abs(self.direction)))
        # changes of all parameters when the leading one is 10 % larger; below 2 % of it not shown
        moves = [
            f"{name} {expm1(log(1.1) * part):+.1%}"
            for name, part in zip(self.names, self.direction, strict=True)
            if abs(part) > 0.02
        ]
        text = (
            f"{' with '.join(moves)} together change the fitted values by "
            f"{self._rms_text(self.joint_effect, '.3g')} (RMS); {self.names[leading]} +10 % alone "
            f"by {self._rms_text(self.effects[leading], '.3g')}"
        )
        if self.joint_effect < 0.2 * self.effects[leading]:
            text = f"nearly non-identifiable combination: {text}"
        yield f"{text}; condition number {self.condition:.3g}"

    # ---- tables ---------------------------------------------------------------------------------

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each parameter: estimate, standard error, 95 % interval, unit [SI].

        The interval is infinite on a side where it has no end.
        """
        import pandas as pd

        ends = np.array([self._intervals().get(name, (nan, nan)) for name in self.names])
        columns = {
            "estimate": self.estimates,
            "standard_error": self.standard_errors,
            "low": ends[:, 0],
            "high": ends[:, 1],
            "unit": [self._unit(name) for name in self.names],
        }
        frame = pd.DataFrame(columns, index=pd.Index(self.names, name="parameter"))
        frame.attrs["long_names"] = {
            "low": "low end of the 95 % profile interval",
            "high": "high end of the 95 % profile interval",
        }
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """Return parameters along ``parameter`` and measured values along ``measurement`` [SI]."""
        units = [self._unit(name) for name in self.row_outputs]
        dims = ("parameter", "parameter_2")
        return (
            self.to_dataframe()
            .to_xarray()
            .set_coords("unit")
            .assign(
                covariance=(dims, self.covariance),
                correlation=(dims, self.correlation),
                measured=("measurement", self.measured),
                fitted=("measurement", self.fitted),
            )
            .assign_coords(
                parameter_2=list(self.names),
                output=("measurement", list(self.row_outputs)),
                row=("measurement", list(self.row_numbers)),
                output_unit=("measurement", units),
            )
            .assign_attrs(
                rms=self.rms, rms_unit="standard deviations" if self.weighted else units[0]
            )
        )

    def _unit(self, name: str) -> str:
        """Return the SI unit of a parameter or an output, '' of a pure number."""
        unit = self._quantity(name).unit
        return "" if unit == "1" else unit

    def _record(self) -> dict[str, Any]:
        record: dict[str, Any] = {name: getattr(self, name) for name in _SAVED}
        record["units"] = {name: quantity.unit for name, quantity in self.quantities.items()}
        record["profiles"] = {
            p.name: {"low": p.low, "high": p.high, "values": p.values, "rms": p.rms}
            for p in self.profiles
        }
        if hasattr(self.problem, "model_dump"):
            record["problem"] = self.problem.model_dump()
        return record
