"""Influence functions of a linear elastic, orthotropic cylinder of layers on a core (sec. 2.2).

The n-th harmonics of displacements w and tractions t of the surface are related by its compliance,
w = Y_n t at r = R (:mod:`.layers`).  On a rigid core it contains the characteristic sequences of
the thesis (57),

    R Y_n = [[ gamma_1, -gamma_2],
             [-chi_1,    chi_2  ]],        symmetric by Betti's theorem.

The influence functions are Fourier sums over n.  Short waves decay within the outermost layer: for
large n its Y_n solves the algebraic Riccati equation F Y + Y F' + N - Y K Y = 0, and the terms of
its solution in powers of 1/n are summed in closed form (:mod:`.fourier`).
"""

from __future__ import annotations

from functools import lru_cache
from math import log, log1p, pi, sqrt
from typing import NamedTuple

import numpy as np

from .fourier import HarmonicSum, HarmonicSums
from .half_plane import coefficients
from .kernels import SurfaceKernels
from .layers import Layers, LayerSystems, RelaxingModuli, stacked_compliance
from .relaxation import incompressible
from .strip import stiffness_along

__all__ = [
    "Sequences",
    "asymptotic_compliance",
    "depth",
    "layered_kernels",
    "sequences",
    "surface_compliance",
    "surface_kernels",
]

Array = np.ndarray
Stiffness = tuple[float, float, float, float, float | None]  # A_rr, A_tt, A_rt, G, D

MAX_TERMS = 1 << 18  # of a sum: the memory of its Fourier transform is a few megabytes
MAX_LAYERED_TERMS = 1 << 16  # shortest wave: a ten-thousandth of the radius
TOLERANCE = 1e-12  # of the sums, relative to their leading term
HIGHEST_POWER = 6  # of 1/n, summed in closed form
# More than MAX_DIRECT harmonics are interpolated from FIRST_SAMPLED on, where n Y_n is a smooth
# function of ln n, known to ROUNDING.
MAX_DIRECT, FIRST_SAMPLED = 2048, 64
ROUNDING = 1e-13  # error of n Y_n by the interpolation
MAX_REMAINDER = 1e-9  # of n Y_n at the last harmonic; else the outer layer is too thin for a series


class Sequences(NamedTuple):
    """The characteristic sequences of a cylinder's surface [m/Pa] (thesis eq. 57)."""

    gamma_1: Array
    gamma_2: Array
    chi_1: Array
    chi_2: Array


def sequences(
    n: Array,
    radius: float,
    core_radius: float,
    A_rr: float,
    A_tt: float,
    A_rt: float,
    G: float,
    D: float | None = None,
) -> Sequences:
    """Return the characteristic sequences gamma_n1, gamma_n2, chi_n1, chi_n2 [m/Pa].

    Parameters
    ----------
    n : array_like of int
        Harmonics, >= 0; for n = 0 gamma_1 is gamma_0, chi_2 is chi_0, and the others are zero.
    radius, core_radius : float
        R and R0 [m], 0 < R0 < R.
    A_rr, A_tt, A_rt, G : float
        Plane-strain stiffness [Pa].
    D : float, optional
        As of :func:`.strip.stiffness_along`, if it is known more accurately.

    Notes
    -----
    Thesis eq. (57): a pressure c cos(n theta) moves the surface by -gamma_1 c cos(n theta) outward
    and chi_1 c sin(n theta) along +theta; a traction f sin(n theta) by -gamma_2 f cos(n theta) and
    chi_2 f sin(n theta).
    """
    Y = radius * surface_compliance(n, depth(radius, core_radius), A_rr, A_tt, A_rt, G, D)
    return Sequences(Y[0, 0], -Y[0, 1], -Y[1, 0], Y[1, 1])


def depth(radius: float, core_radius: float) -> float:
    """Return ln(R/R0), the depth of a layer in ln r, without cancellation for thin layers."""
    if 2 * core_radius > radius:
        return -log1p(-(radius - core_radius) / radius)
    return log(radius / core_radius)


