r"""Influence functions of a rolling viscoelastic surface, relative to an elastic one.

The response of a surface with the creep compliance 1 - e^{-t/theta} to a moving load is a weighted
mean of the elastic influence function k over the retardation length l = V theta,

    (1 + l d/dt)^{-1} k  (t) = int_0^inf e^{-z} k(t - l z) dz .

For the pole and the Dirac pulse of an elastic surface, 1/(t + i0) = 1/t - i pi Dirac(t), it is

    Phi(t) = [F(u) - i pi e^{-u} H(u)]/l,     F(u) = e^{-u} Ei(u),     u = t/l,

H the unit step.  Phi has a logarithm and a step at t = 0 and decays as 1/t and e^{-u}, so that it
is not interpolated by polynomials.  Its second integral is known, Phi = Psi'' with

    Psi(t) = l [K(u) - i pi H(u) (u - 1 + e^{-u})],
    K(u)   = (u - 1) (gamma + ln|u|) - u + F(u) = sum_{k>=2} (-u)^k/k! (gamma + ln|u| - H_k),

and second differences of Psi integrate Phi exactly against hat functions, for any l.  The influence
functions are Re sum_m g_m Phi(t; l_m); the sums over m are tabulated over ln|t|.

On a circle, eps = l/R,

    sum_{n>=1} e^{in theta}/(1 + in eps) = i Phi(theta; eps) + P(theta),   (1 + eps d/dtheta) P = p,

with the regular part p of sum e^{in theta} = i/(theta + i0) + p, a power series of radius 2 pi.
The coefficients of P follow from the recurrence P_k + eps (k+1) P_(k+1) = p_k.  It is stable
upwards for k > 2 pi/eps and downwards below: for large eps it starts at
P_0 = (i/eps) [psi(1 - i/eps) + ln eps + i pi/2], otherwise at k = 2 pi/eps in both directions.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil, factorial, log, pi

import numpy as np

from .fourier import polylogarithm, quintics

__all__ = ["Lag", "periodic_series"]

Array = np.ndarray

GAMMA = float(np.euler_gamma)
STEPS_PER_E = 16  # steps of the table per unit of ln|t|: the error of the quintics is 1e-10
# Smallest distance in the table, relative to the largest, and to the shortest retardation length.
SMALLEST_DISTANCE, SMALLEST_LENGTH = 1e-10, 0.01
RANK_TOLERANCE = 1e-15  # singular value below which a kernel is a combination of others
UPWARD_ABOVE = 0.2  # eps above which the recurrence starts at P_0
# coefficients -H_k (-1)^k/k! of u^k, k = 2 ... 21, H_k the harmonic numbers
SERIES = [-((-1) ** k) / factorial(k) * sum(1 / m for m in range(1, k + 1)) for k in range(2, 22)]


@dataclass(frozen=True, eq=False)
class Lag:
    """Influence functions Re sum_m g_m Phi(t; l_m), evaluated by their second integrals.

    Parameters
    ----------
    length : (M,) array
        l_m [m].
    amplitude : (kernels, M) complex array
        g_m.
    max_distance : float
        Largest |t| [m].
    """

    length: Array
    amplitude: Array
    max_distance: float

    def select(self, kernel: int) -> Lag:
        """Return one of the kernels."""
        return Lag(self.length, self.amplitude[kernel : kernel + 1], self.max_distance)

    @np.errstate(under="ignore")  # t^2 and exp(-t/l) of far points vanish
    def evaluate(self, t: Array, order: int = 0) -> Array:
        """Return second integrals, slopes or kernels at t (k,) in closed form, (kernels, k).

        ``order`` is that of the derivative of the second integrals: 0, 1 or 2.
        """
        return _sum_lengths(self.amplitude, _psi(self.length, t)[order])

    @cached_property
    def _independent_lags(self) -> tuple[Array, Array]:
        """Amplitudes of linearly independent lags, (r, M), and coefficients, (kernels, r).

        The kernels are combinations of the independent lags with these coefficients.  Only the
        independent lags are tabulated; they follow from a singular value decomposition.
        """
        if len(self.amplitude) > 1:
            parts = np.hstack([self.amplitude.real, self.amplitude.imag])
            U, singular_values, V = np.linalg.svd(parts, full_matrices=False)
            independent = singular_values > RANK_TOLERANCE * singular_values[0]
            if not independent.all():
                V, M = V[independent], self.length.size
                coefficients = U[:, independent] * singular_values[independent]
                return V[:, :M] + 1j * V[:, M:], coefficients
        return self.amplitude, np.eye(len(self.amplitude))

    @cached_property
    def _steps(self) -> int:
        """Number of steps of the table on either side of t = 0."""
        relative = SMALLEST_LENGTH * float(self.length.min()) / self.max_distance
        return ceil(-log(min(SMALLEST_DISTANCE, relative)) * STEPS_PER_E)

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """Quintics in ln|t| of the independent lags, (6, r, 2 steps), and the coefficients above.

        The steps of t < 0 precede those of t > 0.
        """
        amplitudes, coefficients = self._independent_lags
        lengths = tuple(self.length.tolist())
        tabulated = _tabulated_psi(lengths, self.max_distance, self._steps)
        value, slope, second = (_sum_lengths(amplitudes, psi) for psi in tabulated)
        step = _table_distances(self.max_distance, self._steps) / STEPS_PER_E
        # derivatives by ln|t|, in units of a step: d/dln t = t d/dt; the halves: t < 0, t > 0
        values = np.array([value, slope * step, second * step**2 + slope * step / STEPS_PER_E])
        table = quintics(values.reshape(3, len(amplitudes), 2, -1))
        return np.moveaxis(table, -1, 0).reshape(6, len(amplitudes), -1), coefficients

    @np.errstate(under="ignore")  # t^2 and exp(-t/l) of far points vanish
    def second_integral(self, negative: Array, logarithm: Array) -> Array:
        """Return the second integrals from the table, (kernels, *shape).

        Parameters
        ----------
        negative : array of bool
            True where t < 0.
        logarithm : array
            ln|t|.
        """
        steps, (table, coefficients) = self._steps, self._table
        x = (logarithm * STEPS_PER_E).ravel()
        x += steps - log(self.max_distance) * STEPS_PER_E  # in steps; < 0 below the table
        # below the smallest distance the second integrals vary about as t^2
        small_t_factor = np.exp(np.minimum(x, 0.0) * (2 / STEPS_PER_E)) if x.min() < 0 else None
        if small_t_factor is not None:
            np.maximum(x, 0.0, out=x)
        i = x.astype(np.intp)
        np.minimum(i, steps - 1, out=i)
        x -= i
        i += np.where(negative.ravel(), 0, steps)
        c = table.take(i, axis=-1)
        y = c[5] * x
        for power in (4, 3, 2, 1):
            y += c[power]
            y *= x
        y += c[0]
        if small_t_factor is not None:
            y *= small_t_factor
        return np.tensordot(coefficients, y.reshape(-1, *logarithm.shape), axes=1)


Psi = tuple[Array, Array]  # real part, and minus the imaginary part, of each length


def _sum_lengths(amplitude: Array, psi: Psi) -> Array:
    """Return Re sum_m g_m Psi_m, (kernels, k)."""
    return np.asarray(amplitude.real @ psi[0] + amplitude.imag @ psi[1])


def _psi(length: Array, t: Array) -> list[Psi]:
    """Return Psi, Psi' and Psi'' = Phi at t (k,), for each length.

    The real parts are l K, K' and F/l.  Minus the imaginary parts are pi times the integrals of the
    step e^{-u} H(u): l (u - 1 + e^{-u}), 1 - e^{-u} and e^{-u}/l for u > 0.
    """
    scale, u = length[:, None], t / length[:, None]
    positive_u = np.maximum(u, 0.0)
    decay = np.expm1(-positive_u)  # e^{-u} - 1
    steps = (decay + positive_u, -decay, np.where(u > 0, 1 + decay, 0.0))
    scales = (scale, np.ones(1), 1 / scale)
    return [
        (factor * pole, pi * factor * step)
        for factor, pole, step in zip(scales, _integrals_of_pole(u), steps, strict=True)
    ]


def _table_distances(max_distance: float, steps: int) -> Array:
    """Return the t of the table: the negative ones, then the positive ones [m]."""
    t = max_distance * np.exp(np.arange(-steps, 1) / STEPS_PER_E)
    return np.concatenate([-t, t])


@lru_cache(maxsize=2)  # the gradients and the displacements of a body use the same values
def _tabulated_psi(length: tuple[float, ...], max_distance: float, steps: int) -> list[Psi]:
    """Return :func:`_psi` at the distances of the table."""
    return _psi(np.array(length), _table_distances(max_distance, steps))


def _integrals_of_pole(u: Array) -> tuple[Array, Array, Array]:
    """Return K, K' and K'' = F = e^{-u} Ei(u), like u; for |u| < 1 by their power series.

    With L = gamma + ln|u| and S = e^{-u} sum_{k>=1} u^k/(k k!) = -sum_{k>=1} H_k (-u)^k/k!,

        F = e^{-u} L + S,    K' = L - F,    K = (u - 1) L - u + F.
    """
    size = np.maximum(np.abs(u), 1e-300)
    is_small = size < 1
    logarithm = np.log(size) + GAMMA
    F = np.empty(u.shape)
    F[~is_small] = _scaled_exponential_integral(u[~is_small])
    z = u[is_small]
    higher = np.full(z.size, SERIES[-1])  # S - u by Horner's scheme
    for c in SERIES[-2::-1]:
        higher *= z
        higher += c
    higher *= z * z
    logarithm_small, decay, series = logarithm[is_small], np.expm1(-z), z + higher
    F[is_small] = (1 + decay) * logarithm_small + series
    slope, K = logarithm - F, (u - 1) * logarithm - u + F
    slope[is_small] = -decay * logarithm_small - series
    K[is_small] = (decay + z) * logarithm_small + higher
    return K, slope, F


def _scaled_exponential_integral(u: Array) -> Array:
    """Return F = e^{-u} Ei(u), like u, for |u| >= 1; for |u| > 50 by its asymptotic series."""
    from scipy.special import exp1, expi  # problems are read and written without SciPy

    is_asymptotic = np.abs(u) > 50
    F, z = np.empty(u.shape), 1 / u[is_asymptotic]
    series = np.zeros(z.shape)
    for k in range(20, 0, -1):
        series = k * z * (1 + series)
    F[is_asymptotic] = z * (1 + series)
    z = u[~is_asymptotic]
    positive, Ei = z > 0, np.empty(z.size)
    Ei[positive], Ei[~positive] = expi(z[positive]), -exp1(-z[~positive])
    F[~is_asymptotic] = np.exp(-z) * Ei
    return F


def periodic_series(eps: Array) -> Array:
    """Return the power series of P(theta) for each eps = l/R, (eps, K) complex.

    P is the regular part of the sum of e^{in theta}/(1 + in eps) over n >= 1.  Its coefficients
    follow from those of the sum of e^{in theta}, p_k, by P_k + eps (k + 1) P_(k+1) = p_k, upwards
    and downwards from a coefficient from where the recurrence is stable.
    """
    p = polylogarithm(0).power
    out = np.empty((eps.size, p.size), dtype=complex)
    for P, e in zip(out, eps.tolist(), strict=True):
        if e >= UPWARD_ABOVE:
            from scipy.special import psi

            start = 0
            P[0] = (1j / e) * (psi(1 - 1j / e) + log(e) + 0.5j * pi)
        else:
            # an estimate suffices: its error decays in both directions
            start = min(p.size - 1, int(2 * pi / e))
            P[start] = p[start]
        for k in range(start - 1, -1, -1):
            P[k] = p[k] - e * (k + 1) * P[k + 1]
        for k in range(start, p.size - 1):
            P[k + 1] = (p[k] - P[k]) / (e * (k + 1))
    return out
