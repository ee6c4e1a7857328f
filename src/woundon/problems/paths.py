"""Dotted names of fields: ``web.thickness``, ``drum.layers.0.thickness``, ``roll.diameter``.

A name is looked up in a class (:func:`find_places`), in a description (:func:`get_field`,
:func:`change_fields`) or in the tables of a case (:func:`set_in_tables`, :func:`nest_tables`).
Items of a list are named by their number, and a diameter may be named in place of a radius.

A description is a validated object: a problem, a body, a material (:mod:`.description`).  A place
is the field that a name denotes in one class of descriptions (:class:`~woundon.quantities.Place`).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any

from pydantic import BaseModel

from ..errors import InvalidProblem, did_you_mean
from ..quantities import Place, Quantity, is_list, members_of, quantity_of
from .inputs import Inputs, NotANumber, is_array, read_number, real_number
from .messages import no_such_field, quote
from .units import parse

__all__ = [
    "change_fields",
    "counterpart",
    "field_or_none",
    "field_quantity",
    "find_places",
    "get_field",
    "halve_diameters",
    "is_part_of",
    "models_at",
    "names_above",
    "nest_tables",
    "number_in_si",
    "parts_of",
    "quantity_of_field",
    "set_in_tables",
    "varied_number",
    "varied_value",
]

Faults = list[tuple[str, str]]  # dotted name of a field, and the text of the error
Described = type[BaseModel] | BaseModel  # a class of descriptions, or one of them
Holder = tuple[type[Any], Quantity | None]  # a class, and the quantity of the field that holds it


def parts_of(path: str) -> list[str]:
    """Return the parts of a dotted name.

    >>> parts_of("drum.layers.0.thickness")
    ['drum', 'layers', '0', 'thickness']

    Raises
    ------
    InvalidProblem
        If it is not text.
    """
    if not isinstance(path, str):
        raise InvalidProblem.at(quote(path), "not the name of a field; must be text")
    return path.split(".")


# ---- in a class ---------------------------------------------------------------------------------


def find_places(thing: Described, path: str, of_field: Quantity | None = None) -> tuple[Place, ...]:
    """Return the places of a dotted name in the class of a description; () if it does not exist.

    Fields of all bodies and materials that the class admits are included, and those of all items
    of a list.  A name that ends at a description gives the places of its field, and a diameter that
    of the field of the radius.

    Parameters
    ----------
    thing : class or instance
        A description.
    path : str
        Items of a list by number, or by ``*`` for any of them.
    of_field : Quantity, optional
        Quantity of the field that contains the description, for the values of a schedule.

    Examples
    --------
    >>> import woundon as wo
    >>> [place.owner.__name__ for place in find_places(wo.NipProblem, "roll.core_radius")]
    ['Cylinder', 'WoundRoll']
    >>> find_places(wo.NipProblem, "web.thickness")[0].quantity.display
    'um'
    """
    *_, places = _places_of_parts(thing, path, of_field)
    return places


def _places_of_parts(
    thing: Described, path: str, of_field: Quantity | None = None
) -> Iterator[tuple[Place, ...]]:
    """Yield the places of the first part of a dotted name, of the first two parts, ...

    A part is looked up in all classes that the field above it admits: a body may be a cylinder or
    a wound roll.  The number of an item of a list has the places of the list itself.
    """
    holders: list[Holder] = [(thing if isinstance(thing, type) else type(thing), of_field)]
    places: tuple[Place, ...] = ()
    parts = parts_of(path)
    for k, name in enumerate(parts):
        is_item = name == "*" or (name.isascii() and name.isdecimal())
        if not (is_item and places and is_list(places[0].field.annotation)):
            places = tuple(_places_of_name(holders, name, ".".join(parts[: k + 1])))
            holders = [(m, p.quantity) for p in places for m in members_of(p.field.annotation)]
        # of an item, places and holders remain those of its list
        yield places


def _places_of_name(holders: list[Holder], name: str, path: str) -> Iterator[Place]:
    """Yield the places of a name in several classes; of a diameter, those of the radius.

    Parameters
    ----------
    holders : list of (class, Quantity or None)
        Classes, each with the quantity of the field that holds it, for the values of a schedule.
    name, path : str
        Last part of a dotted name, and the complete name.
    """
    owners = [holder for holder in holders if name in holder[0].model_fields]
    for model, of_field in owners:
        field = model.model_fields[name]
        quantity = quantity_of(field, of_field)
        yield Place(path, quantity and quantity.named(path), field, model)
    radius = counterpart(name, "diameter")  # "", which no class has, for any other name
    for model, _ in holders:
        if not owners and radius in model.model_fields:
            field = model.model_fields[radius]
            yield Place(path, _diameter(quantity_of(field)), field, model)


def _diameter(radius: Quantity | None) -> Quantity | None:
    """Return the quantity of the diameter that may be given instead of a radius."""
    if radius is None:
        return None
    symbol = radius.symbol.replace("R", "D", 1).replace("r", "d", 1)  # R0: D0, r_c: d_c
    typical = radius.typical and (2 * radius.typical[0], 2 * radius.typical[1])
    meaning = radius.meaning.replace("radius", "diameter").replace("radii", "diameters")
    return dataclasses.replace(radius, symbol=symbol, meaning=meaning, typical=typical)


def models_at(thing: Described, path: str) -> tuple[type[Any], ...]:
    """Return the classes of the descriptions that the field of a dotted name admits."""
    return _members(find_places(thing, path))


def _members(places: Iterable[Place]) -> tuple[type[Any], ...]:
    """Return the classes of the descriptions that the fields at places admit."""
    return tuple(model for place in places for model in members_of(place.field.annotation))


def field_quantity(thing: Described, path: str) -> Quantity | None:
    """Return the quantity of a field; None if it is not a number.

    The field may be one of another body or material than the present one.

    Raises
    ------
    InvalidProblem
        If there is no such field.
    """
    places = find_places(thing, path)
    if not places:
        _check_exists(thing, path)
    return next((place.quantity for place in places if place.quantity is not None), None)


def quantity_of_field(thing: Described, path: str) -> Quantity:
    """Return the quantity of a field that is a number."""
    quantity = field_quantity(thing, path)
    if quantity is None:
        name = (thing if isinstance(thing, type) else type(thing)).__name__
        raise AttributeError(f"{path} of a {name} has no quantity")
    return quantity


def _check_exists(thing: Described, path: str) -> None:
    """Raise an error if a dotted name is not a field.

    The parts of the name are followed from the class of the description downwards.  A place is the
    field that a part names in one class: a part has several where a field admits several bodies or
    materials, and none if no class has such a field.

    Raises
    ------
    InvalidProblem
        Names the field with a suggestion.
    """
    models: tuple[type[Any], ...] = (thing if isinstance(thing, type) else type(thing),)
    above = models[0].__name__
    for name, places in zip(parts_of(path), _places_of_parts(thing, path), strict=True):
        if not models:  # the field above holds a value, not a description
            raise InvalidProblem.at(path, _nothing_below(above))
        if not places and len(models) == 1:
            raise InvalidProblem.at(path, no_such_field(name, models[0]))
        if not places:
            known = {field for model in models for field in model.model_fields}
            raise InvalidProblem.at(path, f"no such field{did_you_mean(name, known)}")
        models, above = _members(places), name


def counterpart(name: str, word: str) -> str:
    """Return the radius of a diameter's name (``core.diameter``), or the reverse; '' for none.

    Parameters
    ----------
    name : str
    word : "diameter" or "radius"
        The word that is replaced.
    """
    opposite = {"diameter": "radius", "radius": "diameter"}[word]
    head, match, tail = name.rpartition(word)
    is_word = not head or head.endswith(("_", "."))
    return head + opposite if match and not tail and is_word else ""


def halve_diameters(
    model: type[BaseModel], values: Mapping[str, Any], faults: Faults
) -> dict[str, Any]:
    """Return values by name with radii in place of the diameters that a class does not have.

    Parameters
    ----------
    model : type
        Class of a description.
    values : mapping
        Diameters are numbers [m], texts with a unit, or lists of them.
    faults : list
        Receives (field, text) for a diameter that is not a length, or next to its radius.
    """
    if model.model_fields.keys() >= values.keys():  # no diameter among them
        return dict(values)
    radii = dict(values)
    for name in values:
        radius = counterpart(name, "diameter")
        if name in model.model_fields or radius not in model.model_fields:
            continue
        diameter = radii.pop(name)
        if radius in values:
            faults.append((name, f"is given together with {radius}; give one of the two"))
            continue
        count = len(faults)
        radii[radius] = _half(diameter, name, faults)
        if len(faults) > count:
            del radii[radius]
            faults.append((radius, ""))  # an empty text: no further error that it is missing
    return radii


def _half(diameter: Any, name: str, faults: Faults) -> float | list[float] | None:
    """Return the radius of a diameter, or of each diameter in a list [m].

    Diameters that are not lengths are added to ``faults``, (field, text).
    """
    diameters = diameter.tolist() if is_array(diameter) else diameter
    if not isinstance(diameters, (list, tuple)):
        return _half_of_one(diameters, name, faults)
    radii = [_half_of_one(item, f"{name}.{k}", faults) for k, item in enumerate(diameters)]
    return [radius for radius in radii if radius is not None]


def _half_of_one(diameter: Any, name: str, faults: Faults) -> float | None:
    """Return the radius of a number [m] or of a text with a unit; None for a fault."""
    try:
        with suppress(NotANumber):  # a text; parse rejects anything else
            diameter = real_number(diameter)
        return parse(diameter, "m", name) / 2
    except InvalidProblem as fault:
        faults += fault.faults
        return None


def is_part_of(name: str, path: str) -> bool:
    """Return True if a dotted name is ``path``, or names a part of it.

    >>> is_part_of("web.material.shear", "web.material"), is_part_of("web_tension", "web")
    (True, False)
    """
    return f"{name}.".startswith(f"{path}.")


def names_above(path: str) -> list[str]:
    """Return the names of the descriptions and lists that contain a field, the outermost first.

    >>> names_above("drum.layers.0.thickness")
    ['drum', 'drum.layers', 'drum.layers.0']
    """
    parts = parts_of(path)
    return [".".join(parts[:k]) for k in range(1, len(parts))]


# ---- in a description ---------------------------------------------------------------------------


def get_field(base: BaseModel, path: str) -> Any:
    """Return the value of a field: nested ones by dotted name, items of a list by number.

    Raises
    ------
    InvalidProblem
        If ``base`` has no such field, with a suggestion.

    Examples
    --------
    >>> import woundon as wo
    >>> get_field(wo.RollerProblem.example(), "upper.diameter")
    0.5
    """
    value: Any = base
    above = type(base).__name__
    for name in parts_of(path):
        try:
            value, above = _inner(value, name), name
        except KeyError:
            raise InvalidProblem.at(path, _no_inner(value, name, above)) from None
    return value


def number_in_si(base: BaseModel, path: str, value: str | float, where: str = "") -> float:
    """Return a value of a field that is a number in SI; a text is read with its unit.

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
    quantity = field_quantity(base, path)
    if quantity is None:
        raise InvalidProblem.at(where or path, f"{value!r} is given, but {path} is not a number")
    return read_number(value, quantity, where or path, Inputs.of(base))


