"""Open sets of descriptions: materials, bodies, radial laws."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

from pydantic import model_serializer

from ..errors import InvalidProblem, nearest
from ..quantities import counterpart
from .description import Description
from .messages import not_one_of

__all__ = ["Family", "best_match"]


class Family(Description):
    """An open set of descriptions; a direct subclass opens one, the classes below are its members.

    A member is known by the snake-case name of its class (``half_plane``), which files write as
    ``kind``; where none is said, the names of a table's fields give the member away.  A class
    that only helps to define members says so: ``class Helper(Body, abstract=True)``.
    """

    _members: ClassVar[dict[str, type[Family]]]

    def __init_subclass__(cls, abstract: bool = False, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)

    @classmethod
    def __pydantic_init_subclass__(cls, abstract: bool = False, **kwargs: Any) -> None:
        """Open a family, or join one."""
        if Family in cls.__bases__:
            cls._members = {}
        elif not abstract:
            cls._members[cls.member_name()] = cls

    @classmethod
    def members(cls) -> dict[str, type[Family]]:
        """Return the family's members by name; of one of its classes, those that it and its are."""
        return {name: member for name, member in cls._members.items() if issubclass(member, cls)}

    @classmethod
    def member_name(cls) -> str:
        """Return the class's name as files write it."""
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).lower()

    @classmethod
    def coerce(cls, value: Any) -> Any:
        """Return the member that a table describes; anything else as it is.

        Raises
        ------
        InvalidProblem
            For an unknown kind, or whatever the member finds at fault.
        """
        if not isinstance(value, Mapping):
            return value
        table, known = dict(value), cls.members()
        if "kind" not in table:
            return best_match(table, known.values())(**table)
        kind = table.pop("kind")
        if not isinstance(kind, str) or kind not in known:
            raise InvalidProblem.at("kind", not_one_of(kind, known))
        return known[kind](**table)

    @model_serializer(mode="wrap")
    def _with_kind(self, handler: Any) -> dict[str, Any]:
        return {"kind": self.member_name(), **handler(self)}


def best_match(names: Iterable[str], models: Iterable[type[Any]]) -> type[Any]:
    """Return the class of description whose fields are nearest to the given names.

    A name that it does not have counts two, but one if it is like a field that is not given; a
    field that is missing counts one.  Of equals the first with the fewest fields.
    """
    given = [counterpart(str(name), "diameter") or str(name) for name in names]
    has_grade = "grade" in given
    given = [name for name in given if name not in ("grade", "grades")]

    def misfit(model: type[Any]) -> tuple[int, int]:
        known = set(model.model_fields) | set(getattr(model, "tables", ()))
        strange = [name for name in given if name not in known]
        meant = {nearest(name, known) for name in strange} - {"", *given}
        had = meant.union(given, getattr(model, "graded", ()) if has_grade else ())
        missing = sum(f.is_required() and n not in had for n, f in model.model_fields.items())
        return 2 * len(strange) - len(meant) + missing, len(known)

    return min(models, key=misfit)
