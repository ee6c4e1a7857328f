"""The web wrapped on the roll behind the nip and on the drum before it (thesis sec. 3.5)."""

from __future__ import annotations

from .result import WrappedNipResult, WrappedResiduals
from .solve import solve_wrapped_nip

__all__ = ["WrappedNipResult", "WrappedResiduals", "solve_wrapped_nip"]
