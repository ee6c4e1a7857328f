"""Quantities: symbol, unit and meaning of each field and output, defined once, in its annotation.

A :class:`Quantity` is metadata in the annotation of a field of a description or a result, or in the
return annotation of a property or method of a result:

    nip_load: Annotated[Number, line_load("P", "nip load"), Field(ge=1e-12, le=1e7)]
    half_width: Annotated[float, length("a", "half-width of the nip")]

    @property
    def nip_width(self) -> Annotated[float, length("2a", "nip width")]: ...

A description is a pydantic class of inputs, or an instance of one: a problem, or a body, a material
or a law in it.  The function :func:`walk` yields all quantities of one, or of a result.  Case
files, ``--set``, studies, reports, plot labels, result files and the tables of the documentation
use it.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, cached_property, lru_cache
from inspect import Parameter, signature
from math import isfinite, nan, pi
from types import MappingProxyType
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    NamedTuple,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
)

if TYPE_CHECKING:
    import numpy as np
    from pydantic.fields import FieldInfo

__all__ = [
    "DISPLAYED",
    "OF_FIELD",
    "Choice",
    "Place",
    "Quantity",
    "Values",
    "angle",
    "as_given",
    "density_of_web",
    "header",
    "in_chosen_units",
    "is_list",
    "length",
    "line_load",
    "members_of",
    "numbers_of",
    "output",
    "outputs",
    "pattern",
    "pure",
    "scalar_outputs",
    "share",
    "shown_in",
    "strain",
    "stress",
    "tension",
    "thickness_of_web",
    "value_of",
    "velocity",
    "walk",
]

# A number, or an array of any shape: a function of either returns the same.
Values = TypeVar("Values", bound="float | np.ndarray")

# Units for display, with the SI unit and how many of it they are.
DISPLAYED: Mapping[str, tuple[str, float]] = MappingProxyType(
    {
        "um": ("m", 1e-6),
        "mm": ("m", 1e-3),
        "kPa": ("Pa", 1e3),
        "MPa": ("Pa", 1e6),
        "GPa": ("Pa", 1e9),
        "%": ("1", 1e-2),
        "deg": ("rad", pi / 180),
        "ms": ("s", 1e-3),
        "kW": ("W", 1e3),
        "rpm": ("rad/s", pi / 30),
        "m/min": ("m/s", 1 / 60),
    }
)


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
        Description in a few words, with the sign convention if there is one.
    shown_unit : str
        Unit for display unless the user has chosen another (:func:`shown_in`); empty if it is
        ``unit``.
    typical : (low, high), optional
        Range met in practice, SI: the ends of a slider, not a limit.
    other_form : "", "stress" or "basis weight"
        Another form in which the quantity may be entered: a web tension as a stress, a web
        thickness or density as a basis weight (:mod:`woundon.problems.inputs`).
    path : str
        Name of the field or output, by which the user chooses its unit; empty if it has none.
    """

    symbol: str
    unit: str
    meaning: str
    shown_unit: str = ""
    typical: tuple[float, float] | None = None
    other_form: str = ""
    path: str = dataclasses.field(default="", compare=False)

    def _unit(self) -> tuple[str, float]:
        """Return the unit for display and how many SI units it is.

        Reports, figures, tables and messages convert by this function alone.
        """
        return self._chosen() or self._usual()

    def _usual(self) -> tuple[str, float]:
        """Return the unit for display unless the user has chosen another, and its size."""
        unit = self.shown_unit or self.unit
        _, size = DISPLAYED.get(unit, ("", 1.0))
        return unit, size

    def _chosen(self) -> tuple[str, float] | None:
        """Return the unit that the user has chosen, by name or in a system, and its size."""
        chosen = _CHOSEN.get()
        # "drum.layers.0.thickness" may be chosen itself, or all layers; the SI unit is part of the
        # key because a name may have another quantity in another kind of problem
        for path in (self.path, pattern(self.path)) if chosen.names and self.path else ():
            if (path, self.unit) in chosen.names:
                return chosen.names[path, self.unit]
        return chosen.system.get(self.shown_unit or self.unit)

    def shown(self, value: Values) -> Values:
        """Return an SI value, or an array of them, in the unit for display."""
        shown: Any = value / self._unit()[1]
        return shown

    @property
    def display(self) -> str:
        """The unit for display, '' for a pure number."""
        unit, _ = self._unit()
        return "" if unit == "1" else unit

    def text(self, value: float, form: str = ".4g", *, error: float = nan) -> str:
        """Return an SI value as text in the unit for display, with its error to two digits.

        >>> load = Quantity("P", "N/m", "nip load")
        >>> load.text(2500.0), load.text(2500.0, error=12.3)
        ('2500 N/m', '2500 ± 12 N/m')
        """
        known = f" ± {rounded_text(self.shown(float(error)), 2)}" if isfinite(error) else ""
        return f"{self.shown(float(value)):{form}}{known} {self.display}".rstrip()

    def stored_text(self, value: float, form: str = ".4g") -> str:
        """Return an SI value as text in the usual unit, for a text that a result keeps.

        :func:`in_chosen_units` converts such texts when they are displayed.
        """
        unit, size = self._usual()
        return f"{float(value) / size:{form}} {'' if unit == '1' else unit}".rstrip()

    def in_table(self, value: Values) -> tuple[str, Values]:
        """Return unit and value for a table: SI, or the chosen unit."""
        unit, size = self._chosen() or (self.unit, 1.0)
        converted: Any = value / size
        return unit, converted

    @property
    def attributes(self) -> dict[str, str]:
        """SI unit, meaning and symbol as attributes of an xarray variable."""
        return {"units": self.unit, "long_name": self.meaning, "symbol": self.symbol}

    def named(self, path: str) -> Quantity:
        """Return the quantity with the name of its field or output."""
        return _named(self, path)


