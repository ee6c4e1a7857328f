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
from itertools import accumulate
from math import ceil, log2
from typing import NamedTuple

import numpy as np

from .strip import stiffness_along

__all__ = [
    "Factors",
    "Layer",
    "Layers",
    "RelaxingModuli",
    "stacked_compliance",
    "traction_transfers",
]

Array = np.ndarray
# ln(outer/inner radius), A_rr, A_tt, A_rt, G, and optionally D if it is known more accurately
Layer = tuple[float | None, ...]
Layers = tuple[Layer, ...]  # outermost first
# E, Q, H: 2 x 2 matrices on the first two axes, then layers (if there are several) and harmonics n.
# The transpose of such a matrix is swapaxes(0, 1).
SectionMatrices = tuple[Array, Array, Array]
Factors = Callable[[Array], Array]  # harmonics (n,) -> factors of the layers' moduli, (L, n)


class RelaxingModuli(NamedTuple):
    """The moduli of viscoelastic layers over the harmonic n, relative to the relaxed ones.

    Attributes
    ----------
    factors : callable
        n -> factors of the moduli, (L, n) complex.
    constant_bulk : tuple of bool
        Of each layer: True if the factor is that of the shear modulus, and the bulk modulus is
        constant; the layer is isotropic then.
    """

    factors: Factors
    constant_bulk: tuple[bool, ...]


@np.errstate(under="ignore")  # short waves vanish across a layer
def stacked_compliance(
    n: Array, layers: Layers, open_bore: bool = False, moduli: RelaxingModuli | None = None
) -> Array:
    """Return Y_n [1/Pa], shape (2, 2) + n.shape, of the outer surface of layers on a core.

    Parameters
    ----------
    n : array_like
        Harmonics, >= 0; above 2 they need not be integers.
    layers : sequence of (depth, A_rr, A_tt, A_rt, G, D)
        Outermost first: ln of the ratio of their radii, and plane-strain stiffness [Pa]; D may be
        omitted, or None.
    open_bore : bool
        True for an open bore, False for a rigid core.
    moduli : RelaxingModuli, optional
        Of viscoelastic layers.
    """
    n = np.asarray(n, dtype=float)
    system = LayerSystems.of(*layers)
    parts = [
        _compliance_on_core(system.stack_matrices(block, moduli), block, open_bore)
        for block in _blocks(n.ravel(), layers)
    ]
    return np.concatenate(parts, axis=-1).reshape((2, 2, *n.shape))


