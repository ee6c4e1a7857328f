"""Grids: the exact kernel integrals against quadrature, closed forms and multiple precision."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import asinh, log, pi
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.integrate import quad

from woundon.contact.grid import Grid, cosine_grid, segmented_grid, uniform_grid, zone_borders
from woundon.contact.meshes import interpolation_rank
from woundon.elasticity.kernels import Kernel

Array = np.ndarray

# uneven on purpose; points near nodes, in the middle, at both ends, none on an interior node
UNEVEN = Grid(
    np.array([-1.0, -0.8, -0.3, 0.1, 0.6, 1.0]),
    np.array([-1.0, -0.999, -0.81, -0.55, -0.29, 0.0, 0.35, 0.601, 0.97, 1.0]),
)
# the other integrands are finite at the nodes too
WITH_NODES = Grid(UNEVEN.nodes, np.append(UNEVEN.nodes, [0.2, 1.0]))


def hat(grid: Grid, m: int, s: float) -> float:
    return float(np.interp(s, grid.nodes[m : m + 3], [0.0, 1.0, 0.0], left=0.0, right=0.0))


def breaks(grid: Grid, m: int, y: float) -> list[float]:
    """Where the hat or the kernel has a kink: quadrature goes piece by piece."""
    x = grid.nodes[m : m + 3]
    return sorted({*x, *([y] if x[0] < y < x[2] else [])})


def by_quadrature(grid: Grid, kernel: Any) -> Array:
    """Integrate kernel(y - s) over the hats; it may have a logarithm or a jump at 0."""

    def one(m: int, y: float) -> float:
        return sum(
            quad(lambda s: hat(grid, m, s) * kernel(y - s), a, b, limit=200, epsabs=1e-13)[0]
            for a, b in pairwise(breaks(grid, m, y))
        )  # fmt: skip

    return np.array([[one(m, y) for m in range(grid.unknowns)] for y in grid.points])


def principal_values(grid: Grid) -> Array:
    """Integrate 1/(y - s) over the hats: QUADPACK's rule for Cauchy's principal value."""

    def one(m: int, y: float) -> float:
        x = grid.nodes[m : m + 3]
        total = 0.0
        for a, b in pairwise(x):
            inside = {"weight": "cauchy", "wvar": y} if a < y < b else {}
            f = (lambda s: -hat(grid, m, s)) if inside else (
                lambda s: hat(grid, m, s) / (y - s) if s != y else -1 / (x[1] - x[0])
            )  # fmt: skip
            total += quad(f, a, b, epsabs=1e-12, limit=200, **inside)[0]
        return total

    return np.array([[one(m, y) for m in range(grid.unknowns)] for y in grid.points])


# ---- the four singular parts --------------------------------------------------------------------


def test_principal_values() -> None:
    # 1e-9: quadrature's own error near the ends of a cell
    np.testing.assert_allclose(UNEVEN.inverse, principal_values(UNEVEN), rtol=0, atol=1e-9)


@pytest.mark.parametrize("grid", [UNEVEN, WITH_NODES], ids=["between", "on nodes"])
def test_logarithms(grid: Grid) -> None:
    known = by_quadrature(grid, lambda t: log(abs(t)) if t else 0.0)
    np.testing.assert_allclose(grid.log, known, rtol=0, atol=1e-10)


@pytest.mark.parametrize("grid", [UNEVEN, WITH_NODES], ids=["between", "on nodes"])
def test_signs(grid: Grid) -> None:
    np.testing.assert_allclose(grid.sign, by_quadrature(grid, np.sign), rtol=0, atol=1e-13)


@pytest.mark.parametrize("grid", [UNEVEN, WITH_NODES], ids=["between", "on nodes"])
def test_values_interpolate(grid: Grid) -> None:
    nodal = np.random.default_rng(1).normal(size=grid.unknowns)
    known = np.interp(grid.points, grid.nodes, np.concatenate([[0.0], nodal, [0.0]]))
    np.testing.assert_allclose(grid.value @ nodal, known, rtol=0, atol=1e-15)


def test_weights_are_the_hats_areas() -> None:
    areas = [quad(lambda s, m=m: hat(UNEVEN, m, s), -1, 1, points=UNEVEN.nodes)[0]
             for m in range(UNEVEN.unknowns)]  # fmt: skip
    np.testing.assert_allclose(UNEVEN.weights, areas, rtol=1e-12)


def test_far_from_the_cell_nothing_cancels() -> None:
    # on 2000 cells most distances are beyond the switch to the series; 30 digits tell its error
    grid = cosine_grid(2001)
    rows, columns = [0, 700, -1], [0, 10, 701, 1998]
    for k in rows:
        y = mpmath.mpf(float(grid.points[k]))
        for m in columns:
            left, top, right = (mpmath.mpf(float(v)) for v in grid.nodes[m : m + 3])
            with mpmath.workdps(30):

                def rise(s: Any, a: Any = left, b: Any = top, y: Any = y) -> Any:
                    return (s - a) / (b - a) / (y - s)

                def fall(s: Any, a: Any = right, b: Any = top, y: Any = y) -> Any:
                    return (s - a) / (b - a) / (y - s)

                if left < y < right or y in (left, right):
                    continue
                known = mpmath.quad(rise, [left, top]) + mpmath.quad(fall, [top, right])
            assert float(grid.inverse[k, m]) == pytest.approx(float(known), rel=1e-11)


@pytest.mark.parametrize("nodes", [9, 65, 1025])
def test_a_semi_ellipse_has_a_straight_slope(nodes: int) -> None:
    # PV int sqrt(1-s^2)/(y-s) ds = pi y; int sqrt(1-s^2) ln|y-s| ds = pi/2 (y^2 - 1/2 - ln 2)
    grid = cosine_grid(nodes)
    p, y = np.sqrt(1 - grid.nodes[1:-1] ** 2), grid.points
    # measured 3.65/n at the edge, where the root's own slope is infinite, 1.9 and 2.7/n^2 for the
    # other two; at the smallest grid somewhat more
    np.testing.assert_allclose(grid.inverse @ p, pi * y, atol=4.5 / nodes)
    np.testing.assert_allclose(grid.log @ p, pi / 2 * (y**2 - 0.5 - log(2)), atol=3 / nodes**2)
    assert grid.weights @ p == pytest.approx(pi / 2, abs=3.5 / nodes**2)


def test_a_semi_ellipse_is_met_at_second_order_inside() -> None:
    def error(nodes: int) -> float:
        grid = cosine_grid(nodes)
        p = np.sqrt(1 - grid.nodes[1:-1] ** 2)
        wrong = np.abs(grid.inverse @ p - pi * grid.points)
        return float(wrong[np.abs(grid.points) < 0.9].max())

    # away from the edge; measured 2.6 to 3.0: what comes in from the edge still dies out
    orders = [log(error(n) / error(2 * n - 1)) / log(2) for n in (33, 65, 129, 257)]
    assert all(order > 2 for order in orders), orders


# ---- the smooth part, and all together ------------------------------------------------------


@dataclass(frozen=True)
class Bell:
    """A kernel that varies on ``length``, as that of a layer of that thickness does."""

    length: float
    lag = None
    inverse = delta = log = sign = 0.0

    def smooth(self, t: Array) -> Array:
        return t / (t * t + self.length**2)


def test_a_smooth_kernel_is_integrated_to_rounding() -> None:
    def smooth(t: Array) -> Array:
        return np.exp(-t) * np.cos(3 * t)

    a = 0.7
    made = UNEVEN.integrate(Kernel(smooth=smooth), a)
    known = a * by_quadrature(UNEVEN, lambda t: float(smooth(a * t)))
    np.testing.assert_allclose(made, known, rtol=0, atol=1e-12)
    rows = UNEVEN.integrate(Kernel(smooth=smooth), a, slice(-1, None))
    np.testing.assert_allclose(rows, made[-1:], rtol=0, atol=1e-15)  # rounding of another product


@pytest.mark.parametrize("slenderness", [0.3, 1.0, 5.0, 20.0])
def test_the_rank_resolves_kernels_that_vary_fast(slenderness: float) -> None:
    a, length = 2e-3, 2e-3 / slenderness
    rank = interpolation_rank(length, a)
    assert rank >= 24
    grid = cosine_grid(257)
    p = np.sqrt(1 - grid.nodes[1:-1] ** 2)
    made = grid.integrate(Bell(length), a, rank=rank) @ p
    # int sqrt(1-s^2) (y-s)/((y-s)^2 + l^2) ds = pi Re[z - sqrt(z-1) sqrt(z+1)], z = y + il
    z = grid.points + 1j * length / a
    known = pi * (z - np.sqrt(z - 1) * np.sqrt(z + 1)).real
    # the hats' own error at 257 nodes, and the 1e-5 that the rank is chosen for
    np.testing.assert_allclose(made, known, atol=1e-4 + 2e-5 * pi)


def test_rank_grows_with_slenderness() -> None:
    ranks = [interpolation_rank(length, 1.0) for length in (np.inf, 10.0, 1.0, 0.1, 0.01, 1e-9)]
    assert ranks[0] == ranks[1] == ranks[2] == 24
    assert ranks == sorted(ranks)
    assert ranks[3] == round(20 / asinh(0.1))
    assert ranks[-1] > 1e9  # the grid then takes the kernel's second integral


def test_a_kernel_is_integrated_as_its_second_integral_tells() -> None:
    """However short it varies: 1/(t^2 + d^2), d a thousandth of a cell, closed form."""
    d, a = 1e-5, 4e-3
    kernel = Kernel(
        smooth=lambda t: 1 / (t**2 + d**2),
        twice=lambda t: t * np.arctan(t / d) / d - np.log(t**2 + d**2) / 2,
    )
    made = UNEVEN.integrate(kernel, a, rank=10_000)
    m, k = 1, 2  # one hat from one point
    x0, x1, x2, y = (*(a * UNEVEN.nodes[m : m + 3]), a * UNEVEN.points[k])

    def hat(s: float) -> float:
        return float(np.interp(s, [x0, x1, x2], [0.0, 1.0, 0.0]) / ((y - s) ** 2 + d**2))

    marks = sorted({x0, x1, x2, *(p for p in (y - 3 * d, y, y + 3 * d) if x0 < p < x2)})
    pieces = pairwise(marks)
    expected = sum(quad(hat, *ends, epsabs=0, epsrel=1e-12, limit=200)[0] for ends in pieces)
    assert made[k, m] == pytest.approx(expected, rel=1e-10)


def test_all_parts_together_in_metres() -> None:
    # with a half width that makes ln(a) matter
    a = 4e-3
    kernel = Kernel(inverse=2.0, delta=-0.3, log=0.7, sign=-1.1, smooth=lambda t: 50.0 * t + 0.2)
    in_metres = Grid(a * UNEVEN.nodes, a * UNEVEN.points)

    def regular(t: float) -> float:
        return 0.7 * (log(abs(t)) if t else 0.0) - 1.1 * np.sign(t) + 50.0 * t + 0.2

    known = by_quadrature(in_metres, regular)
    known += 2.0 * principal_values(UNEVEN) - 0.3 * UNEVEN.value
    np.testing.assert_allclose(UNEVEN.integrate(kernel, a), known, rtol=0, atol=5e-9)
    assert not UNEVEN.integrate(Kernel(), a).any()


@pytest.mark.parametrize("smooth", [True, False])
def test_several_kernels_together_are_each_of_them(smooth: bool) -> None:
    a, grid = 4e-3, cosine_grid(33)
    waves = (
        [lambda t: np.cos(40.0 * t), np.sin, lambda t: 3.0 * t, np.cosh] if smooth else [None] * 4
    )
    kernels = [
        Kernel(inverse=2.0, sign=-1.1, smooth=waves[0]),
        Kernel(delta=-0.3, log=0.7, smooth=waves[1]),
        Kernel(log=-0.2, smooth=waves[2]),
        Kernel(smooth=waves[3]),
    ]
    at_once = (lambda t: np.array([wave(t) for wave in waves])) if smooth else None
    for rank in (12, 24):
        together = grid.integrate_together(kernels, at_once, a, rank)
        alone = [grid.integrate(kernel, a, rank=rank) for kernel in kernels]
        np.testing.assert_allclose(together, alone, rtol=0, atol=1e-13)


# ---- the grids ----------------------------------------------------------------------------------


@pytest.mark.parametrize("nodes", [7, 8, 64, 65])
def test_grids_are_antisymmetric_and_interlace(nodes: int) -> None:
    for grid in (cosine_grid(nodes), uniform_grid(nodes)):
        assert grid.nodes.size == nodes
        assert grid.unknowns == nodes - 2
        assert (grid.nodes[0], grid.nodes[-1], grid.points[-1]) == (-1.0, 1.0, 1.0)
        np.testing.assert_array_equal(grid.nodes, -grid.nodes[::-1])  # to the last bit
        assert np.all(grid.cells > 0)
    grid = cosine_grid(nodes)
    assert np.all(grid.nodes[:-1] < grid.points[:-1])
    assert np.all(grid.points[:-1] < grid.nodes[1:])
    np.testing.assert_array_equal(grid.points[:-1], -grid.points[-2::-1])
    np.testing.assert_array_equal(uniform_grid(nodes).points, uniform_grid(nodes).nodes)
    np.testing.assert_allclose(uniform_grid(nodes).cells, 2 / (nodes - 1), rtol=1e-13)
    assert cosine_grid(nodes) is grid  # made once


def test_a_segmented_grid_has_its_borders_as_nodes() -> None:
    borders = np.array([-0.6, 0.1, 0.9])
    grid = segmented_grid(borders, 101)
    assert np.isin(borders, grid.nodes).all()
    assert (grid.nodes[0], grid.nodes[-1], grid.points[-1]) == (-1.0, 1.0, 1.0)
    assert np.all(grid.nodes[:-1] < grid.points[:-1])
    assert np.all(grid.points[:-1] < grid.nodes[1:])
    assert grid.nodes.size == pytest.approx(101, abs=4)
    ends = [0, *np.searchsorted(grid.nodes, borders), grid.nodes.size - 1]
    for first, last in pairwise(ends):
        cells = grid.cells[first:last]
        assert cells.size >= 6
        # graded to both ends, somewhat faster than the square of the distance
        np.testing.assert_allclose(cells, cells[::-1], rtol=1e-9)
        assert cells[0] == pytest.approx(cells.min(), rel=1e-9)
        length = grid.nodes[last] - grid.nodes[first]
        assert cells[0] == pytest.approx(length / cells.size**2.2, rel=0.5)


def test_borders_too_near_to_another_are_dropped() -> None:
    borders = np.array([-1 + 1e-4, -0.2, -0.2 + 1e-4, 0.3, 1 - 1e-4])
    grid = segmented_grid(borders, 61)
    assert np.isin([-0.2, 0.3], grid.nodes).all()
    assert not np.isin([-1 + 1e-4, -0.2 + 1e-4, 1 - 1e-4], grid.nodes).any()
    assert segmented_grid(np.array([]), 61).nodes.size == 61


def test_a_semi_ellipse_on_a_segmented_grid() -> None:
    grid = segmented_grid(np.array([-0.35, 0.7]), 129)
    p = np.sqrt(1 - grid.nodes[1:-1] ** 2)
    # first order at the edge as on the plain grid
    np.testing.assert_allclose(grid.inverse @ p, pi * grid.points, atol=4.5 / 129)
    inside = np.abs(grid.points) < 0.9
    np.testing.assert_allclose((grid.inverse @ p)[inside], pi * grid.points[inside], atol=5e-3)


def test_zone_borders_lie_where_the_slack_goes_to_zero_like_a_root() -> None:
    nodes = np.array([-1.0, -0.5, -0.1, 0.1, 0.3, 0.7, 0.8, 1.0])
    zones = np.array([1, 0, 0, -1, -1, -1])
    x, left, right = nodes[1:-1], -0.3, 0.15
    behind, before = (np.sqrt(np.clip(d, 0, None)) for d in (x - left, right - x))
    assert zone_borders(nodes, zones, behind)[0] == pytest.approx(left, abs=1e-12)
    assert zone_borders(nodes, zones, before)[1] == pytest.approx(right, abs=1e-12)
    # where the slack is not of that kind the border still lies between its two nodes
    np.testing.assert_allclose(zone_borders(nodes, zones, np.cos(9 * x)), [-0.3, 0.2], atol=0.21)


def test_zone_borders_lie_half_way_without_two_sticking_nodes() -> None:
    nodes = np.array([-1.0, -0.5, -0.1, 0.1, 0.7, 1.0])
    zones, slack = np.array([0, 1, 1, -1]), np.array([0.1, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(zone_borders(nodes, zones, slack), [-0.3, 0.4], rtol=1e-12)
    assert zone_borders(nodes, np.array([1, 1, 1, 1]), 0 * slack).size == 0
