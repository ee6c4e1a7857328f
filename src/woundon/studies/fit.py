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

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial
from operator import attrgetter
from typing import Any

import numpy as np

from ..arguments import check_arguments, whole_number
from ..errors import InvalidProblem, NoSteadyState, NotConverged
from ..io.sheets import TableSource
from ..problems.messages import not_one_of, quote
from ..problems.paths import varied_value
from ..problems.problem import Problem
from .api import range_in_si
from .fit_result import FitResult
from .minimise import ACCURACY, Linearisation, minimise
from .model import model_of, options_of, quantities_of, solver_options
from .observations import Observations, read_observations
from .predict import Parameter, Predictor, with_input_scatter
from .profiles import End, ProfileLikelihood, find_end, profile_of, threshold
from .progress import Progress, progress_reporter
from .run import Workers

__all__ = ["fit", "fit_parameters"]

Array = np.ndarray
FIT_NODES = 65
MOST_STARTS = 6  # by default, if no two of them converge to the same minimum before
WIDEST = 0.5  # relative standard error of a minimum at which two starts are enough
SAME_MINIMUM = 1e-3  # relative difference of S


def fit(
    problem: Problem,
    measured: TableSource,
    vary: Mapping[str, tuple[float | str, float | str] | None] | Sequence[str],
    *,
    tie: Mapping[str, str] | None = None,
    columns: Mapping[str, str | None] | None = None,
    starts: int | None = None,
    seed: int = 0,
    profiles: bool | Sequence[str] = True,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: bool | Progress = False,
    nodes: int | None = None,
    rtol: float | None = None,
    options: Mapping[str, Any] | None = None,
) -> FitResult:
    """Fit fields of a problem of any kind to measured data by least squares.

    Parameters
    ----------
    problem : Problem
        The base case, with the fields that are neither measured nor fitted.
    measured : path, mapping or pandas.DataFrame
        CSV or Excel file with units in its header, or columns by name, SI if they have no unit:
        inputs ("nip_load [kN/m]"), outputs ("wound_on_tension [N/m]"), and standard deviations of
        both ("wound_on_tension +- [N/m]").
    vary : mapping or sequence of str
        Dotted name -> bounds (low, high), SI or texts with units; without bounds, a tenth to ten
        times the value.
    tie : mapping of str to str
        Field -> field that it follows, e.g. ``{"web.material": "roll.material"}``.
    columns : mapping
        Header in the data -> name of the quantity, with or without unit; None omits a column.
    starts, seed : int
        Number of starting points, the values of the problem and drawn ones, and seed of these.  By
        default until two starts converge to the best minimum, at most 6.
    profiles : bool or sequence of str
        Compute profile-likelihood intervals: of all fitted fields, or of the named ones.
    workers : int
        Processes for profiles; by default one for each core if they take long.
    scheduler : str
        Address of a Dask scheduler, "tcp://...", whose workers find the profiles.
    progress : bool or callable
        Show the fraction that is done, or call with (evaluations done, expected).
    nodes, rtol, options
        As of :func:`sweep`; by default 65 nodes if the solver chooses the mesh.  ``rtol`` is not
        recommended: outputs are continuous in the parameters on one mesh, and jump by the
        discretisation error where the mesh changes.

    Returns
    -------
    FitResult
        Its ``problem`` contains the estimates.

    Raises
    ------
    InvalidProblem
        For invalid names, bounds or data.
    NotConverged
        If no start can be solved.

    Examples
    --------
    >>> import woundon as wo
    >>> data = {"load [kN/m]": [50, 89, 120], "half_width [um]": [265, 354, 411]}
    >>> found = wo.fit(
    ...     wo.RollerProblem.example(), data, {"upper.radius": (0.1, 1.0)}, starts=1, nodes=17
    ... )
    >>> round(found.estimate("upper.radius"), 2)  # m
    0.25
    """
    check_arguments(vary=vary, profiles=profiles, seed=seed)
    if starts is not None:
        whole_number("starts", starts, 1, 1000)
    data = read_observations(problem, measured, columns, over_radius=False)
    settings = _on_one_mesh(problem, solver_options(nodes, rtol, options))
    model = model_of(problem, tuple(dict.fromkeys(data.names)), tie, settings)
    bounds = _bounds(vary)
    parameters = tuple(_parameter(problem, name, ends) for name, ends in bounds.items())
    model.check_varied([*(p.name for p in parameters), *data.inputs])
    _check_rows(problem, data)
    rows = (
        {name: float(values[row]) for name, values in data.inputs.items()}
        for row in dict.fromkeys(data.rows.tolist())
    )
    model.check_effects({p.name: (p.low, p.high) for p in parameters}, rows)
    _check_units(data)
    data = with_input_scatter(model, data)
    predictor, profiled = Predictor(model, data, parameters), _names_of_profiles(profiles, bounds)
    with progress_reporter(progress, "fitting") as report:
        result = fit_parameters(
            predictor,
            starts=starts,
            seed=seed,
            profiles=profiled,
            workers=Workers(workers, scheduler),
            progress=report,
        )
    estimates = dict(zip(result.names, result.estimates, strict=True))
    quantities = quantities_of(model, (*result.names, *data.names))
    return replace(result, problem=model.variant(estimates), quantities=quantities)


