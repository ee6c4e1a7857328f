"""What given pressures, tractions and shift leave of a wrapped nip's equations, without matrices.

Where only a residual is asked for, by the certificate or on the way from one half width to another,
the bodies' answers to given tractions are a few products with vectors; :mod:`.equations` has the
laws, and their matrices.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..contact.response import Tractions
from ..losses import Surface
from .columns import WrapColumns
from .face import FaceLaws, Loaded

__all__ = ["Along", "WrapLaws"]

Array = np.ndarray


class Along(NamedTuple):
    """What belongs to given unknowns; tractions and pressures on all N+1 nodes.

    Attributes
    ----------
    gap : array
        What is left of the gap's slope in the nip's cells.
    tension, bend : (N+1,) arrays
        T [N/m] and kappa [1/m].
    roll_slip, drum_slip : arrays
        v+ and v- less the creep, in the cells of each face.
    roll, drum : Loaded
        The surfaces.
    roll_loads, drum_loads : Tractions
    """

    gap: Array
    tension: Array
    bend: Array
    roll_slip: Array
    drum_slip: Array
    roll: Loaded
    drum: Loaded
    roll_loads: Tractions
    drum_loads: Tractions


@dataclass(frozen=True, eq=False)
class WrapLaws(WrapColumns):
    """The laws for one half width; bodies that are not linear are linearised about their loads."""

    about_roll: Tractions | None = None
    about_drum: Tractions | None = None

    @cached_property
    def roll(self) -> FaceLaws:
        """What the roll answers."""
        problem, grid = self.problem, self.grid
        return FaceLaws(
            problem, problem.roll, grid, grid.first, grid.size - 1, grid.last, self.half_width,
            self.about_roll,
        )  # fmt: skip

    @cached_property
    def drum(self) -> FaceLaws:
        """What the drum answers."""
        problem, grid = self.problem, self.grid
        return FaceLaws(
            problem, problem.drum, grid, 0, grid.last, grid.first, self.half_width, self.about_drum
        )

    @property
    def both(self) -> tuple[FaceLaws, FaceLaws]:
        """What roll and drum answer."""
        return self.roll, self.drum

    def at(self, z: Array, q: Array) -> Along:
        """Return what belongs to given z and q."""
        p, shift = z[:-1], float(z[-1])
        known = vars(self).get("_latest")  # of the step before, and for the certificate
        if known is None or not (np.array_equal(known[0], p) and np.array_equal(known[1], q)):
            known = vars(self)["_latest"] = p, q, self._unshifted(p, q)
        along: Along = known[2]
        return along._replace(gap=along.gap + shift)

    def _unshifted(self, p: Array, q: Array) -> Along:
        """Return the same without the shift."""
        problem, grid, web, a = self.problem, self.grid, self.web, self.half_width
        on_roll, on_drum = self.spread(p, q)
        roll, drum = self.roll.under(*on_roll), self.drum.under(*on_drum)
        both = on_roll.traction + on_drum.traction
        share = grid.share
        # a node's traction belongs half to the cell before it
        upto = np.cumsum(grid.weights * both)
        tension = problem.web_tension + a * (upto - both * np.append(grid.cells, 0.0) / 2)
        gap = self._closing(on_roll.pressure)
        nip = slice(grid.first, grid.last)
        gap += roll.slope[: gap.size] + drum.slope[nip]
        gap += web.c12 * (both[:-1] * (1 - share) + both[1:] * share)[nip]
        stretch = (a * web.c11 / problem.web.thickness) * (upto[:-1] - upto[-1])
        p = on_roll.pressure
        strain = stretch - web.c12 * (p[:-1] * (1 - share) + p[1:] * share)
        turn = grid.first + 1 if problem.roll.rigid else grid.last
        return Along(
            gap, tension, np.concatenate([-drum.bend[:turn], roll.bend[turn - grid.first :]]),
            strain[grid.first :] + web.c12 * p[-1] - (roll.strain[:-1] - roll.strain[-1]),
            strain[: grid.last] - drum.strain[:-1],
            roll, drum, on_roll, on_drum,
        )  # fmt: skip

    def surfaces(self, on_roll: Tractions, on_drum: Tractions) -> tuple[Surface, Surface]:
        """Return the surfaces under loads, as the losses take them."""
        return self.roll.surface(*on_roll), self.drum.surface(*on_drum)

    def spread(self, p: Array, q: Array) -> tuple[Tractions, Tractions]:
        """Return the loads of roll and drum on all nodes, zero where a face has none."""
        fields, n_p, n_q = np.zeros((4, self.grid.size)), self.roll_nodes.size, self.roll_q.size
        fields[0, self.roll_nodes], fields[1, self.drum_nodes] = p[:n_p], p[n_p:]
        fields[2, self.roll_q], fields[3, self.drum_q] = q[:n_q], q[n_q:]
        return Tractions(fields[0], fields[2]), Tractions(fields[1], fields[3])

    def balance(self, along: Along) -> Array:
        """Return what is left of p+ = p- + T kappa at the nodes, (N+1,)."""
        weight = np.where(self.weighs, along.tension * along.bend, 0.0)
        return np.asarray(along.roll_loads.pressure - along.drum_loads.pressure - weight)

    def _closing(self, p: Array) -> Array:
        """Return what the web leaves of the gap's slope in the nip's cells."""
        problem, grid, a = self.problem, self.grid, self.half_width
        cells, nip = slice(grid.first, grid.last), slice(grid.first, grid.last + 1)
        known = np.zeros(1) if self.about_roll is None else self.about_roll.pressure[nip]
        thinned, by_p = problem.web.thinned(np.maximum(known, 0.0))
        thinner = thinned + by_p * (p[nip] - np.maximum(known, 0.0))
        miss = -grid.points[cells] * (a / problem.contact_radius)
        return np.asarray(miss - np.diff(thinner) / (a * grid.cells[cells]))
