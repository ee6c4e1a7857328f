"""Conversion of the forms in which users enter values: units, totals, diameters, basis weights.

A field holds a force per metre of width, a radius, a thickness.  Other forms are converted before
a description is validated:

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

from pydantic import BaseModel

from ..errors import InvalidProblem
from ..quantities import OF_FIELD, Place, Quantity, is_list, members_of
from .paths import counterpart, find_places
from .permitted import accepts_number
from .units import has_dimension, parse

__all__ = [
    "Context",
    "FloatWithUnit",
    "conversion_context",
    "conversion_order",
    "convert",
    "convert_fields",
    "convert_number",
    "is_basis_weight",
    "is_word",
    "number_in_si",
    "other_units",
]

Faults = list[tuple[str, str]]

# Fields by which other fields are converted; they are converted first, in this order.
_FIRST = ("width", "density", "web", "web_thickness", "thickness", "density as a basis weight")
# SI units of the values of a schedule that is not yet part of a problem: one of them fits.
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
    """Values that convert totals, stresses and basis weights [SI]; None if unknown.

    ``accepts_width`` tells whether the problem has a field for the width.
    """

    width: float | None = None
    thickness: float | None = None
    density: float | None = None
    accepts_width: bool = False

    def with_field(self, name: str, value: Any) -> Context:
        """Return the context with the value of a field."""
        if name == "web":
            inner = value.get("thickness") if isinstance(value, Mapping) else value
            name, value = "thickness", getattr(inner, "thickness", inner)
        name = name.removeprefix("web_")
        known = name in ("width", "thickness", "density")
        if not known or isinstance(value, bool) or not isinstance(value, (int, float)):
            return self
        return Context(**{**self._asdict(), name: float(value)})


def conversion_context(problem: Any) -> Context:
    """Return the context of a description."""
    context = Context(accepts_width=hasattr(problem, "width"))
    for name in _FIRST:
        context = context.with_field(name, getattr(problem, name, None))
    return context


def conversion_order(changes: Mapping[str, Any]) -> list[str]:
    """Return the dotted names of changed fields in the order of their conversion."""

    def rank(path: str) -> int:
        """Return the place of a field: those that others are converted with come first."""
        name = path.removeprefix("web.").removeprefix("web_")
        if name == "density" and is_basis_weight(changes[path]):
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
        Receives (field, text) for every value that cannot be converted; the value itself is
        returned unchanged.
    context : Context, optional
        Context of the problem that contains this description.
    """
    known = model.model_fields
    if all(name in known for name in fields) and not any(
        _needs_conversion(value) and not is_word(value, known[name].annotation)
        for name, value in fields.items()
    ):
        return dict(fields)
    context = context or Context(accepts_width="width" in model.model_fields)
    return _convert_table(fields, (model,), "", faults, context)


def convert(value: Any, place: Place, context: Context) -> Any:
    """Return the converted value of one field.

    Raises
    ------
    InvalidProblem
        For text that is not a value of the field.
    """
    faults: Faults = []
    converted = _convert_value(value, [place], place.path, faults, context)
    if faults:
        raise InvalidProblem(faults)
    return converted


def number_in_si(base: BaseModel, path: str, value: Any, where: str = "") -> Any:
    """Return the value of a field that is a number in SI; a text is read with its unit.

    Parameters
    ----------
    base : Description
        Gives width, thickness and density, with which totals and stresses are converted.
    path : str
    value : float or str
    where : str
        Name of the value in an error message; the path by default.

    Raises
    ------
    InvalidProblem
        For a text that is not a value of the field.

    Examples
    --------
    >>> import woundon as wo
    >>> number_in_si(wo.RollerProblem.example(), "load", "89 kN/m")
    89000.0
    """
    place, quantity = next(
        (p, p.quantity) for p in find_places(base, path) if p.quantity is not None
    )
    if not isinstance(value, str):
        return parse(value, quantity.unit, where or path)
    return convert(value, place._replace(path=where or path), conversion_context(base))


def _needs_conversion(value: Any) -> bool:
    """Return True if a value is or contains text, a table or a number with a unit."""
    if type(value) in (float, int) or value is None:
        return False
    if type(value) in (list, tuple):
        return any(map(_needs_conversion, value))
    return isinstance(value, (str, Mapping, list, tuple, FloatWithUnit)) or _has_units(value)


