"""The inverse: the tension that makes a wanted pressure, and back; what cannot be made."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from rejections import assert_rejected
from slow_cases import slow_case

import woundon as wo

ROLL = wo.RollProblem.example()
CORE, R = ROLL.core.radius, ROLL.radius
AT_CORE = 1e-3  # where the tension rises from a tenth within some 30 layers


def miss(problem: wo.RollProblem, radius: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Of the roll wound by the solver, of the largest wanted."""
    wound = wo.solve(problem, rtol=1e-4)
    return np.abs(wound.at_radius(radius)["pressure"] - wanted) / wanted.max()


def test_inverse_then_forward_meets_a_pressure_that_falls_to_the_surface():
    falls = wo.Profile(radius=[CORE, 0.06, 0.12, R], value=[250e3, 200e3, 120e3, 0.0])
    design = wo.design_tension(ROLL, falls)
    assert design.outer_layer == 0.0
    off = miss(design.problem, design.radius, design.target_pressure)
    assert off.max() < AT_CORE
    assert off[design.radius > CORE + 0.008].max() < 1e-4


@pytest.mark.parametrize(
    "wanted", [200e3, wo.Profile(radius=[CORE, 0.09, R], value=[300e3, 200e3, 120e3])]
)
def test_what_is_wanted_of_the_surface_is_missed_in_a_layer_that_is_reported(wanted: Any):
    design = wo.design_tension(ROLL, wanted)
    assert 0.01 < design.outer_layer < 0.07
    assert design.surface_deviation == pytest.approx(design.target_pressure[-1])
    inside = design.radius < R - design.outer_layer
    off = miss(design.problem, design.radius, design.target_pressure)
    assert off[inside].max() < AT_CORE
    # 1e-4 of the design and as much of the forward solution
    assert off[inside & (design.radius > CORE + 0.008)].max() < 2e-4
    # and the miss in the layer is as estimated
    caught = np.abs(design.pressure - design.target_pressure) / design.target_pressure.max()
    assert np.max(np.abs(off - caught)) < 2e-4


@pytest.mark.parametrize("schedule", [slow_case(350.0), wo.Taper(start=350.0, taper=0.4)])
def test_forward_then_inverse_finds_the_tension_again(schedule: Any):
    problem = ROLL.replace(wound_on_tension=schedule)
    wound = wo.solve(problem, rtol=1e-5)
    P = np.append(wound.pressure[:-1], 0.0)
    pressure = wo.Profile(radius=wound.radius, value=P, between="smooth")
    design = wo.design_tension(problem, pressure)
    r = np.linspace(CORE, R, 300)
    found, given = (p.tension_curve.at(r) for p in (design.problem, problem))
    np.testing.assert_allclose(found, given, rtol=1e-4)
    assert design.outer_layer == 0.0


def test_a_smooth_schedule_is_wound_like_the_curve_it_stands_for():
    """Of eight values of a taper, a spline makes that taper; the two rolls are one."""
    taper = ROLL.replace(wound_on_tension=wo.Taper(start=350.0, taper=0.3))
    r = np.linspace(CORE, R, 8)
    values = taper.tension_curve.at(r) * ROLL.web_thickness
    smooth = wo.Profile(radius=r, value=values, between="smooth")
    curve = ROLL.replace(wound_on_tension=smooth).tension_curve
    assert curve.kinks.size == 0
    np.testing.assert_allclose(curve.slope(r), taper.tension_curve.slope(r), rtol=1e-9)
    one, two = (
        wo.solve(taper.replace(wound_on_tension=s)) for s in (taper.wound_on_tension, smooth)
    )
    assert two.core_pressure == pytest.approx(one.core_pressure, rel=1e-6)


def test_a_smooth_schedule_that_falls_below_zero_between_its_values_is_rejected():
    dips = wo.Profile(radius=[CORE, 0.05, 0.06, 0.14, R], value=[350, 350, 5, 5, 350],
                      between="smooth")  # fmt: skip
    assert_rejected(
        lambda: ROLL.replace(wound_on_tension=dips),
        "wound_on_tension.value: the smooth curve falls to -",
    )
