"""Case files in, results out: what is read, what is refused and how, what survives a file."""

from __future__ import annotations

import csv
import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
import xarray

import woundon as wo
from woundon import casefile
from woundon.results import NipResult

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


@pytest.fixture(scope="module")
def result() -> NipResult:
    return wo.solve_nip(TABLE_2, nodes=25)


# ---- reading ------------------------------------------------------------------------------------


def test_example_is_table_2():
    assert wo.load_case(EXAMPLE) == TABLE_2


def test_template_is_a_case_ready_to_run(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(casefile.template(), encoding="utf-8")
    assert wo.load_case(path) == TABLE_2


def test_template_names_every_field():
    text = casefile.template()
    models = (wo.NipProblem, wo.Web, wo.Cylinder, wo.Orthotropic, wo.Isotropic)
    missing = [name for model in models for name in model.model_fields if name not in text]
    assert missing == []


def test_covered_drum_of_the_template(tmp_path):
    text = casefile.template()
    kept, _, covered = text.partition("# A covered drum")
    lines = [line.removeprefix("# ") for line in covered.splitlines()[1:]]
    bare = kept[: kept.index("[drum]")]
    path = tmp_path / "case.toml"
    path.write_text(bare + "\n".join(lines), encoding="utf-8")
    drum = wo.load_case(path).drum
    cover = wo.Isotropic(youngs_modulus=10e6, poissons_ratio=0.1)
    assert drum == wo.Cylinder(radius=0.0762, core_radius=0.0562, material=cover)


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
    ],
)
def test_settings(setting, field, value):
    assert wo.load_case(EXAMPLE, [setting]) == TABLE_2.replace(**{field: value})


def test_settings_change_the_kind_of_a_body():
    settings = ["drum.kind=cylinder", "drum.core_radius=70 mm", "drum.material=soft-cover"]
    drum = wo.load_case(EXAMPLE, settings).drum
    assert drum == wo.Cylinder(radius=0.0762, core_radius=0.07, material=wo.material("soft-cover"))


def test_settings_leave_the_tables_as_they_were():
    case = casefile.read_case(EXAMPLE)
    casefile.apply_settings(case, ["web.thickness=57 um"])
    assert case == casefile.read_case(EXAMPLE)


# ---- refusing -----------------------------------------------------------------------------------

# (setting, field named, what the text says); the value is in the text wherever there is one
BAD_SETTINGS = [
    ("nip_load=-3502", "nip_load", "-3502*must be >= 1e-12*[N/m]"),
    ("nip_load=0", "nip_load", "0*must be >= 1e-12*[N/m]"),
    ("nip_load=nan", "nip_load", "nan*not a finite number"),
    ("nip_load=inf", "nip_load", "inf*not a finite number"),
    ("nip_load=1e12", "nip_load", "<= 1e+07 [N/m]"),
    ("nip_load=heavy", "nip_load", "'heavy' is not a number*N/m"),
    ("nip_load='3502 N'", "nip_load", "'3502 N' has the wrong dimension*N/m"),
    ("nip_load=20 plu", "nip_load", "'plu'*did you mean 'pli'?"),
    ("nip_laod=3502", "nip_laod", "did you mean 'nip_load'?"),
    ("wbe.thickness=57 um", "wbe", "did you mean 'web'?"),
    ("web.thicknes=57 um", "web.thicknes", "did you mean 'thickness'?"),
    ("web.thickness=66", "web.thickness", "66*<= 0.01 [m]"),
    ("web.thickness=66 MPa", "web.thickness", "wrong dimension*in m"),
    ("web.thickness=0", "web.thickness", "[m]"),
    ("web.material=newsprnt", "web.material", "'newsprnt'*did you mean 'newsprint'?"),
    ("web.material.shear=0", "web.material.shear", "must be >= 0.001*[Pa]"),
    ("roll.material.cross=400 MPa", "roll.material.cross", "sqrt(radial * tangential)"),
    ("roll.material.cross=-1", "roll.material.cross", "must be >= 0*[Pa]"),
    ("roll.core_radius=100 mm", "roll.core_radius", "0.1*radius"),
    ("roll.core_radius=0", "roll.core_radius", "> 0 [m]"),
    ("roll.kind=cylindre", "roll.kind", "'cylindre'*did you mean 'cylinder'?"),
    ("roll.radius=-0.1", "roll.radius", "[m]"),
    ("drum.core_radius=50 mm", "drum.core_radius", "no such field"),
    ("roll_friction=0", "roll_friction", ">= 1e-08"),
    ("roll_friction=-0.1", "roll_friction", ">= 1e-08"),
    ("roll_friction=0.2 N", "roll_friction", "wrong dimension*plain number"),
    ("web_tension=-1 N/m", "web_tension", "must be >= 0*[N/m]"),
    ("winding_force=800", "winding_force", "800*drum_friction * nip_load = 700.4 [N/m]"),
    ("winding_force=-700.5 N/m", "winding_force", "-700.5*700.4 [N/m]"),
    ("nip_load", "nip_load", "write field=value"),
    ("=3", "=3", "write field=value"),
    ("nip_load.x=3", "nip_load.x", "nip_load has no fields of its own"),
    ("schema=2", "schema", "reads schema = 1"),
]


