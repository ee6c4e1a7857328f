r"""The scatter of measured inputs as part of the standard deviations of the measured outputs.

A column "nip_load +- [kN/m]" states the standard deviations s_j of an input x_j of each row.  The
difference between a prediction Q(x) and a measured value y with the deviation s_y has the variance

    s_y^2 + sum_j (dQ/dx_j s_j)^2

to first order (method of effective variance, Orear 1982), with the derivatives of the base problem.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..errors import InvalidProblem, NotConverged
from .measurements import Observations
from .model import KindModel
from .predict import cases_of
from .slopes import solve_case

__all__ = ["with_input_scatter"]


def with_input_scatter(model: KindModel, data: Observations) -> Observations:
    """Return measured values whose standard deviations contain the scatter of the inputs.

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
