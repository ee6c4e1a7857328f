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
from functools import cached_property
from math import inf, pi
from typing import Any

import numpy as np

from ..contact.response import Response, Tractions
from ..contact.schemes import interpolation_rank
from ..losses import Surface
from ..problems.bodies import Body
from ..problems.nip import WindingNip
from .grid import Influence, OpenGrid, WrapGrid

__all__ = ["Face", "face"]

Array = np.ndarray

ASIDE = 1e-9  # of a cell: where kernels are asked for beside a node


@dataclass(frozen=True, eq=False)
class Face:
    """Matrices of one body on its n nodes and n-1 cells; for a rigid body all are zero.

    Attributes
    ----------
    response : Response or None
        Of the body; None of a rigid one.
    slope_p, slope_q : (n-1, n) arrays
        dv/dx in the cells.
    strain_p, strain_q : (n, n) arrays
        Strain in the cells; the last row is the last node.
    bend : (n,) array
        Curvature of the surface without tractions at the nodes [1/m].
    bend_p, bend_q : (n, n) arrays
        Its change by tractions.
    normal_p, normal_q : (n,) arrays
        v at the nip's trailing edge.
    slope, strain : (n-1,), (n,) arrays
        What a linearised body has at zero tractions.
    sunk : float
        v at the nip's trailing edge then [m].
    """

    response: Response | None
    slope_p: Array
    slope_q: Array
    strain_p: Array
    strain_q: Array
    bend: Array
    bend_p: Array
    bend_q: Array
    normal_p: Array
    normal_q: Array
    slope: Array
    strain: Array
    sunk: float

    def surface(
        self, body: Body, grid: WrapGrid, start: int, a: float, pressure: Array, traction: Array
    ) -> Surface:
        """Return the surface under pressures and tractions on all nodes of the grid."""
        own = slice(start, start + self.bend.size)
        p, q = pressure[own], traction[own]
        cells = slice(start, start + self.bend.size - 1)
        part = (grid.points[cells] - grid.nodes[cells]) / grid.cells[cells]
        slope = self.slope + self.slope_p @ p + self.slope_q @ q
        strain = (self.strain + self.strain_p @ p + self.strain_q @ q)[:-1]
        lengths, k = a * grid.cells[cells], grid.last - start
        v = np.append(0.0, np.cumsum(slope * lengths))
        v += float(self.normal_p @ p + self.normal_q @ q) + self.sunk - v[k]
        v, p, q = (values[:-1] * (1 - part) + values[1:] * part for values in (v, p, q))
        return Surface(slope, strain, v, p, q, lengths, body.curvature)


def face(
    problem: WindingNip, body: Body, grid: WrapGrid, start: int, stop: int, edge: int, a: float,
    about: Tractions | None = None,
) -> Face:  # fmt: skip
    """Return a body's matrices on the nodes start ... stop (inclusive).

    Parameters
    ----------
    problem : WindingNip
    body : Body
        Its roll or drum.
    grid : WrapGrid
    start, stop : int
        First and last node of the face.
    edge : int
        Node where the nip meets the face's arc.
    a : float
        Half width [m].
    about : Tractions, optional
        Loads on all nodes of the grid about which a body that is not linear is linearised.
    """
    n = stop - start + 1
    bend = np.full(n, 1 / body.radius)
    if body.rigid:
        none, zero = np.zeros((n, n)), np.zeros(n)
        return Face(
            None, none[1:], none[1:], none, none, bend, none, none, zero, zero, zero[1:], zero, 0.0
        )  # fmt: skip
    points = FaceGrid(grid, start, stop, edge)
    own = slice(start, stop + 1)
    loads = None if about is None else Tractions(*(part[own] for part in about))
    response = problem.respond(body, points, a, loads)
    slope_p, slope_q, strain_p, strain_q = response.gradients
    last_p, last_q = response.normal()
    v_p = points.deflection(slope_p, last_p, a)
    v_q = points.deflection(slope_q, last_q, a)
    slope, strain = (np.broadcast_to(part, points.points.shape)
                     for part in (response.slope, response.strain))  # fmt: skip
    flatter, sunk = body.curvature**2, 0.0
    if not body.linear:
        v = points.deflection(slope[:, None], response.rest()[0][:, None], a)
        sunk = float(v[points.trailing, 0])
        bend = bend + points.bending(slope[:, None], v, a, flatter)[:, 0]
    rows = np.append(np.arange(n - 1), n)
    return Face(
        response, slope_p[:-2], slope_q[:-2], strain_p[rows], strain_q[rows],
        bend, points.bending(slope_p, v_p, a, flatter), points.bending(slope_q, v_q, a, flatter),
        v_p[points.trailing], v_q[points.trailing], slope[:-2], strain[rows], sunk,
    )  # fmt: skip


