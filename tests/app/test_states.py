"""States over HTTP are those of wo.solve, to the last digit; refusals those of everywhere."""

import json
import math
import time
from concurrent.futures import ThreadPoolExecutor

import httpx
import numpy as np
import pytest

import woundon as wo
from woundon import kinds
from woundon.errors import unwarned
from woundon.quantities import scalar_outputs, value_of

KINDS = [kind.name for kind in kinds.every()]


def same(message, value):
    """Tell whether a number over the wire is the one that was solved; null is nan."""
    return math.isnan(value) if message is None else message == value


# a winding whose nips are solved takes seconds here and there
STATES = [(name, {"tension_law": "friction"} if name == "winding" else {}) for name in KINDS]


@pytest.mark.parametrize(
    ("name", "changes"), [*STATES, pytest.param("winding", {}, marks=pytest.mark.slow)]
)
def test_a_state_is_that_of_solve_to_the_last_digit(client, cases, name, changes):
    answer = client.post("/api/solve", json=cases[name] | changes)
    assert answer.status_code == 200
    record = answer.json()
    with unwarned():
        result = wo.solve(kinds.named(name).example().replace(**changes))
    # other tests may have given results of this process more outputs
    assert set(type(result).MAIN) <= set(record["outputs"]) <= set(scalar_outputs(result))
    for output in record["outputs"]:
        assert same(record["outputs"][output]["value"], float(value_of(result, output))), output
    for output, error in result.errors.items():
        assert same(record["outputs"][output]["error"], error)
    for array, values in record["arrays"].items():
        solved = np.asarray(getattr(result, array), dtype=float)
        np.testing.assert_array_equal(np.array(values, dtype=float), solved)
    assert record["certificate"]["ok"]
    assert record["certificate"]["conditions"] == dict(result.residuals.items())
    assert record["warnings"] == list(result.warnings)


def test_options_of_the_solver_come_with_the_address(client, cases):
    answer = client.post("/api/solve?nodes=41", json=cases["nip"]).json()
    first, last = answer["nip"]
    assert last - first + 1 == 41
    refused = client.post("/api/solve?knots=41", json=cases["nip"]).json()
    assert refused["errors"][0]["field"] == "knots"
    refused = client.post("/api/solve?nodes=many", json=cases["nip"]).json()
    assert refused["detail"] == "nodes: 'many' is out of place; must be a whole number"


def test_a_warm_state_is_that_of_few_nodes_and_agrees_with_a_cold_one(client, cases):
    """The same equations on the same nodes as wo.solve; a cold one within both error estimates."""
    client.post("/api/solve", json=cases["nip"])
    near = cases["nip"] | {"nip_load": 3600.0}
    # the first one has error estimates, since the converged state has other nodes
    client.post("/api/solve?warm=true", json=cases["nip"] | {"nip_load": 3550.0})
    warm = client.post("/api/solve?warm=true", json=near).json()["outputs"]
    cold = client.post("/api/solve", json=near).json()["outputs"]
    coarse = wo.solve(wo.NipProblem.example().replace(nip_load=3600.0), nodes=49)
    for name in ("nip_induced_tension", "half_width"):
        assert warm[name]["error"] is None
        # another initial guess: to the tolerance of the iteration
        assert warm[name]["value"] == pytest.approx(getattr(coarse, name), rel=1e-7)
        estimate = coarse.errors[name] + cold[name]["error"]
        assert warm[name]["value"] == pytest.approx(cold[name]["value"], rel=0, abs=estimate)


def test_a_report_is_of_the_state_that_its_session_has_seen(cases, monkeypatch):
    """Not solved again, unless the state was started from another or is of other options."""
    from woundon.app import computations

    solved, begun = computations.solved, []

    def counted(problem, options, start=None, warm=False):
        begun.append((dict(options), start is not None))
        return solved(problem, options, start, warm)

    monkeypatch.setattr(computations, "solved", counted)

    def outputs(*given):
        return json.loads(computations.solve(cases["nip"], *given))["outputs"]

    few, session = {"nodes": "33"}, "session-of-a-report"
    assert outputs(few, session) == outputs(few, session, False, True)
    assert begun == [(few, False)]
    outputs(few, session, True)
    outputs(few, session, False, True)
    outputs({}, session)
    assert begun[1:] == [(few, True), (few, False), ({}, False)]


