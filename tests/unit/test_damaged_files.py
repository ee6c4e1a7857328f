"""Damaged result files and hostile case files: a sample of ``benchmarks/damaged_files.py``."""

from __future__ import annotations

from collections import Counter

import damaged_files
import pytest

from woundon.io import result_files


@pytest.fixture(scope="module", autouse=True)
def _solved_before() -> None:
    damaged_files.results()


def test_no_damaged_result_is_taken_for_good(tmp_path):
    outcomes = [damaged_files.damaged_result(seed, tmp_path) for seed in range(150)]
    assert [(seed, outcome) for seed, outcome in enumerate(outcomes) if outcome.finding] == []
    assert Counter(outcome.text == "loaded" for outcome in outcomes)[True] < 10
    assert len({(outcome.damage, outcome.ending) for outcome in outcomes}) > 25


def test_hostile_cases_are_refused_in_plain_words(tmp_path):
    outcomes = [damaged_files.hostile_case(seed, tmp_path) for seed in range(60)]
    assert [(seed, outcome) for seed, outcome in enumerate(outcomes) if outcome.finding] == []


@pytest.mark.slow
def test_damage_is_found_by_the_seal_alone(tmp_path, monkeypatch):
    """The campaign can fail: without the seals a fifth of the files is taken for what it is not."""
    monkeypatch.setattr(result_files.seals, "check_bytes", lambda content: True)
    monkeypatch.setattr(result_files.seals, "check_record", lambda record: True)
    outcomes = [damaged_files.damaged_result(seed, tmp_path) for seed in range(100)]
    assert sum(bool(outcome.finding) for outcome in outcomes) > 10


@pytest.mark.parametrize(
    ("raised", "finding"),
    [
        (ValueError("x"), "ValueError"),
        (RecursionError("x"), "RecursionError"),
        (damaged_files.wo.InvalidProblem("a\x1b"), ""),
    ],
)
def test_what_counts_as_a_finding(raised, finding):
    def load() -> None:
        raise raised

    assert damaged_files.judged("", "", load, lambda _: "", "").finding == finding
    assert damaged_files.judged("", "", lambda: 1, lambda _: "x", "").finding == (
        "accepted, differs in x"
    )
