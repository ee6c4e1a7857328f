"""Results to files and back: what survives, what is reported to readers, what is refused."""

from __future__ import annotations

import csv
import json
import re
import time
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import pytest
import xarray
from thesis_cases import film_nip, newsprint_nip

import woundon as wo
from woundon import kinds
from woundon.io import result_files, seals
from woundon.io.case_texts import to_toml
from woundon.problems.fields import Number
from woundon.quantities import length, line_load, outputs, scalar_outputs, stress, value_of
from woundon.results import Residuals

NIP = newsprint_nip()
PAIR = wo.RollerProblem.example()

CASES: dict[str, Any] = {
    "nip": lambda: wo.solve(NIP, nodes=25),
    "nip_rtol": lambda: wo.solve(NIP, rtol=1e-4),
    "wrapped": lambda: wo.solve(
        NIP.replace(roll_wrap=np.pi, drum_wrap=1.0, wrap_friction=0.25), nodes=33
    ),
    "air": lambda: wo.solve(film_nip(), nodes=25),
    "rolling": lambda: wo.solve(PAIR, nodes=25),
    "static": lambda: wo.solve(PAIR.replace(motion="static"), nodes=25),
}
MAIN = ["nip", "wrapped", "air", "rolling"]


@pytest.fixture(scope="module")
def solved() -> Any:
    made: dict[str, Any] = {}

    def of(name: str) -> Any:
        if name not in made:
            made[name] = CASES[name]()
        return made[name]

    return of


# ---- there and back -----------------------------------------------------------------------------


@pytest.mark.parametrize("ending", ["nc", "json"])
@pytest.mark.parametrize("name", CASES)
def test_a_result_comes_back_bit_for_bit(solved, tmp_path, name, ending):
    computed = solved(name).replace(warnings=("4 nodes in the dual-slip zone",))
    path = tmp_path / f"result.{ending}"
    computed.save(path)
    loaded = wo.load_result(path)
    assert loaded == computed
    for place in outputs(computed):
        one, other = value_of(computed, place.path), value_of(loaded, place.path)
        assert np.asarray(one).dtype == np.asarray(other).dtype, place.path
        np.testing.assert_array_equal(one, other, err_msg=place.path)


@pytest.mark.parametrize("ending", ["nc", "json", "csv"])
def test_the_same_result_gives_the_same_bytes(solved, tmp_path, ending):
    one, other = tmp_path / f"a.{ending}", tmp_path / f"b.{ending}"
    solved("wrapped").save(one)
    solved("wrapped").save(other)
    assert one.read_bytes() == other.read_bytes()


@pytest.mark.parametrize("name", CASES)
def test_a_loaded_result_is_as_good_as_a_solved_one(solved, tmp_path, name):
    """Its mesh is restored from x and slip_x, so that it certifies itself, bit for bit."""
    solved(name).save(tmp_path / "result.json")
    loaded = wo.load_result(tmp_path / "result.json")
    assert loaded.refinement is None
    assert loaded.certified().largest <= 1e-8
    assert not loaded.x.flags.writeable
    if name == "wrapped":
        exact, again = solved(name).sensitivity(), loaded.sensitivity()
        # rounding of 1e-12 over steps of 1e-4
        np.testing.assert_allclose(again.elasticities, exact.elasticities, rtol=1e-7, atol=1e-8)


def test_what_is_not_known_is_reported_and_left_out(solved, tmp_path):
    record = json.loads(result_files.to_json(solved("nip")))
    record["fields"]["temperature"] = 300.0
    (tmp_path / "nip.json").write_text(sealed(record))
    with pytest.warns(UserWarning, match="not known to this version of woundon.*: temperature"):
        loaded = wo.load_result(tmp_path / "nip.json")
    assert loaded == solved("nip")
    data = solved("nip").to_xarray()
    data["temperature"] = ((), 300.0)
    (tmp_path / "nip.nc").write_bytes(sealed_netcdf(data))
    with pytest.warns(UserWarning, match="ignored: temperature"):
        assert wo.load_result(tmp_path / "nip.nc") == solved("nip")


