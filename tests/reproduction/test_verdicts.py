"""Verdicts on the thesis's figures: they can fail, and say so; data; which module makes which."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from woundon import InvalidProblem
from woundon.jorkama2001 import catalogue, judgement
from woundon.jorkama2001.exhibits import Exhibit
from woundon.jorkama2001.judgement import judged
from woundon.jorkama2001.nips import dataset, joined
from woundon.jorkama2001.verdicts import (
    Outcome,
    Range,
    Verdict,
    at_least,
    at_most,
    falls,
    grows,
    untested,
    verdict,
    whether,
)


@pytest.mark.parametrize(
    ("value", "low", "high", "outcome"),
    [
        (1.0, 0.5, 2.0, Outcome.HOLDS),
        (2.0, 0.5, 2.0, Outcome.HOLDS),  # ends included
        (2.1, 0.5, 2.0, Outcome.FAILS),
        (0.4, 0.5, np.inf, Outcome.FAILS),
        (0.1, -np.inf, 0.0, Outcome.FAILS),
        (float("nan"), -np.inf, np.inf, Outcome.FAILS),  # nothing computed is no evidence
        (None, 0.5, 2.0, Outcome.UNTESTED),
    ],
)
def test_a_statement_holds_fails_or_cannot_be_tested(value, low, high, outcome):
    assert Verdict("x", value, Range(low, high)).outcome is outcome


def test_a_fact_without_a_number():
    assert whether("x", True).outcome is Outcome.HOLDS
    wrong = whether("x", False)
    assert (wrong.outcome, wrong.measured, wrong.expected) == (Outcome.FAILS, "no", "yes")
    assert untested("x", "no load given").outcome is Outcome.UNTESTED


def test_a_rise_and_a_fall_in_every_step():
    NIT = xr.DataArray([[1.0, 2.0, 2.5], [1.0, 3.0, 2.9]], dims=("F", "P"))
    rising = grows("x", NIT[:1], "P")
    assert (rising.outcome, rising.value, rising.note) == (Outcome.HOLDS, 0.5, "smallest step")
    assert grows("x", NIT, "P").value == pytest.approx(-0.1)
    assert grows("x", NIT, "P").outcome is Outcome.FAILS
    falling = falls("x", -NIT[:1], "P")
    assert (falling.outcome, falling.value, falling.note) == (Outcome.HOLDS, -0.5, "largest step")
    assert falls("x", -NIT, "P").outcome is Outcome.FAILS
    assert falls("x", NIT, "F").outcome is Outcome.FAILS


def test_data_as_csv():
    joint = joined("F [N/m]", {0.0: dataset("node", {"x [m]": [1.0, 2.0], "z [1]": [0, 1]}),
                               -5.0: dataset("node", {"x [m]": [3.0], "z [1]": [1]})})  # fmt: skip
    joint["untold"] = ("node", [7.0, 8.0])
    text = Exhibit("fig15", joint, ()).csv()
    # what is shorter ends where it ends, and what has no unit is no column
    assert text == "F [N/m],x [m],z [1]\n0,1,0\n0,2,1\n-5,3,1\n"


def two(solver: str) -> tuple[Exhibit, ...]:
    """Return an exhibit of which one statement fails with the accurate solver only."""
    value = {"accurate": 5.0, "thesis": 1.0}[solver]
    verdicts = (
        verdict("it is small", value, at_most(2.0, "N/m"), "s_d of the nip"),
        verdict("it is there", 1.0, at_least(0.5)),
        untested("it is blue", "no colour is printed"),
    )
    return (Exhibit("fig18", dataset("row", {"x [m]": [1.0]}), verdicts),)


def test_where_a_statement_fails_both_solvers_are_shown(monkeypatch):
    monkeypatch.setattr(judgement, "made_by", lambda _, solver: two(solver))
    (one,) = judged("fig16_18", ("fig18",), "accurate")
    assert one.tally == "3 statements: 1 holds, 1 does not hold, 1 cannot be tested"
    assert one.lines() == [
        "DOES NOT HOLD: it is small: 5 N/m, asked at most 2 N/m; with the thesis's procedure "
        "1 N/m, holds. s_d of the nip.",
        "holds: it is there: 1, asked at least 0.5.",
        "cannot be tested: it is blue. No colour is printed.",
    ]
    text = one.markdown("fig18.png")
    assert text.startswith("# Fig. 18: Dual slip ratio against the nip load\n")
    assert "![Fig. 18](fig18.png)" in text
    assert one.report().count("\n- ") == 3


def test_the_exhibits_knows_its_figures():
    assert catalogue.chosen(("table4", "fig16")) == ("fig16", "table4")
    assert catalogue.modules(("fig17", "fig16", "table4")) == ("fig16_18", "table4")
    with pytest.raises(InvalidProblem, match="fig1: unknown; did you mean 'fig"):
        catalogue.chosen(("fig1",))
