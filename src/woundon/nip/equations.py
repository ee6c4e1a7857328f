r"""The rolling nip of a web as one nonlinear system.

A web (tension T, thickness 2h, compliances c11, c12, c22) passes between the roll (+, pressure p+)
and the drum (-, pressure p-), and may be wrapped on the drum upstream of the nip and on the roll
downstream of it.  kappa is the curvature of the web, positive with the centre in the roll; v and
eps are normal displacement and strain of a surface (thesis eqs. 64 to 98, 131 to 160).

    gap slope      v+' + v-' + c12 (q+ + q-) - 2h F(p+)' + Delta/R* - x/R* = 0   cells of the nip
    equilibrium    p+ - p- - T_h kappa = 0,    T_h = T - m V^2                   nodes of the wraps
    force          int q- dx = F
    load           int_nip p- dx = P
    tension        T = T_in + int (q+ + q-) dx
    slip velocity  v+ = eps - eps+ - E,  E = (eps - eps+)(end),      v- = eps - eps- + xi,
                   eps = c11 (T - T(end))/2h - c12 p+
    friction law   stick: v = 0;   slip: q = s mu p, s = +1 or -1                traction nodes

F(p) is the compression of the web (c22 p of a linear one).  m V^2 is the centrifugal force of a web
of the mass m per area at the speed V; the hoop tension T_h presses the web on what it is wrapped
on.  On a wrap one face is free: p+ = 0
and kappa = -kappa- on the drum, p- = 0 and kappa = kappa+ on the roll.  In the nip the web follows
the drum, kappa = -kappa-, so that p+ = p- + T_h kappa is explicit.  Without a roll wrap the web is
held to the roll at the trailing edge (thesis eq. 97), and p+ = p- = p in the nip.  If the web runs
into a further nip at the end of the roll wrap, E is given (:mod:`.several_nips`).

Unknowns and Jacobian, d by a difference of two residuals (:mod:`.layout`):

                    p         Delta  xi  ln a   q+       q-
    gap slope    [ S           1     .    d     S        S         ]   S  slopes
    equilibrium  [ I - T_h B   .     .    d    -kappa -kappa-T_h B ]   B  curvatures
    force, load  [ w           .     .    d     .        w         ]   w  integrals
    slip         [ -c12 - E    .     1    d     L - E    L - E     ]   E  strains, L web stretch
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import log
from typing import NamedTuple, Self

import numpy as np

from ..contact.newton import Iterate, Jacobian
from ..elasticity.mesh import Mesh, Wrap, nip_mesh
from ..elasticity.surface import Deformation
from ..problems.bodies import half_width_guess
from ..problems.nip import NipProblem
from .contact_equations import ContactEquations, Side, nearest
from .layout import Layout
from .load_limit import largest_half_width

__all__ = ["Assembly", "Fields", "Geometry", "NipEquations", "NipState"]

Array = np.ndarray

# Shortest roll wrap of an iterate beyond the trailing edge of the nip, in half widths.
LEAST_WRAP = 1e-3


class Geometry(NamedTuple):
    """Mesh and surfaces for one half width a."""

    a: float
    mesh: Mesh
    roll: Side
    drum: Side


class Fields(NamedTuple):
    """Fields along the web at all nodes; tractions are zero where a body is not in contact."""

    geometry: Geometry
    p_roll: Array
    p_drum: Array
    q_roll: Array
    q_drum: Array
    transfer: Array  # int (q+ + q-) dx/a from the first node, with lumped hats (:class:`Mesh`)
    tension: Array
    hoop_tension: Array  # T - m V^2
    roll: Deformation
    far: Deformation  # the part of ``roll`` by other nips
    drum: Deformation
    roll_curvature: Array  # at the nodes of the roll face; empty without a roll wrap
    drum_curvature: Array  # at the nodes of the drum face; empty without a wrap

    def deformed(self, far: Deformation) -> Fields:
        """Return the fields with the deformation of the roll by other nips added."""
        face, a = self.geometry.roll.face, self.geometry.a
        roll = Deformation(self.roll.slope + far.slope, self.roll.strain + far.strain)
        bent = self.roll_curvature + face.curvature_change(far.slope, a, ends=False)
        return self._replace(roll=roll, far=far, roll_curvature=bent)

    @property
    def on_roll(self) -> tuple[Array, Array]:
        """p+ and q+ at the nodes of the roll's face."""
        first = self.geometry.mesh.first
        return self.p_roll[first:], self.q_roll[first:]

    @property
    def on_drum(self) -> tuple[Array, Array]:
        """p- and q- at the nodes of the drum's face."""
        last = self.geometry.mesh.last
        return self.p_drum[: last + 1], self.q_drum[: last + 1]


