"""The base of every description (material, body, problem): immutable, validated when made.

pydantic does the checking; this module turns its report into :class:`InvalidProblem` texts that
name the field, the value and the admissible range, and gives every description ``replace``.

An open set of descriptions (materials, bodies) is a :class:`Family`: whoever subclasses it joins
it, and case files, result files and error texts know the new member.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import FrozenInstanceError
from html import escape
from inspect import Signature
from math import inf, pi
from numbers import Real
from reprlib import Repr
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Generic,
    NoReturn,
    Self,
    TypeVar,
    dataclass_transform,
    get_args,
    overload,
)

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    ValidationError,
    WrapValidator,
    model_serializer,
)
from pydantic.fields import FieldInfo
from pydantic_core import PydanticCustomError

from ..errors import InvalidProblem, NoSteadyState, did_you_mean, nearest, one_of
from ..quantities import (
    Quantity,
    counterpart,
    find,
    is_item,
    members_of,
    quantity_of,
    walk,
)
from .help_texts import documentation, signature
from .inputs import (
    Context,
    FloatWithUnit,
    context_of,
    convert,
    convert_fields,
    in_order,
)
from .permitted import admissible, bounds, unit_of

__all__ = [
    "Description", "Family", "Number", "NumberOfField", "Numbers", "NumbersOfField", "Problem",
    "admissible", "best_match", "bounds", "no_such_field", "not_one_of", "shown",
]  # fmt: skip


def _number(value: Any) -> float:
    """Return a real number of any make (int, NumPy scalar, Fraction, 0-d array) as a float.

    Truth values, and texts that could not be converted, are rejected: pydantic would take both as
    numbers.
    """
    if type(value) is float:  # as nearly all are, of variants too
        return value
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


def _listed(value: Any) -> Any:
    """Return an array of one dimension as a list, which is what a list of numbers is read from."""
    return value.tolist() if hasattr(value, "dtype") and hasattr(value, "tolist") else value


Number = Annotated[float, BeforeValidator(_number)]


def _with_unit(value: Any, handler: Any) -> Any:
    """Validate a number; one that has its unit keeps it."""
    checked = handler(value)
    return value if isinstance(value, FloatWithUnit) else checked


# The values of a schedule: they are in the unit of the field that holds the schedule.
NumberOfField = Annotated[Number, WrapValidator(_with_unit)]

if TYPE_CHECKING:
    Read = TypeVar("Read")
    Write = TypeVar("Write")

    class Given(Generic[Read, Write]):
        """For type checkers: a field that is given as more than what it is read as."""

        @overload
        def __get__(self, instance: None, owner: Any) -> Self: ...
        @overload
        def __get__(self, instance: object, owner: Any) -> Read: ...
        def __get__(self, instance: Any, owner: Any) -> Any: ...
        def __set__(self, instance: Any, value: Write) -> None: ...

    Numbers = Given[tuple[float, ...], Iterable[float | str]]
    NumbersOfField = Numbers
else:
    Numbers = Annotated[tuple[Number, ...], BeforeValidator(_listed)]
    NumbersOfField = Annotated[tuple[NumberOfField, ...], BeforeValidator(_listed)]


if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)


# not frozen_default: a frozen field could not be given as more than what it is read as (Given)
@dataclass_transform(kw_only_default=True)
class Described(ModelMetaclass):
    """How classes of descriptions show themselves to help(), dir() and editors.

    By their fields and their own methods; pydantic's are of no use to who describes a nip.
    """

    @property
    def __doc__(cls) -> str:  # type: ignore[override]  # noqa: N805
        return documentation(cls)

    @property
    def __signature__(cls) -> Signature:  # noqa: N805
        made: Signature = signature(cls)
        return made

    @__signature__.setter
    def __signature__(cls, value: Any) -> None:  # noqa: N805
        pass  # pydantic's, with all its marks

    def __dir__(cls) -> list[str]:  # noqa: N805
        names = set(super().__dir__()) - set(dir(BaseModel))
        return sorted(name for name in names if not name.startswith(("_", "model_")))


class Description(BaseModel, metaclass=Described):
    """An immutable, validated description; unknown names and values out of range are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __dir__(self) -> list[str]:
        return sorted({*dir(type(self)), *type(self).model_fields})

    def __eq__(self, other: object) -> bool:
        if self is other:
            return True
        if type(self) is not type(other):
            return NotImplemented
        # what is cached beside the fields may hold arrays, which do not compare
        return all(getattr(self, name) == getattr(other, name) for name in type(self).model_fields)

    def __init__(self, /, **fields: Any) -> None:
        faults: list[tuple[str, str]] = []
        fields = self._converted(fields, faults)
        try:
            self.__pydantic_validator__.validate_python(fields, self_instance=self)
        except ValidationError as report:
            raise _with_faults(faults, _readable(report, type(self))) from None
        if faults:
            raise _with_faults(faults)

    @classmethod
    def _converted(cls, fields: dict[str, Any], faults: list[tuple[str, str]]) -> dict[str, Any]:
        """Return the fields in the forms that are held; see :mod:`~woundon.problems.inputs`."""
        return convert_fields(cls, fields, faults)

    def __setattr__(self, name: str, value: Any) -> NoReturn:
        """Refuse: a description does not change."""
        raise FrozenInstanceError(
            f"a {type(self).__name__} does not change; make a variant by .replace({name}=...)"
        )

    def __delattr__(self, name: str) -> NoReturn:
        """Refuse: a description does not change."""
        raise FrozenInstanceError(f"a {type(self).__name__} does not change; {name} stays")

    def replace(self, /, **changes: Any) -> Self:
        """Return a variant with some fields changed; nested ones by dotted name, lists by number.

        A value is SI, or a text with its unit; ``diameter`` replaces ``radius``.

        >>> problem.replace(nip_load=5e3, **{"web.thickness": "57 um"})  # doctest: +SKIP

        Raises
        ------
        InvalidProblem
            If a name does not exist or the variant is not admissible.
        """
        fields = {name: getattr(self, name) for name in type(self).model_fields}
        nested: dict[str, dict[str, Any]] = {}
        faults: list[tuple[str, str]] = []
        for path, value in self._changes(changes, faults).items():
            head, dot, rest = path.partition(".")
            if not dot and (radius := counterpart(head, "diameter")) in type(self).model_fields:
                if radius not in changes:
                    del fields[radius]
                fields[head] = value
            elif head not in fields:
                faults.append((path or "''", no_such_field(head, type(self))))
            elif dot and rest:
                nested.setdefault(head, {})[rest] = value
            elif dot:
                faults.append((path, "no field is named behind the dot"))
            else:
                fields[head] = value
        for head, inner in nested.items():
            try:
                fields[head] = _changed(fields[head], head, inner)
            except InvalidProblem as fault:
                faults += fault.under(head).faults
        if faults:
            raise InvalidProblem(faults)
        variant = type(self)(**fields)
        if "_grade" in self.__dict__:  # of a problem that was made with a grade
            variant.__dict__["_grade"] = self.__dict__["_grade"]
        return variant

    def _repr_html_(self) -> str:
        """Return a table of the fields."""
        rows = [
            _cells(place.path, place.quantity, place.value)
            for place in walk(self) if place.value is not None
        ]  # fmt: skip
        cells = "\n".join(
            f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows
        )
        caption = f"<caption><b>{escape(type(self).__name__)}</b></caption>"
        return f"<table>{caption}<tbody>\n{cells}\n</tbody></table>"

    def _changes(self, changes: Mapping[str, Any], faults: list[tuple[str, str]]) -> dict[str, Any]:
        """Return changes by dotted name with texts as numbers in SI."""
        found: dict[str, Any] = dict(changes)
        if not any(isinstance(value, (str, FloatWithUnit)) for value in changes.values()):
            return found
        context = context_of(self)
        for path in in_order(changes):
            name = path.removeprefix("web.")
            if isinstance(changes[path], (str, FloatWithUnit)):
                try:
                    found[path] = self._change(path, changes[path], context)
                except InvalidProblem as fault:
                    faults += fault.faults
                    found.pop(path)
            context = context.with_field(name, found.get(path))
        faults.sort(key=lambda fault: _position(fault[0], changes))
        return found

    def _change(self, path: str, value: str | FloatWithUnit, context: Context) -> Any:
        places = find(type(self), path)
        place = next((p for p in places if p.quantity is not None), None)
        return value if place is None else convert(value, place, context)

    def model_copy(self, *, update: Mapping[str, Any] | None = None, deep: bool = False) -> Self:
        """Return a copy; changes are validated (pydantic's own copy and copy.replace skip that)."""
        return self.replace(**update) if update else super().model_copy(deep=deep)