@pytest.mark.parametrize(("setting", "field", "said"), BAD_SETTINGS)
def test_bad_value_is_refused(setting, field, said):
    with pytest.raises(wo.InvalidProblem) as refusal:
        wo.load_case(EXAMPLE, [setting])
    faults = dict(refusal.value.faults)
    assert list(faults) == [field], "one fault, and no other is told"
    for part in said.split("*"):
        assert part in faults[field]


def test_a_sliding_drum_has_no_steady_state():
    with pytest.raises(wo.NoSteadyState):
        wo.load_case(EXAMPLE, ["winding_force=800"])


def test_incompressible_cover_is_refused():
    settings = ["drum.kind=half_plane", "drum.material.youngs_modulus=1 MPa"]
    with pytest.raises(wo.InvalidProblem, match=r"drum.material.poissons_ratio: .*< 0.5"):
        wo.load_case(EXAMPLE, [*settings, "drum.material.poissons_ratio=0.5"])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty; 'woundon new > case.toml' writes a case"),
        ("# only a comment\n", "is empty"),
        ("schema = 1\nnip_load = 3502 N/m\n", "is no valid TOML*line 2"),
        ("schema = 1\n[web\n", "is no valid TOML*line 2"),
        ("schema = 1\nnip_load = 1\nnip_load = 2\n", "is no valid TOML*line 3"),
        (b"\xff\xfe\x00", "is no UTF-8 text, from byte 0"),
    ],
)
def test_bad_file_is_refused(tmp_path, text, said):
    path = tmp_path / "case.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(wo.InvalidProblem) as refusal:
        wo.load_case(path)
    ((field, fault),) = refusal.value.faults
    assert field == str(path)
    for part in said.split("*"):
        assert part in fault


def test_missing_file_and_folder_are_refused(tmp_path):
    with pytest.raises(wo.InvalidProblem, match="cannot be read: No such file"):
        wo.load_case(tmp_path / "none.toml")
    with pytest.raises(wo.InvalidProblem, match="cannot be read"):
        wo.load_case(tmp_path)


def test_missing_fields_and_schema_are_named(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text('[web]\nthickness = "66 um"\n', encoding="utf-8")
    with pytest.raises(wo.InvalidProblem) as refusal:
        wo.load_case(path)
    faults = dict(refusal.value.faults)
    assert "write 'schema = 1'" in faults["schema"]
    assert {"web.material", "roll", "drum", "nip_load", "roll_friction"} <= faults.keys()


def test_all_faults_are_told_at_once():
    settings = ["nip_load=-1", "web.thickness=66 kg", "roll_fricton=0.2"]
    with pytest.raises(wo.InvalidProblem) as refusal:
        wo.load_case(EXAMPLE, settings)
    assert {"nip_load", "web.thickness", "roll_fricton"} == dict(refusal.value.faults).keys()


def test_loose_field_below_a_section_gets_its_place(tmp_path):
    text = EXAMPLE.read_text(encoding="utf-8").replace('nip_load      = "3502 N/m"\n', "")
    path = tmp_path / "case.toml"
    path.write_text(text + 'nip_load = "3502 N/m"\n', encoding="utf-8")
    with pytest.raises(wo.InvalidProblem) as refusal:
        wo.load_case(path)
    assert "write nip_load above the first [section]" in dict(refusal.value.faults)["drum.nip_load"]


# ---- results to files and back ------------------------------------------------------------------


def assert_same(one: NipResult, other: NipResult) -> None:
    for field in dataclasses.fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, np.ndarray):
            assert a.dtype == b.dtype, field.name
            np.testing.assert_array_equal(a, b, err_msg=field.name)
        else:
            assert a == b or (a != a and b != b), field.name


