"""The base of the problems of two bodies in contact: nip and rollers."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import ClassVar, Self

from pydantic import model_validator

from ..errors import InvalidProblem
from .bodies import Body, contact_radius
from .problem import Problem

__all__ = ["ContactProblem", "unused_speed"]


def unused_speed(field: str, speed: float) -> str:
    """Return the warning for a speed on which nothing depends."""
    text = f"{field} = {speed:.6g} m/s is not used: the bodies are elastic and there is no air"
    if field == "web_speed":
        text += ", and without density the centrifugal force of the web is neglected"
    return text


class ContactProblem(Problem):
    """Base class of the problems of two bodies pressed together.

    Attributes
    ----------
    pair : (str, str)
        Names of the fields that hold body 1 and body 2.
    speed_field : str
        Name of the field that holds the speed.
    """

    pair: ClassVar[tuple[str, str]]
    speed_field: ClassVar[str]

    @cached_property
    def bodies(self) -> tuple[Body, Body]:
        """Body 1 and body 2."""
        body_1, body_2 = (getattr(self, name) for name in self.pair)
        return body_1, body_2

    @property
    def named_bodies(self) -> dict[str, Body]:
        """All bodies by their dotted names."""
        return {name: getattr(self, name) for name in self.pair}

    @cached_property
    def contact_radius(self) -> float:
        """R* with 1/R* = 1/R1 + 1/R2 [m]."""
        return contact_radius(*self.bodies)

    @cached_property
    def linear(self) -> bool:
        """True if all bodies are linear."""
        return all(body.linear for body in self.named_bodies.values())

    @property
    def thinning(self) -> float:
        """Thickness change of the web between the bodies per pressure [m/Pa]; 0 without a web."""
        return 0.0

    @property
    def rolling_speed(self) -> float | None:
        """V of both surfaces along +x [m/s]; None if nothing depends on it."""
        speed: float | None = getattr(self, self.speed_field)
        return None if next(self.uses_of_speed(), None) is None else speed

    @property
    def input_warnings(self) -> tuple[str, ...]:
        """Warnings about inputs that have no effect."""
        speed = getattr(self, self.speed_field)
        if speed is None or self.speed_has_effect:
            return super().input_warnings
        return (unused_speed(self.speed_field, speed),)

    @property
    def speed_has_effect(self) -> bool:
        """True if the result depends on the speed that is given."""
        return self.rolling_speed is not None

    @cached_property
    def viscoelastic(self) -> bool:
        """True if one of the bodies is viscoelastic."""
        return any(body.viscoelastic for body in self.named_bodies.values())

    def uses_of_speed(self) -> Iterator[tuple[str, str]]:
        """Yield (field, reason) for every part of the problem that depends on the speed."""
        for name, body in self.named_bodies.items():
            if body.viscoelastic:
                yield name, f"{name} is of a viscoelastic material"

    @model_validator(mode="after")
    def _check_missing_speed(self) -> Self:
        """Reject a missing speed if the problem depends on it."""
        use = next(self.uses_of_speed(), None)
        if use is not None and self.rolling_speed is None:
            _, reason = use
            text = f"missing; must be > 0 [m/s], as {reason}"
            raise InvalidProblem.at(self.speed_field, text)
        return self

    @model_validator(mode="after")
    def _check_bodies(self) -> Self:
        """Reject two rigid bodies."""
        body_1, body_2 = self.bodies
        if body_1.rigid and body_2.rigid:
            first, second = self.pair
            raise InvalidProblem.at(
                first, f"{first} and {second} are both Rigid; one must be elastic"
            )
        return self
