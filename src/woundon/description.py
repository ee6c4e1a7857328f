"""The base of every description (material, body, problem): immutable, validated when made.

pydantic does the checking; this module turns its report into :class:`InvalidProblem` texts that
name the field, the value and the admissible range, and gives every description ``replace``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import FrozenInstanceError
from math import inf
from numbers import Real
from reprlib import Repr
from typing import Annotated, Any, NoReturn, Self, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from .errors import InvalidProblem, NoSteadyState, did_you_mean, nearest, one_of

__all__ = ["Description", "Number"]


def _number(value: Any) -> float:
    """Return a real number of any make (int, NumPy scalar, Fraction, 0-d array) as a float.

    Text and truth values are refused: both are slips that pydantic would let pass as numbers.
    """
    of_array = getattr(value, "shape", None) == () and hasattr(value, "dtype")
    kind = getattr(value.dtype, "kind", "") if of_array else ""
    if isinstance(value, bool) or not (isinstance(value, Real) or kind in ("i", "u", "f")):
        raise PydanticCustomError("not_a_number", "is not a number")
    if getattr(value, "mask", False) is not False and bool(value.mask):
        raise PydanticCustomError("not_a_number", "is not a number")
    try:
        return float(value)
    except OverflowError:  # a whole number of more than 308 digits
        return inf if value > 0 else -inf


Number = Annotated[float, BeforeValidator(_number)]


class Description(BaseModel):
    """An immutable, validated description; unknown names and values out of range are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __init__(self, /, **fields: Any) -> None:
        try:
            self.__pydantic_validator__.validate_python(fields, self_instance=self)
        except ValidationError as report:
            raise _readable(report, type(self)) from None

    def __setattr__(self, name: str, value: Any) -> NoReturn:
        """Refuse: a description does not change."""
        raise FrozenInstanceError(
            f"a {type(self).__name__} does not change; make a variant by .replace({name}=...)"
        )

    def __delattr__(self, name: str) -> NoReturn:
        """Refuse: a description does not change."""
        raise FrozenInstanceError(f"a {type(self).__name__} does not change; {name} stays")

    def replace(self, /, **changes: Any) -> Self:
        """Return a variant with some fields changed; nested ones by dotted name.

        >>> problem.replace(nip_load=5e3, **{"web.thickness": 57e-6})  # doctest: +SKIP

        Raises
        ------
        InvalidProblem
            If a name does not exist or the variant is not admissible.
        """
        fields = {name: getattr(self, name) for name in type(self).model_fields}
        nested: dict[str, dict[str, Any]] = {}
        faults: list[tuple[str, str]] = []
        for path, value in changes.items():
            head, dot, rest = path.partition(".")
            if head not in fields:
                faults.append((path or "''", _no_such_field(head, type(self))))
            elif dot and rest:
                nested.setdefault(head, {})[rest] = value
            elif dot:
                faults.append((path, "no field is named behind the dot"))
            else:
                fields[head] = value
        for head, inner in nested.items():
            if not isinstance(fields[head], Description):
                faults += [(f"{head}.{rest}", f"{head} has no fields of its own") for rest in inner]
                continue
            try:
                fields[head] = fields[head].replace(**inner)
            except InvalidProblem as fault:
                faults += fault.under(head).faults
        if faults:
            raise InvalidProblem(faults)
        return type(self)(**fields)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy; changes are validated (pydantic's own copy and copy.replace skip that)."""
        return self.replace(**update) if update else super().model_copy(deep=deep)


def _readable(report: ValidationError, model: type[BaseModel]) -> InvalidProblem:
    """Translate pydantic's report; faults of an inner description come translated already."""
    faults: list[tuple[str, str]] = []
    kind: type[InvalidProblem] = InvalidProblem
    for item in report.errors():
        # nested descriptions validate themselves: only a field, never a path, is ours to name
        path = (str(item["loc"][0]) or "''") if item["loc"] else ""
        inner = item.get("ctx", {}).get("error")
        if isinstance(inner, InvalidProblem):
            faults += inner.under(path).faults
            kind = NoSteadyState if isinstance(inner, NoSteadyState) else kind
        elif item["type"] == "extra_forbidden":
            faults.append((path, _no_such_field(path, model)))
        else:
            faults.append(_fault(path, item, model.model_fields[path]))
    return kind(faults)


def _fault(path: str, item: Any, field: FieldInfo) -> tuple[str, str]:
    """Return (field, text) for one item of pydantic's report."""
    value, kind = item["input"], item["type"]
    if kind == "missing":
        return path, f"missing; must be {_admissible(field)}"
    if kind == "not_a_number":
        hint = " (units are read in case files only)" if isinstance(value, str) else ""
        return path, f"{shown(value)} is not a number; must be {_admissible(field)}{hint}"
    if kind == "finite_number":
        return path, f"{shown(value)} is not a finite number; must be {_admissible(field)}"
    if kind == "literal_error" and path == "kind":
        # a nested body is made by its kind, so here a description was asked to be another one
        return path, (
            f"{shown(value)} is not the kind of this one; must be {_admissible(field)} "
            "(for another kind give the whole description)"
        )
    if kind == "literal_error":
        return path, not_one_of(value, get_args(field.annotation))
    if kind == "union_tag_invalid" and isinstance(value, Mapping):
        return f"{path}.kind", not_one_of(value["kind"], [_kind(m) for m in _models(field)])
    if _models(field):
        return path, f"{shown(value)} is out of place; must be {_admissible(field)}"
    must = f"{_admissible(field)}{_slip(value, field)}"
    return path, f"{shown(value)} is out of range; must be {must}"


def not_one_of(value: Any, known: Iterable[str]) -> str:
    """Return the text for a value that is none of the known words."""
    known = list(known)
    text = f"{shown(value)} is unknown; must be {one_of(map(repr, known))}"
    near = nearest(value, known)
    return f"{text}; did you mean {near!r}?" if near else text


def _no_such_field(name: str, model: type[BaseModel]) -> str:
    """Return the text for a name that ``model`` does not have: who has it, or what was meant."""
    own = {known: field for known, field in model.model_fields.items() if known != "kind"}
    kinds = [m for m in Description.__subclasses__() if "kind" in m.model_fields]
    owners = [m.__name__ for m in kinds if model in kinds and name in m.model_fields]
    if owners:
        return (f"no such field in {model.__name__}, but in {one_of(owners, 'and')}; "
                f"known: {', '.join(own)}")  # fmt: skip
    # the symbol of the formulas ("P"), a word of the description, a part of the name ("friction")
    told = [
        known
        for known, field in own.items()
        if name in str(field.description).replace(",", "").split()
        or (len(name) > 2 and name.lower() in known)
    ]
    if told:
        return f"no such field; did you mean {one_of(map(repr, told))}?"
    return f"no such field{did_you_mean(name, own)}"


# ---- what is admissible, from the field itself ------------------------------------------------


def _models(field: FieldInfo) -> list[type[BaseModel]]:
    """Return the descriptions that a field takes."""

    def within(annotation: Any) -> Iterator[type[BaseModel]]:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            yield annotation
        for part in get_args(annotation):
            yield from within(part)

    return list(within(field.annotation))


def _kind(model: type[BaseModel]) -> str:
    return str(model.model_fields["kind"].default)


def _bounds(field: FieldInfo) -> list[tuple[str, float]]:
    signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    return [(sign, getattr(part, name)) for name, sign in signs.items()
            for part in field.metadata if hasattr(part, name)]  # fmt: skip


def _unit(field: FieldInfo) -> str:
    extra = field.json_schema_extra
    return str(extra.get("unit", "")) if isinstance(extra, dict) else ""


def _admissible(field: FieldInfo) -> str:
    """Return what a field takes: "> 0 and <= 10", "Rigid, HalfPlane or Cylinder", ..."""
    models = _models(field)
    if models:
        names = one_of(model.__name__ for model in models)
        by_name = ", or a name that 'woundon materials' lists" if "Isotropic" in names else ""
        return f"{names} (or a table of its fields{by_name})"
    words = [part for part in get_args(field.annotation) if isinstance(part, str)]
    if words:
        return one_of(map(repr, words))
    unit = _unit(field)
    bounds = " and ".join(f"{sign} {bound:g}" for sign, bound in _bounds(field))
    return (bounds or "a finite number") + (f" [{unit}]" if unit not in ("", "1") else "")


def _slip(value: Any, field: FieldInfo) -> str:
    """Return a hint where the number would be right in another unit (66 for 66 um)."""
    if value < 1:
        return ""
    others = {"m": {"mm": 1e-3, "um": 1e-6}, "1": {"%": 1e-2}}.get(_unit(field), {})
    tests = {">": float.__gt__, ">=": float.__ge__, "<": float.__lt__, "<=": float.__le__}
    fits = [
        f"{value:g} {unit} is {value * factor:g}"
        for unit, factor in others.items()
        if all(tests[sign](value * factor, float(bound)) for sign, bound in _bounds(field))
    ]
    return f" (plain numbers are SI: {', '.join(fits)})" if fits else ""


_repr = Repr()
_repr.maxstring = _repr.maxother = 40


def shown(value: Any) -> str:
    """Return a value as an error text shows it: short, numbers without their type."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return _repr.repr(value)
    try:
        return f"{float(value):.10g}"
    except OverflowError:
        return "a number beyond 1e308"
