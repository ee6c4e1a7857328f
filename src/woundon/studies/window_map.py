r"""Margins over the operating point and the probability that all of them hold.

    y_i = asinh(a) - asinh(a (1 - m_i)),     a = 5,     y_i >= 0 if and only if m_i >= 0
    y_i(x, z) = M_i(x) + sum_t c_it(x) psi_t(z),     z_j ~ N(0, 1)

m_i is a reserve as a share of its limit, so that 1 - m_i is the ratio of value and limit.  Values
are about powers of the set points and of the inputs, and the logarithm of a power is linear: asinh
is a logarithm for large ratios that also admits values of zero and of the other sign.

x are the coordinates of the operating point, each scaled to [-1, 1], and z_j the logarithms of the
uncertain inputs in standard deviations from their medians.  M is a Chebyshev interpolant at
Chebyshev-Lobatto points.  The changes with z are a polynomial chaos expansion of second order:
psi_t are products of normalised Hermite polynomials, 1, z_j, z_j z_k and (z_j^2 - 1)/sqrt(2), and
their factors c_t are linear in x, found by least squares.  One sample of z is common to all points,
so that the probability is continuous in x and the margins stay correlated.

Reference: B. Sudret, Global sensitivity analysis using polynomial chaos expansions, Reliability
Engineering and System Safety 93 (2008) 964-979.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement, product

import numpy as np
from numpy.polynomial import chebyshev

__all__ = [
    "NEGLIGIBLE",
    "Expansion",
    "MarginMap",
    "Polynomial",
    "SetPoints",
    "distance",
    "expansion_of",
    "fitted",
    "from_reserve",
    "linear_expansion",
    "lobatto",
    "standard_normal",
    "terms_of",
    "to_reserve",
]

Array = np.ndarray
# Share of the points that polynomials may have as coefficients if points are missing: least squares
# through scattered points oscillate when there are as many coefficients as points.
USED_SHARE = 0.7
POINTS_PER_TERM = 2  # of an expansion by least squares, the usual number
RATIO = 5.0  # a: logarithmic from a fifth of the limit
NEGLIGIBLE = 1e-6  # standard deviation of y below which a margin is certain


@dataclass(frozen=True, eq=False)
class SetPoints:
    """Coordinates of the set points: tension and load by logarithm, the torque split linear.

    Attributes
    ----------
    names : tuple of str
    ranges : (d, 2) array
        Lowest and highest value at the core, SI units.
    """

    names: tuple[str, ...]
    ranges: Array

    @property
    def _is_logarithmic(self) -> Array:
        return np.array([name != "torque_split" for name in self.names])

    def coordinates(self, values: Array) -> Array:
        """Return the coordinates of values at the core in [-1, 1], (points, d)."""
        by_log = self._is_logarithmic
        low, high, inner = (
            np.where(by_log, np.log(np.where(by_log, v, 1.0)), v) for v in (*self.ranges.T, values)
        )
        return np.clip(2 * (inner - low) / (high - low) - 1, -1.0, 1.0)

    def values(self, x: Array) -> Array:
        """Return the values at the core of coordinates, (points, d)."""
        share, (low, high), by_log = (x + 1) / 2, self.ranges.T, self._is_logarithmic
        ratio = np.where(by_log, high / np.where(by_log, low, 1.0), 1.0)
        return np.where(by_log, low * ratio**share, low + (high - low) * share)

    def along(self, k: int, x: Array) -> Array:
        """Return the values at the core of one coordinate, (points,)."""
        return self.values(np.tile(x[:, None], len(self.names)))[:, k]


def distance(mean: Array, deviation: Array) -> Array:
    """Return means in standard deviations; without a deviation a large multiple of the mean."""
    return np.asarray(mean / np.maximum(deviation, NEGLIGIBLE))


def from_reserve(m: Array) -> Array:
    """Return y(reserve)."""
    return np.asarray(np.arcsinh(RATIO) - np.arcsinh(RATIO * (1 - m)))


def to_reserve(y: Array) -> tuple[Array, Array]:
    """Return the reserves of y, and their derivatives with respect to y."""
    inner = np.arcsinh(RATIO) - y
    return 1 - np.sinh(inner) / RATIO, np.cosh(inner) / RATIO


def lobatto(count: int) -> Array:
    """Return the Chebyshev-Lobatto points in [-1, 1], ascending, (count,)."""
    return np.round(-np.cos(np.pi * np.arange(count) / (count - 1)), 15) + 0.0


def standard_normal(inputs: int, samples: int, seed: int) -> Array:
    """Return scrambled Sobol points of the standard normal distribution, (samples, inputs)."""
    from scipy.stats import norm, qmc

    power = int(np.ceil(np.log2(samples)))
    points = qmc.Sobol(max(inputs, 1), rng=seed).random_base2(power)[:samples, :inputs]
    # The first point of a scrambled sequence may be 0 after rounding.
    return np.asarray(norm.ppf(np.clip(points, 1e-12, 1 - 1e-12)))


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A sum of products of Chebyshev polynomials.

    Attributes
    ----------
    powers : tuple of tuple of int
        Degree along each coordinate, of every term.
    coefficients : (terms, ...) array
    """

    powers: tuple[tuple[int, ...], ...]
    coefficients: Array

    def __call__(self, x: Array) -> Array:
        """Return the values at points, (points, ...)."""
        return np.tensordot(_terms(self.powers, x), self.coefficients, axes=1)


