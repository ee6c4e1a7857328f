"""The forms in which users enter values: texts with units, totals, diameters, basis weights.

A field holds one form: a force per metre of width, a radius, a thickness.  The functions here
convert the other forms before a description is validated:

- text with a unit of the field's dimension: "20 pli";
- total force ("3.6 kN") for a force per width, with the ``width`` of the problem;
- stress ("10 MPa") for a web tension, with the thickness of the web;
- basis weight ("45 gsm") for the thickness of the web, with its density, or the reverse;
- ``diameter`` for ``radius``, ``core_diameter`` for ``core_radius``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any, Literal, NamedTuple, get_args, get_origin

from ..errors import InvalidProblem
from ..quantities import (
    OF_FIELD,
    Place,
    Quantity,
    counterpart,
    find,
    is_list,
    members_of,
)
from .permitted import takes_a_number
from .units import has_dimension, parse

__all__ = [
    "Context",
    "FloatWithUnit",
    "context_of",
    "convert",
    "convert_fields",
    "in_order",
    "is_word",
]

Faults = list[tuple[str, str]]

# Fields that other fields are converted with; they are converted first, in this order.
_FIRST = ("width", "density", "web", "web_thickness", "thickness", "density as a basis weight")
# SI units in which the values of a schedule are read that is not yet part of a problem.
_OF_SCHEDULES = ("N/m", "N", "Pa", "1")


class FloatWithUnit(float):
    """A number in SI with its unit: a value of a schedule that is not yet part of a problem."""

    unit: str

    def __new__(cls, value: float, unit: str) -> FloatWithUnit:
        """Return the number."""
        number = super().__new__(cls, value)
        number.unit = unit
        return number

    def __getnewargs__(self) -> tuple[float, str]:  # type: ignore[override]
        return float(self), self.unit

    @property
    def text(self) -> str:
        """The number as text with its unit; :func:`~.units.parse` reads the same number."""
        number = float.__repr__(self)
        return number if self.unit == "1" else f"{number} {self.unit}"


class Context(NamedTuple):
    """What totals, stresses and basis weights are converted with, SI; None where it is unknown."""

    width: float | None = None
    thickness: float | None = None
    density: float | None = None

    def with_field(self, name: str, value: Any) -> Context:
        """Return the context once a field of this name is known."""
        if name == "web":
            inner = value.get("thickness") if isinstance(value, Mapping) else value
            name, value = "thickness", getattr(inner, "thickness", inner)
        name = name.removeprefix("web_")
        if name not in self._fields or isinstance(value, bool):
            return self
        return self._replace(**{name: float(value)}) if isinstance(value, (int, float)) else self


def context_of(problem: Any) -> Context:
    """Return the context that the fields of a description give."""
    context = Context()
    for name in _FIRST:
        context = context.with_field(name, getattr(problem, name, None))
    return context


def in_order(changes: Mapping[str, Any]) -> list[str]:
    """Return the dotted names of changed fields, those first that others are converted with."""

    def rank(path: str) -> int:
        name = "thickness" if path in ("web.thickness", "web_thickness") else path
        if name == "density" and _is_basis_weight(changes[path]):
            return len(_FIRST) - 1
        return _FIRST.index(name) if name in _FIRST else len(_FIRST)

    return sorted(changes, key=rank)


def convert_fields(
    model: type[Any], fields: Mapping[str, Any], faults: Faults, context: Context | None = None
) -> dict[str, Any]:
    """Return the fields of a description as it holds them.

    Parameters
    ----------
    model : type
        Class of the description.
    fields : mapping
        Values by name: numbers in SI, texts with units, tables of nested descriptions.
    faults : list
        Values that cannot be converted stay as they are and are appended here, (field, text).
    context : Context, optional
        That of the description which holds this one.
    """
    if not any(_may_be_converted(name, value, model) for name, value in fields.items()):
        return dict(fields)
    return _table(fields, (model,), "", faults, context or Context())


def convert(value: Any, place: Place, context: Context) -> Any:
    """Return the value of one field as its description holds it.

    Raises
    ------
    InvalidProblem
        For a text that is not a value of the field.
    """
    faults: Faults = []
    found = _value(value, [place], place.path, faults, context)
    if faults:
        raise InvalidProblem(faults)
    return found


def _may_be_converted(name: str, value: Any, model: type[Any]) -> bool:
    return name not in model.model_fields or _holds_other_form(value)


def _holds_other_form(value: Any) -> bool:
    if type(value) in (list, tuple):
        return any(map(_is_other_form, value))
    return _is_other_form(value)


def _is_other_form(value: Any) -> bool:
    if type(value) in (float, int) or value is None:
        return False
    return isinstance(value, (str, Mapping, list, tuple, FloatWithUnit)) or _has_units(value)


def _table(
    table: Mapping[str, Any],
    models: Iterable[type[Any]],
    prefix: str,
    faults: Faults,
    context: Context,
    of_field: Quantity | None = None,
) -> dict[str, Any]:
    """Return the converted fields of a description, or of a table that one is made of."""
    kind = table.get("kind")
    named = [m for m in models if getattr(m, "member_name", str)() == kind]
    models = tuple(named or models)
    given = _with_radii(table, models, prefix, faults)
    first = [name for name in _FIRST if name in given]
    if _is_basis_weight(given.get("density")):  # converted with the thickness
        first = [*(name for name in first if name != "density"), "density"]
    found: dict[str, Any] = {}
    for name in dict.fromkeys((*first, *given)):
        found[name] = given[name]
        if _holds_other_form(given[name]):
            places = [p for m in models for p in find(m, str(name), of_field)]
            places = places or [p for m in models for p in _input_only(m, str(name))]
            found[name] = _value(given[name], places, f"{prefix}{name}", faults, context)
        context = context.with_field(name, found[name])
    helpers = {name for m in models for name in getattr(m, "_input_only", ())} & found.keys()
    for name in helpers:
        if not _is_basis_weight(given.get("thickness")):
            text = "converts a thickness that is given as a basis weight; must be left out here"
            faults.append((f"{prefix}{name}", text))
    return {name: found[name] for name in given if name not in helpers}


def _input_only(model: type[Any], name: str) -> Iterable[Place]:
    """Yield what a description takes to convert its fields, but does not hold."""
    quantity = getattr(model, "_input_only", {}).get(name)
    if quantity is not None:
        yield Place(name, quantity, model.model_fields["thickness"], model)


def _with_radii(
    table: Mapping[str, Any], models: tuple[type[Any], ...], prefix: str, faults: Faults
) -> dict[str, Any]:
    """Return a table with radii in place of diameters."""
    given = dict(table)
    for name in table:
        radius = counterpart(str(name), "diameter")
        if not radius or any(name in m.model_fields for m in models):
            continue
        if not any(radius in m.model_fields for m in models):
            continue
        value = given.pop(name)
        if radius in given:
            text = f"is given together with {radius}; must be one of the two"
            faults.append((f"{prefix}{name}", text))
            continue
        before = len(faults)
        given[radius] = _radius(value, f"{prefix}{name}", faults)
        if len(faults) > before:
            given[radius] = None
            faults.append((f"{prefix}{radius}", ""))  # The fault of the diameter stands for it.
    return given


def _radius(diameter: Any, path: str, faults: Faults) -> Any:
    if isinstance(diameter, (list, tuple)):
        return [_radius(item, f"{path}.{k}", faults) for k, item in enumerate(diameter)]
    if hasattr(diameter, "dtype"):  # an array
        return diameter / 2
    try:
        return parse(_text(diameter), "m", path) / 2
    except InvalidProblem as fault:
        faults += fault.faults
        return diameter


def _value(value: Any, places: list[Place], path: str, faults: Faults, context: Context) -> Any:
    """Return one converted value; ``places`` are the fields that it may be a value of."""
    if type(value) is float or value is None:
        return value
    if isinstance(value, Mapping):
        inner = tuple(model for p in places for model in members_of(p.field.annotation))
        of_field = next((p.quantity for p in places), None)
        return _table(value, inner, f"{path}.", faults, context, of_field)
    if isinstance(value, (list, tuple)) and any(is_list(p.field.annotation) for p in places):
        if all(isinstance(item, (int, float)) and not _has_unit(item) for item in value):
            return value
        found = [_value(v, places, f"{path}.{k}", faults, context) for k, v in enumerate(value)]
        return type(value)(found) if type(value) in (list, tuple) else found
    if _has_units(value):
        return _schedule(value, places, path, faults, context)
    if not isinstance(value, (str, FloatWithUnit)):
        return value
    text = _text(value)
    quantity = next((p.quantity for p in places if p.quantity), None)
    try:
        if quantity is None:
            if any(OF_FIELD in getattr(p.field, "metadata", ()) for p in places):
                return _with_unit(text, path)
            return value
        if any(is_word(value, p.field.annotation) for p in places):
            return value
        return _number(text, quantity, path, context)
    except InvalidProblem as fault:
        faults += fault.faults
        return value


def _has_unit(value: Any) -> bool:
    return isinstance(value, FloatWithUnit)


def _text(value: Any) -> Any:
    return value.text if isinstance(value, FloatWithUnit) else value


def _has_units(value: Any) -> bool:
    """Tell whether a schedule holds values with units."""
    for name in _values_of_field(value.__class__):
        held = getattr(value, name)
        if any(map(_has_unit, held if isinstance(held, tuple) else (held,))):
            return True
    return False


@cache
def _values_of_field(model: Any) -> tuple[str, ...]:
    """Return the names of the fields that are in the unit of the field that holds them all."""
    fields = getattr(model, "model_fields", {})
    return tuple(name for name, field in fields.items() if OF_FIELD in field.metadata)


def _schedule(value: Any, places: list[Place], path: str, faults: Faults, context: Context) -> Any:
    """Return a schedule whose values are in the unit of the field that holds it."""
    changed = {
        name: _value(
            getattr(value, name),
            [p for of in places for p in find(type(value), name, of.quantity)],
            f"{path}.{name}",
            faults,
            context,
        )
        for name in _values_of_field(value.__class__)
    }
    return value.replace(**changed)


def _with_unit(text: str, path: str) -> FloatWithUnit:
    """Return the value of a schedule that is not yet part of a problem."""
    for unit in _OF_SCHEDULES:
        if has_dimension(text, unit):
            return FloatWithUnit(parse(text, unit, path), unit)
    return FloatWithUnit(
        parse(text, "1" if not text.strip(" +-.eE0123456789") else "N/m", path), "1"
    )


# ---- one number ---------------------------------------------------------------------------------


def _number(text: str, quantity: Quantity, path: str, context: Context) -> float:
    """Return a text as a number in the SI unit of a quantity."""
    unit = quantity.unit
    if unit == "N/m" and has_dimension(text, "N"):
        return _per_width(text, path, context)
    if quantity.other_form == "stress" and has_dimension(text, "Pa"):
        return _tension_of_stress(text, path, context)
    if quantity.other_form == "basis weight" and _is_basis_weight(text):
        return _of_basis_weight(text, unit, path, context)
    return parse(text, unit, path)


def _per_width(text: str, path: str, context: Context) -> float:
    if not context.width:
        raise InvalidProblem.at(
            path,
            f"{text!r} is a force; expected a force per width. Give the width of the web, "
            "e.g. width = '2.5 m', which divides it, or write it in N/m, kN/m or pli",
        )
    return parse(text, "N", path) / context.width


def _tension_of_stress(text: str, path: str, context: Context) -> float:
    if not context.thickness:
        raise InvalidProblem.at(
            path,
            f"{text!r} is a stress; expected a force per width. The thickness of the web, "
            "which would convert it, is not known here; write it in N/m, kN/m or pli",
        )
    return parse(text, "Pa", path) * context.thickness


def _is_basis_weight(value: Any) -> bool:
    return isinstance(value, str) and has_dimension(value, "kg/m^2")


def _of_basis_weight(text: str, unit: str, path: str, context: Context) -> float:
    """Return the thickness of the web from its density, or the density from its thickness."""
    weight = parse(text, "kg/m^2", path)
    known, needed, example = context.density, "density", "680 kg/m^3"
    if unit != "m":
        known, needed, example = context.thickness, "thickness", "66 um"
    if not known:
        raise InvalidProblem.at(
            path,
            f"{text!r} is a basis weight; expected a value in {unit}. Give the {needed} of "
            f"the web, e.g. {needed} = {example!r}, to convert it",
        )
    return weight / known


# ---- annotations --------------------------------------------------------------------------------


def is_word(value: Any, annotation: Any) -> bool:
    """Tell whether a text stands for a word that a field admits, and for no number with a unit."""
    words = _words_of(annotation)
    return (
        isinstance(value, str)
        and bool(words)
        and (value in words or not takes_a_number(annotation))
    )


def _words_of(annotation: Any) -> tuple[str, ...]:
    parts = get_args(annotation)
    if get_origin(annotation) is Literal:
        return parts
    return tuple(word for part in parts for word in _words_of(part))
