"""Air in a nip: films against equations solved another way, limits, and the friction left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lubricated_contact import passing_film, second_derivative, sinks
from rejections import assert_rejected
from scipy.integrate import solve_ivp
from slow_cases import slow_case
from thesis_cases import film_nip as make_film_nip

import woundon as wo
from woundon.nip.air_films import FOIL, escaped_film, foil_film, friction_share, nip_film
from woundon.nip.air_inlet import film_factor, solve_inlet
from woundon.nip.entrained_air import _compliance, films_of, inlet_gradient

MU, AMBIENT = 1.81e-5, 101325.0


# ---- films ---------------------------------------------------------------------------------------


def test_the_foil_bearings_coefficient():
    # T (1/R - h'') = p and p' = 6 mu U (h - h0)/h^3 in h0 and h0 (T/6 mu U)^(1/3):
    # y''' = (y - 1)/y^3 from y = 1, whose y'' far out is the coefficient
    start = 1e-8
    path = solve_ivp(
        lambda _, y: [y[1], y[2], (y[0] - 1) / y[0] ** 3], (0, 1e4), [1 + start, start, start],
        rtol=1e-11, atol=1e-14,
    )  # fmt: skip
    assert path.y[2, -1] == pytest.approx(FOIL, abs=1e-5)  # its digits


def test_the_foil_film_of_a_web_on_a_roller():
    # 31.5 um: R 0.1 m, both 10 m/s, 200 N/m, to its three digits
    assert foil_film(0.1, 10.0, 200.0, MU) == pytest.approx(31.5e-6, rel=2e-3)


@pytest.mark.parametrize(
    ("speed", "within"), [(0.01, 4e-3), (0.1, 8e-3), (1.0, 0.015), (10.0, 0.025)]
)
def test_the_inlet_alone_tells_what_a_whole_lubricated_contact_lets_through(speed, within):
    # an asymptotic answer: off by a tenth of l/a, which is 0.012 to 0.2 here
    R, C, P = 0.1, 1 / 4e6, 300.0
    a = np.sqrt(4 * C * P * R / np.pi)
    found = nip_film(2 * P / np.pi / a * (2 / a) ** 0.5, C, speed, MU, AMBIENT)
    film = passing_film(R, P, speed, a, found.film, lambda x: C * sinks(x))
    assert found.film == pytest.approx(film, rel=within)
    assert found.length / a < 0.2


def frictionless(problem, **changes):
    """Return a nip of two half-planes on which the web does nothing but carry its tension."""
    slippery = {"roll_friction": 1e-5, "drum_friction": 1e-5, "web.thickness": 1e-6}
    return problem.replace(**slippery | changes)


def film_of(problem):
    """Return the film at ambient pressure that a nip lets through, and its dry nip."""
    dry = wo.solve(problem.without_air(), nodes=129)
    nip = dry.in_nip
    gradient = inlet_gradient(problem, dry.x[nip], dry.roll_pressure[nip], dry.half_width)
    films = films_of(problem, gradient, dry.half_width)
    lap = problem.web_tension / problem.roll.radius
    return films["nip_film"] * (1 + lap / AMBIENT), films["inlet_length"], dry


@pytest.mark.parametrize("stack", [100e6, 3e6])
@pytest.mark.parametrize(
    ("tension", "speed"), [(20.0, 1.0), (100.0, 5.0), slow_case(100.0, 0.2), slow_case(400.0, 1.0)]
)
def test_a_web_that_comes_wrapped_on_the_drum(film_nip, stack, tension, speed):
    """The film between the roll and a taut web on the drum, and how they give way."""
    problem = frictionless(
        film_nip, drum_wrap=0.5, web_tension=tension, web_speed=speed,
        **{"roll.material.youngs_modulus": stack},
    )  # fmt: skip
    film, length, dry = film_of(problem)
    roll, drum = (body.compliance for body in problem.bodies)

    def gives(x):  # p- = p+ + T w'' on a drum that sinks by w
        at = (x[1:] + x[:-1]) / 2
        sunk = drum / 2 * sinks(x)
        held = np.eye(at.size) - tension * sunk @ second_derivative(at)
        return roll / 2 * sinks(x) + np.linalg.solve(held, sunk)

    own = dry.in_nip
    load = np.trapezoid(dry.roll_pressure[own], dry.x[own])
    whole = passing_film(problem.contact_radius, load, speed, dry.half_width, film, gives)
    # T C/l of 0.06 to 2.5 (7 at the most that was tried): 0.5 to 4 % less
    assert film == pytest.approx(whole, rel=0.045)
    # with K and C of bodies alone it would be up to 30 % less
    assert tension * drum / length > 0.05


@pytest.mark.parametrize(
    ("tau", "speed"), [(1e-3, 1.0), slow_case(1e-4, 1.0), (1e-5, 1.0), slow_case(1e-6, 10.0)]
)
def test_a_film_on_a_viscoelastic_drum(film_nip, tau, speed):
    """Retardation lengths from far longer than the nip to far shorter than its inlet."""
    E = 3e6
    material = wo.Isotropic(youngs_modulus=E, poissons_ratio=0.48, prony=[(2 * E, tau)])
    problem = frictionless(
        film_nip, roll=wo.Rigid(radius=0.2), drum=wo.HalfPlane(radius=0.2, material=material),
        web_tension=1.0, roll_wrap=0.0, web_speed=speed,
    )  # fmt: skip
    film, _, dry = film_of(problem)
    kernel = problem.drum.kernels(speed).normal_p

    def gives(x):
        at = (x[1:] + x[:-1]) / 2
        sides = [(at[:, None] - side).ravel() for side in (x[:-1], x[1:])]
        lags = [kernel.lag.evaluate(t, 1)[0] for t in sides]
        return kernel.log * np.pi / 2 * sinks(x) - (lags[0] - lags[1]).reshape(at.size, -1)

    whole = passing_film(
        problem.contact_radius, problem.nip_load, speed, dry.half_width, film, gives, -dry.offset
    )
    assert film == pytest.approx(whole, rel=0.03)  # 0.5 to 2.5 % are found, l up to a fifth of a


def test_the_inlets_mesh_and_domain():
    # cells of both: second order in the cells, and next to nothing in where the mesh ends
    coarse, fine, finest = (solve_inlet(cells=n).film for n in (100, 200, 400))
    assert abs(fine - finest) < abs(coarse - fine) / 2.5
    assert solve_inlet(cells=400, extent=4000.0).film == pytest.approx(finest, rel=1e-4)
    assert film_factor(1e4) == pytest.approx(finest, rel=3e-4)  # its 1/beta and the table's mesh


def test_a_film_that_hardly_compresses_goes_like_one_over_beta():
    limit = solve_inlet().film
    more = [film_factor(beta) / limit - 1 for beta in (100.0, 200.0)]
    assert more[0] / more[1] == pytest.approx(2, rel=0.02)  # 1/beta^2 is a hundredth


@given(factor=st.floats(0.5, 2.0))
def test_an_incompressible_film_goes_with_the_powers_of_soft_contacts(factor):
    # (mu V)^0.6 C^-0.2 K^-0.8: an ambient pressure that never compresses
    base = nip_film(2e6, 1e-7, 1.0, MU, 1e12).film
    scaled = [nip_film(2e6, 1e-7, factor, MU, 1e12), nip_film(2e6, 1e-7 * factor, 1.0, MU, 1e12),
              nip_film(2e6 * factor, 1e-7, 1.0, MU, 1e12)]  # fmt: skip
    for film, power in zip(scaled, (0.6, -0.2, -0.8), strict=True):
        assert film.film == pytest.approx(base * factor**power, rel=1e-9)  # rounding


def test_air_that_goes_through_the_web():
    assert escaped_film(10e-6, 0.0, 350.0, 20.0) == 10e-6
    # 2 pi k T/V
    assert escaped_film(10e-6, 1e-8, 350.0, 20.0) == pytest.approx(10e-6 - 2 * np.pi * 1.75e-7)
    assert escaped_film(10e-6, 1e-6, 350.0, 20.0) == 0  # newsprint: all of it


def test_friction_falls_with_the_film():
    share = friction_share(np.array([0.0, 1e-6, 2e-6, 3e-6, 9e-6]), 1e-6, 1.0, 3.0)
    assert share == pytest.approx([1, 1, 0.5, 0, 0])


# ---- the nip with air ----------------------------------------------------------------------------


@pytest.fixture(scope="module")
def film_nip():
    return make_film_nip()


@pytest.fixture(scope="module")
def with_air(film_nip):
    return wo.solve(film_nip, nodes=33)


def dry_nip(problem):
    return problem.replace(web_speed=None, air=None)


def test_at_rest_the_results_are_those_without_air_to_the_last_bit(film_nip):
    still, nip = (
        wo.solve(p, nodes=33) for p in (film_nip.replace(web_speed=0.0), dry_nip(film_nip))
    )
    for name in ("wound_on_tension", "nip_induced_tension", "half_width", "peak_pressure"):
        assert getattr(still, name) == getattr(nip, name)
    assert (still.air.film, still.air.friction_share) == (0, 1)
    assert still.without_air == dry_nip(film_nip)
    assert nip.air is None


@pytest.mark.parametrize("changes", [{}, {"roll_wrap": 0.0}], ids=["wrapped", "plain"])
def test_the_nip_was_solved_with_the_friction_that_its_film_leaves(film_nip, changes):
    """Without wraps only the nip's friction is reduced: the dry nip with that friction."""
    with_air = wo.solve(film_nip.replace(**changes), nodes=33)
    assert 0.1 < with_air.air.friction_share < 0.99
    again = wo.solve(with_air.without_air, nodes=33)
    assert again.wound_on_tension == pytest.approx(with_air.wound_on_tension, rel=1e-8)
    assert with_air.residuals.largest < 1e-8
    if changes:
        dry = dry_nip(with_air.problem).replace(roll_friction=with_air.air.roll_friction)
        plain = wo.solve(dry, nodes=33)
        assert plain.wound_on_tension == pytest.approx(with_air.wound_on_tension, rel=1e-8)
        assert with_air.wound_on_tension == with_air.outlet_tension


