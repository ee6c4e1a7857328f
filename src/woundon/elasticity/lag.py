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
PER_E = 16  # steps of the table in ln|t| per unit: the error of the quintics is 1e-10
# Smallest distance in the table, relative to the largest, and to the shortest retardation length.
SMALLEST_DISTANCE, SMALLEST_LENGTH = 1e-10, 0.01
RANK_TOLERANCE = 1e-15  # singular value below which a kernel is a combination of others
UPWARDS = 0.2  # eps above which the recurrence starts at P_0
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

    def evaluate(self, t: Array, order: int = 0) -> Array:
        """Return a derivative of the second integrals at t (k,) without the table, (kernels, k).

        ``order`` 0: the second integrals, 1: their slopes, 2: the kernels.
        """
        return _sum_lengths(self.amplitude, _psi(self.length, t)[order])

    @cached_property
    def _basis(self) -> tuple[Array, Array]:
        """A basis of the amplitudes, (r, M), and the coefficients of the kernels, (kernels, r).

        Only linearly independent kernels are tabulated, found by singular values.
        """
        if len(self.amplitude) > 1:
            parts = np.hstack([self.amplitude.real, self.amplitude.imag])
            left, values, rows = np.linalg.svd(parts, full_matrices=False)
            independent = values > RANK_TOLERANCE * values[0]
            if not independent.all():
                rows, M = rows[independent], self.length.size
                coefficients = left[:, independent] * values[independent]
                return rows[:, :M] + 1j * rows[:, M:], coefficients
        return self.amplitude, np.eye(len(self.amplitude))

    @cached_property
    def _steps(self) -> int:
        """Steps of the table on either side of t = 0."""
        relative = SMALLEST_LENGTH * float(self.length.min()) / self.max_distance
        return ceil(-log(min(SMALLEST_DISTANCE, relative)) * PER_E)

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """Quintics in ln|t| of the basis, (6, r, 2 steps), and coefficients, (kernels, r).

        The steps of t < 0 precede those of t > 0.
        """
        basis, coefficients = self._basis
        lengths = tuple(self.length.tolist())
        tabulated = _tabulated_psi(lengths, self.max_distance, self._steps)
        f, d, s = (_sum_lengths(basis, psi) for psi in tabulated)
        step = _table_distances(self.max_distance, self._steps) / PER_E
        # derivatives by ln|t|, in units of a step
        values = np.array([f, d * step, s * step**2 + d * step / PER_E])
        table = quintics(values.reshape(3, len(basis), 2, -1))
        return np.moveaxis(table, -1, 0).reshape(6, len(basis), -1), coefficients

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
        x = (logarithm * PER_E).ravel()
        x += steps - log(self.max_distance) * PER_E
        below = np.exp(np.minimum(x, 0.0) * (2 / PER_E)) if x.min() < 0 else None
        if below is not None:
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
        if below is not None:  # below the smallest distance Psi varies about as t^2
            y *= below
        return np.tensordot(coefficients, y.reshape(-1, *logarithm.shape), axes=1)


Psi = tuple[Array, Array]  # real part, and minus the imaginary part, of each length


def _sum_lengths(amplitude: Array, psi: Psi) -> Array:
    """Return Re sum_m g_m Psi_m, (kernels, k)."""
    return np.asarray(amplitude.real @ psi[0] + amplitude.imag @ psi[1])


def _psi(length: Array, t: Array) -> list[Psi]:
    """Return Psi, Psi' and Psi'' = Phi at t (k,), for each length."""
    scale, u = length[:, None], t / length[:, None]
    downstream = np.maximum(u, 0.0)
    decay = np.expm1(-downstream)  # e^{-u} - 1
    steps = (decay + downstream, -decay, np.where(u > 0, 1 + decay, 0.0))
    scales = (scale, np.ones(1), 1 / scale)
    return [
        (factor * pole, pi * factor * step)
        for factor, pole, step in zip(scales, _pole_integrals(u), steps, strict=True)
    ]


def _table_distances(max_distance: float, steps: int) -> Array:
    """Return the t of the table: the negative ones, then the positive ones [m]."""
    t = max_distance * np.exp(np.arange(-steps, 1) / PER_E)
    return np.concatenate([-t, t])


@lru_cache(maxsize=2)  # the gradients and the displacements of a body use the same values
def _tabulated_psi(length: tuple[float, ...], max_distance: float, steps: int) -> list[Psi]:
    """Return :func:`_psi` at the distances of the table."""
    return _psi(np.array(length), _table_distances(max_distance, steps))


def _pole_integrals(u: Array) -> tuple[Array, Array, Array]:
    """Return K, K' and K'' = F = e^{-u} Ei(u); for |u| < 1 by their power series."""
    size = np.maximum(np.abs(u), 1e-300)
    near = size < 1
    logarithm = np.log(size) + GAMMA
    F = np.empty(u.shape)
    F[~near] = _scaled_exponential_integral(u[~near])
    z = u[near]
    higher = np.full(z.size, SERIES[-1])  # terms of order u^2 and more of sum -H_k (-u)^k/k!
    for c in SERIES[-2::-1]:
        higher *= z
        higher += c
    higher *= z * z
    log_near, decay, series = logarithm[near], np.expm1(-z), z + higher
    F[near] = (1 + decay) * log_near + series
    first, K = logarithm - F, (u - 1) * logarithm - u + F
    first[near] = -decay * log_near - series
    K[near] = (decay + z) * log_near + higher
    return K, first, F


def _scaled_exponential_integral(u: Array) -> Array:
    """Return F = e^{-u} Ei(u) for |u| >= 1; for |u| > 50 by its asymptotic series."""
    from scipy.special import exp1, expi  # problems are read and written without SciPy

    far = np.abs(u) > 50
    F, z = np.empty(u.shape), 1 / u[far]
    series = np.zeros(z.shape)
    for k in range(20, 0, -1):
        series = k * z * (1 + series)
    F[far] = z * (1 + series)
    z = u[~far]
    positive, Ei = z > 0, np.empty(z.size)
    Ei[positive], Ei[~positive] = expi(z[positive]), -exp1(-z[~positive])
    F[~far] = np.exp(-z) * Ei
    return F


def periodic_series(eps: Array) -> Array:
    """Return the power series of P(theta) for each eps = l/R, (eps, K) complex."""
    p = polylogarithm(0).power
    out = np.empty((eps.size, p.size), dtype=complex)
    for P, e in zip(out, eps.tolist(), strict=True):
        if e >= UPWARDS:
            from scipy.special import psi

            start = 0
            P[0] = (1j / e) * (psi(1 - 1j / e) + log(e) + 0.5j * pi)
        else:
            start = min(p.size - 1, int(2 * pi / e))
            P[start] = p[start]
        for k in range(start - 1, -1, -1):
            P[k] = p[k] - e * (k + 1) * P[k + 1]
        for k in range(start, p.size - 1):
            P[k + 1] = (p[k] - P[k]) / (e * (k + 1))
    return out
