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

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement, product
from math import factorial

import numpy as np
from numpy.polynomial import chebyshev, hermite_e

__all__ = [
    "NEGLIGIBLE",
    "MarginMap",
    "Polynomial",
    "SetPoints",
    "expansion_of",
    "fitted",
    "from_reserve",
    "grid",
    "lobatto",
    "sobol_points",
    "standard_normal",
    "terms_of",
    "to_reserve",
]

Array = np.ndarray
# Share of the points that polynomials may have as coefficients if points are missing: least squares
# through scattered points oscillate when there are as many coefficients as points.
USED_SHARE = 0.7
POINTS_PER_TERM = 2  # of an expansion by least squares, the usual number
# of the variance of some margin at the centre, from which an input has quadratic effects as well
IMPORTANT = 0.01
RATIO = 5.0  # a: logarithmic from a fifth of the limit
NEGLIGIBLE = 1e-6  # standard deviation of y below which a margin is certain
ERROR_POINTS = 3  # every third point of the map gives the errors, which vary slowly


# ---- coordinates and samples --------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class SetPoints:
    """Coordinates of the set points: by logarithm if all values are > 0, else linear.

    The torque split, a share, is linear too.

    Attributes
    ----------
    names : tuple of str
        Dotted names of fields.
    ranges : (d, 2) array
        Lowest and highest value, of a schedule at the core, SI units.
    """

    names: tuple[str, ...]
    ranges: Array

    def is_linear(self, k: int) -> bool:
        """Return whether the coordinate k is linear in the value, not in its logarithm."""
        return bool(self.names[k] == "torque_split" or self.ranges[k, 0] <= 0)

    def along(self, k: int, x: Array) -> Array:
        """Return the values of the coordinate k, (points,)."""
        (low, high), share = self.ranges[k], (x + 1) / 2
        if self.is_linear(k):
            return np.asarray(low + (high - low) * share)
        return np.asarray(low * (high / low) ** share)

    def values(self, x: Array) -> Array:
        """Return the values of coordinates in [-1, 1], (points, d)."""
        return np.column_stack([self.along(k, column) for k, column in enumerate(x.T)])

    def coordinates(self, values: Array) -> Array:
        """Return the coordinates of values in [-1, 1], (points, d)."""
        shares = []
        for k, ((low, high), value) in enumerate(zip(self.ranges, values.T, strict=True)):
            if self.is_linear(k):
                shares.append((value - low) / (high - low))
            else:
                shares.append(np.log(value / low) / np.log(high / low))
        return np.clip(2 * np.column_stack(shares) - 1, -1.0, 1.0)


