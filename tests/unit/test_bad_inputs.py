"""Wrong input of every kind: each refused with field, value and what is admissible.

The texts are written out, because they are what a mill engineer sees: a change of one is a change
of the program.  Three doors, one answer: Python, the case file, the command line.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from decimal import Decimal
from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import woundon as wo
from woundon.cli.commands import main

BODY = "Rigid, HalfPlane, Cylinder, Layered or WoundRoll (or a table of its fields)"
MATERIAL = (
    "Orthotropic, Isotropic, LossAngle, DynamicTest or Stack (or a table of its fields, or a name "
    "that 'woundon materials' lists)"
)
LOAD = ">= 1e-12 and <= 1e+07 [N/m]"
EXPECTED = "expected a value in N/m, e.g. '3.5 kN/m', '20 pli' or 3500"
NIP_FIELDS = (
    "air, drum, drum_friction, drum_wrap, nip_load, roll, roll_friction, roll_wrap, web, "
    "web_speed, web_tension, width, winding_force, wrap_friction"
)
MATERIALS = (
    "cellular-elastomer, composite-shell, hard-drum, microcellular-cover, newsprint, paper, "
    "polyurethane-90-shore-a, rubber, rubber-50-shore-a, rubber-60-shore-a, rubber-80-shore-a, "
    "soft-cover, steel"
)


def nip(**changes: Any) -> wo.NipProblem:
    """Return the newsprint case of the thesis's Table 2 with some fields given anew."""
    fields: dict[str, Any] = {
        "web": wo.Web(thickness=66e-6, material="newsprint"),
        "roll": wo.Cylinder(radius=0.1, core_radius=0.0445, material="newsprint"),
        "drum": wo.Rigid(radius=0.0762),
        "roll_friction": 0.19,
        "drum_friction": 0.2,
        "nip_load": 3502.0,
        "web_tension": 350.0,
        "roll_wrap": 0.0,
    }
    return wo.NipProblem(**fields | changes)


def rollers(**changes: Any) -> wo.RollerProblem:
    """Return Carter's case of two steel rollers with some fields given anew."""
    body = wo.HalfPlane(radius=0.25, material="steel")
    fields = {"upper": body, "lower": body, "load": 89e3, "friction": 0.5}
    return wo.RollerProblem(**fields | changes)


def refusal(make: Callable[..., Any], *args: Any, **fields: Any) -> str:
    """Return the text with which a call is refused."""
    with pytest.raises(wo.InvalidProblem) as caught:
        make(*args, **fields)
    assert "pydantic" not in str(caught.value)
    assert caught.value.__cause__ is None  # nothing of pydantic's in the traceback either
    return str(caught.value)


# ---- numbers that are none, or out of range ---------------------------------------------------

LOADS: list[tuple[Any, str]] = [
    (-1, f"-1 is out of range; must be {LOAD}"),
    (0, f"0 is out of range; must be {LOAD}"),
    (-0.0, f"-0 is out of range; must be {LOAD}"),
    (1e8, f"100000000 is out of range; must be {LOAD}"),
    (nan, f"nan is not a finite number; must be {LOAD}"),
    (inf, f"inf is not a finite number; must be {LOAD}"),
    (-inf, f"-inf is not a finite number; must be {LOAD}"),
    (10**400, f"inf is not a finite number; must be {LOAD}"),
    (np.float64(-3.5), f"-3.5 is out of range; must be {LOAD}"),
    (np.float32(nan), f"nan is not a finite number; must be {LOAD}"),
    (np.array(-2), f"-2 is out of range; must be {LOAD}"),
    (True, f"True is not a number; must be {LOAD}"),
    (np.bool_(True), f"np.True_ is not a number; must be {LOAD}"),
    (None, f"None is not a number; must be {LOAD}"),
    ("5", f"'5' has no unit; {EXPECTED}"),
    ("3 kN/s", f"'3 kN/s' has the wrong dimension; {EXPECTED}"),
    (b"5", f"b'5' is not a number; must be {LOAD}"),
    ([1], f"[1] is not a number; must be {LOAD}"),
    ((), f"() is not a number; must be {LOAD}"),
    ({}, f"{{}} is not a number; must be {LOAD}"),
    (3 + 0j, f"(3+0j) is not a number; must be {LOAD}"),
    (Decimal(3), f"Decimal('3') is not a number; must be {LOAD}"),
    (np.array([3.0]), f"array([3.]) is not a number; must be {LOAD}"),
    (np.array("5"), f"array('5', dtype='<U1') is not a number; must be {LOAD}"),
    (np.array(True), f"array(True) is not a number; must be {LOAD}"),
    (np.ma.masked, f"masked is not a number; must be {LOAD}"),
    (list(range(99)), f"[0, 1, 2, 3, 4, 5, ...] is not a number; must be {LOAD}"),
]


@pytest.mark.parametrize(("value", "text"), LOADS, ids=lambda v: repr(v)[:24])
def test_a_number_that_is_none(value: Any, text: str) -> None:
    assert refusal(nip, nip_load=value) == f"nip_load: {text}"