OF_FIELD = "of the field that holds it"  # in place of a quantity

Range = tuple[float, float] | None
_POSITIONAL = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)


def as_given(values: np.ndarray) -> Any:
    """Return an array, or the number in an array without dimensions, as the argument was given."""
    return values[()]


def rounded_text(value: float, digits: int) -> str:
    """Return a number with so many significant digits, below a million without an exponent.

    >>> rounded_text(234.5, 2), rounded_text(0.01234, 2), rounded_text(2.5e-7, 1)
    ('230', '0.012', '2e-07')
    """
    return f"{float(f'{value:.{digits}g}'):.6g}"


def header(name: str, unit: str) -> str:
    """Return the header of a column of a table: its name with the unit, without that of a number.

    >>> header("load", "N/m"), header("friction", "1")
    ('load [N/m]', 'friction')
    """
    return name if unit in ("", "1") else f"{name} [{unit}]"


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
    """Return a strain or a relative speed, shown in percent [1]."""
    return Quantity(symbol, "1", meaning, "%")


def share(symbol: str, meaning: str, typical: Range = None) -> Quantity:
    """Return a share, a ratio or a relative error, shown in percent [1]."""
    return Quantity(symbol, "1", meaning, "%", typical)


def angle(symbol: str, meaning: str, typical: Range = None) -> Quantity:
    """Return an angle [rad]."""
    return Quantity(symbol, "rad", meaning, "deg", typical)


def line_load(symbol: str, meaning: str, typical: Range = None) -> Quantity:
    """Return a force per metre of width [N/m]."""
    return Quantity(symbol, "N/m", meaning, "", typical)


def tension(symbol: str, meaning: str, typical: Range = None) -> Quantity:
    """Return a tension of the web per metre of width [N/m]; it may be entered as a stress."""
    return Quantity(symbol, "N/m", meaning, "", typical, other_form="stress")


def velocity(meaning: str, typical: Range = None) -> Quantity:
    """Return a speed V [m/s]."""
    return Quantity("V", "m/s", meaning, "m/min", typical)


def pure(symbol: str, meaning: str, typical: Range = None) -> Quantity:
    """Return a pure number [1]."""
    return Quantity(symbol, "1", meaning, "", typical)


@lru_cache(maxsize=4096)
def _named(quantity: Quantity, path: str) -> Quantity:
    """Return a quantity with its name; a walk over a problem names hundreds."""
    return dataclasses.replace(quantity, path=path)


# ---- chosen units -------------------------------------------------------------------------------

Sized = tuple[str, float]  # a unit, and how many SI units it is