def varied_value(base: BaseModel, path: str, where: str = "") -> float | None:
    """Return the value in SI of a field that a study varies; None if the field is not set.

    Parameters
    ----------
    base : Description
    path : str
    where : str
        Name of the field in an error message; the path by default.

    Raises
    ------
    InvalidProblem
        If there is no such field, or its value is not a number: a material, a schedule, a word.
    """
    value = get_field(base, path)
    if field_quantity(base, path) is None or not isinstance(value, float | None):
        text = f"{quote(value)} is not a number, so it cannot be varied"
        raise InvalidProblem.at(where or path, text)
    return value


def varied_number(
    base: BaseModel, path: str, where: str = "", *, is_relative: bool = False
) -> float:
    """Return the value in SI of a field that a study varies around this value.

    Parameters
    ----------
    base : Description
    path : str
    where : str
        Name of the field in an error message; the path by default.
    is_relative : bool
        Whether the study varies the field by a share of its value, which must then be > 0.

    Raises
    ------
    InvalidProblem
        As of :func:`varied_value`, and for a field that is not set.

    Examples
    --------
    >>> import woundon as wo
    >>> varied_number(wo.RollerProblem.example(), "upper.diameter")
    0.5
    """
    value = varied_value(base, path, where)
    if value is None:
        raise InvalidProblem.at(where or path, "is not set, so it cannot be varied")
    if is_relative and value <= 0:
        text = f"{quote(value)} is out of range; must be > 0 to have a relative standard deviation"
        raise InvalidProblem.at(where or path, text)
    return value


