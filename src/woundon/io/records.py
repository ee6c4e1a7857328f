"""Convert results to records of plain values for files, and back.

A record contains format, schema, version, kind, the problem, the fields of the result with their
dimensions, residuals, error estimates and warnings, and the outputs that are computed from the
fields (for other readers).  Fields with ``metadata={"saved": False}`` are omitted.  A field that is
missing in a record takes its default; an unknown one is ignored with a warning, because the record
may come from a later version.  Damaged records are rejected.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, Field, fields
from math import isfinite, nan
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

from .. import __version__, kinds
from ..errors import InvalidProblem, NotConverged
from ..quantities import scalar_outputs, value_of
from ..results import Residuals, Result, Zone

__all__ = [
    "FORMAT",
    "SCHEMA",
    "Record",
    "from_record",
    "number",
    "plain",
    "saved_hints",
    "saved_values",
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
        "residuals": {name: plain(value, name) for name, value in result.residuals.items()},
        "errors": {name: plain(value, name) for name, value in result.errors.items()},
        "warnings": list(result.warnings),
    }


def saved_fields(cls: type[Any]) -> list[Field[Any]]:
    """Return the fields of the class of a result that a record has under ``fields``."""
    return [f for f in fields(cls) if f.name not in _SEPARATE and f.metadata.get("saved", True)]


def saved_hints(cls: type[Any]) -> dict[str, Any]:
    """Return the types of the saved fields; those of parts have dotted names."""
    parts = _parts(cls)
    hints: dict[str, Any] = {}
    for item in saved_fields(cls):
        if item.name in parts:
            inner = saved_hints(parts[item.name])
            hints |= {f"{item.name}.{name}": hint for name, hint in inner.items()}
        else:
            hints[item.name] = item.type
    return hints


def saved_values(result: Result) -> dict[str, Any]:
    """Return the values of the saved fields; those of parts have dotted names.

    Missing parts are omitted, and empty arrays of fields that have a default.
    """
    values: dict[str, Any] = {}
    parts = _parts(type(result))
    for item in saved_fields(type(result)):
        value = getattr(result, item.name)
        if item.name not in parts:
            values[item.name] = value
        elif value is not None:
            values |= {f"{item.name}.{f.name}": getattr(value, f.name) for f in fields(value)}
    required = {item.name for item in saved_fields(type(result)) if _is_required(item)}
    return {
        name: value
        for name, value in values.items()
        if name in required or not (isinstance(value, np.ndarray) and value.size == 0)
    }


def _is_required(item: Field[Any]) -> bool:
    return item.default is MISSING and item.default_factory is MISSING


def _parts(cls: type[Any]) -> dict[str, type[Any]]:
    """Return the classes of the fields that have outputs of their own, by name."""
    return {
        name: part
        for name, hint in get_type_hints(cls).items()
        for part in get_args(hint)
        if getattr(part, "part_of_result", False)
    }


def plain(value: Any, name: str) -> Any:
    """Return a field as JSON types; nan and infinity become null.

    >>> plain(np.array([1.0, np.nan]), "x")
    [1.0, None]
    """
    if value is None or isinstance(value, (str, bool)):
        return value
    if isinstance(value, np.ndarray):
        return plain(value.tolist(), name)
    if isinstance(value, (list, tuple)):
        return [plain(item, name) for item in value]
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        return float(value) if isfinite(value) else None
    text = f"a {type(value).__name__} cannot be saved; give the field metadata={{'saved': False}}"
    raise InvalidProblem.at(name, text)


def _dimensions(values: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return the names of the dimensions of each array: the first array of each length."""
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


def from_record(record: Record) -> Result:
    """Create the result from a record; all parts are checked."""
    kind = kinds.named(str(record.get("kind")))
    try:
        problem = kind.problem(**record["problem"])
        values = dict(_restore_fields(kind.result, record["fields"], record["dimensions"]))
        residuals = {
            str(name): number(value, f"residuals.{name}", False)
            for name, value in record["residuals"].items()
        }
        errors = {name: number(v, f"errors.{name}", True) for name, v in record["errors"].items()}
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
            for name in scalar_outputs(result):
                value_of(result, name)
    except InvalidProblem:
        raise
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError):
        raise InvalidProblem("is not a result saved by woundon, or is damaged") from None
    return _accepted(result)


