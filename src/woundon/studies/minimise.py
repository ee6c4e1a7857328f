"""Local minima of S(u) = |r(u)|^2 by scipy.optimize.least_squares."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .predict import Predictor

__all__ = ["Minimum", "minimise"]

Array = np.ndarray

EVALUATIONS = 60  # of one minimisation
# of the bounds' distance: the last step where S is rough, because nodes change their zones
SMALLEST_STEP = 1e-6
# share of the change of the residuals that the linear model of a minimum may miss in its basin
LINEAR = 0.3


class Minimum(NamedTuple):
    """A minimum: coordinates, residuals and their derivatives."""

    u: Array
    r: Array
    J: Array

    @property
    def S(self) -> float:
        """Sum of the squared residuals."""
        return float(self.r @ self.r)

    def predicts(self, u: Array, r: Array) -> bool:
        """Return True if the linear model about the minimum predicts the residuals at u."""
        change = r - self.r
        error = change - self.J @ (u - self.u)
        return bool(np.linalg.norm(error) <= LINEAR * np.linalg.norm(change))


class _InBasinError(Exception):
    """The minimisation has entered the basin of a known minimum."""


def minimise(
    predictor: Predictor, start: Array, standard_errors: float, known: Minimum | None = None
) -> Minimum | None:
    """Return a local minimum.

    Parameters
    ----------
    predictor : Predictor
    start : (p,) array
    standard_errors : float
        Accuracy of the minimum, in standard errors of the parameters.
    known : Minimum, optional
        It is returned as soon as its linear model predicts the residuals.

    Returns
    -------
    Minimum or None
        None if the start, or a derivative on the way, cannot be solved.
    """
    from scipy.optimize import least_squares

    def residuals(u: Array) -> Array:
        """Return the residuals; stop if the linear model at a known minimum predicts them."""
        r = predictor.residuals(u)
        if known is not None and known.predicts(u, r):
            raise _InBasinError
        return r

    start = np.clip(start, predictor.low, predictor.high)
    if not np.isfinite(predictor.residuals(start)).all():
        return None
    freedom = max(predictor.measured.size - start.size, 1)
    try:
        # a step of e standard errors changes S by e^2 S/(m - p); no gtol, which is absolute: the
        # residuals of small outputs, such as a creepage, would be below it at once
        end = least_squares(
            residuals,
            start,
            predictor.differences,
            (predictor.low, predictor.high),
            method="dogbox",
            x_scale="jac",
            ftol=standard_errors**2 / freedom,
            xtol=SMALLEST_STEP,
            gtol=None,
            max_nfev=EVALUATIONS,
        )
    except _InBasinError:
        return known
    except ValueError:  # a derivative could not be solved
        return None
    return Minimum(np.asarray(end.x), np.asarray(end.fun), np.asarray(end.jac))
