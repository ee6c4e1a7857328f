"""The examples in the docstrings of all modules are executed; their output is compared."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import pytest
from registries import registries_kept
from slow_cases import slow_case

import woundon
from woundon import plugins


def modules_with_examples() -> list[str]:
    root = Path(woundon.__file__).parent
    files = (file for file in sorted(root.rglob("*.py")) if ">>> " in file.read_text("utf-8"))
    return [".".join(("woundon", *file.relative_to(root).with_suffix("").parts)) for file in files]


# the example of woundon.studies.window is nearly the same
@pytest.mark.parametrize(
    "name",
    [slow_case(n) if n.endswith(".window_result") else n for n in modules_with_examples()],
)
def test_examples_of_a_module(name: str) -> None:
    result = doctest.testmod(importlib.import_module(name), verbose=False)
    assert result.failed == 0


def test_what_an_example_registers_is_forgotten() -> None:
    """The lists of commands in other tests do not depend on the examples before them."""
    before = dict(plugins.commands())
    with registries_kept():
        doctest.testmod(plugins)
        assert {*plugins.commands()} - {*before} == {"basis-weight", "greet"}
    assert plugins.commands() == before


@pytest.mark.parametrize("name", woundon.__all__)
def test_a_public_name_has_an_example_that_runs(name: str) -> None:
    text = getattr(woundon, name).__doc__
    assert ">>> " in text
    assert "+SKIP" not in text
