"""Texts of validation errors of descriptions: field, value and permitted range.

A description is an object that pydantic validates: a problem, a body, a material.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from numbers import Real
from reprlib import Repr
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from ..errors import InvalidProblem, NoSteadyState, did_you_mean, nearest, one_of
from ..quantities import DISPLAYED, members_of, quantity_of
from .inputs import FloatWithUnit, NotAList, NotANumber, read_text
from .permitted import admissible, admits, in_brackets, unit_of

__all__ = [
    "check_names",
    "no_such_field",
    "not_one_of",
    "out_of_range",
    "quote",
    "validation_error",
]


def validation_error(
    model: type[BaseModel], report: ValidationError | None, faults: list[tuple[str, str]]
) -> InvalidProblem:
    """Return the error of a description that is not valid.

    Parameters
    ----------
    model : type
        Class of the description.
    report : pydantic.ValidationError or None
        Values that pydantic rejects.
    faults : list of (str, str)
        Field and text of inputs that could not be converted.  They replace what pydantic reports
        on the same fields; an empty text only suppresses its report.
    """
    error = InvalidProblem(()) if report is None else _translate(report, model)
    if not faults:
        return error
    replaced = {field for field, _ in faults}
    rejected = [fault for fault in error.faults if fault[0] not in replaced]
    return InvalidProblem([*(fault for fault in faults if fault[1]), *rejected])


def _translate(report: ValidationError, model: type[BaseModel]) -> InvalidProblem:
    """Translate the errors of pydantic, except those of nested descriptions."""
    faults: list[tuple[str, str]] = []
    error: type[InvalidProblem] = InvalidProblem
    for item in report.errors():
        # Nested descriptions validate themselves: the location is a field, or an item of its list.
        name, *rest = item["loc"] or ("",)
        field = model.model_fields.get(str(name))
        is_table = field is not None and get_origin(field.annotation) is Mapping
        items = [str(part) for part in rest if isinstance(part, int) or is_table]
        path = ".".join([str(name) or "''", *items]) if item["loc"] else ""
        inner = item.get("ctx", {}).get("error")
        if isinstance(inner, InvalidProblem):
            # pydantic reports every member of a union (number or description); the nested
            # description's own report is the one that helps.
            faults = [fault for fault in faults if fault[0] != path or not path]
            faults += inner.under(path).faults
            error = NoSteadyState if isinstance(inner, NoSteadyState) else error
        elif item["type"] == "extra_forbidden":
            faults.append((path, no_such_field(str(name), model)))
        elif not item["loc"]:  # a name with characters that UTF-8 does not have
            faults.append((item["input"], no_such_field(item["input"], model)))
        # only the first error of a field
        elif field is not None and path not in dict(faults) and not _counts_faults(item):
            faults.append((path, _fault(item, str(name), field)))
    return error(faults)


def _counts_faults(item: Any) -> bool:
    """Return True if a list is only too short because pydantic omits its invalid items."""
    count = len(item["input"]) if isinstance(item["input"], (list, tuple)) else 0
    return item["type"] == "too_short" and count > item["ctx"]["actual_length"]


_OTHER_TYPES = {
    "string_type": "text",
    "string_unicode": "text",
    "dict_type": "a table",
    "float_type": "a number",
    "float_parsing": "a number",
}


def _fault(item: Any, name: str, field: FieldInfo) -> str:
    """Return the text for one item of pydantic's report on a field of that name."""
    value, kind, error = item["input"], item["type"], item.get("ctx", {}).get("error")
    if isinstance(error, NotANumber):
        return f"{quote(value)} is not a number; must be {admissible(field)}"
    if kind == "missing":
        return f"missing; must be {admissible(field)}"
    if kind == "finite_number":
        return f"{quote(value)} is not a finite number; must be {admissible(field)}"
    if kind in ("too_short", "too_long"):
        # the context has one of the two names
        (limit,) = (n for name, n in item["ctx"].items() if name in ("min_length", "max_length"))
        bound = "at least" if kind == "too_short" else "at most"
        return f"{item['ctx']['actual_length']} values; must be {bound} {limit}"
    if kind == "tuple_type" or isinstance(error, NotAList):
        return f"{quote(value)} is not a list"
    if kind in _OTHER_TYPES:
        return f"{quote(value)} is out of place; must be {_OTHER_TYPES[kind]}"
    if kind == "literal_error":
        return not_one_of(value, get_args(field.annotation))
    if members_of(field.annotation):
        return f"{quote(value)} is out of place; must be {admissible(field)}"
    if isinstance(value, (str, FloatWithUnit)):
        value = read_text(value, name)
    value = value if isinstance(value, Real) else float(value)  # an array of no dimension
    hint = _other_unit_hint(value, unit_of(field), partial(admits, field))
    return f"{quote(value)} is out of range; must be {admissible(field)}{hint}"


