"""Convert results to records of plain values for files, and back.

A record contains format, schema, version, kind, the problem, the fields of the result with their
dimensions, residuals, error estimates and warnings.  For other readers it also contains the outputs
that are computed from the fields, and the units of all outputs.  Fields with
``metadata={"saved": False}`` are omitted.  A field that is missing in a record takes its default;
an unknown one is ignored with a warning, because the record may come from a later version.  Damaged
records are rejected.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import MISSING, fields
from math import isfinite, nan
from typing import Annotated, Any, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np

from .. import __version__, kinds
from ..errors import InvalidProblem, NotConverged
from ..quantities import outputs, scalar_outputs, value_of
from ..results import Residuals, Result, Zone
from .json_texts import plain

__all__ = [
    "FORMAT",
    "SCHEMA",
    "Record",
    "from_record",
    "is_of_thin_layers",
    "number",
    "saved_fields",
    "saved_values",
    "solved_again",
    "to_record",
]

FORMAT = "woundon-result"
SCHEMA = 5

Array = np.ndarray
Record = dict[str, Any]

_SEPARATE = ("problem", "residuals", "errors", "warnings")  # have their own entries in a record


def to_record(result: Result) -> Record:
    """Return the record of a result.

    Raises
    ------
    InvalidProblem
        For a field of a type that cannot be saved.
    """
    saved = saved_values(result)
    computed = [name for name in scalar_outputs(result) if name not in saved]
    return {
        "format": FORMAT,
        "schema": SCHEMA,
        "version": __version__,
        "kind": kinds.of(result).name,
        "problem": result.problem.model_dump(mode="json"),
        "fields": {name: plain(value, name) for name, value in saved.items()},
        "dimensions": _dimensions(saved),
        "outputs": {name: plain(value_of(result, name), name) for name in computed},
        "residuals": plain(dict(result.residuals.items())),
        "errors": plain(result.errors),
        "warnings": list(result.warnings),
        "units": {place.path: place.quantity.unit for place in outputs(result) if place.quantity},
    }


class SavedField(NamedTuple):
    """A field that a record has under ``fields``.

    Attributes
    ----------
    hint : type
        Its annotation.
    is_required : bool
        Whether it has no default.
    may_be_nan : bool
        Whether its numbers may be nan.
    """

    hint: Any
    is_required: bool
    may_be_nan: bool


def saved_fields(cls: type[Any]) -> dict[str, SavedField]:
    """Return the saved fields of a class of results; those of its parts have dotted names."""
    hints, parts = get_type_hints(cls, include_extras=True), _parts(cls)
    may_be_nan: frozenset[str] | None = getattr(cls, "MAY_BE_NAN", frozenset())  # None: all
    saved: dict[str, SavedField] = {}
    for item in fields(cls):
        name = item.name
        if name in _SEPARATE or not item.metadata.get("saved", True):
            continue
        if name in parts:
            saved |= {f"{name}.{inner}": f for inner, f in saved_fields(parts[name]).items()}
            continue
        is_required = item.default is MISSING and item.default_factory is MISSING
        admits_nan = may_be_nan is None or name in may_be_nan
        saved[name] = SavedField(hints[name], is_required, admits_nan)
    return saved


def _parts(cls: type[Any]) -> dict[str, type[Any]]:
    """Return the classes of the fields that are parts: they have outputs of their own, by name."""
    return {
        name: part
        for name, hint in get_type_hints(cls).items()
        for part in get_args(hint)
        if getattr(part, "part_of_result", False)
    }


def saved_values(result: Result) -> dict[str, Any]:
    """Return the values of the saved fields; those of parts have dotted names.

    Missing parts are omitted, and empty arrays of fields that have a default.
    """
    values: dict[str, Any] = {}
    for name, item in saved_fields(type(result)).items():
        part, _, field = name.rpartition(".")
        owner = getattr(result, part) if part else result
        if owner is None:
            continue
        value = getattr(owner, field)
        if item.is_required or not (isinstance(value, np.ndarray) and value.size == 0):
            values[name] = value
    return values


def _dimensions(values: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return the names of the dimensions of each array.

    A dimension has the name of the first one-dimensional array of its length; if there is none,
    that of the array itself with the number of the axis.
    """
    arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray)}
    dimension_of: dict[int, str] = {}
    for name, array in arrays.items():
        if array.ndim == 1:
            dimension_of.setdefault(array.size, name)
    return {
        name: [dimension_of.setdefault(size, f"{name}_{k}") for k, size in enumerate(array.shape)]
        for name, array in arrays.items()
    }


