r"""Semismooth Newton method (primal-dual active set) for contact with Coulomb friction.

A system on one mesh has the unknowns u, the equilibrium equations E(u) = 0, and for each traction
node a slip velocity v(u), a traction q(u) and a friction bound b(u).  The friction law

    stick (0):   v = 0         while |q| <= b
    slip (+-1):  q = s b       while s v >= 0

is one of two equations; the active set says which.  An iteration solves the linear system

    [ dE/du                      ]         [ E       ]
    [ dv/du            (stick)   ] du = -  [ v       ]
    [ dq/du - s db/du  (slip)    ]         [ q - s b ]

and then updates the active set: a sticking node whose traction exceeds its bound slips in the
direction of the traction, and a slipping node whose slip opposes its traction sticks (Hueber and
Wohlmuth 2005).  Factorisations are reused while the step shrinks (modified Newton method), and
corrected for the rows that change with the active set.

The method contains no mechanics.  All equations and unknowns are scaled to order one by
``System.scales`` and by the system itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from scipy.linalg import lapack

__all__ = ["Counts", "Iterate", "Jacobian", "NewtonFailed", "SemismoothNewton", "System"]

Array = np.ndarray

# Iterations in addition to one for each traction node: where a web slips on the wrap of a rigid
# drum, the zone boundary moves by one node in each.
MAX_ITERATIONS = 60
# An active set that returns more often cycles: then only the last violated node changes (Murty),
# and only after a small step: where a contact nearly slides, violations of 1e-9 may be errors of a
# larger step.  The error of a step is at most a tenth of it, the permitted violation below.
MOST_VISITS, SMALL_STEP = 2, 1e-9
# A factorisation is reused as long as it gains a digit in each iteration.
CONTRACTION = 0.1
# Change of ln a after which the matrices are assembled again; less changes them by about as much.
REASSEMBLE = 0.02
# Step in the units of the unknowns after which they are factorised again with a new column by ln a:
# it varies in proportion to the tractions.
LARGE_STEP = 1.0
# Share of the rows that may change with the active set until it is factorised again.
MOST_CHANGED = 0.1
# A step below this size that a new factorisation does not reduce is due to rounding.
ROUNDING = 1e-6
# Relative error of coefficients: of the tolerance, and of the size of the last step, the error of
# which it increases by so much (inexact Newton method).
COEFFICIENTS, INEXACT = 0.01, 1e-3
# Violation of an inequality, relative to the largest bound or slip, that is due to rounding.
VIOLATION = 1e-10
# Largest change of ln a in a step, about a factor of two: the column by ln a is a linearisation.
LARGEST_STEP = 0.7

_getrf, _getrs = lapack.dgetrf, lapack.dgetrs


class NewtonFailed(ArithmeticError):
    """The iteration found no solution."""


@dataclass(frozen=True, eq=False)
class Iterate:
    """A state of a system; everything but ``u`` is dimensionless.

    Attributes
    ----------
    u : (m+k,) array
        Unknowns.
    equilibrium : (m,) array
        E, the residuals of the equilibrium equations.
    slip, traction, bound : (k,) arrays
        v, q, and the friction bound b in the unit of the traction.
    """

    u: Array
    equilibrium: Array
    slip: Array
    traction: Array
    bound: Array


class Jacobian(NamedTuple):
    """Derivatives of equilibrium (m, m+k), slip and bound (k, m+k) by u."""

    equilibrium: Array
    slip: Array
    bound: Array


class System(Protocol):
    """Equations on one mesh: m equilibrium equations and k traction nodes."""

    @property
    def scales(self) -> Array:
        """Units of the unknowns, (m+k,)."""

    @property
    def traction_unknowns(self) -> Array:
        """The k unknowns that are tractions."""

    @property
    def ln_a(self) -> Array:
        """The unknown ln a of each contact."""

    @property
    def load_rows(self) -> Array:
        """The equation of the load of each contact."""

    @property
    def largest_ln_a(self) -> Array:
        """Largest ln a of each contact that is permitted."""

    @property
    def creepage_nodes(self) -> Sequence[Array]:
        """Traction nodes whose slip velocity contains an unknown creepage, for each creepage."""

    def evaluate(self, u: Array, tolerance: float) -> Any:
        """Return the :class:`Iterate` of given unknowns, with coefficients of a relative error."""

    def jacobian(self, state: Any) -> Jacobian:
        """Return the derivatives."""

    def fill_half_width_column(self, jacobian: Jacobian, state: Any) -> None:
        """Renew the derivatives by ln a, which vary with the tractions."""


@dataclass
class Counts:
    """Number of operations on one mesh."""

    iterations: int = 0
    factorisations: int = 0
    assemblies: int = 0


class SemismoothNewton:
    """Solver of one system; it keeps its factorisation between calls.

    Parameters
    ----------
    system : System
    neighbour : SemismoothNewton, optional
        Solver of a neighbouring problem with the same unknowns, whose factorisation is used as long
        as the step shrinks.
    """

    def __init__(self, system: System, neighbour: SemismoothNewton | None = None) -> None:
        self.system, self.counts = system, Counts()
        self.jacobian: Jacobian | None = None
        # half widths of that Jacobian, and size of the last step; infinite as there are none yet
        self.assembled_ln_a, self.step_size = np.full(system.ln_a.size, np.inf), np.inf
        self.jacobian_is_current = False  # True if the last step had the Jacobian of its state
        self.linear: _LinearSystem | None = neighbour.linear if neighbour else None

    # a diverging iterate may overflow; it is rejected by its residual or its step
    @np.errstate(over="ignore", invalid="ignore", divide="ignore")
    def solve(self, u: Array, active: Array, tolerance: float) -> tuple[Any, Array]:
        """Return the solution and its active set, by Newton steps and updates of the active set.

        Parameters
        ----------
        u : (m+k,) array
            Initial guess.
        active : (k,) int array
            Initial active set: 0 stick, +1 and -1 slip.
        tolerance : float
            Largest component of the last step, in the units of the unknowns.  A step does not
            depend on how the equations are scaled (affine invariance, Deuflhard 2011).

        Raises
        ------
        NewtonFailed
        """
        visits: dict[bytes, int] = {}
        self.step_size, violated = np.inf, np.ones(active.size, dtype=bool)
        coefficients = COEFFICIENTS * tolerance
        state, is_postponed = self.system.evaluate(u, coefficients), False
        for _ in range(MAX_ITERATIONS + active.size):
            self.counts.iterations += 1
            step, size = self._step(state, active)
            # with inexact coefficients a step may be small by chance; a postponed change of the
            # active set is still to be made
            if size < tolerance and coefficients <= tolerance and not is_postponed:
                return state, active
            if not np.isfinite(size):
                raise NewtonFailed("the step is not finite")
            is_settled = not violated.any() or active.tobytes() in visits  # settled, or cycles
            u = _limited_update(self.system, state.u, step, is_settled)
            coefficients = max(COEFFICIENTS * tolerance, INEXACT * size)
            state = self.system.evaluate(u, coefficients)
            violated = _violates_inequality(state, active)
            is_postponed = False
            if violated.any():
                pattern = active.tobytes()
                visits[pattern] = visits.get(pattern, 0) + 1
                cycles = visits[pattern] > MOST_VISITS
                is_postponed = cycles and size > SMALL_STEP
                if cycles:  # change the last violated node only
                    violated[: np.nonzero(violated)[0][-1]] = False
                if not is_postponed:
                    active = _next_active_set(self.system, state, active, violated)
        raise NewtonFailed(
            f"{int(violated.sum())} nodes violate the friction law; the last step is {size:.1e}"
        )

    def _step(self, state: Any, active: Array) -> tuple[Array, float]:
        """Return the Newton step, (m+k,), and its size in the units of the unknowns.

        The latest factorisation is tried first: for the same active set, and near the solution for
        one that differs in a few nodes.  If the set is the same and the step does not shrink as it
        should, the iteration has stalled, and the system is factorised with a new Jacobian.  The
        size is 0 if rounding prevents a smaller step even then.
        """
        residual = np.concatenate([state.equilibrium, friction_residual(state, active)])
        if not np.isfinite(residual).all():
            raise NewtonFailed("the residual is not finite")
        linear, last_size, was_current = self.linear, self.step_size, self.jacobian_is_current
        stalled = False
        is_same = linear is not None and np.array_equal(linear.active, active)
        if linear is not None and (
            is_same or (last_size <= LARGE_STEP and linear.serves(state, active))
        ):
            linear.set_active(active)
            step, self.step_size = linear.newton_step(residual)
            self.jacobian_is_current = False
            if not is_same or self.step_size < CONTRACTION * last_size:
                return step, self.step_size
            stalled = True
        step, self.step_size = self._factorise(state, active, stalled).newton_step(residual)
        # two steps with current Jacobians that do not shrink are due to rounding
        does_not_shrink = self.step_size > CONTRACTION * last_size
        if stalled and was_current and last_size < ROUNDING and does_not_shrink:
            return step, 0.0
        return step, self.step_size

    def _factorise(self, state: Any, active: Array, stalled: bool) -> _LinearSystem:
        """Factorise the system of an active set, with a new Jacobian if the latest one is poor.

        It is poor if the half width has changed, or if the iteration has ``stalled``: its step did
        not shrink with that Jacobian.  Otherwise only the columns of ln a are computed again.

        Parameters
        ----------
        state : Iterate
        active : (k,) int array
        stalled : bool
        """
        ln_a = state.u[self.system.ln_a]
        self.jacobian_is_current = (
            self.jacobian is None
            or stalled
            or np.abs(ln_a - self.assembled_ln_a).max() > REASSEMBLE
        )
        if self.jacobian_is_current or self.jacobian is None:
            self.jacobian, self.assembled_ln_a = self.system.jacobian(state), ln_a
            self.counts.assemblies += 1
        else:
            self.system.fill_half_width_column(self.jacobian, state)
        self.linear = _LinearSystem(self.system, self.jacobian, self.assembled_ln_a, active)
        self.counts.factorisations += 1
        return self.linear


def friction_residual(state: Iterate, active: Array) -> Array:
    """Return v of sticking nodes and q - s b of slipping nodes, (k,)."""
    return np.where(active == 0, state.slip, state.traction - active * state.bound)


def _limited_update(system: System, u: Array, step: Array, is_settled: bool) -> Array:
    """Return u + step, (m+k,), with half widths at most the largest ones permitted.

    A larger half width may be required in passing: only with ``is_settled``, when the active set
    does not change, it is an error.
    """
    ln_a, largest = system.ln_a, system.largest_ln_a
    if is_settled and ((u[ln_a] == largest) & (step[ln_a] > 0)).any():
        raise NewtonFailed("the half width exceeds the largest one permitted")
    u = u + step
    u[ln_a] = np.minimum(u[ln_a], largest)
    return u


def _violates_inequality(state: Iterate, active: Array) -> Array:
    """Return a mask of the nodes that violate the inequality of the friction law, (k,).

    A sticking node must have abs(q) <= b, a node that slips in the direction s = +-1 must have
    s v >= 0; both within a tolerance.
    """
    traction_tolerance = VIOLATION * np.abs(state.bound).max(initial=0.0)
    slip_tolerance = VIOLATION * np.abs(state.slip).max(initial=0.0)
    exceeds = np.abs(state.traction) > state.bound + traction_tolerance
    return np.where(active == 0, exceeds, active * state.slip < -slip_tolerance)


def _next_active_set(system: System, state: Iterate, active: Array, violated: Array) -> Array:
    """Return the next active set, (k,): 0 stick, +1 and -1 slip.

    A sticking node whose inequality is ``violated`` slips in the direction of its traction, and a
    slipping one sticks.

    One node whose slip contains a creepage keeps sticking: otherwise no equation determines the
    creepage, and the Jacobian is singular.
    """
    new = np.where(violated, np.sign(state.traction) * (active == 0), active).astype(np.int8)
    for creepage_nodes in system.creepage_nodes:
        if (new[creepage_nodes] == 0).any():
            continue
        sticking = creepage_nodes[active[creepage_nodes] == 0]
        # prefer a node between zones of opposite slip, where the slip velocity changes sign
        direction = np.sign(new[sticking].sum()) if sticking.size else 0
        slipping = creepage_nodes[active[creepage_nodes] != 0]
        reversals = slipping[new[slipping] * direction <= 0]
        candidates = next(set_ for set_ in (reversals, slipping, creepage_nodes) if set_.size)
        new[candidates[np.argmin(np.abs(state.slip[candidates]))]] = 0
    return new


class _LinearSystem:
    """The factorised linear system of an active set, and of others that differ in a few nodes.

    If k rows of the matrix J change by D, (k, n), with E the columns of the unit matrix for them,

        (J + E D)^-1 = J^-1 - Z (I + D Z)^-1 D J^-1,      Z = J^-1 E        (Woodbury).
    """

    def __init__(self, system: System, jacobian: Jacobian, ln_a: Array, active: Array) -> None:
        self.system, self.jacobian, self.ln_a = system, jacobian, ln_a
        self.factored = self.active = active
        matrix = system_matrix(system, jacobian, active)
        matrix *= system.scales
        self.changes = np.zeros((0, len(matrix)))  # D
        self.correction = self.changes.T  # Z (I + D Z)^-1
        # rows are contiguous, so LAPACK factorises the transpose
        self.lu, self.pivots, info = _getrf(matrix.T, overwrite_a=1)
        if info != 0:
            raise NewtonFailed("singular Jacobian")

    def serves(self, state: Any, active: Array) -> bool:
        """Return True if the factorisation can serve for another state and active set, (k,).

        The half widths must be near those of its Jacobian, and few rows may differ.
        """
        distance = np.abs(state.u[self.system.ln_a] - self.ln_a).max()
        few = MOST_CHANGED * len(self.lu)
        return bool(distance <= REASSEMBLE and np.sum(active != self.factored) <= few)

    def set_active(self, active: Array) -> None:
        """Change the active set, (k,), by a low-rank update of the factorisation.

        D are the changes of the rows of the friction law at the nodes where the set differs from
        the factorised one.
        """
        if np.array_equal(self.active, active):
            return
        self.active, nodes = active, np.nonzero(active != self.factored)[0]
        rows = len(self.jacobian.equilibrium) + nodes
        old, new = (
            friction_rows(self.system, self.jacobian, each, nodes)
            for each in (self.factored, active)
        )
        self.changes = (new - old) * self.system.scales
        units = np.zeros((len(self.lu), nodes.size))
        units[rows, np.arange(nodes.size)] = 1.0
        Z, _ = _getrs(self.lu, self.pivots, units, trans=1)
        try:
            self.correction = Z @ np.linalg.inv(np.eye(nodes.size) + self.changes @ Z)
        except np.linalg.LinAlgError as singular:
            raise NewtonFailed("singular Jacobian") from singular

    def solve(self, right: Array) -> Array:
        """Solve J x = right for a (m+k,) array; x in the units of the unknowns."""
        x, _ = _getrs(self.lu, self.pivots, right, trans=1)
        return np.asarray(x - self.correction @ (self.changes @ x))

    def newton_step(self, residual: Array) -> tuple[Array, float]:
        """Return -J^-1 r, (m+k,), and its size, with the change of each ln a limited.

        A larger change is limited by a multiple of the solution ``by_load`` for a unit residual of
        the contact's load: the equation of the load is relaxed, and all others are satisfied.
        """
        x = self.solve(-residual)
        for ln_a, load_row in zip(self.system.ln_a, self.system.load_rows, strict=True):
            if abs(x[ln_a]) > LARGEST_STEP:
                load = np.zeros(x.size)
                load[load_row] = 1.0
                by_load = self.solve(load)
                x += by_load * ((np.copysign(LARGEST_STEP, x[ln_a]) - x[ln_a]) / by_load[ln_a])
        return x * self.system.scales, float(np.abs(x).max())


def system_matrix(system: System, jacobian: Jacobian, active: Array) -> Array:
    """Return the matrix of the linear system for an active set, (m+k, m+k)."""
    rows = friction_rows(system, jacobian, active, np.arange(active.size))
    return np.concatenate([jacobian.equilibrium, rows])


def friction_rows(system: System, jacobian: Jacobian, active: Array, nodes: Array) -> Array:
    """Return the rows of the friction law of some traction nodes, (nodes, m+k)."""
    rows, slipping = jacobian.slip[nodes], np.nonzero(active[nodes])[0]
    which = nodes[slipping]
    rows[slipping] = jacobian.bound[which] * -active[which, None]
    q = system.traction_unknowns[which]
    rows[slipping, q] += 1 / system.scales[q]
    return rows
