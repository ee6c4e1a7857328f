r"""Isotropic viscoelasticity: from relaxation to retardation.

Young's modulus of a Prony series, with e^{ikx} of a surface that rolls along +x past a fixed load,

    E(ik) = E_inf [1 + sum_k g_k ik c_k/(1 + ik c_k)],      g_k = E_k/E_inf,  c_k = V tau_k,

depends on the speed V only through the lengths c_k that the surface moves within the relaxation
times tau_k.  With a constant Poisson's ratio all moduli are proportional to it.  Its inverse, the
creep compliance, is a sum of as many terms,

    E_inf/E(ik) = j_0 + sum_m j_m/(1 + ik l_m),      j_0 = E_inf/E_0,   j_0 + sum_m j_m = 1,

and E(ik) = 0 at ik = -1/l_m.  One retardation length l_m lies between each two neighbouring c_k,
and one above the largest (a secular equation); they are found by repeated subdivision of these
intervals.

With a constant bulk modulus K the series is that of the shear modulus G.  The compliance of the
surface in plane strain then has two parts with a creep of their own.  All powers of 1/n of a
cylinder, and the half-plane, are combinations of (1 - nu)/G and (1 - 2 nu)/(2 G), and with
nu = (3K - 2G)/(2 (3K + G)),

    (1 - nu)/G = 1/(2 G) + b,      (1 - 2 nu)/(2 G) = b,      b = 3/(2 (3K + G)),

so that one part, that of the incompressible material with the same G, creeps as 1/G, the rest as
1/(3K + G), whose modulus is a Prony series with the terms g_k G/(3K + G) and the same c_k.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

__all__ = [
    "Creep",
    "Relaxation",
    "bulk_relaxation",
    "creep",
    "incompressible",
    "modulus_ratio",
]

Array = np.ndarray
Relaxation = tuple[tuple[float, float], ...]  # (g_k, c_k), empty for an elastic material
# A_rr/G of an incompressible material: 1/A_rr is below the rounding error of every sum
INCOMPRESSIBLE = 1e20
# An interval of ln l is divided into 16 parts, 16 times, so that the error is due to rounding also
# if c_k differ by a factor of 1e30.
SUBDIVISIONS = 16
PARTS = np.arange(17) / 16


class Creep(NamedTuple):
    """Creep compliance times E_inf: instantaneous j_0; delayed j_m, lengths l_m [m], (K,)."""

    instantaneous: float
    delayed: Array
    length: Array


def modulus_ratio(relaxation: Relaxation, k: Array) -> Array:
    """Return E(ik)/E_inf = 1 + sum_m g_m i k c_m/(1 + i k c_m), complex, at k [1/m]."""
    out = np.ones(np.shape(k), dtype=complex)
    for g, c in relaxation:
        z = 1j * np.asarray(k) * c
        out += g * z / (1 + z)
    return out


def bulk_relaxation(A_rt: float, G: float, relaxation: Relaxation) -> Relaxation:
    """Return the relaxation of 3K + G of an isotropic material with a constant bulk modulus K.

    Parameters
    ----------
    A_rt, G : float
        After all relaxation [Pa]; 3K + G = 3 (A_rt + G).
    relaxation : tuple of (g_k, c_k)
        Of the shear modulus.
    """
    return tuple((g * G / (3 * (A_rt + G)), c) for g, c in relaxation)


def incompressible(G: float) -> tuple[float, float, float, float, float]:
    """Return the stiffness A_rr, A_tt, A_rt, G, D of an incompressible material [Pa]."""
    direct = INCOMPRESSIBLE * G
    return direct, direct, direct, G, 4 * G


@lru_cache(maxsize=64)
def creep(relaxation: Relaxation) -> Creep:
    """Return the creep compliance of a Prony series.

    The retardation lengths l_m are the roots of the secular equation.  The residue of 1/E(ik) at
    ik = -1/l_m gives j_m = 1/(d(E/E_inf)/d ln l) at l = l_m.
    """
    # terms with the same relaxation time are added, those that do not relax are left out
    series: dict[float, float] = {}
    for g_k, c_k in relaxation:
        if g_k > 0 and c_k > 0:
            series[c_k] = series.get(c_k, 0.0) + g_k
    c = np.array(sorted(series))
    g = np.array([series[c_k] for c_k in sorted(series)])
    instantaneous = float(1 / (1 + g.sum()))
    if not c.size:
        return Creep(instantaneous, c, c)
    # E(ik) at ik = -1/l is 1 - sum g/(l/c - 1).  It increases with l between two neighbouring c,
    # and above the largest, where it is positive at l = c (1 + sum g).
    low, high = c.copy(), np.append(c[1:], c[-1] * (1 + g.sum()))
    rows = np.arange(c.size)
    with np.errstate(divide="ignore"):  # E is infinite at l = c, the ends of the intervals
        for _ in range(SUBDIVISIONS):
            trial = low[:, None] * (high / low)[:, None] ** PARTS
            trial[:, -1] = high  # without rounding
            is_below = 1 - (1 / (trial[:, 1:-1, None] - c)) @ (g * c) < 0
            k = is_below.sum(axis=1)  # the part of each interval in which E changes its sign
            low, high = trial[rows, k], trial[rows, k + 1]
        length = np.sqrt(low * high)
        derivative = (g * c * length[:, None] / (length[:, None] - c) ** 2).sum(axis=1)
    return Creep(instantaneous, 1 / derivative, length)