def _changed(value: Any, name: str, changes: Mapping[str, Any]) -> Any:
    """Return what a field holds with changes below it, by path; of a list by the item's number."""
    if isinstance(value, Description):
        return value.replace(**changes)
    if not isinstance(value, tuple):
        raise InvalidProblem([(path, f"{name} has no fields of its own") for path in changes])
    items = list(value)
    for path, new in changes.items():
        place, dot, rest = path.partition(".")
        if not is_item(place, len(items)):
            text = f"{name} has no item {place!r}; known: 0 to {len(items) - 1}"
            raise InvalidProblem.at(path, text)
        k = int(place)
        try:
            items[k] = _changed(items[k], f"{name}.{place}", {rest: new}) if dot else new
        except InvalidProblem as fault:
            raise fault.under(place) from None
    return tuple(items)


class Family(Description):
    """An open set of descriptions; a direct subclass opens one, the classes below are its members.

    A member is known by the snake-case name of its class (``half_plane``), which files write as
    ``kind``; where none is said, the names of a table's fields give the member away.  A class
    that only helps to define members says so: ``class Helper(Body, abstract=True)``.
    """

    _members: ClassVar[dict[str, type[Family]]]

    def __init_subclass__(cls, abstract: bool = False, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)

    @classmethod
    def __pydantic_init_subclass__(cls, abstract: bool = False, **kwargs: Any) -> None:
        """Open a family, or join one."""
        if Family in cls.__bases__:
            cls._members = {}
        elif not abstract:
            cls._members[cls.member_name()] = cls

    @classmethod
    def members(cls) -> dict[str, type[Family]]:
        """Return the family's members by name; of one of its classes, those that it and its are."""
        return {name: member for name, member in cls._members.items() if issubclass(member, cls)}

    @classmethod
    def member_name(cls) -> str:
        """Return the class's name as files write it."""
        return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).lower()

    @classmethod
    def made(cls, value: Any) -> Any:
        """Return the member that a table describes; anything else as it is.

        Raises
        ------
        InvalidProblem
            For an unknown kind, or whatever the member finds at fault.
        """
        if not isinstance(value, Mapping):
            return value
        table, known = dict(value), cls.members()
        if "kind" not in table:
            return best_match(table, known.values())(**table)
        kind = table.pop("kind")
        if not isinstance(kind, str) or kind not in known:
            raise InvalidProblem.at("kind", not_one_of(kind, known))
        return known[kind](**table)

    @model_serializer(mode="wrap")
    def _with_kind(self, handler: Any) -> dict[str, Any]:
        return {"kind": self.member_name(), **handler(self)}


