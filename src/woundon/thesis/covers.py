"""Drums with a soft cover on a rigid shell, for Figs. 23 to 27."""

from __future__ import annotations

from typing import Any

from ..bodies import Cylinder
from ..materials import Isotropic
from ..problems import NipProblem
from .cases import paper_nip

__all__ = ["COVER_THICKNESS", "covered_nip"]

DRUM_RADIUS, COVER_THICKNESS = 0.5, 0.02  # [m]


def covered_nip(
    youngs_modulus: float,
    poissons_ratio: float,
    thickness: float = COVER_THICKNESS,
    **changes: Any,
) -> NipProblem:
    """Return Table 1's nip with a drum cover of E [Pa], nu and a thickness [m]."""
    cover = Isotropic(youngs_modulus=youngs_modulus, poissons_ratio=poissons_ratio)
    drum = Cylinder(radius=DRUM_RADIUS, core_radius=DRUM_RADIUS - thickness, material=cover)
    return paper_nip(drum=drum, **changes)
