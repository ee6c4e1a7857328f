"""The load cases of the thesis's Tables 1 and 2, its measured points, and a film, for the tests."""

from __future__ import annotations

from typing import Any

import woundon as wo
from woundon.jorkama2001 import cases
from woundon.jorkama2001.cases import newsprint_nip, paper_nip

__all__ = ["film_nip", "measured_tensions", "newsprint_nip", "paper_nip"]


def film_nip(**changes: Any) -> wo.NipProblem:
    """A polyester film with entrained air under a rubber-covered lay-on roll, not of the thesis."""
    film = wo.Isotropic(youngs_modulus=5e9, poissons_ratio=0.3)
    stack = wo.Isotropic(youngs_modulus=100e6, poissons_ratio=0.3)
    rubber = wo.Isotropic(youngs_modulus=3e6, poissons_ratio=0.48)
    return wo.NipProblem(
        web=wo.Web(thickness=23e-6, material=film),
        roll=wo.HalfPlane(radius=0.2, material=stack),
        drum=wo.HalfPlane(radius=0.1, material=rubber),
        roll_friction=0.25, drum_friction=0.4, nip_load=300.0, web_tension=100.0,
        web_speed=1.0, air=wo.Air(roughness=0.3e-6),
    ).replace(**changes)  # fmt: skip


def measured_tensions() -> list[dict[str, float]]:
    """Table 3, rows put right: nip_load, web_tension, measured, thesis_theory [N/m]."""
    return cases.measured_tensions().to_dict("records")
