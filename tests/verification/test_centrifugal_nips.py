"""The centrifugal force of the web in nips and windings.

The web presses with (T - m V^2)/R on what it is wrapped on.  A force that is the same everywhere
adds no strain differences: a nip at the tension T and the speed V is that at T - m V^2 at rest, and
all its tensions are larger by m V^2.
"""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from slow_cases import slow_case

import woundon as wo
from woundon.nip.air_films import foil_film

NIP = wo.NipProblem.example()
FORCE = 0.045 * (2500 / 60) ** 2  # of 45 g/m^2 at 2500 m/min [N/m]
RUNNING = {"density": "45 gsm", "web_speed": "2500 m/min"}
RUBBER = wo.Cylinder(
    radius=0.3, core_radius=0.28,
    material=wo.Isotropic(youngs_modulus=10e6, poissons_ratio=0.45),
)  # fmt: skip


def test_the_force_of_45_grams_at_2500_metres_per_minute():
    assert pytest.approx(78.1, abs=0.05) == FORCE
    assert NIP.replace(**RUNNING).centrifugal_tension == pytest.approx(FORCE, rel=1e-12)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"drum_wrap": 1.0, "drum": RUBBER},
        {"roll_wrap": 0.0, "winding_force": -100.0},
        slow_case({"next_nips": [wo.NextNip(angle=2.0, drum=RUBBER, nip_load=1000.0)],
                   "roll_wrap": 4.0}),
    ],
    ids=["wrapped", "both wraps", "no wrap", "two nips"],
)  # fmt: skip
def test_a_running_nip_is_that_of_less_tension(changes: dict):
    still = wo.solve(NIP.replace(**changes), nodes=41)
    problem = NIP.replace(**changes, **RUNNING, web_tension=350.0 + FORCE)
    running = wo.solve(problem, nodes=41)
    # the tolerance of the solver, 1e-10 of pressures and tensions
    for name in ("half_width", "peak_pressure", "nip_induced_tension", "slip_angle"):
        assert getattr(running, name) == pytest.approx(getattr(still, name), rel=1e-7, abs=1e-9)
    for name in ("wound_on_tension", "roll_wound_on_tension", "inlet_tension", "outlet_tension"):
        assert getattr(running, name) == pytest.approx(getattr(still, name) + FORCE, rel=1e-8)
    np.testing.assert_allclose(running.roll_pressure, still.roll_pressure, rtol=0, atol=1e-3)
    # unstrained web and drum are the reference of the creepage
    web = NIP.web
    strain = web.compliance.c11 / web.thickness * FORCE
    assert running.drum_creepage == pytest.approx(still.drum_creepage - strain, rel=1e-6)
    assert running.residuals.largest < 1e-8
    assert running.consistency.largest == pytest.approx(still.consistency.largest, rel=1e-4)
    assert running.recomputed()["roll_wound_on_tension"][0] == pytest.approx(
        running.roll_wound_on_tension, rel=1e-8
    )


def test_the_hoop_pressure_on_both_wraps():
    problem = NIP.replace(**RUNNING, drum_wrap=1.0)
    result = wo.solve(problem, nodes=41)
    first, last = result.hoop_pressure[1], result.hoop_pressure[-2]
    # rigid drum; the roll next to the end of its wrap is still deformed by 1 %
    assert -first == pytest.approx((350.0 - FORCE) / problem.drum.radius, rel=1e-6)
    assert last == pytest.approx((result.wound_on_tension - FORCE) / problem.roll.radius, rel=0.02)


def test_the_capstan_relation_of_a_running_web():
    """The largest winding force is mu P + (T - m V^2) (exp(mu theta) - 1)."""
    problem = NIP.replace(**RUNNING, drum_wrap=pi / 2)
    largest = 0.2 * 3502.0 + (350.0 - FORCE) * np.expm1(0.2 * pi / 2)
    problem.replace(winding_force=largest - 0.01)
    with pytest.raises(wo.NoSteadyState, match="winding_force"):
        problem.replace(winding_force=largest + 0.01)
    with pytest.raises(wo.InvalidProblem, match=r"web_tension.*78\.125 \[N/m\], its centrifugal"):
        problem.replace(web_tension=78.0)


@pytest.mark.parametrize("law", ["nip", "friction"])
def test_a_winding_whose_web_is_slack_on_the_drum_wrap(law: str):
    problem = wo.WindingProblem.example().replace(tension_law=law, drum_wrap=1.0, web_speed=60.0)
    # 680 kg/m^3 x 66 um x (60 m/s)^2 = 161.6 N/m; 245 N/m remain at the surface
    with pytest.raises(
        wo.InvalidProblem, match=r"web_tension: 245 .* 0\.6 \[m\] .*> 287\.232 \[N/m\]"
    ):
        problem.replace(web_speed=80.0)
    assert problem.replace(drum_wrap=0.0, web_speed=80.0).centrifugal_tension > 245


def test_a_given_tension_below_the_centrifugal_force_is_named():
    law = wo.Profile(radius=[0.05, 0.12], value=[400, 400])
    problem = wo.WindingProblem.example().replace(radius=0.12, tension_law=law, web_speed=100.0)
    with pytest.raises(wo.NoSteadyState, match=r"tension_law: .* 400 .*> 448\.8"):
        wo.solve(problem)


def test_a_web_that_its_centrifugal_force_lifts_off_the_roll():
    # 0.19 x 100 N/m is less than 78 N/m
    light = NIP.replace(**RUNNING, nip_load=100.0, web_tension=20.0)
    with pytest.raises(wo.NoSteadyState, match="below its centrifugal force of 78"):
        wo.solve(light, nodes=41)
    wo.solve(light.replace(density=None, web_speed=None), nodes=41)


def test_air_films_of_a_running_web():
    air = wo.Air(roughness="3 um")
    running = wo.solve(NIP.replace(air=air, **RUNNING), nodes=41).air
    V = 2500 / 60
    assert running.foil_film == pytest.approx(foil_film(0.1, V, 350.0 - FORCE, 1.81e-5), rel=1e-12)
    still = wo.solve(NIP.replace(air=air, web_speed=V, web_tension=350.0 - FORCE), nodes=41).air
    assert running.film == pytest.approx(still.film, rel=1e-6)


def test_derivatives_by_speed_and_density():
    """By the theorem dWOT/d(m V^2) = 1 - dWOT/dT_in; m V^2 varies as density and speed squared."""
    result = wo.solve(NIP.replace(**RUNNING), nodes=41)
    slopes = result.sensitivity("web_tension", "density", "web_speed", outputs=["wound_on_tension"])
    by_tension, by_density, by_speed = (
        slopes.derivative("wound_on_tension", name)
        for name in ("web_tension", "density", "web_speed")
    )
    problem = result.problem
    # central differences with a relative step of 1e-4
    expected = (1 - by_tension) * FORCE
    assert by_density * problem.density == pytest.approx(expected, abs=1e-5 * FORCE)
    assert by_speed * problem.web_speed == pytest.approx(2 * expected, abs=1e-5 * FORCE)


def test_without_density_the_speed_has_no_effect():
    with pytest.warns(wo.InputWarning, match="without density the centrifugal force"):
        result = wo.solve(NIP.replace(web_speed=40.0), nodes=41)
    assert result.wound_on_tension == wo.solve(NIP, nodes=41).wound_on_tension
    assert "density" in NIP.replace(density=680.0).unused
