"""Changes of a roll after winding: temperature, moisture, shrinkage and removal of its core.

Rolls and windings have the same fields.  :mod:`woundon.roll.finished` contains the equations.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from pydantic import Field

from ..errors import one_of
from ..quantities import Quantity, share, strain
from .fields import Flag, Number
from .free_strains import (
    ALONG_EXPANSION,
    ALONG_SWELLING,
    EXPANSION_RANGE,
    FREE_STRAINS,
    SWELLING_RANGE,
    THROUGH_EXPANSION,
    THROUGH_SWELLING,
    expansion,
    swelling,
)
from .messages import out_of_range
from .permitted import ValuesWithin
from .problem import Problem
from .schedules import Curve, Schedule, misfits_on_roll, values_of

__all__ = [
    "OF_FINISHED_ROLL",
    "UNCHANGED",
    "CoreExpansion",
    "CoreRemoved",
    "CoreShrinkage",
    "CoreSwelling",
    "FinishedRollProblem",
    "FreeStrain",
    "MoistureChange",
    "RadialExpansion",
    "RadialSwelling",
    "TangentialExpansion",
    "TangentialSwelling",
    "TemperatureChange",
]

OF_CORE = "core_shrinkage", "core_expansion", "core_swelling"
# All fields of the changes.
OF_FINISHED_ROLL = (
    *(name for change, (_, of_change) in FREE_STRAINS.items() for name in (change, *of_change)),
    "core_shrinkage",
    "core_removed",
)
# The changes of a roll as wound: none.
UNCHANGED: Mapping[str, Any] = {
    **dict.fromkeys(FREE_STRAINS, 0.0),
    "core_shrinkage": 0.0,
    "core_removed": False,
}


def _within(change: str) -> ValuesWithin:
    """Return the permitted values of a change of temperature or moisture."""
    largest, _ = FREE_STRAINS[change]
    return ValuesWithin(ge=-largest, le=largest)


# Types of the fields.
TemperatureChange = Annotated[
    Schedule,
    Quantity("dT", "K", "temperature change of the finished roll", typical=(-40, 40)),
    _within("temperature_change"),
]
TangentialExpansion = Annotated[Number, ALONG_EXPANSION, EXPANSION_RANGE]
RadialExpansion = Annotated[Number, THROUGH_EXPANSION, EXPANSION_RANGE]
CoreExpansion = Annotated[Number, expansion("alpha_c", "of the core"), EXPANSION_RANGE]
MoistureChange = Annotated[
    Schedule,
    share("dm", "change of the moisture content of the finished roll", typical=(-0.05, 0.05)),
    _within("moisture_change"),
]
TangentialSwelling = Annotated[Number, ALONG_SWELLING, SWELLING_RANGE]
RadialSwelling = Annotated[Number, THROUGH_SWELLING, SWELLING_RANGE]
CoreSwelling = Annotated[Number, swelling("beta_c", "of the core"), SWELLING_RANGE]
CoreShrinkage = Annotated[
    Number, strain("e_c", "shrinkage of the core in the finished roll"), Field(ge=-0.1, le=0.1)
]
CoreRemoved = Annotated[Flag, Field(description="the core or mandrel is removed after winding")]


class FreeStrain(NamedTuple):
    """A change of the finished roll over the radius, and the strains by it without stress.

    Attributes
    ----------
    change : Curve
        Of the temperature [K] or of the moisture content [1].
    along, through, core : float
        Strains along the web, through the stack and of the core by a change of 1.
    """

    change: Curve
    along: float
    through: float
    core: float


class FinishedRollProblem(Problem):
    """Base class of the problems of a roll that changes after winding.

    A subclass has all fields of OF_FINISHED_ROLL, ``core`` and ``radius``.
    """

    if TYPE_CHECKING:
        core: Any
        radius: Any
        core_shrinkage: Any
        core_removed: Any

    def _faults_of_changes(self) -> Iterator[tuple[str, str]]:
        """Yield (field, message) for changes out of range, or that do not reach the roll's ends."""
        ends = self.core.radius, self.radius
        for name, (largest, _) in FREE_STRAINS.items():
            schedule, unit = getattr(self, name), "K" if name == "temperature_change" else "1"
            for part, value in values_of(schedule).items():
                if not abs(value) <= largest:
                    yield f"{name}{part}", out_of_range(value, -largest, largest, unit)
            yield from misfits_on_roll(name, schedule, *ends)

    @property
    def free_strains(self) -> tuple[FreeStrain, ...]:
        """The changes of the finished roll that strain it without stress."""
        return tuple(
            FreeStrain(
                Curve(getattr(self, name), self.core.radius, self.radius),
                *(getattr(self, coefficient) for coefficient in coefficients),
            )
            for name, (_, coefficients) in FREE_STRAINS.items()
        )

    @property
    def is_strained(self) -> bool:
        """True if temperature, moisture or a shrinking core strain the finished roll.

        A change without a coefficient does not, nor does a core that is removed.
        """
        by_change = any(getattr(self, c) != 0 and self._strains_by(c) for c in FREE_STRAINS)
        return bool(by_change or (self.core_shrinkage and not self.core_removed))

    @property
    def is_changed(self) -> bool:
        """True if the finished roll differs from the roll as wound."""
        return bool(self.is_strained or self.core_removed)

    @property
    def _unused_changes(self) -> tuple[str, ...]:
        """Changes and coefficients on which nothing depends in this case."""
        without_effect: list[str] = []
        for change, (_, coefficients) in FREE_STRAINS.items():
            if getattr(self, change) == 0:
                without_effect += coefficients
            if not self._strains_by(change):
                without_effect.append(change)
        return (*without_effect, *(OF_CORE if self.core_removed else ()))

    def _warnings_of_changes(self) -> Iterator[str]:
        """Yield warnings about changes without effect, and about coefficients of no grade."""
        for change, (_, coefficients) in FREE_STRAINS.items():
            if getattr(self, change) != 0 and not self._strains_by(change):
                zero = self.coefficients_of(change)
                yield f"{change} is not used, as {one_of(zero, 'and')} are 0"
            elif getattr(self, change) != 0:
                yield from self._unknown_coefficients(coefficients[:2])
        if self.core_removed:
            for name in OF_CORE:
                if getattr(self, name):
                    yield f"{name} is not used, as core_removed = true"

    def _unknown_coefficients(self, coefficients: Sequence[str]) -> Iterator[str]:
        """Yield a warning for each coefficient that is 0 as the grade has no value for it."""
        grade = self.named_grade
        for name in coefficients:
            if grade is not None and getattr(grade, name) is None and getattr(self, name) == 0:
                yield f"{name} = 0: the grade {grade.name!r} has no value for it"

    def _strains_by(self, change: str) -> bool:
        """Return True if layers or core are strained by a change of temperature or moisture."""
        return any(getattr(self, name) for name in self.coefficients_of(change))

    def coefficients_of(self, change: str) -> tuple[str, ...]:
        """Return the coefficients of layers and core by which a change of the roll strains them."""
        _, (along, through, core) = FREE_STRAINS[change]
        return (along, through) if self.core_removed else (along, through, core)
