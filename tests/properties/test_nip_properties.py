"""What holds for every winding nip, on random admissible ones, to 1e-8.

The program solves to 3e-9 of the load and 1e-11 of each law: 1e-8 is what its certificate asks.

Of mirrors: the rolling direction is not reversible (friction remembers what comes from upstream),
and the wound-on condition tells the roll from the drum, so a nip has no mirror of its own.  What
holds is the mirror of its normal problem, and there the two bodies may change places as well.  The
mirrors of two rollers are in test_roller_properties.py.
"""

from __future__ import annotations

from math import log10, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import woundon as wo
from woundon.elasticity import strip
from woundon.elasticity.mesh import Wrap, nip_mesh
from woundon.nip.load_limit import frictionless_pressure
from woundon.problems.bodies import half_width_guess


def between(low: float, high: float) -> st.SearchStrategy[float]:
    """Draw evenly in the logarithm."""
    return st.floats(log10(low), log10(high)).map(lambda exponent: 10.0**exponent)


@st.composite
def papers(draw: Any) -> wo.Orthotropic:
    """Soft through the thickness, stiff along the web."""
    radial, tangential = draw(between(2e6, 2e8)), draw(between(3e8, 1e10))
    return wo.Orthotropic(
        radial=radial,
        tangential=tangential,
        cross=draw(st.floats(0.0, 0.6)) * min(radial, sqrt(radial * tangential), 4e7),
        shear=draw(between(1e6, 2e8)),
    )


@st.composite
def drums(draw: Any) -> wo.Rigid | wo.HalfPlane | wo.Cylinder:
    """Hard, half-plane, or covered with 2 to 40 mm, foam to nearly incompressible rubber."""
    radius = draw(between(0.06, 1.0))
    kind = draw(st.sampled_from(["rigid", "half-plane", "covered"]))
    if kind == "rigid":
        return wo.Rigid(radius=radius)
    material = wo.Isotropic(
        youngs_modulus=draw(between(5e5, 3e9)), poissons_ratio=draw(st.floats(0.0, 0.499))
    )
    if kind == "half-plane":
        return wo.HalfPlane(radius=radius, material=material)
    core = radius - draw(between(2e-3, 0.04))
    return wo.Cylinder(radius=radius, core_radius=core, material=material)


@st.composite
def admissible_nips(draw: Any) -> wo.NipProblem:
    """Any nip with a steady state, within and beyond what winders do."""
    paper, radius = draw(papers()), draw(between(0.06, 1.0))
    core = draw(st.floats(0.1, 0.9)) * radius
    roll = draw(
        st.sampled_from([
            wo.HalfPlane(radius=radius, material=paper),
            wo.Cylinder(radius=radius, core_radius=core, material=paper),
        ])
    )  # fmt: skip
    nip_load, drum_friction = draw(between(100.0, 2e4)), draw(between(0.05, 0.8))
    return wo.NipProblem(
        web=wo.Web(thickness=draw(between(10e-6, 200e-6)), material=paper),
        roll=roll,
        drum=draw(drums()),
        roll_friction=draw(between(0.05, 0.8)),
        drum_friction=drum_friction,
        nip_load=nip_load,
        winding_force=draw(st.floats(-0.95, 0.95)) * drum_friction * nip_load,
        web_tension=draw(st.floats(0.0, 1000.0)),
        roll_wrap=0.0,
    )


def curves(result: wo.NipResult) -> dict[str, np.ndarray]:
    """The state over x/a, tractions by the largest pressure, slips by the largest slip."""
    top = np.max(result.drum_pressure)
    slip = np.max(np.abs([result.roll_slip, result.drum_slip]))
    return {
        "pressure": result.drum_pressure / top,
        "roll_traction": result.roll_traction / top,
        "drum_traction": result.drum_traction / top,
        "roll_slip": result.roll_slip / slip,
        "drum_slip": result.drum_slip / slip,
    }


def assert_same_state(one: wo.NipResult, other: wo.NipResult) -> None:
    for name, values in curves(one).items():
        np.testing.assert_allclose(curves(other)[name], values, rtol=0, atol=1e-8, err_msg=name)
    shown = curves(one)
    for face, mu in (("roll", one.problem.roll_friction), ("drum", one.problem.drum_friction)):
        differs = getattr(one, f"{face}_zone") != getattr(other, f"{face}_zone")
        # where slip and slack are both zero, either zone is right
        slack = mu * shown["pressure"] - np.abs(shown[f"{face}_traction"])
        assert np.all(np.abs(shown[f"{face}_slip"][differs]) <= 1e-8)
        assert np.all(np.abs(slack[differs]) <= 1e-8 * mu)