def _blocks(n: Array, layers: Layers) -> list[Array]:
    """Split the harmonics into blocks whose matrices fit into the cache of the processor."""
    return np.array_split(n, max(1, n.size * len(layers) // 4096))


@np.errstate(under="ignore")  # short waves vanish across a layer
def traction_transfers(n: Array, layers: Layers, open_bore: bool = False) -> Array:
    """Return B, t = B t1, from t1 on the outer surface to t on every boundary between layers.

    Parameters
    ----------
    n : (n,) array of int
        Harmonics, >= 0.
    layers : sequence of (depth, A_rr, A_tt, A_rt, G, D)
        L layers, as of :func:`stacked_compliance`.
    open_bore : bool
        True for an open bore, False for a rigid core.

    Returns
    -------
    (L-1, 2, 2, n) array
        The boundaries from the outer one inwards.
    """
    n, system = np.asarray(n, dtype=float), LayerSystems.of(*layers)
    parts = [
        _transfers_through(system.layer_matrices(block), block, open_bore)
        for block in _blocks(n, layers)
    ]
    return np.concatenate(parts, axis=-1)


def _transfers_through(layers: SectionMatrices, n: Array, open_bore: bool) -> Array:
    """Return B of every boundary, (L-1, 2, 2, n), from the matrices E, Q, H of the layers.

    With the compliance Y of what lies below a layer, w0 = Y t0, its matrices give

        t0 = T t1,   T = (I + H Y)^-1 A',        w1 = (Q + A Y T) t1,

    so that Y follows from the core outwards, and B = T ... T from the surface inwards.  ``n`` are
    the harmonics; ``open_bore`` is True for an open bore, False for a rigid core.
    """
    *above, innermost = zip(*(np.moveaxis(X, 2, 0) for X in layers), strict=True)
    Y, across = _compliance_on_core(innermost, n, open_bore), []
    for E, Q, H in reversed(above):
        A = _identity_plus(E)
        T = _product(_inverse_of_identity_plus(_product(H, Y)), A.swapaxes(0, 1))
        Y = Q + _product(_product(A, Y), T)
        across.append(T)
    return np.array(list(accumulate(reversed(across), lambda B, T: _product(T, B))))


def _compliance_on_core(stack: SectionMatrices, n: Array, open_bore: bool) -> Array:
    """Return Y_n of a stack on a rigid core, Y = Q, or with an open bore, Y = Q + A X A'.

    A = I + E, Q and H relate the displacements w and tractions t of bore (0) and surface (1),
    w1 = A w0 + Q t1 and t0 = A' t1 - H w0 (see the module).  On a rigid core w0 = 0.

    A bore without traction, t0 = 0, has w0 = X A' t1 with X = H^-1.  For n = 0 (rotation) and n = 1
    (translation) H is singular.  There the bore takes up the torque or the resultant force, and its
    mean rotation or translation is zero: w0 is parallel to f and f.t0 = 0, so that
    X = f f'/(f' H f), with f = (1, 0) for n = 0 and f = (1, 1)/sqrt(2) for n = 1.
    """
    E, Q, H = stack
    if not open_bore:
        return Q
    A = _identity_plus(E)
    (a, b), (c, d) = H
    is_rigid_motion, is_one = n < 2, n == 1
    # X is `projected` for n < 2 and `inverse` for n >= 2; where it is not used, the divisor is 1
    f = np.array([np.where(is_one, np.sqrt(0.5), 1.0), np.where(is_one, np.sqrt(0.5), 0.0)])
    fHf = f[0] * (a * f[0] + b * f[1]) + f[1] * (c * f[0] + d * f[1])
    inverse = np.array([[d, -b], [-c, a]]) / np.where(is_rigid_motion, 1.0, a * d - b * c)
    projected = f[:, None] * f[None] / np.where(is_rigid_motion, fHf, 1.0)
    return Q + _product(
        _product(A, np.where(is_rigid_motion, projected, inverse)), A.swapaxes(0, 1)
    )


@dataclass(frozen=True)
class LayerSystems:
    """The linear systems of all layers, and the matrices E, Q, H that follow from them.

    Parameters
    ----------
    values : (6, L, 1) array
        Depth, A_rr, A_tt, A_rt, G, D; (6, 1, n) complex of an isotropic layer whose moduli depend
        on the harmonic.
    """

    values: Array

    @classmethod
    def of(cls, *layers: Layer) -> LayerSystems:
        """Return the coefficients of layers, outermost first.

        D is computed from A_rr, A_tt and A_rt of a layer that does not state it.
        """
        # of each layer its depth, A_rr, A_tt, A_rt and G, which are its first five values, and D
        values = [
            (*layer[:5], (layer[5] if len(layer) > 5 else None) or stiffness_along(*layer[1:4]))  # type: ignore[arg-type]
            for layer in layers
        ]
        return cls(np.array(values).T[..., None])

    def with_constant_bulk(self, layer: int, factors: Array) -> LayerSystems:
        """Return an isotropic layer with G times the factors (n,) and the same K.

        K = A_rr - 4 G/3 cancels in no case: with G' = factors * G the moduli are
        A_rr + 4 (G' - G)/3, A_rt - 2 (G' - G)/3 and D = 4 G' (A_rt + G')/A_rr, all of G'.
        """
        depth, A_rr, _, A_rt, G, _ = self.values[:, layer]
        increment = G * (factors - 1)
        direct, cross, shear = A_rr + 4 / 3 * increment, A_rt - 2 / 3 * increment, G + increment
        D = 4 * shear * (cross + shear) / direct
        depths = np.full(factors.shape, depth)
        return LayerSystems(np.array([depths, direct, direct, cross, shear, D])[:, None])

    @property
    def depth(self) -> Array:
        """ln(outer/inner radius), (L, 1); real also with complex moduli."""
        return self.values[0].real

    @property
    def D(self) -> Array:
        """A_tt - A_rt^2/A_rr [Pa]."""
        return self.values[5]

    @cached_property
    def stress_scale(self) -> Array:
        """A stress that scales N and K to the same magnitude [Pa]."""
        smaller = np.minimum(np.abs(self.values[1]), np.abs(self.values[4]))
        return np.sqrt(np.abs(self.D) * smaller)

    def roots(self, n: Array) -> tuple[Array, Array]:
        """Return lambda_1 + lambda_3 and lambda_1 lambda_3, the positive roots of thesis eq. (43).

        They are (L, k) for L layers and k harmonics n.
        For n = 0 their difference and minus their product; :meth:`thin_layer_matrices` uses even
        functions of them only, which are the same.
        """
        _, A_rr, A_tt, A_rt, G, D = self.values
        s = np.sqrt(A_rr * A_tt)
        product = s / A_rr * (n * n - 1)
        # mu_n + sqrt(kappa_n) of (45), written as a sum of positive terms
        square = n * n * D * (1 / G + 2 / (s + A_rt)) + (1 - np.sqrt(A_tt / A_rr)) ** 2
        # of an isotropic layer they are n + 1 and n - 1 for any moduli, also complex ones
        return np.sqrt(square.real), product.real

    def penetration_depth(self, n: Array) -> Array:
        """Return the depth in ln r at which harmonic n has decayed to exp(-20), or the layer's.

        (L, k) for L layers and k harmonics.
        """
        total, product = self.roots(n)
        # at most the smaller root: total/2 if complex, product/total < product/larger if real
        rate = np.minimum(total / 2, product / np.maximum(total, 1e-300))
        rate[:, n < 2] = 0.0  # rotation and translation do not decay
        return np.minimum(self.depth, 20 / np.maximum(rate, 1e-300))

    def stack_matrices(self, n: Array, moduli: RelaxingModuli | None = None) -> SectionMatrices:
        """Return E, Q [1/Pa], H [Pa] of the stack of all layers, (2, 2, n)."""
        E, Q, H = self.layer_matrices(n) if moduli is None else self._viscoelastic(n, moduli)
        while E.shape[2] > 1:  # stack neighbours in pairs; an odd one waits for the next pass
            paired = E.shape[2] // 2 * 2
            upper, lower = (tuple(X[:, :, k:paired:2] for X in (E, Q, H)) for k in (0, 1))
            pairs = star_product(lower, upper)  # type: ignore[arg-type]
            E, Q, H = (
                np.concatenate([pair, X[:, :, paired:]], axis=2)
                for pair, X in zip(pairs, (E, Q, H), strict=True)
            )
        return E[:, :, 0], Q[:, :, 0], H[:, :, 0]

    def _viscoelastic(self, n: Array, moduli: RelaxingModuli) -> SectionMatrices:
        """Return E, Q [1/Pa], H [Pa] of every layer with relaxing moduli, (2, 2, L, n)."""
        E, Q, H = self.layer_matrices(n)
        factors = moduli.factors(n)
        Q, H = Q / factors, H * factors  # E depends on the ratios of a layer's moduli only
        if any(moduli.constant_bulk):
            E = E.astype(complex)
        for k in np.flatnonzero(moduli.constant_bulk):
            layer = self.with_constant_bulk(int(k), factors[k])
            for all_layers, one in zip((E, Q, H), layer.layer_matrices(n), strict=True):
                all_layers[:, :, k] = one[:, :, 0]
        return E, Q, H

    def layer_matrices(self, n: Array) -> SectionMatrices:
        """Return E, Q [1/Pa], H [Pa] of every layer, (2, 2, L, n).

        A thin layer is doubled until it has the depth of the layer, or of the penetration of the
        harmonic.
        """
        _, A_rr, _, A_rt, G, _ = self.values
        depth = self.penetration_depth(n)
        m = np.maximum(n, 1.0)
        # a thin layer has |M| <= 1/8, so that the series of e^M converges rapidly
        smaller = np.minimum(np.abs(A_rr), np.abs(G))
        size = np.maximum(np.maximum(np.abs(A_rt / A_rr), 1.0), np.sqrt(np.abs(self.D) / smaller))
        doublings = max(0, ceil(log2(8 * (size * m * depth).max())))
        layer = self.thin_layer_matrices(n, depth / 2**doublings)
        for _ in range(doublings):
            layer = star_product(layer, layer)
        E, Q, H = layer
        # from stresses in m * stress_scale to Pa
        return E, Q / (m * self.stress_scale), H * (m * self.stress_scale)

    def system_matrix(self, n: Array, h: Array) -> Array:
        """Return M, h times the matrix of d/dy (w, t), (L, n, 4, 4).

        The stresses t are in m * stress_scale, m = max(n, 1).
        """
        _, A_rr, _, A_rt, G, _ = self.values
        a, D, m = A_rt / A_rr, self.D, np.maximum(n, 1.0) * self.stress_scale
        M = np.zeros((*h.shape, 4, 4), dtype=self.values.dtype)
        M[..., 0, 0], M[..., 0, 1], M[..., 1, 0], M[..., 1, 1] = -a, -a * n, n, 1.0
        M[..., 0, 2], M[..., 1, 3] = m / A_rr, m / G
        M[..., 2, 0] = D / m
        M[..., 2, 1] = M[..., 3, 0] = n * D / m
        M[..., 3, 1] = n * n * D / m
        M[..., 2:, 2:] = -M[..., :2, :2].swapaxes(-1, -2)
        return M * h[..., None, None]

    def thin_layer_matrices(self, n: Array, h: Array) -> SectionMatrices:
        """Return E, Q, H of layers of depth h, (2, 2, L, n), as of :meth:`system_matrix`.

        With the 2 x 2 blocks of (w1, t1) = e^M (w0, t0) and e^M - I = [[., N], [K, L]],
        t0 = (I + L)^-1 (t1 - K w0) gives A' = (I + L)^-1, H = A' K and Q = N A'.
        """
        M = self.system_matrix(n, h)
        total, product = self.roots(n)
        # of the characteristic equation M^4 - b M^2 + c I = 0
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
        exp_minus_1 = M + f1 * M + f2 * square + f3 * (square @ M) + f0 * np.eye(4)
        # contiguous in the order of the following operations, which is a third faster
        exp_minus_1 = np.ascontiguousarray(np.moveaxis(exp_minus_1, (-2, -1), (0, 1)))
        N, K, L = exp_minus_1[:2, 2:], exp_minus_1[2:, :2], exp_minus_1[2:, 2:]
        inverse = _inverse_of_identity_plus(L)
        E = -_product(inverse, L).swapaxes(0, 1)
        return E, _product(N, inverse), _product(inverse, K)


def star_product(lower: SectionMatrices, upper: SectionMatrices) -> SectionMatrices:
    """Return E, Q, H of one layer on another (Redheffer star product).

    With A = I + E, a the lower and b the upper layer,

        S = (I + Q_a H_b)^-1,       A = A_b S A_a,
        Q = Q_b + A_b S Q_a A_b',   H = H_a + A_a' H_b S A_a.

    E = A - I is small in thin layers and is computed without this difference: S = I - Q_a H_b S
    gives E = (A_b A_a - I) - A_b Q_a H_b S A_a, and A_b A_a - I = E_a + E_b + E_b E_a.
    """
    E_a, Q_a, H_a = lower
    E_b, Q_b, H_b = upper
    A_a = _identity_plus(E_a)
    A_b = A_a if upper is lower else _identity_plus(E_b)
    S = _inverse_of_identity_plus(_product(Q_a, H_b))
    # swapaxes(0, 1) is the transpose of the matrices; the harmonics are on the last axis
    AQ, HSA = _product(A_b, Q_a), _product(H_b, _product(S, A_a))
    E = E_a + E_b + _product(E_b, E_a) - _product(AQ, HSA)
    # S Q_a = Q_a S', because Q and H are symmetric
    Q = Q_b + _product(AQ, _product(A_b, S).swapaxes(0, 1))
    return E, Q, H_a + _product(A_a.swapaxes(0, 1), HSA)


def _product(X: Array, Y: Array) -> Array:
    """Multiply 2 x 2 matrices, shape (2, 2, ...)."""
    product: Array = X[:, :1] * Y[:1]
    product += X[:, 1:] * Y[1:]
    return product


def _identity_plus(E: Array) -> Array:
    """Return I + E of 2 x 2 matrices, shape (2, 2, ...)."""
    A = E.copy()
    A[0, 0] += 1
    A[1, 1] += 1
    return A


def _inverse_of_identity_plus(X: Array) -> Array:
    """Return (I + X)^-1 of 2 x 2 matrices, shape (2, 2, ...)."""
    (a, b), (c, d) = X
    det = 1 + (a + d) + (a * d - b * c)
    return np.array([[1 + d, -b], [-c, 1 + a]]) / det