@pytest.mark.parametrize("speed", [0.0, 0.1, 5.0])
def test_the_edge_of_a_nip_rises_as_hertz_says(film_nip, speed):
    slippery = film_nip.replace(web_tension=0.0, roll_friction=1e-5, web_speed=speed)
    found = wo.solve(slippery, nodes=129)
    a, inlet_share = found.half_width, found.air.inlet_length / found.half_width
    # p = K sqrt(s) sqrt(1 - s/2a); the web's thickness, friction on the drum, 0.5 % of the mesh
    hertz = found.peak_pressure * (2 / a) ** 0.5 * (1 - inlet_share / 2) ** 0.5
    assert found.air.gradient == pytest.approx(hertz, rel=0.01)


def test_the_certificate_detects_every_wrong_value(with_air):
    assert with_air.certified().largest < 1e-8

    def broken(**changes):
        return replace(with_air, air=replace(with_air.air, **changes)).certified()

    for name in ("foil_film", "nip_film", "film", "film_in_nip", "inlet_length", "roll_friction",
                 "wrap_friction", "friction_share", "gradient"):  # fmt: skip
        assert broken(**{name: getattr(with_air.air, name) * 1.001}).air_film > 1e-5, name
    assert broken(gradient=with_air.air.gradient * 1.001).air_inlet > 1e-4
    assert broken(thickness=with_air.air.thickness * 1.001).air_film_profile > 1e-4
    # another friction than that which the nip was solved with
    assert broken(roll_friction=with_air.air.roll_friction * 1.001).largest > 1e-5
    conditions = {condition for condition, _ in with_air.residuals.items()}
    assert {"air_inlet", "air_film", "air_film_profile"} < conditions