def check_names(table: Iterable[object], prefix: str = "") -> None:
    """Reject a table with a name that is not text; ``prefix`` precedes it in the error.

    Raises
    ------
    InvalidProblem
    """
    wrong = [f"{prefix}{quote(name)}" for name in table if not isinstance(name, str)]
    if wrong:
        raise InvalidProblem((name, "not the name of a field; must be text") for name in wrong)


def not_one_of(value: object, known: Iterable[str | int]) -> str:
    """Return the message for a value that is not one of the known words."""
    known = list(known)
    text = f"{quote(value)} is unknown; must be {one_of(map(repr, known))}"
    suggestion = nearest(value, [word for word in known if isinstance(word, str)])
    return f"{text}; did you mean {suggestion!r}?" if suggestion else text


def no_such_field(name: str, model: type[BaseModel]) -> str:
    """Return the message for an unknown field, with the class that has it or the intended name.

    In this order: another member of the family has the field (a body, a law); another kind of
    problem has it; the name is the symbol, a word of the meaning or a part of a field's name; a
    field has a similar name.
    """
    fields = model.model_fields
    family = getattr(model, "_members", {}).values()  # empty if the class is of no family
    names = {name, name.replace("diameter", "radius")}
    owners = [m.__name__ for m in family if names & m.model_fields.keys()]
    if name == "kind" and family:
        return f"not a field; for another kind than {model.__name__} give the whole description"
    if owners:
        return (
            f"no such field in {model.__name__}, but in {one_of(owners, 'and')}; "
            f"known: {', '.join(fields)}"
        )
    if name in (counterparts := getattr(model, "counterparts", {})):
        return f"no such field in {model.__name__}: {counterparts[name]}"
    # The user may know the symbol ("P"), a word of the meaning, or a part of the name ("friction").
    similar = [
        known
        for known, field in fields.items()
        if name in _words(field) or (len(name) > 2 and name.lower() in known)
    ]
    if similar:
        return f"no such field; did you mean {one_of(map(repr, similar))}?"
    return f"no such field{did_you_mean(name, fields)}"


def _words(field: FieldInfo) -> list[str]:
    """Return symbol and words of the meaning of a field, for the search of similar names."""
    quantity = quantity_of(field)
    if quantity is None:
        return []
    return [quantity.symbol, *quantity.meaning.replace(",", "").replace("'s", "").split()]


# by the unit of a field, those in which its numbers are often meant
_OTHER_UNITS = {"m": ("mm", "um"), "1": ("%",), "rad": ("deg",)}


def out_of_range(value: float, low: float, high: float, unit: str) -> str:
    """Return the message for a number that is not from low to high, all in the SI unit."""
    hint = _other_unit_hint(value, unit, lambda number: low <= number <= high)
    must = f"must be >= {low:g} and <= {high:g}{in_brackets(unit)}"
    return f"{quote(value)} is out of range; {must}{hint}"


def _other_unit_hint(value: Any, unit_of_field: str, permits: Callable[[float], bool]) -> str:
    """Return a hint if the number is in range in another unit (66 for 66 um)."""
    if abs(value) < 1:  # 66 looks like um, 66e-6 does not
        return ""
    in_si = {unit: value * DISPLAYED[unit][1] for unit in _OTHER_UNITS.get(unit_of_field, ())}
    fits = [f"{value:g} {unit} is {number:g}" for unit, number in in_si.items() if permits(number)]
    return f" (plain numbers are SI: {', '.join(fits)})" if fits else ""


_repr = Repr()
_repr.maxstring = _repr.maxother = 40


def quote(value: object) -> str:
    """Return a value as text for a message: short, numbers without their type."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return _repr.repr(value)
    try:
        return f"{float(value):.10g}"
    except OverflowError:
        return "a number beyond 1e308"
