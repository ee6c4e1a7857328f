"""A quantity is one thing: its symbol, units and meaning stand once, on the field that holds it.

A :class:`Quantity` is metadata of an annotation: of a description's field, of a result's field, or
of what a result's property or method returns:

    nip_load: Annotated[Number, line_load("P", "nip load"), Field(ge=1e-12, le=1e7)]
    half_width: Annotated[float, length("a", "half-width of the nip")]

    @property
    def nip_width(self) -> Annotated[float, length("2a", "nip width")]: ...

and one function, :func:`walk`, goes over all of them: case files, ``--set``, studies, reports, plot
labels, result files and the tables of the documentation read them there; none keeps its own list.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, cached_property
from inspect import Parameter, signature
from math import pi
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

__all__ = [
    "OF_FIELD",
    "Place",
    "Quantity",
    "angle",
    "counterpart",
    "density_of_web",
    "find",
    "is_item",
    "is_list",
    "length",
    "line_load",
    "members_of",
    "output",
    "outputs",
    "pattern",
    "pure",
    "scalar_outputs",
    "shown_in",
    "strain",
    "stress",
    "tension",
    "thickness_of_web",
    "value_of",
    "velocity",
    "walk",
]

_PER_SI = {
    "mm": 1e3,
    "um": 1e6,
    "kPa": 1e-3,
    "MPa": 1e-6,
    "%": 1e2,
    "deg": 180 / pi,
    "ms": 1e3,
    "m/min": 60.0,
}


@dataclasses.dataclass(frozen=True, slots=True)
class Quantity:
    """The meaning of a number: symbol, unit and label.

    >>> import woundon as wo
    >>> wo.Quantity("P", "N/m", "nip load").display
    'N/m'

    Attributes
    ----------
    symbol : str
        As in the formulas.
    unit : str
        SI; "1" for a pure number.
    meaning : str
        A few words, the sign convention where there is one.
    shown_unit : str
        In which people see it; as ``unit`` where empty.
    typical : (low, high), optional
        The range met in practice, SI; a slider's ends, not a limit.
    shown_in_si : float, optional
        How many of ``unit`` the ``shown_unit`` is, where somebody chose it (:func:`shown_in`).
    other_form : "", "stress" or "basis weight"
        Another form in which the quantity may be entered: a web tension as a stress, a web
        thickness or density as a basis weight (:mod:`woundon.problems.inputs`).
    """

    symbol: str
    unit: str
    meaning: str
    shown_unit: str = ""
    typical: tuple[float, float] | None = None
    shown_in_si: float | None = None
    other_form: str = ""

    def shown(self, value: Any) -> Any:
        """Return an SI value, or an array of them, in the unit for display."""
        if self.shown_in_si is not None:
            return value / self.shown_in_si
        return value * _PER_SI.get(self.shown_unit, 1.0)

    @property
    def display(self) -> str:
        """The unit for display, '' for a pure number."""
        unit = self.shown_unit or self.unit
        return "" if unit == "1" else unit

    def in_table(self, value: Any) -> tuple[str, Any]:
        """Return unit and value for a table: SI, or the chosen unit."""
        if self.shown_in_si is None:
            return self.unit, value
        return self.shown_unit, self.shown(value)


OF_FIELD = "of the field that holds it"  # in place of a quantity

Range = tuple[float, float] | None
_POSITIONAL = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)


def length(symbol: str, meaning: str, shown: str = "mm", typical: Range = None) -> Quantity:
    """Return a length [m]."""
    return Quantity(symbol, "m", meaning, shown, typical)


def thickness_of_web(typical: Range = None) -> Quantity:
    """Return the thickness of the web [m]; it may be entered as a basis weight."""
    return Quantity("2h", "m", "web thickness", "um", typical, other_form="basis weight")


def density_of_web(typical: Range = None) -> Quantity:
    """Return the density of the web [kg/m^3]; it may be entered as a basis weight."""
    return Quantity("rho", "kg/m^3", "density of the web", "", typical, other_form="basis weight")


def stress(symbol: str, meaning: str, shown: str = "kPa", typical: Range = None) -> Quantity:
    """Return a stress, a pressure or a modulus [Pa]."""
    return Quantity(symbol, "Pa", meaning, shown, typical)


def strain(symbol: str, meaning: str) -> Quantity:
    """Return a strain, a relative speed or another share, shown in percent [1]."""
    return Quantity(symbol, "1", meaning, "%")


def angle(symbol: str, meaning: str, typical: Range = None) -> Quantity:
    """Return an angle [rad]."""
    return Quantity(symbol, "rad", meaning, "deg", typical)


def line_load(symbol: str, meaning: str, typical: Range = None) -> Quantity:
    """Return a force per metre of width [N/m]."""
    return Quantity(symbol, "N/m", meaning, "", typical)


def tension(symbol: str, meaning: str, typical: Range = None) -> Quantity:
    """Return a tension of the web per metre of width [N/m]; it may be entered as a stress."""
    return Quantity(symbol, "N/m", meaning, "", typical, other_form="stress")


def velocity(symbol: str, meaning: str, typical: Range = None) -> Quantity:
    """Return a speed [m/s]."""
    return Quantity(symbol, "m/s", meaning, "m/min", typical)


def pure(symbol: str, meaning: str, typical: Range = None) -> Quantity:
    """Return a pure number [1]."""
    return Quantity(symbol, "1", meaning, "", typical)


# ---- chosen units -------------------------------------------------------------------------------

# (name, SI unit) -> chosen unit, how many SI units it is
Chosen = Mapping[tuple[str, str], tuple[str, float]]
_CHOSEN: ContextVar[Chosen] = ContextVar("chosen units", default=MappingProxyType({}))


@contextmanager
def shown_in(chosen: Chosen) -> Iterator[None]:
    """Show fields and outputs in other units, wherever they are asked for here."""
    token = _CHOSEN.set({**_CHOSEN.get(), **chosen})
    try:
        yield
    finally:
        _CHOSEN.reset(token)


def pattern(path: str) -> str:
    """Return a path as a class's has it, with ``*`` for the numbers of items."""
    return ".".join("*" if part.isdigit() else part for part in path.split("."))