def fitted(x: Array, values: Array, degrees: Sequence[int]) -> Polynomial:
    """Return the polynomial through values at points.

    Parameters
    ----------
    x : (points, d) array
        In [-1, 1].
    values : (points, ...) array
    degrees : sequence of int
        Largest degree along each coordinate.

    Returns
    -------
    Polynomial
        The interpolant if the points are the tensor product of Lobatto points of these degrees;
        otherwise a least-squares fit of a lower total degree.
    """
    powers = list(product(*(range(degree + 1) for degree in degrees)))
    if len(x) < len(powers):
        limit = max(1, int(USED_SHARE * len(x)))
        total = sum(degrees)
        while len(powers) > limit:
            total -= 1
            powers = [power for power in powers if sum(power) <= total]
    flat = values.reshape(len(x), -1)
    coefficients = np.linalg.lstsq(_terms(tuple(powers), x), flat, rcond=1e-10)[0]
    return Polynomial(tuple(powers), coefficients.reshape(len(powers), *values.shape[1:]))


def _terms(powers: tuple[tuple[int, ...], ...], x: Array) -> Array:
    """Return products of Chebyshev polynomials at points x, (points, terms)."""
    degree = max(max(power) for power in powers)
    basis = [chebyshev.chebvander(column, degree) for column in x.T]
    return np.stack(
        [np.prod([basis[k][:, p] for k, p in enumerate(power)], axis=0) for power in powers],
        axis=1,
    )


@dataclass(frozen=True, eq=False)
class Expansion:
    """Changes of the margins with the uncertain inputs: sum_t c_t(x) psi_t(z).

    Attributes
    ----------
    products : tuple of tuple of int
        Inputs of each psi: () of 1, (j,) of z_j, (j, k) of z_j z_k, (j, j) of
        (z_j^2 - 1)/sqrt(2).  They are orthonormal for z of the standard normal distribution.
    factors : (products, 1 + d, margins) array
        Of 1, x_1, ..., x_d in c.
    inputs : int
    """

    products: tuple[tuple[int, ...], ...]
    factors: Array
    inputs: int

    def at(self, x: Array) -> Array:
        """Return c at set points, (points, margins, products)."""
        return np.einsum("pk,tkm->pmt", _with_one(x), self.factors)

    def basis(self, z: Array) -> Array:
        """Return psi of inputs, (draws, products)."""
        return _hermite(self.products, z)

    def mean(self, x: Array) -> Array:
        """Return the mean change, (points, margins)."""
        is_one = [product == () for product in self.products]
        return np.asarray(self.at(x)[..., is_one].sum(axis=-1))

    def variances(self, x: Array) -> Array:
        """Return the contributions of the inputs to the variance, (points, margins, inputs).

        The variance of a product is divided equally among its inputs (Shapley effects).
        """
        shares = np.zeros((len(self.products), self.inputs))
        for t, inputs in enumerate(self.products):
            for j in inputs:
                shares[t, j] += 1 / len(inputs)
        return np.asarray(self.at(x) ** 2 @ shares)


def linear_expansion(differences: Array, d: int) -> Expansion:
    """Return the expansion of changes that are linear in the inputs.

    Parameters
    ----------
    differences : (inputs, margins) array
        For one standard deviation of each input; those that are nan count as zero.
    d : int
        Number of coordinates of the set points.
    """
    inputs, margins = differences.shape
    factors = np.zeros((inputs, 1 + d, margins))
    factors[:, 0] = np.nan_to_num(differences)
    return Expansion(tuple((j,) for j in range(inputs)), factors, inputs)


