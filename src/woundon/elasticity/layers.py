"""Layers of linear elastic, orthotropic materials on a core (thesis sec. 2.2), one on the other.

A surface load cos(n theta), sin(n theta) deforms every circle r in the same pattern, so that the
displacements (U, V) and the stresses times radius (S, T) of the n-th harmonic,

    u_r = U cos(n theta),  u_theta = V sin(n theta),  r sigma_r = S cos(..),  r tau = T sin(..),

obey, in y = ln(r/R), a linear system, its coefficients constant in a layer (thesis eqs. 34, 35):

    d/dy [w]   [F   N  ] [w]        w = (U, V),  t = (S, T),  a = A_rt/A_rr,  k = (1, n)
         [t] = [K  -F' ] [t],       F = [[-a, -a n], [n, 1]],  N = diag(1/A_rr, 1/G),
                                    K = D k k',  D = A_tt - A_rt^2/A_rr.

N and K are positive semidefinite and stay finite for incompressible materials; w and t pass from
layer to layer.  What is wanted is the surface compliance Y_n, w = Y_n t at r = R.

The thesis builds Y_n from the roots of (43) and powers of r; these overflow, coincide, and cancel
in thin or nearly incompressible layers.  Here every layer is described by three matrices, from its
inner side 0 to its outer side 1,

    w1 = A w0 + Q t1,     t0 = A' t1 - H w0,     A = I + E,

those of a very thin one by a short series.  Two layers, one on the other, are one (the star product
of Redheffer):

        w2 t2            S = (I + Q_a H_b)^-1
       ---------         A = A_b S A_a
           b             Q = Q_b + A_b S Q_a A_b'
       --- 1 ---         H = H_a + A_a' H_b S A_a
           a
       ---------
        w0 t0

Thin layers are doubled until they are as thick as theirs, then all are stacked.  Only positive
semidefinite matrices are added, no root is ever computed, n = 0 and n = 1 are no exceptions, and
nothing overflows.  On a rigid core w0 = 0 and Y = Q.

An open bore is free of traction, t0 = 0, but for what holds the cylinder: a resultant force (n = 1)
and a torque (n = 0) are met by a uniform traction on the bore, along the force or around, and the
bore does not move on average, that is, neither shifts nor turns as a whole.  With e the pattern of
that motion, (1, -1) or (0, 1), and f the one across, e.w0 = 0 and f.t0 = 0, so w0 is along f and

    Y = Q + (A f)(A f)'/(f' H f);        Y = Q + A H^-1 A' for n >= 2.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import ceil, log2

import numpy as np

from .strip import stiffness_along

__all__ = ["Factors", "Layer", "Layers", "stacked_compliance", "traction_transfer"]

Array = np.ndarray
# ln(outer/inner radius), A_rr, A_tt, A_rt, G, and D where it is known better than by the three
Layer = tuple[float | None, ...]
Layers = tuple[Layer, ...]  # outermost first
Matrices = tuple[Array, Array, Array]  # E, Q, H
Factors = Callable[[Array], Array]


def stacked_compliance(
    n: Array, layers: Layers, free: bool = False, factors: Factors | None = None
) -> Array:
    """Return Y_n [1/Pa], shape (2, 2) + n.shape, of the outer surface of layers on a core.

    Parameters
    ----------
    n : array_like
        Harmonics, >= 0, whole or, from 2 on, anything between.
    layers : sequence of (depth, A_rr, A_tt, A_rt, G, D)
        Outermost first: ln of the ratio of their radii, and plane-strain stiffness [Pa]; D may be
        left out, or None.
    free : bool
        Whether the core is an open bore; else it is rigid.
    factors : callable, optional
        n -> by what the moduli of the layers are multiplied, (L, n) complex: viscoelastic ones.
        The ratios of a layer's moduli do not change with n.
    """
    n = np.asarray(n, dtype=float)
    system = Systems.of(*layers)
    # each block stays in the cache
    blocks = np.array_split(n.ravel(), max(1, n.size * len(layers) // 4096))
    made = (system.stacked(block, factors and factors(block)) for block in blocks)
    Y = np.concatenate(
        [_on_core(stack, block, free) for stack, block in zip(made, blocks, strict=True)], axis=-1
    )
    return Y.reshape((2, 2, *n.shape))


def traction_transfer(n: Array, upper: Layers, lower: Layers, free: bool = False) -> Array:
    """Return B with t = B t1 between upper and lower layers, t1 at the outer surface, (2, 2, n).

    Parameters
    ----------
    n : (n,) array of int
        Harmonics, >= 0.
    upper, lower : sequence of (depth, A_rr, A_tt, A_rt, G, D)
        Outermost first, as of :func:`stacked_compliance`.
    free : bool
        Whether the core is an open bore; else it is rigid.

    Notes
    -----
    t0 = A' t1 - H w0 of the upper layers and w0 = Y t0 of the lower ones give
    B = (I + H Y)^-1 A'.
    """
    n = np.asarray(n, dtype=float)
    Y, system = stacked_compliance(n, lower, free), Systems.of(*upper)
    blocks = np.array_split(n, max(1, n.size * len(upper) // 4096))  # each stays in the cache
    E, _, H = (
        np.concatenate(parts, axis=-1)
        for parts in zip(*(system.stacked(block) for block in blocks), strict=True)
    )
    return _mul(_inverse_of_one_plus(_mul(H, Y)), _one_plus(E).swapaxes(0, 1))


def _on_core(stack: Matrices, n: Array, free: bool) -> Array:
    E, Q, H = stack
    if not free:
        return Q
    A = _one_plus(E)
    (a, b), (c, d) = H
    low, one = n < 2, n == 1
    f = np.array([np.where(one, np.sqrt(0.5), 1.0), np.where(one, np.sqrt(0.5), 0.0)])
    along = f[0] * (a * f[0] + b * f[1]) + f[1] * (c * f[0] + d * f[1])
    det = np.where(low, 1.0, a * d - b * c)
    inverse = np.array([[d, -b], [-c, a]]) / det
    held = f[:, None] * f[None] / np.where(low, along, 1.0)
    return Q + _mul(_mul(A, np.where(low, held, inverse)), A.swapaxes(0, 1))


@dataclass(frozen=True)
class Systems:
    """The coefficients of the system above, of all layers.

    Parameters
    ----------
    values : (6, L, 1) array
        Depth, A_rr, A_tt, A_rt, G, D.
    """

    values: Array

    @classmethod
    def of(cls, *layers: Layer) -> Systems:
        """Return the coefficients of layers, outermost first."""
        known = [
            (*layer[:5], (layer[5] if len(layer) > 5 else None) or stiffness_along(*layer[1:4]))  # type: ignore[arg-type]
            for layer in layers
        ]
        return cls(np.array(known).T[..., None])

    @property
    def depth(self) -> Array:
        """ln(outer/inner radius), (L, 1)."""
        return self.values[0]

    @property
    def D(self) -> Array:
        """A_tt - A_rt^2/A_rr [Pa]."""
        return self.values[5]

    @cached_property
    def unit(self) -> Array:
        """A stress [Pa] that makes N and K of one size."""
        return np.sqrt(self.D * np.minimum(self.values[1], self.values[4]))

    def roots(self, n: Array) -> tuple[Array, Array]:
        """Return lambda_1 + lambda_3 and lambda_1 lambda_3, growing roots of thesis eq. (43).

        For n = 0 their difference and minus their product: the even functions below stay right.
        """
        _, A_rr, A_tt, A_rt, G, D = self.values
        s = np.sqrt(A_rr * A_tt)
        product = s / A_rr * (n * n - 1)
        # mu_n + sqrt(kappa_n) of (45), written as a sum of positive terms
        steep = n * n * D * (1 / G + 2 / (s + A_rt)) + (1 - np.sqrt(A_tt / A_rr)) ** 2
        return np.sqrt(steep), product

    def reach(self, n: Array) -> Array:
        """Return the depth to which the n-th harmonic needs to be followed, at most the layer's."""
        total, product = self.roots(n)
        slowest = np.minimum(total / 2, product / np.maximum(total, 1e-300))
        slowest[:, n < 2] = 0.0  # torsion and translation reach the core at any depth
        return np.minimum(self.depth, 20 / np.maximum(slowest, 1e-300))

    def stacked(self, n: Array, factors: Array | None = None) -> Matrices:
        """Return E, Q [1/Pa], H [Pa] of all layers together, (2, 2, n)."""
        E, Q, H = self.each(n)
        if factors is not None:  # E has no dimension, nor have a layer's roots
            Q, H = Q / factors, H * factors
        while E.shape[2] > 1:  # neighbours in pairs; one that is left over waits for the next round
            pairs = slice(0, E.shape[2] // 2 * 2)
            both = ([X[:, :, pairs][:, :, k::2] for X in (E, Q, H)] for k in (0, 1))
            upper, lower = (tuple(part) for part in both)
            made = star(lower, upper)  # type: ignore[arg-type]
            E, Q, H = (
                np.concatenate([new, X[:, :, pairs.stop :]], axis=2)
                for new, X in zip(made, (E, Q, H), strict=True)
            )
        return E[:, :, 0], Q[:, :, 0], H[:, :, 0]

    def each(self, n: Array) -> Matrices:
        """Return E, Q [1/Pa], H [Pa] of every layer, (2, 2, L, n)."""
        _, A_rr, _, A_rt, G, _ = self.values
        steps = self.reach(n)
        m = np.maximum(n, 1.0)
        size = np.maximum(np.maximum(A_rt / A_rr, 1.0), np.sqrt(self.D / np.minimum(A_rr, G)))
        doublings = max(0, ceil(log2(8 * (size * m * steps).max())))
        one = self.thin(n, steps / 2**doublings)
        for _ in range(doublings):
            one = star(one, one)
        E, Q, H = one
        return E, Q / (m * self.unit), H * (m * self.unit)

    def matrix(self, n: Array, h: Array) -> Array:
        """Return h times the system's matrix, stresses in n * unit, shape (L, n, 4, 4)."""
        _, A_rr, _, A_rt, G, _ = self.values
        a, D, m = A_rt / A_rr, self.D, np.maximum(n, 1.0) * self.unit
        M = np.zeros((*h.shape, 4, 4))
        M[..., 0, 0], M[..., 0, 1], M[..., 1, 0], M[..., 1, 1] = -a, -a * n, n, 1.0
        M[..., 0, 2], M[..., 1, 3] = m / A_rr, m / G
        M[..., 2, 0] = D / m
        M[..., 2, 1] = M[..., 3, 0] = n * D / m
        M[..., 3, 1] = n * n * D / m
        M[..., 2:, 2:] = -M[..., :2, :2].swapaxes(-1, -2)
        return M * h[..., None, None]

    def thin(self, n: Array, h: Array) -> Matrices:
        """Return E, Q, H of thin layers, stresses in n * unit."""
        M = self.matrix(n, h)
        total, product = self.roots(n)
        c = (product * h * h) ** 2
        b = (total * h) ** 2 - 2 * product * h * h
        # e^M = f0 + f1 M + f2 M^2 + f3 M^3, as M^4 = b M^2 - c
        alpha, beta = np.ones_like(h), np.zeros_like(h)
        f0, f1, f2, f3 = (np.zeros_like(h) for _ in range(4))
        weight = 1.0
        for k in range(1, 7):
            weight /= 2 * k * (2 * k - 1)
            f0 += weight * beta
            f2 += weight * alpha
            f1 += weight / (2 * k + 1) * beta
            f3 += weight / (2 * k + 1) * alpha
            alpha, beta = b * alpha + beta, -c * alpha
        square = M @ M
        f0, f1, f2, f3 = (f[..., None, None] for f in (f0, f1, f2, f3))
        change = M + f1 * M + f2 * square + f3 * (square @ M) + f0 * np.eye(4)  # e^M - I
        # in the order of what follows, which would keep any other: a third of all doublings' time
        change = np.ascontiguousarray(np.moveaxis(change, (-2, -1), (0, 1)))
        upper, lower, last = change[:2, 2:], change[2:, :2], change[2:, 2:]
        inverse = _inverse_of_one_plus(last)
        E = -_mul(inverse, last).swapaxes(0, 1)
        return E, _mul(upper, inverse), _mul(inverse, lower)


def star(lower: Matrices, upper: Matrices) -> Matrices:
    """Return E, Q, H of one layer on another."""
    E_a, Q_a, H_a = lower
    E_b, Q_b, H_b = upper
    A_a = _one_plus(E_a)
    A_b = A_a if upper is lower else _one_plus(E_b)
    S = _inverse_of_one_plus(_mul(Q_a, H_b))
    AQ, HSA = _mul(A_b, Q_a), _mul(H_b, _mul(S, A_a))
    # A S A - I with I - S = Q H S: small changes stay accurate; S Q = Q S' by symmetry
    E = E_a + E_b + _mul(E_b, E_a) - _mul(AQ, HSA)
    Q = Q_b + _mul(AQ, _mul(A_b, S).swapaxes(0, 1))
    return E, Q, H_a + _mul(A_a.swapaxes(0, 1), HSA)


def _mul(X: Array, Y: Array) -> Array:
    """Multiply 2 x 2 matrices, shape (2, 2, ...)."""
    product: Array = X[:, :1] * Y[:1]
    product += X[:, 1:] * Y[1:]
    return product


def _one_plus(E: Array) -> Array:
    A = E.copy()
    A[0, 0] += 1
    A[1, 1] += 1
    return A


def _inverse_of_one_plus(X: Array) -> Array:
    """Return (I + X)^-1 of 2 x 2 matrices, shape (2, 2, ...)."""
    (a, b), (c, d) = X
    det = 1 + (a + d) + (a * d - b * c)
    return np.array([[1 + d, -b], [-c, 1 + a]]) / det
