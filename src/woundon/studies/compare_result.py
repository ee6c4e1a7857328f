"""The result of a comparison of measurement and prediction: agreement, error budget, explanations.

    residual = measured - predicted
    total^2 = deviation^2 + error^2 + spread^2

deviation: standard deviation of the measurement; error: estimated discretisation error; spread:
standard deviation of the prediction from those of uncertain inputs, s dQ/dx for each input x with
the standard deviation s.
Deviations are independent; errors and spreads are common to all rows, and do not average out.

Reference: Evaluation of measurement data - Guide to the expression of uncertainty in measurement,
JCGM 100:2008, sec. 5.1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isnan, nan, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..errors import InvalidProblem
from ..problems.messages import not_one_of
from ..problems.problem import Problem
from ..quantities import Quantity, in_chosen_units
from .outcome import Outcome

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Agreement", "Comparison", "Explanation"]

Array = np.ndarray


class Explanation(NamedTuple):
    """A systematic difference and its possible causes.

    Attributes
    ----------
    output : str
    finding : str
        What the data show, with numbers.
    causes : tuple of str
        Possible causes, in no order; empty if the finding needs none.

    The texts have the usual units; :meth:`lines` converts them to the chosen ones.
    """

    output: str
    finding: str
    causes: tuple[str, ...] = ()

    def lines(self) -> list[str]:
        """Return finding and causes as lines of text."""
        head = f"{self.output}: {in_chosen_units(self.finding)}"
        if not self.causes:
            return [head]
        return [
            f"{head}. Possible causes:",
            *(f"  - {in_chosen_units(cause)}" for cause in self.causes),
        ]


class Agreement(NamedTuple):
    """Agreement of a measured output with its predictions, SI units.

    Attributes
    ----------
    size : int
        Values that could be compared.
    bias, bias_uncertainty : float
        Mean residual and its standard uncertainty.
    relative_bias : float
        Mean residual over the mean of the predictions.
    rms, expected_rms : float
        Root mean square of the residuals, and of their total standard uncertainties.
    coverage : float
        Share of the residuals within two standard uncertainties, 0.95 is expected; nan without the
        standard deviations of the measurement.
    """

    size: int
    bias: float
    bias_uncertainty: float
    relative_bias: float
    rms: float
    expected_rms: float
    coverage: float


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Outcome):
    """Measured values, predictions and the error budget; m values, SI units.

    Attributes
    ----------
    names : tuple of str
        The output of each value.
    numbers : tuple of int
        Row of each value, as a spreadsheet shows it.
    position : (m,) array
        Radius of the measurement in the roll [m]; nan of a value that belongs to no radius.
    measured, predicted : (m,) arrays
        The latter nan where the case has no solution.
    deviation, error : (m,) arrays
        Standard deviation of the measurement and estimated discretisation error; nan if not known.
    sources : tuple of str
        The uncertain inputs, and "pull tab" for its calibration.
    effects : (m, sources) array
        What one standard deviation of each changes in the predictions.
    inputs : mapping of str to (m,) array
        The varied inputs of each value.
    covariates : tuple of str
        Those of them that the problem does not contain, such as the web speed of a nip without air:
        they are used for trends only.
    failures : tuple of str
        Why a value has no prediction, '' if it has one.
    notes : tuple of str
        Definitions of measured quantities that have two.
    quantities : mapping of str to Quantity
    explanations : tuple of Explanation
        Possible causes of systematic differences; the data do not decide between them.
    problem : Problem

    Examples
    --------
    >>> import woundon as wo
    >>> rows = {"load [kN/m]": [50.0, 89.0], "nip_width [mm]": [0.54, 0.72]}
    >>> check = wo.compare(wo.RollerProblem.example(), rows, nodes=33)
    >>> round(check.agreement("nip_width").bias * 1e3, 2)  # mm
    0.01
    """

    names: tuple[str, ...]
    numbers: tuple[int, ...]
    position: Array
    measured: Array
    predicted: Array
    deviation: Array
    error: Array
    sources: tuple[str, ...]
    effects: Array
    inputs: Mapping[str, Array]
    failures: tuple[str, ...]
    quantities: Mapping[str, Quantity]
    problem: Problem
    covariates: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    explanations: tuple[Explanation, ...] = ()

    @property
    def outputs(self) -> tuple[str, ...]:
        """The measured outputs."""
        return tuple(dict.fromkeys(self.names))

    @property
    def residual(self) -> Array:
        """Measured minus predicted, (m,)."""
        return self.measured - self.predicted

    @property
    def spread(self) -> Array:
        """Standard deviation of the predictions from that of the inputs, (m,)."""
        return np.asarray(np.sqrt(np.sum(self.effects**2, axis=1)))

    @property
    def total(self) -> Array:
        """Standard uncertainty of the residuals, (m,); unknown parts count as zero."""
        known = [np.nan_to_num(self.deviation), np.nan_to_num(self.error), self.spread]
        return np.asarray(np.sqrt(np.sum(np.square(known), axis=0)))

    @property
    def ratio(self) -> Array:
        """Residual over its standard uncertainty, (m,); nan without that of the measurement."""
        return np.asarray(self.residual / np.where(np.isnan(self.deviation), nan, self.total))

    def of(self, output: str) -> Array:
        """Return the mask of the values of an output that have a prediction, (m,) of bool.

        Raises
        ------
        InvalidProblem
            If it is none of the measured outputs.
        """
        if not isinstance(output, str) or output not in self.names:
            raise InvalidProblem.at("output", not_one_of(output, self.outputs))
        return np.array([name == output for name in self.names]) & np.isfinite(self.predicted)

    def agreement(self, output: str) -> Agreement:
        """Return the agreement of an output with its predictions."""
        rows = self.of(output)
        n = int(rows.sum())
        if n == 0:
            return Agreement(0, *[nan] * 6)  # all other fields
        residual, total = self.residual[rows], self.total[rows]
        bias = float(residual.mean())
        deviation = self.deviation[rows]
        scatter = float(residual.std(ddof=1)) if n > 1 else nan
        # the scatter of the rows stands in for deviations that are not known
        random = np.where(np.isnan(deviation), np.nan_to_num(scatter), deviation)
        common = self.effects[rows].mean(axis=0)
        error = float(np.nan_to_num(self.error[rows]).mean())
        uncertainty = sqrt(float(np.sum(random**2)) / n**2 + float(np.sum(common**2)) + error**2)
        mean = float(np.mean(self.predicted[rows]))
        coverage = nan if np.isnan(deviation).any() else np.mean(np.abs(residual) <= 2 * total)
        return Agreement(
            n,
            bias,
            uncertainty,
            bias / mean if mean else nan,
            _rms(residual),
            _rms(total),
            float(coverage),
        )

    def __repr__(self) -> str:
        texts = []
        for output in self.outputs:
            agreement = self.agreement(output)
            texts.append(
                f"{output}: {agreement.size} values, {100 * agreement.relative_bias:+.2g} %"
            )
        return f"Comparison({'; '.join(texts)})"

    def answer(self) -> list[str]:
        """Return the agreement of the first output as a line of text."""
        return [self._agreement_text(self.outputs[0])]

    def remarks(self) -> list[str]:
        """Return the agreement of further outputs, failures, notes and possible explanations."""
        texts = [self._agreement_text(output) for output in self.outputs[1:]]
        failed = [pair for pair in zip(self.numbers, self.failures, strict=True) if pair[1]]
        if failed:
            number, reason = failed[0]
            count = "1 value" if len(failed) == 1 else f"{len(failed)} values"
            why = in_chosen_units(reason)
            texts.append(f"{count} without a prediction, e.g. row {number}: {why}")
        for name in self.covariates:
            texts.append(f"{name} is not part of this problem: it is used for trends only")
        texts += [in_chosen_units(note) for note in self.notes]
        return [*texts, *(line for entry in self.explanations for line in entry.lines())]

    def _agreement_text(self, output: str) -> str:
        """Return the agreement of an output as a line."""
        agreement, quantity = self.agreement(output), self.quantities[output]
        if agreement.size == 0:
            return f"{output}: no value with a prediction"

        uncertainty = agreement.bias_uncertainty or nan  # zero if no part of it is known
        parts = [
            f"{output}: {agreement.size} {'value' if agreement.size == 1 else 'values'}",
            f"measured - predicted {quantity.text(agreement.bias, '+.3g', error=uncertainty)} "
            f"({100 * agreement.relative_bias:+.2g} %)",
            f"RMS {quantity.text(agreement.rms, '.3g')}",
        ]
        if not isnan(agreement.coverage):
            parts.append(f"expected {quantity.text(agreement.expected_rms, '.3g')}")
            parts.append(f"{100 * agreement.coverage:.0f} % within two standard uncertainties")
        return ", ".join(parts)

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each measured value: prediction, residual and its budget, SI units."""
        import pandas as pd

        columns: dict[str, Any] = {"row": self.numbers, "output": self.names}
        if np.isfinite(self.position).any():
            columns["measured_radius"] = self.position
        columns |= dict(self.inputs)
        columns |= {
            "measured": self.measured,
            "predicted": self.predicted,
            "residual": self.residual,
            "deviation": self.deviation,
            "error": self.error,
            "spread": self.spread,
            "total": self.total,
            "ratio": self.ratio,
            "failure": self.failures,
        }
        frame = pd.DataFrame(columns)
        # behind row and output
        frame.insert(2, "unit", [self.quantities[name].unit for name in self.names])
        return frame

    def table(self) -> list[str]:
        """Return all values as lines of text, in units for display."""
        head = f"{'row':>5}  {'output':20} {'measured':>11} {'predicted':>11} {'residual':>11}"
        texts = [f"{head} {'uncertainty':>11}  unit"]
        columns = (self.measured, self.predicted, self.residual)
        for k, (number, name) in enumerate(zip(self.numbers, self.names, strict=True)):
            quantity = self.quantities[name]
            cells = " ".join(f"{quantity.shown(column[k]):11.5g}" for column in columns)
            # zero if no part of it is known
            total = float(self.total[k])
            cells += f" {quantity.shown(total):11.5g}" if total else f" {'-':>11}"
            note = f"  {in_chosen_units(self.failures[k])}" if self.failures[k] else ""
            texts.append(f"{number:5}  {name:20} {cells}  {quantity.display}{note}")
        return texts

    def _record(self) -> dict[str, Any]:
        return {
            "values": self.to_dataframe().to_dict(orient="records"),
            "agreement": {name: self.agreement(name)._asdict() for name in self.outputs},
            "sources": list(self.sources),
            "explanations": [entry._asdict() for entry in self.explanations],
        }


def _rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))
