"""Kinds of problem that are registered for the time of a test."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType

from woundon import kinds

__all__ = ["registered"]


@contextmanager
def registered(module: str) -> Iterator[ModuleType]:
    """Import a module, which registers a kind; forget both at the end."""
    before = dict(kinds._KINDS)
    yield import_module(module)
    kinds._KINDS.clear()
    kinds._KINDS.update(before)
    del sys.modules[module]
