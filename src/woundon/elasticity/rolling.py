r"""Influence functions of rolling bodies with isotropic viscoelastic layers.

In steady rolling the material sees the n-th harmonic e^{in theta} of the loads as an oscillation
with n periods per revolution, so that its modulus is E(in/R) (:mod:`.relaxation`).  The surface
compliances Y_n are those of elastic layers (:mod:`.layers`) with complex moduli.  The influence
functions are

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

With a constant bulk modulus two such sums with creep compliances of their own are added, those of
1/G and of 1/(3K + G) (:mod:`.relaxation`); X_n is relative to the first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from math import pi
from typing import NamedTuple

import numpy as np

from .cylinder import HIGHEST_POWER, Spectrum, _elastic_spectrum, _spectrum
from .fourier import POWERS, HarmonicSum, HarmonicSums
from .half_plane import coefficients
from .kernels import Kernel, SurfaceKernels
from .lag import Lag, periodic_series
from .layers import Layers, RelaxingModuli
from .relaxation import (
    Creep,
    Relaxation,
    bulk_relaxation,
    creep,
    incompressible,
    modulus_ratio,
)

__all__ = ["half_plane_kernels", "layered_kernels"]

Array = np.ndarray

EXPANDED_ABOVE = 1.0  # eps above which a term of the creep compliance is expanded in powers of 1/n
MIN_EXPANDED_TERMS = 128  # number of harmonics for such terms: the expansion is then exact to 1e-12


@lru_cache(maxsize=16)
def half_plane_kernels(
    stiffness: tuple[float, ...],
    relaxation: Relaxation,
    max_distance: float,
    constant_bulk: bool = False,
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
    constant_bulk : bool
        True if the relaxation is that of the shear modulus of an isotropic material with a constant
        bulk modulus.

    Notes
    -----
    An elastic slope or strain k(t) becomes j_0 k(t) plus a lag, sum_m j_m (1 + l_m d/dt)^-1 k.  An
    elastic displacement, whose derivative is k, becomes sum_m j_m (1 + l_m d/dt)^-1 int k = int k
    minus a lag of amplitude l_m, with j_0 + sum_m j_m = 1.
    """
    A, B, C = total = np.array(coefficients(*stiffness))
    parts = [(creep(relaxation), total)]
    if constant_bulk:
        _, _, A_rt, G, *_ = stiffness
        shear = np.array(coefficients(*incompressible(G)))
        bulk = creep(bulk_relaxation(A_rt, G, relaxation))
        parts = [(creep(relaxation), shear), (bulk, total - shear)]
    instant = np.zeros(3)  # A, B, C of the instantaneous response
    amplitudes = []
    for (j_0, j, _), (A_i, B_i, C_i) in parts:
        instant += j_0 * np.array([A_i, B_i, C_i])
        # amplitudes g of Re(g Phi) for the lag of 1/(pi t), and of -Dirac(t)
        pole, pulse = j / pi + 0j, -1j * j / pi
        # slope and strain by p and q, the derivatives of v and u by p and q in the same order
        amplitudes.append(np.array([C_i * pole, A_i * pulse, A_i * pulse, -B_i * pole]))
    gradient_amplitudes = np.hstack(amplitudes)
    length = np.concatenate([part.length for part, _ in parts])
    gradients = Lag(length, gradient_amplitudes, max_distance)
    displacements = Lag(length, -length * gradient_amplitudes, max_distance)
    A_0, B_0, C_0 = instant
    return SurfaceKernels(
        normal_p=Kernel(log=C / pi, lag=displacements.select(0)),
        normal_q=Kernel(sign=-A / 2, lag=displacements.select(1)),
        tangent_p=Kernel(sign=-A / 2, lag=displacements.select(2)),
        tangent_q=Kernel(log=-B / pi, lag=displacements.select(3)),
        slope_p=Kernel(inverse=C_0 / pi, lag=gradients.select(0)),
        slope_q=Kernel(delta=-A_0, lag=gradients.select(1)),
        strain_p=Kernel(delta=-A_0, lag=gradients.select(2)),
        strain_q=Kernel(inverse=-B_0 / pi, lag=gradients.select(3)),
        uniform_strain=-A,
        lag=gradients,
    )


