r"""Influence functions of a rolling viscoelastic surface, relative to an elastic one.

A compliance that creeps by 1 - e^{-t/theta} answers a load that rolls past with the past of the
elastic answer k along the surface, weighted over the retardation length l = V theta,

    (1 + l d/dt)^{-1} k  (t) = int_0^inf e^{-z} k(t - l z) dz .

Of the elastic pole and pulse together, 1/(t + i0) = 1/t - i pi Dirac(t), this is

    Phi(t) = [F(u) - i pi e^{-u} H(u)]/l,     F(u) = e^{-u} Ei(u),     u = t/l,

with a logarithm and a step at t = 0, and tails 1/t and e^{-u}: no polynomial follows it.  But it is
integrated in closed form, Phi = Psi'' with

    Psi(t) = l [K(u) - i pi H(u) (u - 1 + e^{-u})],
    K(u)   = (u - 1) (gamma + ln|u|) - u + F(u) = sum_{k>=2} (-u)^k/k! (gamma + ln|u| - H_k),

so that hats take its second differences, exact for a surface that forgets within a cell, or not
within the contact.  Real parts of g Phi serve cosines and sines alike; all lengths are summed once,
on a table over ln|t|.

On a circle 1 + 2 sum cos(n theta) takes the place of the pulse, and

    sum_{n>=1} e^{in theta}/(1 + in eps) = i Phi(theta; eps) + P(theta),   (1 + eps d/dtheta) P = p,

where p is what is regular in sum e^{in theta} = i/(theta + i0) + p.  Its power series has the
radius 2 pi; P comes from it by the recurrence P_k + eps (k+1) P_(k+1) = p_k: upwards from
P_0 = (i/eps) [psi(1 - i/eps) + ln eps + i pi/2] where eps is large, and where it is small both
ways from k = 2 pi/eps, as each is stable there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import ceil, factorial, log, pi

import numpy as np

from .fourier import polylogarithm, quintics

__all__ = ["Lag", "around"]

Array = np.ndarray

GAMMA = float(np.euler_gamma)
PER_E = 16  # steps of the table for each factor e: quintics leave 1e-10
SHORTEST = 1e-10  # distance in the table, of the longest; and a hundredth of the shortest lag
ALIKE = 1e-15  # what kernels that are sums of others may miss
UPWARDS = 0.2  # eps from which the recurrence starts at P_0
SERIES = [-((-1) ** k) / factorial(k) * sum(1 / m for m in range(1, k + 1)) for k in range(2, 22)]


@dataclass(frozen=True, eq=False)
class Lag:
    """Kernels Re sum_m g_m Phi(t; l_m), given by their second integrals.

    Parameters
    ----------
    length : (M,) array
        l_m [m].
    amplitude : (kernels, M) complex array
        g_m.
    reach : float
        Largest distance that is asked for [m].
    """

    length: Array
    amplitude: Array
    reach: float

    def one(self, kernel: int) -> Lag:
        """Return one of the kernels alone."""
        return Lag(self.length, self.amplitude[kernel : kernel + 1], self.reach)

    def exactly(self, t: Array, order: int = 0) -> Array:
        """Return the second integrals at t (k,), or a derivative of them, (kernels, k)."""
        return _summed(self.amplitude, _each(self.length, t)[order])

    @cached_property
    def _basis(self) -> tuple[Array, Array]:
        """Amplitudes of kernels of which all are sums, (r, M), and their shares, (kernels, r).

        Where none is a sum of others, they are their own.
        """
        if len(self.amplitude) > 1:
            parts = np.hstack([self.amplitude.real, self.amplitude.imag])
            shares, size, rows = np.linalg.svd(parts, full_matrices=False)
            kept = size > ALIKE * size[0]
            if not kept.all():
                rows, M = rows[kept], self.length.size
                return rows[:, :M] + 1j * rows[:, M:], shares[:, kept] * size[kept]
        return self.amplitude, np.eye(len(self.amplitude))

    @cached_property
    def _steps(self) -> int:
        """Steps of the table on either side of t = 0."""
        least = min(SHORTEST, 0.01 * float(self.length.min()) / self.reach)
        return ceil(-log(least) * PER_E)

    @cached_property
    def _table(self) -> tuple[Array, Array]:
        """Quintics in ln|t| of which all kernels are sums, and their shares.

        (6, r, 2 steps), t < 0 first, and (kernels, r).
        """
        basis, shares = self._basis
        known = _tabulated(tuple(self.length.tolist()), self.reach, self._steps)
        f, d, s = (_summed(basis, parts) for parts in known)
        step = _distances(self.reach, self._steps) / PER_E
        by_logarithm = np.array([f, d * step, s * step**2 + d * step / PER_E])
        made = quintics(by_logarithm.reshape(3, len(basis), 2, -1))
        return np.moveaxis(made, -1, 0).reshape(6, len(basis), -1), shares

    @property
    def shares(self) -> Array:
        """Coefficients of the kernels by ``parts``, (kernels, r).

        If r is the number of kernels, the parts are the kernels.
        """
        return self._table[1]

    def twice(self, before: Array, logarithm: Array) -> Array:
        """Return the second integrals by whether t < 0 and by ln|t|, (kernels, *shape)."""
        return np.tensordot(self.shares, self.parts(before, logarithm), axes=1)

    def parts(self, before: Array, logarithm: Array) -> Array:
        """Return the second integrals of which those of all kernels are sums, (r, *shape)."""
        steps, table = self._steps, self._table[0]
        x = (logarithm * PER_E).ravel()
        x += steps - log(self.reach) * PER_E
        short = np.exp(np.minimum(x, 0.0) * (2 / PER_E)) if x.min() < 0 else None
        if short is not None:
            np.maximum(x, 0.0, out=x)
        i = x.astype(np.intp)
        np.minimum(i, steps - 1, out=i)
        x -= i
        i += np.where(before.ravel(), 0, steps)
        c = table.take(i, axis=-1)
        y = c[5] * x
        for power in (4, 3, 2, 1):
            y += c[power]
            y *= x
        y += c[0]
        if short is not None:  # like t^2, but for its logarithm
            y *= short
        return y.reshape(-1, *logarithm.shape)


Parts = tuple[Array, Array]  # of each length: by the real part of g, by the imaginary one


def _summed(amplitude: Array, parts: Parts) -> Array:
    """Return sums over the lengths, (kernels, k)."""
    return np.asarray(amplitude.real @ parts[0] + amplitude.imag @ parts[1])


def _each(length: Array, t: Array) -> list[Parts]:
    """Return Psi at t (k,), and both derivatives, of each length."""
    own, u = length[:, None], t / length[:, None]
    after = np.maximum(u, 0.0)
    gone = np.expm1(-after)
    past = (gone + after, -gone, np.where(u > 0, 1 + gone, 0.0))
    scales = (own, np.ones(1), 1 / own)
    return [
        (scale * pole, pi * scale * step)
        for scale, pole, step in zip(scales, _pole(u), past, strict=True)
    ]


def _distances(reach: float, steps: int) -> Array:
    """Return t of the table: at the same distances before 0, then behind it."""
    t = reach * np.exp(np.arange(-steps, 1) / PER_E)
    return np.concatenate([-t, t])


@lru_cache(maxsize=2)  # of a body's gradients as of its displacements
def _tabulated(length: tuple[float, ...], reach: float, steps: int) -> list[Parts]:
    """Return :func:`_each` at the table's distances, before and behind."""
    return _each(np.array(length), _distances(reach, steps))


