"""Integrals of influence functions against hats: quadrature, closed forms, multiple precision."""

from __future__ import annotations

from itertools import pairwise
from math import log, pi
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.integrate import quad

from woundon.elasticity.hat_integrals import (
    by_second_integral,
    gauss_rule_in_cells,
    singular_integrals,
)
from woundon.elasticity.mesh import Wrap, nip_mesh

Array = np.ndarray
# uneven on purpose; points next to nodes, in the middle, none on a node
NODES = np.array([-1.0, -0.8, -0.3, 0.1, 0.6, 1.0])
POINTS = np.array([-0.999, -0.81, -0.55, -0.29, 0.0, 0.35, 0.601, 0.97, 1.4])
INVERSE, DIRAC, LOG, SIGN = range(4)


def hat(m: int, s: float) -> float:
    return float(np.interp(s, NODES, np.eye(NODES.size)[m]))


def by_quadrature(kernel: Any, points: Array = POINTS) -> Array:
    """Integrate kernel(y - s) over all hats; it may have a logarithm or a jump at 0."""

    def one(m: int, y: float) -> float:
        inside = [y] if NODES[0] < y < NODES[-1] else []
        breaks = sorted({*NODES.tolist(), *inside})
        return sum(
            quad(lambda s: hat(m, s) * kernel(y - s), a, b, limit=200, epsabs=1e-13)[0]
            for a, b in pairwise(breaks)
        )

    return np.array([[one(m, y) for m in range(NODES.size)] for y in points])


def test_principal_values() -> None:
    """QUADPACK's rule for Cauchy's principal value."""

    def one(m: int, y: float) -> float:
        total = 0.0
        for a, b in pairwise(NODES):
            if a < y < b:
                total += quad(
                    lambda s: -hat(m, s), a, b, weight="cauchy", wvar=y, epsabs=1e-12, limit=200
                )[0]
            else:
                total += quad(lambda s: hat(m, s) / (y - s), a, b, epsabs=1e-12, limit=200)[0]
        return total

    known = np.array([[one(m, y) for m in range(NODES.size)] for y in POINTS])
    found = singular_integrals(POINTS, NODES)[INVERSE]
    # 1e-9: the error of the quadrature next to the ends of a cell
    np.testing.assert_allclose(found, known, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("part", "kernel"), [(LOG, lambda t: log(abs(t)) if t else 0.0), (SIGN, np.sign)],
    ids=["logarithm", "sign"],
)  # fmt: skip
@pytest.mark.parametrize("points", [POINTS, NODES], ids=["between nodes", "on nodes"])
def test_logarithms_and_signs(part: int, kernel: Any, points: Array) -> None:
    found = singular_integrals(points, NODES)[part]
    np.testing.assert_allclose(found, by_quadrature(kernel, points), rtol=0, atol=1e-10)


def test_dirac_interpolates() -> None:
    values = np.random.default_rng(1).normal(size=NODES.size)
    inside = POINTS[:-1]
    found = singular_integrals(inside, NODES)[DIRAC] @ values
    np.testing.assert_allclose(found, np.interp(inside, NODES, values), rtol=0, atol=1e-15)
    assert not singular_integrals(POINTS[-1:], NODES)[DIRAC].any()


def test_nothing_cancels_far_from_a_cell() -> None:
    """On 2000 cells most distances are large; thirty digits show the error."""
    mesh = nip_mesh(2001, Wrap(), Wrap())
    found = singular_integrals(mesh.points, mesh.nodes)
    for k in (0, 700, -1):
        y = mpmath.mpf(float(mesh.points[k]))
        for m in (10, 701, 1990):
            left, top, right = (mpmath.mpf(float(v)) for v in mesh.nodes[m - 1 : m + 2])
            if left <= y <= right:
                continue
            with mpmath.workdps(30):

                def over(s: Any, f: Any, l: Any = left, t: Any = top, r: Any = right) -> Any:  # noqa: E741
                    return (s - l) / (t - l) * f(s) if s < t else (r - s) / (r - t) * f(s)

                for part, f in ((INVERSE, lambda s, y=y: 1 / (y - s)),
                                (LOG, lambda s, y=y: mpmath.log(abs(y - s)))):  # fmt: skip
                    known = mpmath.quad(lambda s, f=f, over=over: over(s, f), [left, top, right])
                    # a logarithm near zero crosses zero: relative to the weight of the hat
                    size = max(abs(float(known)), float(right - left) / 2)
                    assert abs(float(found[part, k, m]) - float(known)) < 1e-10 * size