# ---- from a record ------------------------------------------------------------------------------


def is_of_thin_layers(record: Record) -> bool:
    """Return True for a roll or a winding of version 0.3, which computed them with thin layers."""
    of_roll = record.get("kind") in ("roll", "winding")
    return of_roll and str(record.get("version")).startswith("0.3.")


def solved_again(record: Record) -> Result:
    """Return the solution of the problem of a record, with a warning.

    Raises
    ------
    InvalidProblem, NotConverged
    """
    kind = kinds.named(str(record["kind"]))
    try:
        problem = kind.problem(**record["problem"])
    except (LookupError, TypeError):
        raise InvalidProblem("is not a result saved by woundon, or is damaged") from None
    text = (
        f"the file is of woundon {record['version']}, whose pressures were those of infinitely "
        "thin layers; its problem has been solved again"
    )
    warnings.warn(text, UserWarning, stacklevel=4)
    result: Result = kind.solver(problem)
    return result


def from_record(record: Record) -> Result:
    """Create the result from a record; all parts are checked."""
    kind = kinds.named(str(record.get("kind")))
    try:
        problem = kind.problem(**record["problem"])
        values = _restore_fields(kind.result, record["fields"], record["dimensions"])
        residuals = {
            str(name): number(value, f"residuals.{name}", admits_nan=False)
            for name, value in record["residuals"].items()
        }
        errors = {
            name: number(value, f"errors.{name}", admits_nan=True)
            for name, value in record["errors"].items()
        }
        notes = tuple(str(text) for text in record["warnings"])
        result = kind.result(
            problem=problem,
            residuals=Residuals(**residuals),
            errors=errors,
            warnings=notes,
            **values,
        )
        _check_nodes(result)
        with np.errstate(all="ignore"):
            for name in scalar_outputs(result):  # raises if damaged fields do not give the output
                value_of(result, name)
    except InvalidProblem:
        raise
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError):
        raise InvalidProblem("is not a result saved by woundon, or is damaged") from None
    return _accepted(result)