def field_or_none(base: BaseModel, path: str) -> Any:
    """Return the value of a field; None if the description, or one in it, has no such field."""
    value: Any = base
    for name in parts_of(path):
        try:
            value = _inner(value, name)
        except KeyError:
            return None
    return value


def _inner(value: Any, name: str) -> Any:
    """Return the field of a description, or the item of a list, with that name.

    Raises
    ------
    KeyError
        If there is none.
    """
    if isinstance(value, tuple) and _is_item(name, len(value)):
        return value[int(name)]
    fields = getattr(type(value), "model_fields", {})
    if name in fields:
        return getattr(value, name)
    radius = counterpart(name, "diameter")
    if radius not in fields:
        raise KeyError(name)
    held = getattr(value, radius)  # a radius, several, or None
    if isinstance(held, tuple):
        return tuple(2 * r for r in held)
    return None if held is None else 2 * held


def _no_inner(value: Any, name: str, above: str) -> str:
    """Return the message for a name below a value; ``above`` is the name of the value."""
    if isinstance(value, tuple):
        return _no_item(name, len(value))
    if isinstance(value, BaseModel):
        return no_such_field(name, type(value))
    return _nothing_below(above)


def _nothing_below(name: str) -> str:
    return f"{name} has no fields of its own"


def _no_item(name: str, count: int) -> str:
    known = f"known: 0 to {count - 1}" if count else "it is empty"
    return f"no item {name!r} in this list; {known}"


