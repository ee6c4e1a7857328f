"""What a description says of its fields, nested ones by dotted name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, get_args

from pydantic import BaseModel

from ..description import Description
from ..errors import InvalidProblem, did_you_mean
from .model import Label

__all__ = ["field_label", "follow", "get_field"]


def field_label(base: Description, path: str) -> Label:
    """Return unit and meaning of a field of ``base``.

    A field that only another kind of body or material has is found too.

    Raises
    ------
    InvalidProblem
        If there is no such field, with the nearest name.
    """
    models: list[type[BaseModel]] = [type(base)]
    *heads, leaf = path.split(".")
    for head in heads:
        fields = [m.model_fields[head] for m in models if head in m.model_fields]
        models = [inner for field in fields for inner in _models_in(field.annotation)]
    for model in models:
        field = model.model_fields.get(leaf)
        if field is not None and leaf != "kind":
            extra = field.json_schema_extra
            unit = str(extra.get("unit", "")) if isinstance(extra, dict) else ""
            return Label(unit, field.description or path.replace(".", " "))
    known = sorted({name for model in models for name in model.model_fields} - {"kind"})
    hint = did_you_mean(leaf, known) if known else f"; {path.rpartition('.')[0]} has no fields"
    raise InvalidProblem([(path, f"no such field{hint}")])


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _models_in(part)


def get_field(base: Description, path: str) -> Any:
    """Return the value of a field, nested ones by dotted name.

    Raises
    ------
    InvalidProblem
        If ``base`` has no such field.
    """
    value: Any = base
    for name in path.split("."):
        if not isinstance(value, Description) or name not in type(value).model_fields:
            known = type(value).model_fields if isinstance(value, Description) else ()
            raise InvalidProblem([(path, f"no such field{did_you_mean(name, known)}")])
        value = getattr(value, name)
    return value


def follow(problem: Description, tie: Mapping[str, str]) -> Any:
    """Return the problem with each tied field given the value of the field it follows."""
    if not tie:
        return problem
    return problem.replace(**{path: get_field(problem, leader) for path, leader in tie.items()})
