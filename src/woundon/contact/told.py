r"""Told discretisation errors, by the changes of an output from mesh to mesh.

On the program's own meshes of N_0 < N_1 < ... cells an output is

    v_k = v + s z_k / N_k^2,    z_k independent, of variance 1:

second order, but erratic, because the borders of the zones fall anywhere between the nodes.  (On a
rigid body tractions may jump at a border, which leaves errors of first order beside those of second
one: there the order is in between.)  A change v_k - v_{k-1} then has the variance
s^2 (N_k^-4 + N_{k-1}^-4), so that each change tells the scatter s once more, and the last error
over what n changes tell is distributed as Student's t with n degrees of freedom.  The told error is
the one that is exceeded :data:`WITHIN` times in :data:`OUTSIDE` of cases.  (Smooth errors of second
order, a third of the change from half the cells, are within.)  A neighbouring case scatters as
much, though not alike: what its changes told counts too.  All changes may be small by chance, as
borders fall alike on two meshes; so what the last mesh lets foresee of s counts as a few changes
more.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import nan, sqrt
from typing import NamedTuple

__all__ = [
    "CHANCE",
    "CHANGE_WEIGHT",
    "ERROR_WEIGHTS",
    "NOTHING",
    "ORDER",
    "Foreseen",
    "Scatter",
    "by_changes",
]

# An error is estimated as a weighted sum of the last two changes under doubling of the mesh.
# Smooth errors of order two would leave a third of the last change; zone borders make it erratic,
# so both weights are larger, set by benchmarks/campaign (95 % of cases within 1.5 estimates).
ERROR_WEIGHTS = (0.7, 0.2)
# Where only one change is known (from a neighbour's state, or on coarse meshes) it may be small by
# chance, as zone borders fall between nodes; so it counts less, and a share of the scale is added
# which falls with the nodes: 95 % of random nips are within 2 estimates (4.3 of the change alone).
CHANGE_WEIGHT, CHANCE = 0.4, 4e-4

ORDER = 2.0
WITHIN, OUTSIDE = 1.5, 0.06
COUNTED = 3  # changes of a case: of coarser meshes the order is not two yet
REMEMBERED = 3  # changes of neighbouring cases
# Student's t exceeded, either way, in OUTSIDE of cases: of 1, 1.5, 2, ... degrees of freedom
STUDENT = (10.579, 5.306, 3.896, 3.285, 2.951, 2.742, 2.601, 2.499, 2.422, 2.361,
           2.313, 2.274, 2.241, 2.213, 2.189, 2.168)  # fmt: skip


class Foreseen(NamedTuple):
    """The scatter that a mesh lets foresee, and as how many changes it counts, in halves."""

    size: float = 0.0
    changes: float = 0.0


NOTHING = Foreseen()


class Scatter(NamedTuple):
    """The scatter s of an output, as of a mesh of one cell and over the output's scale.

    ``changes`` tell it, and ``foreseen``, on the same terms, counts beside them: together the
    degrees of ``freedom``.  It falls with the cells to the power ``order``.
    """

    size: float
    changes: int
    order: float = ORDER
    foreseen: Foreseen = NOTHING

    @classmethod
    def of(
        cls, values: Sequence[float], cells: Sequence[int], scale: float, order: float = ORDER,
        foreseen: Foreseen = NOTHING,
    ) -> Scatter:  # fmt: skip
        """Return that of the values of one mesh after another, each of so many cells.

        ``foreseen`` is of the last mesh and of the values' unit.
        """
        if scale == 0:
            return cls(0.0, min(len(values) - 1, COUNTED), order)
        count = min(len(values) - 1, COUNTED)
        squares = 0.0
        for k in range(-count, 0):  # a share of s^2 is what a mesh has
            shares = cells[k - 1] ** (-2 * order) + cells[k] ** (-2 * order)
            squares += (values[k] - values[k - 1]) ** 2 / shares
        size = sqrt(squares / count) / scale if count else 0.0
        if not foreseen.changes:
            return cls(size, count, order)
        of_one_cell = Foreseen(foreseen.size * cells[-1] ** order / scale, foreseen.changes)
        return cls(size, count, order, of_one_cell)

    @property
    def freedom(self) -> float:
        """The degrees of freedom."""
        return self.changes + self.foreseen.changes

    @property
    def tells(self) -> bool:
        """Whether there is enough to tell an error by, a change at least."""
        return self.changes > 0 and self.freedom >= 2

    def after(self, before: Scatter | None) -> Scatter:
        """Return what is known with what a neighbouring case told, the last of it at most.

        What that one foresaw counts only where nothing is foreseen.
        """
        if before is None:
            return self
        foreseen = self.foreseen if self.foreseen.changes else before.foreseen
        known = min(before.changes, REMEMBERED)
        count = self.changes + known
        squares = self.changes * self.size**2 + known * before.size**2
        size = sqrt(squares / count) if count else 0.0
        return Scatter(size, count, self.order, foreseen)

    def error(self, cells: int, scale: float) -> float:
        """Return the told error on a mesh of so many cells; nan where no change tells it."""
        if self.changes == 0:
            return nan
        size, usual, weight = self.size, *self.foreseen
        squares = self.changes * size**2 + weight * usual**2
        student = STUDENT[min(round(2 * self.freedom) - 2, len(STUDENT) - 1)]
        return student / WITHIN * sqrt(squares / self.freedom) / cells**self.order * scale


def by_changes(values: Sequence[float], weights: tuple[float, float] = ERROR_WEIGHTS) -> float:
    """Return the last value's told error from the last two changes; nan from a single value."""
    changes = [abs(b - a) for a, b in pairwise(values)][::-1]
    if len(changes) < 2:
        return changes[0] if changes else nan
    return weights[0] * changes[0] + weights[1] * changes[1]
