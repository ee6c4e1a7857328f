"""Torque and power of the drives: balances of power and of the moment of momentum, closed forms."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import woundon as wo
from woundon.report.result_panels import panels_of
from woundon.winding.drives import drives_of

BASE = wo.WindingProblem.example().replace(
    tension_law="friction", width=2.5, web_speed=30.0, web_tension=wo.Taper(start=350, taper=0.3)
)
R = np.linspace(0.05, 0.6, 12)
WITHOUT_MASS = BASE.replace(density=None)
TWO_DRUMS = BASE.replace(
    winder=wo.TwoDrums(front_drum=wo.Rigid(radius=0.2), gap=0.02, rider_load=3000.0,
                       rider=wo.Rigid(radius=0.15)),
    nip_load=None, torque_split=0.4,
)  # fmt: skip


def drives(problem: wo.WindingProblem, film: float = 0.0) -> dict[str, wo.winding.drives.Drive]:
    return {name: one for name, one in drives_of(problem, R, film).items() if one is not None}


def total_power(problem: wo.WindingProblem) -> np.ndarray:
    return sum(one.power for one in drives(problem).values())


# ---- constant speed -----------------------------------------------------------------------------


def test_the_core_of_a_centre_winder_carries_the_web_tension():
    found = drives(WITHOUT_MASS)
    T = WITHOUT_MASS.at("web_tension", R)
    np.testing.assert_allclose(found["core_drive"].torque, T * R * 2.5, rtol=1e-14)
    np.testing.assert_allclose(found["core_drive"].speed, 30 / R, rtol=1e-14)
    assert not found["drum_drive"].torque.any()
    constant = WITHOUT_MASS.replace(web_tension=wo.Taper(start=350, law="constant_torque"))
    np.testing.assert_allclose(drives(constant)["core_drive"].torque, 350 * 0.05 * 2.5, rtol=1e-14)


@settings(deadline=None, max_examples=30)
@given(st.floats(-0.5, 0.999), st.floats(0.1, 60.0), st.floats(0.2, 3.0))
def test_without_inertia_the_drives_supply_the_power_of_the_web(split, speed, width):
    """The sum of the powers is T_in V w, whatever the split; a drum that brakes takes power."""
    force = {"torque_split": split} if split >= 0 else {"winding_force": -split * 350.0}
    T = WITHOUT_MASS.at("web_tension", R)
    problem = WITHOUT_MASS.replace(**force, web_speed=speed, width=width, nip_load=5e3)
    # rounding of the differences of the forces
    np.testing.assert_allclose(total_power(problem), T * speed * width, rtol=1e-12)


@pytest.mark.parametrize("core_torque", [0.0, 30.0, wo.Profile(radius=[0.05, 0.6], value=[5, 40])])
def test_two_drums_and_a_core_drive_supply_the_power_of_the_web(core_torque: object):
    """The weight that the density gives the roll has no part in it; its inertia is subtracted."""
    problem = TWO_DRUMS.replace(**{"winder.core_torque": core_torque})
    found = drives(problem)
    assert ("core_drive" in found) == (core_torque != 0.0)
    expected = problem.at("web_tension", R) * 30 * 2.5 - growth_power(problem)
    np.testing.assert_allclose(total_power(problem), expected, rtol=1e-12)
    if "core_drive" in found:
        given_torque = problem.at("winder.core_torque", R) * 2.5
        np.testing.assert_allclose(found["core_drive"].torque, given_torque, rtol=1e-14)


def growth_power(problem: wo.WindingProblem) -> np.ndarray:
    """The web arrives with m V^2/2 and keeps a half of it: rho h w V^3 (1 - (r_c/r)^4)/4."""
    mass_flow = 680 * 66e-6 * problem.width * problem.web_speed
    return mass_flow * problem.web_speed**2 / 4 * (1 - (0.05 / R) ** 4)


def test_at_constant_speed_the_growing_roll_gives_kinetic_energy_back():
    saved = total_power(WITHOUT_MASS) - total_power(BASE)
    np.testing.assert_allclose(saved, growth_power(BASE), rtol=1e-9)
    # a film between the layers makes the roll larger, not heavier
    with_film = drives(BASE, film=66e-6)["core_drive"].power
    np.testing.assert_allclose(with_film, drives(BASE)["core_drive"].power, rtol=1e-12)


# ---- acceleration -------------------------------------------------------------------------------


@pytest.mark.parametrize("problem", [
    BASE.replace(inertia=wo.Inertia(core=4.0), **{"limits.acceleration": 0.5}),
    BASE.replace(torque_split=1.0, nip_load=8000.0, **{"limits.acceleration": 2.0}),
    TWO_DRUMS.replace(inertia=wo.Inertia(core=9.0, rider=3.0), **{"limits.acceleration": 1.0}),
], ids=["centre", "surface", "two drums"])  # fmt: skip
def test_moment_of_momentum_of_a_roll_wound_layer_by_layer(problem: wo.WindingProblem):
    """The roll as rings of single layers, which turn at V/r; a time step by differences.

    d(J omega)/dt - what the web brings = moments of core, web and drums about the axis.
    """
    h, w, a = 66e-6, 2.5, problem.limits.acceleration
    dt = 1e-3  # s; central differences, of the second order in dt/(r/V) ~ 1e-2, dt V/... ~ 1e-6

    inertias = problem.inertia or wo.Inertia()

    def momentum(r: float, V: float) -> float:
        edges = np.linspace(0.05, r, 200_001)  # a ring's inertia by its mean radius squared
        mean = (edges[1:] + edges[:-1]) / 2
        web = 680 * w * np.sum(2 * pi * mean * np.diff(edges) * mean**2)
        return (web + inertias.core) * V / r

    for k in (4, 11):
        r, V = R[k], 30.0
        growth = h * V / (2 * pi * r)
        later, earlier = (
            momentum(
                r + growth * t + (h * a / (4 * pi * r) - growth**2 / (2 * r)) * t**2, V + a * t
            )
            for t in (dt, -dt)
        )
        change = (later - earlier) / (2 * dt)
        brought = 680 * h * w * V * V * r
        found = drives(problem)
        core = found.get("core_drive")
        moment = -problem.at("web_tension", r) * r * w
        if core is not None:
            moment += core.torque[k] + core.acceleration_torque[k]
        for name, radius, own in (("drum_drive", 0.25, inertias.drum),
                                  ("front_drive", 0.2, inertias.front_drum)):  # fmt: skip
            if name in found:
                drum = found[name]
                # without its own inertia the moment of the drum acts at the roll's surface
                on_roll = drum.torque[k] + drum.acceleration_torque[k] - own * a / radius
                moment += on_roll * r / radius
        if problem.winder is not None:
            moment -= inertias.rider * a / 0.15**2 * r
        # differences and rings: relative 1e-6 of the largest term, the web's moment
        assert change - brought == pytest.approx(moment, abs=1e-5 * 350 * r * w)


def test_a_drum_accelerates_itself():
    problem = BASE.replace(inertia=wo.Inertia(drum=50.0), **{"limits.acceleration": 0.8})
    drum = drives(problem)["drum_drive"]
    np.testing.assert_allclose(drum.acceleration_torque, 50 * 0.8 / 0.25, rtol=1e-14)
    # a hollow drum of the mass m on its surface has J = m R^2: m a at the surface
    assert drum.largest_torque == pytest.approx(50 / 0.25**2 * 0.8 * 0.25)
    assert drum.largest_power == pytest.approx(50 / 0.25**2 * 0.8 * 30)


def test_two_drums_share_the_inertia_as_the_web_tension():
    problem = TWO_DRUMS.replace(**{"limits.acceleration": 0.5})
    found = drives(problem)
    J = pi / 2 * 680 * 2.5 * (R**4 - 0.05**4)
    for name, radius, share in (("drum_drive", 0.25, 0.4), ("front_drive", 0.2, 0.6)):
        expected = share * J * 0.5 / R**2 * radius
        np.testing.assert_allclose(found[name].acceleration_torque, expected, rtol=1e-12)


def test_largest_values_are_those_of_speeding_up_or_slowing_down():
    brakes = BASE.replace(winding_force=300.0, nip_load=8000.0)
    problem = brakes.replace(inertia=wo.Inertia(drum=10.0), **{"limits.acceleration": 0.5})
    drum = drives(problem)["drum_drive"]
    assert (drum.torque < 0).all()
    assert drum.largest_torque == pytest.approx(300 * 2.5 * 0.25 + 10 * 0.5 / 0.25)
    core = drives(problem)["core_drive"]
    assert core.largest_power == np.max((core.torque + core.acceleration_torque) * core.speed)


# ---- as outputs ---------------------------------------------------------------------------------


def test_results_have_drives_with_a_width_and_a_speed(tmp_path):
    small = BASE.replace(radius=0.12, **{"limits.acceleration": 0.5})
    result = wo.solve(small, rtol=1e-2)
    path = tmp_path / "winding.json"
    result.save(path)
    again = wo.load_result(path)
    np.testing.assert_array_equal(again.core_drive.torque, result.core_drive.torque)
    np.testing.assert_array_equal(again.drive_radius, result.drive_radius)
    assert result.to_xarray()["core_drive.torque"].dims == ("drive_radius",)
    assert again.drum_drive.largest_power == result.drum_drive.largest_power == 0.0
    assert result.front_drive is None
    for missing in ({"width": None}, {"web_speed": None}):
        assert wo.solve(small.replace(**missing), rtol=1e-2).core_drive is None


def test_a_torque_of_a_file_that_is_wrong_is_found():
    result = wo.solve(BASE.replace(radius=0.12), rtol=1e-2)
    wrong = result.core_drive.torque * 1.001
    from dataclasses import replace

    damaged = result.replace(core_drive=replace(result.core_drive, torque=wrong))
    assert result.certified().schedules < 1e-12
    assert damaged.certified().schedules > 1e-4
    assert result.replace(core_drive=None).certified().schedules == np.inf


def test_moments_of_inertia_with_units():
    problem = BASE.replace(inertia={"core": "12 lb*ft^2", "drum": "60 kg m^2"})
    assert problem.inertia.core == pytest.approx(12 * 0.45359237 * 0.3048**2, rel=1e-14)
    assert problem.inertia.drum == 60.0
    assert "inertia.rider" in problem.unused
    assert "inertia" in problem.replace(width=None).unused


def test_moments_of_inertia_without_effect_are_warned_of():
    given = {"inertia": wo.Inertia(core=3.0, drum=2.0, rider=1.0)}
    problem = BASE.replace(**given)
    assert [text.split()[0] for text in problem.input_warnings] == ["inertia.rider"]
    assert not TWO_DRUMS.replace(**given).input_warnings
    for changes in ({"width": None}, {"web_speed": None}, {"web_speed": 0.0}):
        assert any(t.startswith("inertia is") for t in problem.replace(**changes).input_warnings)
    alone = problem.replace(nip_load=0.0, drum=None, drum_friction=None)
    names = {text.split()[0] for text in alone.input_warnings}
    assert names == {"inertia.drum", "inertia.rider"}


@pytest.mark.parametrize("problem", [BASE, TWO_DRUMS], ids=["centre", "two drums"])
def test_the_report_and_the_panels_show_torque_and_power(problem: wo.WindingProblem):
    moving = problem.replace(inertia=wo.Inertia(drum=20.0), **{"limits.acceleration": 0.5})
    result = wo.solve(moving, rtol=1e-2)
    lines = str(result).splitlines()
    name, words = ("drum_drive", "rear drum") if problem.winder else ("core_drive", "core")
    row = next(line for line in lines if line.startswith(f" torque of the {words}  ")).split()
    drive = getattr(result, name)
    at_surface = float(row[-2])
    assert at_surface == pytest.approx(drive.torque[-1], rel=5e-4)  # four digits
    assert any("largest power" in line and "kW" in line for line in lines)
    panels = panels_of(result)
    for panel, output in (("torque", drive.torque), ("power", drive.power)):
        curve = next(c for c in panels[panel].make(result).curves if c.name == f"{name}.{panel}")
        np.testing.assert_array_equal(curve.x, result.drive_radius)
        np.testing.assert_array_equal(curve.y, output)
    # drums that share the power equally are both visible
    power = panels["power"].make(result).curves
    assert len({curve.line for curve in power if "drum" in curve.label}) == len(
        [curve for curve in power if "drum" in curve.label]
    )
    assert "torque" not in panels_of(wo.solve(problem.replace(width=None), rtol=1e-2))


def test_a_speed_has_an_effect_with_a_width():
    texts = WITHOUT_MASS.replace(width=None).input_warnings
    assert any("web_speed" in text for text in texts)
    assert not any("web_speed" in text for text in WITHOUT_MASS.input_warnings)
    assert "web_speed" in WITHOUT_MASS.replace(width=None).unused
    assert "web_speed" not in WITHOUT_MASS.unused
