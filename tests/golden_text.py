"""Comparison of a text with a file of ``tests/golden``.

``UPDATE_GOLDEN=1 ./run test`` with ``tests/unit/test_messages.py`` or ``test_golden_reports.py``
rewrites the files; read the differences before they are committed.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

__all__ = ["assert_golden", "read_golden"]

FOLDER = Path(__file__).parent / "golden"
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")


def read_golden(name: str) -> str:
    """Return the text of a golden file."""
    return (FOLDER / name).read_text("utf-8")


def assert_golden(name: str, text: str, rtol: float = 0.0, atol: float = 0.0) -> None:
    """Assert that a text is that of a golden file; its numbers within tolerances."""
    if os.environ.get("UPDATE_GOLDEN"):
        (FOLDER / name).write_text(text, "utf-8")
    expected = read_golden(name)
    if not rtol:
        assert text == expected
        return

    def words(one: str) -> list[list[str]]:
        return [NUMBER.sub("#", line).split() for line in one.splitlines()]

    assert words(text) == words(expected)
    for line, other in zip(text.splitlines(), expected.splitlines(), strict=True):
        for one, two in zip(NUMBER.findall(line), NUMBER.findall(other), strict=True):
            assert abs(float(one) - float(two)) <= rtol * abs(float(two)) + atol, (line, other)
