r"""Optimise a winding schedule: a few fields are variables, the margins are constraints.

    a goal    min f(u)  so that  m_i(u) >= 0
    no goal   max t     so that  m_i(u) >= t    maximise the smallest reserve

u are the fields as shares of their ranges, m_i the reserves of the margins that have limits.  Each
evaluation is a complete winding.  Derivatives are not available: a margin is the minimum over the
radius, with a kink where the location of the minimum jumps, and contains discretisation errors.
COBYLA (Powell 1994, in SciPy) uses linear models on a simplex of n + 1 windings and a trust region.
At the optimum usually as many limits are active as there are fields, which linear models find fast.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite, isinf, nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from .. import kinds
from ..arguments import check_arguments, check_type, whole_number
from ..errors import InvalidProblem, NotConverged, one_of
from ..problems.limits import Limits
from ..problems.messages import quote
from ..problems.paths import field_or_none, get_field, varied_number
from ..problems.problem import Problem
from ..quantities import Quantity, in_chosen_units, value_of
from ..results import Result
from .api import range_in_si
from .model import KindModel, model_of, quantities_of, solver_options
from .outcome import Outcome
from .progress import Progress, progress_reporter

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["OptimisedSchedule", "optimise_schedule"]

Array = np.ndarray
# settings of a winder and their usual ranges
USUAL = {"web_tension.taper": (0.0, 0.7), "torque_split": (0.0, 1.0)}
USUAL_SHARES = {"nip_load": (0.25, 2.0)}  # relative to the present value
FIRST_STEP, LAST_STEP = 0.2, 5e-4  # of the ranges
TOLERANCE = 1e-4  # of a limit: tolerance of the constraints
FAILED = -1.0  # reserve of a winding that cannot be solved
FAILED_OBJECTIVE = 2.0  # of such a winding, in magnitudes of the output of the first one
BINDING = 0.01  # of a limit: a margin with a smaller reserve is active
MIN_EVALUATIONS, MOST_EVALUATIONS = 5, 100_000


@dataclass(frozen=True, eq=False, repr=False)
class OptimisedSchedule(Outcome):
    """Result of :func:`woundon.optimise_schedule`: initial and best schedule.

    Attributes
    ----------
    names : tuple of str
        Names of the varied fields.
    start, values : (n,) arrays
        Initial and best values, SI.
    before, after : Result
        Results; ``after`` is the best feasible one, or the one with the smallest violation.
    margins_before, margins_after : Margins
        Reserves of the limits for ``before`` and ``after``.
    feasible : bool
        Whether all limits are kept.
    binding : tuple of str
        The active margins: violated, or nearest to their limits.
    tried : (k, n) array
        The values of all windings that were computed, SI.
    reserves : (k,) array
        The smallest reserve of each; nan where it could not be solved.
    goal : str
        The objective as text.
    goals : (k,) array
        The values of the objective: the output in SI, or the smallest reserve; nan where it could
        not be solved.
    ended : str
        Reason of the termination.
    ranges : (n, 2) array
        Of the fields, SI.
    quantities : mapping of str to Quantity
        Of the fields.

    Examples
    --------
    >>> import woundon as wo
    >>> best = wo.optimise_schedule(
    ...     wo.RollProblem.example(), {"wound_on_tension": (200.0, 400.0)},
    ...     limits=wo.Limits(core_pressure="1 MPa"), evaluations=5,
    ... )
    >>> best.after.problem == best.problem
    True
    """

    names: tuple[str, ...]
    start: Array
    values: Array
    before: Result
    after: Result
    margins_before: Any
    margins_after: Any
    feasible: bool
    binding: tuple[str, ...]
    tried: Array
    reserves: Array
    goal: str
    goals: Array
    ended: str
    ranges: Array
    quantities: Mapping[str, Quantity]

    @property
    def problem(self) -> Problem:
        """The winding with the best schedule."""
        return self.after.problem

    def __repr__(self) -> str:
        values = [
            f"{name} {self.quantities[name].text(value)}"
            for name, value in zip(self.names, self.values, strict=True)
        ]
        word = "feasible" if self.feasible else "infeasible"
        return f"OptimisedSchedule({', '.join(values)}; {word})"

    def answer(self) -> list[str]:
        """Return the verdict on the limits and the schedule, as lines of text."""
        words = "All limits are kept" if self.feasible else "NO schedule keeps all limits"
        texts = [f"{words}: {self.goal}, {len(self.tried)} windings, {self.ended}"]
        # whether each value is at the low and at the high end of its range, (n, 2)
        ends = np.isclose(self.ranges, self.values[:, None], rtol=1e-3, atol=0)
        for name, old, new, end in zip(self.names, self.start, self.values, ends, strict=True):
            quantity = self.quantities[name]
            before, after = f"{quantity.shown(old):.4g}", f"{quantity.shown(new):.4g}"
            mark = "  at the end of its range" if end.any() else ""
            line = f"  {name:<24} {before:>14} -> {after} {quantity.display}{mark}"
            texts.append(line.rstrip())
        return texts

    def remarks(self) -> list[str]:
        """Return the reserves of the margins before and after as lines of text."""
        texts = [f"  {'margin':<24} {'reserve before':>14} -> after"]
        for old, new in zip(self.margins_before, self.margins_after, strict=True):
            if not new.checked:
                texts.append(f"  {new.name:<24} not checked: {in_chosen_units(new.note)}")
                continue
            mark = "  binds" if new.name in self.binding else ""
            mark += "  VIOLATED" if new.ok is False else ""
            before, after = (
                "no friction" if isinf(m.reserve) else f"{100 * m.reserve:.4g} %"
                for m in (old, new)
            )
            texts.append(f"  {new.name:<24} {before:>14} -> {after}{mark}")
        return texts

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each field: initial and best value, ends of its range [SI]."""
        import pandas as pd

        low, high = self.ranges.T
        columns = {"start": self.start, "value": self.values, "low": low, "high": high}
        return pd.DataFrame(columns, index=pd.Index(self.names, name="field"))


