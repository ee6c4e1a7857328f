r"""Two rollers in contact without a web, rolling or static, as one nonlinear system.

The upper roller (1) carries the pressure p and the traction q along +x, the lower roller (2) the
pressure p and the traction -q.  v_i is the outward normal displacement of a surface, u_i its
tangential displacement along +x, eps_i = u_i' + v_i/R_i its strain (u_i' on a half-plane).

    gap slope      v1' + v2' + Delta/R* - x/R* = 0                     cells
    drive          int q dx = Q,   or   xi given
    load           int p dx = P
    slip           rolling   s = eps2 - eps1 + xi                      cell upstream of each node
                   static    s = u2 - u1 + xi                          nodes
    friction law   stick: s = 0;   slip: q = +-mu p,  +-s >= 0         inner nodes

s > 0 where the lower surface is the faster one, or has moved farther along +x: it drags the upper
roller along +x, so q > 0.  In rolling, xi is the creepage: a surface point moves at V (1 + eps), so
s = (V2 + V2 eps2 - V1 - V1 eps1)/V.  In a static contact under a load that only grows, every point
slips in one direction (Cattaneo 1938, Mindlin 1949), so that the slip is the relative tangential
displacement itself, and xi is the rigid displacement of the lower roller relative to the upper.

Displacements at the nodes follow from strains and slopes in the cells, with a point y_j and the
length h_j of cell j,

    v(x_k) = v(a) - sum_(j>=k) h_j v'(y_j),      u(x_k) = u(a) - sum_(j>=k) h_j (eps - v/R)(y_j).

The difference of the static slip between two neighbouring sticking nodes is then the difference of
strains in the cell between them, as in rolling.  u(a) is a constant that xi absorbs while the
system is solved; the reported displacement contains it.

Unknowns u = (p | Delta/R*, xi, ln a | q) and Jacobian, d by a difference of two residuals:

                    p       Delta  xi   ln a   q
    gap slope    [ S1+S2     1     .     d     S1-S2    ]   S_i slopes by p and by q
    drive        [ -w Q/P    .     .     d     w        ]   w integrals over the contact
    load         [ w         .     .     d     .        ]
    slip         [ E2-E1     .     1     d    -E2-E1    ]   E_i strains or displacements

With mu = 0 there are no traction nodes, and no equation determines an xi that is not given.  The
reported one is the limit of vanishing friction, for which tractions mu p sgn(s) have no resultant:
-xi is the median of eps2 - eps1 (or u2 - u1) weighted by the pressure.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..contact.newton import Iterate, Jacobian
from ..elasticity.mesh import Wrap, nip_mesh
from ..elasticity.surface import Deformation, SurfaceTangent
from ..problems.bodies import half_width_guess
from ..problems.rollers import RollerProblem
from .contact_equations import ContactEquations, Side, nearest
from .energy import BodyWork, body_work, viscoelastic_outputs
from .layout import Unknowns
from .zones import slip_share

__all__ = ["RollerEquations", "RollerState", "pressure_median", "work_on_rollers"]

Array = np.ndarray


class RollerGeometry(NamedTuple):
    """Both rollers for a half width a."""

    a: float
    upper: Side
    lower: Side


@dataclass(frozen=True, eq=False)
class RollerState(Iterate):
    """An iterate u with its residuals, and the fields along the contact.

    Attributes
    ----------
    geometry : RollerGeometry
    p, q : (N+1,) arrays
        Pressure and traction on the upper roller at all nodes [Pa].
    upper, lower : Deformation
        At the points of the face: one in each cell, then two at the trailing edge, which ``[:-2]``
        leaves out.
    node_slip : (N+1,) array
        s of all nodes, with the xi of u: a strain in rolling, a length in a static contact [m].
    """

    geometry: RollerGeometry
    p: Array
    q: Array
    upper: Deformation
    lower: Deformation
    node_slip: Array


class RollerEquations(ContactEquations[RollerGeometry, RollerState]):
    """Residual and Jacobian of two rollers on a mesh of ``size`` nodes, N cells.

    Parameters
    ----------
    problem : RollerProblem
    size : int
    """

    problem: RollerProblem

    def __init__(self, problem: RollerProblem, size: int) -> None:
        P = problem.load
        super().__init__(problem, P, half_width_guess(P, *problem.bodies))
        self.size, self.friction = size, problem.friction
        self.mesh = nip_mesh(size, Wrap(), Wrap())
        self.layout = Unknowns(size - 2, size - 2 if problem.friction else 0)
        self.drive_row = self.load_rows[0] - 1
        self.static = problem.motion == "static"
        if self.static:
            self.slip_scale = self.slope_scale * self.guessed_half_width

    # ---- interface of the semismooth Newton method ---------------------------------------------

    @cached_property
    def creepage_nodes(self) -> list[Array]:
        """All traction nodes, unless the creepage is given or there is no friction."""
        k = self.layout.traction_count
        return [np.arange(k)] if k and self.problem.creepage is None else []

    def for_problem(self, problem: RollerProblem) -> RollerEquations:
        """Return the equations of a neighbouring problem on the same mesh."""
        return RollerEquations(problem, self.size)

    def node_names(self, tractions: Array) -> list[str]:
        """Return the names of traction nodes for messages."""
        return [f"node {i + 1}" for i in tractions.tolist()]

    # ---- residual ------------------------------------------------------------------------------

    def geometry(self, a: float, tolerance: float = 0.0) -> RollerGeometry:
        """Return the rollers for a half width, with an error below a tolerance."""
        face = self.mesh.roll_face
        return RollerGeometry(a, *self.sides(a, (face, face), tolerance))

    def state(self, u: Array, geometry: RollerGeometry) -> RollerState:
        """Evaluate fields, residuals, slip and friction bounds of the unknowns u, (size,)."""
        layout, (a, upper_side, lower_side) = self.layout, geometry
        p, q = np.zeros((2, self.size))
        p[1:-1] = u[layout.p]
        if self.friction:
            q[1:-1] = u[layout.q]
        upper, lower = upper_side.surface.deform(p, q), lower_side.surface.deform(p, -q)
        drive_and_load = self._drive_and_load(u, a, p, q)
        rows = np.concatenate([self._gap_slope(u, a, upper, lower), drive_and_load])
        if self.static:
            displacement = self._displacement(lower_side, lower, p, -q, a)
            node_slip = displacement - self._displacement(upper_side, upper, p, q, a) + u[layout.xi]
        else:
            # each node has the slip of the cell upstream of it, the first node that of its cell
            cell_slip = (lower.strain - upper.strain)[:-2] + u[layout.xi]
            node_slip = np.concatenate([cell_slip[:1], cell_slip])
        slip, traction, bound = np.zeros((3, 0))
        if self.friction:
            slip = node_slip[1:-1] / self.slip_scale
            traction = u[layout.q] / self.scales[layout.q]
            bound = u[layout.p] / self.pressure_scale
        return RollerState(u, rows, slip, traction, bound, geometry, p, q, upper, lower, node_slip)

    def _gap_slope(self, u: Array, a: float, upper: Deformation, lower: Deformation) -> Array:
        """Return the residual v1' + v2' + Delta/R* - x/R* in the cells, (N,), dimensionless."""
        slope = (upper.slope + lower.slope)[:-2] + u[self.layout.shift]
        slope -= self.mesh.points * (a / self.problem.contact_radius)
        return np.asarray(slope / self.slope_scale)

    def _drive_and_load(self, u: Array, a: float, p: Array, q: Array) -> tuple[float, float]:
        """Return the residual of the tangential load or the creepage, and that of the load.

        int p dx must be P, and int q dx the tangential load Q.  An iterate whose load is not yet P
        may transmit less: its tangential load must be (Q/P) int p dx.  p and q are the pressures
        and tractions at all nodes, (N+1,) [Pa]; both residuals are dimensionless.
        """
        problem = self.problem
        load = a * float(self.mesh.weights @ p)
        if self.is_force_given:
            force = a * float(self.mesh.weights @ q) - self._force_by_load * load
            drive = force / (problem.friction * problem.load)
        else:
            drive = float(u[self.layout.xi] - (problem.creepage or 0.0)) / self.slip_scale
        return drive, load / problem.load - 1

    @property
    def is_force_given(self) -> bool:
        """True if the tangential load is prescribed and xi is unknown."""
        return self.problem.friction > 0 and self.problem.creepage is None

    @property
    def _force_by_load(self) -> float:
        """Q/P, the tangential load of an iterate relative to its load."""
        return (self.problem.tangential_load or 0.0) / self.problem.load

    def _displacement(
        self, side: Side, deformation: Deformation, p: Array, q: Array, a: float
    ) -> Array:
        """Return u at the nodes relative to the last node, (N+1,) [m], under the loads p and q."""
        end = side.surface.end_displacement(p, q) if side.flattening else 0.0
        return self._integrate_strain(side, deformation.slope, deformation.strain, end, a)

    def _integrate_strain(
        self, side: Side, slope: Array, strain: Array, end: Array | float, a: float
    ) -> Array:
        """Return u at the nodes relative to the last node, the integral of u' = eps - v/R.

        The values of a deformation, or each column of their derivatives by nodal pressures or
        tractions, are integrated in the same way.

        Parameters
        ----------
        side : Side
        slope, strain : (N+2, ...) arrays
            v' and eps at the points of the face.
        end : float or (...) array
            v at the trailing edge [m]; only a cylinder needs it.
        a : float
            [m].
        """
        u_slope = strain
        if side.flattening:
            v = side.face.displacement_at_nodes(slope, end, a)
            u_slope = strain.copy()
            u_slope[:-2] -= (self.mesh.hats @ v) / side.radius
        return side.face.displacement_at_nodes(u_slope, 0.0, a)

    # ---- Jacobian ------------------------------------------------------------------------------

    def jacobian(self, state: RollerState) -> Jacobian:
        """Return the derivatives of equilibrium, slip and bound by u, all dimensionless.

        The blocks are those of the table in the docstring of the module: first the influence of
        both bodies on gap slope and slip, then the columns of Delta/R* and xi, and the rows of
        drive and load; the column by ln a last.  Edge nodes carry no load, so that only the
        ``inner`` nodes have columns; ``[:-2]`` leaves out the two points at the trailing edge, so
        that each cell has one row.
        """
        layout, geometry, inner = self.layout, state.geometry, slice(1, -1)
        gap_slope = np.zeros((self.size - 1, layout.size))
        slip = np.zeros((layout.traction_count, layout.size))
        # the traction is q on the upper and -q on the lower roller, and the slip u2 - u1 + xi
        for side, sign in ((geometry.upper, 1.0), (geometry.lower, -1.0)):
            if side.surface.rigid:
                continue
            tangent = side.surface.tangent(state.p, sign * state.q)
            gap_slope[:, layout.p] += tangent.slope_p[:-2, inner]
            if self.friction:
                gap_slope[:, layout.q] += sign * tangent.slope_q[:-2, inner]
                by_p, by_q = self._slip_influence(side, tangent, state, sign)
                slip[:, layout.p] -= sign * by_p[:, inner]
                slip[:, layout.q] -= by_q[:, inner]  # sign^2 = 1
        gap_slope[:, layout.shift] = 1.0
        slip[:, layout.xi] = 1.0
        # the friction bound of node i, in units of mu, is its pressure, the unknown i
        bound = np.eye(layout.traction_count, layout.size) / self.pressure_scale
        equilibrium = np.concatenate(
            [gap_slope / self.slope_scale, self._drive_and_load_rows(geometry.a)]
        )
        jacobian = Jacobian(equilibrium, slip / self.slip_scale, bound)
        self.fill_half_width_column(jacobian, state)
        return jacobian

    def _slip_influence(
        self, side: Side, tangent: SurfaceTangent, state: RollerState, sign: float
    ) -> tuple[Array, Array]:
        """Return the derivatives of what a body adds to the slip of the inner nodes.

        In rolling that is the strain in the cell upstream of each node, in a static contact the
        displacement of the node.

        Parameters
        ----------
        side : Side
        tangent : SurfaceTangent
            Derivatives of its slopes and strains.
        state : RollerState
        sign : float
            1 for the upper and -1 for the lower roller: its traction is ``sign * state.q``.

        Returns
        -------
        by_p, by_q : (N-1, N+1) arrays
            Derivatives by the pressures and the tractions at all nodes of the body.
        """
        if not self.static:
            cells = slice(0, self.size - 2)  # all but the last cell, at the end of which q = 0
            return tangent.strain_p[cells], tangent.strain_q[cells]
        end_p = end_q = np.zeros(self.size)
        if side.flattening:
            end_p, end_q = side.surface.end_tangent(state.p, sign * state.q)
        a = state.geometry.a
        by_p = self._integrate_strain(side, tangent.slope_p, tangent.strain_p, end_p, a)
        by_q = self._integrate_strain(side, tangent.slope_q, tangent.strain_q, end_q, a)
        return by_p[1:-1], by_q[1:-1]

    def _drive_and_load_rows(self, a: float) -> Array:
        """Return the derivatives of :meth:`_drive_and_load` by u but ln a, (2, size)."""
        layout, problem = self.layout, self.problem
        rows, weights = np.zeros((2, layout.size)), a * self.mesh.weights[1:-1]
        if self.is_force_given:
            rows[0, layout.p] = -self._force_by_load * weights
            rows[0, layout.q] = weights
            rows[0] /= problem.friction * problem.load
        else:
            rows[0, layout.xi] = 1 / self.slip_scale
        rows[1, layout.p] = weights / problem.load
        return rows

    # ---- fields and outputs --------------------------------------------------------------------

    def slip_points(self, a: float) -> Array:
        """Return the collocation points of the slip of the nodes, (N+1,) [m]."""
        points = self.mesh.nodes
        if not self.static:
            points = np.append(self.mesh.points[:1], self.mesh.points)
        return np.asarray(a * points)

    def slip(self, state: RollerState) -> tuple[float, Array]:
        """Return xi and the slip of all nodes, (N+1,): strains in rolling, lengths [m] if static.

        An xi that no equation determines is that of vanishing friction (docstring of the module).
        """
        slip, xi = state.node_slip, float(state.u[self.layout.xi])
        if not self.friction and self.problem.creepage is None:
            xi = -pressure_median(slip[1:-1] - xi, (self.mesh.weights * state.p)[1:-1])
            slip = slip + (xi - state.u[self.layout.xi])
        return xi, slip

    def rigid_displacement(self, state: RollerState, xi: float) -> float:
        """Return the rigid displacement of the lower roller relative to the upper [m].

        For half-planes it is determined up to a constant; nan for a body whose u is unknown.
        """
        s = state.geometry
        u1 = s.upper.surface.end_tangential_displacement(state.p, state.q)
        u2 = s.lower.surface.end_tangential_displacement(state.p, -state.q)
        return xi + u1 - u2

    def approach(self, state: RollerState) -> float:
        """Return the approach of the centres, from the closed gap at the trailing edge [m]."""
        s = state.geometry
        v = s.upper.surface.end_displacement(state.p, state.q)
        v += s.lower.surface.end_displacement(state.p, -state.q)
        return float(
            s.a**2 / (2 * self.problem.contact_radius) - v - state.u[self.layout.shift] * s.a
        )

    def main_outputs(self, state: RollerState) -> dict[str, float]:
        """Return the outputs whose error estimates end the mesh refinement."""
        out = {
            "half_width": state.geometry.a,
            "peak_pressure": float(state.p.max()),
            "tangential_load": state.geometry.a * float(self.mesh.weights @ state.q),
        }
        return out if self.static else {**out, "creepage": self.slip(state)[0]}

    def outputs(
        self, state: RollerState, active: Array, names: Collection[str] = ()
    ) -> dict[str, float]:
        """Return the outputs whose discretisation error is estimated, by name, in SI units.

        ``active`` are the zones of the traction nodes, (k,), ``names`` those that are needed, if
        not all: others that take longer are left out.
        """
        problem, a = self.problem, state.geometry.a
        xi, _ = self.slip(state)
        out = {
            "half_width": a,
            "nip_width": 2 * a,
            "peak_pressure": float(state.p.max()),
            "offset": float(state.u[self.layout.shift] * problem.contact_radius),
            "tangential_load": a * float(self.mesh.weights @ state.q),
        }
        if self.static:
            out["shift"] = self.rigid_displacement(state, xi)
        else:
            out["creepage"] = xi
        if not names or "approach" in names:
            out["approach"] = self.approach(state)
        x = a * self.mesh.nodes
        if not names or "slip_share" in names:
            slack = problem.friction * state.p - np.abs(state.q)
            out["slip_share"] = slip_share(x, self.zones(state, active), self.slip(state)[1], slack)
        if problem.viscoelastic:
            work = work_on_rollers(state)
            out |= viscoelastic_outputs(problem, work, x, state.p, out["offset"])
        return out

    def zones(self, state: RollerState, active: Array) -> Array:
        """Return the zones of all nodes; those at the edges have the zones of their neighbours.

        Without friction all nodes slip.
        """
        inner = active if self.problem.friction else np.sign(self.slip(state)[1][1:-1])
        return np.concatenate([inner[:1], inner, inner[-1:]]).astype(np.int8)

    # ---- transfer to another mesh --------------------------------------------------------------

    def prolong(
        self, state: RollerState, active: Array, coarse: RollerEquations
    ) -> tuple[Array, Array]:
        """Return the initial guess on this mesh from the solution on another mesh.

        Pressures and tractions are interpolated linearly between the nodes; Delta/R* and ln a are
        copied, and xi if it has the same meaning (creepage or displacement); each traction node
        has the zone of the nearest one.  The other solution may be one without friction.

        Parameters
        ----------
        state : RollerState
            The solution on the other mesh.
        active : (k,) int array
            Its active set: 0 stick, +1 and -1 slip.
        coarse : RollerEquations
            Equations on the other mesh.

        Returns
        -------
        u : (size,) array
            Unknowns on this mesh.
        active : int array
        """
        new, old = self.layout, coarse.layout
        x_old, x_new = coarse.mesh.nodes, self.mesh.nodes[1:-1]
        u, zones = np.zeros(new.size), np.zeros(new.traction_count, dtype=np.int8)
        u[new.p] = np.interp(x_new, x_old, state.p)
        u[new.shift] = state.u[old.shift]
        u[new.ln_a] = min(state.u[old.ln_a], self.largest_ln_a[0])
        if self.static == coarse.static:
            u[new.xi] = state.u[old.xi]
        if zones.size and active.size:
            u[new.q] = np.interp(x_new, x_old, state.q)
            zones = nearest(x_old[1:-1], active, x_new)
        return u, zones


def work_on_rollers(state: RollerState) -> tuple[BodyWork, BodyWork]:
    """Return the work on the upper and on the lower roller."""
    a, upper, lower = state.geometry
    return (
        body_work(upper, state.upper, state.p, state.q, a),
        body_work(lower, state.lower, state.p, -state.q, a),
    )


def pressure_median(values: Array, weights: Array) -> float:
    """Return the median of values with weights, (n,) each, linear between the values.

    Half of the weight lies on either side of it; that of a value lies half below, half above it.
    """
    order = np.argsort(values)
    v, w = values[order], weights[order]
    fraction = (np.cumsum(w) - w / 2) / np.sum(w)
    return float(np.interp(0.5, fraction, v))