VERSION_0_3_1 = Path(__file__).parents[1] / "golden" / "version_0_3_1"
ADDED = (
    *("next_nips", "winder", "thickness_profile", "oscillation", "core_removed", "inertia"),
    *("moisture_change", "tangential_swelling", "radial_swelling", "core_swelling"),
    *("drum_bending", "core_bending"),
)
# a nip had a speed and no density, a roll the reverse; a winding had no changes of its roll
ADDED_TO_SOME = (
    *("density", "web_speed", "temperature_change", "core_shrinkage"),
    *("tangential_expansion", "radial_expansion", "core_expansion"),
)


OF_VERSION_0_3_1 = sorted(path.stem for path in VERSION_0_3_1.glob("*.toml"))


@pytest.mark.parametrize("name", ["roll", "winding"])
def test_rolls_of_version_0_3_1_are_solved_again(name):
    """Their pressures are those of infinitely thin layers."""
    for ending in ("json", "nc"):
        with pytest.warns(UserWarning, match="of woundon 0.3.1.*has been solved again"):
            result = wo.load_result(VERSION_0_3_1 / f"{name}.{ending}")
        assert result.problem == wo.load_case(VERSION_0_3_1 / f"{name}.toml")
        saved = json.loads((VERSION_0_3_1 / f"{name}.json").read_text("utf-8"))["outputs"]
        more = result.core_pressure / saved["core_pressure"] - 1
        assert 0.02 < more < 0.06  # 4.9 and 4.0 % were stated as the effect of the layers
        assert result.residuals.largest <= 1e-8


@pytest.mark.parametrize("change", [{"problem": 5}, {"problem": None}])
def test_damaged_rolls_of_version_0_3_1_are_rejected(tmp_path, change):
    record = json.loads((VERSION_0_3_1 / "roll.json").read_text("utf-8")) | change
    path = tmp_path / "a[1]*'.json"
    path.write_text(sealed({key: value for key, value in record.items() if value is not None}))
    with pytest.raises(wo.InvalidProblem, match=r"a\[1\]\*'.json.*is not a result saved"):
        wo.load_result(path)


@pytest.mark.parametrize("name", sorted({*OF_VERSION_0_3_1} - {"roll", "winding"}))
def test_files_of_version_0_3_1_are_read_and_written_alike(tmp_path, name):
    """Its cases and results are read; written again they have the same values.

    Added are fields that the version does not know, with their default values.
    """
    paths = {ending: VERSION_0_3_1 / f"{name}.{ending}" for ending in ("toml", "json", "nc")}
    result = wo.load_result(paths["nc"])
    assert result == wo.load_result(paths["json"])
    assert result.problem == wo.load_case(paths["toml"])
    written = to_toml(result.problem).splitlines(keepends=True)
    kept = paths["toml"].read_text("utf-8").splitlines(keepends=True)
    left_out = {*ADDED} - {line.partition(" ")[0] for line in kept}
    known = [line for line in written if line.partition(" ")[0] not in left_out]
    # equals signs are aligned with the longest name, which may be one of the added fields
    assert [line.split() for line in known] == [line.split() for line in kept]
    records, data = [], []
    result.save(tmp_path / "written.json")
    result.save(tmp_path / "written.nc")
    for path in (paths["json"], tmp_path / "written.json"):
        record = json.loads(path.read_text("utf-8"))
        records.append({key: record[key] for key in record if key not in ("version", "sha256")})
    for path in (paths["nc"], tmp_path / "written.nc"):
        with xarray.open_dataset(path, engine="scipy", decode_times=False) as dataset:
            data.append(dataset.load())
        del dataset.attrs["version"], dataset.attrs["sha256"]
        dataset.attrs["problem"] = json.loads(dataset.attrs["problem"])
    known_record = as_known(records[1], records[0])
    # outputs are computed when a file is written: rounding
    computed, before = (record.pop("outputs") for record in (known_record, records[0]))
    assert computed.keys() == before.keys()
    for key, value in computed.items():
        assert value == (None if before[key] is None else pytest.approx(before[key], rel=1e-9))
    assert records[0] == known_record
    known_data = data[1].drop_vars(set(data[1]) - set(data[0]))
    xarray.testing.assert_allclose(known_data, data[0], rtol=1e-9)
    assert as_known(known_data.attrs, data[0].attrs) == data[0].attrs
    assert all(known_data[each].attrs == data[0][each].attrs for each in data[0])
    added = set(records[1]["problem"]) - set(records[0]["problem"])
    assert added <= {*ADDED, *ADDED_TO_SOME}


