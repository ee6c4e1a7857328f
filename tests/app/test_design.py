"""The inverse over HTTP: the tension that leaves a wanted pressure."""

import pytest

import woundon as wo

WANTED = {"radius": ["44.5 mm", 0.09, 0.15], "value": ["250 kPa", 180e3, 0]}


def test_a_design_is_that_of_python(client, cases):
    case = cases["roll"]
    answer = client.post("/api/design", json={"case": case, "pressure": WANTED, "rtol": 1e-3})
    found = answer.raise_for_status().json()
    pressure = wo.Profile(radius=[0.0445, 0.09, 0.15], value=[250e3, 180e3, 0.0])
    design = wo.design_tension(wo.RollProblem.example(), pressure, rtol=1e-3)
    assert found["tension"] == {
        "radius": list(design.tension.radius), "value": list(design.tension.value),
        "between": "smooth",
    }  # fmt: skip
    assert found["pressure"] == design.pressure.tolist()
    assert found["target_pressure"] == design.target_pressure.tolist()
    assert (found["outer_layer"], found["surface_deviation"]) == (0.0, design.surface_deviation)
    # what it says is a schedule of a case
    wound = client.post("/api/solve", json=case | {"wound_on_tension": found["tension"]})
    core = wound.raise_for_status().json()["outputs"]["core_pressure"]["value"]
    assert core == pytest.approx(250e3, rel=2e-3)  # rtol of the design, and of the solver


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"pressure": "200"}, "pressure: '200' has no unit"),
        ({"pressure": -2e5}, "pressure: -200000 is out of range; must be > 0"),
        ({"pressure": {"radius": [0.05, 0.15], "value": [1e5, 1e5]}}, "pressure.radius.0: 0.05 is"),
        ({"pressure": {"radius": [0.0445, "9 kPa"], "value": [1e5, 1e5]}}, "pressure.radius.1: "),
        ({"pressure": {"radius": 1}}, "pressure.value: missing"),
        ({"pressure": None}, "pressure.float: Input should be a valid number"),
        ({"rtol": 0.5}, "rtol: Input should be less than or equal to 0.01"),
        ({"case": "nip"}, "must be a RollProblem"),
        ({"presure": 1}, "presure: Extra inputs are not permitted"),
    ],
)
def test_what_cannot_be_designed_is_rejected_in_words(client, cases, change, says):
    body = {"case": cases["roll"], "pressure": 2e5} | change
    if body["case"] == "nip":
        body["case"] = cases["nip"]
    answer = client.post("/api/design", json=body)
    assert answer.status_code == 422
    assert says in answer.json()["detail"]