def _restore_fields(
    cls: type[Any], saved: Mapping[str, Any], dimensions: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the fields of a result, with its parts, by name.

    Parameters
    ----------
    cls : type
        Class of the result.
    saved : mapping
        Values of the record by name; those of parts have dotted names.
    dimensions : mapping
        Names of the dimensions of each array.
    """
    known = saved_fields(cls)
    unknown = [str(name) for name in saved if name not in known]
    if unknown:
        text = f"not known to this version of woundon, ignored: {', '.join(unknown)}"
        # points to the caller of load_result <- from_record <- this function
        warnings.warn(text, UserWarning, stacklevel=4)
    present = {name.rpartition(".")[0] for name in saved}
    sizes: dict[str, int] = {}  # of the dimensions
    values: dict[str, dict[str, Any]] = {"": {}}  # by part; "" is the result itself
    for name, item in known.items():
        part, _, field = name.rpartition(".")
        if name in saved:
            value = _restore_field(saved[name], item, name)
            if isinstance(value, np.ndarray):
                _check_shape(value, dimensions[name], sizes, name)
            values.setdefault(part, {})[field] = value
        elif item.is_required and (not part or part in present):
            raise InvalidProblem.at(name, "missing")
    direct, parts = values.pop(""), _parts(cls)
    return direct | {part: parts[part](**inner) for part, inner in values.items()}


def _check_shape(value: Array, dimensions: Any, sizes: dict[str, int], name: str) -> None:
    """Reject an array whose shape contradicts the named dimensions.

    ``sizes`` has the sizes of the dimensions of the arrays before; those of this one are added.
    """
    if len(dimensions) != value.ndim:
        raise InvalidProblem.at(name, f"has {value.ndim} dimensions; must be {len(dimensions)}")
    for dimension, size in zip(dimensions, value.shape, strict=True):
        expected = sizes.setdefault(str(dimension), size)
        if size != expected:
            text = f"has {size} values; must be {expected}, as {dimension}"
            raise InvalidProblem.at(name, text)


def _restore_field(value: Any, item: SavedField, name: str) -> Any:
    """Return a value of the type of the annotation of its field."""
    is_marked = get_origin(item.hint) is Annotated
    expected, *marks = get_args(item.hint) if is_marked else (item.hint,)
    if expected is np.ndarray:
        return _zones(value, name) if Zone in marks else _array(value, name, item.may_be_nan)
    if expected is float:
        return number(value, name, item.may_be_nan)
    if expected in (int, str) and type(value) is not expected:
        word = "a whole number" if expected is int else "a word"
        raise InvalidProblem.at(name, f"{value!r:.40} is out of place; must be {word}")
    return _items(value, expected)


def _items(value: Any, hint: Any) -> Any:
    """Return the lists of a value as tuples, and null as nan where its type hint has a float.

    >>> _items([[0.5, "a"], [None, "b"]], tuple[tuple[float, str], ...])
    ((0.5, 'a'), (nan, 'b'))
    """
    if not isinstance(value, list):
        return nan if value is None and hint is float else value
    inner = get_args(hint) or (Any,)
    # tuple[float, str] has a hint for each item, tuple[float, ...] one for all
    hints = inner if len(inner) == len(value) and ... not in inner else inner[:1] * len(value)
    return tuple(map(_items, value, hints))


def number(value: Any, name: str, admits_nan: bool) -> float:
    """Return a number of a record, null as nan if ``admits_nan``; reject other values.

    >>> number(None, "half_width", admits_nan=True)
    nan
    """
    if value is None and admits_nan:
        return nan
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise InvalidProblem.at(name, f"{value!r:.40} is not a finite number")
    return float(value)


def _array(values: Any, name: str, admits_nan: bool) -> Array:
    """Return a list, or a list of lists, of numbers as an array; reject others.

    Null is nan if ``admits_nan``, else it is rejected.
    """
    parts = np.asarray(values)
    numeric = parts.dtype.kind in "iuf" or all(
        part is None or type(part) in (int, float) for part in parts.ravel().tolist()
    )
    array = np.asarray(values, dtype=float) if numeric and parts.ndim else None
    if array is None or np.isinf(array).any() or (not admits_nan and np.isnan(array).any()):
        raise InvalidProblem.at(name, "must be a list of finite numbers")
    return array


def _zones(values: Any, name: str) -> Array:
    """Return an array of zones; reject other values."""
    parts = np.asarray(values)
    if parts.dtype.kind not in "iu" or not np.isin(parts, list(Zone)).all():
        raise InvalidProblem.at(name, "must be a list of zones, -1, 0 or 1")
    return parts.astype(np.int8)


def _check_nodes(result: Result) -> None:
    """Reject nodes that do not increase."""
    x = getattr(result, "x", None)
    if isinstance(x, np.ndarray) and not (x.size > 2 and np.all(np.diff(x) > 0)):
        raise InvalidProblem.at("x", "must be increasing, of three values or more")


def _accepted(result: Result) -> Result:
    """Return a result whose certificate is satisfied."""
    try:
        return result.checked()
    except NotConverged as fault:
        raise InvalidProblem.at("residuals", str(fault)) from None
