"""Free rolling of dissimilar rollers, Q = 0, against Bentall and Johnson (1967), both limits.

Shear moduli 23 and 82 GPa, nu = 0.31 and 0.28, P = 16.2019 N/mm.  The published half width of
0.1 mm and creepages belong to a relative radius of 25 mm, that is rollers of 50 mm; with rollers of
25 mm the width is 0.1/sqrt(2) mm and xi = 0.457386 kappa a/R holds as well.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from random_nips import random_rollers
from roller_cases import dissimilar_pair

import woundon as wo
from woundon import theories

BETA = 0.143834  # Dundurs' constant of the pair


def test_the_limit_of_little_friction() -> None:
    """The soft upper roller is the faster one before strain: xi < 0."""
    result = wo.solve(dissimilar_pair(1e-4))
    assert result.creepage == pytest.approx(-5.26299e-4, rel=3e-3)  # measured: 1e-4
    assert result.half_width == pytest.approx(0.1e-3, rel=1e-4)
    assert result.tangential_load == pytest.approx(0, abs=1e-10 * 16201.9)
    assert result.residuals.largest <= 1e-8
    # slip turns at |x| = 0.40397 a, so that the tractions balance
    inner = np.abs(result.x) < 0.38 * result.half_width
    outer = np.abs(result.x) > 0.43 * result.half_width
    assert len(set(result.zone[inner])) == 1
    assert len(set(result.zone[outer])) == 1
    assert result.zone[inner][0] == -result.zone[outer][0]


def test_little_friction_with_rollers_half_as_large() -> None:
    result = wo.solve(dissimilar_pair(1e-4, radius=0.025))
    a, R = result.half_width, 0.0125
    assert a == pytest.approx(0.1e-3 / sqrt(2), rel=1e-4)
    assert result.creepage == pytest.approx(-0.457386 * 2 * BETA * a / R, rel=3e-3)


def test_the_limit_of_full_stick() -> None:
    problem = dissimilar_pair(10.0)
    result, exact = wo.solve(problem), theories.bentall_johnson_stick(problem)
    # with mu = 10 the slip at the edges is shorter than a cell of this or any affordable grid
    assert set(result.zone) == {wo.Zone.STICK}
    assert result.creepage == pytest.approx(-3.67269e-4, rel=3e-3)  # measured: 3.3e-4
    assert result.half_width == pytest.approx(exact.half_width, rel=1e-4)
    assert np.interp(0.0, result.x, result.pressure) == pytest.approx(103.788e6, rel=1e-3)
    inner = np.abs(result.x) < 0.95 * result.half_width
    error = (result.traction - exact.traction(result.x))[inner]
    assert np.max(np.abs(error)) < 1e-3 * np.max(result.pressure)
    assert result.residuals.largest <= 1e-8


def test_full_stick_converges() -> None:
    problem, nodes = dissimilar_pair(10.0), [26, 51, 101, 201]
    exact = theories.bentall_johnson_stick(problem)
    misses = [abs(wo.solve(problem, nodes=n).creepage - exact.creepage) for n in nodes]
    order = -np.polyfit(np.log(nodes), np.log(misses), 1)[0]
    assert order >= 1.5  # measured: 1.9


def test_between_the_limits_the_creepage_falls_with_friction() -> None:
    creepages = [
        abs(wo.solve(dissimilar_pair(mu)).creepage) for mu in (1e-4, 0.02, 0.05, 0.2, 10.0)
    ]
    assert creepages == sorted(creepages, reverse=True)


@pytest.mark.parametrize(("seed", "nodes"), [(110007, 201), (72026, 201), (72041, 401)])
def test_strong_coupling_is_reached_from_none(seed: int, nodes: int) -> None:
    """Rolls far softer one way than the other, on which pivots alone go round in a circle."""
    problem = random_rollers(seed)
    fine, coarse = (wo.solve(problem, nodes=count) for count in (nodes, 101))
    # both are reported to better than a thousandth
    assert fine.half_width == pytest.approx(coarse.half_width, rel=1e-3)
    assert sorted(set(fine.zone)) == sorted(set(coarse.zone))
    assert fine.residuals.largest < 1e-8
