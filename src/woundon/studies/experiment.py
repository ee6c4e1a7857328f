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
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import check_type, whole_number
from ..errors import InvalidProblem, NotConverged
from ..problems.messages import not_one_of, quote
from ..problems.paths import field_quantity, varied_number
from ..problems.problem import Problem
from ..problems.units import parse
from ..quantities import Quantity, in_chosen_units
from .api import solver_options
from .fit_result import FitResult
from .model import kind_of
from .outcome import Outcome
from .planned import Measurement, Planned, plan_measurement
from .progress import Progress, progress_reporter

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["NextExperiment", "next_experiment"]

Array = np.ndarray
CRITERIA = ("A", "D", "output")
# a standard error that all candidates together reduce by less than this share is not identified
REDUCED = 0.1
# linearisation points: drawn within two standard deviations, each at most by a factor of e
WIDEST, MOST_SIGMA = 1.0, 2.0
# score, relative to the best one, from which two first measurements count as equally good
EQUAL = 0.9


@dataclass(frozen=True, eq=False, repr=False)
class NextExperiment(Outcome):
    """Candidates in the order in which they should be measured; p parameters, n steps.

    Attributes
    ----------
    names : tuple of str
        The unknown fields.
    values : (p,) array
        Where the outputs are linearised, SI.
    measurements : tuple of Measurement
        The selected ones, best first.
    scores : (n,) array
        Expected reduction of the criterion per cost, of each after those before it.
    standard_errors : (n + 1, p) array
        Expected relative standard errors of the parameters: before, and after each measurement.
    output : str
        The output at the operating point.
    output_value : float
        Its prediction, SI.
    output_errors : (n + 1,) array
        Expected standard error of it, SI.
    covariance : (p, p) array
        Of ln(parameters), after all selected measurements.
    candidates : tuple of Measurement
    first_scores : (1 + draws, candidates) array
        Scores as the first measurement, at the problem and at each point drawn.
    first_errors : (candidates, p) array
        Expected relative standard errors of the parameters after this candidate alone.
    unidentified : tuple of str
        Parameters whose standard error all candidates together reduce by less than 10 %.
    direction : (p,) array
        The change of ln(parameters) that all candidates together determine least; its largest
        entry is 1.
    direction_error : float
        Standard error along it.
    criterion : str
    warnings : tuple of str
    quantities : mapping of str to Quantity
    problem : object

    Examples
    --------
    >>> import woundon as wo
    >>> half_width = wo.Measurement("half_width", {}, "1 %")
    >>> plan = wo.next_experiment(
    ...     wo.RollerProblem.example(), {"upper.radius": "5 %"}, [half_width], draws=0
    ... )
    >>> plan.best.quantity
    'half_width'
    >>> before, after = plan.standard_errors[:, 0]
    >>> bool(after < before)
    True
    """

    names: tuple[str, ...]
    values: Array
    measurements: tuple[Measurement, ...]
    scores: Array
    standard_errors: Array
    output: str
    output_value: float
    output_errors: Array
    covariance: Array
    candidates: tuple[Measurement, ...]
    first_scores: Array
    first_errors: Array
    unidentified: tuple[str, ...]
    direction: Array
    direction_error: float
    criterion: str
    warnings: tuple[str, ...] = ()
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    problem: Any = None

    @property
    def best(self) -> Measurement:
        """The measurement to do next."""
        return self.measurements[0]

    def answer(self) -> list[str]:
        """Return the next measurement, and the expected standard errors of each step."""
        quantity = self.quantities[self.output]
        unit = f" {quantity.display}" if quantity.display else ""
        texts = [f"next measurement: {self.best.name} (cost {self.best.cost:g})"]
        for k, step in enumerate(("now", *(m.name for m in self.measurements))):
            errors = zip(self.names, self.standard_errors[k], strict=True)
            parts = [f"{name} {_percent(error)}" for name, error in errors]
            parts.append(f"{self.output} {quantity.shown(self.output_errors[k]):.3g}{unit}")
            texts.append(f"{'' if k == 0 else f'{k}. after '}{step}: {', '.join(parts)}")
        return texts

    def remarks(self) -> list[str]:
        """Return the quantities that the measurements do not determine, and warnings."""
        texts = []
        if self.unidentified:
            texts.append(f"not identified by any candidate: {', '.join(self.unidentified)}")
        if len(self.names) > 1:
            change = ", ".join(
                f"{name} {10 * value:+.0f} %"
                for name, value in zip(self.names, self.direction, strict=True)
                if abs(value) >= 0.05  # shown as 0 % otherwise
            )
            texts.append(
                f"least determined change with all candidates: {change}; "
                f"standard error {_percent(self.direction_error)}"
            )
        return [*texts, *(f"warning: {in_chosen_units(text)}" for text in self.warnings)]

    def __repr__(self) -> str:
        errors = zip(self.names, self.standard_errors[[0, 1]].T, strict=True)
        change = ", ".join(f"{n} {_percent(a)} -> {_percent(b)}" for n, (a, b) in errors)
        return f"NextExperiment({self.best.name}: {change})"

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each step: cost, score, expected standard errors (output: SI)."""
        import pandas as pd

        columns: dict[str, Any] = {
            "cost": [0.0, *(m.cost for m in self.measurements)],
            "score": [np.nan, *self.scores],
        }
        columns |= {f"{name} +-": self.standard_errors[:, j] for j, name in enumerate(self.names)}
        columns[f"{self.output} +- [{self.quantities[self.output].unit}]"] = self.output_errors
        steps = pd.Index(["now", *(m.stored_name for m in self.measurements)], name="measurement")
        return pd.DataFrame(columns, index=steps)

    def _record(self) -> dict[str, Any]:
        names = [candidate.stored_name for candidate in self.candidates]
        return {
            "criterion": self.criterion,
            "steps": self.to_dataframe().reset_index().to_dict(orient="records"),
            "first_scores": dict(zip(names, self.first_scores[0], strict=True)),
            "unidentified": self.unidentified,
            "direction": dict(zip(self.names, self.direction, strict=True)),
            "direction_error": self.direction_error,
            "warnings": self.warnings,
        }


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
    fitted = problem if isinstance(problem, FitResult) else None
    base: Any = fitted.problem if fitted is not None else problem
    kind_of(base)
    prior = _prior(base, unknown, fitted)
    names = tuple(prior)
    theta = {
        name: varied_number(base, name, f"unknown: {name}", is_relative=True) for name in names
    }
    if criterion not in CRITERIA:
        raise InvalidProblem.at("criterion", not_one_of(criterion, CRITERIA))
    for name, measurements in (("candidates", candidates), ("completed", completed)):
        check_type(name, measurements, list, tuple)
    if not candidates:
        raise InvalidProblem.at("candidates", "missing; give at least one wo.Measurement")
    n = len(candidates)
    count = n if count is None else whole_number("count", count, 1, n)
    whole_number("draws", draws, 0, 1000)
    settings = solver_options(nodes, rtol, options)
    target = Measurement(output or _main_output(base, candidates), operating_point or {}, 1.0)

    def planned(measurement: Measurement) -> Planned:
        return plan_measurement(measurement, base, theta, tie or {}, settings)

    known, goal = [planned(m) for m in completed], planned(target)
    if goal.measurement.size != 1:
        raise InvalidProblem.at("operating_point", "must be one state, without sequences")
    total = len(completed) + (1 + draws) * n
    with progress_reporter(progress, "planning") as report:
        done = itertools.count(1)
        study = _Study(
            [planned(m) for m in candidates],
            known,
            goal,
            criterion,
            np.array([m.cost for m in candidates]),
            _start_information(prior, fitted),
            lambda: report(next(done), total),
        )
        local = study.at(theta)
        order = local.select(count)
        scores, covariances = local.steps(order)
        others, failures = _others(study, theta, covariances[0], draws, seed)
    unidentified, direction, direction_error = _weakest(local, covariances[0], names)
    first = np.array([local.first_scores(), *(other.first_scores() for other in others)])
    quantities = {goal.output: goal.quantity}
    quantities |= {name: q for name in names if (q := field_quantity(base, name)) is not None}
    return NextExperiment(
        names=names,
        values=np.array(list(theta.values())),
        measurements=tuple(candidates[k] for k in order),
        scores=scores,
        standard_errors=np.sqrt([np.diag(C) for C in covariances]),
        output=goal.output,
        output_value=local.output_value,
        output_errors=np.sqrt([local.gradient @ C @ local.gradient for C in covariances]),
        covariance=covariances[-1],
        candidates=tuple(candidates),
        first_scores=first,
        first_errors=np.sqrt(
            [np.diag(np.linalg.inv(local.J0 + each)) for each in local.information]
        ),
        unidentified=unidentified,
        direction=direction,
        direction_error=direction_error,
        criterion=criterion,
        warnings=tuple(_warnings(first, candidates, covariances[0], names, failures)),
        quantities=quantities,
        problem=base,
    )


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
    tuple of str
        Fields whose standard error they reduce by less than ``REDUCED``.
    (p,) array
        Direction of the largest standard error, with the largest component 1.
    float
        Standard error in this direction.
    """
    covariance = np.linalg.inv(local.J0 + local.information.sum(axis=0))
    errors, initial_errors = np.sqrt(np.diag(covariance)), np.sqrt(np.diag(initial))
    is_weak = errors > (1 - REDUCED) * initial_errors
    variances, vectors = np.linalg.eigh(covariance)
    direction = vectors[:, -1] / vectors[np.argmax(np.abs(vectors[:, -1])), -1]
    unidentified = tuple(name for name, weak in zip(names, is_weak, strict=True) if weak)
    return unidentified, direction, float(np.sqrt(variances[-1]))


