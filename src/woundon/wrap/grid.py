r"""Grids of a nip with the arcs on which the web lies on the roll behind it and on the drum before.

In units of the half width a, along the web:

      drum's arc (optional)        nip            roll's arc (optional)
    |--|---|----|----|---|--|-|||--- ... ---|||-|--|---|-----|------|------|
    start                  -1                1                            end
     moves |        stays                          stays     |     moves

The nip has the nodes and collocation points of the plain nip.  On an arc the cells grow with the
distance from the nip, and towards the far side stay below a fraction of the arc.  A loaded arc may
end on a finite traction, so its ends carry half hats; the nip's own hats are kept as they are.

Of how long an arc is in half widths, only a rounded value shapes its cells, and only those at its
far side move to meet its end: between one half width and another, and from case to case, most of
the grid stays as it is, and all that belongs to it can be kept.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import log
from typing import NamedTuple

import numpy as np

from ..contact.grid import Grid
from ..errors import InvalidProblem
from ..problems.nip import WrappedNipProblem

__all__ = [
    "GRADING", "GRADING_0_1", "Arc", "Grading", "WrapGrid", "grid_for", "grid_of_0_1", "wrap_grid",
]  # fmt: skip

Array = np.ndarray

SHORTEST_WRAP = 2.0  # half widths
STEP = log(2) / 64  # of ln of an arc's length: what shapes its cells
OVERLAP = 5e-6  # of it too: so far a shape is kept beyond, or a width there would not settle


class Grading(NamedTuple):
    """How the cells of an arc grow.

    Attributes
    ----------
    fine, power : float
        Beyond ``fine`` [a] cells grow like the distance, nearer like its power 1 - 1/power.
    evenness : float
        A cell at the far side is at most 1/evenness of an even one.
    to_entry : float
        Share of the cells that is graded to where tractions set in.
    """

    fine: float
    power: float
    evenness: float
    to_entry: float


GRADING = Grading(fine=0.1, power=2.5, evenness=0.5, to_entry=1 / 3)
GRADING_0_1 = Grading(fine=0.2, power=2.0, evenness=3.0, to_entry=1 / 2)  # that of woundon 0.1


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
    arcs : (Arc, Arc)
        Those before it and behind it.
    """

    nodes: Array
    points: Array
    first: int
    last: int
    nip: Grid
    arcs: tuple[Arc, Arc]

    @property
    def size(self) -> int:
        """Number N+1 of nodes."""
        return self.nodes.size

    @property
    def kept(self) -> tuple[int, int]:
        """First and last of the nodes that stay where they are in units of a."""
        before, behind = self.arcs
        return self.first - before.kept, self.last + behind.kept

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


class Arc(NamedTuple):
    """An arc beside the nip.

    Attributes
    ----------
    rows : (2 cells + 1,) array
        Nodes (even) and points (odd) by distance from the nip, in units of the half width.
    kept : int
        How many cells stay where they are as the length changes a little.
    shape : float
        The rounded length that shapes the cells.
    """

    rows: Array
    kept: int
    shape: float

    @classmethod
    def of(cls, length: float, cells: int, entry: bool, like: float = 0.0) -> Arc:
        """Return an arc of so many cells, shaped like another where it is nearly as long.

        With ``entry`` the far side is an edge where traction sets in, and is resolved too.
        """
        if length == 0:
            return cls(np.zeros(1), 0, 0.0)
        shape = float(np.exp(STEP * round(log(length) / STEP)))
        if like and abs(log(length / like)) < STEP / 2 + OVERLAP:
            shape = like
        rows, kept = (_graded_to_entry if entry else _graded)(shape, cells, GRADING)
        rows, last = rows.copy(), rows[2 * kept]
        rows[2 * kept :] += (rows[2 * kept :] - last) * ((length - shape) / (shape - last))
        rows[-1] = length
        return cls(rows, kept, shape)

    @classmethod
    def of_0_1(cls, length: float, cells: int, entry: bool) -> Arc:
        """Return an arc as woundon 0.1 had it, no part of which stays."""
        if length == 0:
            return cls(np.zeros(1), 0, 0.0)
        rows, _ = (_graded_to_entry if entry else _graded)(length, cells, GRADING_0_1)
        return cls(rows, 0, length)