def _as_chosen(path: str, quantity: Quantity | None) -> Quantity | None:
    """Return a quantity with the unit for display that the user has chosen."""
    chosen = _CHOSEN.get()
    if quantity is None or (path, quantity.unit) not in chosen:
        return quantity
    unit, size = chosen[path, quantity.unit]
    return dataclasses.replace(quantity, shown_unit=unit, shown_in_si=size)


# ---- the one walk -------------------------------------------------------------------------------


class Place(NamedTuple):
    """The position of a quantity in a description or result.

    Attributes
    ----------
    path : str
        Dotted name; items of a list by their number, or ``*`` where a class is walked.
    quantity : Quantity or None
        None for a field that is no number: a word, a name, a curve's law.
    field : object
        A description's pydantic ``FieldInfo``; of a result's output, what its annotation says.
    owner : type
        The class that has it.
    value : object
        Its value where an instance is walked, else None.
    """

    path: str
    quantity: Quantity | None
    field: Any
    owner: type
    value: Any = None

    @property
    def name(self) -> str:
        """The last part of the path."""
        return self.path.rpartition(".")[2]


def walk(thing: Any, prefix: str = "", of_field: Quantity | None = None) -> Iterator[Place]:
    """Yield every leaf of a description, or every output of a result, in the order of definition.

    Parameters
    ----------
    thing : class or instance
        Of a description (nested ones and lists of them are entered; of a class, all members of an
        open set) or of a result (fields, then properties and methods that take no argument).
    prefix : str
        Put before every path.
    of_field : Quantity, optional
        That of the field which holds the description, for what is marked ``OF_FIELD``.
    """
    of = thing if isinstance(thing, type) else type(thing)
    if not hasattr(of, "model_fields"):
        yield from _walk_outputs(thing, of, prefix)
        return
    for name, field in of.model_fields.items():
        path = f"{prefix}{name}"
        quantity = quantity_of(field, of_field)
        if thing is of:
            yield from _walk_annotation(Place(path, quantity, field, of))
        else:
            yield from _walk_value(Place(path, quantity, field, of, getattr(thing, name)))


def _walk_value(place: Place) -> Iterator[Place]:
    """Yield a value of a description, or the values of the descriptions it contains."""
    path, value = place.path, place.value
    if hasattr(type(value), "model_fields"):
        yield from walk(value, f"{path}.", place.quantity)
    elif isinstance(value, tuple) and any(hasattr(type(v), "model_fields") for v in value):
        for k, item in enumerate(value):
            yield from _walk_value(place._replace(path=f"{path}.{k}", value=item))
    else:  # a word in a number's place is none
        quantity = None if isinstance(value, str) else place.quantity
        yield place._replace(quantity=_as_chosen(path, quantity))