def as_known(new, old):
    """Return a record without the entries that an older one does not have."""
    if not isinstance(new, dict) or not isinstance(old, dict):
        return new
    return {key: as_known(value, old[key]) for key, value in new.items() if key in old}


# ---- for readers --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["nip", "wrapped", "air", "rolling", "static"])
def test_netcdf_is_labelled(solved, tmp_path, name):
    result = solved(name)
    result.save(tmp_path / "result.nc")
    with xarray.open_dataset(tmp_path / "result.nc") as data:
        for place in outputs(result):
            if place.path == "residual" or np.size(value_of(result, place.path)) == 0:
                assert place.path == "residual" or place.path not in data
                continue
            labels = data[place.path].attrs
            assert labels["units"] == place.quantity.unit
            assert labels["symbol"] == place.quantity.symbol
            assert labels["long_name"] == place.quantity.meaning
        for output, quantity in scalar_outputs(result).items():
            if output == "residual":  # law by law, below
                continue
            np.testing.assert_array_equal(float(data[output]), value_of(result, output))
            if output in result.errors:
                error = data[f"{output}_error"]
                assert error.attrs["units"] == quantity.unit
                np.testing.assert_array_equal(float(error), result.errors[output])
        assert json.loads(data.attrs["problem"]) == result.problem.model_dump(mode="json")
        assert data.attrs["version"] == wo.__version__
        assert data.attrs["kind"] == kinds.of(result).name
        assert float(data.residual.max()) == result.residuals.largest
        assert list(data.condition.values) == [law for law, _ in result.residuals.items()]
        # labelled by position: the pressure nearest the middle of the nip
        pressure = data[result.CONTACT_PRESSURE]
        assert float(pressure.sel(x=0, method="nearest")) > 0.9 * result.peak_pressure
        unlabelled = {name for name, v in data.variables.items() if "units" not in v.attrs}
        assert unlabelled == {"condition"}


@pytest.mark.parametrize("name", MAIN)
def test_csv_has_units_in_its_header(solved, tmp_path, name):
    result = solved(name)
    result.save(tmp_path / "result.csv")
    lines = (tmp_path / "result.csv").read_text("utf-8").splitlines()
    header, *rows = csv.reader(line for line in lines if not line.startswith("#"))
    assert {"x [m]", "slip_x [m]", f"{result.CONTACT_PRESSURE} [Pa]"} <= set(header)
    table = np.array(rows, dtype=float)
    for place in outputs(result):
        value = value_of(result, place.path)
        if isinstance(value, np.ndarray) and value.size == result.x.size:
            unit = f" [{place.quantity.unit}]" if place.quantity.unit != "1" else ""
            column = header.index(f"{place.path}{unit}")
            np.testing.assert_array_equal(table[:, column], value)


@pytest.mark.parametrize(
    ("changes", "rows"),
    [
        (
            {"thickness_profile": wo.ThicknessProfile(position=[0, 2], thickness=[6.6e-5, 6.7e-5])},
            {"thickness_profile.position [m]": ["0.0", "2.0"],
             "thickness_profile.thickness [m]": ["6.6e-05", "6.7e-05"]},
        ),
        (
            {"wound_on_tension": wo.Profile(radius=[0.04, 0.1, 0.2], value=[400, 350, 300])},
            {"wound_on_tension.radius [m]": ["0.04", "0.1", "0.2"],
             "wound_on_tension.value [N/m]": ["400.0", "350.0", "300.0"]},
        ),
    ],
)  # fmt: skip
def test_csv_has_a_cell_for_each_item_of_a_profile(changes, rows, tmp_path):
    wo.solve(wo.RollProblem.example().replace(**changes)).save(tmp_path / "roll.csv")
    lines = (tmp_path / "roll.csv").read_text("utf-8").splitlines()
    found = {name.removeprefix("# "): cells for name, *cells in csv.reader(lines)}
    assert {name: found.get(name) for name in rows} == rows