@pytest.mark.parametrize("tension", [20.0, 100.0, 400.0])
def test_the_air_that_passes_the_nip_is_on_the_roll(film_nip, tension):
    """Conservation of mass: isothermal air has the same h (p_a + p) in the nip and under a layer.

    p is the mean pressure P/2a in the nip and T/R under the layer wound on.
    """
    problem = film_nip.replace(web_tension=tension)
    result, p_a = wo.solve(problem, nodes=33), problem.air.ambient_pressure
    in_nip = result.air.film_in_nip * (p_a + problem.nip_load / (2 * result.half_width))
    on_roll = result.air.nip_film * (p_a + tension / problem.roll.radius)
    assert on_roll == pytest.approx(in_nip, rel=1e-9)


def test_trends_that_every_winder_knows(film_nip, with_air):
    def film(**changes):
        return wo.solve(film_nip.replace(**changes), nodes=33).air.nip_film

    assert film(web_speed=2.0) > with_air.air.nip_film  # faster: more air
    heavier = film(**{"nip_load": 600.0})
    assert heavier < with_air.air.nip_film  # a heavier nip excludes more
    harder = film(**{"drum.material.youngs_modulus": 6e6})
    assert harder < with_air.air.nip_film  # so does a harder cover
    assert with_air.air.nip_film < with_air.air.foil_film / 10  # and any nip does, next to none


