r"""The equations of the nip with the web wrapped on the roll behind it and on the drum before it.

The web is a wire: it carries its tension T along curved surfaces and weighs on them,

    dT/ds = q+ + q-          p+ = p- + T kappa        (thesis eq. 139)

where p+ presses the roll, p- the drum, and kappa is the web's curvature, centre on the roll's side:
that of the deformed roll where the web touches it, minus that of the drum where it touches only the
drum.  Along the web, from the drum's arc through the nip to the far side of the roll:

                       drum's arc            nip                        roll's arc
    pressures     p- = T kappa2, p+ = 0   p+ - p- = T kappa1        p+ = T kappa1, p- = 0
    geometry                              indentation (82)'
    slip at drum  eps - eps2 + xi-        the same
    slip at roll                          eps - eps1 - [eps - eps1](far)   the same

(the last: thesis eq. 96) with eps = c11 T/(2h) - c12 p+ everywhere.  p+ begins with zero at the
leading edge; at the trailing edge it goes over into the hoop pressure while p- ends with a jump.

T kappa is the only product of unknowns.  It is linearised about a known (T0, kappa0),

    T kappa  ~  T0 kappa + kappa0 (T - T0),

which leaves, as in the plain nip, a linear normal problem for z = (p+, p-, Delta/R*), z = z0 + Z q,
and a stick-slip problem in q = (q+, q-).  A few such Newton steps, taken together with those for
the half width, settle it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..contact import lapack
from ..contact.response import Tractions
from ..contact.stick_slip import StickSlip, StickSlipSolution
from .columns import WrapColumns
from .face import Face
from .grid import grid_for
from .joint import WrapJoint
from .laws import Along, WrapLaws

__all__ = ["Known", "WrapEquations", "WrapState"]

Array = np.ndarray

# below, tractions drown in the rounding of the pressures if both are solved for together
LEAST_FRICTION = 0.01

# matrices of linear bodies and of the web that do not depend on what is known
UNMOVED = frozenset({
    "friction", "force_weights", "indentation", "laws", "load_weights",
    "node_slips", "slip_offset", "slips", "tension_q", "web", "weighs",
})  # fmt: skip


@dataclass(frozen=True, eq=False)
class Known:
    """What the equations are linearised about, on all nodes.

    Attributes
    ----------
    tension, bend : (N+1,) arrays
        T0 [N/m] and kappa0 [1/m].
    roll, drum : Tractions, optional
        Loads of the bodies; only those that are not linear ask for them.
    """

    tension: Array
    bend: Array
    roll: Tractions | None = None
    drum: Tractions | None = None


@dataclass(frozen=True, eq=False)
class WrapState:
    """A solved contact; arrays over all nodes, zero where a face has none."""

    half_width: float
    solution: StickSlipSolution
    along: Along
    shift: float  # Delta/R*
    roll_slip: Array  # nan where a face has no contact
    drum_slip: Array

    @property
    def pressure(self) -> Array:
        """p- on the drum, that of the nip and its largest."""
        return self.along.drum_loads.pressure

    @property
    def known(self) -> Known:
        """What to linearise about next."""
        along = self.along
        return Known(along.tension, along.bend, along.roll_loads, along.drum_loads)


@dataclass(frozen=True, eq=False)
class WrapEquations(WrapColumns):
    """The equations for one half width, linearised about a tension and a curvature.

    Matrices are made when they are asked for; what given unknowns leave, :attr:`laws` tell without.
    """

    about: Known

    @cached_property
    def laws(self) -> WrapLaws:
        """The same at given unknowns."""
        about, problem = self.about, self.problem
        return WrapLaws(problem, self.grid, self.half_width, about.roll, about.drum)

    @property
    def roll(self) -> Face:
        """The roll's matrices."""
        return self.laws.roll.matrices

    @property
    def drum(self) -> Face:
        """The drum's matrices."""
        return self.laws.drum.matrices

    # ---- linear maps from z and q --------------------------------------------------------------

    @cached_property
    def tension_q(self) -> Array:
        """T at the nodes less T_in, (N+1, m)."""
        grid, columns, weights = self.grid, self.columns, self.half_width * self.grid.weights
        out = self.numbers.upstream_of_nodes * weights[columns]
        # a node's traction belongs half to the cell before it
        out[columns, np.arange(columns.size)] = (self.half_width / 2) * grid.cells[columns - 1]
        return out

    @cached_property
    def indentation(self) -> tuple[Array, Array, Array]:
        """The gap's slope in the nip's cells (M,) and what closes it, by z and by q."""
        cells = self.grid.last - self.grid.first
        by_z, by_q = self._none(cells)
        return self.put_indentation(by_z, by_q), by_z, by_q

    def _none(self, rows: int) -> tuple[Array, Array]:
        """Return zeros by z and by q."""
        return np.zeros((rows, self.load_weights.size)), np.zeros((rows, self.columns.size))

    def put_indentation(self, by_z: Array, by_q: Array) -> Array:
        """Put what closes the gap's slope into rows of zeros; return the slope, (M,)."""
        problem, grid, web, a = self.problem, self.grid, self.web, self.half_width
        n_p, n_q = self.roll_nodes.size, self.roll_q.size
        cells = slice(grid.first, grid.last)  # in the row of all cells
        own = slice(0, grid.last - grid.first)  # among the roll's
        gap = grid.points[cells] * (a / problem.contact_radius)
        gap = gap - self.roll.slope[own] - self.drum.slope[cells]
        by_q[:] = web.c12 * self.by_q(grid.value, cells)
        known, nip = self.about.roll, slice(grid.first, grid.last + 1)
        p = np.zeros(gap.size + 1) if known is None else np.maximum(known.pressure[nip], 0.0)
        thinned, by_p = problem.web.thinned(p)
        length, k = a * grid.cells[cells], np.arange(gap.size)
        by_z[k, k] = by_p[:-1] / length
        by_z[k, k + 1] = by_p[1:] / -length
        if not problem.web.linear:
            gap = gap + np.diff(thinned - by_p * p) / length
        by_z[:, -1] = 1.0
        if not problem.roll.rigid:
            by_z[:, :n_p] += self.roll.slope_p[own]
            by_q[:, :n_q] += self.roll.slope_q[own, 1:-1]
        if not problem.drum.rigid:
            by_z[:, n_p:-1] = self.drum.slope_p[cells, self.drum_p]
            by_q[:, n_q:] += self.drum.slope_q[cells, 1:-1]
        return gap

    def balance(self) -> tuple[Array, Array, Array]:
        """Return the web's normal balance p+ - p- - T kappa = 0, one row a node: constant, z, q."""
        by_z, by_q = self._none(self.grid.size)
        return self.put_balance(by_z, by_q), by_z, by_q

    def put_balance(self, by_z: Array, by_q: Array, size: float = 1.0) -> Array:
        """Put the web's normal balance, times a size, into rows of zeros; return the constant.

        T kappa is linearised.  The web bends with the roll behind the nip, with the drum before it
        and inside it.  There the surfaces differ by the web's change of thickness; that they share
        the drum's curvature is exact for a rigid drum.  Inside a nip of a rigid roll the web bends
        with the roll.
        """
        grid, roll, drum, problem = self.grid, self.roll, self.drum, self.problem
        n_p, n_q, first = self.roll_nodes.size, self.roll_q.size, grid.first
        by_z[self.roll_nodes, np.arange(n_p)] = size
        by_z[self.drum_nodes, n_p + np.arange(self.drum_nodes.size)] = -size
        if not self.weighs.any():
            return np.zeros(grid.size)
        T, bend = (np.where(self.weighs, -size * part, 0.0)
                   for part in (self.about.tension, self.about.bend))  # fmt: skip
        turn = first + 1 if problem.roll.rigid else grid.last
        behind, before, own = slice(turn, None), slice(0, turn), slice(turn - first, None)
        constant = np.empty(grid.size)
        constant[behind], constant[before] = roll.bend[own], -drum.bend[before]
        by_q += bend[:, None] * self.tension_q
        if not problem.roll.rigid:
            by_z[behind, :n_p] += T[behind, None] * roll.bend_p[own]
            by_q[behind, :n_q] += T[behind, None] * roll.bend_q[own, 1:-1]
        if not problem.drum.rigid:
            by_z[before, n_p:-1] -= T[before, None] * drum.bend_p[before, self.drum_p]
            by_q[before, n_q:] -= T[before, None] * drum.bend_q[before, 1:-1]
        return T * constant + bend * (problem.web_tension - self.about.tension)

    # ---- the two problems ----------------------------------------------------------------------

    @cached_property
    def normal(self) -> tuple[Array, Array]:
        """Return z0 (k,) and Z (k, m) of z = z0 + Z q."""
        gap, closing_z, closing_q = self.indentation
        constant, by_z, by_q = self.balance()
        scale = float(np.max(np.abs(closing_z[:, :-1])))
        k = closing_z.shape[1]
        matrix, right = np.zeros((k, k), order="F"), np.zeros((k, 1 + by_q.shape[1]), order="F")
        M, N = gap.size, gap.size + constant.size
        matrix[:M], right[:M, 0], right[:M, 1:] = closing_z / scale, gap / scale, -closing_q / scale
        matrix[M:N], right[M:N, 0], right[M:N, 1:] = by_z, -constant, -by_q
        if self.drum_arc:
            matrix[N, 0] = 1.0  # p+ begins with zero where the web comes off the drum's arc
        matrix[:M, -1] = 1.0
        if self.problem.drum.rigid:
            solved = self._without_drum_pressure(matrix, right, M)
        else:
            solved = _solve(matrix, right)
        solved[-1] *= scale
        return solved[:, 0], solved[:, 1:]

    def _without_drum_pressure(self, matrix: Array, right: Array, first: int) -> Array:
        """Solve with p- eliminated: on a rigid drum it is in its own balance only, ``first`` on."""
        k, n_p = matrix.shape[0], self.roll_nodes.size
        own, others = first + self.drum_nodes, np.append(np.arange(n_p), k - 1)
        rows = np.delete(np.arange(k), own)
        solved = np.empty_like(right)
        solved[others] = _solve(
            np.asfortranarray(matrix[np.ix_(rows, others)]), np.asfortranarray(right[rows])
        )
        solved[n_p:-1] = matrix[np.ix_(own, others)] @ solved[others] - right[own]
        return solved

    @cached_property
    def slips(self) -> tuple[Array, Array]:
        """Return v+ and v- less its creep in all cells of both faces, by z and by q."""
        grid, web, roll, drum = self.grid, self.web, self.roll, self.drum
        n_p, n_q = self.roll_nodes.size, self.roll_q.size
        N = n_p - 1  # of the roll
        on_roll, on_drum = slice(grid.first, None), slice(0, grid.last)
        # referred to the far side, where the web has taken up what lies downstream as well
        stretch = self.half_width * web.c11 / self.problem.web.thickness
        by_q = self.numbers.downstream_of_cells * (-stretch * grid.weights[self.columns])
        by_z = np.zeros((by_q.shape[0], n_p + self.drum_nodes.size + 1))
        for own, rows in ((slice(0, N), on_roll), (slice(N, None), on_drum)):
            np.multiply(grid.value[rows, grid.first :], -web.c12, out=by_z[own, :n_p])
        by_z[:N, n_p - 1] += web.c12
        if not self.problem.roll.rigid:
            by_z[:N, :n_p] -= roll.strain_p[:-1] - roll.strain_p[-1]
            by_q[:N, :n_q] -= (roll.strain_q[:-1] - roll.strain_q[-1])[:, 1:-1]
        if not self.problem.drum.rigid:
            by_z[N:, n_p:-1] -= drum.strain_p[:-1, self.drum_p]
            by_q[N:, n_q:] -= drum.strain_q[:-1, 1:-1]
        return by_z, by_q

    @cached_property
    def slip_offset(self) -> Array:
        """What bodies that are not linear add to the slips in all cells of both faces."""
        roll, drum = self.roll.strain, self.drum.strain
        return np.concatenate([roll[-1] - roll[:-1], -drum[:-1]])

    @cached_property
    def node_slips(self) -> tuple[Array, Array, Array]:
        """The slips that belong to the tractions, (m,): by z, by q, and what bodies add.

        A node belongs with the cell before it; each face's last cell belongs to no unknown.
        """
        last = [self.roll_q.size, self.columns.size + 1]
        by_z, by_q, offset = (
            np.delete(part, last, axis=0) for part in (*self.slips, self.slip_offset)
        )
        return by_z, by_q, offset

    @cached_property
    def share(self) -> float:
        """The nip's part of F by the load that a half width carries: a steady state at any width.

        The wrap takes what the nip cannot.
        """
        problem = self.problem
        most = problem.drum_friction * problem.nip_load
        return min(max(problem.winding_force, -most), most) / problem.nip_load

    @property
    def force(self) -> float:
        """The wrap's part of F [N/m]."""
        return self.problem.winding_force - self.share * self.problem.nip_load

    def stick_slip(self) -> StickSlip:
        """Return the stick-slip problem of both faces; every node has a pressure of its own."""
        z, by_q = self.normal
        slip_z, slip_q, offset = self.node_slips
        own = self.own_pressure
        rest = np.setdiff1d(np.arange(z.size), own)  # pressures that bound no traction
        creep, share = self.on_drum.astype(float), self.share
        resultant = self.force_weights - share * (self.load_weights @ by_q)
        force = self.force + share * float(self.load_weights @ z)
        return StickSlip(
            slip_q + slip_z[:, rest] @ by_q[rest], slip_z[:, own],
            offset + slip_z[:, rest] @ z[rest],
            z[own], by_q[own], self.friction, faces=1,
            creep=creep, resultant=resultant, force=force,
        )  # fmt: skip

    @cached_property
    def joint(self) -> WrapJoint | None:
        """The system of pressures and tractions together.

        None where rounding blurs tractions, of bodies that are not linear, and of those that answer
        by matrices only: then it goes from one half width to the next no quicker.
        """
        if not (self.problem.linear and all(face.acts for face in self.laws.both)):
            return None
        return None if self.friction.min() < LEAST_FRICTION else WrapJoint.of(self)

    def state(self, solution: StickSlipSolution) -> WrapState:
        """Return the state that belongs to solved tractions."""
        q = solution.traction
        if solution.joint is None:
            z0, by_q = self.normal
            z = z0 + by_q @ q
        else:
            z = solution.joint[1][: self.load_weights.size]
        along = self.laws.at(z, q)
        slips = self.at_nodes(along, solution.creep)
        return WrapState(self.half_width, solution, along, float(z[-1]), slips[0], slips[1])

    def at_nodes(self, along: Along, creep: float) -> Array:
        """Return v+ and v- along all nodes, each that of the cell before it, (2, N+1)."""
        grid = self.grid
        out = np.full((2, grid.size), np.nan)
        out[0, grid.first + 1 :] = along.roll_slip
        out[1, 1 : grid.last + 1] = along.drum_slip + creep
        out[0, grid.first], out[1, 0] = out[0, grid.first + 1], out[1, 1]
        return out

    # ---- from one half width to another --------------------------------------------------------

    def moved(self, a: float) -> WrapEquations:
        """Return the equations for another half width [m], no matrices made."""
        grid = self.grid
        drum, roll = grid.first, grid.size - 1 - grid.last
        other = grid_for(self.problem, grid.nip, a, drum, roll, grid)
        made = WrapEquations(self.problem, other, a, self.about)
        vars(made)["joint"] = self.joint  # for the sizes of its rows
        return made

    def left(self, found: Array) -> Array:
        """Return what unknowns leave of the joint system's right sides; less all slips."""
        joint, k = self.joint, self.load_weights.size
        assert joint is not None
        z, q = found[:k], found[k:-1]
        along = self.laws.at(z, q)
        out = np.zeros(joint.matrix.shape[0])
        M, N = along.gap.size, along.gap.size + self.grid.size
        out[:M], out[M:N] = along.gap, joint.size * self.laws.balance(along)
        if self.drum_arc:
            out[N] = joint.size * z[0]
        force = float(self.force_weights @ q - self.share * (self.load_weights @ z))
        out[k] = joint.force_size * (force - self.force)
        slips = np.concatenate([along.roll_slip, along.drum_slip + found[-1]])
        out[k + 1 :] = slips[joint.order]
        return np.negative(out, out=out)

    def missed(self, left: Array) -> float:
        """Return what is left of the gap's slope and of the web's balance, relative.

        As :meth:`imbalance` and the certificate measure them.
        """
        joint, grid = self.joint, self.grid
        assert joint is not None
        M = grid.last - grid.first
        gap, balance = np.abs(left[:M]).max(), np.abs(left[M : M + grid.size]).max()
        top = joint.size * np.abs(self.about.tension * self.about.bend)[self.weighs].max(
            initial=0.0
        )
        gap /= np.abs(joint.right[:M]).max()
        return float(max(gap, balance / top if top else 0.0))

    def load_of(self, p: Array) -> float:
        """Return the load that pressures carry [N/m]."""
        return float(self.load_weights[:-1] @ p)

    def carried(self, state: WrapState) -> float:
        """Return the integral of p- over the nip [N/m]."""
        return float(self.load_weights @ self.unknowns(state))

    def frictionless(self) -> float | None:
        """Return nothing: a wrap's load without friction is not the plain nip's."""
        return None

    def unknowns(self, state: WrapState) -> Array:
        """Return z of a state, (k,)."""
        return np.concatenate(
            [state.along.roll_loads.pressure[self.roll_nodes], state.pressure[self.drum_nodes],
             [state.shift]]
        )  # fmt: skip

    def imbalance(self, state: WrapState) -> float:
        """Return what the state leaves of all that was linearised, relative."""
        weight = np.where(self.weighs, state.along.tension * state.along.bend, 0.0)
        miss = np.max(np.abs(self.laws.balance(state.along)))
        pressure = state.along.roll_loads.pressure
        top = np.max(np.abs(weight)) if self.weighs.any() else np.max(pressure)
        if self.problem.linear:
            return float(miss / top)
        return max(float(miss / top), self._bodies_miss(state))

    def _bodies_miss(self, state: WrapState) -> float:
        """Return the largest difference that another linearisation makes to slopes and slips."""
        z, q = self.unknowns(state), state.solution.traction
        here, there = (one.laws.at(z, q) for one in (self, self.anew(state)))
        miss = max(float(np.max(np.abs(getattr(here, of) - getattr(there, of))))
                   for of in ("gap", "roll_slip", "drum_slip"))  # fmt: skip
        return miss / float(np.max(np.abs(self.indentation[0])))

    def anew(self, state: WrapState) -> WrapEquations:
        """Return the equations for the same half width about a state."""
        return self.linearised(state.known)

    def linearised(self, about: Known) -> WrapEquations:
        """Return the equations for the same half width about another state.

        Of linear bodies all matrices stay but those of the web's weight.
        """
        made = replace(self, about=about)
        if self.problem.linear:
            vars(made).update({name: vars(self)[name] for name in UNMOVED & vars(self).keys()})
        return made


def _solve(matrix: Array, right: Array) -> Array:
    """Solve in place, columns first; rows of one size, or rounding of the largest drowns others."""
    size = np.maximum(matrix.max(axis=1), -matrix.min(axis=1))
    matrix /= size[:, None]
    right /= size[:, None]
    _, _, solved, info = lapack.dgesv(matrix, right, overwrite_a=1, overwrite_b=1)
    if info != 0:
        raise ArithmeticError("the normal problem is singular")
    out: Array = solved
    return out
