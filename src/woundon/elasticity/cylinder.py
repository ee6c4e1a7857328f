"""The linear elastic, orthotropic cylinder on a rigid core (thesis sec. 2.2).

A surface load cos(n theta), sin(n theta) deforms every circle r in the same pattern, so that the
displacements (U, V) and the stresses times radius (S, T) of the n-th harmonic,

    u_r = U cos(n theta),  u_theta = V sin(n theta),  r sigma_r = S cos(..),  r tau = T sin(..),

obey, in y = ln(r/R), a linear system with constant coefficients (thesis eqs. 34, 35):

    d/dy [w]   [F   N  ] [w]        w = (U, V),  t = (S, T),  a = A_rt/A_rr,  k = (1, n)
         [t] = [K  -F' ] [t],       F = [[-a, -a n], [n, 1]],  N = diag(1/A_rr, 1/G),
                                    K = D k k',  D = A_tt - A_rt^2/A_rr.

N and K are positive semidefinite and stay finite for incompressible materials.  The surface
compliance Y_n, w = Y_n t at r = R with w = 0 at r = R0, holds the characteristic sequences (57):

    R Y_n = [[ gamma_1, -gamma_2],
             [-chi_1,    chi_2  ]],        symmetric by Betti's theorem.

The thesis builds Y_n from the roots of (43) and powers of r; these overflow, coincide, and cancel
in thin or nearly incompressible layers.  Here a thin layer's response is squared again and again
(the doubling of Riccati equations): only positive semidefinite matrices are added, no root is ever
computed, n = 0 and n = 1 are no exceptions, and nothing overflows.

For large n the core is not felt and Y_n solves the algebraic Riccati equation
F Y + Y F' + N - Y K Y = 0, whose solution in powers of 1/n gives the closed form parts of the sums.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import ceil, log, log1p, log2, pi, sqrt
from typing import NamedTuple

import numpy as np

from .fourier import HarmonicSum, HarmonicSums
from .half_plane import coefficients
from .kernels import SurfaceKernels
from .strip import stiffness_along

__all__ = [
    "Sequences",
    "asymptotic_compliance",
    "sequences",
    "surface_compliance",
    "surface_kernels",
]

Array = np.ndarray
Stiffness = tuple[float, float, float, float, float | None]  # A_rr, A_tt, A_rt, G, D

MAX_TERMS = 1 << 18
TOLERANCE = 1e-12  # of the sums, relative to their leading term
HIGHEST_POWER = 6  # of 1/n, summed in closed form


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
        Harmonics, >= 0; n = 0 gives gamma_0 and chi_0 in place of gamma_1 and chi_2, zeros else.
    radius, core_radius : float
        R and R0 [m], 0 < R0 < R.
    A_rr, A_tt, A_rt, G : float
        Plane-strain stiffness [Pa].
    D : float, optional
        :func:`.strip.stiffness_along`, where it is known better than by the others.

    Notes
    -----
    Thesis eq. (57): a pressure c cos(n theta) moves the surface by -gamma_1 c cos(n theta) outward
    and chi_1 c sin(n theta) along +theta; a traction f sin(n theta) by -gamma_2 f cos(n theta) and
    chi_2 f sin(n theta).
    """
    Y = radius * surface_compliance(n, _depth(radius, core_radius), A_rr, A_tt, A_rt, G, D)
    return Sequences(Y[0, 0], -Y[0, 1], -Y[1, 0], Y[1, 1])


def _depth(radius: float, core_radius: float) -> float:
    """Return ln(R/R0), accurate for thin layers too."""
    if 2 * core_radius > radius:
        return -log1p(-(radius - core_radius) / radius)
    return log(radius / core_radius)


