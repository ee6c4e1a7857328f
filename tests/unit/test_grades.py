"""Grades: sources and spreads of all values, plausible rolls, cases with a grade, own grades."""

from __future__ import annotations

import math
import re
import tomllib
import warnings
from contextlib import contextmanager

import numpy as np
import pytest
from slow_cases import slow_case

import woundon as wo
from woundon.io.case_files import apply_settings, load_case, make_problem, to_toml
from woundon.io.case_texts import grade_template
from woundon.problems.free_strains import OF_WEB
from woundon.problems.library import library
from woundon.problems.materials import MATERIALS
from woundon.problems.units import parse

GRADES = wo.grades()
CORE = {"diameter": "100 mm", "stiffness": "1 GPa"}
# Bulky grades are wound to pressures at which they keep their bulk.
BULKY = {"tissue", "nonwoven-20"}


@contextmanager
def no_input_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error", wo.InputWarning)
        yield


# ---- values -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", GRADES)
def test_every_value_has_a_source_and_a_spread(name):
    grade = GRADES[name]
    names = {name for name, _ in grade.texts()}
    assert len(names - set(OF_WEB)) == 20
    assert all(grade.sources[each] for each in names)
    spread = {each for each in names if not each.startswith("limits.")} - {"pressure"}
    assert spread == grade.spread.keys()
    assert all(0 < value < 1 for value in grade.spread.values())


def test_sources_are_listed_or_marked_typical():
    tables = library("grades") | library("materials")
    known = ("typical", "nominal", "handbook", *tables["sources"])
    entries = [value for group in ("grades", "covers") for table in tables[group].values()
               for value in (*table.values(), *table.get("limits", {}).values())
               if isinstance(value, dict) and "value" in value]  # fmt: skip
    assert len(entries) > 300
    assert all(entry["source"].startswith(known) for entry in entries)
    used = " ".join(entry["source"] for entry in entries)
    assert all(name in used for name in tables["sources"])


@pytest.mark.parametrize("name", GRADES)
def test_values_agree_with_each_other(name):
    grade = GRADES[name]
    # A fifth of the strength, at least: webs break far below it.
    assert grade.tension < 0.4 * grade.limits.web_strength
    assert grade.limits.slack_tension < 0.3 * grade.tension
    assert grade.roll_radial == pytest.approx(
        grade.stack.radial.modulus(0.6e6 if name not in BULKY else 40e3), rel=0.5
    )
    assert grade.roughness < grade.thickness / 5
    assert grade.web().material.tangential == grade.stack.tangential


@pytest.mark.parametrize(
    "name", [name if k % 3 == 0 else slow_case(name) for k, name in enumerate(GRADES)]
)
def test_a_wound_roll_has_a_usual_pressure(name):
    grade = GRADES[name]
    roll = wo.RollProblem(grade=grade, core=CORE, diameter="1 m", wound_on_tension=grade.tension)
    result = wo.solve(roll)
    low, high = grade.pressure
    inner = 0.05 + 0.3 * 0.45
    halfway = float(np.interp(inner, result.radius, result.pressure))
    assert low <= result.pressure[0] <= high
    assert low <= halfway <= high
    if name not in BULKY:
        assert low >= 70e3
        assert high <= 700e3
    assert result.pressure.max() < grade.limits.blocking_pressure
    assert -result.hoop_stress.min() < grade.limits.compression


# ---- grades in cases ----------------------------------------------------------------------------


def test_a_nip_of_a_grade():
    with no_input_warning():
        nip = wo.NipProblem(
            grade="newsprint", roll={"radius": 0.1, "core_radius": 0.0445},
            drum=wo.Rigid(radius=0.0762), nip_load=3502.0, web_tension=350.0,
        )  # fmt: skip
        assert nip == wo.NipProblem.example().replace(density=680.0)
        assert not nip.input_warnings
    newsprint = wo.grade("newsprint")
    assert newsprint.material == wo.material("newsprint")
    assert newsprint.roll("200 mm", "89 mm") == wo.Cylinder(
        diameter=0.4, core_diameter=0.178, material="newsprint"
    )
    assert newsprint.roll(0.1, 0.0445, pressure="200 kPa").stack == newsprint.stack