class FaceGrid:
    """The nodes of a face, all of them columns, and points: one in each cell, two more.

    The one beside the edge of the arc tells the slope with which the arc begins; the last is the
    end.
    """

    def __init__(self, grid: WrapGrid, start: int, stop: int, edge: int) -> None:
        self.nip = grid.nip
        self.edge, self.trailing = edge - start, grid.last - start
        self.columns = grid.nodes[start : stop + 1]
        self.cells = np.diff(self.columns)
        self.behind = stop > grid.last  # the arc lies behind the nip, not before it
        self.has_arc = self.behind or start < grid.first
        beside = self.columns[self.edge]
        if self.has_arc:
            beside += ASIDE * (self.cells[self.edge] if self.behind else -self.cells[self.edge - 1])
        end = self.columns[-1] - ASIDE * self.cells[-1]
        self.points = np.concatenate([grid.points[start:stop], [beside, end]])
        # points and hats inside the nip keep the plain nip's integrals
        self.rows = np.arange(grid.first - start, self.trailing)
        self.inside = slice(grid.first - start + 1, self.trailing)
        if not self.behind:  # the end is the nip's trailing edge
            self.rows = np.append(self.rows, self.points.size - 1)

    @property
    def nodes(self) -> Array:
        """The columns: an arc may end on a traction."""
        return self.columns

    @cached_property
    def _cell(self) -> Array:
        """The cell of each point, (K,)."""
        k = np.searchsorted(self.columns, self.points) - 1
        return np.clip(k, 0, self.cells.size - 1)

    @cached_property
    def value(self) -> Array:
        """Traction at the points by its nodal values, (K, n)."""
        k, rows = self._cell, np.arange(self.points.size)
        part = (self.points - self.columns[k]) / self.cells[k]
        out = np.zeros((self.points.size, self.columns.size))
        out[rows, k], out[rows, k + 1] = 1 - part, part
        return out

    @cached_property
    def slope(self) -> Array:
        """Its derivative there, per a, (K, n)."""
        k, rows = self._cell, np.arange(self.points.size)
        out = np.zeros((self.points.size, self.columns.size))
        out[rows, k], out[rows, k + 1] = -1 / self.cells[k], 1 / self.cells[k]
        return out

    def integrated(self, kernels: Any, curvature: float, radius: float, a: float) -> Response:
        """Return the response of a linear body by its influence functions."""
        period = 2 * pi * radius if curvature else inf
        put = Influence(
            OpenGrid(self.columns, self.points), self.nip, self.rows, self.inside,
            a, kernels.length, period,
        )  # fmt: skip

        def gradients() -> Any:
            return tuple(put.together(kernels.gradients, kernels.smooth, kernels.lag))

        def last(points: Array | None) -> Any:
            """Integrate at the last node; without an arc as the plain nip does."""
            normal = kernels.normal_p, kernels.normal_q
            if self.has_arc:
                return tuple(put.at_end(normal))
            rank = interpolation_rank(kernels.length, a)
            made = (self.nip.integrate(one, a, slice(-1, None), rank) for one in normal)
            return tuple(np.pad(one, ((0, 0), (1, 1))) for one in made)

        return Response(
            gradients, last, terms=kernels.terms, truncation_error=kernels.truncation_error
        )

    def deflection(self, slope: Array, last: Array, a: float) -> Array:
        """Return v at the nodes: at the last one as given, from there by the slopes."""
        steps = slope[:-2] * (a * self.cells[:, None])
        return np.vstack([last - np.cumsum(steps[::-1], axis=0)[::-1], last])

    def bending(self, slope: Array, v: Array, a: float, flatter: float) -> Array:
        """Return the change of curvature at the nodes; those without two neighbours copy one."""
        y, cells = self.points[:-2], slope[:-2]
        out = np.empty_like(v)
        out[1:-1] = np.diff(cells, axis=0) * (-1 / (a * np.diff(y)[:, None]))
        out[1:-1] -= flatter * v[1:-1]
        e, nodes = self.edge, self.columns
        if self.has_arc:
            # half a cell turns from the edge to the first point of the arc; kappa is linear there
            k, near = (e, e + 1) if self.behind else (e - 1, e - 1)
            half = (cells[k] - slope[-2]) / (a * (nodes[e] - y[k])) - flatter * v[e]
            share = (y[k] - nodes[e]) / (nodes[near] - nodes[e]) / 2
            out[e] = (half - share * out[near]) / (1 - share)
        out[0], out[-1] = out[1], out[-2]
        return out
