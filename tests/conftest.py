"""Settings of all tests: hypothesis draws the same examples every time; a server of the page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

settings.register_profile(
    "repeatable",
    derandomize=True,
    deadline=None,  # a shared machine may be slow
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def process() -> Iterator[Any]:
    """A server of the page on a free port, as people start it; its workers are ready."""
    from page_server import serving

    with serving() as started:
        yield started
