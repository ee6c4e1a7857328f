r"""Descent to a minimum of S = |r|^2, as far as the data can tell it from its neighbours.

By the derivatives J about a point, S still falls by |r|^2 - |r + J du|^2, at the best du.  In units
of s^2 = S/(m - p) that is the square of the way left in standard errors: a descent ends where it is
a few hundredths.  A solver's mesh moves minima by as much; there S is rough, derivatives jump where
a node changes its zone, and a step that is to gain little gains nothing.

A descent is also over where it is known to lead to a minimum that others have found: where that
one's linear model tells the residuals here, or where its own step leads most of the way there and
the derivatives at both ends tell what lies between.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .predict import Predictor
from .slopes import ASTRAY, Slopes, best_step

__all__ = ["COARSE", "FINE", "End", "descend"]

Array = np.ndarray

# standard errors left, by S; within the second S may be rough, and few nodes need not tell more
FINE, COARSE = 0.03, 0.1
NEAR = 0.01  # of the bounds' distance: there a minimum that is known is gone to
HALF = 0.5  # of the way to a known minimum
STALLED = 1e-8  # steps of u, a hundredth of it of S: where nothing else has ended a descent
MOST = 60  # evaluations


class End(NamedTuple):
    """Where a descent ended: u, residuals and their derivatives."""

    u: Array
    r: Array
    J: Array

    @property
    def S(self) -> float:
        """The sum of their squares."""
        return float(self.r @ self.r)

    def tells(self, u: Array, r: Array) -> bool:
        """Tell whether the linear model about here foretells the residuals elsewhere."""
        change = r - self.r
        miss = change - self.J @ (u - self.u)
        return bool(np.linalg.norm(miss) <= ASTRAY * np.linalg.norm(change))

    def follows(self, point: End, step: Array) -> bool:
        """Tell whether a step from another point leads here, and nothing lies between.

        Where slopes at both ends add up to between one and three times that of the chord, the
        cubic through them is monotone (Fritsch and Carlson 1980).
        """
        way, change = self.u - point.u, self.r - point.r
        miss = change - (self.J + point.J) @ way / 2
        between = np.linalg.norm(miss) <= HALF * np.linalg.norm(change)
        return bool(between and np.linalg.norm(way - step) <= HALF * np.linalg.norm(way))


class _Ended(Exception):
    """A descent need not go on."""

    def __init__(self, end: End) -> None:
        self.end = end


def descend(
    predictor: Predictor, start: Array, tolerance: float, known: Sequence[End] = ()
) -> End | None:
    """Descend from a start, to a minimum that is known maybe; None if it cannot be solved there.

    Parameters
    ----------
    predictor : Predictor
    start : (p,) array
    tolerance : float
        Standard errors that may be left: ``FINE``, or ``COARSE`` on few nodes.
    known : sequence of End
        Minima; the same object is returned.
    """
    from scipy.optimize import least_squares

    low, high = predictor.low, predictor.high
    inside = np.clip(start, low + 1e-6 * (high - low), high - 1e-6 * (high - low))
    if not np.isfinite(predictor.residuals(inside)).all():
        return None
    way = _Way(predictor, tolerance, known)
    try:
        # no gtol: it is absolute, so that outputs of small numbers (a creep) would stop at once
        end = least_squares(
            way.residuals, inside, way.derivatives, (low, high), x_scale="jac",
            xtol=STALLED, ftol=1e-2 * STALLED, gtol=None, max_nfev=MOST,
        )  # fmt: skip
        return way.ended(End(np.asarray(end.x), np.asarray(end.fun), np.asarray(end.jac)))
    except _Ended as stop:
        return stop.end
    except ValueError:  # a derivative could not be had
        return None


class _Way:
    """What a descent asks for, and when that is enough."""

    def __init__(self, predictor: Predictor, tolerance: float, known: Sequence[End]) -> None:
        self.predictor, self.tolerance, self.known = predictor, tolerance, known
        self.slopes = Slopes(predictor)
        self.low, self.high = predictor.low, predictor.high
        self.here: End | None = None
        self.left = np.inf

    def residuals(self, u: Array) -> Array:
        """Return them; end at a minimum that tells them, or where S is rough."""
        r = self.predictor.residuals(u)
        reach = NEAR * (self.high - self.low)
        for end in self.known:
            if np.all(np.abs(u - end.u) < reach) or end.tells(u, r):
                raise _Ended(end)
        if self.here is not None and self.left <= COARSE and r @ r >= self.here.S:
            raise _Ended(self.ended(self.here))
        return r

    def derivatives(self, u: Array) -> Array:
        """Return them; end where little is left, or where a known minimum follows."""
        here = End(u.copy(), self.predictor.residuals(u), self.slopes(u))
        there, left = self._foreseen(here)
        for end in self.known:
            if end.follows(here, (there - u)):
                raise _Ended(end)
        if left <= self.tolerance:
            here = self.ended(here)
            _, left = self._foreseen(here)
            if left <= COARSE:
                raise _Ended(here)
        self.here, self.left = here, left
        return here.J

    def ended(self, here: End) -> End:
        """Return an end; of a fine descent with derivatives of its own, not those mended."""
        if self.tolerance == FINE and self.slopes.are_mended:
            return here._replace(J=self.slopes.anew(here.u))
        return here

    def _foreseen(self, here: End) -> tuple[Array, float]:
        """Return where the linear model leads, and how many standard errors that gains S."""
        there, gain = best_step(here.r, here.J, here.u, self.low, self.high)
        freedom = max(here.r.size - here.u.size, 1)
        return there, float(np.sqrt(max(gain, 0.0) * freedom / here.S)) if here.S else 0.0
