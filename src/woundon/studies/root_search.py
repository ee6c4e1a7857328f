"""Scan, brackets and Brent's method for the values of a field at which an output has a target.

    f(x) = output(problem with field = x) - target = 0

1. Scan: f is evaluated at points of a range, from the present value of the field outwards, each
   from the initial guess of its nearest neighbour.
2. Limits of existence: between a point x0 that is solved and one without a solution the range is
   bisected.  If the output varies towards the limit at most as a square root, the change D between
   the neighbours x1 and x0 bounds the change beyond x0 within the unsolved gap g,

       |D| / (sqrt(1 + |x0 - x1|/g) - 1).

   The bisection ends when it is smaller than |f|, and than 0.05 % of the output or the target if no
   solution is bracketed.  Then the range up to the limit is scanned with as many points as the
   whole range.
3. Brackets: neighbouring points between which f changes its sign; a local minimum of |f| that may
   reach zero is searched by Brent's minimisation (scipy.optimize.minimize_scalar).
4. Each bracket is solved by Brent's method (scipy.optimize.brentq) on one mesh, on which the output
   is a continuous function of the field.
5. Without a solution, the smallest and the largest output are computed by the same minimisation.
6. Every solution is solved again without the initial guess of a neighbour.

Reference: R. P. Brent, Algorithms for Minimization without Derivatives, Prentice-Hall 1973, ch. 4.
"""

from __future__ import annotations

from bisect import insort
from collections.abc import Callable
from contextlib import suppress
from itertools import groupby, pairwise
from math import isfinite, nan, sqrt
from typing import Any, NamedTuple

import numpy as np

from ..arguments import keywords_of
from ..errors import InvalidProblem, NotConverged
from .model import KindModel
from .slopes import on_mesh_of

__all__ = ["DECADE", "Interval", "RootSearch", "Sample"]

Array = np.ndarray

DECADE = 10.0  # ratio of the ends of a range from which its points have a constant ratio
EXTENSIONS = 10  # doublings of the range on a side where the output still approaches the target
# Bisections towards a limit of existence: at least so many, because an output may vary more steeply
# next to it than between the points of the scan; and at most, to 1e-9 of their distance.
LEAST_BISECTIONS, MOST_BISECTIONS = 5, 30
VALIDITY_BISECTIONS = 40  # of the range of valid problems, without solving them
LIMIT_ERROR = 5e-4  # of an output at a limit of existence, relative to its scale: half of 0.1 %
# At a minimum: evaluations, 1e-3 of the interval by golden section; and its width, at which a
# parabola changes by 1e-8 of its change over the interval.
MINIMISATIONS, MINIMUM_WIDTH = 16, 1e-4
INSIDE = 1e-2  # of the distance of two samples, where an extreme value next to an end shows
# |f| relative to the target at which Brent's method stops: ten times the residual of a solution,
# 1e-8, and below every discretisation error
CLOSE = 1e-7
WIDTH = 1e-6  # of a bracket, at which Brent's method stops too
# Share of the change of an output within a bracket up to which a discontinuity counts as one of the
# discretisation, e.g. of an adaptive step, where its error is not known.
ROUGHNESS = 0.05
SEARCHES = 4  # bisections of a bracket in which a point cannot be solved
# Relative difference of two solutions of one problem where the discretisation error is not known:
# the default tolerance of the solvers.
SAME = 1e-3


