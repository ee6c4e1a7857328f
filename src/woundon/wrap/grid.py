r"""Grids of a nip with the arcs on which the web lies on the roll behind it and on the drum before.

In units of the half width a, along the web:

      drum's arc (optional)        nip            roll's arc (optional)
    |--|---|----|----|---|--|-|||--- ... ---|||-|--|---|-----|------|------|
    start                  -1                1                            end

The nip has the nodes and collocation points of the plain nip.  On an arc the cells grow with the
distance from the nip, and towards the far side stay below a fraction of the arc.  A loaded arc may
end on a finite traction, so its ends carry half hats; the nip's own hats are kept as they are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ..contact.grid import HIGHEST_RANK, Grid, Past
from ..contact.schemes import interpolation_rank
from ..elasticity.kernels import Kernel
from ..errors import InvalidProblem
from ..problems.nip import WrappedNipProblem

__all__ = ["Gauss", "Influence", "OpenGrid", "WrapGrid", "grid_for", "wrap_grid"]

Array = np.ndarray

FINE = 0.2  # [a]: farther out cells grow like the distance from the nip, nearer like its root
SHORTEST_WRAP = 2.0  # half widths
EVENNESS = 3.0  # a cell at the far side is at most 1/EVENNESS of an even one
MOST_POINTS = 150  # of a cell; three for each length on which a body responds


@dataclass(frozen=True, eq=False)
class OpenGrid(Grid):
    """A grid whose ends carry half hats, so that every node is an unknown."""

    @property
    def unknowns(self) -> int:
        """Number of nodes, ends included."""
        return self.nodes.size

    @cached_property
    def weights(self) -> Array:
        """Integrals of the hats and half hats, (N+1,)."""
        return (np.append(self.cells, 0.0) + np.append(0.0, self.cells)) / 2

    def _hats(self, zeroth: Array, first: Array) -> Array:
        out = np.zeros((first.shape[0], first.shape[1] + 1))
        np.subtract(zeroth, first, out=out[:, :-1])
        out[:, 1:] += first
        return out

    def lagging(self, lag: Past, scale: float, rows: slice = slice(None)) -> Array:
        """Integrate what a viscoelastic surface adds against hats and half hats, (k, K, N+1)."""
        before, logarithm = (part[rows] for part in self.apart)
        rise = np.diff(lag.twice(before, logarithm + np.log(scale)), axis=-1) / (scale * self.cells)
        ends = [
            -lag.exactly(scale * (self.points[rows] - node), 1)[..., None]
            for node in self.nodes[[0, -1]]
        ]
        return np.diff(np.concatenate([ends[0], rise, ends[1]], axis=-1), axis=-1)


@dataclass(frozen=True, eq=False)
class WrapGrid:
    """Nodes of drum arc, nip and roll arc in one row, in units of the half width.

    Attributes
    ----------
    nodes : (N+1,) array
    points : (N,) array
        Collocation points, one in each cell.
    first, last : int
        Nodes at -1 and 1, where the nip begins and ends.
    nip : Grid
        The plain nip's grid.
    """

    nodes: Array
    points: Array
    first: int
    last: int
    nip: Grid

    @property
    def size(self) -> int:
        """Number N+1 of nodes."""
        return self.nodes.size

    @cached_property
    def cells(self) -> Array:
        """Cell lengths, (N,)."""
        return np.diff(self.nodes)

    @cached_property
    def share(self) -> Array:
        """Where in its cell each point lies, from 0 to 1, (N,)."""
        return (self.points - self.nodes[:-1]) / self.cells

    @cached_property
    def weights(self) -> Array:
        """Integrals of the hats, half ones at the ends, (N+1,)."""
        return (np.append(self.cells, 0.0) + np.append(0.0, self.cells)) / 2

    @cached_property
    def to_nodes(self) -> Array:
        """Integrals of the hats from the start to each node, (N+1, N+1)."""
        before = np.append(0.0, self.cells) / 2
        return np.tril(np.broadcast_to(self.weights, (self.size,) * 2), -1) + np.diag(before)

    @cached_property
    def to_points(self) -> Array:
        """Integrals from the start to each cell, what lies upstream counted whole, (N, N+1)."""
        return np.tril(np.broadcast_to(self.weights, (self.size,) * 2))[:-1]

    @cached_property
    def value(self) -> Array:
        """Value of the piecewise linear function at the points, (N, N+1)."""
        k = np.arange(self.cells.size)  # one point in each cell
        out = np.zeros((k.size, self.size))
        out[k, k], out[k, k + 1] = 1 - self.share, self.share
        return out


def wrap_grid(
    nip: Grid, drum_arc: float, drum_cells: int, roll_arc: float, roll_cells: int
) -> WrapGrid:
    """Join arcs to a nip's grid.

    Parameters
    ----------
    nip : Grid
    drum_arc, roll_arc : float
        Lengths of the arcs beyond the nip in units of the half width; 0 for none.
    drum_cells, roll_cells : int
        Their numbers of cells.
    """
    before, after = _arc(drum_arc, drum_cells, True), _arc(roll_arc, roll_cells, False)
    nodes = np.concatenate([-1 - before[:0:-2], nip.nodes, 1 + after[2::2]])
    points = np.concatenate([-1 - before[-2::-2], nip.points[:-1], 1 + after[1::2]])
    first = before.size // 2
    return WrapGrid(nodes, points, first, first + nip.nodes.size - 1, nip)


def grid_for(
    problem: WrappedNipProblem, nip: Grid, a: float, drum_cells: int, roll_cells: int
) -> WrapGrid:
    """Return a problem's grid for the half width a [m]: the arcs' ends stay where they are.

    Raises
    ------
    InvalidProblem
        For a wrap on the roll that ends within the nip, or too near behind it.
    """
    radius, wrap = problem.roll.radius, problem.roll_wrap
    drum = problem.drum_wrap * problem.drum.radius / a
    roll = wrap * radius / a - 1 if wrap > 0 else 0.0
    if wrap > 0 and roll < SHORTEST_WRAP - 1:
        raise InvalidProblem.at(
            "roll_wrap",
            f"{wrap:.6g} is out of range; the nip's trailing edge is at {a / radius:.4g}, so it "
            f"must be 0 or >= {SHORTEST_WRAP * a / radius:.4g} [rad]",
        )
    return wrap_grid(nip, drum, drum_cells, roll, roll_cells)


def _arc(length: float, cells: int, entry: bool) -> Array:
    """Return nodes (even) and points (odd) of an arc by distance from the nip, (2 cells + 1,).

    With ``entry`` the far side is an edge where traction sets in, and is resolved like the nip's.
    """
    if length == 0:
        return np.zeros(1)
    if entry:
        half = _arc(length / 2, max(cells // 2, 2), False)
        return np.concatenate([half, (length - half)[-2::-1]])

    # cells are counted by 2 ln(1 + u) + even u^2, with u the root of the distance over FINE
    even = EVENNESS * FINE / length
    most = float(np.sqrt(length / FINE))
    t = np.linspace(0.0, 1.0, 2 * cells + 1) * (2 * np.log1p(most) + even * most**2)
    u = np.minimum(np.expm1(t / 2), most)
    for _ in range(50):  # Newton's method from above, on a growing function
        step = (2 * np.log1p(u) + even * u**2 - t) / (2 / (1 + u) + 2 * even * u)
        u = np.clip(u - step, 0.0, most)
        if np.max(np.abs(step)) < 1e-14 * most:
            break
    distance = FINE * u**2
    distance[0], distance[-1] = 0.0, length
    return distance


class Gauss:
    """Gauss's rule along a row of nodes, few points a cell, more where a kernel varies in it.

    Parameters
    ----------
    nodes : (N+1,) array
        In units of the half width.
    scale : float
        a [m].
    length : float
        On which the kernels vary [m].
    """

    def __init__(self, nodes: Array, scale: float, length: float) -> None:
        cells = np.diff(nodes)
        share = scale * cells / length
        orders = np.where(share < 0.01, 1, 2 + np.minimum(3 * share, MOST_POINTS).astype(int))
        self.cell = cell = np.repeat(np.arange(cells.size), orders)
        rules = [_gauss(order) for order in orders.tolist()]
        part = (np.concatenate([g for g, _ in rules]) + 1) / 2
        weight = np.concatenate([w for _, w in rules]) / 2 * cells[cell] * scale
        self.points = nodes[cell] + cells[cell] * part
        # hats and half hats times weights, (Q, N+1)
        self.hats = np.zeros((part.size, nodes.size))
        k = np.arange(part.size)
        self.hats[k, cell], self.hats[k, cell + 1] = weight * (1 - part), weight * part


class Influence:
    """Integrates kernels of a closed circle against all hats of a grid scaled by a half width.

    What is singular is integrated in closed form, the smooth rest by Gauss's rule, few points a
    cell, for it varies on the radius.  Points and hats inside the nip keep the plain nip's
    integrals, so that without arcs nothing changes.

    Parameters
    ----------
    grid : OpenGrid
        Nodes of a face and the points where kernels are asked for.
    nip : Grid
    rows, columns : int array, slice
        Which points are the nip's, in its order, and which hats lie wholly inside it.
    scale : float
        a [m].
    length : float
        Length on which the smooth parts vary [m].
    period : float
        Circumference [m]; inf for a half-plane.
    gauss : Gauss, optional
        Of the grid's nodes, where it is at hand.
    """

    def __init__(
        self, grid: OpenGrid, nip: Grid | None, rows: Array, columns: slice,
        scale: float, length: float, period: float, gauss: Gauss | None = None,
    ) -> None:  # fmt: skip
        self.grid, self.nip, self.rows, self.columns = grid, nip, rows, columns
        self.scale, self.length, self.period = scale, length, period
        self.gauss = gauss or Gauss(grid.nodes, scale, length)

    def __call__(self, kernel: Kernel) -> Array:
        """Return the integrals of one kernel at each point, (K, N+1)."""
        smooth = None if kernel.smooth is None else _stacked(kernel.smooth)
        found: Array = self.together((kernel,), smooth, kernel.lag)[0]
        return found

    def together(
        self, kernels: Sequence[Kernel], smooth: Callable[[Array], Array] | None,
        lag: Past | None = None,
    ) -> Array:  # fmt: skip
        """Return the integrals of kernels whose smooth parts and lags are at hand together.

        Returns
        -------
        (kernels, K, N+1) array
            See :meth:`woundon.contact.grid.Grid.integrate_together`.
        """
        out = self._closed(kernels)
        if smooth is not None:
            for rows, points in self.blocks:
                out[:, rows] += self._smooth(kernels, smooth, rows, points)
        rank = interpolation_rank(self.length, self.scale)
        most = HIGHEST_RANK if self.nip is None else self.nip.highest_rank
        twice = [kernel.twice for kernel in kernels if kernel.twice is not None]
        if rank > most and len(twice) == len(kernels):  # too short for Gauss's rule
            for part, one in zip(out, twice, strict=True):
                part[:, 1:-1] = self.grid.by_second_integral(one, self.scale)
        elif self.nip is not None:
            own = self.nip.integrate_together(kernels, smooth, self.scale, rank)
            out[:, self.rows, self.columns] = own[:, : self.rows.size]
        return out if lag is None else out + self.grid.lagging(lag, self.scale)

    def at_end(self, kernels: Sequence[Kernel]) -> Array:
        """Return the integrals at the last point alone, (kernels, 1, N+1)."""
        end, out = slice(-1, None), self._closed(kernels, slice(-1, None))
        rank, every = interpolation_rank(self.length, self.scale), slice(None)
        for part, kernel in zip(out, kernels, strict=True):
            if rank > HIGHEST_RANK and kernel.twice is not None:
                part[:, 1:-1] = self.grid.by_second_integral(kernel.twice, self.scale, end)
            elif kernel.smooth is not None:
                part += self._smooth((kernel,), _stacked(kernel.smooth), end, every)[0]
            if kernel.lag is not None:
                part += self.grid.lagging(kernel.lag, self.scale, end)[0]
        return out

    def _closed(self, kernels: Sequence[Kernel], rows: slice = slice(None)) -> Array:
        """Return the integrals of the singular parts, (kernels, rows, N+1)."""
        a, grid = self.scale, self.grid
        factors = np.array([[k.inverse, k.delta, k.log * a, k.sign * a] for k in kernels])
        singular = grid.singular.reshape(4, grid.points.size, -1)[:, rows]
        out: Array = (factors @ singular.reshape(4, -1)).reshape(-1, *singular.shape[1:])
        for part, kernel in zip(out, kernels, strict=True):
            if kernel.log:
                part += kernel.log * a * np.log(a) * grid.weights
        return out

    @cached_property
    def blocks(self) -> list[tuple[Array, Array]]:
        """Return for which points smooth parts are integrated by which of Gauss's points."""
        points, every = np.arange(self.grid.points.size), np.arange(self.gauss.points.size)
        if self.nip is None:
            return [(points, every)]
        cell = self.gauss.cell
        inner = (cell >= self.columns.start) & (cell < self.columns.stop - 1)
        return [(np.delete(points, self.rows), every), (self.rows, every[~inner])]

    def _smooth(
        self, kernels: Sequence[Kernel], smooth: Callable[[Array], Array],
        rows: Array | slice, points: Array | slice,
    ) -> Array:  # fmt: skip
        """Return the integrals of smooth parts by some of Gauss's points, (kernels, rows, N+1)."""
        return self.between(kernels, smooth, rows, points) @ self.gauss.hats[points]

    def between(
        self, kernels: Sequence[Kernel], smooth: Callable[[Array], Array],
        rows: Array | slice, points: Array | slice,
    ) -> Array:  # fmt: skip
        """Return smooth parts between points and some of Gauss's, (kernels, rows, points).

        Beyond half the circumference a smooth part is continued by periodicity of the whole kernel:
        the singular parts are exchanged there.
        """
        t = self.scale * (self.grid.points[rows, None] - self.gauss.points[points])
        far = np.abs(t) > self.period / 2
        straight = t[far]
        if straight.size:
            t[far] = round_ = straight - np.sign(straight) * self.period
        values = smooth(t)
        if straight.size:
            for value, kernel in zip(values, kernels, strict=True):
                value[far] += kernel.singular(round_) - kernel.singular(straight)
        return values


def _stacked(smooth: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """Return one smooth part as if it were several together."""
    return lambda t: smooth(t)[None]


@lru_cache
def _gauss(order: int) -> tuple[Array, Array]:
    """Return Gauss's points and weights on [-1, 1]."""
    g, w = np.polynomial.legendre.leggauss(order)
    return g, w
