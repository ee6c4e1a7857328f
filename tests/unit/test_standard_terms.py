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
# Messages state what is wrong, then what is permitted: "5 is out of range; must be <= 2 [m]".
OTHER_FORM = re.compile(r"[:,] must be\b|\bquote\([^()]*\)\} must be\b|\bmust be [^;]*, got\b")
# the changelog has the history; this file has the list
LEFT_OUT = ("CHANGELOG.md", "docs/_build", "tests/unit/test_standard_terms.py")


def lines_with(words: re.Pattern[str], pattern: str) -> list[str]:
    """Return the lines of the files of a pattern in which the words occur, with their places."""
    return [
        f"{name}:{number}: {line.strip()}"
        for path in sorted(ROOT.glob(pattern))
        if path.is_file() and not (name := path.relative_to(ROOT).as_posix()).startswith(LEFT_OUT)
        for number, line in enumerate(path.read_text("utf-8").splitlines(), start=1)
        if words.search(line)
    ]


@pytest.mark.parametrize("pattern", PATTERNS)
def test_no_word_of_private_terminology(pattern: str) -> None:
    assert lines_with(AVOIDED, pattern) == []


@pytest.mark.parametrize("pattern", ["src/**/*.py", "src/**/*.js", "tests/golden/messages.txt"])
def test_what_is_permitted_stands_after_a_semicolon(pattern: str) -> None:
    texts = [line for line in lines_with(OTHER_FORM, pattern) if "/vendor/" not in line]
    # "nodes: must be ..." begins with the name of the field
    assert [line for line in texts if not re.search(r":\d+: \w+: must be", line)] == []


def test_a_word_is_found() -> None:
    assert AVOIDED.search("the told_errors of x")
    assert not AVOIDED.search("nilpotent, retold")