@lru_cache(maxsize=16)
def layered_kernels(
    radius: float,
    layers: Layers,
    relaxations: tuple[Relaxation, ...],
    open_bore: bool = False,
    constant_bulk: tuple[bool, ...] = (),
) -> SurfaceKernels:
    """Return the influence functions of a rolling cylinder of layers, some of them viscoelastic.

    Parameters
    ----------
    radius, layers, open_bore
        As of :func:`.cylinder.layered_kernels`; relaxed stiffness.
    relaxations : tuple of tuples of (g_k, c_k)
        Of each layer, E_k/E_inf [1] and V tau_k [m]; empty if elastic.
    constant_bulk : tuple of bool
        Of each layer: True if the relaxation is that of the shear modulus of an isotropic material
        with a constant bulk modulus.  By default all moduli of all layers relax in proportion.
    """
    R = float(radius)
    constant_bulk = constant_bulk or (False,) * len(layers)
    spectrum, tails, creeps, ratios = _parts(R, layers, relaxations, open_bore, constant_bulk)
    X, _, J, decay, error, _ = spectrum
    n = np.arange(1.0, X.shape[-1])
    mean, X = X[..., 0].real / 2, X[..., 1:]
    # coefficients of 1/n^j of the displacements X_n, the slopes n X_n and the strains (1, n) X_n,
    # (parts, J + 1, ...)
    displacement = np.array([tail[: J + 1] for tail in tails])
    slope = np.array([tail[1 : J + 2] for tail in tails])
    strain, strain_terms = displacement[:, :, 0] + slope[:, :, 1], X[0] + n * X[1]
    sums = ViscoelasticSums(R, creeps, n.size)

    def harmonics(odd: bool, scale: float, a: Array, c: Array, mean: float = 0.0) -> SplitSum:
        """Return the sum of scale J_n c_n trig(n theta), c_n = a_0 + a_1/n + ... + remainder.

        J_n is the first creep compliance; a, (parts, J + 1), has the powers of each.
        """
        powers = zip(a, ratios, strict=True)
        closed = sum(ratio * sums.powers(each)[: n.size] for each, ratio in powers)
        return sums.split(odd, scale, a, c - closed, mean)

    # the same sums as in cylinder.layered_kernels
    scale = 1 / (pi * R)
    gradients = [
        harmonics(True, scale, slope[:, :, 0, 0], n * X[0, 0]),
        harmonics(False, -scale, slope[:, :, 0, 1], n * X[0, 1]),
        harmonics(False, -scale, strain[:, :, 0], strain_terms[0], mean[0, 0]),
        harmonics(True, -scale, strain[:, :, 1], strain_terms[1]),
    ]
    normal = [
        harmonics(False, -1 / pi, displacement[:, :, 0, 0], X[0, 0], mean[0, 0]),
        harmonics(True, -1 / pi, displacement[:, :, 0, 1], X[0, 1]),
    ]
    tangential = [harmonics(False, 1 / pi, displacement[:, :, 1, 1], X[1, 1], mean[1, 1])]
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


class _Parts(NamedTuple):
    """The compliances of a rolling cylinder by harmonics, as a sum of parts with a creep each.

    Attributes
    ----------
    spectrum : Spectrum
        Compliances relative to the first creep compliance, J_n.
    tails : list of (powers, 2, 2) arrays
        Coefficients of 1/n^j of each part.
    creeps : list of Creep
    ratios : list of (n,) arrays
        Creep compliances relative to the first one.
    """

    spectrum: Spectrum
    tails: list[Array]
    creeps: list[Creep]
    ratios: list[Array]