def _main_output(base: Problem, candidates: Sequence[Measurement]) -> str:
    main: tuple[str, ...] = kind_of(base).result.MAIN
    return main[0] if main else candidates[0].quantity


# ---- unknown fields ------------------------------------------------------------------------------


def _prior(base: Problem, unknown: Any, fitted: FitResult | None) -> dict[str, float]:
    """Return the prior relative standard deviations; inf for a parameter of a fit without one."""
    check_type("unknown", unknown, Mapping)
    prior = {} if fitted is None else dict.fromkeys(fitted.names, np.inf)
    for name, value in unknown.items():
        deviation = float(parse(value, "1", f"unknown: {name}"))
        if not 0 < deviation < np.inf:
            text = f"{quote(value)} is out of range; must be a relative standard deviation > 0"
            raise InvalidProblem.at(f"unknown: {name}", text)
        prior[name] = deviation
    if not prior:
        raise InvalidProblem.at("unknown", "missing; must be {field: prior standard deviation}")
    return prior


def _start_information(prior: Mapping[str, float], fitted: FitResult | None) -> Array:
    """Return the information of prior and fit on ln(theta), (p, p)."""
    information = np.diag([1 / s**2 for s in prior.values()])
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


class _Study(NamedTuple):
    """Data of a study that do not depend on the linearisation point."""

    candidates: list[Planned]
    completed: list[Planned]
    goal: Planned
    criterion: str
    cost: Array
    start: Array
    report: Callable[[], None]

    def at(self, theta: Mapping[str, float], fixed: Array | None = None) -> _Linearised:
        """Return the information of all candidates at a linearisation point.

        Parameters
        ----------
        theta : mapping
        fixed : (p, p) array, optional
            Information before the first candidate; computed by default.
        """
        solved: dict[Any, Any] = {}
        value, gradient = self.goal.predict(theta, solved)
        J0 = fixed
        if J0 is None:
            J0 = self.start + sum(self._information(m, theta, solved) for m in self.completed)
        each = np.array([self._information(m, theta, solved) for m in self.candidates])
        return _Linearised(J0, each, gradient[0], float(value[0]), self.criterion, self.cost)

    def _information(
        self, measurement: Planned, theta: Mapping[str, float], solved: dict[Any, Any]
    ) -> Array:
        """Return the information of one measurement, and report that it is known."""
        information = measurement.information(theta, solved)
        self.report()
        return information