def surface_compliance(
    n: Array, depth: float, A_rr: float, A_tt: float, A_rt: float, G: float, D: float | None = None
) -> Array:
    """Return Y_n [1/Pa], shape (2, 2) + n.shape, of a layer of depth ln(R/R0) on a rigid core."""
    return stacked_compliance(n, ((depth, A_rr, A_tt, A_rt, G, D),))


@lru_cache(maxsize=64)
def asymptotic_compliance(
    orders: int, A_rr: float, A_tt: float, A_rt: float, G: float, D: float | None = None
) -> Array:
    """Return the coefficients S_j of the compliance Y_n = sum_j S_j/n^j far from any core [1/Pa].

    The array has the shape (orders+1, 2, 2) and is read-only; S_0 = 0.

    Notes
    -----
    F Y + Y F' + N = D z z' with z = Y k is solved order by order in 1/n.  The first order is the
    half-plane, S_1 = [[C, A], [A, B]] (thesis eq. 30).
    """
    D = D or stiffness_along(A_rr, A_tt, A_rt)
    A, B, C = coefficients(A_rr, A_tt, A_rt, G, D)
    a, r, DB = A_rt / A_rr, sqrt(A_tt / A_rr), D * B
    S = np.zeros((orders + 2, 2, 2))
    S[1] = [[C, A], [A, B]]
    z = np.zeros((orders + 2, 2))
    z[0] = S[1, :, 1]
    shift = np.array([-a, 1.0])
    for j in range(2, orders + 1):
        # the terms of lower order; S_j enters through F_1 and z_(j-1)
        z[j - 1] = S[j - 1, :, 0]
        lower_order = shift[:, None] * S[j - 1] + S[j - 1] * shift
        lower_order -= D * (z[:j].T @ z[j - 1 :: -1])
        y12 = lower_order[0, 0] / (2 * r)
        y22 = (y12 + lower_order[1, 1] / 2) / DB
        y11 = -lower_order[0, 1] + r * y22 + DB * y12
        S[j] = [[y11, y12], [y12, y22]]
        z[j - 1] += S[j, :, 1]
    S.setflags(write=False)
    return S[: orders + 1]


def surface_kernels(
    radius: float,
    core_radius: float,
    A_rr: float,
    A_tt: float,
    A_rt: float,
    G: float,
    D: float | None = None,
) -> SurfaceKernels:
    """Return the influence functions (thesis eq. 59) of one layer on a rigid core.

    Parameters
    ----------
    radius, core_radius : float
        R and R0 [m], 0 < R0 < R.
    A_rr, A_tt, A_rt, G : float
        Plane-strain stiffness [Pa].
    D : float, optional
        As of :func:`.strip.stiffness_along`, if it is known more accurately.
    """
    stiffness = map(float, (A_rr, A_tt, A_rt, G))
    return layered_kernels(radius, ((depth(radius, core_radius), *stiffness, D),))


