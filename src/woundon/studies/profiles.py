r"""Profile likelihood: S(u_j), the least S over the other parameters, and its 95 % interval.

    S(u_j) = min |r(u)|^2 over u_k, k != j;      end: S(u_j) = limit

The ends are roots of sqrt(S(u_j) - S_min) - sqrt(limit - S_min), which is linear in u_j for a
linear model, found by Brent's method.  For each u_j the others are fitted again, from the values
that the linear model about the minimum gives, with its Jacobian as long as it is accurate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .minimise import Linearisation, ReusedJacobian, minimise
from .predict import Predictor

__all__ = ["End", "ProfileLikelihood", "find_end", "profile_of", "threshold"]

Array = np.ndarray

LEVEL = 0.95
ACCURACY = 1e-2  # of the distance from the minimum to an end; another mesh moves it by more
# Accuracy of the other parameters in standard errors; the decrease of S that a further step would
# bring is taken from the linear model.
REFIT = 0.5
# A distance relative to that of the end in the linear model, to bracket the end mostly, and the
# growth of the distance until it is bracketed.
BEYOND = 1.1
GROWTH = 1.2, 4.0
EVALUATIONS = 30
ROUNDING = 1e-12  # of the distance of a bound


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
        The least S of all evaluations, and the coordinates u of all parameters there.
    """

    name: str
    values: Array
    rms: Array
    low: float
    high: float
    rms_limit: float
    best: tuple[float, Array]


@dataclass(frozen=True, eq=False)
class End:
    """One end of an interval.

    Attributes
    ----------
    u : float or None
        Coordinate of the parameter; None if the bound is inside the interval.
    points : tuple of (S, u)
        All evaluations with the others refitted; u are the coordinates of all parameters.
    """

    u: float | None
    points: tuple[tuple[float, Array], ...]


def threshold(S: float, freedom: int, weighted: bool) -> float:
    """Return the S up to which a parameter's value is within the 95 % interval.

    S is that of the minimum, ``freedom`` m - p, and ``weighted`` states that the deviations are
    known: then S + chi2(1); else S (1 + F(1, m - p)/(m - p)), nan without freedom.

    >>> round(threshold(2.0, 10, weighted=True), 3)
    5.841
    """
    from scipy.stats import chi2, f

    if weighted:
        return S + float(chi2.ppf(LEVEL, 1))
    return S * (1 + float(f.ppf(LEVEL, 1, freedom)) / freedom) if freedom > 0 else float("nan")


def profile_of(
    predictor: Predictor, j: int, minimum: Linearisation, limit: float, ends: Sequence[End]
) -> ProfileLikelihood:
    """Return the profile of parameter ``j`` from its lower and its upper end."""
    parameter, m = predictor.parameters[j], predictor.measured.size
    points = sorted(
        [(minimum.S, minimum.u), *(point for end in ends for point in end.points)],
        key=lambda point: float(point[1][j]),
    )
    low, high = (None if end.u is None else parameter.value(end.u) for end in ends)
    return ProfileLikelihood(
        name=parameter.name,
        values=np.array([parameter.value(float(u[j])) for _, u in points]),
        rms=np.sqrt(np.array([S for S, _ in points]) / m),
        low=-np.inf if low is None else low,
        high=np.inf if high is None else high,
        rms_limit=float(np.sqrt(limit / m)),
        best=min(points, key=lambda point: point[0]),
    )


def find_end(
    predictor: Predictor,
    j: int,
    sign: int,
    minimum: Linearisation,
    limit: float,
    known: Sequence[tuple[float, Array]] = (),
) -> End:
    """Return the lower (``sign`` -1) or upper (+1) end of the interval of parameter ``j``.

    Parameters
    ----------
    predictor : Predictor
    j, sign : int
    minimum : Linearisation
        Of the fit.
    limit : float
        S at the end.
    known : sequence of (S, u)
        Points of the profile that were computed before, on both sides.
    """
    from scipy.optimize import brentq

    on_this_side = [point for point in known if sign * (point[1][j] - minimum.u[j]) > 0]
    profile = _Profile(predictor, j, minimum, limit, on_this_side)
    bound = float((predictor.low if sign < 0 else predictor.high)[j] - minimum.u[j])
    distances = sorted(profile.known, key=abs)  # the first is 0, the minimum
    if len(distances) == 1:
        distances.append(sign * min(BEYOND * profile.predicted_distance(), abs(bound)))
    inner, outer, *farther = distances
    for _ in range(EVALUATIONS + len(farther)):
        f = profile(outer)
        if f >= 0:
            break
        if abs(outer) >= (1 - ROUNDING) * abs(bound):
            return End(None, tuple(profile.points))
        if not farther:
            # f + reach, the root of the increase of S, is nearly proportional to the distance
            growth = BEYOND * profile.reach / max(f + profile.reach, 1e-300)
            grown = abs(outer) * float(np.clip(growth, *GROWTH))
            farther = [sign * min(grown, abs(bound))]
        inner, (outer, *farther) = outer, farther
    if f > 0 and np.isfinite(f):
        outer = brentq(profile, inner, outer, xtol=ACCURACY * abs(outer), maxiter=EVALUATIONS)
    elif f > 0:  # infinite: outer cannot be solved
        outer = _last_solved(profile, inner, outer)
    return End(float(minimum.u[j] + outer), tuple(profile.points))


