"""Grids of the wrapped nips that woundon 0.1 saved, so that their files certify."""

from __future__ import annotations

import numpy as np

from ..contact.grid import Grid
from ..problems.nip import WrappedNipProblem
from .grid import Arc, WrapGrid, graded, joined, lengths

__all__ = ["grid_of_0_1"]

FINE, POWER, EVENNESS = 0.2, 2.0, 3.0  # see graded


def grid_of_0_1(
    problem: WrappedNipProblem, nip: Grid, a: float, drum_cells: int, roll_cells: int
) -> WrapGrid:
    """Return a problem's grid for the half width a [m]."""
    drum, roll = lengths(problem, a)
    return joined(nip, _arc(drum, drum_cells, True), _arc(roll, roll_cells, False))


def _arc(length: float, cells: int, entry: bool) -> Arc:
    """Return an arc; of one with an entry at the far side, half the cells are graded to it."""
    if length == 0:
        return Arc.of(length, cells, entry)
    if not entry:
        return Arc(graded(length, cells, FINE, POWER, EVENNESS), 0, length)
    half = graded(length / 2, max(cells // 2, 2), FINE, POWER, EVENNESS)
    return Arc(np.concatenate([half, (length - half)[-2::-1]]), 0, length)
