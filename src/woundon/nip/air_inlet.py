r"""What air a nip lets through: the inlet of a lubricated contact of elastic bodies.

Near the inlet edge of a dry contact, s from the edge inwards, the pressure is K sqrt(s) inside and
the gap (4/3) C K |s|^(3/2) outside, C half the sum of the bodies' half-plane compliances.  Air that
both surfaces carry in at the speed V keeps them apart (Reynolds, isothermal, p above the ambient
p_a; both surfaces move alike, so that nothing is sheared)

    dp/ds = 12 mu V (h - m/(p_a + p)) / h^3,        m = what passes, (p_a + p) h far inside,
    h = (4/3) C K |s|^(3/2) [s < 0] + h_c - (2 C/pi) int (p - K sqrt(s)) ln|s - t| dt.

Counted in

    l = (12 mu V / (C^2 K^3))^(2/5),   K sqrt(l),   H = C K l^(3/2),   beta = p_a/(K sqrt(l))

only beta is left.  Piecewise linear p - K sqrt(s), collocated at the middle of cells graded like
sinh; a net force of p - K sqrt(s) would only shift the edge, which is at s = 0, and is none.
Newton; for small beta from larger ones.  For beta -> infinity m/(p_a H) is 0.5121: an isoviscous
film of 3.77 (mu V/(E' R))^0.6 (P/(E' R))^-0.2 R in a nip of half-planes, E' = 2/C.

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
CELLS, FAR, FINEST = 200, 400.0, 0.3  # of the mesh, lengths in l; 2e-4 of what passes
LEAST_BETA, MOST_BETA = 0.01, 1e4
PER_DECADE = 6


class Inlet(NamedTuple):
    """A solved inlet, dimensionless."""

    s: Array  # (n + 1,) nodes, from the edge inwards
    pressure: Array  # (n + 1,)
    gap: Array  # (n,) at the middle of the cells
    passed: float  # m/(p_a H)


def passed(beta: float) -> float:
    """Return m/(p_a H), the film at ambient pressure that passes, of 1/H.

    Parameters
    ----------
    beta : float
        Ambient pressure over that of the inlet, >= 0.01.

    Raises
    ------
    ValueError
        Below 0.01: not solved there.
    """
    if not beta >= LEAST_BETA:
        raise ValueError(f"beta = {beta:.4g} is out of range; must be >= {LEAST_BETA:g}")
    # the first-order term of 1/beta is left beyond
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
        That of a similar beta on the same mesh, to start from.
    cells : int
    far : float
        Where the mesh ends on both sides, in l.

    Raises
    ------
    ArithmeticError
        If Newton's iteration does not end.
    """
    s = FINEST * np.sinh(np.arcsinh(far / FINEST) * np.linspace(-1, 1, cells + 1))
    equations = _Equations(s, beta)
    x = np.zeros(cells + 1) if before is None else equations.unknowns(before)
    if before is None:
        x[-2:] = 0.9
    for _ in range(60):
        miss, jacobian = equations(x)
        step = np.linalg.solve(jacobian, -miss)
        share = min(1.0, 0.5 * equations.room(x, step))
        x = x + share * step
        if share == 1.0 and np.max(np.abs(step)) < 1e-10:
            return equations.inlet(x)
    raise ArithmeticError(f"the inlet for beta = {beta:.4g} was not found")


class _Equations:
    """Unknown: p - sqrt(s) at the inner nodes, h_c, and what passes."""

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
        """Return how often a step fits until somewhere the gap closes."""
        gap = self._state(x)[1]
        falls = gap - self._state(x + step)[1]
        return float(np.min(np.where(falls > 0, gap / np.where(falls > 0, falls, 1.0), inf)))

    def __call__(self, x: Array) -> tuple[Array, Array]:
        p, h = self._state(x)
        n, rise = h.size, np.diff(p) / self.width
        density = 1 + (p[1:] + p[:-1]) / (2 * self.beta)
        flow = x[-1] / density
        miss = np.append(rise * h**3 - h + flow, self.force @ (p - self.dry))
        by_gap = 3 * h**2 * rise - 1
        by_p = by_gap[:, None] * self.displaced
        own, squeezed = h**3 / self.width, flow / density / (2 * self.beta)
        cell = np.arange(n)
        by_p[cell, cell] -= own + squeezed
        by_p[cell, cell + 1] += own - squeezed
        jacobian = np.zeros((n + 1, n + 1))
        jacobian[:n, :-2], jacobian[:n, -2], jacobian[:n, -1] = by_p[:, 1:-1], by_gap, 1 / density
        jacobian[n, :-2] = self.force[1:-1]
        return miss, jacobian

    def inlet(self, x: Array) -> Inlet:
        p, h = self._state(x)
        return Inlet(self.s, p, h, float(x[-1]))


def _displaced(nodes: Array, at: Array) -> Array:
    """Return what nodal pressures displace, -(2/pi) int p ln|s - t| dt, (len(at), len(nodes)).

    The second derivative of a hat is three impulses, so its integral is three values of the
    twice-integrated logarithm.  The two ends carry nothing.
    """
    u = at[:, None] - nodes
    twice = u * u * (np.log(np.abs(u)) / 2 - 0.75)
    slopes = 1 / np.diff(nodes)
    matrix = np.zeros(twice.shape)
    inner = twice[:, 1:-1] * (slopes[:-1] + slopes[1:])
    matrix[:, 1:-1] = twice[:, :-2] * slopes[:-1] - inner + twice[:, 2:] * slopes[1:]
    return -2 / np.pi * matrix