def _restore_fields(
    cls: type[Any], saved: Mapping[str, Any], dimensions: Mapping[str, Any]
) -> Iterator[tuple[str, Any]]:
    """Yield the fields of a result by name, with its parts."""
    parts = _parts(cls)
    for name, part in parts.items():
        part_values = {k.partition(".")[2]: v for k, v in saved.items() if k.startswith(f"{name}.")}
        inner = {k.partition(".")[2]: v for k, v in dimensions.items() if k.startswith(f"{name}.")}
        if part_values:
            yield name, part(**dict(_restore_values(part, part_values, inner, {})))
    direct = {k: v for k, v in saved.items() if k.partition(".")[0] not in parts}
    yield from _restore_values(cls, direct, dimensions, {})


def _restore_values(
    cls: type[Any], saved: Mapping[str, Any], dimensions: Mapping[str, Any], sizes: dict[str, int]
) -> Iterator[tuple[str, Any]]:
    """Yield the values of a dataclass by name, except those of parts.

    Parameters
    ----------
    cls : type
    saved : mapping
        Values of the record by name.
    dimensions : mapping
        Names of the dimensions of each array.
    sizes : dict
        Length of each dimension; extended by the dimensions of these arrays.
    """
    hints, parts = get_type_hints(cls, include_extras=True), _parts(cls)
    known = {item.name: item for item in saved_fields(cls) if item.name not in parts}
    # None: nan is admitted in all fields
    may_be_nan: frozenset[str] | None = getattr(cls, "MAY_BE_NAN", frozenset())
    unknown = [str(name) for name in saved if name not in known]
    if unknown:
        text = f"not known to this version of woundon, ignored: {', '.join(unknown)}"
        # points to the caller of load_result <- from_record <- _restore_fields <- this generator
        warnings.warn(text, UserWarning, stacklevel=5)
    for name, item in known.items():
        if name in saved:
            admits_nan = may_be_nan is None or name in may_be_nan
            value = _restore_field(saved[name], hints[name], name, admits_nan)
            if isinstance(value, np.ndarray):
                _check_shape(value, dimensions[name], sizes, name)
            yield name, value
        elif _is_required(item):
            raise InvalidProblem.at(name, "missing")


def _check_shape(value: Array, dimensions: Any, sizes: dict[str, int], name: str) -> None:
    """Reject an array whose shape contradicts the named dimensions."""
    if len(dimensions) != value.ndim:
        raise InvalidProblem.at(name, f"has {value.ndim} dimensions; must be {len(dimensions)}")
    for dimension, size in zip(dimensions, value.shape, strict=True):
        expected = sizes.setdefault(str(dimension), size)
        if size != expected:
            text = f"has {size} values; must be {expected}, as {dimension}"
            raise InvalidProblem.at(name, text)


def _restore_field(value: Any, hint: Any, name: str, admits_nan: bool) -> Any:
    """Return a field of the type of its annotation; it may contain nan if ``admits_nan``."""
    marks = get_args(hint)[1:] if get_origin(hint) not in (None, tuple) else ()
    expected = get_args(hint)[0] if marks else hint
    if expected is np.ndarray:
        return _zones(value, name) if Zone in marks else _array(value, name, admits_nan)
    if expected is float:
        return number(value, name, admits_nan)
    if expected in (int, str) and type(value) is not expected:
        word = "a whole number" if expected is int else "a word"
        raise InvalidProblem.at(name, f"{value!r:.40} is out of place; must be {word}")
    return _items(value, expected)


def _items(value: Any, hint: Any) -> Any:
    """Return lists as tuples, and null among floats as nan."""
    if not isinstance(value, list):
        return nan if value is None and hint is float else value
    inner = get_args(hint) or (Any,)
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
    """Return a list as an array, null as nan."""
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
