"""How dense a wound roll is: one mass, counted in three ways; what roll people draw."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from coarse_solutions import coarse_solution
from slow_cases import slow_case

import woundon as wo

NEWSPRINT = wo.RollProblem.example()
ROLLS = {
    "newsprint": NEWSPRINT,
    "taper": NEWSPRINT.replace(wound_on_tension=wo.Taper(start=350.0, taper=0.4)),
    "kink": NEWSPRINT.replace(
        wound_on_tension=wo.Profile(radius=[0.0445, 0.08, 0.15], value=[350.0, 200.0, 250.0])
    ),
    "cooled": NEWSPRINT.replace(
        temperature_change=-20.0, radial_expansion=5e-5, tangential_expansion=1e-5
    ),
    "stiff": NEWSPRINT.replace(stack=NEWSPRINT.stack.replace(radial=40e6)),
}
rolls = pytest.mark.parametrize(
    "name", ["newsprint", "taper", slow_case("kink"), slow_case("cooled"), "stiff"]
)


@cache
def wound(name: str) -> wo.RollResult:
    return wo.solve(ROLLS[name], rtol=1e-5)


@rolls
def test_the_mass_is_that_laid(name: str):
    """Density over the volume of the finished roll against the mass laid stage by stage."""
    result = wound(name)
    place = np.pi * (result.radius + result.displacement) ** 2
    summed = np.trapezoid(result.density, place)
    assert summed == pytest.approx(result.wound_mass, rel=3e-5)  # of the trapezoids
    assert summed / (place[-1] - place[0]) == pytest.approx(result.mean_density, rel=3e-5)
    laid = np.trapezoid(result.density_as_wound, np.pi * result.radius**2)
    assert laid == pytest.approx(result.wound_mass, rel=1e-3)  # steep at the core


@rolls
def test_a_piece_of_the_roll_has_the_density_of_its_strains(name: str):
    """By the law of the stack alone, which knows nothing of kappa and stages."""
    result, problem = wound(name), ROLLS[name]
    stack = problem.stack
    through = -stack.radial.strain_at(result.pressure) - (
        stack.poissons_ratio / stack.tangential * result.hoop_stress
    )
    through += problem.radial_expansion * problem.temperature_change
    by_strains = problem.density / ((1 + through) * (1 + result.layer_strain))
    # equal but for squares of the strains, of up to 9 %
    miss = np.abs(result.density / by_strains - 1)
    assert miss.max() < np.max(np.abs(through)) ** 2 + 1e-5
    assert miss.max() < 0.1 * np.max(np.abs(result.density / problem.density - 1))


def test_under_the_caliper_pressure_the_web_has_its_own_density():
    """The thickness and the density of the web are those under the caliper pressure."""
    wound = coarse_solution(NEWSPRINT)
    pressure = wound.mid_pressure
    result = wo.solve(NEWSPRINT.replace(caliper_pressure=pressure))
    middle = (result.radius[0] + result.radius[-1]) / 2
    density = np.interp(middle, result.radius, result.density)
    strain = NEWSPRINT.stack.radial.strain_at(pressure)
    # but for squares of the strains, and the strain along the web, of 0.16 %
    assert density == pytest.approx(680.0, rel=strain**2)
    assert np.interp(middle, wound.radius, wound.density) > (1 + strain) * 680.0 * (1 - strain**2)
    # lengths, masses and layers decrease by one factor, pressures do not depend on it
    for name in ("length", "wound_length", "layer_count", "mass", "wound_mass", "mean_density"):
        assert getattr(result, name) == pytest.approx(getattr(wound, name) * (1 - strain)), name
    assert result.pressure == pytest.approx(wound.pressure)


def test_the_two_lengths_of_a_roll_are_those_of_its_masses():
    """The mass per area of the web is rho h, whatever the caliper pressure."""
    for pressure in (None, 50e3):
        roll = wo.solve(NEWSPRINT.replace(caliper_pressure=pressure))
        per_area = NEWSPRINT.density * NEWSPRINT.web_thickness
        assert roll.mass == pytest.approx(roll.length * per_area)
        assert roll.wound_mass == pytest.approx(roll.wound_length * per_area)
        text = " ".join(str(roll).split())
        assert "length of web, counted in layers without pressure L" in text
        assert "length of web, its layers compressed as wound L_w" in text
        without = "that without pressure, as caliper_pressure is not given"
        assert (without in text) == (pressure is None)


def test_an_air_film_is_added_to_the_thickness_without_pressure():
    """The caliper of the web is measured without the film, that of the film at no pressure."""
    stack = NEWSPRINT.stack
    law = wo.AirBetween(law=stack.radial, film=3e-6, web_thickness=66e-6)
    airy = NEWSPRINT.replace(
        stack=stack.replace(radial=law), web_thickness=69e-6, caliper_pressure=1e5
    )
    dry = NEWSPRINT.replace(caliper_pressure=1e5)
    assert airy.unloaded_thickness == pytest.approx(dry.unloaded_thickness + 3e-6)


def test_layers_without_tension_are_as_dense_as_the_web():
    thin = wo.solve(NEWSPRINT.replace(wound_on_tension=1e-3))
    assert thin.mean_density == pytest.approx(680.0, rel=1e-4)
    assert thin.wound_mass == pytest.approx(thin.mass, rel=1e-4)


def test_a_tighter_roll_is_denser_and_without_a_density_none_is_reported():
    tight = wo.solve(NEWSPRINT.replace(wound_on_tension=500.0))
    assert tight.mean_density > coarse_solution(NEWSPRINT).mean_density > 680.0
    untold = wo.solve(NEWSPRINT.replace(density=None))
    assert np.isnan([untold.mean_density, untold.wound_mass, *untold.density]).all()
    assert "density" not in str(untold)
    assert "density" not in _panels(untold)


def _panels(result: wo.RollResult) -> list[str]:
    from woundon.report.roll_panels import roll_panels

    return [name for name, panel in roll_panels(result).items() if panel.by_default]
