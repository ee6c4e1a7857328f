"""Inverse problems: the value of a field for which an output reaches a target.

    output(problem with field = x) = target

:mod:`.root_search` finds all solutions on a scan of the range.  With the estimated discretisation
error e of the output, a value is uncertain by e / |d output / dx|.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite, nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import whole_number
from ..errors import InvalidProblem, NoSolution, NotConverged, warn
from ..io.json_texts import json_text
from ..problems.inputs import conversion_context, convert_number
from ..problems.messages import quote
from ..problems.permitted import admissible, bounds
from ..problems.problem import Problem
from ..problems.units import parse
from ..quantities import Quantity, in_chosen_units
from ..quantities import find as find_places
from ..results import Presented, ReadOnly
from .kind_model import get_field, model_of
from .measurements import Observable
from .model import quantities_of
from .progress import Progress, progress_reporter
from .root_search import DECADE, Interval, RootSearch, Sample, error_of
from .slopes import slopes as slopes_of

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["FindResult", "Solution", "find", "remarks"]

Array = np.ndarray

POINTS = 17  # of the scan: a factor of 1.33 between neighbours over two decades


class Solution(NamedTuple):
    """A value of the field and the result for it."""

    value: float
    result: Any


@dataclass(frozen=True, eq=False, repr=False)
class FindResult(Presented, ReadOnly):
    """The values of a field for which an output has the target value.

    Attributes
    ----------
    name, output : str
        The field and the output.
    target : float
        SI units.
    solutions : tuple of (value, result)
        In ascending order of the value, SI units.
    reached, errors : (k,) arrays
        The output at the solutions, and its estimated discretisation error.
    uncertainties : (k,) array
        The estimated discretisation error of the output over the magnitude of the slope, in units
        of the field; nan where the error is not known.
    slopes : (k,) array
        d output / d field at the solutions.
    values, outputs : (n,) arrays
        All points that were evaluated, in ascending order; nan where no solution exists.
    failures : tuple of (value, reason)
        The points that were not solved, e.g. because no steady state exists.
    jumps : tuple of (low, high)
        Intervals in which the output jumps across the target without taking its value.
    quantities : mapping of str to Quantity
        Of the field and the output.

    Examples
    --------
    >>> import woundon as wo
    >>> found = wo.find(wo.RollerProblem.example(), "load", nip_width="1 mm", nodes=33)
    >>> len(found.solutions), round(found.problem.load / 1e3)  # kN/m
    (1, 178)
    """

    name: str
    output: str
    target: float
    solutions: tuple[Solution, ...]
    reached: Array
    errors: Array
    uncertainties: Array
    slopes: Array
    values: Array
    outputs: Array
    failures: tuple[tuple[float, str], ...] = ()
    jumps: tuple[tuple[float, float], ...] = ()
    quantities: Mapping[str, Quantity] = field(default_factory=dict)

    @property
    def value(self) -> float:
        """The first, smallest value."""
        return self.solutions[0].value

    @property
    def result(self) -> Any:
        """The result for the first value."""
        return self.solutions[0].result

    @property
    def problem(self) -> Any:
        """The problem with the first value."""
        return self.result.problem

    @property
    def uncertainty(self) -> float:
        """The uncertainty of the first value from the discretisation error."""
        return float(self.uncertainties[0])

    @property
    def reachable(self) -> tuple[float, float]:
        """Smallest and largest output of the points evaluated."""
        return float(np.nanmin(self.outputs)), float(np.nanmax(self.outputs))

    def lines(self) -> list[str]:
        """Return the solutions as lines of text, the first one first."""
        return [_answer(self, k) for k in range(len(self.solutions))] + remarks(self)

    def __repr__(self) -> str:
        outcome = ", ".join(_text(self, self.name, value) for value, _ in self.solutions)
        return f"FindResult({self.name} = {outcome} for {_target_text(self)})"

    def _repr_html_(self) -> str:
        return self._html_of_table(_answer(self, 0), self.to_dataframe(), remarks(self))

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each solution: value, uncertainty, output, its error, slope [SI]."""
        import pandas as pd

        columns = {
            self.name: [value for value, _ in self.solutions],
            "uncertainty": self.uncertainties,
            self.output: self.reached,
            f"errors.{self.output}": self.errors,
            "slope": self.slopes,
        }
        return pd.DataFrame(columns)

    def to_json(self) -> str:
        """Return solutions, scan and failures as JSON, SI units."""
        table = {
            "field": self.name,
            "output": self.output,
            "target": self.target,
            "units": {name: quantity.unit for name, quantity in self.quantities.items()},
            "solutions": self.to_dataframe().to_dict(orient="records"),
            "scan": np.column_stack([self.values, self.outputs]),
            "failures": self.failures,
            "jumps": self.jumps,
        }
        return json_text(table)

    def plot(self, path: Any = None, ax: Any = None) -> Any:
        """Draw the output over the field with the target and the solutions.

        Parameters
        ----------
        path, ax
            As of :func:`woundon.plot`.

        Returns
        -------
        matplotlib.figure.Figure, or ``ax`` where it is given
        """
        return self._figure(path, ax)


