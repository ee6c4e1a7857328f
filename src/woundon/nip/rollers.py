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

from dataclasses import dataclass
from functools import cached_property
from math import log
from typing import NamedTuple

import numpy as np

from ..contact.newton import Jacobian
from ..elasticity.mesh import Face, Wrap, nip_mesh
from ..elasticity.surface import Deformation
from ..problems.bodies import half_width_guess
from ..problems.rollers import RollerProblem
from .contact_equations import ContactEquations, Side, nearest
from .energy import dissipation, pressure_resultant
from .roller_energy import work_on_rollers
from .zones import slip_share

__all__ = ["RollerEquations", "RollerState", "pressure_median"]

Array = np.ndarray


class RollerGeometry(NamedTuple):
    """Both rollers for a half width a."""

    a: float
    upper: Side
    lower: Side


@dataclass(frozen=True, eq=False)
class RollerState:
    """An iterate; residuals, slip, traction and bound are dimensionless.

    ``p`` and ``q`` hold all nodes, ``upper`` and ``lower`` the deformation at the points of the
    face: one in each cell, then two at the trailing edge, which ``[:-2]`` leaves out.
    """

    u: Array
    geometry: RollerGeometry
    p: Array
    q: Array
    upper: Deformation
    lower: Deformation
    equilibrium: Array
    slip: Array
    traction: Array
    bound: Array


