"""Inverse problems: the value of a field for which an output reaches a target.

    output(problem with field = x) = target

:mod:`.root_search` finds all solutions on a scan of the range.  With the estimated discretisation
error e of the output, a value is uncertain by e / |d output / dx|.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import isfinite, nan
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import whole_number
from ..errors import InvalidProblem, NoSolution, NotConverged, warn
from ..problems.inputs import Inputs, read_number
from ..problems.messages import quote
from ..problems.paths import find_places, varied_value
from ..problems.permitted import SearchedWithin, ValuesWithin, extremes
from ..problems.problem import Problem
from ..quantities import Quantity, in_chosen_units
from ..results import Result
from .api import range_in_si
from .model import model_of, quantities_of, solver_options
from .observations import Observable
from .outcome import Outcome
from .progress import Progress, progress_reporter
from .root_search import DECADE, Interval, RootSearch, Sample
from .slopes import slopes as slopes_of

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["FindResult", "Solution", "find"]

Array = np.ndarray

# A search extends to so many times the usual changes of a finished roll: 200 K, beyond all
# temperatures of paper and film.  The permitted 1000 K bound numbers, not temperatures.  The same
# for the thickness of a profile: 20 %, where half to one and a half of the mean are permitted.
LARGEST_CHANGE = 5.0
POINTS = 17  # of the scan: a factor of 1.33 between neighbours over two decades


class Solution(NamedTuple):
    """A value of the field and the result for it."""

    value: float
    result: Any


@dataclass(frozen=True, eq=False, repr=False)
class FindResult(Outcome):
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
    unconfirmed : tuple of (value, reason)
        Solutions that are solved only from the result for a neighbouring value, and what the solver
        gives without it.
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
    unconfirmed: tuple[tuple[float, str], ...] = ()
    quantities: Mapping[str, Quantity] = field(default_factory=dict)

    @property
    def value(self) -> float:
        """The first, smallest value."""
        return self.solutions[0].value

    @property
    def result(self) -> Result:
        """The result for the first value."""
        return self.solutions[0].result

    @property
    def problem(self) -> Problem:
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

    def __repr__(self) -> str:
        values = ", ".join(self._text(self.name, value) for value, _ in self.solutions)
        return f"FindResult({self.name} = {values} for {self._target_text()})"

    def answer(self) -> list[str]:
        """Return a line for each solution, the first one first: value, uncertainty, output."""
        texts = []
        for k, (value, _) in enumerate(self.solutions):
            text = self.quantities[self.name].text(value, ".6g", error=self.uncertainties[k])
            reached = self._text(self.output, self.reached[k])
            texts.append(f"{self.name} = {text}: {self.output} = {reached}")
        return texts

    def remarks(self) -> list[str]:
        """Return remarks on number and uncertainty of the solutions, the scan and its failures."""
        texts = []
        if len(self.solutions) > 1:
            texts.append(
                f"{len(self.solutions)} values give {self._target_text()}; "
                "value, problem and result are those of the first"
            )
        if np.isfinite(self.uncertainties).any():
            texts.append("± is the estimated discretisation error of the output over the slope")
        texts.append(f"scanned: {self._range_text()}, {self.output} {self._reachable_text()}")
        texts += self._limit_texts()
        for low, _ in self.jumps:
            place = f"{self.name} = {self._text(self.name, low)}"
            texts.append(f"{self.output} jumps across the target at {place}")
        for value, reason in self.unconfirmed:
            place = f"{self.name} = {self._text(self.name, value)}"
            text = f"{place} is solved only from the result for a neighbouring value; without it"
            texts.append(f"{text}: {in_chosen_units(reason)}")
        return texts

    def _text(self, name: str, value: float) -> str:
        """Return a value of the field or of the output with its unit."""
        return self.quantities[name].text(value, ".6g")

    def _target_text(self) -> str:
        return f"{self.output} = {self._text(self.output, self.target)}"

    def _range_text(self) -> str:
        low, high = (self._text(self.name, end) for end in self.values[[0, -1]])
        return f"{self.name} from {low} to {high}"

    def _reachable_text(self) -> str:
        return " to ".join(self._text(self.output, end) for end in self.reachable)

    def _limit_texts(self) -> list[str]:
        """Return the limits of existence between neighbouring points, with the reasons."""
        texts, reasons = [], {value: in_chosen_units(text) for value, text in self.failures}
        points = list(zip(self.values.tolist(), np.isfinite(self.outputs), strict=True))
        for (low, low_is_solved), (high, high_is_solved) in pairwise(points):
            if low_is_solved and not high_is_solved:
                place = f"{self.name} = {self._text(self.name, low)}"
                texts.append(f"solved up to {place}; above it: {reasons[high]}")
            if high_is_solved and not low_is_solved:
                place = f"{self.name} = {self._text(self.name, high)}"
                texts.append(f"solved down to {place}; below it: {reasons[low]}")
        return texts

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

    def _record(self) -> dict[str, Any]:
        return {
            "field": self.name,
            "output": self.output,
            "target": self.target,
            "units": {name: quantity.unit for name, quantity in self.quantities.items()},
            "solutions": self.to_dataframe().to_dict(orient="records"),
            "scan": np.column_stack([self.values, self.outputs]),  # a row for each point
            "failures": self.failures,
            "jumps": self.jumps,
            "unconfirmed": self.unconfirmed,
        }


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
        approaches the target; for changes of temperature and moisture to five times the usual
        range, 200 K and 0.25; a thickness of a profile is searched within 4 %, at most 20 %.
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
    model = model_of(problem, output, tie, solver_options(nodes, rtol, options))
    model.check_varied([name])
    quantities = quantities_of(model, (name, output))
    base = varied_value(problem, name)
    # with the width of the web a total force is one per width
    aim = read_number(value, quantities[output], output, Inputs.of(problem))
    if not isfinite(aim):
        raise InvalidProblem.at(output, f"the target {quote(aim)} is not a finite number")
    count = whole_number("points", points, 3, 1000)
    interval = _interval(problem, name, base, quantities[name], between)
    model.check_effects({name: (interval.low, interval.high)})
    with progress_reporter(progress, "finding") as report:
        search = RootSearch(
            model, name, output, aim, interval, lambda done: report(done, max(done, count))
        )
        search.scan(count, base)
        roots = search.solutions()
        if not roots:
            search.refine_range()
            roots = search.solutions()
        differences = [(sample.value, search.difference(sample)) for sample in roots]
    slopes = np.array([_slope(search, sample) for sample in roots])
    errors = np.array([search.error(sample) for sample in roots])
    with np.errstate(divide="ignore", invalid="ignore"):
        uncertainties = np.where(slopes == 0, nan, errors / np.abs(slopes))
    found = FindResult(
        name=name,
        output=output,
        target=aim,
        solutions=tuple(Solution(sample.value, sample.result) for sample in roots),
        reached=np.array([sample.output for sample in roots]),
        errors=errors,
        uncertainties=uncertainties,
        slopes=slopes,
        values=np.array([sample.value for sample in search.samples]),
        outputs=np.array([sample.output for sample in search.samples]),
        failures=tuple((s.value, s.failure) for s in search.samples if s.failure),
        jumps=tuple(search.jumps),
        unconfirmed=tuple((value, text) for value, text in differences if text),
        quantities=quantities,
    )
    if not roots:
        raise _no_solution(found, search.not_converged)
    warn(found.result.warnings)
    return found


# ---- input --------------------------------------------------------------------------------------


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
    """Return the range of the scan.

    Parameters
    ----------
    problem : Problem
    name : str
        The field.
    base : float or None
        Its present value, SI; None if it is not set.
    quantity : Quantity
        Of the field.
    between : (low, high) or None
        The requested range; by default the usual one within the permitted one.
    """
    info = find_places(problem, name)[0].field  # definition of the field, with its bounds
    lowest, highest = extremes(info)
    if between is not None:
        low, high = range_in_si(problem, name, between, f"between: {name}")
        return Interval(low, high, (lowest, highest), may_grow=False)
    near = next((part for part in info.metadata if isinstance(part, SearchedWithin)), None)
    if near is not None and base:
        change = near.share * abs(base)
        lowest = max(lowest, base - LARGEST_CHANGE * change)
        highest = min(highest, base + LARGEST_CHANGE * change)
        low, high = max(base - change, lowest), min(base + change, highest)
        return Interval(low, high, (lowest, highest), may_grow=True)
    if quantity.typical and any(isinstance(part, ValuesWithin) for part in info.metadata):
        largest = max(LARGEST_CHANGE * max(map(abs, quantity.typical)), 2 * abs(base or 0.0))
        lowest, highest = max(lowest, -largest), min(highest, largest)
    low, high = _usual_range(base, (lowest, highest), quantity.typical)
    low, high = max(low, lowest), min(high, highest)
    if not (isfinite(low) and isfinite(high) and low < high):
        text = f"{quote(base)} has no scale to search around; give between=(low, high)"
        raise InvalidProblem.at(name, text)
    return Interval(low, high, (lowest, highest), may_grow=True)


def _usual_range(
    base: float | None, permitted: tuple[float, float], typical: tuple[float, float] | None
) -> tuple[float, float]:
    """Return the range around the present value together with the typical one.

    Parameters
    ----------
    base : float or None
        Present value.
    permitted : (low, high)
        Is the range if the present value is 0 or None, and no range is typical.
    typical : (low, high) or None
    """
    ends = list(typical or ())
    if base is not None and base > 0 and permitted[0] >= 0:  # a decade on both sides
        ends += [base / DECADE, base * DECADE]
    elif base and not typical:  # of either sign, whose magnitude is the only scale that is known
        ends += [base - DECADE * abs(base), base + DECADE * abs(base)]
    elif base:  # of either sign: the typical range may have to be extended to it
        ends += [0.0, 2 * base]
    elif not typical:
        ends += permitted
    return min(ends), max(ends)


# ---- output -------------------------------------------------------------------------------------


def _slope(search: RootSearch, sample: Sample) -> float:
    """Return d output / d field; nan if it cannot be solved on either side."""
    # for the step of a difference; a value of 0 has no scale itself
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


def _no_solution(found: FindResult, not_converged: bool) -> NoSolution | NotConverged:
    """Return the error that explains why there is no solution.

    ``not_converged`` states whether the solver did not converge at a point of the scan.
    """
    points = {
        "values": found.values.tolist(),
        "outputs": found.outputs.tolist(),
        "failures": found.failures,
    }
    if len(found.failures) == len(found.values):
        reason = in_chosen_units(found.failures[0][1])
        text = f"no point of {found._range_text()} was solved; the first reason: {reason}"
        if not_converged:
            return NotConverged(text)
        return NoSolution([(found.name, text)], reachable=None, **points)
    aim = found._text(found.output, found.target)
    text = f"{aim} is not reached by {found._range_text()}, which gives {found._reachable_text()}"
    if found.jumps:
        place = found._text(found.name, found.jumps[0][0])
        text += f"; the output jumps across the target at {found.name} = {place}"
    text = "; ".join([text, *found._limit_texts()])
    return NoSolution([(found.output, text)], reachable=found.reachable, **points)
