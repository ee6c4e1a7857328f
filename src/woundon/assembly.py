r"""The nip's equations on a grid: bodies and web joined into a normal and a stick-slip problem.

With tractions of the web on the roll q+ and on the drum q- (along +x), pressure p on both faces,
T = T_in + int (q+ + q-), 1/R* = 1/R1 + 1/R2 and the web's compliances c:

    indentation (82), differentiated      v1' + v2' + c12 (q+ + q-) - 2h c22 p' + Delta/R* = x/R*
    slip at the roll (133)                v+ = eps - eps1 - [eps - eps1](x = a)
    slip at the drum (133)                v- = eps - eps2 + xi-
    strain of the web (72)                eps = c11 T/(2h) - c12 p

The first is linear in p and Delta and is solved for them once:  p = p0 + K q  (the normal problem).
Put into the other two it leaves the stick-slip problem in q = (q+, q-) and one rigid slip,
xi = xi- + c11 T_out/(2h), which the winding force fixes.  T_in drops out: the winding theorem.

                 p          q+                    q-              xi
    v+  [  S+ = -c12 -E1p | L - E1q           |   L             |  0 ]     E: strain of a body
    v-  [  S- = -c12 -E2p | L                 |   L - E2q       |  1 ]     (E1 less its last row)
    L = c11/(2h) (upstream integral - whole integral)
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import pi, sqrt

import numpy as np

from .bodies import Body, Cylinder
from .contact.discretisation import Discretisation, Response
from .contact.normal import solve_normal
from .contact.stick_slip import StickSlip, StickSlipSolution
from .elasticity.strip import compliance
from .problems import NipProblem

__all__ = [
    "NipEquations",
    "NipMatrices",
    "NipState",
    "contact_radius",
    "half_width_guess",
    "surface_response",
]

Array = np.ndarray


def contact_radius(problem: NipProblem) -> float:
    """Return R* with 1/R* = 1/R1 + 1/R2 [m]."""
    return 1 / (1 / problem.roll.radius + 1 / problem.drum.radius)


def half_width_guess(load: float, radius: float, bodies: Iterable[Body]) -> float:
    """Return a half width to start from [m]: Hertz's, or less where a layer is thin.

    Hertz's theory for half-planes, a = 2 sqrt(P R*/(pi E*)) with 1/E* = sum C/2 (thesis eqs. 101
    to 103), is an upper bound; on a layer much thinner than a it is far off.
    """
    bodies = tuple(bodies)
    C = pi * sum(body.surface(0.01 * body.radius).slope_p.inverse for body in bodies)
    layers = [4 * body.thickness for body in bodies if isinstance(body, Cylinder)]
    return min(sqrt(2 * C * load * radius / pi), *layers, 0.3 * radius)


@dataclass(frozen=True, eq=False)
class NipState:
    """A solved nip on one grid: contact state, pressure and shift for one half width."""

    half_width: float
    solution: StickSlipSolution
    pressure: Array  # (n,) [Pa]
    shift: float  # Delta/R*

    @property
    def roll_traction(self) -> Array:
        """q+ at the interior nodes, (n,) [Pa]."""
        return self.solution.traction[: self.pressure.size]

    @property
    def drum_traction(self) -> Array:
        """q- at the interior nodes, (n,) [Pa]."""
        return self.solution.traction[self.pressure.size :]


@dataclass(frozen=True, eq=False)
class NipMatrices:
    """Every matrix of the nip's equations for one half width a, nothing solved yet.

    N cells, n = N - 1 unknown nodes; tractions are stacked (q+, q-).  Slips are those of the nodes'
    cells first, roll then drum; the last cell, which belongs to no unknown, follows for both.
    """

    half_width: float
    slope_p: Array  # (N, n)
    slope_q: Array  # (N, 2n)
    gap: Array  # (N,) slope of the gap, x/R*
    direct: Array  # (2n + 2, 2n) slips by tractions
    through_pressure: Array  # (2n + 2, n) slips by pressures
    weights: Array  # (n,) integrate a traction over the nip [m]

    @classmethod
    def at(cls, problem: NipProblem, disc: Discretisation, a: float) -> NipMatrices:
        """Assemble for the half width ``a`` [m]."""
        responses = (surface_response(body, disc, a) for body in (problem.roll, problem.drum))
        return cls.of(problem, disc, a, *responses)

    @classmethod
    def of(
        cls,
        problem: NipProblem,
        disc: Discretisation,
        a: float,
        roll: Response | None,
        drum: Response | None,
    ) -> NipMatrices:
        """Assemble for the half width ``a`` [m] and given responses of the bodies."""
        web = compliance(*problem.web.material.stiffness[:3])
        n, N = disc.unknowns, disc.unknowns + 1
        weights = a * disc.grid.weights
        slope_p = (-problem.web.thickness * web.c22 / a) * disc.slope
        slope_q = np.empty((N, 2 * n))
        slope_q[:, :n] = slope_q[:, n:] = web.c12 * disc.value
        # the web: its tension between the point and the trailing edge, and its squeezing
        direct, through = np.empty((2 * N, 2 * n)), np.empty((2 * N, n))
        stretch = (a * web.c11 / problem.web.thickness) * disc.behind
        squeeze = -web.c12 * disc.value
        direct[: 2 * n].reshape(2, n, 2, n)[...] = stretch[:-1, None]
        direct[2 * n :].reshape(2, 2, n)[...] = stretch[-1]
        through[: 2 * n].reshape(2, n, n)[...] = squeeze[:-1]
        through[2 * n :] = squeeze[-1]
        for face, response in enumerate((roll, drum)):
            if response is None:
                continue
            own, last = slice(face * n, (face + 1) * n), 2 * n + face
            slope_p = slope_p + response.slope_p
            slope_q[:, own] += response.slope_q
            strain_q, strain_p = response.strain_q[:-1], response.strain_p[:-1]
            if face == 0:  # the wound-on condition refers the roll's strain to the trailing edge
                strain_q = strain_q - response.strain_q[-1]
                strain_p = strain_p - response.strain_p[-1]
            direct[own, own] -= strain_q[:-1]
            direct[last, own] -= strain_q[-1]
            through[own] -= strain_p[:-1]
            through[last] -= strain_p[-1]
        gap = disc.middle * (a / contact_radius(problem))
        return cls(a, slope_p, slope_q, gap, direct, through, weights)


@dataclass(frozen=True, eq=False)
class NipEquations:
    """The equations of a nip for one half width, the normal problem solved; made by :meth:`at`."""

    problem: NipProblem
    disc: Discretisation
    matrices: NipMatrices
    pressure: Array  # (n,) p0
    pressure_response: Array  # (n, 2n) K
    shift: float  # Delta/R*
    shift_response: Array  # (2n,)

    @classmethod
    def at(cls, problem: NipProblem, disc: Discretisation, a: float) -> NipEquations:
        """Assemble the equations for the half width ``a`` [m] and solve the normal problem."""
        made = NipMatrices.at(problem, disc, a)
        solved = solve_normal(made.slope_p, made.gap, made.slope_q)
        return cls(
            problem, disc, made,
            solved[:-1, 0], solved[:-1, 1:], float(solved[-1, 0]), solved[-1, 1:],
        )  # fmt: skip

    @staticmethod
    def frictionless_load(problem: NipProblem, disc: Discretisation, a: float) -> float:
        """Return the load that a frictionless contact of half width ``a`` carries [N/m]."""
        web = compliance(*problem.web.material.stiffness[:3])
        slope_p = (-problem.web.thickness * web.c22 / a) * disc.slope
        for body in (problem.roll, problem.drum):
            kernels = body.surface(2 * a)
            if kernels.deforms:
                slope_p = slope_p + disc.pressure_slope(kernels, a)
        gap = disc.middle * (a / contact_radius(problem))
        pressure = solve_normal(slope_p, gap, np.empty((gap.size, 0)))[:-1, 0]
        return float(a * disc.grid.weights @ pressure)

    def stick_slip(self) -> StickSlip:
        """Return the stick-slip problem of both faces; slips are strains, tractions in Pa."""
        n, made, problem = self.disc.unknowns, self.matrices, self.problem
        nodes = slice(0, 2 * n)
        zero, one = np.zeros(n), np.ones(n)
        friction = np.concatenate([problem.roll_friction * one, problem.drum_friction * one])
        # F in proportion to the load that this half width carries: a steady state at any width
        share = problem.winding_force / problem.nip_load
        carried = share * (made.weights @ self.pressure_response)
        return StickSlip(
            made.direct[nodes], made.through_pressure[nodes], np.zeros(2 * n),
            self.pressure, self.pressure_response, friction, faces=2,
            creep=np.concatenate([zero, one]),
            resultant=np.concatenate([zero, made.weights]) - carried,
            force=share * float(made.weights @ self.pressure),
        )  # fmt: skip

    def state(self, solution: StickSlipSolution) -> NipState:
        """Return the state that belongs to solved tractions."""
        q = solution.traction
        return NipState(
            self.matrices.half_width, solution,
            self.pressure + self.pressure_response @ q,
            self.shift + float(self.shift_response @ q),
        )  # fmt: skip

    def last_slips(self, state: NipState) -> tuple[float, float]:
        """Return v+ and v- in the last cell, which belongs to no unknown."""
        last = slice(2 * self.disc.unknowns, None)
        slips = self.matrices.direct[last] @ state.solution.traction
        slips += self.matrices.through_pressure[last] @ state.pressure
        return float(slips[0]), float(slips[1]) + state.solution.creep


def surface_response(body: Body, disc: Discretisation, a: float) -> Response | None:
    """Return a body's matrices on the grid scaled by ``a`` [m]; None for a rigid one."""
    kernels = body.surface(2 * a)
    return disc.response(kernels, body.curvature, a) if kernels.deforms else None
