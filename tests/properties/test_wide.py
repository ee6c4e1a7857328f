"""Random problems over all that is admissible end in a certificate, or in what to change.

A sample of benchmarks/wide.py; nearly all of what it refuses is far from anything that is wound.
"""

from __future__ import annotations

import re

import pytest
from wide import WIDE, ending

TOLD = (
    "solved",
    # a load that no contact carries
    r"InvalidProblem: (nip_)?load: .* is out of range; must be <= .* \[N/m\], about: ",
    # a layer whose response is not resolved
    "InvalidProblem: (roll|drum|upper|lower): .* the layer must be thicker, or the stiffnesses",
    # webs
    "NoSteadyState: web_tension: .* more is needed, about ",
    "InvalidProblem: roll_wrap: .* must be 0 or >= ",
    # what was not solved, and why
    "NotConverged: .*this is far outside the model: .*; take ",
    r"NotConverged: contact conditions are not satisfied to 1e-8: .*\(limit .*%\)",
    "NotConverged: stick and slip not found .*; another number of nodes may do$",
)


@pytest.mark.parametrize(
    ("kind", "seed"),
    # the first few, and some that ended otherwise once
    [*(("nip", seed) for seed in (*range(5), 191, 194, 199)),
     *(("wrapped-nip", seed) for seed in (*range(3), 22, 128)),
     *(("rollers", seed) for seed in range(8)),
     *(pytest.param(*case, marks=pytest.mark.slow)
       for case in (("nip", 41), ("nip", 250), ("wrapped-nip", 184)))],
)  # fmt: skip
def test_every_ending_is_a_certificate_or_says_what_to_change(kind: str, seed: int) -> None:
    told = ending(WIDE[kind](seed))
    assert any(re.match(pattern, told) for pattern in TOLD), told
    if (kind, seed) in (("nip", 250), ("wrapped-nip", 184), ("nip", 41), ("nip", 199)):
        assert told == "solved"
