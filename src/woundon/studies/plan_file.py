"""STUDY.toml of ``woundon plan``: a base case, unknown fields, measurements and candidates."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..errors import InvalidProblem, did_you_mean
from ..io.case_files import read_case
from .planned import Measurement
from .studyfile import SCHEMA, base_case, flat_names, table_of

__all__ = ["load_plan"]

_KNOWN = (
    "schema",
    "case",
    "unknown",
    "tie",
    "completed",
    "candidate",
    "plan",
    "operating_point",
    "solver",
)
_PLAN = ("count", "criterion", "output", "draws", "seed")
_MEASUREMENT = ("quantity", "at", "standard_deviation", "cost", "case", "fields", "label")


def load_plan(path: str | Path) -> dict[str, Any]:
    """Return the keywords of :func:`~woundon.studies.experiment.next_experiment` in a study file.

    Raises
    ------
    InvalidProblem
        For a file that cannot be read, or fields at fault.
    """
    path = Path(path)
    given = read_case(path)
    _check_names(given, _KNOWN, "")
    if given.get("schema") != SCHEMA:
        raise InvalidProblem.at("schema", f"write 'schema = {SCHEMA}' at the top of the file")
    settings = table_of(given, "plan")
    _check_names(settings, _PLAN, "plan.")
    return {
        "problem": base_case(given.get("case"), path.parent),
        "unknown": flat_names(table_of(given, "unknown")),
        "candidates": _measurements(given, "candidate", path.parent),
        "completed": _measurements(given, "completed", path.parent),
        "operating_point": flat_names(table_of(given, "operating_point")),
        "tie": flat_names(table_of(given, "tie")),
        "options": table_of(given, "solver"),
        **settings,
    }


def _measurements(given: Mapping[str, Any], name: str, folder: Path) -> list[Measurement]:
    """Return the measurements in an array of tables of a study file."""
    tables = given.get(name, [])
    if not isinstance(tables, list) or not all(isinstance(table, Mapping) for table in tables):
        raise InvalidProblem.at(name, f"must be tables; write [[{name}]] above each")
    return [_measurement(table, f"{name}.{k}", folder) for k, table in enumerate(tables)]


def _measurement(table: Mapping[str, Any], where: str, folder: Path) -> Measurement:
    """Return the measurement that a table of a study file describes."""
    _check_names(table, _MEASUREMENT, f"{where}.")
    if "quantity" not in table:
        raise InvalidProblem.at(f"{where}.quantity", "missing; give the name of an output")
    keywords = {name: value for name, value in table.items() if name != "case"}
    for name in ("at", "fields"):
        keywords[name] = flat_names(table_of(table, name))
    if "case" in table:
        keywords["problem"] = base_case(table["case"], folder)
    return Measurement(**keywords)


def _check_names(table: Mapping[str, Any], known: tuple[str, ...], prefix: str) -> None:
    for name in table:
        if name not in known:
            raise InvalidProblem.at(f"{prefix}{name}", f"no such field{did_you_mean(name, known)}")
