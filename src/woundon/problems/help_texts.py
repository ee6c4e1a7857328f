"""Signature and docstring of a class of descriptions for ``help``, with units and ranges.

Descriptions are the problems, bodies and materials (:mod:`.description`).
"""

from __future__ import annotations

from inspect import Parameter, Signature, cleandoc
from textwrap import fill
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from ..quantities import quantity_of
from .permitted import admissible

__all__ = ["documentation", "signature"]

WIDTH = 92  # characters of a line


def signature(model: Any) -> Signature:
    """Return the constructor's signature without pydantic's annotations."""
    return Signature(
        [
            Parameter(
                name,
                Parameter.KEYWORD_ONLY,
                annotation=_type_name(field.annotation),
                default=Parameter.empty if field.is_required() else field.default,
            )
            for name, field in model.model_fields.items()
        ],
        return_annotation=None,
    )


def documentation(model: Any) -> str:
    """Return a description's docstring with a table of its fields before its sections."""
    # vars: the metaclass makes model.__doc__ by this function
    docstring, fields = cleandoc(vars(model)["__doc__"] or ""), model.model_fields
    if not fields:
        return docstring
    width = max(map(len, fields)) + 2
    rows = [
        fill(
            f"{name:<{width}}{_describe(field)}",
            WIDTH,
            initial_indent="    ",
            subsequent_indent=" " * (width + 4),
            break_on_hyphens=False,
        )
        for name, field in fields.items()
    ]
    head, mark, sections = docstring.partition("\n\nParameters\n---")
    return "\n".join([head, "", "Fields, SI units::", "", *rows]) + mark + sections


def _describe(field: FieldInfo) -> str:
    """Return a field in words: "P, nip load: >= 1e-12 and <= 1e+07 [N/m], usually 500 to 10000"."""
    quantity = quantity_of(field)
    if quantity is None:
        label = f"{field.description}: " if field.description else ""
        return label + admissible(field)
    text = f"{quantity.symbol}, {quantity.meaning}: {admissible(field)}"
    if quantity.typical:
        low, high = quantity.typical
        text += f", usually {low:g} to {high:g}"
    return text


def _type_name(annotation: Any) -> str:
    """Return a type as text, such as "float | None"."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _type_name(parts[0])
    if origin in (Union, UnionType):
        return " | ".join(map(_type_name, parts))
    if origin is Literal:
        return f"Literal[{', '.join(map(repr, parts))}]"
    if annotation in (NoneType, None):
        return "None"
    if annotation is Ellipsis:
        return "..."
    name = getattr(origin or annotation, "__name__", str(annotation))
    return f"{name}[{', '.join(map(_type_name, parts))}]" if parts else name