def _walk_annotation(place: Place) -> Iterator[Place]:
    """Yield a field if it may be a value, then the fields of the descriptions it may contain."""
    annotation = place.field.annotation
    inner = members_of(annotation)
    if not inner or float in get_args(annotation):
        yield place._replace(quantity=_as_chosen(place.path, place.quantity))
    part = f"{place.path}.*." if is_list(annotation) else f"{place.path}."
    for model in inner:
        yield from walk(model, part, place.quantity)


def find(thing: Any, path: str, of_field: Quantity | None = None) -> tuple[Place, ...]:
    """Return the places of a dotted name below a description's class or instance; () if none.

    A field that only another body or material than the present one has is found too, and so is one
    of any item of a list; a path that ends at a description gives the places of its field.  The
    diameter of what has a radius is found with the field of the radius.
    """
    of = thing if isinstance(thing, type) else type(thing)
    models: tuple[tuple[Any, Quantity | None], ...] = ((of, of_field),)
    found: tuple[Place, ...] = ()
    parts = path.split(".")
    for k, name in enumerate(parts):
        if found and name.isascii() and name.isdecimal() and is_list(found[0].field.annotation):
            continue
        below = ".".join(parts[: k + 1])
        fields = [(m, m.model_fields[name], above) for m, above in models if name in m.model_fields]
        found = tuple(
            Place(below, _as_chosen(below, quantity_of(field, above)), field, m)
            for m, field, above in fields
        )
        radius = counterpart(name, "diameter")
        if radius and not found:
            found = tuple(
                Place(
                    below, _diameter(quantity_of(m.model_fields[radius])), m.model_fields[radius], m
                )
                for m, _ in models
                if radius in m.model_fields
            )
        models = tuple((m, p.quantity) for p in found for m in members_of(p.field.annotation))
    return found


def counterpart(name: str, word: str) -> str:
    """Return the radius of a diameter's name (``core_diameter``), or the reverse; '' for none.

    Parameters
    ----------
    name : str
    word : "diameter" or "radius"
        The word that is replaced.
    """
    other = {"diameter": "radius", "radius": "diameter"}[word]
    head, found, tail = name.rpartition(word)
    return head + other if found and not tail and (not head or head.endswith("_")) else ""


def _diameter(radius: Quantity | None) -> Quantity | None:
    """Return the quantity of the diameter that may be given instead of a radius."""
    if radius is None:
        return None
    symbol = radius.symbol.replace("R", "D", 1).replace("r", "d", 1)
    ends = radius.typical and (2 * radius.typical[0], 2 * radius.typical[1])
    meaning = radius.meaning.replace("radius", "diameter").replace("radii", "diameters")
    return dataclasses.replace(radius, symbol=symbol, meaning=meaning, typical=ends)


def quantity_of(field: Any, of_field: Quantity | None = None) -> Quantity | None:
    """Return the quantity in a pydantic field's metadata.

    What is marked ``OF_FIELD``, as a profile's values, has that of the field which holds it all.
    """
    if OF_FIELD in field.metadata:
        return of_field
    return next((part for part in field.metadata if isinstance(part, Quantity)), None)


def members_of(annotation: Any) -> tuple[type, ...]:
    """Return the descriptions that an annotation admits, all members of an open set."""
    if isinstance(annotation, type) and hasattr(annotation, "model_fields"):
        members: Mapping[str, type] | None = getattr(annotation, "members", lambda: None)()
        return (annotation,) if members is None else tuple(members.values())
    found = (model for part in get_args(annotation) for model in members_of(part))
    return tuple(dict.fromkeys(found))


def is_item(name: str, count: int) -> bool:
    """Return True if a part of a dotted name is the index of an item in a list of ``count``."""
    # Python limits the digits of int(), and isdecimal() admits digits of other scripts.
    return name.isascii() and name.isdecimal() and len(name) < 10 and int(name) < count


def is_list(annotation: Any) -> bool:
    """Return True if an annotation admits a list or tuple of values or descriptions."""
    if get_origin(annotation) in (tuple, list):
        return True
    return any(is_list(part) for part in get_args(annotation) if get_origin(part) is not None)


# ---- outputs ------------------------------------------------------------------------------------