def _is_item(name: str, count: int) -> bool:
    """Return True if a part of a dotted name is the number of an item in a list of ``count``."""
    # Python limits the digits of int(), and isdecimal() admits digits of other scripts.
    return name.isascii() and name.isdecimal() and len(name) < 10 and int(name) < count


def _index_of(name: str, items: list[Any], path: str) -> int:
    """Return the index of the item of a list with that name; ``path`` is quoted in the error."""
    if not _is_item(name, len(items)):
        raise InvalidProblem.at(path, _no_item(name, len(items)))
    return int(name)


def change_fields(base: BaseModel, changes: Mapping[str, Any], faults: Faults) -> dict[str, Any]:
    """Return the fields of a description with changes by dotted name, for its constructor.

    Parameters
    ----------
    base : Description
    changes : mapping
        New values; descriptions and lists with changes below them are replaced by variants.
    faults : list
        Receives (field, text) for every name that does not exist.
    """
    fields = {name: getattr(base, name) for name in type(base).model_fields}
    nested: dict[str, dict[str, Any]] = {}
    for path, value in changes.items():
        head, dot, rest = path.partition(".")
        if not dot and (radius := counterpart(head, "diameter")) in type(base).model_fields:
            if radius not in changes:  # the constructor rejects both
                del fields[radius]
            fields[head] = value
        elif head not in fields:
            faults.append((path or "''", no_such_field(head, type(base))))
        elif dot and rest:
            nested.setdefault(head, {})[rest] = value
        elif dot:
            faults.append((path, "the name of a field is missing after the dot"))
        else:
            fields[head] = value
    # the web first: its new thickness converts tensions that are given as stresses
    for head in sorted(nested, key=lambda head: head != "web"):
        with Inputs(type(base), fields, Inputs.current()) as inputs:
            inputs.field = head  # the descriptions below read the quantity of this field
            try:
                fields[head] = _changed(fields[head], head, nested[head])
            except InvalidProblem as fault:
                faults += fault.under(head).faults
    return fields


def _changed(value: Any, name: str, changes: Mapping[str, Any]) -> Any:
    """Return the value of a field, a description or a list, with changes below it.

    Parameters
    ----------
    value : object
    name : str
        Of the field, for the error message.
    changes : mapping
        New values by the dotted names below the field: ``{"0.thickness": 0.01}`` of a list.
    """
    if isinstance(value, BaseModel):
        return value.replace(**changes)  # type: ignore[attr-defined]  # of a Description
    if not isinstance(value, tuple):
        raise InvalidProblem([(path, _nothing_below(name)) for path in changes])
    items = list(value)
    for path, new in changes.items():
        number, dot, rest = path.partition(".")
        k = _index_of(number, items, path)
        try:
            items[k] = _changed(items[k], number, {rest: new}) if dot else new
        except InvalidProblem as fault:
            raise fault.under(number) from None
    return tuple(items)


