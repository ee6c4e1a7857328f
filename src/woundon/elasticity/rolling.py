r"""The kernels of rolling bodies with isotropic viscoelastic layers of constant Poisson's ratio.

In steady rolling the material at an angle theta meets the n-th harmonic of the loads n times a
turn, so that e^{in theta} sees the modulus E(in/R) (:mod:`.relaxation`): the layers' own code with
complex moduli.  With Y_n of :mod:`.layers` an elastic sum of cosines becomes Re sum Y_n e^{in
theta}, one of sines Im sum Y_n e^{in theta}: even and odd parts, each a sum of :mod:`.fourier`.
Over a half-plane the same holds with the wave number k in place of n/R.

Short waves feel the outermost layer alone.  With its creep compliance J_n taken out,
Y_n = J_n X_n / E_inf, X_n tends to the elastic powers of 1/n as fast as an elastic body's does,
however fast the layer relaxes.  For each retardation length, eps = l/R, a polynomial in x = 1/n
leaves

    A(x)/(1 + in eps) = A(-i eps)/(1 + in eps) + x B(x),       A(x) = A(-i eps) + (x + i eps) B(x),

powers like the elastic ones, and a single sum for :mod:`.lag`.  Where eps > 1 the left side itself
is taken in powers of 1/n, which cancel otherwise.
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
from .lag import Lag, around
from .layers import Layers
from .relaxation import Creep, Relaxation, creep, factor

__all__ = ["half_plane_kernels", "layered_kernels"]

Array = np.ndarray

SLOW = 1.0  # eps above which a retardation is expanded in powers of 1/n
LEAST_TERMS = 128  # then they are so many, which leave 1e-12


@lru_cache(maxsize=16)
def half_plane_kernels(
    stiffness: tuple[float, ...], relaxation: Relaxation, reach: float
) -> SurfaceKernels:
    """Return the influence functions of a rolling viscoelastic half-plane.

    Parameters
    ----------
    stiffness : tuple of float
        A_rr, A_tt, A_rt, G, D [Pa] after all relaxation.
    relaxation : tuple of (g_k, c_k)
    reach : float
        Largest distance that is asked for [m].
    """
    A, B, C = coefficients(*stiffness)
    j_0, j, length = creep(relaxation)
    pole, pulse = j / pi + 0j, -1j * j / pi
    gradients = np.array([C * pole, A * pulse, A * pulse, -B * pole])
    moved = -length * np.array([C * pole, -A * pulse, -A * pulse, -B * pole])
    slopes, places = (Lag(length, g, reach) for g in (gradients, moved))
    sign, step = partial(Kernel, sign=-A / 2), partial(Kernel, delta=-A * j_0)
    return SurfaceKernels(
        normal_p=Kernel(log=C / pi, lag=places.one(0)),
        normal_q=sign(lag=places.one(1)),
        tangent_p=sign(lag=places.one(2)),
        tangent_q=Kernel(log=-B / pi, lag=places.one(3)),
        slope_p=Kernel(inverse=C * j_0 / pi, lag=slopes.one(0)),
        slope_q=step(lag=slopes.one(1)),
        strain_p=step(lag=slopes.one(2)),
        strain_q=Kernel(inverse=-B * j_0 / pi, lag=slopes.one(3)),
        uniform_strain=-A,
        lag=slopes,
    )


def layered_kernels(
    radius: float, layers: Layers, relaxations: tuple[Relaxation, ...], free: bool = False
) -> SurfaceKernels:
    """Return the influence functions of a rolling cylinder of layers, some of them viscoelastic.

    Parameters
    ----------
    radius, layers, free
        As of :func:`.cylinder.layered_kernels`, stiffness after all relaxation.
    relaxations : tuple of tuples of (g_k, c_k)
        Of each layer, empty where elastic.
    """
    return _kernels(float(radius), layers, relaxations, free)


@lru_cache(maxsize=16)
def _kernels(
    R: float, layers: Layers, relaxations: tuple[Relaxation, ...], free: bool
) -> SurfaceKernels:
    def factors(n: Array) -> Array:
        return np.array([factor(relaxation, n / R) for relaxation in relaxations])

    alone = len(layers) == 1  # its own factor is all
    made = _elastic_spectrum(layers, free) if alone else _spectrum(layers, free, factors)
    Y, tail, J, decay, error = made
    n = np.arange(1.0, Y.shape[-1])
    mean, Y = Y[..., 0].real / 2, Y[..., 1:]
    still, moved = tail[: J + 1], tail[1 : J + 2]
    stretch, sums = still[:, 0] + moved[:, 1], Y[0] + n * Y[1]
    surface = Surface(R, creep(relaxations[0]), n.size)
    wave, slope = -1 / pi, 1 / (pi * R)
    parts = [
        surface.sum(odd, scale, a, c - surface.powers(a)[: n.size], mean)
        for odd, scale, a, c, mean in (
            (True, slope, moved[:, 0, 0], n * Y[0, 0], 0.0),
            (False, -slope, moved[:, 0, 1], n * Y[0, 1], 0.0),
            (False, -slope, stretch[:, 0], sums[0], mean[0, 0]),
            (True, -slope, stretch[:, 1], sums[1], 0.0),
            (False, wave, still[:, 0, 0], Y[0, 0], mean[0, 0]),
            (True, wave, still[:, 0, 1], Y[0, 1], 0.0),
            (False, -wave, still[:, 1, 1], Y[1, 1], mean[1, 1]),
        )
    ]
    kernels, together, lag = surface.kernels(parts[:4])
    slope_p, slope_q, strain_p, strain_q = kernels
    (normal_p, coupling), _, _ = surface.kernels(parts[4:6])
    (tangent_q,), _, _ = surface.kernels(parts[6:])  # often nobody asks for its table
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
        together=together,
        lag=lag,
    )


class Part(NamedTuple):
    """One influence function: its even and its odd sum, and the amplitudes of its lags (M,)."""

    even: HarmonicSum
    odd: HarmonicSum
    lag: Array


class Surface:
    """Sums over harmonics in proportion to the creep compliance of the outermost layer.

    Parameters
    ----------
    radius : float
        R [m].
    compliance : Creep
    terms : int
        How many harmonics there are to sum.
    """

    def __init__(self, radius: float, compliance: Creep, terms: int) -> None:
        self.radius, self.compliance = radius, compliance
        eps = compliance.length / radius
        self.fast, self.slow = eps <= SLOW, eps > SLOW
        self.eps, self.regular = eps, around(eps[self.fast])
        self.n = np.arange(1.0, 1 + (max(terms, LEAST_TERMS) if self.slow.any() else terms))
        self._powers = (1 / self.n) ** np.arange(HIGHEST_POWER + 1)[:, None]
        creeps = 1 / (1 + 1j * self.n[:, None] * eps)
        self.retarded = creeps[:, self.slow] @ compliance.share[self.slow]
        self.whole = compliance.at_once + creeps @ compliance.share

    def powers(self, a: Array) -> Array:
        """Return a_0 + a_1/n + ... of all harmonics, (N,)."""
        return np.asarray(a @ self._powers[: a.size])

    def sum(self, odd: bool, scale: float, a: Array, rest: Array, mean: float) -> Part:
        """Return scale * [mean + sum_n J_n (a_0 + a_1/n + ... + rest_n) trig(n t/R)].

        Parameters
        ----------
        odd : bool
            Whether the sum of elastic coefficients is one of sines.
        scale : float
        a : (J+1,) array
        rest : (N,) array
        mean : float
        """
        j_0, j, _ = self.compliance
        a = a.astype(complex)
        B, amplitude = _divided(a, -1j * self.eps[self.fast])
        powers = j_0 * a
        powers[1:] += B @ j[self.fast]
        rest = np.append(rest, np.zeros(self.n.size - rest.size)) * self.whole
        if self.slow.any():
            slowly = np.zeros(a.size, dtype=complex)
            for m in np.flatnonzero(self.slow):
                series = -((1j / self.eps[m]) ** np.arange(a.size))  # of 1/(1 + i eps/x)
                series[0] = 0.0
                slowly += j[m] * np.convolve(a, series)[: a.size]
            powers += slowly
            rest += self.powers(a) * self.retarded - self.powers(slowly)
        turn: complex = -1j if odd else 1.0
        c, left = turn * powers, turn * rest
        amplitude = scale * turn * amplitude * j[self.fast]
        regular = (amplitude @ self.regular).real
        is_even = np.arange(POWERS) % 2 == 0
        return Part(
            HarmonicSum(
                False, self.radius, scale, mean, c.real, left.real, np.where(is_even, regular, 0.0)
            ),
            HarmonicSum(
                True, self.radius, -scale, 0.0, c.imag, left.imag, np.where(is_even, 0.0, regular)
            ),
            1j * self.radius * amplitude,
        )

    def kernels(self, parts: list[Part]) -> tuple[list[Kernel], _Together, Lag | None]:
        """Return the influence functions, their smooth parts at once, and their lags."""
        lag, made, together = None, [], _Together.of(parts)
        if self.fast.any():
            length, R = self.compliance.length[self.fast], self.radius
            lag = Lag(length, np.array([part.lag for part in parts]), (pi + 1) * R)
        for k, part in enumerate(parts):
            even, odd = part.even.kernel(), part.odd.kernel()
            made.append(
                replace(
                    even,
                    inverse=odd.inverse,
                    sign=odd.sign,
                    smooth=_Alone(together.one(k)),
                    twice=_Twice(part),
                    lag=None if lag is None else lag.one(k),
                )
            )
        return made, together, lag


def _divided(a: Array, z: Array) -> tuple[Array, Array]:
    """Return B (J, M) and A(z) of A(x) = A(z) + (x - z) B(x) for z (M,), powers upwards."""
    B, value = np.empty((a.size - 1, z.size), dtype=complex), np.full(z.size, a[-1])
    for k in range(a.size - 2, -1, -1):
        B[k] = value
        value = a[k] + z * value
    return B, value


@dataclass(frozen=True)
class _Together:
    """Smooth parts of several kernels at once, even and odd."""

    sums: HarmonicSums

    @classmethod
    def of(cls, parts: list[Part]) -> _Together:
        return cls(HarmonicSums(tuple(p.even for p in parts) + tuple(p.odd for p in parts)))

    def one(self, kernel: int) -> _Together:
        """Return the smooth part of one of the kernels, by the table of all."""
        return _Together(self.sums.some(slice(kernel, None, len(self.sums.sums) // 2)))

    def __call__(self, t: Array) -> Array:
        values = self.sums(t)
        half = len(values) // 2
        return values[:half] + values[half:]


@dataclass(frozen=True)
class _Alone:
    """The smooth part of one kernel."""

    both: _Together

    def __call__(self, t: Array) -> Array:
        return np.asarray(self.both(t)[0])


@dataclass(frozen=True)
class _Twice:
    """The second integral of one kernel but for its lag."""

    part: Part

    def __call__(self, t: Array) -> Array:
        even, odd, _ = self.part
        assert even.power is not None
        assert odd.power is not None
        k, theta = np.arange(POWERS), t / even.radius
        c = (even.power + odd.power) / ((k + 1) * (k + 2))
        regular = (t * t) * np.polynomial.polynomial.polyval(theta, c)
        return np.asarray(even.twice(t) + odd.twice(t) + regular)
