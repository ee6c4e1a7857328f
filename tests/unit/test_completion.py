"""Completion in the shell: what the installation page tells to write works."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "start" / "installation.md"
# what the script of each shell ends with: the shell is reported whom to ask
REGISTERED = {
    "bash": r"complete -o nosort -F \w+ woundon",
    "zsh": r"compdef \w+ woundon",
    "fish": r"complete --no-files --command woundon",
}


@pytest.fixture
def environment(tmp_path) -> dict[str, str]:
    """An environment whose ``woundon`` is the one that is tested."""
    command = tmp_path / "woundon"
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m woundon "$@"\n')
    command.chmod(0o755)
    path = os.pathsep.join([str(tmp_path), os.environ["PATH"]])
    return {**os.environ, "PATH": path, "PYTHONPATH": os.pathsep.join(sys.path)}


def instructions_for(shell: str) -> str:
    """Return the line that the page gives for a shell."""
    found = re.search(rf"^```{shell}\n(.*)\n```$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert found
    return found[1]


def run(line: str, environment: dict[str, str]) -> str:
    done = subprocess.run(
        ["bash", "-c", line], env=environment, capture_output=True, text=True, check=True
    )
    return done.stdout


@pytest.mark.parametrize("shell", REGISTERED)
def test_the_script_of_each_shell_is_written(shell, environment):
    asked = re.search(r"_WOUNDON_COMPLETE=\w+ woundon", instructions_for(shell))
    assert asked
    assert re.search(REGISTERED[shell], run(asked[0], environment))