class Problem(Description):
    """What is solved.  Its kind is known by its class, and in files by the names of its fields.

    Attributes
    ----------
    tables : mapping of str to tuple of str
        Fields that a case file groups in a table of their own, by the table's name.
    graded : tuple of str
        Fields that a ``grade`` supplies: of a problem that has one, ``grade = "newsprint"`` may
        stand in their place.
    """

    tables: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    graded: ClassVar[tuple[str, ...]] = ()

    def __init__(self, /, **fields: Any) -> None:
        super().__init__(**fields)
        if "grade" in fields:
            library = _grades()
            self.__dict__["_grade"] = library.grade(fields["grade"])
            library.warn_of_contradictions(self.named_grade, self)

    @property
    def named_grade(self) -> Any:
        """The :class:`~woundon.Grade` that the problem was made with; None without one."""
        return self.__dict__.get("_grade")

    @classmethod
    def _converted(cls, fields: dict[str, Any], faults: list[tuple[str, str]]) -> dict[str, Any]:
        if "grade" in fields:
            fields = _grades().with_grade(cls, fields, faults)
        return super()._converted(fields, faults)

    @property
    def remarks(self) -> tuple[str, ...]:
        """Inputs that have no effect or contradict each other, as sentences."""
        return ()

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What the model assumes of this case, as sentences."""
        return ()

    @classmethod
    def example(cls) -> Self:
        """Return a case to start from: what ``woundon new`` writes."""
        raise NotImplementedError(f"{cls.__name__} has no example")


def _grades() -> Any:
    from . import grades  # which depend on descriptions

    return grades


def best_match(names: Iterable[str], models: Iterable[type[Any]]) -> type[Any]:
    """Return the class of description whose fields are nearest to the given names.

    A name that it does not have counts two, but one if it is like a field that is not given; a
    field that is missing counts one.  Of equals the first with the fewest fields.
    """
    given = [counterpart(str(name), "diameter") or str(name) for name in names]
    has_grade = "grade" in given
    given = [name for name in given if name not in ("grade", "grades")]

    def misfit(model: type[Any]) -> tuple[int, int]:
        known = set(model.model_fields) | set(getattr(model, "tables", ()))
        strange = [name for name in given if name not in known]
        meant = {nearest(name, known) for name in strange} - {"", *given}
        had = meant.union(given, getattr(model, "graded", ()) if has_grade else ())
        missing = sum(f.is_required() and n not in had for n, f in model.model_fields.items())
        return 2 * len(strange) - len(meant) + missing, len(known)

    return min(models, key=misfit)


def _readable(report: ValidationError, model: type[BaseModel]) -> InvalidProblem:
    """Translate pydantic's report; faults of an inner description come translated already."""
    faults: list[tuple[str, str]] = []
    kind: type[InvalidProblem] = InvalidProblem
    for item in report.errors():
        # nested descriptions validate themselves: only a field, or an item of it, is ours to name
        name, *rest = item["loc"] or ("",)
        items = [str(part) for part in rest if isinstance(part, int)]
        path = ".".join([str(name) or "''", *items]) if item["loc"] else ""
        inner = item.get("ctx", {}).get("error")
        if isinstance(inner, InvalidProblem):
            # what a number is not, a description may nearly be
            faults = [fault for fault in faults if fault[0] != path or not path]
            faults += inner.under(path).faults
            kind = NoSteadyState if isinstance(inner, NoSteadyState) else kind
        elif item["type"] == "extra_forbidden":
            faults.append((path, no_such_field(str(name), model)))
        elif path not in dict(faults) and not _counts_faults(item):
            faults.append((path, _fault(item, model.model_fields[str(name)])))
    return kind(faults)


