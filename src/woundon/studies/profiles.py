"""Profile likelihood: how far one parameter can go while the others make the best of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .predict import Predictor

__all__ = ["ProfileLikelihood", "profile_of", "threshold"]

Array = np.ndarray
LEVEL = 0.95


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
    predictor: Predictor, j: int, u: Array, S: float, limit: float, spread: float
) -> ProfileLikelihood:
    """Walk parameter ``j`` both ways until S passes ``limit`` or a bound is met.

    Parameters
    ----------
    predictor : Predictor
    j : int
    u, S : array, float
        The minimum.
    limit : float
        Of S.
    spread : float
        Standard error of u_j: the unit of the steps.
    """
    parameter = predictor.parameters[j]
    walk = _Walk(predictor, j, u, S)
    low, high = (walk.end(limit, sign * spread) for sign in (-1.0, 1.0))
    points = sorted(walk.points, key=lambda point: point[0])
    m = predictor.measured.size
    return ProfileLikelihood(
        parameter.name,
        np.array([parameter.value(at) for at, _, _ in points]),
        np.sqrt(np.array([s for _, s, _ in points]) / m),
        -np.inf if low is None else parameter.value(low),
        np.inf if high is None else parameter.value(high),
        float(np.sqrt(limit / m)),
        min(((s, v) for _, s, v in points), key=lambda pair: pair[0]),
    )


class _Walk:
    """Refits the other parameters along one; ``points`` holds (u_j, S, u)."""

    def __init__(self, predictor: Predictor, j: int, u: Array, S: float) -> None:
        self.predictor, self.j, self.u = predictor, j, u
        self.points: list[tuple[float, float, Array]] = [(float(u[j]), S, u)]

    def end(self, limit: float, step: float) -> float | None:
        """Return where S passes ``limit``, coming from the minimum; None if a bound comes first."""
        from scipy.optimize import brentq

        low, high = self.predictor.parameters[self.j].ends
        inner = float(self.u[self.j])
        while True:
            outer = min(max(inner + step, low), high)
            S = self._refitted(outer)
            if not np.isfinite(S) or limit < S:
                break
            if outer in (low, high):
                return None
            inner, step = outer, 1.6 * step
        if not np.isfinite(S):
            return outer  # beyond lies what cannot be solved
        # S grows about as the square of the distance: its root is nearly straight
        floor = self.points[0][1]

        def excess(at: float) -> float:
            return float(np.sqrt(max(self._refitted(at) - floor, 0.0)) - np.sqrt(limit - floor))

        if excess(inner) >= 0:
            return inner
        return float(brentq(excess, inner, outer, xtol=1e-2 * abs(step), rtol=1e-6))

    def _refitted(self, at: float) -> float:
        """Return the least S over the other parameters, this one held."""
        from scipy.optimize import least_squares

        for known, S, _ in self.points:
            if known == at:
                return S
        predictor, j = self.predictor, self.j

        def whole(part: Array) -> Array:
            return np.insert(part, j, at)

        def residuals(part: Array) -> Array:
            return predictor.residuals(whole(part))

        def jacobian(part: Array) -> Array:
            return np.delete(predictor.jacobian(whole(part)), j, axis=1)

        low, high = np.delete(np.transpose([p.ends for p in predictor.parameters]), j, axis=1)
        for others in self._expected(at):
            best = whole(np.clip(others, low + 1e-9, high - 1e-9))
            r = predictor.residuals(best)
            if np.isfinite(r).all():
                break
        if others.size and np.isfinite(r).all():
            found = least_squares(
                residuals, np.delete(best, j), jacobian, (low, high), x_scale="jac",
                ftol=1e-6, xtol=1e-6, gtol=None, max_nfev=20,
            )  # fmt: skip
            best, r = whole(found.x), found.fun
        S = float(r @ r)
        if np.isfinite(S):
            self.points.append((at, S, best))
        return S

    def _expected(self, at: float) -> Iterator[Array]:
        """Yield where the other parameters are to be looked for: as they went, as they were."""
        (one, _, u), *more = sorted(self.points, key=lambda point: abs(point[0] - at))
        for other, _, v in more[:1]:
            yield np.delete(u + (v - u) * (at - one) / (other - one), self.j)
        yield np.delete(u, self.j)
