"""Conversion of the forms in which users enter values: units, totals, stresses, basis weights.

A description is a validated object with fields: a problem, a body, a material.  A schedule is a
field of values over the radius of a roll, which have the unit of the field that holds it.

A field holds a force per metre of width, a thickness, a pressure in SI.  Users also enter

- text with a unit of the field's dimension: "20 pli";
- a total force ("3.6 kN") for a force per width, with the ``width`` of the problem;
- a stress ("10 MPa") for a web tension, with the thickness of the web;
- a basis weight ("45 gsm") for the thickness of the web, with its density, or the reverse.

The constructor of a description states its values (:class:`Inputs`), pydantic calls the validator
of each number (:mod:`.fields`), and this converts a text: :func:`read_text` finds the quantity of
the field, :func:`read_number` the form, and :func:`.units.parse` the unit.  Diameters are halved
before (:func:`.paths.halve_diameters`).
"""

from __future__ import annotations

from collections.abc import Mapping
from contextvars import ContextVar, Token
from math import inf
from numbers import Real
from typing import Any, Literal, Self

from pydantic import BaseModel

from ..errors import InvalidProblem
from ..quantities import (
    OF_FIELD,
    Quantity,
    density_of_web,
    length,
    quantity_of,
    thickness_of_web,
)
from .units import has_dimension, parse

__all__ = [
    "FloatWithUnit",
    "Inputs",
    "NotAList",
    "NotANumber",
    "is_array",
    "is_basis_weight",
    "other_units",
    "read_number",
    "read_text",
    "real_number",
]

# Values by which other values are converted, and their quantities.
_CONVERTING = {
    "width": length("w", "width of the web"),
    "thickness": thickness_of_web(),
    "density": density_of_web(),
}
# SI units of the values of a schedule that is not yet part of a problem: one of them fits.
_OF_SCHEDULES = ("N/m", "N", "Pa", "1")


class NotANumber(ValueError):
    """A validator found something else in place of a number."""


class NotAList(ValueError):
    """A validator found something else in place of a list."""


class Inputs:
    """Values from which a description is created; they convert totals, stresses, basis weights.

    Used as a context, it is the :meth:`current` one for the validators of the fields.

    Attributes
    ----------
    model : type
        Class of the description.
    fields : mapping
        Values by name as they were entered: numbers in SI, texts, tables, descriptions.
    outer : Inputs, optional
        Values of the description that contains this one.
    field : str
        Name of the field for which a contained description is created.
    """

    __slots__ = ("_token", "field", "fields", "model", "outer")
    _token: Token[Inputs | None]

    def __init__(
        self, model: type[BaseModel], fields: Mapping[str, Any], outer: Inputs | None = None
    ) -> None:
        self.model, self.fields, self.outer = model, fields, outer
        self.field = ""

    @classmethod
    def of(cls, description: BaseModel) -> Self:
        """Return the values of a description."""
        return cls(type(description), vars(description))

    @staticmethod
    def current() -> Inputs | None:
        """Return the values of the description that is being created; None outside of one."""
        return _CURRENT.get()

    def __enter__(self) -> Self:
        self._token = _CURRENT.set(self)
        return self

    def __exit__(self, *exception: object) -> None:
        _CURRENT.reset(self._token)

    @property
    def holder(self) -> Quantity | None:
        """Quantity of the field that holds the description; None if it is not known."""
        if self.outer is None or not self.outer.field:
            return None
        return quantity_of(self.outer.model.model_fields[self.outer.field], self.outer.holder)

    @property
    def accepts_width(self) -> bool:
        """True if the description, or one that contains it, has a field for the width."""
        is_outside = self.outer is not None and self.outer.accepts_width
        return is_outside or "width" in self.model.model_fields

    def known(self, name: Literal["width", "thickness", "density"]) -> float | None:
        """Return the width [m], thickness [m] or density [kg/m^3] of the web; None if unknown."""
        own = self._own(name)
        return self.outer.known(name) if own is None and self.outer is not None else own

    def _own(self, name: Literal["width", "thickness", "density"]) -> float | None:
        """Return a value of the web that is among the fields; None if there is none."""
        value = self.fields.get(name)
        if name == "thickness":
            # the fields are those of a nip or a winding, of a roll, or of a web
            web = self.fields.get("web", self.fields.get("web_thickness", value))
            if isinstance(web, Mapping):  # it may contain the density of the web
                return Inputs(self.model, web, self)._own(name)
            value = getattr(web, "thickness", web)
        if name == "density" and is_basis_weight(value):  # it is converted with the thickness
            return None
        if isinstance(value, str):
            try:
                return read_number(value, _CONVERTING[name], name, self)
            except InvalidProblem:  # the validator of the field reports it
                return None
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            return None
        return float(value)


_CURRENT: ContextVar[Inputs | None] = ContextVar("current inputs", default=None)


