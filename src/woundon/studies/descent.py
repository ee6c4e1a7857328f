r"""Descent to a minimum of S = |r|^2, as far as the data can tell it from its neighbours.

By the derivatives J about a point, S is least a step du away.  |J du| over s, s^2 = S/(m - p), is
its length in standard errors: a descent ends where it is a few hundredths.  A solver's mesh moves
minima by as much; there S is rough, derivatives jump where a node changes its zone, and a short
step may gain nothing.

A descent is also over where it is known to lead to a minimum that others have found: where that
one's linear model tells the residuals here, or where the next step leads nearer to it, and the
derivatives at both ends and a look half-way tell that S falls all the way.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .predict import Predictor
from .slopes import ASTRAY, Slopes, best_step

__all__ = ["COARSE", "FINE", "End", "descend"]

Array = np.ndarray

# standard errors left at an end; on few nodes, and by derivatives that one node may change
FINE, COARSE = 0.03, 0.3
ROUGH = 0.1  # of them: shorter steps may gain nothing, and are the last where one is left at most
NEAR = 0.01  # of the bounds' distance: there a minimum that is known is gone to
HALF = 0.5  # of the change of residuals on the way to a known minimum, by slopes at both ends
ON_BOUND = 1e-5  # of the bounds' distance; a fit tells which parameters are within 1e-4
STALLED = 1e-8  # steps of u, where nothing else has ended a descent
MOST = 60  # evaluations of a beginning, and beginnings


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

    def halfway(self, point: End, step: Array) -> tuple[Array, Array, float] | None:
        """Return what lies half-way to another point whose step leads nearer to here.

        By the cubic through residuals and slopes at both ends, where these add up to between one
        and three times that of the chord: it is monotone then (Fritsch and Carlson 1980).

        Returns
        -------
        tuple of (p,) array, (m,) array, float
            u, residuals, and how far these may be off; None where the step leads elsewhere.
        """
        way, change = self.u - point.u, self.r - point.r
        miss = change - (self.J + point.J) @ way / 2
        size = float(np.linalg.norm(change))
        if np.linalg.norm(miss) > HALF * size or np.linalg.norm(way - step) > np.linalg.norm(way):
            return None
        r = (self.r + point.r) / 2 - (self.J - point.J) @ way / 8
        return (self.u + point.u) / 2, r, ASTRAY * size


class _Ended(Exception):
    """A descent need not go on."""

    def __init__(self, end: End) -> None:
        self.end = end


class _Misled(Exception):
    """Mended derivatives led upwards."""


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
    low, high = predictor.low, predictor.high
    inside = np.clip(start, low + 1e-6 * (high - low), high - 1e-6 * (high - low))
    if not np.isfinite(predictor.residuals(inside)).all():
        return None
    way = _Way(predictor, tolerance, known)
    for _ in range(MOST):
        try:
            return way.ended(way.exact(_least_squares(way, inside)))
        except _Ended as stop:
            return stop.end
        except _Misled:
            assert way.here is not None
            inside = way.here.u
        except ValueError:  # a derivative could not be had
            return None
    return way.here


def _least_squares(way: _Way, start: Array) -> End:
    from scipy.optimize import least_squares

    # no gtol: it is absolute, so that outputs of small numbers (a creep) would stop at once
    end = least_squares(
        way.residuals, start, way.derivatives, (way.low, way.high), x_scale="jac",
        xtol=STALLED, ftol=way.tolerance**2 / max(way.predictor.measured.size - start.size, 1),
        gtol=None, max_nfev=MOST,
    )  # fmt: skip
    return End(np.asarray(end.x), np.asarray(end.fun), np.asarray(end.jac))


class _Way:
    """What a descent asks for, and when that is enough."""

    def __init__(self, predictor: Predictor, tolerance: float, known: Sequence[End]) -> None:
        self.predictor, self.tolerance, self.known = predictor, tolerance, known
        self.slopes = Slopes(predictor)
        self.low, self.high = predictor.low, predictor.high
        self.here: End | None = None
        self.left, self.misled = np.inf, False

    def residuals(self, u: Array) -> Array:
        """Return them; end at a minimum that tells them, or where S is rough."""
        r = self.predictor.residuals(u)
        reach = NEAR * (self.high - self.low)
        for end in self.known:
            if np.all(np.abs(u - end.u) < reach) or end.tells(u, r):
                raise _Ended(end)
        if self.here is not None and not self.misled and r @ r >= self.here.S:
            step = self._errors(self.here.J @ (u - self.here.u), self.here)
            if step <= ROUGH and self.left <= 1:
                raise _Ended(self.ended(self.exact(self.here)))
            if self.slopes.are_mended:
                self.misled = True
                raise _Misled
        return r

    def derivatives(self, u: Array) -> Array:
        """Return them; end where little is left, or where a known minimum follows."""
        J = self.slopes.anew(u) if self.misled else self.slopes(u)
        here = End(u.copy(), self.predictor.residuals(u), J)
        there, left = self._foreseen(here)
        for end in self.known:
            if self._falls_to(end, here, there - u):
                raise _Ended(end)
        enough = COARSE if self.misled else self.tolerance
        if left <= enough:
            here = self.exact(here)
            _, left = self._foreseen(here)
            if left <= COARSE:
                raise _Ended(self.ended(here))
        self.here, self.left, self.misled = here, left, False
        return here.J

    def ended(self, here: End) -> End:
        """Return an end; on the bounds that the next step leads onto, for a fit tells of them."""
        there, _ = self._foreseen(here)
        off = np.minimum(there - self.low, self.high - there)
        u = np.where(off < ON_BOUND * (self.high - self.low), there, here.u)
        if np.array_equal(u, here.u):
            return here
        r = self.predictor.residuals(u)
        return here._replace(u=u, r=r) if r @ r <= here.S else here

    def exact(self, here: End) -> End:
        """Return a place; in a fine descent with derivatives of its own, not those mended."""
        if self.tolerance == FINE and self.slopes.are_mended:
            return here._replace(J=self.slopes.anew(here.u))
        return here

    def _falls_to(self, end: End, here: End, step: Array) -> bool:
        """Tell whether S falls all the way to a known minimum, looked at half-way."""
        told = end.halfway(here, step)
        if told is None:
            return False
        u, foreseen, off = told
        r = self.predictor.residuals(u)
        return bool(r @ r < here.S and np.linalg.norm(r - foreseen) <= off)

    def _foreseen(self, here: End) -> tuple[Array, float]:
        """Return where the linear model leads, and how many standard errors that is."""
        there, _ = best_step(here.r, here.J, here.u, self.low, self.high)
        return there, self._errors(here.J @ (there - here.u), here)

    def _errors(self, change: Array, here: End) -> float:
        """Return a change of residuals in standard errors."""
        freedom = max(here.r.size - here.u.size, 1)
        return float(np.linalg.norm(change) * np.sqrt(freedom / here.S)) if here.S else 0.0