def optimise_schedule(
    problem: Problem,
    over: Mapping[str, tuple[Any, Any]] | None = None,
    *,
    limits: Limits | None = None,
    minimise: str | None = None,
    maximise: str | None = None,
    evaluations: int = 60,
    progress: bool | Progress = False,
    options: Mapping[str, Any] | None = None,
) -> OptimisedSchedule:
    """Find the best schedule that keeps all limits of a roll.

    Parameters
    ----------
    problem : WindingProblem or RollProblem
        The initial schedule; values outside their ranges are replaced by the ends.
    over : mapping, optional
        Dotted name of a field -> (low, high), SI or texts with units.  By default
        ``web_tension.taper`` from 0 to 0.7, ``torque_split`` from 0 to 1 and ``nip_load`` from a
        quarter to twice the present value, if they are numbers in the problem.
    limits : Limits, optional
        By default those of the winding; required for a roll.
    minimise, maximise : str, optional
        A scalar output; by default the smallest reserve is maximised.
    evaluations : int
        Maximum number of windings.  Ctrl-C ends the search with the best one so far.
    progress : bool or callable
        Show rate and time left, or call with (windings done, maximum).
    options : mapping
        Of the solver, e.g. ``{"rtol": 1e-4}``.

    Returns
    -------
    OptimisedSchedule
        If no schedule is feasible, it contains the one with the smallest violation.

    Raises
    ------
    InvalidProblem
        For invalid names or ranges, or if no margin has a limit.
    NotConverged
        If the winding that the search begins with cannot be solved.

    Examples
    --------
    >>> import woundon as wo
    >>> best = wo.optimise_schedule(
    ...     wo.RollProblem.example(), {"wound_on_tension": (200.0, 400.0)},
    ...     limits=wo.Limits(core_pressure="1 MPa"), evaluations=5,
    ... )
    >>> best.feasible, best.names
    (True, ('wound_on_tension',))
    """
    check_arguments(over=over, minimise=minimise, maximise=maximise)
    whole_number("evaluations", evaluations, MIN_EVALUATIONS, MOST_EVALUATIONS)
    if limits is not None:
        check_type("limits", limits, Limits)
    if minimise is not None and maximise is not None:
        raise InvalidProblem.at(
            "maximise", "is given together with minimise; must be one of the two"
        )
    goal, sign = (minimise, 1.0) if maximise is None else (maximise, -1.0)
    model = model_of(problem, goal, None, solver_options(None, None, options))
    if model.kind.margins is None:
        known = one_of(kind.problem.__name__ for kind in kinds.every() if kind.margins)
        raise InvalidProblem.at("problem", f"{quote(problem)} is out of place; must be a {known}")
    ranges = _ranges(problem, over)
    with progress_reporter(progress, "winding", unit="windings/min") as report:
        search = _Search(model, ranges, limits, goal, sign, evaluations, report)
        ended = search.run()
    return search.result(ended)


