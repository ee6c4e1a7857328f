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
from collections.abc import Callable, Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ..errors import InvalidProblem, NotConverged
from ..parallel import in_processes
from ..quantities import Quantity
from ..results import Presented, ReadOnly
from . import fitreport
from .minimise import Minimum, minimise
from .predict import Parameter, Predictor
from .profiles import End, ProfileLikelihood, find_end, profile_of, threshold
from .progress import Progress
from .runners import WORTH_A_POOL

if TYPE_CHECKING:
    import pandas as pd
    import xarray

__all__ = ["FitResult", "fit_parameters"]

Array = np.ndarray
Item = TypeVar("Item")
Answer = TypeVar("Answer")
# accuracy of minima in standard errors: another mesh moves a minimum by as much; on few nodes
FINE, COARSE = 0.05, 0.3
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

    def __str__(self) -> str:
        return "\n".join(self.lines())

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
    starts: int,
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
    starts : int
        Number of starting points: the base value, the others by Latin hypercube.
    seed : int
    profiles : collection of str
        Parameters whose profile-likelihood intervals are found.
    quantities : mapping of str to Quantity
        Of parameters and outputs.
    workers : int
        Processes for starts and profiles, if they take long; the result does not depend on it.
    progress : callable
        Is called with the number of starts and profiles that are done, and of all.

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
    tasks = _Tasks(workers, starts + 1 + 2 * len(profiles), progress)
    found = _minima(predictor, _starting_points(parameters, starts, seed), tasks)
    if not found:
        raise NotConverged(f"no start of the fit could be solved: {predictor.fault}")
    for _ in range(3):
        made = _profiles(predictor, found[0], profiles, tasks)
        S, deepest = min((profile.best for profile in made), key=_first, default=(np.inf, None))
        if deepest is None or found[0].S * (1 - _same_minimum(predictor)) <= S:
            break
        # a profile has entered the basin of a deeper minimum that no start had found
        deeper = minimise(predictor, deepest, FINE)
        found = found if deeper is None else sorted([deeper, *found], key=_sum_of_squares)
    return _result(predictor, found, starts, made, quantities)


def _starting_points(parameters: Sequence[Parameter], starts: int, seed: int) -> list[Array]:
    """Return the base case and Latin hypercube samples within the bounds."""
    from scipy.stats import qmc

    low, high = np.transpose([p.ends for p in parameters])
    base = np.array([p.start for p in parameters])
    drawn = qmc.LatinHypercube(len(parameters), rng=seed).random(max(starts - 1, 0))
    return [base, *(low + drawn * (high - low))]


def _minima(predictor: Predictor, starts: Sequence[Array], tasks: _Tasks) -> list[Minimum]:
    """Return the minimum of each start that can be solved, in ascending order.

    The starts are minimised on few nodes where the model permits; what differs is then minimised
    on all nodes.
    """
    coarse = predictor.coarse
    ends = _from_starts(coarse or predictor, starts, FINE if coarse is None else COARSE, tasks)
    if coarse is not None:
        predictor.solves += coarse.solves
        fine: list[Minimum | None] = []
        refined: list[tuple[Minimum, Minimum | None]] = []
        for end in ends:
            same = [fine for known, fine in refined if _is_same(end, known, coarse)]
            if not same:
                refined.append((end, minimise(predictor, end.u, FINE)))
            fine.append(same[0] if same else refined[-1][1])
        ends = [end for end in fine if end is not None]
        ends = ends or _from_starts(predictor, starts, FINE, tasks)
    tasks.finish(1)
    return sorted(ends, key=_sum_of_squares)


def _from_starts(
    predictor: Predictor, starts: Sequence[Array], accuracy: float, tasks: _Tasks
) -> list[Minimum]:
    """Return the minima from several starts; the first one ends the others in its basin."""
    began = time.perf_counter()
    first = minimise(predictor, starts[0], accuracy)
    pace = time.perf_counter() - began
    tasks.finish(1)
    start_from = predictor if first is None else predictor.remembering(first.u)
    work = partial(_minimise_in_process, start_from, accuracy=accuracy, known=first)
    others = tasks.run(work, starts[1:], pace)
    predictor.solves += sum(solves for _, solves, _ in others)
    predictor.fault = predictor.fault or next((fault for *_, fault in others if fault), "")
    return [end for end in (first, *(end for end, *_ in others)) if end is not None]


def _minimise_in_process(
    predictor: Predictor, start: Array, *, accuracy: float, known: Minimum | None
) -> tuple[Minimum | None, int, str]:
    """Return the minimum from a start, the number of solves, and the last failure."""
    predictor = copy(predictor)
    predictor.solves = 0
    return minimise(predictor, start, accuracy, known), predictor.solves, predictor.fault


def _profiles(
    predictor: Predictor, minimum: Minimum, names: Collection[str], tasks: _Tasks
) -> tuple[ProfileLikelihood, ...]:
    """Return the profiles of named parameters; none without degrees of freedom."""
    freedom = predictor.measured.size - len(predictor.parameters)
    limit = threshold(minimum.S, freedom, predictor.weighted)
    chosen = [j for j, parameter in enumerate(predictor.parameters) if parameter.name in names]
    if not np.isfinite(limit):
        return ()
    ends: dict[tuple[int, int], End] = {}
    work = partial(_end_in_process, predictor.remembering(minimum.u), minimum, limit)
    places = [(j, sign) for j in chosen for sign in (-1, 1)]
    for place, (end, solves) in zip(places, tasks.run(work, places), strict=True):
        ends[place] = end
        predictor.solves += solves
    return tuple(
        profile_of(predictor, j, minimum, limit, [ends[j, -1], ends[j, 1]]) for j in chosen
    )


