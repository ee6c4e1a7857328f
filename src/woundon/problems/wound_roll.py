"""The wound roll in a nip: a stack that hardens under wound-in and nip pressure."""

from __future__ import annotations

from dataclasses import InitVar
from functools import lru_cache
from math import isfinite
from typing import TYPE_CHECKING, Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from ..elasticity import cylinder
from ..elasticity.half_plane import coefficients
from ..elasticity.hardening import HardeningLaw
from ..elasticity.influence import InfluenceSurface
from ..elasticity.interior_stress import Section, cylinder_sections
from ..errors import InvalidProblem
from ..quantities import stress
from .bodies import Body, CoreRadius, check_core
from .graded import graded_layers, wound_kernels
from .messages import quote
from .schedules import Schedule, at_radius, values_of
from .stack import AnyStack, Stack

if TYPE_CHECKING:
    from ..elasticity.kernels import SurfaceKernels
    from ..elasticity.mesh import Face
    from ..elasticity.ring_equilibrium import RingPair
    from ..elasticity.surface import SurfaceResponse

__all__ = ["WoundRoll"]

Array = np.ndarray


class WoundRoll(Body):
    """A roll whose stack hardens under the wound-in pressure and the pressure of the nip.

    Parameters
    ----------
    radius, core_radius : float
        R and R0 [m], as for a :class:`~woundon.problems.bodies.Cylinder`.
    stack : Stack
    pressure : float or Profile
        P0, pressure wound into the roll [Pa], >= 0.
    hardening : "direct" or "frozen"
        "direct": equilibrium of the roll under all loads, by finite elements.  "frozen": linearised
        at the pressure wound in, without hardening in the nip, therefore too soft; for checks.

    Raises
    ------
    InvalidProblem
        For a core that is not smaller than the roll, or a pressure beyond the stack law.

    Examples
    --------
    >>> import woundon as wo
    >>> stack = wo.grade("newsprint").stack
    >>> roll = wo.WoundRoll(radius=0.5, core_radius=0.05, stack=stack, pressure="200 kPa")
    >>> roll.linear
    False
    """

    core_radius: CoreRadius = Field(...)
    if TYPE_CHECKING:
        core_diameter: InitVar[float | str] = Field(...)
    stack: AnyStack
    pressure: Annotated[
        Schedule, stress("P0", "interlayer pressure in the roll", "kPa", (10e3, 1e6))
    ]
    hardening: Literal["direct", "frozen"] = "direct"

    @model_validator(mode="after")
    def _check_pressure(self) -> Self:
        """Reject a core out of range, or a pressure outside the range of the stack law."""
        check_core(self)
        for name, P in values_of(self.pressure).items():
            # within the law, but its strain energy would be indefinite
            if self.stack.limit <= P < self.stack.radial.max_pressure:
                raise self.stack.beyond_limit(P).under("stack")
            if not 0 <= P < self.stack.limit:
                end = self.stack.radial.max_pressure
                below = f" and < {end:.6g}, where the stack law ends" if isfinite(end) else ""
                raise InvalidProblem.at(
                    f"pressure{name}", f"{quote(P)} is out of range; must be >= 0{below} [Pa]"
                )
        if self.hardening == "direct":
            _check_shear_slope(self.stack)
        return self

    @property
    def linear(self) -> bool:  # type: ignore[override]
        """True if the roll is linearised at the pressure wound in."""
        return self.hardening == "frozen"

    @property
    def validity_warning(self) -> str:  # type: ignore[override]
        """A warning for every result with this body; empty if there is none."""
        misfit = getattr(self.stack.radial, "misfit", 0.0)
        texts = [VALIDITY_WARNINGS[self.hardening]]
        if misfit > WARNING_MISFIT:
            texts.append(f"its stack test is fitted to {misfit:.2g} of its strain only")
        return "; ".join(filter(None, texts))

    @property
    def thickness(self) -> float:
        """Thickness R - R0 of the layers [m]."""
        return self.radius - self.core_radius

    @property
    def compliance(self) -> float:
        """C of the half-plane that the surface resembles near a line load [1/Pa]."""
        P0 = float(self.wound_pressure(np.array(self.radius)))
        return coefficients(*self.stack.tangent(P0, P0)[:4]).C  # A_rr, A_tt, A_rt, G

    @property
    def _kernels(self) -> SurfaceKernels:
        """The influence functions, linearised at the pressure wound into the roll."""
        return wound_kernels(self.radius, self.core_radius, self.stack, self.pressure)

    def wound_pressure(self, r: Array) -> Array:
        """Return the pressure P0 wound into the roll at radii [m], with their shape [Pa]."""
        return at_radius(self.pressure, r)

    def uniform_strain(self, pressure: float) -> float:
        """Return the surface strain under a uniform pressure [Pa], which hardens the roll."""
        if self.hardening == "frozen":
            return pressure * self._kernels.uniform_strain
        from ..elasticity.ring_equilibrium import uniform_strain

        return uniform_strain(ring_of(self), pressure)

    def surface(self, face: Face, half_width: float, speed: float | None = None) -> SurfaceResponse:
        """Return the response of the surface; parameters as of :meth:`.Body.surface`."""
        if self.hardening == "frozen":
            return InfluenceSurface(
                self._kernels, self.radius, curved=True, face=face, half_width=half_width
            )
        # Imported here: SciPy's sparse solvers take 0.25 s to load.
        from ..elasticity.hardening_surface import HardeningSurface

        ring = ring_of(self)
        kernels = cylinder.surface_kernels(self.radius, self.core_radius, *ring.stiffness)
        linear = InfluenceSurface(
            kernels, self.radius, curved=True, face=face, half_width=half_width
        )
        return HardeningSurface(ring, linear, face, half_width, self.stack.limit)

    def interior_stress(
        self, x: Array, p: Array, q: Array, depths: Array, half_width: float
    ) -> tuple[Section, ...]:
        """Return the stresses due to the tractions, without those wound in.

        Parameters as of :meth:`.Body.interior_stress`.
        """
        if self.hardening == "frozen":
            layers = graded_layers(self.radius, self.core_radius, self.stack, self.pressure)
            return cylinder_sections(x, p, q, depths, self.radius, layers)
        from ..elasticity.hardening_surface import hardening_sections

        return hardening_sections(ring_of(self), x, p, q, depths, half_width)