@dataclass(frozen=True, eq=False)
class NipState(Iterate):
    """An iterate u with its residuals, and the fields along the web.

    Attributes
    ----------
    fields : Fields
    laid_strain : float
        E, the strain of the laid web relative to the roll's surface, with eps = 0 for T = T(end)
        and p+ = 0.
    """

    fields: Fields
    laid_strain: float

    @property
    def geometry(self) -> Geometry:
        """Mesh and surfaces."""
        return self.fields.geometry

    @property
    def nips(self) -> tuple[NipState]:
        """The state of each nip."""
        return (self,)


class NipEquations(ContactEquations[Geometry, NipState]):
    """Residual and Jacobian of a nip on a mesh of ``size`` nodes in the nip.

    Parameters
    ----------
    problem : NipProblem
        Without air.
    size : int
    like : Mesh, optional
        A mesh with the numbers of cells to use; by default those for the initial half width.
    is_last : bool
        False if the web runs into a further nip at the end of the roll wrap.
    is_alone : bool
        False if there are other nips on the roll.
    """

    problem: NipProblem
    layout: Layout

    def __init__(
        self,
        problem: NipProblem,
        size: int,
        like: Mesh | None = None,
        is_last: bool = True,
        is_alone: bool = True,
    ) -> None:
        self.size, self.is_last, self.is_alone = size, is_last, is_alone
        self.roll_wrap, self.drum_wrap = problem.roll_wrap, problem.drum_wrap
        P, R = problem.nip_load, problem.contact_radius
        # a compressed web between rigid bodies, 2h c22 p = (a^2 - x^2)/2R, or Hertz's contact
        web_only = np.cbrt(1.5 * P * R * problem.web.thickness * problem.web.compliance.c22)
        super().__init__(problem, P, max(half_width_guess(P, *problem.bodies), web_only))
        self._first_mesh = like
        self._first_mesh = self.mesh(self.guessed_half_width)
        self.layout = layout = Layout(self._first_mesh, self.roll_wrap > 0, self.drum_wrap > 0)
        self.friction: Array = np.full(layout.traction_count, problem.roll_friction)
        self.friction[layout.last - layout.roll_nodes.start :] = problem.friction_on_wrap
        self.friction[layout.roll_count :] = problem.drum_friction

    # ---- interface of the semismooth Newton method ---------------------------------------------

    @cached_property
    def largest_ln_a(self) -> Array:
        """ln of the largest half width that the bodies and the roll wrap permit, (1,)."""
        a = largest_half_width(self.problem)
        if self.roll_wrap:
            a = min(a, self.roll_wrap * self.problem.roll.radius / (1 + LEAST_WRAP))
        return np.array([log(a)])

    @cached_property
    def creepage_nodes(self) -> list[Array]:
        """Traction nodes on the drum, whose slip velocity contains the creepage."""
        return [np.arange(self.layout.roll_count, self.friction.size)]

    def for_problem(self, problem: NipProblem) -> Self:
        """Return the equations of a neighbouring problem with the same numbers of cells."""
        return type(self)(problem, self.size, self._first_mesh, self.is_last, self.is_alone)

    def node_names(self, tractions: Array) -> list[str]:
        """Return the names of traction nodes, given by their numbers (n,), for messages."""
        layout, k = self.layout, self.layout.roll_count
        return [
            f"roll node {layout.roll_nodes.start + i}"
            if i < k
            else f"drum node {layout.drum_nodes.start + i - k}"
            for i in tractions.tolist()
        ]

    @property
    def nips(self) -> tuple[Self]:
        """The equations of each nip."""
        return (self,)

    # ---- geometry ------------------------------------------------------------------------------

    def mesh(self, a: float) -> Mesh:
        """Return the mesh for a half width, with the same numbers of cells for all half widths."""
        if self._first_mesh is not None and not (self.roll_wrap or self.drum_wrap):
            return self._first_mesh
        roll, drum = (body.radius / a for body in self.problem.bodies)
        length = max(self.roll_wrap * roll - 1, LEAST_WRAP) if self.roll_wrap else 0.0
        return nip_mesh(
            self.size,
            Wrap(self.drum_wrap * drum, drum, graded_end=True),
            Wrap(length, roll, graded_end=not self.is_last),
            self._first_mesh,
        )

    def geometry(self, a: float, tolerance: float = 0.0) -> Geometry:
        """Return mesh and surfaces for a half width, with an error below a tolerance."""
        mesh = self.mesh(a)
        roll, drum = self.sides(a, (mesh.roll_face, mesh.drum_face), tolerance)
        return Geometry(a, mesh, roll._replace(ends=self.is_last), drum)

    # ---- residual ------------------------------------------------------------------------------

    def state(self, u: Array, geometry: Geometry) -> NipState:
        """Evaluate fields, residuals, slip velocities and friction bounds of the unknowns u."""
        return self.state_of(u, self.fields(u, geometry, self.problem.web_tension))

    def state_of(self, u: Array, f: Fields, laid_strain: float | None = None) -> NipState:
        """Evaluate residuals, slip velocities and friction bounds of the unknowns u.

        Parameters
        ----------
        u : (size,) array
        f : Fields
            Those of u.
        laid_strain : float, optional
            E (:class:`NipState`); by default that at the end of the roll's face.
        """
        layout = self.layout
        E = self.strain_at_end(f) if laid_strain is None else laid_strain
        rows = [self._gap_slope(u, f), *self._normal_equilibrium(f), self._force_and_load(u, f)]
        p = np.concatenate([f.p_roll[layout.roll_nodes], f.p_drum[layout.drum_nodes]])
        # the slip velocity of a traction node is that of the cell upstream of it
        slip = np.concatenate([v[:-1] for v in self.slip_velocities(u[layout.xi], f, E)])
        traction = u[layout.q] / self.scales[layout.q]
        # tractions are in units of mu times the pressure scale: their bounds are the scaled p
        slip, p = slip / self.slope_scale, p / self.pressure_scale
        return NipState(u, np.concatenate(rows), slip, traction, p, f, E)

    def state_like(self, state: NipState, geometry: Geometry) -> NipState:
        """Return the state for another geometry, with the same inlet tension and laid strain."""
        f = self.fields(state.u, geometry, float(state.fields.tension[0]))
        if not self.is_alone:
            f = f.deformed(state.fields.far)
        return self.state_of(state.u, f, None if self.is_last else state.laid_strain)

    def fields(self, u: Array, g: Geometry, inlet_tension: float) -> Fields:
        """Evaluate pressures, tractions, tension and the deformation of both bodies at u, (size,).

        In this order: the unknowns at the nodes, the tension from the ``inlet_tension`` [N/m], the
        drum, p+ in the nip, which depends on the curvature of the drum, and the roll.
        """
        layout, a, mesh = self.layout, g.a, g.mesh
        p_roll, p_drum, q_roll, q_drum = np.zeros((4, layout.end + 1))
        p_drum[layout.drum_p_nodes] = u[layout.drum_p]
        p_roll[layout.wrap_p_nodes] = u[layout.wrap_p]
        q_roll[layout.roll_nodes], q_drum[layout.drum_nodes] = u[layout.roll_q], u[layout.drum_q]
        q = q_roll + q_drum
        # int q dx/a up to each node: complete hats for the slips (Mesh.integral_to_points), and
        # without the downstream half of the last hat for the tension
        transfer = (mesh.weights * q).cumsum()
        T = inlet_tension + a * transfer
        T[:-1] -= (a / 2) * mesh.cells * q[:-1]
        hoop_tension = T - self.problem.centrifugal_tension
        on_drum = p_drum[: layout.last + 1], q_drum[: layout.last + 1]
        drum = g.drum.surface.deform(*on_drum)
        kappa_roll, kappa_drum = np.zeros(0), np.zeros(0)
        if self.roll_wrap or self.drum_wrap:
            kappa_drum = g.drum.curvature(drum.slope, *on_drum, a)
        # p+ in the nip; without a roll wrap the hoop pressure is neglected
        inner = slice(layout.first + 1, layout.last)
        p_roll[inner] = p_drum[inner]
        if self.roll_wrap:
            p_roll[inner] -= hoop_tension[inner] * kappa_drum[inner]
        on_roll = p_roll[layout.first :], q_roll[layout.first :]
        roll = g.roll.surface.deform(*on_roll)
        if self.roll_wrap:
            kappa_roll = g.roll.curvature(roll.slope, *on_roll, a)
        far = Deformation(*np.zeros((2, roll.strain.size)))
        return Fields(
            g,
            p_roll,
            p_drum,
            q_roll,
            q_drum,
            transfer,
            T,
            hoop_tension,
            roll,
            far,
            drum,
            kappa_roll,
            kappa_drum,
        )

    def _gap_slope(self, u: Array, f: Fields) -> Array:
        """Return the residual of the gap slope in the cells of the nip, (cells,), dimensionless.

        v+' + v-' + c12 (q+ + q-) - 2h F(p+)' + Delta/R* - x/R*
        """
        (a, mesh, *_), web, nip = f.geometry, self.problem.web, f.geometry.mesh.nip_cells
        thinning, _ = web.thinned(f.p_roll[mesh.nip_nodes])
        gap = f.roll.slope[: mesh.last - mesh.first] + f.drum.slope[nip] + u[self.layout.shift]
        gap += web.compliance.c12 * mesh.at_points(f.q_roll + f.q_drum)[nip]
        gap -= (thinning[1:] - thinning[:-1]) / (a * mesh.cells[nip])
        return (gap - mesh.points[nip] * (a / self.problem.contact_radius)) / self.slope_scale

    def _normal_equilibrium(self, f: Fields) -> list[Array]:
        """Return the residual p+ - p- - T_h kappa of the normal equilibrium on the wraps.

        One array for each wrap, drum first, at its nodes.  On the drum p+ is zero and kappa is
        -kappa-; on the roll p- is zero and kappa is kappa+.
        """
        layout, T, residuals = self.layout, f.hoop_tension, []
        if self.drum_wrap:
            nodes = layout.drum_wrap_nodes
            residuals.append(f.p_drum[nodes] - T[nodes] * f.drum_curvature[nodes])
        if self.roll_wrap:
            nodes, kappa = layout.roll_wrap_nodes, f.roll_curvature[layout.last - layout.first :]
            residuals.append(f.p_roll[nodes] - T[nodes] * kappa)
        return [residual / self.pressure_scale for residual in residuals]

    def _force_and_load(self, u: Array, f: Fields) -> Array:
        """Return the residuals of the winding force and of the nip load, (2,).

        int_nip p- dx must be P, and int q- dx the force F.  An iterate whose load is not yet P may
        transmit less: its force must be F + (dF/dP) (int_nip p- dx - P).
        """
        P, F = self.problem.nip_load, self.problem.winding_force
        a, mesh = f.geometry.a, f.geometry.mesh
        load = a * (mesh.nip_weights[self.layout.p_nodes] @ u[self.layout.p])
        force = a * (mesh.weights @ f.q_drum)
        force_defect = force - F - self._force_by_load * (load - P)
        return np.array([force_defect / (self.problem.drum_friction * P), load / P - 1])

    @cached_property
    def _force_by_load(self) -> float:
        """dF/dP of :meth:`_force_and_load`: F/P, at most the friction coefficient of the drum."""
        mu = self.problem.drum_friction
        return float(np.clip(self.problem.winding_force / self.problem.nip_load, -mu, mu))

    def strain_at_end(self, f: Fields) -> float:
        """Return eps - eps+ at the end of the roll face, with eps = 0 for T = T(end), p+ = 0."""
        return float(-self.problem.web.compliance.c12 * f.p_roll[-1] - f.roll.strain[-1])

    def slip_velocities(self, xi: float, f: Fields, laid_strain: float) -> tuple[Array, Array]:
        """Return v+ in the cells of the roll face and v- in those of the drum face, an array each.

        v+ is relative to the laid layer, whose strain relative to the roll's surface is given.
        """
        layout, (a, mesh, *_), web = self.layout, f.geometry, self.problem.web
        stretch = a * web.compliance.c11 / web.thickness * (f.transfer[:-1] - f.transfer[-1])
        strain = stretch - web.compliance.c12 * mesh.at_points(f.p_roll)
        roll = strain[layout.first :] - f.roll.strain[:-2] - laid_strain
        return roll, strain[: layout.last] - f.drum.strain[:-2] + xi

    # ---- Jacobian ------------------------------------------------------------------------------

    def jacobian(self, state: NipState) -> Jacobian:
        """Return the derivatives of equilibrium, slip and bound by u."""
        jacobian = Assembly(self, state).jacobian()
        self.fill_half_width_column(jacobian, state)
        return jacobian

    # ---- transfer to another mesh --------------------------------------------------------------

    def prolong(self, state: NipState, active: Array, coarse: NipEquations) -> tuple[Array, Array]:
        """Return the initial guess on this mesh from the solution on another mesh.

        Pressures and tractions are interpolated linearly between the nodes; Delta/R*, xi and ln a
        are copied; each traction node has the zone of the nearest traction node of its face.

        Parameters
        ----------
        state : NipState
            The solution on the other mesh.
        active : (k,) int array
            Its active set: 0 stick, +1 and -1 slip.
        coarse : NipEquations
            Equations on the other mesh.

        Returns
        -------
        u : (size,) array
            Unknowns on this mesh.
        active : int array
        """
        new, old, f = self.layout, coarse.layout, state.fields
        x_old, x_new = f.geometry.mesh.nodes, self.mesh(f.geometry.a).nodes
        p = np.where(np.arange(x_old.size) < old.last, f.p_drum, f.p_roll)
        u = np.empty(new.size)
        u[new.p] = np.interp(x_new[new.p_nodes], x_old, p)
        u[[new.shift, new.xi, new.ln_a]] = state.u[[old.shift, old.xi, old.ln_a]]
        u[new.roll_q] = np.interp(x_new[new.roll_nodes], x_old, f.q_roll)
        u[new.drum_q] = np.interp(x_new[new.drum_nodes], x_old, f.q_drum)
        k = old.roll_count
        roll_zones = nearest(x_old[old.roll_nodes], active[:k], x_new[new.roll_nodes])
        drum_zones = nearest(x_old[old.drum_nodes], active[k:], x_new[new.drum_nodes])
        return u, np.append(roll_zones, drum_zones)


