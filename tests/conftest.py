"""Settings of all tests: hypothesis draws the same examples every time; a server of the page."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers

from woundon.parallel import environment

# as ./run test has it, before NumPy loads: by two threads sums may end in another digit
for _name, _one in environment().items():
    os.environ.setdefault(_name, _one)

settings.register_profile(
    "repeatable",
    derandomize=True,
    deadline=None,  # a shared machine may be slow
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("repeatable")
# what it finds in the modules that happen to be loaded would make the examples others
providers._get_local_constants = lambda: providers._local_constants


def pytest_collection_finish() -> None:
    """Leave what is collected alone: searched again and again, it is a tenth of the time."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def process() -> Iterator[Any]:
    """A server of the page on a free port, as people start it; its workers are ready."""
    from page_server import serving

    with serving() as started:
        yield started


@pytest.fixture(autouse=True)
def _registries() -> Iterator[None]:
    """Forget the kinds and commands that a test has registered: other tests list them."""
    from registries import registries_kept

    with registries_kept():
        yield


@pytest.fixture(autouse=True)
def _closed_figures() -> Iterator[None]:
    """Close the figures that a test has drawn and not saved: they are pyplot's."""
    yield
    pyplot = sys.modules.get("matplotlib.pyplot")
    if pyplot is not None:
        pyplot.close("all")


@pytest.fixture(autouse=True, scope="module")
def _memory(request: pytest.FixtureRequest) -> Iterator[None]:
    """Release the cached solutions and influence matrices when a module of tests ends.

    glibc keeps the freed blocks, more than a gigabyte, unless a limit makes it return them.
    """
    yield
    elastic = [module for name, module in sys.modules.items() if "woundon.elasticity" in name]
    for module in (request.module, *elastic):
        for cached in list(vars(module).values()):
            if hasattr(cached, "cache_clear"):
                cached.cache_clear()
    with suppress(OSError, AttributeError):
        ctypes.CDLL("libc.so.6").malloc_trim(0)
