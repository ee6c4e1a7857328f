r"""Chebyshev elements on [-1, 1]: grids on which the singular kernels are integrated exactly.

Between two borders an element maps r in [-1, 1] on x by a cubic that is flat at both ends,

    x = e + L phi(r),    phi = (2 + 3 r - r^3)/4,    phi' = 3/4 (1 - r^2),

so that whatever goes like the root of the distance to a border is smooth in r: a polynomial of low
degree.  The map turns Cauchy's kernel at y into three of them, at the roots r_k of phi(r) = eta,
eta = (y - e)/L, and the logarithm into Cauchy's kernel, F being the integral of f from the right:

    int f/(y - x) dx      = - sum_k int f(r)/(r - r_k) dr
    int f ln|y - x| dx    = - F(left) ln|y - left| + int F/(y - x) dx

An element has m cells.  Its m + 1 nodes are Chebyshev's points of the second kind, its first and
last on the borders and shared with the neighbours; its m points, one in each cell, are those of the
first kind.

      border                                          border
    r = -1 |-o-|--o--|---o---|---o---|--o--|-o-| 1        | nodes   o points
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import ceil, pi
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev

from .grid import HIGHEST_RANK, Grid, chebyshev_transform

__all__ = ["Element", "ElementGrid", "cauchy", "element"]

Array = np.ndarray

# rounding grows in the recurrence by rho^n, rho the size of the ellipse through the pole; beyond
# this growth the pole is so far that Gauss's rule of 2.5 n points is exact to rounding
GROWTH = 1e4


def cauchy(z: Array, degree: int) -> Array:
    """Return int T_n(r)/(r - z) dr over [-1, 1], n = 0 ... degree: (z.size, degree + 1).

    On the cut it is the principal value; at its ends the logarithm is left out, which what vanishes
    there does not ask for.
    """
    out = np.empty((z.size, degree + 1), dtype=z.dtype)
    root = np.sqrt(z.astype(complex) ** 2 - 1)
    far = np.maximum(np.abs(z + root), np.abs(z - root)) ** degree > GROWTH
    if far.any():
        r, weights = _gauss(ceil(2.5 * degree) + 4)
        out[far] = (1 / (r - z[far, None])) @ (weights[:, None] * chebyshev.chebvander(r, degree))
    w, ends = z[~far], np.abs(z[~far]) == 1
    ratio = (1 - w) / np.where(ends, 1, 1 + w)
    first = np.log(np.where(ends, 1, np.abs(ratio))) if not np.iscomplexobj(z) else np.log(-ratio)
    near = [first, 2 + w * first]
    for n in range(1, degree):
        near.append(2 * w * near[n] - near[n - 1] + (0 if n % 2 else 4 / (1 - n * n)))
    out[~far] = np.transpose(near[: degree + 1])
    return out


@lru_cache(maxsize=64)
def _gauss(points: int) -> tuple[Array, Array]:
    return np.polynomial.legendre.leggauss(points)


@dataclass(frozen=True, eq=False)
class Element:
    """What all elements of m cells share: matrices on nodal values, for unit length."""

    cells: int

    @cached_property
    def angles(self) -> tuple[Array, Array]:
        """Half the angles of nodes and points: u = (1 + r)/2 is the square of their sine."""
        m = self.cells
        return pi / (2 * m) * np.arange(m + 1), pi / (2 * m) * (np.arange(m) + 0.5)

    @cached_property
    def coefficients(self) -> Array:
        """Chebyshev coefficients of the polynomial through nodal values, (m+1, m+1)."""
        return np.linalg.inv(chebyshev.chebvander(-np.cos(2 * self.angles[0]), self.cells))

    @cached_property
    def points(self) -> Array:
        """r of the points, (m,)."""
        return -np.cos(2 * self.angles[1])

    @cached_property
    def value(self) -> Array:
        """Values at the points, (m, m+1)."""
        return chebyshev.chebvander(self.points, self.cells) @ self.coefficients

    @cached_property
    def slope(self) -> Array:
        """Derivatives with respect to x at the points, (m, m+1)."""
        by_r = chebyshev.chebder(self.coefficients)
        by_x = 4 / 3 / np.sin(2 * self.angles[1]) ** 2
        return by_x[:, None] * (chebyshev.chebvander(self.points, self.cells - 1) @ by_r)

    def peak(self, values: Array) -> float:
        """Return the largest value of the polynomial through nodal values, (m+1,)."""
        series = self.coefficients @ values
        flat = chebyshev.chebroots(chebyshev.chebder(series))
        inside = flat[(flat.imag == 0) & (np.abs(flat) < 1)].real
        return float(max(*values, *chebyshev.chebval(inside, series)))

    @cached_property
    def start_slope(self) -> Array:
        """Derivative with respect to r at the left border, (m+1,)."""
        by_r = chebyshev.chebder(self.coefficients)
        return np.asarray(chebyshev.chebvander(np.array([-1.0]), self.cells - 1)[0] @ by_r)

    @cached_property
    def integrals(self) -> Array:
        """Coefficients of the integrals F over x, nil at the right border, (m+4, m+1)."""
        c = self.coefficients
        by_square = np.array([chebyshev.chebmul([0.375, 0, -0.375], column) for column in c.T]).T
        made = chebyshev.chebint(by_square)
        made[0] -= made.sum(0)
        return np.asarray(made)

    @cached_property
    def weights(self) -> Array:
        """Integrals over the whole element, (m+1,)."""
        signs = (-1.0) ** np.arange(self.cells + 4)
        return np.asarray(-signs @ self.integrals)

    @cached_property
    def upstream(self) -> Array:
        """Integrals from the left border to the points, (m, m+1)."""
        at_points = chebyshev.chebvander(self.points, self.cells + 3)
        return np.asarray(at_points @ self.integrals + self.weights)

    @cached_property
    def to_nodes(self) -> Array:
        """Integrals from the left border to the nodes, (m+1, m+1)."""
        at_nodes = chebyshev.chebvander(-np.cos(2 * self.angles[0]), self.cells + 3)
        return np.asarray(at_nodes @ self.integrals + self.weights)

    @cached_property
    def own(self) -> Array:
        """int T_n phi'/(eta - phi) dr at the own points and the right border, (m+1, m+4)."""
        r = np.append(self.points, 1.0)
        half = np.sqrt(12 - 3 * r * r)
        each = (r, (-r + half) / 2, (-r - half) / 2)
        return np.asarray(-sum(cauchy(root, self.cells + 3) for root in each))

    def other(self, away: Array, side: Array) -> Array:
        """Return the same at points outside.

        Parameters
        ----------
        away : (k,) array
            Distance from the nearer border in units of the element's length.
        side : (k,) array
            1 behind the element, -1 before it.

        Returns
        -------
        (k, m+4) array
        """
        degree = self.cells + 3
        third = 2 / 3 * np.arcsinh(np.sqrt(away))
        near = np.cosh(third) + 1j * np.sqrt(3) * np.sinh(third)
        out = np.empty((away.size, degree + 1))
        far = np.abs(near + np.sqrt(near**2 - 1)) ** degree > GROWTH
        if far.any():
            phi, kernel = self._far
            eta = np.where(side > 0, 1 + away, -away)[far, None]
            out[far] = (1 / (eta - phi)) @ kernel
        if not far.all():
            z, sign = near[~far], side[~far]
            out[~far] = -2 * cauchy(sign * z, degree).real
            out[~far] -= cauchy(-2 * sign * np.cosh(third[~far]), degree)
        return out

    @cached_property
    def _far(self) -> tuple[Array, Array]:
        """phi at Gauss's points, and the weights of its Chebyshev integrals there."""
        degree = self.cells + 3
        r, weights = _gauss(ceil(2.5 * degree) + 4)
        kernel = (weights * 0.75 * (1 - r * r))[:, None] * chebyshev.chebvander(r, degree)
        return (2 + 3 * r - r**3) / 4, kernel

    @lru_cache(maxsize=8)  # noqa: B019 - elements are kept as well
    def ruled(self, points: int) -> tuple[Array, Array]:
        """Return phi at the points of Gauss's rule, and the nodal functions by its weights."""
        r, weights = _gauss(points)
        values = chebyshev.chebvander(r, self.cells) @ self.coefficients
        return (2 + 3 * r - r**3) / 4, (weights * 0.75 * (1 - r * r))[:, None] * values

    @cached_property
    def to_right(self) -> Array:
        """Value at the right border of the polynomial through values at the points, (m,)."""
        made = np.linalg.solve(
            chebyshev.chebvander(self.points, self.cells - 1).T, np.ones(self.cells)
        )
        return np.asarray(made)

    @cached_property
    def extrapolation(self) -> Array:
        """Value at the left border of the polynomial through the nodes behind it, (m,)."""
        r = -np.cos(2 * self.angles[0][1:])
        made = np.linalg.solve(
            chebyshev.chebvander(r, self.cells - 1).T, (-1.0) ** np.arange(r.size)
        )
        return np.asarray(made)