class _Linearised(NamedTuple):
    """Information of all candidates at one linearisation point."""

    J0: Array
    information: Array
    gradient: Array
    output_value: float
    criterion: str
    cost: Array

    def criterion_of(self, J: Array) -> float:
        """Return the criterion; small is good."""
        if self.criterion == "D":
            return -float(np.linalg.slogdet(J)[1])
        C = np.linalg.inv(J)
        return float(np.trace(C) if self.criterion == "A" else self.gradient @ C @ self.gradient)

    def first_scores(self) -> Array:
        """Return the score of each candidate as the first measurement, (candidates,)."""
        return np.array([self._score(self.J0, k) for k in range(len(self.cost))])

    def _score(self, J: Array, k: int) -> float:
        """Return the reduction of the criterion by candidate k per its cost; large is good."""
        reduction = self.criterion_of(J) - self.criterion_of(J + self.information[k])
        return reduction / float(self.cost[k])

    def select(self, count: int) -> list[int]:
        """Return the selected candidates, best first, by an exchange algorithm (Fedorov 1972).

        From the greedy selection, each selected candidate is exchanged for each of the others, and
        every exchange that increases the reduction per cost is kept, until there is none.
        """
        n = len(self.cost)
        selection = self._greedy(range(n), count)
        reduction = self._reduction_per_cost(selection)
        improved = count < n  # otherwise there is nothing to exchange
        while improved:
            improved = False
            for i in range(count):
                for k in set(range(n)) - set(selection):
                    trial = [*selection[:i], k, *selection[i + 1 :]]
                    trial_reduction = self._reduction_per_cost(trial)
                    # by more than rounding, so that the loop ends
                    if trial_reduction > reduction * (1 + 1e-9):
                        selection, reduction, improved = trial, trial_reduction, True
        return self._greedy(selection, count)

    def _reduction_per_cost(self, selection: Sequence[int]) -> float:
        """Return the reduction of the criterion per total cost; large is good."""
        J = self.J0 + self.information[list(selection)].sum(axis=0)
        reduction = self.criterion_of(self.J0) - self.criterion_of(J)
        return reduction / float(self.cost[list(selection)].sum())

    def _greedy(self, among: Sequence[int] | range, count: int) -> list[int]:
        """Return the indices of measurements, each the best one in addition to those before it."""
        J, remaining, order = self.J0, list(among), []
        for _ in range(count):
            best = max(remaining, key=lambda k: self._score(J, k))
            J = J + self.information[best]
            remaining.remove(best)
            order.append(best)
        return order

    def steps(self, order: Sequence[int]) -> tuple[Array, list[Array]]:
        """Return the score of each step, and the covariance before and after each."""
        J, scores, covariances = self.J0, [], [np.linalg.inv(self.J0)]
        for k in order:
            scores.append(self._score(J, k))
            J = J + self.information[k]
            covariances.append(np.linalg.inv(J))
        return np.array(scores), covariances


