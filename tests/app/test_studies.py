"""Studies over HTTP: the numbers of wo.sweep, progress as it comes, cancel, and a stated size."""

import base64
import json
import threading
import time

import httpx
import numpy as np
import pytest

import woundon as wo
from woundon.parallel import Cancelled


def events(client, study):
    with client.stream("POST", "/api/sweep", json=study) as answer:
        assert answer.headers["content-type"] == "application/x-ndjson"
        yield from map(json.loads, answer.iter_lines())


@pytest.fixture
def slow(slow_nip):
    """A study that takes much longer than the test: a hundred cases."""
    return {"case": slow_nip, "over": {"nip_load": {"from": 2000, "to": 4000, "count": 100}}}


def test_a_study_has_the_numbers_of_a_sweep(client, cases):
    over = {"nip_load": ["2 kN/m", "4 kN/m"], "web_tension": [200, 300, 400]}
    outputs = ["nip_induced_tension", "nip_width"]
    first, *computed, last = events(
        client, {"case": cases["nip"], "over": over, "outputs": outputs}
    )
    assert first["dims"] == ["nip_load", "web_tension"]
    assert first["inputs"] == {"nip_load": [2000, 4000], "web_tension": [200, 300, 400]}
    assert last["event"] == "done"
    assert computed[-1]["done"] == computed[-1]["of"] == 6
    found = {name: np.full(6, np.nan) for name in outputs}
    for event in computed:
        for name in outputs:
            found[name][event["numbers"]] = event["values"][name]
    swept = wo.sweep(
        wo.NipProblem.example(), {"nip_load": [2e3, 4e3], "web_tension": [2e2, 3e2, 4e2]}, outputs,
        chunk=10, workers=1,
    )  # fmt: skip
    for name in outputs:
        np.testing.assert_array_equal(found[name], swept[name].values.ravel())


def test_a_case_that_fails_is_a_row_with_its_reason(client, cases):
    over = {"winding_force": [0.0, 1e5]}
    _, computed, _ = events(client, {"case": cases["nip"], "over": over})
    assert computed["failures"][0] == ""
    assert "winding_force" in computed["failures"][1]
    assert computed["values"]["wound_on_tension"][1] is None


def test_a_study_is_cancelled_by_its_session(client, slow):
    stream = events(client, slow)
    assert next(stream)["cases"] == 100
    other = httpx.post(f"{client.base_url}/api/cancel", headers={"X-Session": "somebody-else"})
    assert other.json() == {"cancelled": False}
    assert client.post("/api/cancel").json() == {"cancelled": True}
    began = time.monotonic()
    assert [event["event"] for event in stream][-1] == "cancelled"
    assert time.monotonic() - began < 60  # all cases take minutes on such a machine


def test_a_study_ends_with_the_page_that_asked(client, slow):
    stream = events(client, slow)
    next(stream)
    stream.close()
    deadline = time.monotonic() + 120
    while client.post("/api/cancel").json()["cancelled"]:
        assert time.monotonic() < deadline
        time.sleep(0.2)


EIGHT = ("nip_load", "web_tension", "web_speed", "roll_friction", "drum_friction", "roll_wrap",
         "drum_wrap", "winding_force")  # fmt: skip


@pytest.mark.parametrize(
    ("over", "cases_asked"),
    [({"nip_load": {"from": 1e3, "to": 2e3, "count": 1_000_000}}, 10**6),
     ({n: {"from": 1, "to": 2, "count": 10**6} for n in EIGHT}, 10**48),
     ({"nip_load": list(range(1, 100)), "web_tension": list(range(1, 100))}, 9801)],
)  # fmt: skip
def test_a_study_above_the_stated_size_is_rejected(client, cases, catalogue, over, cases_asked):
    answer = client.post("/api/sweep", json={"case": cases["nip"], "over": over})
    assert answer.status_code == 413
    assert answer.json()["detail"].startswith(f"{cases_asked} cases are too many")
    assert str(catalogue["limits"]["sweep_cases"]) in answer.json()["detail"]


