"""Types of the fields of a description: numbers, lists of numbers, nested descriptions.

A description is a validated object: a problem, a body, a material, a schedule over the radius.
A field accepts more than it holds: a number may be entered as text with a unit ("36 um"), a nested
description as a table.  Type checkers see a :class:`CoercedField`, whose ``__set__`` gives the type
of the argument and whose ``__get__`` gives the type of the attribute.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING, Annotated, Any, Generic, Literal, Self, TypeVar, overload

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WrapValidator,
)

from ..errors import InvalidProblem
from .inputs import FloatWithUnit, NotAList, is_array, read_text, real_number
from .messages import not_one_of, out_of_range, quote
from .permitted import in_brackets, unit_of

__all__ = [
    "FLAGS",
    "CoercedField",
    "Flag",
    "Nested",
    "Number",
    "NumberOfField",
    "Numbers",
    "NumbersOfField",
    "OptionalNested",
    "OptionalNumber",
    "OptionalNumbers",
    "check_equal_lengths",
    "check_rising",
    "check_within",
    "default",
    "listed",
]


def _number(value: Any, info: ValidationInfo) -> float:
    """Return a real number of any type, or a text with a unit, as a float in SI."""
    if type(value) is float:  # the common case first: studies create many variants
        return value
    if isinstance(value, (str, FloatWithUnit)):
        return read_text(value, info.field_name)
    return real_number(value)


FLAGS = (
    "false",
    "true",
)  # texts of a case file's values; their numbers are those of the truth values


def _flag(value: Any) -> bool:
    """Return a truth value, or one of its texts, as a bool."""
    if isinstance(value, str) and value.lower() in FLAGS:  # spreadsheets write TRUE
        return value.lower() == FLAGS[True]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    raise InvalidProblem(not_one_of(value, FLAGS))


def _number_of_field(
    value: Any, handler: ValidatorFunctionWrapHandler, info: ValidationInfo
) -> float:
    """Return a value of a schedule: a float, or with its text until a field holds the schedule.

    The field determines the unit of the values, and reads the text again.
    """
    number = _number(value, info)
    checked: float = handler(float(number))
    return number if isinstance(number, FloatWithUnit) else checked


def listed(value: Any) -> Any:
    """Return an array as a list, which pydantic validates.

    Reject a set, which has no order, and a description, whose fields would be taken for items.
    """
    if isinstance(value, (set, frozenset, BaseModel)):
        raise NotAList
    return value.tolist() if is_array(value) else value


def check_equal_lengths(table: BaseModel, first: str, *others: str) -> None:
    """Reject lists of a description that have not as many values as the first one.

    Raises
    ------
    InvalidProblem
    """
    count = len(getattr(table, first))
    for name in others:
        if len(getattr(table, name)) != count:
            text = f"{len(getattr(table, name))} values; must be as many as of {first}, {count}"
            raise InvalidProblem.at(name, text)


def check_rising(table: BaseModel, name: str, above: float = -inf) -> None:
    """Reject a list of a description whose values do not rise, or do not begin above a value.

    Raises
    ------
    InvalidProblem
    """
    unit = in_brackets(unit_of(type(table).model_fields[name]))
    for k, (previous, value) in enumerate(pairwise((above, *getattr(table, name)))):
        if value <= previous:
            text = f"{quote(value)} is out of range; must be > {quote(previous)}{unit}"
            raise InvalidProblem.at(f"{name}.{k}", f"{text}, the previous value" if k else text)


def check_within(table: BaseModel, name: str, low: float, high: float) -> None:
    """Reject a list of a description with a value out of range; None is permitted.

    Raises
    ------
    InvalidProblem
    """
    unit = unit_of(type(table).model_fields[name])
    for k, value in enumerate(getattr(table, name) or ()):
        if not low <= value <= high:
            raise InvalidProblem.at(f"{name}.{k}", out_of_range(value, low, high, unit))


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
    OptionalNumbers = CoercedField[tuple[float, ...] | None, Iterable[float | str] | None]
    Flag = CoercedField[bool, bool | Literal["false", "true"]]
    Nested = CoercedField[T, T | Mapping[str, Any]]
    OptionalNested = CoercedField[T | None, T | Mapping[str, Any] | None]
    NumberOfField = Number
    NumbersOfField = Numbers
else:
    Number = Annotated[float, BeforeValidator(_number)]
    OptionalNumber = Number | None
    Numbers = Annotated[tuple[Number, ...], BeforeValidator(listed)]
    OptionalNumbers = Numbers | None
    Flag = Annotated[bool, BeforeValidator(_flag)]
    Nested = Annotated[T, "or a table of its fields"]  # pydantic ignores the text
    OptionalNested = T | None
    # Values of a schedule: they have the unit of the field that holds the schedule.
    NumberOfField = Annotated[float, WrapValidator(_number_of_field)]
    NumbersOfField = Annotated[tuple[NumberOfField, ...], BeforeValidator(listed)]