def _ranges(problem: Problem, over: Mapping[str, Any] | None) -> dict[str, tuple[float, float]]:
    """Return the ranges of the varied fields, SI."""
    given = _usual(problem) if over is None else over
    if not given:
        text = "nothing to vary; must be a mapping of fields to (low, high)"
        raise InvalidProblem.at("over", text)
    ranges = {}
    for name, ends in given.items():
        varied_number(problem, name)  # rejects a field that is not a number
        ranges[name] = range_in_si(problem, name, ends)
    return ranges


def _usual(problem: Problem) -> dict[str, tuple[float, float]]:
    """Return the usual ranges of those settings that are numbers in the problem."""
    ranges: dict[str, tuple[float, float]] = {}
    for name, (low, high) in (USUAL | USUAL_SHARES).items():
        value = field_or_none(problem, name)
        is_used = name not in problem.unused and not (name in USUAL_SHARES and value == 0.0)
        if isinstance(value, float) and is_used:
            size = value if name in USUAL_SHARES else 1.0
            ranges[name] = (low * size, high * size)
    return ranges


class _Stop(Exception):
    """The maximum number of evaluations is reached."""


class _Evaluation(NamedTuple):
    """One winding: values of the fields [SI], reserves as shares of the limits, goal [SI].

    Result and margins are None if it was not solved.
    """

    values: tuple[float, ...]
    reserves: Array
    goal: float = nan
    result: Any = None
    margins: Any = None

    @property
    def least(self) -> float:
        """The smallest reserve; nan if the winding was not solved."""
        return float(self.reserves.min()) if self.result is not None else nan