def find(
    problem: Problem,
    name: str,
    /,
    *,
    between: Sequence[float | str] | None = None,
    points: int = POINTS,
    tie: Mapping[str, str] | None = None,
    progress: bool | Progress = False,
    nodes: int | None = None,
    rtol: float | None = None,
    options: Mapping[str, Any] | None = None,
    **target: float | str,
) -> FindResult:
    """Find the value of a field for which an output reaches a target.

    Parameters
    ----------
    problem : Problem
        Of any kind.
    name : str
        Dotted name of the field: ``"nip_load"``, ``"roll.material.shear"``.
    between : (low, high), optional
        The range in which solutions are searched; SI or texts with units.  By default a decade on
        both sides of the present value, together with the range that is usual in practice; if it
        contains no solution, it is extended as far as the field permits while the output
        approaches the target.
    points : int
        Points of the scan, 3 to 1000.  Two solutions between neighbouring points are found only
        if the output shows a minimum or a maximum there.
    tie : mapping of str to str
        Field -> field that it follows, e.g. ``{"web.material": "roll.material"}``.
    progress : bool or callable
        Show the number of solves, or call with (done, expected).
    nodes, rtol, options
        Of the kind's solver, as of :func:`woundon.sweep`.
    **target : float or str
        The output and its target: ``wound_on_tension=300.0`` or ``wound_on_tension="300 N/m"``.

    Returns
    -------
    FindResult
        All solutions in ascending order; ``value``, ``problem`` and ``result`` are those of the
        first one.

    Raises
    ------
    NoSolution
        If no value in the range gives the target; carries the reachable range of the output.
    InvalidProblem
        For a name or a range that is not admissible.
    NotConverged
        If no point of the scan was solved, and the solver did not converge at one of them.

    Examples
    --------
    >>> import woundon as wo
    >>> pair = wo.RollerProblem.example()
    >>> found = wo.find(pair, "load", nip_width="4 mm")
    >>> round(found.result.nip_width * 1e3, 4)  # mm
    4.0
    """
    output, value = _one_target(target)
    settings = {"nodes": nodes, "rtol": rtol, **(options or {})}
    model = model_of(problem, output, tie, settings)
    model.check_varied([name])
    quantities = quantities_of(model, (name, output))
    base = get_field(problem, name)
    if name not in quantities or not isinstance(base, float | None):
        raise InvalidProblem.at(name, f"{quote(base)} is not a number, so it cannot be found")
    aim = _target_in_si(value, quantities[output], output, problem)
    if not isfinite(aim):
        raise InvalidProblem.at(output, f"the target {quote(aim)} is not a finite number")
    count = whole_number("points", points, 3, 1000)
    interval = _interval(problem, name, base, quantities[name], between)
    with progress_reporter(progress, "finding") as report:
        search = RootSearch(
            model, name, output, aim, interval, lambda done: report(done, max(done, count))
        )
        search.scan(count, base)
        roots = search.solutions()
        if not roots:
            search.refine_range()
            roots = search.solutions()
    slopes = np.array([_slope(search, sample) for sample in roots])
    scan = np.array([[sample.value, sample.output] for sample in search.samples])
    failures = tuple((s.value, s.failure) for s in search.samples if s.failure)
    if not roots:
        raise _no_solution(search, quantities, scan, failures)
    errors = np.array([error_of(sample.result, output) for sample in roots])
    with np.errstate(divide="ignore", invalid="ignore"):
        uncertainties = np.where(slopes == 0, nan, errors / np.abs(slopes))
    warn(roots[0].result.warnings)
    return FindResult(
        name=name,
        output=output,
        target=aim,
        solutions=tuple(Solution(sample.value, sample.result) for sample in roots),
        reached=np.array([sample.output for sample in roots]),
        errors=errors,
        uncertainties=uncertainties,
        slopes=slopes,
        values=scan[:, 0].copy(),
        outputs=scan[:, 1].copy(),
        failures=failures,
        jumps=tuple(search.jumps),
        quantities=quantities,
    )


