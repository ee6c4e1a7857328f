"""The base of every description (material, body, problem): immutable and validated.

pydantic validates; :mod:`~woundon.problems.messages` words the errors.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import FrozenInstanceError
from html import escape
from inspect import Signature
from typing import TYPE_CHECKING, Any, NoReturn, Self, dataclass_transform

from pydantic import BaseModel, ConfigDict, ValidationError

from ..errors import InvalidProblem
from ..quantities import Quantity, walk
from .help_texts import documentation, signature
from .inputs import (
    Context,
    FloatWithUnit,
    conversion_context,
    conversion_order,
    convert,
    convert_fields,
)
from .messages import validation_error
from .paths import change_fields, find_places, is_part_of

__all__ = ["Description"]

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)


# not frozen_default: type checkers reject a frozen CoercedField
@dataclass_transform(kw_only_default=True)
class DocumentedMeta(ModelMetaclass):
    """Metaclass for the documentation of descriptions in help(), dir() and editors.

    It shows the fields and the methods of the description, and hides those of pydantic.
    """

    @property
    def __doc__(cls) -> str:  # type: ignore[override]  # noqa: N805
        return documentation(cls)

    @property
    def __signature__(cls) -> Signature:  # noqa: N805
        arguments: Signature = signature(cls)
        return arguments

    @__signature__.setter
    def __signature__(cls, value: Any) -> None:  # noqa: N805
        pass  # pydantic sets its own, with annotations that help() cannot show

    def __dir__(cls) -> list[str]:  # noqa: N805
        names = set(super().__dir__()) - set(dir(BaseModel))
        return sorted(name for name in names if not name.startswith(("_", "model_")))


class Description(BaseModel, metaclass=DocumentedMeta):
    """An immutable, validated description; rejects unknown names and values out of range."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __dir__(self) -> list[str]:
        return sorted({*dir(type(self)), *type(self).model_fields})

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(self) is not type(other):
            return NotImplemented
        # Only the fields: cached properties may be arrays, which have no single truth value.
        return all(getattr(self, name) == getattr(other, name) for name in type(self).model_fields)

    def __init__(self, /, **fields: Any) -> None:
        faults: list[tuple[str, str]] = []
        fields = self._converted(fields, faults)
        report = None
        try:
            self.__pydantic_validator__.validate_python(fields, self_instance=self)
        except ValidationError as rejected:
            report = rejected
        if report is not None or faults:
            raise validation_error(type(self), report, faults)

    @classmethod
    def _converted(cls, fields: dict[str, Any], faults: list[tuple[str, str]]) -> dict[str, Any]:
        """Return the fields converted to SI numbers; see :mod:`~woundon.problems.inputs`."""
        return convert_fields(cls, fields, faults)

    def __setattr__(self, name: str, value: Any) -> NoReturn:
        """Raise an error: a description is immutable."""
        raise FrozenInstanceError(
            f"a {type(self).__name__} is immutable; create a variant with .replace({name}=...)"
        )

    def __delattr__(self, name: str) -> NoReturn:
        """Raise an error: a description is immutable."""
        raise FrozenInstanceError(f"a {type(self).__name__} is immutable; {name} cannot be deleted")

    def replace(self, /, **changes: Any) -> Self:
        """Return a variant with some fields changed.

        Nested fields have dotted names, items of lists are numbered.  A value is a number in SI or
        text with a unit; ``diameter`` may replace ``radius``.

        >>> import woundon as wo
        >>> nip = wo.NipProblem.example().replace(nip_load=5e3, **{"web.thickness": "57 um"})
        >>> nip.nip_load, nip.web.thickness
        (5000.0, 5.7e-05)

        Raises
        ------
        InvalidProblem
            If a name does not exist or the variant is not admissible.
        """
        faults: list[tuple[str, str]] = []
        fields = change_fields(self, self._changes(changes, faults), faults)
        if faults:
            raise InvalidProblem(faults)
        return type(self)(**fields)

    def _repr_html_(self) -> str:
        """Return a table of the fields."""
        rows = [
            _cells(place.path, place.quantity, place.value)
            for place in walk(self)
            if place.value is not None
        ]
        cells = "\n".join(
            f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows
        )
        caption = f"<caption><b>{escape(type(self).__name__)}</b></caption>"
        return f"<table>{caption}<tbody>\n{cells}\n</tbody></table>"

    def _changes(self, changes: Mapping[str, Any], faults: list[tuple[str, str]]) -> dict[str, Any]:
        """Return changes by dotted name, with text converted to numbers in SI."""
        converted: dict[str, Any] = dict(changes)
        if not any(isinstance(value, (str, FloatWithUnit)) for value in changes.values()):
            return converted
        context = conversion_context(self)
        for path in conversion_order(changes):
            name = path.removeprefix("web.")
            if isinstance(changes[path], (str, FloatWithUnit)):
                try:
                    converted[path] = self._change(path, changes[path], context)
                except InvalidProblem as fault:
                    faults += fault.faults
                    converted.pop(path)
            context = context.with_field(name, converted.get(path))
        faults.sort(key=lambda fault: _position(fault[0], changes))
        return converted

    def _change(self, path: str, value: str | FloatWithUnit, context: Context) -> Any:
        """Return the value of a field from a text with its unit."""
        places = find_places(self, path)
        place = next((p for p in places if p.quantity is not None), None)
        return value if place is None else convert(value, place, context)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy; changes are validated (pydantic's own copy and copy.replace skip that)."""
        return self.replace(**update) if update else super().model_copy(deep=deep)


def _position(field: str, changes: Mapping[str, Any]) -> int:
    """Return the index of the change that a fault belongs to."""
    paths = list(changes)
    return next((k for k, path in enumerate(paths) if is_part_of(field, path)), len(paths))


def _cells(path: str, quantity: Quantity | None, value: Any) -> tuple[str, str, str, str]:
    """Return the label, symbol, value and unit of a field as text."""
    if quantity is None or not isinstance(value, (int, float)):
        return path, "", str(value), ""
    # The meaning of a nested field ("outer radius") does not identify the part.
    label = path if "." in path else quantity.meaning
    return label, quantity.symbol, f"{quantity.shown(value):.6g}", quantity.display
