"""Open sets of descriptions, the validated objects of a problem: materials, bodies, radial laws."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar, TypeVar

from pydantic import model_serializer

from ..errors import InvalidProblem, nearest
from .description import Description
from .messages import check_names, not_one_of
from .paths import counterpart, models_at

__all__ = ["Family", "best_match", "field_from_table", "from_table", "snake_case"]

DescriptionT = TypeVar("DescriptionT", bound=Description)


def snake_case(name: str) -> str:
    """Return the name of a class as files and commands write it: "HalfPlane" as "half_plane"."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


class Family(Description):
    """An open set of descriptions: a direct subclass is a family, its subclasses are the members.

    Files identify a member by ``kind``, the snake-case name of its class (``half_plane``); without
    ``kind`` the member with the best matching fields is chosen.  Abstract classes between family
    and members are declared with ``class Helper(Body, abstract=True)``.
    """

    _members: ClassVar[dict[str, type[Family]]]

    def __init_subclass__(cls, abstract: bool = False, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)  # without abstract, which pydantic does not know

    @classmethod
    def __pydantic_init_subclass__(cls, abstract: bool = False, **kwargs: Any) -> None:
        """Register a member, or create the register of a family."""
        if Family in cls.__bases__:
            cls._members = {}
        elif not abstract:
            cls._members[cls.member_name()] = cls

    @classmethod
    def members(cls) -> dict[str, type[Family]]:
        """Return the members that are subclasses of this class, by name."""
        return {name: member for name, member in cls._members.items() if issubclass(member, cls)}

    @classmethod
    def member_name(cls) -> str:
        """Return the name of the class in files."""
        return snake_case(cls.__name__)

    @classmethod
    def coerce(cls, value: Any) -> Any:
        """Return the member that a table describes; other values unchanged.

        Raises
        ------
        InvalidProblem
            For an unknown kind, or invalid fields of the member.
        """
        if not isinstance(value, Mapping):
            return value
        return from_table(value, cls.members().values())

    @model_serializer(mode="wrap")
    def _with_kind(self, handler: Any) -> dict[str, Any]:
        """Return the table of the fields with the name of the class."""
        return {"kind": self.member_name(), **handler(self)}


def from_table(table: Mapping[str, Any], models: Iterable[type[Any]]) -> Any:
    """Return the description of a table: of the class named by ``kind``, or of the best match.

    Raises
    ------
    InvalidProblem
        For an unknown kind, or invalid fields of the class.
    """
    check_names(table)
    models, fields = tuple(models), dict(table)
    known = {model.member_name(): model for model in models if hasattr(model, "member_name")}
    if not known or "kind" not in fields:
        return best_match(fields, models)(**fields)
    kind = fields.pop("kind")
    if not isinstance(kind, str) or kind not in known:
        raise InvalidProblem.at("kind", not_one_of(kind, known))
    return known[kind](**fields)


def field_from_table(problem: Description, path: str, table: object) -> Description:
    """Return the body, material or other description of a table, for a field of a dotted name.

    Raises
    ------
    InvalidProblem
        If it is not a table of fields, or for invalid fields.
    """
    models = models_at(problem, path)
    if not models or not isinstance(table, dict):
        raise InvalidProblem(f"{table!r} is not a table of fields")
    return from_table(table, models)


def best_match(names: Iterable[str], models: Iterable[type[DescriptionT]]) -> type[DescriptionT]:
    """Return the class whose fields match the given names best.

    The penalty is 2 for an unknown name (1 if it resembles a field that is not given) and 1 for a
    missing required field.  Ties are resolved by the smaller number of fields, then by order.
    ``tables`` of a class are names of tables in a file that are no fields.
    """
    # a diameter stands for the radius
    present = [counterpart(str(name), "diameter") or str(name) for name in names]
    has_grade = "grade" in present
    present = [name for name in present if name not in ("grade", "grades")]

    def penalty(model: type[DescriptionT]) -> tuple[int, int]:
        """Return the penalty of a class and its number of fields."""
        known = set(model.model_fields) | set(getattr(model, "tables", ()))
        unknown = [name for name in present if name not in known]
        # names that were meant; nearest is "" for a name that resembles none
        intended = {nearest(name, known) for name in unknown} - {"", *present}
        # with a grade, the fields that it supplies are not missing
        available = intended.union(present, getattr(model, "graded", ()) if has_grade else ())
        missing = sum(f.is_required() and n not in available for n, f in model.model_fields.items())
        return 2 * len(unknown) - len(intended) + missing, len(known)

    return min(models, key=penalty)
