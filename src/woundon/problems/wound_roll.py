"""The wound roll: a stack under the pressure that was wound into it, stiffer still under a nip."""

from __future__ import annotations

from math import inf, isfinite
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import model_validator

from ..contact.response import Response
from ..elasticity.half_plane import coefficients
from ..errors import InvalidProblem
from ..quantities import stress
from .bodies import Body, CoreRadius, Cylinder, core_inside
from .fields import shown
from .graded import estimated, wound_kernels
from .materials import Orthotropic
from .schedules import Schedule, at_radius, values_of
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
    pressure : float or Profile
        P0, wound in [Pa], >= 0.
    hardening : "direct", "estimate" or "frozen"
        "direct": the equilibrium of the roll under all loads, by finite elements.  "estimate": a
        linear cylinder with E_r at P0 + 0.3 p_max, for sweeps that bear 3 % of NIT; only for nips
        without wraps.  "frozen": linear about the wound state, as if the nip pressed nothing
        together; too soft under a nip, for checks.

    Raises
    ------
    InvalidProblem
        For a core that is not smaller than the roll, a pressure at which the stack's law ends, or
        an estimate where it is known to fail.
    """

    core_radius: CoreRadius
    stack: AnyStack
    pressure: Annotated[Schedule, stress("P0", "pressure wound into the roll", "kPa", (10e3, 1e6))]
    hardening: Literal["direct", "estimate", "frozen"] = "direct"

    @model_validator(mode="after")
    def _admissible(self) -> Self:
        core_inside(self)
        for name, P in values_of(self.pressure).items():
            if not 0 <= P < self.stack.limit:
                raise InvalidProblem.at(
                    f"pressure{name}",
                    f"{shown(P)} is out of range; must be >= 0 and < {self.stack.limit:.6g} [Pa], "
                    "where the stack's law ends or its modulus is tangential/poissons_ratio^2",
                )
        if self.hardening == "estimate":
            _estimable(self)
        if self.hardening == "direct" and self.stack.shear_exponent > 0:
            _has_slope(self.stack)
        return self

    @property
    def linear(self) -> bool:  # type: ignore[override]
        """Whether the response is the same about every state."""
        return self.hardening == "frozen"

    @property
    def confined_only(self) -> bool:  # type: ignore[override]
        """Whether only nips without wraps can have it."""
        return self.hardening == "estimate"

    @property
    def caution(self) -> str:  # type: ignore[override]
        """What is to be said with every result."""
        misfit = getattr(self.stack.radial, "misfit", 0.0)
        coarse = f"its stack test is fitted to {misfit:.2g} of its strain only" * (misfit > POOR)
        return "; ".join(filter(None, (CAUTIONS[self.hardening], coarse)))

    @property
    def thickness(self) -> float:
        """Thickness R - R0 of what deforms [m]."""
        return self.radius - self.core_radius

    @property
    def compliance(self) -> float:
        """C of the half-plane that the wound surface is near a line load [1/Pa]."""
        wound = float(self.wound_pressure(self.radius))
        return coefficients(*self.stack.tangent(wound, wound)[:4]).C

    def stand_in(self, pressure: float) -> Cylinder:
        """Return the cylinder that is as stiff as the roll is under a pressure of the nip too.

        The wound pressure counts by its value at the surface.
        """
        wound = float(self.wound_pressure(self.radius))
        P = min(wound + pressure, ALMOST * self.stack.limit)
        rr, tt, rt, shear, _ = self.stack.tangent(P, wound)
        material = Orthotropic(radial=rr, tangential=tt, cross=rt, shear=shear)
        return Cylinder(radius=self.radius, core_radius=self.core_radius, material=material)

    def wound_pressure(self, r: Any) -> Any:
        """Return P0 at radii [Pa]."""
        return at_radius(self.pressure, r)

    def respond(
        self,
        grid: ContactGrid,
        a: float,
        about: Tractions | None = None,
        speed: float | None = None,
    ) -> Response:
        """Return the response, linearised about the loads unless it is frozen."""
        if self.hardening == "direct":
            from .direct import respond, ring  # imported late: most never ask for it

            return respond(ring(self), self.stack.limit, grid, a, about)
        if self.hardening == "estimate":
            return estimated(self, grid, a, about)
        return grid.integrated(wound_kernels(self), self.curvature, self.radius, a)


CAUTIONS = {
    "direct": "",
    "estimate": "its modulus is an estimate, E_r at P0 + 0.3 p_max: the tension may be 3 % off",
    "frozen": "it is taken as linear about the wound state, without the nip's own pressure: too "
    "soft under the nip, by up to a factor of six",
}

POOR = 0.01  # misfit of a stack test, of its strain, from which it is told
SOFTEST_ESTIMATE = 100e3  # Pa, of E_r/E_r' (Pfeiffer's K1 + P0): below, 3 % are not kept


def _has_slope(stack: Any) -> None:
    """Refuse a shear modulus whose slope is infinite where a roll may lose its pressure.

    Shear strains the stack radially in proportion to that slope: without bound there.
    """
    if not isfinite(float(stack.radial.modulus_slope(np.zeros(())))):
        raise InvalidProblem.at(
            "stack.shear_exponent",
            f"{shown(stack.shear_exponent)} is out of range; must be 0 with a radial law that "
            "sets in with an infinite slope, as a PowerLaw with m < 1 does",
        )


def _estimable(roll: WoundRoll) -> None:
    """Refuse an estimate where a direct solution has shown that it fails."""
    if roll.stack.shear_exponent > 0:
        text = "'estimate' is out of place where the shear modulus hardens (stack.shear_exponent "
        raise InvalidProblem.at("hardening", f"{text}> 0); must be 'direct' or 'frozen'")
    surface = roll.wound_pressure(roll.radius)
    radial = roll.stack.radial
    slope = float(radial.modulus_slope(surface))
    own = float(radial.modulus(surface)) / slope if slope > 0 else inf
    if own < SOFTEST_ESTIMATE:
        raise InvalidProblem.at(
            "hardening",
            f"'estimate' needs a stack of E_r/E_r' >= {SOFTEST_ESTIMATE:g} [Pa] at the surface "
            f"(K1 + P0 of Pfeiffer's law), and it is {shown(own)}; must be 'direct' or 'frozen'",
        )