def test_the_size_of_a_study_of_rows_is_their_number(cases):
    from woundon.app.study_stream import start_sweep

    over = {"nip_load": list(range(1000, 1060)), "web_tension": list(range(300, 360))}
    tables = {"case": cases["nip"], "over": over, "design": {"kind": "table"}}
    assert json.loads(start_sweep(tables).first)["cases"] == 60


def test_a_study_ends_whose_journal_is_gone(tmp_path):
    from woundon.app.study_stream import Journal

    folder = tmp_path / "study"
    folder.mkdir()
    journal = Journal(folder / "journal")
    journal.progress(1, 3)
    assert journal.path.read_bytes() == b'{"event":"progress","done":1,"of":3}\n'
    journal.path.unlink()
    folder.rmdir()
    with pytest.raises(Cancelled):
        journal.progress(2, 3)


@pytest.mark.parametrize(
    ("change", "field"),
    [({"case": "case.toml"}, "case"), ({"over": "cases.csv"}, "over"), ({"over": {}}, "over"),
     ({"over": {"nip_lod": [1, 2]}}, "nip_lod"), ({"outputs": ["no_such"]}, "no_such"),
     ({"out": "/tmp/results"}, "out"), ({"over": {"nip_load": [1, "66 um"]}}, "over.nip_load")],
)  # fmt: skip
def test_a_study_of_nothing_is_rejected(client, cases, change, field):
    study = {"case": cases["nip"], "over": {"nip_load": [1e3, 2e3]}} | change
    answer = client.post("/api/sweep", json=study)
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["field"] == field


def test_a_long_study_of_another_leaves_states_their_worker(client, server, cases, slow):
    """They have processes of their own: a state comes while all workers of studies are busy."""
    begun, stop = threading.Event(), threading.Event()

    def study():
        with httpx.Client(base_url=server, timeout=120, headers={"X-Session": "long-study"}) as own:
            for _ in events(own, slow):
                begun.set()
                if stop.is_set():
                    return

    thread = threading.Thread(target=study)
    thread.start()
    try:
        assert begun.wait(60)
        answer = client.post("/api/solve", json=cases["nip"])
        assert answer.status_code == 200
    finally:
        stop.set()
        httpx.post(f"{server}/api/cancel", headers={"X-Session": "long-study"})
        thread.join(60)


# ---- fits -------------------------------------------------------------------------------------

RADII = {"upper.radius": [0.1, "1 m"]}
WIDTHS = "load [kN/m]\thalf_width [um]\n50\t265\n89\t354\n120\t411\n"


def fit_events(client, case, table, vary=RADII, **more):
    body = {"case": case, "table": table, "vary": vary} | more
    with client.stream("POST", "/api/fit", json=body) as answer:
        yield from map(json.loads, answer.iter_lines())


def workbook(path, header, *rows):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in (header, *rows):
        book.active.append(row)
    book.save(path)
    return base64.b64encode(path.read_bytes()).decode()


def test_a_fit_has_the_numbers_of_python_for_a_text_and_a_workbook(client, cases, tmp_path):
    data = {"load [kN/m]": [50, 89, 120], "half_width [um]": [265, 354, 411]}
    same = wo.fit(wo.RollerProblem.example(), data, {"upper.radius": (0.1, 1.0)})
    table = workbook(tmp_path / "widths.xlsx", list(data), *zip(*data.values(), strict=True))
    for asked in ({"table": WIDTHS}, {"table": table, "file": "widths.xlsx"}):
        first, *progress, found = fit_events(client, cases["rollers"], **asked)
        assert first == {"event": "started"}
        assert [one["event"] for one in progress] == ["progress"] * len(progress)
        (radius,) = found["parameters"]
        # the same computation, on the same nodes
        assert radius["estimate"] == pytest.approx(same.estimates[0], rel=1e-9)
        assert radius["standard_error"] == pytest.approx(same.standard_errors[0], rel=1e-6)
        assert radius["interval"] == pytest.approx([same.profiles[0].low, same.profiles[0].high])
        assert radius["is_identified"]
        assert not radius["is_at_bound"]
        fitted = [row["fitted"] for row in found["rows"]]
        assert fitted == pytest.approx(same.fitted.tolist(), rel=1e-9)
        assert found["remarks"] == same.remarks()


