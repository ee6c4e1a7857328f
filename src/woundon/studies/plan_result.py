"""The result of the choice of the next measurement: order, expected standard errors, warnings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ..problems.problem import Problem
from ..quantities import Quantity, header, in_chosen_units
from .outcome import Outcome
from .planned import Measurement

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["NextExperiment", "percent"]

Array = np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class NextExperiment(Outcome):
    """Candidates in the order in which they should be measured; p parameters, n steps.

    Attributes
    ----------
    names : tuple of str
        The unknown fields.
    values : (p,) array
        Where the outputs are linearised, SI.
    measurements : tuple of Measurement
        The selected ones, best first.
    scores : (n,) array
        Expected reduction of the criterion per cost, of each after those before it.
    standard_errors : (n + 1, p) array
        Expected relative standard errors of the parameters: before, and after each measurement.
    output : str
        The output at the operating point.
    output_value : float
        Its prediction, SI.
    output_errors : (n + 1,) array
        Expected standard error of it, SI.
    covariance : (p, p) array
        Of ln(parameters), after all selected measurements.
    candidates : tuple of Measurement
    first_scores : (1 + draws, candidates) array
        Scores as the first measurement, at the problem and at each point drawn.
    first_errors : (candidates, p) array
        Expected relative standard errors of the parameters after this candidate alone.
    unidentified : tuple of str
        Parameters whose standard error all candidates together reduce by less than 10 %.
    direction : (p,) array
        The change of ln(parameters) that all candidates together determine least; its largest
        entry is 1.
    direction_error : float
        Standard error along it.
    criterion : str
    warnings : tuple of str
    quantities : mapping of str to Quantity
    problem : object

    Examples
    --------
    >>> import woundon as wo
    >>> half_width = wo.Measurement("half_width", {}, "1 %")
    >>> plan = wo.next_experiment(
    ...     wo.RollerProblem.example(), {"upper.radius": "5 %"}, [half_width], draws=0
    ... )
    >>> plan.best.quantity
    'half_width'
    >>> before, after = plan.standard_errors[:, 0]
    >>> bool(after < before)
    True
    """

    names: tuple[str, ...]
    values: Array
    measurements: tuple[Measurement, ...]
    scores: Array
    standard_errors: Array
    output: str
    output_value: float
    output_errors: Array
    covariance: Array
    candidates: tuple[Measurement, ...]
    first_scores: Array
    first_errors: Array
    unidentified: tuple[str, ...]
    direction: Array
    direction_error: float
    criterion: str
    warnings: tuple[str, ...] = ()
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    problem: Problem | None = None

    @property
    def best(self) -> Measurement:
        """The measurement to do next."""
        return self.measurements[0]

    def answer(self) -> list[str]:
        """Return the next measurement, and the expected standard errors of each step."""
        quantity = self.quantities[self.output]
        texts = [f"next measurement: {self.best.name} (cost {self.best.cost:g})"]
        for k, step in enumerate(("now", *(m.name for m in self.measurements))):
            errors = zip(self.names, self.standard_errors[k], strict=True)
            parts = [f"{name} {percent(error)}" for name, error in errors]
            parts.append(f"{self.output} {quantity.text(self.output_errors[k], '.3g')}")
            texts.append(f"{'' if k == 0 else f'{k}. after '}{step}: {', '.join(parts)}")
        return texts

    def remarks(self) -> list[str]:
        """Return the quantities that the measurements do not determine, and warnings."""
        texts = []
        if self.unidentified:
            texts.append(f"not identified by any candidate: {', '.join(self.unidentified)}")
        if len(self.names) > 1:
            # with 10 % of the leading parameter, whose entry is 1
            change = ", ".join(
                f"{name} {10 * value:+.0f} %"
                for name, value in zip(self.names, self.direction, strict=True)
                if abs(value) >= 0.05  # shown as 0 % otherwise
            )
            texts.append(
                f"least determined change with all candidates: {change}; "
                f"standard error {percent(self.direction_error)}"
            )
        return [*texts, *(f"warning: {in_chosen_units(text)}" for text in self.warnings)]

    def __repr__(self) -> str:
        before_and_after_best = self.standard_errors[[0, 1]].T
        errors = zip(self.names, before_and_after_best, strict=True)
        change = ", ".join(f"{n} {percent(a)} -> {percent(b)}" for n, (a, b) in errors)
        return f"NextExperiment({self.best.name}: {change})"

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each step: cost, score, expected standard errors (output: SI)."""
        import pandas as pd

        columns: dict[str, Any] = {
            "cost": [0.0, *(m.cost for m in self.measurements)],
            "score": [np.nan, *self.scores],
        }
        columns |= {f"{name} +-": self.standard_errors[:, j] for j, name in enumerate(self.names)}
        columns[header(f"{self.output} +-", self.quantities[self.output].unit)] = self.output_errors
        steps = pd.Index(["now", *(m.stored_name for m in self.measurements)], name="measurement")
        return pd.DataFrame(columns, index=steps)

    def _record(self) -> dict[str, Any]:
        names = [candidate.stored_name for candidate in self.candidates]
        return {
            "criterion": self.criterion,
            "steps": self.to_dataframe().reset_index().to_dict(orient="records"),
            "first_scores": dict(zip(names, self.first_scores[0], strict=True)),
            "unidentified": self.unidentified,
            "direction": dict(zip(self.names, self.direction, strict=True)),
            "direction_error": self.direction_error,
            "warnings": self.warnings,
        }


def percent(error: float) -> str:
    """Return a relative standard error as text: "2.5 %", "140 %"."""
    return f"{100 * error:.2g} %" if error < 1 else f"{100 * error:.0f} %"