@pytest.mark.parametrize("name", ["nip", "without wraps", "rollers"])
def test_zones_cover_the_contact_and_no_traction_exceeds_its_bound(client, cases, name):
    case = cases["nip"] | {"roll_wrap": 0.0} if name == "without wraps" else cases[name]
    answer = client.post("/api/solve", json=case).json()
    first, last = answer["nip"]
    for strip in answer["zones"]:
        assert strip["runs"][0][1] == answer["arrays"]["x"][first]
        assert strip["runs"][-1][2] == answer["arrays"]["x"][last]
    for bound in answer["bounds"]:
        traction = np.abs(answer["arrays"][bound["of"]])
        # 1e-8 of the largest: what the certificate admits
        assert np.all(traction <= np.array(bound["values"]) + 1e-8 * traction.max())


# ---- refusals ---------------------------------------------------------------------------------


def rejected(client, case, status=422):
    headers = {"content-type": "application/json"}
    answer = client.post("/api/solve", content=json.dumps(case), headers=headers)
    assert answer.status_code == status
    assert answer.headers["content-type"] == "application/problem+json"
    record = answer.json()
    assert record["status"] == status
    return record


def test_every_fault_is_reported_at_its_field_with_its_range(client, cases):
    case = cases["nip"] | {"nip_load": -3.0, "web": {"thickness": "66 kg", "material": "paper"}}
    answer = rejected(client, case)
    faults = {fault["field"]: fault for fault in answer["errors"]}
    assert set(faults) == {"nip_load", "web.thickness"}
    assert faults["nip_load"]["range"] == {"ge": 1e-12, "le": 1e7}
    assert faults["nip_load"]["unit"] == "N/m"
    assert "wrong dimension" in faults["web.thickness"]["message"]


def test_no_steady_state_is_distinguished(client, cases):
    answer = rejected(client, cases["nip"] | {"winding_force": 1e6})
    assert answer["type"] == "/problems/no-steady-state"


@pytest.mark.parametrize(
    "body", [b"{", b'{"a": NaN}', b"\xff", b"[" * 100_000, b'{"a": "\\ud800"}']
)
def test_what_is_no_json_is_rejected(client, body):
    headers = {"content-type": "application/json"}
    answer = client.post("/api/solve", content=body, headers=headers)
    assert answer.status_code == 400
    assert "not JSON" in answer.json()["detail"]


def test_numbers_beyond_floats_are_rejected(client, cases):
    text = json.dumps(cases["nip"])
    for number in ("1e999", "-1e999", "9" * 4000, "1e308"):
        body = text.replace("3502.0", number).encode()
        headers = {"content-type": "application/json"}
        answer = client.post("/api/solve", content=body, headers=headers)
        assert answer.status_code in (400, 422), number


def test_tables_that_name_files_are_rejected(client, cases, tmp_path):
    """As a case file's columns that stand in a CSV file next to it."""
    (tmp_path / "test.csv").write_text("pressure [kPa], strain [%]\n10,0.9\n25,1.6\n")
    stack = cases["roll"]["stack"] | {
        "radial": {"kind": "stack_test", "csv": str(tmp_path / "test.csv")}
    }
    answer = rejected(client, cases["roll"] | {"stack": stack})
    assert any("csv" in fault["field"] for fault in answer["errors"])


# ---- around a state ---------------------------------------------------------------------------


def test_a_curve_goes_through_the_state(client, cases):
    asked = {"field": "nip_load", "points": 5}
    answer = client.post("/api/curve", json=cases["nip"], params=asked).json()
    assert answer["values"][2] == answer["at"] == cases["nip"]["nip_load"]
    result = wo.solve(wo.NipProblem.example())
    # each state starts from the one before, maybe on another mesh: the same within error estimates
    assert answer["outputs"]["nip_induced_tension"][2] == pytest.approx(
        result.nip_induced_tension, abs=2 * result.errors["nip_induced_tension"]
    )
    assert not answer["failures"]


def test_a_curve_stays_within_what_the_field_permits(client, cases):
    """Half the value on either side would end above the largest permitted friction."""
    case = {**cases["rollers"], "friction": 8.0}
    answer = client.post("/api/curve", json=case, params={"field": "friction", "points": 3}).json()
    assert answer["values"] == [4.0, 7.0, 10.0]


