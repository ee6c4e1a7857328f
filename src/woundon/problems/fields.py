"""Types of the fields of a description: numbers, lists of numbers, nested descriptions.

A field accepts more than it holds: a number may be entered as text with a unit ("36 um"), a nested
description as a table.  Type checkers see a :class:`CoercedField`, whose ``__set__`` gives the type
of the argument and whose ``__get__`` gives the type of the attribute.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import inf
from numbers import Real
from typing import TYPE_CHECKING, Annotated, Any, Generic, Self, TypeVar, overload

from pydantic import (
    BeforeValidator,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)

from .inputs import FloatWithUnit, NotANumber, read_text

__all__ = [
    "CoercedField",
    "Nested",
    "Number",
    "NumberOfField",
    "Numbers",
    "NumbersOfField",
    "OptionalNested",
    "OptionalNumber",
    "default",
]


def _number(value: Any, info: ValidationInfo) -> float:
    """Return a real number of any type (int, NumPy scalar, Fraction, 0-d array) as a float.

    Text is converted to SI.  Booleans are rejected; pydantic would accept them as numbers.
    """
    if type(value) is float:  # the common case first: studies create many variants
        return value
    if isinstance(value, (str, FloatWithUnit)):
        return read_text(value, info.field_name)
    is_scalar = getattr(value, "shape", None) == () and hasattr(value, "dtype")
    kind = getattr(value.dtype, "kind", "") if is_scalar else ""
    if isinstance(value, bool) or not (isinstance(value, Real) or kind in ("i", "u", "f")):
        raise NotANumber
    if getattr(value, "mask", False) is not False and bool(value.mask):
        raise NotANumber
    try:
        return float(value)
    except OverflowError:  # an integer of more than 308 digits
        return inf if value > 0 else -inf


def _number_of_field(
    value: Any, handler: ValidatorFunctionWrapHandler, info: ValidationInfo
) -> float:
    """Return a value of a schedule: a float, or with its unit until a field holds the schedule."""
    number = _number(value, info)
    checked: float = handler(float(number))
    return number if isinstance(number, FloatWithUnit) else checked


def _listed(value: Any) -> Any:
    """Return a one-dimensional array as a list, which pydantic validates."""
    return value.tolist() if hasattr(value, "dtype") and hasattr(value, "tolist") else value


def default(value: Any) -> Any:
    """Return a default value; its type is hidden from type checkers, which see a CoercedField."""
    return value


T = TypeVar("T")

if TYPE_CHECKING:
    Held = TypeVar("Held")
    Accepted = TypeVar("Accepted")

    class CoercedField(Generic[Held, Accepted]):
        """A field that accepts more types than it holds."""

        @overload
        def __get__(self, instance: None, owner: Any) -> Self: ...
        @overload
        def __get__(self, instance: object, owner: Any) -> Held: ...
        def __get__(self, instance: Any, owner: Any) -> Any: ...
        def __set__(self, instance: Any, value: Accepted) -> None: ...

    Number = CoercedField[float, float | str]
    OptionalNumber = CoercedField[float | None, float | str | None]
    Numbers = CoercedField[tuple[float, ...], Iterable[float | str]]
    Nested = CoercedField[T, T | Mapping[str, Any]]
    OptionalNested = CoercedField[T | None, T | Mapping[str, Any] | None]
    NumberOfField = Number
    NumbersOfField = Numbers
else:
    Number = Annotated[float, BeforeValidator(_number)]
    OptionalNumber = Number | None
    Numbers = Annotated[tuple[Number, ...], BeforeValidator(_listed)]
    Nested = Annotated[T, "or a table of its fields"]
    OptionalNested = T | None
    # Values of a schedule: they have the unit of the field that holds the schedule.
    NumberOfField = Annotated[float, WrapValidator(_number_of_field)]
    NumbersOfField = Annotated[tuple[NumberOfField, ...], BeforeValidator(_listed)]
