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
from typing import Any, NamedTuple

import numpy as np

from ..contact.meshes import interpolation_rank
from ..contact.response import Response, Tractions
from ..losses import Surface
from ..problems.bodies import Body
from ..problems.nip import WindingNip
from .action import FaceAction
from .grid import WrapGrid
from .influence import Influence, Within
from .integrals import OpenGrid

__all__ = ["Face", "FaceLaws", "Loaded"]

Array = np.ndarray

ASIDE = 1e-9  # of a cell: where kernels are asked for beside a node


class Loaded(NamedTuple):
    """A body's surface under given tractions; of a rigid body as it was.

    Attributes
    ----------
    slope : (n-1,) array
        dv/dx in the cells.
    strain : (n,) array
        In the cells, then at the last node.
    bend : (n,) array
        Curvature at the nodes [1/m].
    """

    slope: Array
    strain: Array
    bend: Array


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
    slope, strain : (n-1,), (n,) arrays
        What a linearised body has at zero tractions.
    """

    response: Response | None
    slope_p: Array
    slope_q: Array
    strain_p: Array
    strain_q: Array
    bend: Array
    bend_p: Array
    bend_q: Array
    slope: Array
    strain: Array

    def under(self, p: Array, q: Array) -> tuple[Array, Array, Array]:
        """Return slope, strain and curvature under pressures and tractions on the nodes."""
        return (
            self.slope + self.slope_p @ p + self.slope_q @ q,
            self.strain + self.strain_p @ p + self.strain_q @ q,
            self.bend + self.bend_p @ p + self.bend_q @ q,
        )


@dataclass(frozen=True, eq=False)
class FaceLaws:
    """What a body answers on the nodes start ... stop (inclusive) of a grid.

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
    half_width : float
        a [m].
    about : Tractions, optional
        Loads on all nodes of the grid about which a body that is not linear is linearised.
    """

    problem: WindingNip
    body: Body
    grid: WrapGrid
    start: int
    stop: int
    edge: int
    half_width: float
    about: Tractions | None = None

    @cached_property
    def points(self) -> FaceGrid:
        """The nodes and points of the face."""
        return FaceGrid(self.grid, self.start, self.stop, self.edge)

    @cached_property
    def response(self) -> Response | None:
        """That of the body; None of a rigid one."""
        if self.body.rigid:
            return None
        own = slice(self.start, self.stop + 1)
        loads = None if self.about is None else Tractions(*(part[own] for part in self.about))
        return self.problem.respond(self.body, self.points, self.half_width, loads)

    @property
    def acts(self) -> bool:
        """Whether it answers without matrices."""
        return self.response is None or self.response.acts

    @cached_property
    def _end(self) -> tuple[Array, Array]:
        """v at the last point, by pressures and by tractions, (1, n) each."""
        assert self.response is not None
        return self.response.normal()

    @cached_property
    def _round(self) -> Array:
        """Curvature of the body as it was, (n,)."""
        return np.full(self.stop - self.start + 1, 1 / self.body.radius)

    def under(self, pressure: Array, traction: Array) -> Loaded:
        """Return the surface under pressures and tractions on all nodes of the grid."""
        if self.response is None:
            none = np.zeros(self._round.size)
            return Loaded(none[1:], none, self._round)
        own = slice(self.start, self.stop + 1)
        p, q = pressure[own], traction[own]
        by_p, by_q = self._end
        last = by_p @ p + by_q @ q + self.response.rest()[0]
        made = vars(self).get("matrices")
        return Loaded(*(self._acted(p, q, last) if made is None else made.under(p, q)))

    def sunk(self, pressure: Array, traction: Array) -> float:
        """Return v at the nip's trailing edge [m], under loads as ``under`` takes them.

        By the influence functions: :meth:`summed` is of first order in the cells.
        """
        if self.response is None:
            return 0.0
        own, points = slice(self.start, self.stop + 1), self.points
        edge = points.points[-2:-1] if points.behind else None
        by_p, by_q = self._end if edge is None else self.response.normal(edge)
        return float((by_p @ pressure[own] + by_q @ traction[own] + self.response.rest(edge)[0])[0])

    def summed(self, pressure: Array, traction: Array) -> float:
        """Return the same as 0.1 had it [m], by slopes summed from the end of an arc.

        There hoop pressure ends, and the slope has a logarithm.
        """
        if self.response is None:
            return 0.0
        own, behind = slice(self.start, self.stop + 1), slice(self.points.trailing, None)
        (by_p, by_q), rest = self._end, self.response.rest()[0]
        last = float((by_p @ pressure[own] + by_q @ traction[own] + rest)[0])
        slope = self.under(pressure, traction).slope
        return last - float(self.half_width * self.points.cells[behind] @ slope[behind])

    def _acted(self, p: Array, q: Array, last: Array) -> tuple[Array, Array, Array]:
        """Return slope, strain and curvature, no matrices made."""
        points, response, a = self.points, self.response, self.half_width
        assert response is not None
        slope, strain = response.act(p, q)
        slope, strain = slope + response.slope, strain + response.strain
        bend = points.bending(slope[:, None], last[:, None], a, self.body.curvature**2)[:, 0]
        return slope[:-2], np.append(strain[:-2], strain[-1]), self._round + bend

    def surface(self, pressure: Array, traction: Array) -> Surface:
        """Return the same as the losses take it."""
        grid, start = self.grid, self.start
        own, cells = slice(start, self.stop + 1), slice(start, self.stop)
        part = (grid.points[cells] - grid.nodes[cells]) / grid.cells[cells]
        loaded = self.under(pressure, traction)
        lengths, k = self.half_width * grid.cells[cells], grid.last - start
        v = np.append(0.0, np.cumsum(loaded.slope * lengths))
        v += self.sunk(pressure, traction) - v[k]
        v, p, q = (
            values[:-1] * (1 - part) + values[1:] * part
            for values in (v, pressure[own], traction[own])
        )
        return Surface(loaded.slope, loaded.strain[:-1], v, p, q, lengths, self.body.curvature)

    @cached_property
    def matrices(self) -> Face:
        """The matrices."""
        n, bend = self._round.size, self._round
        if self.response is None:
            none, zero = np.zeros((n, n)), np.zeros(n)
            return Face(
                None, none[1:], none[1:], none, none, bend, none, none, zero[1:], zero
            )  # fmt: skip
        points, response, a = self.points, self.response, self.half_width
        slope_p, slope_q, strain_p, strain_q = response.gradients
        last_p, last_q = self._end
        slope, strain = (np.broadcast_to(part, points.points.shape)
                         for part in (response.slope, response.strain))  # fmt: skip
        flatter = self.body.curvature**2
        if not self.body.linear:
            last = response.rest()[0][:, None]
            bend = bend + points.bending(slope[:, None], last, a, flatter)[:, 0]
        rows = np.append(np.arange(n - 1), n)
        return Face(
            response, slope_p[:-2], slope_q[:-2], strain_p[rows], strain_q[rows],
            bend, points.bending(slope_p, last_p, a, flatter),
            points.bending(slope_q, last_q, a, flatter), slope[:-2], strain[rows],
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
        nip, beside, end = np.arange(grid.first - start, self.trailing), 1.0, 1.0
        if self.has_arc:
            beside = self.columns[self.edge]
            beside += ASIDE * (self.cells[self.edge] if self.behind else -self.cells[self.edge - 1])
        if self.behind:
            end = self.columns[-1] - ASIDE * self.cells[-1]
        else:  # the end is the nip's trailing edge, and so is what no arc begins at
            nip = np.append(nip, -1 if self.has_arc else [-2, -1])
        self.points = np.concatenate([grid.points[start:stop], [beside, end]])
        # points and hats inside the nip keep the plain nip's integrals
        ends = max(grid.kept[0] - start, 0), min(grid.kept[1], stop) - start
        moving = [*range(ends[0]), *range(ends[1], stop - start)]
        if self.behind:  # with the end the point beside the edge, so that those that stay are a run
            moving += [self.points.size - 2, self.points.size - 1]
        self.within = Within(
            grid.nip, grid.first - start, nip % self.points.size,
            slice(ends[0], ends[1] + 1), np.array(moving, dtype=int),
        )  # fmt: skip

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
        around = 2 * pi * radius if curvature else inf, kernels.reach
        grid = OpenGrid(self.columns, self.points)
        put = Influence(grid, self.within, a, kernels.length, *around)
        acts = put.within is not None and kernels.lag is None

        def gradients() -> Any:
            return tuple(put.together(kernels.gradients, kernels.smooth, kernels.lag))

        def last(points: Array | None) -> Any:
            """Integrate at the last node, by what is at hand of it; elsewhere anew.

            The grid's own points along an arc are at hand too; without an arc it is the plain nip's
            trailing edge.
            """
            normal = kernels.normal_p, kernels.normal_q
            known = self.points[-1:] if points is None else points
            if (
                self.has_arc
                and known.size == 1
                and (at := (self.points == known).nonzero()[0]).size
            ):
                return tuple(put.at(int(at[-1]), normal, kernels.normal_smooth))
            if points is not None:
                there = Influence(OpenGrid(self.columns, points), None, a, kernels.length, *around)
                return tuple(there(one) for one in normal)
            rank = interpolation_rank(kernels.length, a)
            made = (self.nip.integrate(one, a, slice(-1, None), rank) for one in normal)
            return tuple(np.pad(one, ((0, 0), (1, 1))) for one in made)

        return Response(
            gradients, last, act=(lambda: FaceAction(put, kernels)) if acts else None,
            terms=kernels.terms, truncation_error=kernels.truncation_error,
        )  # fmt: skip

    def bending(self, slope: Array, last: Array, a: float, flatter: float) -> Array:
        """Return the change of curvature at the nodes; those without two neighbours copy one.

        By slopes, and by v at the last node, from where they tell it at the others.  Of a roll it
        is nil inside the nip, where the web bends with the drum.
        """
        out, f = np.zeros((self.columns.size, slope.shape[1])), self._first_bent
        y, cells, bend, e, nodes = self.points[f:-2], slope[f:-2], out[f:], self.edge, self.columns
        steps = cells * (a * self.cells[f:, None])
        v = np.concatenate([last - np.cumsum(steps[::-1], axis=0)[::-1], last])
        np.multiply(cells[1:] - cells[:-1], -1 / (a * (y[1:] - y[:-1])[:, None]), out=bend[1:-1])
        bend[1:-1] -= flatter * v[1:-1]
        if self.has_arc:
            # half a cell turns from the edge to the first point of the arc; kappa is linear there
            k, near = (e, e + 1) if self.behind else (e - 1, e - 1)
            half = (slope[k] - slope[-2]) / (a * (nodes[e] - self.points[k])) - flatter * v[e - f]
            share = (self.points[k] - nodes[e]) / (nodes[near] - nodes[e]) / 2
            out[e] = (half - share * out[near]) / (1 - share)
        if f == 0:
            out[0] = out[1]
        out[-1] = out[-2]
        return out

    @property
    def _first_bent(self) -> int:
        """The first node that tells a curvature that is asked for."""
        if self.edge != self.trailing:  # a drum's
            return 0
        return self.edge if self.behind else max(self.columns.size - 3, 0)