VALIDITY_WARNINGS = {
    "direct": "",
    "frozen": "it is linearised at the pressure wound in, without hardening in the nip: too soft "
    "by up to a factor of six",
}

WARNING_MISFIT = 0.01  # relative misfit of a stack test above which a warning is given


def _check_shear_slope(stack: Stack) -> None:
    """Reject a shear modulus with an infinite slope at zero pressure.

    Shear causes a radial strain in proportion to this slope.  The shear modulus varies as
    E_r(P)^beta with beta the shear exponent: for beta > 0 its slope is infinite if that of E_r is.
    """
    if stack.shear_exponent == 0:
        return
    if not isfinite(float(stack.radial.modulus_slope(np.zeros(())))):
        raise InvalidProblem.at(
            "stack.shear_exponent",
            f"{quote(stack.shear_exponent)} is out of range; must be 0 for a radial law with "
            "an infinite slope at P = 0, such as a PowerLaw with m < 1",
        )


@lru_cache(maxsize=4)
def ring_of(roll: WoundRoll) -> RingPair:
    """Return the finite-element rings of a roll; they keep the last solution as initial guess."""
    from ..elasticity.ring_equilibrium import RingPair

    stack = roll.stack
    law = HardeningLaw(
        stack.radial, stack.tangential, stack.poissons_ratio, stack.shear, stack.shear_exponent
    )
    return RingPair(roll.radius, roll.core_radius, law, roll.wound_pressure)
