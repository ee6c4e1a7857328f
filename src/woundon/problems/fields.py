"""Types of the fields of a description: numbers and lists of numbers."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf
from numbers import Real
from typing import TYPE_CHECKING, Annotated, Any, Generic, Self, TypeVar, overload

from pydantic import BeforeValidator, WrapValidator
from pydantic_core import PydanticCustomError

from .inputs import FloatWithUnit

__all__ = ["CoercedField", "Number", "NumberOfField", "Numbers", "NumbersOfField"]


def _number(value: Any) -> float:
    """Return a real number of any make (int, NumPy scalar, Fraction, 0-d array) as a float.

    Truth values, and texts that could not be converted, are rejected: pydantic would take both as
    numbers.
    """
    if type(value) is float:  # as nearly all are, of variants too
        return value
    of_array = getattr(value, "shape", None) == () and hasattr(value, "dtype")
    kind = getattr(value.dtype, "kind", "") if of_array else ""
    if isinstance(value, bool) or not (isinstance(value, Real) or kind in ("i", "u", "f")):
        raise PydanticCustomError("not_a_number", "is not a number")
    if getattr(value, "mask", False) is not False and bool(value.mask):
        raise PydanticCustomError("not_a_number", "is not a number")
    try:
        return float(value)
    except OverflowError:  # a whole number of more than 308 digits
        return inf if value > 0 else -inf


def _listed(value: Any) -> Any:
    """Return an array of one dimension as a list, which is what a list of numbers is read from."""
    return value.tolist() if hasattr(value, "dtype") and hasattr(value, "tolist") else value


Number = Annotated[float, BeforeValidator(_number)]


def _with_unit(value: Any, handler: Any) -> Any:
    """Validate a number; one that has its unit keeps it."""
    checked = handler(value)
    return value if isinstance(value, FloatWithUnit) else checked


# The values of a schedule: they are in the unit of the field that holds the schedule.
NumberOfField = Annotated[Number, WrapValidator(_with_unit)]

if TYPE_CHECKING:
    Read = TypeVar("Read")
    Write = TypeVar("Write")

    class CoercedField(Generic[Read, Write]):
        """For type checkers: a field that is given as more than what it is read as."""

        @overload
        def __get__(self, instance: None, owner: Any) -> Self: ...
        @overload
        def __get__(self, instance: object, owner: Any) -> Read: ...
        def __get__(self, instance: Any, owner: Any) -> Any: ...
        def __set__(self, instance: Any, value: Write) -> None: ...

    Numbers = CoercedField[tuple[float, ...], Iterable[float | str]]
    NumbersOfField = Numbers
else:
    Numbers = Annotated[tuple[Number, ...], BeforeValidator(_listed)]
    NumbersOfField = Annotated[tuple[NumberOfField, ...], BeforeValidator(_listed)]
