r"""Influence functions of rolling bodies with isotropic viscoelastic layers.

Poisson's ratio is constant.  In steady rolling the material sees the n-th harmonic e^{in theta} of
the loads as an oscillation with n periods per revolution, so that its modulus is E(in/R)
(:mod:`.relaxation`).  The surface compliances Y_n are those of elastic layers (:mod:`.layers`) with
complex moduli.  The influence functions are

    Re sum_n Y_n e^{in theta}   in place of   sum_n Y_n cos(n theta),
    Im sum_n Y_n e^{in theta}   in place of   sum_n Y_n sin(n theta),

split into even and odd parts, each a sum of :mod:`.fourier`.  For a half-plane the wave number k
replaces n/R.

For large n only the outermost layer deforms, and Y_n = J_n X_n/E_inf with its creep compliance

    J_n = j_0 + sum_m j_m/(1 + i n eps_m),      eps_m = l_m/R.

X_n tends to a polynomial A(x) in x = 1/n.  Polynomial division of each term of J_n A,

    A(x)/(1 + i n eps) = A(-i eps)/(1 + i n eps) + x B(x),     A(x) = A(-i eps) + (x + i eps) B(x),

gives powers of 1/n, summed as for an elastic body, and one sum 1/(1 + i n eps), which is known in
closed form (:mod:`.lag`).  For eps > 1 these two cancel; then the left side is expanded in powers
of 1/n instead.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache, partial
from math import pi
from typing import NamedTuple

import numpy as np

from .cylinder import HIGHEST_POWER, _elastic_spectrum, _spectrum
from .fourier import POWERS, HarmonicSum, HarmonicSums
from .half_plane import coefficients
from .kernels import Kernel, SurfaceKernels
from .lag import Lag, periodic_series
from .layers import Layers
from .relaxation import Creep, Relaxation, creep, modulus_ratio

__all__ = ["half_plane_kernels", "layered_kernels"]

Array = np.ndarray

EXPANDED_ABOVE = 1.0  # eps above which a term of the creep compliance is expanded in powers of 1/n
MIN_EXPANDED_TERMS = 128  # number of harmonics for such terms: the expansion is then exact to 1e-12


@lru_cache(maxsize=16)
def half_plane_kernels(
    stiffness: tuple[float, ...], relaxation: Relaxation, max_distance: float
) -> SurfaceKernels:
    """Return the influence functions of a rolling viscoelastic half-plane.

    Parameters
    ----------
    stiffness : tuple of float
        Relaxed plane-strain stiffness A_rr, A_tt, A_rt, G, D [Pa].
    relaxation : tuple of (g_k, c_k)
        Relaxing moduli E_k/E_inf [1], and speed times relaxation time V tau_k [m].
    max_distance : float
        Largest distance |t| at which they are evaluated [m].

    Notes
    -----
    An elastic slope or strain k(t) becomes j_0 k(t) plus a lag, sum_m j_m (1 + l_m d/dt)^-1 k.  An
    elastic displacement, whose derivative is k, becomes sum_m j_m (1 + l_m d/dt)^-1 int k = int k
    minus a lag of amplitude l_m, with j_0 + sum_m j_m = 1.
    """
    A, B, C = coefficients(*stiffness)
    j_0, j, length = creep(relaxation)
    # amplitudes g of Re(g Phi) for the lag of 1/(pi t), and of -Dirac(t)
    pole, pulse = j / pi + 0j, -1j * j / pi
    # slope and strain by p and q, the derivatives of v and u by p and q in the same order
    gradient_amplitudes = np.array([C * pole, A * pulse, A * pulse, -B * pole])
    gradients = Lag(length, gradient_amplitudes, max_distance)
    displacements = Lag(length, -length * gradient_amplitudes, max_distance)
    return SurfaceKernels(
        normal_p=Kernel(log=C / pi, lag=displacements.select(0)),
        normal_q=Kernel(sign=-A / 2, lag=displacements.select(1)),
        tangent_p=Kernel(sign=-A / 2, lag=displacements.select(2)),
        tangent_q=Kernel(log=-B / pi, lag=displacements.select(3)),
        slope_p=Kernel(inverse=C * j_0 / pi, lag=gradients.select(0)),
        slope_q=Kernel(delta=-A * j_0, lag=gradients.select(1)),
        strain_p=Kernel(delta=-A * j_0, lag=gradients.select(2)),
        strain_q=Kernel(inverse=-B * j_0 / pi, lag=gradients.select(3)),
        uniform_strain=-A,
        lag=gradients,
    )


@lru_cache(maxsize=16)
def layered_kernels(
    radius: float, layers: Layers, relaxations: tuple[Relaxation, ...], open_bore: bool = False
) -> SurfaceKernels:
    """Return the influence functions of a rolling cylinder of layers, some of them viscoelastic.

    Parameters
    ----------
    radius, layers, open_bore
        As of :func:`.cylinder.layered_kernels`; relaxed stiffness.
    relaxations : tuple of tuples of (g_k, c_k)
        Of each layer, E_k/E_inf [1] and V tau_k [m]; empty if elastic.
    """
    R = float(radius)

    def moduli(n: Array) -> Array:
        """Return E(in/R)/E_inf of the layers, (L, n)."""
        return np.array([modulus_ratio(relaxation, n / R) for relaxation in relaxations])

    # all compliances of a single layer vary as J_n: X_n is elastic
    single = len(layers) == 1
    X, tail, J, decay, error = (
        _elastic_spectrum(layers, open_bore) if single else _spectrum(layers, open_bore, moduli)
    )
    n = np.arange(1.0, X.shape[-1])
    mean, X = X[..., 0].real / 2, X[..., 1:]
    # coefficients of 1/n^j of the displacements X_n, the slopes n X_n and the strains (1, n) X_n
    displacement, slope = tail[: J + 1], tail[1 : J + 2]
    strain, strain_terms = displacement[:, 0] + slope[:, 1], X[0] + n * X[1]
    sums = ViscoelasticSums(R, creep(relaxations[0]), n.size)

    def harmonics(odd: bool, scale: float, a: Array, c: Array, mean: float = 0.0) -> SplitSum:
        """Return the sum of scale J_n c_n trig(n theta), c_n = a_0 + a_1/n + ... + remainder."""
        return sums.split(odd, scale, a, c - sums.powers(a)[: n.size], mean)

    # the same sums as in cylinder.layered_kernels
    scale = 1 / (pi * R)
    gradients = [
        harmonics(True, scale, slope[:, 0, 0], n * X[0, 0]),
        harmonics(False, -scale, slope[:, 0, 1], n * X[0, 1]),
        harmonics(False, -scale, strain[:, 0], strain_terms[0], mean[0, 0]),
        harmonics(True, -scale, strain[:, 1], strain_terms[1]),
    ]
    normal = [
        harmonics(False, -1 / pi, displacement[:, 0, 0], X[0, 0], mean[0, 0]),
        harmonics(True, -1 / pi, displacement[:, 0, 1], X[0, 1]),
    ]
    tangential = [harmonics(False, 1 / pi, displacement[:, 1, 1], X[1, 1], mean[1, 1])]
    (slope_p, slope_q, strain_p, strain_q), smooth, lag = sums.kernels(gradients)
    (normal_p, coupling), _, _ = sums.kernels(normal)
    (tangent_q,), _, _ = sums.kernels(tangential)  # a table of its own, because it is rarely needed
    return SurfaceKernels(
        normal_p=normal_p,
        normal_q=coupling,
        tangent_p=coupling,
        tangent_q=tangent_q,
        slope_p=slope_p,
        slope_q=slope_q,
        strain_p=strain_p,
        strain_q=strain_q,
        uniform_strain=-2 * float(mean[0, 0]),
        length=R * min(1.0, 2 * decay),
        truncation_error=error,
        terms=n.size,
        smooth_gradients=smooth,
        lag=lag,
    )


class SplitSum(NamedTuple):
    """One influence function: its even and its odd sum, and the amplitudes of its lag, (M,)."""

    even: HarmonicSum
    odd: HarmonicSum
    lag_amplitudes: Array


class ViscoelasticSums:
    """Sums of J_n X_n over the harmonics, J_n the creep compliance of the outermost layer.

    A term of J_n with eps <= EXPANDED_ABOVE has a lag in closed form; one with a larger eps, which
    varies slowly around the circle, is expanded in powers of 1/n.

    Parameters
    ----------
    radius : float
        R [m].
    compliance : Creep
    terms : int
        Number of harmonics.

    Attributes
    ----------
    eps : (M,) array
        l_m/R of the terms of J_n.
    has_lag, is_expanded : (M,) bool arrays
        The terms with a lag, and those that are expanded.
    lag_series : (lags, POWERS) complex array
        Power series of theta in addition to the lags; see :func:`.lag.periodic_series`.
    n : (N,) array
        Harmonics from 1; more than ``terms`` if that serves the expanded terms.
    J, J_expanded : (N,) complex arrays
        J_n, and the sum of its expanded terms.
    """

    def __init__(self, radius: float, compliance: Creep, terms: int) -> None:
        self.radius, self.compliance = radius, compliance
        eps = compliance.length / radius
        self.eps, self.has_lag, self.is_expanded = eps, eps <= EXPANDED_ABOVE, eps > EXPANDED_ABOVE
        self.lag_series = periodic_series(eps[self.has_lag])
        harmonics = max(terms, MIN_EXPANDED_TERMS) if self.is_expanded.any() else terms
        self.n = np.arange(1.0, 1 + harmonics)
        self._inverse_powers = (1 / self.n) ** np.arange(HIGHEST_POWER + 1)[:, None]
        retardation = 1 / (1 + 1j * self.n[:, None] * eps)
        self.J_expanded = retardation[:, self.is_expanded] @ compliance.delayed[self.is_expanded]
        self.J = compliance.instantaneous + retardation @ compliance.delayed

    def powers(self, a: Array) -> Array:
        """Return a_0 + a_1/n + ... of all harmonics, (N,)."""
        return np.asarray(a @ self._inverse_powers[: a.size])

    def split(self, odd: bool, scale: float, a: Array, remainder: Array, mean: float) -> SplitSum:
        """Split scale * [mean + sum_n J_n (A(1/n) + remainder_n) trig(n t/R)].

        A(x) = a_0 + a_1 x + ... + a_J x^J.

        Parameters
        ----------
        odd : bool
            True for sines of an elastic body, False for cosines.
        scale : float
        a : (J+1,) array
        remainder : (N,) array
        mean : float

        Notes
        -----
        J_n (A + remainder) = powers(1/n) + sum_m j_m A(-i eps_m)/(1 + i n eps_m) + J_n remainder:
        the sum over m is the lag, and ``powers`` contains the quotients B of the divisions
        and the expanded terms, whose truncation error is added to the remainder.
        """
        j_0, j, _ = self.compliance
        a = a.astype(complex)
        B, amplitude = _divide(a, -1j * self.eps[self.has_lag])
        powers = j_0 * a
        powers[1:] += B @ j[self.has_lag]
        remainder = np.append(remainder, np.zeros(self.n.size - remainder.size)) * self.J
        if self.is_expanded.any():
            expanded = np.zeros(a.size, dtype=complex)
            for m in np.flatnonzero(self.is_expanded):
                series = -((1j / self.eps[m]) ** np.arange(a.size))  # of 1/(1 + i eps/x) in x
                series[0] = 0.0
                expanded += j[m] * np.convolve(a, series)[: a.size]
            powers += expanded
            remainder += self.powers(a) * self.J_expanded - self.powers(expanded)
        # Im(Y e^{i n theta}) = Re(-i Y e^{i n theta}); its real part multiplies cos, its imaginary
        # part -sin
        phase: complex = -1j if odd else 1.0
        c, terms = phase * powers, phase * remainder
        amplitude = scale * phase * amplitude * j[self.has_lag]
        regular = (amplitude @ self.lag_series).real  # powers of theta in addition to the lag
        is_even = np.arange(POWERS) % 2 == 0
        even_powers, odd_powers = np.where(is_even, regular, 0.0), np.where(is_even, 0.0, regular)
        return SplitSum(
            HarmonicSum(False, self.radius, scale, mean, c.real, terms.real, even_powers),
            HarmonicSum(True, self.radius, -scale, 0.0, c.imag, terms.imag, odd_powers),
            # the sum of e^{in theta}/(1 + in eps) contains i Phi(theta; l/R) = i R Phi(t; l)
            1j * self.radius * amplitude,
        )

    def kernels(self, split_sums: list[SplitSum]) -> tuple[list[Kernel], EvenPlusOdd, Lag | None]:
        """Return influence functions, one function for all their smooth parts, and their lags.

        The kernels are in the order of the sums; the lag is None if no term of J_n has one.
        """
        lag, kernels = None, []
        sums = HarmonicSums(tuple(p.even for p in split_sums) + tuple(p.odd for p in split_sums))
        smooth = EvenPlusOdd(sums)
        if self.has_lag.any():
            length, R = self.compliance.length[self.has_lag], self.radius
            lag = Lag(
                length,
                np.array([split_sum.lag_amplitudes for split_sum in split_sums]),
                (pi + 1) * R,  # largest distance: more than half the circumference
            )
        for k, split_sum in enumerate(split_sums):
            odd = split_sum.odd.kernel()
            kernel = replace(
                split_sum.even.kernel(),
                inverse=odd.inverse,
                sign=odd.sign,
                smooth=smooth.select(k).first,
                second_integral=partial(_second_integral, split_sum),
                lag=None if lag is None else lag.select(k),
            )
            kernels.append(kernel)
        return kernels, smooth, lag


def _divide(a: Array, z: Array) -> tuple[Array, Array]:
    """Divide A(x) = sum_k a_k x^k by x - z for each z (M,): A(x) = A(z) + (x - z) B(x).

    Returns the ascending coefficients of B, (J, M), and A(z), (M,).
    """
    B, value = np.empty((a.size - 1, z.size), dtype=complex), np.full(z.size, a[-1])
    for k in range(a.size - 2, -1, -1):
        B[k] = value
        value = a[k] + z * value
    return B, value


@dataclass(frozen=True)
class EvenPlusOdd:
    """Smooth parts of several influence functions; ``sums`` holds all even sums, then all odd."""

    sums: HarmonicSums

    def select(self, kernel: int) -> EvenPlusOdd:
        """Return the smooth part of one of the influence functions, from the same table."""
        # its even sum, and its odd sum half the list further on
        return EvenPlusOdd(self.sums.select(slice(kernel, None, len(self.sums.sums) // 2)))

    def __call__(self, t: Array) -> Array:
        """Return the smooth parts at t [m], shape (kernels, *t.shape)."""
        values = self.sums(t)
        half = len(values) // 2
        return values[:half] + values[half:]

    def first(self, t: Array) -> Array:
        """Return the first of the smooth parts at t [m]."""
        return np.asarray(self(t)[0])


def _second_integral(split_sum: SplitSum, t: Array) -> Array:
    """Return the second integral of an influence function without its lag, at t [m]."""
    even, odd, _ = split_sum
    assert even.regular is not None
    assert odd.regular is not None
    k, theta = np.arange(POWERS), t / even.radius
    c = (even.regular + odd.regular) / ((k + 1) * (k + 2))  # theta^k integrated twice
    regular = (t * t) * np.polynomial.polynomial.polyval(theta, c)
    return np.asarray(even.second_integral(t) + odd.second_integral(t) + regular)
