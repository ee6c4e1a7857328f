r"""Kernels of a surface integrated against the tractions of a nip and of the arc beside it.

Each kernel is a singular part, integrated in closed form over every cell, and a smooth rest f:

                      nip's cells                      arc's cells
    nip's points      of the plain nip                 closed form
                      Chebyshev <- f <- Chebyshev      Chebyshev <- f <- Gauss
    arc's points      closed form                      closed form
                      f <- Chebyshev                   f <- Gauss

Inside the nip f is interpolated by the plain nip's own Chebyshev points, so that without arcs
nothing changes; along an arc, where it is asked for at few points, it is taken as it is, and
integrated by Gauss's rule.  Beyond what smooth parts hold for they are continued by periodicity
of the whole kernel: the singular parts are exchanged there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, lru_cache
from math import log
from typing import NamedTuple

import numpy as np

from ..contact.grid import HIGHEST_RANK, Grid, Past, chebyshev_points
from ..contact.meshes import interpolation_rank
from ..elasticity.kernels import Kernel, singular
from .integrals import OpenGrid, closed, closed_blocks, gauss

__all__ = ["Influence", "Within"]

Array = np.ndarray
Smooth = Callable[[Array], Array]

KEPT = 300  # nodes of a face up to which much that belongs to its grid is kept


class Within(NamedTuple):
    """Where a plain nip lies in a face.

    Attributes
    ----------
    nip : Grid
    first : int
        The face's node with which it begins.
    rows : (k,) int array
        Which of the face's points are the nip's, in its order.
    stays : slice
        The nodes around it that stay where they are, in units of a, from one half width to another.
    moving : (k,) int array
        The points that do not.
    """

    nip: Grid
    first: int
    rows: Array
    stays: slice
    moving: Array

    @property
    def columns(self) -> slice:
        """Its nodes."""
        return slice(self.first, self.first + self.nip.nodes.size)

    @property
    def own(self) -> Array:
        """Which of the nip's points those are: the last may stand twice."""
        return np.minimum(np.arange(self.rows.size), self.nip.points.size - 1)


class Block(NamedTuple):
    """Integrals at some points over some nodes; what several have in common is their sum.

    Attributes
    ----------
    points : (k,) int array
        Which of the grid's points, ascending.
    rows : array or slice
        The same, as a slice where none between them is left out.
    columns : slice
        The nodes.
    values : (4, k, columns) array
    """

    points: Array
    rows: Array | slice
    columns: slice
    values: Array


