"""Limits of requests, which the page shows too."""

from __future__ import annotations

__all__ = ["LIMITS"]

LIMITS = {
    "body_bytes": 1_000_000,
    "sweep_cases": 2500,
    "curve_points": 41,
    "solve_seconds": 60,
    "document_seconds": 180,
    "study_seconds": 600,
    "compare": 4,
    "fit_rows": 100,
    "fit_unknowns": 2,
}
