"""Surface compliance of linear elastic, orthotropic layers on a core (thesis sec. 2.2).

Under a surface load cos(n theta), sin(n theta) the displacements (U, V) and the stresses times the
radius (S, T) of the n-th harmonic,

    u_r = U cos(n theta),  u_theta = V sin(n theta),  r sigma_r = S cos(..),  r tau = T sin(..),

satisfy, in y = ln(r/R), a linear system with constant coefficients in each layer (thesis eqs. 34,
35):

    d/dy [w]   [F   N  ] [w]        w = (U, V),  t = (S, T),  a = A_rt/A_rr,  k = (1, n)
         [t] = [K  -F' ] [t],       F = [[-a, -a n], [n, 1]],  N = diag(1/A_rr, 1/G),
                                    K = D k k',  D = A_tt - A_rt^2/A_rr.

N and K are positive semidefinite and finite for incompressible materials; w and t are continuous
between layers.  The result is the surface compliance Y_n, w = Y_n t at r = R.

The thesis computes Y_n from the roots of (43) and powers of r; these overflow, coincide, and cancel
in thin or nearly incompressible layers.  Here each layer is described by three matrices between its
inner side 0 and its outer side 1,

    w1 = A w0 + Q t1,     t0 = A' t1 - H w0,     A = I + E,

which a short series gives for a very thin layer.  Layer b on layer a is one layer with the matrices
(Redheffer star product)

        w2 t2            S = (I + Q_a H_b)^-1
       ---------         A = A_b S A_a
           b             Q = Q_b + A_b S Q_a A_b'
       --- 1 ---         H = H_a + A_a' H_b S A_a
           a
       ---------
        w0 t0

Thin sublayers are doubled until they have the thickness of the layer, then all layers are stacked.
Only positive semidefinite matrices are added and no roots are needed, so that nothing overflows,
also for n = 0 and n = 1.  On a rigid core w0 = 0 and Y = Q.

An open bore is free of traction, t0 = 0 and Y = Q + A H^-1 A', for n >= 2.  For n = 0 and n = 1 a
uniform traction on the bore balances the torque and the resultant force, and the mean rotation and
translation of the bore are zero.  With e = (0, 1) or (1, -1) the pattern of this rigid motion and
f orthogonal to it, e.w0 = 0 and f.t0 = 0, so that w0 is parallel to f and

    Y = Q + (A f)(A f)'/(f' H f).
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
# ln(outer/inner radius), A_rr, A_tt, A_rt, G, and optionally D if it is known more accurately
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
        Harmonics, >= 0; above 2 they need not be integers.
    layers : sequence of (depth, A_rr, A_tt, A_rt, G, D)
        Outermost first: ln of the ratio of their radii, and plane-strain stiffness [Pa]; D may be
        omitted, or None.
    free : bool
        True for an open bore, False for a rigid core.
    factors : callable, optional
        n -> factors of the moduli of viscoelastic layers, (L, n) complex.
    """
    n = np.asarray(n, dtype=float)
    system = Systems.of(*layers)
    parts = [
        _on_core(system.stacked(block, factors and factors(block)), block, free)
        for block in _blocks(n.ravel(), layers)
    ]
    return np.concatenate(parts, axis=-1).reshape((2, 2, *n.shape))


