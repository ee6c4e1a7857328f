"""The published procedure, kept to compare with: thesis sec. 3.4 and 3.6 to the letter.

Even nodes, backward differences, web coefficients (121) as printed; the cylinder's displacements by
Fourier series of 20 000 terms, summed plainly over the differences of the nodes (113); for each
half width the modified Panagiotopoulos process from a cold start, all nodes in stick.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

import woundon as wo
from woundon.contact.meshes import Mesh
from woundon.contact.panagiotopoulos import panagiotopoulos
from woundon.contact.response import Response
from woundon.contact.schemes import SCHEMES
from woundon.contact.stick_slip import Ending
from woundon.contact.width import width_for_load
from woundon.elasticity.cylinder import Sequences, sequences
from woundon.nip.equations import NipEquations, NipMatrices
from woundon.problems.bodies import half_width_guess
from woundon.two_bodies import PairState

__all__ = ["solve_as_published"]

Array = np.ndarray
LOAD_RTOL = 1e-6


def solve_as_published(
    problem: wo.NipProblem, nodes: int = 200, terms: int = 20_000, scheme: str = "thesis-printed"
) -> tuple[float, int]:
    """Return NIT [N/m] and the number of linear systems solved."""
    mesh, solves = SCHEMES[scheme].mesh(nodes), 0

    def evaluate(a: float) -> tuple[tuple[NipEquations, PairState], float]:
        nonlocal solves
        equations = _equations(problem, mesh, a, terms)
        solution = panagiotopoulos(equations.stick_slip())
        solves += solution.solves
        if solution.ending is not Ending.SOLVED:
            raise wo.NotConverged(solution.ending.value)
        state = equations.state(solution._replace(solves=solves))
        return (equations, state), equations.carried(state)

    guess = half_width_guess(problem.nip_load, *problem.bodies)
    (equations, state), _ = width_for_load(evaluate, problem.nip_load, guess, LOAD_RTOL)
    total = state.traction.reshape(2, -1).sum(axis=0)
    return float(equations.matrices.weights @ total), solves


def _equations(problem: wo.NipProblem, mesh: Mesh, a: float, terms: int) -> NipEquations:
    responses = (_response(body, mesh, a, terms) for body in problem.bodies)
    made = NipMatrices.of(problem, mesh, a, *responses)
    return NipEquations(problem, mesh, made)


@lru_cache
def _sequences(body: wo.Cylinder, terms: int) -> Sequences:
    n = np.arange(terms + 1)
    return sequences(n, body.radius, body.core_radius, *body.material.stiffness)


def _response(
    body: wo.Rigid | wo.HalfPlane | wo.Cylinder, mesh: Mesh, a: float, terms: int
) -> Response:
    """Return the body's matrices, by sums over all terms for each difference of two nodes."""
    if not isinstance(body, wo.Cylinder):
        return body.respond(mesh, a)
    M, R = mesh.nodes.size, body.radius
    gamma_1, gamma_2, chi_1, chi_2 = _sequences(body, terms)
    n, delta = np.arange(1, terms + 1), a * float(mesh.grid.cells[0]) / R
    # a hat of base 2 delta R as a Fourier series
    hat = 4 * np.sin(n * delta / 2) ** 2 / (np.pi * n**2 * delta)
    mean = delta / (2 * np.pi)
    angle = np.outer(np.arange(M) * delta, n)
    cos, sin = np.cos(angle), np.sin(angle)
    v_p = _even(-(cos @ (gamma_1[1:] * hat)) - gamma_1[0] * mean)
    u_q = _even(cos @ (chi_2[1:] * hat))
    v_q = _odd(sin @ (gamma_2[1:] * hat))
    u_p = _odd(sin @ (chi_1[1:] * hat))
    dx = delta * R
    cells = (
        np.diff(v_p, axis=0) / dx,
        np.diff(v_q, axis=0) / dx,
        np.diff(u_p, axis=0) / dx + v_p[1:] / R,
        np.diff(u_q, axis=0) / dx + v_q[1:] / R,
    )
    # at the trailing edge what the last cell has
    slope_p, slope_q, strain_p, strain_q = (np.vstack([part, part[-1:]]) for part in cells)
    return Response((slope_p, slope_q, strain_p, strain_q))


def _even(values: Array) -> Array:
    """Spread a function of |x_l - x_m| over all nodes l and interior nodes m, (M, M-2)."""
    M = values.size
    distance = np.arange(M)[:, None] - np.arange(1, M - 1)
    return values[np.abs(distance)]


def _odd(values: Array) -> Array:
    M = values.size
    distance = np.arange(M)[:, None] - np.arange(1, M - 1)
    return np.sign(distance) * values[np.abs(distance)]
