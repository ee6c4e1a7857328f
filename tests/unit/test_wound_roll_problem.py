"""Wound rolls: what is refused, what a core is, and what a schedule says."""

from __future__ import annotations

import numpy as np
import pytest
from rejections import assert_rejected

import woundon as wo
from woundon.problems.schedules import Curve

ROLL = wo.RollProblem.example()


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"radius": 0.04}, "core.radius: 0.0445 is out of range; must be > 0 and < radius"),
        ({"wound_on_tension": -5.0}, "wound_on_tension: -5 is out of range; must be > 0"),
        ({"wound_on_tension": float("nan")}, "wound_on_tension"),
        ({"wound_on_tension": wo.Taper(start=350, taper=1.0)},
         "wound_on_tension.taper: 1 is out of range; the tension at the surface must be"),
        ({"wound_on_tension": wo.Profile(radius=[0.05, 0.15], value=[300, 300])},
         "wound_on_tension.radius.0: 0.05 is out of range; must be <= core.radius = 0.0445"),
        ({"wound_on_tension": wo.Profile(radius=[0.04, 0.14], value=[300, 300])},
         "wound_on_tension.radius.1: 0.14 is out of range; must be >= radius = 0.15"),
        ({"web_thickness": 1e-8}, "web_thickness: 1e-08 is out of range; must be >="),
        ({"web_thickness": 0.02}, "10 to 1e+06 layers"),
        ({"core_shrinkage": 0.5}, "core_shrinkage: 0.5 is out of range"),
    ],
)  # fmt: skip
def test_what_cannot_be_wound_is_rejected(changes: dict, text: str):
    with pytest.raises(wo.InvalidProblem) as fault:
        ROLL.replace(**changes)
    assert text in str(fault.value)
    assert len(str(fault.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("core", "text"),
    [
        ({}, "stiffness: missing"),
        ({"stiffness": 1e9, "inner_radius": 0.04}, "given together with a tube"),
        ({"inner_radius": 0.04}, "material: missing"),
        ({"inner_radius": 0.05, "material": "steel"}, "inner_radius: 0.05 is out of range"),
    ],
)
def test_a_core_has_a_stiffness_or_is_a_tube(core: dict, text: str):
    if core.get("material") == "steel":
        core = core | {"material": wo.material("steel")}
    with pytest.raises(wo.InvalidProblem) as fault:
        wo.Core(radius=0.0445, **core)
    assert text in str(fault.value)


def test_a_tube_shrinks_as_lame_says():
    steel = wo.Isotropic(youngs_modulus=206e9, poissons_ratio=0.3)
    solid = wo.Core(radius=0.05, inner_radius=0.0, material=steel).effective_stiffness
    # plane strain: u/r = -(1 + nu)(1 - 2 nu) P/E of a full cylinder
    assert solid == pytest.approx(206e9 / (1.3 * 0.4))
    thin = wo.Core(radius=0.05, inner_radius=0.0499, material=steel).effective_stiffness
    # a thin ring: E t/((1 - nu^2) r), to the ring's thickness
    assert thin == pytest.approx(206e9 * 0.002 / (1 - 0.09), rel=4e-3)


@pytest.mark.parametrize(
    "schedule",
    [
        wo.Taper(start=300.0, taper=0.4),
        wo.Taper(start=300.0, taper=0.4, law="hyperbolic"),
        wo.Taper(start=300.0, law="constant_torque"),
        wo.Profile(radius=[0.04, 0.1, 0.2], value=[300.0, 250.0, 100.0]),
        300.0,
    ],
)
def test_a_curve_s_slope_is_that_of_its_values(schedule: object):
    curve = Curve(schedule, 0.05, 0.2, scale=2.0)
    r = np.linspace(0.051, 0.199, 37)
    differences = (curve.at(r + 1e-7) - curve.at(r - 1e-7)) / 2e-7
    np.testing.assert_allclose(curve.slope(r), differences, rtol=1e-6, atol=1e-4)
    assert curve.at(np.array([0.05]))[0] == pytest.approx(2 * (
        schedule if isinstance(schedule, float) else getattr(schedule, "start", 291.6666666666667)
    ))  # fmt: skip


def test_a_profile_s_kinks_have_two_slopes():
    curve = Curve(wo.Profile(radius=[0.04, 0.1, 0.2], value=[300.0, 240.0, 200.0]), 0.05, 0.2)
    kink = np.array([0.1])
    assert curve.kinks.tolist() == [0.1]
    assert curve.slope(kink, -1)[0] == pytest.approx(-1000)
    assert curve.slope(kink, 1)[0] == pytest.approx(-400)
    assert curve.bends[0] == pytest.approx(0.1 * 600 / 240)


def test_a_stack_that_ends_is_reported():
    """A measured law that ends at 100 kPa cannot carry a roll of 300 kPa."""
    test = wo.StackTest(pressure=[0, 2e4, 5e4, 1e5], strain=[0, 0.03, 0.045, 0.058])
    with pytest.raises(wo.NotConverged) as fault:
        wo.solve(ROLL.replace(stack=ROLL.stack.replace(radial=test)))
    assert "beyond the stack's law" in str(fault.value)


def test_a_roll_that_comes_apart_is_reported():
    with pytest.raises(wo.NotConverged) as fault:
        wo.solve(ROLL.replace(core_shrinkage=0.05))
    assert "come apart" in str(fault.value)


@pytest.fixture(scope="module")
def result() -> wo.RollResult:
    return wo.solve(ROLL.replace(wound_on_tension=wo.Taper(start=400.0, taper=0.25)), rtol=1e-2)


@pytest.mark.parametrize("ending", ["nc", "json"])
def test_result_file_round_trip(result, tmp_path, ending: str):
    path = tmp_path / f"roll.{ending}"
    result.save(path)
    again = wo.load_result(path)
    assert again == result
    assert again.certified().largest < 1e-8
    assert again.at(0.1).radius[-1] == 0.1  # the build-up is in the file


@pytest.mark.parametrize(
    ("radius", "message"),
    [
        ("x", "radius: 'x' is not a number; must be a radius on the roll [m]"),
        ([0.05, 0.06], "radius: 2 values; must be one radius [m]"),
        (0.0446, "radius: 0.0446 is out of range; must be >= 0.04516 [m], 10 layers"),
        (0.2, "radius: 0.2 is out of range; must be >= 0.0445 and <= 0.15 [m], on the roll"),
        (float("nan"), "radius: nan is out of range"),
    ],
)
def test_a_stage_that_is_none_is_rejected(wound, radius: object, message: str):
    assert_rejected(lambda: wound.at(radius), message)


@pytest.fixture(scope="module")
def wound():
    return wo.solve(ROLL)


def test_changes_too_large_to_settle_are_reported_by_what_they_do():
    """Not by an estimated error of 1e297 of the pressure."""
    with pytest.raises(wo.NotConverged, match="the layers come apart at the radius"):
        wo.solve(ROLL.replace(temperature_change=1000.0, radial_expansion=-1e-2))


def test_a_stack_too_soft_to_wind_on_is_reported_so():
    with pytest.raises(wo.NotConverged, match="stack without pressure, or the core, is too soft"):
        wo.solve(ROLL.replace(**{"stack.radial.K1": 1e-6}))


def test_temperatures_and_expansions_have_units_in_case_files():
    warmer = ROLL.replace(temperature_change="-10 K", radial_expansion="50e-6 1/K")
    assert (warmer.temperature_change, warmer.radial_expansion) == (-10.0, 50e-6)
    # a difference of temperatures: no scale with another zero
    assert_rejected(
        lambda: ROLL.replace(temperature_change="-10 degC"),
        "temperature_change: '-10 degC' has the unknown unit 'degC'; expected a value in K, "
        "e.g. '-10 K', a difference; did you mean 'K'?",
    )
