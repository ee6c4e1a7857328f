"""Schedules over the radius of a roll: a number throughout, or a profile."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from ..errors import InvalidProblem
from ..quantities import OF_FIELD, length
from .fields import Description, Number, Numbers, shown

if TYPE_CHECKING:
    from .fields import Given

__all__ = ["Profile", "Schedule", "at_radius", "values_of"]

Array = np.ndarray


class Profile(Description):
    """Values over the radius, linear between, constant beyond the first and the last.

    Parameters
    ----------
    radius : sequence of float
        [m], rising.
    value : sequence of float
        As many, in the unit of the field that has the profile.
    """

    radius: Annotated[
        Numbers, length("r", "radii of a profile"), Field(min_length=2, max_length=10_000)
    ]
    value: Annotated[
        Numbers, OF_FIELD, Field(min_length=2, max_length=10_000, description="values there")
    ]

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if len(self.radius) != len(self.value):
            text = f"{len(self.value)} values; must be as many as of radius, {len(self.radius)}"
            raise InvalidProblem.at("value", text)
        for k, (before, radius) in enumerate(pairwise((0.0, *self.radius))):
            if radius <= before:
                what = "the radius before it" if k else "0"
                text = f"{shown(radius)} is out of range; must be > {shown(before)} [m]"
                raise InvalidProblem.at(f"radius.{k}", f"{text}, {what}" if k else text)
        return self

    def at(self, r: Array) -> Any:
        """Return the values at radii [m]."""
        return np.interp(r, self.radius, self.value)


def _made(value: Any) -> Any:
    return Profile(**value) if isinstance(value, Mapping) else value


# a number throughout, or a profile
if TYPE_CHECKING:
    Schedule = Given[float | Profile, float | Profile | Mapping[str, Any]]
else:
    Schedule = Annotated[Number | Profile, BeforeValidator(_made)]


def at_radius(schedule: float | Profile, r: Array) -> Array:
    """Return a schedule's values at radii [m]."""
    return schedule.at(r) if isinstance(schedule, Profile) else np.full(np.shape(r), schedule)


def values_of(schedule: float | Profile) -> dict[str, float]:
    """Return the numbers that a schedule is made of, by what is added to its field's name."""
    if isinstance(schedule, Profile):
        return {f".value.{k}": value for k, value in enumerate(schedule.value)}
    return {"": schedule}
