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

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from ..contact.grid import HIGHEST_RANK, Grid, Past
from ..contact.schemes import interpolation_rank
from ..elasticity.kernels import Kernel
from ..errors import InvalidProblem
from ..problems.nip import WrappedNipProblem

__all__ = ["Influence", "OpenGrid", "WrapGrid", "grid_for", "wrap_grid"]

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
        falling = zeroth - first
        inner = first[:, :-1] + falling[:, 1:]
        return np.hstack([falling[:, :1], inner, first[:, -1:]])

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
        part = (self.points - self.nodes[:-1]) / self.cells
        out = np.zeros((k.size, self.size))
        out[k, k], out[k, k + 1] = 1 - part, part
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
    """

    def __init__(
        self, grid: OpenGrid, nip: Grid | None, rows: Array, columns: slice,
        scale: float, length: float, period: float,
    ) -> None:  # fmt: skip
        self.grid, self.nip, self.rows, self.columns = grid, nip, rows, columns
        self.scale, self.length, self.period = scale, length, period

    def __call__(self, kernel: Kernel) -> Array:
        """Return the integrals at each point, (K, N+1)."""
        whole, lag = kernel, kernel.lag
        kernel = replace(kernel, lag=None)
        out = self.grid.integrate(replace(kernel, smooth=None), self.scale)
        if kernel.smooth is not None:
            needed, near, far, across = self._distances
            values = np.zeros(needed.shape)
            values[needed] = kernel.smooth(near)
            values[far] += whole.singular(across[0]) - whole.singular(across[1])
            out += values @ self._hats_at_points
        rank = interpolation_rank(self.length, self.scale)
        most = HIGHEST_RANK if self.nip is None else self.nip.highest_rank
        if rank > most and kernel.twice is not None:  # too short for Gauss's rule
            out[:, 1:-1] = self.grid.by_second_integral(kernel.twice, self.scale)
        elif self.nip is not None:
            own = slice(0, self.rows.size)
            out[self.rows, self.columns] = self.nip.integrate(kernel, self.scale, own, rank)
        return out if lag is None else out + self.grid.lagging(lag, self.scale)[0]

    @cached_property
    def _points(self) -> tuple[Array, Array, Array]:
        """Return Gauss's points, their cells and weights, (Q,)."""
        cells = self.grid.cells
        share = self.scale * cells / self.length
        orders = np.where(share < 0.01, 1, 2 + np.minimum(3 * share, MOST_POINTS).astype(int))
        cell = np.repeat(np.arange(cells.size), orders)
        rules = [_gauss(order) for order in orders.tolist()]
        part = (np.concatenate([g for g, _ in rules]) + 1) / 2
        return part, cell, np.concatenate([w for _, w in rules]) / 2 * cells[cell] * self.scale

    @cached_property
    def _hats_at_points(self) -> Array:
        """Hats times weights at Gauss's points, (Q, N+1)."""
        part, cell, weight = self._points
        hats = np.zeros((part.size, self.grid.nodes.size))
        k = np.arange(part.size)
        hats[k, cell], hats[k, cell + 1] = weight * (1 - part), weight * part
        return hats

    @cached_property
    def _distances(self) -> tuple[Array, Array, Array, tuple[Array, Array]]:
        """Return where smooth parts are needed (K, Q), at which distances, and what is beyond half.

        Beyond half the circumference a smooth part is continued by periodicity of the whole kernel:
        the singular parts are exchanged there.
        """
        part, cell, _ = self._points
        s = self.grid.nodes[cell] + self.grid.cells[cell] * part
        t = self.scale * (self.grid.points[:, None] - s)
        needed = np.ones(t.shape, dtype=bool)
        if self.nip is not None:
            inner = (cell >= self.columns.start) & (cell < self.columns.stop - 1)
            needed[self.rows] = ~inner
        far = needed & (np.abs(t) > self.period / 2)
        straight = t[far]
        t[far] -= np.sign(straight) * self.period if straight.size else straight
        return needed, t[needed], far, (t[far], straight)


@lru_cache
def _gauss(order: int) -> tuple[Array, Array]:
    """Return Gauss's points and weights on [-1, 1]."""
    g, w = np.polynomial.legendre.leggauss(order)
    return g, w
