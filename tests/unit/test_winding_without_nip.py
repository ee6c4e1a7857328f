"""Winding without a nip: the tension of the web, the film of a foil bearing, thick films."""

from __future__ import annotations

import tomllib
from typing import Any

import numpy as np
import pytest
from slow_cases import campaign_case

import woundon as wo
from woundon.io.case_files import make_problem
from woundon.io.case_texts import to_toml
from woundon.report.result_panels import panels_of

EXAMPLE = wo.WindingProblem.example()
ALONE = EXAMPLE.replace(radius=0.15, nip_load=0.0, drum=None, drum_friction=None)
AIR = wo.Air(roughness=0.5e-6)


def random_film(seed: int) -> wo.WindingProblem:
    """Return a film wound without a nip, with its air: from a tenth to five times its thickness."""
    rng = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(low * (high / low) ** rng.random())

    core, thickness, T = between(0.03, 0.15), between(8e-6, 200e-6), between(40.0, 400.0)
    radius = core * between(1.5, 6.0)
    law = [
        T,
        wo.Taper(start=T, taper=float(rng.uniform(0, 0.6))),
        wo.Taper(start=T, law="power", exponent=float(rng.uniform(0, 0.6))),
        wo.Steps(value=[T, 0.8 * T], depth=[(radius - core) / 3]),
    ][seed % 4]
    ratio = between(0.1, 5.0)
    # the speed for which the film at two thirds of the surface has this ratio to the thickness
    speed = (ratio * thickness / (0.643 * 0.67 * radius)) ** 1.5 * T / (12 * 1.81e-5)
    modulus = between(1e9, 6e9)
    return wo.WindingProblem(
        web=wo.Web(thickness=thickness, material=wo.Isotropic(
            youngs_modulus=modulus, poissons_ratio=0.3)),
        stack=wo.Stack(radial=wo.Pfeiffer(K1=between(3e3, 1e5), K2=between(20.0, 200.0)),
                       tangential=modulus, poissons_ratio=0.01, shear=1e7),
        core=wo.Core(radius=core, stiffness=between(1e8, 1e11)), radius=radius,
        roll_friction=0.3, web_tension=law, nip_load=0.0, web_speed=min(speed, 200.0),
        air=wo.Air(roughness=min(1e-6, thickness / 10)),
    )  # fmt: skip


def mean_film(problem: wo.WindingProblem) -> float:
    """Return h = 0.643 r (12 eta V/T)^(2/3), weighted by the length of web, by Gauss points."""
    x, weights = np.polynomial.legendre.leggauss(12)
    cuts = np.union1d(np.linspace(*problem.ends, 40), list(problem.kinks))
    r = cuts[:-1, None] + np.diff(cuts)[:, None] * (1 + x) / 2
    w = np.diff(cuts)[:, None] * weights / 2 * r
    T = problem.at("web_tension", r)
    film = 0.643 * r * (12 * problem.air.viscosity * problem.web_speed / T) ** (2 / 3)
    return float((w * film).sum() / w.sum())


@pytest.mark.parametrize("seed", [*range(4), *(campaign_case(k) for k in range(4, 100))])
@pytest.mark.filterwarnings("ignore::woundon.ValidityWarning")
def test_random_films_have_the_film_of_the_formula(seed: int):
    """100 random films, half of them with more air than web; none is refused."""
    problem = random_film(seed)
    result = wo.solve(problem, rtol=1e-2)
    # 0.643 has three digits, of the constant 0.64304; trapezoids over 2049 radii: below 1e-6
    assert result.air_film == pytest.approx(mean_film(problem), rel=1e-4)
    assert result.nip_radius.size == 0
    np.testing.assert_array_equal(result.wound_on_tension, result.web_tension)
    assert result.core_pressure > 0


def test_a_film_thicker_than_the_web():
    problem = ALONE.replace(web_speed=20.0, air=AIR, web_tension=100.0)
    result = wo.solve(problem)
    R, core = problem.radius, problem.core.radius
    pressing = 100 - 680 * 66e-6 * 20**2  # T - m V^2
    at_surface = 0.64304 * R * (12 * 1.81e-5 * 20 / pressing) ** (2 / 3)
    # h is proportional to r: mean over r dr
    mean = at_surface / R * 2 / 3 * (R**3 - core**3) / (R**2 - core**2)
    assert result.air_film == pytest.approx(mean, rel=1e-6)  # trapezoids over 2049 radii
    assert result.air_film > problem.web.thickness
    layers = result.roll.length / (np.pi * (R + core))
    assert layers == pytest.approx((R - core) / (66e-6 + mean), rel=1e-3)
    assert result.certified().largest < 1e-8
    wrong = result.replace(air_film=1.001 * mean)
    assert wrong.certified().air > 1e-8