def _last_solved(profile: _Profile, solved: float, unsolved: float) -> float:
    """Return the end of an interval that cannot be solved as far as its limit, by bisection.

    Parameters
    ----------
    profile : _Profile
        Is infinite at a distance that is not solved.
    solved, unsolved : float
        Signed distances u_j - u_j,min.  The first may be 0, the minimum; where nothing else is
        solved, it is returned after ``EVALUATIONS`` bisections.
    """
    for _ in range(EVALUATIONS):
        if abs(unsolved - solved) <= 0.05 * abs(unsolved):
            break
        middle = (solved + unsolved) / 2
        if np.isfinite(f := profile(middle)):
            solved = middle
            if f >= 0:  # the limit is reached where a solution exists: no need to go farther
                break
        else:
            unsolved = middle
    return solved


class _Profile:
    """Function of the distance of u_j from the minimum whose root is the end of the interval.

    Parameters
    ----------
    predictor : Predictor
    j : int
        The parameter.
    minimum : Linearisation
        Of the fit.
    limit : float
        S at the end of the interval.
    points : sequence of (S, u)
        Points of the profile that were computed before, on one side of the minimum.

    Attributes
    ----------
    points : list of (S, u)
        The same, extended by every new point.
    reach : float
        sqrt(limit - S_min), the increase of the root of S up to the end.
    known : dict
        Signed distance u_j - u_j,min -> value of the function.
    """

    def __init__(
        self,
        predictor: Predictor,
        j: int,
        minimum: Linearisation,
        limit: float,
        points: Sequence[tuple[float, Array]] = (),
    ) -> None:
        self.predictor, self.j, self.minimum, self.limit = predictor, j, minimum, limit
        self.reach = float(np.sqrt(limit - minimum.S))
        self.points = list(points)
        self.known = {0.0: -self.reach}
        self.known |= {float(u[j] - minimum.u[j]): self._increase(S) for S, u in points}
        self.linearised = ReusedJacobian(predictor, minimum, fixed=j)
        J_j, J_others = minimum.J[:, j], np.delete(minimum.J, j, axis=1)
        # d(other u)/d(u_j) that keeps S least in the linear model, and the residuals' change
        self.slope = -np.linalg.lstsq(J_others, J_j, rcond=None)[0]
        self.change = float(np.linalg.norm(J_j + J_others @ self.slope))

    def predicted_distance(self) -> float:
        """Return the distance of the end in the linear model, at most a tenth of the bounds'."""
        width = float(self.predictor.high[self.j] - self.predictor.low[self.j])
        return min(self.reach / self.change, 0.1 * width) if self.change > 0 else 0.1 * width

    def __call__(self, distance: float) -> float:
        """Return sqrt(S - S_min) - sqrt(limit - S_min); exactly 0 within the accuracy."""
        if distance not in self.known:  # Brent's method starts with points that are known
            self.known[distance] = self._increase(self._refit(distance))
        return self.known[distance]

    def _increase(self, S: float) -> float:
        """Return the value of the function for the least S at a distance."""
        f = float(np.sqrt(max(S - self.minimum.S, 0.0))) - self.reach
        return 0.0 if abs(f) <= ACCURACY * self.reach else f

    def _refit(self, distance: float) -> float:
        """Return the least S over the other parameters, this one fixed; inf if not solved."""
        predictor, j, minimum = self.predictor, self.j, self.minimum
        u_j = float(minimum.u[j]) + distance
        known = [minimum.u, *(u for _, u in self.points)]
        nearest, *farther = sorted(known, key=lambda u: abs(float(u[j]) - u_j))
        others, slope = np.delete(nearest, j), self.slope
        if farther:  # secant through the two nearest points of the profile
            slope = (np.delete(farther[0], j) - others) / (farther[0][j] - nearest[j])
        u = np.insert(others + slope * (u_j - nearest[j]), j, u_j)
        refit = minimise(predictor, u, linearised=self.linearised, accuracy=REFIT)
        if refit is None:
            return float("inf")
        decrease = refit.expected_decrease(predictor, j)
        # the minimisation attempted a larger decrease and did not achieve it: S is rough
        is_achievable = decrease <= REFIT**2 * predictor.variance(refit.S)
        S = refit.S - decrease if is_achievable else refit.S
        self.points.append((S, refit.u))
        return S
