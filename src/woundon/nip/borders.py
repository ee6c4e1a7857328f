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

from dataclasses import dataclass, replace
from functools import cached_property
from math import exp, log
from typing import Any, NamedTuple

import numpy as np

from ..contact.grid import zone_borders
from ..contact.loop import Ladder, Level
from ..contact.schemes import ELEMENTS
from ..contact.stick_slip import StickSlip, StickSlipSolution

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
    """A run of stick on a face: where it begins and ends, and the ways of the slip around it."""

    face: int
    begins: float  # -1 at the leading edge
    ends: float
    before: int
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
    """Elements between given borders of given zones, and the equations on them."""

    contact: Any
    faces: list[Face]
    half_width: float
    order: int

    @cached_property
    def ends(self) -> Array:
        """Ends of all elements."""
        inner = np.sort(np.concatenate([face.borders for face in self.faces]))
        ends = np.concatenate([[-1.0], inner, [1.0]])
        # the web's thinness leaves p a layer at the edges, a hundredth of the contact
        edges = [-1 + EDGE * (ends[1] + 1), 1 - EDGE * (1 - ends[-2])]
        kept = [edge for edge in edges if abs(edge) < 1 - EDGE * LONG]
        return np.sort(np.append(ends, kept))

    @cached_property
    def mesh(self) -> Any:
        return ELEMENTS.between(self.ends, self.order)

    @cached_property
    def equations(self) -> Any:
        return self.contact.equations(self.mesh, self.half_width, None)

    @cached_property
    def problem(self) -> StickSlip:
        return self.equations.stick_slip()

    @property
    def runs(self) -> list[Run]:
        """The runs of stick whose level is free; one that ends at the trailing edge is the roll's
        own, to which slips are referred."""
        found = []
        for f, (zones, borders) in enumerate(self.faces):
            at = [-1.0, *borders.tolist(), 1.0]
            for k, zone in enumerate(zones):
                if zone == 0 and not (f == 0 and k + 1 == len(zones)):
                    around = (zones[k - 1] if k else 0, zones[k + 1] if k + 1 < len(zones) else 0)
                    found.append(Run(f, at[k], at[k + 1], *around))
        return found

    def node(self, border: float) -> int:
        """Return the number of the node on a border."""
        return self.order * int(np.searchsorted(self.ends, border))

    @cached_property
    def state(self) -> Array:
        """The zones of all unknown tractions."""
        middle = (self.ends[1:] + self.ends[:-1]) / 2
        each = (np.array(zones)[np.searchsorted(at, middle)] for zones, at in self.faces)
        return np.concatenate([np.repeat(zone, self.order)[:-1] for zone in each]).astype(np.int8)

    def rigid(self, face: int) -> bool:
        return bool(self.contact.problem.bodies[face].rigid)

    def solve(self) -> tuple[StickSlipSolution, Array]:
        """Return the solution, and the levels of the runs."""
        problem, runs, n = self.problem, self.runs, self.mesh.unknowns
        m, scale = 2 * n, problem.scale
        base, right = problem.system(self.state)
        matrix = np.zeros((m + len(runs),) * 2)
        matrix[:m, :m] = base[:m, :m]
        right = np.append(right[:m], np.zeros(len(runs)))
        for r, run in enumerate(runs, start=m):
            first, last = self.node(run.begins), self.node(run.ends)
            # node k belongs with the cell before it, and is traction k - 1 of its face
            matrix[run.face * n + first : run.face * n + last, r] = scale
            if self.rigid(run.face):
                cells = run.face * n + np.arange(first - self.order, first)
                to_end = self.mesh.grid.element.to_right
                matrix[r, :m], matrix[r, r] = to_end @ problem.stick_matrix[cells], scale
                right[r] = -to_end @ problem.stick_offset[cells]
            else:
                bound = run.behind * scale * problem.friction[run.face * n]
                matrix[r, :m] = -bound * problem.pressure_response[last - 1]
                matrix[r, run.face * n + last - 1] += scale
                right[r] = bound * problem.pressure[last - 1]
        found = np.linalg.solve(matrix, right)
        levels = scale * found[m:]
        drum = [level for run, level in zip(runs, levels, strict=True) if run.face == 1]
        return problem.evaluate(self.state, found[:m], drum[0]), levels

    @cached_property
    def level(self) -> Level:
        return Level(self.mesh, self.equations, self.solved[0], self.contact.load, 2.0)

    @cached_property
    def solved(self) -> tuple[Any, Array]:
        solution, levels = self.solve()
        return self.equations.state(solution), levels

    def left(self) -> Array:
        """Return what the solution leaves of the conditions, in the order of borders, then of P."""
        (state, levels), problem, n = self.solved, self.problem, self.mesh.unknowns
        top, peak = self.equations.matrices.top, float(np.max(state.pressure))
        force = float(problem.resultant @ state.traction) - problem.force
        closed = {(run.face, run.ends): level for run, level in zip(self.runs, levels)}
        xi, found = state.solution.creep, []
        p = np.concatenate([[0.0], state.pressure, [0.0]])
        for f, (zones, borders) in enumerate(self.faces):
            mu, first = problem.friction[f * n], True
            q = np.concatenate([[0.0], state.traction[f * n : (f + 1) * n], [0.0]])
            for border, before, behind in zip(borders, zones, zones[1:]):
                if behind == 0:
                    k = self.node(border)
                    own = slice(k, k + self.order + 1)
                    element, excess = self.mesh.grid.element, q[own] - before * mu * p[own]
                    if self.rigid(f):
                        excess[0] = element.extrapolation @ q[own][1:] - before * mu * p[k]
                    else:
                        excess[0] = element.start_slope @ excess
                    found.append(excess[0] / (mu * peak))
                elif f == 0:
                    found.append(closed[f, border] / top)
                elif first:
                    found.append(force / self.contact.load)
                    first = False
                else:
                    found.append((closed[f, border] - xi) / top)
        found.append(log(self.equations.carried(state) / self.contact.load))
        return np.array(found)


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
            self.level = replace(layout.level, power=self.level.power)
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
        return Layout(self.contact, faces, exp(unknowns[-1]), order)

    def _settled(self, order: int) -> Layout:
        """Return the layout of this order whose conditions are kept."""
        here = self._layout(self._unknowns, order)
        left = here.left()
        for _ in range(MOST_STEPS):
            if np.max(np.abs(left)) < CLOSE:
                return here
            if self._jacobian is None:
                self._jacobian = self._differences(left, order)
            step = -np.linalg.solve(self._jacobian, left)
            step *= min(1.0, float(np.min(self._room() / np.maximum(np.abs(step), 1e-300))))
            here = self._layout(self._unknowns + step, order)
            new = here.left()
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
            made[:, k] = (self._layout(moved, order).left() - left) / STEP
        return made

    def _room(self) -> Array:
        """Return how far each unknown may go in one step: elements shrink to a tenth at most."""
        borders = self._unknowns[:-1]
        at = np.argsort(borders)
        gaps = np.diff(np.concatenate([[-1.0], borders[at], [1.0]]))
        room = np.full(self._unknowns.size, 0.3)
        room[at] = 0.45 * np.minimum(gaps[1:], gaps[:-1])
        return room