@lru_cache(maxsize=16)
def layered_kernels(radius: float, layers: Layers, open_bore: bool = False) -> SurfaceKernels:
    """Return the influence functions of a cylinder of layers, defined on the complete circle.

    Parameters
    ----------
    radius : float
        R [m].
    layers : sequence of (depth, A_rr, A_tt, A_rt, G, D)
        Outermost first: ln of the ratio of their radii, and plane-strain stiffness [Pa]; D may be
        omitted, or None.
    open_bore : bool
        True for an open bore, False for a rigid core.
    """
    R = float(radius)
    Y, tail, J, decay, error, _ = _elastic_spectrum(layers, open_bore)
    n = np.arange(1.0, Y.shape[-1])
    mean, Y = Y[..., 0] / 2, Y[..., 1:]  # the constant of a Fourier series is half of n = 0
    # coefficients of 1/n^j of the displacements Y_n, the slopes n Y_n and the strains (1, n) Y_n
    displacement, slope = tail[: J + 1], tail[1 : J + 2]
    strain, strain_terms = displacement[:, 0] + slope[:, 1], Y[0] + n * Y[1]

    def harmonics(odd: bool, scale: float, a: Array, c: Array, mean: float = 0.0) -> HarmonicSum:
        """Return scale * [mean + sum of c_n trig(n theta)], c_n = a_0 + a_1/n + ... + remainder.

        trig is sin if ``odd``, else cos; a (J+1,), c (N,).
        """
        return HarmonicSum(odd, R, scale, mean, a, c - _powers(a, n.size))

    normal = HarmonicSums(
        (
            harmonics(False, -1 / pi, displacement[:, 0, 0], Y[0, 0], mean[0, 0]),
            harmonics(True, -1 / pi, displacement[:, 0, 1], Y[0, 1]),
        )
    )
    normal_p, coupling = normal.kernels()
    scale = 1 / (pi * R)
    gradients = HarmonicSums(
        (
            harmonics(True, scale, slope[:, 0, 0], n * Y[0, 0]),
            harmonics(False, -scale, slope[:, 0, 1], n * Y[0, 1]),
            harmonics(False, -scale, strain[:, 0], strain_terms[0], mean[0, 0]),
            harmonics(True, -scale, strain[:, 1], strain_terms[1]),
        )
    )
    slope_p, slope_q, strain_p, strain_q = gradients.kernels()
    return SurfaceKernels(
        normal_p=normal_p,
        normal_q=coupling,
        tangent_p=coupling,
        tangent_q=harmonics(False, 1 / pi, displacement[:, 1, 1], Y[1, 1], mean[1, 1]).kernel(),
        slope_p=slope_p,
        slope_q=slope_q,
        strain_p=strain_p,
        strain_q=strain_q,
        smooth_gradients=gradients,
        smooth_normals=normal,
        uniform_strain=-2 * float(mean[0, 0]),
        length=R * min(1.0, 2 * decay),
        truncation_error=error,
        terms=n.size,
        max_distance=gradients.max_distance,
    )


class BulkPart(NamedTuple):
    """The part of the powers of 1/n that creeps as 1/(3K + G), with a constant bulk modulus K.

    Attributes
    ----------
    tail : (K, 2, 2) array
        Its coefficients of 1/n^j [1/Pa].
    moduli : RelaxingModuli
        Of all layers; the first is the outermost one.
    share : float
        G/(3K + G) after all relaxation.
    """

    tail: Array
    moduli: RelaxingModuli
    share: float

    def creep_ratio(self, n: Array) -> Array:
        """Return the creep compliance of 3K + G over that of G at harmonics n, each 1 at 0."""
        factor = self.moduli.factors(n)[0]
        return factor / (1 + self.share * (factor - 1))


class Spectrum(NamedTuple):
    """The surface compliance Y_n = sum_j S_j/n^j + remainder of the harmonics that are summed.

    Attributes
    ----------
    Y : (2, 2, N + 1) array
        Y_n [1/Pa].
    tail : (K, 2, 2) array
        The coefficients S_j.
    J : int
        Highest power of 1/n that is summed in closed form.
    decay : float
        kappa: the remainder decays as exp(-2 kappa n).
    error : float
        Estimated error of the sums of n Y_n, relative.
    bulk : BulkPart, optional
        The part of the powers of 1/n that is relative to another creep compliance.
    """

    Y: Array
    tail: Array
    J: int
    decay: float
    error: float
    bulk: BulkPart | None = None


@lru_cache(maxsize=2)
def _elastic_spectrum(layers: Layers, open_bore: bool) -> Spectrum:
    """Return the surface compliances Y_n of elastic layers, and their powers of 1/n.

    They are also those of a single viscoelastic layer, relative to its creep compliance.
    Parameters as of :func:`layered_kernels`.
    """
    return _spectrum(layers, open_bore)


