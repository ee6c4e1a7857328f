"""Case files: what is read, what is refused and how, what is written and read again."""

from __future__ import annotations

import time
import tomllib
from math import pi
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from viscoelastic_cases import cover, rubber

import woundon as wo
from woundon import kinds
from woundon.io.case_files import make_problem, template, to_toml
from woundon.problems.materials import MATERIALS

EXAMPLE = Path(__file__).parents[2] / "examples" / "newsprint_table2.toml"

NEWSPRINT = wo.Orthotropic(radial=27e6, tangential=3.38e9, cross=5e6, shear=10e6)
TABLE_2 = wo.NipProblem(
    web=wo.Web(thickness=66e-6, material=NEWSPRINT),
    roll=wo.Cylinder(radius=0.1, core_radius=0.0445, material=NEWSPRINT),
    drum=wo.Rigid(radius=0.0762),
    roll_friction=0.19,
    drum_friction=0.2,
    nip_load=3502.0,
    winding_force=0.0,
    web_tension=350.0,
)
PLAIN = TABLE_2.replace(roll_wrap=0.0)
PAIR = """
schema = 1
load = "89 kN/m"
tangential_load = "8.4 kN/m"
friction = 0.5

[upper]
kind = "half_plane"
radius = "250 mm"
material = "steel"

[lower]
kind = "half_plane"
radius = "250 mm"
material = "steel"
"""


# ---- reading ------------------------------------------------------------------------------------


def test_example_is_table_2():
    assert wo.load_case(EXAMPLE) == TABLE_2


@pytest.fixture
def pair(tmp_path) -> Path:
    path = tmp_path / "pair.toml"
    path.write_text(PAIR, encoding="utf-8")
    return path


def test_the_kind_is_reported_by_the_names(pair):
    assert wo.load_case(pair) == wo.RollerProblem.example()
    assert wo.load_case(pair, ["motion=static"]).motion == "static"
    assert wo.load_case(EXAMPLE, ["wrap=none"]) == TABLE_2
    assert wo.load_case(EXAMPLE, ["roll_wrap=0"]) == PLAIN


def test_a_table_without_fields_has_the_usual_wraps():
    tables = tomllib.loads(to_toml(PLAIN))
    assert make_problem(tables) == PLAIN
    assert tables.pop("wrap") == {"roll_wrap": "0 deg", "drum_wrap": "0 deg"}
    assert make_problem(tables) == make_problem({**tables, "wrap": {}}) == TABLE_2
    assert make_problem(tables, "nip") == TABLE_2


@pytest.mark.parametrize(
    ("setting", "field", "value"),
    [
        ("nip_load=3.5 kN/m", "nip_load", 3500.0),
        ("nip_load = 17 pli", "nip_load", 2977.1561991900985),
        ("nip_load=5000", "nip_load", 5000.0),
        ("winding_force=-3e2", "winding_force", -300.0),
        ("roll_friction=25 %", "roll_friction", 0.25),
        ("web.thickness=57 um", "web.thickness", 57e-6),
        ("web.thickness='57 um'", "web.thickness", 57e-6),
        ("roll.material.shear=12 MPa", "roll.material.shear", 12e6),
        ("web.material=paper", "web.material", wo.material("paper")),
        ("roll_wrap=90 deg", "roll_wrap", pi / 2),
        ("wrap.roll_wrap=90 deg", "roll_wrap", pi / 2),
        ("drum_wrap=1.5", "drum_wrap", 1.5),
        ("wrap_friction=0.3", "wrap_friction", 0.3),
        ("wrap_friction=none", "wrap_friction", None),
    ],
)
def test_settings(setting, field, value):
    assert wo.load_case(EXAMPLE, [setting]) == TABLE_2.replace(**{field: value})


def test_settings_change_the_kind_of_a_body():
    settings = ["drum.kind=cylinder", "drum.core_radius=70 mm", "drum.material=soft-cover"]
    drum = wo.load_case(EXAMPLE, settings).drum
    assert drum == wo.Cylinder(radius=0.0762, core_radius=0.07, material=wo.material("soft-cover"))


