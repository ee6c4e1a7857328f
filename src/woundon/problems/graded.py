"""Wound rolls as linear bodies about the wound state."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import log, sqrt
from typing import TYPE_CHECKING

import numpy as np

from ..elasticity import cylinder
from ..elasticity.kernels import SurfaceKernels
from ..elasticity.layers import Layers, stacked_compliance
from .schedules import Profile

if TYPE_CHECKING:
    from .wound_roll import WoundRoll

__all__ = ["graded_layers", "wound_kernels"]

Array = np.ndarray

# of p_max: what a direct solution wants for the confined tension, 0.25 to 0.3 (docs, stacks)
SHARE = 0.3
STEP = 1e-4  # of p_max, for differences: their error is its square
# of a roll's depth ln(R/R0): the outermost cell, the thickest one, and the growth between
THINNEST, THICKEST, GROWTH = 3e-4, 0.04, 0.12


def graded_layers(roll: WoundRoll, parts: int = 1) -> Layers:
    """Return the layers of one modulus each that tell a roll under its wound pressure.

    The depth is cut into cells, fine near the surface, where short waves look, and each into so
    many ``parts``.  A cell is two layers, by the commutator-free Magnus method of fourth order
    (Blanes and Moan 2006, two exponentials): the coefficients of the equations, which are 1/A_rr,
    1/G, A_rt/A_rr and D, are averaged of those at Gauss's two points, weights 1/2 +- 1/sqrt(3).
    """
    R, depth = roll.radius, log(roll.radius / roll.core_radius)
    if not isinstance(roll.pressure, Profile):
        P = roll.wound_pressure(R)
        return ((depth, *map(float, roll.stack.tangent(P, P)[:4])),)
    marks = [0.0, *(log(R / r) / depth for r in roll.pressure.radius if roll.core_radius < r < R)]
    mark = THINNEST
    while mark < 1:
        marks.append(mark)
        mark += min(max(GROWTH * mark, THINNEST), THICKEST)
    ends = np.append(np.unique(marks), 1.0)
    ends = np.append((ends[:-1, None] + np.diff(ends)[:, None] * np.arange(parts) / parts), 1.0)
    cells = np.diff(ends)
    points = ends[:-1, None] + cells[:, None] * (0.5 + np.array([-0.5, 0.5]) / sqrt(3))
    P = roll.wound_pressure(R * np.exp(-depth * points))
    A_rr, A_tt, A_rt, G = np.broadcast_arrays(*roll.stack.tangent(P, P)[:4])
    near, far = 0.5 + 1 / sqrt(3), 0.5 - 1 / sqrt(3)
    average = np.array([[near, far], [far, near]])
    given = (1 / A_rr, 1 / G, A_rt / A_rr, A_tt - A_rt**2 / A_rr)
    c_rr, c_G, a, D = ((values @ average).ravel() for values in given)
    made = np.repeat(depth * cells / 2, 2), 1 / c_rr, D + a * a / c_rr, a / c_rr, 1 / c_G, D
    return tuple(map(tuple, np.transpose(made).tolist()))


@lru_cache(maxsize=16)
def wound_kernels(roll: WoundRoll) -> SurfaceKernels:
    """Return the influence functions of a roll linearised about its wound state.

    The error of cutting it into layers is that by which cells cut in two differ, in what a line
    load does below itself, told by waves down to a thousandth of the radius.
    """
    layers = graded_layers(roll)
    kernels = cylinder.layered_kernels(roll.radius, layers)
    if len(layers) == 1:
        return kernels
    n = np.geomspace(2, 6000, 60)
    coarse, fine = (n * stacked_compliance(n, graded_layers(roll, parts)) for parts in (1, 2))
    # of sums over n, which are integrals over ln n of n Y_n
    error = np.max(np.abs(fine - coarse).sum(axis=-1)) / np.max(np.abs(fine).sum(axis=-1))
    return replace(kernels, truncation_error=max(kernels.truncation_error, float(error)))
