"""Pairs of rollers with published or closed solutions, for the tests."""

from __future__ import annotations

from typing import Any

import woundon as wo

__all__ = ["STEEL", "dissimilar_pair", "steel_pair"]

STEEL = wo.HalfPlane(radius=0.25, material=wo.material("steel"))


def steel_pair(**fields: Any) -> wo.RollerProblem:
    """Return two equal steel rollers: thesis Fig. 5 with a tangential load below sliding."""
    given: dict[str, Any] = {"load": 89e3, "friction": 0.5, "tangential_load": 8.4e3}
    return wo.RollerProblem(upper=STEEL, lower=STEEL, **(given | fields))


def dissimilar_pair(friction: float = 0.1, radius: float = 0.05, **fields: Any) -> wo.RollerProblem:
    """Return Bentall and Johnson's pair: shear moduli 23 and 82 GPa, nu = 0.31 and 0.28.

    The published half width by Hertz, 0.1 mm, load and creepages agree with each other for a
    relative radius of 25 mm, that is rollers of 50 mm.
    """
    upper, lower = (
        wo.HalfPlane(
            radius=radius,
            material=wo.Isotropic(youngs_modulus=2 * shear * (1 + nu), poissons_ratio=nu),
        )
        for shear, nu in ((23e9, 0.31), (82e9, 0.28))
    )
    given: dict[str, Any] = {"load": 16201.9, "friction": friction}
    return wo.RollerProblem(upper=upper, lower=lower, **(given | fields))
