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
from .relaxation import Creep, Relaxation, creep, factor

__all__ = ["half_plane_kernels", "layered_kernels"]

Array = np.ndarray

SLOW = 1.0  # eps above which a term of the creep compliance is expanded in powers of 1/n
MIN_SLOW_TERMS = 128  # number of harmonics for such terms: the expansion is then exact to 1e-12


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
    max_distance : float
        Largest distance |t| at which they are evaluated [m].
    """
    A, B, C = coefficients(*stiffness)
    j_0, j, length = creep(relaxation)
    # delayed 1/t and Dirac pulses of the elastic slopes and strains, times 1/pi
    pole, pulse = j / pi + 0j, -1j * j / pi
    of_gradients = np.array([C * pole, A * pulse, A * pulse, -B * pole])
    of_displacements = -length * np.array([C * pole, -A * pulse, -A * pulse, -B * pole])
    gradients = Lag(length, of_gradients, max_distance)
    displacements = Lag(length, of_displacements, max_distance)
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
    radius: float, layers: Layers, relaxations: tuple[Relaxation, ...], free: bool = False
) -> SurfaceKernels:
    """Return the influence functions of a rolling cylinder of layers, some of them viscoelastic.

    Parameters
    ----------
    radius, layers, free
        As of :func:`.cylinder.layered_kernels`; relaxed stiffness.
    relaxations : tuple of tuples of (g_k, c_k)
        Of each layer, empty if elastic.
    """
    R = float(radius)

    def moduli(n: Array) -> Array:
        """Return E(in/R)/E_inf of the layers, (L, n)."""
        return np.array([factor(relaxation, n / R) for relaxation in relaxations])

    # all compliances of a single layer vary as J_n: X_n is elastic
    single = len(layers) == 1
    X, tail, J, decay, error = (
        _elastic_spectrum(layers, free) if single else _spectrum(layers, free, moduli)
    )
    n = np.arange(1.0, X.shape[-1])
    mean, X = X[..., 0].real / 2, X[..., 1:]
    displacement, slope = tail[: J + 1], tail[1 : J + 2]  # coefficients of X and of n X
    strain, strain_terms = displacement[:, 0] + slope[:, 1], X[0] + n * X[1]
    sums = ViscoelasticSums(R, creep(relaxations[0]), n.size)
    wave, gradient = -1 / pi, 1 / (pi * R)
    parts = [
        sums.split(odd, scale, a, c - sums.powers(a)[: n.size], constant)
        for odd, scale, a, c, constant in (
            (True, gradient, slope[:, 0, 0], n * X[0, 0], 0.0),
            (False, -gradient, slope[:, 0, 1], n * X[0, 1], 0.0),
            (False, -gradient, strain[:, 0], strain_terms[0], mean[0, 0]),
            (True, -gradient, strain[:, 1], strain_terms[1], 0.0),
            (False, wave, displacement[:, 0, 0], X[0, 0], mean[0, 0]),
            (True, wave, displacement[:, 0, 1], X[0, 1], 0.0),
            (False, -wave, displacement[:, 1, 1], X[1, 1], mean[1, 1]),
        )
    ]
    (slope_p, slope_q, strain_p, strain_q), smooth, lag = sums.kernels(parts[:4])
    (normal_p, coupling), _, _ = sums.kernels(parts[4:6])
    (tangent_q,), _, _ = sums.kernels(parts[6:])  # its table is rarely needed
    return SurfaceKernels(
        normal_p,
        coupling,
        coupling,
        tangent_q,
        slope_p,
        slope_q,
        strain_p,
        strain_q,
        uniform_strain=-2 * float(mean[0, 0]),
        length=R * min(1.0, 2 * decay),
        truncation_error=error,
        terms=n.size,
        together=smooth,
        lag=lag,
    )


class Part(NamedTuple):
    """One influence function: its even and its odd sum, and the amplitudes of its lags (M,)."""

    even: HarmonicSum
    odd: HarmonicSum
    lag: Array


class ViscoelasticSums:
    """Sums of J_n X_n over the harmonics, J_n the creep compliance of the outermost layer.

    Parameters
    ----------
    radius : float
        R [m].
    compliance : Creep
    terms : int
        Number of harmonics.
    """

    def __init__(self, radius: float, compliance: Creep, terms: int) -> None:
        self.radius, self.compliance = radius, compliance
        eps = compliance.length / radius
        self.eps, self.fast, self.slow = eps, eps <= SLOW, eps > SLOW
        self.lag_series = periodic_series(eps[self.fast])
        self.n = np.arange(1.0, 1 + (max(terms, MIN_SLOW_TERMS) if self.slow.any() else terms))
        self._inverse_powers = (1 / self.n) ** np.arange(HIGHEST_POWER + 1)[:, None]
        retardation = 1 / (1 + 1j * self.n[:, None] * eps)
        self.J_slow = retardation[:, self.slow] @ compliance.share[self.slow]
        self.J = compliance.at_once + retardation @ compliance.share

    def powers(self, a: Array) -> Array:
        """Return a_0 + a_1/n + ... of all harmonics, (N,)."""
        return np.asarray(a @ self._inverse_powers[: a.size])

    def split(self, odd: bool, scale: float, a: Array, remainder: Array, mean: float) -> Part:
        """Split scale * [mean + sum_n J_n (a_0 + a_1/n + ... + remainder_n) trig(n t/R)].

        Parameters
        ----------
        odd : bool
            True for sines of an elastic body, False for cosines.
        scale : float
        a : (J+1,) array
        remainder : (N,) array
        mean : float
        """
        j_0, j, _ = self.compliance
        a = a.astype(complex)
        B, amplitude = _divide(a, -1j * self.eps[self.fast])
        powers = j_0 * a
        powers[1:] += B @ j[self.fast]
        remainder = np.append(remainder, np.zeros(self.n.size - remainder.size)) * self.J
        if self.slow.any():
            expanded = np.zeros(a.size, dtype=complex)
            for m in np.flatnonzero(self.slow):
                series = -((1j / self.eps[m]) ** np.arange(a.size))  # of 1/(1 + i eps/x)
                series[0] = 0.0
                expanded += j[m] * np.convolve(a, series)[: a.size]
            powers += expanded
            remainder += self.powers(a) * self.J_slow - self.powers(expanded)
        phase: complex = -1j if odd else 1.0
        c, terms = phase * powers, phase * remainder
        amplitude = scale * phase * amplitude * j[self.fast]
        regular = (amplitude @ self.lag_series).real
        is_even = np.arange(POWERS) % 2 == 0
        even, odd_ = np.where(is_even, regular, 0.0), np.where(is_even, 0.0, regular)
        return Part(
            HarmonicSum(False, self.radius, scale, mean, c.real, terms.real, even),
            HarmonicSum(True, self.radius, -scale, 0.0, c.imag, terms.imag, odd_),
            1j * self.radius * amplitude,
        )

    def kernels(self, parts: list[Part]) -> tuple[list[Kernel], SmoothParts, Lag | None]:
        """Return the influence functions, their smooth parts together, and their lags."""
        lag, kernels = None, []
        sums = HarmonicSums(tuple(p.even for p in parts) + tuple(p.odd for p in parts))
        smooth = SmoothParts(sums)
        if self.fast.any():
            length, R = self.compliance.length[self.fast], self.radius
            lag = Lag(length, np.array([part.lag for part in parts]), (pi + 1) * R)
        for k, part in enumerate(parts):
            odd = part.odd.kernel()
            kernel = replace(
                part.even.kernel(),
                inverse=odd.inverse,
                sign=odd.sign,
                smooth=smooth.select(k).first,
                second_integral=partial(_second_integral, part),
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
class SmoothParts:
    """Smooth parts of several influence functions; ``sums`` holds all even sums, then all odd."""

    sums: HarmonicSums

    def select(self, kernel: int) -> SmoothParts:
        """Return the smooth part of one of the influence functions, from the same table."""
        return SmoothParts(self.sums.select(slice(kernel, None, len(self.sums.sums) // 2)))

    def __call__(self, t: Array) -> Array:
        """Return the smooth parts at t [m], shape (kernels, *t.shape)."""
        values = self.sums(t)
        half = len(values) // 2
        return values[:half] + values[half:]

    def first(self, t: Array) -> Array:
        """Return the first of the smooth parts at t [m]."""
        return np.asarray(self(t)[0])


def _second_integral(part: Part, t: Array) -> Array:
    """Return the second integral of an influence function without its lag, at t [m]."""
    even, odd, _ = part
    assert even.regular is not None
    assert odd.regular is not None
    k, theta = np.arange(POWERS), t / even.radius
    c = (even.regular + odd.regular) / ((k + 1) * (k + 2))
    regular = (t * t) * np.polynomial.polynomial.polyval(theta, c)
    return np.asarray(even.second_integral(t) + odd.second_integral(t) + regular)
