r"""The operating window: the probability that a roll keeps all its limits, over the set points.

The windings are solved in stages:

    nips     windings with nips at 3 x 3 set points: the friction shares as polynomials of them
    preview  windings with these shares, which need no nips, at the centre with each input one
             standard deviation higher
    steps    the same windings with nips: the effects of the inputs on the shares
    rolls    windings with shares at 5 x 5 set points with median inputs, 9 along a field that is no
             schedule, and at set points and inputs drawn from their distributions
    checks   windings with nips at eight other set points, four of them with other inputs: errors

If shares are of no help, all windings are solved like those of the first stage.
:mod:`.window_cases` solves the windings, :mod:`.window_map` interpolates their margins and computes
the probabilities.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import check_arguments, check_type, whole_number
from ..errors import InvalidProblem, NotConverged
from ..problems.grades import Grade
from ..problems.problem import Problem
from ..problems.winding import SCHEDULES, WindingProblem
from .model import quantities_of
from .progress import Progress, progress_reporter
from .run import Workers
from .window_cases import (
    CaseSolver,
    Shares,
    Windings,
    joined,
    margin_names,
    ranges_of,
    share_polynomials,
    spreads_and_ties,
    window_model,
)
from .window_map import (
    MarginMap,
    SetPoints,
    expansion_of,
    fitted,
    grid,
    lobatto,
    sobol_points,
    standard_normal,
    terms_of,
    to_reserve,
)
from .window_result import MOST_SAMPLES, OperatingWindow

__all__ = ["operating_window"]

Array = np.ndarray
Case = tuple[tuple[float, ...], tuple[float, ...]]  # coordinates of set point and inputs
GRID = 33  # points of the map along its two axes
# windings with drawn inputs: for each coefficient of an expansion in which all inputs matter, but
# at most so many of rolls, which are fast, or with nips
DRAWN_PER_TERM, DRAWN, DRAWN_WITH_NIPS = 3, 128, 48
# Work of a winding whose nips are solved, relative to one with known friction shares, for the
# reported progress: ten nips of 33 nodes and three iterations take as long as about 20 rolls.
WORK_WITH_NIPS = 20
FEWEST = 4  # solved windings from which a map is made
INNER = 0.5**0.5  # third coordinate of the checks, between two of its three levels
# Points of the rolls along a set point: margins are about powers of tensions and loads.  Those of
# other fields may have a kink, as over the oscillation where another lane becomes the worst.
OF_SCHEDULE, OF_OTHER = 5, 9
CHECKS = 4  # with median inputs, and as many with other inputs
# Coordinates of the checks, halfway in the angle between points of these numbers.
BETWEEN = {OF_SCHEDULE: (0.92387953, 0.38268343), OF_OTHER: (0.83146961, 0.19509032)}


def operating_window(
    problem: Problem,
    web_tension: Sequence[float | str] | None = None,
    nip_load: Sequence[float | str] | None = None,
    torque_split: Sequence[float | str] | None = None,
    *,
    rider_load: Sequence[float | str] | None = None,
    vary: Mapping[str, Sequence[float | str]] | None = None,
    uncertain: Mapping[str, float | str] | Grade | str | None = None,
    tie: Mapping[str, str] | None = None,
    samples: int = 2048,
    seed: int = 0,
    workers: int | None = None,
    scheduler: str | None = None,
    out: str | Path | None = None,
    resume: bool = False,
    progress: bool | Progress = False,
    preview: Callable[[OperatingWindow], object] | None = None,
    options: Mapping[str, Any] | None = None,
) -> OperatingWindow:
    """Map the probability that all margins of a winding hold, over two or three set points.

    They are usually web tension and nip load; of a two-drum winder, whose nip loads follow from its
    geometry, web tension and rider load; or any other fields, such as the oscillation of the web.
    Schedules keep their shape; the ranges are of their values at the core.  A third set point has
    three levels.

    Parameters
    ----------
    problem : WindingProblem
        With at least one limit.
    web_tension, nip_load, torque_split : (low, high), optional
        At the core, SI or texts with units.
    rider_load : (low, high)
        With a ``winder``, in place of ``nip_load``.
    vary : mapping of str to (low, high), optional
        Dotted name of any other field, ``"oscillation"`` or ``"thickness_profile.variation"``, ->
        its range.  They follow the others, in this order.
    uncertain : mapping, Grade or str, optional
        Dotted name of a field -> relative standard deviation, 0.05 or "5 %", of its log-normal
        distribution, whose median is the value of the problem.  A grade, or its name, gives the
        spreads of the grade.  By default those of the grade that the problem was made with; a
        mapping then replaces single ones, 0 removes one.
    tie : mapping of str to str
        Field -> field that it follows.  With the spreads of a grade, values that it supplies to
        several fields are tied.
    samples, seed : int
        Draws from the distributions, 100 to 100 000, and the seed of their generator.
    workers : int
        Processes; by default one for each core.
    scheduler : str
        Address of a Dask scheduler, "tcp://...", whose workers solve the windings.
    out : path
        Folder for the windings; ``resume=True`` continues an interrupted computation.
    progress : bool or callable
        Show the fraction done, or call with (work done, work expected); a winding whose nips are
        solved counts as 20 with known friction shares.
    preview : callable, optional
        Is called with a coarse window of 3 x 3 points, after about a third of the time.
    options : mapping
        Options of the solver.  By default a reduced accuracy: rtol 0.01, 33 nodes,
        coupling_rtol 0.001.

    Returns
    -------
    OperatingWindow

    Raises
    ------
    InvalidProblem
        For invalid ranges or names, without limits, or without spreads.
    NotConverged
        If too few windings can be solved, or there is no steady state at any point.

    Examples
    --------
    A roll of 60 layers of board with full slip in the nip, so that no nip is solved:

    >>> import woundon as wo
    >>> board = wo.WindingProblem.example().replace(
    ...     stack=wo.Stack(radial=27e6, tangential=3.38e9, poissons_ratio=0.01, shear=10e6),
    ...     radius=0.08, tension_law="friction", limits=wo.Limits(blocking_pressure="200 kPa"),
    ...     **{"web.thickness": "500 um"},
    ... )
    >>> window = wo.operating_window(
    ...     board, web_tension=(200, 500), nip_load=("1 kN/m", "4 kN/m"),
    ...     uncertain={"roll_friction": 0.3}, samples=128, workers=1,
    ... )
    >>> window.best.probability, window.at("400 N/m", "3 kN/m").binding
    (1.0, 'blocking')
    """
    if not isinstance(problem, WindingProblem):
        text = f"{type(problem).__name__} is out of place; must be a WindingProblem"
        raise InvalidProblem.at("problem", text)
    check_arguments(out=out, resume=resume, progress=progress, preview=preview, seed=seed)
    vary = {} if vary is None else vary
    check_arguments(vary=vary)
    check_type("vary", vary, Mapping)  # not names without ranges
    if resume and out is None:
        raise InvalidProblem.at("resume", "needs out, the folder of the windings")
    spreads, ties = spreads_and_ties(problem, uncertain, tie)
    whole_number("samples", samples, 100, MOST_SAMPLES)
    model = window_model(problem, ties, options)
    given = {
        "web_tension": web_tension,
        "nip_load": nip_load,
        "rider_load": rider_load,
        "torque_split": torque_split,
    }
    ranges = ranges_of(problem, given, vary)
    model.check_varied([*spreads, *ranges])
    model.check_effects(ranges)
    if repeated := [name for name in ranges if name in spreads]:
        text = "is a set point, which has no spread; must be left out, or set to 0"
        raise InvalidProblem((f"uncertain.{name}", text) for name in repeated)
    set_points = SetPoints(tuple(ranges), np.array(list(ranges.values())))
    sample = standard_normal(len(spreads), samples, seed)
    folder = None if out is None else Path(out)
    solver = CaseSolver(model, set_points, spreads, Workers(workers, scheduler), folder, resume)
    with progress_reporter(progress, "winding") as report:
        return _Study(solver, sample, report).run(preview)


class _Study:
    """The windings of a window, solved in stages, and the maps that follow from them.

    Set points have two or three coordinates x in [-1, 1], inputs are coordinates z in standard
    deviations from their medians.

    Parameters
    ----------
    solver : CaseSolver
    sample : (draws, inputs) array
        Inputs in standard deviations, for the probabilities.
    report : callable
        Is called with (work done, work expected), in windings with known friction shares.
    """

    def __init__(self, solver: CaseSolver, sample: Array, report: Progress) -> None:
        self.solver, self.sample, self.report = solver, sample, report
        self.model, self.set_points = solver.model, solver.set_points
        self.dimension, self.inputs = len(self.set_points.names), len(solver.spreads)
        levels = [lobatto(3)] * (self.dimension - 2)  # of a third set point
        self.rough = grid(lobatto(3), lobatto(3), *levels)
        counts = [OF_SCHEDULE if name in SCHEDULES else OF_OTHER for name in self.set_points.names]
        self.counts = counts[0], counts[1]  # of points along the axes of the map
        # has all points of the rough grid
        self.fine = grid(*(lobatto(count) for count in self.counts), *levels)
        self.added = np.array([x for x in self.fine.tolist() if x not in self.rough.tolist()])
        names = np.array(margin_names(self.model.problem))
        self.margins, self.is_checked = names, np.ones(names.size, dtype=bool)
        self.with_nips: list[Windings] = []  # of all stages in which nips are solved
        self.work_with_nips = WORK_WITH_NIPS if self.model.depths else 1
        with_nips = len(self.rough) + self.inputs + 2 * CHECKS
        self.done, self.expected = 0, self.work_with_nips * with_nips
        self.expected += len(self.added) + self._number_of_draws()
        if self.model.depths:  # the preview, and the rough points of the rolls too
            self.expected += 1 + self.inputs + len(self.rough)

    # ---- stages ---------------------------------------------------------------------------------

    def run(self, preview: Callable[[OperatingWindow], object] | None) -> OperatingWindow:
        """Solve the windings of all stages; return the window."""
        rough = nips = self._solve("nips", self.rough)
        is_fine, has_shares = False, bool(self.model.depths)
        if has_shares and not nips.is_solved.all():  # polynomials need more points then
            nips, is_fine = joined(nips, self._solve("more_nips", self.added)), True
        self._select_checked(nips)
        rough, nips = self._checked(rough), self._checked(nips)

        # each input one standard deviation higher, at one set point
        reference = nips.rows([_nearest_to_centre(nips)])
        x, z = np.repeat(reference.x, self.inputs, axis=0), np.eye(self.inputs)
        if has_shares:
            # a preview without further nips, as if the inputs had no effect on the friction shares
            without_effects = reference.rows([0] * self.inputs)
            shares = share_polynomials(nips, self._degrees(is_fine), reference, without_effects)
            cases = np.vstack([reference.x, x]), np.vstack([reference.z, z])
            known = self._solve("preview", *cases, shares)
            # median inputs first, then each input one standard deviation higher
            base, steps = known.rows([0]), known.rows(slice(1, None))
        else:
            base, steps = reference, self._solve("steps", x, z)
        coarse = self._window(rough, base, steps)
        if preview is not None:
            preview(coarse)

        if has_shares:
            steps = self._solve("steps", x, z)
            shares = share_polynomials(nips, self._degrees(is_fine), reference, steps)
            nominal, drawn = self._solve_rolls(self.fine, shares)
        else:
            added, drawn = self._solve_rolls(self.added, None)
            nominal = joined(nips, added)
            # in the order of the grid: by the first coordinate, then the second, ...
            nominal = nominal.rows(np.lexsort(nominal.x.T[::-1]))
        checks = self._solve("checks", *self._checks())
        return self._window(nominal, reference, steps, drawn, checks)

    def _solve_rolls(self, points: Array, shares: Shares | None) -> tuple[Windings, Windings]:
        """Solve windings at points (n, d) with median inputs, and with drawn inputs.

        ``shares`` as of :meth:`_solve`.
        """
        x, z = self._drawn()
        medians = np.zeros((len(points), self.inputs))
        windings = self._solve("rolls", np.vstack([points, x]), np.vstack([medians, z]), shares)
        return windings.rows(slice(len(points))), windings.rows(slice(len(points), None))

    def _solve(
        self, stage: str, x: Array, z: Array | None = None, shares: Shares | None = None
    ) -> Windings:
        """Solve the windings of a stage and report the progress.

        Parameters
        ----------
        stage : str
            Name of its folder.
        x : (cases, d) array
            Coordinates of the set points.
        z : (cases, inputs) array, optional
            By default median inputs.
        shares : callable, optional
            Friction shares of cases; by default the nips are solved.
        """
        z = np.zeros((len(x), self.inputs)) if z is None else z
        done, work = self.done, self.work_with_nips if shares is None else 1
        self.done = done + work * len(x)
        self.expected = max(self.expected, self.done)

        def report(solved: int, _: int) -> None:
            self.report(done + work * solved, self.expected)

        windings = self.solver.solve(stage, x, z, shares, report)
        if shares is None:
            self.with_nips.append(windings)
        return self._checked(windings)

    def _select_checked(self, nips: Windings) -> None:
        """Select the margins that have a limit: those that are a number in a winding.

        Raises
        ------
        NotConverged, InvalidProblem
            If no winding was solved; if no margin has a limit.
        """
        if not nips.is_solved.any():
            text = f"none of {len(nips.x)} windings was solved: {self._reasons()}"
            raise NotConverged(text)
        self.is_checked = np.isfinite(nips.margins).any(axis=0)
        if not self.is_checked.any():
            text = "none is given; must be at least one, or no margin can be checked"
            raise InvalidProblem.at("limits", text)

    def _checked(self, windings: Windings) -> Windings:
        """Return windings with the margins that have a limit only, all before these are known."""
        return windings._replace(margins=windings.margins[:, self.is_checked])

    # ---- cases ----------------------------------------------------------------------------------

    def _drawn(self) -> tuple[Array, Array]:
        """Return cases (x, z) at admissible set points with inputs of their distribution.

        The set points are distributed evenly in x.
        """
        from scipy.stats import norm

        # more than needed, because some set points may not be admissible
        points = sobol_points(self.dimension + self.inputs, 4 * DRAWN, seed=0)
        x, z = 2 * points[:, : self.dimension] - 1, norm.ppf(points[:, self.dimension :])
        kept = np.nonzero(self._is_admissible(x))[0][: self._number_of_draws()]
        return x[kept], z[kept]

    def _number_of_draws(self) -> int:
        """Return the number of windings with drawn inputs."""
        if self.inputs == 0:
            return 0
        solves_nips = self.model.problem.solves_nips and not self.model.depths
        terms = terms_of(self.inputs, self.inputs, self.dimension)
        return min(DRAWN_WITH_NIPS if solves_nips else DRAWN, DRAWN_PER_TERM * terms)

    def _checks(self) -> tuple[Array, Array]:
        """Return cases (x, z) at set points between those of the polynomials.

        The inputs are median, then all changed by one standard deviation, with random signs.
        """
        (x_outer, x_middle), (y_outer, y_middle) = (BETWEEN[count] for count in self.counts)
        corners = np.array(
            [(x_outer, y_middle), (-x_middle, y_outer), (-x_outer, -y_middle), (x_middle, -y_outer)]
        )
        points = np.vstack([corners, corners * [-1, 1]])  # and mirrored ones for other inputs
        # between two of the three levels of a third set point
        split = np.tile((-1.0) ** np.arange(CHECKS) * INNER, 2)
        x = np.column_stack([points, *[split] * (self.dimension - 2)])
        signs = np.random.default_rng(0).choice([-1.0, 1.0], (CHECKS, self.inputs))
        return x, np.vstack([np.zeros((CHECKS, self.inputs)), signs])

    # ---- maps -----------------------------------------------------------------------------------

    def _window(
        self,
        nominal: Windings,
        base: Windings,
        steps: Windings,
        drawn: Windings | None = None,
        checks: Windings | None = None,
    ) -> OperatingWindow:
        """Return the window from the windings solved so far.

        Parameters
        ----------
        nominal : Windings
            At nodes with median inputs.
        base, steps : Windings
            At one set point: with median inputs, and with one input each one standard deviation
            higher.
        drawn : Windings, optional
            With drawn inputs; without them the window is a preview.
        checks : Windings, optional
            As of :meth:`_checks`.
        """
        mapped = self._margin_map(nominal, base, steps, drawn)
        axes = [np.linspace(-1, 1, GRID)] * 2 + [lobatto(3)] * (self.dimension - 2)
        mesh, shape = grid(*axes), tuple(len(axis) for axis in axes)
        failures = self._failures(nominal, *([] if drawn is None else [drawn]))
        is_steady = self._is_steady(mesh, nominal.x, failures)
        if not is_steady.any():
            raise NotConverged("no steady state exists at any point of the map")
        deviations = self._deviations(mapped, checks)
        varied = (*self.set_points.names, *self.solver.spreads)
        return OperatingWindow(
            problem=self.model.problem,
            names=self.set_points.names,
            ranges=self.set_points.ranges,
            margins=tuple(self.margins[self.is_checked].tolist()),
            uncertain=self.solver.spreads,
            axes=tuple(self.set_points.along(k, axis) for k, axis in enumerate(axes)),
            probability=np.where(is_steady, mapped.probability(mesh), np.nan).reshape(shape),
            index=mapped.distances(mesh).reshape(*shape, -1),
            points=self.set_points.values(nominal.x),
            values=to_reserve(nominal.margins)[0],  # without the derivatives
            failures=tuple(
                (tuple(self.set_points.values(np.array([x]))[0].tolist()), reason)
                for (x, _), reason in failures.items()
            ),
            errors=mapped.probability_errors(mesh[is_steady], deviations),
            **deviations,
            windings=sum(len(part.x) for part in self.with_nips),
            is_coarse=drawn is None,
            quantities=quantities_of(self.model, varied),
            map=mapped,
            model=self.model.with_margins(self.margins[self.is_checked].tolist()),
        )

    def _margin_map(
        self, nominal: Windings, base: Windings, steps: Windings, drawn: Windings | None
    ) -> MarginMap:
        """Return the margins as functions of set point and inputs; arguments as of a window.

        Raises
        ------
        NotConverged
            If too few windings are solved.
        """
        known = nominal.rows(np.isfinite(nominal.margins).all(axis=1))
        if len(known.x) < FEWEST:
            text = f"only {len(known.x)} of {len(nominal.x)} windings were solved"
            raise NotConverged(f"{text}: {self._reasons(nominal)}")
        degrees = self._degrees(is_fine=drawn is not None)
        polynomial = fitted(known.x, known.margins, degrees)
        changed = steps if drawn is None else joined(steps, drawn)
        changed = changed.rows(np.isfinite(changed.margins).all(axis=1))
        changes = changed.margins - polynomial(changed.x)
        differences = steps.margins - base.margins
        powers, factors = expansion_of(changed.x, changed.z, changes, differences)
        return MarginMap(polynomial, powers, factors, self.sample)

    def _degrees(self, is_fine: bool) -> list[int]:
        """Return the degrees along all coordinates; a third set point has three levels."""
        of_axes = [count - 1 if is_fine else 2 for count in self.counts]
        return [*of_axes, *[2] * (self.dimension - 2)]

    def _deviations(self, mapped: MarginMap, checks: Windings | None) -> dict[str, Array]:
        """Return root mean square differences of the margins from windings, nan without any.

        Those with median inputs are errors of the interpolation, the others of the expansion.
        """
        unknown = np.full(self.is_checked.sum(), np.nan)
        deviations = {"interpolation": unknown, "expansion": unknown}
        if checks is None:
            return deviations
        halves = slice(CHECKS), slice(CHECKS, None)  # as of _checks
        for name, half in zip(deviations, halves, strict=True):
            solved = checks.rows(half).rows(checks.is_solved[half])
            if len(solved.x):
                differences = mapped.margins(solved.x, solved.z) - solved.margins
                deviations[name] = np.sqrt(np.mean(differences**2, axis=0))
        return deviations

    # ---- where windings exist -------------------------------------------------------------------

    def _is_steady(self, mesh: Array, nodes: Array, failures: Mapping[Case, str]) -> Array:
        """Return a mask of the points at which a winding exists, (points,).

        Not where the problem is rejected, as the drum slides, and not where the nearest node is
        admissible and nevertheless not solved.

        Parameters
        ----------
        mesh : (points, d) array
            Coordinates x of the map.
        nodes : (n, d) array
            Those at which windings with median inputs were solved.
        failures : mapping
            As :meth:`_failures` returns them.
        """
        median = (0.0,) * self.inputs
        has_failed = np.array([(tuple(x), median) in failures for x in nodes.tolist()])
        if not has_failed.any():
            return np.ones(len(mesh), dtype=bool)
        unsolved = has_failed & self._is_admissible(nodes)
        squares = ((mesh[:, None] - nodes[None]) ** 2).sum(axis=-1)
        return self._is_admissible(mesh) & ~unsolved[np.argmin(squares, axis=1)]

    def _is_admissible(self, x: Array) -> Array:
        """Return a mask, (n,), of the coordinates x, (n, d), with a valid problem.

        It is not valid where the drum slides under the loads.
        """
        names, points = self.set_points.names, self.set_points.values(x).tolist()
        admitted = [self.model.admits(dict(zip(names, point, strict=True))) for point in points]
        return np.array(admitted, dtype=bool)

    def _failures(self, *others: Windings) -> dict[Case, str]:
        """Return why windings failed, by (x, z): those with nips, and others."""
        return {
            (tuple(x), tuple(z)): reason
            for part in (*self.with_nips, *others)
            for x, z, reason in zip(part.x.tolist(), part.z.tolist(), part.failures, strict=True)
            if reason
        }

    def _reasons(self, *others: Windings) -> str:
        """Return the different reasons of failures as one text."""
        return "; ".join(dict.fromkeys(self._failures(*others).values()))


def _nearest_to_centre(windings: Windings) -> int:
    """Return the row of the solved winding whose set point is nearest to the centre."""
    squares = np.sum(windings.x**2, axis=1)
    return int(np.argmin(np.where(windings.is_solved, squares, np.inf)))