def _convert_table(
    table: Mapping[str, Any],
    models: Iterable[type[Any]],
    prefix: str,
    faults: Faults,
    context: Context,
    of_field: Quantity | None = None,
) -> dict[str, Any]:
    """Return the converted fields of a description or of a nested table.

    Parameters
    ----------
    table : mapping
        Values by field name.
    models : iterable of types
        Classes whose fields the table may contain; ``kind`` selects one of them.
    prefix : str
        Dotted path of the table, for error messages.
    faults : list
        Receives (field, text).
    context : Context
    of_field : Quantity, optional
        Quantity of the field that contains the table, for the values of a schedule.
    """
    kind = table.get("kind")
    selected = [m for m in models if getattr(m, "member_name", str)() == kind]
    models = tuple(selected or models)
    values = _diameters_to_radii(table, models, prefix, faults)
    first = [name for name in _FIRST if name in values]
    if is_basis_weight(values.get("density")):  # which the thickness converts
        first = [*(name for name in first if name != "density"), "density"]
    converted: dict[str, Any] = {}
    for name in dict.fromkeys((*first, *values)):
        converted[name] = values[name]
        if _needs_conversion(values[name]):
            places = [p for m in models for p in find_places(m, str(name), of_field)]
            places = places or [p for m in models for p in _input_only(m, str(name))]
            converted[name] = _convert_value(
                values[name], places, f"{prefix}{name}", faults, context
            )
        context = context.with_field(name, converted[name])
    helpers = {name for m in models for name in getattr(m, "input_only", ())} & converted.keys()
    for name in helpers:
        if not is_basis_weight(values.get("thickness")):
            text = "converts a thickness that is given as a basis weight; must be left out here"
            faults.append((f"{prefix}{name}", text))
    return {name: converted[name] for name in values if name not in helpers}


def _input_only(model: type[Any], name: str) -> Iterable[Place]:
    """Yield inputs that convert other fields and are not stored, such as the density of a web."""
    quantity = getattr(model, "input_only", {}).get(name)
    if quantity is not None:
        yield Place(name, quantity, model.model_fields["thickness"], model)


def _diameters_to_radii(
    table: Mapping[str, Any], models: tuple[type[Any], ...], prefix: str, faults: Faults
) -> dict[str, Any]:
    """Replace diameters in a table by radii."""
    radii = dict(table)
    for name in table:
        radius = counterpart(str(name), "diameter")
        if not radius or any(name in m.model_fields for m in models):
            continue
        if not any(radius in m.model_fields for m in models):
            continue
        value = radii.pop(name)
        if radius in radii:
            text = f"is given together with {radius}; give one of the two"
            faults.append((f"{prefix}{name}", text))
            continue
        count = len(faults)
        radii[radius] = _half(value, f"{prefix}{name}", faults)
        if len(faults) > count:
            radii[radius] = None
            faults.append((f"{prefix}{radius}", ""))  # not missing
    return radii


def _half(diameter: Any, path: str, faults: Faults) -> Any:
    """Return the radius of a diameter, or of each diameter in a list [m]."""
    if isinstance(diameter, (list, tuple)):
        return [_half(item, f"{path}.{k}", faults) for k, item in enumerate(diameter)]
    if hasattr(diameter, "dtype"):  # an array
        return diameter / 2
    try:
        return parse(_as_text(diameter), "m", path) / 2
    except InvalidProblem as fault:
        faults += fault.faults
        return diameter


def _convert_value(
    value: Any, places: list[Place], path: str, faults: Faults, context: Context
) -> Any:
    """Return one converted value; ``places`` are the fields that it may belong to."""
    if type(value) is float or value is None:
        return value
    if isinstance(value, Mapping):
        inner = tuple(model for p in places for model in members_of(p.field.annotation))
        of_field = next((p.quantity for p in places), None)
        return _convert_table(value, inner, f"{path}.", faults, context, of_field)
    if isinstance(value, (list, tuple)) and any(is_list(p.field.annotation) for p in places):
        if all(type(item) in (int, float) for item in value):
            return value
        converted = [
            _convert_value(v, places, f"{path}.{k}", faults, context) for k, v in enumerate(value)
        ]
        return type(value)(converted) if type(value) in (list, tuple) else converted
    if _has_units(value):
        return _convert_schedule(value, places, path, faults, context)
    if not isinstance(value, (str, FloatWithUnit)):
        return value
    text = _as_text(value)
    quantity = next((p.quantity for p in places if p.quantity), None)
    try:
        if quantity is None:
            if any(OF_FIELD in getattr(p.field, "metadata", ()) for p in places):
                return _value_with_unit(text, path)
            return value
        if any(is_word(value, p.field.annotation) for p in places):
            return value
        return convert_number(text, quantity, path, context)
    except InvalidProblem as fault:
        faults += fault.faults
        return value


def _as_text(value: Any) -> Any:
    return value.text if isinstance(value, FloatWithUnit) else value


