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

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..contact.grid import Grid
from ..errors import InvalidProblem
from ..problems.nip import WrappedNipProblem

__all__ = ["WrapGrid", "grid_for", "wrap_grid"]

Array = np.ndarray

FINE = 0.2  # [a]: farther out cells grow like the distance from the nip, nearer like its root
SHORTEST_WRAP = 2.0  # half widths
EVENNESS = 3.0  # a cell at the far side is at most 1/EVENNESS of an even one


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

