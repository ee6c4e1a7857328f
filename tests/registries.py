"""The registries of kinds and plug-ins, kept as they are for the time of a test."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from copy import copy

from woundon import kinds, plugins

__all__ = ["registries_kept"]

REGISTRIES = (
    (kinds, "_KINDS"), (plugins, "_COMMANDS"), (plugins, "_FIGURES"), (plugins, "_OUTPUTS"),
)  # fmt: skip


@contextmanager
def registries_kept() -> Iterator[None]:
    """Forget at the end what was registered in between: an example of a docstring may do so."""
    plugins.load()  # installed plug-ins are loaded once, and stay
    kept = [(module, name, copy(getattr(module, name))) for module, name in REGISTRIES]
    try:
        yield
    finally:
        for module, name, registry in kept:
            setattr(module, name, registry)