# ---- other linearisation points ------------------------------------------------------------------


def _others(
    study: _Study, theta: Mapping[str, float], C: Array, draws: int, seed: int
) -> tuple[list[_Linearised], int]:
    """Return the study at points drawn from the covariance C, and how many could not be solved."""
    variance, vectors = np.linalg.eigh(C)
    widths = np.minimum(np.sqrt(np.maximum(variance, 0)), WIDEST / MOST_SIGMA)
    rng = np.random.default_rng(seed)
    studies: list[_Linearised] = []
    failures = 0
    for z in np.clip(rng.standard_normal((draws, len(theta))), -MOST_SIGMA, MOST_SIGMA):
        factors = np.exp(vectors @ (widths * z)).tolist()
        point = {name: v * f for (name, v), f in zip(theta.items(), factors, strict=True)}
        try:
            studies.append(study.at(point, np.linalg.inv(C)))
        except (InvalidProblem, NotConverged):
            failures += 1
    return studies, failures


def _warnings(
    first: Array, candidates: Sequence[Measurement], C: Array, names: Sequence[str], failures: int
) -> list[str]:
    """Return warnings about the dependence of the ranking on the linearisation point."""
    texts = []
    best = int(np.argmax(first[0]))
    other = [int(np.argmax(scores)) for scores in first[1:] if scores[best] < EQUAL * scores.max()]
    if other:
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
                f"{name} is uncertain by {_percent(error)}: expected standard errors are linear "
                "and only rough"
            )
    return texts


def _percent(error: float) -> str:
    return f"{100 * error:.2g} %" if error < 1 else f"{100 * error:.0f} %"