def test_the_remarks_on_a_fit_begin_with_what_is_not_determined(client, cases):
    *_, found = fit_events(client, cases["rollers"], WIDTHS, {"upper.radius": [0.3, 1]})
    assert found["parameters"][0]["is_at_bound"]
    assert found["remarks"][0].startswith("upper.radius")
    assert "at its bound" in found["remarks"][0]


@pytest.mark.parametrize(
    ("change", "status", "words"),
    [({"table": "no_such [m]\n1\n2"}, 422, "no_such"), ({"table": "/etc/passwd"}, 422, "no header"),
     ({"table": "AAAA", "file": "a.xlsx"}, 422, "not an Excel file"),
     ({"table": "?", "file": "a.tdms"}, 422, "base64"),
     ({"table": WIDTHS + "1\t1\n" * 100}, 413, "100"), ({"vary": {"nope": None}}, 422, "nope"),
     ({"vary": {"upper.radius": [0.5, -1]}}, 422, "upper.radius")],
)  # fmt: skip
def test_a_fit_of_invalid_data_fails_with_the_reason(client, cases, change, status, words):
    *_, last = fit_events(client, cases["rollers"], **{"table": WIDTHS} | change)
    assert last["event"] == "failed"
    assert last["problem"]["status"] == status
    assert words in last["problem"]["detail"]


def test_a_fit_of_more_inputs_than_stated_is_rejected(client, cases, catalogue):
    names = [f"roll.{k}" for k in range(catalogue["limits"]["fit_unknowns"] + 1)]
    body = {"case": cases["nip"], "table": WIDTHS, "vary": dict.fromkeys(names)}
    assert client.post("/api/fit", json=body).status_code == 422


def test_a_fit_is_cancelled_by_its_session(client, cases):
    table = "nip_load [kN/m], wound_on_tension [N/m]\n" + "3, 620\n4, 705\n" * 50
    stream = fit_events(client, cases["nip"], table, {"roll_friction": [0.05, 0.6]})
    assert next(stream) == {"event": "started"}
    assert client.post("/api/cancel").json() == {"cancelled": True}
    assert [event["event"] for event in stream][-1] == "cancelled"


# ---- operating windows ------------------------------------------------------------------------

WINDOW = {"web_tension": [300, "400 N/m"], "vary": {"nip_load": ["2 kN/m", 3000]}}
SPREADS = {"stack.radial.K2": 0.3, "roll_friction": 0.15}


def window_events(client, cases, uncertain):
    # no nip is solved, which takes seconds
    body = {"case": cases["winding"] | {"tension_law": "friction"}, "uncertain": uncertain}
    with client.stream("POST", "/api/window", json=body | WINDOW) as answer:
        assert answer.status_code == 200
        yield from map(json.loads, answer.iter_lines())


@pytest.mark.campaign
def test_an_operating_window_is_that_of_python(client, cases):
    found = list(window_events(client, cases, SPREADS))
    assert found[-1] == {"event": "done"}
    assert found[0]["event"] == "progress"
    coarse, window = (one for one in found if one["event"] == "window")
    assert coarse["is_coarse"]
    problem = wo.WindingProblem.example().replace(tension_law="friction")
    same = wo.operating_window(problem, (300, 400), (2e3, 3e3), uncertain=SPREADS, workers=2)
    np.testing.assert_allclose(window["probability"], same.probability.ravel(), atol=1e-6)
    assert window["best"]["binding"] == same.best.binding
    np.testing.assert_array_equal(window["dominant"], same.dominant.ravel())
    assert window["remarks"] == same.remarks()
    assert window["inputs"] == list(SPREADS)


def test_an_operating_window_that_fails_or_is_abandoned_admits_the_next(client, cases):
    (failed,) = window_events(client, cases, "no-such-grade")
    assert failed["problem"]["status"] == 422
    assert "no-such-grade" in failed["problem"]["detail"]
    stream = window_events(client, cases, SPREADS)
    assert next(stream)["event"] == "progress"
    stream.close()
    deadline = time.monotonic() + 120
    body = {"case": cases["winding"], "uncertain": "no-such-grade"} | WINDOW
    while client.post("/api/window", json=body).status_code == 503:
        assert time.monotonic() < deadline
        time.sleep(0.2)
