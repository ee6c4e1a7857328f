"""Studies over every kind of problem, woundon's and others': fields, outputs, options by name."""

from __future__ import annotations

import json
from math import pi

import numpy as np
import pytest
import study_models as models
from registered_kinds import registered
from thesis_cases import measured_tensions, newsprint_nip, paper_nip

import woundon as wo

STARTED = 1e-8  # cases start from their neighbours: to the tolerance of the load


@pytest.fixture
def springs():
    """A kind registered for the time of a test."""
    with registered("spring_problem") as module:
        yield module


@pytest.fixture
def row(springs):
    parts = [{"stiffness": 100.0}, {"stiffness": 300.0}]
    return springs.SpringsProblem(springs=parts, force=3.0)


# ---- woundon's kinds ----------------------------------------------------------------------------


def test_wraps_are_swept_as_any_field():
    """Also over friction behind the nip that the base case leaves to that in it."""
    wrapped = paper_nip().replace(roll_wrap=pi, drum_wrap=0.5)
    over = {"wrap_friction": [0.1, 0.3], "roll_wrap": [0.5, pi]}
    outputs = ("wound_on_tension", "slip_angle")
    data = wo.sweep(wrapped, over, outputs, nodes=17, workers=1)
    for mu in over["wrap_friction"]:
        for angle in over["roll_wrap"]:
            single = wo.solve(wrapped.replace(wrap_friction=mu, roll_wrap=angle), nodes=17)
            case = data.sel(wrap_friction=mu, roll_wrap=angle)
            assert float(case.wound_on_tension) == pytest.approx(
                single.wound_on_tension, rel=STARTED
            )
            assert float(case.slip_angle) == pytest.approx(single.slip_angle, rel=STARTED)
    assert data.roll_wrap.attrs["units"] == "rad"
    assert data.wound_on_tension.attrs["long_name"] == ("wound-on tension")
    assert data.attrs["kind"] == "nip"


@pytest.mark.slow
def test_a_wrapped_nip_is_fitted_to_measured_tensions():
    """Three of the thesis's points; what the fit predicts is what the solver says."""
    rows = [p for p in measured_tensions() if p["web_tension"] == 350 and p["nip_load"] > 1000]
    data = {
        "nip_load": [row["nip_load"] for row in rows],
        "wound_on_tension": [row["measured"] for row in rows],
    }
    wrapped = newsprint_nip().replace(roll_wrap=pi / 2, drum_wrap=pi)
    fit = wo.fit(
        wrapped, data, {"roll_friction": (0.05, 0.8)}, nodes=17, starts=1, profiles=False
    )  # fmt: skip
    assert isinstance(fit.problem, wo.NipProblem)

    def tensions(mu: float) -> np.ndarray:
        nips = (wrapped.replace(nip_load=P, roll_friction=mu) for P in data["nip_load"])
        return np.array([wo.solve(nip, nodes=17).wound_on_tension for nip in nips])

    best = fit.estimate("roll_friction")
    # what is added for borders within their cells, up to 4e-3 of a tension, is warm and cold the
    # same to a thousandth
    assert fit.fitted == pytest.approx(tensions(best), rel=4e-6)
    for near in (0.98 * best, 1.02 * best):
        miss = tensions(near) - data["wound_on_tension"]
        assert np.sqrt(np.mean(miss**2)) > fit.rms


def test_rollers_are_fitted_to_a_curve_of_creepage():
    """The tangential load that the problem gives is an input, though results tell it too."""
    true = wo.RollerProblem.example()
    loads = [2e3, 6e3, 1e4]
    solved = [wo.solve(true.replace(tangential_load=Q), nodes=41) for Q in loads]
    data = {"tangential_load": loads, "creepage": [result.creepage for result in solved]}
    base = true.replace(friction=0.3)
    fit = wo.fit(base, data, ["friction"], nodes=41, starts=1, profiles=False)
    assert fit.estimate("friction") == pytest.approx(0.5, rel=1e-5)


# ---- a kind from outside ------------------------------------------------------------------------


def test_items_of_a_list_are_varied_by_their_number(row):
    over = {"springs.1.stiffness": [200.0, 600.0], "force": [3.0, 6.0]}
    data = wo.sweep(row, over, ("extension", "share", "residual"), workers=1)
    extension = data.extension.sel({"springs.1.stiffness": 600.0, "force": 6.0})
    assert float(extension) == pytest.approx(0.07)
    share = data.share.sel({"springs.1.stiffness": 200.0, "force": 3.0})
    assert float(share) == pytest.approx(2 / 3)
    assert data["springs.1.stiffness"].attrs == {
        "units": "N/m", "long_name": "stiffness of a spring", "symbol": "k",
    }  # fmt: skip
    assert json.loads(data.attrs["problem"])["springs"][1]["stiffness"] == 300.0


def test_workers_know_the_kind_from_its_module(row):
    over = {"springs.0.stiffness": np.linspace(50, 150, 12)}
    one = wo.sweep(row, over, workers=1, chunk=3)
    two = wo.sweep(row, over, workers=2, chunk=3)
    assert one.identical(two)


def test_items_of_a_list_are_fitted(row):
    """y = origin + F (1/k0 + 1/k1)."""
    data = {"force": [1.0, 2.0, 2.0], "origin": [0.0, 0.0, 1.0], "end": [0.0125, 0.025, 1.025]}
    vary = {"springs.0.stiffness": (10.0, 1000.0)}
    fit = wo.fit(row, data, vary, tie={"springs.1.stiffness": "springs.0.stiffness"}, starts=1)
    assert fit.estimate("springs.0.stiffness") == pytest.approx(160.0, rel=1e-6)
    assert [part.stiffness for part in fit.problem.springs] == [fit.estimates[0]] * 2
    assert fit.solves % 3 == 0  # of three rows each


@pytest.mark.parametrize(
    ("over", "outputs", "says"),
    [
        ({"springs.2.stiffness": [1.0]}, None, "no item '2' in this list; known: 0 to 1"),
        ({"springs.stiffness": [1.0]}, None, "no item 'stiffness' in this list"),
        ({"springs.0.stifness": [1.0]}, None, "stifness: no such field; did you mean 'stiffness'"),
        ({"force": [1.0]}, "strain", "strain: no such output: springs have an extension"),
        ({"force": [1.0]}, "extent", "extent: not a scalar output; did you mean 'extension'"),
    ],
)
def test_bad_studies_of_another_kind_are_rejected(row, over, outputs, says):
    with pytest.raises(wo.InvalidProblem, match=says):
        wo.sweep(row, over, outputs)


def test_a_case_that_a_list_does_not_admit_fails_alone(row):
    table = models.table_of(row, {"springs.0.stiffness": [100.0, -1.0]})
    assert table.failed.tolist() == [1]
    assert table.failure[1].startswith("InvalidProblem: springs.0.stiffness: -1 is out of range")