class Choice(NamedTuple):
    """Units that the user has chosen.

    Attributes
    ----------
    names : mapping of (str, str) to (str, float)
        (Name of a field or output, SI unit) -> unit, size.
    system : mapping of str to (str, float)
        Unit for display -> unit in its place, size: of all quantities without a chosen name.
    """

    names: Mapping[tuple[str, str], Sized] = MappingProxyType({})
    system: Mapping[str, Sized] = MappingProxyType({})


_DEFAULT = Choice()
_CHOSEN: ContextVar[Choice] = ContextVar("chosen units", default=_DEFAULT)


@contextmanager
def shown_in(choice: Choice) -> Iterator[None]:
    """Display quantities in other units within a context, in addition to those chosen outside."""
    outer = _CHOSEN.get()
    names, system = {**outer.names, **choice.names}, {**outer.system, **choice.system}
    token = _CHOSEN.set(Choice(names, system))
    try:
        yield
    finally:
        _CHOSEN.reset(token)


_NUMBER = r"[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_SENTENCE_DIGITS = 3  # at least: the zeros of "100 mm" may be significant


def in_chosen_units(text: str) -> str:
    """Return a text of a result, such as a warning, with its numbers in the chosen system of units.

    Results keep such texts with the usual units, ``"23.4 mm"``, ``"2 and 3 GPa"``, whatever units
    were chosen when they were solved.  Texts of errors that a report quotes have SI units in
    brackets: ``"5 is out of range; must be >= 1 and <= 2 [m]"``.
    """
    system = _CHOSEN.get().system
    if not system:
        return text
    # a unit of the system; the longest first, because a pattern takes the first one that fits
    names = "|".join(re.escape(name) for name in sorted(system, key=len, reverse=True))
    # several numbers share a unit, as do the value and the bounds in the text of an error
    several = rf"{_NUMBER}(?:(?:, | to | and ){_NUMBER})*"
    permitted = rf"{_NUMBER} is out of range; must be [^;\[\]]*"
    sharing = rf"(?<![\w.])({several}|{permitted}) (\[?)({names})(\]?)(?![\w/^*])"

    def converted(match: re.Match[str]) -> str:
        """Return the match, (numbers) (bracket)(unit)(bracket), in the chosen unit."""
        unit, size = system[match[3]]
        scale = DISPLAYED.get(match[3], ("", 1.0))[1] / size

        def number(digits: re.Match[str]) -> str:
            """Return a number with as many significant digits as it had."""
            mantissa = re.sub(r"e.*|\D", "", digits[0]).lstrip("0")
            count = max(_SENTENCE_DIGITS, len(mantissa))
            return f"{float(digits[0]) * scale:.{count}g}"

        values = re.sub(rf"(?<![\w.]){_NUMBER}", number, match[1])
        return f"{values} {match[2]}{unit}{match[4]}"

    return re.sub(sharing, converted, text)


def pattern(path: str) -> str:
    """Return the path in the class of the path in an instance: ``*`` for the numbers of items."""
    return ".".join("*" if part.isdigit() else part for part in path.split("."))


# ---- fields -------------------------------------------------------------------------------------