@pytest.mark.parametrize("name", GRADES)
def test_a_winding_of_every_grade(name, tmp_path):
    grade = GRADES[name]
    file = tmp_path / "case.toml"
    file.write_text(
        f'schema = 1\ngrade = "{name}"\ndiameter = "1 m"\n'
        f'nip_load = "1 kN/m"\nweb_tension = "{grade.tension / 2} N/m"\n'
        '[core]\ndiameter = "100 mm"\nstiffness = "1 GPa"\n[drum]\nkind = "rigid"\nradius = 0.25\n'
    )
    with no_input_warning():
        problem = load_case(file)
    assert isinstance(problem, wo.WindingProblem)
    assert (problem.stack, problem.web, problem.limits) == (grade.stack, grade.web(), grade.limits)
    assert not problem.input_warnings
    spread = grade.spread_of(problem)
    assert spread["stack.radial.K2"] == grade.spread["K2"]
    assert spread["roll_friction"] == grade.spread["friction"]
    assert {"web.thickness", "stack.shear", "density"} <= spread.keys()
    again = tmp_path / "again.toml"
    again.write_text(to_toml(problem))
    with no_input_warning():
        assert load_case(again) == problem
    assert load_case(again).named_grade == grade
    # a value that the grade has and the problem does not have would be read back from the grade
    without = problem.replace(limits=wo.Limits())
    again.write_text(to_toml(without))
    assert load_case(again) == without


def test_values_that_differ_from_the_grade_are_warned_of():
    case = {"schema": 1, "grade": "newsprint", "radius": "0.5 m", "core": CORE,
            "wound_on_tension": "400 N/m"}  # fmt: skip
    with no_input_warning():
        make_problem({**case, "web_thickness": "66 um"})
    said = "web_thickness = 57 um replaces the 66 um of the grade 'newsprint'"
    with pytest.warns(wo.InputWarning, match=said):
        problem = make_problem({**case, "web_thickness": "57 um"})
    assert problem.web_thickness == 57e-6
    with pytest.warns(wo.InputWarning, match=r"stack\.radial\.K2 = 50 replaces the 42"):
        problem = make_problem({**case, "stack": {"radial": {"K2": 50}}})
    assert (problem.stack.radial.K1, problem.stack.radial.K2) == (10e3, 50.0)
    changed = make_problem(apply_settings(case, ["grade=sc"]))
    assert changed.stack == GRADES["sc"].stack


# ---- grades of users ----------------------------------------------------------------------------


OWN = """
[grades.ours]
like = "newsprint"
title = "our newsprint"
thickness = "64 um"
friction = { value = 0.22, spread = 0.05, source = "laboratory" }
[grades.ours.limits]
blocking_pressure = "500 kPa"
"""


def test_grades_of_users(tmp_path):
    file = tmp_path / "mill.toml"
    file.write_text(OWN)
    ours, newsprint = wo.grade("ours", file), wo.grade("newsprint")
    assert (ours.thickness, ours.title, ours.K2) == (64e-6, "our newsprint", newsprint.K2)
    assert (ours.spread["friction"], ours.sources["friction"]) == (0.05, "laboratory")
    assert "thickness" not in ours.spread | ours.sources  # not those of another thickness
    assert ours.limits == newsprint.limits.replace(blocking_pressure=500e3)
    assert {*wo.grades(file)} == {*wo.grades(), "ours"}
    case = tmp_path / "case.toml"
    case.write_text(
        'schema = 1\ngrade = "ours"\ngrades = "mill.toml"\nradius = 0.5\n'
        'wound_on_tension = 400\n[core]\nradius = 0.05\nstiffness = "1 GPa"\n'
    )
    problem = load_case(case)
    assert problem.web_thickness == 64e-6
    case.write_text(to_toml(problem))  # the file of the grade is not known
    assert load_case(case) == problem


# ---- covers -------------------------------------------------------------------------------------


@pytest.mark.parametrize("shore", [50, 60, 80, 90])
def test_covers_follow_the_relation_of_gent(shore):
    E = 0.0981e6 * (56 + 7.62336 * shore) / (0.137505 * (254 - 2.54 * shore))
    (name,) = (name for name in MATERIALS if name.endswith(f"{shore}-shore-a"))
    cover = wo.material(name)
    assert cover.youngs_modulus == pytest.approx(E, rel=0.03)
    assert 0 < MATERIALS[name].spread["youngs_modulus"] < 0.5
    drum = wo.Cylinder(diameter=0.5, core_diameter=0.47, material=name)
    assert math.isfinite(drum.compliance)


