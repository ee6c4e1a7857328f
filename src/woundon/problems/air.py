"""Air that comes in with the web, and a nip with it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from ..elasticity.relaxation import factor
from ..errors import InvalidProblem
from ..quantities import Quantity, length, pure, stress, velocity
from .air_law import AirBetween
from .bodies import Body, HalfPlane
from .fields import Description, Number, shown
from .materials import Isotropic
from .nip import Web, WrappedNip, WrappedNipProblem
from .radial_laws import SolidLaw
from .roll import WoundRollProblem

__all__ = ["Air", "AirNipProblem", "with_film"]


class Air(Description):
    """The air around a winder, and the surfaces that it is caught between.

    Parameters
    ----------
    roughness : float
        Root mean square of both facing surfaces of the web together, sqrt(s1^2 + s2^2) [m].
    viscosity : float
        Of the air [Pa s].
    ambient_pressure : float
        [Pa].
    permeance : float
        Speed of the air through the web per pressure across it [m/(Pa s)]: 0 for film, of paper as
        measured.
    full_friction, no_friction : float
        Film up to which friction is that without air, and from which there is none, in
        roughnesses; linear between.
    """

    roughness: Annotated[
        Number, length("s", "rms roughness of both surfaces together", "um", (0.05e-6, 10e-6)),
        Field(gt=0, le=1e-3),
    ]  # fmt: skip
    viscosity: Annotated[
        Number, Quantity("mu_a", "Pa*s", "viscosity of the air", typical=(1.7e-5, 2e-5)),
        Field(ge=1e-7, le=1e-2),
    ] = 1.81e-5  # fmt: skip
    ambient_pressure: Annotated[
        Number, stress("p_a", "ambient pressure", "kPa", (80e3, 105e3)), Field(ge=1e3, le=1e7)
    ] = 101325.0
    permeance: Annotated[
        Number, Quantity("k_a", "m/Pa/s", "permeance of the web", typical=(0.0, 1e-5)),
        Field(ge=0, le=1),
    ] = 0.0  # fmt: skip
    full_friction: Annotated[
        Number, pure("h/s full", "film up to which friction is full, in roughnesses", (0.5, 2.0)),
        Field(ge=0, le=100),
    ] = 1.0  # fmt: skip
    no_friction: Annotated[
        Number, pure("h/s none", "film that leaves no friction, in roughnesses", (2.0, 4.0)),
        Field(gt=0, le=100),
    ] = 3.0  # fmt: skip

    @model_validator(mode="after")
    def _falls(self) -> Self:
        if self.no_friction <= self.full_friction:
            raise InvalidProblem.at(
                "no_friction",
                f"{shown(self.no_friction)} is out of range; must be > full_friction = "
                f"{self.full_friction:.6g} [1]",
            )
        return self

    def too_rough(self, thickness: float) -> Iterator[tuple[str, str]]:
        """Yield the field at fault and what to say where a web is rougher than thick [m]."""
        if self.roughness >= thickness:
            yield (
                "roughness",
                f"{shown(self.roughness)} is out of range; must be < the web's thickness, "
                f"{thickness:.6g} [m]",
            )


def with_film(roll: WoundRollProblem, film: float, air: Air) -> WoundRollProblem:
    """Return a roll whose laps hold a film of air between them; see :class:`.AirBetween`.

    Parameters
    ----------
    roll : WoundRollProblem
        Without air.
    film : float
        At ambient pressure [m].
    air : Air

    Raises
    ------
    InvalidProblem
        If the roll's stack has air already.
    """
    if film == 0:
        return roll
    stack, web = roll.stack, roll.web_thickness
    if not isinstance(stack.radial, SolidLaw):
        raise InvalidProblem.at("stack.radial", "has air already; must be without")
    law = AirBetween(
        law=stack.radial, film=film, web_thickness=web, ambient_pressure=air.ambient_pressure
    )
    solid = web / (web + film)
    return roll.replace(
        stack=stack.replace(radial=law, tangential=stack.tangential * solid),
        web_thickness=web + film,
        density=None if roll.density is None else roll.density * solid,
    )


class AirNipProblem(WrappedNip):
    """A winding nip and the air that the web brings: the friction it leaves, and the tension.

    Parameters
    ----------
    web, roll, drum, roll_friction, drum_friction, nip_load, winding_force, web_tension
        As of :class:`WrappedNipProblem`; the friction is that without air.
    roll_wrap, drum_wrap, wrap_friction
        As of :class:`WrappedNipProblem`.
    web_speed : float
        V of web, roll and drum [m/s]; at 0 the answers are those without air.
    air : Air

    Raises
    ------
    InvalidProblem
        Naming every field, value and range at fault; where neither roll nor drum deforms.
    NoSteadyState
        As of :class:`WrappedNipProblem`.
    """

    web_speed: Annotated[Number, velocity("V", "web speed", (1.0, 50.0)), Field(ge=0, le=200)]
    air: Air

    def uses_of_speed(self) -> Iterator[tuple[str, str]]:
        """Yield what depends on the speed: the air does, and viscoelastic bodies."""
        yield "air", "air comes in with the web"
        yield from super().uses_of_speed()

    @model_validator(mode="after")
    def _turns(self) -> Self:
        if self.viscoelastic and self.web_speed == 0:
            uses = next(text for field, text in super().uses_of_speed())
            raise InvalidProblem.at("web_speed", f"0 is out of range; must be > 0 [m/s], as {uses}")
        return self

    @model_validator(mode="after")
    def _is_smooth(self) -> Self:
        for field, text in self.air.too_rough(self.web.thickness):
            raise InvalidProblem.at(f"air.{field}", text)
        return self

    @model_validator(mode="after")
    def _yields(self) -> Self:
        if not self.compliance > 0:
            raise InvalidProblem.at(
                "roll",
                "is rigid, and so is the drum; one of them must deform, or there is no nip that "
                "air could pass",
            )
        return self

    @property
    def compliance(self) -> float:
        """C, half the sum of both surfaces' half-plane compliances [1/Pa]."""
        return (self.roll.compliance + self.drum.compliance) / 2

    def compliance_over(self, length: float) -> float:
        """Return C as waves of the wave number 1/length meet it [1/Pa].

        A viscoelastic surface answers them by its modulus at the frequency V/length; a drum that
        the web is wrapped on gives way by C/(1 + T C/length), as the web's tension goes along.

        Parameters
        ----------
        length : float
            [m]; 0 at rest.
        """
        roll, drum = (self._met(body, length) for body in self.bodies)
        if self.drum_wrap > 0 and length > 0:
            drum /= 1 + self.web_tension * drum / length
        return (roll + drum) / 2

    def _met(self, body: Body, length: float) -> float:
        material = body.surface_material
        if material is None or not material.relaxes:
            return body.compliance
        relaxation = material.relaxation(self.web_speed)
        return float(body.compliance / abs(factor(relaxation, np.array(1 / length))))

    def without_air(self, roll_friction: float, wrap_friction: float) -> WrappedNipProblem:
        """Return the nip as one without air, with friction in it and behind it."""
        fields = {name: getattr(self, name) for name in WrappedNipProblem.model_fields}
        if not self.viscoelastic:
            fields["web_speed"] = None  # nothing but the air depends on it
        if (roll_friction, wrap_friction) != (self.roll_friction, self.friction_behind):
            fields |= {"roll_friction": roll_friction, "wrap_friction": wrap_friction}
        return WrappedNipProblem(**fields)

    @classmethod
    def example(cls) -> Self:
        """Return a polyester film under a rubber-covered lay-on roll; roughness illustrative."""
        film = Isotropic(youngs_modulus=5e9, poissons_ratio=0.3)
        stack = Isotropic(youngs_modulus=100e6, poissons_ratio=0.3)
        rubber = Isotropic(youngs_modulus=3e6, poissons_ratio=0.48)
        return cls(
            web=Web(thickness=23e-6, material=film),
            roll=HalfPlane(radius=0.2, material=stack),
            drum=HalfPlane(radius=0.1, material=rubber),
            roll_friction=0.25, drum_friction=0.4, nip_load=300.0, web_tension=100.0,
            web_speed=1.0, air=Air(roughness=0.3e-6),
        )  # fmt: skip
