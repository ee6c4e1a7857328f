"""A sample of ``benchmarks/hostile_studies.py``: damaged folders, kill -9, full disks."""

from __future__ import annotations

import os
from pathlib import Path

import hostile_studies as hostile
import pytest
from slow_cases import slow_case

pytestmark = pytest.mark.skipif(os.name == "nt", reason="pipes, signals and limits of POSIX")


OFTEN, SELDOM = range(1000, 1006), range(1006, 1025)


@pytest.mark.parametrize("seed", [*OFTEN, *map(slow_case, SELDOM)])
def test_damage_is_refused_in_one_line_or_repaired(seed: int, tmp_path: Path):
    hostile.damage(seed, tmp_path)  # raises what it finds


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> hostile.Undisturbed:
    return hostile.Undisturbed(tmp_path_factory.mktemp("whole"))


@pytest.mark.slow
@pytest.mark.parametrize("trial", [hostile.killed, hostile.together, hostile.stopped, hostile.full])
def test_what_is_killed_or_out_of_space_resumes_to_the_same_table(
    trial, whole: hostile.Undisturbed, tmp_path: Path
):
    trial(1000, tmp_path, whole)
