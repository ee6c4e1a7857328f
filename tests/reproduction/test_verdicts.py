"""Verdicts on the thesis's figures: they can fail, and say so; tables; the registry."""

from __future__ import annotations

import numpy as np
import pytest
from jorkama2001.frame import Figure, Outcome, Scheme, Table, Verdict

from jorkama2001 import judgement, registry
from jorkama2001.judgement import Judged, judged
from woundon.errors import InvalidProblem


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
    assert Verdict("x", value, low, high).outcome is outcome


def test_a_fact_without_a_number():
    assert Verdict.whether("x", True).outcome is Outcome.HOLDS
    wrong = Verdict.whether("x", False)
    assert (wrong.outcome, wrong.measured, wrong.expected) == (Outcome.FAILS, "no", "yes")
    assert Verdict.untested("x", "no load given").outcome is Outcome.UNTESTED


@pytest.mark.parametrize(
    ("verdict", "measured", "expected"),
    [
        (Verdict("", 1.234567, high=3.0, unit="%"), "1.23 %", "at most 3 %"),
        (Verdict("", 206.04, 195.7, 216.3, "N/m"), "206.0 N/m", "195.7 to 216.3 N/m"),
        (Verdict("", -0.5, 0.0), "-0.5", "at least 0"),
        (Verdict("", 3.0, 3, 3), "3", "3"),
    ],
)
def test_numbers_with_their_ranges(verdict, measured, expected):
    assert (verdict.measured, verdict.expected) == (measured, expected)


def test_a_table_is_read_by_column_and_row():
    table = Table.of({"P [N/m]": [1.0, 1.0, 2.0], "F [N/m]": [0.0, -5.0, 0.0]})
    assert table["P"].tolist() == [1.0, 1.0, 2.0]
    assert table.where(P=1.0)["F"].tolist() == [0.0, -5.0]
    assert table.where(P=1.0, F=0.0).rows.shape == (1, 2)
    assert table.within("P", 1.5).rows.shape == (1, 2)
    assert table.csv().splitlines()[:2] == ["P [N/m],F [N/m]", "1,0"]
    assert len(table.stacked(table).rows) == 6
    with pytest.raises(ValueError, match="headers differ"):
        table.stacked(Table.of({"a": [0.0]}))


def two(scheme: Scheme) -> tuple[Figure, ...]:
    """Return a figure of which one statement fails with the accurate scheme only."""
    value = {"graded": 5.0, "thesis": 1.0}[scheme]
    verdicts = (
        Verdict("it is small", value, high=2.0, unit="N/m", note="s_d of the nip"),
        Verdict("it is there", 1.0, 0.5),
        Verdict.untested("it is blue", "no colour is printed"),
    )
    return (Figure("fig99", "Two", scheme, Table.of({"x": [1.0]}), verdicts),)


def test_where_a_statement_fails_both_schemes_are_shown(monkeypatch):
    monkeypatch.setattr(judgement, "figures", lambda _, scheme: two(scheme))
    (one,) = judged("fig99", ("fig99",), "graded")
    assert one.tally == "3 statements: 1 holds, 1 does not hold, 1 cannot be tested"
    assert one.lines() == [
        "DOES NOT HOLD: it is small: 5 N/m, asked at most 2 N/m; with the thesis's scheme 1 N/m, "
        "holds. s_d of the nip.",
        "holds: it is there: 1, asked at least 0.5.",
        "cannot be tested: it is blue. No colour is printed.",
    ]
    text = one.markdown("fig99.png")
    assert text.startswith("# Fig. 99: Two\n")
    assert "![Fig. 99](fig99.png)" in text
    assert one.report().count("\n- ") == 3


def test_where_all_hold_one_scheme_is_enough(monkeypatch):
    asked: list[str] = []

    def figures(_: str, scheme: Scheme) -> tuple[Figure, ...]:
        asked.append(scheme)
        return two(scheme)

    monkeypatch.setattr(judgement, "figures", figures)
    (one,) = judged("fig99", ("fig99",), "thesis")
    assert asked == ["thesis"]
    assert one.others == ()
    assert judged("fig99", (), "thesis") == ()


def test_verdicts_of_both_schemes_must_be_the_same_statements():
    with pytest.raises(ValueError, match="shorter"):
        Judged(two("graded")[0], two("thesis")[0].verdicts[:1]).lines()


def test_the_registry_knows_its_figures():
    assert registry.chosen(("table4", "fig16")) == ("fig16", "table4")
    assert registry.modules(("fig17", "fig16", "table4")) == ("fig16_18", "table4")
    with pytest.raises(InvalidProblem, match="fig1: unknown; did you mean 'fig"):
        registry.chosen(("fig1",))