def test_json_is_strict_complete_and_tells_units(solved, tmp_path):
    result = solved("wrapped").replace(errors={"wound_on_tension": float("nan")})
    result.save(tmp_path / "a.json")

    def refuse(word: str) -> None:
        raise AssertionError(f"{word} is not JSON")

    record = json.loads((tmp_path / "a.json").read_text(), parse_constant=refuse)
    assert (record["format"], record["schema"], record["kind"]) == (
        "woundon-result", 5, "nip",
    )  # fmt: skip
    assert record["errors"] == {"wound_on_tension": None}
    computed = record["fields"] | record["outputs"]
    for place in outputs(result):
        assert record["units"][place.path] == place.quantity.unit
        is_empty = np.size(value_of(result, place.path)) == 0  # arrays of what there is not
        assert (place.path in computed) != is_empty
    assert computed["wound_on_tension"] == result.wound_on_tension
    assert computed["drum_slip"][-1] is None  # the web touches the roll alone there
    assert record["warnings"] == list(result.warnings)


# ---- kinds and outputs from outside the package -------------------------------------------------


class SpringProblem(wo.Problem):
    """A line of springs under a load."""

    load: Annotated[Number, line_load("P", "load")]


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class SpringResult(wo.Result):
    """Arrays of two lengths, a table, a word, a pair and something that is not saved."""

    place: Annotated[np.ndarray, length("s", "place of a spring")]
    push: Annotated[np.ndarray, stress("p", "push of a spring")]
    mode: Annotated[np.ndarray, length("k", "number of a mode")]
    table: Annotated[np.ndarray, length("u", "modes, by spring")]
    bare: np.ndarray
    word: str = "stiff"
    pair: tuple[int, ...] = (1, 2)
    parts: tuple[tuple[float, str], ...] = ((0.5, "a"), (np.nan, "b"))
    helper: Any = None

    @property
    def total(self) -> Annotated[float, line_load("P_s", "sum of the pushes")]:
        """Their sum."""
        return float(self.push.sum())

    def certified(self) -> Residuals:
        """Measure the one law."""
        return Residuals(balance=abs(self.total - self.problem.load))


@pytest.fixture
def springs() -> SpringResult:
    kinds.register(SpringProblem, lambda problem: None, SpringResult)
    return SpringResult(
        problem=SpringProblem(load=6.0), place=np.arange(3.0), push=np.array([1.0, 2.0, 3.0]),
        mode=np.arange(2.0), table=np.arange(6.0).reshape(3, 2), bare=np.array([np.nan, 1, 2]),
        residuals=Residuals(balance=0.0), errors={"total": 0.5},
    )  # fmt: skip


@pytest.mark.parametrize("ending", ["nc", "json"])
def test_a_kind_from_outside_is_saved_and_loaded(springs, tmp_path, ending):
    path = tmp_path / f"springs.{ending}"
    springs.save(path)
    assert wo.load_result(path) == springs
    springs.replace(push=np.ones(3)).save(path)
    assert re.search(r"the contents of the file do not match: .*balance 3", refusal(path))


def test_what_no_file_holds_is_rejected_by_name(springs, tmp_path):
    with pytest.raises(wo.InvalidProblem, match=r"helper: a object cannot be saved; .*'saved'"):
        springs.replace(helper=object()).save(tmp_path / "springs.json")
    assert list(tmp_path.iterdir()) == []


# ---- refused ------------------------------------------------------------------------------------


def refusal(path: Path) -> str:
    """Return the message with which a file is refused."""
    with pytest.raises(wo.InvalidProblem) as error:
        wo.load_result(path)
    return str(error.value)


@pytest.mark.parametrize(
    "content",
    [
        b"", b"{}", b"[1]", b"CDF\x01rubbish", b'{"format": 3}', b"[" * 100_000, b"\xff\xfe",
        b'{"format": "woundon-result"}', b'{"format": "woundon-study", "sha256": "0"}',
    ],
    ids=lambda content: repr(content[:12]),
)  # fmt: skip
@pytest.mark.parametrize("ending", ["nc", "json"])
def test_a_file_that_is_no_result_is_rejected(tmp_path, content, ending):
    path = tmp_path / f"other.{ending}"
    path.write_bytes(content)
    assert refusal(path) == f"{path}: is not a result saved by woundon, or is damaged"


def test_another_schema_and_an_unknown_kind_are_reported(solved, tmp_path):
    record, path = json.loads(result_files.to_json(solved("nip"))), tmp_path / "nip.json"
    path.write_text(sealed(record | {"schema": 3}))
    assert re.search("schema: 3 is unknown; .* reads 5", refusal(path))
    path.write_text(sealed(record | {"kind": "nap"}))
    assert "'nap' is not a kind of problem; did you mean 'nip'" in refusal(path)


