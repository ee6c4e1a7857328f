"""Rollers without friction: Hertz's problem, in every motion, and the limit of little friction.

Tolerances: the pressure is linear between nodes, so half widths and pressures err like the square
of the cells, at the edge like the cells; the constants are measured and rounded up.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import woundon as wo
from woundon import theories

STEEL = wo.HalfPlane(radius=0.25, material="steel")
SOFTER = wo.HalfPlane(radius=0.1, material=wo.Isotropic(youngs_modulus=1e9, poissons_ratio=0.2))
WAYS: dict[str, dict[str, Any]] = {
    "rolling": {},
    "no load along": {"tangential_load": 0.0},
    "static": {"motion": "static"},
    "creepage": {"creepage": 1e-3},
}


def pair(upper: wo.Body = STEEL, **changes: Any) -> wo.RollerProblem:
    return wo.RollerProblem(upper=upper, lower=STEEL, load=89e3, friction=0.0).replace(**changes)


@pytest.mark.parametrize("upper", [STEEL, SOFTER], ids=["similar", "dissimilar"])
@pytest.mark.parametrize("way", WAYS)
def test_hertz_is_met_to_the_grids_order(way: str, upper: wo.Body) -> None:
    problem = pair(upper, **WAYS[way])
    exact = theories.hertz(problem)
    for nodes in (25, 49, 97):
        result = wo.solve(problem, nodes=nodes)
        cell = 2 / (nodes - 1)
        assert result.nodes == nodes
        assert result.residuals.largest <= 1e-8
        assert result.half_width == pytest.approx(exact.half_width, rel=0.1 * cell**2)
        ellipse = np.sqrt(np.maximum(1 - (result.x / exact.half_width) ** 2, 0))
        miss = np.abs(result.pressure / exact.peak_pressure - ellipse)
        assert miss[np.abs(result.x) < 0.8 * result.half_width].max() <= 0.4 * cell**2
        assert miss.max() <= 0.2 * cell  # next to the edge, where it goes like a root
        assert not result.traction.any()
        assert result.tangential_load == 0.0


def test_the_creepage_is_that_of_vanishing_friction() -> None:
    problem = pair(SOFTER)
    creepage = wo.solve(problem, nodes=201).creepage
    # a median over nodes is known to a share of a cell
    assert creepage == pytest.approx(theories.bentall_johnson_frictionless(problem), rel=2e-3)
    little = wo.solve(problem.replace(friction=1e-6), nodes=201)
    assert creepage == pytest.approx(little.creepage, rel=2e-3)
    assert little.half_width == pytest.approx(wo.solve(problem).half_width, rel=1e-5)


def test_where_a_creepage_is_given_all_slips() -> None:
    result = wo.solve(pair(SOFTER, creepage=-0.1))
    assert result.creepage == -0.1
    assert np.all(result.zone == wo.Zone.BACKWARD)
    assert result.slip_share == pytest.approx(1.0)


def test_a_layer_without_friction_is_the_limit_of_little() -> None:
    layer = wo.Cylinder(
        radius=0.25, core_radius=0.24, material=wo.Isotropic(youngs_modulus=1e7, poissons_ratio=0.5)
    )
    none = wo.solve(pair(layer))
    little = wo.solve(pair(layer, friction=1e-7))
    # other nodes: those of little friction are fitted to its zones
    assert none.half_width == pytest.approx(little.half_width, rel=1e-4)
    assert none.peak_pressure == pytest.approx(little.peak_pressure, rel=1e-3)


def test_without_friction_there_is_no_tangential_load() -> None:
    with pytest.raises(wo.NoSteadyState, match=r"^tangential_load: 1 is out of range; must be 0 or"
                       " omitted for rollers without friction$"):  # fmt: skip
        pair(tangential_load=1.0)
    with pytest.raises(
        wo.InvalidProblem, match=r"friction: 1e-09 .*; must be 0 or >= 1e-08 and <="
    ):
        pair(friction=1e-9)
    with pytest.raises(
        wo.InvalidProblem, match=r"friction: 0 .* must be > 0: nothing sticks, use hertz"
    ):
        theories.carter(pair())


@pytest.mark.parametrize("face", ["roll", "drum"])
def test_a_web_needs_friction(face: str) -> None:
    reason = f"without friction the web speed relative to the {face} is undetermined"
    with pytest.raises(wo.InvalidProblem, match=f"^{face}_friction: 0 is out of range; .*{reason}"):
        wo.NipProblem.example().replace(roll_wrap=0.0).replace(**{f"{face}_friction": 0.0})
