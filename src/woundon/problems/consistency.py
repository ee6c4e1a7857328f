"""Contradictions between values that describe the same paper in two places."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from .materials import Orthotropic
from .stack import Stack

if TYPE_CHECKING:
    from .web import Web

__all__ = ["different_moduli"]

# Relative difference above which two moduli describe different papers; plane strain and the
# pressure at which the thickness is measured cause smaller differences.
TOLERANCE = 0.01


def different_moduli(web: Web, field: str, layers: object) -> Iterator[str]:
    """Yield a sentence if web and roll have different moduli along the web.

    Parameters
    ----------
    web : Web
    field : str
        Name of the field that describes the layers in the roll.
    layers : Stack, Material or other
        Stack or material of the layers.  An isotropic material describes the roll as a whole and is
        not compared.
    """
    if not isinstance(layers, (Orthotropic, Stack)):
        return
    E_web, E_roll = 1 / web.compliance.c11, _modulus_along(layers)
    if abs(E_roll - E_web) > TOLERANCE * E_web:
        yield (
            f"web.material and {field} describe two papers: their moduli along the web are "
            f"{E_web / 1e9:.4g} and {E_roll / 1e9:.4g} GPa"
        )


def _modulus_along(layers: Orthotropic | Stack) -> float:
    """Return the plane-strain modulus along the web [Pa]."""
    if isinstance(layers, Stack):
        return layers.tangential
    A = layers.stiffness
    return A.tt - A.rt**2 / A.rr