def surface_compliance(
    n: Array,
    depth: float,
    A_rr: float,
    A_tt: float,
    A_rt: float,
    G: float,
    D: float | None = None,
) -> Array:
    """Return Y_n [1/Pa], shape (2, 2) + n.shape, of a layer of depth ln(R/R0) on a rigid core."""
    n = np.asarray(n, dtype=float)
    layer = _Layer(A_rr, A_tt, A_rt, G, D)
    blocks = np.array_split(n.ravel(), max(1, n.size // 4096))  # each stays in the cache
    Y = np.concatenate([layer.compliance(block, depth) for block in blocks], axis=-1)
    return Y.reshape((2, 2, *n.shape))


@dataclass(frozen=True)
class _Layer:
    """The coefficients of the system above."""

    A_rr: float
    A_tt: float
    A_rt: float
    G: float
    known_D: float | None = None

    @property
    def D(self) -> float:
        """A_tt - A_rt^2/A_rr [Pa]."""
        return self.known_D or stiffness_along(self.A_rr, self.A_tt, self.A_rt)

    @property
    def unit(self) -> float:
        """A stress [Pa] that makes N and K of one size."""
        return sqrt(self.D * min(self.A_rr, self.G))

    def roots(self, n: Array) -> tuple[Array, Array]:
        """Return lambda_1 + lambda_3 and lambda_1 lambda_3, growing roots of thesis eq. (43).

        For n = 0 their difference and minus their product: the even functions below stay right.
        """
        A_rr, A_tt, A_rt, G = self.A_rr, self.A_tt, self.A_rt, self.G
        s = sqrt(A_rr * A_tt)
        product = s / A_rr * (n * n - 1)
        # mu_n + sqrt(kappa_n) of (45), written as a sum of positive terms
        steep = n * n * self.D * (1 / G + 2 / (s + A_rt)) + (1 - sqrt(A_tt / A_rr)) ** 2
        return np.sqrt(steep), product

    def reach(self, n: Array, depth: float) -> Array:
        """Return the depth to which the n-th harmonic needs to be followed, at most ``depth``."""
        total, product = self.roots(n)
        slowest = np.minimum(total / 2, product / np.maximum(total, 1e-300))
        slowest[n < 2] = 0.0  # torsion and translation reach the core at any depth
        return np.minimum(depth, 20 / np.maximum(slowest, 1e-300))

    def compliance(self, n: Array, depth: float) -> Array:
        """Return Y_n [1/Pa], shape (2, 2, n)."""
        steps = self.reach(n, depth)
        m = np.maximum(n, 1.0)
        size = max(self.A_rt / self.A_rr, 1.0, sqrt(self.D / min(self.A_rr, self.G)))
        doublings = max(0, ceil(log2(8 * size * (m * steps).max())))
        E, Q, H = self.thin(n, steps / 2**doublings)
        for _ in range(doublings):
            E, Q, H = _double(E, Q, H)
        return Q / (m * self.unit)

    def matrix(self, n: Array, h: Array) -> Array:
        """Return h times the system's matrix, stresses in n * unit, shape (n, 4, 4)."""
        a, D, m = self.A_rt / self.A_rr, self.D, np.maximum(n, 1.0) * self.unit
        M = np.zeros((n.size, 4, 4))
        M[:, 0, 0], M[:, 0, 1], M[:, 1, 0], M[:, 1, 1] = -a, -a * n, n, 1.0
        M[:, 0, 2], M[:, 1, 3] = m / self.A_rr, m / self.G
        M[:, 2, 0] = D / m
        M[:, 2, 1] = M[:, 3, 0] = n * D / m
        M[:, 3, 1] = n * n * D / m
        M[:, 2:, 2:] = -M[:, :2, :2].swapaxes(1, 2)
        return M * h[:, None, None]

    def thin(self, n: Array, h: Array) -> tuple[Array, Array, Array]:
        """Return E, Q, H of a thin layer, w1 = (I+E) w0 + Q t1 and t0 = (I+E)' t1 - H w0."""
        M = self.matrix(n, h)
        total, product = self.roots(n)
        c = (product * h * h) ** 2
        b = (total * h) ** 2 - 2 * product * h * h
        # e^M = f0 + f1 M + f2 M^2 + f3 M^3, as M^4 = b M^2 - c
        alpha, beta = np.ones_like(h), np.zeros_like(h)
        f0, f1, f2, f3 = (np.zeros_like(h) for _ in range(4))
        weight = 1.0
        for k in range(1, 8):
            weight /= 2 * k * (2 * k - 1)
            f0 += weight * beta
            f2 += weight * alpha
            f1 += weight / (2 * k + 1) * beta
            f3 += weight / (2 * k + 1) * alpha
            alpha, beta = b * alpha + beta, -c * alpha
        square = M @ M
        f0, f1, f2, f3 = (f[:, None, None] for f in (f0, f1, f2, f3))
        change = M + f1 * M + f2 * square + f3 * (square @ M) + f0 * np.eye(4)  # e^M - I
        change = np.moveaxis(change, 0, -1)
        upper, lower, last = change[:2, 2:], change[2:, :2], change[2:, 2:]
        inverse = _inverse_of_one_plus(last)
        E = -_mul(inverse, last).swapaxes(0, 1)
        return E, _mul(upper, inverse), _mul(inverse, lower)


def _mul(X: Array, Y: Array) -> Array:
    """Multiply 2 x 2 matrices, shape (2, 2, n)."""
    return X[:, :1] * Y[:1] + X[:, 1:] * Y[1:]


def _inverse_of_one_plus(X: Array) -> Array:
    """Return (I + X)^-1 of 2 x 2 matrices, shape (2, 2, n)."""
    (a, b), (c, d) = X
    det = 1 + (a + d) + (a * d - b * c)
    return np.array([[1 + d, -b], [-c, 1 + a]]) / det


def _double(E: Array, Q: Array, H: Array) -> tuple[Array, Array, Array]:
    """Return E, Q, H of two equal layers, one on the other."""
    A = E.copy()
    A[0, 0] += 1
    A[1, 1] += 1
    At = A.swapaxes(0, 1)
    QH = _mul(Q, H)
    S = _inverse_of_one_plus(QH)
    SA = _mul(S, A)
    # A S A - I with I - S = Q H S: small changes stay accurate
    E_next = 2 * E + _mul(E, E) - _mul(A, _mul(QH, SA))
    return E_next, Q + _mul(A, _mul(_mul(S, Q), At)), H + _mul(At, _mul(H, SA))


def asymptotic_compliance(
    orders: int, A_rr: float, A_tt: float, A_rt: float, G: float, D: float | None = None
) -> Array:
    """Return Y_j [1/Pa], shape (orders+1, 2, 2): Y_n = sum_j Y_j/n^j far from any core; Y_0 = 0.

    Notes
    -----
    F Y + Y F' + N = D z z' with z = Y k is solved order by order in 1/n.  The first order is the
    half-plane, Y_1 = [[C, A], [A, B]] (thesis eq. 30).
    """
    D = D or stiffness_along(A_rr, A_tt, A_rt)
    A, B, C = coefficients(A_rr, A_tt, A_rt, G, D)
    a, r, DB = A_rt / A_rr, sqrt(A_tt / A_rr), D * B
    Y = np.zeros((orders + 2, 2, 2))
    Y[1] = [[C, A], [A, B]]
    z = np.zeros((orders + 2, 2))
    z[0] = Y[1, :, 1]
    shift = np.array([-a, 1.0])
    for j in range(2, orders + 1):
        # all that is known at this order; the unknown enters through F_1 and z_(j-1)
        z[j - 1] = Y[j - 1, :, 0]
        known = shift[:, None] * Y[j - 1] + Y[j - 1] * shift
        known -= D * sum(np.outer(z[i], z[j - 1 - i]) for i in range(j))
        y12 = known[0, 0] / (2 * r)
        y22 = (y12 + known[1, 1] / 2) / DB
        y11 = -known[0, 1] + r * y22 + DB * y12
        Y[j] = [[y11, y12], [y12, y22]]
        z[j - 1] += Y[j, :, 1]
    return Y[: orders + 1]


def surface_kernels(
    radius: float,
    core_radius: float,
    A_rr: float,
    A_tt: float,
    A_rt: float,
    G: float,
    D: float | None = None,
) -> SurfaceKernels:
    """Return the cylinder's influence functions (thesis eq. 59), which hold on the whole circle.

    Parameters
    ----------
    radius, core_radius : float
        R and R0 [m], 0 < R0 < R.
    A_rr, A_tt, A_rt, G : float
        Plane-strain stiffness [Pa].
    D : float, optional
        :func:`.strip.stiffness_along`, where it is known better than by the others.
    """
    return _kernels(*map(float, (radius, core_radius, A_rr, A_tt, A_rt, G)), D)


@lru_cache(maxsize=16)
def _kernels(
    R: float, R0: float, A_rr: float, A_tt: float, A_rt: float, G: float, D: float | None
) -> SurfaceKernels:
    stiffness = A_rr, A_tt, A_rt, G, D
    tail = asymptotic_compliance(HIGHEST_POWER + 2, *stiffness)
    J = _closed_powers(tail)
    depth = _depth(R, R0)
    N = _terms(depth, tail, J, stiffness)
    n = np.arange(N + 1.0)
    Y = surface_compliance(n, depth, *stiffness)
    mean, Y, n = Y[..., 0] / 2, Y[..., 1:], n[1:]
    # sums of Y, of n Y, and of the strain's (1, n) Y: first their powers of 1/n, then the terms
    still, moved = tail[: J + 1], tail[1 : J + 2]
    stretch, sums = still[:, 0] + moved[:, 1], Y[0] + n * Y[1]

    def harmonics(odd: bool, scale: float, a: Array, c: Array, mean: float = 0.0) -> HarmonicSum:
        return HarmonicSum(odd, R, scale, mean, a, c - _powers(a, n))

    coupling = harmonics(True, -1 / pi, still[:, 0, 1], Y[0, 1]).kernel()
    slope = 1 / (pi * R)
    gradients = HarmonicSums((
        harmonics(True, slope, moved[:, 0, 0], n * Y[0, 0]),
        harmonics(False, -slope, moved[:, 0, 1], n * Y[0, 1]),
        harmonics(False, -slope, stretch[:, 0], sums[0], mean[0, 0]),
        harmonics(True, -slope, stretch[:, 1], sums[1]),
    ))  # fmt: skip
    slope_p, slope_q, strain_p, strain_q = (of_one.kernel() for of_one in gradients.sums)
    return SurfaceKernels(
        normal_p=harmonics(False, -1 / pi, still[:, 0, 0], Y[0, 0], mean[0, 0]).kernel(),
        normal_q=coupling,
        tangent_p=coupling,
        tangent_q=harmonics(False, 1 / pi, still[:, 1, 1], Y[1, 1], mean[1, 1]).kernel(),
        slope_p=slope_p,
        slope_q=slope_q,
        strain_p=strain_p,
        strain_q=strain_q,
        together=gradients,
        length=R * min(1.0, 2 * _decay(depth, stiffness)),
        truncation_error=_truncation_error(n * Y - _powers(moved, n), tail, depth, stiffness, J),
        terms=N,
    )


def _powers(a: Array, n: Array) -> Array:
    """Sum a_j/n^j, a of shape (J+1, ...), to shape (..., n)."""
    total = np.zeros(a.shape[1:] + n.shape)
    for value in a[::-1]:
        total = total / n + value[..., None]
    return total


def _closed_powers(tail: Array) -> int:
    """Return how many powers of 1/n to sum in closed form: fewer where their coefficients grow."""
    size = np.abs(tail).max(axis=(1, 2))
    for J in range(HIGHEST_POWER, 1, -1):
        if size[1 : J + 2].max() < 1e4 * size[1]:
            return J
    return 1


def _decay(depth: float, stiffness: Stiffness) -> float:
    """Return kappa: the core's echo dies as exp(-2 kappa n)."""
    total, product = (float(v) for v in _Layer(*stiffness).roots(np.array(1e8)))
    spread = total * total / 4 - product
    slowest = product / (total / 2 + sqrt(spread)) if spread > 0 else total / 2
    return slowest / 1e8 * depth


def _terms(depth: float, tail: Array, J: int, stiffness: Stiffness) -> int:
    """Return the number of harmonics to sum: until the echo and the first power left out die."""
    echo = 20 / _decay(depth, stiffness)
    size = np.abs(tail).max(axis=(1, 2))
    power = (size[J + 2] / (J * TOLERANCE * size[1])) ** (1 / J)
    return int(min(max(echo, power, 32), MAX_TERMS))


def _truncation_error(
    rest: Array, tail: Array, depth: float, stiffness: Stiffness, J: int
) -> float:
    """Estimate the missing part of the derivatives' sums from their last terms.

    It is measured by the derivatives' size at the distance of the layer's thickness (or radius).
    """
    N = rest.shape[-1]
    last = rest[..., -max(4, N // 16) :]
    beyond = max(N / J, 0.5 / _decay(depth, stiffness))
    return float(np.abs(last).max() / np.abs(tail[1]).max() * beyond * min(depth, 1.0))