def _blocks(n: Array, layers: Layers) -> list[Array]:
    """Split the harmonics into blocks whose matrices fit into the cache of the processor."""
    return np.array_split(n, max(1, n.size * len(layers) // 4096))


def traction_transfer(n: Array, upper: Layers, lower: Layers, free: bool = False) -> Array:
    """Return B, t = B t1, from the outer surface to a boundary between layers, (2, 2, n).

    Parameters
    ----------
    n : (n,) array of int
        Harmonics, >= 0.
    upper, lower : sequence of (depth, A_rr, A_tt, A_rt, G, D)
        Layers above and below the boundary, as of :func:`stacked_compliance`.
    free : bool
        True for an open bore, False for a rigid core.

    Notes
    -----
    t0 = A' t1 - H w0 of the upper layers and w0 = Y t0 of the lower ones give
    B = (I + H Y)^-1 A'.
    """
    n = np.asarray(n, dtype=float)
    Y, system = stacked_compliance(n, lower, free), Systems.of(*upper)
    stacks = (system.stacked(block) for block in _blocks(n, upper))
    E, _, H = (np.concatenate(parts, axis=-1) for parts in zip(*stacks, strict=True))
    return _mul(_inverse_of_one_plus(_mul(H, Y)), _one_plus(E).swapaxes(0, 1))


def _on_core(stack: Matrices, n: Array, free: bool) -> Array:
    """Return Y_n of a stack on a rigid core, Y = Q, or with an open bore, Y = Q + A X A'.

    X = H^-1 for n >= 2, and f f'/(f' H f) for n = 0, f = (1, 0), and n = 1, f = (1, 1)/sqrt(2).
    """
    E, Q, H = stack
    if not free:
        return Q
    A = _one_plus(E)
    (a, b), (c, d) = H
    is_low, is_one = n < 2, n == 1
    f = np.array([np.where(is_one, np.sqrt(0.5), 1.0), np.where(is_one, np.sqrt(0.5), 0.0)])
    fHf = f[0] * (a * f[0] + b * f[1]) + f[1] * (c * f[0] + d * f[1])
    inverse = np.array([[d, -b], [-c, a]]) / np.where(is_low, 1.0, a * d - b * c)
    projected = f[:, None] * f[None] / np.where(is_low, fHf, 1.0)
    return Q + _mul(_mul(A, np.where(is_low, projected, inverse)), A.swapaxes(0, 1))


@dataclass(frozen=True)
class Systems:
    """The coefficients of the linear system above for all layers.

    Parameters
    ----------
    values : (6, L, 1) array
        Depth, A_rr, A_tt, A_rt, G, D.
    """

    values: Array

    @classmethod
    def of(cls, *layers: Layer) -> Systems:
        """Return the coefficients of layers, outermost first."""
        values = [
            (*layer[:5], (layer[5] if len(layer) > 5 else None) or stiffness_along(*layer[1:4]))  # type: ignore[arg-type]
            for layer in layers
        ]
        return cls(np.array(values).T[..., None])

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
        """A stress that scales N and K to the same magnitude [Pa]."""
        return np.sqrt(self.D * np.minimum(self.values[1], self.values[4]))

    def roots(self, n: Array) -> tuple[Array, Array]:
        """Return lambda_1 + lambda_3 and lambda_1 lambda_3, the positive roots of thesis eq. (43).

        For n = 0 their difference and minus their product; :meth:`thin` uses even functions of
        them only, which are the same.
        """
        _, A_rr, A_tt, A_rt, G, D = self.values
        s = np.sqrt(A_rr * A_tt)
        product = s / A_rr * (n * n - 1)
        # mu_n + sqrt(kappa_n) of (45), written as a sum of positive terms
        square = n * n * D * (1 / G + 2 / (s + A_rt)) + (1 - np.sqrt(A_tt / A_rr)) ** 2
        return np.sqrt(square), product

    def penetration_depth(self, n: Array) -> Array:
        """Return the depth at which the n-th harmonic has decayed to exp(-20), or the layer's."""
        total, product = self.roots(n)
        rate = np.minimum(total / 2, product / np.maximum(total, 1e-300))
        rate[:, n < 2] = 0.0  # rotation and translation do not decay
        return np.minimum(self.depth, 20 / np.maximum(rate, 1e-300))

    def stacked(self, n: Array, factors: Array | None = None) -> Matrices:
        """Return E, Q [1/Pa], H [Pa] of the stack of all layers, (2, 2, n)."""
        E, Q, H = self.each(n)
        if factors is not None:  # E depends on the ratios of a layer's moduli only
            Q, H = Q / factors, H * factors
        while E.shape[2] > 1:  # stack neighbours in pairs; an odd one waits for the next pass
            paired = E.shape[2] // 2 * 2
            upper, lower = (tuple(X[:, :, k:paired:2] for X in (E, Q, H)) for k in (0, 1))
            pairs = star(lower, upper)  # type: ignore[arg-type]
            E, Q, H = (
                np.concatenate([pair, X[:, :, paired:]], axis=2)
                for pair, X in zip(pairs, (E, Q, H), strict=True)
            )
        return E[:, :, 0], Q[:, :, 0], H[:, :, 0]

    def each(self, n: Array) -> Matrices:
        """Return E, Q [1/Pa], H [Pa] of every layer by doubling a thin one, (2, 2, L, n)."""
        _, A_rr, _, A_rt, G, _ = self.values
        depth = self.penetration_depth(n)
        m = np.maximum(n, 1.0)
        # a thin layer has |M| <= 1/8, so that the series of e^M converges rapidly
        size = np.maximum(np.maximum(A_rt / A_rr, 1.0), np.sqrt(self.D / np.minimum(A_rr, G)))
        doublings = max(0, ceil(log2(8 * (size * m * depth).max())))
        layer = self.thin(n, depth / 2**doublings)
        for _ in range(doublings):
            layer = star(layer, layer)
        E, Q, H = layer
        return E, Q / (m * self.unit), H * (m * self.unit)

    def matrix(self, n: Array, h: Array) -> Array:
        """Return M, h times the matrix of the system, stresses in n * unit, (L, n, 4, 4)."""
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
        """Return E, Q, H of layers of depth h from e^M - I, stresses in n * unit."""
        M = self.matrix(n, h)
        total, product = self.roots(n)
        c = (product * h * h) ** 2
        b = (total * h) ** 2 - 2 * product * h * h
        # e^M = I + f0 I + (1 + f1) M + f2 M^2 + f3 M^3, with the even powers
        # M^(2k) = alpha M^2 + beta I by the Cayley-Hamilton theorem, M^4 = b M^2 - c I
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
        # contiguous in the order of the following operations, which is a third faster
        change = np.ascontiguousarray(np.moveaxis(change, (-2, -1), (0, 1)))
        upper, lower, last = change[:2, 2:], change[2:, :2], change[2:, 2:]
        inverse = _inverse_of_one_plus(last)
        E = -_mul(inverse, last).swapaxes(0, 1)
        return E, _mul(upper, inverse), _mul(inverse, lower)


def star(lower: Matrices, upper: Matrices) -> Matrices:
    """Return E, Q, H of one layer on another (Redheffer star product)."""
    E_a, Q_a, H_a = lower
    E_b, Q_b, H_b = upper
    A_a = _one_plus(E_a)
    A_b = A_a if upper is lower else _one_plus(E_b)
    S = _inverse_of_one_plus(_mul(Q_a, H_b))
    AQ, HSA = _mul(A_b, Q_a), _mul(H_b, _mul(S, A_a))
    # E = A S A - I without cancellation, by I - S = Q H S; S Q = Q S' by symmetry
    E = E_a + E_b + _mul(E_b, E_a) - _mul(AQ, HSA)
    Q = Q_b + _mul(AQ, _mul(A_b, S).swapaxes(0, 1))
    return E, Q, H_a + _mul(A_a.swapaxes(0, 1), HSA)


def _mul(X: Array, Y: Array) -> Array:
    """Multiply 2 x 2 matrices, shape (2, 2, ...)."""
    product: Array = X[:, :1] * Y[:1]
    product += X[:, 1:] * Y[1:]
    return product


def _one_plus(E: Array) -> Array:
    """Return I + E of 2 x 2 matrices, shape (2, 2, ...)."""
    A = E.copy()
    A[0, 0] += 1
    A[1, 1] += 1
    return A


def _inverse_of_one_plus(X: Array) -> Array:
    """Return (I + X)^-1 of 2 x 2 matrices, shape (2, 2, ...)."""
    (a, b), (c, d) = X
    det = 1 + (a + d) + (a * d - b * c)
    return np.array([[1 + d, -b], [-c, 1 + a]]) / det
