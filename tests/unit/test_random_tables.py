"""Random table files of all formats: read rightly, or rejected in a few lines with a remedy.

Evidence: ``benchmarks/random_tables.py`` states the values of each file before it is written.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from random_tables import FAULTS, FORMATS, outcome, random_file
from slow_cases import campaign_case

SAMPLE, ALL = 60, 300


@pytest.mark.parametrize(
    "seeds", [range(SAMPLE), campaign_case(range(SAMPLE, ALL))], ids=["sample", "others"]
)
def test_no_file_is_read_wrongly(seeds: range, tmp_path: Path):
    files = [random_file(seed, tmp_path) for seed in seeds]
    assert {made.story[1] for made in files} == set(FORMATS)
    assert {made.fault for made in files} == set(FAULTS)
    outcomes = [(made, *outcome(made)) for made in files]
    failed = [(made.story, why) for made, end, why in outcomes if end not in ("read", "rejected")]
    assert not failed
    # none of the files without a fault is rejected
    assert not [
        (made.story, why) for made, end, why in outcomes if end != "read" and not made.fault
    ]