def _parts(
    radius: float,
    layers: Layers,
    relaxations: tuple[Relaxation, ...],
    open_bore: bool,
    constant_bulk: tuple[bool, ...],
) -> _Parts:
    """Return the compliances by harmonics; parameters as of :func:`layered_kernels`."""

    def factors(n: Array) -> Array:
        """Return E(in/R)/E_inf, or G(in/R)/G_inf with a constant bulk modulus, (L, n)."""
        return np.array([modulus_ratio(relaxation, n / radius) for relaxation in relaxations])

    if len(layers) == 1 and not constant_bulk[0]:
        # all compliances of a single layer vary as J_n: X_n is elastic
        spectrum = _elastic_spectrum(layers, open_bore)
    else:
        spectrum = _spectrum(layers, open_bore, RelaxingModuli(factors, constant_bulk))
    bulk, n = spectrum.bulk, np.arange(1.0, spectrum.Y.shape[-1])
    tails, creeps, ratios = [spectrum.tail], [creep(relaxations[0])], [np.ones(n.size)]
    if bulk is not None:
        A_rt, G = (float(layers[0][k] or 0.0) for k in (3, 4))  # never None
        tails.append(bulk.tail)
        creeps.append(creep(bulk_relaxation(A_rt, G, relaxations[0])))
        ratios.append(bulk.creep_ratio(n))
    return _Parts(spectrum, tails, creeps, ratios)


class SplitSum(NamedTuple):
    """One influence function: its even and its odd sum, and the amplitudes of its lag, (M,)."""

    even: HarmonicSum
    odd: HarmonicSum
    lag_amplitudes: Array


class CreepPart:
    """A creep compliance over the harmonics n (N,), as closed forms and expansions need it.

    Attributes
    ----------
    creep : Creep
    eps : (M,) array
        l_m/R of its terms.
    has_lag, is_expanded : (M,) bool arrays
        The terms with a lag, and those that are expanded.
    lag_series : (lags, POWERS) complex array
        Power series of theta in addition to the lags; see :func:`.lag.periodic_series`.
    """

    def __init__(self, radius: float, compliance: Creep) -> None:
        self.creep, self.eps = compliance, compliance.length / radius
        self.has_lag, self.is_expanded = self.eps <= EXPANDED_ABOVE, self.eps > EXPANDED_ABOVE
        self.lag_series = periodic_series(self.eps[self.has_lag])

    def compliance(self, n: Array) -> tuple[Array, Array]:
        """Return J_n, and the sum of its expanded terms, at harmonics n, complex (N,) each."""
        retardation, delayed = 1 / (1 + 1j * n[:, None] * self.eps), self.creep.delayed
        J = self.creep.instantaneous + retardation @ delayed
        return J, retardation[:, self.is_expanded] @ delayed[self.is_expanded]

    def split(self, a: Array) -> tuple[Array, Array, Array]:
        """Split J_n A(1/n), A(x) = a_0 + a_1 x + ... + a_J x^J.

        Returns
        -------
        powers : (J+1,) complex array
            Coefficients of 1/n^j: the quotients B of the divisions, and the expanded terms.
        expanded : (J+1,) complex array
            The part of ``powers`` that is due to the expanded terms.
        amplitude : (lags,) complex array
            Of the sums 1/(1 + i n eps).
        """
        j_0, j, _ = self.creep
        B, value = _divide(a, -1j * self.eps[self.has_lag])
        powers = j_0 * a
        powers[1:] += B @ j[self.has_lag]
        expanded = np.zeros(a.size, dtype=complex)
        for m in np.flatnonzero(self.is_expanded):
            series = -((1j / self.eps[m]) ** np.arange(a.size))  # of 1/(1 + i eps/x) in x
            series[0] = 0.0
            expanded += j[m] * np.convolve(a, series)[: a.size]
        return powers + expanded, expanded, value * j[self.has_lag]


