"""The stages of an operating window, and the maps that follow from their windings.

    nips     windings with nips at 3 x 3 set points: the friction shares as polynomials of them
    preview  windings with these shares, which need no nips, at the centre with each input one
             standard deviation higher
    steps    the same windings with nips: the effects of the inputs on the shares
    rolls    windings with shares at 5 x 5 set points with median inputs, and at set points and
             inputs drawn from their distributions
    checks   windings with nips at eight other set points, four of them with other inputs: errors

If shares are of no help, all windings are solved like those of the first stage.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import InvalidProblem, NotConverged
from .window_cases import Case, CaseSolver, Point, Shares, Windings, share_polynomials
from .window_map import (
    Expansion,
    MarginMap,
    Polynomial,
    distance,
    expansion_of,
    fitted,
    linear_expansion,
    lobatto,
    standard_normal,
    terms_of,
    to_reserve,
)
from .window_model import margin_names
from .window_result import OperatingWindow

__all__ = ["WindowStudy"]

Array = np.ndarray
GRID = 33  # points of the map along web tension and nip load
# of the variance of some margin at the centre, from which an input has quadratic effects as well
IMPORTANT = 0.01
# windings with drawn inputs: for each coefficient of an expansion in which all inputs matter, but
# at most so many of rolls, which are fast, or with nips
DRAWN_PER_TERM, DRAWN, DRAWN_WITH_NIPS = 3, 128, 48
# Work of a winding whose nips are solved, relative to one with known friction shares, for the
# reported progress: ten nips of 33 nodes and three iterations take as long as about 20 rolls.
WORK_WITH_NIPS = 20
FEWEST = 4  # solved windings from which a map is made
FEWEST_DRAWN = 2  # for each coefficient of an expansion that is linear in the inputs
INNER = 0.5**0.5  # torque split of the checks, between two of its three levels
# off all lines of the 5 x 5 points, halfway between them in the angle
OUTER, MIDDLE = 0.92387953, 0.38268343
CHECKS = ((OUTER, MIDDLE), (-MIDDLE, OUTER), (-OUTER, -MIDDLE), (MIDDLE, -OUTER))
CHECKS_OF_INPUTS = tuple((-u, v) for u, v in CHECKS)


class WindowStudy:
    """The windings of a window and the maps that follow from them.

    Parameters
    ----------
    solver : CaseSolver
    sampling : (samples, seed)
        Of the inputs.
    report : callable
        Is called with (work done, work expected), in windings with known friction shares.
    """

    def __init__(
        self, solver: CaseSolver, sampling: tuple[int, int], report: Callable[[int, int], None]
    ) -> None:
        self.solver, self.sampling, self.report = solver, sampling, report
        self.set_points = solver.set_points
        self.names = margin_names(solver.model.problem)
        dimension, self.inputs = len(self.set_points.names), len(solver.spreads)
        self.median = (0.0,) * self.inputs
        self.reference = (0.0,) * dimension  # point of the differences in the inputs
        third = [lobatto(3)] * (dimension - 2)
        self.fine = _product(lobatto(5), lobatto(5), *third)
        self.rough = _product(lobatto(3), lobatto(3), *third)
        self.degrees = [2] * (dimension - 2)  # of the torque split
        self.uses_shares = bool(solver.model.depths)
        self.nips = Windings()
        self.rolls = Windings() if self.uses_shares else self.nips
        self.steps = self.nips  # with the differences in the inputs
        problem: Any = solver.model.problem
        self.has_nips = problem.tension_law == "nip"
        further = len(self.fine) - len(self.rough) + self._draws()
        with_nips = len(self.rough) + self.inputs + len(CHECKS) + len(CHECKS_OF_INPUTS)
        self.work = WORK_WITH_NIPS if self.uses_shares else 1  # of a winding with nips
        self.done, self.expected = 0, self.work * with_nips + further
        if self.uses_shares:  # the preview, and the rough points of the rolls too
            self.expected += 1 + self.inputs + len(self.rough)

    # ---- stages ---------------------------------------------------------------------------------

    def coarse(self) -> OperatingWindow:
        """Solve 3 x 3 points and one difference for each input; return the preview."""
        self._solve("nips", self.nips, self._nominal(self.rough))
        if self.nips.reasons and self.uses_shares:  # polynomials need more points then
            self._solve("more_nips", self.nips, self._nominal(self.fine))
        solved = [x for x, z in self._nominal(self.fine) if self.nips.is_solved((x, z))]
        if solved:
            self.reference = _nearest(self.reference, solved)
            self._solve_preview()
        return self._window(self.nips, self.rough, [2, 2, *self.degrees], is_coarse=True)

    def _solve_preview(self) -> None:
        """Solve the differences at the reference point, if possible with known friction shares."""
        steps = self._steps(range(self.inputs), 1.0)
        if not self.uses_shares:
            self._solve("steps", self.nips, steps)
            return
        self.steps = Windings()
        base = self._nominal([self.reference])
        self._solve("preview", self.steps, [*base, *steps], self._shares())

    def complete(self) -> OperatingWindow:
        """Solve all points, the windings with drawn inputs, and the checks."""
        self.steps = self.nips
        self._solve("steps", self.nips, self._steps(range(self.inputs), 1.0))
        shares = self._shares() if self.uses_shares else None
        self._solve("rolls", self.rolls, [*self._nominal(self.fine), *self._drawn], shares)
        self._solve("checks", self.nips, [*self._checks(), *self._checks_of_inputs()])
        return self._window(self.rolls, self.fine, [4, 4, *self.degrees], is_coarse=False)

    def _solve(
        self, stage: str, windings: Windings, cases: Sequence[Case], shares: Shares | None = None
    ) -> None:
        """Solve the windings of a stage and report the progress."""
        done, each = self.done, self.work if windings is self.nips else 1
        new = sum(case not in windings.margins for case in dict.fromkeys(cases))
        self.expected = max(self.expected, done + each * new)

        def report(solved: int) -> None:
            self.report(done + each * solved, self.expected)

        self.solver.solve(stage, windings, cases, shares, report)
        self.done = done + each * new

    def _shares(self) -> Shares:
        """Return the friction shares as polynomials of the windings with nips."""
        known = [(x, z) for x, z in self._nominal(self.fine) if (x, z) in self.nips.margins]
        degree = 2 if len(known) == len(self.rough) else 4
        solved = [x for x, z in known if self.nips.is_solved((x, z))]
        steps = self._steps(range(self.inputs), 1.0)
        return share_polynomials(self.nips, solved, [degree, degree, *self.degrees], steps)

    def _nominal(self, points: Sequence[Point]) -> list[Case]:
        """Return the cases of set points with median inputs."""
        return [(x, self.median) for x in points]

    def _step(self, k: int, size: float) -> Point:
        return tuple(size * (j == k) for j in range(self.inputs))

    def _steps(self, numbers: Sequence[int], size: float) -> list[Case]:
        """Return the cases at the reference point with one input changed."""
        return [(self.reference, self._step(k, size)) for k in numbers]

    def _draws(self) -> int:
        """Return the number of windings with drawn inputs."""
        if self.inputs == 0:
            return 0
        terms = terms_of(self.inputs, self.inputs, len(self.set_points.names))
        most = DRAWN_WITH_NIPS if self.has_nips and not self.uses_shares else DRAWN
        return min(most, DRAWN_PER_TERM * terms)

    @cached_property
    def _drawn(self) -> list[Case]:
        """Cases at admissible set points, even in x, with inputs of their distribution."""
        from scipy.stats import norm, qmc

        d = len(self.set_points.names)
        # more than needed, because some set points may not be admissible
        points = qmc.Sobol(d + self.inputs, rng=0).random(4 * DRAWN)
        x = 2 * points[:, :d] - 1
        z = norm.ppf(np.clip(points[:, d:], 1e-12, 1 - 1e-12))  # 0 is possible after rounding
        admissible = self._admissible(x)
        places, inputs = (part[admissible][: self._draws()].tolist() for part in (x, z))
        return list(zip(map(tuple, places), map(tuple, inputs), strict=True))

    def _checks(self) -> list[Case]:
        """Return cases with median inputs at set points between those of the polynomials."""
        return self._nominal([(*x, *self._between(k)) for k, x in enumerate(CHECKS)])

    def _checks_of_inputs(self) -> list[Case]:
        """Return cases with all inputs changed by one standard deviation, with random signs."""
        sides = np.random.default_rng(0).choice([-1.0, 1.0], (len(CHECKS_OF_INPUTS), self.inputs))
        points = [(*x, *self._between(k)) for k, x in enumerate(CHECKS_OF_INPUTS)]
        return list(zip(points, map(tuple, sides.tolist()), strict=True))

    def _between(self, k: int) -> list[float]:
        """Return the torque split of a check, between two of its three levels."""
        return [(-1) ** k * INNER] * len(self.degrees)

    # ---- effects of the inputs ------------------------------------------------------------------

    def _checked(self) -> Array:
        """Return the margins that have a limit: those that are a number in any winding."""
        return np.isfinite(np.array(list(self.nips.margins.values()))).any(axis=0)

    def _differences(self, checked: Array) -> Array:
        """Return the changes at the reference point, (inputs, margins), nan if unknown."""
        base = self.steps.margins[self.reference, self.median]
        steps = self._steps(range(self.inputs), 1.0)
        changes = [self.steps.margins[case] - base for case in steps]
        return np.reshape(changes, (self.inputs, len(self.names)))[:, checked]

    def _important(self, checked: Array) -> list[int]:
        """Return the inputs that matter for some margin, the most important one first.

        Inputs of an unknown effect are among them.
        """
        variance = self._differences(checked) ** 2
        total = np.nansum(variance, axis=0)
        share = (variance / np.where(total > 0, total, 1.0)).max(axis=1)
        share[np.isnan(share)] = 1.0
        order = np.argsort(-share, kind="stable")
        return [k for k in order.tolist() if share[k] > IMPORTANT]

    def _expansion(self, windings: Windings, nominal: Polynomial, checked: Array) -> Expansion:
        """Return the effects of the inputs by all windings with other than median inputs.

        Without drawn inputs, in the preview, these are the differences at the reference point.
        """
        cases = [*self._steps(range(self.inputs), 1.0), *self._drawn]
        rows = []
        for case in cases:
            solved = windings if windings.is_solved(case) else self.steps
            if solved.is_solved(case) and np.isfinite(solved.margins[case][checked]).all():
                rows.append((*case, solved.margins[case][checked]))
        d = len(self.set_points.names)
        if len(rows) < FEWEST_DRAWN * (self.inputs + d + 1):
            return linear_expansion(self._differences(checked), d)
        x, z, margins = (np.array(part) for part in zip(*rows, strict=True))
        return expansion_of(x, z, margins - nominal(x), self._important(checked))

    # ---- maps -----------------------------------------------------------------------------------

    def _window(
        self, windings: Windings, nodes: Sequence[Point], degrees: Sequence[int], *, is_coarse: bool
    ) -> OperatingWindow:
        """Return the window of the windings solved so far."""
        checked = self._checked()
        if not checked.any():
            self._reject()
        margins = np.array([windings.margins[case] for case in self._nominal(nodes)])[:, checked]
        mapped = self._margin_map(windings, np.array(nodes), margins, checked, degrees)
        axes = [np.linspace(-1, 1, GRID)] * 2 + [lobatto(3)] * len(self.degrees)
        mesh, shape = np.array(_product(*axes)), tuple(len(axis) for axis in axes)
        steady = self._steady(mesh, windings, nodes)
        if not steady.any():
            raise NotConverged("no steady state exists at any point of the map")
        interpolation = self._deviation(mapped, checked, self._checks())
        expansion = self._deviation(mapped, checked, self._checks_of_inputs())
        model, spreads = self.solver.model, self.solver.spreads
        varied = {name: model.quantity(name) for name in (*self.set_points.names, *spreads)}
        probability = np.where(steady, mapped.probability(mesh), np.nan)
        names = tuple(n for n, known in zip(self.names, checked, strict=True) if known)
        return OperatingWindow(
            problem=model.problem,
            names=self.set_points.names,
            ranges=self.set_points.ranges,
            margins=names,
            uncertain=spreads,
            axes=tuple(self.set_points.along(k, axis) for k, axis in enumerate(axes)),
            probability=probability.reshape(shape),
            index=distance(*mapped.moments(mesh)).reshape(*shape, -1),
            points=self.set_points.values(np.array(nodes)),
            values=to_reserve(margins)[0],
            failures=self._failures(windings),
            errors=_probability_errors(mapped, mesh[steady], interpolation, expansion),
            interpolation=interpolation,
            expansion=expansion,
            windings=len(self.nips.margins),
            is_coarse=is_coarse,
            quantities={name: q for name, q in varied.items() if q is not None},
            map=mapped,
            model=model.only(f"margins.{name}" for name in names),
        )

    def _margin_map(
        self, windings: Windings, x: Array, margins: Array, checked: Array, degrees: Sequence[int]
    ) -> MarginMap:
        """Return the margins as functions of set point and inputs.

        Raises
        ------
        NotConverged
            If too few windings are solved.
        """
        solved = np.isfinite(margins).all(axis=1)
        if solved.sum() < FEWEST:
            text = f"only {solved.sum()} of {len(x)} windings were solved"
            raise NotConverged(f"{text}: {self._reasons(windings)}")
        nominal = fitted(x[solved], margins[solved], degrees)
        draws = standard_normal(self.inputs, *self.sampling)
        return MarginMap(nominal, self._expansion(windings, nominal, checked), draws)

    def _reject(self) -> None:
        """Raise the error for a study without any solved winding or without limits."""
        if self.nips.reasons and len(self.nips.reasons) == len(self.nips.margins):
            text = f"none of {len(self.nips.margins)} windings was solved"
            raise NotConverged(f"{text}: {self._reasons(self.nips)}")
        text = "none is given; must be at least one, or no margin can be checked"
        raise InvalidProblem.at("limits", text)

    def _reasons(self, windings: Windings) -> str:
        return "; ".join(dict.fromkeys([*self.nips.reasons.values(), *windings.reasons.values()]))

    def _steady(self, mesh: Array, windings: Windings, nodes: Sequence[Point]) -> Array:
        """Return a mask of the points at which a winding exists.

        Not where the problem is rejected, as the drum slides, and not where the nearest node is
        admissible and nevertheless not solved.
        """
        failed = [
            case in self.nips.reasons or case in windings.reasons for case in self._nominal(nodes)
        ]
        if not any(failed):
            return np.ones(len(mesh), dtype=bool)
        unsolved = np.array(failed) & self._admissible(np.array(nodes))
        squares = ((mesh[:, None] - np.array(nodes)[None]) ** 2).sum(axis=-1)
        return self._admissible(mesh) & ~unsolved[np.argmin(squares, axis=1)]

    def _admissible(self, x: Array) -> Array:
        """Return a mask of the coordinates with a valid problem: loads that the drum can carry."""
        admissible = np.ones(len(x), dtype=bool)
        for k, point in enumerate(self.set_points.values(x).tolist()):
            try:
                self.solver.model.variant(dict(zip(self.set_points.names, point, strict=True)))
            except InvalidProblem:
                admissible[k] = False
        return admissible

    def _failures(self, windings: Windings) -> tuple[tuple[Point, str], ...]:
        reasons = {**self.nips.reasons, **windings.reasons}
        points = [self.set_points.values(np.array([x]))[0].tolist() for x, _ in reasons]
        return tuple(zip(map(tuple, points), reasons.values(), strict=True))

    def _deviation(self, mapped: MarginMap, checked: Array, cases: Sequence[Case]) -> Array:
        """Return root mean square differences of the margins from windings, nan without any."""
        solved = [case for case in cases if self.nips.is_solved(case)]
        if not solved:
            return np.full(int(checked.sum()), np.nan)
        x, z = (np.array(part) for part in zip(*solved, strict=True))
        margins = np.array([self.nips.margins[case][checked] for case in solved])
        return np.asarray(np.sqrt(np.mean((mapped.margins(x, z) - margins) ** 2, axis=0)))


def _probability_errors(
    mapped: MarginMap, x: Array, interpolation: Array, expansion: Array
) -> dict[str, float]:
    """Return the largest errors of the probability over the map, nan if unknown."""
    sample = x[::3]  # every third point: the errors vary slowly
    reference = mapped.probability(sample)
    errors: dict[str, float] = {}
    for name, deviation in (("interpolation", interpolation), ("expansion", expansion)):
        shifted = [mapped.probability(sample, shift=side * deviation) for side in (-1, 1)]
        largest = float(np.abs(np.array(shifted) - reference).max())
        errors[name] = largest if np.isfinite(deviation).all() else np.nan
    # variance of independent draws; the error of Sobol points is smaller
    variance = reference * (1 - reference) / len(mapped.sample)
    return {**errors, "sampling": float(np.sqrt(variance).max())}


def _product(*axes: Array) -> list[Point]:
    """Return all combinations of coordinates."""
    mesh = np.meshgrid(*axes, indexing="ij")
    return [tuple(row) for row in np.stack(mesh, axis=-1).reshape(-1, len(axes)).tolist()]


def _nearest(point: Point, points: Sequence[Point]) -> Point:
    """Return the point that is nearest to another."""
    return min(points, key=lambda other: float(np.sum((np.array(other) - point) ** 2)))