def _position(field: str, changes: Mapping[str, Any]) -> int:
    """Return which of the changes a fault belongs to."""
    paths = list(changes)
    return next((k for k, path in enumerate(paths) if f"{field}.".startswith(path)), len(paths))


def _with_faults(
    faults: list[tuple[str, str]], report: InvalidProblem | None = None
) -> InvalidProblem:
    """Return the error of inputs that could not be converted, and of what validation rejects."""
    if not faults:
        assert report is not None
        return report
    named = {field for field, _ in faults}
    others = [] if report is None else [fault for fault in report.faults if fault[0] not in named]
    return InvalidProblem([*(fault for fault in faults if fault[1]), *others])


def _counts_faults(item: Any) -> bool:
    """Tell whether a list is called too short for the items of it that are at fault."""
    return item["type"] == "too_short" and len(item["input"]) > item["ctx"]["actual_length"]


def _fault(item: Any, field: FieldInfo) -> str:
    """Return the text for one item of pydantic's report."""
    value, kind = item["input"], item["type"]
    if kind == "missing":
        return f"missing; must be {admissible(field)}"
    if kind == "not_a_number":
        return f"{shown(value)} is not a number; must be {admissible(field)}"
    if kind == "finite_number":
        return f"{shown(value)} is not a finite number; must be {admissible(field)}"
    if kind in ("too_short", "too_long"):
        (limit,) = (n for name, n in item["ctx"].items() if name in ("min_length", "max_length"))
        least = "at least" if kind == "too_short" else "at most"
        return f"{len(value)} values; must be {least} {limit}"
    if kind in ("tuple_type", "list_type"):
        return f"{shown(value)} is not a list"
    if kind == "literal_error":
        return not_one_of(value, get_args(field.annotation))
    if members_of(field.annotation):
        return f"{shown(value)} is out of place; must be {admissible(field)}"
    value = value if isinstance(value, Real) else float(value)  # an array of no dimension
    return f"{shown(value)} is out of range; must be {admissible(field)}{_slip(value, field)}"


