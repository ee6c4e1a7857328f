"""The examples in the docstrings of the registry, the plug-ins and the command line."""

from __future__ import annotations

import doctest
from types import ModuleType

import pytest

from woundon import kinds, plugins
from woundon.cli import commands, options
from woundon.io import case_texts


@pytest.mark.parametrize("module", [kinds, plugins, commands, options, case_texts])
def test_the_examples_of_a_module_are_right(module: ModuleType, monkeypatch) -> None:
    monkeypatch.setattr(plugins, "_COMMANDS", dict(plugins._COMMANDS))
    outcome = doctest.testmod(module)
    assert outcome.attempted > 0
    assert outcome.failed == 0