class FloatWithUnit(float):
    """A number in SI with its text: a value of a schedule that is not yet part of a problem."""

    text: str

    def __new__(cls, value: float, text: str) -> FloatWithUnit:
        """Return the number."""
        number = super().__new__(cls, value)
        number.text = text
        return number

    def __getnewargs__(self) -> tuple[float, str]:  # type: ignore[override]  # for copies
        return float(self), self.text

    @classmethod
    def of_text(cls, text: str) -> FloatWithUnit:
        """Return the number of a text with a unit of one of the quantities of schedules.

        Raises
        ------
        InvalidProblem
            If it has none.
        """
        is_plain = not text.strip(" +-.eE0123456789")
        units = (unit for unit in _OF_SCHEDULES if has_dimension(text, unit))
        # if none fits, parse reads a pure number, or rejects the text with an example in N/m
        return cls(parse(text, next(units, "1" if is_plain else "N/m"), ""), text)


def real_number(number: object) -> float:
    """Return a real number of any type (int, Fraction, NumPy scalar, 0-d array) as a float.

    Raises
    ------
    NotANumber
        For anything else: texts, masked values and booleans, which pydantic accepts as numbers.
    """
    value: Any = number
    kind = value.dtype.kind if is_array(value) and value.shape == () else ""
    if isinstance(value, bool) or not (isinstance(value, Real) or kind in ("i", "u", "f")):
        raise NotANumber
    if getattr(value, "mask", False) is not False and bool(value.mask):
        raise NotANumber
    try:
        return float(value)
    except OverflowError:  # an integer of more than 308 digits
        return inf if value > 0 else -inf


def is_array(value: object) -> bool:
    """Return True for arrays, scalars and series of NumPy and of libraries that build on it."""
    return hasattr(value, "dtype") and hasattr(value, "tolist")


def read_text(text: str | FloatWithUnit, name: str | None) -> float:
    """Return the number in SI of a text, for a field of the description that is being created.

    Parameters
    ----------
    text : str or FloatWithUnit
    name : str
        Name of the field.  A value of a schedule that is not yet part of a problem is returned as a
        :class:`FloatWithUnit`.

    Raises
    ------
    NotANumber
        If the field is not a number with a unit.
    InvalidProblem
        For a text that is not a value of the field; without the name of the field.
    """
    inputs = _CURRENT.get()
    if inputs is None or name is None:  # outside of a description
        raise NotANumber
    field = inputs.model.model_fields[name]
    quantity = quantity_of(field, inputs.holder)
    if quantity is not None:
        return read_number(getattr(text, "text", text), quantity, "", inputs)
    if OF_FIELD not in field.metadata:
        raise NotANumber
    return text if isinstance(text, FloatWithUnit) else FloatWithUnit.of_text(text)


def read_number(value: str | float, quantity: Quantity, where: str, inputs: Inputs) -> float:
    """Return a value in the SI unit of a quantity; a number is in SI already.

    Parameters
    ----------
    value : str or float
    quantity : Quantity
    where : str
        Name of the value, for the error message.
    inputs : Inputs
        Width, thickness and density with which other forms are converted.

    Raises
    ------
    InvalidProblem
        If the text is not a value of the quantity, or cannot be converted to it.
    """
    if not isinstance(value, str):
        return parse(value, quantity.unit, where)
    if quantity.unit == "N/m" and has_dimension(value, "N"):
        width = inputs.known("width")
        if not width:
            hint = "Divide it by the width of the web and write it in N/m, kN/m or pli"
            if inputs.accepts_width:
                hint = "Give the width of the web, e.g. width = '2.5 m', or write it in N/m or pli"
            text = f"{value!r} is a force; expected a force per width. {hint}"
            raise InvalidProblem.at(where, text)
        return parse(value, "N", where) / width
    if quantity.other_form == "stress" and has_dimension(value, "Pa"):
        thickness = inputs.known("thickness")
        if not thickness:
            text = f"{value!r} is a stress; expected a force per width. The thickness of the web"
            hint = "is not known here; write it in N/m, kN/m or pli"
            raise InvalidProblem.at(where, f"{text} {hint}")
        return parse(value, "Pa", where) * thickness
    if quantity.other_form == "basis weight" and is_basis_weight(value):
        return _of_basis_weight(value, quantity.unit, where, inputs)
    return parse(value, quantity.unit, where)


def _of_basis_weight(text: str, unit: str, where: str, inputs: Inputs) -> float:
    """Return the thickness of the web from its density, or the density from its thickness."""
    if unit == "m":
        known, required, example = inputs.known("density"), "density", "680 kg/m^3"
    else:
        known, required, example = inputs.known("thickness"), "thickness", "66 um"
    if not known:
        raise InvalidProblem.at(
            where,
            f"{text!r} is a basis weight; expected a value in {unit}. Give the {required} of "
            f"the web, e.g. {required} = {example!r}, to convert it",
        )
    return parse(text, "kg/m^2", where) / known


def is_basis_weight(value: object) -> bool:
    """Return True for a text such as "45 gsm"."""
    return isinstance(value, str) and has_dimension(value, "kg/m^2")


def other_units(quantity: Quantity) -> tuple[str, ...]:
    """Return the SI units of the other forms in which a quantity may be entered."""
    total = ("N",) if quantity.unit == "N/m" else ()
    form = {"stress": ("Pa",), "basis weight": ("kg/m^2",)}
    return total + form.get(quantity.other_form, ())
