r"""Air film through a nip: the inlet of a lubricated contact of elastic bodies.

Let s be the distance from the inlet edge of a dry contact, positive inside.  Near the edge the
pressure is K sqrt(s) inside and the gap (4/3) C K |s|^(3/2) outside, with C half the sum of the
half-plane compliances of the bodies.  The air entrained by both surfaces at the speed V separates
them.  With the pressure p relative to the ambient pressure p_a, the isothermal Reynolds equation
and the elastic deformation give

    dp/ds = 12 mu V (h - m/(p_a + p)) / h^3,        m = mass flow, (p_a + p) h far inside,
    h(s) = (4/3) C K |s|^(3/2) [s < 0] + h_c - (2 C/pi) int (p(t) - K sqrt(t)) ln|s - t| dt.

In units of

    l = (12 mu V / (C^2 K^3))^(2/5),   K sqrt(l),   H = C K l^(3/2),   beta = p_a/(K sqrt(l))

beta is the only parameter, and the equations become, with d = p - sqrt(s) for s > 0 and d = p
otherwise, flow f = m/(p_a H) and density rho = 1 + p/beta,

    h^3 dp/ds - h + f/rho = 0,      h = (4/3) |s|^(3/2) [s < 0] + h_c - (2/pi) int d ln|s - t| dt,
    int d ds = 0        (a resultant would shift the edge).

d is piecewise linear, and the first equation is collocated at the middle of cells graded by sinh.
Newton's method starts from the solution for a larger beta (continuation).  For beta -> infinity f
is 0.5121: an isoviscous film of 3.77 (mu V/(E' R))^0.6 (P/(E' R))^-0.2 R in a nip of half-planes,
E' = 2/C.

Derived for woundon.  The powers are those of isoviscous-elastic line contacts (Herrebrugh 1968).
"""

from __future__ import annotations

from functools import cache
from math import exp, inf, log
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

__all__ = ["Inlet", "film_factor", "solve_inlet"]

Array = np.ndarray
# Number of cells, extent of the mesh and length scale of its grading [l]: error 2e-4 of the film.
CELLS, EXTENT, GRADING = 200, 400.0, 0.3
MIN_BETA, MAX_BETA = 0.01, 1e4
PER_DECADE = 6  # solutions of the table of the film over beta


class Inlet(NamedTuple):
    """The solution of the inlet, dimensionless.

    Attributes
    ----------
    s : (n + 1,) array
        Nodes, positive inside the contact.
    pressure : (n + 1,) array
    gap : (n,) array
        At the middle of the cells.
    film : float
        f = m/(p_a H), the film at ambient pressure.
    """

    s: Array
    pressure: Array
    gap: Array
    film: float


def film_factor(beta: float) -> float:
    """Return f = m/(p_a H), the film at ambient pressure in units of H.

    Parameters
    ----------
    beta : float
        Ambient pressure relative to the pressure of the inlet, >= 0.01.

    Raises
    ------
    ValueError
        For smaller values, for which the equations are not solved.
    """
    if not beta >= MIN_BETA:
        raise ValueError(f"beta = {beta:.4g} is out of range; must be >= {MIN_BETA:g}")
    # for larger beta, f differs from its limit by less than 1/beta
    return float(exp(_film_spline()(log(min(beta, MAX_BETA)))))


@cache
def _film_spline() -> CubicSpline:
    """Return ln f as a cubic spline of ln beta, by continuation from the largest beta."""
    from scipy.interpolate import CubicSpline

    count = round(np.log10(MAX_BETA / MIN_BETA) * PER_DECADE)
    betas = np.geomspace(MAX_BETA, MIN_BETA, count + 1)
    solution, films = None, []
    for beta in betas:
        solution = solve_inlet(float(beta), solution)
        films.append(solution.film)
    return CubicSpline(np.log(betas[::-1]), np.log(films[::-1]))


def solve_inlet(
    beta: float = inf, start: Inlet | None = None, cells: int = CELLS, extent: float = EXTENT
) -> Inlet:
    """Solve the inlet for one beta.

    Parameters
    ----------
    beta : float
        Ambient pressure relative to the pressure of the inlet; inf for an incompressible film.
    start : Inlet, optional
        Initial guess: the solution for a similar beta on the same mesh.
    cells : int
    extent : float
        Extent of the mesh on both sides, in units of l.

    Raises
    ------
    ArithmeticError
        If Newton's method does not converge.
    """
    # even cells in arcsinh(s/GRADING), short at the edge s = 0
    s = GRADING * np.sinh(np.arcsinh(extent / GRADING) * np.linspace(-1, 1, cells + 1))
    equations = _InletEquations(s, beta)
    x = np.zeros(cells + 1) if start is None else equations.unknowns_of(start)
    if start is None:
        x[-2:] = 0.9  # h_c and f: their order of magnitude
    for _ in range(60):
        residual, jacobian = equations.residual_and_jacobian(x)
        step = np.linalg.solve(jacobian, -residual)
        damping = min(1.0, 0.5 * equations.step_to_closure(x, step))  # keeps the gap open
        x = x + damping * step
        if damping == 1.0 and np.max(np.abs(step)) < 1e-10:
            return Inlet(s, *equations.pressure_and_gap(x), float(x[-1]))
    raise ArithmeticError(f"Newton's method for the inlet with beta = {beta:.4g} did not converge")


