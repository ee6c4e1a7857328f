"""Local minima of S(u) = |r(u)|^2 by scipy.optimize.least_squares, with a reused Jacobian.

The Jacobian costs an evaluation for each parameter.  It is computed again only where its linear
model r(u) = r(u0) + J(u0) (u - u0) does not predict the residuals (modified Gauss-Newton method).
The iteration ends when the part of r in the range of J, which the next step would remove, is small
relative to the residual standard deviation (the relative offset of Bates and Watts).

References: J. E. Dennis and R. B. Schnabel, Numerical Methods for Unconstrained Optimization and
Nonlinear Equations, SIAM 1996, ch. 10; D. M. Bates and D. G. Watts, Nonlinear Regression Analysis
and Its Applications, Wiley 1988, sec. 2.2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .predict import Predictor

__all__ = ["Linearisation", "ReusedJacobian", "minimise"]

Array = np.ndarray

EVALUATIONS = 60  # of one minimisation
# Accuracy of a minimum in standard errors: another mesh moves it by as much.
ACCURACY = 0.05
# Of the bounds' distance: the last step where S is rough, because nodes change their zones.
SMALLEST_STEP = 1e-6
# Share of the change of the residuals that the linear model of a minimum may miss in its basin.
IN_BASIN = 0.3
# Error of a linear model whose Jacobian is used again, in standard deviations of the residuals: on
# the way to a minimum, and next to one.
ON_THE_WAY, NEXT_TO_IT = 0.05, 0.5


class Linearisation(NamedTuple):
    """Residuals and their derivatives at one point, e.g. a minimum.

    Attributes
    ----------
    u : (p,) array
        Coordinates of the parameters.
    r : (m,) array
        Residuals.
    J : (m, p) array
        dr/du.
    """

    u: Array
    r: Array
    J: Array

    @property
    def S(self) -> float:
        """Sum of the squared residuals."""
        return float(self.r @ self.r)

    def change(self, u: Array) -> float:
        """Return the squared change of the residuals in the linear model."""
        return float(np.sum((self.J @ (u - self.u)) ** 2))

    def prediction_error(self, u: Array, r: Array) -> float:
        """Return the norm of the error of the linear model, where the residuals at u are r."""
        return float(np.linalg.norm(r - self.r - self.J @ (u - self.u)))

    def predicts(self, u: Array, r: Array) -> bool:
        """Return True if the linear model predicts the change of the residuals, within 30 %."""
        return self.prediction_error(u, r) <= IN_BASIN * float(np.linalg.norm(r - self.r))

    def expected_decrease(self, predictor: Predictor, fixed: int | None = None) -> float:
        """Return the decrease of S in the linear model, parameters at their bounds held there.

        ``fixed`` is the number of a parameter that is held in any case.
        """
        slope = self.J.T @ self.r
        held = ((self.u <= predictor.low) & (slope > 0)) | (
            (self.u >= predictor.high) & (slope < 0)
        )
        if fixed is not None:
            held[fixed] = True
        free = self.J[:, ~held]
        step = np.linalg.lstsq(free, self.r, rcond=None)[0]
        return float(np.sum((free @ step) ** 2))


class ReusedJacobian:
    """The Jacobian of the residuals, computed where the last one is not accurate enough.

    Parameters
    ----------
    predictor : Predictor
    last : Linearisation, optional
        Where it was computed before.
    fixed : int, optional
        Parameter whose column is not needed.
    """

    def __init__(
        self, predictor: Predictor, last: Linearisation | None = None, fixed: int | None = None
    ) -> None:
        self.predictor, self.last, self.fixed = predictor, last, fixed

    def __call__(self, u: Array, tolerance: float | None = None) -> Linearisation:
        """Return the residuals at u (p,), with the last Jacobian if it is accurate enough.

        ``tolerance`` is the error of its linear model at u that is admitted, in standard deviations
        of the residuals; 0 computes the Jacobian at u.  By default it is that on the way to a
        minimum, or with a fixed parameter that next to one, where the profiles start.
        """
        r = self.predictor.residuals(u)
        if tolerance is None:
            tolerance = ON_THE_WAY if self.fixed is None else NEXT_TO_IT
        # a parameter's standard error changes the residuals by their standard deviation
        limit = tolerance * np.sqrt(self.predictor.variance(float(r @ r)))
        if self.last is None or self.last.prediction_error(u, r) > limit:
            self.last = Linearisation(u.copy(), r, self.predictor.jacobian(u, self.fixed))
        return Linearisation(u.copy(), r, self.last.J)


class _EndError(Exception):
    """The minimisation has converged, or entered the basin of a known minimum.

    The functions that SciPy calls raise it, because this is the only way to end its iteration.
    """

    def __init__(self, minimum: Linearisation) -> None:
        super().__init__()
        self.minimum = minimum


def minimise(
    predictor: Predictor,
    start: Array,
    known: Linearisation | None = None,
    *,
    linearised: ReusedJacobian | None = None,
    accuracy: float = ACCURACY,
) -> Linearisation | None:
    """Return a local minimum.

    Parameters
    ----------
    predictor : Predictor
    start : (p,) array
    known : Linearisation, optional
        A minimum, which is returned as soon as its linear model predicts the residuals, or S is
        within a standard error of it and the linear model predicts no smaller one.
    linearised : ReusedJacobian, optional
        With a fixed parameter, and a Jacobian that need not be that at the minimum; by default all
        parameters are free, and the Jacobian is computed at the minimum.
    accuracy : float
        In standard errors.

    Returns
    -------
    Linearisation or None
        None if the start, or a derivative on the way, cannot be solved.
    """
    # tolerance of the Jacobian at the minimum: that of ``linearised``, or 0: computed there
    at_end = None if linearised else 0.0
    linearised = linearised or ReusedJacobian(predictor)
    start = np.clip(start, predictor.low, predictor.high)
    return _Minimisation(predictor, start, known, linearised, at_end, accuracy).run()


class _Minimisation:
    """Residuals and Jacobian of the free parameters, which end the iteration at the minimum.

    The free coordinates are v = 1 at the lower and 2 at the upper bound: SciPy takes |v| for the
    length of the first step, and relates the last one to it.  In coordinates u, a start at u = 0
    (a value of zero, or of 1 in SI units) would have a first step so short that it ends there.

    Parameters as of :func:`minimise`; ``at_end`` is the tolerance of the Jacobian at the minimum,
    of :meth:`ReusedJacobian.__call__`.  Arrays v have the f free of the p parameters.
    """

    def __init__(
        self,
        predictor: Predictor,
        start: Array,
        known: Linearisation | None,
        linearised: ReusedJacobian,
        at_end: float | None,
        accuracy: float,
    ) -> None:
        self.predictor, self.start, self.known = predictor, start, known
        self.linearised, self.at_end, self.accuracy = linearised, at_end, accuracy
        self.free = np.arange(start.size) != linearised.fixed
        self.low = predictor.low[self.free]
        self.width = predictor.high[self.free] - self.low
        self.first = np.clip(1 + (start[self.free] - self.low) / self.width, 1.0, 2.0)
        self.last: Linearisation | None = None

    def run(self) -> Linearisation | None:
        """Return the minimum; None if the start, or a derivative on the way, cannot be solved."""
        from scipy.optimize import least_squares

        predictor, start = self.predictor, self.start
        if not np.isfinite(predictor.residuals(start)).all():
            return None
        try:
            # no gtol, which is absolute: the residuals of small outputs, such as a creepage, would
            # be below it at once
            end = least_squares(
                self.residuals,
                self.first,
                self.jacobian,
                (1.0, 2.0),
                method="dogbox",
                x_scale="jac",
                ftol=self.accuracy**2 / max(predictor.measured.size - start.size, 1),
                xtol=SMALLEST_STEP,
                gtol=None,
                max_nfev=EVALUATIONS,
            )
            return self._at_minimum(self._all_parameters(end.x))
        except _EndError as reached:
            return reached.minimum
        except ValueError:  # a derivative could not be solved
            return None

    def residuals(self, v: Array) -> Array:
        """Return the residuals at v (f,), (m,).

        Stop in the basin of a known minimum, and where S is rough.
        """
        u, known, last = self._all_parameters(v), self.known, self.last
        r = self.predictor.residuals(u)
        if known is not None and known.predicts(u, r):
            raise _EndError(known)
        # S is rough where a step within the accuracy does not decrease it; the next one is shorter;
        # S that is nan counts as no decrease
        if last is not None and not r @ r < last.S and self._is_negligible(last.change(u), last):
            # also with the Jacobian of that point: a reused one may be too small by far
            self.last = last = self._at_minimum(last.u)
            if self._is_negligible(last.change(u), last):
                raise _EndError(last)
        return r

    def jacobian(self, v: Array) -> Array:
        """Return the columns of the free parameters at v (f,), (m, f); stop at the minimum."""
        self.last = self.linearised(self._all_parameters(v))
        # converged with a reused Jacobian: also with the one of the minimum?
        if self._is_converged(self.last) and self.at_end is not None:
            self.last = self._at_minimum(self.last.u)
        if self._is_converged(self.last):
            raise _EndError(self.last)
        if self.known is not None and self._is_in_valley(self.last, self.known):
            raise _EndError(self.known)
        return self.last.J[:, self.free] * self.width

    def _all_parameters(self, v: Array) -> Array:
        """Return all parameters, (p,), for values v (f,) of the free ones."""
        u = self.start.copy()
        if not np.array_equal(v, self.first):  # the start without rounding, which may be solved
            u[self.free] = self.low + (v - 1) * self.width
        return u

    def _at_minimum(self, u: Array) -> Linearisation:
        """Return the residuals at the minimum, with the Jacobian of the requested tolerance."""
        return self.linearised(u, self.at_end)

    def _is_negligible(self, change: float, current: Linearisation) -> bool:
        """Return True if a step is within the accuracy.

        ``change`` is the squared change of the residuals by the step, or the decrease of S.
        """
        return change <= self.accuracy**2 * self.predictor.variance(current.S)

    def _expected_decrease(self, current: Linearisation) -> float:
        """Return the decrease of S in the linear model."""
        return current.expected_decrease(self.predictor, self.linearised.fixed)

    def _is_converged(self, current: Linearisation) -> bool:
        """Return True if the next step would be shorter than the accuracy."""
        return self._is_negligible(self._expected_decrease(current), current)

    def _is_in_valley(self, current: Linearisation, minimum: Linearisation) -> bool:
        """Return True if S exceeds a minimum by one standard error at most and does not fall below.

        A curved valley may be long; the profiles follow it.
        """
        above, s2 = current.S - minimum.S, self.predictor.variance(minimum.S)
        decrease = self._expected_decrease(current)
        return above <= s2 and decrease <= above + self.accuracy**2 * s2