class _Search:
    """The windings that were computed, and objective and constraints for SciPy.

    The winding of the model's problem is solved first; it selects the margins that are kept.

    Parameters
    ----------
    model : KindModel
    ranges : mapping of str to (low, high)
        Of the varied fields, SI.
    limits : Limits or None
    goal : str or None
        The output to optimise; None for the smallest reserve.
    sign : float
        -1 if the output is maximised.
    evaluations : int
        Maximum number of windings.
    report : callable
        Is called with the number of windings and the maximum.

    Raises
    ------
    InvalidProblem
        If no margin has a limit.
    NotConverged
        If the first winding cannot be solved.
    """

    def __init__(
        self,
        model: KindModel,
        ranges: Mapping[str, tuple[float, float]],
        limits: Limits | None,
        goal: str | None,
        sign: float,
        evaluations: int,
        report: Progress,
    ) -> None:
        self.model, self.limits, self.goal, self.sign = model, limits, goal, sign
        self.names = tuple(ranges)
        self.low, self.high = np.array(list(ranges.values())).T
        self.max_evaluations, self.failure, self.report = evaluations, "", report
        self.evaluations: dict[tuple[float, ...], _Evaluation] = {}
        # the values of the problem, and the values within the ranges with which the search starts
        self.initial = np.array([get_field(model.problem, name) for name in self.names])
        self.first = np.clip(self.initial, self.low, self.high)
        self.before = model.solve(model.problem, None)
        self.margins_before = self._margins(self.before)
        self.checked = [margin.name for margin in self.margins_before if margin.checked]
        if not self.checked:
            text = "none is given; must be one at least, or there is nothing to keep"
            raise InvalidProblem.at("limits", text)
        # magnitude of the output to optimise
        self.scale = (abs(value_of(self.before, goal)) or 1.0) if goal else 1.0
        if np.array_equal(self.initial, self.first):
            values = tuple(self.first.tolist())
            self.evaluations[values] = self._evaluation(values, self.before)

    # ---- windings --------------------------------------------------------------------------------

    def _margins(self, result: Result) -> Any:
        """Return the margins of a winding, by the function of its kind of problem."""
        margins: Any = self.model.kind.margins
        return margins(result, self.limits)

    def at(self, u: Array) -> _Evaluation:
        """Return the winding at coordinates u, (fields,), computed if necessary.

        They are 0 and 1 at the ends of the ranges, and are limited to these.
        """
        values = tuple((self.low + np.clip(u, 0, 1) * (self.high - self.low)).tolist())
        if values in self.evaluations:
            return self.evaluations[values]
        if len(self.evaluations) >= self.max_evaluations:
            raise _Stop
        try:
            problem = self.model.variant(dict(zip(self.names, values, strict=True)))
            evaluation = self._evaluation(values, self.model.solve(problem, self._nearest(values)))
        except (InvalidProblem, NotConverged) as fault:
            self.failure = str(fault).partition("\n")[0]
            evaluation = _Evaluation(values, np.full(len(self.checked), FAILED))
        self.evaluations[values] = evaluation
        self.report(len(self.evaluations), self.max_evaluations)
        return evaluation

    @property
    def solved(self) -> list[_Evaluation]:
        """The windings that were solved."""
        return [case for case in self.evaluations.values() if case.result is not None]

    def _nearest(self, values: tuple[float, ...]) -> Result | None:
        """Return the result with the nearest values, relative to the ranges, as a warm start."""
        if not self.solved:
            return None
        distances = (np.array([case.values for case in self.solved]) - values) / (
            self.high - self.low
        )
        return self.solved[int(np.argmin(np.sum(distances**2, axis=1)))].result

    def _evaluation(self, values: tuple[float, ...], result: Result) -> _Evaluation:
        """Return a solved winding with its reserves and the value of the goal."""
        margins = self._margins(result)
        reserves = np.array([margins[name].reserve for name in self.checked])
        goal = float(value_of(result, self.goal)) if self.goal else float(reserves.min())
        return _Evaluation(values, reserves, goal, result, margins)

    # ---- searching -------------------------------------------------------------------------------

    def run(self) -> str:
        """Optimise; return the reason of the termination."""
        from scipy.optimize import Bounds, NonlinearConstraint, minimize

        n = len(self.names)
        start = (self.first - self.low) / (self.high - self.low)
        low, high = [0.0] * n, [1.0] * n
        try:
            first = self.at(start)
            if self.goal is None:  # t is the last variable, from -2 to 1
                smallest = np.clip(first.reserves.min(), -1, 1)
                start, low, high = np.append(start, smallest), [*low, -2.0], [*high, 1.0]
            end = minimize(
                self._objective,
                start,
                method="COBYLA",
                bounds=Bounds(low, high),
                constraints=NonlinearConstraint(self._constraints, TOLERANCE, np.inf),
                tol=LAST_STEP,
                options={"rhobeg": FIRST_STEP, "maxiter": 20 * self.max_evaluations},
            )
        except _Stop:
            return f"stopped after {self.max_evaluations} windings"
        except KeyboardInterrupt:
            return "interrupted"
        return "converged" if end.status == 0 else str(end.message).rstrip(".").lower()

    def _objective(self, v: Array) -> float:
        """Return the objective: minus the smallest reserve t = v[-1], or the scaled output.

        v are the coordinates u; with the smallest reserve as goal t follows them.
        """
        if self.goal is None:
            return -float(v[-1])
        goal = self.at(v).goal
        return self.sign * goal / self.scale if isfinite(goal) else FAILED_OBJECTIVE

    def _constraints(self, v: Array) -> Array:
        """Return the constraints at v, (margins,): the reserves, minus t if t is maximised.

        They must be >= 0; v as of :meth:`_objective`.
        """
        if self.goal is not None:
            return self.at(v).reserves
        # COBYLA's linear models need finite reserves; 2 is larger than t, at most 1
        return np.minimum(self.at(v[:-1]).reserves, 2.0) - v[-1]

    # ---- result ----------------------------------------------------------------------------------

    def result(self, ended: str) -> OptimisedSchedule:
        """Return the best of all computed windings.

        Parameters
        ----------
        ended : str
            Reason of the termination.
        """
        if not self.solved:
            raise NotConverged(f"no schedule in these ranges can be computed: {self.failure}")
        feasible = [case for case in self.solved if case.least >= 0]
        if feasible and self.goal is not None:
            best = min(feasible, key=lambda case: self.sign * case.goal)
        else:
            best = max(feasible or self.solved, key=lambda case: case.least)
        # margins up to this reserve are active: violated, nearly so, or near the smallest one
        nearest = max(best.least, 0.0) + BINDING
        reserves = zip(self.checked, best.reserves, strict=True)
        goal = "largest smallest reserve"
        if self.goal is not None:
            goal = f"{'most' if self.sign < 0 else 'least'} {self.goal}"
        every = list(self.evaluations.values())
        return OptimisedSchedule(
            names=self.names,
            start=self.initial,
            values=np.array(best.values),
            before=self.before,
            after=best.result,
            margins_before=self.margins_before,
            margins_after=best.margins,
            feasible=best.least >= 0,
            binding=tuple(name for name, reserve in reserves if reserve <= nearest),
            tried=np.array([case.values for case in every]),
            reserves=np.array([case.least for case in every]),
            goal=goal,
            goals=np.array([case.goal for case in every]),
            ended=ended,
            ranges=np.column_stack([self.low, self.high]),
            quantities=quantities_of(self.model, self.names),
        )
