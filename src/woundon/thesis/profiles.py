"""Nips along x: what Figs. 15, 20, 25 and 30 show, as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..results import NipResult
from .frame import Table

__all__ = ["profiles", "squeezed"]

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


def squeezed(r: NipResult) -> tuple[float, float]:
    """Compare the fall of the tension where the web sticks to a rigid drum with Poisson's effect.

    There the web cannot stretch, so that T falls by 2h (A_rt/A_rr) times the rise of p.

    Parameters
    ----------
    r : NipResult

    Returns
    -------
    share : float
        The fall to the lowest tension over that, from where the web first sticks.
    begins : float
        Where it does, as a share of the nip's width.
    """
    low = int(np.argmin(r.web_tension))
    slips = np.flatnonzero(r.drum_zone[:low] != 0)
    first = int(slips[-1]) + 1 if slips.size else 0
    paper, thickness = r.problem.web.material.stiffness, r.problem.web.thickness
    rise = float(r.pressure[low] - r.pressure[first])
    fall = float(r.web_tension[first] - r.web_tension[low])
    begins = float(r.x[first] / r.half_width + 1) / 2
    return fall / (thickness * paper.rt / paper.rr * rise), begins