def _pole(u: Array) -> tuple[Array, Array, Array]:
    """Return K, K' and K'' = F = e^{-u} Ei(u) at u."""
    size = np.maximum(np.abs(u), 1e-300)  # at 0 as near it
    near = size < 1
    logarithm = np.log(size) + GAMMA
    F = np.empty(u.shape)
    F[~near] = _forgotten(u[~near])
    z = u[near]
    rest = np.full(z.size, SERIES[-1])
    for c in SERIES[-2::-1]:
        rest *= z
        rest += c
    rest *= z * z
    own, gone, series = logarithm[near], np.expm1(-z), z + rest
    F[near] = (1 + gone) * own + series
    once, twice = logarithm - F, (u - 1) * logarithm - u + F
    once[near] = -gone * own - series
    twice[near] = (gone + z) * own + rest
    return twice, once, F


def _forgotten(u: Array) -> Array:
    """Return F at |u| >= 1."""
    from scipy.special import exp1, expi  # problems are read and written without SciPy

    far = np.abs(u) > 50
    F, z = np.empty(u.shape), 1 / u[far]
    total = np.zeros(z.shape)
    for k in range(20, 0, -1):
        total = k * z * (1 + total)
    F[far] = z * (1 + total)
    z = u[~far]
    after, integral = z > 0, np.empty(z.size)
    integral[after], integral[~after] = expi(z[after]), -exp1(-z[~after])
    F[~far] = np.exp(-z) * integral
    return F


def around(eps: Array) -> Array:
    """Return the power series P of the harmonics' sum, (eps, K) complex; eps = l/R."""
    p = polylogarithm(0).power
    out = np.empty((eps.size, p.size), dtype=complex)
    for row, e in zip(out, eps.tolist(), strict=True):
        if e >= UPWARDS:
            from scipy.special import psi

            known = 0
            row[0] = (1j / e) * (psi(1 - 1j / e) + log(e) + 0.5j * pi)
        else:
            known = min(p.size - 1, int(2 * pi / e))
            row[known] = p[known]
        for k in range(known - 1, -1, -1):
            row[k] = p[k] - e * (k + 1) * row[k + 1]
        for k in range(known, p.size - 1):
            row[k + 1] = (p[k] - row[k]) / (e * (k + 1))
    return out
