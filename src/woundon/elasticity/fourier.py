"""Fourier sums around a circle whose coefficients decay algebraically.

The influence functions of a cylinder are sums over the harmonics n of the angle theta,

    f(theta) = c_0 + sum_{n>=1} c_n trig(n theta),        trig = cos (even) or sin (odd),

with coefficients c_n = a_0 + a_1/n + ... + a_J/n^J + r_n whose remainder r_n decays rapidly.
The powers are summed in closed form: the sums of n^-j cos(n theta) and n^-j sin(n theta) are the
real and the imaginary part of the polylogarithm

    Li_j(e^{i theta}) = (i theta)^(j-1)/(j-1)! [1 + 1/2 + ... + 1/(j-1) - ln(-i theta)]
                        + sum_{k != j-1} zeta(j-k) (i theta)^k / k!,     0 < theta < 2 pi,

(DLMF 25.12.12).  This isolates the singularities at theta = 0: the pole or Dirac pulse of a_0, the
logarithm or step of a_1, and the weaker terms theta^(j-1) ln(theta).  The regular part and its
first two derivatives are tabulated by fast Fourier transform and interpolated by quintics.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import ceil, comb, factorial, log, pi

import numpy as np

from .kernels import Kernel

__all__ = [
    "POWERS",
    "HarmonicSum",
    "HarmonicSums",
    "polylogarithm",
    "quintics",
]

Array = np.ndarray

BLOCK = 1024  # angles per block in the evaluation of power series
# A contact seldom extends over more than the first steps of the table.  These are summed directly,
# which is cheaper than a Fourier transform up to MAX_DIRECT_SIZE steps around the circle.
SHORT_TABLE, MAX_DIRECT_SIZE = 16, 4096
POWERS = 60  # terms of the power series, of radius 2 pi: at the angle pi (1/2)^60 < 1e-18
MARGIN = 1 / 16  # tables extend to (1 + MARGIN) pi; 0.53^60 < 1e-16 there


@dataclass(frozen=True, eq=False)
class Polylogarithm:
    """Li_j(e^{i theta}) = pole/theta + log theta^(j-1) ln(theta) + sum_k power[k] theta^k."""

    pole: complex
    log: complex
    power: Array


@lru_cache(maxsize=32)
def polylogarithm(j: int) -> Polylogarithm:
    """Return the expansion of Li_j(e^{i theta}), 0 < theta <= pi, for an integer j >= 0."""
    power = np.array([_zeta(j - k) * 1j**k / factorial(k) for k in range(POWERS) if k != j - 1])
    if j == 0:
        return Polylogarithm(1j, 0.0, power)
    lead = 1j ** (j - 1) / factorial(j - 1)
    harmonic = sum(1 / m for m in range(1, j))
    # the power k = j - 1 has the finite part of 1 + ... + 1/(j-1) - ln(-i theta), in which
    # ln(-i theta) = ln(theta) - i pi/2
    return Polylogarithm(0.0, -lead, np.insert(power, j - 1, lead * (harmonic + 0.5j * pi)))


@lru_cache(maxsize=16)
def _power_series(odd: bool, orders: int) -> Array:
    """Return the real or imaginary power[k] of Li_0, Li_1, ..., (orders, POWERS)."""
    powers = np.array([polylogarithm(j).power for j in range(orders)])
    return powers.imag if odd else powers.real


@lru_cache(maxsize=8)
def _powers_of_angles(size: int) -> Array:
    """Return theta^k and its first two derivatives at the first angles 2 pi i/size of a table.

    At most BLOCK angles, (3, POWERS, i).
    """
    theta = 2 * pi / size * np.arange(min(BLOCK, int(size / 2 * (1 + MARGIN)) + 1))
    k, out = np.arange(1.0, POWERS)[:, None], np.zeros((3, POWERS, theta.size))
    powers, first, second = out
    powers[0], powers[1:] = 1.0, theta
    np.cumprod(powers, axis=0, out=powers)
    first[1:] = k * powers[:-1]
    second[1:] = k * first[:-1]
    return out


def _shift_series(series: Array, shift: float, terms: int) -> Array:
    """Re-expand power series of theta in powers of theta - shift, (..., terms)."""
    binomials, exponents = (matrix[:, :terms] for matrix in _binomials())
    return series @ (binomials * (shift ** np.arange(POWERS))[exponents])


@lru_cache(maxsize=8)
def _short_table_harmonics(size: int, terms: int) -> Array:
    """Return the matrix of the direct Fourier sums at the angles 2 pi k/size of the short table.

    Its rows are 2 cos(n theta), n = 1 ... terms, then -2 sin(n theta), to be multiplied by the real
    and the imaginary parts of the coefficients of e^{i n theta}: (2 terms, SHORT_TABLE + 1).
    """
    # n k modulo size: angles below 2 pi are not affected by rounding
    angles = 2 * pi / size * (np.outer(np.arange(1, terms + 1), np.arange(SHORT_TABLE + 1)) % size)
    return np.concatenate([2 * np.cos(angles), -2 * np.sin(angles)])


@lru_cache(maxsize=1)
def _binomials() -> tuple[Array, Array]:
    """Return the binomial coefficients (k over i) and the exponents max(k - i, 0), (k, i)."""
    k = np.arange(POWERS)
    binomials = np.array([[comb(n, i) for i in k.tolist()] for n in k.tolist()], dtype=float)
    return binomials, np.maximum(k[:, None] - k, 0)


@lru_cache(maxsize=128)
def _zeta(s: int) -> float:
    """Return Riemann's zeta(s) for an integer s != 1, for s < 0 by the reflection formula."""
    if s == 0:
        return -0.5
    if s < 0:
        if s % 2 == 0:
            return 0.0
        m = 1 - s
        return 2 * (2 * pi) ** -m * (-1.0) ** (m // 2) * factorial(m - 1) * _zeta(m)
    # Euler-Maclaurin after N terms; the first neglected term is below 1e-17 for s >= 2
    N = 20
    head = sum(float(k) ** -s for k in range(N - 1, 0, -1))
    tail = float(N) ** (1 - s) / (s - 1) + 0.5 * float(N) ** -s
    rising = float(s)
    for m, bernoulli in enumerate((1 / 6, -1 / 30, 1 / 42, -1 / 30, 5 / 66), start=1):
        tail += bernoulli / factorial(2 * m) * rising * float(N) ** (1 - s - 2 * m)
        rising *= (s + 2 * m - 1) * (s + 2 * m)
    return head + tail


@dataclass(frozen=True, eq=False)
class HarmonicSum:
    """The function scale * [mean + sum_n (a_0 + a_1/n + ... + r_n) trig(n t/radius)] of t [m].

    Parameters
    ----------
    odd : bool
        True for sines, False for cosines.
    radius : float
        Radius R of the circle [m]; t is an arc length.
    scale : float
        Factor in front of the sum.
    mean : float
        Coefficient of n = 0; cosines only.
    tail : ndarray, shape (J+1,), J >= 1
        a_0 ... a_J.
    remainder : ndarray, shape (N,)
        r_n, n = 1 ... N; zero for larger n.
    regular : ndarray, shape (POWERS,), optional
        Power series of theta that is added; even powers of cosines, odd powers of sines.
        ``second_integral`` does not include it.
    """

    odd: bool
    radius: float
    scale: float
    mean: float
    tail: Array
    remainder: Array
    regular: Array | None = None

    def kernel(self) -> Kernel:
        """Return the singular coefficients and the smooth part, which is tabulated on first use.

        The smooth part holds for |t| <= pi R.  It is bounded, and smooth on either side of t = 0;
        at t = 0 it may have a kink (even sums) or behave as t ln|t| (odd sums).
        """
        scale, R = self.scale, self.radius
        a = self.tail
        if self.odd:
            inverse, sign = scale * a[0] * R, scale * a[1] * pi / 2
            return Kernel(
                inverse=inverse, sign=sign, smooth=self, second_integral=self.second_integral
            )
        delta, log_ = scale * a[0] * pi * R, -scale * a[1]
        return Kernel(delta=delta, log=log_, smooth=self, second_integral=self.second_integral)

    def second_integral(self, t: Array) -> Array:
        """Return a second integral K, K'' = f, of the sum with its singularities at t [m], like t.

        The sum without its mean is integrated as a function of period 2 pi R.
        """
        period, antiderivative = 2 * pi * self.radius, self._second_antiderivative
        shift = period * np.rint(t / period)  # whole turns
        K = antiderivative(t - shift) + self.scale * self.mean / 2 * t * t
        if self.odd and antiderivative.regular is not None:
            # continue the linear term, which is not periodic, over the whole turns
            K += antiderivative.regular[1] / self.radius * shift
        return K

    @cached_property
    def _second_antiderivative(self) -> HarmonicSum:
        """The sum of -R^2 c_n/n^2 trig(n theta), less its value (even) or slope (odd) at 0."""
        n = np.arange(1, self.remainder.size + 1)
        # Two leading zeros divide the tail by n^2: a_0 becomes the coefficient of 1/n^2, and so on.
        tail = np.concatenate([[0.0, 0.0], self.tail])
        scale, remainder = -self.scale * self.radius**2, self.remainder / (n * n)
        total = HarmonicSum(self.odd, self.radius, scale, 0.0, tail, remainder)
        # Constant and slope are arbitrary.  Large ones would cause cancellation in the second
        # differences over short cells.
        lowest = int(self.odd)
        regular = np.zeros(POWERS)
        remainder_at_zero = scale * float(remainder @ n if self.odd else remainder.sum())
        # value (even) or slope (odd) at 0 of the tail's sum, from its series, and of the remainder
        regular[lowest] = -float(total.series[lowest]) - remainder_at_zero
        return replace(total, regular=regular)

    def __call__(self, t: Array) -> Array:
        """Return the smooth part at the arc lengths t [m], any shape, |t| <= pi R."""
        return self._table(t)[0]

    @cached_property
    def _table(self) -> HarmonicSums:
        """The table of this sum alone."""
        return HarmonicSums((self,))

    def log_coefficients(self) -> Array:
        """Return the coefficients of theta^(j-1) ln(theta), one for each j of the tail.

        j = 2, 4, ... of an odd sum and 3, 5, ... of an even one; that of ln(theta) itself, j = 1,
        is singular.
        """
        orders = range(2 if self.odd else 3, self.tail.size, 2)
        weights = np.array([polylogarithm(j).log for j in orders])
        weights = weights.imag if self.odd else weights.real
        return np.array(self.scale * self.tail[orders.start :: 2] * weights)

    @property
    def spectrum(self) -> Array:
        """Coefficients of exp(i n theta) of the remainder, n = 1 ... N."""
        return (-0.5j if self.odd else 0.5) * self.scale * self.remainder

    @property
    def series(self) -> Array:
        """Power series of theta of the regular part of the sums of a_j/n^j, (POWERS,)."""
        c = self.tail @ _power_series(self.odd, self.tail.size)
        if self.odd:
            c[0] = 0.0  # the step of a_1 is Kernel.sign
        else:
            c[0] += self.mean + self.tail[1] * log(self.radius)  # ln(theta) = ln(t) - ln(R)
        c *= self.scale
        return np.asarray(c if self.regular is None else c + self.regular)


@dataclass(frozen=True, eq=False)
class HarmonicSums:
    """The smooth parts of several sums with the same radius and number of terms, in one table.

    The evaluation of all sums costs hardly more than that of one.

    Attributes
    ----------
    sums : tuple of HarmonicSum
    parent : (HarmonicSums, slice), optional
        A larger set whose table contains the sums, and their position in it.
    """

    sums: tuple[HarmonicSum, ...]
    parent: tuple[HarmonicSums, slice] | None = None

    def select(self, positions: slice) -> HarmonicSums:
        """Return some of the sums, which share the table of all."""
        return HarmonicSums(self.sums[positions], (self, positions))

    def kernels(self) -> tuple[Kernel, ...]:
        """Return the sums as influence functions that share one table of smooth parts."""
        return tuple(
            replace(sum_.kernel(), smooth=self.select(slice(k, k + 1)).first)
            for k, sum_ in enumerate(self.sums)
        )

    def first(self, t: Array) -> Array:
        """Return the smooth part of the first sum at t [m], shape t.shape."""
        return np.asarray(self(t)[0])

    @property
    def max_distance(self) -> float:
        """Largest |t| in the table [m]; the expansions converge for all angles below 2 pi."""
        return (1 + MARGIN) * pi * self.sums[0].radius

    def __call__(self, t: Array) -> Array:
        """Return the smooth parts at arc lengths |t| <= max_distance [m], (sums, *t.shape).

        They are bounded (:meth:`HarmonicSum.kernel`): the quintics of the table, and the terms
        theta^(j-1) ln(theta), which are not tabulated as their derivatives are unbounded.  Both are
        evaluated at |t|; odd sums are multiplied by the sign of t.
        """
        t = np.asarray(t, dtype=float)
        flat = t.ravel()
        theta = np.abs(flat) * (1 / self.sums[0].radius)
        x = theta * (self._size / (2 * pi))  # in steps of the table
        # a contact of small angles needs the first steps only, which are tabulated faster alone
        is_short = x.max(initial=0.0) < SHORT_TABLE and self._size <= MAX_DIRECT_SIZE
        coefficients = self._short_quintics if is_short else self._all_quintics
        i = x.astype(np.intp)
        np.minimum(i, coefficients.shape[-1] - 1, out=i)
        x -= i  # position in step i
        # Horner's scheme, without temporary arrays
        y = coefficients[5].take(i, axis=-1, mode="clip")
        buffer = np.empty_like(y)
        for c in coefficients[4::-1]:
            y *= x
            y += c.take(i, axis=-1, mode="clip", out=buffer)
        y += self._log_terms(theta)
        sign = np.sign(flat)
        for row, odd in zip(y, self._odd, strict=True):
            if odd:
                row *= sign
        return y.reshape(-1, *t.shape)

    def _log_terms(self, theta: Array) -> Array:
        """Return the sums of the terms theta^(j-1) ln(theta) at theta >= 0, (sums, theta).

        j - 1 = 2, 4, ... for even sums; for odd ones, 1, 3, ..., theta^2, theta^4, ... are divided
        by theta.
        """
        square = theta * theta
        powers = np.empty((self._log_coefficients.shape[1], theta.size))
        powers[0] = square
        for k in range(1, len(powers)):
            np.multiply(powers[k - 1], square, out=powers[k])
        positive = np.maximum(theta, 1e-150)  # the terms vanish at theta = 0
        logarithm = np.log(positive)
        terms: Array = self._log_coefficients @ powers
        over_theta = logarithm / positive
        for row, odd in zip(terms, self._odd, strict=True):
            row *= over_theta if odd else logarithm
        return terms

    @cached_property
    def _odd(self) -> tuple[bool, ...]:
        """True for each sum of sines."""
        return tuple(sum_.odd for sum_ in self.sums)

    @cached_property
    def _size(self) -> int:
        """Steps around the circle: 4 for the shortest wave, whose amplitude is negligible."""
        return max(256, 1 << (4 * self.sums[0].remainder.size - 1).bit_length())

    @cached_property
    def _short_quintics(self) -> Array:
        """Coefficients of the quintics on the first steps, (6, sums, SHORT_TABLE)."""
        if self.parent is not None:
            return np.ascontiguousarray(self.parent[0]._short_quintics[:, self.parent[1]])
        return self._tabulate(SHORT_TABLE + 1)

    @cached_property
    def _all_quintics(self) -> Array:
        """Coefficients of the quintics on all steps up to ``max_distance``, (6, sums, steps)."""
        if self.parent is not None:
            return np.ascontiguousarray(self.parent[0]._all_quintics[:, self.parent[1]])
        return self._tabulate(int(self._size / 2 * (1 + MARGIN)) + 1)

    def _tabulate(self, angles: int) -> Array:
        """Return the coefficients of the quintics between the first angles 2 pi k/size."""
        step = 2 * pi / self._size
        values = self._remainders(angles) + self._regular_parts(angles)
        # derivatives by the position in a step
        values *= np.array([1.0, step, step * step])[:, None, None]
        return np.ascontiguousarray(np.moveaxis(quintics(values), -1, 0))

    def _remainders(self, angles: int) -> Array:
        """Sum r_n trig(n theta) and its first two derivatives, (3, sums, angles)."""
        spectrum = np.array([sum_.spectrum for sum_ in self.sums])
        n = 1j * np.arange(1, spectrum.shape[-1] + 1)
        # f = Re(2 sum_n spectrum_n exp(i n theta)); a derivative multiplies the terms by i n
        if angles == SHORT_TABLE + 1:  # the short table: direct summation
            derivatives = np.array([spectrum, spectrum * n, spectrum * (n * n)])
            parts = np.concatenate([derivatives.real, derivatives.imag], axis=-1)
            return np.asarray(parts @ _short_table_harmonics(self._size, n.size))
        padded = np.zeros((3, len(spectrum), self._size // 2 + 1), dtype=complex)
        derivatives = padded[..., 1 : n.size + 1]
        derivatives[0] = spectrum * self._size
        np.multiply(derivatives[0], n, out=derivatives[1])
        np.multiply(derivatives[1], n, out=derivatives[2])
        return np.fft.irfft(padded, self._size)[..., :angles]

    def _regular_parts(self, angles: int) -> Array:
        """Evaluate the power series of theta and their first two derivatives, (3, sums, angles).

        All blocks of angles use the powers of the first block: the series are re-expanded there,
        with as many powers as their rounding errors require at a distance from the singularity at
        2 pi of at least (1 - MARGIN) pi.
        """
        c = np.array([sum_.series for sum_ in self.sums])
        powers, step = _powers_of_angles(self._size), 2 * pi / self._size
        parts = [c @ powers[..., :angles]]
        ratio = powers.shape[-1] * step / ((1 - MARGIN) * pi)
        terms = min(POWERS, 3 + ceil(log(1e-18, ratio))) if ratio < 1 else POWERS
        for first in range(BLOCK, angles, BLOCK):
            shifted = _shift_series(c, step * first, terms)
            parts.append(shifted @ powers[:, :terms, : angles - first])
        return np.concatenate(parts, axis=-1)

    @cached_property
    def _log_coefficients(self) -> Array:
        """Coefficients of the terms theta^(j-1) ln(theta), (sums, orders); at least one order."""
        log_coefficients = [sum_.log_coefficients() for sum_ in self.sums]
        padded = np.zeros((len(log_coefficients), max(1, *(row.size for row in log_coefficients))))
        for row, values in zip(padded, log_coefficients, strict=True):
            row[: values.size] = values
        return padded


def quintics(values: Array) -> Array:
    """Return the coefficients of the quintic Hermite interpolants with unit steps.

    Parameters
    ----------
    values : (3, ..., K+1) array
        f, f' and f'' at the K+1 points.

    Returns
    -------
    (..., K, 6) array
        Ascending coefficients in each step.

    Notes
    -----
    With f, f' and f''/2 at the left end, the Taylor parabola f + f' x + (f''/2) x^2 misses the
    values at the right end, x = 1, by three defects, which the terms x^3, x^4 and x^5 remove.
    """
    f0, slope0, second0 = values[..., :-1]
    f1, slope1, second1 = values[..., 1:]
    half = second0 / 2
    value_defect = f1 - f0 - slope0 - half
    slope_defect = slope1 - slope0 - second0
    half_second_defect = second1 / 2 - half
    return np.stack(
        (
            f0,
            slope0,
            half,
            10 * value_defect - 4 * slope_defect + half_second_defect,
            -15 * value_defect + 7 * slope_defect - 2 * half_second_defect,
            6 * value_defect - 3 * slope_defect + half_second_defect,
        ),
        axis=-1,
    )
