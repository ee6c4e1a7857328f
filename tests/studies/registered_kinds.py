"""Kinds of problem that are registered for the time of a test."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from types import ModuleType

from registries import registries_kept

__all__ = ["registered"]


@contextmanager
def registered(module: str) -> Iterator[ModuleType]:
    """Import a module, which registers a kind; forget both at the end."""
    with registries_kept():
        yield import_module(module)
    del sys.modules[module]