class Place(NamedTuple):
    """The position of a quantity in a description or result.

    Attributes
    ----------
    path : str
        Dotted name; items of a list by their number, or by ``*`` in a class.
    quantity : Quantity or None
        None for a field that is not a number: a word, a name, the law of a curve.
    field : object
        Pydantic ``FieldInfo`` of a field of a description; annotation of an output of a result.
    owner : type
        Class of the field or output.
    value : object
        Value in an instance; None in a class.
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


def walk(thing: object, prefix: str = "", of_field: Quantity | None = None) -> Iterator[Place]:
    """Yield every leaf of a description, or every output of a result, in the order of definition.

    Parameters
    ----------
    thing : class or instance
        A description, with nested ones and lists of them (in a class with all members of a family),
        or a result (fields, then properties and methods without arguments).
    prefix : str
        Beginning of every path.
    of_field : Quantity, optional
        Quantity of the field that contains the description, for fields marked ``OF_FIELD``.
    """
    cls = thing if isinstance(thing, type) else type(thing)
    if not hasattr(cls, "model_fields"):
        yield from _walk_outputs(thing, cls, prefix)
        return
    for name, field in cls.model_fields.items():
        path = f"{prefix}{name}"
        quantity = quantity_of(field, of_field)
        if thing is cls:
            yield from _walk_annotation(Place(path, quantity, field, cls))
        else:
            yield from _walk_value(Place(path, quantity, field, cls, getattr(thing, name)))


def numbers_of(description: object) -> dict[str, float]:
    """Return the numbers with a unit in a description by dotted name, without items of lists.

    >>> import woundon as wo
    >>> list(numbers_of(wo.RollerProblem.example().upper.material))
    ['youngs_modulus', 'poissons_ratio']
    """
    return {
        place.path: place.value
        for place in walk(description)
        if isinstance(place.value, float) and place.quantity is not None
    }


def _walk_value(place: Place) -> Iterator[Place]:
    """Yield the value of a field, or the values in the description or descriptions that it is."""
    path, value = place.path, place.value
    if hasattr(type(value), "model_fields"):
        yield from walk(value, f"{path}.", place.quantity)
    elif isinstance(value, tuple) and any(hasattr(type(v), "model_fields") for v in value):
        for k, item in enumerate(value):
            yield from _walk_value(place._replace(path=f"{path}.{k}", value=item))
    else:  # a word in place of a number has no quantity
        quantity = None if isinstance(value, str) else place.quantity
        yield place._replace(quantity=quantity and quantity.named(path))


def _walk_annotation(place: Place) -> Iterator[Place]:
    """Yield a field if it may be a value, then the fields of the descriptions it may contain."""
    annotation = place.field.annotation
    inner = members_of(annotation)
    if not inner or float in get_args(annotation):  # float | Profile is a number or a description
        yield place._replace(quantity=place.quantity and place.quantity.named(place.path))
    part = f"{place.path}.*." if is_list(annotation) else f"{place.path}."
    for model in inner:
        yield from walk(model, part, place.quantity)


def quantity_of(field: FieldInfo, of_field: Quantity | None = None) -> Quantity | None:
    """Return the quantity in the metadata of a pydantic field.

    Fields marked ``OF_FIELD``, such as the values of a profile, have that of the containing field.
    """
    if OF_FIELD in field.metadata:
        return of_field
    return next((part for part in field.metadata if isinstance(part, Quantity)), None)


def members_of(annotation: object) -> tuple[type, ...]:
    """Return the classes of descriptions that an annotation admits, all members of a family."""
    if isinstance(annotation, type) and hasattr(annotation, "model_fields"):
        # the base class of a family, such as the bodies, has a method "members"; others have none
        members: Mapping[str, type] | None = getattr(annotation, "members", lambda: None)()
        return (annotation,) if members is None else tuple(members.values())
    models = (model for part in get_args(annotation) for model in members_of(part))
    return tuple(dict.fromkeys(models))


def is_list(annotation: object) -> bool:
    """Return True if an annotation admits a list or tuple of values or descriptions."""
    if get_origin(annotation) in (tuple, list):
        return True
    return any(is_list(part) for part in get_args(annotation) if get_origin(part) is not None)


# ---- outputs ------------------------------------------------------------------------------------


def output(thing: object, name: str) -> Place | None:
    """Return one output of a result's class or instance, without its value."""
    return next((p for p in outputs(thing) if p.path == name), None)


def outputs(thing: object) -> tuple[Place, ...]:
    """Return the outputs of a result's class or instance, without values."""
    cls = thing if isinstance(thing, type) else type(thing)
    return tuple(_walk_outputs(thing, cls, "", values=False))


def scalar_outputs(thing: object) -> dict[str, Quantity]:
    """Return the quantities of the outputs that are single numbers, by name."""
    return {  # the annotation is Annotated[float, Quantity]
        place.path: place.quantity
        for place in outputs(thing)
        if place.quantity is not None and get_args(place.field)[0] in (float, int)
    }


class on_request(cached_property[Any]):  # noqa: N801
    """An output, or a part with outputs, that is computed when it is used, not in every report."""


def value_of(thing: Any, name: str) -> Any:
    """Return an output's value; a method without arguments is called.

    An output of a missing part, such as ``air.film`` without air, is nan.
    """
    head, _, rest = name.partition(".")
    value = getattr(thing, head)
    if rest:
        return float("nan") if value is None else value_of(value, rest)
    return value() if callable(value) else value


