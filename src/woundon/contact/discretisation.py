"""Two ways to put surface responses on a grid: the graded scheme and the thesis's.

Both deliver the same four matrices, so that one assembly serves both.

graded   cosine nodes; slope and strain at the middle of each cell by exact kernel integrals; the
         strain at the trailing edge exact.
thesis   even nodes; slope and strain as backward differences of the nodal displacements (thesis
         eqs. 109, 114); the strain at the trailing edge is that of the last cell, half a cell
         inside, where the pressure goes like the root of the distance: hence its slow convergence.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from math import asinh
from typing import Protocol

import numpy as np

from .grid import Grid, KernelParts, cosine_grid, uniform_grid

__all__ = ["Discretisation", "Response", "discretisation", "interpolation_rank", "on_grid"]

Array = np.ndarray


class Kernels(Protocol):
    """The eight influence functions of a surface (see elasticity.kernels.SurfaceKernels)."""

    @property
    def normal_p(self) -> KernelParts: ...
    @property
    def normal_q(self) -> KernelParts: ...
    @property
    def tangent_p(self) -> KernelParts: ...
    @property
    def tangent_q(self) -> KernelParts: ...
    @property
    def slope_p(self) -> KernelParts: ...
    @property
    def slope_q(self) -> KernelParts: ...
    @property
    def strain_p(self) -> KernelParts: ...
    @property
    def strain_q(self) -> KernelParts: ...
    @property
    def length(self) -> float: ...
    @property
    def gradients(self) -> tuple[KernelParts, KernelParts, KernelParts, KernelParts]: ...
    @property
    def smooth(self) -> Callable[[Array], Array] | None: ...


def interpolation_rank(length: float, a: float, least: int = 24) -> int:
    """Return the interpolation points that resolve kernels varying on ``length`` over [-a, a]."""
    return int(min(max(least, round(20 / asinh(length / a))), 600))


@dataclass(frozen=True, eq=False)
class Response:
    """Slope dv/dx in the N cells, and strain there and at the trailing edge, of n nodal tractions.

    Attributes
    ----------
    slope_p, slope_q : (N, n) arrays
    strain_p, strain_q : (N+1, n) arrays
        The last row is the trailing edge.
    """

    slope_p: Array
    slope_q: Array
    strain_p: Array
    strain_q: Array


@dataclass(frozen=True, eq=False)
class Discretisation:
    """A grid and a scheme; all matrices for unit half width.

    Attributes
    ----------
    grid : Grid
    scheme : {"graded", "thesis", "thesis-printed"}
        ``thesis-printed`` takes the web tension by eq. (121) as printed, ``thesis`` lumps it.
    """

    grid: Grid
    scheme: str

    @property
    def unknowns(self) -> int:
        """Number n of interior nodes."""
        return self.grid.unknowns

    def rank(self, length: float, a: float) -> int:
        """Return ``interpolation_rank`` for this grid.

        The least rank is what the weak kink at t = 0 asks for: 24 leave up to 6e-7 of NIT on random
        nips, 12 leave 4e-6, a hundredth of what the cells of a coarse graded grid leave.
        """
        coarse = self.scheme == "graded" and self.unknowns < 48
        return interpolation_rank(length, a, 12 if coarse else 24)

    @cached_property
    def middle(self) -> Array:
        """Where the slope of the gap is taken, one point a cell, (N,)."""
        x = self.grid.nodes
        return self.grid.points[:-1] if self.scheme == "graded" else (x[1:] + x[:-1]) / 2

    @cached_property
    def value(self) -> Array:
        """Traction in each cell, (N, n)."""
        if self.scheme == "graded":
            return self.grid.value[:-1]
        identity = np.eye(self.unknowns + 2)[:, 1:-1]
        return (identity[1:] + identity[:-1]) / 2

    @cached_property
    def slope(self) -> Array:
        """Derivative of the traction in each cell, (N, n)."""
        identity = np.eye(self.unknowns + 2)[:, 1:-1]
        return np.diff(identity, axis=0) / self.grid.cells[:, None]

    @cached_property
    def upstream(self) -> Array:
        """Integral of the traction from the leading edge to each cell, (N, n)."""
        cells, nodes = np.arange(self.unknowns + 1)[:, None], np.arange(self.unknowns)[None, :]
        if self.scheme == "thesis-printed":
            # eq. (121): 1/6 of the own node's hat, 5/6 of the one before, all of the others
            share = np.select(
                [nodes == cells, nodes == cells - 1, nodes < cells], [1 / 6, 5 / 6, 1]
            )
            return share * self.grid.weights
        return np.where(nodes < cells, self.grid.weights, 0.0)

    @cached_property
    def behind(self) -> Array:
        """Less the integral of the traction from each cell to the trailing edge, (N, n)."""
        return self.upstream - self.grid.weights

    def pressure_slope(self, kernels: Kernels, a: float) -> Array:
        """Return the slope in each cell by nodal pressures alone, (N, n)."""
        rank = self.rank(kernels.length, a)
        if self.scheme == "graded":
            return self.grid.integrate(kernels.slope_p, a, slice(0, -1), rank)
        displacement = self.grid.integrate(kernels.normal_p, a, rank=rank)
        return np.diff(displacement, axis=0) / (a * self.grid.cells[:, None])

    def response(self, kernels: Kernels, curvature: float, a: float) -> Response:
        """Return the response of a body's surface on the grid scaled by the half width a [m].

        Parameters
        ----------
        kernels : Kernels
        curvature : float
            1/R of a cylinder, whose strain has the term v/R; 0 for a half-plane [1/m].
        a : float
            Half width [m].
        """
        rank = self.rank(kernels.length, a)
        if self.scheme == "graded":
            slope_p, slope_q, strain_p, strain_q = self.grid.integrate_together(
                kernels.gradients, kernels.smooth, a, rank
            )
            return Response(slope_p[:-1], slope_q[:-1], strain_p, strain_q)
        put = partial(self.grid.integrate, rank=rank)
        dx = a * self.grid.cells[:, None]
        v_p, v_q = put(kernels.normal_p, a), put(kernels.normal_q, a)
        u_p, u_q = put(kernels.tangent_p, a), put(kernels.tangent_q, a)
        strain_p = np.diff(u_p, axis=0) / dx + curvature * v_p[1:]
        strain_q = np.diff(u_q, axis=0) / dx + curvature * v_q[1:]
        return Response(
            np.diff(v_p, axis=0) / dx,
            np.diff(v_q, axis=0) / dx,
            np.vstack([strain_p, strain_p[-1:]]),
            np.vstack([strain_q, strain_q[-1:]]),
        )


@lru_cache(maxsize=64)
def discretisation(scheme: str, nodes: int) -> Discretisation:
    """Return the discretisation of a scheme on its own grid; made once, used for all cases."""
    grid = cosine_grid(nodes) if scheme == "graded" else uniform_grid(nodes)
    return Discretisation(grid, scheme)


def on_grid(grid: Grid) -> Discretisation:
    """Return the graded scheme on any grid."""
    return Discretisation(grid, "graded")