def _end_in_process(
    predictor: Predictor, minimum: Minimum, limit: float, place: tuple[int, int]
) -> tuple[End, int]:
    """Return an end of a profile and the number of solves."""
    predictor = copy(predictor)
    predictor.solves = 0
    end = find_end(predictor, *place, minimum, limit)
    return end, predictor.solves


class _Tasks:
    """Runs independent parts of a fit, in processes if they take long, and reports progress."""

    def __init__(self, workers: int, count: int, progress: Progress) -> None:
        self.workers, self.count, self.progress, self.done = workers, count, progress, 0

    def finish(self, tasks: int) -> None:
        """Report that some more tasks are done."""
        self.done += tasks
        self.progress(min(self.done, self.count), self.count)

    def run(
        self, work: Callable[[Item], Answer], items: Sequence[Item], pace: float | None = None
    ) -> list[Answer]:
        """Return ``work(item)`` of every item.

        Parameters
        ----------
        work : callable
        items : sequence
        pace : float, optional
            Expected seconds for each item; by default that of the first one.
        """
        answers: dict[int, Answer] = {}
        began = time.perf_counter()
        for k, item in enumerate(items):
            if pace is None and k:
                pace = (time.perf_counter() - began) / k
            left = len(items) - k
            if self.workers > 1 and left > 1 and pace is not None and pace * left > WORTH_A_POOL:
                rest = [(number, items[number]) for number in range(k, len(items))]
                workers = min(self.workers, left)
                for (number, _), answer in in_processes(partial(_numbered, work), rest, workers):
                    answers[number] = answer
                    self.finish(1)
                break
            answers[k] = work(item)
            self.finish(1)
        return [answers[k] for k in range(len(items))]


def _numbered(work: Callable[[Item], Answer], item: tuple[int, Item]) -> Answer:
    return work(item[1])


def _first(pair: tuple[float, Any]) -> float:
    return pair[0]


def _sum_of_squares(minimum: Minimum) -> float:
    return minimum.S


def _is_same(one: Minimum, other: Minimum, predictor: Predictor) -> bool:
    """Return True if two minima are the same to their accuracy."""
    if one is other:
        return True
    freedom = max(one.r.size - one.u.size, 1)
    distance = np.linalg.norm(other.J @ (one.u - other.u)) * np.sqrt(freedom / max(other.S, 1e-300))
    return bool(distance <= 2 * COARSE)


def _covariance(predictor: Predictor, J: Array, S: float) -> Array:
    """Return s^2 (J^T J)^-1; inf if J is singular."""
    m, p = J.shape
    s2 = 1.0 if predictor.weighted else S / (m - p) if m > p else np.nan
    _, values, V = np.linalg.svd(J, full_matrices=False)
    with np.errstate(divide="ignore"):
        return np.asarray((V.T / values**2) @ V * s2)


def _result(
    predictor: Predictor,
    found: list[Minimum],
    starts: int,
    profiles: tuple[ProfileLikelihood, ...],
    quantities: Mapping[str, Quantity],
) -> FitResult:
    """Assemble the result: estimates, covariance, identifiability and fitted values."""
    u, r, _ = found[0]
    J = predictor.jacobian(u)
    S, parameters = found[0].S, predictor.parameters
    slope = np.array([p.slope(float(v)) for p, v in zip(parameters, u, strict=True)])
    covariance = slope[:, None] * _covariance(predictor, J, S) * slope
    error = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore"):
        correlation = covariance / np.outer(error, error)
    # identifiability in relative changes: of the value, or of the range
    unit = np.array([1.0 if p.logarithmic else p.high - p.low for p in parameters])
    _, singular, V = np.linalg.svd(J * unit, full_matrices=False)
    direction = V[-1] / V[-1][np.argmax(np.abs(V[-1]))]
    m, tenth = predictor.measured.size, np.log(1.1)
    rounding = 1e-12 * float(np.sum((predictor.measured / predictor.deviation) ** 2))
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
        minima=tuple((end.S, tuple(predictor.inputs(end.u).values())) for end in found),
        reached=sum(S * (1 + _same_minimum(predictor)) + rounding >= end.S for end in found),
        starts=starts,
        solves=predictor.solves,
        measured=predictor.measured,
        fitted=predictor.measured + predictor.deviation * r,
        row_outputs=predictor.row_outputs,
        row_numbers=predictor.row_numbers,
        weighted=predictor.weighted,
        profiles=profiles,
        quantities=quantities,
    )


def _same_minimum(predictor: Predictor) -> float:
    """Return the relative difference of S within which minima are the same."""
    freedom = predictor.measured.size - len(predictor.parameters)
    return max(SAME_MINIMUM, COARSE**2 / max(freedom, 1))


def _at_bound(parameters: Sequence[Parameter], u: Array) -> list[str]:
    """Return the names of the parameters whose estimates are at a bound."""
    found = []
    for parameter, value in zip(parameters, u, strict=True):
        low, high = parameter.ends
        if min(value - low, high - value) < 1e-4 * (high - low):
            found.append(parameter.name)
    return found