def wrap_grid(
    nip: Grid, drum_arc: float, drum_cells: int, roll_arc: float, roll_cells: int,
    like: WrapGrid | None = None,
) -> WrapGrid:  # fmt: skip
    """Join arcs to a nip's grid.

    Parameters
    ----------
    nip : Grid
    drum_arc, roll_arc : float
        Lengths of the arcs beyond the nip in units of the half width; 0 for none.
    drum_cells, roll_cells : int
        Their numbers of cells.
    like : WrapGrid, optional
        Of nearly the same lengths; most of it is to stay.
    """
    shapes = (0.0, 0.0) if like is None else (like.arcs[0].shape, like.arcs[1].shape)
    drum = Arc.of(drum_arc, drum_cells, True, shapes[0])
    roll = Arc.of(roll_arc, roll_cells, False, shapes[1])
    return _joined(nip, drum, roll)


def _joined(nip: Grid, drum: Arc, roll: Arc) -> WrapGrid:
    """Return a nip's grid with arcs before and behind."""
    before, after = drum.rows, roll.rows
    nodes = np.concatenate([-1 - before[:0:-2], nip.nodes, 1 + after[2::2]])
    points = np.concatenate([-1 - before[-2::-2], nip.points[:-1], 1 + after[1::2]])
    first = before.size // 2
    return WrapGrid(nodes, points, first, first + nip.nodes.size - 1, nip, (drum, roll))


def grid_for(
    problem: WrappedNipProblem, nip: Grid, a: float, drum_cells: int, roll_cells: int,
    like: WrapGrid | None = None,
) -> WrapGrid:  # fmt: skip
    """Return a problem's grid for the half width a [m]: the arcs' ends stay where they are.

    ``like`` is that of nearly the same half width.

    Raises
    ------
    InvalidProblem
        For a wrap on the roll that ends within the nip, or too near behind it.
    """
    drum, roll = _lengths(problem, a)
    return wrap_grid(nip, drum, drum_cells, roll, roll_cells, like)


def grid_of_0_1(
    problem: WrappedNipProblem, nip: Grid, a: float, drum_cells: int, roll_cells: int
) -> WrapGrid:
    """Return the grid that woundon 0.1 had, whose files hold its nodes; see above."""
    drum, roll = _lengths(problem, a)
    return _joined(nip, Arc.of_0_1(drum, drum_cells, True), Arc.of_0_1(roll, roll_cells, False))


def _lengths(problem: WrappedNipProblem, a: float) -> tuple[float, float]:
    """Return the lengths of the arcs of drum and roll beyond the nip, in half widths."""
    radius, wrap = problem.roll.radius, problem.roll_wrap
    drum = problem.drum_wrap * problem.drum.radius / a
    roll = wrap * radius / a - 1 if wrap > 0 else 0.0
    if wrap > 0 and roll < SHORTEST_WRAP - 1:
        raise InvalidProblem.at(
            "roll_wrap",
            f"{wrap:.6g} is out of range; the nip's trailing edge is at {a / radius:.4g}, so it "
            f"must be 0 or >= {SHORTEST_WRAP * a / radius:.4g} [rad]",
        )
    return drum, roll


@lru_cache(maxsize=128)
def _graded(length: float, cells: int, by: Grading) -> tuple[Array, int]:
    """Return nodes and points by distance, and how many cells from the nip on stay."""
    # cells are counted by m ln(1 + u) + even u^m, with u^m the distance over fine
    m, even = by.power, by.evenness * by.fine / length
    most = float((length / by.fine) ** (1 / m))
    t = np.linspace(0.0, 1.0, 2 * cells + 1) * (m * np.log1p(most) + even * most**m)
    u = np.minimum(np.expm1(t / m), most)
    for _ in range(50):  # Newton's method from above, on a growing function
        step = (m * np.log1p(u) + even * u**m - t) / (m / (1 + u) + m * even * u ** (m - 1))
        u = np.clip(u - step, 0.0, most)
        if np.max(np.abs(step)) < 1e-14 * most:
            break
    distance = by.fine * u**m
    distance[0], distance[-1] = 0.0, length
    return distance, cells - max(1, cells // 8)


@lru_cache(maxsize=128)
def _graded_to_entry(length: float, cells: int, by: Grading) -> tuple[Array, int]:
    """Return the same with an entry at the far side, to which some of the cells are graded."""
    fine = max(int(by.to_entry * cells), 2)
    near, kept = _graded(length / 2, cells - fine, by)
    far, _ = _graded(length / 2, fine, by)
    return np.concatenate([near, (length - far)[-2::-1]]), kept
