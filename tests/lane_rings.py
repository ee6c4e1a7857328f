"""Independent program for gauge profiles: lanes wound layer by layer from finite rings.

Every lane j of the web has the share w_j of the width, the thickness h_j and the slack b_j.  All
lanes have the same number of layers and the same core.  With the pressures P_i, P_(i+1) on the
inner and the outer face of ring i, at the radii q_i, q_(i+1) at which it was laid,

    hoop stress       sigma_i = (P_i q_i - P_(i+1) q_(i+1))/h
    hoop strain       e_i = (sigma_i - T_i + nu (Pm_i - Pm_i as laid))/E_t,    Pm mean pressure
    position          X_i = m_i (1 + e_i),    m_i the radius as laid
    thickness         t_i = h (1 - F(Pm_i) - nu sigma_i/E_t)
    closure           X_(i+1) - X_i = (t_i + t_(i+1))/2
    core              X_0 - t_0/2 = r_c (1 - P_0/E_c)

are solved by Newton's method with a tridiagonal matrix for every layer, all lanes at once.  The
tension of the next layer follows from the surface radii s_j of the lanes,

    web               sigma_j = E_t max(0, e0 + s_j/s - 1 - b_j),    sum w_j h_j sigma_j = T_in
    nip (optional)    P_j = P(delta + s_j - s),                      sum w_j P_j = N
    wound on          T_j h_j = sigma_j h_j + A(P_j)

with s = sum w_j s_j.  The program shares no code with woundon, neither C(r) nor kappa, and takes
one layer after another, explicit in the radii.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack
from scipy.optimize import brentq

Array = np.ndarray


@dataclass
class Nip:
    """A nip across the lanes: load P(d) of a lane for its approach d, >= 0, and the added tension.

    Attributes
    ----------
    load_at, approach_at : callable
        P [N/m] of the approach [m], and the reverse.
    added : callable
        A(P), tension that the nip adds [N/m].
    total : float
        N [N/m].
    """

    load_at: Callable[[Array], Array]
    approach_at: Callable[[float], float]
    added: Callable[[Array], Array]
    total: float


@dataclass
class Rolls:
    """The lanes of a roll after the last layer.

    Attributes
    ----------
    laid : (N, L) array
        Radius of the surface on which each layer was laid [m].
    tension : (N, L) array
        Wound-on stress T of each layer [Pa].
    web : (N, L) array
        sigma, its part that the web had upstream of the nip [Pa].
    load : (N, L) array
        Nip load of each lane [N/m]; zero without a nip.
    radius, pressure : (N, L) arrays
        Inner radius of each layer as laid [m], pressure there [Pa].
    surface : (L,) array
        Radius of the surface [m].
    """

    laid: Array
    tension: Array
    web: Array
    load: Array
    pressure: Array
    surface: Array

    @property
    def radius(self) -> Array:
        return self.laid


def wind_lanes(
    *,
    K1: float,
    K2: float,
    E_t: float,
    nu: float,
    thickness: float,
    excess: Array,
    share: Array,
    core: float,
    core_stiffness: float,
    tension: float,
    layers: int,
    until: float = np.inf,
    slack: Array | None = None,
    nip: Nip | None = None,
) -> Rolls:
    """Wind lanes layer by layer; Pfeiffer's law F = ln(1 + P/K1)/K2.

    Parameters
    ----------
    excess, share, slack : (L,) arrays
        d_j, w_j (sum 1) and b_j.
    tension : float
        T_in, the mean web tension [N/m].
    layers : int
        N.
    until : float
        Mean radius of the surface [m] at which the roll ends, if it is reached before N layers.
    """
    d, w = np.asarray(excess, dtype=float), np.asarray(share, dtype=float)
    b = np.zeros(d.size) if slack is None else np.asarray(slack, dtype=float)
    h, L = thickness * (1 + d), d.size
    shape = (layers, L)
    q = np.zeros((layers + 1, L))  # radii of the faces as laid
    middle, T, as_laid = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    web, load = np.zeros(shape), np.zeros(shape)
    P = np.zeros((layers + 1, L))
    surface = np.full(L, core)
    e0, delta = tension / thickness / E_t, 0.0

    def strains(P: Array, n: int) -> tuple[Array, Array, Array, Array]:
        """Return X, t, and the derivatives of the mean pressure in t, of the first n rings."""
        mean = (P[:-1] + P[1:]) / 2
        sigma = (P[:-1] * q[:n] - P[1:] * q[1 : n + 1]) / h
        X = middle[:n] * (1 + (sigma - T[:n] + nu * (mean - as_laid[:n])) / E_t)
        t = h * (1 - np.log1p(mean / K1) / K2 - nu * sigma / E_t)
        return X, t, 1 / (K2 * (K1 + mean)), sigma

    for n in range(layers):
        mean_surface = float(w @ surface)
        e0, sigma = _web(e0, surface / mean_surface - 1 - b, w * h, E_t, tension)
        web[n] = T[n] = sigma
        if nip is not None:
            delta, load[n] = _loads(delta, surface - mean_surface, w, nip)
            T[n] = sigma + nip.added(load[n]) / h
        q[n], P[n + 1] = surface, 0.0
        new = T[n] * h / q[n]  # pressure under the new layer
        if n:
            stack = P[: n + 1].copy()
            stack[:n] += new  # a first guess: the pressure of the layer, all the way down
            stack[n] = new
            for _ in range(50):
                X, t, F_P, _ = strains(stack, n)
                inner_X = middle[:n] * (q[:n] / h + nu / 2) / E_t
                outer_X = middle[:n] * (-q[1 : n + 1] / h + nu / 2) / E_t
                inner_t = h * (-F_P / 2 - nu * q[:n] / h / E_t)
                outer_t = h * (-F_P / 2 + nu * q[1 : n + 1] / h / E_t)
                # row k: closure below ring k; unknowns: pressures on the inner faces
                residual = np.empty((n, L))
                lower, main, upper = (np.zeros((n, L)) for _ in range(3))
                residual[0] = X[0] - t[0] / 2 - core * (1 - stack[0] / core_stiffness)
                main[0] = inner_X[0] - inner_t[0] / 2 + core / core_stiffness
                upper[0] = outer_X[0] - outer_t[0] / 2
                residual[1:] = X[1:] - X[:-1] - (t[:-1] + t[1:]) / 2
                lower[1:] = -inner_X[:-1] - inner_t[:-1] / 2
                main[1:] = inner_X[1:] - outer_X[:-1] - (inner_t[1:] + outer_t[:-1]) / 2
                upper[1:] = outer_X[1:] - outer_t[1:] / 2
                upper[-1] = 0.0  # the pressure under the new layer is known
                flat = [part.T.ravel() for part in (lower, main, upper, residual)]
                *_, step, info = lapack.dgtsv(flat[0][1:], flat[1], flat[2][:-1], flat[3])
                assert info == 0
                change = step.reshape(L, n).T
                # a pressure stays above -K1/2, where the law ends
                stack[:n] = np.maximum(stack[:n] - change, -K1 / 2)
                if np.max(np.abs(change)) <= 1e-9 * np.max(np.abs(stack)) + 1e-6:
                    break
            P[: n + 1] = stack
            X, t, *_ = strains(P[: n + 1], n)
            face = X[-1] + t[-1] / 2
        else:
            P[0] = new
            face = core * (1 - P[0] / core_stiffness)
        as_laid[n] = new / 2
        new_thickness = h * (1 - np.log1p(as_laid[n] / K1) / K2 - nu * T[n] / E_t)
        middle[n] = face + new_thickness / 2
        q[n + 1] = surface = face + new_thickness
        if float(w @ surface) >= until:
            layers = n + 1
            break
    return Rolls(q[:layers], T[:layers], web[:layers], load[:layers], P[:layers], surface)


def _web(
    e0: float, strain: Array, weight: Array, E_t: float, tension: float
) -> tuple[float, Array]:
    """Return e0 and the stresses of the lanes, by Newton's method on a piecewise linear sum."""
    for _ in range(100):
        stress = E_t * np.maximum(0.0, e0 + strain)
        missing = tension - weight @ stress
        slope = E_t * float(np.sum(weight[e0 + strain > 0]))
        if not slope:  # all slack: start with the longest lane taut
            e0 = -float(np.min(strain)) + 1e-9
            continue
        e0 += missing / slope
        if abs(missing) <= 1e-13 * tension:
            break
    return e0, E_t * np.maximum(0.0, e0 + strain)


def _loads(delta: float, height: Array, w: Array, nip: Nip) -> tuple[float, Array]:
    """Return the approach of a lane of mean height, and the loads of all lanes [N/m]."""
    mean = nip.approach_at(nip.total)
    width = float(np.ptp(height)) + 0.5 * mean

    def surplus(delta: float) -> float:
        return float(w @ nip.load_at(np.maximum(0.0, delta + height))) - nip.total

    delta = brentq(surplus, mean - width, mean + width, xtol=1e-18, rtol=1e-14)
    return delta, nip.load_at(np.maximum(0.0, delta + height))