def test_paper_lets_the_film_escape():
    dense = ALONE.replace(web_speed=20.0, air=AIR)
    porous = dense.replace(**{"air.permeance": 1e-6})
    assert wo.solve(dense, rtol=1e-2).air_film > 20e-6
    assert wo.solve(porous, rtol=1e-2).air_film == 0.0


@pytest.mark.parametrize("law", ["nip", "friction"])
def test_the_roll_is_that_of_the_web_tension(law: str):
    """Without a nip the winding is a RollProblem with WOT = T_in."""
    winding = wo.solve(ALONE.replace(tension_law=law))
    roll = wo.solve(ALONE.wound_roll(ALONE.web_tension))
    # both to the tolerance of the roll, rtol 1e-3
    assert winding.core_pressure == pytest.approx(roll.core_pressure, rel=2e-3)
    assert not winding.nip_induced_tension.any()
    share = winding.margins["slip"].value
    assert 0 < share < 1


def test_as_the_nip_load_vanishes_the_tension_is_that_without_a_nip():
    pressed = wo.solve(EXAMPLE.replace(radius=0.15, nip_load=1e-3, tension_law="friction"))
    alone = wo.solve(ALONE)
    assert pressed.core_pressure == pytest.approx(alone.core_pressure, rel=1e-5)  # mu P/T: 5e-7


def test_a_case_file_gives_the_problem_back():
    text = to_toml(ALONE)
    assert "[drum]" not in text
    assert "drum_friction" not in text
    assert make_problem(tomllib.loads(text)) == ALONE
    kept = ALONE.replace(drum=wo.Rigid(radius=0.3))
    assert any("drum is not used" in warning for warning in kept.input_warnings)
    assert "drum" in kept.unused
    assert {"drum", "drum_friction"} <= set(kept.unused)


@pytest.mark.parametrize("ending", ["json", "nc"])
def test_a_roll_whose_layers_carry_no_friction_comes_back_from_a_file(tmp_path, ending: str):
    """Its margin of slip is -inf, which no file holds."""
    problem = ALONE.replace(radius=0.1, web_tension=350.0, web_speed=5.0, air=AIR)
    result = wo.solve(problem, rtol=1e-2)
    assert result.margins.slip == -np.inf
    result.save(tmp_path / f"roll.{ending}")
    assert wo.load_result(tmp_path / f"roll.{ending}") == result


def test_the_report_and_the_panels_name_no_drum():
    limits = wo.Limits(blocking_pressure=1e3, web_strength=100.0, yield_strain=1e-4)
    result = wo.solve(ALONE.replace(width=2.0, web_speed=10.0, air=AIR, limits=limits), rtol=1e-2)
    text = " ".join(str(result).split())
    assert all(margin.hint in text for margin in result.margins if margin.ok is False)
    assert "wound without a nip" in text
    assert "Trade rule" not in text
    margins = text.partition("Margins")[2].partition("Assumptions")[0]
    for words in ("the drum", "a drum", "the nip", "of nip", "nip load"):
        assert words not in margins
    assert not any(words in text for words in ("winding force", "torque of the drum", "NIT"))
    assert result.drum_drive is None
    assert result.core_drive.torque[-1] > 0
    panels = panels_of(result)
    assert "loads" not in panels
    assert [curve.name for curve in panels["tension"].make(result).curves] == ["wound_on_tension"]


@pytest.mark.parametrize(
    "changes",
    [{"nip_load": 2000.0}, {"winding_force": 10.0}, {"torque_split": 1.0}, {"nip_load": None}],
)
def test_what_needs_a_drum_is_rejected_without_one(changes: dict[str, Any]):
    with pytest.raises(wo.InvalidProblem) as fault:
        ALONE.replace(**changes)
    names = {name for name, _ in fault.value.faults}
    assert names <= {"drum", "drum_friction", *changes}


def test_a_winder_without_a_rear_drum_names_it_once():
    winder = wo.TwoDrums(front_drum=wo.Rigid(radius=0.25), gap=0.02, rider_load=2500.0)
    with pytest.raises(wo.InvalidProblem) as fault:
        ALONE.replace(winder=winder)
    names = [name for name, _ in fault.value.faults]
    assert names.count("drum") == names.count("drum_friction") == 1
