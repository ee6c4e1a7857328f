"""The data files of grades, and of drum covers and materials, and users' files of grades."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from os import PathLike
from pathlib import Path
from typing import Any, Literal, NamedTuple

from ..errors import InvalidProblem, did_you_mean
from .messages import check_names, quote

__all__ = ["Entry", "entry_of", "library", "read_file", "relative_deviation"]

LARGEST_FILE = 10_000_000  # bytes; far above any list of grades


class Entry(NamedTuple):
    """The values of a table by dotted name, their relative standard deviations, their sources."""

    values: dict[str, Any]
    spread: dict[str, float]
    sources: dict[str, str]


@cache
def library(name: Literal["grades", "materials"]) -> Mapping[str, Mapping[str, Any]]:
    """Return the tables of a data file.

    Those of ``grades`` are ``sources`` and ``grades``, those of ``materials``, a small file that
    every process reads, are ``covers`` and ``materials``.
    """
    return tomllib.loads(Path(__file__).with_name(f"{name}.toml").read_text(encoding="utf-8"))


def read_file(path: str | Path) -> dict[str, Any]:
    """Return the tables of a user's file.

    Raises
    ------
    InvalidProblem
        If it cannot be read, or is not a TOML file with a table ``grades``.
    """
    if not isinstance(path, (str, PathLike)):
        raise InvalidProblem.at("path", f"{quote(path)} is out of place; must be a path")
    path = Path(path)
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise InvalidProblem.at(str(path), f"is larger than {LARGEST_FILE} bytes")
        tables = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, UnicodeDecodeError, ValueError, RecursionError) as fault:
        text = getattr(fault, "strerror", None) or str(fault)
        raise InvalidProblem.at(str(path), f"cannot be read as a TOML file: {text}") from None
    known = tables.get("grades")
    if not isinstance(known, dict) or not all(isinstance(grade, dict) for grade in known.values()):
        text = "has no grades; write each as a table, [grades.NAME]"
        raise InvalidProblem.at(str(path), text)
    return known


def entry_of(table: Mapping[str, Any]) -> Entry:
    """Return the values, spreads and sources of a table and of the tables in it.

    A value is written alone, or as a table with ``value``, ``spread`` and ``source``.

    Raises
    ------
    InvalidProblem
        For an entry without a value, an unknown name in it, or a spread that is not a number >= 0.
    """
    entry = Entry({}, {}, {})
    for name, item in _flat_items(table, ""):
        if isinstance(item, Mapping):
            _add_entry(entry, name, item)
        else:
            entry.values[name] = item
    return entry


def _flat_items(table: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    """Yield dotted name and item of a table and of the tables in it that are no entries."""
    check_names(table, prefix)
    for name, item in table.items():
        if isinstance(item, Mapping) and "value" not in item:
            yield from _flat_items(item, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", item


def _add_entry(entry: Entry, name: str, item: Mapping[str, Any]) -> None:
    """Add value, spread and source of an entry of the data file."""
    known = ("value", "spread", "source")
    for key in item:
        if key not in known:
            raise InvalidProblem.at(f"{name}.{key}", f"no such field{did_you_mean(key, known)}")
    entry.values[name] = item["value"]
    spread = relative_deviation(item.get("spread", 0.0), f"{name}.spread")
    if spread:
        entry.spread[name] = spread
    if not isinstance(item.get("source", ""), str):
        raise InvalidProblem.at(f"{name}.source", f"{item['source']!r} is not text")
    if item.get("source"):
        entry.sources[name] = item["source"]


def relative_deviation(value: object, name: str) -> float:
    """Return a relative standard deviation [1]; ``name`` is quoted in the error.

    Raises
    ------
    InvalidProblem
        If it is not a number, or out of range.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value <= 10:
        text = f"{value!r} is not a number >= 0 and <= 10, a relative standard deviation"
        raise InvalidProblem.at(name, text)
    return float(value)