# ---- laws ---------------------------------------------------------------------------------------


@settings(max_examples=30)
@given(admissible_nips())
def test_every_solution_keeps_every_law(problem: wo.NipProblem) -> None:
    """Checked on the returned curves, next to the certificate."""
    result = wo.solve(problem)
    assert result.residuals.largest <= 1e-8
    p, top = result.drum_pressure, np.max(result.drum_pressure)
    assert np.all(p[1:-1] > 0)
    for q, slip, zone, mu in (
        (result.roll_traction, result.roll_slip, result.roll_zone, problem.roll_friction),
        (result.drum_traction, result.drum_slip, result.drum_zone, problem.drum_friction),
    ):
        assert np.all(np.abs(q) <= mu * p + 1e-8 * mu * top)
        slips = zone != wo.Zone.STICK
        np.testing.assert_allclose(q[slips], (zone * mu * p)[slips], rtol=0, atol=1e-8 * mu * top)
        inner = slice(1, -1)  # the end nodes repeat their neighbours' zone
        unit = np.max(np.abs(slip)) or 1.0
        assert np.all((zone * slip)[inner][slips[inner]] >= -1e-8 * unit)
        assert np.all(np.abs(slip[inner][~slips[inner]]) <= 1e-8 * unit)


@settings(max_examples=20)
@given(admissible_nips())
def test_equilibrium_and_the_bounds_of_the_added_tension(problem: wo.NipProblem) -> None:
    """NIT = Q+ + F with |Q+| <= mu+ P, whatever the contact does, as the mesh has it and beyond."""
    result = wo.solve(problem)
    P, F, T_in = problem.nip_load, problem.winding_force, problem.web_tension
    x, NIT = result.x, result.nip_induced_tension
    assert np.trapezoid(result.drum_pressure, x) == pytest.approx(P, rel=1e-8)
    assert np.trapezoid(result.drum_traction, x) == pytest.approx(F, abs=1e-8 * P)
    total = np.trapezoid(result.roll_traction, x) + F
    assert pytest.approx(total, abs=1e-8 * P) == NIT
    assert abs(NIT - F) <= problem.roll_friction * P * (1 + 1e-8)
    assert result.tension[0] == T_in
    assert result.tension[-1] == pytest.approx(T_in + total, abs=1e-8 * P)
    assert result.outlet_tension == pytest.approx(T_in + NIT, abs=1e-10 * P)


@pytest.mark.parametrize("share", [0.3, -0.12])
@pytest.mark.parametrize("distance", [1e-9, 1e-10, 3e-11, 1e-12])
def test_a_drum_that_nearly_slides_is_solved_and_continuous(share: float, distance: float) -> None:
    """Up to the friction capacity, F = mu- P (1 - distance), without a neighbour's solution.

    The last node that sticks carries less than the rounding error of its neighbours' friction.
    """
    nip = wo.NipProblem.example().replace(web_tension=2000.0, drum_friction=abs(share))
    limit = nip.nip_load * share
    results = [wo.solve(nip.replace(winding_force=limit * (1 - d)), nodes=33)
               for d in (1e-7, distance)]  # fmt: skip
    for output in ("half_width", "wound_on_tension", "drum_creepage", "offset"):
        one, other = (getattr(result, output) for result in results)
        assert other == pytest.approx(one, rel=1e-5), output
    assert results[1].residuals.largest <= 1e-8


# ---- the winding theorem ------------------------------------------------------------------------


@settings(max_examples=12)
@given(admissible_nips(), st.floats(0.0, 5000.0))
def test_the_winding_theorem(problem: wo.NipProblem, T_in: float) -> None:
    """T_in changes only the drum's creep and the approach, these exactly by eq. (171)."""
    other = problem.replace(web_tension=T_in)
    # the default mesh depends on the wound-on tension
    one, two = (wo.solve(of, nodes=65) for of in (problem, other))
    assert_same_state(one, two)
    P, more = problem.nip_load, T_in - problem.web_tension
    assert two.nip_induced_tension == pytest.approx(one.nip_induced_tension, abs=1e-8 * P)
    assert two.half_width == pytest.approx(one.half_width, rel=1e-8)
    assert two.offset == pytest.approx(one.offset, abs=1e-8 * one.half_width)
    np.testing.assert_allclose(two.tension - one.tension, more, rtol=0, atol=1e-8 * P)
    c = strip.compliance(*problem.web.material.stiffness[:3])
    creep = -c.c11 / problem.web.thickness * more
    assert two.drum_creepage - one.drum_creepage == pytest.approx(creep, rel=1e-8, abs=1e-12)
    # c12 < 0: a tauter web is thinner, the centres come closer
    thinner = -c.c12 * more
    span = max(abs(one.approach), abs(two.approach), abs(thinner))
    assert two.approach - one.approach == pytest.approx(thinner, abs=1e-8 * span)


