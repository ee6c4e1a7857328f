"""Studies survive damaged files, kill -9, Ctrl-C and full disks (``study_attacks.py``)."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
import study_attacks
from slow_cases import campaign_case

pytestmark = pytest.mark.skipif(os.name == "nt", reason="pipes, signals and limits of POSIX")


@pytest.mark.parametrize("seed", range(1000, 1010))
def test_damaged_studies_are_rejected_or_give_the_same_table(seed: int, tmp_path: Path):
    study_attacks.damaged(seed, tmp_path)  # raises if it finds a fault


@pytest.mark.slow
@pytest.mark.parametrize("seeds", [range(1000, 1005), campaign_case(range(500))])
def test_attacked_studies_are_rejected_or_resume_to_the_same_table(seeds: range, tmp_path: Path):
    whole = study_attacks.Undisturbed(tmp_path)
    for seed in seeds:
        study_attacks.attacked(seed, tmp_path / str(seed), whole)