# ---- input --------------------------------------------------------------------------------------


def _on_one_mesh(problem: Problem, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options with a fixed number of nodes and without error estimates."""
    known = options_of(problem)  # option -> default; nodes None lets the solver choose the mesh
    defaults: dict[str, Any] = {"errors": False} if "errors" in known else {}
    if known.get("nodes", ...) is None and not options.keys() & {"nodes", "rtol"}:
        defaults["nodes"] = FIT_NODES
    return defaults | dict(options)


def _bounds(vary: Mapping[str, Any] | Sequence[str]) -> dict[str, Any]:
    """Return the fields to fit with their bounds; None for default bounds."""
    names = [vary] if isinstance(vary, str) else vary
    bounds = dict(names) if isinstance(names, Mapping) else dict.fromkeys(names)
    if not bounds:
        raise InvalidProblem.at("vary", "nothing to fit: give fields and their bounds")
    return bounds


def _names_of_profiles(
    profiles: bool | Sequence[str], varied: Mapping[str, Any]
) -> tuple[str, ...]:
    """Return the names of the parameters that get a profile."""
    if isinstance(profiles, bool):
        return tuple(varied) if profiles else ()
    names = (profiles,) if isinstance(profiles, str) else tuple(profiles)
    for name in names:
        if name not in varied:
            raise InvalidProblem.at("profiles", not_one_of(name, varied))
    return names


def _parameter(problem: Problem, name: str, bounds: Any) -> Parameter:
    """Return a parameter of a fit; its default bounds are a tenth and ten times its value."""
    base = varied_value(problem, name)
    if bounds is None:
        if base is None or base <= 0:
            raise InvalidProblem.at(name, f"is {quote(base)}: give bounds for it")
        bounds = (base / 10, base * 10)
    return Parameter(name, *range_in_si(problem, name, bounds), base)


def _check_rows(problem: Problem, data: Observations) -> None:
    """Reject rows with invalid inputs; rows without a steady state are left to the fit."""
    # each row once, although it may have several values: its number in a spreadsheet by its index
    for row, number in dict(zip(data.rows.tolist(), data.numbers, strict=True)).items():
        try:
            problem.replace(**{name: float(values[row]) for name, values in data.inputs.items()})
        except NoSteadyState:
            continue
        except InvalidProblem as fault:
            raise fault.under(f"{data.where}: row {number}") from None


def _check_units(data: Observations) -> None:
    """Reject outputs of different units without standard deviations."""
    units = {data.quantities[name].unit for name in data.names}
    if len(units) > 1 and np.isnan(data.deviation).any():
        text = f"outputs of different units ({', '.join(sorted(units))}) need standard deviations"
        raise InvalidProblem.at("measured", text)


# ---- minima and profiles ------------------------------------------------------------------------


def fit_parameters(
    predictor: Predictor,
    *,
    starts: int | None,
    seed: int,
    profiles: Collection[str],
    workers: Workers,
    progress: Progress = lambda done, expected: None,
) -> FitResult:
    """Fit the predictor's parameters; the result has no problem and no quantities.

    Parameters
    ----------
    predictor : Predictor
    starts : int or None
        Number of starting points: the base value, the others by Latin hypercube; by default until
        two of them converge to the best minimum, at most 6.
    seed : int
    profiles : collection of str
        Parameters whose profile-likelihood intervals are found.
    workers : Workers
        Where the profiles are found; the result does not depend on it.
    progress : callable
        Is called with the number of evaluations, and the expected one.

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
    tasks = _Tasks(predictor, (starts or 2) + 2 * len(profiles), progress)
    minima, count = _minima(predictor, starts, seed, tasks)
    if not minima:
        raise NotConverged(f"no start of the fit could be solved: {predictor.fault}")
    ends: dict[tuple[int, int], End] = {}  # by number of the parameter and sign of the side
    for _ in range(MOST_STARTS):  # profiles, until none of them finds a smaller S
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
    return _result(predictor, minima, count, likelihoods)


def _minima(
    predictor: Predictor, starts: int | None, seed: int, tasks: _Tasks
) -> tuple[list[Linearisation], int]:
    """Return the minima of the starts, the least one first, and the number of starts."""
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
    """Return the base case and Latin hypercube samples within the bounds, as coordinates u."""
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
    workers: Workers,
) -> tuple[ProfileLikelihood, ...]:
    """Return the profiles of named parameters; none without degrees of freedom.

    Parameters
    ----------
    predictor : Predictor
    minimum : Linearisation
    names : collection of str
    ends : dict
        Ends by number of the parameter and sign (-1 lower, 1 upper end), computed from a minimum
        that was not the least one; they are replaced.  Their points are still points of the
        profiles.
    tasks : _Tasks
    workers : Workers
    """
    freedom = predictor.measured.size - len(predictor.parameters)
    limit = threshold(minimum.S, freedom, predictor.weighted)
    indices = [j for j, parameter in enumerate(predictor.parameters) if parameter.name in names]
    if not np.isfinite(limit):
        return ()
    sides = [(j, sign) for j in indices for sign in (-1, 1)]
    # points of both ends: the minimum may have moved past them
    known = {j: [p for k, end in ends.items() if k[0] == j for p in end.points] for j in indices}
    # a worker receives the solutions of one u only: at the minimum they are good initial guesses
    predictor.keep_for_workers(minimum.u)
    work = partial(_end_of_profile, predictor, minimum, limit, known)
    for side, (end, solves) in workers.map(work, sides):
        ends[side] = end
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
    side: tuple[int, int],
) -> tuple[End, int]:
    """Return an end of a profile and the number of solves.

    Parameters
    ----------
    predictor : Predictor
    minimum : Linearisation
    limit : float
        S at the end.
    known : mapping of int to sequence of (S, u)
        Points of the profiles that were computed before, by number of the parameter.
    side : (int, int)
        Number of the parameter, and sign: -1 for the lower, 1 for the upper end.
    """
    before = predictor.solves
    end = find_end(predictor, *side, minimum, limit, known[side[0]])
    # the caller counts the solves, because it does not see the predictor of a worker
    solves, predictor.solves = predictor.solves - before, before
    return end, solves