def _spectrum(layers: Layers, open_bore: bool, moduli: RelaxingModuli | None = None) -> Spectrum:
    """Return the surface compliances Y_n of layers, and their powers of 1/n.

    As many harmonics are computed as are needed until Y_n is its asymptotic series sum_j S_j/n^j.

    Parameters
    ----------
    layers : sequence of (depth, A_rr, A_tt, A_rt, G, D)
        As of :func:`layered_kernels`.
    open_bore : bool
        True for an open bore, False for a rigid core.
    moduli : RelaxingModuli, optional
        Of viscoelastic layers.  The spectrum is then relative to the creep compliance of the
        outermost layer, of its shear modulus if its bulk modulus is constant.
    """
    depth = float(layers[0][0] or 0.0)  # never None; `or` serves the type checker
    stiffness: Stiffness = layers[0][1:]  # type: ignore[assignment]
    tail = asymptotic_compliance(HIGHEST_POWER + 2, *stiffness)
    J = _highest_power(tail)
    decay, N = _decay_over_depth(depth, stiffness), _harmonic_count(depth, tail, J, stiffness)
    if len(layers) > 1:
        N = min(N, MAX_LAYERED_TERMS)
    n = np.arange(N + 1.0)
    if len(layers) == 1 or N <= MAX_DIRECT:
        Y = _compliance(n, layers, open_bore, moduli)
    else:
        Y = _interpolated_compliance(N, layers, open_bore, moduli)
    shear_tail, bulk = tail, None
    if moduli is not None and moduli.constant_bulk[0]:
        _, _, A_rt, G, _ = stiffness
        shear_tail = asymptotic_compliance(HIGHEST_POWER + 2, *incompressible(G))
        bulk = BulkPart(tail - shear_tail, moduli, share=G / (3 * (A_rt + G)))
    if len(layers) > 1:
        remainder = _remainder(Y, shear_tail, J, bulk)
        # the remainder exp(-2 kappa n) is negligible from n = 20/kappa on
        if 20 / decay > N and remainder[-1] > MAX_REMAINDER:
            return _truncated_spectrum(Y, tail, decay)  # with a creep of 1/G alone
        # similar layers below have a weaker effect: kappa from the n with a remainder of
        # 1e-5 = exp(-2 kappa n), about exp(-12)
        decay = max(decay, 6.0 / (1 + np.max(np.nonzero(remainder > 1e-5)[0], initial=0)))
        N = max(32, 1 + int(np.max(np.nonzero(remainder > ROUNDING)[0], initial=0)))
        Y = Y[..., : min(N, n.size - 1) + 1]
    n = np.arange(1.0, Y.shape[-1])
    terms = n * (Y[..., 1:] - _closed_form(shear_tail[: J + 2], bulk, n.size))
    error = _truncation_error(terms, tail, depth, stiffness, J)
    return Spectrum(Y, shear_tail, J, decay, error, bulk)


def _compliance(n: Array, layers: Layers, open_bore: bool, moduli: RelaxingModuli | None) -> Array:
    """Return Y_n at harmonics n (k,), (2, 2, k) [1/Pa].

    With the ``moduli`` of viscoelastic layers it is relative to the creep compliance of the
    outermost one.
    """
    Y = stacked_compliance(n, layers, open_bore, moduli)
    return Y if moduli is None else Y * moduli.factors(n)[0]


