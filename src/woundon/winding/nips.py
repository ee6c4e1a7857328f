"""The nips of a winding, solved on the growing roll with warm starts."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

import numpy as np

from ..errors import RESOLUTION, InvalidProblem, NotConverged
from ..nip.result import NipResult
from ..nip.solve import solve_nip, solve_with_film
from ..problems.bodies import Body
from ..problems.nip import NipProblem
from ..problems.winding import WindingProblem
from ..roll.density import mean_over_length
from ..roll.result import RollResult
from ..roll.stages import Stage, stages_at
from ..validity import LENGTH
from .bodies import NipSample, predicted_nip, solved_nip, with_exponents

__all__ = ["PRESSURE_TOLERANCE", "Nips", "warnings_of"]

COARSE_NODES = 33
# relative tolerances of the effective pressure in one nip-roll iteration
COARSE_PRESSURE_TOLERANCE, PRESSURE_TOLERANCE = 0.05, 3e-3
# ``coupling_rtol`` from which on the exponents of P_e of a neighbouring nip suffice: they differ by
# up to 0.02, and P_e changes by some percent after the first solution
COARSE_COUPLING_RTOL = 3e-4


class Nips:
    """The nips of one winding.

    Parameters
    ----------
    problem : WindingProblem
    nodes : int
        Number of nodes of each nip.
    coupling_rtol : float
        Relative tolerance of the iteration between friction and entrained air.
    report : callable
        Called with the number of solved nips.
    neighbours : iterable of NipSample
        Nips of a neighbouring winding, for warm starts.
    solved : int
        Number of nips solved before.
    errors : bool
        False omits the error estimates.

    Attributes
    ----------
    samples : dict of float to NipSample
        The latest solution at each radius.
    solved : int
        Total number of solved nips.
    coarse, rough : bool
        True if the nips are solved on a coarse mesh, and with a coarse tolerance of the effective
        pressure: at the beginning of the nip-roll iteration.
    films : dict of float to float
        Entrained air film [m] by the radius of the roll [m].
    frictions : dict of float to (float, float)
        Coefficients of friction in the nip and on the roll wrap, reduced by this film.
    """

    def __init__(
        self,
        problem: WindingProblem,
        nodes: int,
        coupling_rtol: float,
        report: Callable[[int], None],
        neighbours: Iterable[NipSample] = (),
        solved: int = 0,
        errors: bool = True,
    ) -> None:
        self.problem, self.nodes, self.coupling_rtol = problem, nodes, coupling_rtol
        self.report = report
        self.neighbours = {sample.radius: sample for sample in neighbours}
        self.samples: dict[float, NipSample] = {}
        self.solved, self.coarse, self.rough = solved, False, False
        self.errors = errors
        self.films: dict[float, float] = {}
        self.frictions: dict[float, tuple[float, float]] = {}
        self._differentiated: set[float] = set()  # radii of the nips with exponents of P_e
        # stages of the latest roll at the nips
        self._staged: RollResult | None = None
        self._stages: dict[float, Stage] = {}

    @property
    def is_roll_independent(self) -> bool:
        """True if the wound-on tension of a nip does not depend on the wound roll."""
        return self.problem.roll_body == "linear" and self.problem.air is None

    def tension(
        self, radius: float, roll: RollResult | None, pressure: float | None = None
    ) -> float:
        """Solve the nip at a radius on a roll; return its wound-on tension [N/m].

        ``roll`` may be None if :attr:`is_roll_independent`.  ``pressure`` is a guess of P_e [Pa]
        for a nip that has no solution yet.
        """
        previous = self.samples.get(radius)
        if self.is_roll_independent and previous is not None:
            return previous.tension
        with _radius_in_errors(radius):
            linear = self.problem.roll_body == "linear"
            stage = None if roll is None or linear else self._stage(radius, roll)
            sample = solved_nip(
                self._with_stack_of(roll),
                radius,
                stage,
                previous,
                self._nearest(radius),
                self.solve,
                COARSE_PRESSURE_TOLERANCE if self.rough else PRESSURE_TOLERANCE,
                pressure,
            )
            if self._needs_exponents(radius) and stage is not None:
                sample = with_exponents(self._with_stack_of(roll), stage, sample)
                self._differentiated.add(radius)
        self.samples[radius] = sample
        return sample.tension

    def _needs_exponents(self, radius: float) -> bool:
        """True for the first solution of a nip on its last mesh, for fine tolerances."""
        is_fine = self.coupling_rtol < COARSE_COUPLING_RTOL and not (self.coarse or self.rough)
        is_effective = self.problem.roll_body == "effective"
        return is_fine and is_effective and radius not in self._differentiated

    def predict(self, radius: float, roll: RollResult) -> float:
        """Return the tension of a nip predicted on another effective roll [N/m]."""
        stage = self._stage(radius, roll)
        self.samples[radius] = predicted_nip(self._with_stack_of(roll), stage, self.samples[radius])
        return self.samples[radius].tension

    def from_core_to_surface(self) -> list[NipSample]:
        """Return the latest solution of every nip, from the core to the surface."""
        return [self.samples[radius] for radius in sorted(self.samples)]

    def estimate_errors(self) -> None:
        """Add the error estimates to the nips that were solved without: solve their coarse meshes.

        The solution on the last mesh stays the same.
        """
        if not self.errors or self._has_estimates:
            return
        for radius, sample in self.samples.items():
            nip = sample.result
            result = solve_nip(nip.problem, nodes=self.nodes, start=nip)
            self.samples[radius] = sample._replace(result=result)

    @property
    def _has_estimates(self) -> bool:
        """True if nips are solved with estimates: once, or with the iteration of their air."""
        return self.errors and (self.is_roll_independent or self.problem.air is not None)

    def mean_film(self) -> float:
        """Return the mean air film of the nips over the length of web [m]."""
        if not any(self.films.values()):
            return 0.0
        r = np.array(sorted(self.films))
        h = np.array([self.films[radius] for radius in r.tolist()])
        return mean_over_length(r, h)

    def warnings(self) -> tuple[str, ...]:
        """Return the warnings of the nips, each kind once, with its radii."""
        return warnings_of(
            [(sample.radius, sample.result.warnings) for sample in self.from_core_to_surface()]
        )

    def _stage(self, radius: float, roll: RollResult) -> Stage:
        """Return a stage of the roll; those at all nips are solved together."""
        if roll is not self._staged:
            self._staged, self._stages = roll, {}
        if radius not in self._stages:
            radii = [radius, *(r for r in self.samples if r not in self._stages and r != radius)]
            self._stages |= zip(radii, stages_at(roll, radii, as_wound=True), strict=True)
        return self._stages[radius]

    def _with_stack_of(self, roll: RollResult | None) -> WindingProblem:
        """Return the problem with the stack of a roll, including its air film."""
        problem = self.problem
        if roll is None or roll.problem.stack is problem.stack:
            return problem
        return problem.replace(stack=roll.problem.stack)

    def _nearest(self, radius: float) -> NipSample | None:
        """Return the nip that is nearest in ln(r - r_c), for a warm start."""
        core = self.problem.core.radius
        candidates = self.neighbours or self.samples
        nearest = min(
            candidates, key=lambda r: abs(np.log((r - core) / (radius - core))), default=None
        )
        return None if nearest is None else candidates[nearest]

    def solve(self, roll: Body, start: NipResult | None) -> NipResult:
        """Solve the nip on a roll; without the warm start if it does not converge."""
        nodes = min(self.nodes, COARSE_NODES) if self.coarse else self.nodes
        nip = self.problem.nip(roll.radius, roll)
        try:
            result = self._solve_with_air(nip, nodes, start)
        except NotConverged:  # possibly because of a poor initial guess
            if start is None:
                raise
            result = self._solve_with_air(nip, nodes, None)
        self.solved += 1
        self.report(self.solved)
        return result

    def _solve_with_air(self, nip: NipProblem, nodes: int, start: NipResult | None) -> NipResult:
        """Solve a nip with its entrained air and the reduced friction; store both."""
        radius = nip.roll.radius
        if nip.air is None:
            self.films[radius] = 0.0
            return solve_nip(nip, nodes=nodes, start=start, errors=self._has_estimates)
        nearest = min(self.films, key=lambda other: abs(other - radius), default=None)
        # the friction of the nearest nip is the initial guess
        result = solve_with_film(
            nip,
            frictions=None if nearest is None else self.frictions[nearest],
            tolerance=self.coupling_rtol,
            nodes=nodes,
            start=start,
        )
        assert result.air is not None
        self.films[radius] = result.air.film
        self.frictions[radius] = result.air.roll_friction, result.air.wrap_friction
        return result


def warnings_of(nips: Iterable[tuple[float, tuple[str, ...]]]) -> tuple[str, ...]:
    """Merge the warnings of all nips, (radius [m], texts): each kind once, with its radii."""
    first: dict[str, str] = {}
    radii: dict[str, list[float]] = {}
    for radius, texts in nips:
        for text in texts:
            kind = re.sub(r"[\d.e+-]+", "", text)  # the text without its numbers
            first.setdefault(kind, text)
            radii.setdefault(kind, []).append(radius)
    merged = []
    for kind, text in first.items():
        # the mark of a resolution warning stays at the beginning of the text
        mark = RESOLUTION if text.startswith(RESOLUTION) else ""
        merged.append(f"{mark}{_radii_text(radii[kind])}: {text.removeprefix(RESOLUTION)}")
    return tuple(merged)


def _radii_text(radii: list[float]) -> str:
    """Return the radii of a warning as text."""
    first_nip = f"nip at the radius {LENGTH.stored_text(radii[0])}"
    if len(radii) == 1:
        return first_nip
    return f"{first_nip} and {len(radii) - 1} more up to {LENGTH.stored_text(max(radii))}"


@contextmanager
def _radius_in_errors(radius: float) -> Iterator[None]:
    """Add the radius to the messages of errors."""
    prefix = f"at the radius {radius:.4g} m: "
    try:
        yield
    except InvalidProblem as fault:
        raise type(fault)([(field, prefix + text) for field, text in fault.faults]) from None
    except NotConverged as stop:
        raise NotConverged(prefix + str(stop), stop.best) from None
