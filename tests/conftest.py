"""Settings of all tests: hypothesis draws the same examples in every run."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

settings.register_profile(
    "repeatable",
    derandomize=True,
    deadline=None,  # a shared machine may be slow
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("repeatable")
