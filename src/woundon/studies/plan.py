r"""Choice of the next measurement by its expected information (optimal experimental design).

With S = d output / d ln theta at the linearisation point and independent deviations sigma,

    J = J_0 + sum S^T S / sigma^2,      C = J^-1,

J_0 = diag(1/s^2) + information of the completed measurements, s the prior relative standard
deviations.  C is the covariance of ln theta that is expected after the measurements.  Criteria:

    A         trace C
    D         ln det C
    output    g^T C g,  g = d output / d ln theta at the operating point

The score of a measurement is the reduction of the criterion per cost.  Measurements are selected
greedily; then selected and other candidates are exchanged until no exchange reduces the criterion
per total cost.

References: V. V. Fedorov, Theory of Optimal Experiments, Academic Press 1972; A. C. Atkinson,
A. N. Donev, R. D. Tobias, Optimum Experimental Designs, with SAS, Oxford 2007, ch. 9-12.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..arguments import check_arguments, check_type, whole_number
from ..errors import InvalidProblem, NotConverged
from ..problems.messages import not_one_of
from ..problems.paths import field_quantity, varied_number
from ..problems.problem import Problem
from ..problems.units import parse
from .fit_result import FitResult
from .model import kind_of, solver_options
from .observations import read_deviation
from .plan_result import NextExperiment, percent
from .planned import Measurement, PlannedMeasurement, SolvedStates, plan_measurement
from .progress import Progress, progress_reporter

__all__ = ["next_experiment"]

Array = np.ndarray
CRITERIA = ("A", "D", "output")
# a standard error that all candidates together reduce by less than this share is not identified
REDUCED = 0.1
# linearisation points: drawn within two standard deviations, each at most by a factor of e
WIDEST, MOST_SIGMA = 1.0, 2.0
# score, relative to the best one, from which two first measurements count as equally good
EQUAL = 0.9


def next_experiment(
    problem: Problem | FitResult,
    unknown: Mapping[str, float | str],
    candidates: Sequence[Measurement],
    *,
    completed: Sequence[Measurement] = (),
    count: int | None = None,
    criterion: str = "A",
    output: str | None = None,
    operating_point: Mapping[str, Any] | None = None,
    tie: Mapping[str, str] | None = None,
    draws: int = 3,
    seed: int = 0,
    nodes: int | None = None,
    rtol: float | None = None,
    options: Mapping[str, Any] | None = None,
    progress: bool | Progress = False,
) -> NextExperiment:
    """Rank candidate measurements by the expected reduction of uncertainty per cost.

    Parameters
    ----------
    problem : Problem or FitResult
        The values of its fields are the linearisation point.  The covariance of a fit is the
        information that its measured values give of the fitted parameters; give its measurements
        as ``completed`` of ``fit.problem`` instead if other fields are unknown too.
    unknown : mapping of str to float or str
        Dotted name of a field -> prior relative standard deviation, "25 %" or 0.25.  Parameters of
        a fit need no prior.
    candidates, completed : sequence of Measurement
        A completed measurement counts with its standard deviation; its value is not needed.
    count : int, optional
        Number of measurements to select; all candidates by default.
    criterion : {"A", "D", "output"}
        Sum of the variances of the parameters' logarithms; logarithm of the determinant of their
        covariance; variance of ``output`` at the operating point.
    output : str, optional
        By default the main output of the kind of problem, or, if it has none, the quantity of the
        first candidate.
    operating_point : mapping, optional
        Fields at the operating point, SI or texts with units.
    tie : mapping of str to str
        As of :func:`woundon.fit`.
    draws, seed : int
        Points drawn from the present uncertainty at which the ranking is repeated.
    nodes, rtol, options
        As of :func:`woundon.sweep`.
    progress : bool or callable
        Show the fraction that is done, or call with (measurements done, expected).

    Returns
    -------
    NextExperiment

    Raises
    ------
    InvalidProblem
        For invalid names, units, values or standard deviations.
    NotConverged
        If a state cannot be solved.

    Examples
    --------
    >>> import woundon as wo
    >>> plan = wo.next_experiment(
    ...     wo.RollerProblem.example(), {"upper.radius": "5 %", "load": "10 %"},
    ...     [wo.Measurement("half_width", {}, "10 %"), wo.Measurement("peak_pressure", {}, "1 %")],
    ...     draws=0,
    ... )
    >>> plan.best.quantity
    'peak_pressure'
    """
    check_arguments(
        unknown=unknown,
        criterion=criterion,
        output=output,
        operating_point=operating_point,
        seed=seed,
        tie=tie,
    )
    whole_number("draws", draws, 0, 1000)
    if criterion not in CRITERIA:
        raise InvalidProblem.at("criterion", not_one_of(criterion, CRITERIA))
    fitted = problem if isinstance(problem, FitResult) else None
    base: Any = fitted.problem if fitted is not None else problem
    main_outputs = kind_of(base).result.MAIN
    prior = _prior(unknown, fitted)
    theta = {
        name: varied_number(base, name, f"unknown: {name}", is_relative=True) for name in prior
    }
    _check_measurements(candidates, completed)
    n = len(candidates)
    count = n if count is None else whole_number("count", count, 1, n)
    planned = partial(
        plan_measurement,
        problem=base,
        unknown=tuple(theta),
        tie=tie or {},
        options=solver_options(nodes, rtol, options),
    )
    output = output or next(iter(main_outputs), candidates[0].quantity)
    # the output at the operating point is predicted only, so its standard deviation has no meaning
    goal = planned(Measurement(output, operating_point or {}, standard_deviation=1.0))
    if goal.measurement.size != 1:
        raise InvalidProblem.at("operating_point", "must be one state, without sequences")
    known, possible = [planned(m) for m in completed], [planned(m) for m in candidates]
    total = len(completed) + (1 + draws) * n
    with progress_reporter(progress, "planning") as report:
        done = itertools.count(1)
        study = _Study(possible, goal, criterion, lambda: report(next(done), total))
        solved: SolvedStates = {}
        start = _prior_information(prior, fitted) + study.information(known, theta, solved).sum(0)
        local = study.at(theta, start, solved)
        steps = local.select(count)
        others, failures = _at_drawn_points(study, theta, steps.covariances[0], draws, seed)
    return _result(base, theta, study, [local, *others], steps, failures)


def _check_measurements(
    candidates: Sequence[Measurement], completed: Sequence[Measurement]
) -> None:
    """Reject lists with anything else than measurements, and an empty list of candidates."""
    for name, measurements in (("candidates", candidates), ("completed", completed)):
        check_type(name, measurements, list, tuple)
        for measurement in measurements:
            check_type(name, measurement, Measurement)
    if not candidates:
        raise InvalidProblem.at("candidates", "missing; give at least one wo.Measurement")


def _result(
    problem: Problem,
    theta: Mapping[str, float],
    study: _Study,
    points: Sequence[_Linearised],
    steps: _Steps,
    failures: int,
) -> NextExperiment:
    """Return the result of a study.

    Parameters
    ----------
    problem : Problem
    theta : mapping of str to float
        Unknown field -> value, SI.
    study : _Study
    points : sequence of _Linearised
        At the values of the problem, and at the points drawn.
    steps : _Steps
        The selected measurements.
    failures : int
        Number of points drawn that could not be solved.
    """
    local, names, goal = points[0], tuple(theta), study.goal
    candidates = tuple(each.measurement for each in study.candidates)
    covariances = steps.covariances
    first_scores = np.array([point.scores(point.start) for point in points])
    after_first = [np.linalg.inv(local.start + each) for each in local.information]
    unidentified, direction, direction_error = _weakest(local, covariances[0], names)
    warnings = _warnings(first_scores, candidates, covariances[0], names, failures)
    quantities = {goal.output: goal.quantity}
    quantities |= {name: q for name in names if (q := field_quantity(problem, name)) is not None}
    return NextExperiment(
        names=names,
        values=np.array(list(theta.values())),
        measurements=tuple(candidates[k] for k in steps.order),
        scores=np.array(steps.scores),
        standard_errors=np.sqrt([np.diag(C) for C in covariances]),
        output=goal.output,
        output_value=local.output_value,
        output_errors=np.sqrt([local.gradient @ C @ local.gradient for C in covariances]),
        covariance=covariances[-1],
        candidates=candidates,
        first_scores=first_scores,
        first_errors=np.sqrt([np.diag(C) for C in after_first]),
        unidentified=unidentified,
        direction=direction,
        direction_error=direction_error,
        criterion=study.criterion,
        warnings=tuple(warnings),
        quantities=quantities,
        problem=problem,
    )


# ---- unknown fields ------------------------------------------------------------------------------


def _prior(unknown: Mapping[str, float | str], fitted: FitResult | None) -> dict[str, float]:
    """Return the prior relative standard deviations; inf for a parameter of a fit without one."""
    prior = {} if fitted is None else dict.fromkeys(fitted.names, np.inf)
    for name, value in unknown.items():
        where = f"unknown: {name}"
        # relative in both forms, 0.25 and "25 %"
        prior[name], _ = read_deviation(value, partial(parse, unit="1", field=where), where)
    if not prior:
        raise InvalidProblem.at("unknown", "missing; must be {field: prior standard deviation}")
    return prior


def _prior_information(prior: Mapping[str, float], fitted: FitResult | None) -> Array:
    """Return the information of prior and fit on ln(theta), (p, p)."""
    information = np.diag([1 / s**2 for s in prior.values()])  # 0 of an infinite deviation
    if fitted is not None:
        relative = fitted.covariance / np.outer(fitted.estimates, fitted.estimates)
        if not np.isfinite(relative).all():
            text = (
                "its covariance is not finite: the data do not determine all parameters; "
                "give fit.problem, a prior and the measurements as completed"
            )
            raise InvalidProblem.at("problem", text)
        names = list(prior)
        indices = [names.index(name) for name in fitted.names]
        information[np.ix_(indices, indices)] += np.linalg.inv(relative)
    return np.asarray(information)


# ---- criteria and selection ----------------------------------------------------------------------


class _Steps(NamedTuple):
    """Selected candidates, each in addition to those before it.

    Attributes
    ----------
    order : list of n int
        Numbers of the candidates, best first.
    scores : list of n float
    covariances : list of n + 1 (p, p) arrays
        Of ln(theta), before and after each.
    """

    order: list[int]
    scores: list[float]
    covariances: list[Array]


@dataclass(frozen=True)
class _Study:
    """Measurements and criterion, which do not depend on the values of the unknown fields.

    Attributes
    ----------
    candidates : list of PlannedMeasurement
    goal : PlannedMeasurement
        The output at the operating point.
    criterion : str
    report : callable
        Is called after each measurement of which the information is known.
    """

    candidates: list[PlannedMeasurement]
    goal: PlannedMeasurement
    criterion: str
    report: Callable[[], None]

    def information(
        self,
        measurements: Iterable[PlannedMeasurement],
        theta: Mapping[str, float],
        solved: SolvedStates,
    ) -> Array:
        """Return the information of measurements on ln(theta), (measurements, p, p)."""
        each = [np.zeros((0, len(theta), len(theta)))]  # the shape if there is no measurement
        for measurement in measurements:
            each.append(measurement.information(theta, solved)[np.newaxis])
            self.report()
        return np.concatenate(each)

    def at(self, theta: Mapping[str, float], start: Array, solved: SolvedStates) -> _Linearised:
        """Return the information of all candidates at theta.

        Parameters
        ----------
        theta : mapping of str to float
            Unknown field -> value, SI.
        start : (p, p) array
            Information before the first candidate.
        solved : dict
            States that are solved at theta already.
        """
        value, gradient = self.goal.predict(theta, solved)
        cost = np.array([m.measurement.cost for m in self.candidates])
        each = self.information(self.candidates, theta, solved)
        return _Linearised(start, each, gradient[0], float(value[0]), self.criterion, cost)


@dataclass(frozen=True)
class _Linearised:
    """Information on ln(theta) at one point, and the criterion by which candidates are selected.

    Attributes
    ----------
    start : (p, p) array
        Information before the first candidate.
    information : (candidates, p, p) array
    gradient : (p,) array
        d output / d ln(theta) at the operating point.
    output_value : float
    criterion : str
    cost : (candidates,) array
    """

    start: Array
    information: Array
    gradient: Array
    output_value: float
    criterion: str
    cost: Array

    def measure(self, J: Array) -> float:
        """Return the criterion for the information J, (p, p); a small value is good."""
        if self.criterion == "D":
            return -float(np.linalg.slogdet(J)[1])
        C = np.linalg.inv(J)
        return float(np.trace(C) if self.criterion == "A" else self.gradient @ C @ self.gradient)

    def scores(self, J: Array) -> Array:
        """Return the reduction of the criterion per cost by each candidate in addition to J."""
        reductions = [self.measure(J) - self.measure(J + each) for each in self.information]
        return np.array(reductions) / self.cost

    def select(self, count: int) -> _Steps:
        """Return the selected candidates, best first, by an exchange algorithm (Fedorov 1972).

        From the greedy selection, each selected candidate is exchanged for each of the others, and
        every exchange that increases the reduction per total cost is kept, until there is none.
        """
        everyone = range(len(self.cost))
        selection = self.ranked(everyone, count).order
        reduction = self._reduction_per_cost(selection)
        improved = True
        while improved:
            improved = False
            for i, k in itertools.product(range(count), everyone):
                if k in selection:
                    continue
                trial = [*selection[:i], k, *selection[i + 1 :]]
                trial_reduction = self._reduction_per_cost(trial)
                # by more than rounding, so that the loop ends
                if trial_reduction > reduction * (1 + 1e-9):
                    selection, reduction, improved = trial, trial_reduction, True
        return self.ranked(selection, count)

    def _reduction_per_cost(self, selection: list[int]) -> float:
        """Return the reduction of the criterion by a selection per its total cost."""
        J = self.start + self.information[selection].sum(axis=0)
        return (self.measure(self.start) - self.measure(J)) / float(self.cost[selection].sum())

    def ranked(self, among: Iterable[int], count: int) -> _Steps:
        """Return candidates, each the best one in addition to those before it."""
        J, remaining = self.start, list(among)
        steps = _Steps([], [], [np.linalg.inv(J)])
        for _ in range(count):
            scores = self.scores(J)
            best = max(remaining, key=scores.__getitem__)
            remaining.remove(best)
            J = J + self.information[best]
            steps.order.append(best)
            steps.scores.append(float(scores[best]))
            steps.covariances.append(np.linalg.inv(J))
        return steps


def _weakest(
    local: _Linearised, initial: Array, names: Sequence[str]
) -> tuple[tuple[str, ...], Array, float]:
    """Return the fields and the direction that all candidates together determine worst.

    Parameters
    ----------
    local : _Linearised
    initial : (p, p) array
        Covariance before the first candidate.
    names : sequence of str
        The p unknown fields.

    Returns
    -------
    unidentified : tuple of str
        Fields whose standard error they reduce by less than ``REDUCED``.
    direction : (p,) array
        Direction of the largest standard error, with the largest component 1.
    direction_error : float
        Standard error in this direction.
    """
    covariance = np.linalg.inv(local.start + local.information.sum(axis=0))
    errors, initial_errors = np.sqrt(np.diag(covariance)), np.sqrt(np.diag(initial))
    is_weak = errors > (1 - REDUCED) * initial_errors
    variances, vectors = np.linalg.eigh(covariance)
    direction = vectors[:, -1] / vectors[np.argmax(np.abs(vectors[:, -1])), -1]
    unidentified = tuple(name for name, weak in zip(names, is_weak, strict=True) if weak)
    return unidentified, direction, float(np.sqrt(variances[-1]))


# ---- other linearisation points ------------------------------------------------------------------


def _at_drawn_points(
    study: _Study, theta: Mapping[str, float], C: Array, draws: int, seed: int
) -> tuple[list[_Linearised], int]:
    """Return the study at points drawn from the covariance C, and how many could not be solved.

    Parameters
    ----------
    study : _Study
    theta : mapping of str to float
        Unknown field -> value, SI.
    C : (p, p) array
        Covariance of ln(theta) before the first candidate.
    draws, seed : int
    """
    variance, vectors = np.linalg.eigh(C)
    # standard deviations along the principal axes; negative variances are rounding errors
    widths = np.minimum(np.sqrt(np.maximum(variance, 0)), WIDEST / MOST_SIGMA)
    rng = np.random.default_rng(seed)
    studies: list[_Linearised] = []
    failures = 0
    for z in np.clip(rng.standard_normal((draws, len(theta))), -MOST_SIGMA, MOST_SIGMA):
        factors = np.exp(vectors @ (widths * z)).tolist()
        point = {name: v * f for (name, v), f in zip(theta.items(), factors, strict=True)}
        try:
            studies.append(study.at(point, np.linalg.inv(C), {}))
        except (InvalidProblem, NotConverged):
            failures += 1
    return studies, failures


def _warnings(
    first: Array, candidates: Sequence[Measurement], C: Array, names: Sequence[str], failures: int
) -> list[str]:
    """Return warnings about the dependence of the ranking on the linearisation point.

    Parameters
    ----------
    first : (1 + draws, candidates) array
        Scores as the first measurement, at the problem and at each point drawn.
    candidates : sequence of Measurement
    C : (p, p) array
        Covariance of the logarithms of the unknown fields before the first candidate.
    names : sequence of str
        The p unknown fields.
    failures : int
        Number of points drawn that could not be solved.
    """
    texts = []
    best = int(np.argmax(first[0]))
    # best candidates at the points drawn where that of the problem is clearly not the best
    other = [int(np.argmax(scores)) for scores in first[1:] if scores[best] < EQUAL * scores.max()]
    if other:  # the most frequent one is named
        name = candidates[max(other, key=other.count)].stored_name
        texts.append(
            f"the ranking depends on the values assumed: at {len(other)} of {len(first) - 1} "
            f"points drawn from the present uncertainty another measurement is best ({name})"
        )
    if failures:
        texts.append(f"{failures} points drawn from the present uncertainty have no solution")
    for name, error in zip(names, np.sqrt(np.diag(C)), strict=True):
        if error > 0.5:
            texts.append(
                f"{name} is uncertain by {percent(error)}: expected standard errors are linear "
                "and only rough"
            )
    return texts