def _walk_outputs(thing: Any, cls: type, prefix: str, values: bool = True) -> Iterator[Place]:
    """Yield the outputs of a result or a class of results, with those of its parts.

    Of an instance, outputs of a part that it does not have (``air.film`` without air) and outputs
    on request are left out, and its attribute ``relabelled`` may replace quantities by name.

    Parameters
    ----------
    thing : result or class
    cls : class
        Of the result.
    prefix : str
        Beginning of every path.
    values : bool
        Whether the values of an instance are read, which may compute them.
    """
    relabelled = {} if thing is cls else getattr(thing, "relabelled", {})
    for name, (quantity, hint) in _annotated(cls, _version(cls)).items():
        part = name.partition(".")[0]
        # "" stands for a part that is no field but a property, which computes it
        missing = part != name and thing is not cls and vars(thing).get(part, "") is None
        if missing or (thing is not cls and is_on_request(cls, part)):
            continue
        value = value_of(thing, name) if values and thing is not cls else None
        quantity = relabelled.get(name, quantity).named(name)
        yield Place(f"{prefix}{name}", quantity, hint, cls, value)


def is_on_request(cls: type, name: str) -> bool:
    """Return True if an output of a class, or the part that has it, is computed on request."""
    return isinstance(getattr(cls, name.partition(".")[0], None), on_request)


def _version(cls: type) -> tuple[tuple[str, int], ...]:
    """Return the identity of the properties and methods of a class, a key for caching.

    Plug-ins may add outputs to a class after it was created.
    """
    return tuple(
        (name, id(attribute))
        for base in cls.__mro__
        for name, attribute in vars(base).items()
        if isinstance(attribute, property) or callable(attribute)
    )


@cache
def _annotated(cls: type, version: object) -> Mapping[str, tuple[Quantity, Any]]:
    """Return quantity and annotation of each output of a class by name; parts have dotted names.

    ``version`` is :func:`_version` of the class, with which the answer is cached.
    """
    hints: dict[str, Any] = {}
    for name, hint in _hints(cls):
        # classes whose fields are outputs of the result that holds them, such as the air film
        parts = [h for h in (hint, *get_args(hint)) if getattr(h, "part_of_result", False)]
        if parts:
            inner = _annotated(parts[0], version)
            hints |= {f"{name}.{part}": part_hint for part, (_, part_hint) in inner.items()}
        elif not name.startswith("_"):
            hints[name] = hint
    return {
        name: (quantity, hint)
        for name, hint in hints.items()
        if (quantity := _quantity_in(hint)) is not None
    }


def _hints(cls: type) -> Iterator[tuple[str, Any]]:
    """Yield name and annotation of the fields of a dataclass, its properties and methods.

    Those of base classes come first, so that a dictionary takes the annotation of the subclass.
    """
    if dataclasses.is_dataclass(cls):
        hints = get_type_hints(cls, include_extras=True)
        yield from ((field.name, hints[field.name]) for field in dataclasses.fields(cls))
    for base in reversed(cls.__mro__):
        for name, attribute in vars(base).items():
            if (hint := _returned(attribute)) is not None:
                yield name, hint


def _returned(attribute: Any) -> Any:
    """Return the annotation of the value of a property, or of a method without required arguments.

    It is None for another attribute.
    """
    if isinstance(attribute, cached_property):
        attribute = property(attribute.func)
    function: Callable[..., Any] | None = (
        attribute.fget if isinstance(attribute, property) else attribute
    )
    hint = getattr(function, "__annotations__", {}).get("return")
    if function is None or hint is None:
        return None
    if isinstance(hint, str):
        try:
            hint = eval(hint, function.__globals__)  # as typing.get_type_hints does, return only
        except NameError:  # a name that type checkers alone import: no quantity
            return None
    parameters = list(signature(function).parameters.values())[1:]  # without self
    required = [p for p in parameters if p.default is p.empty and p.kind in _POSITIONAL]
    return None if required else hint


def _quantity_in(hint: Any) -> Quantity | None:
    """Return the quantity in the metadata of an annotation; None if there is none."""
    if get_origin(hint) is not Annotated:
        return None
    return next((part for part in get_args(hint) if isinstance(part, Quantity)), None)