# ---- input --------------------------------------------------------------------------------------


def _target_in_si(value: float | str, quantity: Quantity, output: str, problem: Problem) -> float:
    """Return the target in SI; with the width of the web a total force is one per width."""
    if isinstance(value, str):
        return convert_number(value, quantity, output, conversion_context(problem))
    return parse(value, quantity.unit, output)


def _one_target(target: Mapping[str, float | str]) -> tuple[str, float | str]:
    """Return the output and its target."""
    if len(target) != 1:
        names = ", ".join(target) or "none"
        text = f"{names} given; must be one output, e.g. wound_on_tension=300.0"
        raise InvalidProblem.at("target", text)
    ((output, value),) = target.items()
    return output, value


def _interval(
    problem: Problem, name: str, base: float | None, quantity: Quantity, between: Any
) -> Interval:
    """Return the range of the scan."""
    info = find_places(problem, name)[0].field
    limits = bounds(info)
    permitted = (
        max((bound for sign, bound in limits if sign[0] == ">"), default=-inf),
        min((bound for sign, bound in limits if sign[0] == "<"), default=inf),
    )
    if between is not None:
        low, high = _ends(between, quantity, name)
        for end in (low, high):
            if not _admits(limits, end):
                text = f"{quote(end)} is out of range; must be {admissible(info)}"
                raise InvalidProblem.at(f"between: {name}", text)
        return Interval(low, high, permitted, may_grow=False)
    low, high = _usual_range(base, permitted, quantity.typical)
    low, high = max(low, permitted[0]), min(high, permitted[1])
    if not (isfinite(low) and isfinite(high) and low < high):
        text = f"{quote(base)} has no scale to search around; give between=(low, high)"
        raise InvalidProblem.at(name, text)
    return Interval(low, high, permitted, may_grow=True)


def _ends(between: Any, quantity: Quantity, name: str) -> tuple[float, float]:
    """Return the given range in SI; reject one that is not a pair low < high."""
    pair = list(between) if isinstance(between, (list, tuple, np.ndarray)) else []
    if len(pair) != 2:
        raise InvalidProblem.at("between", f"{quote(between)} is not a range; write (low, high)")
    numbers = [end.item() if isinstance(end, np.generic) else end for end in pair]
    low, high = (parse(end, quantity.unit, f"between: {name}") for end in numbers)
    if not (isfinite(low) and isfinite(high) and low < high):
        raise InvalidProblem.at("between", f"{quote(between)} is not a range: must be low < high")
    return low, high


def _admits(limits: Sequence[tuple[str, float]], value: float) -> bool:
    tests = {">": float.__gt__, ">=": float.__ge__, "<": float.__lt__, "<=": float.__le__}
    return all(tests[sign](value, float(bound)) for sign, bound in limits)


def _usual_range(
    base: float | None, permitted: tuple[float, float], typical: tuple[float, float] | None
) -> tuple[float, float]:
    """Return the range around the present value together with the typical one."""
    ends = list(typical or ())
    if base is not None and base > 0 and permitted[0] >= 0:
        ends += [base / DECADE, base * DECADE]
    elif base and not typical:
        ends += [base - DECADE * abs(base), base + DECADE * abs(base)]
    elif base:
        ends += [0.0, 2 * base]
    elif not typical:
        ends += permitted
    return min(ends), max(ends)


# ---- output -------------------------------------------------------------------------------------


def _slope(search: RootSearch, sample: Sample) -> float:
    """Return d output / d field; nan if it cannot be solved on either side."""
    scale = abs(sample.value) or search.interval.high - search.interval.low
    slopes = slopes_of(
        search.model,
        sample.result,
        [Observable(search.output)],
        [search.name],
        {search.name: sample.value},
        scales=[scale],
        nan_if_unsolved=True,
    )
    return float(slopes[0, 0])


