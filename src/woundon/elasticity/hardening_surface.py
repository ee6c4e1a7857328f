r"""Surface response of a hardening roll: the linear cylinder plus a difference by finite elements.

The surface displacements w = (v, u) under the tractions f = (p, q) are

    w(f) = w_0(f) + [w_h(f) - w_0h(f)],

where w_0 is the response of the linear cylinder with the moduli of the wound surface by its
influence functions (:mod:`.influence`), and w_h and w_0h are the responses of the hardening and of
the linear ring on the same finite elements (:mod:`.ring_equilibrium`).  The tractions vanish at the
contact edges as a square root, so that both rings have the same moduli and the same singularities
there.  The difference is smoother, and resolved by the elements: its strains vary as the distance
from the edge times its logarithm.

The elements are scaled with the half width, so that the response is a smooth function of p, q and
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

MIN_COLUMNS = 8  # of elements under the contact
# The error of the elements varies as the third power of their size, that of the contact as the
# second.  Above this number of cells in the nip the number of columns therefore grows more slowly.
MANY_CELLS = 64


class RingSolution(NamedTuple):
    """The ring under the pressures p and the tractions q."""

    p: Array
    q: Array
    state: RingState
    difference: Array  # v and u of the surface nodes minus those of the linear ring, (2, k) [m]


class HardeningSurface:
    """The :class:`.surface.SurfaceResponse` of a hardening roll.

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

    Notes
    -----
    The arguments p and q of the methods are pressures and tractions along +x at the n nodes of the
    face, (n,) each [Pa].
    """

    rigid = False

    def __init__(
        self, ring: RingPair, linear: InfluenceSurface, face: Face, half_width: float, limit: float
    ) -> None:
        self.ring, self.linear, self.face = ring, linear, face
        self.a, self.limit = half_width, limit
        self._latest: RingSolution | None = None

    def deform(self, p: Array, q: Array) -> Deformation:
        """Return the deformation under nodal pressures and tractions, (n,) each [Pa].

        That of the linear ring is added to the difference of the hardening ring.
        """
        slope, strain = self.linear.deform(p, q)
        slope_difference, strain_difference = self._gradients(self._solve(p, q).difference)
        return Deformation(slope + slope_difference, strain + strain_difference)

    def tangent(self, p: Array, q: Array) -> SurfaceTangent:
        """Return the derivatives of ``deform`` by nodal pressures and tractions p, q, (n,) each."""
        by_p, by_q = self._tangent(p, q)
        slope_p, slope_q, strain_p, strain_q = self.linear.tangent(p, q)
        d_slope_p, d_strain_p = self._gradients(by_p)
        d_slope_q, d_strain_q = self._gradients(by_q)
        return SurfaceTangent(
            slope_p + d_slope_p, slope_q + d_slope_q, strain_p + d_strain_p, strain_q + d_strain_q
        )

    def end_displacement(self, p: Array, q: Array) -> float:
        """Return v at the trailing edge of the nip [m]."""
        v = self._solve(p, q).difference[0]
        return self.linear.end_displacement(p, q) + float(self._end_values @ v)

    def end_tangential_displacement(self, p: Array, q: Array) -> float:
        """Return u at the last node [m]."""
        u = self._solve(p, q).difference[1]
        return self.linear.end_tangential_displacement(p, q) + float(self._end_values @ u)

    def end_tangent(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``end_displacement`` by p and by q, (n,) each [m/Pa]."""
        by_p, by_q = self._tangent(p, q)
        end_p, end_q = self.linear.end_tangent(p, q)
        return end_p + self._end_values @ by_p[0], end_q + self._end_values @ by_q[0]

    def strain_outside(self, p: Array, q: Array, s: Array) -> Array:
        """Return the strain at positions s (k,) [m] along the surface, outside of the face."""
        v, u = self._solve(p, q).difference
        value, slope = self._mesh.splines(s)
        linear = self.linear.strain_outside(p, q, s)
        return np.asarray(linear + slope @ u + value @ v / self.ring.radius)

    def tangent_outside(self, s: Array) -> SurfaceTangent:
        """Return the derivatives of slope and strain at positions s [m] outside, (k, n) each.

        Far from the nip the roll is loaded lightly, and its law is that of the linear ring.
        """
        return self.linear.tangent_outside(s)

    # ---- state of the ring ---------------------------------------------------------------------

    def residual(self, p: Array, q: Array) -> float:
        """Return the residual of the equilibrium of the ring (energy norm)."""
        return self._solve(p, q).state.residual

    def range_message(self, p: Array, q: Array) -> str:
        """Return a message if a pressure in the roll is outside the range of the law, else ''.

        p and q are the nodal pressures and tractions, (n,) [Pa].
        """
        state, law = self._solve(p, q).state, self.ring.law
        # the limit may be the end of the law, or E_r so large that the energy is indefinite
        if self.limit < state.max_pressure < law.radial.max_pressure:
            E = float(law.radial.modulus(np.array(state.max_pressure)))
            return (
                f"the pressure in it reaches {state.max_pressure:.4g} [Pa], where E_r = {E:.4g} "
                f"[Pa]: its poissons_ratio = {law.poissons_ratio:.4g} must be < "
                f"(tangential/E_r)^(1/2) = {(law.tangential / E) ** 0.5:.4g}, or the strain energy "
                "is indefinite"
            )
        if state.max_pressure > self.limit:
            return (
                f"the pressure in it reaches {state.max_pressure:.4g} [Pa], beyond the range of "
                f"its stack law ({self.limit:.4g} [Pa]): lower the nip load or extend the law"
            )
        if state.min_pressure < law.min_pressure:
            return (
                "its stack is torn next to the contact: the pressure falls to "
                f"{state.min_pressure:.4g} [Pa], and at {law.min_pressure:.4g} [Pa] it has lost 95 "
                "% of its stiffness; a higher wound pressure or a lower nip load is needed"
            )
        return ""

    # ---- finite elements -----------------------------------------------------------------------

    def _solve(self, p: Array, q: Array) -> RingSolution:
        """Return the ring under p and q, (n,); negative pressures of an iterate count as zero.

        The solution of the last p and q is kept, because a state is evaluated several times.
        """
        latest = self._latest
        if latest is None or not (np.array_equal(p, latest.p) and np.array_equal(q, latest.q)):
            forces = np.stack([-self._hat_forces @ np.maximum(p, 0.0), self._hat_forces @ q])
            state = self.ring.equilibrium(self._mesh, forces)
            latest = RingSolution(p.copy(), q.copy(), state, self.ring.difference(state, forces))
            self._latest = latest
        return latest

    def _tangent(self, p: Array, q: Array) -> tuple[Array, Array]:
        """Return the derivatives of v and u of k surface nodes by p and by q, (2, k, n) [m/Pa]."""
        compliance = self.ring.tangent(self._solve(p, q).state)
        by_radial_force, by_tangential_force = compliance[:, :, 0], compliance[:, :, 1]
        # negative pressures are replaced by zero and have no effect
        by_p = -by_radial_force @ (self._hat_forces * (p >= 0))
        return by_p, by_tangential_force @ self._hat_forces

    def _gradients(self, w: Array) -> tuple[Array, Array]:
        """Return slope and strain at the points of the face from v and u of the surface nodes.

        ``w`` is (2, k) or, for derivatives by the n nodal tractions, (2, k, n).
        """
        value, slope = self._splines
        return slope @ w[0], slope @ w[1] + value @ w[0] / self.ring.radius

    @cached_property
    def _mesh(self) -> RingMesh:
        """The elements of the ring for this half width."""
        return self.ring.mesh(ring_fineness(self.face.size - 1), self.a)

    @cached_property
    def _hat_forces(self) -> Array:
        """Forces at the surface nodes of the ring by unit nodal tractions, (k, n) [m]."""
        return self._mesh.hat_forces(self.a * self.face.nodes)

    @cached_property
    def _splines(self) -> tuple[Array, Array]:
        """Values and slopes at the points of the face of unit nodal displacements, (n+1, k)."""
        return self._mesh.splines(self.a * self.face.points)

    @cached_property
    def _end_values(self) -> Array:
        """Values at the trailing edge of the nip of unit nodal displacements, (k,)."""
        trailing_edge = self.a * self.face.points[-2:-1]
        values, _ = self._mesh.splines(trailing_edge)
        return values[0]


