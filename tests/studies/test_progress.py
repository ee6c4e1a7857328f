"""The bar on the error channel: what is counted, how far, how fast."""

from __future__ import annotations

import re
from types import SimpleNamespace

import pytest

import woundon as wo
from woundon.studies.progress import _Rate, bar, fraction_bar


@pytest.mark.parametrize(
    ("unit", "elapsed", "says"),
    [
        ("cases/s", 90.0, "0.0667 cases/s"),
        ("figures/min", 90.0, "4 figures/min"),
        ("cases/s", 0.0, "- cases/s"),
    ],
)
def test_the_rate_counts_from_where_the_work_went_on(unit: str, elapsed: float, says: str):
    task = SimpleNamespace(
        completed=10, elapsed=elapsed, finished_time=None, fields={"begun_with": 4, "unit": unit}
    )
    assert str(_Rate().render(task)) == says


def test_a_bar_says_what_is_done(capsys: pytest.CaptureFixture[str]):
    with bar(4, 10, "drawing", "figures/min") as tell:
        tell(6)
    said = capsys.readouterr().err
    assert re.search(r"drawing .*10/10 \S+ figures/min", said)
    with bar(0, 2) as tell:
        tell(2)
    assert re.search(r"solving .*2/2 \S+ cases/s", capsys.readouterr().err)


def test_a_bar_of_a_solve_shows_the_fraction(monkeypatch: pytest.MonkeyPatch, capsys):
    monkeypatch.setenv("FORCE_COLOR", "1")
    with fraction_bar() as progress:
        wo.solve(wo.NipProblem.example(), nodes=33, progress=progress)
    assert "100%" in capsys.readouterr().err