# ---- in the tables of a case --------------------------------------------------------------------


def set_in_tables(tables: dict[str, Any], path: str, value: object, model: type[BaseModel]) -> None:
    """Set a field in the tables of a case, which are changed; tables above it are added.

    Parameters
    ----------
    tables : dict
        Of a problem, as in a case file.
    path : str
        Name of a field, or of one in a table that groups fields (``wrap.roll_wrap``).
    value : object
        None unsets the field.
    model : type
        Class of the problem.

    Raises
    ------
    InvalidProblem
        If a part of the name is not a table or an item of a list, or a field that is unset does
        not exist.
    """
    *heads, leaf = parts_of(path)
    inner: Any = tables
    # not strict: the places of the leaf are left over
    for head, places in zip(heads, _places_of_parts(model, path), strict=False):
        if value is None and isinstance(inner, dict) and head not in inner:
            inner = {}  # the table is not given, so there is nothing to unset
            break
        inner = _table_below(inner, head, _members(places), path)
    if isinstance(inner, list):
        inner[_index_of(leaf, inner, path)] = value
        return
    if leaf not in inner:
        for word in ("diameter", "radius"):  # a diameter replaces a given radius, and the reverse
            inner.pop(counterpart(leaf, word), None)
    if value is not None:
        inner[leaf] = value
    elif leaf in inner:
        del inner[leaf]
    elif not _is_group(
        path, {"schema": (), **getattr(model, "tables", {})}
    ):  # which are no fields of the class
        _check_exists(model, path)


def _is_group(path: str, groups: Mapping[str, tuple[str, ...]]) -> bool:
    """Return True if a name is that of a table that groups fields, or of a field in one."""
    group, dot, name = path.partition(".")
    return group in groups and (not dot or name in groups[group])


def _table_below(table: Any, name: str, models: tuple[type[Any], ...], path: str) -> Any:
    """Return the table, or the list, of a name in a table or a list of tables.

    One that is missing in a table is added.

    Parameters
    ----------
    table : dict or list
    name : str
        Name, or number of an item.
    models : tuple of types
        Classes of the descriptions that the field admits, which may have names as materials do.
    path : str
        Complete dotted name, for the error message.
    """
    key: Any = _index_of(name, table, path) if isinstance(table, list) else name
    inner = table[key] if isinstance(table, list) else table.setdefault(name, {})
    if isinstance(inner, str):
        # the name of a material is replaced by its fields, so that one of them can be changed
        inner = table[key] = _named_fields(inner, name, models)
    if not isinstance(inner, (dict, list)):
        raise InvalidProblem.at(path, _nothing_below(name))
    return inner


def _named_fields(text: str, name: str, models: tuple[type[Any], ...]) -> Any:
    """Return the fields of the description that a text names; the text itself if it names none."""
    for model in models:
        try:
            named = model.coerce(text) if hasattr(model, "coerce") else text
        except InvalidProblem as fault:
            raise fault.under(name) from None
        if isinstance(named, BaseModel):
            return named.model_dump()
    return text


def nest_tables(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of fields by dotted name; items of a list, named by numbers, as a list.

    >>> nest_tables({"web.thickness": 66e-6, "drum.layers.0.thickness": 0.01})
    {'drum': {'layers': [{'thickness': 0.01}]}, 'web': {'thickness': 6.6e-05}}

    Raises
    ------
    InvalidProblem
        If a field is below another one that has a value.
    """
    tables: dict[str, Any] = {}
    for path, value in sorted(fields.items()):  # a table comes before the fields in it
        *heads, leaf = parts_of(path)
        inner = tables
        for k, head in enumerate(heads):
            inner = inner.setdefault(head, {})
            if not isinstance(inner, dict):
                above = ".".join(heads[: k + 1])
                text = f"has no fields of its own in a table without case: {above} has a column"
                raise InvalidProblem.at(path, text)
        inner[leaf] = value
    return {name: _numbered_to_lists(value) for name, value in tables.items()}


def _numbered_to_lists(table: Any) -> Any:
    """Return tables with the names "0", "1", ... as lists."""
    if not isinstance(table, dict):
        return table
    inner = {name: _numbered_to_lists(value) for name, value in table.items()}
    if inner and all(name.isdecimal() for name in inner):
        return [inner[name] for name in sorted(inner, key=int)]
    return inner
