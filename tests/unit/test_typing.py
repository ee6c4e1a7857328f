"""Type checkers accept what the constructors accept, and find mistakes (evidence: mypy)."""

from __future__ import annotations

import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAMS = Path(__file__).parents[1] / "typing"


@pytest.mark.slow
def test_type_checkers_know_the_arguments():
    pytest.importorskip("mypy")
    files = [str(PROGRAMS / name) for name in ("accepted.py", "rejected.py")]
    options = ["--no-error-summary", "--config-file=", "--ignore-missing-imports"]
    command = [sys.executable, "-m", "mypy", *options, *files]
    environment = os.environ | {"MYPYPATH": str(PROGRAMS.parents[1] / "src")}
    report = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
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