def not_one_of(value: Any, known: Iterable[str]) -> str:
    """Return the text for a value that is none of the known words."""
    known = list(known)
    text = f"{shown(value)} is unknown; must be {one_of(map(repr, known))}"
    near = nearest(value, known)
    return f"{text}; did you mean {near!r}?" if near else text


def no_such_field(name: str, model: type[BaseModel]) -> str:
    """Return the text for a name that ``model`` does not have: who has it, or what was meant."""
    own = model.model_fields
    family = model._members.values() if issubclass(model, Family) else ()
    owners = [m.__name__ for m in family if name in m.model_fields]
    if name == "kind" and family:
        return f"not a field; for another kind than {model.__name__} give the whole description"
    if owners:
        return (f"no such field in {model.__name__}, but in {one_of(owners, 'and')}; "
                f"known: {', '.join(own)}")  # fmt: skip
    # the symbol of the formulas ("P"), a word of the meaning, a part of the name ("friction")
    told = [
        known
        for known, field in own.items()
        if name in _words(field) or (len(name) > 2 and name.lower() in known)
    ]
    if told:
        return f"no such field; did you mean {one_of(map(repr, told))}?"
    return f"no such field{did_you_mean(name, own)}"


def _words(field: FieldInfo) -> list[str]:
    quantity = quantity_of(field)
    if quantity is None:
        return []
    return [quantity.symbol, *quantity.meaning.replace(",", "").replace("'s", "").split()]


_OTHER_UNITS = {"m": {"mm": 1e-3, "um": 1e-6}, "1": {"%": 1e-2}, "rad": {"deg": pi / 180}}


def _slip(value: Any, field: FieldInfo) -> str:
    """Return a hint where the number would be right in another unit (66 for 66 um)."""
    if value < 1:
        return ""
    tests = {">": float.__gt__, ">=": float.__ge__, "<": float.__lt__, "<=": float.__le__}
    fits = [
        f"{value:g} {unit} is {value * factor:g}"
        for unit, factor in _OTHER_UNITS.get(unit_of(field), {}).items()
        if all(tests[sign](value * factor, float(bound)) for sign, bound in bounds(field))
    ]
    return f" (plain numbers are SI: {', '.join(fits)})" if fits else ""


def _cells(path: str, quantity: Quantity | None, value: Any) -> tuple[str, str, str, str]:
    """Return what a field is, its symbol, its value and its unit as text."""
    if quantity is None or not isinstance(value, (int, float)):
        return path, "", str(value), ""
    # the meaning of a nested field does not say of which part it is
    label = path if "." in path else quantity.meaning
    return label, quantity.symbol, f"{quantity.shown(value):.6g}", quantity.display


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