def output(thing: Any, name: str) -> Place | None:
    """Return one output of a result's class or instance, without its value."""
    return next((p for p in outputs(thing) if p.path == name), None)


def outputs(thing: Any) -> tuple[Place, ...]:
    """Return the outputs of a result's class or instance, without values."""
    of = thing if isinstance(thing, type) else type(thing)
    return tuple(_walk_outputs(thing, of, "", values=False))


def scalar_outputs(thing: Any) -> dict[str, Quantity]:
    """Return the quantities of the outputs that are single numbers, by name."""
    return {
        place.path: place.quantity
        for place in outputs(thing)
        if place.quantity is not None and get_args(place.field)[0] in (float, int)
    }


class on_request(cached_property[Any]):  # noqa: N801
    """An output, or a part with outputs, that is computed when it is used: not in every report."""


def value_of(thing: Any, name: str) -> Any:
    """Return an output's value; a method without arguments is called.

    An output of a part that the result does not have, as ``air.film`` without air, is nan.
    """
    head, _, rest = name.partition(".")
    value = getattr(thing, head)
    if rest:
        return float("nan") if value is None else value_of(value, rest)
    return value() if callable(value) else value


def _walk_outputs(thing: Any, of: type, prefix: str, values: bool = True) -> Iterator[Place]:
    """Yield the outputs of a result or a class of results, with those of its parts."""
    own = {} if thing is of else getattr(thing, "relabelled", {})
    for name, (quantity, hint) in _annotated(of, _version(of)).items():
        part = name.partition(".")[0]
        missing = part != name and thing is not of and vars(thing).get(part, "") is None
        if missing or (thing is not of and is_on_request(of, part)):
            continue
        value = value_of(thing, name) if values and thing is not of else None
        yield Place(f"{prefix}{name}", _as_chosen(name, own.get(name, quantity)), hint, of, value)


def is_on_request(of: type, name: str) -> bool:
    """Return True if an output of a class, or the part that has it, is computed on request."""
    return isinstance(getattr(of, name.partition(".")[0], None), on_request)


def _version(of: type) -> tuple[tuple[str, int], ...]:
    """Return the identity of the outputs of a class, for caching."""
    return tuple(
        (name, id(made))
        for base in of.__mro__
        for name, made in vars(base).items()
        if isinstance(made, property) or callable(made)
    )


@cache
def _annotated(of: type, version: object) -> Mapping[str, tuple[Quantity, Any]]:
    """Return the outputs of a class by name with what their annotation says."""
    found: dict[str, Any] = {}
    if dataclasses.is_dataclass(of):
        hints = get_type_hints(of, include_extras=True)
        for field in dataclasses.fields(of):
            hint = hints[field.name]
            found[field.name] = hint
            for part in get_args(hint):
                if getattr(part, "part_of_result", False):
                    inner = _annotated(part, version)
                    found |= {f"{field.name}.{name}": each for name, (_, each) in inner.items()}
    for base in reversed(of.__mro__):
        for name, made in vars(base).items():
            hint = _returned(made)
            parts = [h for h in (hint, *get_args(hint)) if getattr(h, "part_of_result", False)]
            if parts:
                inner = _annotated(parts[0], version)
                found |= {f"{name}.{each}": part for each, (_, part) in inner.items()}
            elif hint is not None and not name.startswith("_"):
                found[name] = hint
    return {
        name: (quantity, hint)
        for name, hint in found.items()
        if (quantity := _quantity_in(hint)) is not None
    }


def _returned(made: Any) -> Any:
    """Return the annotation of a property, or of a method that needs no argument."""
    if isinstance(made, cached_property):
        made = property(made.func)
    function: Callable[..., Any] | None = made.fget if isinstance(made, property) else made
    hint = getattr(function, "__annotations__", {}).get("return")
    if function is None or hint is None:
        return None
    if isinstance(hint, str):
        try:
            hint = eval(hint, function.__globals__)  # as typing.get_type_hints does, return only
        except NameError:  # a name that type checkers alone import: no quantity
            return None
    parameters = list(signature(function).parameters.values())[1:]
    needed = [p for p in parameters if p.default is p.empty and p.kind in _POSITIONAL]
    return None if needed else hint


def _quantity_in(hint: Any) -> Quantity | None:
    if get_origin(hint) is not Annotated:
        return None
    return next((part for part in get_args(hint) if isinstance(part, Quantity)), None)
