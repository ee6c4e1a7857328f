"""Studies survive damaged files, kill -9, Ctrl-C and full disks (``study_attacks.py``)."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
import study_attacks

pytestmark = pytest.mark.skipif(os.name == "nt", reason="pipes, signals and limits of POSIX")
CAMPAIGN = (pytest.mark.slow, pytest.mark.campaign)
DISTURBANCES = [
    study_attacks.killed, study_attacks.together, study_attacks.stopped, study_attacks.full,
]  # fmt: skip


@pytest.mark.parametrize(
    "seeds",
    [
        range(1000, 1005),
        pytest.param(range(1005, 1025), marks=pytest.mark.slow),
        pytest.param(range(500), marks=CAMPAIGN),
    ],
)
def test_damaged_studies_are_rejected_or_give_the_same_table(seeds: range, tmp_path: Path):
    for seed in seeds:
        folder = tmp_path / str(seed)
        folder.mkdir()
        study_attacks.damage(seed, folder)  # raises if it finds a fault


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> study_attacks.Undisturbed:
    return study_attacks.Undisturbed(tmp_path_factory.mktemp("undisturbed"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "seeds", [range(1000, 1001), pytest.param(range(50), marks=pytest.mark.campaign)]
)
@pytest.mark.parametrize("trial", DISTURBANCES)
def test_interrupted_studies_resume_to_the_same_table(
    trial: Callable[..., str], seeds: range, undisturbed: study_attacks.Undisturbed, tmp_path: Path
):
    for seed in seeds:
        folder = tmp_path / str(seed)
        folder.mkdir()
        trial(seed, folder, undisturbed)