class _InletEquations:
    """Residual and Jacobian of the inlet on a mesh of n cells with the nodes s, dimensionless.

    The unknowns are x = (d at the n - 1 inner nodes, h_c, film f), (n + 1,).
    """

    def __init__(self, s: Array, beta: float) -> None:
        self.beta = beta
        middle, self.cell_lengths = (s[1:] + s[:-1]) / 2, np.diff(s)
        self.dry_pressure = np.sqrt(np.clip(s, 0, None))
        self.dry_gap = 4 / 3 * np.clip(-middle, 0, None) ** 1.5
        self.deformation = _deformation_matrix(s, middle)
        padded = np.concatenate([[0.0], self.cell_lengths, [0.0]])
        self.weights = (padded[1:] + padded[:-1]) / 2

    def unknowns_of(self, solution: Inlet) -> Array:
        """Return the unknowns x, (n + 1,), of a solution on the same mesh."""
        d = solution.pressure - self.dry_pressure
        h_c = float(np.mean(solution.gap - self.dry_gap - self.deformation @ d))
        return np.concatenate([d[1:-1], [h_c, solution.film]])

    def pressure_and_gap(self, x: Array) -> tuple[Array, Array]:
        """Return p at the nodes and h at the middle of the cells."""
        d = np.concatenate([[0.0], x[:-2], [0.0]])
        return self.dry_pressure + d, self.dry_gap + x[-2] + self.deformation @ d

    def step_to_closure(self, x: Array, step: Array) -> float:
        """Return the multiple of a Newton step at which the gap closes somewhere; inf if never.

        ``x`` and ``step`` are (n + 1,).  The gap is a linear function of the unknowns.
        """
        gap = self.pressure_and_gap(x)[1]
        decrease = gap - self.pressure_and_gap(x + step)[1]
        is_closing = decrease > 0
        return float(np.min(np.where(is_closing, gap / np.where(is_closing, decrease, 1.0), inf)))

    def residual_and_jacobian(self, x: Array) -> tuple[Array, Array]:
        """Return the residual R, (n + 1,), and the Jacobian dR/dx, (n + 1, n + 1).

        R contains h^3 dp/ds - h + f/rho in the cells, then int d ds.  p and rho of a cell depend on
        the pressures of its two nodes, h on all.
        """
        p, h = self.pressure_and_gap(x)
        n, slope = h.size, np.diff(p) / self.cell_lengths
        rho = 1 + (p[1:] + p[:-1]) / (2 * self.beta)
        flow = x[-1] / rho
        residual = np.append(h**3 * slope - h + flow, self.weights @ (p - self.dry_pressure))
        dR_dh = 3 * h**2 * slope - 1
        dR_dp = dR_dh[:, None] * self.deformation
        slope_term, density_term = h**3 / self.cell_lengths, flow / rho / (2 * self.beta)
        cell = np.arange(n)
        dR_dp[cell, cell] -= slope_term + density_term
        dR_dp[cell, cell + 1] += slope_term - density_term
        jacobian = np.zeros((n + 1, n + 1))
        jacobian[:n, :-2], jacobian[:n, -2], jacobian[:n, -1] = dR_dp[:, 1:-1], dR_dh, 1 / rho
        jacobian[n, :-2] = self.weights[1:-1]
        return residual, jacobian


def _deformation_matrix(nodes: Array, points: Array) -> Array:
    """Return the matrix of -(2/pi) int d(t) ln|s - t| dt, (points s, nodes of d).

    The integral over a hat function is the second difference of the second integral of ln|u|.
    The values at both ends are zero.
    """
    u = points[:, None] - nodes
    second_integral = u * u * (np.log(np.abs(u)) / 2 - 0.75)
    matrix = np.zeros(u.shape)
    matrix[:, 1:-1] = np.diff(np.diff(second_integral, axis=1) / np.diff(nodes), axis=1)
    return -2 / np.pi * matrix
