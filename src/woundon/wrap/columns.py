r"""Which unknown of a wrapped nip lives where, and what weighs it.

Columns of z are p+ on the nodes from the leading edge to the far side, p- on those from the drum's
arc (or inside the leading edge) to inside the trailing edge, and the shift; columns of q are q+ and
q- on the same nodes less the outermost ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from ..elasticity.strip import Compliance
from ..problems.nip import WrappedNipProblem
from .grid import WrapGrid

__all__ = ["WrapColumns"]

Array = np.ndarray


class Numbers(NamedTuple):
    """The nodes of p+, p-, q+ and q-, the last two in one row, their entries of z, and faces.

    Which tractions are upstream of each node, (N+1, m), and downstream of each cell of both faces,
    (m+2, m), as zeros and ones.  All are kept: the same are asked for at all half widths.
    """

    roll_nodes: Array
    drum_nodes: Array
    roll_q: Array
    drum_q: Array
    columns: Array
    own_pressure: Array
    on_drum: Array
    upstream_of_nodes: Array
    downstream_of_cells: Array


@dataclass(frozen=True, eq=False)
class WrapColumns:
    """The unknowns of one half width a [m]."""

    problem: WrappedNipProblem
    grid: WrapGrid
    half_width: float

    @property
    def roll_arc(self) -> bool:
        """Whether there is an arc behind the nip."""
        return self.problem.roll_wrap > 0

    @property
    def drum_arc(self) -> bool:
        """Whether there is an arc before the nip."""
        return self.problem.drum_wrap > 0

    @cached_property
    def web(self) -> Compliance:
        """The web's compliances."""
        return self.problem.web.compliance

    @property
    def faces(self) -> tuple[Array, Array]:
        """Where the tractions on roll and drum are, in units of a."""
        return self.grid.nodes[self.roll_q], self.grid.nodes[self.drum_q]

    @property
    def places(self) -> Array:
        """Where tension, curvature and loads are given, in units of a."""
        return self.grid.nodes

    @cached_property
    def numbers(self) -> Numbers:
        """The numbers of the nodes that its unknowns are of."""
        return _numbers(self.grid.first, self.grid.last, self.grid.size, self.drum_arc)

    @property
    def roll_nodes(self) -> Array:
        """Nodes of p+."""
        return self.numbers.roll_nodes

    @property
    def drum_nodes(self) -> Array:
        """Nodes of p-."""
        return self.numbers.drum_nodes

    @property
    def roll_q(self) -> Array:
        """Nodes of q+."""
        return self.numbers.roll_q

    @property
    def drum_q(self) -> Array:
        """Nodes of q-."""
        return self.numbers.drum_q

    @property
    def columns(self) -> Array:
        """Nodes of q."""
        return self.numbers.columns

    @property
    def own_pressure(self) -> Array:
        """Entries of z that bound each traction, (m,)."""
        return self.numbers.own_pressure

    @property
    def on_drum(self) -> Array:
        """Which tractions act on the drum, (m,) bool."""
        return self.numbers.on_drum

    def by_q(self, matrix: Array, rows: slice = slice(None)) -> Array:
        """Return those columns of a matrix by all nodes, (..., N+1), that belong to q."""
        roll, drum = slice(self.grid.first + 1, -1), slice(1, self.grid.last)
        return np.concatenate([matrix[rows, roll], matrix[rows, drum]], axis=1)

    @property
    def drum_p(self) -> slice:
        """Columns of the drum's matrices that belong to p-."""
        return slice(0 if self.drum_arc else 1, self.grid.last)

    @cached_property
    def weighs(self) -> Array:
        """Nodes at which the web's weight T kappa acts, (N+1,) bool."""
        grid = self.grid
        weighs = np.full(grid.size, self.roll_arc)  # without: one pressure on both faces
        # p+ begins with zero at the leading edge, but may set in suddenly on a rigid roll
        weighs[: grid.first + 1] = self.drum_arc
        weighs[grid.first] |= self.roll_arc and self.problem.roll.rigid
        return weighs

    @cached_property
    def friction(self) -> Array:
        """Coefficient of friction at each traction, (m,)."""
        problem, behind = self.problem, self.columns >= self.grid.last
        on_roll = np.where(behind, problem.friction_behind, problem.roll_friction)
        return np.where(self.on_drum, problem.drum_friction, on_roll)

    @cached_property
    def force_weights(self) -> Array:
        """What integrates q- over the drum, by q, (m,)."""
        return self.on_drum * (self.half_width * self.grid.weights[self.columns])

    @cached_property
    def load_weights(self) -> Array:
        """What integrates p- over the nip, by z, (k,)."""
        grid = self.grid
        cells = np.where(np.arange(grid.cells.size) >= grid.first, grid.cells, 0.0)
        hats = (np.append(cells, 0.0) + np.append(0.0, cells)) / 2
        out = np.zeros(self.roll_nodes.size + self.drum_nodes.size + 1)
        out[self.roll_nodes.size : -1] = self.half_width * hats[self.drum_nodes]
        return out


@lru_cache(maxsize=64)
def _numbers(first: int, last: int, size: int, drum_arc: bool) -> Numbers:
    """Return the numbers of the nodes of a grid's unknowns, see :class:`Numbers`."""
    roll_nodes, roll_q = np.arange(first, size), np.arange(first + 1, size - 1)
    drum_nodes, drum_q = np.arange(0 if drum_arc else 1, last), np.arange(1, last)
    columns = np.concatenate([roll_q, drum_q])
    own = np.concatenate([roll_q - roll_nodes[0], roll_nodes.size + drum_q - drum_nodes[0]])
    on_drum = np.arange(columns.size) >= roll_q.size
    cells = np.concatenate([roll_nodes[:-1], np.arange(last)])
    upstream, downstream = (columns < np.arange(size)[:, None], columns > cells[:, None])
    made = Numbers(
        roll_nodes, drum_nodes, roll_q, drum_q, columns, own, on_drum, upstream.astype(float),
        downstream.astype(float),
    )  # fmt: skip
    for part in made:
        part.setflags(write=False)
    return made