@pytest.mark.parametrize("size", [9, 65, 1025])
def test_a_semi_ellipse_has_a_straight_slope(size: int) -> None:
    """PV int sqrt(1-s^2)/(y-s) ds = pi y; int sqrt(1-s^2) ln|y-s| ds = pi/2 (y^2 - 1/2 - ln 2)."""
    mesh = nip_mesh(size, Wrap(), Wrap())
    p, y = np.sqrt(1 - mesh.nodes**2), mesh.points
    found = singular_integrals(y, mesh.nodes)
    # measured 3.65/n at the edge, where the slope of the root is infinite, and 1.9/n^2; somewhat
    # more on the coarsest mesh
    np.testing.assert_allclose(found[INVERSE] @ p, pi * y, atol=4.5 / size)
    np.testing.assert_allclose(found[LOG] @ p, pi / 2 * (y**2 - 0.5 - log(2)), atol=3 / size**2)
    assert mesh.weights @ p == pytest.approx(pi / 2, abs=3.5 / size**2)


def test_a_semi_ellipse_converges_with_the_second_order_inside() -> None:
    def error(size: int) -> float:
        mesh = nip_mesh(size, Wrap(), Wrap())
        p = np.sqrt(1 - mesh.nodes**2)
        wrong = np.abs(singular_integrals(mesh.points, mesh.nodes)[INVERSE] @ p - pi * mesh.points)
        return float(wrong[np.abs(mesh.points) < 0.9].max())

    orders = [log(error(n) / error(2 * n - 1)) / log(2) for n in (33, 65, 129, 257)]
    assert min(orders) > 2, orders


def test_second_differences_of_a_second_integral_are_exact() -> None:
    """1/(t^2 + d^2), however small d is against a cell: closed form and quadrature."""
    for d in (1e-3, 0.5):

        def first(t: Array, d: float = d) -> Array:
            return np.arctan(t / d) / d

        def second(t: Array, d: float = d) -> Array:
            return t * np.arctan(t / d) / d - np.log(t**2 + d**2) / 2

        found = by_second_integral(second, first, POINTS, NODES)
        known = np.empty_like(found)
        for k, y in enumerate(POINTS):
            marks = sorted({*NODES.tolist(),
                            *(p for p in (y - 3 * d, y, y + 3 * d) if -1 < p < 1)})  # fmt: skip
            for m in range(NODES.size):
                known[k, m] = sum(
                    quad(lambda s, m=m, y=y, d=d: hat(m, s) / ((y - s) ** 2 + d**2), *ends,
                         epsabs=0, epsrel=1e-12, limit=200)[0]
                    for ends in pairwise(marks)
                )  # fmt: skip
        np.testing.assert_allclose(found, known, rtol=1e-9, atol=1e-10 * known.max())
        inner = by_second_integral(second, None, POINTS, NODES)
        np.testing.assert_allclose(inner[:, 1:-1], found[:, 1:-1], rtol=1e-12)
        assert not inner[:, [0, -1]].any()


@pytest.mark.parametrize("length", [1.0, 0.05])
def test_gauss_points_integrate_smooth_functions(length: float) -> None:
    """A function with poles at +-i length, in units of metres."""
    a = 0.7
    rule = gauss_rule_in_cells(NODES, a, length)
    found = 1 / (1 + ((0.3 * a - a * rule.points) / length) ** 2) @ rule.moments
    known = a * by_quadrature(lambda t: 1 / (1 + (a * t / length) ** 2), np.array([0.3]))[0]
    # three points a length resolve it to 1e-4
    np.testing.assert_allclose(found, known, rtol=0, atol=2e-4 * known.max())
    assert rule.moments.sum() == pytest.approx(2 * a, rel=1e-12)
