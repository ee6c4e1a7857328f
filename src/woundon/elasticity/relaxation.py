r"""Isotropic viscoelasticity of constant Poisson's ratio: from relaxation to retardation.

Young's modulus of a Prony series, with e^{ikx} of a surface that rolls along +x past a fixed load,

    E(ik) = E_inf [1 + sum_k g_k ik c_k/(1 + ik c_k)],      g_k = E_k/E_inf,  c_k = V tau_k,

sees the frequency kV only in lengths: those that the surface moves in its relaxation times.  All
moduli are in proportion to it.  Its inverse, the creep compliance, is a sum of as many terms,

    E_inf/E(ik) = j_0 + sum_m j_m/(1 + ik l_m),      j_0 = E_inf/E_0,   j_0 + sum_m j_m = 1,

whose retardation lengths l_m are the zeros of E, one between each two neighbouring c_k and one
beyond the longest: the secular equation of a diagonal matrix and one of rank one.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

__all__ = ["Creep", "Relaxation", "creep", "factor"]

Array = np.ndarray
Relaxation = tuple[tuple[float, float], ...]  # (g_k, c_k), empty where elastic
SIXTEENTHS = 16  # of ln l, each of the one before: lengths a factor 1e30 apart to rounding
PARTS = np.arange(17) / 16


class Creep(NamedTuple):
    """The creep compliance over 1/E_inf: j_0, and arrays j_m and l_m [m], (K,) each."""

    at_once: float
    share: Array
    length: Array


def factor(relaxation: Relaxation, k: Array) -> Array:
    """Return E(ik)/E_inf at the wave numbers k [1/m], complex."""
    out = np.ones(np.shape(k), dtype=complex)
    for g, c in relaxation:
        z = 1j * np.asarray(k) * c
        out += g * z / (1 + z)
    return out


@lru_cache(maxsize=64)
def creep(relaxation: Relaxation) -> Creep:
    """Return the creep compliance of a Prony series."""
    series: dict[float, float] = {}
    for share, relaxed in relaxation:
        if share > 0 and relaxed > 0:
            series[relaxed] = series.get(relaxed, 0.0) + share
    c = np.array(sorted(series))
    g = np.array([series[known] for known in sorted(series)])
    at_once = float(1 / (1 + g.sum()))
    if not c.size:
        return Creep(at_once, c, c)
    # E(ik) at ik = -1/l: 1 - sum g/(l/c - 1) rises from one c to the next, and beyond the last,
    # where it is positive at l = c (1 + sum g)
    low, high = c.copy(), np.append(c[1:], c[-1] * (1 + g.sum()))
    amounts, each = g * c, np.arange(c.size)
    with np.errstate(divide="ignore"):
        for _ in range(SIXTEENTHS):
            between = low[:, None] * (high / low)[:, None] ** PARTS
            between[:, -1] = high
            short = 1 - (1 / (between[:, 1:-1, None] - c)) @ amounts < 0
            last = short.sum(axis=1)
            low, high = between[each, last], between[each, last + 1]
        length = np.sqrt(low * high)
        steep = (g * c * length[:, None] / (length[:, None] - c) ** 2).sum(axis=1)
    return Creep(at_once, 1 / steep, length)
