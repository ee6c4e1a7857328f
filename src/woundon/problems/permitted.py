"""Permitted values of a field of a description, in words."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, get_args

from pydantic.fields import FieldInfo

from ..errors import one_of
from ..quantities import Values, members_of, quantity_of

if TYPE_CHECKING:
    import numpy as np

__all__ = [
    "Conditional",
    "SearchedWithin",
    "ValuesWithin",
    "accepts_number",
    "admissible",
    "admits",
    "bounds",
    "extremes",
    "in_brackets",
    "is_within",
    "requirement",
    "unit_of",
    "words_of",
]

ROUNDING = 1e-9  # relative; inputs are often computed, such as radius = core + 10 layers


def is_within(value: Values, low: float, high: float) -> bool | np.ndarray:
    """Return True where low <= value <= high, except for rounding errors of computed bounds."""
    return (low - ROUNDING * abs(low) <= value) & (value <= high + ROUNDING * abs(high))


@dataclass(frozen=True)
class Conditional:
    """Metadata of a field with the default None that some descriptions require: when, in words."""

    text: str


@dataclass(frozen=True)
class ValuesWithin:
    """Metadata of a schedule: bounds of its values, which the problem checks."""

    ge: float
    le: float


@dataclass(frozen=True)
class SearchedWithin:
    """Metadata of a field whose permitted values are no scale of a search: the usual change of it.

    The change is relative to the present value.
    """

    share: float


def requirement(field: FieldInfo) -> str:
    """Return when a field may be left out; empty for a field that is always required.

    >>> from woundon import NipProblem
    >>> [requirement(NipProblem.model_fields[n]) for n in ("nip_load", "winding_force", "width")]
    ['', 'default 0', 'optional']
    """
    condition = next((part for part in field.metadata if isinstance(part, Conditional)), None)
    if condition is not None:
        return condition.text
    if field.is_required():
        return ""
    if isinstance(field.default, str):
        return f'default "{field.default}"'
    quantity = quantity_of(field)
    if quantity is None or not isinstance(field.default, float):
        return "optional"
    return f"default {quantity.shown(field.default):.6g}"


def bounds(field: FieldInfo) -> list[tuple[str, float]]:
    """Return the bounds of a field with their signs, such as (">", 0.0)."""
    signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    return [
        (sign, getattr(part, name))
        for name, sign in signs.items()
        for part in field.metadata
        if hasattr(part, name)
    ]


def extremes(field: FieldInfo) -> tuple[float, float]:
    """Return the bounds of a field, infinite where there is none.

    >>> from woundon import RollerProblem
    >>> extremes(RollerProblem.model_fields["friction"])
    (0, 10.0)
    """
    limits = bounds(field)
    low = max((bound for sign, bound in limits if sign in (">", ">=")), default=-inf)
    high = min((bound for sign, bound in limits if sign in ("<", "<=")), default=inf)
    return low, high


def admits(field: FieldInfo, value: float) -> bool:
    """Return True if a number is within the bounds of a field."""
    tests = {">": float.__gt__, ">=": float.__ge__, "<": float.__lt__, "<=": float.__le__}
    return all(tests[sign](float(value), float(bound)) for sign, bound in bounds(field))


def unit_of(field: FieldInfo) -> str:
    """Return the SI unit of a field; empty if the field is not a number."""
    quantity = quantity_of(field)
    return quantity.unit if quantity else ""


def in_brackets(unit: str) -> str:
    """Return " [m]" of an SI unit for a message; empty for a pure number."""
    return f" [{unit}]" if unit not in ("", "1") else ""


def admissible(field: FieldInfo) -> str:
    """Return the permitted values as text: "> 0 and <= 10", "Rigid, HalfPlane or Cylinder"."""
    models = members_of(field.annotation)
    limits = " and ".join(f"{sign} {bound:.6g}" for sign, bound in bounds(field))
    if models:
        names = one_of(model.__name__ for model in models)
        if accepts_number(field.annotation):
            number = " ".join(filter(None, ("a number", limits))) + in_brackets(unit_of(field))
            names = f"{number} or a {names}"
        by_name = ", or a name that 'woundon materials' lists" if "Isotropic" in names else ""
        return f"{names} (or a table of its fields{by_name})"
    if field.annotation is bool:
        return "false or true"
    if words := words_of(field):
        return one_of(map(repr, words))
    return (limits or "a finite number") + in_brackets(unit_of(field))


def words_of(field: FieldInfo) -> list[str]:
    """Return the words that a field may be; empty if it is no Literal of words."""
    return [part for part in get_args(field.annotation) if isinstance(part, str)]


def accepts_number(annotation: object) -> bool:
    """Return True if an annotation admits a number."""
    return annotation is float or any(map(accepts_number, get_args(annotation)))
