"""Fourier sums around a circle whose coefficients decay algebraically.

The influence functions of a cylinder are sums over the harmonics n of the angle theta,

    f(theta) = c_0 + sum_{n>=1} c_n trig(n theta),        trig = cos (even) or sin (odd),

with coefficients that approach an inverse power series, c_n = a_0 + a_1/n + ... + a_J/n^J + rest_n.
The powers are summed in closed form: trig sums of n^-j are the parts of the polylogarithm

    Li_j(e^{i theta}) = (i theta)^(j-1)/(j-1)! [1 + 1/2 + ... + 1/(j-1) - ln(-i theta)]
                        + sum_{k != j-1} zeta(j-k) (i theta)^k / k!,     0 < theta < 2 pi,

(DLMF 25.12.12), which isolates what is singular at theta = 0: the pole or Dirac pulse of a_0, the
logarithm or step of a_1, and weaker theta^(j-1) ln(theta) terms.  What remains is tabulated with
its first two derivatives, by fast Fourier transform, and interpolated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import comb, factorial, log, pi

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

KEPT = 1024  # so many angles at a time share their powers
NEAR = 16  # steps of a table that are made first; of coarse tables contacts see no more
MOST_WAVES = 4096  # steps around the circle, of which waves near 0 are kept: half a megabyte
POWERS = 60  # (1/2)^60 < 1e-18: the power series below, at the angle pi
BEYOND = 1 / 16  # of pi: so much farther tables go, for who asks a little beyond; 0.53^60 < 1e-16


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
    return Polylogarithm(0.0, -lead, np.insert(power, j - 1, lead * (harmonic + 0.5j * pi)))


@lru_cache(maxsize=16)
def _power_series(odd: bool, orders: int) -> Array:
    """Return the power series of theta in the polylogarithms 0, 1, ..., (orders, POWERS)."""
    powers = np.array([polylogarithm(j).power for j in range(orders)])
    return powers.imag if odd else powers.real


@lru_cache(maxsize=8)
def _powers_of_angles(size: int) -> Array:
    """Return the powers of theta = 2 pi k/size and their two derivatives.

    From k = 0 on, KEPT of them or as many as tables have, (3, POWERS, k).
    """
    theta = 2 * pi / size * np.arange(min(KEPT, int(size / 2 * (1 + BEYOND)) + 1))
    k, found = np.arange(1.0, POWERS)[:, None], np.zeros((3, POWERS, theta.size))
    powers, slopes, bends = found
    powers[0], powers[1:] = 1.0, theta
    np.cumprod(powers, axis=0, out=powers)
    slopes[1:] = k * powers[:-1]
    bends[1:] = k * slopes[:-1]
    return found


def _moved(series: Array, to: float) -> Array:
    """Return power series of theta as such of theta - to, (..., POWERS)."""
    binomials, less = _binomials()
    return series @ (binomials * (to ** np.arange(POWERS))[less])


@lru_cache(maxsize=8)
def _waves(size: int, terms: int) -> Array:
    """Return 2 cos and -2 sin of n theta at the first angles 2 pi k/size, (2 terms, NEAR + 1)."""
    angles = 2 * pi / size * (np.outer(np.arange(1, terms + 1), np.arange(NEAR + 1)) % size)
    return np.concatenate([2 * np.cos(angles), -2 * np.sin(angles)])


@lru_cache(maxsize=1)
def _binomials() -> tuple[Array, Array]:
    """Return k over i, and k - i where that is not 0, (k, i)."""
    k = np.arange(POWERS)
    found = np.array([[comb(n, i) for i in k.tolist()] for n in k.tolist()], dtype=float)
    return found, np.maximum(k[:, None] - k, 0)


@lru_cache(maxsize=128)
def _zeta(s: int) -> float:
    """Return Riemann's zeta(s) of an integer s != 1, by its sum and reflection."""
    if s == 0:
        return -0.5
    if s < 0:
        if s % 2 == 0:
            return 0.0
        m = 1 - s
        return 2 * (2 * pi) ** -m * (-1.0) ** (m // 2) * factorial(m - 1) * _zeta(m)
    # Euler-Maclaurin after N terms; the first term left out is below 1e-17 for s >= 2
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
    """scale * [mean + sum_n (a_0 + a_1/n + ... + rest_n) trig(n t/radius)].

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
    rest : ndarray, shape (N,)
        c_n less the powers, n = 1 ... N; taken as zero beyond.
    power : ndarray, shape (POWERS,), optional
        Of theta, even ones of cosines or odd ones of sines: a smooth part added as it is, which
        ``twice`` leaves out.
    """

    odd: bool
    radius: float
    scale: float
    mean: float
    tail: Array
    rest: Array
    power: Array | None = None

    def kernel(self) -> Kernel:
        """Return the sum taken apart by singularity; the smooth part is tabulated when first used.

        The smooth part holds for |t| <= pi R.  It is bounded, and smooth on either side of t = 0;
        at t = 0 it may have a kink (even sums) or behave as t ln|t| (odd sums).
        """
        scale, R = self.scale, self.radius
        a = self.tail
        if self.odd:
            inverse, sign = scale * a[0] * R, scale * a[1] * pi / 2
            return Kernel(inverse=inverse, sign=sign, smooth=self, twice=self.twice)
        delta, log_ = scale * a[0] * pi * R, -scale * a[1]
        return Kernel(delta=delta, log=log_, smooth=self, twice=self.twice)

    def twice(self, t: Array) -> Array:
        """Return a second integral of the whole sum at the arc lengths t [m], of any size."""
        around, whole = 2 * pi * self.radius, self._integrated
        turned = around * np.rint(t / around)
        found = whole(t - turned) + self.scale * self.mean / 2 * t * t
        if self.odd and whole.power is not None:
            found += whole.power[1] / self.radius * turned  # the line that it lacks goes on
        return found

    @cached_property
    def _integrated(self) -> HarmonicSum:
        n = np.arange(1, self.rest.size + 1)
        tail = np.concatenate([[0.0, 0.0], self.tail])
        scale, rest = -self.scale * self.radius**2, self.rest / (n * n)
        whole = HarmonicSum(self.odd, self.radius, scale, 0.0, tail, rest)
        # constant and line are free; kept, they would drown the differences of short cells
        less = np.zeros(POWERS)
        first = scale * float(rest @ n if self.odd else rest.sum())
        less[int(self.odd)] = -float(whole.series[int(self.odd)]) - first
        return replace(whole, power=less)

    def __call__(self, t: Array) -> Array:
        """Return the smooth part at the arc lengths t [m], any shape, |t| <= pi R."""
        return self._alone(t)[0]

    @cached_property
    def _alone(self) -> HarmonicSums:
        return HarmonicSums((self,))

    def logs(self) -> Array:
        """Return the coefficients of theta^(j-1) ln(theta); j = 2, 4, ... if odd, else 3, 5, ..."""
        orders = range(2 if self.odd else 3, self.tail.size, 2)
        weights = np.array([polylogarithm(j).log for j in orders])
        return np.array(self.scale * self.tail[orders.start :: 2] * self._part(weights))

    def _part(self, z: Array) -> Array:
        return z.imag if self.odd else z.real

    @property
    def spectrum(self) -> Array:
        """Coefficients of exp(i n theta) of the rest, n = 1 ... N."""
        return (-0.5j if self.odd else 0.5) * self.scale * self.rest

    @property
    def series(self) -> Array:
        """Coefficients of the regular parts of the powers n^-j, by powers of theta."""
        c = self.tail @ _power_series(self.odd, self.tail.size)
        if self.odd:
            c[0] = 0.0  # the step of a_1, which the kernel carries as its sign
        else:
            c[0] += self.mean + self.tail[1] * log(self.radius)  # ln(theta) = ln(t) - ln(R)
        c *= self.scale
        return np.asarray(c if self.power is None else c + self.power)


@dataclass(frozen=True, eq=False)
class HarmonicSums:
    """The smooth parts of several sums on one circle, with equally many terms, at once.

    Where they are needed together, this costs hardly more than one of them.
    """

    sums: tuple[HarmonicSum, ...]
    some_of: tuple[HarmonicSums, slice] | None = None  # whose table has theirs

    def some(self, which: slice) -> HarmonicSums:
        """Return some of them, by the table of all."""
        return HarmonicSums(self.sums[which], (self, which))

    def kernels(self) -> tuple[Kernel, ...]:
        """Return each of them taken apart by singularity, all by one table when first used."""
        return tuple(
            replace(one.kernel(), smooth=self.some(slice(k, k + 1)).first)
            for k, one in enumerate(self.sums)
        )

    def first(self, t: Array) -> Array:
        """Return the first of them, shape t.shape."""
        return np.asarray(self(t)[0])

    @property
    def reach(self) -> float:
        """Largest |t| that they hold for [m]: the expansions do for all angles below 2 pi."""
        return (1 + BEYOND) * pi * self.sums[0].radius

    def __call__(self, t: Array) -> Array:
        """Return them at the arc lengths t [m], shape (sums, *t.shape), |t| <= reach."""
        t = np.asarray(t, dtype=float)
        flat = t.ravel()
        theta = np.abs(flat) * (1 / self.sums[0].radius)
        x = theta * (self._size / (2 * pi))
        near = x.max(initial=0.0) < NEAR and self._size <= MOST_WAVES
        coefficients = self._near if near else self._whole
        i = x.astype(np.intp)
        np.minimum(i, coefficients.shape[-1] - 1, out=i)
        x -= i
        y = coefficients[5].take(i, axis=-1, mode="clip")
        here = np.empty_like(y)
        for c in coefficients[4::-1]:
            y *= x
            y += c.take(i, axis=-1, mode="clip", out=here)
        y += self._weak(theta)
        sign = np.sign(flat)
        for row, odd in zip(y, self._odd, strict=True):
            if odd:
                row *= sign
        return y.reshape(-1, *t.shape)

    def _weak(self, theta: Array) -> Array:
        """Return the terms theta^(j-1) ln(theta), (sums, theta)."""
        square = theta * theta
        powers = np.empty((self._logs.shape[1], theta.size))
        powers[0] = square
        for k in range(1, len(powers)):
            np.multiply(powers[k - 1], square, out=powers[k])
        least = np.maximum(theta, 1e-150)
        logarithm = np.log(least)
        weak: Array = self._logs @ powers
        over_angle = logarithm / least
        for row, odd in zip(weak, self._odd, strict=True):
            row *= over_angle if odd else logarithm
        return weak

    @cached_property
    def _odd(self) -> tuple[bool, ...]:
        return tuple(sum_.odd for sum_ in self.sums)

    @cached_property
    def _size(self) -> int:
        """Steps around the circle: 4 a shortest wave, where coefficients have died out already."""
        return max(256, 1 << (4 * self.sums[0].rest.size - 1).bit_length())

    @cached_property
    def _near(self) -> Array:
        """Quintics on the first steps, all that a contact sees mostly, (6, sums, NEAR)."""
        if self.some_of is not None:
            return np.ascontiguousarray(self.some_of[0]._near[:, self.some_of[1]])
        return self._quintics(NEAR + 1)

    @cached_property
    def _whole(self) -> Array:
        """Quintics on equal steps up to the reach, (6, sums, steps)."""
        if self.some_of is not None:
            return np.ascontiguousarray(self.some_of[0]._whole[:, self.some_of[1]])
        return self._quintics(int(self._size / 2 * (1 + BEYOND)) + 1)

    def _quintics(self, angles: int) -> Array:
        step = 2 * pi / self._size
        values = self._rest_on_circle(angles) + self._powers(angles)
        values *= np.array([1.0, step, step * step])[:, None, None]
        return np.ascontiguousarray(np.moveaxis(quintics(values), -1, 0))

    def _rest_on_circle(self, angles: int) -> Array:
        """Sum the rests and their two derivatives at the first of the angles, (3, sums, angles)."""
        once = np.array([sum_.spectrum for sum_ in self.sums])
        n = 1j * np.arange(1, once.shape[-1] + 1)
        if angles == NEAR + 1:
            waves = np.array([once, once * n, once * (n * n)])
            parts = np.concatenate([waves.real, waves.imag], axis=-1)
            return np.asarray(parts @ _waves(self._size, n.size))
        spectrum = np.zeros((3, len(once), self._size // 2 + 1), dtype=complex)
        inner = spectrum[..., 1 : n.size + 1]
        inner[0] = once * self._size
        np.multiply(inner[0], n, out=inner[1])
        np.multiply(inner[1], n, out=inner[2])
        return np.fft.irfft(spectrum, self._size)[..., :angles]

    def _powers(self, angles: int) -> Array:
        """Sum the regular parts of the powers n^-j and their two derivatives where they are kept.

        At the first of the angles, (3, sums, angles).
        """
        c = np.array([sum_.series for sum_ in self.sums])
        near = _powers_of_angles(self._size)
        parts = [c @ near[..., :angles]]
        for first in range(KEPT, angles, KEPT):
            parts.append(_moved(c, 2 * pi / self._size * first) @ near[..., : angles - first])
        return np.concatenate(parts, axis=-1)

    @cached_property
    def _logs(self) -> Array:
        """Coefficients of the weak terms, (sums, orders); at least one, for the sake of shape."""
        found = [sum_.logs() for sum_ in self.sums]
        logs = np.zeros((len(found), max(f.size for f in (*found, np.zeros(1)))))
        for row, of_one in zip(logs, found, strict=True):
            row[: of_one.size] = of_one
        return logs


def quintics(values: Array) -> Array:
    """Return coefficients (..., K, 6) of the quintics with given f, f', f'' at unit steps.

    Values are (3, ..., K+1).
    """
    f, d, s = values[..., :-1]
    F, D, S = values[..., 1:]
    half, Half = s / 2, S / 2
    rise = F - f - d - half
    turn = D - d - s
    bend = Half - half
    return np.stack(
        (
            f,
            d,
            half,
            10 * rise - 4 * turn + bend,
            -15 * rise + 7 * turn - 2 * bend,
            6 * rise - 3 * turn + bend,
        ),
        axis=-1,
    )
