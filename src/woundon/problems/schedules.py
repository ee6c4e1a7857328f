"""Schedules over the radius of a roll: a constant, a profile, a taper, or steps."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, BeforeValidator, Field, ValidationInfo, model_validator

from ..errors import InvalidProblem
from ..quantities import OF_FIELD, Quantity, length, members_of, pure, quantity_of
from .description import Description
from .family import from_table
from .fields import (
    Number,
    NumberOfField,
    Numbers,
    NumbersOfField,
    OptionalNumber,
    check_equal_lengths,
    check_rising,
    default,
)
from .inputs import FloatWithUnit, Inputs
from .messages import quote
from .paths import field_or_none
from .permitted import Conditional, is_within

if TYPE_CHECKING:
    from .fields import CoercedField

__all__ = [
    "AnySchedule",
    "Curve",
    "OptionalWindingSchedule",
    "Profile",
    "Schedule",
    "Steps",
    "Taper",
    "WindingSchedule",
    "as_schedule",
    "at_radius",
    "misfits_on_roll",
    "schedule_fields",
    "unused_in_tapers",
    "values_of",
]

Array = np.ndarray
MOST_STEPS = 20


class Profile(Description):
    """Values over the radius, constant beyond the first and the last.

    Parameters
    ----------
    radius : sequence of float
        [m], rising.
    value : sequence of float
        Values at these radii, in the unit of the field that has the profile.
    between : "lines" or "smooth"
        Linear interpolation or a cubic spline.  Windings without kinks are solved faster; a spline
        may overshoot the values.

    Examples
    --------
    >>> import woundon as wo
    >>> load = wo.Profile(radius=["50 mm", "0.5 m"], value=["1 kN/m", "2 kN/m"])
    >>> round(float(load.at(0.275)))
    1500
    """

    radius: Annotated[
        Numbers, length("r", "radii of the profile"), Field(min_length=2, max_length=10_000)
    ]
    value: Annotated[
        NumbersOfField,
        OF_FIELD,
        Field(min_length=2, max_length=10_000, description="values at these radii"),
    ]
    between: Annotated[
        Literal["lines", "smooth"], Field(description="curve between the values")
    ] = "lines"

    @model_validator(mode="after")
    def _check_columns(self) -> Self:
        """Reject a profile whose radii do not increase."""
        check_equal_lengths(self, "radius", "value")
        check_rising(self, "radius", above=0.0)
        return self

    @cached_property
    def _nodes_and_slopes(self) -> tuple[Array, Array, Array]:
        """Radii, values, and the slopes of the intervals with a zero before and after them."""
        x, y = np.asarray(self.radius), np.asarray(self.value)
        return x, y, np.concatenate([[0.0], np.diff(y) / np.diff(x), [0.0]])

    @cached_property
    def _smooth(self) -> tuple[Any, Any]:
        """The cubic spline and its derivative, functions of the radius."""
        from scipy.interpolate import CubicSpline

        curve = CubicSpline(self.radius, self.value)
        return curve, curve.derivative()

    def at(self, r: Array) -> Array:
        """Return the values at radii [m]."""
        if self.between == "lines":
            radii, values, _ = self._nodes_and_slopes
            return np.interp(r, radii, values)
        spline, _ = self._smooth
        return spline(np.clip(r, self.radius[0], self.radius[-1]))

    def slope(self, r: Array, side: int | Array = 1) -> Array:
        """Return the derivatives [1/m]; at a kink the left (-1) or right (1) derivative."""
        x, _, slopes = self._nodes_and_slopes
        if self.between == "smooth":
            _, derivative = self._smooth
            return np.where((r < x[0]) | (r > x[-1]), 0.0, derivative(np.clip(r, x[0], x[-1])))
        # A radius that should be at a kink may differ from it by rounding: the shift by more than
        # that selects the interval on the requested side.
        shifted = r * (1 + side * 1e-12)
        # slopes[k] belongs to x[k-1] < r <= x[k]; the first and the last, outside of x, are zero
        return np.asarray(slopes[np.searchsorted(x, shifted)])

    @property
    def kinks(self) -> tuple[float, ...]:
        """Radii at which the slope jumps [m]; for a spline only its ends."""
        smooth = self.between == "smooth"
        return (self.radius[0], self.radius[-1]) if smooth else self.radius


class Taper(Description):
    """A value that decreases from the core to the surface.

    With t(r) = (r - rc)/(R - rc), from the core at rc to the roll's radius R:

    - ``linear``: start (1 - taper t);
    - ``hyperbolic``: start (1 - taper (1 - rc/r));
    - ``constant_torque``: start rc/r, without a taper: hyperbolic with the taper 1;
    - ``power``: start (rc/r)^exponent, without a taper: 0 is constant, 1 constant torque.

    Parameters
    ----------
    start : float
        Value at the core, in the unit of the field that has the schedule.
    taper : float
        Relative decrease, 0 to 1; negative for an increase.
    law : "linear", "hyperbolic", "constant_torque" or "power"
    exponent : float, optional
        Of the law "power" [1]; negative for an increase.

    Raises
    ------
    InvalidProblem
        For a value out of range, or one that the law does not have.

    Examples
    --------
    >>> import woundon as wo
    >>> tension = wo.Taper(start="400 N/m", taper="30 %")
    >>> wo.WindingProblem.example().replace(web_tension=tension).web_tension.taper
    0.3
    >>> falling = wo.Taper(start="400 N/m", law="power", exponent=0.5)
    >>> winding = wo.WindingProblem.example().replace(web_tension=falling)  # core 0.05 m
    >>> winding.at("web_tension", 0.2).item()
    200.0
    """

    start: Annotated[NumberOfField, OF_FIELD, Field(description="value at the core")]
    taper: Annotated[
        Number,
        pure("k_T", "taper: relative decrease over the build-up", (0.0, 0.7)),
        Field(ge=-10, le=1),
    ] = default(0.0)
    law: Annotated[
        Literal["linear", "hyperbolic", "constant_torque", "power"],
        Field(description="law of the taper"),
    ] = "linear"
    exponent: Annotated[
        OptionalNumber,
        pure("n_T", "exponent of the power law of a taper", (0.0, 1.0)),
        Field(ge=-10, le=10),
        Conditional('required with law = "power", not allowed otherwise'),
    ] = default(None)

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        """Reject a taper or an exponent that the law does not have."""
        law = f"law = {self.law!r}"
        if self.taper and self.field_of_law != "taper":
            text = f"{quote(self.taper)} is given, but {law} has no taper; must be omitted"
            raise InvalidProblem.at("taper", text)
        if self.exponent is None and self.law == "power":
            text = f"missing; must be >= -10 and <= 10 with {law}"
            raise InvalidProblem.at("exponent", text)
        if self.exponent is not None and self.law != "power":
            text = f"{quote(self.exponent)} is given, but {law} has no exponent; must be omitted"
            raise InvalidProblem.at("exponent", text)
        return self

    @property
    def field_of_law(self) -> str:
        """Name of the field that determines the decrease: that of the law, else ``start``."""
        return {"power": "exponent", "constant_torque": "start"}.get(self.law, "taper")

    def at(self, r: Array, core: float, radius: float) -> Array:
        """Return the values at radii [m] of a roll from ``core`` to ``radius`` [m]."""
        if self.law == "linear":
            return self.start * (1 - self.taper * (r - core) / (radius - core))
        if self.law == "hyperbolic":
            return self.start * (1 - self.taper * (1 - core / r))
        return self.start * (core / r) ** self._power

    def slope(self, r: Array, core: float, radius: float) -> Array:
        """Return the derivatives [1/m] at radii [m] of a roll from ``core`` to ``radius`` [m]."""
        if self.law == "linear":
            return np.full(np.shape(r), -self.start * self.taper / (radius - core))
        if self.law == "hyperbolic":
            return -self.start * self.taper * core / r**2
        return -self._power * self.at(r, core, radius) / r

    @property
    def _power(self) -> float:
        """n of start (rc/r)^n, of the laws "constant_torque" and "power"."""
        return 1.0 if self.exponent is None else self.exponent


class Steps(Description):
    """A value that changes in steps from the core to the surface, such as a hard core.

    Parameters
    ----------
    value : sequence of float
        Values from the core outward, in the unit of the field that has the schedule.
    depth : sequence of float
        Thickness wound onto the core where the next value begins [m], rising; one less than values.
    ramp : float
        Depth over which the value then changes linearly to the next one [m].

    Raises
    ------
    InvalidProblem
        For a step that begins before the previous ramp ends, or the wrong number of depths.

    Examples
    --------
    >>> import woundon as wo
    >>> hard_core = wo.Steps(value=["450 N/m", "350 N/m"], depth=["20 mm"])
    >>> winding = wo.WindingProblem.example().replace(web_tension=hard_core)  # core 0.05 m
    >>> winding.at("web_tension", [0.05, 0.07, 0.0705, 0.071, 0.6])
    array([450., 450., 400., 350., 350.])
    """

    value: Annotated[
        NumbersOfField,
        OF_FIELD,
        Field(min_length=2, max_length=MOST_STEPS + 1, description="values from the core outward"),
    ]
    depth: Annotated[
        Numbers,
        length("d_T", "thickness on the core where the next value begins"),
        Field(min_length=1, max_length=MOST_STEPS),
    ]
    ramp: Annotated[
        Number,
        length("b_T", "depth over which a step is made", typical=(0.5e-3, 5e-3)),
        Field(gt=0, le=10),
    ] = default(1e-3)

    @model_validator(mode="after")
    def _check_steps(self) -> Self:
        """Reject a wrong number of depths, and a step that begins before the last one ends."""
        if len(self.depth) != len(self.value) - 1:
            must = f"must be {len(self.value) - 1}, one less than of value"
            raise InvalidProblem.at("depth", f"{len(self.depth)} values; {must}")
        ends = (0.0, *(depth + self.ramp for depth in self.depth))
        for k, (depth, end) in enumerate(zip(self.depth, ends, strict=False)):
            if depth <= end:
                after = ", the end of the previous ramp" if k else ""
                text = f"{quote(depth)} is out of range; must be > {end:.6g} [m]{after}"
                raise InvalidProblem.at(f"depth.{k}", text)
        return self

    def profile(self, core: float, radius: float) -> Profile:
        """Return the values as a profile, for a roll from ``core`` to ``radius`` [m]."""
        radii, values = [core], [self.value[0]]
        for depth, before, after in zip(self.depth, self.value, self.value[1:], strict=False):
            radii += [core + depth, core + depth + self.ramp]
            values += [before, after]
        if radii[-1] < radius:
            radii, values = [*radii, radius], [*values, self.value[-1]]
        return Profile(radius=radii, value=values)


AnySchedule = float | Profile | Taper | Steps


def as_schedule(value: Any, name: str | None, *classes: type[Profile | Taper | Steps]) -> Any:
    """Return the schedule that a field holds for a table, or for a schedule with units.

    Values with units were read without the field, which alone determines the unit; they are read
    again from their texts.

    Parameters
    ----------
    value : object
        Other values are returned unchanged.
    name : str
        Name of the field, of the description that is being created.
    classes : types
        Schedules that a table may describe.
    """
    inputs = Inputs.current()
    if inputs is not None:
        inputs.field = name or ""  # its quantity is that of the values
    if isinstance(value, Mapping):
        return from_table(value, classes)
    texts = _texts_of(value)
    return value.replace(**texts) if texts else value


def _texts_of(schedule: Any) -> dict[str, Any]:
    """Return the values of a schedule as they were entered, if they have units; otherwise {}."""
    if isinstance(schedule, Taper) and isinstance(schedule.start, FloatWithUnit):
        return {"start": schedule.start.text}
    values = schedule.value if isinstance(schedule, Profile | Steps) else ()
    if any(isinstance(value, FloatWithUnit) for value in values):
        return {"value": [getattr(value, "text", value) for value in values]}
    return {}


def _profile(value: Any, info: ValidationInfo) -> Any:
    return as_schedule(value, info.field_name, Profile)


def _any_schedule(value: Any, info: ValidationInfo) -> Any:
    return as_schedule(value, info.field_name, Taper, Profile, Steps)


# Schedule: a number or a profile.  WindingSchedule: also a taper or steps, for the inputs of a
# winder.
if TYPE_CHECKING:
    Schedule = CoercedField[float | Profile, float | str | Profile | Mapping[str, Any]]
    WindingSchedule = CoercedField[AnySchedule, AnySchedule | str | Mapping[str, Any]]
    OptionalWindingSchedule = CoercedField[
        AnySchedule | None, AnySchedule | str | Mapping[str, Any] | None
    ]
else:
    Schedule = Annotated[Number | Profile, BeforeValidator(_profile)]
    WindingSchedule = Annotated[Number | Profile | Taper | Steps, BeforeValidator(_any_schedule)]
    OptionalWindingSchedule = WindingSchedule | None


def schedule_fields(problem: type[BaseModel]) -> dict[str, Quantity]:
    """Return the quantities of the fields of a problem that may be profiles over the radius.

    >>> import woundon as wo
    >>> list(schedule_fields(wo.RollProblem))
    ['wound_on_tension', 'temperature_change', 'moisture_change']
    """
    fields = {
        name: quantity_of(field)
        for name, field in problem.model_fields.items()
        if Profile in members_of(field.annotation)
    }
    return {name: quantity for name, quantity in fields.items() if quantity is not None}


class Curve:
    """A schedule between two radii: values, slopes and kinks.

    Attributes
    ----------
    kinks : (k,) array
        Radii between core and surface at which the slope jumps [m].
    jumps, bends : (k,) arrays
        Jump of the slope at the kinks, |d slope| [1/m], and their sharpness, r |d slope|/|value|
        [1]; inf or nan where the value is zero.

    Parameters
    ----------
    schedule : float, Profile, Taper or Steps
    core, radius : float
        [m].
    scale : float
        Factor of the values.
    """

    def __init__(
        self, schedule: AnySchedule, core: float, radius: float, scale: float = 1.0
    ) -> None:
        if isinstance(schedule, Steps):
            schedule = schedule.profile(core, radius)
        self.schedule, self.core, self.radius, self.scale = schedule, core, radius, scale
        inner = schedule.kinks if isinstance(schedule, Profile) else ()
        self.kinks = np.array([r for r in inner if core < r < radius])
        slope_left, slope_right = (self.slope(self.kinks, side) for side in (-1, 1))
        self.jumps = np.abs(slope_right - slope_left)
        # a value of zero at a kink: infinitely sharp, or no kink if the slope does not jump
        with np.errstate(divide="ignore", invalid="ignore"):
            self.bends = self.kinks * self.jumps / np.abs(self.at(self.kinks))

    def at(self, r: Array) -> Array:
        """Return the values at radii [m]."""
        schedule = self.schedule
        if isinstance(schedule, Profile):
            return self.scale * schedule.at(r)
        if isinstance(schedule, Taper):
            return self.scale * schedule.at(r, self.core, self.radius)
        return self.scale * np.full(np.shape(r), schedule)

    def slope(self, r: Array, side: int | Array = 1) -> Array:
        """Return the derivatives [1/m]; at a kink the left (-1) or right (1) derivative."""
        schedule = self.schedule
        if isinstance(schedule, Profile):
            return self.scale * schedule.slope(r, side)
        if isinstance(schedule, Taper):
            return self.scale * schedule.slope(r, self.core, self.radius)
        return np.zeros(np.shape(r))


def at_radius(schedule: float | Profile, r: Array) -> Array:
    """Return a schedule's values at radii [m]."""
    return schedule.at(r) if isinstance(schedule, Profile) else np.full(np.shape(r), schedule)