OTHER = "the contents of the file do not match: "
UNMET = "contact conditions are not satisfied to 1e-8: "
# (result, path of the damaged part of its record, value in its place, part of the error)
DAMAGE: list[tuple[str, str, Any, str]] = [
    ("nip", "fields.x", [0.0] * 25, "x: must be increasing"),
    ("nip", "fields.x", 1.0, "x: must be a list of finite numbers"),
    ("nip", "fields.drum_pressure", [1.0] * 24, "pressure: has 24 values; must be 25, as x"),
    ("nip", "fields.drum_pressure", [None] * 25, "pressure: must be a list of finite numbers"),
    ("nip", "fields.drum_pressure", ["1"] * 25, "pressure: must be a list of finite numbers"),
    ("nip", "fields.drum_pressure", [[1.0], 2.0], "damaged"),
    ("nip", "fields.roll_zone.3", 7, "roll_zone: must be a list of zones, -1, 0 or 1"),
    ("nip", "fields.half_width", "wide", "half_width: 'wide' is not a finite number"),
    ("nip", "fields.half_width", ..., "half_width: missing"),
    ("nip", "fields.iterations", 3.5, "iterations: 3.5 is out of place; must be a whole number"),
    ("nip", "fields", {}, "roll_wound_on_tension: missing"),
    ("nip", "residuals.stick", None, "residuals.stick: None is not a finite number"),
    ("nip", "residuals.stick", 1.0, f"residuals: {UNMET}stick 1"),
    ("nip", "residuals", {}, f"residuals: {UNMET}no condition was evaluated"),
    ("nip", "errors.half_width", "small", "errors.half_width: 'small' is not a finite number"),
    ("nip", "problem.nip_load", -1, "nip_load: -1 is out of range"),
    ("nip", "problem.web", None, "web: None is out of place"),
    ("nip", "warnings", 3, "damaged"),
    ("nip", "kind", None, "'None' is not a kind of problem"),
    ("nip", "outputs.nip_induced_tension", 9999.0, OTHER),
    ("nip", "fields.roll_wound_on_tension", 9999.0, OTHER),
    ("nip", "problem.nip_load", 3503.0, OTHER),
    ("nip", "problem.web.thickness", 67e-6, OTHER),
    ("nip", "fields.roll_traction.9", 0.0, OTHER),
    ("nip", "fields.drum_creepage", 0.0, OTHER),
    ("nip", "fields.half_width", 2.6e-3, OTHER),
    ("wrapped", "fields.tension.20", 9999.0, OTHER),
    ("wrapped", "fields.curvature.20", 0.0, OTHER),
    ("wrapped", "problem.roll_wrap", 3.0, OTHER),
    ("air", "fields/air.film", 1e-6, OTHER),
    ("air", "fields/air.thickness/9", 0.0, OTHER),
    ("rolling", "fields.traction.9", 0.0, OTHER),
    ("rolling", "fields.creepage", 0.0, OTHER),
    ("static", "fields.shift", 0.0, OTHER),
    ("nip", "outputs.peak_pressure", 9999.0, f"{OTHER}peak_pressure: 9999.0, but the arrays give "),
    ("nip", "fields.approach", 9999.0, f"{OTHER}approach: 9999.0, but the arrays give "),
    ("nip", "fields.leading_roll", 0.9, f"{OTHER}leading_roll: 0.9, but the arrays give -0.1"),
    ("wrapped", "outputs.wound_on_tension", None, f"{OTHER}wound_on_tension: nan, but the arrays"),
    ("wrapped", "fields.approach", 9999.0, f"{OTHER}approach: 9999.0, but the arrays give "),
    ("wrapped", "fields.dual", 0.9, f"{OTHER}dual: 0.9, but the arrays give "),
    ("rolling", "fields.approach", 9999.0, f"{OTHER}{UNMET}approach "),
    ("static", "fields.approach", 9999.0, f"{OTHER}{UNMET}approach "),
]


def sealed(record: dict[str, Any]) -> str:
    """Return a record as JSON, sealed as if woundon had written it."""
    return json.dumps(record | {"sha256": seals.of_record(record)})