@pytest.mark.parametrize("ending", ["nc", "json"])
@pytest.mark.parametrize("error", [0.25, float("nan")])
def test_a_result_comes_back_bit_for_bit(result, tmp_path, ending, error):
    told = dataclasses.replace(
        result, nip_induced_tension_error=error, warnings=("4 nodes in the dual-slip zone",)
    )
    path = tmp_path / f"nip.{ending}"
    told.save(path)
    assert_same(told, wo.load_result(path))


@pytest.mark.parametrize("ending", ["nc", "json", "csv"])
def test_the_same_result_gives_the_same_bytes(result, tmp_path, ending):
    one, other = tmp_path / f"a.{ending}", tmp_path / f"b.{ending}"
    result.save(one)
    result.save(other)
    assert one.read_bytes() == other.read_bytes()


@pytest.mark.parametrize(("motion", "unit"), [("rolling", "1"), ("static", "m")])
def test_rollers_come_back_too(tmp_path, motion, unit):
    roller = wo.HalfPlane(radius=0.25, material="steel")
    pair = wo.RollerProblem(
        upper=roller, lower=roller, load=89e3, tangential_load=8.4e3, friction=0.5, motion=motion
    )
    solved = wo.solve_rollers(pair, nodes=25)
    for ending in ("nc", "json"):
        casefile.save_result(solved, tmp_path / f"pair.{ending}")
        assert_same(solved, wo.load_result(tmp_path / f"pair.{ending}"))
    with xarray.open_dataset(tmp_path / "pair.nc") as data:
        assert data.slip.attrs["units"] == unit


def test_netcdf_is_labelled(result, tmp_path):
    result.save(tmp_path / "nip.nc")
    with xarray.open_dataset(tmp_path / "nip.nc") as data:
        assert data.pressure.attrs["units"] == "Pa"
        assert data.x.attrs["units"] == "m"
        assert data.wound_on_tension.attrs["long_name"] == "wound-on tension"
        assert float(data.wound_on_tension) == result.wound_on_tension
        assert json.loads(data.attrs["problem"])["nip_load"] == 3502.0
        assert data.attrs["version"] == wo.__version__
        assert float(data.residual.max()) == result.residuals.largest
        # labelled by position: the pressure nearest the middle of the nip
        assert float(data.pressure.sel(x=0, method="nearest")) > 0.9 * result.pressure.max()
        assert all("units" in variable.attrs for name, variable in data.variables.items()
                   if name != "law")  # fmt: skip


def test_csv_has_units_in_its_header(result, tmp_path):
    result.save(tmp_path / "nip.csv")
    with open(tmp_path / "nip.csv", encoding="utf-8", newline="") as file:
        header, *rows = csv.reader(file)
    assert {"x [m]", "slip_x [m]", "pressure [Pa]", "roll_traction [Pa]"} <= set(header)
    table = np.array(rows, dtype=float)
    np.testing.assert_array_equal(table[:, header.index("pressure [Pa]")], result.pressure)


def test_json_is_strict_and_tells_units(result, tmp_path):
    dataclasses.replace(result, nip_induced_tension_error=float("nan")).save(tmp_path / "a.json")

    def refuse(word: str) -> None:
        raise AssertionError(f"{word} is no JSON")

    record = json.loads((tmp_path / "a.json").read_text(), parse_constant=refuse)
    assert record["units"]["nip_induced_tension"] == "N/m"
    assert record["nip_induced_tension_error"] is None


def test_unknown_ending_is_refused(result, tmp_path):
    with pytest.raises(
        wo.InvalidProblem, match=r"'.xls' names no format; must be .nc, .json, .csv"
    ):
        result.save(tmp_path / "nip.xls")


@pytest.mark.parametrize("content", [b"", b"{}", b"[1]", b"CDF\x01rubbish", b'{"format": 3}'])
@pytest.mark.parametrize("ending", ["nc", "json"])
def test_a_file_that_is_no_result_is_refused(tmp_path, content, ending):
    path = tmp_path / f"other.{ending}"
    path.write_bytes(content)
    with pytest.raises(wo.InvalidProblem, match="is no result saved by this version"):
        wo.load_result(path)


def test_an_interrupted_write_keeps_the_old_file(result, tmp_path, monkeypatch):
    path = tmp_path / "nip.json"
    path.write_text("old")

    def full_disk(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("woundon.resultfile.os.replace", full_disk)
    with pytest.raises(OSError, match="No space left"):
        result.save(path)
    assert [file.name for file in tmp_path.iterdir()] == ["nip.json"]
    assert path.read_text() == "old"
