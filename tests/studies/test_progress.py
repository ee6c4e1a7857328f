"""The bar on the error channel: what is counted, how far, how fast."""

from __future__ import annotations

import re

import numpy as np
import pytest

import woundon as wo
from woundon.studies.bars import bar
from woundon.studies.progress import progress_reporter


def test_a_bar_says_what_is_done(capsys: pytest.CaptureFixture[str]):
    with progress_reporter(True, "drawing", unit="figures/min", done=4) as report:
        report(10, 10)
    assert re.search(r"drawing .*10/10 \S+ figures/min", capsys.readouterr().err)


def test_a_file_contains_lines_in_place_of_a_bar(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    seconds = iter([0.0, 4.0, 11.0, 12.0, 32.0])
    monkeypatch.setattr("woundon.studies.bars.monotonic", lambda: next(seconds))
    with bar("fitting") as report:
        for done in (1, 2, 3, 4):
            report(done, 8)
    lines = capsys.readouterr().err.split("\n")
    assert [line for line in lines if line] == [
        "fitting: 25% after 11 s",
        "fitting: 50% after 32 s",
    ]


def test_a_fit_reports_progress_until_all_is_done():
    calls: list[tuple[int, int]] = []
    wo.fit(
        wo.NipProblem.example().replace(roll_wrap=0.0),
        {"nip_load": [1e3, 2e3, 3e3], "outlet_tension": [400.0, 450.0, 490.0]},
        ["roll_friction"],
        nodes=17,
        starts=2,
        workers=1,
        progress=lambda done, expected: calls.append((done, expected)),
    )
    # every evaluation is reported, at most the expected ones
    done, expected = np.transpose(calls)
    assert len(calls) > 10
    assert np.all(np.diff(done) >= 0)
    assert set(expected) == {done[-1]}