def test_one_of_two_fields_is_left_out_for_the_other(pair):
    problem = wo.load_case(pair, ["tangential_load=none", "creepage=0.01 %"])
    assert (problem.tangential_load, problem.creepage) == (None, 1e-4)


# ---- refusing -----------------------------------------------------------------------------------

QUOTED = '"a.b"'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty; 'woundon new > case.toml' writes a case"),
        ("# only a comment\n", "is empty"),
        ("schema = 1\n", "is empty"),
        ("schema = 1\nnip_load = 3502 N/m\n", "is not valid TOML*line 2"),
        ("schema = 1\n[web\n", "is not valid TOML*line 2"),
        ("schema = 1\nnip_load = 1\nnip_load = 2\n", "is not valid TOML*line 3"),
        (b"\xff\xfe\x00", "is not UTF-8 text, from byte 0"),
    ],
)
def test_bad_file_is_rejected(tmp_path, text, said):
    path = tmp_path / "case.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(wo.InvalidProblem) as refusal:
        wo.load_case(path)
    ((field, fault),) = refusal.value.faults
    assert field == str(path)
    for part in said.split("*"):
        assert part in fault


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f"schema = {'1' * 5000}", "it has a number of thousands of digits"),
        (f"[{'.'.join('a' * 900)}]", "it is nested too deeply"),
        (f"nip_load = 0x{'f' * 5000}", "it has a number of thousands of digits"),
        (f"layers = [1, [0b{'1' * 20_000}]]", "it has a number of thousands of digits"),
        (f"{'.'.join('a' * 50_000)} = 1", "it is nested too deeply"),
        (f"[{' . '.join(['a', QUOTED] * 25_000)}]", "it is nested too deeply"),
        (f"a = {'[' * 50_000}{']' * 50_000}", "it is nested too deeply"),
        ("\n".join(f"a{k} = {k}" for k in range(5001)), "it has 5001 names"),
        ("\n".join(f"[a{k}]\nb = 1" for k in range(2501)), "it has 5002 names"),
    ],
    ids=lambda text: text[:12],
)
def test_what_is_like_no_case_is_rejected_soon(tmp_path, text, said):
    path = tmp_path / "case.toml"
    path.write_text(text)
    start = time.process_time()
    with pytest.raises(wo.InvalidProblem) as refusal:
        wo.load_case(path)
    assert str(refusal.value) == f"{path}: is not a case file: {said}"
    assert time.process_time() - start < 5  # tomllib alone takes minutes for the long keys


@pytest.mark.parametrize(
    ("name", "content"),
    [("tensions.csv", b"nip_load [kN/m],T [N/m]\n2,500\n"), ("tensions.xlsx", b"PK\x03\x04\xff")],
)
def test_a_table_in_place_of_a_case_is_recognised(tmp_path, name, content):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(wo.InvalidProblem, match="not a case file; 'woundon table CASES' solves"):
        wo.load_case(path)


def test_texts_and_numbers_may_hold_many_dots(tmp_path):
    path = tmp_path / "case.toml"
    dots = f"# {'. ' * 50}\n# {'.' * 200}\n# {', '.join(['0.5'] * 100)}\n"
    path.write_text(dots + template("nip"))
    assert wo.load_case(path) == wo.NipProblem.example()


