"""Fourier sums: closed parts against mpmath's polylogarithm, tables against the sums themselves."""

from __future__ import annotations

from math import pi

import mpmath as mp
import numpy as np
import pytest
from elastic_cases import whole

from woundon.elasticity.fourier import HarmonicSum, HarmonicSums, polylogarithm

R = 0.4


@pytest.mark.parametrize("j", range(8))
def test_polylogarithm(j: int) -> None:
    """The expansion equals mpmath's Li_j on the unit circle, up to the half turn."""
    P = polylogarithm(j)
    for theta in (1e-3, 0.3, 2.0, pi):
        found = P.pole / theta + P.log * theta ** (j - 1) * np.log(theta)
        found += P.power @ theta ** np.arange(P.power.size)
        expected = complex(mp.polylog(j, mp.expj(theta)))
        # 60 powers of (1/2), and rounding of the largest term
        assert found == pytest.approx(expected, abs=1e-14 * max(1, abs(expected)))


@pytest.mark.parametrize("odd", [False, True], ids=["cos", "sin"])
def test_powers_and_rest_add_up(odd: bool) -> None:
    """A sum of powers n^-j and a dying rest equals its polylogarithms and plain harmonics."""
    tail = np.array([0.7, -1.3, 2.0, 0.4, -0.9, 1.1, 0.3])
    n = np.arange(1, 61)
    rest = 5 * np.exp(-0.5 * n)
    kernel = HarmonicSum(odd, R, 3.0, 0.0 if odd else 0.25, tail, rest).kernel()
    for theta in (0.01, 0.5, 2.2, pi):
        closed = complex(mp.fsum(a * mp.polylog(j, mp.expj(theta)) for j, a in enumerate(tail)))
        both = closed + rest @ np.exp(1j * n * theta)
        expected = 3.0 * (both.imag if odd else 0.25 + both.real)
        for sign in (1, -1):
            found = whole(kernel, np.array([sign * theta * R]))
            # the quintics' error at a step of 2 pi/256: (0.0245/0.5)^6/64 of 5/0.5
            assert found == pytest.approx(expected * (sign if odd else 1), abs=1e-8)


@pytest.mark.parametrize("odd", [False, True], ids=["cos", "sin"])
def test_table_is_of_sixth_order(odd: bool) -> None:
    """Between the knots the quintics err by step^6: 64 times less when the table doubles."""
    n = np.arange(1, 401)
    waves = np.exp(-0.12 * n)
    theta = np.linspace(0.0, 0.6, 3001)
    trig = np.sin if odd else np.cos
    exact = trig(np.outer(theta, n)) @ waves
    errors = []
    for terms in (200, 400):  # tables of 1024 and 2048 points
        sums = HarmonicSum(odd, R, 1.0, 0.0, np.zeros(2), waves[:terms])
        errors.append(np.abs(sums(theta * R) - exact).max())
    assert 50 < errors[0] / errors[1] < 75


@pytest.mark.parametrize("odd", [False, True], ids=["cos", "sin"])
@pytest.mark.parametrize(
    ("h", "middles"),
    [
        (1e-6, [5e-6, -3e-5, 4e-4]),
        (0.03, [0.15, -0.5, pi - 0.01, pi + 0.2, -2 * pi + 0.15, 3 * pi + 0.1]),
        (0.4, [0.5, -2.0, pi - 0.1, pi + 0.2, -3 * pi + 0.1]),
    ],
)
def test_hats_by_second_integrals(odd: bool, h: float, middles: list[float]) -> None:
    """Hats of half width h R about any angle: short ones are not drowned, nor turns forgotten."""
    tail, rest = (
        np.array([0.0, -1.3, 2.0, 0.4, -0.9, 1.1, 0.3]),
        5 * np.exp(-0.5 * np.arange(1, 61)),
    )
    series = HarmonicSum(odd, R, 3.0, 0.0 if odd else 0.25, tail, rest)
    kernel = series.kernel()
    s, weights = np.polynomial.legendre.leggauss(24)
    for middle in middles:
        found = np.diff(series.second_integral(R * (middle + h * np.array([-1.0, 0.0, 1.0]))), 2)[
            0
        ] / (h * R)
        expected = 0.0
        for side in (-1, 1):
            x = middle + side * h * (s + 1) / 2
            around = x - 2 * pi * np.rint(x / (2 * pi))
            expected += h * R / 2 * weights @ ((1 - s) / 2 * whole(kernel, R * around))
        # the quintics' error, as above; rounding of t^2, of which short hats are the differences
        rounding = 1e-15 * (middle / h) ** 2
        assert found == pytest.approx(expected, rel=1e-7 + rounding, abs=1e-8 * h * R)


def test_regular_at_zero() -> None:
    """The smooth part of an odd sum starts as t ln t; nothing stronger is left in it."""
    f = HarmonicSum(True, R, 1.0, 0.0, np.array([1.0, 1.0, 1.0]), np.zeros(1))
    t = R * np.logspace(-12, -3, 10)
    bounded = f(t) / (t / R * np.log(t / R))
    assert np.all(np.abs(bounded) < 2)


def test_several_sums_at_once_are_each_of_them() -> None:
    rng = np.random.default_rng(2)
    rest = rng.normal(size=(4, 40)) / np.arange(1, 41) ** 9
    tails = [rng.normal(size=size) for size in (7, 7, 4, 2)]  # with fewer powers, and with one
    odd = [True, False, False, True]
    sums = tuple(
        HarmonicSum(o, R, 1.5, 0.0 if o else 0.3, tail, r)
        for o, tail, r in zip(odd, tails, rest, strict=True)
    )
    t = rng.uniform(-3.1 * R, 3.1 * R, (5, 6))
    t[0, 0] = 0.0
    together = HarmonicSums(sums)(t)
    assert together.shape == (4, 5, 6)
    for one, values in zip(sums, together, strict=True):
        np.testing.assert_allclose(values, one(t), rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("odd", [False, True])
def test_blocks_of_a_table_continue_the_power_series(odd: bool) -> None:
    """Many angles: each block re-expands the series in few powers; the reference sums all of them.

    Sums of sixty terms of order one in double precision: 1e-13.
    """
    tail, waves = np.array([0.0, 1.0, 0.7, -0.4, 0.2, 0.1]), np.zeros(1 << 12)
    sums = HarmonicSums((HarmonicSum(odd, R, 1.0, 0.0, tail, waves),))
    k = np.array([0, 1000, 1024, 1025, 5000, 8191])  # in the first and in further blocks, up to pi
    found = sums._regular_parts(int(k[-1]) + 1)[0, 0, k]
    theta = 2 * pi / sums._size * k
    exact = np.polynomial.polynomial.polyval(theta, sums.sums[0].series)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-13)