def test_a_film_without_friction_is_reported(film_nip):
    with pytest.warns(wo.ValidityWarning, match="do not touch, and the nip adds no tension"):
        fast = wo.solve(film_nip.replace(web_speed=5.0), nodes=33)
    assert fast.nip_induced_tension < 0.01
    T_in = fast.problem.web_tension
    assert fast.wound_on_tension == pytest.approx(T_in, rel=1e-4)  # friction 1e-6 is left


def test_paper_lets_the_air_through(film_nip, with_air):
    air = film_nip.air.replace(permeance=1e-6)
    paper = wo.solve(film_nip.replace(air=air), nodes=33)
    assert paper.air.film == 0
    assert with_air.air.film == with_air.air.nip_film
    assert paper.layer_friction(0.0) == film_nip.roll_friction


# ---- the winding ---------------------------------------------------------------------------------


# trends and laws are looked at here, not digits
COARSE = {"nodes": 25, "rtol": 0.05}


@pytest.fixture(scope="module")
def winding(film_nip):
    stack = wo.Stack(
        radial=wo.Pfeiffer(K1=5e3, K2=100.0), tangential=5e9, poissons_ratio=0.01, shear=10e6
    )
    return wo.WindingProblem(
        web=film_nip.web, stack=stack, core=wo.Core(radius=0.05, stiffness=2e9), radius=0.2,
        roll_body="linear", drum=film_nip.drum, roll_friction=0.25, drum_friction=0.4,
        web_tension=100.0, nip_load=300.0,
    )  # fmt: skip


def wind(problem, speed):
    air = wo.Air(roughness=0.3e-6)
    return wo.solve(problem.replace(web_speed=speed, air=air), **COARSE)


@pytest.fixture(scope="module")
def windings(winding):
    return {speed: wind(winding, speed) for speed in (0.0, 2.0, 4.0)}


@pytest.mark.slow
def test_a_winding_at_rest_has_no_air(winding, windings):
    dry, still = wo.solve(winding, **COARSE), windings[0.0]
    within = dry.coupling_rtol  # of nips and roll, which a last turn for the film's sake may better
    np.testing.assert_allclose(still.wound_on_tension, dry.wound_on_tension, rtol=within)
    largest = dry.roll.pressure.max()
    np.testing.assert_allclose(still.roll.pressure, dry.roll.pressure, atol=within * largest)
    assert still.margins["slip"].value == pytest.approx(dry.margins["slip"].value, rel=within)


@pytest.mark.slow
def test_speed_softens_the_roll_and_takes_its_slip_margin(windings):
    still, fast, faster = windings.values()
    assert still.air_film == 0
    for slow, quick in ((still, fast), (fast, faster)):
        assert slow.air_film < quick.air_film
        assert slow.mid_pressure > quick.mid_pressure
        assert slow.length > quick.length  # less web on the same radius
        assert slow.margins["slip"].value < quick.margins["slip"].value
    assert (faster.nip_friction <= fast.nip_friction + 1e-6).all()
    # the laps below the surface float: nothing carries the core's torque there
    assert fast.margins["slip"].value < 1 < faster.margins["slip"].value


@pytest.mark.slow
def test_the_roll_holds_the_air_that_its_nips_let_through(windings):
    fast = windings[2.0]
    assert fast.residual < 1e-8
    assert fast.roll.problem.web_thickness == fast.problem.web.thickness + fast.air_film
    assert replace(fast, air_film=fast.air_film * 1.01).certified().air > 1e-8
    again = replace(fast, wound=None)  # as from a file
    assert again.mid_pressure == pytest.approx(fast.mid_pressure, rel=1e-12)


