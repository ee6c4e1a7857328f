"""A nip on Chebyshev elements between given borders of given zones; :mod:`.borders` finds them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import log
from typing import Any, NamedTuple

import numpy as np

from ..contact.grid import zone_borders
from ..contact.loop import Level
from ..contact.meshes import ElementMesh
from ..contact.response import padded
from ..contact.schemes import ELEMENTS
from ..contact.stick_slip import StickSlipSolution
from ..two_bodies import Matrices, PairState
from .equations import NipEquations, NipMatrices

__all__ = ["Face", "Layout", "Unsettled", "faces_of"]

Array = np.ndarray

SHORTEST = 1e-7  # element
GROWTH, CUT = 12.0, 5.0  # elements are cut that are so much longer than one beside; to how much
NEAR = 0.1  # the first nodes behind a border are a hundredth of the element away


class Unsettled(ArithmeticError):
    """The borders were not found: zones appear, vanish or collide."""


class Face(NamedTuple):
    """The zones of a face from the leading edge on, and the borders between them."""

    zones: tuple[int, ...]
    borders: Array


class Run(NamedTuple):
    """A run of stick on a face, by nodes, and the way of the slip behind it."""

    face: int
    first: int  # the node where it begins
    last: int
    behind: int


def faces_of(level: Level) -> list[Face]:
    """Return the zones of both faces of a solved mesh."""
    solution, found, first = level.state.solution, [], 0
    slack = solution.bound - np.abs(solution.traction)
    bodies = level.equations.problem.bodies
    for face, body in zip(level.equations.faces, bodies, strict=True):
        own = slice(first, first + face.size)
        nodes, zones = np.concatenate([[-1.0], face, [1.0]]), solution.state[own]
        changes = np.nonzero(np.diff(zones))[0]
        kinds = [int(zones[0]), *(int(zones[k + 1]) for k in changes)]
        borders = zone_borders(nodes, zones, slack[own]).tolist()
        first += face.size
        if not body.rigid:
            _part_slips(kinds, borders)
        else:
            _slip_before(level.equations.problem, level.half_width, kinds, borders)
        found.append(Face(tuple(kinds), np.array(borders)))
    return found


def _slip_before(problem: Any, half_width: float, kinds: list[int], borders: list[float]) -> None:
    """Put slip before stick that begins at the leading edge of a rigid body.

    There the web's strain -c12 p' is held by a traction, more than friction allows as p is nil.
    """
    if kinds[0]:
        return
    web, thickness = problem.web.compliance, problem.web.thickness
    length = thickness * abs(web.c12) / (web.c11 * problem.drum_friction * half_width)
    kinds.insert(0, 1 if web.c12 > 0 else -1)
    first = borders[0] if borders else 1.0
    borders.insert(0, min(length, 0.5 * (first + 1)) - 1)


def _part_slips(kinds: list[int], borders: list[float]) -> None:
    """Put stick between slip one way and slip the other, too short for the mesh to show."""
    for k in reversed(range(len(borders))):
        if kinds[k] and kinds[k + 1]:
            around = [-1.0, *borders, 1.0]
            half = 0.25 * min(around[k + 1] - around[k], around[k + 2] - around[k + 1])
            borders[k : k + 1] = [borders[k] - half, borders[k] + half]
            kinds.insert(k + 1, 0)


def layer(problem: Any) -> float:
    """Return the length on which the web's thinning weighs against the bodies' compliance [m]."""
    return float(-problem.thinning / sum(body.compliance for body in problem.bodies))


def graded(ends: Array, layer: float) -> Array:
    """Cut elements much longer than those beside them, or than the layer at the contact's edges.

    What leaves a border varies over the length of the shorter element; at an edge of the contact,
    over the length on which the web's thinning tells.
    """
    lengths = [layer, *np.diff(ends).tolist(), layer]
    made = [-1.0]
    for k, _length in enumerate(lengths[1:-1]):
        before, behind = lengths[k], lengths[k + 2]
        low, high, cuts = float(ends[k]), float(ends[k + 1]), [float(ends[k + 1])]
        while high - low > GROWTH * min(before, behind):
            if before <= behind:
                before *= CUT
                low += before
                made.append(low)
            else:
                behind *= CUT
                high -= behind
                cuts.insert(0, high)
        made += cuts
    return np.array(made)


def _layers(ends: Array, about: Array) -> Array:
    """Cut what lies on either side of some ends into a short element and the rest."""
    k = np.searchsorted(ends, about)
    before, behind = (ends[k] - ends[k - 1]) / GROWTH, (ends[k + 1] - ends[k]) / GROWTH
    return np.unique(np.concatenate([ends, about - before, about + behind]))


@dataclass(frozen=True, eq=False)
class Layout:
    """Elements between given borders of given zones, and the equations on them.

    With tractions put in where they slip, unknown are p, the shift, q where it sticks, and levels:

                       p         shift   q      levels
        [ slope_p + slope_q s mu   1   slope_q    0   ]    indentation      N
        [ through + direct s mu    0   direct     1   ]    sticking nodes
        [          .               0     .        .   ]    what closes a run
    """

    problem: Any
    faces: list[Face]
    half_width: float
    mesh: ElementMesh

    @classmethod
    def between(
        cls, problem: Any, faces: list[Face], half_width: float, order: int, layered: bool = False
    ) -> Layout:
        """Return the layout of elements of this order; layered, short ones lie about borders."""
        inner = np.sort(np.concatenate([face.borders for face in faces]))
        ends = np.concatenate([[-1.0], inner, [1.0]])
        if np.diff(ends).min() < SHORTEST:
            raise Unsettled("borders of zones collide")
        made = graded(ends, layer(problem) / half_width)
        if layered:
            sharp = [  # where stick begins, and where a traction may jump
                face.borders[(np.array(face.zones[1:]) == 0) | body.rigid]
                for face, body in zip(faces, problem.bodies, strict=True)
            ]
            made = _layers(made, np.concatenate(sharp))
        return cls(problem, faces, half_width, ELEMENTS.between(made, order))

    @cached_property
    def made(self) -> Matrices:
        """The nip's matrices."""
        return NipMatrices.at(self.problem, self.mesh, self.half_width)

    @property
    def order(self) -> int:
        """Cells of an element."""
        return self.mesh.grid.order

    @cached_property
    def friction(self) -> tuple[float, float]:
        """mu+ and mu-."""
        return self.problem.roll_friction, self.problem.drum_friction

    @cached_property
    def state(self) -> Array:
        """The zones of all unknown tractions, (2n,)."""
        borders = self.mesh.grid.borders
        middle = (borders[1:] + borders[:-1]) / 2
        each = (np.array(zones)[np.searchsorted(at, middle)] for zones, at in self.faces)
        return np.concatenate([np.repeat(zone, self.order)[:-1] for zone in each]).astype(np.int8)

    @cached_property
    def runs(self) -> list[Run]:
        """The runs of stick of both faces.

        But for one of the roll that ends at the trailing edge, to which its slips are referred.
        """
        found = []
        for f, (zones, borders) in enumerate(self.faces):
            at = [-1.0, *borders.tolist(), 1.0]
            for k, zone in enumerate(zones):
                if zone == 0 and not (f == 0 and k + 1 == len(zones)):
                    behind = zones[k + 1] if k + 1 < len(zones) else 0
                    found.append(Run(f, self.node(at[k]), self.node(at[k + 1]), behind))
        return found

    def refuse(self) -> None:
        """Raise for zones whose borders these conditions do not tell."""
        for f, ((zones, _), body) in enumerate(zip(self.faces, self.problem.bodies, strict=True)):
            turns = any(before and behind for before, behind in pairwise(zones))
            if (
                (turns and not body.rigid)
                or (body.rigid and zones[0] == 0)
                or (f and (zones[-1] == 0 or not (0 in zones or turns)))
            ):
                raise Unsettled("borders of a kind that elements do not know")

    def node(self, border: float) -> int:
        """Return the number of the node on a border."""
        return self.order * int(np.searchsorted(self.mesh.grid.borders, border))

    @cached_property
    def slipping(self) -> Array:
        """S mu of the tractions that slip, 0 of those that stick, (2n,)."""
        return self.state * np.repeat(self.friction, self.mesh.unknowns)

    def _by_unknowns(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return what acts on pressures and sticking tractions, by rows for p and all q."""
        n, s = self.mesh.unknowns, self.slipping
        return p + q[:, :n] * s[:n] + q[:, n:] * s[n:], q[:, self.state == 0]

    def _system(self, scale: float) -> tuple[Array, Array]:
        """Return the matrix of the class's text and the right side; lengths in units of scale."""
        made, N, held = self.made, self.mesh.unknowns + 1, np.nonzero(self.state == 0)[0]
        sticks = slice(N, N + held.size)
        size = sticks.stop + len(self.runs)
        matrix, right = np.zeros((size, size)), np.zeros(size)
        matrix[:N, : N - 1], matrix[:N, sticks] = self._by_unknowns(made.slope_p, made.slope_q)
        matrix[:N, N - 1], right[:N] = scale, made.gap
        by_p, by_q = made.through_pressure[held], made.direct[held]
        matrix[sticks, : N - 1], matrix[sticks, sticks] = self._by_unknowns(by_p, by_q)
        # node k belongs with the cell before it, and is traction k - 1 of its face
        place = np.cumsum(self.state == 0) - 1 + N
        for r, run in enumerate(self.runs, start=sticks.stop):
            first, last = run.face * (N - 1) + run.first, run.face * (N - 1) + run.last
            matrix[place[first:last], r] = scale
            if self.problem.bodies[run.face].rigid:
                cells, to_end = slice(first - self.order, first), self.mesh.grid.element.to_right
                by_p, by_q = to_end @ made.through_pressure[cells], to_end @ made.direct[cells]
                both = self._by_unknowns(by_p[None], by_q[None])
                matrix[r, : N - 1], matrix[r, sticks] = both[0][0], both[1][0]
                matrix[r, r] = scale
            else:
                matrix[r, place[last - 1]] = scale
                matrix[r, run.last - 1] = -scale * run.behind * self.friction[run.face]
        return matrix, right

    @cached_property
    def solved(self) -> tuple[PairState, Array]:
        """The state, and the levels of the runs."""
        made, n, stuck = self.made, self.mesh.unknowns, self.state == 0
        scale = float(np.max(np.abs(made.direct)))
        found = np.linalg.solve(*self._system(scale))
        p, levels = found[:n], scale * found[found.size - len(self.runs) :]
        q = self.slipping * np.tile(p, 2)
        q[stuck] = found[n + 1 : found.size - len(self.runs)]
        of_drum = (float(x) for run, x in zip(self.runs, levels, strict=True) if run.face == 1)
        creep = next(of_drum, None)
        if creep is None:  # the drum's surface slips all along, and turns where it has none
            zones, borders = self.faces[1]
            turn = next(b for b, (x, y) in zip(borders, pairwise(zones), strict=True) if x and y)
            creep = -self._at(1, turn, made.slips(p, q, 0.0))
        slip = made.slips(p, q, creep)[: 2 * n]
        slip[stuck] = 0.0  # solved for: what is left is rounding
        bound = np.repeat(self.friction, n) * np.tile(p, 2)
        solution = StickSlipSolution(self.state, q, creep, slip, bound)
        state = PairState(self.half_width, solution, p, float(scale * found[n]), made.loads(p, q))
        return state, levels

    @cached_property
    def left(self) -> Array:
        """What the solution leaves of the conditions, in the order of borders, then that of P."""
        (state, levels), made, n = self.solved, self.made, self.mesh.unknowns
        P, carried = self.problem.nip_load, float(made.weights @ state.pressure)
        p, peak = padded(state.pressure), float(np.max(state.pressure))
        closed = {(run.face, run.last): x for run, x in zip(self.runs, levels, strict=True)}
        found = []
        for f, (zones, borders) in enumerate(self.faces):
            mu, q, first = self.friction[f], padded(state.traction[f * n : (f + 1) * n]), True
            for border, before, behind in zip(borders, zones[:-1], zones[1:], strict=True):
                k = self.node(border)
                if behind == 0:
                    found.append(NEAR * self._entry(f, k, q, before * mu * p) / (mu * peak))
                elif f and first and (not before or 0 not in zones):
                    # F in proportion to the load that this half width carries
                    force = self._force(q[1:-1]) / carried
                    found.append(force - self.problem.winding_force / P)
                    first = False
                elif before:  # slip turns, on a rigid body
                    found.append(self._at(f, border, state.solution.slip) / made.top)
                elif f == 0:
                    found.append(closed[f, k] / made.top)
                else:
                    found.append((closed[f, k] - state.solution.creep) / made.top)
        return np.array([*found, log(carried / P)])

    def _at(self, face: int, border: float, slips: Array) -> float:
        """Return the slip of a face at a border, by the cells before it."""
        last = face * self.mesh.unknowns + self.node(border)
        return float(self.mesh.grid.element.to_right @ slips[last - self.order : last])

    def _entry(self, face: int, node: int, q: Array, bound: Array) -> float:
        """Return what must be nil where stick begins at a node, by q and s mu p."""
        grid, own = self.mesh.grid, slice(node, node + self.order + 1)
        if self.problem.bodies[face].rigid:
            return float(grid.element.extrapolation @ q[own][1:] - bound[node])
        # by the root of the distance: whatever the length of the element, which others may cut
        root = np.sqrt(grid.lengths[node // self.order])
        return float(grid.element.start_slope @ (q - bound)[own] / root)

    def _force(self, q_drum: Array) -> float:
        drum = self.mesh.facing(self.problem.drum.rigid)
        return float(self.half_width * drum.grid.weights @ q_drum)

    @property
    def broken(self) -> float:
        """The largest violation of a law of friction, as the certificate measures it."""
        solution, n = self.solved[0].solution, self.mesh.unknowns
        unit = np.repeat(self.friction, n) * np.max(self.solved[0].pressure)
        excess = (np.abs(solution.traction) - solution.bound) / unit
        against = -solution.state * solution.slip / self.made.top
        return float(np.max(np.where(solution.state == 0, excess, against)))

    def asked(self) -> list[Face]:
        """Return the zones that nodes ask for whose law is broken, known borders as they are."""
        solution, n, x = self.solved[0].solution, self.mesh.unknowns, self.mesh.nodes
        state, found = solution.flipped(solution.violated()), []
        for f, (_, borders) in enumerate(self.faces):
            own = state[f * n : (f + 1) * n]
            changes = np.nonzero(np.diff(own))[0]
            between = (x[changes + 1] + x[changes + 2]) / 2
            at = [
                x[k + 1] if x[k + 1] in borders else y
                for k, y in zip(changes, between, strict=True)
            ]
            kinds, at = [int(own[0]), *(int(own[k + 1]) for k in changes)], [float(b) for b in at]
            if f and not kinds[-1] and len(kinds) > 1:  # at the edge nothing holds: slip turns
                kinds, at = [*kinds, -kinds[-2]], [*at, (at[-1] + 1) / 2]
            if self.problem.bodies[f].rigid:
                _slip_before(self.problem, self.half_width, kinds, at)
            else:
                _part_slips(kinds, at)
            found.append(Face(tuple(kinds), np.array(at)))
        return found

    def level(self, contact: Any, power: float) -> Level:
        """Return what the loop knows of a solved mesh."""
        equations = NipEquations(self.problem, self.mesh, self.made)
        return Level(self.mesh, equations, self.solved[0], contact.load, power)
