r"""Equilibrium of a hardening ring and of a linear one under forces on the surface.

The ring R0 <= r <= R on a rigid core is wound under the pressure P0(r).  Displacements u of its
finite elements (:mod:`.ring_elements`) add strains B u and stresses s(B u) (:mod:`.hardening`); the
surface carries nodal forces f:

    F(u) = int B^T s(B u) dV = f,        K = dF/du = int B^T (ds/de) B dV.

The energy is convex, so that the solution is unique.  Newton's method finds it.  A factorisation
of K costs as much as ten steps and is reused while the steps shrink (modified Newton method): under
other forces, and for other half widths, because K of a deep ring does not change if its mesh is
scaled.  The residual is the step K^-1 (f - F) in the energy norm, relative to the displacements:

    residual^2 = (f - F).K^-1 (f - F) / f.u

The forces f - F themselves cannot vanish in thin rows of elements: with K ~ E_t h/l for elements
of length l and height h, displacements that are rounded in the last digit change them by 1e-8 of
the load.  The linear ring has the moduli of the wound surface; its displacements follow
by conjugate gradients with an earlier factorisation as preconditioner.  The earlier states affect
the results by the remaining residuals only.

Under a uniform pressure p the ring needs no elements: with e_t = v/r and s_t = E_t e_t + nu s_r,

    dv/dr = e_r(s_r, s_t),   ds_r/dr = (s_t - s_r)/r,   v(R0) = 0,   s_r(R) = -p.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import log, sqrt

import numpy as np
from scipy.integrate import solve_bvp
from scipy.sparse.linalg import LinearOperator, cg

from .hardening import HardeningLaw, StressState
from .ring_elements import Factors, Fineness, RingMesh

__all__ = ["NoEquilibrium", "RingPair", "RingState", "uniform_strain"]

Array = np.ndarray

# Largest residual: the last step of the Newton method of the contact.  Rounding errors are 3e-12 in
# a roll of 0.54 m under 98 N/m, where the first elements are 0.06 um high, and less in others.
TOLERANCE = 1e-11
# Residual of the conjugate gradients, relative to the load.
LINEAR_TOLERANCE = 1e-12
MAX_ITERATIONS = 200  # of Newton's method with reused factorisations
# Largest change of ln E_r in a step: the tangent is that of the modulus before the step.
LARGEST_CHANGE = 1.0
# K is factorised again if a step exceeds this fraction of the one before.  A factorisation
# costs about ten steps; factors of 0.05 to 0.5 take the same time.
SLOWEST_RATE = 0.3
# A factorisation with which the steps shrink by this factor is an accurate tangent.
ACCURATE_RATE = 1e-4
# Change of ln a up to which the compliance of the linear ring is reused in a tangent.
REUSE_DISTANCE = 0.02
# Iterations before the linear ring of this half width is factorised, which costs about as much.
CONJUGATE_GRADIENTS = 10
# Initial nodes and relative tolerance of the ring under a uniform pressure, whose strain is a small
# part of that of the web.
UNIFORM_NODES, UNIFORM_TOLERANCE = 41, 1e-5


class NoEquilibrium(ArithmeticError):
    """No equilibrium of the ring was found."""


@dataclass(frozen=True, eq=False)
class RingState:
    """A ring in equilibrium.

    Attributes
    ----------
    mesh : RingMesh
    u : (size,) array
        Displacements of all unknowns of the mesh [m].
    stress_state : StressState
        Stresses, moduli and pressure at the quadrature points.
    residual : float
        Of the equilibrium in the energy norm, relative to the displacements.
    factors : Factors
        A factorisation of K at this state or a neighbouring one.
    accurate : bool
        True if the factorisation is the tangent of this state.
    """

    mesh: RingMesh
    u: Array
    stress_state: StressState
    residual: float
    factors: Factors
    accurate: bool

    @property
    def min_pressure(self) -> float:
        """Smallest pressure in the ring [Pa]."""
        return float(self.stress_state.pressure.min())

    @property
    def max_pressure(self) -> float:
        """Largest pressure in the ring [Pa]."""
        return float(self.stress_state.pressure.max())


class RingPair:
    """The hardening ring and the linear ring on the same elements.

    Parameters
    ----------
    radius, core_radius : float
        R and R0 [m].
    law : HardeningLaw
    wound_pressure : callable
        P0(r) [Pa], vectorised.

    Attributes
    ----------
    factorisations : int
        Number of stiffness matrices factorised so far.
    """

    def __init__(
        self,
        radius: float,
        core_radius: float,
        law: HardeningLaw,
        wound_pressure: Callable[[Array], Array],
    ) -> None:
        self.radius, self.core_radius = radius, core_radius
        self.law, self.wound_pressure = law, wound_pressure
        self._latest: RingState | None = None  # of the hardening ring, the next initial guess
        self._reference: tuple[RingMesh, Factors] | None = None  # of the linear ring
        self.factorisations = 0

    @property
    def stiffness(self) -> tuple[float, float, float, float]:
        """A_rr, A_tt, A_rt, G of the linear ring: those of the wound surface [Pa]."""
        return self.law.stiffness(float(self.wound_pressure(np.array(self.radius))))

    def mesh(self, fineness: Fineness, a: float) -> RingMesh:
        """Return the elements for a half width a [m]."""
        return RingMesh(self.radius, self.core_radius, fineness, a)

    # ---- hardening ring ------------------------------------------------------------------------

    def equilibrium(self, mesh: RingMesh, forces: Array) -> RingState:
        """Return the hardening ring in equilibrium, from the latest state as initial guess.

        Parameters
        ----------
        mesh : RingMesh
        forces : (2, k) array
            Nodal forces of the surface along r and x [N/m].

        Raises
        ------
        NoEquilibrium
        """
        f = np.zeros(mesh.topology.size)
        f[mesh.topology.surface] = forces
        zero, latest = np.zeros(f.size), self._latest
        try:
            if latest is None:
                state = self._newton(mesh, f, zero)
            elif latest.mesh.fineness == mesh.fineness:  # displacements scale with the mesh
                u = latest.u * (mesh.half_width / latest.mesh.half_width)
                state = self._newton(mesh, f, u, latest)
            else:
                state = self._newton(mesh, f, mesh.interpolate(latest.u, latest.mesh))
        except NoEquilibrium:
            if latest is None:
                raise
            state = self._newton(mesh, f, zero)
        self._latest = state
        return state

    def _newton(
        self, mesh: RingMesh, f: Array, u: Array, neighbour: RingState | None = None
    ) -> RingState:
        """Solve F(u) = f by the modified Newton method.

        Parameters
        ----------
        mesh : RingMesh
        f, u : (size,) arrays
            Forces on all unknowns [N/m], and the initial guess of the displacements [m].
        neighbour : RingState, optional
            A neighbouring state, whose pressures and factorisation are used.

        Raises
        ------
        NoEquilibrium
        """
        P0 = self.wound_pressure(mesh.quadrature_radii)
        pressure, factors, accurate = None, None, False
        if neighbour is not None:
            pressure, factors = neighbour.stress_state.pressure, neighbour.factors
            accurate = neighbour.accurate
        stress_state = self.law.stress_state(mesh.strain(u), P0, pressure)
        # rate: largest ratio of successive residuals with these factors
        last_residual, rate = np.inf, 0.0
        for _ in range(MAX_ITERATIONS):
            unbalanced = f - mesh.forces(stress_state.stress)
            if factors is not None:
                step = factors.solve(unbalanced)
                residual = _energy_norm(unbalanced, step, f, u)
                if last_residual < np.inf:
                    rate = max(rate, residual / last_residual)
                    accurate = rate <= ACCURATE_RATE
            if factors is None or rate > SLOWEST_RATE:
                factors, rate = self._factorise(mesh, stress_state.tangent), 0.0
                accurate = True
                step = factors.solve(unbalanced)
                residual = _energy_norm(unbalanced, step, f, u)
            if residual <= TOLERANCE:
                return RingState(mesh, u, stress_state, residual, factors, accurate)
            last_residual = residual
            u, stress_state = self._advance(mesh, P0, u, step, stress_state, f)
        raise NoEquilibrium(f"the roll has no equilibrium: residual {residual:.2g}")

    def _advance(
        self, mesh: RingMesh, P0: Array, u: Array, step: Array, stress_state: StressState, f: Array
    ) -> tuple[Array, StressState]:
        """Take a damped step: ln E_r changes by at most 1, and the energy does not increase.

        Returns displacements u and stress state after the step; arguments as of :meth:`_newton`.
        The step is halved until the derivative of the energy along it, (F(u) - f).step at its end,
        is at most half of the descent at its start.
        """
        # dP = -E_r de_r changes ln E_r by -(dE_r/dP) de_r
        E_slope = self.law.radial.modulus_slope(stress_state.pressure)
        change = float(np.max(np.abs(E_slope * mesh.strain(step)[..., 0])))
        damping = min(1.0, LARGEST_CHANGE / change) if change > 0 else 1.0
        descent = (f - mesh.forces(stress_state.stress)) @ step
        for _ in range(30):
            stepped = self.law.stress_state(
                mesh.strain(u + damping * step), P0, stress_state.pressure
            )
            if (mesh.forces(stepped.stress) - f) @ step <= descent / 2:
                break
            damping /= 2
        return u + damping * step, stepped

    def _factorise(self, mesh: RingMesh, moduli: Array) -> Factors:
        """Factorise the stiffness matrix of moduli (e, 9, 3, 3)."""
        self.factorisations += 1
        return mesh.stiffness(moduli)

    # ---- linear ring ---------------------------------------------------------------------------

    def linear(self, mesh: RingMesh, forces: Array) -> Array:
        """Return the surface displacements of the linear ring, (2, k) [m]."""
        return np.asarray(self.linear_displacements(mesh, forces)[mesh.topology.surface])

    def linear_displacements(self, mesh: RingMesh, forces: Array) -> Array:
        """Return all displacements of the linear ring under nodal forces (2, k) [m].

        Raises
        ------
        NoEquilibrium
            If the conjugate gradients do not converge and the displacements are not in equilibrium
            up to rounding errors.
        """
        size, surface = mesh.topology.size, mesh.topology.surface
        f = np.zeros(size)
        f[surface] = forces
        moduli, atol = self._moduli, LINEAR_TOLERANCE * float(np.linalg.norm(f))
        # conjugate gradients for K u = f, K as an operator on the elements; preconditioned by the
        # factors for another half width, or if these do not serve, by those for this one, the
        # rounding errors of which they correct
        K = LinearOperator((size, size), lambda v: mesh.forces(mesh.strain(v.ravel()) @ moduli))
        for distance in (np.inf, 0.0):
            reference, factors = self._linear_factors(mesh, distance)
            M = LinearOperator((size, size), factors.solve)
            u, info = cg(
                K, f, factors.solve(f), rtol=0.0, atol=atol, maxiter=CONJUGATE_GRADIENTS, M=M
            )
            if info == 0:
                return np.asarray(u)
            if reference is mesh:  # they are the factors for this half width
                break
        # rounding errors of K may exceed the tolerance of the forces, but not that of the
        # displacements, which is also that of the hardening ring
        unbalanced = f - K.matvec(u)
        residual = _energy_norm(unbalanced, factors.solve(unbalanced), f, u)
        if not residual <= TOLERANCE:
            raise NoEquilibrium(f"the linear ring has no equilibrium: residual {residual:.2g}")
        return np.asarray(u)

    def _linear_factors(self, mesh: RingMesh, distance: float) -> tuple[RingMesh, Factors]:
        """Return a factorisation of the linear ring and its mesh.

        It is reused if the half width of its mesh differs by less than ``distance`` in ln a.
        """
        reference = self._reference
        if (
            reference is None
            or reference[0].fineness != mesh.fineness
            or (
                reference[0] is not mesh
                and abs(log(reference[0].half_width / mesh.half_width)) >= distance
            )
        ):
            moduli = np.broadcast_to(self._moduli, (*mesh.weights.shape, 3, 3))
            reference = self._reference = mesh, self._factorise(mesh, moduli)
        return reference

    @property
    def _moduli(self) -> Array:
        """Matrix of the moduli of the linear ring, (3, 3) [Pa]."""
        A_rr, A_tt, A_rt, G = self.stiffness
        return np.array([[A_rr, A_rt, 0], [A_rt, A_tt, 0], [0, 0, G]])

    # ---- difference ----------------------------------------------------------------------------

    def difference(self, state: RingState, forces: Array) -> Array:
        """Return the surface displacements of a state minus those of the linear ring, (2, k)."""
        return state.u[state.mesh.topology.surface] - self.linear(state.mesh, forces)

    def stress_difference(self, state: RingState, forces: Array) -> Array:
        """Return sigma_r, sigma_t and tau of a state minus those of the linear ring, (e, 9, 3)."""
        linear = state.mesh.strain(self.linear_displacements(state.mesh, forces))
        return np.asarray(state.stress_state.stress - linear @ self._moduli)

    def tangent(self, state: RingState) -> Array:
        """Return the derivative of :meth:`difference` by the nodal forces, (2, k, 2, k)."""
        factors = state.factors
        if not state.accurate:
            factors = self._factorise(state.mesh, state.stress_state.tangent)
            if self._latest is state:
                self._latest = replace(state, factors=factors, accurate=True)
        _, linear = self._linear_factors(state.mesh, REUSE_DISTANCE)
        return factors.compliance - linear.compliance


def _energy_norm(forces: Array, step: Array, f: Array, u: Array) -> float:
    """Return the step under unbalanced forces in the energy norm, the residual of the equilibrium.

    It is relative to the displacements after the step, u + step, under the forces f; a ring without
    forces has none, and the norm is absolute [sqrt(J/m)].

    Parameters
    ----------
    forces, f : (size,) arrays
        Unbalanced forces, and all forces on the ring [N/m].
    step, u : (size,) arrays
        Step of Newton's method, and the displacements before it [m].
    """
    return sqrt(abs(forces @ step) / (abs(f @ (u + step)) or 1.0))


def uniform_strain(ring: RingPair, pressure: float) -> float:
    """Return the surface strain v(R)/R of the hardening ring under a uniform pressure [Pa].

    Raises
    ------
    NoEquilibrium
    """
    law, R, R0 = ring.law, ring.radius, ring.core_radius

    def rates(r: Array, y: Array) -> Array:
        """Return dv/dr and ds_r/dr of y = (v, s_r)."""
        v, s_r = y
        P0 = ring.wound_pressure(r)
        s_t = law.tangential * v / r + law.poissons_ratio * s_r
        e_r = law.radial.strain_at(P0) - law.radial.strain_at(P0 - s_r)
        return np.array([e_r - law.poissons_ratio / law.tangential * s_t, (s_t - s_r) / r])

    def boundary(core: Array, surface: Array) -> Array:
        """Return the residuals of v(R0) = 0 and s_r(R) = -p."""
        return np.array([core[0] / R, surface[1] / pressure + 1])

    r = R - (R - R0) * np.linspace(1, 0, UNIFORM_NODES) ** 3  # the pressure decays from the surface
    initial_guess = np.stack([np.zeros(r.size), np.full(r.size, -pressure)])
    solution = solve_bvp(rates, boundary, r, initial_guess, tol=UNIFORM_TOLERANCE, max_nodes=20_000)
    if not solution.success:
        raise NoEquilibrium(f"the ring under a uniform pressure: {solution.message}")
    return float(solution.y[0, -1] / R)
