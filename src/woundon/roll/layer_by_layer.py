"""The published layer-by-layer scheme: a sum of pressure increments (Hakiel 1987).

A layer of thickness h, wound at the radius s with the stress T, adds to the pressure P of the
layers below the increment p with

    r^2 p'' + 3 r p' + (1 - E_t/E_r(P)) p = 0,    p = T h/s at s,    r_c p' = b p at the core,

discretised by central differences on the layers, with the moduli at P without the increment.  Then
P += p.  The scheme is of order one in h: with groups of layers its error is large; with single
layers the effect of their thickness is included.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.linalg import lapack

__all__ = ["wind_layers"]

Array = np.ndarray


def wind_layers(
    modulus: Callable[[Array], Any], tangential: float, core: float, r: Array, T: Array
) -> Array:
    """Return the pressure below every layer, (n + 1,) [Pa], zero at the surface.

    Parameters
    ----------
    modulus : callable
        E_r(P) [Pa].
    tangential : float
        E_t [Pa].
    core : float
        b = E_t/E_c - 1 + nu.
    r : (n + 1,) array
        Inner radii of n layers, then the surface, equidistant [m].
    T : (n + 1,) array
        Wound-on stress there [Pa].
    """
    h = float(r[1] - r[0])
    P = np.zeros(r.size)
    second = r**2 / h**2
    below, above = second - 1.5 * r / h, second + 1.5 * r / h
    for layer in range(r.size - 1):
        inner = slice(0, layer + 1)
        diagonal = -2 * second[inner] + 1 - tangential / modulus(P[inner])
        load = T[layer] * h / r[layer]
        if layer == 0:  # on the core
            P[0] += load
            continue
        lower, upper = below[1 : layer + 1].copy(), above[:layer].copy()
        # the core condition by a node inside the core: p_1 - p_-1 = 2 h b p_0/r_c
        diagonal[0] -= 2 * h * core / r[0] * below[0]
        upper[0] += below[0]
        lower[-1], diagonal[-1] = 0.0, 1.0  # the last equation: p = T h/s below the new layer
        right = np.zeros(layer + 1)
        right[-1] = load
        # tridiagonal system; the four numbers permit to overwrite the four arrays
        *_, p, info = lapack.dgtsv(lower, diagonal, upper, right, 1, 1, 1, 1)
        if info != 0:
            raise ArithmeticError("an increment has no solution")
        P[inner] += p
    return P
