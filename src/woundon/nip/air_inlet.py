r"""Air film through a nip: the inlet of a lubricated contact of elastic bodies.

Near the inlet edge of a dry contact, s from the edge inwards, the pressure is K sqrt(s) inside and
the gap (4/3) C K |s|^(3/2) outside, C half the sum of the bodies' half-plane compliances.  Air that
both surfaces entrain at the speed V separates them (Reynolds equation, isothermal, p relative to
the ambient pressure p_a; both surfaces have the same speed, so that the air is not sheared)

    dp/ds = 12 mu V (h - m/(p_a + p)) / h^3,        m = mass flow, (p_a + p) h far inside,
    h = (4/3) C K |s|^(3/2) [s < 0] + h_c - (2 C/pi) int (p - K sqrt(s)) ln|s - t| dt.

In units of

    l = (12 mu V / (C^2 K^3))^(2/5),   K sqrt(l),   H = C K l^(3/2),   beta = p_a/(K sqrt(l))

beta is the only parameter.  p - K sqrt(s) is piecewise linear, and the equations are collocated at
the middle of cells graded by sinh.  A resultant of p - K sqrt(s) would shift the edge, so that it
is prescribed to be zero.  Newton's method starts from the solution for a larger beta.  For
beta -> infinity m/(p_a H) is 0.5121: an isoviscous film of
3.77 (mu V/(E' R))^0.6 (P/(E' R))^-0.2 R in a nip of half-planes, E' = 2/C.

Derived for woundon.  The powers are those of isoviscous-elastic line contacts (Herrebrugh 1968).
"""

from __future__ import annotations

from functools import cache
from math import exp, inf, log
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

__all__ = ["Inlet", "inlet", "passed"]

Array = np.ndarray
CELLS, FAR, FINEST = 200, 400.0, 0.3  # of the mesh, lengths in l; error 2e-4 of the film
LEAST_BETA, MOST_BETA = 0.01, 1e4
PER_DECADE = 6


class Inlet(NamedTuple):
    """A solved inlet, dimensionless."""

    s: Array  # (n + 1,) nodes, from the edge inwards
    pressure: Array  # (n + 1,)
    gap: Array  # (n,) at the middle of the cells
    passed: float  # film m/(p_a H)


def passed(beta: float) -> float:
    """Return m/(p_a H), the film at ambient pressure in units of H.

    Parameters
    ----------
    beta : float
        Ambient pressure over that of the inlet, >= 0.01.

    Raises
    ------
    ValueError
        For smaller values, for which the equations are not solved.
    """
    if not beta >= LEAST_BETA:
        raise ValueError(f"beta = {beta:.4g} is out of range; must be >= {LEAST_BETA:g}")
    # beyond, m/(p_a H) differs from the limit by less than 1/beta
    return float(exp(_table()(log(min(beta, MOST_BETA)))))


@cache
def _table() -> CubicSpline:
    from scipy.interpolate import CubicSpline

    count = round(np.log10(MOST_BETA / LEAST_BETA) * PER_DECADE)
    betas = np.geomspace(MOST_BETA, LEAST_BETA, count + 1)
    before, found = None, []
    for beta in betas:
        before = inlet(float(beta), before)
        found.append(before.passed)
    return CubicSpline(np.log(betas[::-1]), np.log(found[::-1]))


def inlet(
    beta: float = inf, before: Inlet | None = None, cells: int = CELLS, far: float = FAR
) -> Inlet:
    """Solve the inlet for one beta.

    Parameters
    ----------
    beta : float
        Ambient pressure over that of the inlet; inf for a film that does not compress.
    before : Inlet, optional
        Solution for a similar beta on the same mesh, the initial guess.
    cells : int
    far : float
        Extent of the mesh on both sides, in units of l.

    Raises
    ------
    ArithmeticError
        If Newton's method does not converge.
    """
    s = FINEST * np.sinh(np.arcsinh(far / FINEST) * np.linspace(-1, 1, cells + 1))
    equations = _Equations(s, beta)
    x = np.zeros(cells + 1) if before is None else equations.unknowns(before)
    if before is None:
        x[-2:] = 0.9
    for _ in range(60):
        residual, jacobian = equations(x)
        step = np.linalg.solve(jacobian, -residual)
        share = min(1.0, 0.5 * equations.room(x, step))
        x = x + share * step
        if share == 1.0 and np.max(np.abs(step)) < 1e-10:
            return equations.inlet(x)
    raise ArithmeticError(f"the inlet for beta = {beta:.4g} was not found")


