"""A wound roll as a linear body: layers with the tangent moduli at the wound-in pressure P0(r).

The moduli vary with y = ln(r/R).  The roll is divided into cells, and each cell into two
homogeneous layers (:mod:`woundon.elasticity.layers`) by a commutator-free Magnus method of fourth
order.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import log, sqrt

import numpy as np

from ..elasticity import cylinder
from ..elasticity.kernels import SurfaceKernels
from ..elasticity.layers import Layers, stacked_compliance
from .schedules import Profile, at_radius
from .stack import Stack

__all__ = ["graded_layers", "wound_kernels"]

Array = np.ndarray

# Cells over the relative depth ln(R/r)/ln(R/R0): smallest and largest thickness, and the ratio of
# thickness to depth between them.
THINNEST, THICKEST, RELATIVE_THICKNESS = 3e-4, 0.04, 0.12


def graded_layers(
    radius: float, core_radius: float, stack: Stack, pressure: float | Profile, parts: int = 1
) -> Layers:
    """Return homogeneous layers that approximate a roll at its wound-in pressure.

    Each is ln(outer/inner radius) and A_rr, A_tt, A_rt, G [Pa], and D = A_tt - A_rt^2/A_rr unless
    the pressure is uniform; the outermost first.

    A cell of the depth is replaced by two layers, the commutator-free Magnus method of fourth order
    (Blanes and Moan 2006, two exponentials): the coefficients of the equations, which are 1/A_rr,
    1/G, A_rt/A_rr and D, are averages of their values at the two Gauss points, with the weights
    1/2 +- 1/sqrt(3).

    Parameters
    ----------
    radius, core_radius : float
        R and R0 [m].
    stack : Stack
    pressure : float or Profile
        P0 wound into the roll [Pa].
    parts : int
        Number of parts into which every cell is divided.
    """
    # the moduli at the pressure P, and the shear modulus at the wound-in pressure, are at the same
    R, depth = radius, log(radius / core_radius)
    if not isinstance(pressure, Profile):
        return ((depth, *map(float, stack.tangent(pressure, pressure)[:4])),)
    # relative depths ln(R/r)/ln(R/R0)
    ends = _cell_boundaries([log(R / r) / depth for r in pressure.radius if core_radius < r < R])
    ends = np.append((ends[:-1, None] + np.diff(ends)[:, None] * np.arange(parts) / parts), 1.0)
    cells = np.diff(ends)
    gauss = ends[:-1, None] + cells[:, None] * (0.5 + np.array([-0.5, 0.5]) / sqrt(3))
    P = at_radius(pressure, R * np.exp(-depth * gauss))
    A_rr, A_tt, A_rt, G = np.broadcast_arrays(*stack.tangent(P, P)[:4])
    w_near, w_far = 0.5 + 1 / sqrt(3), 0.5 - 1 / sqrt(3)
    average = np.array([[w_near, w_far], [w_far, w_near]])  # two Gauss points to two layers
    coefficients = (1 / A_rr, 1 / G, A_rt / A_rr, A_tt - A_rt**2 / A_rr)
    c_rr, c_G, a, D = ((values @ average).ravel() for values in coefficients)
    layers = np.repeat(depth * cells / 2, 2), 1 / c_rr, D + a * a / c_rr, a / c_rr, 1 / c_G, D
    return tuple(map(tuple, np.transpose(layers).tolist()))


def _cell_boundaries(kinks: list[float]) -> Array:
    """Return relative depths from 0 to 1, ascending: kinks of the pressure, and cells that grow.

    The cells are small near the surface, because short waves decay within a short depth.
    """
    boundaries = [0.0, *kinks]
    depth = THINNEST
    while depth < 1:
        boundaries.append(depth)
        depth += min(max(RELATIVE_THICKNESS * depth, THINNEST), THICKEST)
    return np.append(np.unique(boundaries), 1.0)


@lru_cache(maxsize=16)
def wound_kernels(
    radius: float, core_radius: float, stack: Stack, pressure: float | Profile
) -> SurfaceKernels:
    """Return the influence functions of a roll linearised at its wound-in pressure.

    Their truncation error includes that of the layers.  Parameters as of :func:`graded_layers`.
    """
    layers = graded_layers(radius, core_radius, stack, pressure)
    kernels = cylinder.layered_kernels(radius, layers)
    if len(layers) == 1:
        return kernels
    halved = graded_layers(radius, core_radius, stack, pressure, parts=2)
    error = max(kernels.truncation_error, _relative_change(layers, halved))
    return replace(kernels, truncation_error=error)


def _relative_change(layers: Layers, halved: Layers) -> float:
    """Return the relative change of the response to a line load when every cell is halved."""
    n = np.geomspace(2, 6000, 60)  # wave lengths 2 pi R/n down to a thousandth of the radius
    # The factor n: a sum over n of Y_n is an integral over ln n of n Y_n.
    coarse, fine = (n * stacked_compliance(n, each) for each in (layers, halved))  # (2, 2, n)
    # sums over the harmonics, and the largest of the 2 x 2 entries
    return float(np.abs(fine - coarse).sum(axis=-1).max() / np.abs(fine).sum(axis=-1).max())