def _interpolated_compliance(
    N: int, layers: Layers, open_bore: bool, moduli: RelaxingModuli | None
) -> Array:
    """Return Y_n, n = 0 ... N, (2, 2, N + 1), with n Y_n interpolated by polynomials of ln n.

    The number of Chebyshev points is doubled until the last quarter of the coefficients of the
    Chebyshev polynomials is negligible.  Other parameters as of :func:`_spectrum`.
    """
    from scipy.fft import dct  # problems are read and written without SciPy

    n = np.arange(N + 1.0)
    unsampled = _compliance(n[:FIRST_SAMPLED], layers, open_bore, moduli)
    Y = np.empty((2, 2, N + 1), dtype=unsampled.dtype)
    Y[..., :FIRST_SAMPLED] = unsampled
    low, high, size = log(FIRST_SAMPLED), log(N), 32
    known_values = np.zeros((2, 2, 0))  # values at the points of the previous polynomial
    while size < N // 4:
        angle = np.pi * np.arange(size + 1) / size
        # every second point is one of the previous polynomial, where the values are known
        new_points = slice(1, None, 2) if known_values.size else slice(None)
        n_sampled = np.exp(low + (high - low) * (1 + np.cos(angle[new_points])) / 2)
        values = np.empty((2, 2, size + 1), dtype=Y.dtype)
        values[..., ::2] = known_values if known_values.size else 0.0
        values[..., new_points] = n_sampled * _compliance(n_sampled, layers, open_bore, moduli)
        c = dct(values, type=1, axis=-1) / size
        c[..., [0, -1]] /= 2  # the first and the last coefficient count half
        if np.abs(c[..., -size // 4 :]).max() < 1e-15 * np.abs(values).max():
            x = (np.log(n[FIRST_SAMPLED:]) - low) / (high - low) * 2 - 1
            for block in np.array_split(np.arange(x.size), max(1, x.size // 4096)):
                k = FIRST_SAMPLED + block
                Y[..., k] = c @ np.polynomial.chebyshev.chebvander(x[block], size).T / n[k]
            return Y
        known_values, size = values, 2 * size
    # polynomials do not converge with fewer points than harmonics: all are computed
    Y[..., FIRST_SAMPLED:] = _compliance(n[FIRST_SAMPLED:], layers, open_bore, moduli)
    return Y


def _remainder(Y: Array, tail: Array, J: int, bulk: BulkPart | None) -> Array:
    """Return |n Y_n - sum_j S_(j+1)/n^j|, n = 1 ... N, relative to |S_1|, (N,).

    Parameters
    ----------
    Y : (2, 2, N + 1) array
        The surface compliances.
    tail : (K, 2, 2) array
        The coefficients S_j of their asymptotic series.
    J : int
        Highest power of 1/n in the sum.
    bulk : BulkPart or None
        Further powers.
    """
    n = np.arange(1.0, Y.shape[-1])
    remainder = np.abs(n * (Y[..., 1:] - _closed_form(tail[: J + 2], bulk, n.size)))
    return np.array(remainder.max(axis=(0, 1)) / np.abs(tail[1]).max())


def _truncated_spectrum(Y: Array, tail: Array, decay: float) -> Spectrum:
    """Return the spectrum of a layer so thin that Y_n does not reach its asymptotic series.

    Shorter waves, which are much shorter than any contact, are given the n Y_n of the last one.
    Parameters as the attributes of :class:`Spectrum`.
    """
    N = Y.shape[-1] - 1
    last_terms = np.zeros((3, 2, 2), dtype=Y.dtype)
    last_terms[1] = N * Y[..., -1]
    error = np.abs(last_terms[1] - tail[1]).max() / max(
        np.abs(last_terms[1]).max(), np.abs(tail[1]).max()
    )
    # A wave of N periods around the circumference takes polynomials of a degree above N a/R on
    # [-a, a].  With kappa = 6/N, as in _spectrum, their degree is 10 a/(kappa R) = 1.7 N a/R; with
    # a lower degree the response would jump with the half width.
    return Spectrum(Y, tail=last_terms, J=1, decay=max(6 / N, decay), error=float(error) / N)


def _closed_form(tail: Array, bulk: BulkPart | None, terms: int) -> Array:
    """Sum tail_j/n^j and the same powers of the bulk part, n = 1 ... terms, (2, 2, terms)."""
    powers = _powers(tail, terms)
    if bulk is not None:
        ratio = bulk.creep_ratio(np.arange(1.0, terms + 1))
        powers = powers + ratio * _powers(bulk.tail[: len(tail)], terms)
    return powers


def _powers(a: Array, terms: int) -> Array:
    """Sum a_j/n^j, a of shape (J+1, ...), for n = 1 ... terms, to shape (..., terms)."""
    return np.asarray(np.moveaxis(a, 0, -1) @ _inverse_powers(len(a), terms))


@lru_cache(maxsize=2)
def _inverse_powers(count: int, terms: int) -> Array:
    """Return 1, 1/n, 1/n^2, ... of n = 1 ... terms, (count, terms)."""
    powers = np.ones((count, terms))
    powers[1:] = 1 / np.arange(1.0, terms + 1)
    return np.cumprod(powers, axis=0)


def _highest_power(tail: Array) -> int:
    """Return the highest power of 1/n to sum in closed form.

    Coefficients S_j of the asymptotic series (``tail``, (K, 2, 2)) that grow by a factor of more
    than 1e4 would cause cancellation.
    """
    size = np.abs(tail).max(axis=(1, 2))
    for J in range(HIGHEST_POWER, 1, -1):
        if size[1 : J + 2].max() < 1e4 * size[1]:
            return J
    return 1


def _decay_over_depth(depth: float, stiffness: Stiffness) -> float:
    """Return kappa: the effect of the lower side of a layer decays as exp(-2 kappa n).

    kappa is the rate of decay per unit of ln r times the depth of the layer.
    """
    return _decay_rate(stiffness) * depth


@lru_cache(maxsize=64)
def _decay_rate(stiffness: Stiffness) -> float:
    """Return the rate of decay per unit of ln r and of n of short waves below the surface [1].

    Both waves decay as exp(-lambda y) over the depth y in ln r; for large n the smaller real part
    of lambda is proportional to n.
    """
    n = 1e8
    # sum and product of the two lambda with a positive real part
    total, product = (v.item() for v in LayerSystems.of((1.0, *stiffness)).roots(np.array([n])))
    discriminant = total * total / 4 - product
    slow = product / (total / 2 + sqrt(discriminant)) if discriminant > 0 else total / 2
    return slow / n


def _harmonic_count(depth: float, tail: Array, J: int, stiffness: Stiffness) -> int:
    """Return the number of harmonics at which the remainder is negligible.

    The remainder consists of the effect of the core, exp(-2 kappa n), and the next power of 1/n.

    Parameters
    ----------
    depth : float
        Of the outermost layer, ln of the ratio of its radii.
    tail : (K, 2, 2) array
        The coefficients S_j of the asymptotic series of Y_n.
    J : int
        Highest power of 1/n that is summed in closed form.
    stiffness : (A_rr, A_tt, A_rt, G, D)
        Of the outermost layer [Pa].
    """
    core = 20 / _decay_over_depth(depth, stiffness)
    size = np.abs(tail).max(axis=(1, 2))
    # the sum of the next power S_(J+2)/m^(J+1) over m > n is S_(J+2)/(J n^J)
    power = (size[J + 2] / (J * TOLERANCE * size[1])) ** (1 / J)
    return int(min(max(core, power, 32), MAX_TERMS))


def _truncation_error(
    terms: Array, tail: Array, depth: float, stiffness: Stiffness, J: int
) -> float:
    """Estimate the truncation error of the sums of slopes and strains from their last terms.

    It is relative to their values at a distance of the thickness of the layer (or the radius).  The
    neglected terms n > N decay as n^-(J+1), with a sum of N/J last terms, or as exp(-2 kappa n),
    with a sum of 1/(2 kappa).

    Parameters
    ----------
    terms : (2, 2, N) array
        n Y_n less the powers of 1/n that are summed in closed form.
    tail, depth, stiffness, J
        As of :func:`_harmonic_count`.
    """
    N = terms.shape[-1]
    last = terms[..., -max(4, N // 16) :]
    neglected = max(N / J, 0.5 / _decay_over_depth(depth, stiffness))  # in units of the last term
    return float(np.abs(last).max() / np.abs(tail[1]).max() * neglected * min(depth, 1.0))