def test_replace_with_another_grade():
    lwc = wo.grade("lwc")
    with no_input_warning():
        nip = wo.NipProblem.example().replace(grade="lwc")
    assert nip == wo.NipProblem(
        grade="lwc", roll={"radius": 0.1, "core_radius": 0.0445}, drum=wo.Rigid(radius=0.0762),
        nip_load=3502.0, web_tension=350.0,
    )  # fmt: skip
    assert nip.named_grade == lwc
    with no_input_warning():
        winding = wo.WindingProblem.example().replace(grade="lwc")
    assert (winding.web, winding.stack, winding.limits) == (lwc.web(), lwc.stack, lwc.limits)
    with pytest.warns(wo.InputWarning, match="roll_friction"):
        assert nip.replace(grade="newsprint", roll_friction=0.3).roll_friction == 0.3


@pytest.mark.parametrize("kind", ["nip", "winding"])
@pytest.mark.parametrize("name", wo.grades())
def test_templates_state_the_tension_of_their_grade(name, kind):
    # Consistency: the web tension is half the wound-on tension of the grade, which is stated
    text = grade_template(kind, name)
    tension = parse(tomllib.loads(text)["web_tension"], "N/m", "web_tension")
    assert tension == pytest.approx(wo.grade(name).tension / 2, rel=1e-12)
    stated = re.search(r"usual for the grade, (.*?): the nip", " ".join(text.split()))
    assert parse(stated[1], "N/m", "tension") == pytest.approx(wo.grade(name).tension, rel=1e-12)


# ---- moisture and temperature -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "coefficients"),
    [
        # sources in the data file
        ("newsprint", {"tangential_swelling": 0.01}),
        ("pet-36", {"tangential_expansion": 17e-6}),
        ("aluminium-foil-9", {"tangential_expansion": 23.6e-6, "radial_expansion": 23.6e-6}),
        ("bopp-20", {}),
    ],
)
def test_a_grade_supplies_the_coefficients_that_have_a_source(name, coefficients):
    known = {each: getattr(wo.grade(name), each) for each in OF_WEB}
    assert {each: value for each, value in known.items() if value is not None} == coefficients
    roll = wo.RollProblem(grade=name, core=CORE, diameter="0.4 m", wound_on_tension=100.0)
    assert {each: getattr(roll, each) for each in OF_WEB} == {
        each: coefficients.get(each, 0.0) for each in OF_WEB
    }


def test_moisture_and_grade_are_enough():
    """A change of the moisture strains the web as its grade; an unknown swelling is named."""
    dry = wo.RollProblem(grade="newsprint", core=CORE, diameter="0.4 m", wound_on_tension=400.0,
                         moisture_change="-2 %")  # fmt: skip
    alone = dry.replace(moisture_change=0.0)
    assert dry.free_strains[1].along == 0.01
    stated = wo.RollProblem(
        core=CORE, diameter="0.4 m", wound_on_tension=400.0, web_thickness=dry.web_thickness,
        stack=dry.stack, density=dry.density, moisture_change="-2 %", tangential_swelling=0.01,
    )  # fmt: skip
    np.testing.assert_array_equal(wo.solve(dry).pressure, wo.solve(stated).pressure)
    assert "radial_swelling = 0: the grade 'newsprint' has no value for it" in dry.input_warnings
    assert not alone.input_warnings
    assert not dry.replace(radial_swelling=0.3).input_warnings
    # uncertain is only what has an effect
    grade = dry.named_grade
    assert grade.spread_of(dry)["tangential_swelling"] == 0.5
    assert "tangential_swelling" not in grade.spread_of(alone)


def test_another_grade_takes_its_coefficients_along():
    roll = wo.RollProblem(grade="newsprint", core=CORE, diameter="0.4 m", wound_on_tension=60.0)
    film = roll.replace(grade="pet-12")
    assert (film.tangential_swelling, film.tangential_expansion) == (0.0, 17e-6)
    ours = wo.grade({"like": "newsprint", "radial_swelling": 0.4})
    assert roll.replace(grade=ours).radial_swelling == 0.4
    assert roll.replace(grade=ours, radial_swelling=0.2).radial_swelling == 0.2
    with pytest.warns(wo.InputWarning, match="tangential_swelling = 0.02 replaces the 0.01 of"):
        roll.replace(grade="sc", tangential_swelling=0.02)
    with pytest.raises(wo.InvalidProblem, match="radial_swelling: 11 is out of range"):
        wo.grade({"like": "newsprint", "radial_swelling": 11})
