"""Chapter 5: Table 3 and Fig. 37, made together because they share the fits."""

from __future__ import annotations

from . import fig37, table3
from .frame import Figure, Scheme

__all__ = ["figures"]


def figures(scheme: Scheme = "graded") -> tuple[Figure, ...]:
    """Return Table 3 and Fig. 37."""
    return (*table3.figures(scheme), *fig37.figures(scheme))
