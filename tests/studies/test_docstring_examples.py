"""The examples in the docstrings of io and studies run, and every public name has one."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
from pathlib import Path

import pytest

import woundon as wo
import woundon.io
import woundon.studies

# an example would take half a minute; it is on the how-to pages
TOO_SLOW = {"OperatingWindow"}
PUBLIC = sorted(name for name in wo.__all__ if not name.startswith("_") and name not in TOO_SLOW)
MODULES = [
    info.name
    for package in (woundon.io, woundon.studies)
    for info in pkgutil.iter_modules(package.__path__, f"{package.__name__}.")
]


@pytest.mark.parametrize("name", MODULES)
def test_examples_run(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    module = importlib.import_module(name)
    assert doctest.testmod(module, optionflags=doctest.IGNORE_EXCEPTION_DETAIL).failed == 0


@pytest.mark.parametrize("name", PUBLIC)
def test_public_names_of_io_and_studies_have_an_example(name: str):
    thing = getattr(wo, name)
    if getattr(thing, "__module__", "").startswith(("woundon.io.", "woundon.studies.")):
        assert ">>> " in (thing.__doc__ or "")