class RollerEquations(ContactEquations):
    """Residual and Jacobian of two rollers on a mesh of ``size`` nodes.

    Parameters
    ----------
    problem : RollerProblem
    size : int
    """

    def __init__(self, problem: RollerProblem, size: int) -> None:
        P = problem.load
        super().__init__(problem, P, half_width_guess(P, *problem.bodies))
        self.size = size
        self.mesh = nip_mesh(size, Wrap(), Wrap())
        self.face: Face = self.mesh.roll_face
        n = size - 2
        k = n if problem.friction else 0
        # indices in u; the rows are gap slope (n + 1), tangential load or creepage, load
        self.p, self.q = slice(0, n), slice(n + 3, n + 3 + k)
        self.shift, self.xi, self.ln_a = n, n + 1, n + 2
        self.drive_row, self.load_row = n + 1, n + 2
        self.static = problem.motion == "static"
        self.slip_scale = self.slope_scale * (self.guessed_half_width if self.static else 1.0)

    # ---- what Newton's method needs ------------------------------------------------------------

    @cached_property
    def scales(self) -> Array:
        """Scales of the unknowns."""
        out = np.full(self.q.stop, self.pressure_scale)
        out[self.shift], out[self.xi], out[self.ln_a] = self.slope_scale, self.slip_scale, 1.0
        out[self.q] *= self.problem.friction
        return out

    @property
    def traction_unknowns(self) -> slice:
        """Indices of the tractions in u."""
        return self.q

    @cached_property
    def largest_ln_a(self) -> float:
        """ln of the largest half width that the bodies permit."""
        return log(min(min(body.radius, body.max_half_width) for body in self.problem.bodies))

    @property
    def creepage_nodes(self) -> Array:
        """All traction nodes, unless the creepage is given."""
        is_given = self.problem.creepage is not None
        return np.arange(0 if is_given else self.q.stop - self.q.start)

    def for_problem(self, problem: RollerProblem) -> RollerEquations:
        """Return the equations of a neighbouring problem on the same mesh."""
        return RollerEquations(problem, self.size)

    def node_names(self, tractions: Array) -> list[str]:
        """Return the names of traction nodes for messages."""
        return [f"node {i + 1}" for i in tractions.tolist()]

    def initial_guess(self) -> tuple[Array, Array]:
        """Return zero fields and full stick."""
        u = np.zeros(self.q.stop)
        u[self.ln_a] = log(self.initial_half_width())
        return u, np.zeros(self.q.stop - self.q.start, dtype=np.int8)

    # ---- residual ------------------------------------------------------------------------------

    def geometry(self, a: float, tolerance: float = 0.0) -> RollerGeometry:
        """Return the rollers for a half width, with an error below a tolerance."""
        return RollerGeometry(a, *self.sides(a, (self.face, self.face), tolerance))

    def state(self, u: Array, geometry: RollerGeometry) -> RollerState:
        """Evaluate residuals, slip and friction bounds of the unknowns u."""
        s, problem = geometry, self.problem
        p, q = np.zeros((2, self.size))
        p[1:-1] = u[self.p]
        if problem.friction:
            q[1:-1] = u[self.q]
        upper, lower = s.upper.surface.deform(p, q), s.lower.surface.deform(p, -q)
        rows = np.append(self._gap_slope(u, s.a, upper, lower), self._drive_and_load(u, s.a, p, q))
        slip, traction, bound = np.zeros((3, 0))
        if problem.friction:
            slip = self._slip(u, s, p, q, upper, lower)[1:-1] / self.slip_scale
            traction = u[self.q] / self.scales[self.q]
            bound = u[self.p] / self.pressure_scale
        return RollerState(u, s, p, q, upper, lower, rows, slip, traction, bound)

    def _gap_slope(self, u: Array, a: float, upper: Deformation, lower: Deformation) -> Array:
        """Return the residual of the gap slope in the cells."""
        slope = (upper.slope + lower.slope)[:-2] + u[self.shift]
        slope -= self.mesh.points * (a / self.problem.contact_radius)
        return np.asarray(slope / self.slope_scale)

    def _drive_and_load(self, u: Array, a: float, p: Array, q: Array) -> tuple[float, float]:
        """Return the residuals of the tangential load or creepage, and of the load."""
        problem = self.problem
        load = a * float(self.mesh.weights @ p)
        if self.is_force_given:
            # the force of an iterate varies with its load: else a small load could not transmit Q
            force = a * float(self.mesh.weights @ q) - self._force_by_load * load
            drive = force / (problem.friction * problem.load)
        else:
            drive = float(u[self.xi] - (problem.creepage or 0.0)) / self.slip_scale
        return drive, load / problem.load - 1

    @property
    def is_force_given(self) -> bool:
        """True if the tangential load is prescribed and xi is unknown."""
        return self.problem.friction > 0 and self.problem.creepage is None

    @property
    def _force_by_load(self) -> float:
        """dQ/dP for an iterate whose load differs from P: Q/P."""
        return (self.problem.tangential_load or 0.0) / self.problem.load

    def _slip(
        self,
        u: Array,
        s: RollerGeometry,
        p: Array,
        q: Array,
        upper: Deformation,
        lower: Deformation,
    ) -> Array:
        """Return the slip of all nodes, (N+1,).

        In rolling each node has the slip of the cell upstream of it, and the first node that of
        the first cell.  In a static contact xi is relative to the last node.
        """
        if not self.static:
            slip = (lower.strain - upper.strain)[:-2] + u[self.xi]
            return np.append(slip[:1], slip)
        displacements = []
        for side, deformation, traction in ((s.upper, upper, q), (s.lower, lower, -q)):
            end = side.surface.end_displacement(p, traction) if side.flattening else 0.0
            u_i = self._displacement(side, s.a, deformation.slope, deformation.strain, end)
            displacements.append(u_i)
        return np.asarray(displacements[1] - displacements[0] + u[self.xi])

    def _displacement(
        self, side: Side, a: float, slope: Array, strain: Array, end: Array | float
    ) -> Array:
        """Return u at the nodes relative to the last one, from v there; of columns of matrices."""
        gradient = strain
        if side.flattening:
            v = self.face.displacement_at_nodes(slope, end, a)
            gradient = strain.copy()
            gradient[:-2] -= (self.mesh.hats @ v) / side.radius
        return self.face.displacement_at_nodes(gradient, 0.0, a)

    # ---- Jacobian ------------------------------------------------------------------------------

    def jacobian(self, state: RollerState) -> Jacobian:
        """Return the derivatives of equilibrium, slip and bound by u."""
        problem, (a, *pair), n = self.problem, state.geometry, self.size - 2
        inner, size = slice(1, -1), self.q.stop
        k = size - self.q.start
        gap, slip, bound = np.zeros((n + 1, size)), np.zeros((k, size)), np.zeros((k, size))
        for side, sign in zip(pair, (1.0, -1.0), strict=True):
            surface = side.surface
            if surface.rigid:
                continue
            tangent = surface.tangent(state.p, sign * state.q)
            gap[:, self.p] += tangent.slope_p[:-2, inner]
            if not k:
                continue
            gap[:, self.q] += sign * tangent.slope_q[:-2, inner]
            by_p, by_q = tangent.strain_p, tangent.strain_q
            if self.static:
                ends = np.zeros((2, self.size))
                if side.flattening:
                    ends = np.array(surface.end_tangent(state.p, sign * state.q))
                by_p = self._displacement(side, a, tangent.slope_p, tangent.strain_p, ends[0])
                by_q = self._displacement(side, a, tangent.slope_q, tangent.strain_q, ends[1])
                by_p, by_q = by_p[inner], by_q[inner]
            slip[:, self.p] -= sign * by_p[:k, inner]
            slip[:, self.q] -= by_q[:k, inner]
        gap[:, self.shift] = 1.0
        rows, weights = np.zeros((2, size)), a * self.mesh.weights[inner]
        if self.is_force_given:
            rows[0, self.p] = -self._force_by_load * weights
            rows[0, self.q] = weights
            rows[0] /= problem.friction * problem.load
        else:
            rows[0, self.xi] = 1 / self.slip_scale
        rows[1, self.p] = weights / problem.load
        if k:
            slip[:, self.xi] = 1.0
            bound[np.arange(k), np.arange(k)] = 1 / self.pressure_scale
        equilibrium = np.concatenate([gap / self.slope_scale, rows])
        jacobian = Jacobian(equilibrium, slip / self.slip_scale, bound)
        self.fill_half_width_column(jacobian, state)
        return jacobian

    # ---- fields and outputs --------------------------------------------------------------------

    def slip_points(self, a: float) -> Array:
        """Return the collocation points of the slip of the nodes, (N+1,) [m]."""
        points = self.mesh.nodes
        if not self.static:
            points = np.append(self.mesh.points[:1], self.mesh.points)
        return np.asarray(a * points)

    def slip(self, state: RollerState) -> tuple[float, Array]:
        """Return xi and the slip of all nodes: strains in rolling, lengths [m] if static."""
        slip = self._slip(state.u, state.geometry, state.p, state.q, state.upper, state.lower)
        xi = float(state.u[self.xi])
        if not self.problem.friction and self.problem.creepage is None:
            xi = -pressure_median(slip[1:-1] - xi, (self.mesh.weights * state.p)[1:-1])
            slip = slip + (xi - state.u[self.xi])
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
        return float(s.a**2 / (2 * self.problem.contact_radius) - v - state.u[self.shift] * s.a)

    def main_outputs(self, state: RollerState) -> dict[str, float]:
        """Return the outputs whose error estimates end the mesh refinement."""
        out = {
            "half_width": state.geometry.a,
            "peak_pressure": float(state.p.max()),
            "tangential_load": state.geometry.a * float(self.mesh.weights @ state.q),
        }
        return out if self.static else {**out, "creepage": self.slip(state)[0]}

    def outputs(self, state: RollerState, active: Array) -> dict[str, float]:
        """Return the outputs whose discretisation error is estimated."""
        problem, a = self.problem, state.geometry.a
        xi, _ = self.slip(state)
        out = {
            "half_width": a,
            "nip_width": 2 * a,
            "peak_pressure": float(state.p.max()),
            "offset": float(state.u[self.shift] * problem.contact_radius),
            "approach": self.approach(state),
            "tangential_load": a * float(self.mesh.weights @ state.q),
        }
        if self.static:
            out["shift"] = self.rigid_displacement(state, xi)
        else:
            out["creepage"] = xi
        slack = problem.friction * state.p - np.abs(state.q)
        x = a * self.mesh.nodes
        out["slip_share"] = slip_share(x, self.zones(state, active), self.slip(state)[1], slack)
        if problem.viscoelastic:
            assert problem.rolling_speed is not None
            out["rolling_resistance"] = dissipation(problem, work_on_rollers(state))
            out["dissipated_power"] = problem.rolling_speed * out["rolling_resistance"]
            out["pressure_shift"] = pressure_resultant(x, state.p)[1] - out["offset"]
        return out

    def zones(self, state: RollerState, active: Array) -> Array:
        """Return the zones of all nodes; those at the edges have the zones of their neighbours.

        Without friction all nodes slip.
        """
        inner = active if self.problem.friction else np.sign(self.slip(state)[1][1:-1])
        return np.pad(inner, 1, mode="edge").astype(np.int8)

    # ---- transfer to another mesh --------------------------------------------------------------

    def prolong(
        self, state: RollerState, active: Array, coarse: RollerEquations
    ) -> tuple[Array, Array]:
        """Interpolate the unknowns of a coarse mesh; zones are those of the nearest node."""
        u = np.zeros(self.q.stop)
        old, new = coarse.mesh.nodes, self.mesh.nodes[1:-1]
        u[self.p] = np.interp(new, old, np.pad(state.u[coarse.p], 1))
        u[[self.shift, self.ln_a]] = state.u[[coarse.shift, coarse.ln_a]]
        u[self.ln_a] = min(u[self.ln_a], self.largest_ln_a)
        if self.static == coarse.static:
            u[self.xi] = state.u[coarse.xi]
        zones = np.zeros(self.q.stop - self.q.start, dtype=np.int8)
        if zones.size and active.size:
            u[self.q] = np.interp(new, old, np.pad(state.u[coarse.q], 1))
            zones = nearest(old[1:-1], active, new)
        return u, zones


def pressure_median(values: Array, weights: Array) -> float:
    """Return the weighted median, linear between the values."""
    order = np.argsort(values)
    v, w = values[order], weights[order]
    fraction = (np.cumsum(w) - w / 2) / np.sum(w)
    return float(np.interp(0.5, fraction, v))