@pytest.mark.parametrize(
    ("asked", "field"),
    [({"field": "nip_lod"}, "nip_lod"), ({"field": "drum"}, "drum"),
     ({"field": "nip_load", "points": 1000}, "points"),
     ({"field": "nip_load", "low": 5e3, "high": 1e3}, "nip_load"),
     ({"field": "nip_load", "low": -5, "high": 1e3}, "nip_load"),
     ({"field": "nip_load", "low": 2e7, "high": 3e7}, "nip_load"),
     ({"field": "nip_load", "low": "nan"}, "low"), ({}, "field"),
     ({"field": "nip_load", "outputs": "no_such"}, "no_such")],
)  # fmt: skip
def test_a_curve_of_nothing_is_rejected(client, cases, asked, field):
    answer = client.post("/api/curve", json=cases["nip"], params=asked)
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["field"] == field


def test_sensitivities_of_a_nip_are_the_exact_ones(client, cases):
    answer = client.post("/api/sensitivities", json=cases["nip"]).json()
    exact = wo.solve(wo.NipProblem.example()).sensitivity().sorted()
    assert answer["method"] == "exact"
    assert answer["parameters"] == list(exact.parameters)
    # rounding: where arrays lie in memory, products of matrices differ in their last digits
    np.testing.assert_allclose(answer["derivatives"], exact.derivatives, rtol=1e-8)


def test_sensitivities_of_a_roll_are_differences(client, cases):
    """The same as the derivatives of the result; fields without an effect come last."""
    answer = client.post("/api/sensitivities", json=cases["roll"]).json()
    assert answer["method"] == "differences"
    result = wo.solve(wo.RollProblem.example())
    names = answer["parameters"]
    known = wo.derivatives(result, *names)
    for output, elasticities in zip(answer["outputs"], answer["elasticities"], strict=True):
        row = known.elasticities[known.outputs.index(output)]
        assert elasticities == pytest.approx(row.tolist(), rel=1e-6, abs=1e-9)
    first = np.abs(answer["elasticities"][0])
    assert (np.diff(first) <= 0).all()


def test_abandoned_windings_do_not_block_the_next_nip(client, cases):
    """Each would take seconds, and more of them wait than there are workers."""
    case = {**cases["winding"], "radius": 0.5}
    headers = {"X-Session": "", "Content-Type": "application/json"}
    began = time.monotonic()
    assert client.post("/api/solve", json=cases["nip"]).status_code == 200
    alone = time.monotonic() - began
    for _ in range(6):
        with (
            httpx.Client(base_url=client.base_url, timeout=0.5) as impatient,
            pytest.raises(httpx.ReadTimeout),
        ):
            impatient.post("/api/solve?nodes=129", json=case, headers=headers)
    began = time.monotonic()
    assert client.post("/api/solve", json=cases["nip"]).status_code == 200
    # 3 s until a worker is killed, the start of another; on a busy machine all takes longer
    assert time.monotonic() - began < 30 + 30 * alone


def test_a_newer_request_of_the_session_cancels_the_older_one(client, cases):
    case = {**cases["winding"], "radius": 0.5}
    limit = time.monotonic() + 100
    with ThreadPoolExecutor(1) as other:
        older = other.submit(client.post, "/api/solve?nodes=129", json=case)
        while not older.done():  # one that comes before the older one is no newer one
            newer = client.post("/api/solve", json=cases["nip"])
            assert time.monotonic() < limit
    assert older.result().status_code == 409
    assert newer.status_code == 200


def test_find_has_the_solutions_of_python(client, cases):
    body = {"case": cases["rollers"], "field": "load", "output": "nip_width", "target": "4 mm"}
    found = client.post("/api/find", json=body).raise_for_status().json()
    result = wo.find(wo.RollerProblem.example(), "load", nip_width="4 mm")
    assert [one["value"] for one in found["solutions"]] == [value for value, _ in result.solutions]
    assert found["values"] == result.values.tolist()
    assert found["unconfirmed"] == []


@pytest.mark.parametrize(
    ("change", "kind", "says"),
    [({"output": "nip_widht"}, "invalid", "did you mean 'nip_width'"),
     ({"output": "between"}, "invalid", "is not an output"),
     ({"field": "laod"}, "invalid", "laod"),
     ({"target": "4 kg"}, "invalid", "nip_width"),
     ({"target": 5.0}, "no-solution", "nip_width")],
)  # fmt: skip
def test_what_cannot_be_found_is_rejected(client, cases, change, kind, says):
    body = {"case": cases["rollers"], "field": "load", "output": "nip_width", "target": "4 mm"}
    answer = client.post("/api/find", json=body | change)
    assert answer.status_code == 422
    assert answer.json()["type"] == f"/problems/{kind}"
    assert says in answer.json()["detail"]
