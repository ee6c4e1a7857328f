"""Type checkers accept what the constructors accept, and find mistakes (evidence: mypy)."""

from __future__ import annotations

import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PROGRAMS = ROOT / "tests" / "typing"


@pytest.mark.slow
def test_type_checkers_know_the_arguments():
    pytest.importorskip("mypy")
    # with the options of the project and from its folder: what mypy has cached of it serves here
    files = [str(PROGRAMS / name) for name in ("accepted.py", "rejected.py")]
    command = [sys.executable, "-m", "mypy", "--no-error-summary", *files]
    environment = os.environ | {"MYPYPATH": "src"}
    report = subprocess.run(
        command, capture_output=True, text=True, check=False, env=environment, cwd=ROOT
    )
    found = re.findall(r"(\w+)\.py:(\d+): error: .*\[([\w-]+)\]", report.stdout)
    lines = (PROGRAMS / "rejected.py").read_text(encoding="utf-8").splitlines()
    expected = [
        ("rejected", str(number), line.rpartition("  # ")[2])
        for number, line in enumerate(lines, start=1)
        if "  # " in line
    ]
    assert len(expected) == 7
    assert found == expected, report.stdout + report.stderr


def test_accepted_programs_run():
    runpy.run_path(str(PROGRAMS / "accepted.py"))
