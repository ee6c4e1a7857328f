"""The wound roll: a stack under the pressure that was wound into it, stiffer still under a nip."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ..contact.response import Response
from ..elasticity.half_plane import coefficients
from ..elasticity.hardening import HardeningLaw
from ..elasticity.hardening_ring import HardeningRing
from ..errors import InvalidProblem
from ..quantities import stress
from .bodies import Body, CoreRadius, Cylinder, core_inside
from .direct import respond
from .fields import Number, shown
from .materials import Orthotropic
from .stack import AnyStack

if TYPE_CHECKING:
    from ..contact.response import ContactGrid, Tractions

__all__ = ["WoundRoll"]

Array = np.ndarray

ALMOST = 0.9  # of the pressure at which a law ends


class WoundRoll(Body):
    """A roll of a stack that hardens under the pressure wound in and under that of the nip.

    Parameters
    ----------
    radius, core_radius : float
        R and R0 [m], as of a :class:`~woundon.problems.bodies.Cylinder`.
    stack : Stack
    pressure : float
        P0, wound in, alike at all radii [Pa], >= 0.
    hardening : "direct"
        The equilibrium of the roll under all loads, by finite elements.

    Raises
    ------
    InvalidProblem
        For a core that is not smaller than the roll, or a pressure at which the stack's law ends.
    """

    core_radius: CoreRadius
    stack: AnyStack
    pressure: Annotated[
        Number, stress("P0", "pressure wound into the roll", "kPa", (10e3, 1e6)), Field(ge=0)
    ]
    hardening: Literal["direct"] = "direct"

    linear: ClassVar[bool] = False

    @model_validator(mode="after")
    def _admissible(self) -> Self:
        core_inside(self)
        if self.pressure >= self.stack.limit:
            raise InvalidProblem.at(
                "pressure",
                f"{shown(self.pressure)} is out of range; must be >= 0 and < {self.stack.limit:.6g}"
                " [Pa], where the stack's law ends or its modulus is tangential/poissons_ratio^2",
            )
        return self

    @property
    def thickness(self) -> float:
        """Thickness R - R0 of what deforms [m]."""
        return self.radius - self.core_radius

    @property
    def compliance(self) -> float:
        """C of the half-plane that the wound surface is near a line load [1/Pa]."""
        return coefficients(*self.stack.tangent(self.pressure, self.pressure)).C

    def stand_in(self, pressure: float) -> Cylinder:
        """Return the cylinder that is as stiff as the roll is under a pressure of the nip too."""
        P = min(self.pressure + pressure, ALMOST * self.stack.limit)
        rr, tt, rt, shear = self.stack.tangent(P, self.pressure)
        material = Orthotropic(radial=rr, tangential=tt, cross=rt, shear=shear)
        return Cylinder(radius=self.radius, core_radius=self.core_radius, material=material)

    def respond(self, grid: ContactGrid, a: float, about: Tractions | None = None) -> Response:
        """Return the response linearised about the loads."""
        return respond(ring(self), self.stack.limit, grid, a, about)


@lru_cache(maxsize=4)
def ring(roll: WoundRoll) -> HardeningRing:
    """Return the ring that a roll is; it keeps what it has found to start from."""
    stack, P0 = roll.stack, roll.pressure
    law = HardeningLaw(
        stack.radial, stack.tangential, stack.poissons_ratio, stack.shear, stack.shear_exponent
    )
    return HardeningRing(roll.radius, roll.core_radius, law, lambda r: np.full(np.shape(r), P0))
