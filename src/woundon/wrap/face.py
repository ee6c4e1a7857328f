"""What a body's surface does along its arc: slopes, strains and the curvature under tractions.

The surface of a body of radius R with outward displacement v has, to first order, the curvature

    kappa = 1/R - v'' - v/R^2,

the polar curvature (r^2 + 2 r'^2 - r r'')/(r^2 + r'^2)^(3/2) of r = R + v with s = R theta
(thesis eq. 154, whose last term is misprinted: an evenly inflated circle must get flatter, and a
translation, v = cos theta, must change nothing).  On the grid kappa is the turn of the surface
between neighbouring collocation points over their distance, so that the web's normal balance holds
for every stretch of web, however coarse the cells.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, pi

import numpy as np

from ..bodies import Body
from ..contact.discretisation import interpolation_rank
from ..contact.grid import Grid
from ..elasticity.kernels import Kernel, SurfaceKernels
from .grid import Influence, OpenGrid, WrapGrid

__all__ = ["Face", "face"]

Array = np.ndarray

ASIDE = 1e-9  # of a cell: where kernels are asked for beside a node


@dataclass(frozen=True, eq=False)
class Face:
    """Matrices of one body on its n nodes and n-1 cells; for a rigid body all are zero.

    Attributes
    ----------
    start : int
        The face's first node in the row of all nodes.
    slope_p, slope_q : (n-1, n) arrays
        dv/dx in the cells.
    strain_p, strain_q : (n, n) arrays
        Strain in the cells; the last row is the last node.
    bend : (n,) array
        Curvature of the undeformed surface at the nodes [1/m].
    bend_p, bend_q : (n, n) arrays
        Its change by tractions.
    normal_p, normal_q : (n,) arrays
        v at the nip's trailing edge.
    """

    start: int
    slope_p: Array
    slope_q: Array
    strain_p: Array
    strain_q: Array
    bend: Array
    bend_p: Array
    bend_q: Array
    normal_p: Array
    normal_q: Array


def face(body: Body, grid: WrapGrid, start: int, stop: int, edge: int, a: float) -> Face:
    """Return a body's matrices on the nodes start ... stop (inclusive).

    Parameters
    ----------
    body : Body
    grid : WrapGrid
    start, stop : int
        First and last node of the face.
    edge : int
        Node where the nip meets the face's arc.
    a : float
        Half width [m].
    """
    n = stop - start + 1
    bend = np.full(n, 1 / body.radius)
    kernels = body.surface(pi * body.radius)
    if not kernels.deforms:
        none = np.zeros((n, n))
        return Face(start, none[1:], none[1:], none, none, bend, none, none, none[0], none[0])
    return _Assembly(body, kernels, grid, start, stop, edge, a).face(start, bend)


class _Assembly:
    """Integrates the kernels of one face."""

    def __init__(
        self, body: Body, kernels: SurfaceKernels, grid: WrapGrid,
        start: int, stop: int, edge: int, a: float,
    ) -> None:  # fmt: skip
        self.body, self.kernels, self.a, self.nip = body, kernels, a, grid.nip
        self.edge, self.trailing = edge - start, grid.last - start
        self.nodes = grid.nodes[start : stop + 1]
        self.cells = np.diff(self.nodes)
        self.behind = stop > grid.last  # the arc lies behind the nip, not before it
        self.has_arc = self.behind or start < grid.first
        beside = self.nodes[self.edge]
        if self.has_arc:
            beside += ASIDE * (self.cells[self.edge] if self.behind else -self.cells[self.edge - 1])
        self.end = self.nodes[-1] - ASIDE * self.cells[-1]
        self.points = np.concatenate([grid.points[start:stop], [beside, self.end]])
        self.period = 2 * pi * body.radius if body.curvature else inf
        rows = np.arange(grid.first - start, self.trailing)
        columns = slice(grid.first - start + 1, self.trailing)
        if not self.behind:  # the end is the nip's trailing edge
            rows = np.append(rows, self.points.size - 1)
        self.put = self.influence(self.points, grid.nip, rows, columns)

    def influence(self, points: Array, nip: Grid | None, rows: Array, columns: slice) -> Influence:
        """Return what integrates kernels at the points."""
        grid = OpenGrid(self.nodes, points)
        return Influence(grid, nip, rows, columns, self.a, self.kernels.length, self.period)

    def face(self, start: int, bend: Array) -> Face:
        """Return the matrices; the last two points are the edge of the arc and the end."""
        k = self.kernels
        slope_p, slope_q = self.put(k.slope_p), self.put(k.slope_q)
        strain_p, strain_q = self.put(k.strain_p), self.put(k.strain_q)
        v_p = self.deflection(slope_p, self.last(k.normal_p))
        v_q = self.deflection(slope_q, self.last(k.normal_q))
        rows = np.append(np.arange(self.cells.size), self.cells.size + 1)
        return Face(
            start, slope_p[:-2], slope_q[:-2], strain_p[rows], strain_q[rows],
            bend, self.bending(slope_p, v_p), self.bending(slope_q, v_q),
            v_p[self.trailing], v_q[self.trailing],
        )  # fmt: skip

    def last(self, kernel: Kernel) -> Array:
        """Integrate a kernel at the last node, (1, n); without an arc as the plain nip does."""
        if self.has_arc:
            return self.influence(self.points[-1:], None, np.arange(0), slice(0))(kernel)
        rank = interpolation_rank(self.kernels.length, self.a)
        return np.pad(self.nip.integrate(kernel, self.a, slice(-1, None), rank), ((0, 0), (1, 1)))

    def deflection(self, slope: Array, last: Array) -> Array:
        """Return v at the nodes: at the last one by its kernel, from there by the slopes."""
        steps = slope[:-2] * (self.a * self.cells[:, None])
        return np.vstack([last - np.cumsum(steps[::-1], axis=0)[::-1], last])

    def bending(self, slope: Array, v: Array) -> Array:
        """Return the change of curvature at the nodes; those without two neighbours copy one."""
        y, cells, flatter = self.points[:-2], slope[:-2], self.body.curvature**2
        out = np.empty_like(v)
        out[1:-1] = np.diff(cells, axis=0) * (-1 / (self.a * np.diff(y)[:, None]))
        out[1:-1] -= flatter * v[1:-1]
        e, nodes = self.edge, self.nodes
        if self.has_arc:
            # half a cell turns from the edge to the first point of the arc; kappa is linear there
            k, near = (e, e + 1) if self.behind else (e - 1, e - 1)
            half = (cells[k] - slope[-2]) / (self.a * (nodes[e] - y[k])) - flatter * v[e]
            share = (y[k] - nodes[e]) / (nodes[near] - nodes[e]) / 2
            out[e] = (half - share * out[near]) / (1 - share)
        out[0], out[-1] = out[1], out[-2]
        return out