ORTHOTROPIC = {"radial": 20e6, "tangential": 3e9, "cross": 5e6, "shear": 10e6}
CYLINDER = {"radius": 0.1, "core_radius": 0.05, "material": "steel"}
MODULUS = ">= 0.001 and <= 1e+14 [Pa]"
THICKNESS = "thickness: {} is out of range; must be >= 1e-07 and <= 0.01 [m]"
CORE = ">= 1e-09 * radius = 1e-10 and <= 0.9995 * radius = 0.09995 [m]"
RADIUS = "radius: {} is out of range; must be > 0.0001 and <= 50 [m]"

RANGES: list[tuple[Any, dict[str, Any], dict[str, Any], str]] = [
    # (description, its fields, the bad ones, the text)
    (wo.Orthotropic, ORTHOTROPIC, {"radial": 0}, f"radial: 0 is out of range; must be {MODULUS}"),
    (
        wo.Orthotropic, ORTHOTROPIC, {"tangential": -3e9},
        f"tangential: -3000000000 is out of range; must be {MODULUS}",
    ),
    (
        wo.Orthotropic, ORTHOTROPIC, {"cross": -1},
        "cross: -1 is out of range; must be >= 0 and <= 1e+14 [Pa]",
    ),
    (
        wo.Orthotropic, ORTHOTROPIC, {"shear": 1e15},
        f"shear: 1e+15 is out of range; must be {MODULUS}",
    ),
    (
        wo.Orthotropic, ORTHOTROPIC | {"radial": 1e6, "tangential": 1e8}, {"cross": 1e7},
        "cross: 10000000 is out of range; must be >= 0 and < "
        "sqrt(radial * tangential) = 10000000 [Pa]",
    ),
    (
        # the solvers would end in overflow
        wo.Orthotropic, ORTHOTROPIC, {"shear": 1e-300},
        f"shear: 1e-300 is out of range; must be {MODULUS}",
    ),
    (
        wo.Isotropic, {"youngs_modulus": 1e9}, {"poissons_ratio": 0.51},
        "poissons_ratio: 0.51 is out of range; must be >= 0 and <= 0.5",
    ),
    (
        wo.Isotropic, {"youngs_modulus": 1e9}, {"poissons_ratio": -0.1},
        "poissons_ratio: -0.1 is out of range; must be >= 0 and <= 0.5",
    ),
    (
        wo.Isotropic, {"youngs_modulus": 1e9}, {"poissons_ratio": 30},
        "poissons_ratio: 30 is out of range; must be >= 0 and <= 0.5 "
        "(plain numbers are SI: 30 % is 0.3)",
    ),
    (
        wo.Isotropic, {"poissons_ratio": 0.3}, {"youngs_modulus": 0},
        f"youngs_modulus: 0 is out of range; must be {MODULUS}",
    ),
    (
        wo.Web, {"material": "paper"}, {"thickness": 66},
        THICKNESS.format(66) + " (plain numbers are SI: 66 um is 6.6e-05)",
    ),
    (
        wo.Web, {"material": "paper"}, {"thickness": 3},
        THICKNESS.format(3) + " (plain numbers are SI: 3 mm is 0.003, 3 um is 3e-06)",
    ),
    (wo.Web, {"material": "paper"}, {"thickness": 0}, THICKNESS.format(0)),
    (wo.Web, {"material": "paper"}, {"thickness": -66e-6}, THICKNESS.format("-6.6e-05")),
    (wo.Web, {"material": "paper"}, {"thickness": 0.02}, THICKNESS.format(0.02)),
    (
        wo.Rigid, {}, {"radius": 762},
        RADIUS.format(762) + " (plain numbers are SI: 762 mm is 0.762, 762 um is 0.000762)",
    ),
    (wo.Rigid, {}, {"radius": 0}, RADIUS.format(0)),
    (wo.HalfPlane, {"material": "steel"}, {"radius": -0.1}, RADIUS.format(-0.1)),
    (wo.Cylinder, CYLINDER, {"radius": 1e-9}, RADIUS.format("1e-09")),
    (
        wo.Cylinder, CYLINDER, {"core_radius": 0.1},
        f"core_radius: 0.1 is out of range; must be {CORE}",
    ),
    (
        wo.Cylinder, CYLINDER, {"core_radius": 76},
        f"core_radius: 76 is out of range; must be {CORE}",
    ),
    (
        wo.Cylinder, CYLINDER, {"core_radius": 1e-300},
        f"core_radius: 1e-300 is out of range; must be {CORE}",
    ),
    (
        wo.Rigid, {}, {"radius": 100},
        RADIUS.format(100) + " (plain numbers are SI: 100 mm is 0.1)",
    ),
    (wo.Cylinder, CYLINDER, {"core_radius": 0}, "core_radius: 0 is out of range; must be > 0 [m]"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("model", "fields", "bad", "text"), RANGES, ids=lambda v: str(v)[:40] if v is not str else None
)
def test_a_value_out_of_range(
    model: Any, fields: dict[str, Any], bad: dict[str, Any], text: str
) -> None:
    assert refusal(model, **fields | bad) == text


FORCE = ">= -1e+07 and <= 1e+07 [N/m]"
SLIDES = (
    "must be > -700.4 and < 700.4 [N/m], what friction carries in the nip (drum_friction * "
    "nip_load) and on the drum wrap, or the drum slides"
)
FRICTION = "friction: {} is out of range; must be >= 1e-08 and <= 10"

PROBLEMS: list[tuple[Callable[..., Any], dict[str, Any], str]] = [
    (nip, {"winding_force": 701}, f"winding_force: 701 is out of range; {SLIDES}"),
    (nip, {"winding_force": 0.2 * 3502}, f"winding_force: 700.4 is out of range; {SLIDES}"),
    (nip, {"winding_force": -1e9}, f"winding_force: -1000000000 is out of range; must be {FORCE}"),
    (nip, {"winding_force": inf}, f"winding_force: inf is not a finite number; must be {FORCE}"),
    (nip, {"winding_force": None}, f"winding_force: None is not a number; must be {FORCE}"),
    (
        nip, {"web_tension": -1},
        "web_tension: -1 is out of range; must be >= 0 and <= 1e+06 [N/m]",
    ),
    (
        nip, {"roll_friction": 0},
        "roll_" + FRICTION.format(0) + ": without friction nothing fixes how fast the web runs "
        "against the roll; the smallest value shows the limit",
    ),
    (nip, {"drum_friction": -0.2}, "drum_" + FRICTION.format(-0.2)),
    (
        nip, {"drum_friction": 20},
        "drum_" + FRICTION.format(20) + " (plain numbers are SI: 20 % is 0.2)",
    ),
    (
        nip, {"roll": wo.Rigid(radius=0.1)},
        "roll: roll and drum are both Rigid; one must be elastic",
    ),
    (
        rollers, {"upper": wo.Rigid(radius=0.1), "lower": wo.Rigid(radius=0.1)},
        "upper: upper and lower are both Rigid; one must be elastic",
    ),
    (
        rollers, {"creepage": 1e-4, "tangential_load": 5.0},
        "creepage: 0.0001 is given beside tangential_load = 5; must be one of the two",
    ),
    (
        rollers, {"creepage": 1e-4, "motion": "static"},
        "creepage: 0.0001 is given, but motion = 'static' has none; "
        "must be left out, or motion = 'rolling'",
    ),
    (
        rollers, {"creepage": -0.5},
        "creepage: -0.5 is out of range; must be > -0.5 and < 0.5",
    ),
    (
        rollers, {"tangential_load": -44500},
        "tangential_load: -44500 is out of range; |tangential_load| must be < "
        "friction * load = 44500 [N/m], or the rollers slide",
    ),
    (rollers, {"load": 0}, "load: 0 is out of range; must be >= 1e-12 and <= 1e+09 [N/m]"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "bad", "text"), PROBLEMS)
def test_a_load_case_that_cannot_be(
    make: Callable[..., Any], bad: dict[str, Any], text: str
) -> None:
    assert refusal(make, **bad) == text


@pytest.mark.parametrize(
    ("make", "bad"), [(nip, {"winding_force": -701.0}), (rollers, {"tangential_load": 44500.0})]
)
def test_sliding_is_told_apart(make: Callable[..., Any], bad: dict[str, Any]) -> None:
    with pytest.raises(wo.NoSteadyState):
        make(**bad)
    with pytest.raises(wo.NoSteadyState):
        make().replace(**bad)


# ---- names --------------------------------------------------------------------------------------

NAMES: list[tuple[Callable[..., Any], dict[str, Any], str]] = [
    (nip, {"nip_laod": 1.0}, "nip_laod: no such field; did you mean 'nip_load'?"),
    (nip, {"Nip_Load": 1.0}, "Nip_Load: no such field; did you mean 'nip_load'?"),
    (nip, {"tension": 1.0}, "tension: no such field; did you mean 'web_tension'?"),
    # the letters of the formulas
    (nip, {"P": 1.0}, "P: no such field; did you mean 'nip_load'?"),
    (nip, {"T_in": 1.0}, "T_in: no such field; did you mean 'web_tension'?"),
    (
        nip, {"friction": 0.2},
        "friction: no such field; did you mean 'roll_friction', 'drum_friction' or "
        "'wrap_friction'?",
    ),
    (nip, {"xyzzy": 1.0}, f"xyzzy: no such field; known: {NIP_FIELDS}"),
    (nip, {"self": 1.0}, f"self: no such field; known: {NIP_FIELDS}"),
    (nip, {"": 1.0}, f"'': no such field; known: {NIP_FIELDS}"),
    (nip, {"kind": "nip"}, f"kind: no such field; known: {NIP_FIELDS}"),
    (
        wo.Rigid, {"radius": 1.0, "core_radius": 0.5},
        "core_radius: no such field in Rigid, but in Cylinder and WoundRoll; known: radius",
    ),
    (
        wo.Rigid, {"radius": 1.0, "material": "steel"},
        "material: no such field in Rigid, but in HalfPlane and Cylinder; known: radius",
    ),
    (
        wo.Isotropic, {"youngs_modulus": 1e9, "nu": 0.3},
        "poissons_ratio: missing; must be >= 0 and <= 0.5\n"
        "nu: no such field; did you mean 'poissons_ratio'?",
    ),
    (wo.Web, {"thickness": 66e-6}, f"material: missing; must be {MATERIAL}"),
    (wo.Cylinder, {**CYLINDER, "radius": None}, "radius: None is not a number; "
     "must be > 0.0001 and <= 50 [m]"),
    (rollers, {"motion": "roling"}, "motion: 'roling' is unknown; must be 'rolling' or 'static'; "
     "did you mean 'rolling'?"),
    (rollers, {"motion": 5}, "motion: 5 is unknown; must be 'rolling' or 'static'"),
    (rollers, {"motion": None}, "motion: None is unknown; must be 'rolling' or 'static'"),
    (wo.Rigid, {"kind": "cylinder", "radius": 1.0},
     "kind: not a field; for another kind than Rigid give the whole description"),
]  # fmt: skip


@pytest.mark.parametrize(("make", "bad", "text"), NAMES)
def test_a_wrong_name(make: Callable[..., Any], bad: dict[str, Any], text: str) -> None:
    assert refusal(make, **bad) == text


def test_an_empty_problem_names_all_that_is_missing() -> None:
    assert refusal(wo.NipProblem).splitlines() == [
        "web: missing; must be Web (or a table of its fields)",
        f"roll: missing; must be {BODY}",
        f"drum: missing; must be {BODY}",
        "roll_friction: missing; must be >= 1e-08 and <= 10",
        "drum_friction: missing; must be >= 1e-08 and <= 10",
        f"nip_load: missing; must be {LOAD}",
    ]


# ---- one thing in the place of another ----------------------------------------------------------

PLACES: list[tuple[dict[str, Any], str]] = [
    ({"web": 66e-6}, "web: 6.6e-05 is out of place; must be Web (or a table of its fields)"),
    ({"web": None}, "web: None is out of place; must be Web (or a table of its fields)"),
    (
        {"web": "newsprint"},
        "web: 'newsprint' is out of place; must be Web (or a table of its fields)",
    ),
    (
        {"web": wo.Rigid(radius=1)},
        "web: Rigid(radius=1.0) is out of place; must be Web (or a table of its fields)",
    ),
    ({"drum": None}, f"drum: None is out of place; must be {BODY}"),
    ({"drum": "rigid"}, f"drum: 'rigid' is out of place; must be {BODY}"),
    ({"drum": [1, 2]}, f"drum: [1, 2] is out of place; must be {BODY}"),
    (
        {"drum": wo.Rigid},
        f"drum: <class 'woundon.problems.bodies.Rigid'> is out of place; must be {BODY}",
    ),
    (
        {"drum": wo.material("steel")},
        f"drum: Isotropic(youngs_m...io=0.3, prony=None) is out of place; must be {BODY}",
    ),
    ({"drum": {}}, "drum.radius: missing; must be > 0.0001 and <= 50 [m]"),
    (
        {"drum": {"kind": "rigd", "radius": 1}},
        "drum.kind: 'rigd' is unknown; must be 'rigid', 'half_plane', 'cylinder', "
        "'layered' or 'wound_roll'; "
        "did you mean 'rigid'?",
    ),
    (
        {"drum": {"kind": "half-plane", "radius": 1}},
        "drum.kind: 'half-plane' is unknown; must be 'rigid', 'half_plane', 'cylinder', "
        "'layered' or 'wound_roll'; "
        "did you mean 'half_plane'?",
    ),
    (
        {"drum": {"kind": None, "radius": 1}},
        "drum.kind: None is unknown; must be 'rigid', 'half_plane', 'cylinder', "
        "'layered' or 'wound_roll'",
    ),
    # a field that happens to be called like a kind
    ({"drum": {"radius": 1, "rigid": 3}}, "drum.rigid: no such field; known: radius"),
    ({"drum": wo.HalfPlane}, f"drum: <class 'woundon.pr....bodies.HalfPlane'> is out of place; "
     f"must be {BODY}"),
    (
        {"drum": {"radius": 1, "core_raduis": 0.5, "material": "steel"}},
        "drum.core_radius: missing; must be > 0 [m]\n"
        "drum.core_raduis: no such field; did you mean 'core_radius'?",
    ),
    (
        {"web": {"thickness": 66e-6, "material": "newsprnt"}},
        "web.material: 'newsprnt' is not a named material; did you mean 'newsprint'?",
    ),
    (
        {"web": {"thickness": 66e-6, "material": ""}},
        f"web.material: '' is not a named material; known: {MATERIALS}",
    ),
    (
        {"web": {"thickness": 66e-6, "material": 5}},
        f"web.material: 5 is out of place; must be {MATERIAL}",
    ),
    (
        {"web": {"thickness": 66e-6, "material": wo.Rigid(radius=1)}},
        f"web.material: Rigid(radius=1.0) is out of place; must be {MATERIAL}",
    ),
    (
        {"web": {"thickness": 66e-6, "material": {"kind": "wood"}}},
        "web.material.kind: 'wood' is unknown; must be 'orthotropic', 'isotropic', "
        "'loss_angle', 'dynamic_test' or 'stack'",
    ),
    (
        {"web": {"thickness": "66 s", "material": {**ORTHOTROPIC, "shaer": 1e6, "radial": -1}}},
        "web.thickness: '66 s' has the wrong dimension; expected a value in m, "
        "e.g. '66 um' or 66e-6\n"
        "web.material.radial: -1 is out of range; must be >= 0.001 and <= 1e+14 [Pa]\n"
        "web.material.shaer: no such field; did you mean 'shear'?",
    ),
    (
        {"web": {"thickness": 66e-6, "material": {"young": 1e9, "poissons_ratio": 0.3}}},
        "web.material.youngs_modulus: missing; must be >= 0.001 and <= 1e+14 [Pa]\n"
        "web.material.young: no such field; did you mean 'youngs_modulus'?",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("bad", "text"), PLACES)
def test_one_thing_in_the_place_of_another(bad: dict[str, Any], text: str) -> None:
    assert refusal(nip, **bad) == text


@pytest.mark.parametrize("name", ["stel", "", 5, None, ["steel"]])
def test_an_unknown_material(name: Any) -> None:
    hint = "did you mean 'steel'?" if name in ("stel", ["steel"]) else f"known: {MATERIALS}"
    assert refusal(wo.material, name) == f"material: {name!r} is not a named material; {hint}"


# ---- variants -----------------------------------------------------------------------------------

VARIANTS: list[tuple[dict[str, Any], str]] = [
    ({"nip_laod": 1}, "nip_laod: no such field; did you mean 'nip_load'?"),
    ({"web.thicknes": 1}, "web.thicknes: no such field; did you mean 'thickness'?"),
    ({"webb.thickness": 1}, "webb.thickness: no such field; did you mean 'web'?"),
    ({"web.material.shaer": 1}, "web.material.shaer: no such field; did you mean 'shear'?"),
    (
        {"web.material.shear": -1},
        "web.material.shear: -1 is out of range; must be >= 0.001 and <= 1e+14 [Pa]",
    ),
    (
        {"web.material.shear.x": 1},
        "web.material.shear.x: shear has no fields of its own",
    ),
    ({"nip_load.x": 1}, "nip_load.x: nip_load has no fields of its own"),
    ({"web.": 1}, "web.: no field is named behind the dot"),
    ({".web": 1}, f".web: no such field; known: {NIP_FIELDS}"),
    ({"": 1}, f"'': no such field; known: {NIP_FIELDS}"),
    ({"web..thickness": 1}, "web..thickness: no such field; known: material, thickness"),
    (
        {"roll.core_radius": 0.2},
        f"roll.core_radius: 0.2 is out of range; must be {CORE}",
    ),
    (
        {"drum.core_radius": 0.05},
        "drum.core_radius: no such field in Rigid, but in Cylinder and WoundRoll; known: radius",
    ),
    (
        {"roll.kind": "rigid"},
        "roll.kind: not a field; for another kind than Cylinder give the whole description",
    ),
    ({"roll.material": "stel"}, "roll.material: 'stel' is not a named material; "
     "did you mean 'steel'?"),
    (
        {"nip_load": "3 kN"},
        "nip_load: '3 kN' is a force; expected a force per width. Give the width of the web, "
        "e.g. width = '2.5 m', which divides it, or write it in N/m, kN/m or pli",
    ),
    # all at once
    (
        {"nip_load": "3", "web.thickness": "57 N"},
        "nip_load: '3' has no unit; expected a value in N/m, e.g. '3.5 kN/m', '20 pli' or 3500\n"
        "web.thickness: '57 N' has the wrong dimension; expected a value in m, "
        "e.g. '66 um' or 66e-6",
    ),
    (
        {"web.thicknes": 1, "rolll": 2, "roll.radius": True},
        "rolll: no such field; did you mean 'roll'?\n"
        "web.thicknes: no such field; did you mean 'thickness'?\n"
        "roll.radius: True is not a number; must be > 0.0001 and <= 50 [m]",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "text"), VARIANTS)
def test_a_variant_that_cannot_be(changes: dict[str, Any], text: str) -> None:
    assert refusal(nip().replace, **changes) == text


# ---- options ------------------------------------------------------------------------------------

OPTIONS: list[tuple[dict[str, Any], str]] = [
    ({"nodes": 3}, r"nodes: 3 .*whole number, 13 to 1025"),
    ({"nodes": 1026}, r"nodes: 1026 .*whole number, 13 to 1025"),
    ({"nodes": True}, r"nodes: True .*whole number, 13 to 1025"),
    ({"nodes": "65"}, r"nodes: '65' .*whole number, 13 to 1025"),
    ({"nodes": 65.5}, r"nodes: 65.5 .*whole number, 13 to 1025"),
    ({"nodes": nan}, r"nodes: nan .*whole number, 13 to 1025"),
    ({"rtol": 0}, r"rtol: 0 .*>= 1e-05 and <= 0.1"),
    ({"rtol": 1}, r"rtol: 1 .*>= 1e-05 and <= 0.1"),
    ({"rtol": nan}, r"rtol: nan .*>= 1e-05 and <= 0.1"),
    ({"rtol": "1e-3"}, r"rtol: '1e-3' .*>= 1e-05 and <= 0.1"),
    ({"rtol": -1e-3}, r"rtol: -0.001 .*>= 1e-05 and <= 0.1"),
    ({"rtol": 1e-6}, r"rtol: 1e-06 .*>= 1e-05 and <= 0.1"),
]


@pytest.mark.parametrize(("options", "text"), OPTIONS)
def test_an_option_out_of_range(options: dict[str, Any], text: str) -> None:
    with pytest.raises(wo.InvalidProblem, match=text):
        wo.solve(nip(), **options)


@pytest.mark.parametrize("nodes", [3, True, "65", 4001, 101.0])
def test_rollers_check_their_nodes(nodes: Any) -> None:
    with pytest.raises(wo.InvalidProblem, match=r"nodes: .*whole number, 7 to 2049"):
        wo.solve(rollers(), nodes=nodes)


# ---- the case file, and the command line in front of it -----------------------------------------

CASE = """
schema = 1
nip_load = "3502 N/m"
winding_force = "0 N/m"
web_tension = "350 N/m"
roll_friction = 0.19
drum_friction = 0.20

[web]
thickness = "66 um"
material = "newsprint"

[roll]
kind = "cylinder"
radius = "100 mm"
core_radius = "44.5 mm"

[roll.material]
radial = "27 MPa"
tangential = "3.38 GPa"
cross = "5 MPa"
shear = "10 MPa"

[drum]
kind = "rigid"
radius = "76.2 mm"
"""
RANGE = r">= 1e-12 and <= 1e\+07 \[N/m\]"
# (what to replace in CASE, by what, fragments of the answer)
CASES: list[tuple[str, str, str]] = [
    ('"3502 N/m"', "-5", rf"nip_load: -5 .*{RANGE}"),
    ('"3502 N/m"', '"-5 kN/m"', rf"nip_load: -5000 .*{RANGE}"),
    ('"3502 N/m"', "0", rf"nip_load: 0 .*{RANGE}"),
    ('"3502 N/m"', "nan", rf"nip_load: nan .*finite.*{RANGE}"),
    ('"3502 N/m"', "inf", rf"nip_load: inf .*finite.*{RANGE}"),
    ('"3502 N/m"', '"1e999 N/m"', r"nip_load: '1e999 N/m' .*finite.*N/m"),
    ('"3502 N/m"', "1" + "0" * 400, r"nip_load: .*finite"),
    ('"3502 N/m"', "true", r"nip_load: True .*not a number.*N/m"),
    ('"3502 N/m"', "[1, 2]", r"nip_load: \[1, 2\] .*not a number.*N/m"),
    ('"3502 N/m"', "{ a = 1 }", rf"nip_load: \{{'a': 1\}} .*not a number.*{RANGE}"),
    ('"3502 N/m"', "1979-05-27", r"nip_load: .*1979.*not a number.*N/m"),
    ('"3502 N/m"', '"3502"', r"nip_load: '3502' .*no unit.*N/m"),
    ('"3502 N/m"', '"abc"', r"nip_load: 'abc' .*not a number.*N/m"),
    ('"3502 N/m"', '"3.5 kN"', r"nip_load: '3.5 kN' is a force.*N/m"),
    ('"3502 N/m"', '"35 furlong"', r"nip_load: '35 furlong' .*unknown unit 'furlong'.*N/m"),
    ('"3502 N/m"', '"3.5 kn/m"', r"nip_load: '3.5 kn/m' .*did you mean 'kN'"),
    ('"66 um"', "66", r"web\.thickness: 66 .*>= 1e-07 and <= 0.01 \[m\].*66 um is 6.6e-05"),
    ('"66 um"', '"66 m"', r"web\.thickness: 66 .*>= 1e-07 and <= 0.01 \[m\]"),
    ('"66 um"', '"0,066 mm"', r"web\.thickness: '0,066 mm' .*66 um.*decimal point"),
    ('"66 um"', '"66 millimetres"', r"web\.thickness: '66 millimetres' .*did you mean 'mm'"),
    ('"66 um"', '"0.066 millimeter"', r"web\.thickness: .*did you mean 'mm'"),
    ('"0 N/m"', '"\N{MINUS SIGN}400 N/m"', r"winding_force: .*write the minus as '-'"),
    ('"0 N/m"', '"\N{EN DASH}400 N/m"', r"winding_force: .*write the minus as '-'"),
    ("0.20", "20", r"drum_friction: 20 .*>= 1e-08 and <= 10.*20 % is 0.2"),
    ("0.20", '"20 um"', r"drum_friction: '20 um' .*dimension.*plain number"),
    ('"0 N/m"', '"1 kN/m"', r"winding_force: 1000 .*< 700.4 \[N/m\].*drum_friction \* nip_load"),
    ('"5 MPa"', '"500 MPa"', r"roll\.material\.cross: 500000000 .*sqrt\(radial"),
    ('"44.5 mm"', '"100 mm"', r"roll\.core_radius: 0.1 .*0.9995 \* radius"),
    ('= "rigid"', '= "rigd"', r"drum\.kind: 'rigd' .*did you mean 'rigid'"),
    ('= "newsprint"', '= "newsprnt"', r"web\.material: 'newsprnt' .*did you mean 'newsprint'"),
    ("nip_load =", "nip_laod =", r"nip_laod: no such field; did you mean 'nip_load'"),
    ("thickness =", "thicknes =", r"web\.thicknes: no such field; did you mean 'thickness'"),
    ("shear =", "shaer =", r"roll\.material\.shaer: no such field; did you mean 'shear'"),
    ("core_radius = ", "core_raduis = ", r"roll\.core_raduis: .*did you mean 'core_radius'"),
    ("[drum]", "[durm]", r"durm: no such field; did you mean 'drum'"),
    ("nip_load =", "# ", r"nip_load: missing.*>= 1e-12"),
    ("[web]", "[[web]]", r"web: .*must be Web"),
    ("schema = 1", "schema = 2", r"schema: 2 .*schema = 1"),
    ("schema = 1", "schema = true", r"schema: True .*schema = 1"),
    ("schema = 1", "", r"schema: missing.*schema = 1"),
    ("[web]", "[web", r"case\.toml: .*TOML.*line \d+"),
    ("[roll]", "[web]", r"case\.toml: .*TOML.*twice.*line \d+"),
]


def refused_by_command(capsys: pytest.CaptureFixture[str], *args: str) -> str:
    """Return what the command line says; it must end with code 2 and without a traceback."""
    assert main(["solve", *args]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "Traceback" not in said.err
    assert all(line.startswith("error: ") for line in said.err.splitlines())
    return said.err


@pytest.mark.parametrize(("old", "new", "text"), CASES)
def test_a_bad_case_file(
    old: str, new: str, text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = tmp_path / "case.toml"
    assert old in CASE
    case.write_text(CASE.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(wo.InvalidProblem, match=text):
        wo.load_case(case)
    said = refused_by_command(capsys, str(case))
    assert re.search(text, said)


FILES: list[tuple[bytes, str]] = [
    (b"", "is empty"),
    (b"# nothing but a comment\n", "is empty"),
    (b"nip_load = = 5", "TOML"),
    (bytes(range(256)), "UTF-8"),
    (b"\x00\x01\x02", "TOML"),
    (b"\x89PNG\r\n\x1a\n", "UTF-8"),
    (CASE.encode("utf-16"), "is not UTF-8 text, from byte 0; save it as UTF-8"),
    (b"a = " + b"[" * 5000 + b"]" * 5000, "nested too deeply"),
    # the line is shown, for it names field and value
    (b"nip_load = 1\nnip_load = 2\n", "(at line 2, column 13): nip_load = 2"),
    (b"nip_load = 1\nnip_load = 2", "(at end of document): nip_load = 2"),
    (b"nip_load = 3.5 kN/m # P", 'nip_load = 3.5 kN/m; text with a unit needs quotes: "3.5 kN/m"'),
]


@pytest.mark.parametrize(("content", "text"), FILES)
def test_a_file_that_is_no_case(
    content: bytes, text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = tmp_path / "case.toml"
    case.write_bytes(content)
    said = refused_by_command(capsys, str(case))
    assert str(case) in said
    assert text in said


def test_a_file_that_cannot_be_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    missing = tmp_path / "nope.toml"
    assert f"{missing}: cannot be read: No such file" in refused_by_command(capsys, str(missing))
    assert "Is a directory" in refused_by_command(capsys, str(tmp_path))
    assert "CASE" in refused_by_command(capsys)


COMMANDS: list[tuple[list[str], str]] = [
    (["--set", "nip_load"], "nip_load"),
    (["--set", "=5"], "=5"),
    (["--set", "nip_load="], "nip_load="),
    (["--set", "nip_laod=5"], "nip_laod: no such field; did you mean 'nip_load'?"),
    (["--set", "web.thicknes=5"], "web.thicknes: no such field; did you mean 'thickness'?"),
    (["--set", "nip_load.x=5"], "nip_load.x: nip_load has no fields of its own"),
    (["--set", "nip_load=-5"], "nip_load: -5 is out of range"),
    (["--set", "nip_load=nan"], "nip_load: nan is not a finite number"),
    (["--set", "nip_load=1e999"], "nip_load: inf is not a finite number"),
    (["--set", "nip_load=True"], "nip_load: 'True' is not a number"),
    (["--set", "nip_load=3.5 kN"], "nip_load: '3.5 kN' is a force"),
    (["--set", "web.material=steeel"], "web.material: 'steeel' is not a named material"),
    (["--set", "winding_force=701 N/m"], "winding_force: 701 is out of range"),
    (["--nodes", "3"], "nodes: 3"),
    (["--nodes", "abc"], "'abc'"),
    (["--rtol", "2"], "rtol: 2"),
    (["--save", "x.xyz"], ".nc"),
    (["--plot", "x.xyz"], ".png"),
    (["--save", "no/such/folder/x.nc"], "folder"),
    (["--save", "case.toml/x.nc"], "case.toml/x.nc: the folder 'case.toml' does not exist"),
    (["--roll-wrap", "180 degrees"], "roll_wrap: '180 degrees' has the unknown unit"),
    (["--colour", "red"], "--colour"),
]


@pytest.mark.parametrize(("args", "text"), COMMANDS, ids=lambda v: " ".join(v)[:30])
def test_a_bad_command(
    args: list[str],
    text: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("case.toml").write_text(CASE, encoding="utf-8")
    assert text in refused_by_command(capsys, "case.toml", *args)
    assert [path.name for path in tmp_path.iterdir()] == ["case.toml"]  # nothing was written


@pytest.mark.parametrize("option", ["--save", "--plot"])
def test_an_output_is_refused_before_anything_is_solved(
    option: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_solving(*_: object, **__: object) -> None:
        raise AssertionError("solved first")

    monkeypatch.setattr("woundon.kinds.solve", no_solving)
    case = tmp_path / "case.toml"
    case.write_text(CASE, encoding="utf-8")
    target = tmp_path / ("x.nc" if option == "--save" else "x.png")
    # root may write anywhere, so the system's answer is put in place of its permissions
    monkeypatch.setattr("os.access", lambda _, mode: mode != os.W_OK)
    said = refused_by_command(capsys, str(case), option, str(target))
    assert f"{target}: cannot be written: no permission" in said
    target.mkdir()
    said = refused_by_command(capsys, str(case), option, str(target))
    assert f"{target}: is a folder; name a file" in said


def test_windows_files_are_read(tmp_path: Path) -> None:
    plain, windows = tmp_path / "plain.toml", tmp_path / "windows.toml"
    plain.write_bytes(CASE.encode())
    windows.write_bytes(b"\xef\xbb\xbf" + CASE.replace("\n", "\r\n").encode())
    assert wo.load_case(windows) == wo.load_case(plain)


# ---- arguments of the solvers -------------------------------------------------------------------


def wrapped() -> wo.NipProblem:
    return nip().replace(roll_wrap=np.pi)


def named(value: Any) -> str:
    """Return a name that is the same in every process: a function's address is not."""
    return str(getattr(value, "__name__", value))[:30]


@pytest.mark.parametrize("given", [None, 5, "case.toml", {"nip_load": 1}, wo.NipProblem])
def test_a_solver_takes_problems_only(given: Any) -> None:
    text = refusal(wo.solve, given)
    assert text.startswith("problem: ")
    assert " is out of place; must be a NipProblem" in text


ANY_KIND: list[tuple[Callable[[], Any], dict[str, Any], str]] = [
    (rollers, {"nodes": True}, "nodes: True is out of range: must be a whole number, 7 to 2049"),
    (rollers, {"nodes": 33.0}, "nodes: 33 is out of range: must be a whole number, 7 to 2049"),
    (rollers, {"nodes": 2050}, "nodes: 2050 is out of range: must be a whole number, 7 to 2049"),
    (rollers, {"rtol": nan}, "rtol: nan is out of range: must be >= "),
    (rollers, {"rtol": True}, "rtol: True is out of range: must be >= "),
    (nip, {"start": 5}, "start: 5 is out of place; must be a NipResult"),
    (nip, {"start": nip()}, "start: NipProblem("),
    (wrapped, {"nodes": 12}, "nodes: 12 is out of range: must be a whole number, 13 to 1025"),
    (wrapped, {"rtol": inf}, "rtol: inf is out of range: must be >= 1e-05 and <= 0.1"),
]


@pytest.mark.parametrize(("kind", "bad", "text"), ANY_KIND, ids=named)
def test_an_option_that_cannot_be(kind: Callable[[], Any], bad: dict[str, Any], text: str) -> None:
    assert refusal(wo.solve, kind(), **bad).startswith(text)


@pytest.mark.parametrize(
    ("angle", "text"),
    [(3.5, "(plain numbers are SI: 3.5 deg is 0.0610865)"),
     (180, "(plain numbers are SI: 180 deg is 3.14159)")],
)  # fmt: skip
def test_angles_that_are_meant_in_degrees_are_told(angle: float, text: str) -> None:
    told = refusal(nip, roll_wrap=angle)
    assert told.startswith(f"roll_wrap: {angle} is out of range; must be >= 0 and <= 3.14159 [rad]")
    assert text in told


@pytest.mark.parametrize("kind", [nip, lambda: nip().replace(roll_wrap=np.pi), rollers])
def test_nodes_and_rtol_are_one_or_the_other(kind: Any) -> None:
    text = "nodes: 65 is given together with rtol, which chooses the nodes; omit one"
    assert refusal(wo.solve, kind(), nodes=65, rtol=1e-3) == text


def test_options_may_be_numpys() -> None:
    assert wo.solve(nip(), nodes=np.int64(17)).nodes == 17
    assert wo.solve(rollers(), nodes=np.int32(33)).nodes == 33
    assert max(wo.solve(rollers(), rtol=np.float32(0.1)).errors.values()) > 0


ROLLER_THEORIES = ["bentall_johnson_frictionless", "bentall_johnson_stick", "carter", "cattaneo"]


@pytest.mark.parametrize("name", [*ROLLER_THEORIES, "friction_limit", "jalkanen", "dual_slip"])
@pytest.mark.parametrize("given", [None, "other"])
def test_a_theory_takes_its_problem_only(name: str, given: Any) -> None:
    of_rollers = name in ROLLER_THEORIES
    problem = given and (nip() if of_rollers else rollers())
    extra = (1e-4,) if name in ("jalkanen", "dual_slip") else ()
    text = refusal(getattr(wo.theories, name), problem, *extra)
    due = "RollerProblem" if of_rollers else "NipProblem"
    assert text.endswith(f"must be a {due}")
