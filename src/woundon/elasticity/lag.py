r"""What a rolling viscoelastic surface adds to the influence functions of an elastic one.

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
from functools import cached_property
from math import ceil, log, pi

import numpy as np

from .fourier import polylogarithm, quintics

__all__ = ["Lag", "around"]

Array = np.ndarray

GAMMA = float(np.euler_gamma)
PER_E = 24  # steps of the table for each factor e: quintics leave 1e-11
SHORTEST = 1e-10  # distance in the table, of the longest; and a hundredth of the shortest lag
FEW = 300  # points that need no table
ALIKE = 1e-15  # what kernels that are sums of others may miss
UPWARDS = 0.2  # eps from which the recurrence starts at P_0


@dataclass(frozen=True, eq=False)
class Lag:
    """Kernels Re sum_m g_m Phi(t; l_m), told by their second integrals.

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
        return self._of(self.amplitude, t, order)

    def _of(self, amplitude: Array, t: Array, order: int) -> Array:
        u = t / self.length[:, None]
        after = np.maximum(u, 0.0)
        past = (np.expm1(-after) + after, -np.expm1(-after), np.where(u > 0, np.exp(-after), 0.0))
        part = (_pole(u, order) - 1j * pi * past[order]) * self.length[:, None] ** (1 - order)
        return np.asarray((amplitude @ part).real)

    @cached_property
    def _basis(self) -> tuple[Array, Array]:
        """Amplitudes of kernels of which all are sums, (r, M), and their shares, (kernels, r)."""
        parts = np.hstack([self.amplitude.real, self.amplitude.imag])
        shares, size, rows = np.linalg.svd(parts, full_matrices=False)
        kept = size > ALIKE * size[0]
        rows, M = rows[kept], self.length.size
        return rows[:, :M] + 1j * rows[:, M:], shares[:, kept] * size[kept]

    @cached_property
    def _steps(self) -> int:
        """Steps of the table on either side of t = 0."""
        least = min(SHORTEST, 0.01 * float(self.length.min()) / self.reach)
        return ceil(-log(least) * PER_E)

    @cached_property
    def _table(self) -> Array:
        """Quintics of the basis's second integrals in ln|t|, (r, 6, 2 steps); t < 0 first."""
        steps, (basis, _) = self._steps, self._basis
        t = self.reach * np.exp(np.arange(-steps, 1) / PER_E)
        made = []
        for sign in (-1.0, 1.0):
            f, d, s = (self._of(basis, sign * t, order) for order in range(3))
            d, s = sign * d * t / PER_E, s * (t / PER_E) ** 2 + sign * d * t / PER_E**2
            made.append([quintics(np.array(values)) for values in zip(f, d, s, strict=True)])
        return np.ascontiguousarray(np.concatenate(made, axis=1).transpose(0, 2, 1))

    def twice(self, before: Array, logarithm: Array) -> Array:
        """Return the second integrals by whether t < 0 and by ln|t|, (kernels, *shape)."""
        steps, shape = self._steps, logarithm.shape
        if logarithm.size < FEW:
            t = np.exp(logarithm.ravel())
            return self.exactly(np.where(before.ravel(), -t, t)).reshape(-1, *shape)
        x = ((logarithm - log(self.reach)) * PER_E + steps).ravel()
        i = np.clip(x, 0, steps - 1).astype(np.intp)
        short = np.exp(np.minimum(x, 0.0) * (2 / PER_E)) if x.min() < 0 else None
        x = np.maximum(x, 0.0) - i
        i += np.where(before.ravel(), 0, steps)
        basis, part = np.empty((len(self._table), x.size)), np.empty(x.size)
        for y, c in zip(basis, self._table, strict=True):
            np.take(c[5], i, out=y, mode="clip")
            for power in (4, 3, 2, 1, 0):
                y *= x
                y += np.take(c[power], i, out=part, mode="clip")
        if short is not None:  # like t^2, but for its logarithm
            basis *= short
        return (self._basis[1] @ basis).reshape(-1, *shape)


def _pole(u: Array, order: int) -> Array:
    """Return K, K' or K'' = F = e^{-u} Ei(u) at u."""
    size = np.maximum(np.abs(u), 1e-300)  # at 0 as near it
    near = size < 1
    logarithm = np.log(size) + GAMMA
    F = np.empty(u.shape)
    F[~near] = _forgotten(u[~near])
    z = u[near]
    series, term, harmonic = np.zeros(z.size), np.ones(z.size), 0.0
    for k in range(1, 22):  # (-u)^k/k! H_k
        term = term * (-z) / k
        harmonic += 1 / k
        series -= term * harmonic
    if order == 2:
        F[near] = np.exp(-z) * logarithm[near] + series
        return F
    if order == 1:
        once = logarithm - F
        once[near] = -np.expm1(-z) * logarithm[near] - series
        return once
    twice: Array = (u - 1) * logarithm - u + F
    twice[near] = (np.expm1(-z) + z) * logarithm[near] + (series - z)
    return twice


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
    F[~far] = np.exp(-z) * np.where(z > 0, expi(np.abs(z)), -exp1(np.abs(z)))
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
