r"""Fit parameters to measured data by least squares, with intervals and identifiability.

    residual r_i = (predicted_i - measured_i) / deviation_i,    S = sum r_i^2

Started from several points, because S may have several minima.  With J = dr/du at the best one and
s^2 = S/(m - p), or 1 where the deviations are known:

    covariance        s^2 (J^T J)^-1
    profile           S_j(u_j) = min of S over the other parameters; the 95 % interval is where
                      S_j - S <= s^2 F(1, m - p); valid for curved and open valleys too
    identifiability   J = U diag(lambda) V^T: the last column of V is the direction of parameters
                      to which the predictions are least sensitive
"""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import partial
from operator import attrgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InvalidProblem, NotConverged
from ..parallel import in_processes
from ..quantities import Quantity
from ..results import Presented, ReadOnly
from . import fitreport
from .minimise import ACCURACY, Linearisation, minimise
from .predict import Parameter, Predictor
from .profiles import End, ProfileLikelihood, find_end, profile_of, threshold
from .progress import Progress
from .runners import WORTH_A_POOL

if TYPE_CHECKING:
    import pandas as pd
    import xarray

__all__ = ["FitResult", "fit_parameters"]

Array = np.ndarray
MOST_STARTS = 6  # by default, if no two of them converge to the same minimum before
WIDEST = 0.5  # relative standard error of a minimum at which two starts are enough
SAME_MINIMUM = 1e-3  # relative difference of S


