"""Nips of thesis Table 2 whose roll hardens, and bodies to compare with."""

from __future__ import annotations

from functools import cache
from typing import Any, ClassVar

import numpy as np

import woundon as wo
from woundon.elasticity.hardening import HardeningLaw
from woundon.elasticity.hardening_surface import HardeningSurface
from woundon.elasticity.mesh import Face
from woundon.elasticity.ring_equilibrium import RingPair
from woundon.problems.radial_laws import Constant

NEWSPRINT: Any = wo.material("newsprint")
E_T = NEWSPRINT.tangential - NEWSPRINT.cross**2 / NEWSPRINT.radial
NU = NEWSPRINT.cross / NEWSPRINT.radial


def roll(K1: float = 10e3, K2: float = 127.0, P0: float = 90e3, **stack: float) -> wo.WoundRoll:
    """Return the laboratory winder's roll, hardening by Pfeiffer's law."""
    given = {"tangential": E_T, "poissons_ratio": NU, "shear": 10e6} | stack
    material = wo.Stack(radial=wo.Pfeiffer(K1=K1, K2=K2), **given)
    return wo.WoundRoll(radius=0.1, core_radius=0.0445, stack=material, pressure=P0)


def linear(roll: wo.WoundRoll, pressure: float) -> wo.Cylinder:
    """Return the linear cylinder as stiff as the stack under a pressure."""
    rr, tt, rt, shear = roll.stack.tangent(pressure, roll.pressure)[:4]
    material = wo.Orthotropic(radial=rr, tangential=tt, cross=rt, shear=shear)
    return wo.Cylinder(radius=roll.radius, core_radius=roll.core_radius, material=material)


def nip(body: wo.Body, nip_load: float = 3502.0, **changes: Any) -> wo.NipProblem:
    """Return Table 2's nip with another roll."""
    fields = {
        "web": wo.Web(thickness=66e-6, material=NEWSPRINT), "roll": body,
        "drum": wo.Rigid(radius=0.0762), "roll_friction": 0.19, "drum_friction": 0.2,
        "nip_load": nip_load, "winding_force": 0.0, "web_tension": 350.0,
    }  # fmt: skip
    return wo.NipProblem(**fields | changes, roll_wrap=0.0)


class OtherReference(wo.Body, abstract=True):  # of the tests alone
    """A linear cylinder by elements that supply the difference to one of another modulus."""

    core_radius: float
    modulus: float
    reference: float

    linear: ClassVar[bool] = False

    @property
    def compliance(self) -> float:
        """That of the newsprint [1/Pa]."""
        return wo.Cylinder(radius=0.1, core_radius=0.0445, material=NEWSPRINT).compliance

    def surface(
        self, face: Face, half_width: float, speed: float | None = None
    ) -> HardeningSurface:
        """Return the response of the elements and of the other cylinder."""
        linear = linear_of(self.reference).surface(face, half_width)
        pair = constant_rings(self.modulus, self.reference)
        return HardeningSurface(pair, linear, face, half_width, np.inf)


def law_of(modulus: float) -> HardeningLaw:
    """Return a law that does not harden."""
    return HardeningLaw(Constant(youngs_modulus=modulus), E_T, NU, 10e6)


def linear_of(modulus: float) -> wo.Cylinder:
    """Return the linear cylinder of a modulus through it."""
    rr, tt, rt, shear = law_of(modulus).stiffness(0.0)
    material = wo.Orthotropic(radial=rr, tangential=tt, cross=rt, shear=shear)
    return wo.Cylinder(radius=0.1, core_radius=0.0445, material=material)


@cache
def constant_rings(modulus: float, reference: float) -> RingPair:
    """Return rings of two constant moduli."""

    class Pair(RingPair):
        @property
        def stiffness(self) -> tuple[float, float, float, float]:
            return law_of(reference).stiffness(0.0)

    return Pair(0.1, 0.0445, law_of(modulus), lambda r: np.zeros(np.shape(r)))
