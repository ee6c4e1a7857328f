"""The base of every description (material, body, problem): immutable and validated.

pydantic validates; :mod:`~woundon.problems.messages` words the errors.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import FrozenInstanceError
from html import escape
from inspect import Signature
from typing import TYPE_CHECKING, Any, NoReturn, Self, dataclass_transform

from pydantic import (
    BaseModel,
    ConfigDict,
    ModelWrapValidatorHandler,
    ValidationError,
    model_validator,
)

from ..errors import InvalidProblem
from ..quantities import Quantity, walk
from .help_texts import documentation, signature
from .inputs import Inputs
from .messages import check_names, validation_error
from .paths import Faults, change_fields, halve_diameters

__all__ = ["Description", "is_unset"]

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


def is_unset(value: object) -> bool:
    """Return True for the value of an optional field that is not set: None, or an empty list."""
    return value is None or value == ()


class Description(BaseModel, metaclass=DocumentedMeta):
    """An immutable, validated description; rejects unknown names and values out of range."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, defer_build=True)

    @model_validator(mode="wrap")
    @classmethod
    def _check_names(cls, fields: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Reject a table with a name that is not text, before the constructor receives it."""
        if not isinstance(fields, Description) and isinstance(fields, Mapping):
            check_names(fields)
        return handler(fields)

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
        faults: Faults = []
        report = None
        # the validators of the fields read the inputs; the current ones are those of a description
        # that will contain this one
        with Inputs(type(self), fields, Inputs.current()) as inputs:
            values = self._fields_of(inputs, faults)
            try:
                self.__pydantic_validator__.validate_python(values, self_instance=self)
            except ValidationError as rejected:
                report = rejected
            if report is not None or faults:
                raise validation_error(type(self), report, faults)

    @classmethod
    def _fields_of(cls, inputs: Inputs, faults: Faults) -> dict[str, Any]:
        """Return the values by field that pydantic validates: radii in place of diameters.

        Values that cannot be converted are added to ``faults``, (field, text); an empty text only
        suppresses what pydantic reports on the field.
        """
        return halve_diameters(cls, inputs.fields, faults)

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
        faults: Faults = []
        fields = change_fields(self, changes, faults)
        try:
            variant = type(self)(**fields)
        except InvalidProblem as error:
            if not faults:
                raise
            # errors of other fields may only follow from the changes that do not exist
            faults = [*(fault for fault in error.faults if fault[0] in changes), *faults]
        if faults:
            raise InvalidProblem(faults)
        return variant

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

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy; changes are validated (pydantic's own copy and copy.replace skip that)."""
        return self.replace(**update) if update else super().model_copy(deep=deep)


def _cells(path: str, quantity: Quantity | None, value: Any) -> tuple[str, str, str, str]:
    """Return the label, symbol, value and unit of a field as text."""
    if quantity is None or not isinstance(value, (int, float)):
        return path, "", str(value), ""
    # The meaning of a nested field ("outer radius") does not identify the part.
    label = path if "." in path else quantity.meaning
    return label, quantity.symbol, f"{quantity.shown(value):.6g}", quantity.display
