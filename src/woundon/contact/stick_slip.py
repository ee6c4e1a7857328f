r"""The stick-slip problem on matrices, and the pivoting that solves it.

Unknown are the tractions q (m of them, one or two faces) and, where a resultant is prescribed, one
rigid slip xi (a creep).  The tractions load the bodies and press back on the pressure:

    p = p0 + K q                        pressure, from the normal problem
    v = c0 + D q + S p + e xi           slip at each node's collocation point
    b = mu * p[face nodes]              friction bound
    g q = F                             prescribed resultant (optional)

and each node obeys one of three laws, held in ``state``:

    stick      0    v = 0    |q| <= b
    forward   +1    q = +b   v >= 0
    backward  -1    q = -b   v <= 0

so that, for a given state, everything is one linear system

      rows of sticking nodes    [ D + S K    e ] [ q  ]   [ -(c0 + S p0) ]
      rows of slipping nodes    [ I - s mu K 0 ] [ xi ] = [  s mu p0     ]
      resultant                 [ g          0 ]          [  F           ]

This is a mixed complementarity problem.  With one face and the interlacing collocation points of
:mod:`.grid` its matrix for given xi is a P-matrix (docs, theory), for which block pivoting with a
single-pivot safeguard ends at the unique solution after finitely many steps (Judice and Pires 1994;
the single pivots are Murty's).  The resultant grows with xi.  So three steps suffice:

    1. block pivoting on the whole system, xi among the unknowns: 1 to 10 systems nearly always;
    2. where that wanders, from K = 0, where the theory holds, to the whole of K by large steps;
    3. where that fails, regula falsi on xi with block pivoting inside: slower, and safe.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from . import lapack

if TYPE_CHECKING:
    from .joint import Joint

__all__ = [
    "Ending",
    "RigidFace",
    "StickSlip",
    "StickSlipSolution",
    "keep_one_stuck",
    "solve_stick_slip",
]

Array = np.ndarray

# a law counts as kept when violated by less than this, relative to the largest bound or slip
TOLERANCE = 1e-11
LEAST_STEP = 1 / 64  # of the coupling, to which no state is followed further


class Ending(Enum):
    """How an iteration ended, and what to do next."""

    SOLVED = "every law is kept"
    CYCLE = "the iteration repeats itself: use algorithm='pivoting'"
    LIMIT = "the limit of iterations was reached; another number of nodes may do"
    SINGULAR = "a linear system was singular"


class RigidFace(NamedTuple):
    """The nodes on a rigid body, in one row, and what integrates their tractions."""

    nodes: slice
    weights: Array


class _System(NamedTuple):
    """A linear system as it was last asked for, changed in place."""

    state: Array
    matrix: Array
    right: Array


@dataclass(frozen=True, eq=False)
class StickSlip:
    """The matrices of a stick-slip problem; see the module's text for the letters.

    Attributes
    ----------
    direct : (m, m) array
        D.
    through_pressure : (m, n) array
        S.
    offset : (m,) array
        c0.
    pressure : (n,) array
        p0.
    pressure_response : (n, m) array
        K.
    friction : (m,) array
        mu of each node.
    faces : int
        Number of faces; node k of each face sees pressure k.
    creep : (m,) array or None
        e; None if no resultant is prescribed.
    resultant : (m,) array or None
        g.
    force : float
        F.
    """

    direct: Array
    through_pressure: Array
    offset: Array
    pressure: Array
    pressure_response: Array
    friction: Array
    faces: int
    creep: Array | None = None
    resultant: Array | None = None
    force: float = 0.0

    rigid: ClassVar[None] = None  # told to the joint system alone

    @cached_property
    def stick_matrix(self) -> Array:
        """D + S K."""
        if self.apart:
            return self.direct
        return self.direct + self.through_pressure @ self.pressure_response

    @cached_property
    def held(self) -> Array:
        """The nodes that feel the creep, of which one must stick."""
        return np.empty(0, dtype=int) if self.creep is None else self.creep.nonzero()[0]

    @cached_property
    def apart(self) -> bool:
        """Whether tractions leave the pressure alone, K = 0: then slipping ones are known."""
        return not self.pressure_response.any()

    @cached_property
    def stick_offset(self) -> Array:
        """c0 + S p0."""
        return self.offset + self.through_pressure @ self.pressure

    @cached_property
    def bound_offset(self) -> Array:
        """mu p0 for all faces, (m,)."""
        return self.friction * self.on_faces(self.pressure)

    def on_faces(self, values: Array) -> Array:
        """Return nodal values of the nip repeated for each face."""
        return np.concatenate([values] * self.faces)

    @cached_property
    def scale(self) -> float:
        """Slip per traction; slipping rows are multiplied by it to balance the system."""
        matrix = self.stick_matrix
        return float(max(matrix.max(), -matrix.min()))

    def system(self, state: Array) -> tuple[Array, Array]:
        """Return matrix and right side of one state, slipping rows balanced by ``scale``."""
        made = self._made
        turned = np.nonzero(state != made.state)[0]  # after the first time these are few
        made.state[turned] = state[turned]
        self._write_rows(made, turned)
        return made.matrix.copy(), made.right.copy()

    @cached_property
    def _made(self) -> _System:
        """The system asked for last; to begin with, that of all nodes in stick."""
        m, bordered = self.friction.size, self.creep is not None
        matrix, right = np.empty((m + bordered, m + bordered)), np.empty(m + bordered)
        matrix[:m, :m], right[:m] = self.stick_matrix, -self.stick_offset
        if self.creep is not None and self.resultant is not None:
            unit = self.scale / float(np.max(np.abs(self.resultant)))
            matrix[:m, m], matrix[m, m] = self.scale * self.creep, 0.0
            matrix[m, :m], right[m] = unit * self.resultant, unit * self.force
        return _System(np.zeros(m, dtype=np.int8), matrix, right)

    def _write_rows(self, made: _System, rows: Array) -> None:
        """Write the laws of some nodes: v = 0 in stick, q = s mu p in slip."""
        m, scale = self.friction.size, self.scale
        stuck, slips = (rows[made.state[rows] == 0], rows[made.state[rows] != 0])
        made.matrix[stuck, :m] = self.stick_matrix[stuck]
        made.right[stuck] = -self.stick_offset[stuck]
        sign = scale * made.state[slips]
        bound = self.pressure_response[slips % self.pressure.size]
        made.matrix[slips, :m] = (-sign * self.friction[slips])[:, None] * bound
        made.matrix[slips, slips] += scale
        made.right[slips] = sign * self.bound_offset[slips]
        if self.creep is not None:
            made.matrix[stuck, m], made.matrix[slips, m] = scale * self.creep[stuck], 0.0

    def solve(self, state: Array) -> StickSlipSolution:
        """Solve the linear system of one state."""
        if self.apart:
            return self._solve_apart(state)
        m = state.size
        matrix, right = self.system(state)
        # rows are written contiguously, so LAPACK is handed the transpose
        factor, pivots, info = lapack.dgetrf(matrix.T, overwrite_a=1)
        if info != 0:
            return StickSlipSolution.failed(state)
        unknown, _ = lapack.dgetrs(factor, pivots, right, trans=1, overwrite_b=1)
        if not np.isfinite(unknown).all():
            return StickSlipSolution.failed(state)
        creep = self.scale * float(unknown[m]) if self.creep is not None else 0.0
        return self.evaluate(state, unknown[:m], creep)

    def _solve_apart(self, state: Array) -> StickSlipSolution:
        """Solve for the sticking tractions and the creep alone, where slipping ones are known."""
        q, creep = state * self.bound_offset, 0.0
        stuck = (state == 0).nonzero()[0]
        k, bordered = stuck.size, int(self.creep is not None)
        matrix, right = np.zeros((k + bordered,) * 2), np.empty(k + bordered)
        matrix[:k, :k] = self.direct[np.ix_(stuck, stuck)]
        right[:k] = -self.stick_offset[stuck] - self.direct[stuck] @ q
        if self.creep is not None and self.resultant is not None:
            unit = self.scale / float(np.max(np.abs(self.resultant)))
            matrix[:k, k] = self.scale * self.creep[stuck]
            matrix[k, :k] = unit * self.resultant[stuck]
            right[k] = unit * (self.force - self.resultant @ q)
        if right.size:
            _, _, unknown, info = lapack.dgesv(matrix.T.copy().T, right, overwrite_b=1)
            if info != 0 or not np.isfinite(unknown).all():
                return StickSlipSolution.failed(state)
            q[stuck] = unknown[:k]
            creep = self.scale * float(unknown[k]) if bordered else 0.0
        return self.evaluate(state, q, creep)

    def evaluate(self, state: Array, traction: Array, creep: float) -> StickSlipSolution:
        """Evaluate slip and bound of given tractions."""
        slip = self.stick_offset + self.stick_matrix @ traction
        if self.creep is not None:
            slip += self.creep * creep
        slip[state == 0] = 0.0  # solved for: what is left is rounding
        pressure = self.pressure + self.pressure_response @ traction
        bound = self.friction * self.on_faces(pressure)
        return StickSlipSolution(state, traction, creep, slip, bound)


class StickSlipSolution(NamedTuple):
    """Tractions, rigid slip, slips and bounds of a state, and how it was reached.

    ``joint`` is what a joint system tells besides: factors, unknowns, further slips.
    """

    state: Array
    traction: Array
    creep: float
    slip: Array
    bound: Array
    ending: Ending = Ending.SOLVED
    solves: int = 1
    joint: Any = None

    @classmethod
    def failed(cls, state: Array) -> StickSlipSolution:
        """Return what stands for the solution of a singular system."""
        nan = np.full(state.size, np.nan)
        return cls(state, nan, np.nan, nan, nan, Ending.SINGULAR)

    @property
    def finite(self) -> bool:
        """Whether tractions were found at all."""
        return bool(np.isfinite(self.traction).all())

    def violated(self) -> Array:
        """Which nodes break the law of their state, (m,) bool."""
        # a node in stick has no slip, one that slips no slack: nodes break one law or the other
        b_tol = TOLERANCE * np.maximum.reduce(np.abs(self.bound))
        v_tol = TOLERANCE * np.maximum.reduce(np.abs(self.slip))
        over = np.abs(self.traction) > self.bound + b_tol
        return np.where(self.state == 0, over, self.state * self.slip < -v_tol)

    def flipped(self, which: Array) -> Array:
        """Return the state with the given nodes brought to the law they ask for."""
        asked = np.sign(self.traction) * (self.state == 0)
        return np.where(which, asked, self.state).astype(np.int8)


def solve_stick_slip(problem: StickSlip | Joint, start: Array | None = None) -> StickSlipSolution:
    """Find the state in which every law holds.

    Parameters
    ----------
    problem : StickSlip or Joint
    start : (m,) int array, optional
        State to begin with; all in stick by default.

    Returns
    -------
    StickSlipSolution
        With ``ending`` SOLVED, or the best that was found.
    """
    all_stick, solves = np.zeros(problem.friction.size, dtype=np.int8), 0
    # a start that leads astray is let go; from all in stick one gets to the answer nearly always
    for state in (start, all_stick) if start is not None and start.any() else (all_stick,):
        direct = _pivot(problem, state, limit=60)
        solves += direct.solves
        if direct.ending is Ending.SOLVED:
            return direct if direct.solves == solves else direct._replace(solves=solves)
    if not isinstance(problem, StickSlip):  # nearer to rounding, and then the safe way
        apart = solve_stick_slip(problem.condensed(), start)
        return apart._replace(solves=apart.solves + solves)
    coupled = _couple(problem)
    solves += coupled.solves
    if coupled.ending is Ending.SOLVED or problem.creep is None:
        return coupled._replace(solves=solves)
    bracketed = _bracket_creep(problem, direct.state, direct.creep)
    return bracketed._replace(solves=bracketed.solves + solves)


def _couple(problem: StickSlip) -> StickSlipSolution:
    """Solve without what tractions change of the pressure, then with ever more of it.

    Where it is large, of bodies far softer one way than the other, pivots may go round in a circle
    of states that all lie far from the answer; the one without it is near.
    """
    whole, part, step = problem.pressure_response, 0.0, 1.0
    without = replace(problem, pressure_response=np.zeros_like(whole))
    last = _pivot(without, np.zeros(problem.friction.size, dtype=np.int8), limit=60)
    solves = last.solves
    while part < 1 and last.ending is Ending.SOLVED and step >= LEAST_STEP:
        more = min(1.0, part + step)
        coupled = problem if more == 1 else replace(problem, pressure_response=more * whole)
        found = _pivot(coupled, last.state, limit=60)
        solves += found.solves
        if found.ending is Ending.SOLVED:
            part, last = more, found
        else:
            step /= 2
    return last._replace(ending=last.ending if part == 1 else Ending.LIMIT, solves=solves)


def _pivot(problem: StickSlip | Joint, state: Array, limit: int) -> StickSlipSolution:
    """Block pivoting; single pivots when the number of violated laws does not fall."""
    fewest, patience, solution = state.size + 1, 8, problem.solve(state)
    for solves in range(1, limit + 1):
        if solution.ending is Ending.SINGULAR:
            return solution._replace(solves=solves)
        violated = solution.violated()
        count = int(np.count_nonzero(violated))
        if count == 0:
            return solution if solves == 1 else solution._replace(solves=solves)
        single = count >= fewest and patience == 0
        if count < fewest:
            fewest, patience = count, 8
        elif single:  # Murty's rule: only the violated node of the highest index
            violated[: np.nonzero(violated)[0][-1]] = False
        else:
            patience -= 1
        state = solution.flipped(violated)
        if problem.rigid is not None and not single:
            _pass_on(problem.rigid, solution, violated, state)
        state = keep_one_stuck(problem, solution, state)
        solution = problem.solve(state)
    return solution._replace(ending=Ending.LIMIT, solves=limit)


def _pass_on(face: RigidFace, solution: StickSlipSolution, violated: Array, state: Array) -> None:
    """Turn nodes of a rigid body that cannot hold what the last one of a run of stick passes on.

    Where a web sticks to a rigid body its strain tells what each node holds, but for the last one
    of a run, which takes what is left of the force: that one alone would turn from state to state.
    What is above its bound goes to the nodes before it, until their slack holds it.
    """
    nodes, weights = face
    before, traction, bound = solution.state[nodes], solution.traction[nodes], solution.bound[nodes]
    ends = violated[nodes] & (before == 0)
    ends[:-1] &= before[1:] != 0
    for last in ends.nonzero()[0].tolist():
        way = 1 if traction[last] > 0 else -1
        over = weights * (way * traction - bound)
        held = (over[last::-1].cumsum() <= 0) | (before[last::-1] != 0)
        turned = int(held.argmax()) if held.any() else last + 1
        state[nodes][last + 1 - turned : last + 1] = way


def keep_one_stuck(problem: StickSlip | Joint, solution: StickSlipSolution, state: Array) -> Array:
    """Leave a node in stick where a resultant is prescribed: else nothing holds the creep."""
    held = problem.held
    if not held.size or np.count_nonzero(state.take(held)) < held.size:
        return state
    # the node that turns between the two directions: of those that pull against what the nodes just
    # unable to stick ask for, the one that slips least
    free = solution.state[held] == 0
    asked = np.sign(np.sum(state[held][free]))
    against = ~free & (state[held] * asked <= 0)
    distance = np.where(against if against.any() else ~free, np.abs(solution.slip[held]), np.inf)
    last = held[np.argmin(distance)] if np.isfinite(distance).any() else held[0]
    state = state.copy()
    state[last] = 0
    return state


def _bracket_creep(problem: StickSlip, start: Array, guess: float) -> StickSlipSolution:
    """Find the creep that carries the resultant, by regula falsi on a monotone function.

    For a given creep the problem is solved by pivoting; the resultant grows with the creep, from
    full slip one way to full slip the other, so a bracket exists whenever a steady state does.
    """
    search = _CreepSearch(problem, start)
    reach = float(np.max(np.abs(problem.stick_offset)))
    step, creep = 1e-3 * reach, guess if np.isfinite(guess) else 0.0
    excess = search.excess(creep)
    ends = [(creep, excess), (creep, excess)]
    while ends[0][1] * ends[1][1] > 0 and search.alive and step < 1e9 * reach:
        creep -= np.copysign(step, excess)
        step *= 2
        ends = [ends[1], (creep, search.excess(creep))]
    ends.sort()
    for _ in range(200):
        if not search.alive:
            break
        # the resultant is piecewise linear in the creep: the right piece's state solves the whole
        exact = search.whole()
        if exact.ending is Ending.SOLVED:
            return exact._replace(solves=search.solves)
        (low, f_low), (high, f_high) = ends
        creep = (low * f_high - high * f_low) / (f_high - f_low) if f_high > f_low else low
        excess = search.excess(creep)
        # Illinois: halve the value kept, or the other end would stand still
        ends = (
            [(low, f_low / 2), (creep, excess)]
            if excess > 0
            else [(creep, excess), (high, f_high / 2)]
        )
    return search.last._replace(ending=Ending.LIMIT, solves=search.solves)


class _CreepSearch:
    """Solves for given creeps, each from the state of the one before."""

    def __init__(self, problem: StickSlip, start: Array) -> None:
        self.problem, self.state, self.solves = problem, start, 0
        self.limit = 200 + 4 * start.size
        self.alive = True
        self.last: StickSlipSolution = StickSlipSolution.failed(start)

    def excess(self, creep: float) -> float:
        """Return the resultant less the prescribed one."""
        problem = self.problem
        assert problem.creep is not None
        assert problem.resultant is not None
        given = replace(
            problem, creep=None, resultant=None, offset=problem.offset + problem.creep * creep
        )
        self.last = _pivot(given, self.state, self.limit)
        self.state, self.solves = self.last.state, self.solves + self.last.solves
        self.alive = self.last.ending is Ending.SOLVED
        return float(problem.resultant @ self.last.traction) - problem.force

    def whole(self) -> StickSlipSolution:
        """Try the whole system from the state found last."""
        solution = _pivot(self.problem, self.state, limit=6)
        self.solves += solution.solves
        return solution