class _Equations:
    """Equations of the inlet; the unknowns are p - sqrt(s) at the inner nodes, h_c and the film."""

    def __init__(self, s: Array, beta: float) -> None:
        self.s, self.beta = s, beta
        self.middle, self.width = (s[1:] + s[:-1]) / 2, np.diff(s)
        self.dry = np.sqrt(np.clip(s, 0, None))
        self.dry_gap = 4 / 3 * np.clip(-self.middle, 0, None) ** 1.5
        self.displaced = _displaced(s, self.middle)
        ends = np.concatenate([[0.0], self.width, [0.0]])
        self.force = (ends[1:] + ends[:-1]) / 2

    def unknowns(self, before: Inlet) -> Array:
        more = before.pressure - self.dry
        gap = self.dry_gap + self.displaced @ more
        return np.concatenate([more[1:-1], [float(np.mean(before.gap - gap)), before.passed]])

    def _state(self, x: Array) -> tuple[Array, Array]:
        more = np.concatenate([[0.0], x[:-2], [0.0]])
        return self.dry + more, self.dry_gap + x[-2] + self.displaced @ more

    def room(self, x: Array, step: Array) -> float:
        """Return the multiple of a step at which the gap closes at some point."""
        gap = self._state(x)[1]
        falls = gap - self._state(x + step)[1]
        return float(np.min(np.where(falls > 0, gap / np.where(falls > 0, falls, 1.0), inf)))

    def __call__(self, x: Array) -> tuple[Array, Array]:
        p, h = self._state(x)
        n, rise = h.size, np.diff(p) / self.width
        density = 1 + (p[1:] + p[:-1]) / (2 * self.beta)
        flow = x[-1] / density
        residual = np.append(rise * h**3 - h + flow, self.force @ (p - self.dry))
        by_gap = 3 * h**2 * rise - 1
        by_p = by_gap[:, None] * self.displaced
        own, squeezed = h**3 / self.width, flow / density / (2 * self.beta)
        cell = np.arange(n)
        by_p[cell, cell] -= own + squeezed
        by_p[cell, cell + 1] += own - squeezed
        jacobian = np.zeros((n + 1, n + 1))
        jacobian[:n, :-2], jacobian[:n, -2], jacobian[:n, -1] = by_p[:, 1:-1], by_gap, 1 / density
        jacobian[n, :-2] = self.force[1:-1]
        return residual, jacobian

    def inlet(self, x: Array) -> Inlet:
        p, h = self._state(x)
        return Inlet(self.s, p, h, float(x[-1]))


def _displaced(nodes: Array, at: Array) -> Array:
    """Return the matrix of -(2/pi) int p ln|s - t| dt for nodal pressures, (len(at), len(nodes)).

    The second derivative of a hat is three impulses, so its integral is three values of the
    twice-integrated logarithm.  The pressure is zero at both ends.
    """
    u = at[:, None] - nodes
    twice = u * u * (np.log(np.abs(u)) / 2 - 0.75)
    slopes = 1 / np.diff(nodes)
    matrix = np.zeros(twice.shape)
    inner = twice[:, 1:-1] * (slopes[:-1] + slopes[1:])
    matrix[:, 1:-1] = twice[:, :-2] * slopes[:-1] - inner + twice[:, 2:] * slopes[1:]
    return -2 / np.pi * matrix