class Interval(NamedTuple):
    """The range of a field that is scanned, and the one that the field permits.

    Attributes
    ----------
    low, high : float
        Ends of the scan, SI.
    permitted : (low, high)
        Bounds of the field; they may be infinite.
    may_grow : bool
        Whether the search may leave the range of the scan.
    """

    low: float
    high: float
    permitted: tuple[float, float]
    may_grow: bool

    @property
    def geometric(self) -> bool:
        """True if the points have a constant ratio instead of a constant distance."""
        return self.low > 0 and self.high / self.low >= DECADE

    def points(self, count: int) -> Array:
        """Return points that include both ends."""
        space = np.geomspace if self.geometric else np.linspace
        inner = space(self.low, self.high, count)[1:-1]
        return np.array([self.low, *inner.tolist(), self.high])  # the ends without rounding

    def middle(self, a: float, b: float) -> float:
        """Return the point half-way between two others."""
        return sqrt(a * b) if self.geometric else (a + b) / 2

    def beyond(self, edge: float, outward: int) -> float:
        """Return the next point outside the range, within the permitted range.

        ``edge`` is the outermost point so far, and ``outward`` -1 for the lower side, 1 for the
        upper one.
        """
        if self.geometric:
            point = edge * 2.0**outward
        else:  # the distance from the other end of the range is doubled
            point = edge + outward * max(edge - self.low, self.high - edge)
        return min(max(point, self.permitted[0]), self.permitted[1])


class Sample(NamedTuple):
    """One evaluation: value of the field, output [SI], result.

    Without a solution the result is None, and ``failure`` the reason.  ``is_started`` states that a
    neighbour supplied the initial guess.
    """

    value: float
    output: float
    result: Any
    failure: str = ""
    is_started: bool = False

    @property
    def is_solved(self) -> bool:
        """True if the problem has a solution."""
        return self.result is not None


class _InterruptedError(Exception):
    """An iteration of SciPy met a point without a solution, or a change of sign."""


