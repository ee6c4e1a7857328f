"""Words of private terminology appear nowhere: the standard terms stand for them.

Evidence: consistency of code, page, tests and documentation with the list of standard terms.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
# standard terms: error estimate, initial guess, recompute, next to, zero, contact conditions
AVOIDED = re.compile(
    r"(?<![a-z])(told|foreseen|anew|afresh|astray|nil|besides?|laws hold)(?![a-z])", re.IGNORECASE
)
PATTERNS = (
    "*.md", "docs/**/*.md", "docs/*.py", "docs/_ext/*.py", "examples/**/*.*", "benchmarks/*.py",
    "tests/**/*.py", "src/**/*.py", "src/**/*.js", "src/**/*.html", "src/**/*.css",
)  # fmt: skip
# the changelog has the history; this file has the list
LEFT_OUT = ("CHANGELOG.md", "docs/_build", "tests/unit/test_standard_terms.py")


@pytest.mark.parametrize("pattern", PATTERNS)
def test_no_word_of_private_terminology(pattern: str) -> None:
    found = [
        f"{name}:{number}: {line.strip()}"
        for path in sorted(ROOT.glob(pattern))
        if path.is_file() and not (name := path.relative_to(ROOT).as_posix()).startswith(LEFT_OUT)
        for number, line in enumerate(path.read_text("utf-8").splitlines(), start=1)
        if AVOIDED.search(line)
    ]
    assert found == []


def test_a_word_is_found() -> None:
    assert AVOIDED.search("the told_errors of x")
    assert not AVOIDED.search("nilpotent, retold")