class Influence:
    """Integrates kernels against all hats of a grid scaled by a half width.

    Parameters
    ----------
    grid : OpenGrid
        Nodes of a face and the points where kernels are asked for.
    within : Within, optional
        The nip in it; without, all is integrated as along an arc.
    scale : float
        a [m].
    length : float
        Length on which the smooth parts vary [m].
    period : float
        Circumference [m]; inf for a half-plane.
    reach : float, optional
        Largest |t| for which smooth parts hold [m]; half the circumference without.
    """

    def __init__(
        self, grid: OpenGrid, within: Within | None, scale: float, length: float, period: float,
        reach: float | None = None,
    ) -> None:  # fmt: skip
        self.grid, self.scale, self.length = grid, scale, length
        self.period, self.reach = period, period / 2 if reach is None else reach
        self.rank = interpolation_rank(length, scale)
        # too short for polynomials
        self.short = self.rank > (within.nip.highest_rank if within else HIGHEST_RANK)
        self.within = None if self.short else within

    def __call__(self, kernel: Kernel) -> Array:
        """Return the integrals of one kernel at each point, (K, N+1)."""
        smooth = None if kernel.smooth is None else _stacked(kernel.smooth)
        found: Array = self.together((kernel,), smooth, kernel.lag)[0]
        return found

    def together(
        self, kernels: Sequence[Kernel], smooth: Smooth | None, lag: Past | None = None
    ) -> Array:
        """Return the integrals of kernels whose smooth parts and lags are at hand together.

        Returns
        -------
        (kernels, K, N+1) array
            See :meth:`woundon.contact.grid.Grid.integrate_together`.
        """
        grid = self.grid
        out: Array = (self.factors(kernels) @ self.singular.reshape(4, -1)).reshape(
            -1, grid.points.size, grid.nodes.size
        )
        self._add_logs(out, kernels)
        if smooth is not None:
            apart = self.apart
            values = apart.integrated(self.between(kernels, smooth, apart.points))
            out[:, apart.rows] += values[:, apart.interpolated :]
            if self.within is not None:
                out[:, _run(self.within.rows)] += apart.at_nip @ values[:, : apart.interpolated]
        if self.short and all(kernel.twice for kernel in kernels):
            for part, kernel in zip(out, kernels, strict=True):
                part[:, 1:-1] = grid.by_second_integral(kernel.twice, self.scale)  # type: ignore[arg-type]
        return out if lag is None else out + grid.lagging(lag, self.scale)

    def at(self, point: int, kernels: Sequence[Kernel], smooth: Smooth | None) -> Array:
        """Return the integrals at one of the grid's points alone, (kernels, 1, N+1)."""
        grid, own = self.grid, slice(point, point + 1)
        out: Array = (self.factors(kernels) @ self._singular_at(point))[:, None]
        self._add_logs(out, kernels)
        if smooth is not None:
            out += self.apart.integrated(self.between(kernels, smooth, grid.points[own]))
        for part, kernel in zip(out, kernels, strict=True):
            if self.short and kernel.twice is not None:
                part[:, 1:-1] = grid.by_second_integral(kernel.twice, self.scale, own)
            if kernel.lag is not None:
                part += grid.lagging(kernel.lag, self.scale, own)[0]
        return out

    def factors(self, kernels: Sequence[Kernel]) -> Array:
        """Return what multiplies the singular parts, (kernels, 4)."""
        a = self.scale
        return np.array([[k.inverse, k.delta, k.log * a, k.sign * a] for k in kernels])

    def _add_logs(self, out: Array, kernels: Sequence[Kernel]) -> None:
        """Add what ln(a) is in ln|t|."""
        a = self.scale
        for part, kernel in zip(out, kernels, strict=True):
            if kernel.log:
                part += kernel.log * a * log(a) * self.grid.weights

    @cached_property
    def blocks(self) -> list[Block]:
        """The integrals of the inverse, the pulse, the logarithm and the sign, block by block."""
        points, nodes, within = self.grid.points, self.grid.nodes, self.within
        every, all_nodes = np.arange(points.size), slice(0, nodes.size)
        if within is None:
            return [Block(every, slice(None), all_nodes, closed(points, nodes))]
        stays, moving = within.stays, within.moving
        rows = np.delete(every, moving)
        own = within._replace(
            first=within.first - stays.start, rows=np.searchsorted(rows, within.rows)
        )
        ahead, behind = slice(0, stays.start + 1), slice(stays.stop - 1, nodes.size)
        moved = [(rows, part) for part in (ahead, behind) if part.stop - part.start > 1]
        if moving.size:
            moved.append((moving, all_nodes))
        values = [_around(own, points[rows], nodes[stays])]
        if moved:
            values += closed_blocks(*((points[at], nodes[part]) for at, part in moved))
        return [
            Block(at, _run(at), part, made)
            for (at, part), made in zip([(rows, stays), *moved], values, strict=True)
        ]

    @property
    def singular(self) -> Array:
        """Them in one, (4, K, N+1)."""
        first, *others = self.blocks
        out = np.zeros((4, self.grid.points.size, self.grid.nodes.size))
        out[:, first.rows, first.columns] = first.values
        for _, rows, columns, values in others:
            out[:, rows, columns] += values
        return out

    def singular_under(self, loads: Array) -> Array:
        """Return them times loads on the nodes, (N+1, k) -> (4, K, k)."""
        out = np.zeros((4, self.grid.points.size, loads.shape[1]))
        for _, rows, columns, values in self.blocks:
            out[:, rows] += values @ loads[columns]
        return out

    def _singular_at(self, point: int) -> Array:
        """Return them at one point, (4, N+1)."""
        out = np.zeros((4, self.grid.nodes.size))
        for points, _, columns, values in self.blocks:
            k = int(points.searchsorted(point))
            if k < points.size and points[k] == point:
                out[:, columns] += values[:, k]
        return out

    @cached_property
    def apart(self) -> Apart:
        """Where smooth parts are asked for."""
        return Apart(self.grid, self.within, self.rank, self.scale, self.length)

    def between(self, kernels: Sequence[Kernel], smooth: Smooth, points: Array) -> Array:
        """Return smooth parts between points and their sources, (kernels, points, sources)."""
        sources, most = self.apart.sources, self.reach / self.scale
        t = self.scale * (points[:, None] - sources)
        reach = np.maximum(points - sources.min(), sources.max() - points)
        rows = (reach > most).nonzero()[0]  # few of them
        if not rows.size:
            return smooth(t)
        short = t[rows]
        far = np.abs(short) > self.reach
        straight = short[far]
        short[far] = round_ = straight - np.sign(straight) * self.period
        t[rows] = short
        values = smooth(t)
        k, source = far.nonzero()
        values[:, rows[k], source] += singular(kernels, round_) - singular(kernels, straight)
        return values


