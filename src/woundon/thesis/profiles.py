"""Nips along x: what Figs. 15, 20, 25 and 30 show, as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..results import NipResult
from .frame import Table

__all__ = ["profiles"]

Array = np.ndarray


def profiles(results: Sequence[tuple[Mapping[str, float], NipResult]]) -> Table:
    """Return the solved nips node by node; the columns of parameters tell which is which.

    Parameters
    ----------
    results : sequence of (parameters, NipResult)
        Parameters by name with unit, the same names for every result.
    """
    blocks: list[Table] = []
    for parameters, r in results:
        ones = np.ones(r.x.size)
        columns: dict[str, Array] = {name: value * ones for name, value in parameters.items()}
        columns |= {
            "x [m]": r.x,
            "pressure [Pa]": r.pressure,
            "roll_traction [Pa]": r.roll_traction,
            "drum_traction [Pa]": r.drum_traction,
            "slip_x [m]": r.slip_x,
            "roll_slip [1]": r.roll_slip,
            "drum_slip [1]": r.drum_slip,
            "tension_increase [N/m]": r.web_tension - r.problem.web_tension,
            "roll_zone [1]": r.roll_zone,
            "drum_zone [1]": r.drum_zone,
        }
        blocks.append(Table.of(columns))
    table = blocks[0]
    for block in blocks[1:]:
        table = table.stacked(block)
    return table
