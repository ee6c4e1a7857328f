r"""Which unknown of a wrapped nip lives where, and what weighs it.

Columns of z are p+ on the nodes from the leading edge to the far side, p- on those from the drum's
arc (or inside the leading edge) to inside the trailing edge, and the shift; columns of q are q+ and
q- on the same nodes less the outermost ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..elasticity.strip import Compliance
from ..problems.nip import WrappedNipProblem
from .grid import WrapGrid

__all__ = ["WrapColumns"]

Array = np.ndarray


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
    def roll_nodes(self) -> Array:
        """Nodes of p+."""
        return np.arange(self.grid.first, self.grid.size)

    @cached_property
    def drum_nodes(self) -> Array:
        """Nodes of p-."""
        return np.arange(0 if self.drum_arc else 1, self.grid.last)

    @cached_property
    def roll_q(self) -> Array:
        """Nodes of q+."""
        return np.arange(self.grid.first + 1, self.grid.size - 1)

    @cached_property
    def drum_q(self) -> Array:
        """Nodes of q-."""
        return np.arange(1, self.grid.last)

    @cached_property
    def columns(self) -> Array:
        """Nodes of q."""
        return np.concatenate([self.roll_q, self.drum_q])

    def by_q(self, matrix: Array, rows: slice = slice(None)) -> Array:
        """Return those columns of a matrix by all nodes, (..., N+1), that belong to q."""
        roll, drum = slice(self.grid.first + 1, -1), slice(1, self.grid.last)
        return np.concatenate([matrix[rows, roll], matrix[rows, drum]], axis=1)

    @cached_property
    def drum_p(self) -> slice:
        """Columns of the drum's matrices that belong to p-."""
        return slice(self.drum_nodes[0], self.grid.last)

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
    def on_drum(self) -> Array:
        """Which tractions act on the drum, (m,) bool."""
        return np.arange(self.columns.size) >= self.roll_q.size

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
    def own_pressure(self) -> Array:
        """Entries of z that bound each traction, (m,)."""
        n_p = self.roll_nodes.size
        return np.concatenate(
            [self.roll_q - self.roll_nodes[0], n_p + self.drum_q - self.drum_nodes[0]]
        )

    @cached_property
    def load_weights(self) -> Array:
        """What integrates p- over the nip, by z, (k,)."""
        grid = self.grid
        cells = np.where(np.arange(grid.cells.size) >= grid.first, grid.cells, 0.0)
        hats = (np.append(cells, 0.0) + np.append(0.0, cells)) / 2
        out = np.zeros(self.roll_nodes.size + self.drum_nodes.size + 1)
        out[self.roll_nodes.size : -1] = self.half_width * hats[self.drum_nodes]
        return out
