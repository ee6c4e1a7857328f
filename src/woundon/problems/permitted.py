"""Permitted values of a field of a description, in words."""

from __future__ import annotations

from typing import Any, get_args

from pydantic.fields import FieldInfo

from ..errors import one_of
from ..quantities import members_of, quantity_of

__all__ = ["admissible", "bounds", "takes_a_number", "unit_of"]


def bounds(field: FieldInfo) -> list[tuple[str, float]]:
    """Return the limits of a field, each with its sign, as (">", 0.0)."""
    signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    return [
        (sign, getattr(part, name))
        for name, sign in signs.items()
        for part in field.metadata
        if hasattr(part, name)
    ]


def unit_of(field: FieldInfo) -> str:
    """Return the SI unit of a field, '' of one that is no number."""
    quantity = quantity_of(field)
    return quantity.unit if quantity else ""


def admissible(field: FieldInfo) -> str:
    """Return what a field takes: "> 0 and <= 10", "Rigid, HalfPlane or Cylinder", ..."""
    models = members_of(field.annotation)
    if models:
        names = one_of(model.__name__ for model in models)
        if takes_a_number(field.annotation):
            unit = unit_of(field)
            names = f"a number{f' [{unit}]' if unit not in ('', '1') else ''} or a {names}"
        by_name = ", or a name that 'woundon materials' lists" if "Isotropic" in names else ""
        return f"{names} (or a table of its fields{by_name})"
    words = [part for part in get_args(field.annotation) if isinstance(part, str)]
    if words:
        return one_of(map(repr, words))
    unit = unit_of(field)
    limits = " and ".join(f"{sign} {bound:.6g}" for sign, bound in bounds(field))
    return (limits or "a finite number") + (f" [{unit}]" if unit not in ("", "1") else "")


def takes_a_number(annotation: Any) -> bool:
    """Return whether an annotation admits a number."""
    return annotation is float or any(map(takes_a_number, get_args(annotation)[:2]))