def values_of(schedule: AnySchedule) -> dict[str, float]:
    """Return the numbers of a schedule by the suffix of their dotted name."""
    if isinstance(schedule, Profile | Steps):
        return {f".value.{k}": value for k, value in enumerate(schedule.value)}
    if isinstance(schedule, Taper):
        return {".start": schedule.start}
    return {"": schedule}


def misfits_on_roll(
    name: str, schedule: AnySchedule, core: float, radius: float
) -> Iterator[tuple[str, str]]:
    """Yield (field, message) for what of a schedule does not fit a roll.

    The radii of a profile must reach from the core to the surface; steps must end below it.

    Parameters
    ----------
    name : str
        Field that holds the schedule.
    schedule : float, Profile, Taper or Steps
    core, radius : float
        Radii of the core and of the finished roll [m].
    """
    if isinstance(schedule, Steps):
        largest = radius - core - schedule.ramp
        if largest <= 0:
            text = f"{quote(schedule.ramp)} is out of range; must be < {radius - core:.6g} [m]"
            yield f"{name}.ramp", f"{text}, the build-up of the roll"
            return
        for k, depth in enumerate(schedule.depth):
            if not is_within(depth, 0.0, largest):
                text = f"{quote(depth)} is out of range; must be <= {largest:.6g} [m]"
                yield f"{name}.depth.{k}", f"{text}: the ramp must end on the roll"
    if not isinstance(schedule, Profile):
        return
    last = len(schedule.radius) - 1
    # index of a radius, the interval that it must be in, and its text
    for k, covered, must in (
        (0, (-inf, core), f"<= core.radius = {core:.6g}"),
        (last, (radius, inf), f">= radius = {radius:.6g}"),
    ):
        if not is_within(schedule.radius[k], *covered):
            text = f"{quote(schedule.radius[k])} is out of range; must be {must} [m]"
            yield f"{name}.radius.{k}", f"{text}: the schedule must cover the whole roll"


def unused_in_tapers(problem: BaseModel, names: Iterable[str]) -> Iterator[str]:
    """Yield the dotted names of the tapers of a law that has none."""
    for name in names:
        schedule = field_or_none(problem, name)
        if isinstance(schedule, Taper) and schedule.field_of_law != "taper":
            yield f"{name}.taper"
