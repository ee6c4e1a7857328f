r"""A nip on Chebyshev elements: the borders of its zones and its half width are the unknowns.

Between given borders stick and slip are known, so that for a given half width the equations are
linear.  Every run of stick keeps a slip of its own, its level, which is free, and closes by a
condition at one of its ends; so tractions stay bounded whatever the borders are:

                       on an elastic body                     on a rigid body
    closed by          q = s mu p where stick ends            v = level where stick begins

With s the way of the slip, these are left for Newton's method, one for each border and for a:

    stick begins       d(q - s mu p)/dr = 0 at its side       q = s mu p at its side
    stick ends         level = 0 at the roll; at the drum int q- = F, and all levels = xi
    half width         int p = P

On an elastic body a traction is continuous, and where material leaves a stick zone it goes like the
root of the distance; where material enters one it must go like its power 3/2, or the slip before it
would be the wrong way.  On a rigid body nothing but the web holds a traction: it may jump where
stick ends, and is continuous where stick begins, as v there has no kink.

The conditions are few, so their Jacobian is taken once by differences and kept up by Broyden's
formula, from one order to the next.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import exp, log
from typing import Any, NamedTuple

import numpy as np

from ..contact.grid import zone_borders
from ..contact.loop import Ladder, Level
from ..contact.response import padded
from ..contact.schemes import ELEMENTS, ElementMesh
from ..contact.stick_slip import StickSlipSolution
from ..two_bodies import Matrices, PairState
from .equations import NipEquations, NipMatrices

__all__ = ["Face", "OnElements", "Unsettled", "faces_of"]

Array = np.ndarray

EDGE = 0.1  # share of a long element at an edge that is made one of its own
LONG = 0.2
ORDERS = (12, 17, 24, 34)
RATE = 4  # errors fall at least like order^-RATE
CLOSE = 2e-9  # the certificate allows 1e-8
STEP = 1e-6  # of borders and ln a, for the Jacobian
MOST_STEPS = 12  # on one order
LEAST_GAIN = 0.3  # a step that leaves more asks for a new Jacobian


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
    for face in level.equations.faces:
        own = slice(first, first + face.size)
        nodes, zones = np.concatenate([[-1.0], face, [1.0]]), solution.state[own]
        changes = np.nonzero(np.diff(zones))[0]
        kinds = (int(zones[0]), *(int(zones[k + 1]) for k in changes))
        found.append(Face(kinds, zone_borders(nodes, zones, slack[own])))
        first += face.size
    return found


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
    def between(cls, problem: Any, faces: list[Face], half_width: float, order: int) -> Layout:
        """Return the layout of elements of this order."""
        inner = np.sort(np.concatenate([face.borders for face in faces]))
        ends = np.concatenate([[-1.0], inner, [1.0]])
        # the web's thinness leaves p a layer at the edges, a hundredth of the contact
        edges = [-1 + EDGE * (ends[1] + 1), 1 - EDGE * (1 - ends[-2])]
        kept = [edge for edge in edges if abs(edge) < 1 - EDGE * LONG]
        return cls(problem, faces, half_width, ELEMENTS.between(np.sort(np.append(ends, kept)), order))

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

    def node(self, border: float) -> int:
        """Return the number of the node on a border."""
        return self.order * int(np.searchsorted(self.mesh.grid.borders, border))

    @cached_property
    def solved(self) -> tuple[PairState, Array]:
        """The state, and the levels of the runs."""
        made, n, runs, stuck = self.made, self.mesh.unknowns, self.runs, self.state == 0
        rigid = [body.rigid for body in self.problem.bodies]
        slipping = self.state * np.repeat(self.friction, n)  # s mu, 0 in stick

        def columns(p: Array, q: Array) -> tuple[Array, Array]:
            return p + q[:, :n] * slipping[:n] + q[:, n:] * slipping[n:], q[:, stuck]

        N, sticks = n + 1, int(np.count_nonzero(stuck))
        size, scale = N + sticks + len(runs), float(np.max(np.abs(made.direct)))
        matrix, right = np.zeros((size, size)), np.zeros(size)
        matrix[:N, :n], matrix[:N, N : N + sticks] = columns(made.slope_p, made.slope_q)
        matrix[:N, n], right[:N] = scale, made.gap
        rows = slice(N, N + sticks)
        held = np.nonzero(stuck)[0]
        matrix[rows, :n], matrix[rows, rows] = columns(made.through_pressure[held], made.direct[held])
        place = np.cumsum(stuck) - 1 + N  # of a sticking traction among the unknowns
        for r, run in enumerate(runs, start=N + sticks):
            first, last = run.face * n + run.first, run.face * n + run.last
            # node k belongs with the cell before it, and is traction k - 1 of its face
            matrix[place[first : last], r] = scale
            if rigid[run.face]:
                cells, to_end = np.arange(first - self.order, first), self.mesh.grid.element.to_right
                by_p = to_end @ made.through_pressure[cells]
                by_q = to_end @ made.direct[cells]
                matrix[r, :n], matrix[r, rows] = (
                    part[0] for part in columns(by_p[None], by_q[None])
                )
                matrix[r, r] = scale
            else:
                matrix[r, place[last - 1]] = scale
                matrix[r, run.last - 1] = -scale * run.behind * self.friction[run.face]
        found = np.linalg.solve(matrix, right)
        p, levels = found[:n], scale * found[N + sticks :]
        q = slipping * np.tile(p, 2)
        q[stuck] = found[rows]
        creep = next(float(x) for run, x in zip(runs, levels, strict=True) if run.face == 1)
        slip = made.slips(p, q, creep)[: 2 * n]
        slip[stuck] = 0.0
        bound = np.repeat(self.friction, n) * np.tile(p, 2)
        solution = StickSlipSolution(self.state, q, creep, slip, bound)
        state = PairState(self.half_width, solution, p, float(scale * found[n]), made.loads(p, q))
        return state, levels

    @property
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
                    found.append(self._entry(f, q[k:], before * mu * p[k:]) / (mu * peak))
                elif f == 0:
                    found.append(closed[f, k] / made.top)
                elif first:
                    # F in proportion to the load that this half width carries
                    force = self._force(q[1:-1]) / carried
                    found.append(force - self.problem.winding_force / P)
                    first = False
                else:
                    found.append((closed[f, k] - state.solution.creep) / made.top)
        return np.array([*found, log(carried / P)])

    def _entry(self, face: int, q: Array, bound: Array) -> float:
        """Return what must be nil where stick begins, by q and s mu p from there on."""
        element, own = self.mesh.grid.element, slice(0, self.order + 1)
        if self.problem.bodies[face].rigid:
            return float(element.extrapolation @ q[own][1:] - bound[0])
        return float(element.start_slope @ (q - bound)[own])

    def _force(self, q_drum: Array) -> float:
        drum = self.mesh.facing(self.problem.drum.rigid)
        return float(self.half_width * drum.grid.weights @ q_drum)

    def level(self, contact: Any, power: float) -> Level:
        """Return what the loop knows of a solved mesh."""
        equations = NipEquations(self.problem, self.mesh, self.made, np.empty(0))
        return Level(self.mesh, equations, self.solved[0], contact.load, power)


class OnElements(Ladder):
    """Solves a nip on elements of one order after another, from a solved mesh.

    Parameters
    ----------
    ladder : Ladder
        That solved the mesh; it is left as it is.
    """

    def __init__(self, ladder: Ladder) -> None:
        self.__dict__.update(ladder.__dict__)
        self.scheme, self.history = ELEMENTS, []
        self.faces = faces_of(ladder.level)
        borders = [face.borders for face in self.faces]
        self._unknowns = np.concatenate([*borders, [log(ladder.level.half_width)]])
        self._jacobian: Array | None = None

    def refine(self, rtol: float) -> None:
        """Raise the order until the target's told error is below rtol.

        Raises
        ------
        Unsettled
            Where borders are not found, or the last order does not reach rtol.
        """
        for k, order in enumerate(ORDERS):
            layout = self._settled(order)
            self.level = layout.level(self.contact, self.level.power)
            self.history.append(self.contact.scalars(self.level))
            if k:
                self._tell_by(ORDERS[k - 1] / order)
                if self.reached(rtol):
                    return
        raise Unsettled("the last order does not reach rtol")

    def _tell_by(self, share: float) -> None:
        """Take the values of the last order, and tell their errors from the change."""
        self.values = dict(self.history[-1])
        left = share**RATE / (1 - share**RATE)
        for name, value in self.values.items():
            self.errors[name] = left * abs(value - self.history[-2][name])

    def _layout(self, unknowns: Array, order: int) -> Layout:
        cuts = np.cumsum([face.borders.size for face in self.faces])
        parts = np.split(unknowns[:-1], cuts[:-1])
        faces = [Face(face.zones, part) for face, part in zip(self.faces, parts, strict=True)]
        self.solves += 1
        return Layout.between(self.contact.problem, faces, exp(unknowns[-1]), order)

    def _settled(self, order: int) -> Layout:
        """Return the layout of this order whose conditions are kept."""
        here = self._layout(self._unknowns, order)
        left = here.left
        for _ in range(MOST_STEPS):
            if np.max(np.abs(left)) < CLOSE:
                return here
            if self._jacobian is None:
                self._jacobian = self._differences(left, order)
            step = -np.linalg.solve(self._jacobian, left)
            step *= min(1.0, float(np.min(self._room() / np.maximum(np.abs(step), 1e-300))))
            here = self._layout(self._unknowns + step, order)
            new = here.left
            self._unknowns = self._unknowns + step
            if np.max(np.abs(new)) > LEAST_GAIN * np.max(np.abs(left)):
                self._jacobian = None
            else:
                miss = new - left - self._jacobian @ step
                self._jacobian = self._jacobian + np.outer(miss, step) / (step @ step)
            left = new
        raise Unsettled("the borders of the zones did not settle")

    def _differences(self, left: Array, order: int) -> Array:
        made = np.empty((self._unknowns.size,) * 2)
        for k in range(made.shape[0]):
            moved = self._unknowns.copy()
            moved[k] += STEP
            made[:, k] = (self._layout(moved, order).left - left) / STEP
        return made

    def _room(self) -> Array:
        """Return how far each unknown may go in one step: elements shrink to a tenth at most."""
        borders = self._unknowns[:-1]
        at = np.argsort(borders)
        gaps = np.diff(np.concatenate([[-1.0], borders[at], [1.0]]))
        room = np.full(self._unknowns.size, 0.3)
        room[at] = 0.45 * np.minimum(gaps[1:], gaps[:-1])
        return room
