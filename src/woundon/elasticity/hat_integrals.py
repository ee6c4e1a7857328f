"""Integrals of influence functions against piecewise linear tractions.

A traction on the nodes s_0 < ... < s_n is a sum of nodal hat functions; those of the end nodes have
one half.  For an influence function k and a point y the integrals  int k(y - s) hat_m(s) ds  are
needed.  The singular parts 1/t, Dirac(t), ln|t| and sgn(t) are integrated in closed form, smooth
functions by Gauss's rule, and functions with a known second integral K'' = k by second differences.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from .mesh import hat_weights
from .quadrature import gauss_rule

__all__ = ["SourceRule", "by_second_integral", "gauss_rule_in_cells", "singular_integrals"]

Array = np.ndarray

# Ratio of a cell to its distance below which the difference of two logarithms is taken as log1p.
LOG1P_BELOW = 0.2
# A cell has three Gauss points for each length on which the function varies, at most MAX_POINTS.
MAX_POINTS = 150


def singular_integrals(points: Array, nodes: Array) -> Array:
    """Integrate 1/t, Dirac(t), ln|t| and sgn(t), t = y - s, against all hats.

    Parameters
    ----------
    points : (k,) array
        y.  A value at a node where 1/t is singular is large, but finite.
    nodes : (n,) array

    Returns
    -------
    (4, k, n) array
        1/t as Cauchy principal value.

    Notes
    -----
    For a cell of length h with the middle at the distance d = y - s_m, t0 and t1 the distances of
    its ends and L = ln|t0/t1|,

        int ds/t                = L             int (s - s_m) ds/t       = d L - h
        int ln|t| ds            = d L + h (ln|t0| + ln|t1|)/2 - h
                                                int (s - s_m) ln|t| ds   = [d (d L - h) - h^2 L/4]/2

    and a hat is 1/2 +- (s - s_m)/h in its two cells.  The integrals of Dirac(t) are the values of
    the hats at y, and those of sgn(t) are their integrals left of y minus those right of y.
    """
    t, h = points[:, None] - nodes, np.diff(nodes)
    out = np.empty((4, *t.shape))
    logs = np.log(np.maximum(np.abs(t), 1e-300))
    d = (t[:, :-1] + t[:, 1:]) / 2
    L = logs[:, :-1] - logs[:, 1:]
    with np.errstate(divide="ignore"):
        ratio = h / t[:, 1:]
    np.log1p(ratio, out=L, where=np.abs(ratio) < LOG1P_BELOW)
    # 1/t: L and d L - h
    moment_1 = d * L - h
    _hats_from_moments(out[0], L / 2, moment_1 / h)
    # ln|t|: d L - h + h (ln|t0| + ln|t1|)/2 and [d (d L - h) - h^2 L/4]/2, by operations in place,
    # because these matrices take most of the time of a new mesh
    moment_0 = logs[:, :-1] + logs[:, 1:]
    moment_0 *= h / 2
    moment_0 += moment_1
    moment_1 *= d
    L *= h**2 / 4
    moment_1 -= L
    moment_0 /= 2
    moment_1 /= 2 * h
    _hats_from_moments(out[2], moment_0, moment_1)
    _integrate_dirac_and_sign(out[1], out[3], t, points, nodes)
    return out


def _hats_from_moments(out: Array, moment_0: Array, moment_1: Array) -> None:
    """Write integrals against the hats, (k, n), from moments of the cells, (k, n - 1).

    ``moment_0`` is half the integral of the function over a cell, ``moment_1`` that of its product
    with (s - s_m)/h: their difference belongs to the left node, their sum to the right one.
    ``moment_0`` is overwritten.
    """
    np.subtract(moment_0, moment_1, out=out[:, :-1])
    out[:, -1] = 0.0
    moment_0 += moment_1
    out[:, 1:] += moment_0


def _integrate_dirac_and_sign(
    dirac: Array, sign: Array, t: Array, points: Array, nodes: Array
) -> None:
    """Write the integrals of Dirac(t) and sgn(t), t = y - s, against the hats.

    At the fraction f of its cell, of length h, y divides the hats of both ends: (1 - f)^2 h/2 of
    the left one and (1 - f^2) h/2 of the right one are beyond y, where sgn(t) = -1.

    Parameters
    ----------
    dirac, sign : (k, n) arrays
        Are overwritten.
    t : (k, n) array
    points, nodes : (k,) and (n,) arrays
    """
    h = np.diff(nodes)
    dirac[:] = 0.0
    # hats on one side of y: plus or minus their integral
    np.multiply(np.sign(t), hat_weights(h), out=sign)
    # the two hats of the cell that contains y
    k = np.nonzero((points >= nodes[0]) & (points <= nodes[-1]))[0]
    cell = np.clip(np.searchsorted(nodes, points[k]) - 1, 0, h.size - 1)
    fraction, padded = (points[k] - nodes[cell]) / h[cell], np.concatenate([[0.0], h, [0.0]])
    dirac[k, cell], dirac[k, cell + 1] = 1 - fraction, fraction
    sign[k, cell] = padded[cell] / 2 + h[cell] * (2 * fraction - fraction**2 - 0.5)
    sign[k, cell + 1] = h[cell] * (fraction**2 - 0.5) - padded[cell + 2] / 2


def by_second_integral(
    K: Callable[[Array], Array],
    K_slope: Callable[[Array], Array] | None,
    points: Array,
    nodes: Array,
) -> Array:
    """Integrate influence functions k = K'' against hats by second differences of K (exact).

    Parameters
    ----------
    K : callable
        t -> K(t), (..., k, n) for t (k, n).
    K_slope : callable or None
        t -> K'(t), (..., k) for t (k,); if None, the columns of the end nodes are zero.
    points, nodes : arrays
        [m].

    Returns
    -------
    (..., k, n) array
    """
    t = points[:, None] - nodes
    slopes = np.diff(K(t), axis=-1) / np.diff(nodes)
    if K_slope is None:
        out = np.zeros((*slopes.shape[:-1], nodes.size))
        out[..., 1:-1] = np.diff(slopes, axis=-1)
        return out
    start, end = (-np.asarray(K_slope(points - node))[..., None] for node in nodes[[0, -1]])
    return np.diff(np.concatenate([start, slopes, end], axis=-1), axis=-1)


class SourceRule(NamedTuple):
    """Integration of a function against hat functions, from its values at some points.

    Attributes
    ----------
    points : (g,) array
        In units of a.
    moments : (g, n) array
        Values (..., g) @ moments -> integrals against the hats of n nodes, (..., n) [m].
    """

    points: Array
    moments: Array


def gauss_rule_in_cells(nodes: Array, a: float, length: float) -> SourceRule:
    """Return Gauss's rule in the cells between nodes, for functions that vary on a length.

    Parameters
    ----------
    nodes : (n,) array
        In units of a.
    a, length : float
        Half width, and the length on which the functions vary [m].
    """
    cells = np.diff(nodes)
    ratio = a * cells / length
    # the function is constant in a cell that is much shorter than the length
    orders = np.where(ratio < 0.01, 1, 2 + np.minimum(3 * ratio, MAX_POINTS).astype(int))
    cell, fraction, weight = _points_in_cells(orders.tobytes())  # bytes can be keys of the cache
    weight = weight * (cells[cell] * a)
    # a point contributes to the hats of both ends of its cell, by their values there
    moments, point = np.zeros((cell.size, nodes.size)), np.arange(cell.size)
    moments[point, cell], moments[point, cell + 1] = weight * (1 - fraction), weight * fraction
    return SourceRule(nodes[cell] + cells[cell] * fraction, moments)


@lru_cache(maxsize=64)
def _points_in_cells(orders: bytes) -> tuple[Array, Array, Array]:
    """Return the cell of each Gauss point, its position there from 0 to 1, and its weight.

    ``orders`` are the bytes of an integer array: the number of points of each cell.  The weights
    of a cell have the sum 1.
    """
    counts = np.frombuffer(orders, dtype=int)
    rules = [gauss_rule(n) for n in counts.tolist()]
    points, weights = (np.concatenate(parts) for parts in zip(*rules, strict=True))
    return np.repeat(np.arange(counts.size), counts), (points + 1) / 2, weights / 2