class Apart:
    """Points and sources between which smooth parts are asked for; see the module's text.

    Attributes
    ----------
    rows : (k,) int array or slice
        Which of the face's points are not the nip's.
    arc : slice
        The nodes of the arc's cells.
    interpolated : int
        Chebyshev points of the nip, the first among points and sources; 0 where there is none.
    points, sources : arrays
        In units of the half width.
    """

    def __init__(
        self, grid: OpenGrid, within: Within | None, rank: int, scale: float, length: float
    ) -> None:
        every, nodes = np.arange(grid.points.size), grid.nodes
        self.scale, self.nodes = scale, nodes.size
        self.rows: Array | slice = slice(None)
        if within is None:
            self.arc, self.interpolated = slice(None), 0
            self.sources, self.hats = gauss(nodes, scale, length)
            self.points = grid.points
            return
        self.interpolated, self.inside = rank, within.columns
        self.rows = _run(np.delete(every, within.rows))
        behind = within.first == 0
        self.arc = slice(self.inside.stop - 1, None) if behind else slice(0, within.first + 1)
        at_points, self.moments = _opened(within.nip).interpolation(rank)
        self.at_nip = at_points[within.own]
        self.sources = chebyshev = chebyshev_points(rank)
        outside = grid.points[self.rows]
        self.points = np.append(chebyshev, outside)
        if outside.size:
            outer, self.hats = gauss(nodes[self.arc], scale, length)
            self.sources = np.append(chebyshev, outer)

    def integrated(self, values: Array) -> Array:
        """Integrate values at the sources against all hats: (..., sources) -> (..., N+1)."""
        r = self.interpolated
        out = np.zeros((*values.shape[:-1], self.nodes))
        if r:
            np.matmul(values[..., :r], self.scale * self.moments, out=out[..., self.inside])
        if values.shape[-1] > r:
            out[..., self.arc] += values[..., r:] @ self.hats
        return out

    def moments_of(self, loads: Array) -> Array:
        """Return what loads (N+1, k) weigh at the sources, (sources, k)."""
        parts = []
        if self.interpolated:
            parts.append(self.scale * (self.moments @ loads[self.inside]))
        if self.sources.size > self.interpolated:
            parts.append(self.hats @ loads[self.arc])
        return np.concatenate(parts)


def _run(rows: Array) -> Array | slice:
    """Return ascending rows as a slice where none is left out: they are reached many times."""
    if rows.size and rows[-1] - rows[0] + 1 == rows.size:
        return slice(int(rows[0]), int(rows[-1]) + 1)
    return rows


def _stacked(smooth: Smooth) -> Smooth:
    """Return one smooth part as if it were several together."""
    return lambda t: smooth(t)[None]


def _around(within: Within, points: Array, nodes: Array) -> Array:
    """Return the singular parts' integrals in and around a nip; of few nodes, kept."""
    make = _kept_around if nodes.size <= KEPT else _kept_around.__wrapped__
    return make(
        within.nip, within.first, *(part.tobytes() for part in (within.rows, points, nodes))
    )


@lru_cache(maxsize=16)
def _kept_around(nip: Grid, first: int, rows: bytes, points: bytes, nodes: bytes) -> Array:
    """Return the singular parts' integrals, (4, K, N+1), the nip's as the plain nip has them."""
    x, y, own = np.frombuffer(nodes), np.frombuffer(points), np.frombuffer(rows, dtype=int)
    inside, out = slice(first, first + nip.nodes.size), np.zeros((4, y.size, x.size))
    plain = _opened(nip).singular.reshape(4, -1, nip.nodes.size)
    out[:, own, inside] = plain[:, np.minimum(np.arange(own.size), nip.points.size - 1)]
    others = np.delete(np.arange(y.size), own)
    out[:, others, inside] = closed(y[others], x[inside])
    for arc in (slice(0, first + 1), slice(inside.stop - 1, None)):
        if x[arc].size > 1:
            out[:, :, arc] += closed(y, x[arc])
    out.setflags(write=False)
    return out


@lru_cache(maxsize=8)
def _opened(nip: Grid) -> OpenGrid:
    """Return the same nip with half hats at its ends, of which much is kept."""
    return OpenGrid(nip.nodes, nip.points)