class Assembly:
    """Assembly of the Jacobian at a state, block by block (table in the docstring of the module).

    Rows of a block are equations, columns all ``size`` unknowns; each method returns its block in
    the units of its equation.  Blocks are assembled from the derivatives by the nodal loads of a
    face: the columns of p- and q+- are copied to those of their unknowns, and p+ is eliminated by
    dp+/du.

    Attributes
    ----------
    roll, drum : SurfaceTangent
        Derivatives of slopes and strains by the pressures and tractions of the faces.
    kappa_roll, kappa_drum : pair of arrays, or None
        Derivatives of the curvatures by pressures and by tractions.
    dp_roll : (n, size) array
        Derivative dp+/du of the pressure at the nodes of the roll's face by all unknowns.
    """

    def __init__(self, equations: NipEquations, state: NipState) -> None:
        self.equations, self.problem = equations, equations.problem
        self.layout, self.fields = equations.layout, state.fields
        f = state.fields
        self.a, self.mesh, roll, drum = f.geometry
        self.roll, self.drum = roll.surface.tangent(*f.on_roll), drum.surface.tangent(*f.on_drum)
        self.kappa_roll = self.kappa_drum = None
        if f.roll_curvature.size:
            self.kappa_roll = roll.curvature_tangent(self.roll, *f.on_roll, self.a)
        if f.drum_curvature.size:
            self.kappa_drum = drum.curvature_tangent(self.drum, *f.on_drum, self.a)
        self.dp_roll = self._derivative_of_p_roll()

    def jacobian(self) -> Jacobian:
        """Return all blocks, dimensionless; the column by ln a is zero."""
        layout, equations = self.layout, self.equations
        gap = self._gap_slope_rows() / equations.slope_scale
        wraps = [rows / equations.pressure_scale for rows in self._wrap_rows()]
        equilibrium = np.concatenate([gap, *wraps, self._force_and_load_rows()])
        slip = self._slip_rows() / equations.slope_scale
        # the friction bound of a node is its pressure, p+ on the roll and p- on the drum
        shift = layout.drum_nodes.start - layout.p_nodes.start
        on_drum = np.eye(layout.traction_count - layout.roll_count, layout.size, shift)
        bound = np.concatenate([self.dp_roll[1:-1], on_drum]) / equations.pressure_scale
        return Jacobian(equilibrium, slip, bound)

    def _derivative_of_p_roll(self) -> Array:
        """Return dp+/du at the n nodes of the roll's face, (n, size).

        In the nip p+ = p- + T_h kappa, without a roll wrap p+ = p-; on the roll wrap p+ is an
        unknown.  Row 0 is zero: p+ = 0 at the leading edge.
        """
        layout, first = self.layout, self.layout.first
        out = np.zeros((layout.end + 1 - first, layout.size))
        # the pressures on the face of the roll
        nodes = np.arange(max(layout.p_nodes.start, first + 1), layout.p_nodes.stop)
        out[nodes - first, nodes - layout.p_nodes.start] = 1.0
        if self.equations.roll_wrap:
            inner = slice(first + 1, layout.last)
            kappa = self.fields.drum_curvature[inner]
            self._subtract_hoop(out[1 : layout.last - first], inner, kappa, self.kappa_drum)
        return out

    def _subtract_hoop(
        self, rows: Array, nodes: slice, kappa: Array, tangent: tuple[Array, Array] | None
    ) -> None:
        """Subtract the derivatives of T_h kappa, dT kappa + T_h dkappa, from rows in place.

        Parameters
        ----------
        rows : (m, size) array
            One row for each of ``nodes``.
        nodes : slice
            m nodes of the mesh.
        kappa : (m,) array
            Curvature at these nodes [1/m].
        tangent : pair of arrays, or None
            Derivatives of the curvature of the drum by p- and by q- at the nodes of its face; None
            if kappa does not depend on them.
        """
        layout = self.layout
        by_q = self.a * self.mesh.integral_to_nodes[nodes]
        rows[:, layout.roll_q] -= kappa[:, None] * by_q[:, layout.roll_nodes]
        rows[:, layout.drum_q] -= kappa[:, None] * by_q[:, layout.drum_nodes]
        if tangent is not None:
            T = self.fields.hoop_tension[nodes, None]
            rows[:, layout.drum_p] -= T * tangent[0][nodes, layout.drum_p_nodes]
            rows[:, layout.drum_q] -= T * tangent[1][nodes, 1:-1]

    def chain_p_roll(self, matrix: Array) -> Array:
        """Return the derivatives by u, matrix @ dp+/du (chain rule).

        Parameters
        ----------
        matrix : (m, n) array
            Derivatives by p+ at the n nodes of the roll's face.

        Returns
        -------
        (m, size) array
            Without a roll wrap p+ = p- in the nip, so that columns are copied.
        """
        layout, n = self.layout, self.layout.last - self.layout.first
        if self.equations.roll_wrap:
            out: Array = matrix[:, 1:n] @ self.dp_roll[1:n]
        else:
            out = np.zeros((len(matrix), layout.size))
            out[:, layout.drum_p.stop - n + 1 : layout.drum_p.stop] = matrix[:, 1:n]
        out[:, layout.wrap_p] += matrix[:, n : n + layout.wrap_p.stop - layout.wrap_p.start]
        return out

    def by_loads_on_roll(self, by_p: Array, by_q: Array) -> Array:
        """Return the derivatives by u, (m, size), from those by the loads on the roll's face.

        Parameters
        ----------
        by_p, by_q : (m, n) arrays
            Derivatives by p+ and by q+ at the n nodes of the face.
        """
        out = self.chain_p_roll(by_p)
        out[:, self.layout.roll_q] += by_q[:, 1:-1]
        return out

    def _gap_slope_rows(self) -> Array:
        """Return the rows of the gap slope in the cells of the nip, (cells, size).

        Derivatives of v+' + v-' + c12 (q+ + q-) - 2h F(p+)' + Delta/R*.
        """
        layout, mesh, web, nip = self.layout, self.mesh, self.problem.web, self.mesh.nip_cells
        n = layout.last - layout.first
        by_p = self.roll.slope_p[:n].copy()
        _, thinning = web.thinned(self.fields.p_roll[mesh.nip_nodes])
        k, h = np.arange(n), self.a * mesh.cells[nip]
        by_p[k, k] += thinning[:-1] / h
        by_p[k, k + 1] -= thinning[1:] / h
        rows = self.chain_p_roll(by_p)
        # c12 (q+ + q-)
        thickening = web.compliance.c12 * mesh.hats[nip]
        rows[:, layout.roll_q] += thickening[:, layout.roll_nodes] + self.roll.slope_q[:n, 1:-1]
        rows[:, layout.drum_q] += thickening[:, layout.drum_nodes] + self.drum.slope_q[nip, 1:-1]
        rows[:, layout.drum_p] += self.drum.slope_p[nip, layout.drum_p_nodes]
        rows[:, layout.shift] = 1.0
        return rows

    def _wrap_rows(self) -> list[Array]:
        """Return the rows of the normal equilibrium p+ - p- - T_h kappa, one block for each wrap.

        On the drum p+ is zero, and kappa is -kappa-; on the roll p- is zero.
        """
        layout, f, blocks = self.layout, self.fields, []
        if self.equations.drum_wrap:
            nodes = layout.drum_wrap_nodes
            rows = np.eye(nodes.stop, layout.size)  # dp-: the first unknowns
            self._subtract_hoop(rows, nodes, f.drum_curvature[nodes], self.kappa_drum)
            blocks.append(rows)
        if self.equations.roll_wrap:
            nodes, on_face = layout.roll_wrap_nodes, slice(layout.last - layout.first, None)
            rows = np.eye(nodes.stop - nodes.start, layout.size, layout.wrap_p.start)  # dp+
            if self.kappa_roll is not None:
                T = f.hoop_tension[nodes, None]
                rows += self.chain_p_roll(-T * self.kappa_roll[0][on_face])
                rows[:, layout.roll_q] -= T * self.kappa_roll[1][on_face, 1:-1]
            self._subtract_hoop(rows, nodes, f.roll_curvature[on_face], None)
            blocks.append(rows)
        return blocks

    def _force_and_load_rows(self) -> Array:
        """Return the rows of winding force int q- dx and nip load int_nip p- dx, (2, size).

        Derivatives of the residuals of ``_force_and_load``.
        """
        layout, problem = self.layout, self.problem
        rows, weights = np.zeros((2, layout.size)), self.a * self.mesh.nip_weights[layout.p_nodes]
        rows[0, layout.p] = -self.equations._force_by_load * weights
        rows[0, layout.drum_q] = self.a * self.mesh.weights[layout.drum_nodes]
        rows[0] /= problem.drum_friction
        rows[1, layout.p] = weights
        return rows / problem.nip_load

    def _slip_rows(self) -> Array:
        """Return the rows of the slips of the k traction nodes, roll then drum, (k, size).

        v+ = eps - eps+ - (eps - eps+)(end) and v- = eps - eps- + xi in the cell upstream of each
        node, where the strain of the web is eps = c11 (T - T(end))/2h - c12 p+.
        """
        layout, mesh, web, first = self.layout, self.mesh, self.problem.web, self.layout.first
        c12 = web.compliance.c12
        n, m = layout.roll_count, layout.traction_count - layout.roll_count
        # c11 (T - T(end))/2h in all cells
        stretch = mesh.integral_to_points - mesh.weights
        stretch *= self.a * web.compliance.c11 / web.thickness
        # eps - eps+ at the points of the roll's face by its own loads
        by_p = -c12 * self.fields.geometry.roll.face.hats - self.roll.strain_p
        by_q = -self.roll.strain_q
        if self.equations.is_last:
            by_p, by_q = by_p - by_p[-1], by_q - by_q[-1]
        roll, drum = self.by_loads_on_roll(by_p[:n], by_q[:n]), np.zeros((m, layout.size))
        # p+ strains the web in the cells of the nip
        fraction = mesh.fraction[first:m, None]
        drum[first:] = c12 * (fraction - 1) * self.dp_roll[: m - first]
        drum[first:] -= c12 * fraction * self.dp_roll[1 : m - first + 1]
        drum[:, layout.drum_p] -= self.drum.strain_p[:m, layout.drum_p_nodes]
        drum[:, layout.drum_q] -= self.drum.strain_q[:m, 1:-1]
        drum[:, layout.xi] = 1.0
        for block, cells in ((roll, slice(first, first + n)), (drum, slice(0, m))):
            block[:, layout.roll_q] += stretch[cells, layout.roll_nodes]
            block[:, layout.drum_q] += stretch[cells, layout.drum_nodes]
        return np.concatenate([roll, drum])