@pytest.mark.slow
def test_friction_of_a_winding_is_that_which_the_film_leaves(windings):
    """And nips that are solved again tell friction and film from values 0.1 % larger."""
    fast = windings[2.0]
    left = [sample.result.air.roll_friction for sample in fast.nips]
    np.testing.assert_array_equal(fast.nip_friction, left)
    assert fast.nip_friction.min() < 0.9 * fast.problem.roll_friction
    again = fast.recomputed_nips()
    for name in ("nip_friction", "nip_air_film"):
        value, within = again[name]
        assert np.isclose(getattr(fast, name), value, rtol=1e-9, atol=within).all(), name
        assert not np.isclose(1.001 * getattr(fast, name), value, rtol=1e-9, atol=within).any()


# ---- the roll ------------------------------------------------------------------------------------


def law(film=2e-6, inner=None):
    inner = inner or wo.Pfeiffer(K1=500.0, K2=400.0)
    return wo.AirBetween(law=inner, film=film, web_thickness=23e-6)


@pytest.mark.parametrize("P", [10.0, 1e3, 1e5])
def test_the_law_of_a_stack_with_air_is_one_law(P):
    step = 1e-4 * P
    between = law()
    rise = 2 * step / (between.strain_at(P + step) - between.strain_at(P - step))
    # of differences: rounding 1e-16/1e-4 against the third derivative's 1e-8
    assert between.modulus(P) == pytest.approx(rise, rel=1e-6)
    bend = (between.modulus(P + step) - between.modulus(P - step)) / (2 * step)
    assert between.modulus_slope(P) == pytest.approx(bend, rel=1e-6)
    assert between.pressure_at(between.strain_at(P)) == pytest.approx(P, rel=1e-9)


def test_air_between_rigid_layers_is_boyles_law():
    stiff = law(film=23e-6, inner=1e12)
    # half of the thickness is air; a second atmosphere halves it
    assert stiff.strain_at(AMBIENT) == pytest.approx(0.25, rel=1e-6)
    assert law(film=0.0).modulus(1e5) == pytest.approx(400 * (500 + 1e5), rel=1e-12)


def test_air_softens_the_roll_and_leaves_its_web(film_nip, with_air):
    roll = wo.RollProblem(
        core=wo.Core(radius=0.05, stiffness=2e9), radius=0.2, web_thickness=23e-6, density=1390.0,
        wound_on_tension=100.0, stack=wo.Stack(radial=wo.Pfeiffer(K1=500.0, K2=400.0),
        tangential=5e9, poissons_ratio=0.01, shear=10e6),
    )  # fmt: skip
    dry, airy = wo.solve(roll), wo.solve(with_air.wound(roll))
    assert airy.mid_pressure < 0.9 * dry.mid_pressure
    # the same side of the roll, less web on it: its mass goes with its length
    assert airy.mass / dry.mass == pytest.approx(airy.length / dry.length, rel=1e-12)
    assert airy.length < dry.length
    assert_rejected(
        lambda: with_air.wound(roll.replace(web_thickness=24e-6)), "web_thickness: 2.4e-05"
    )


def test_a_viscoelastic_drum_takes_its_speed_from_the_web(film_nip):
    prony = [(1e6, 1e-3)]
    rubber = wo.Isotropic(youngs_modulus=3e6, poissons_ratio=0.48, prony=prony)
    problem = film_nip.replace(**{"drum.material": rubber})
    result = wo.solve(problem, nodes=33)
    assert result.residuals.largest < 1e-8
    assert result.without_air.web_speed == problem.web_speed
    assert wo.solve(result.without_air, nodes=33).dissipated_power > 0
    # stiffer at the inlet than relaxed, softer than at once
    soft, hard = (film_nip.replace(**{"drum.material.youngs_modulus": E}) for E in (3e6, 4e6))
    at = result.air.inlet_length
    assert _compliance(soft, at) > _compliance(problem, at) > _compliance(hard, at)
