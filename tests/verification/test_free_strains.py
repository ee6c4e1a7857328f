"""Free strains of finished rolls: temperature and moisture, uniform or over the radius."""

from __future__ import annotations

import numpy as np
import pytest
from rings import Rings
from scipy.integrate import quad

import woundon as wo
from woundon.roll.finite_layers import finite_layer_stresses
from woundon.roll.theories import constant_moduli

NEWSPRINT = wo.RollProblem.example()


def disc(**changes: object) -> wo.RollProblem:
    """An isotropic roll without a core, wound so tight that its layers stay in contact."""
    stack = wo.Stack(radial=4e9, tangential=4e9, poissons_ratio=0.3, shear=1e7)
    return wo.RollProblem(
        core=wo.Core(radius=0.05, stiffness=1e9), core_removed=True, radius=0.2, stack=stack,
        web_thickness=1e-4, wound_on_tension=2000.0, **changes,
    )  # fmt: skip


@pytest.mark.parametrize(
    "profile",
    [
        wo.Profile(radius=[0.05, 0.2], value=[0.0, -30.0]),
        wo.Profile(radius=[0.05, 0.15, 0.17, 0.2], value=[5.0, 5.0, -10.0, -40.0]),
        wo.Profile(radius=[0.05, 0.1, 0.2], value=[0.0, -5.0, -40.0], between="smooth"),
    ],
    ids=["linear", "kinks", "smooth"],
)
def test_the_thermal_stress_of_a_disc(profile: wo.Profile):
    """Timoshenko: the disc with a hole in plane stress, whose temperature depends on the radius."""
    a, b, E, alpha = 0.05, 0.2, 4e9, 2e-5
    heated = disc(temperature_change=profile, tangential_expansion=alpha, radial_expansion=alpha)
    result, before = wo.solve(heated, rtol=1e-6), wo.solve(disc(), rtol=1e-6)
    r = np.array([0.051, 0.06, 0.09, 0.12, 0.15, 0.16, 0.18, 0.199])

    def moment(outer: float) -> float:
        """Return the integral of T r from the bore."""
        kinks = [x for x in profile.radius if a < x < outer]
        return quad(lambda x: float(profile.at(np.array(x))) * x, a, outer, points=kinks or None,
                    epsabs=0, epsrel=1e-12)[0]  # fmt: skip

    whole, part = moment(b), np.array([moment(x) for x in r])
    radial = E * alpha / r**2 * ((r**2 - a**2) / (b**2 - a**2) * whole - part)
    hoop = (r**2 + a**2) / (b**2 - a**2) * whole + part - profile.at(r) * r**2
    hoop = E * alpha / r**2 * hoop
    found, wound = result.at_radius(r), before.at_radius(r)
    # relative to E alpha T = 3 MPa; interpolated slopes are of order three
    np.testing.assert_allclose(wound["pressure"] - found["pressure"], radial, rtol=0, atol=5.0)
    np.testing.assert_allclose(found["hoop_stress"] - wound["hoop_stress"], hoop, rtol=0, atol=30.0)
    assert result.residuals.largest < 1e-8


def test_moisture_and_temperature_are_one_term():
    """The same free strains by either give the same roll, and both add up."""
    strains = {"tangential": -0.2e-3, "radial": -4e-3, "core": 0.1e-3}
    by_heat = {f"{name}_expansion": value / 10 for name, value in strains.items()}
    by_water = {f"{name}_swelling": value / 0.02 for name, value in strains.items()}
    one, two, both = (
        wo.solve(NEWSPRINT.replace(**changes))
        for changes in (
            {"temperature_change": 10.0, **by_heat},
            {"moisture_change": "2 %", **by_water},
            {"temperature_change": 5.0, "moisture_change": 0.01, **by_heat, **by_water},
        )
    )
    for other in (two, both):
        # rounding of the free strains
        np.testing.assert_allclose(one.pressure, other.pressure, rtol=1e-10, atol=1e-6)
        np.testing.assert_allclose(one.layer_strain, other.layer_strain, rtol=1e-10)
    assert one.mid_pressure < 0.9 * wo.solve(NEWSPRINT).mid_pressure
    swollen = wo.solve(NEWSPRINT.replace(moisture_change=-0.02, core_swelling=0.05))
    shrunk = wo.solve(NEWSPRINT.replace(core_shrinkage=0.001))
    assert swollen.core_pressure == pytest.approx(shrunk.core_pressure, rel=1e-10)
    assert constant_moduli(
        disc(moisture_change=0.02, radial_swelling=0.01), [0.1]
    ).pressure == pytest.approx(
        wo.solve(disc(moisture_change=0.02, radial_swelling=0.01), rtol=1e-6).at_radius(
            [0.1])["pressure"], rel=1e-6)  # fmt: skip