def expansion_of(x: Array, z: Array, changes: Array, important: Sequence[int]) -> Expansion:
    """Return the expansion of changes that are known at set points with inputs, by least squares.

    Parameters
    ----------
    x : (points, d) array
    z : (points, inputs) array
    changes : (points, margins) array
        y(x, z) - M(x).
    important : sequence of int
        Inputs, the most important one first.  Their linear effects depend on the set point, and
        their squares and products are included, of as many of them as the points permit.
    """
    (d, inputs), important = (x.shape[1], z.shape[1]), list(important)
    while important and POINTS_PER_TERM * terms_of(inputs, len(important), d) > len(x):
        important.pop()
    products: list[tuple[int, ...]] = [(), *((j,) for j in range(inputs))]
    products += combinations_with_replacement(sorted(important), 2)
    # which of 1, x_1, ..., x_d are factors of each product
    varies = [len(p) == 0 or (len(p) == 1 and p[0] in important) for p in products]
    used = np.array([[True, *([v] * d)] for v in varies])
    rows = _hermite(products, z)[:, :, None] * _with_one(x)[:, None, :]
    factors = np.zeros((*used.shape, changes.shape[1]))
    factors[used] = np.linalg.lstsq(rows[:, used], changes, rcond=1e-10)[0]
    return Expansion(tuple(products), factors, inputs)


def terms_of(inputs: int, important: int, d: int) -> int:
    """Return the number of coefficients of an expansion."""
    return 1 + d + inputs + important * d + important * (important + 1) // 2


def _with_one(x: Array) -> Array:
    return np.column_stack([np.ones(len(x)), x])


def _hermite(products: Sequence[tuple[int, ...]], z: Array) -> Array:
    """Return products of normalised Hermite polynomials, (points, products)."""
    values = np.ones((len(z), len(products)))
    for t, p in enumerate(products):
        is_square = len(p) == 2 and p[0] == p[1]
        values[:, t] = (
            (z[:, p[0]] ** 2 - 1) / np.sqrt(2) if is_square else np.prod(z[:, list(p)], axis=1)
        )
    return values


@dataclass(frozen=True, eq=False)
class MarginMap:
    """The margins as functions of the operating point and the uncertain inputs.

    Attributes
    ----------
    nominal : Polynomial
        M, of (margins,) coefficients.
    expansion : Expansion
    sample : (draws, inputs) array
        z.
    """

    nominal: Polynomial
    expansion: Expansion
    sample: Array

    def moments(self, x: Array) -> tuple[Array, Array]:
        """Return mean and standard deviation of y, (points, margins) each."""
        mean = self.nominal(x) + self.expansion.mean(x)
        return mean, np.sqrt(self.variances(x).sum(axis=-1))

    def reserves(self, x: Array) -> tuple[Array, Array]:
        """Return the reserves with median inputs and their standard deviations (first order)."""
        reserve, derivative = to_reserve(self.nominal(x))
        return reserve, derivative * np.sqrt(self.variances(x).sum(axis=-1))

    def variances(self, x: Array) -> Array:
        """Return the contributions to the variance of y, (points, margins, inputs)."""
        return self.expansion.variances(x)

    def margins(self, x: Array, z: Array) -> Array:
        """Return y at set points with inputs z, one for each point, (points, margins)."""
        change = np.einsum("pmt,pt->pm", self.expansion.at(x), self.expansion.basis(z))
        return np.asarray(self.nominal(x) + change)

    def probability(self, x: Array, shift: Array | float = 0.0) -> Array:
        """Return the probability that all margins hold, (points,).

        Parameters
        ----------
        x : (points, d) array
        shift : (margins,) array, optional
            Added to y.
        """
        return self.holds(x, shift).all(axis=1).mean(axis=-1)

    def holds(self, x: Array, shift: Array | float = 0.0) -> Array:
        """Return a mask of the margins that hold for each draw, (points, margins, draws)."""
        mean, factors = self.nominal(x) + shift, self.expansion.at(x)
        basis = self.expansion.basis(self.sample).T
        holds = np.empty((len(x), mean.shape[1], len(self.sample)), dtype=bool)
        for k in range(mean.shape[1]):
            holds[:, k] = mean[:, k, None] + factors[:, k] @ basis >= 0
        return holds
