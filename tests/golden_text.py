"""Comparison of a text with a file of ``tests/golden``.

``UPDATE_GOLDEN=1 ./run test`` with ``tests/unit/test_messages.py`` rewrites the file; read the
differences before they are committed.
"""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["assert_golden", "read_golden"]

FOLDER = Path(__file__).parent / "golden"


def read_golden(name: str) -> str:
    """Return the text of a golden file."""
    return (FOLDER / name).read_text("utf-8")


def assert_golden(name: str, text: str) -> None:
    """Assert that a text is that of a golden file."""
    if os.environ.get("UPDATE_GOLDEN"):
        (FOLDER / name).write_text(text, "utf-8")
    assert text == read_golden(name)