def _has_units(schedule: Any) -> bool:
    """Return True if a schedule contains values with units."""
    for name in _values_of_field(schedule.__class__):
        values = getattr(schedule, name)
        values = values if isinstance(values, tuple) else (values,)
        if any(isinstance(value, FloatWithUnit) for value in values):
            return True
    return False


@cache
def _values_of_field(model: Any) -> tuple[str, ...]:
    """Return the fields of a schedule whose unit is that of the field that holds the schedule."""
    fields = getattr(model, "model_fields", {})
    return tuple(name for name, field in fields.items() if OF_FIELD in field.metadata)


def _convert_schedule(
    value: Any, places: list[Place], path: str, faults: Faults, context: Context
) -> Any:
    """Return a schedule with its values in the SI unit of the field that holds it."""
    changed = {
        name: _convert_value(
            getattr(value, name),
            [p for holder in places for p in find_places(type(value), name, holder.quantity)],
            f"{path}.{name}",
            faults,
            context,
        )
        for name in _values_of_field(value.__class__)
    }
    return value.replace(**changed)


def _value_with_unit(text: str, path: str) -> FloatWithUnit:
    """Return a value of a schedule that is not yet part of a problem, with its unit."""
    for unit in _OF_SCHEDULES:
        if has_dimension(text, unit):
            return FloatWithUnit(parse(text, unit, path), unit)
    return FloatWithUnit(
        parse(text, "1" if not text.strip(" +-.eE0123456789") else "N/m", path), "1"
    )


# ---- one number ---------------------------------------------------------------------------------


def convert_number(text: str, quantity: Quantity, path: str, context: Context) -> float:
    """Return text as a number in the SI unit of a quantity."""
    unit = quantity.unit
    if unit == "N/m" and has_dimension(text, "N"):
        return _per_width(text, path, context)
    if quantity.other_form == "stress" and has_dimension(text, "Pa"):
        return _tension_of_stress(text, path, context)
    if quantity.other_form == "basis weight" and is_basis_weight(text):
        return _of_basis_weight(text, unit, path, context)
    return parse(text, unit, path)


def other_units(quantity: Quantity) -> tuple[str, ...]:
    """Return the SI units of the other forms in which a quantity may be entered."""
    total = ("N",) if quantity.unit == "N/m" else ()
    form = {"stress": ("Pa",), "basis weight": ("kg/m^2",)}
    return total + form.get(quantity.other_form, ())


def _per_width(text: str, path: str, context: Context) -> float:
    """Convert a total force to a force per width."""
    if not context.width:
        hint = "Divide it by the width of the web and write it in N/m, kN/m or pli"
        if context.accepts_width:
            hint = "Give the width of the web, e.g. width = '2.5 m', or write it in N/m or pli"
        raise InvalidProblem.at(path, f"{text!r} is a force; expected a force per width. {hint}")
    return parse(text, "N", path) / context.width


def _tension_of_stress(text: str, path: str, context: Context) -> float:
    """Convert a stress to a force per width by the thickness of the web."""
    if not context.thickness:
        raise InvalidProblem.at(
            path,
            f"{text!r} is a stress; expected a force per width. The thickness of the web is not "
            "known here; write it in N/m, kN/m or pli",
        )
    return parse(text, "Pa", path) * context.thickness


def is_basis_weight(value: Any) -> bool:
    """Return True for a text such as "45 gsm"."""
    return isinstance(value, str) and has_dimension(value, "kg/m^2")


def _of_basis_weight(text: str, unit: str, path: str, context: Context) -> float:
    """Return the thickness of the web from its density, or the density from its thickness."""
    weight = parse(text, "kg/m^2", path)
    known, required, example = context.density, "density", "680 kg/m^3"
    if unit != "m":
        known, required, example = context.thickness, "thickness", "66 um"
    if not known:
        raise InvalidProblem.at(
            path,
            f"{text!r} is a basis weight; expected a value in {unit}. Give the {required} of "
            f"the web, e.g. {required} = {example!r}, to convert it",
        )
    return weight / known


# ---- annotations --------------------------------------------------------------------------------


def is_word(value: Any, annotation: Any) -> bool:
    """Return True if a text is a word for a field with this annotation.

    These are the words that the field accepts, or any text if it accepts words but no number: the
    validation then names the accepted words.
    """
    words = _words_of(annotation)
    return (
        isinstance(value, str)
        and bool(words)
        and (value in words or not accepts_number(annotation))
    )


def _words_of(annotation: Any) -> tuple[str, ...]:
    """Return the words that an annotation admits."""
    parts = get_args(annotation)
    if get_origin(annotation) is Literal:
        return parts
    return tuple(word for part in parts for word in _words_of(part))