# ---- scaling ------------------------------------------------------------------------------------


def scaled_body(body: Any, length: float, stress: float) -> Any:
    fields = {"radius": body.radius * length}
    if not isinstance(body, wo.Rigid):
        fields["material"] = scaled_material(body.material, stress)
    if isinstance(body, wo.Cylinder):
        fields["core_radius"] = body.core_radius * length
    return body.replace(**fields)


def scaled_material(material: Any, stress: float) -> Any:
    names = ("radial", "tangential", "cross", "shear", "youngs_modulus")
    return material.replace(
        **{name: getattr(material, name) * stress for name in names if hasattr(material, name)}
    )


def scaled(problem: wo.NipProblem, length: float, stress: float) -> wo.NipProblem:
    load, web = length * stress, problem.web
    return problem.replace(
        web=wo.Web(
            thickness=web.thickness * length, material=scaled_material(web.material, stress)
        ),
        roll=scaled_body(problem.roll, length, stress),
        drum=scaled_body(problem.drum, length, stress),
        nip_load=problem.nip_load * load,
        winding_force=problem.winding_force * load,
        web_tension=problem.web_tension * load,
    )


@settings(max_examples=12)
@given(admissible_nips(), st.floats(0.3, 3.0), st.floats(0.1, 10.0))
def test_scaling(problem: wo.NipProblem, length: float, stress: float) -> None:
    """All lengths and loads by one factor, all moduli and loads by another: the same state."""
    one, two = wo.solve(problem), wo.solve(scaled(problem, length, stress))
    assert_same_state(one, two)
    load, P = length * stress, problem.nip_load
    assert two.nip_induced_tension / load == pytest.approx(one.nip_induced_tension, abs=1e-8 * P)
    assert two.half_width / length == pytest.approx(one.half_width, rel=1e-8)
    assert two.offset / length == pytest.approx(one.offset, abs=1e-8 * one.half_width)
    assert two.drum_creepage == pytest.approx(one.drum_creepage, rel=1e-8, abs=1e-12)
    for ratio in ("leading_roll", "trailing_roll", "dual"):
        # borders within a cell follow from slips, roots of differences of 1e-8
        assert getattr(two, ratio) == pytest.approx(getattr(one, ratio), abs=1e-6)
    if not (isinstance(problem.roll, wo.HalfPlane) or isinstance(problem.drum, wo.HalfPlane)):
        # with a half-plane the approach holds up to a constant, which a change of unit shifts
        assert two.approach / length == pytest.approx(one.approach, rel=1e-8, abs=1e-12)


# ---- the mirror of the normal problem -----------------------------------------------------------


@settings(max_examples=20)
@given(admissible_nips())
def test_the_normal_problem_mirrors(problem: wo.NipProblem) -> None:
    """x -> -x leaves the pressure without friction as it is, and so does exchanging the bodies."""
    face = nip_mesh(41, Wrap(), Wrap()).roll_face
    widest = 0.3 * min(body.radius for body in problem.bodies)
    a = min(half_width_guess(problem.nip_load, *problem.bodies), widest)
    exchanged = problem.replace(roll=problem.drum, drum=problem.roll)
    one, two = (frictionless_pressure(of, face, a) for of in (problem, exchanged))
    small = 1e-8 * np.max(np.abs(one))
    np.testing.assert_allclose(one[::-1], one, rtol=0, atol=small)
    np.testing.assert_allclose(two, one, rtol=0, atol=small)


@settings(max_examples=20)
@given(admissible_nips())
def test_the_response_to_tractions_mirrors(problem: wo.NipProblem) -> None:
    """Under x -> -x the slope by a traction is even and the strain by a traction is odd."""
    face = nip_mesh(25, Wrap(), Wrap()).roll_face
    a, none = 0.01 * problem.roll.radius, np.zeros(25)
    surface = problem.roll.surface(face, a)
    made = surface.tangent(none, none)
    for part, sign in zip(made, (-1, 1, 1, -1), strict=True):
        inner = part[:-2, 1:-1]
        small = 1e-8 * np.max(np.abs(inner))
        np.testing.assert_allclose(inner[::-1, ::-1], sign * inner, rtol=0, atol=small)
