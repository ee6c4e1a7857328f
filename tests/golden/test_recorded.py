"""Numbers, texts, files, names and panels are those recorded before the support code is rewritten.

Evidence: invariance.  ``UPDATE_GOLDEN=1 ./run test tests/golden/test_recorded.py`` rewrites the
records of ``tests/golden/recorded``; every difference needs a line in the changelog.
"""

from __future__ import annotations

import inspect
import json
import os
import re
from pathlib import Path
from typing import Any

import pytest
from golden.recorded import RECORDS, ROOT

FOLDER = Path(__file__).with_name("recorded")
# On the same processor the same operations give the same digits; on another one the rounding
# differs, and Newton's iterations end where the residuals are below 1e-8.
RTOL = 1e-9 if os.environ.get("GOLDEN_EXACT") else 1e-6
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")


@pytest.mark.slow
@pytest.mark.parametrize("name", RECORDS)
def test_the_record_is_that_of_the_file(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("COLUMNS", "100")
    record = RECORDS[name]
    made = record(tmp_path) if inspect.signature(record).parameters else record()
    path = FOLDER / name
    text = made if isinstance(made, str) else lines_of(made)
    if os.environ.get("UPDATE_GOLDEN"):
        path.write_text(text, encoding="utf-8")
    kept = path.read_text(encoding="utf-8")
    if isinstance(made, str):
        assert_same_text(text, kept)
    else:
        assert_same(json.loads(text), json.loads(kept), name)


def lines_of(record: dict[str, Any]) -> str:
    """Return a record as JSON with one entry in each line."""
    entries = (f"{json.dumps(name)}: {json.dumps(entry)}" for name, entry in record.items())
    return "{\n" + ",\n".join(entries) + "\n}\n"


def assert_same(made: Any, kept: Any, where: str) -> None:
    """Assert that two trees of JSON have the same keys and texts, and numbers within RTOL."""
    if isinstance(kept, dict):
        assert list(made) == list(kept), where
        for name in kept:
            assert_same(made[name], kept[name], f"{where}, {name}")
    elif isinstance(kept, list) and all(isinstance(one, int | float) for one in kept):
        # what vanishes is a rounding error of the largest
        largest = max(map(abs, kept), default=0.0)
        assert made == pytest.approx(kept, rel=RTOL, abs=RTOL * largest, nan_ok=True), where
    elif isinstance(kept, list):
        assert len(made) == len(kept), where
        for k, (one, other) in enumerate(zip(made, kept, strict=True)):
            assert_same(one, other, f"{where}, {k}")
    elif isinstance(kept, float):
        # outputs that vanish by symmetry are rounding errors of about 1e-17
        assert made == pytest.approx(kept, rel=RTOL, abs=1e-12, nan_ok=True), where
    else:
        assert made == kept, where


def assert_same_text(made: str, kept: str) -> None:
    """Assert that two texts have the same words, and printed numbers within 0.1 %."""
    # which residual is the largest depends on the rounding
    made, kept = (re.sub(r"largest residual .*", "largest residual", text) for text in (made, kept))
    for line, other in zip(made.splitlines(), kept.splitlines(), strict=False):
        assert NUMBER.sub("#", line).split() == NUMBER.sub("#", other).split(), other
        for one, two in zip(NUMBER.findall(line), NUMBER.findall(other), strict=True):
            # residuals are rounding errors
            assert float(one) == pytest.approx(float(two), rel=1e-3, abs=1e-8), (line, other)
    assert len(made.splitlines()) == len(kept.splitlines())