def ring_fineness(cells: int) -> Fineness:
    """Return the numbers of elements for the number of cells of a nip.

    One column under the contact for two cells.  Above MANY_CELLS the number of columns varies as
    the power 0.6 of the number of cells.
    """
    columns = MANY_CELLS / 2 * (cells / MANY_CELLS) ** 0.6
    inside = max(MIN_COLUMNS, cells // 2 if cells <= MANY_CELLS else round(columns))
    return Fineness(inside=inside, outside=8 + inside // 4, rows=4 + 3 * inside // 8)


def hardening_sections(
    ring: RingPair, x: Array, p: Array, q: Array, depths: Array, half_width: float
) -> tuple[Section, ...]:
    """Return the stresses added by surface tractions to those of a wound, hardening roll.

    They are the stresses in the linear cylinder with the moduli of the wound surface
    (:mod:`.interior_stress`) plus the difference between the hardening and the linear ring.  The
    difference is zero at the surface and interpolated linearly between the quadrature points.

    Parameters
    ----------
    ring : RingPair
    x, p, q : (k,) arrays
        Nodes [m], within one circumference, and piecewise linear tractions [Pa].
    depths : (m,) array
        z > 0 [m], above the core.
    half_width : float
        a of the nip [m].

    Returns
    -------
    tuple of Section
        One for each depth, at the equidistant positions of :func:`.cylinder_sections`.
    """
    cells = int(np.sum(np.abs(x) <= half_width * (1 + 1e-9))) - 1  # of the nip, without wraps
    mesh = ring.mesh(ring_fineness(cells), half_width)
    hat_forces = mesh.hat_forces(x)
    forces = np.stack([-hat_forces @ np.maximum(p, 0.0), hat_forces @ q])
    stress = ring.stress_difference(ring.equilibrium(mesh, forces), forces)
    grid_x, grid_r = mesh.quadrature_grid
    grid_r = np.append(grid_r, ring.radius)
    # sigma_r and tau, components 0 and 2, on the grid (r, x), with a row of zeros at the surface
    normal, shear = (
        np.vstack([mesh.on_quadrature_grid(stress[..., k]), np.zeros(grid_x.size)]) for k in (0, 2)
    )

    def interpolate(values: Array, z: float, x: Array) -> Array:
        """Interpolate values on the quadrature grid at the depth z and the positions x [m]."""
        # rows k - 1 and k enclose the radius; below the first row the values are extrapolated
        k = int(np.clip(np.searchsorted(grid_r, ring.radius - z), 1, grid_r.size - 1))
        t = (ring.radius - z - grid_r[k - 1]) / np.diff(grid_r)[k - 1]
        return np.interp(x, grid_x, values[k - 1] * (1 - t) + values[k] * t, period=mesh.period)

    # one layer, of the depth ln(R/R0)
    layers = ((depth(ring.radius, ring.core_radius), *ring.stiffness),)
    return tuple(
        Section(
            linear.depth,
            linear.x,
            linear.normal + interpolate(normal, linear.depth, linear.x),
            linear.shear + interpolate(shear, linear.depth, linear.x),
        )
        for linear in cylinder_sections(x, p, q, depths, ring.radius, layers)
    )