class _Tasks:
    """Reports the progress of a fit: evaluations that are done, of those expected for all tasks.

    A task is the minimisation from one start, or one end of a profile.
    """

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
        # no more than the present task has, and less than all before the end
        limit = min((self.finished + 1) * self.each, self.expected - 1)
        self.done = max(self.done, min(done, limit))
        self.progress(self.done, self.expected)


def _count_best(predictor: Predictor, minima: Sequence[Linearisation]) -> int:
    """Return the number of starts that converged to the best minimum."""
    return sum(_is_least(end.S, minima[0].S, predictor) for end in minima)


def _is_least(S: float, smallest: float, predictor: Predictor) -> bool:
    """Return True if S is the least sum of squares to the accuracy of minima."""
    freedom = max(predictor.measured.size - len(predictor.parameters), 1)
    # k standard errors off the minimum S is larger by k^2 s^2, relatively k^2 / freedom
    rounding = 1e-12 * float(np.sum((predictor.measured / predictor.deviation) ** 2))
    limit = smallest * (1 + max(SAME_MINIMUM, (3 * ACCURACY) ** 2 / freedom)) + rounding
    return limit >= S


def _covariance(predictor: Predictor, J: Array, S: float) -> Array:
    """Return the covariance of the coordinates u, s^2 (J^T J)^-1, (p, p).

    It is not finite if J, (m, p), is singular.  s^2 is the variance of the residuals, whose squared
    sum is S; 1 if their standard deviations are known.
    """
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
) -> FitResult:
    """Assemble the result: estimates, covariance, identifiability and fitted values."""
    u, r, J = minima[0]
    S, parameters = minima[0].S, predictor.parameters
    slope = np.array([p.slope(float(v)) for p, v in zip(parameters, u, strict=True)])  # d value/du
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
    )


def _at_bound(parameters: Sequence[Parameter], u: Array) -> list[str]:
    """Return the names of the parameters whose estimates u, (p,), are at a bound."""
    names = []
    for parameter, value in zip(parameters, u, strict=True):
        low, high = parameter.ends
        if min(value - low, high - value) < 1e-4 * (high - low):
            names.append(parameter.name)
    return names