class RootSearch:
    """The samples of f, in ascending order of the value.

    Parameters
    ----------
    model : KindModel
    name, output : str
        The field, and the output that has the target.
    target : float
    interval : Interval
    report : callable
        Is called with the number of samples.
    """

    def __init__(
        self,
        model: KindModel,
        name: str,
        output: str,
        target: float,
        interval: Interval,
        report: Callable[[int], None],
    ) -> None:
        self.model, self.name, self.output, self.target = model, name, output, target
        self.interval, self.report = interval, report
        self.samples: list[Sample] = []
        self.jumps: list[tuple[float, float]] = []  # ends of intervals across which f jumps
        self.not_converged = False

    def f(self, sample: Sample) -> float:
        """Return output - target."""
        return sample.output - self.target

    @property
    def scale(self) -> float:
        """The magnitude of the target; if it is 0, the largest one of the outputs."""
        return abs(self.target) or max(abs(s.output) for s in self.solved)

    @property
    def solved(self) -> list[Sample]:
        """The samples that have a solution."""
        return [sample for sample in self.samples if sample.is_solved]

    def is_root(self, sample: Sample) -> bool:
        """True if a sample has the target value to the tolerance of the solver."""
        return abs(self.f(sample)) <= CLOSE * self.scale

    def error(self, sample: Sample) -> float:
        """Return the estimated discretisation error of the output; nan where it is not known."""
        return float(sample.result.errors.get(self.output, nan))

    def evaluate(self, value: float, model: KindModel | None = None) -> Sample:
        """Return the sample at a value, solved from the nearest neighbour that is solved."""
        nearest = min(self.solved, key=lambda s: abs(s.value - value), default=None)
        try:
            start = nearest.result if nearest else None
            answer = (model or self.model).run({self.name: value}, start)
            output = answer.values[0]
            reason = "" if isfinite(output) else f"{self.output} is {output:g}"
            state = None if reason else answer.state
            sample = Sample(value, output, state, reason, start is not None)
        except InvalidProblem as fault:
            sample = Sample(value, nan, None, str(fault).replace("\n", "; "))
        except NotConverged as fault:
            self.not_converged = True
            sample = Sample(value, nan, None, f"not converged: {fault}")
        self.report(len(self.samples) + 1)
        # a sample on another mesh replaces the one at the same value
        self.samples = [other for other in self.samples if other.value != value]
        insort(self.samples, sample, key=lambda s: s.value)
        return sample

    # ---- scan -----------------------------------------------------------------------------------

    def scan(self, count: int, base: float | None) -> None:
        """Evaluate the points of the range, and points next to it if needed.

        Parameters
        ----------
        count : int
            Number of points.
        base : float or None
            Present value of the field, near which the scan starts; without it at the low end.
        """
        start = self.interval.low if base is None else base
        for value in sorted(self.interval.points(count).tolist(), key=lambda x: abs(x - start)):
            self.evaluate(value)
        # the solvable values around the present one may all lie between two points
        around = [pair for pair in pairwise(self.samples) if pair[0].value < start < pair[1].value]
        if any(not sample.is_solved for pair in around for sample in pair):
            self.evaluate(start)
        if self.interval.may_grow and not self._brackets():
            for outward in (-1, 1):
                self._extend(outward)
        for solved, failed in self._limits():
            self._approach_limit(solved, failed)
        for stretch in self._stretches():
            self._scan_sparse(stretch, count)
        self._search_minima()

    def _brackets(self) -> list[tuple[Sample, Sample]]:
        """Return neighbouring samples between which f changes its sign, or is zero."""
        return [
            (a, b)
            for a, b in pairwise(self.samples)
            if a.is_solved and b.is_solved and self.f(a) * self.f(b) <= 0
        ]

    def _extend(self, outward: int) -> None:
        """Double the range on one side while the output approaches the target."""
        for _ in range(EXTENSIONS):
            # the two outermost samples
            edge, inner = self.samples[:2] if outward < 0 else self.samples[:-3:-1]
            if not (edge.is_solved and inner.is_solved) or self._brackets():
                return
            value = self.interval.beyond(edge.value, outward)
            if value == edge.value or abs(self.f(edge)) >= abs(self.f(inner)):
                return
            self.evaluate(value)

    def _stretches(self) -> list[list[Sample]]:
        """Return the samples between two limits of existence each."""
        groups = groupby(self.samples, key=lambda sample: sample.is_solved)
        return [list(group) for is_solved, group in groups if is_solved]

    def _scan_sparse(self, stretch: list[Sample], count: int) -> None:
        """Evaluate points where samples are sparse relative to the range that they cover."""
        known = np.array([sample.value for sample in stretch])
        if known.size > 1:
            points = self.interval._replace(low=known[0], high=known[-1]).points(count)
            # inner points, each with its distance from the point before
            for value, spacing in zip(points[1:-1], np.diff(points[:-1]), strict=True):
                if np.abs(known - value).min() > spacing:
                    self.evaluate(float(value))

    # ---- limits of existence --------------------------------------------------------------------

    def _limits(self) -> list[tuple[Sample, Sample]]:
        """Return the neighbours (solved, failed) at the limits of existence, in ascending order."""
        return [
            (a, b) if a.is_solved else (b, a)
            for a, b in pairwise(self.samples)
            if a.is_solved != b.is_solved
        ]

    def _approach_limit(self, solved: Sample, failed: Sample) -> None:
        """Bisect between a solved and a failed point until the limit cannot hide the target.

        That is, until the output between them is known well enough (step 2 of the module).
        """
        valid = self._last_valid(solved.value, failed.value)
        if valid not in (solved.value, failed.value):
            failed = self.evaluate(valid)
            if failed.is_solved:
                return
        inner = self._next_to(solved, failed)
        for bisections in range(MOST_BISECTIONS):
            if inner is not None and self.f(inner) * self.f(solved) <= 0:
                return
            if bisections >= LEAST_BISECTIONS and self._is_close(inner, solved, failed):
                return
            middle = self.evaluate(self.interval.middle(solved.value, failed.value))
            if not middle.is_solved:
                failed = middle
            else:
                inner, solved = solved, middle

    def _is_close(self, inner: Sample | None, solved: Sample, failed: Sample) -> bool:
        """Return True if the output between a solved and a failed point is known.

        ``inner`` is the solved neighbour of ``solved`` on the other side; the bound of the change
        is that of step 2 of the module.
        """
        if inner is None:
            return False
        gap = abs(failed.value - solved.value)
        ratio = abs(solved.value - inner.value) / gap
        change = abs(solved.output - inner.output) / (sqrt(1 + ratio) - 1)
        accepted = abs(self.f(solved))
        if not self._brackets():
            accepted = min(accepted, LIMIT_ERROR * max(self.scale, abs(solved.output)))
        return change <= accepted

    def _last_valid(self, solved: float, failed: float) -> float:
        """Return the valid value next to the limit of validity, without solving any problem."""
        if self.model.admits({self.name: failed}):
            return failed
        for _ in range(VALIDITY_BISECTIONS):
            middle = self.interval.middle(solved, failed)
            if self.model.admits({self.name: middle}):
                solved = middle
            else:
                failed = middle
        return solved

    def _next_to(self, solved: Sample, failed: Sample) -> Sample | None:
        """Return the solved neighbour on the other side of a sample."""
        k = self.samples.index(solved) + (1 if solved.value > failed.value else -1)
        adjacent = self.samples[k] if 0 <= k < len(self.samples) else None
        return adjacent if adjacent is not None and adjacent.is_solved else None

    # ---- extreme values -------------------------------------------------------------------------

    def _search_minima(self) -> None:
        """Search for a change of sign at local minima of |f| that may reach zero."""
        for a, b, c in self._solved_triples():
            sizes = [abs(self.f(sample)) for sample in (a, b, c)]
            one_sign = len({np.sign(self.f(sample)) for sample in (a, b, c)}) == 1
            # between the points |f| falls by at most the larger rise next to the middle one
            if one_sign and sizes[1] <= min(sizes) and sizes[1] <= max(sizes) - sizes[1]:
                self._minimise(a, b, c, np.sign(self.f(b)))

    def refine_range(self) -> None:
        """Compute the smallest and the largest output, where they lie between the points."""
        for sign in (1, -1):  # minimum of the output, then of its negative
            self._look_inside(sign)
            lowest = min((sign * s.output for s in self.solved), default=nan)
            for a, b, c in self._solved_triples():
                if sign * b.output == lowest < max(sign * a.output, sign * c.output):
                    self._minimise(a, b, c, sign)

    def _look_inside(self, sign: int) -> None:
        """Evaluate a point next to an extreme value at an end: the extreme one may be inside.

        ``sign`` is 1 for the smallest output, -1 for the largest one.
        """
        for stretch in self._stretches():
            outputs = [sign * sample.output for sample in stretch]
            for end, adjacent in ((0, 1), (-1, -2)):  # the first two and the last two samples
                if len(stretch) > 1 and outputs[end] == min(sign * s.output for s in self.solved):
                    x = stretch[end].value
                    self.evaluate(x + INSIDE * (stretch[adjacent].value - x))

    def _solved_triples(self) -> list[tuple[Sample, Sample, Sample]]:
        """Return three neighbouring samples each, all of which are solved."""
        triples = zip(self.samples, self.samples[1:], self.samples[2:], strict=False)
        return [triple for triple in triples if all(s.is_solved for s in triple)]

    def _minimise(self, a: Sample, b: Sample, c: Sample, sign: float) -> None:
        """Minimise the output times a sign between a and c, whose smallest known one is at b.

        Stop where f changes its sign, a bracket of a solution, or is not known.
        """
        from scipy.optimize import minimize_scalar

        def height(value: float) -> float:
            """Return the output times the sign; interrupt the search where it is of no use."""
            sample = self.evaluate(float(value))
            if not sample.is_solved or self.f(sample) * self.f(b) <= 0:
                raise _InterruptedError
            return float(sign * sample.output)

        with suppress(_InterruptedError):
            minimize_scalar(
                height,
                bounds=(a.value, c.value),
                method="bounded",
                options={"maxiter": MINIMISATIONS, "xatol": MINIMUM_WIDTH * (c.value - a.value)},
            )

    # ---- solutions ------------------------------------------------------------------------------

    def solutions(self) -> list[Sample]:
        """Return the samples that solve the problem, in ascending order."""
        roots = [sample for sample in self.solved if self.is_root(sample)]
        for a, b in self._brackets():
            if not any(self.is_root(end) for end in (a, b)):
                roots += self._solve_bracket(a, b, SEARCHES)
        return sorted(roots, key=lambda sample: sample.value)

    def difference(self, sample: Sample) -> str:
        """Return how a solution differs from that without a neighbour's initial guess, or ""."""
        if not sample.is_started or "start" not in keywords_of(self.model.kind.solver):
            return ""
        try:
            model = on_mesh_of(self.model, sample.result)
            output = model.run({self.name: sample.value}, None).values[0]
        except InvalidProblem as fault:
            return str(fault).replace("\n", "; ")
        except NotConverged as fault:
            return f"not converged: {fault}"
        finally:
            self.report(len(self.samples) + 1)
        error = self.error(sample)
        permitted = error if isfinite(error) else SAME * max(self.scale, abs(sample.output))
        if abs(output - sample.output) <= permitted:
            return ""
        quantity = self.model.quantity(self.output)
        return f"{self.output} = {quantity.stored_text(output, '.6g') if quantity else output}"

    def _solve_bracket(self, a: Sample, b: Sample, depth: int) -> list[Sample]:
        """Return the solutions between two samples of different sign; record a jump without one.

        ``depth`` is the number of times that parts of the bracket may be searched where a point in
        it cannot be solved.
        """
        from scipy.optimize import brentq

        low, high, model = a, b, on_mesh_of(self.model, a.result, b.result)
        if model is not self.model:
            low, high = self.evaluate(a.value, model), self.evaluate(b.value, model)
            if self.f(low) * self.f(high) > 0 and not any(map(self.is_root, (low, high))):
                # the target lies within the discretisation error of an end
                low, high, model = self.evaluate(a.value), self.evaluate(b.value), self.model
        samples = {low.value: low, high.value: high}

        def function(value: float) -> float:
            """Return the output minus the target; exactly 0 within the tolerance of the solver."""
            if value not in samples:
                samples[value] = self.evaluate(value, model)
            if not samples[value].is_solved:
                raise _InterruptedError
            return 0.0 if self.is_root(samples[value]) else self.f(samples[value])

        # Brent's method usually stops at CLOSE; the width ends it where outputs are less smooth
        tolerance = WIDTH * (b.value - a.value)
        try:
            if function(a.value) * function(b.value) > 0:
                return [min((low, high), key=lambda sample: abs(self.f(sample)))]
            value = float(brentq(function, a.value, b.value, xtol=tolerance, rtol=1e-14))
            function(value)  # the last evaluation may be another one than the returned value
        except _InterruptedError:
            return self._around_unsolved(a.value, b.value, depth)
        sample = samples[value]
        error = self.error(sample)
        if not isfinite(error):
            error = ROUGHNESS * abs(self.f(b) - self.f(a))
        if self.is_root(sample) or abs(self.f(sample)) <= error:
            return [sample]
        # f jumps between the sample and the nearest one of the other sign
        opposite = [s.value for s in self.solved if self.f(s) * self.f(sample) < 0]
        other = min(opposite, key=lambda x: abs(x - value))
        self.jumps.append((min(value, other), max(value, other)))
        return []

    def _around_unsolved(self, low: float, high: float, depth: int) -> list[Sample]:
        """Return the solutions in the parts of a bracket next to a point that was not solved."""
        for solved, failed in self._limits():
            if low <= min(solved.value, failed.value) and max(solved.value, failed.value) <= high:
                self._approach_limit(solved, failed)
        roots: list[Sample] = []
        for first, second in self._brackets():
            if low <= first.value and second.value <= high and depth:
                roots += self._solve_bracket(first, second, depth - 1)
        return roots