def test_a_uniform_profile_is_a_number():
    changes = {"temperature_change": -20.0, "tangential_expansion": 1e-5, "radial_expansion": 1e-4}
    number = wo.solve(NEWSPRINT.replace(**changes))
    changes["temperature_change"] = wo.Profile(radius=[0.0445, 0.1, 0.15], value=[-20.0] * 3)
    profile = wo.solve(NEWSPRINT.replace(**changes))
    # another node at 0.1 m
    assert profile.core_pressure == pytest.approx(number.core_pressure, rel=1e-5)
    assert profile.density == pytest.approx(
        np.interp(profile.radius, number.radius, number.density), rel=1e-3
    )


DRYING = {
    "moisture_change": wo.Profile(radius=[0.0445, 0.1, 0.125, 0.16], value=[0, 0, -0.01, -0.04]),
    "tangential_swelling": 0.02, "radial_swelling": 0.5, "core_swelling": 0.1,
}  # fmt: skip


@pytest.mark.parametrize(
    "changes",
    [
        DRYING,
        {"temperature_change": wo.Profile(radius=[0.0445, 0.16], value=[30.0, -10.0]),
         "tangential_expansion": 1e-5, "radial_expansion": 8e-5, "core_expansion": 2e-5},
    ],
    ids=["drying from the surface", "heated at the core"],
)  # fmt: skip
def test_profiles_against_rings(changes: dict):
    """Rings with their own free strains: their first-order difference is that of finite layers."""
    core, h = 0.0445, 4 * 66e-6
    R = core + 399 * h
    plain = NEWSPRINT.replace(web_thickness=h, wound_on_tension=4 * 350.0, radius=R)
    problem = plain.replace(**changes)
    result, rings = wo.solve(problem, rtol=1e-4), Rings(problem, 2)
    r = np.minimum(rings.r, problem.radius)
    miss = rings.P - result.at_radius(r)["pressure"]
    assert np.max(np.abs(miss)) <= 1.25 * result.errors["peak_pressure"]
    change = np.interp(r, result.radius, finite_layer_stresses(result)[0])
    assert np.max(np.abs(miss - change)) < 0.05 * np.max(np.abs(miss))
    effect = result.at_radius(r)["pressure"] - wo.solve(plain).at_radius(r)["pressure"]
    # without r e_t' the difference from the rings would be a tenth of the effect of drying
    assert np.max(np.abs(miss - change)) < 0.06 * np.max(np.abs(effect))


@pytest.mark.parametrize("removed", [False, True])
def test_lanes_of_an_even_web_are_the_plain_roll(removed: bool):
    """Changes with kinks over the radius, at which lanes and mean roll have nodes."""
    even = wo.ThicknessProfile(position=[0.0, 0.5, 1.0], thickness=[1.0, 1.0, 1.0])
    warmth = wo.Profile(radius=[0.04, 0.08, 0.0835, 0.16], value=[5.0, 4.0, -10.0, -10.0])
    result = wo.solve(
        NEWSPRINT.replace(
            thickness_profile=even, core_removed=removed, temperature_change=warmth,
            tangential_expansion=1e-5, radial_expansion=2e-5,
        ),
        lanes=4,
    )  # fmt: skip
    lanes = result.lanes
    r = lanes.radius.values
    assert set(r) >= {*np.exp(np.log([0.08, 0.0835]))}
    for name, values in result.at_radius(r).items():
        # rounding errors of the stages of the build-up; 5e-3 of the pressure without the nodes
        scale = np.max(np.abs(values))
        np.testing.assert_allclose(lanes[name].values.T / scale, [values / scale] * 4, atol=1e-8)
    again = result.replace(lane_roll=None)  # as a loaded result
    # with nodes at the kinks in all stages: a tenth of rtol at most
    assert again.worst_lane.pressure == pytest.approx(result.worst_lane.pressure, rel=1e-4)


def test_the_free_strains_of_a_stage_and_of_what_has_no_effect():
    result = wo.solve(NEWSPRINT.replace(**DRYING))
    stage = result.at(0.1)
    assert stage.problem.moisture_change == 0
    assert stage.core_pressure == pytest.approx(wo.solve(NEWSPRINT).at(0.1).core_pressure, rel=1e-4)
    assert "moisture_change" in NEWSPRINT.replace(moisture_change=0.01).unused
    assert "radial_swelling" in NEWSPRINT.replace(radial_swelling=0.5).unused
    # a core that is removed does not swell
    swollen = NEWSPRINT.replace(moisture_change=0.01, core_swelling=0.1)
    assert not swollen.input_warnings
    for problem in (NEWSPRINT.replace(moisture_change=0.01), swollen.replace(core_removed=True)):
        assert any("moisture_change is not used" in text for text in problem.input_warnings)
        assert "moisture_change" in problem.unused
    removed = NEWSPRINT.replace(core_shrinkage=1e-4, core_removed=True)
    assert removed.input_warnings == ("core_shrinkage is not used, as core_removed = true",)
    assert "change of the moisture content" in str(result)