@lru_cache(maxsize=64)
def element(cells: int) -> Element:
    """Return the element of so many cells."""
    return Element(cells)


@dataclass(frozen=True, eq=False)
class ElementGrid(Grid):
    """Chebyshev elements between borders, each of as many cells.

    Attributes
    ----------
    borders : (S+1,) array
        Increasing from -1 to 1.
    order : int
        Cells m of an element: polynomials are of this degree.
    split : bool
        Whether functions may jump behind a border: each element's left node is then no node of its
        own, and its polynomial of degree m - 1.
    beside : bool
        Whether the points lie outside the contact, in place of in the cells.
    """

    borders: Array
    order: int
    split: bool = False
    beside: bool = False

    @classmethod
    def between(cls, borders: Array, order: int, points: Array | None = None) -> ElementGrid:
        """Return the grid of given borders, and of its own points without others."""
        own = element(order)
        left, length = borders[:-1, None], np.diff(borders)[:, None]
        nodes = np.append((left + length * _phi(own.angles[0][:-1])).ravel(), borders[-1])
        if points is None:
            points = np.append((left + length * _phi(own.angles[1])).ravel(), borders[-1])
        return cls(nodes, points, borders, order)

    def outside(self, points: Array) -> ElementGrid:
        """Return the same elements with points outside them, none nearer than rounding can see."""
        points = np.sign(points) * np.maximum(np.abs(points), 1 + 1e-13)
        return replace(self, points=points, beside=True)

    @cached_property
    def lengths(self) -> Array:
        """Lengths of the elements, (S,)."""
        return np.diff(self.borders)

    @property
    def element(self) -> Element:
        """The element that all of them are."""
        return element(self.order)

    @cached_property
    def weights(self) -> Array:
        """Integrals of the nodal functions, (n,)."""
        return self.gathered(self.lengths[None, :, None] * self.element.weights)[0]

    @cached_property
    def value(self) -> Array:
        """Value at the points, (K, n)."""
        return self._in_own(self.element.value, np.ones(self.lengths.size))

    @cached_property
    def slope(self) -> Array:
        """Derivative at the points, (K, n); of the last one, the trailing edge, that before it."""
        made = self._in_own(self.element.slope, 1 / self.lengths)
        made[-1] = made[-2]
        return made

    @cached_property
    def upstream(self) -> Array:
        """Integral from the leading edge to the points, (K, n)."""
        return self._before(self.element.upstream)

    @cached_property
    def to_nodes(self) -> Array:
        """Integral from the leading edge to the nodes but the first, (N, n)."""
        return self._before(self.element.to_nodes[1:])[:-1]

    @cached_property
    def inverse(self) -> Array:
        """Principal values of int psi_m(s)/(y - s) ds, (K, n)."""
        return self.gathered(self._kernel[..., : self.order + 1] @ self.element.coefficients)

    @cached_property
    def log(self) -> Array:
        """Integrals of psi_m(s) ln|y - s| ds, (K, n)."""
        whole = np.log(np.abs(self._distance[:, :-1]))[..., None] * self.element.weights
        made = self._kernel @ self.element.integrals + whole
        return self.gathered(self.lengths[:, None] * made)

    @cached_property
    def sign(self) -> Array:
        """Integrals of psi_m(s) sgn(y - s) ds, (K, n)."""
        return 2 * self.upstream - self.weights

    @property
    def highest_rank(self) -> int:
        """The rank up to which kernels are interpolated."""
        return HIGHEST_RANK

    def _interpolate(self, r: int) -> tuple[Array, Array]:
        transform = chebyshev_transform(r)
        at_points = chebyshev.chebvander(self.points, r - 1) @ transform
        waves = r * float(np.max(np.diff(np.arccos(-self.borders))))
        phi, hats = self.element.ruled(8 * ceil((self.order + 8 + 0.75 * waves) / 8))
        x = self.borders[:-1, None] + self.lengths[:, None] * phi
        polynomials = chebyshev.chebvander(x.ravel(), r - 1).T.reshape(r, *x.shape)
        return at_points, transform.T @ self.gathered(polynomials * self.lengths[:, None] @ hats)

    def gathered(self, blocks: Array) -> Array:
        """Put the elements' matrices (K, S, m+1) into one on the interior nodes, (K, n)."""
        K, S, m = blocks.shape[0], self.lengths.size, self.order
        out = np.zeros((K, S * m + 1))
        blocks = self._on_nodes(blocks)
        if self.split:
            out[:, 1:] = blocks.reshape(K, S * m)
        else:
            out[:, :-1].reshape(K, S, m)[...] = blocks[..., :-1]
            out[:, m::m] += blocks[..., -1]
        return out[:, 1:-1]

    def _in_own(self, block: Array, factors: Array, whole: Array | None = None) -> Array:
        """Put an element's matrix at each one's own points, times a factor, and a row behind it."""
        if self.beside:
            behind = 0.0 if whole is None else np.where(self.points > 0, 1.0, 0.0)[:, None]
            return behind * np.broadcast_to(self.weights, (self.points.size, self.unknowns))
        m, block = self.order, self._on_nodes(block)
        out = np.zeros((self.lengths.size * m + 1,) * 2)
        for s, factor in enumerate(factors.tolist()):
            columns = slice(s * m + self.split, (s + 1) * m + 1)
            out[s * m : (s + 1) * m, columns] += factor * block
            if whole is not None:
                out[(s + 1) * m :, columns] += factor * self._on_nodes(whole)
        return out[:, 1:-1]

    def _before(self, block: Array) -> Array:
        return self._in_own(block, self.lengths, self.element.weights)

    def _on_nodes(self, blocks: Array) -> Array:
        """Return elements' matrices on nodes of their own, where the left one is none."""
        if not self.split:
            return blocks
        return blocks[..., 1:] + blocks[..., :1] * self.element.extrapolation

    @cached_property
    def _own(self) -> Array:
        """In which element each of the points lies, (K,)."""
        S, m = self.lengths.size, self.order
        if self.beside:
            return np.full(self.points.size, -1)
        return np.minimum(np.arange(S * m + 1) // m, S - 1)

    @cached_property
    def _distance(self) -> Array:
        """Points less borders, (K, S+1), without cancellation next to them."""
        t, own = self.points[:, None] - self.borders, self._own
        if self.beside:
            return t
        k, angles = np.arange(own.size - 1), np.tile(self.element.angles[1], self.lengths.size)
        t[k, own[:-1]] = self.lengths[own[:-1]] * _phi(angles)
        t[k, own[:-1] + 1] = -self.lengths[own[:-1]] * _phi(pi / 2 - angles)
        return t

    @cached_property
    def _kernel(self) -> Array:
        """int T_n phi'/(eta - phi) dr of every element at every point, (K, S, m+4)."""
        own, m, S = self._own, self.order, self.lengths.size
        out = np.empty((own.size, S, m + 4))
        if not self.beside:
            k = np.arange(own.size)
            out[k, own] = self.element.own[np.append(np.tile(np.arange(m), S), m)]
        other = np.arange(S) != own[:, None]
        left, right = self._distance[:, :-1][other], self._distance[:, 1:][other]
        away = np.where(right > 0, right, -left) / np.broadcast_to(self.lengths, other.shape)[other]
        out[other] = self.element.other(away, np.where(right > 0, 1.0, -1.0))
        return out


def _phi(angle: Array) -> Array:
    """Return phi by half the angle of r."""
    u = np.sin(angle) ** 2
    return u * u * (3 - 2 * u)


def borders_of(nodes: Array) -> tuple[Array, int] | None:
    """Return the borders and the order of an element grid by its nodes; None if it is none."""
    N: Any = nodes.size - 1
    for m in range(2, N + 1):
        if N % m == 0:
            made = ElementGrid.between(nodes[::m], m)
            if np.abs(made.nodes - nodes).max() < 1e-12:
                return nodes[::m], m
    return None
