r"""Surface response of a hardening roll: the linear cylinder plus a difference by finite elements.

Under pressures and tractions f = (p, q) the surface moves by

    w(f) = w_0(f) + [w_h(f) - w_0h(f)],        w = (v, u),

w_0 that of the linear cylinder with the moduli of the wound surface, by its influence functions
(:mod:`.influence`), w_h and w_0h those of the hardening and of the linear ring on the same finite
elements (:mod:`.ring_equilibrium`).  At the contact edges the tractions fall to zero like a square
root, so that both rings are equally stiff and have the same singularities: the elements resolve the
rest, whose strains vary as the distance times its logarithm.

The columns of elements follow the half width, so that the response is a smooth function of p, q and
ln a.  A cubic spline through the displacements of the surface nodes gives slopes and strains.
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from .cylinder import depth
from .influence import InfluenceSurface
from .interior_stress import Section, cylinder_sections
from .mesh import Face
from .ring_elements import Fineness, RingMesh
from .ring_equilibrium import RingPair, RingState
from .surface import Deformation, SurfaceTangent

__all__ = ["HardeningSurface", "hardening_sections", "ring_fineness"]

Array = np.ndarray

FEWEST_COLUMNS = 8  # of elements under the contact
# The error of the elements falls with the third power of their size, that of the contact with the
# second: from so many cells of the nip on, the number of columns grows more slowly.
MANY_CELLS = 64


class Solved(NamedTuple):
    """The ring under given pressures and tractions."""

    p: Array
    q: Array
    state: RingState
    difference: Array  # v and u of the surface nodes minus those of the linear ring, (2, k) [m]


class HardeningSurface:
    """The surface of a hardening roll on a face.

    Parameters
    ----------
    ring : RingPair
    linear : InfluenceSurface
        The linear cylinder with ``ring.stiffness``.
    face : Face
    half_width : float
        a [m].
    limit : float
        Pressure at which the law of the stack ends [Pa].
    """

    rigid = False

    def __init__(
        self, ring: RingPair, linear: InfluenceSurface, face: Face, half_width: float, limit: float
    ) -> None:
        self.ring, self.linear, self.face, self.a, self.limit = (
            ring,
            linear,
            face,
            half_width,
            limit,
        )
        self._solved: Solved | None = None

    def deform(self, p: Array, q: Array) -> Deformation:
        """Return the deformation under nodal pressures and tractions."""
        slope, strain = self.linear.deform(p, q)
        more_slope, more_strain = self._gradients(self._solve(p, q).difference)
        return Deformation(slope + more_slope, strain + more_strain)

    def tangent(self, p: Array, q: Array) -> SurfaceTangent:
        """Return the derivatives of ``deform``."""
        by_p, by_q = self._tangent(p, q)
        slope_p, slope_q, strain_p, strain_q = self.linear.tangent(p, q)
        (more_slope_p, more_strain_p), (more_slope_q, more_strain_q) = map(
            self._gradients, (by_p, by_q)
        )
        return SurfaceTangent(
            slope_p + more_slope_p,
            slope_q + more_slope_q,
            strain_p + more_strain_p,
            strain_q + more_strain_q,
        )

    def end_displacement(self, p: Array, q: Array) -> float:
        """Return v at the trailing edge of the nip [m]."""
        v = self._solve(p, q).difference[0]
        return self.linear.end_displacement(p, q) + float(self._end @ v)

    def end_tangential_displacement(self, p: Array, q: Array) -> float:
        """Return u at the last node [m]."""
        u = self._solve(p, q).difference[1]
        return self.linear.end_tangential_displacement(p, q) + float(self._end @ u)

    def end_tangent(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``end_displacement`` by p and q."""
        by_p, by_q = self._tangent(p, q)
        end_p, end_q = self.linear.end_tangent(p, q)
        return end_p + self._end @ by_p[0], end_q + self._end @ by_q[0]

    def strain_outside(self, p: Array, q: Array, s: Array) -> Array:
        """Return the strain at positions s (k,) [m] along the surface, outside of the face."""
        v, u = self._solve(p, q).difference
        value, slope = self._mesh.splines(s)
        linear = self.linear.strain_outside(p, q, s)
        return np.asarray(linear + slope @ u + value @ v / self.ring.radius)

    # ---- state of the ring ---------------------------------------------------------------------

    def residual(self, p: Array, q: Array) -> float:
        """Return the largest nodal force of the ring that is not balanced, relative to the load."""
        return self._solve(p, q).state.residual

    def outside(self, p: Array, q: Array) -> str:
        """Return a message if a pressure in the roll lies outside the law, else ''."""
        state, law = self._solve(p, q).state, self.ring.law
        if state.max_pressure > self.limit:
            return (
                f"the pressure in it reaches {state.max_pressure:.4g} [Pa], beyond the range of "
                f"its stack law ({self.limit:.4g} [Pa]): lower the nip load or extend the law"
            )
        if state.lowest < law.lowest:
            return (
                f"its stack is torn next to the contact: the pressure falls to {state.lowest:.4g} "
                f"[Pa], and at {law.lowest:.4g} [Pa] it has lost 95 % of its stiffness; a higher "
                "wound pressure or a lower nip load is needed"
            )
        return ""

    # ---- finite elements -----------------------------------------------------------------------

    def _solve(self, p: Array, q: Array) -> Solved:
        """Return the ring under p and q; a negative pressure of an iterate does not act on it."""
        last = self._solved
        if last is None or not (np.array_equal(p, last.p) and np.array_equal(q, last.q)):
            forces = np.stack([-self._hats @ np.maximum(p, 0.0), self._hats @ q])
            state = self.ring.equilibrium(self._mesh, forces)
            last = Solved(p.copy(), q.copy(), state, self.ring.difference(state, forces))
            self._solved = last
        return last

    def _tangent(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return v and u of the surface nodes by p and by q, (2, k, n) [m/Pa]."""
        compliance = self.ring.tangent(self._solve(p, q).state)
        hats = self._hats
        return -compliance[:, :, 0] @ (hats * (p >= 0)), compliance[:, :, 1] @ hats

    def _gradients(self, w: Array) -> tuple[Array, Array]:
        """Return slope and strain at the points of the face, of v and u of the surface nodes."""
        value, slope = self._splines
        return slope @ w[0], slope @ w[1] + value @ w[0] / self.ring.radius

    @cached_property
    def _mesh(self) -> RingMesh:
        return self.ring.mesh(ring_fineness(self.face.size - 1), self.a)

    @cached_property
    def _hats(self) -> Array:
        """Nodal forces of unit pressures, (k, n) [m]."""
        return self._mesh.hats(self.a * self.face.nodes)

    @cached_property
    def _splines(self) -> tuple[Array, Array]:
        """Values and slopes at the points of the face, (n+1, k)."""
        return self._mesh.splines(self.a * self.face.points)

    @cached_property
    def _end(self) -> Array:
        """Value at the trailing edge of the nip, (k,)."""
        return self._mesh.splines(self.a * self.face.points[-2:-1])[0][0]


def ring_fineness(cells: int) -> Fineness:
    """Return the numbers of elements for the number of cells of a nip."""
    many = MANY_CELLS / 2 * (cells / MANY_CELLS) ** 0.6
    inside = max(FEWEST_COLUMNS, cells // 2 if cells <= MANY_CELLS else round(many))
    return Fineness(inside, 8 + inside // 4, 4 + 3 * inside // 8)


def hardening_sections(
    ring: RingPair, x: Array, p: Array, q: Array, depths: Array, half_width: float
) -> tuple[Section, ...]:
    """Return the stresses that surface tractions add to those of a wound, hardening roll.

    Those of the linear cylinder with the moduli of the wound surface, by harmonics, plus the
    difference between the hardening and the linear ring.  The difference vanishes at the surface
    and is interpolated linearly between the quadrature points of the elements.

    Parameters
    ----------
    ring : RingPair
    x, p, q : (k,) arrays
        Nodes [m], within one circumference, and piecewise linear tractions [Pa].
    depths : (m,) array
        z > 0 [m], above the core.
    half_width : float
        a of the nip [m].
    """
    cells = int(np.sum(np.abs(x) <= half_width * (1 + 1e-9))) - 1
    mesh = ring.mesh(ring_fineness(cells), half_width)
    hats = mesh.hats(x)
    forces = np.stack([-hats @ np.maximum(p, 0.0), hats @ q])
    stress = ring.stress_difference(ring.equilibrium(mesh, forces), forces)
    grid_x, grid_r = mesh.quadrature_grid
    grid_r = np.append(grid_r, ring.radius)
    normal, shear = (
        np.vstack([mesh.on_quadrature_grid(stress[..., k]), np.zeros(grid_x.size)]) for k in (0, 2)
    )

    def at_depth(values: Array, z: float, around: Array) -> Array:
        k = int(np.clip(np.searchsorted(grid_r, ring.radius - z), 1, grid_r.size - 1))
        t = (ring.radius - z - grid_r[k - 1]) / np.diff(grid_r)[k - 1]
        along = values[k - 1] * (1 - t) + values[k] * t
        return np.interp(around, grid_x, along, period=mesh.period)

    layers = ((depth(ring.radius, ring.core_radius), *ring.stiffness),)
    return tuple(
        Section(
            s.depth,
            s.x,
            s.normal + at_depth(normal, s.depth, s.x),
            s.shear + at_depth(shear, s.depth, s.x),
        )
        for s in cylinder_sections(x, p, q, depths, ring.radius, layers)
    )
