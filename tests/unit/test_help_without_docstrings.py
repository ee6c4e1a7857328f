"""The help of all commands is the same where Python leaves docstrings out (``python -OO``)."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache

import pytest

from woundon import plugins
from woundon.cli.commands import commands

PRINT_HELP = """\
import sys
from woundon.cli.commands import main
for name in sys.argv[1:]:
    print("#", name)
    code = main([*name.split(), "--help"])
    if code:
        sys.exit(code)
"""
COMMANDS = ("", *commands.commands, *plugins.commands())


@cache
def texts(flag: str) -> list[str]:
    """Return the help of each command."""
    said = subprocess.run(
        [sys.executable, flag, "-c", PRINT_HELP, *COMMANDS], check=True, capture_output=True,
        text=True, env={**os.environ, "COLUMNS": "100"}, timeout=300,
    )  # fmt: skip
    return said.stdout.split("# ")[1:]


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_help_does_not_depend_on_docstrings(command: str):
    place = COMMANDS.index(command)
    assert texts("-OO")[place] == texts("-B")[place]
    assert len(texts("-OO")) == len(COMMANDS)
