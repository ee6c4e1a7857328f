r"""Profile likelihood: how far one parameter can go while the others make the best of it.

About a point u with residuals r and derivatives J, S is about |r + J du|^2: that tells where S,
least over the others, comes to the limit, and what the others are there.  One evaluation shows how
far it was right, and mends J by Broyden's formula.  Once another step of the others would gain
little, S less that little is the profile.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .predict import Predictor
from .slopes import mended

__all__ = ["ProfileLikelihood", "profile_of", "threshold"]

Array = np.ndarray
LEVEL = 0.95

MOST = 30  # points of a walk, and steps of the others at one
FARTHEST = 3.0  # standard errors of the first step
GROWTH = 1.6  # of the steps while nothing tells where the end is
LEAST = 0.05  # of a step that is halved before what cannot be solved
CLOSE = 5e-3  # of the way to the end, from where it is told by the chord; bent by a tenth at most
SETTLED = 2e-2  # of the rise of S: what the others may gain still, known to a tenth of it


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
        self.low, self.high = np.transpose([p.ends for p in predictor.parameters])

    def end(self, step: float) -> float | None:
        """Return where S passes the limit, coming from the minimum; None if a bound comes first."""
        low, high, minimum = self.low[self.j], self.high[self.j], self.points[0]
        reach = float(np.sqrt(self.limit - minimum.S))
        inner: tuple[float, float] = float(minimum.u[self.j]), -reach
        outer: tuple[float, float] | None = None
        at = inner[0] + self._foreseen(minimum, step)
        for _ in range(MOST):
            at = min(max(at, low), high)
            S = self._refitted(at)
            if not np.isfinite(S):
                if abs(at - inner[0]) < LEAST * abs(step):
                    return at  # beyond lies what cannot be solved
                at = (at + inner[0]) / 2
                continue
            # S grows about as the square of the distance: its root is nearly straight
            excess = float(np.sqrt(max(S - minimum.S, 0.0))) - reach
            slope = (excess - inner[1]) / (at - inner[0])
            if abs(excess) <= CLOSE * reach and slope * step > 0:
                return min(max(at - excess / slope, low), high)
            if excess > 0:
                outer = (at, excess)
            elif at in (low, high):
                return None
            else:
                ahead = -excess / slope if slope * step > 0 else np.inf
                inner = (at, excess)
            if outer is None:
                step *= GROWTH
                at += float(np.copysign(min(abs(ahead), abs(step)), step))
            else:
                share = inner[1] / (inner[1] - outer[1])
                at = inner[0] + min(max(share, 0.05), 0.95) * (outer[0] - inner[0])
        return at

    def _foreseen(self, point: _Point, step: float) -> float:
        """Return the step after which S is about the limit, a few times that given at most."""
        J, j = point.J, self.j
        others = np.delete(J, j, axis=1)
        along = J[:, j] - others @ np.linalg.lstsq(others, J[:, j], rcond=None)[0]
        size = float(np.linalg.norm(along))
        most = FARTHEST * abs(step)
        ahead = np.sqrt(self.limit - point.S) / size if size > 0 else np.inf
        return float(np.copysign(min(ahead, most), step))

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
        for _ in range(MOST):
            point = point.reached(self.predictor, u, r)
            u, gain = self._best(point, point.u)
            if gain <= SETTLED * (abs(point.S - self.points[0].S) + SETTLED * self.points[0].S):
                break
            r = self.predictor.residuals(u)
            if not np.isfinite(r).all() or r @ r > point.S:
                return self._carefully(point)
        return self._keep(point, gain)

    def _best(self, point: _Point, start: Array) -> tuple[Array, float]:
        """Return what the others go to by a point's derivatives, and what they gain."""
        from scipy.optimize import lsq_linear

        r, J = point.r + point.J @ (start - point.u), np.delete(point.J, self.j, axis=1)
        others = np.delete(start, self.j)
        if not others.size:
            return start, 0.0
        low, high = (np.delete(ends, self.j) for ends in (self.low, self.high))
        step = np.linalg.lstsq(J, -r, rcond=None)[0]
        if np.any(others + step < low) or np.any(others + step > high):
            inside = np.clip(others, low, high)
            step = lsq_linear(J, -r, (low - inside - 1e-12, high - inside + 1e-12)).x
        moved = np.clip(others + step, low, high)
        left = r + J @ (moved - others)
        return np.insert(moved, self.j, start[self.j]), float(r @ r - left @ left)

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
