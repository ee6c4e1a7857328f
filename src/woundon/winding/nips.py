"""The nips of a winding: solved on the roll wound so far, each from what was solved before."""

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
from ..roll.result import RollResult
from ..roll.stages import stage_at
from .bodies import Felt, predicted_nip, solved_nip

__all__ = ["Nips", "warnings_of"]

COARSE_NODES = 33
# to what the pressure that a nip's roll feels is found in one turn
FELT_COARSELY, FELT = 0.02, 3e-3


class Nips:
    """The nips of one winding.

    Parameters
    ----------
    problem : WindingProblem
    nodes : int
        Of each.
    agreed : float
        To what friction and air are to agree.
    tell : callable
        Is called with how many nips are solved.
    before : iterable of Felt
        Nips of a neighbouring winding, to start from.
    solved : int
        How many were solved before.

    Attributes
    ----------
    felt : dict of float to Felt
        The last ones, by radius.
    solved : int
        How many in all.
    coarse : bool
        Whether they may be solved on few nodes.
    """

    def __init__(
        self, problem: WindingProblem, nodes: int, agreed: float, tell: Callable[[int], None],
        before: Iterable[Felt] = (), solved: int = 0,
    ) -> None:  # fmt: skip
        self.problem, self.nodes, self.agreed, self.tell = problem, nodes, agreed, tell
        self.before = {felt.radius: felt for felt in before}
        self.felt: dict[float, Felt] = {}
        self.solved, self.coarse, self.rough = solved, False, False
        self.films: dict[float, float] = {}  # of air, that the nips let through, by radius
        self.frictions: dict[float, tuple[float, float]] = {}  # that they leave

    @property
    def alone(self) -> bool:
        """Whether they answer the same on every roll."""
        return self.problem.roll_body == "linear" and self.problem.air is None

    def tension(self, radius: float, roll: RollResult | None) -> float:
        """Solve the nip at a radius on a roll; return its wound-on tension [N/m].

        It takes no roll where nips are ``alone``.
        """
        own = self.felt.get(radius)
        if self.alone and own is not None:
            return own.tension
        with _at(radius):
            linear = self.problem.roll_body == "linear"
            stage = None if roll is None or linear else stage_at(roll, radius)
            felt = solved_nip(
                self._on(roll), radius, stage, own, self._near(radius), self._solve,
                FELT_COARSELY if self.rough else FELT,
            )  # fmt: skip
        self.felt[radius] = felt
        return felt.tension

    def predict(self, radius: float, roll: RollResult) -> float:
        """Return the tension of a nip predicted on another effective roll [N/m]."""
        stage = stage_at(roll, radius)
        self.felt[radius] = predicted_nip(self._on(roll), stage, self.felt[radius])
        return self.felt[radius].tension

    def from_core_to_surface(self) -> list[Felt]:
        """Return the latest solution of every nip, from the core to the surface."""
        return [self.felt[radius] for radius in sorted(self.felt)]

    def mean_film(self) -> float:
        """Return the mean of the nips' films over the length of web [m]."""
        if not any(self.films.values()):
            return 0.0
        r = np.array(sorted(self.films))
        h = np.array([self.films[radius] for radius in r.tolist()])
        return float(np.trapezoid(h * r, r) / np.trapezoid(r, r)) if r.size > 1 else float(h[0])

    def warnings(self) -> tuple[str, ...]:
        """Return the warnings of the nips, each kind once, with its radii."""
        return warnings_of(
            [(felt.radius, felt.result.warnings) for felt in self.from_core_to_surface()]
        )

    def _on(self, roll: RollResult | None) -> WindingProblem:
        """Return the problem with the stack of a roll, air and all."""
        own = self.problem.stack
        stack = own if roll is None else roll.problem.stack
        return self.problem if stack is own else self.problem.replace(stack=stack)

    def _near(self, radius: float) -> Felt | None:
        """Return the nip nearest to a radius by the roll's depth."""
        core = self.problem.core.radius
        known = self.before or self.felt
        found = min(known, key=lambda r: abs(np.log((r - core) / (radius - core))), default=None)
        return None if found is None else known[found]

    def _solve(self, roll: Body, start: NipResult | None) -> NipResult:
        nodes = min(self.nodes, COARSE_NODES) if self.coarse else self.nodes
        nip = self.problem.nip(roll.radius, roll)
        try:
            result = self._with_its_air(nip, nodes, start)
        except NotConverged:  # as a start that is too far off may end
            if start is None:
                raise
            result = self._with_its_air(nip, nodes, None)
        self.solved += 1
        self.tell(self.solved)
        return result

    def _with_its_air(self, nip: NipProblem, nodes: int, start: NipResult | None) -> NipResult:
        """Solve a nip, with the friction that its air leaves; keep the film."""
        radius = nip.roll.radius
        if nip.air is None:
            self.films[radius] = 0.0
            return solve_nip(nip, nodes=nodes, start=start)
        near = min(self.films, key=lambda other: abs(other - radius), default=None)
        result = solve_with_film(
            nip, frictions=None if near is None else self.frictions[near], tolerance=self.agreed,
            nodes=nodes, start=start,
        )  # fmt: skip
        assert result.air is not None
        self.films[radius] = result.air.film
        self.frictions[radius] = result.air.roll_friction, result.air.wrap_friction
        return result


def warnings_of(nips: Iterable[tuple[float, tuple[str, ...]]]) -> tuple[str, ...]:
    """Return warnings at radii, each sort once, with the radii at which it comes up."""
    first: dict[str, str] = {}
    radii: dict[str, list[float]] = {}
    for radius, texts in nips:
        for text in texts:
            sort = re.sub(r"[\d.e+-]+", "", text)
            first.setdefault(sort, text)
            radii.setdefault(sort, []).append(radius)
    found = []
    for sort, text in first.items():
        mark = RESOLUTION if text.startswith(RESOLUTION) else ""
        found.append(f"{mark}{_where(radii[sort])}: {text.removeprefix(RESOLUTION)}")
    return tuple(found)


def _where(radii: list[float]) -> str:
    one = f"nip at the radius {radii[0]:.4g} m"
    if len(radii) == 1:
        return one
    return f"{one} and {len(radii) - 1} more up to {max(radii):.4g} m"


@contextmanager
def _at(radius: float) -> Iterator[None]:
    """Name the radius at which a nip fails."""
    where = f"at the radius {radius:.4g} m: "
    try:
        yield
    except InvalidProblem as fault:
        raise type(fault)([(f, where + text) for f, text in fault.faults]) from None
    except NotConverged as stop:
        raise NotConverged(where + str(stop), stop.best) from None