class ViscoelasticSums:
    """Sums of J_n X_n over the harmonics, J_n the creep compliance of the outermost layer.

    A term of J_n with eps <= EXPANDED_ABOVE has a lag in closed form; one with a larger eps, which
    varies slowly around the circle, is expanded in powers of 1/n.  With a constant bulk modulus the
    powers of 1/n have two parts with creep compliances of their own.

    Parameters
    ----------
    radius : float
        R [m].
    creeps : sequence of Creep
        Of each part.
    terms : int
        Number of harmonics.

    Attributes
    ----------
    n : (N,) array
        Harmonics from 1; more than ``terms`` if that serves the expanded terms.
    J, J_expanded : (parts, N) complex arrays
        J_n of each part, and the sum of its expanded terms.
    """

    def __init__(self, radius: float, creeps: Sequence[Creep], terms: int) -> None:
        self.radius = radius
        self.parts = [CreepPart(radius, each) for each in creeps]
        is_expanded = any(part.is_expanded.any() for part in self.parts)
        harmonics = max(terms, MIN_EXPANDED_TERMS) if is_expanded else terms
        self.n = np.arange(1.0, 1 + harmonics)
        self._inverse_powers = (1 / self.n) ** np.arange(HIGHEST_POWER + 1)[:, None]
        compliances = [part.compliance(self.n) for part in self.parts]
        self.J, self.J_expanded = (np.array(each) for each in zip(*compliances, strict=True))
        lengths = [part.creep.length[part.has_lag] for part in self.parts]
        self.lag_length = np.concatenate(lengths)
        self.lag_series = np.concatenate([part.lag_series for part in self.parts])

    def powers(self, a: Array) -> Array:
        """Return a_0 + a_1/n + ... of all harmonics, (N,)."""
        return np.asarray(a @ self._inverse_powers[: a.size])

    def split(self, odd: bool, scale: float, a: Array, remainder: Array, mean: float) -> SplitSum:
        """Split scale * [mean + sum_n (sum_i J_n,i A_i(1/n) + J_n,0 remainder_n) trig(n t/R)].

        A_i(x) = a_i0 + a_i1 x + ... + a_iJ x^J of the part i.

        Parameters
        ----------
        odd : bool
            True for sines of an elastic body, False for cosines.
        scale : float
        a : (parts, J+1) array
        remainder : (N,) array
            Relative to the first creep compliance.
        mean : float

        Notes
        -----
        J_n A(1/n) = powers(1/n) + sum_m j_m A(-i eps_m)/(1 + i n eps_m): the sum over m is the lag,
        and ``powers`` contains the quotients B of the divisions and the expanded terms, whose
        truncation error is added to the remainder.
        """
        a = a.astype(complex)
        remainder = np.append(remainder, np.zeros(self.n.size - remainder.size)) * self.J[0]
        powers, amplitudes = np.zeros(a.shape[1], dtype=complex), []
        for part, a_i, J_expanded in zip(self.parts, a, self.J_expanded, strict=True):
            part_powers, expanded, amplitude = part.split(a_i)
            powers += part_powers
            amplitudes.append(amplitude)
            if part.is_expanded.any():
                remainder += self.powers(a_i) * J_expanded - self.powers(expanded)
        # Im(Y e^{i n theta}) = Re(-i Y e^{i n theta}); its real part multiplies cos, its imaginary
        # part -sin
        phase: complex = -1j if odd else 1.0
        c, terms = phase * powers, phase * remainder
        amplitude = scale * phase * np.concatenate(amplitudes)
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

        The kernels are in the order of the sums; the lag is None if no term of J_n has one.  Of the
        singular terms of a kernel, Dirac(t) and ln|t| come from its even sum, and 1/t and sgn(t)
        from its odd one.
        """
        lag, kernels = None, []
        sums = HarmonicSums(tuple(p.even for p in split_sums) + tuple(p.odd for p in split_sums))
        smooth = EvenPlusOdd(sums)
        if self.lag_length.size:
            lag = Lag(
                self.lag_length,
                np.array([split_sum.lag_amplitudes for split_sum in split_sums]),
                (pi + 1) * self.radius,  # largest distance: more than half the circumference
            )
        for k, split_sum in enumerate(split_sums):
            odd = split_sum.odd.kernel()
            kernel = replace(
                split_sum.even.kernel(),
                inverse=odd.inverse,
                sign=odd.sign,
                smooth=smooth.select(k).first,  # as one array, without the axis of the kernels
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
        """Return the smooth part of influence function ``kernel``, from the same table."""
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
    """Return the second integral of an influence function without its lag, at any t [m].

    ``HarmonicSum.second_integral`` leaves out the power series of theta, which is integrated here.
    """
    even, odd, _ = split_sum
    assert even.regular is not None
    assert odd.regular is not None
    k, theta = np.arange(POWERS), t / even.radius
    c = (even.regular + odd.regular) / ((k + 1) * (k + 2))  # theta^k integrated twice
    regular = (t * t) * np.polynomial.polynomial.polyval(theta, c)
    return np.asarray(even.second_integral(t) + odd.second_integral(t) + regular)