@dataclass(frozen=True, eq=False, repr=False)
class FitResult(Presented, ReadOnly):
    """Result of :func:`woundon.fit`, of m measured values and p parameters.

    Attributes
    ----------
    names : tuple of str
    estimates, standard_errors : (p,) arrays
        SI.
    covariance, correlation : (p, p) arrays
    rms : float
        Root mean square of the residuals, in the unit of the outputs, or in standard deviations if
        ``weighted``.
    profiles : tuple of ProfileLikelihood
        Profiles with 95 % intervals; empty if not requested.
    direction : (p,) array
        The direction to which the predictions are least sensitive, in ln(value), or in value /
        range if a bound is not positive; the largest entry is 1.
    condition : float
        Ratio of the largest to the smallest singular value of the scaled Jacobian.
    effects : (p,) array
        RMS change of the predictions for +10 % of each parameter (or 10 % of the range).
    joint_effect : float
        The same for ``direction`` at +-10 % of its largest entry.
    minima : tuple of (S, estimates)
        Minima of all starts, best first.
    reached : int
        Number of starts, of ``starts``, that converged to the best minimum.
    measured, fitted : (m,) arrays
    row_outputs, row_numbers : tuples
        Output and row of each measured value.
    quantities : mapping of str to Quantity
        Of parameters and outputs.
    problem : object
        The base problem with the estimates.

    Examples
    --------
    >>> import woundon as wo
    >>> data = {"load [kN/m]": [50, 89, 120], "half_width [um]": [265, 354, 411]}
    >>> found = wo.fit(
    ...     wo.RollerProblem.example(), data, {"upper.radius": (0.1, 1.0)}, starts=1, nodes=17
    ... )
    >>> round(found.problem.upper.radius, 2), found.not_identified
    (0.25, ())
    """

    names: tuple[str, ...]
    estimates: Array
    standard_errors: Array
    covariance: Array
    correlation: Array
    rms: float
    direction: Array
    condition: float
    effects: Array
    joint_effect: float
    at_bound: tuple[str, ...]
    minima: tuple[tuple[float, tuple[float, ...]], ...]
    reached: int
    starts: int
    solves: int
    measured: Array
    fitted: Array
    row_outputs: tuple[str, ...]
    row_numbers: tuple[int, ...]
    weighted: bool
    profiles: tuple[ProfileLikelihood, ...] = ()
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    problem: Any = None

    @property
    def degrees_of_freedom(self) -> int:
        """m - p."""
        return self.measured.size - len(self.names)

    @property
    def not_identified(self) -> tuple[str, ...]:
        """Names of the parameters that the data do not identify: standard error above 100 %."""
        errors = zip(self.names, self.estimates, self.standard_errors, strict=True)
        return tuple(n for n, value, error in errors if value and not error < abs(value))

    def estimate(self, name: str) -> float:
        """Return the estimate of one parameter."""
        return float(self.estimates[self.names.index(name)])

    def lines(self) -> list[str]:
        """Return the fit as lines of text."""
        return fitreport.lines(self)

    def __repr__(self) -> str:
        return fitreport.line(self)

    def _repr_html_(self) -> str:
        head, *_ = self.lines()
        return self._html_of_table(head, self.to_dataframe(), fitreport.remarks(self))

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each parameter: estimate, standard error, 95 % interval, unit [SI]."""
        return fitreport.to_frame(self)

    def to_xarray(self) -> xarray.Dataset:
        """Return parameters along ``parameter`` and measured values along ``measurement`` [SI]."""
        return fitreport.to_dataset(self)

    def to_json(self) -> str:
        """Return the fit as JSON."""
        return fitreport.to_json(self)

    def plot(self, path: Any = None, ax: Any = None, panels: Any = None) -> Any:
        """Draw fitted against measured values ("agreement"), and the profile of each parameter.

        Parameters
        ----------
        path, ax
            As of :func:`woundon.plot`.
        panels : str or sequence of str, optional
            Which to draw: "agreement", names of parameters.

        Returns
        -------
        matplotlib.figure.Figure, or ``ax`` where it is given
        """
        return self._figure(path, ax, panels)


def fit_parameters(
    predictor: Predictor,
    *,
    starts: int | None,
    seed: int,
    profiles: Collection[str],
    quantities: Mapping[str, Quantity],
    workers: int = 1,
    progress: Progress = lambda done, expected: None,
) -> FitResult:
    """Fit the predictor's parameters.

    Parameters
    ----------
    predictor : Predictor
    starts : int or None
        Number of starting points: the base value, the others by Latin hypercube; by default until
        two of them converge to the best minimum, at most 6.
    seed : int
    profiles : collection of str
        Parameters whose profile-likelihood intervals are found.
    quantities : mapping of str to Quantity
        Of parameters and outputs.
    workers : int
        Processes for the profiles, if they take long; the result does not depend on it.
    progress : callable
        Is called with the number of evaluated places, and the expected one.

    Raises
    ------
    InvalidProblem
        If there are fewer measured values than parameters.
    NotConverged
        If no start can be solved.
    """
    parameters, m = predictor.parameters, predictor.measured.size
    if m < len(parameters):
        text = f"{len(parameters)} parameters cannot be fitted to {m} measured values"
        raise InvalidProblem.at("vary", text)
    began = time.perf_counter()
    tasks = _Tasks(predictor, (starts or 2) + 2 * len(profiles), progress)
    minima, count = _minima(predictor, starts, seed, tasks)
    if not minima:
        raise NotConverged(f"no start of the fit could be solved: {predictor.fault}")
    if time.perf_counter() - began < WORTH_A_POOL:
        workers = 1
    ends: dict[tuple[int, int], End] = {}
    for _ in range(MOST_STARTS):
        likelihoods = _profiles(predictor, minima[0], profiles, ends, tasks, workers)
        best = min(
            (profile.best for profile in likelihoods), key=lambda best: best[0], default=None
        )
        if best is None or _is_least(minima[0].S, best[0], predictor):
            break
        # a profile has entered the basin of a deeper minimum that no start had found
        deeper = minimise(predictor, best[1])
        minima = minima if deeper is None else sorted([deeper, *minima], key=attrgetter("S"))
    tasks.end()
    return _result(predictor, minima, count, likelihoods, quantities)


def _minima(
    predictor: Predictor, starts: int | None, seed: int, tasks: _Tasks
) -> tuple[list[Linearisation], int]:
    """Return the minima of the starts in ascending order, and the number of starts."""
    minima: list[Linearisation] = []
    count = 0
    for start in _starting_points(predictor.parameters, starts or MOST_STARTS, seed):
        minimum = minimise(predictor, start, minima[0] if minima else None)
        count += 1
        tasks.finish()
        if minimum is not None:
            minima = sorted([*minima, minimum], key=attrgetter("S"))
        agree = starts is None and _count_best(predictor, minima) >= 2
        if agree and _is_conclusive(predictor, minima[0]):
            break
    return minima, count


def _is_conclusive(predictor: Predictor, minimum: Linearisation) -> bool:
    """Return False at a bound, and where the predictions hardly depend on a parameter.

    Starts on such a plateau agree although there may be a sharp minimum elsewhere: the wound-on
    tension, for example, hardly depends on a large friction.
    """
    errors = np.sqrt(np.diag(_covariance(predictor, minimum.J, minimum.S)))
    flat = np.any(errors > WIDEST * _units(predictor.parameters))
    return not flat and not _at_bound(predictor.parameters, minimum.u)


def _units(parameters: Sequence[Parameter]) -> Array:
    """Return the units of relative changes: of the value, or of the range."""
    return np.array([1.0 if p.logarithmic else p.high - p.low for p in parameters])


def _starting_points(parameters: Sequence[Parameter], starts: int, seed: int) -> list[Array]:
    """Return the base case and Latin hypercube samples within the bounds."""
    from scipy.stats import qmc

    low, high = np.transpose([p.ends for p in parameters])
    base = np.array([p.start for p in parameters])
    samples = qmc.LatinHypercube(len(parameters), rng=seed).random(max(starts - 1, 0))
    return [base, *(low + samples * (high - low))]


def _profiles(
    predictor: Predictor,
    minimum: Linearisation,
    names: Collection[str],
    ends: dict[tuple[int, int], End],
    tasks: _Tasks,
    workers: int,
) -> tuple[ProfileLikelihood, ...]:
    """Return the profiles of named parameters; none without degrees of freedom.

    Parameters
    ----------
    predictor : Predictor
    minimum : Linearisation
    names : collection of str
    ends : dict
        Ends by parameter and sign, computed from a minimum that was not the least one; they are
        replaced.  Their points are still points of the profiles.
    tasks : _Tasks
    workers : int
    """
    freedom = predictor.measured.size - len(predictor.parameters)
    limit = threshold(minimum.S, freedom, predictor.weighted)
    indices = [j for j, parameter in enumerate(predictor.parameters) if parameter.name in names]
    if not np.isfinite(limit):
        return ()
    places = [(j, sign) for j in indices for sign in (-1, 1)]
    # points of both ends: the minimum may have moved past them
    known = {j: [p for k, end in ends.items() if k[0] == j for p in end.points] for j in indices}
    if workers > 1 and len(places) > 1:
        work = partial(_end_of_profile, predictor.remembering(minimum.u), minimum, limit, known)
        answers = in_processes(work, places, workers)
    else:
        work = partial(_end_of_profile, predictor, minimum, limit, known)
        answers = ((place, work(place)) for place in places)
    for place, (end, solves) in answers:
        ends[place] = end
        predictor.solves += solves
        tasks.finish()
    return tuple(
        profile_of(predictor, j, minimum, limit, [ends[j, -1], ends[j, 1]]) for j in indices
    )


def _end_of_profile(
    predictor: Predictor,
    minimum: Linearisation,
    limit: float,
    known: Mapping[int, Sequence[tuple[float, Array]]],
    place: tuple[int, int],
) -> tuple[End, int]:
    """Return an end of a profile and the number of solves."""
    predictor = copy(predictor)
    predictor.solves = 0
    end = find_end(predictor, *place, minimum, limit, known[place[0]])
    return end, predictor.solves


class _Tasks:
    """Reports the progress of a fit: evaluations that are done, of those expected for all tasks."""

    def __init__(self, predictor: Predictor, count: int, progress: Progress) -> None:
        # a minimisation takes about five iterations, and as many derivatives
        self.each = 5 * (1 + predictor.low.size)
        self.expected = count * self.each
        self.progress, self.finished, self.done = progress, 0, 0
        predictor.report = lambda: self._report(self.done + 1)

    def finish(self) -> None:
        """Report that the present task is done."""
        self.finished += 1
        self._report(self.finished * self.each)

    def end(self) -> None:
        """Report that all is done; a deeper minimum may have led to further tasks."""
        self.progress(self.expected, self.expected)

    def _report(self, done: int) -> None:
        """Report a number of evaluations, which never decreases."""
        limit = min((self.finished + 1) * self.each, self.expected - 1)
        self.done = max(self.done, min(done, limit))
        self.progress(self.done, self.expected)


def _count_best(predictor: Predictor, minima: Sequence[Linearisation]) -> int:
    """Return the number of starts that converged to the best minimum."""
    return sum(_is_least(end.S, minima[0].S, predictor) for end in minima)


def _is_least(S: float, smallest: float, predictor: Predictor) -> bool:
    """Return True if S is the least sum of squares to the accuracy of minima."""
    freedom = max(predictor.measured.size - len(predictor.parameters), 1)
    rounding = 1e-12 * float(np.sum((predictor.measured / predictor.deviation) ** 2))
    limit = smallest * (1 + max(SAME_MINIMUM, (3 * ACCURACY) ** 2 / freedom)) + rounding
    return limit >= S


def _covariance(predictor: Predictor, J: Array, S: float) -> Array:
    """Return s^2 (J^T J)^-1; inf if J is singular."""
    m, p = J.shape
    s2 = 1.0 if predictor.weighted else S / (m - p) if m > p else np.nan
    _, values, V = np.linalg.svd(J, full_matrices=False)
    with np.errstate(divide="ignore"):
        return np.asarray((V.T / values**2) @ V * s2)


def _result(
    predictor: Predictor,
    minima: list[Linearisation],
    starts: int,
    profiles: tuple[ProfileLikelihood, ...],
    quantities: Mapping[str, Quantity],
) -> FitResult:
    """Assemble the result: estimates, covariance, identifiability and fitted values."""
    u, r, J = minima[0]
    S, parameters = minima[0].S, predictor.parameters
    slope = np.array([p.slope(float(v)) for p, v in zip(parameters, u, strict=True)])
    covariance = slope[:, None] * _covariance(predictor, J, S) * slope
    error = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore"):
        correlation = covariance / np.outer(error, error)
    # identifiability in relative changes: of the value, or of the range
    unit = _units(parameters)
    _, singular, V = np.linalg.svd(J * unit, full_matrices=False)
    direction = V[-1] / V[-1][np.argmax(np.abs(V[-1]))]
    m, tenth = predictor.measured.size, np.log(1.1)
    return FitResult(
        names=tuple(p.name for p in parameters),
        estimates=np.array(list(predictor.inputs(u).values())),
        standard_errors=error,
        covariance=covariance,
        correlation=correlation,
        rms=float(np.sqrt(S / m)),
        direction=direction,
        condition=float(singular[0] / singular[-1]) if singular[-1] > 0 else float("inf"),
        effects=tenth * np.linalg.norm(J * unit, axis=0) / np.sqrt(m),
        joint_effect=float(tenth * np.linalg.norm(J @ (unit * direction)) / np.sqrt(m)),
        at_bound=tuple(_at_bound(parameters, u)),
        minima=tuple((end.S, tuple(predictor.inputs(end.u).values())) for end in minima),
        reached=_count_best(predictor, minima),
        starts=starts,
        solves=predictor.solves,
        measured=predictor.measured,
        fitted=predictor.measured + predictor.deviation * r,
        row_outputs=predictor.data.names,
        row_numbers=tuple(predictor.data.rows.tolist()),
        weighted=predictor.weighted,
        profiles=profiles,
        quantities=quantities,
    )


def _at_bound(parameters: Sequence[Parameter], u: Array) -> list[str]:
    """Return the names of the parameters whose estimates are at a bound."""
    names = []
    for parameter, value in zip(parameters, u, strict=True):
        low, high = parameter.ends
        if min(value - low, high - value) < 1e-4 * (high - low):
            names.append(parameter.name)
    return names