def sealed_netcdf(data: xarray.Dataset) -> bytes:
    data = data.assign_attrs(sha256=seals.BLANK)
    return seals.sealed_bytes(bytes(data.to_netcdf(engine="scipy")))


def damaged(result: Any, place: str, value: Any) -> str:
    """Return a result's record with one part changed, or missing (...), sealed again."""
    record = json.loads(result_files.to_json(result))
    *heads, last = place.split("/" if "/" in place else ".")  # names of an air film hold a dot
    inner = record
    for head in heads:
        inner = inner[head]
    key: Any = int(last) if isinstance(inner, list) else last
    if value is ...:
        del inner[key]
    else:
        inner[key] = value
    return sealed(record)


@pytest.mark.parametrize(("name", "place", "value", "said"), DAMAGE)
def test_damage_is_rejected_by_name(solved, tmp_path, name, place, value, said):
    """By the shapes of the record, the residuals, or the outputs that the arrays give."""
    path = tmp_path / "result.json"
    path.write_text(damaged(solved(name), place, value))
    text = refusal(path)
    assert text.startswith(f"{path}")
    assert said in text
    assert len(text.splitlines()) == 1


@pytest.mark.parametrize("name", ["nip", "wrapped", "rolling"])
def test_a_file_with_too_many_nodes_is_rejected_before_its_matrices_are_computed(
    solved, tmp_path, name
):
    result, size = solved(name), 50_000  # a matrix would take 20 GB
    arrays = {part.name: value for part in fields(result)
              if isinstance(value := getattr(result, part.name), np.ndarray)}  # fmt: skip
    grown = {key: np.interp(np.linspace(0, 1, size), np.linspace(0, 1, value.size), value)
             for key, value in arrays.items() if value.size}  # fmt: skip
    grown = {key: value.astype(arrays[key].dtype) for key, value in grown.items()}
    result.replace(**grown).save(tmp_path / "large.nc")
    start = time.process_time()
    assert "the contents of the file do not match" in refusal(tmp_path / "large.nc")
    assert time.process_time() - start < 5.0  # of the parser


# ---- the seal -----------------------------------------------------------------------------------

CHANGED = (
    "sha256: its content has changed since it was saved; load an unchanged copy, "
    "or solve the problem again"
)
GONE = "sha256: missing; the file was not written by result.save, or has changed since"


def test_json_may_be_laid_out_again(solved, tmp_path):
    solved("wrapped").save(tmp_path / "a.json")
    record, path = json.loads((tmp_path / "a.json").read_text()), tmp_path / "b.json"
    turned = dict(reversed(record.items()))
    for text in (json.dumps(record), json.dumps(turned, indent=4).replace("\n", "\r\n")):
        path.write_bytes(text.encode())
        assert wo.load_result(path) == solved("wrapped")


def test_a_damaged_netcdf_file_is_rejected_before_it_is_taken_apart(solved, tmp_path, monkeypatch):
    path = tmp_path / "nip.nc"
    solved("nip").save(path)
    content = path.read_bytes()
    # not the seal's own head: without it a file has no seal, and is taken apart to be reported so
    head = content.index(b"\0\0\0\x06sha256")
    places = [k for k in range(4, len(content), 37) if not head <= k < head + 20]
    monkeypatch.setattr(xarray, "open_dataset", lambda *_, **__: pytest.fail("taken apart"))
    for place in places:
        flipped = bytearray(content)
        flipped[place] ^= 1
        path.write_bytes(flipped)
        assert refusal(path) == f"{path}: {CHANGED}"
    assert len(places) > 200


def test_a_file_that_lost_its_seal_is_rejected(solved, tmp_path):
    record, path = json.loads(result_files.to_json(solved("nip"))), tmp_path / "a"
    del record["sha256"]
    path.write_text(json.dumps(record))
    assert refusal(path) == f"{path}: {GONE}"
    solved("nip").to_xarray().to_netcdf(path, engine="scipy")
    assert refusal(path) == f"{path}: {GONE}"


def test_a_table_is_no_result(solved, tmp_path):
    path = tmp_path / "nip.csv"
    solved("nip").save(path)
    expected = "is a table for spreadsheets; load the .nc or .json file of the result"
    assert refusal(path) == f"{path}: {expected}"
