"""The forms of all kinds of problem, their outputs, materials, grades and units, for the page.

A description is a validated object: a problem, or a body, a material, a schedule in it.  A family
is an open set of classes of descriptions, its members.  The form of a class lists its fields.
No field or output is named here: the forms follow from the registered kinds, so that a kind of a
plug-in appears on the page too.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from types import NoneType
from typing import Any, Literal, get_args, get_origin

import numpy as np
from pydantic.fields import FieldInfo

from .. import __version__, kinds, plugins
from ..errors import InvalidProblem
from ..io.case_texts import SCHEMA
from ..problems.description import Description
from ..problems.family import Family
from ..problems.fields import FLAGS
from ..problems.grades import grades
from ..problems.materials import MATERIALS, Material
from ..problems.units import MILL, compatible_units, definitions
from ..quantities import OF_FIELD, Quantity, is_list, members_of, outputs, quantity_of
from ..results import Result
from .limits import LIMITS

__all__ = ["catalogue", "limits_of", "quantity_schema", "tables_of"]


# Unit of a field that has the unit of the field that holds it, such as the values of a profile; the
# page looks for this word.
OF_HOLDER = "holder"


@cache
def catalogue() -> dict[str, Any]:
    """Return kinds, forms, materials, units and limits, for JSON."""
    forms: dict[str, Any] = {}
    kind_entries = []
    for kind in kinds.every():
        _add_form(kind.problem, forms)
        kind_entries.append(_kind(kind))
    return {
        "version": __version__,
        "schema": SCHEMA,
        "kinds": kind_entries,
        "forms": forms,
        "materials": [
            {"name": name, "source": known.source, "material": tables_of(known.material)}
            for name, known in MATERIALS.items()
        ],
        "grades": [{"name": name, "title": grade.title} for name, grade in grades().items()],
        "units": _units(forms, kind_entries),
        "unit_definitions": definitions(),
        "systems": {"SI": {}, "mill": MILL},
        "exhibits": [figure for group in plugins.figures() for figure in group.list()],
        "limits": LIMITS,
    }


def tables_of(description: Description) -> dict[str, Any]:
    """Return the tables of a description as in a case file, in SI and without groups."""
    tables: dict[str, Any] = description.model_dump(mode="json", exclude_none=True)
    return tables


# ---- kinds ------------------------------------------------------------------------------------


def _kind(kind: kinds.Kind) -> dict[str, Any]:
    """Return name, form, example, outputs and solver options of a kind of problem, for JSON."""
    try:
        example = tables_of(kind.example())
    except InvalidProblem:
        example = None
    return {
        "name": kind.name,
        "title": _title(kind.name),
        "about": kind.about,
        "has_grades": bool(kind.problem.graded),
        "form": kind.problem.__name__,
        "groups": {name: list(fields) for name, fields in kind.problem.tables.items()},
        "example": example,
        "main": list(kind.result.MAIN),
        "outputs": list(_outputs(kind.result)),
        "exact_sensitivity": hasattr(kind.result, "sensitivity"),
        "options": [
            {
                "name": name,
                "type": option.type.__name__,
                "words": list(option.choices),
                "about": f"{option.help} {option.details}".strip(),
            }
            for name, option in kind.solver_options().items()
        ],
    }


def _outputs(result: type[Result]) -> Iterator[dict[str, Any]]:
    """Yield name, quantity and type of each output of a class of results."""
    for place in outputs(result):
        if place.quantity is not None:
            # of Annotated[kind, quantity, ...], the annotation of an output
            kind, *marks = get_args(place.field)
            yield {
                "name": place.path,
                **quantity_schema(place.quantity),
                "array": kind is np.ndarray,
                # whole numbers have another type in addition to their quantity: zones, counts
                "whole": kind is int
                or any(isinstance(m, type) and issubclass(m, int) for m in marks),
            }


def quantity_schema(quantity: Quantity) -> dict[str, Any]:
    """Return symbol, label and units of a quantity."""
    return {
        "symbol": quantity.symbol,
        "label": quantity.meaning,
        "unit": quantity.unit,
        "shown_unit": quantity.display,
    }


# ---- forms ------------------------------------------------------------------------------------


def _add_form(model: type[Description], forms: dict[str, Any]) -> None:
    """Add the form of a class of descriptions, and those of all classes that its fields admit."""
    name = model.__name__
    if name in forms:
        return
    # the initial entries of lists, such as the table of a radial law: the field's only example
    start = {n: list(f.examples[0]) for n, f in model.model_fields.items() if f.examples}
    forms[name] = {"title": _title(name), "fields": [], "start": start}
    for field_name, field in model.model_fields.items():
        forms[name]["fields"].append(_field(field_name, field))
        for member in members_of(field.annotation):
            _add_form(member, forms)


def _field(name: str, field: FieldInfo) -> dict[str, Any]:
    """Return a field of a form, for JSON: type, unit, limits, default and choices."""
    annotation, quantity = field.annotation, quantity_of(field)
    members = members_of(annotation)
    entry: dict[str, Any] = {
        "name": name,
        "symbol": "",
        "label": field.description or _title(name).lower(),
        "type": _type(annotation),
        "required": field.is_required(),
        "optional": NoneType in get_args(annotation),
        "unit": "",
        "shown_unit": "",
        "typical": None,
        "limits": limits_of(field),
    }
    if not field.is_required():
        default = field.get_default(call_default_factory=True)
        entry["default"] = tables_of(default) if isinstance(default, Description) else default
    if quantity is not None:
        entry |= quantity_schema(quantity)
        entry |= {"typical": quantity.typical, "other_form": quantity.other_form}
    elif OF_FIELD in field.metadata:
        entry |= {"unit": OF_HOLDER, "shown_unit": OF_HOLDER}
    if members:
        families = [m for m in members if issubclass(m, Family)]
        entry["members"] = [
            {
                # identifies a member in a case; a single one needs no name
                "kind": m.member_name() if m in families and len(families) > 1 else None,
                "form": m.__name__,
            }
            for m in members
        ]
        entry["number"] = not is_list(annotation) and float in _parts(annotation)
        entry["named"] = any(issubclass(m, Material) for m in members)
    if words := _literal_words(annotation):
        entry["choices"] = words
    if is_list(annotation):
        entry |= _constraints(field, min_length="min_items", max_length="max_items")
    return entry


def _type(annotation: Any) -> str:
    """Return the type of a form field, from its annotation.

    ``member`` is a form in the form, that of a body, a material or another description, and
    ``members`` a list of them; ``numbers`` is a list of numbers, and ``pairs`` one of pairs of
    numbers; ``choice`` is a field with a list of words; all others are ``number`` or ``text``.
    """
    if members_of(annotation):
        return "members" if is_list(annotation) else "member"
    if is_list(annotation):
        lists = [part for part in _parts(annotation) if get_origin(part) in (tuple, list)]
        return (
            "pairs"
            if any(is_list(item) for each in lists for item in get_args(each))
            else "numbers"
        )
    if _literal_words(annotation):
        return "choice"
    return "number" if float in _parts(annotation) else "text"


def _parts(annotation: Any) -> list[Any]:
    """Return an annotation and all types of which it consists."""
    inner = () if get_origin(annotation) is Literal else get_args(annotation)
    return [annotation, *(part for one in inner for part in _parts(one))]


def _literal_words(annotation: Any) -> list[str]:
    """Return the words that an annotation admits: of a bool, or the values of all Literal types."""
    if annotation is bool:
        return list(FLAGS)
    literals = [part for part in _parts(annotation) if get_origin(part) is Literal]
    return [word for literal in literals for word in get_args(literal)]


def limits_of(field: FieldInfo) -> dict[str, float]:
    """Return the limits of a field: "gt", "ge", "lt", "le"."""
    return _constraints(field, gt="gt", ge="ge", lt="lt", le="le")


def _constraints(field: FieldInfo, **names: str) -> dict[str, float]:
    """Return constraints of a field from its metadata: name there = name in the form."""
    return {
        form_name: getattr(part, name)
        for name, form_name in names.items()
        for part in field.metadata
        if hasattr(part, name)
    }


# ---- words and units --------------------------------------------------------------------------


def _units(forms: Mapping[str, Any], kind_entries: list[Any]) -> dict[str, Any]:
    """Return the units in which each SI unit can be displayed, the smallest first.

    Parameters
    ----------
    forms : mapping
        By name, as of :func:`_add_form`.
    kind_entries : list
        As of :func:`_kind`.
    """
    entries = [field for form in forms.values() for field in form["fields"]]
    entries += [output for kind in kind_entries for output in kind["outputs"]]
    names_of: dict[str, list[str]] = {}  # shown units by SI unit
    for entry in entries:
        if entry["unit"] not in ("", OF_HOLDER):
            # compatible_units knows the pure number, which is shown without a unit, as "1"
            names_of.setdefault(entry["unit"], []).append(entry["shown_unit"] or "1")
    return {
        unit: [
            {"name": name, "factor": size} for name, size in compatible_units(unit, *names).items()
        ]
        for unit, names in names_of.items()
    }


def _title(name: str) -> str:
    """Return a name in snake case or of a class in words.

    >>> _title("web_tension"), _title("HalfPlane")
    ('Web tension', 'Half plane')
    """
    return re.sub(r"(?<!^)(?=[A-Z])", "_", name).replace("_", " ").capitalize()