def grid(*axes: Array) -> Array:
    """Return all combinations of coordinates, (points, axes); the last one varies fastest."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def lobatto(count: int) -> Array:
    """Return the Chebyshev-Lobatto points in [-1, 1], ascending, (count,)."""
    # + 0.0 makes 0 of -0.0
    return np.round(-np.cos(np.pi * np.arange(count) / (count - 1)), 15) + 0.0


def sobol_points(dimension: int, samples: int, seed: int) -> Array:
    """Return scrambled Sobol points of the open unit cube, (samples, dimension)."""
    from scipy.stats import qmc

    power = int(np.ceil(np.log2(samples)))
    # the generator has one dimension at least; the slice also gives an array without columns
    points = qmc.Sobol(max(dimension, 1), rng=seed).random_base2(power)[:samples, :dimension]
    # the first point of a scrambled sequence may be 0 after rounding
    return np.clip(points, 1e-12, 1 - 1e-12)


def standard_normal(inputs: int, samples: int, seed: int) -> Array:
    """Return scrambled Sobol points of the standard normal distribution, (samples, inputs)."""
    from scipy.stats import norm

    return np.asarray(norm.ppf(sobol_points(inputs, samples, seed)))


# ---- margins ------------------------------------------------------------------------------------


def from_reserve(m: Array) -> Array:
    """Return y of reserves m, as shares of their limits."""
    return np.asarray(np.arcsinh(RATIO) - np.arcsinh(RATIO * (1 - m)))


def to_reserve(y: Array) -> tuple[Array, Array]:
    """Return the reserves of y, and their derivatives with respect to y."""
    inner = np.arcsinh(RATIO) - y
    return 1 - np.sinh(inner) / RATIO, np.cosh(inner) / RATIO


@dataclass(frozen=True, eq=False)
class Polynomial:
    """A sum of products of Chebyshev polynomials.

    Attributes
    ----------
    powers : (terms, d) int array
        Degree along each coordinate, of every term.
    coefficients : (terms, ...) array
        Further axes are those of the values.
    """

    powers: Array
    coefficients: Array

    def __call__(self, x: Array) -> Array:
        """Return the values at points, (points, ...)."""
        return np.tensordot(
            _products(chebyshev.chebvander, self.powers, x), self.coefficients, axes=1
        )


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
    powers = np.array(list(product(*(range(degree + 1) for degree in degrees))))
    if len(x) < len(powers):  # leave out the terms of the highest total degrees
        limit, total = max(1, int(USED_SHARE * len(x))), sum(degrees)
        while len(powers) > limit:
            total -= 1
            powers = powers[powers.sum(axis=1) <= total]
    flat = values.reshape(len(x), -1)
    coefficients = np.linalg.lstsq(_products(chebyshev.chebvander, powers, x), flat, rcond=1e-10)[0]
    return Polynomial(powers, coefficients.reshape(len(powers), *values.shape[1:]))


def _products(basis: Callable[[Array, int], Array], powers: Array, x: Array) -> Array:
    """Return products of polynomials in single coordinates.

    Parameters
    ----------
    basis : callable
        (coordinate, degree) -> polynomials of all degrees up to the given one, (points, degrees).
    powers : (terms, d) int array
        Degree in each coordinate.
    x : (points, d) array

    Returns
    -------
    (points, terms) array
    """
    values = np.ones((len(x), len(powers)))
    for column, power in zip(x.T, powers.T, strict=True):
        values *= basis(column, powers.max())[:, power]
    return values


def _hermite(z: Array, degree: int) -> Array:
    """Return normalised Hermite polynomials of a standard normal variable, (points, degrees)."""
    norms = np.sqrt([float(factorial(k)) for k in range(degree + 1)])
    return np.asarray(hermite_e.hermevander(z, degree) / norms)


# ---- effects of the inputs ----------------------------------------------------------------------


def expansion_of(x: Array, z: Array, changes: Array, differences: Array) -> tuple[Array, Array]:
    """Return the expansion of changes of the margins at set points with inputs.

    If the points are too few for least squares, the changes are linear in the inputs.

    Parameters
    ----------
    x : (points, d) array
        Coordinates of the set points in [-1, 1].
    z : (points, inputs) array
        Inputs in standard deviations from their medians.
    changes : (points, margins) array
        y(x, z) - M(x).
    differences : (inputs, margins) array
        Changes of y at one set point for one standard deviation of each input; nan if unknown.

    Returns
    -------
    powers : (terms, inputs) int array
    factors : (terms, 1 + d, margins) array
        As of :class:`MarginMap`.
    """
    inputs, d = z.shape[1], x.shape[1]
    if len(x) < POINTS_PER_TERM * (inputs + d + 1):
        factors = np.zeros((inputs, 1 + d, changes.shape[1]))
        factors[:, 0] = np.nan_to_num(differences)
        return np.eye(inputs, dtype=int), factors
    important = _important(differences)
    while important and POINTS_PER_TERM * terms_of(inputs, len(important), d) > len(x):
        important.pop()  # the least important one
    return _least_squares_expansion(x, z, changes, important)


def _least_squares_expansion(
    x: Array, z: Array, changes: Array, important: Sequence[int]
) -> tuple[Array, Array]:
    """Return powers and factors of the expansion by least squares.

    The linear effects of the important inputs depend on the set point, and their squares and
    products are included.

    Parameters
    ----------
    x, z, changes
        As of :func:`expansion_of`.
    important : sequence of int
        Numbers of the important inputs.
    """
    inputs, d = z.shape[1], x.shape[1]
    unit = np.eye(inputs, dtype=int)  # the degrees of z_1, z_2, ...
    pairs = combinations_with_replacement(sorted(important), 2)
    seconds = [unit[j] + unit[k] for j, k in pairs]
    powers = np.vstack([np.zeros((1, inputs), dtype=int), unit, *seconds])
    # which of 1, x_1, ..., x_d are factors of each term: all of the constant term, only 1 of others
    used = np.ones((len(powers), 1 + d), dtype=bool)
    used[1:, 1:] = False
    # and all of the linear terms of important inputs, which follow the constant term
    used[[1 + j for j in important], 1:] = True
    rows = _products(_hermite, powers, z)[:, :, None] * _with_one(x)[:, None, :]
    factors = np.zeros((*used.shape, changes.shape[1]))
    factors[used] = np.linalg.lstsq(rows[:, used], changes, rcond=1e-10)[0]
    return powers, factors


def _important(differences: Array) -> list[int]:
    """Return the inputs that matter for some margin, the most important one first.

    Inputs of an unknown effect are among them.

    Parameters
    ----------
    differences : (inputs, margins) array
        Changes for one standard deviation of each input.
    """
    variance = differences**2
    total = np.nansum(variance, axis=0)
    share = (variance / np.where(total > 0, total, 1.0)).max(axis=1)
    share[np.isnan(share)] = 1.0
    order = np.argsort(-share, kind="stable")
    return [k for k in order.tolist() if share[k] > IMPORTANT]


def terms_of(inputs: int, important: int, d: int) -> int:
    """Return the number of coefficients of an expansion.

    1 + d of the constant term, one of each linear term, d more of those of important inputs, and
    one of each square or product of important inputs.
    """
    return 1 + d + inputs + important * d + important * (important + 1) // 2


def _with_one(x: Array) -> Array:
    """Return 1, x_1, ..., x_d of points, (points, 1 + d)."""
    return np.column_stack([np.ones(len(x)), x])


@dataclass(frozen=True, eq=False)
class MarginMap:
    """The margins as functions of the operating point and the uncertain inputs.

    Attributes
    ----------
    nominal : Polynomial
        M(x), (points, margins).
    powers : (terms, inputs) int array
        Degree of psi in each input.  The psi are orthonormal for z of the standard normal
        distribution.
    factors : (terms, 1 + d, margins) array
        Of 1, x_1, ..., x_d in c.
    sample : (draws, inputs) array
        z.
    """

    nominal: Polynomial
    powers: Array
    factors: Array
    sample: Array

    def margins(self, x: Array, z: Array) -> Array:
        """Return y at set points with inputs z, one for each point, (points, margins)."""
        basis = _products(_hermite, self.powers, z)
        return np.asarray(self.nominal(x) + np.einsum("pmt,pt->pm", self._effects(x), basis))

    def _effects(self, x: Array) -> Array:
        """Return c at set points, (points, margins, terms)."""
        # points p, factors k of 1, x_1, ..., x_d, terms t, margins m
        return np.einsum("pk,tkm->pmt", _with_one(x), self.factors)

    def means(self, x: Array) -> Array:
        """Return the means of y, (points, margins)."""
        is_one = self.powers.sum(axis=1) == 0  # the constant term; the others have the mean 0
        return np.asarray(self.nominal(x) + self._effects(x)[..., is_one].sum(axis=-1))

    def variances(self, x: Array) -> Array:
        """Return the contributions of the inputs to the variance of y, (points, margins, inputs).

        The variance of a product is divided equally among its inputs (Shapley effects).
        """
        is_factor = self.powers > 0
        # share of each input in each term, (terms, inputs); the constant term has none
        shares = is_factor / np.maximum(is_factor.sum(axis=1, keepdims=True), 1)
        return np.asarray(self._effects(x) ** 2 @ shares)

    def distances(self, x: Array) -> Array:
        """Return the means of y in standard deviations, (points, margins).

        Without a deviation they are a large multiple of the mean.
        """
        return np.asarray(self.means(x) / np.maximum(self._deviations(x), NEGLIGIBLE))

    def reserves(self, x: Array) -> tuple[Array, Array]:
        """Return the reserves with median inputs and their standard deviations (first order).

        Both are (points, margins) arrays of shares of the limits.
        """
        reserve, derivative = to_reserve(self.nominal(x))
        return reserve, derivative * self._deviations(x)

    def _deviations(self, x: Array) -> Array:
        """Return the standard deviations of y, (points, margins)."""
        return np.asarray(np.sqrt(self.variances(x).sum(axis=-1)))

    def probability(self, x: Array, shift: Array | float = 0.0) -> Array:
        """Return the probability that all margins hold, (points,).

        Parameters
        ----------
        x : (points, d) array
        shift : (margins,) array, optional
            Added to y.
        """
        nominal, effects = self.nominal(x) + shift, self._effects(x)
        basis = _products(_hermite, self.powers, self.sample).T
        all_hold = np.ones((len(x), len(self.sample)), dtype=bool)
        for k in range(nominal.shape[1]):  # by margin: all at a time would take much memory
            all_hold &= nominal[:, k, None] + effects[:, k] @ basis >= 0
        return np.asarray(all_hold.mean(axis=1))

    def probability_errors(self, x: Array, deviations: Mapping[str, Array]) -> dict[str, float]:
        """Return the largest error of the probability at points from each source.

        Parameters
        ----------
        x : (points, d) array
        deviations : mapping of str to (margins,) array
            Differences of y from windings by source; nan if unknown, and the error is then.

        Returns
        -------
        dict of str to float
            The largest change if all margins are shifted by the deviations, and ``sampling``, the
            standard deviation of independent draws; the error of Sobol points is smaller.
        """
        x = x[::ERROR_POINTS]
        probability, errors = self.probability(x), {}
        for name, deviation in deviations.items():
            shifted = [self.probability(x, shift=side * deviation) for side in (-1, 1)]
            largest = float(np.abs(np.array(shifted) - probability).max())
            errors[name] = largest if np.isfinite(deviation).all() else np.nan
        variance = probability * (1 - probability) / len(self.sample)
        return {**errors, "sampling": float(np.sqrt(variance).max())}
