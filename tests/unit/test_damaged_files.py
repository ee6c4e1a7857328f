"""Damaged result files and malformed case files, drawn by ``tests/damaged_files.py``."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import damaged_files
import pytest

import woundon as wo
from woundon.io import result_files


@pytest.mark.parametrize(
    "seeds",
    [range(60), pytest.param(range(60, 360), marks=(pytest.mark.slow, pytest.mark.campaign))],
)
def test_no_damaged_result_is_accepted(tmp_path: Path, seeds: range):
    outcomes = [damaged_files.damaged_result(seed, tmp_path) for seed in seeds]
    assert [(seed, one) for seed, one in zip(seeds, outcomes, strict=True) if one.finding] == []
    loaded = Counter(outcome.text == "loaded" for outcome in outcomes)[True]
    assert loaded < 0.1 * len(outcomes)  # most damage is real
    assert len({(outcome.damage, outcome.ending) for outcome in outcomes}) > 15


@pytest.mark.slow
@pytest.mark.campaign
def test_malformed_cases_are_rejected_in_plain_words(tmp_path: Path):
    """The record of errors contains the first 200."""
    seeds = range(200, 700)
    outcomes = [damaged_files.hostile_case(seed, tmp_path) for seed in seeds]
    assert [(seed, one) for seed, one in zip(seeds, outcomes, strict=True) if one.finding] == []


@pytest.mark.slow
def test_without_its_checksum_damage_would_be_accepted(tmp_path: Path, monkeypatch):
    """The test of damaged results can fail: a tenth of the files passes the certificate too."""
    monkeypatch.setattr(result_files.seals, "check_bytes", lambda content: True)
    monkeypatch.setattr(result_files.seals, "check_record", lambda record: True)
    outcomes = [damaged_files.damaged_result(seed, tmp_path) for seed in range(100)]
    assert sum(bool(outcome.finding) for outcome in outcomes) > 5


@pytest.mark.parametrize(
    ("raised", "finding"),
    [
        (ValueError("x"), "ValueError"),
        (RecursionError("x"), "RecursionError"),
        (wo.InvalidProblem("a\x1b"), ""),
    ],
)
def test_findings_are_recognised(raised: Exception, finding: str):
    def load() -> None:
        raise raised

    assert damaged_files.judged("", "", load, lambda _: "", "").finding == finding
    assert damaged_files.judged("", "", lambda: 1, lambda _: "x", "").finding == (
        "accepted, differs in x"
    )