def _no_solution(
    search: RootSearch,
    quantities: Mapping[str, Quantity],
    scan: Array,
    failures: tuple[tuple[float, str], ...],
) -> Exception:
    """Return the error that explains why there is no solution."""
    field_of, output_of = quantities[search.name], quantities[search.output]
    values, outputs = scan[:, 0].tolist(), scan[:, 1].tolist()
    low, high = (field_of.text(end, ".6g") for end in scan[[0, -1], 0])
    where = f"{search.name} from {low} to {high}"
    reasons = f"; the first reason: {in_chosen_units(failures[0][1])}" if failures else ""
    if len(failures) == len(scan):
        text = f"no point of {where} was solved{reasons}"
        if search.not_converged:
            return NotConverged(text)
        return NoSolution([(search.name, text)], None, values, outputs, failures)
    reachable = (float(np.nanmin(scan[:, 1])), float(np.nanmax(scan[:, 1])))
    ends = " to ".join(output_of.text(end, ".6g") for end in reachable)
    text = f"{output_of.text(search.target, '.6g')} is not reached by {where}, which gives {ends}"
    if search.jumps:
        place = field_of.text(search.jumps[0][0], ".6g")
        text += f"; the output jumps across the target at {search.name} = {place}"
    text = "; ".join([text, *_limit_texts(search.name, field_of, scan, failures)])
    return NoSolution([(search.output, text)], reachable, values, outputs, failures)


def _limit_texts(
    name: str, quantity: Quantity, scan: Array, failures: tuple[tuple[float, str], ...]
) -> list[str]:
    """Return the limits of existence between neighbouring points, with the reasons."""
    texts, reasons = [], {value: in_chosen_units(text) for value, text in failures}
    for (a, ya), (b, yb) in zip(scan.tolist(), scan[1:].tolist(), strict=False):
        if isfinite(ya) and not isfinite(yb):
            texts.append(f"solved up to {name} = {quantity.text(a, '.6g')}; above it: {reasons[b]}")
        if isfinite(yb) and not isfinite(ya):
            text = f"solved down to {name} = {quantity.text(b, '.6g')}; below it: {reasons[a]}"
            texts.append(text)
    return texts


def _text(outcome: FindResult, name: str, value: float, form: str = ".6g") -> str:
    """Return a value of the field or of the output with its unit."""
    return outcome.quantities[name].text(value, form)


def _target_text(outcome: FindResult) -> str:
    """Return the output with its target value."""
    return f"{outcome.output} = {_text(outcome, outcome.output, outcome.target)}"


def _answer(outcome: FindResult, k: int) -> str:
    """Return a solution as a line: value, uncertainty, output."""
    value = outcome.solutions[k].value
    spread = outcome.uncertainties[k]
    known = f" +- {_text(outcome, outcome.name, spread, '.2g')}" if isfinite(spread) else ""
    reached = _text(outcome, outcome.output, outcome.reached[k])
    text = _text(outcome, outcome.name, value)
    return f"{outcome.name} = {text}{known}: {outcome.output} = {reached}"


def remarks(outcome: FindResult) -> list[str]:
    """Return remarks on the solutions: their number, the uncertainty, scan, failures and jumps."""
    texts = []
    if len(outcome.solutions) > 1:
        texts.append(
            f"{len(outcome.solutions)} values give {_target_text(outcome)}; "
            "value, problem and result are those of the first"
        )
    if np.isfinite(outcome.uncertainties).any():
        texts.append("+- is the estimated discretisation error of the output over the slope")
    low, high = (_text(outcome, outcome.name, end) for end in outcome.values[[0, -1]])
    ends = " to ".join(_text(outcome, outcome.output, end) for end in outcome.reachable)
    texts.append(f"scanned: {outcome.name} from {low} to {high}, {outcome.output} {ends}")
    scan = np.column_stack([outcome.values, outcome.outputs])
    quantity = outcome.quantities[outcome.name]
    texts += _limit_texts(outcome.name, quantity, scan, outcome.failures)
    for jump in outcome.jumps:
        texts.append(
            f"{outcome.output} jumps across the target at {outcome.name} = "
            f"{_text(outcome, outcome.name, jump[0])}"
        )
    return texts