def test_missing_fields_and_schema_are_named(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text('[web]\nthickness = "66 um"\n', encoding="utf-8")
    with pytest.raises(wo.InvalidProblem) as refusal:
        wo.load_case(path)
    faults = dict(refusal.value.faults)
    assert "write 'schema = 1'" in faults["schema"]
    assert {"web.material", "roll", "drum", "nip_load", "roll_friction"} <= faults.keys()


def test_all_faults_are_reported_at_once():
    settings = ["nip_load=-1", "web.thickness=66 kg", "roll_fricton=0.2"]
    with pytest.raises(wo.InvalidProblem) as refusal:
        wo.load_case(EXAMPLE, settings)
    assert {"nip_load", "web.thickness", "roll_fricton"} == dict(refusal.value.faults).keys()


def test_a_field_in_two_places_is_rejected():
    tables = tomllib.loads(to_toml(TABLE_2)) | {"roll_wrap": 1.0}
    with pytest.raises(wo.InvalidProblem, match=r"roll_wrap: given twice, in \[wrap\] and at "):
        make_problem(tables)


# ---- writing ------------------------------------------------------------------------------------

KINDS = ["nip", "rollers"]


@pytest.mark.parametrize("kind", ["nip", "rollers", "roll", "winding"])
def test_fields_of_a_template_that_are_not_set_are_described(kind):
    lines = [line for line in template(kind).splitlines() if " = ..." in line]
    assert lines
    assert not [line for line in lines if "#" not in line.removeprefix("#")]


def test_tables_of_a_template_that_are_not_set_are_called_tables():
    text = " ".join(template("winding").replace("#", " ").split())
    assert "winder = ... front drum and rider of a two-drum winder; a table of its fields" in text
    assert "thickness_profile = ... thickness of the web across its width; a table" in text
    assert "material = ... a name ('woundon materials' lists them), or a table of its" in text
    text = " ".join(template("nip").replace("#", " ").split())
    assert "next_nips = ... further nips of the laid web, in its direction; tables of" in text


@pytest.mark.parametrize("kind", KINDS)
def test_template_is_a_case_ready_to_run(kind):
    example = kinds.named(kind).problem.example()
    assert make_problem(tomllib.loads(template(kind))) == example


def numbers(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers of all magnitudes in a range, with many digits and with few."""
    any_of = st.floats(low, high, allow_subnormal=False)
    short = any_of.map(lambda v: float(f"{v:.3g}")).filter(lambda v: low <= v <= high)
    return st.one_of(any_of, short)


MODULI = numbers(1e-3, 1e14)
MATERIAL = st.one_of(
    st.sampled_from([entry.material for entry in MATERIALS.values()]),
    st.builds(wo.Isotropic, youngs_modulus=MODULI, poissons_ratio=numbers(0, 0.499)),
    st.builds(
        lambda r, t, share, shear: wo.Orthotropic(
            radial=r, tangential=t, cross=share * (r * t) ** 0.5, shear=shear
        ),
        numbers(1e3, 1e9), numbers(1e3, 1e9), st.floats(0, 0.9), MODULI,
    ),
)  # fmt: skip
RADIUS = numbers(2e-4, 50)
DEEP = st.builds(wo.HalfPlane, radius=RADIUS, material=MATERIAL)
LAYER = st.builds(
    lambda radius, share, material: wo.Cylinder(
        radius=radius, core_radius=share * radius, material=material
    ),
    RADIUS, numbers(1e-3, 0.999), MATERIAL,
)  # fmt: skip
SOFT = st.one_of(DEEP, LAYER)
BODY = st.one_of(SOFT, st.builds(wo.Rigid, radius=RADIUS))
NIP = st.builds(
    lambda force, **fields: wo.NipProblem(
        winding_force=force * min(fields["drum_friction"] * fields["nip_load"], 1e7),
        **fields,
        roll_wrap=0.0,
    ),
    force=st.floats(-0.99, 0.99),
    web=st.builds(wo.Web, thickness=numbers(1e-7, 1e-2), material=MATERIAL),
    roll=SOFT,
    drum=BODY,
    roll_friction=numbers(1e-8, 10),
    drum_friction=numbers(1e-8, 10),
    nip_load=numbers(1e-12, 1e7),
    web_tension=numbers(1e-6, 1e6),
)
ANGLE = st.one_of(numbers(0, pi), st.sampled_from([0.0, pi, pi / 2, pi / 3, 2 * pi / 3]))
WRAPPED = st.builds(
    lambda nip, **wraps: nip.replace(**wraps),
    NIP, roll_wrap=ANGLE, drum_wrap=ANGLE,
    wrap_friction=st.one_of(st.none(), numbers(1e-6, 10)),
)  # fmt: skip
ROLLERS = st.builds(
    lambda load, friction, share, how, **fields: wo.RollerProblem(
        load=load, friction=friction, motion="static" if how == "static" else "rolling",
        tangential_load=None if how == "creepage" else share * friction * load,
        creepage=share / 2.1 if how == "creepage" else None, **fields,
    ),
    upper=SOFT, lower=BODY, load=numbers(1e-12, 1e9), friction=numbers(1e-8, 10),
    share=st.floats(-0.99, 0.99), how=st.sampled_from(["static", "rolling", "creepage"]),
)  # fmt: skip


@given(st.one_of(NIP, WRAPPED, ROLLERS), st.booleans())
@settings(max_examples=120)
def test_every_problem_comes_back_equal(problem, comments):
    text = to_toml(problem, comments)
    assert make_problem(tomllib.loads(text)) == problem


WINDING = wo.WindingProblem.example()
WINDER = WINDING.replace(
    winder=wo.TwoDrums(front_drum=wo.Rigid(radius=0.25), gap=0.02, rider_load=2500.0),
    drum=wo.Rigid(radius=0.3), nip_load=None, torque_split=0.5,
)  # fmt: skip
SCHEDULE = wo.Profile(radius=[0.05, 0.6], value=[500.0, 300.0])
MEASURED = {"frequency": [1, 10, 100], "storage_modulus": [8.9e6, 9.9e6, 12.3e6],
            "loss_modulus": [1.2e6, 1.6e6, 2.1e6]}  # fmt: skip
VISCOELASTIC = [
    rubber(),
    wo.LossAngle(youngs_modulus=5e6, poissons_ratio=0.45, loss_angle=0.2, frequency=100.0),
    wo.DynamicTest(**MEASURED, poissons_ratio=0.48),
    wo.RelaxationTest(
        time=["1 ms", "10 ms", "1 s"], modulus=["12 MPa", "10 MPa", "9 MPa"], poissons_ratio=0.48
    ),
    *(wo.RelativeProny(instantaneous_modulus="10 MPa", poissons_ratio=0.45, bulk=bulk,
                       prony_relative=[("30 %", "1 ms")]) for bulk in ("relaxing", "constant")),
]  # fmt: skip


@pytest.mark.parametrize("comments", [False, True])
@pytest.mark.parametrize(
    ("problem", "changes"),
    [
        *((TABLE_2, {"drum": cover(one), "web_speed": 5.0}) for one in VISCOELASTIC),
        (WINDING, {}),
        (WINDING, {"tension_law": "friction"}),
        (WINDING, {"tension_law": "fixed", "nip_induced_tension": wo.Taper(start=100, taper=0.2)}),
        (WINDING, {"tension_law": SCHEDULE}),
        (WINDING, {"torque_split": 0.3, "roll_body": "direct", "drum_wrap": 1.0,
                   "wrap_friction": 0.1}),
        (WINDING, {"nip_load": SCHEDULE}),
        (WINDING, {"inertia": {"core": "12 lb*ft^2", "drum": "60 kg m^2"}}),
        (WINDING, {"core_shrinkage": 1e-3, "moisture_change": SCHEDULE.replace(value=[0, -0.03]),
                   "tangential_swelling": 0.02, "radial_swelling": 0.3, "core_swelling": 0.05}),
        (WINDER, {}),
        (WINDER, {"winder.rider": wo.Rigid(radius=0.1), "winder.rider_friction": 0.3}),
        (WINDER, {"winder.rider_load": wo.Taper(start=3000.0, taper=0.5)}),
        (WINDER, {"winder.front_drum": cover(wo.material("rubber"))}),
        (WINDER, {"winder.core_torque": SCHEDULE.replace(value=[10.0, 30.0])}),
    ],
)  # fmt: skip
def test_a_problem_of_every_sort_comes_back_equal(problem, changes, comments):
    """Schedules, drums, measured materials; a speed is written in its own unit."""
    given = problem.replace(**changes)
    text = to_toml(given, comments)
    assert make_problem(tomllib.loads(text)) == given
    assert ('"5 m/s"' in text) == ("web_speed" in changes)
