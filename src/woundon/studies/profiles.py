r"""Profile likelihood: how far one parameter can go while the others make the best of it.

About a point u with residuals r and derivatives J, S is about |r + J du|^2: that tells where S,
least over the others, comes to the limit, and what the others are there.  One evaluation shows how
far it was right, and mends J by Broyden's formula.  Once another step of the others would gain
little, S less that little is the profile.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from .predict import Predictor
from .slopes import best_step, mended

__all__ = ["ProfileLikelihood", "profile_of", "threshold"]

Array = np.ndarray
LEVEL = 0.95

MOST, MOST_STEPS = 30, 8  # points of a walk; steps of the others at one
FARTHEST = 3.0  # standard errors of the first step
GROWTH = 1.6  # of the steps while nothing tells where the end is
LEAST = 0.05  # of a step that is halved before what cannot be solved
# of the way to the end, from where it is told by a parabola, if that is so little off its chord
NEAR, BENT = 0.03, 2e-3
SETTLED = 1e-2  # of the rise of S: what the others may gain still, known to a tenth of it


@dataclass(frozen=True, eq=False)
class ProfileLikelihood:
    """The profile of one parameter.

    Attributes
    ----------
    name : str
    values, rms : (k,) arrays
        Fixed values, increasing, and the RMS of the residuals with the others refitted.
    low, high : float
        Ends of the 95 % interval; -inf or inf where the bounds were reached within it.
    rms_limit : float
        RMS at the ends of the interval.
    best : (S, u)
        The least S on the way.
    """

    name: str
    values: Array
    rms: Array
    low: float
    high: float
    rms_limit: float
    best: tuple[float, Array]


def threshold(S: float, freedom: int, weighted: bool) -> float:
    """Return the S up to which a parameter's value is within the 95 % interval.

    With known deviations S + chi2(1); else S (1 + F(1, m - p)/(m - p)), nan without freedom.
    """
    from scipy.stats import chi2, f

    if weighted:
        return S + float(chi2.ppf(LEVEL, 1))
    return S * (1 + float(f.ppf(LEVEL, 1, freedom)) / freedom) if freedom > 0 else float("nan")


def profile_of(
    predictor: Predictor, j: int, minimum: tuple[Array, Array, Array], limit: float, spread: float
) -> ProfileLikelihood:
    """Walk parameter ``j`` both ways until S passes ``limit`` or a bound is met.

    Parameters
    ----------
    predictor : Predictor
    j : int
    minimum : (u, r, J)
        With the residuals and their derivatives there.
    limit : float
        Of S.
    spread : float
        Standard error of u_j: the unit of the steps.
    """
    parameter = predictor.parameters[j]
    walk = _Walk(predictor, j, _Point(*minimum), limit)
    low, high = (walk.end(sign * spread) for sign in (-1.0, 1.0))
    points = sorted(walk.points, key=lambda point: float(point.u[j]))
    m = predictor.measured.size
    best = min(points, key=lambda point: point.S)
    return ProfileLikelihood(
        parameter.name,
        np.array([parameter.value(float(point.u[j])) for point in points]),
        np.sqrt(np.array([point.S - point.gain for point in points]) / m),
        -np.inf if low is None else parameter.value(low),
        np.inf if high is None else parameter.value(high),
        float(np.sqrt(limit / m)),
        (best.S, best.u),
    )


@dataclass(frozen=True, eq=False)
class _Point:
    """Residuals and derivatives at u; ``gain`` is what the others would take off S still."""

    u: Array
    r: Array
    J: Array
    gain: float = 0.0

    @property
    def S(self) -> float:
        return float(self.r @ self.r)

    def reached(self, predictor: Predictor, u: Array, r: Array) -> _Point:
        """Return another point near it, J mended by what the step told, or made anew."""
        J = mended(self.J, u - self.u, r - self.r)
        return _Point(u, r, predictor.jacobian(u) if J is None else J)


class _Walk:
    """Refits the other parameters along one, from the minimum on."""

    def __init__(self, predictor: Predictor, j: int, minimum: _Point, limit: float) -> None:
        self.predictor, self.j, self.limit = predictor, j, limit
        self.points = [minimum]
        self.low, self.high = predictor.low, predictor.high

    def end(self, step: float) -> float | None:
        """Return where S passes the limit, coming from the minimum; None if a bound comes first."""
        minimum = self.points[0]
        begin, reach = float(minimum.u[self.j]), float(np.sqrt(self.limit - minimum.S))
        low, high = self.low[self.j] - begin, self.high[self.j] - begin
        # S grows about as the square of the way: its root is nearly straight
        pace = float(np.copysign(self._pace(minimum), step))
        risen, ways = [0.0, 0.0], [0.0, 0.0]
        inner, outer = (0.0, 0.0), None
        way = float(np.copysign(min(abs(pace) * reach, FARTHEST * abs(step)), step))
        for _ in range(MOST):
            way = min(max(way, low), high)
            S = self._refitted(begin + way)
            if not np.isfinite(S):
                if abs(way - inner[0]) < LEAST * abs(step):
                    return begin + way  # beyond lies what cannot be solved
                way = (way + inner[0]) / 2
                continue
            risen.append(float(np.sqrt(max(S - minimum.S, 0.0))))
            ways.append(way)
            there, bend = _inverse(risen[-3:], ways[-3:], pace, reach)
            near = abs(risen[-1] - reach) <= NEAR * reach and abs(bend) <= BENT * abs(way)
            if near and there * step > 0:
                return begin + min(max(there, low), high)
            if risen[-1] > reach:
                outer = (way, risen[-1])
            elif way in (low, high):
                return None
            else:
                inner = (way, risen[-1])
            if outer is None:
                step *= GROWTH
                ahead = abs(there - way) if (there - way) * step > 0 else np.inf
                way += float(np.copysign(min(ahead, abs(step)), step))
            else:
                share = (there - inner[0]) / (outer[0] - inner[0])
                if not 0 < share < 1:
                    share = (reach - inner[1]) / (outer[1] - inner[1])
                way = inner[0] + min(max(share, 0.05), 0.95) * (outer[0] - inner[0])
        return begin + way

    def _pace(self, point: _Point) -> float:
        """Return the way for which the root of the rise of S grows by one, by a point's J."""
        own, others = point.J[:, self.j], np.delete(point.J, self.j, axis=1)
        along = own - others @ np.linalg.lstsq(others, own, rcond=None)[0]
        size = float(np.linalg.norm(along))
        return 1 / size if size > 0 else np.inf

    def _refitted(self, at: float) -> float:
        """Return the least S over the other parameters, this one held; inf if not solved."""
        known = [point for point in self.points if point.u[self.j] == at]
        if known:
            return known[0].S - known[0].gain
        point = min(self.points, key=lambda point: abs(float(point.u[self.j]) - at))
        held = np.where(np.arange(point.u.size) == self.j, at, point.u)
        for u in (self._best(point, held)[0], held):
            r = self.predictor.residuals(u)
            if np.isfinite(r).all():
                break
        else:
            return float("inf")
        for _ in range(MOST_STEPS):
            there = point.reached(self.predictor, u, r)
            worse = point.u[self.j] == at and there.S > point.S
            # a step that gains nothing still tells of the derivatives
            point = replace(point, J=there.J) if worse else there
            u, gain = self._best(point, point.u)
            if gain <= SETTLED * (abs(point.S - self.points[0].S) + SETTLED * self.points[0].S):
                return self._keep(point, gain)
            r = self.predictor.residuals(u)
            if not np.isfinite(r).all():
                break
        return self._carefully(point)

    def _best(self, point: _Point, start: Array) -> tuple[Array, float]:
        """Return what the others go to by a point's derivatives, and what they gain."""
        r, J = point.r + point.J @ (start - point.u), np.delete(point.J, self.j, axis=1)
        if not J.shape[1]:
            return start, 0.0
        others, low, high = (np.delete(x, self.j) for x in (start, self.low, self.high))
        moved, gain = best_step(r, J, others, low, high)
        return np.insert(moved, self.j, start[self.j]), gain

    def _carefully(self, point: _Point) -> float:
        """Refit the others from a point where whole steps lead nowhere."""
        from scipy.optimize import least_squares

        predictor, j, at = self.predictor, self.j, point.u[self.j]
        low, high = (np.delete(ends, j) for ends in (self.low, self.high))

        def residuals(part: Array) -> Array:
            return predictor.residuals(np.insert(part, j, at))

        def jacobian(part: Array) -> Array:
            return np.delete(predictor.jacobian(np.insert(part, j, at)), j, axis=1)

        found = least_squares(
            residuals, np.clip(np.delete(point.u, j), low + 1e-9, high - 1e-9), jacobian,
            (low, high), x_scale="jac", ftol=1e-6, xtol=1e-6, gtol=None, max_nfev=20,
        )  # fmt: skip
        u = np.insert(found.x, j, at)
        return self._keep(_Point(u, found.fun, predictor.jacobian(u)), 0.0)

    def _keep(self, point: _Point, gain: float) -> float:
        self.points.append(replace(point, gain=gain))
        return point.S - gain


def _inverse(
    f: Sequence[float], x: Sequence[float], slope: float, at: float
) -> tuple[float, float]:
    """Return x where f is ``at`` by the inverse parabola through three points, and off the chord.

    The chord is that of the last two; ``slope`` is dx/df at the first two where they are one.
    """
    if f[2] in f[:2]:
        return x[2], np.inf
    first = slope if f[1] == f[0] else (x[1] - x[0]) / (f[1] - f[0])
    last = (x[2] - x[1]) / (f[2] - f[1])
    bend = (at - f[2]) * (at - f[1]) * (last - first) / (f[2] - f[0])
    chord = x[2] + (at - f[2]) * last
    return (chord + bend, bend) if np.isfinite(bend) else (chord, np.inf)
