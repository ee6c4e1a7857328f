"""Save and load results: netCDF (labelled, for xarray), JSON (complete), CSV (export only).

The record of a result (:mod:`.records`) is saved; labels and units come from the quantities, so
that a new field, output or kind needs no change here.
"""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InvalidProblem, NotConverged
from ..quantities import outputs, scalar_outputs, value_of
from ..results import Result
from . import seals
from .datasets import record_of_netcdf, to_netcdf
from .files import check_ending, read_whole, write_whole
from .frames import to_csv
from .json_texts import plain
from .records import FORMAT, SCHEMA, Record, from_record, number, to_record

if TYPE_CHECKING:
    from ..sensitivity import Sensitivity

__all__ = ["load_result", "save_result", "to_json", "writer_for"]

MAX_BYTES = 1_000_000_000


def save_result(result: Result, path: str | PathLike[str]) -> None:
    """Save a result as ``.nc``, ``.json`` or ``.csv``.

    netCDF and JSON files are complete and contain a ``sha256`` that detects changes; CSV files are
    for spreadsheets and cannot be loaded.

    Raises
    ------
    InvalidProblem
        For another suffix, or a field of a type that cannot be saved.
    OSError
        If the file cannot be written; an existing file is unchanged.
    """
    write_whole(path, writer_for(path)(result))


def load_result(path: str | Path) -> Result:
    """Return the result saved in a netCDF or JSON file.

    The ``sha256`` in the file must be that of its content, and all arrays must have the shapes and
    units of the result.  The residuals are recomputed from the problem and the arrays and must be
    within the limits of a solution; the outputs in the file must be those that the arrays give.
    The nips of a winding are solved again by :meth:`woundon.WindingResult.recomputed_nips` only.

    Parameters
    ----------
    path : path

    Raises
    ------
    InvalidProblem
        If the file cannot be read, is not a saved result, is damaged or changed, or if the
        residuals exceed their limits.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import woundon as wo
    >>> path = pathlib.Path(tempfile.mkdtemp(), "rollers.nc")
    >>> result = wo.solve(wo.RollerProblem.example(), nodes=33)
    >>> result.save(path)
    >>> wo.load_result(path).half_width == result.half_width
    True
    """
    content = read_whole(path, MAX_BYTES)
    if Path(path).suffix == ".csv":
        text = "is a table for spreadsheets; load the .nc or .json file of the result"
        raise InvalidProblem.at(str(path), text)
    try:
        record = _read(content)
        result = from_record(record)
        _check_units(record, result)
        _verify(record, result)
    except InvalidProblem as fault:
        raise InvalidProblem.at(str(path), str(fault).replace("\n", "; ")) from None
    return result


def writer_for(path: str | PathLike[str]) -> Callable[[Result], bytes]:
    """Return the function that converts a result to the file format of the suffix of a path.

    Raises
    ------
    InvalidProblem
        For a suffix other than .nc, .json, .csv.
    """
    return _WRITERS[check_ending(path, _WRITERS)]


# ---- reading ------------------------------------------------------------------------------------


def _read(content: bytes) -> Record:
    """Return the record in the content of a file after checking its SHA-256."""
    try:
        if content[:3] == b"CDF":  # the classic format of netCDF
            sealed = seals.check_bytes(content)
            record = record_of_netcdf(content)
        else:
            record = _record_of_json(content)
            sealed = seals.check_record(record)
        schema = record["schema"]
        if not all(isinstance(record.get(part, {}), dict) for part in ("units", "outputs")):
            raise TypeError("no table")
    except InvalidProblem:
        raise
    except Exception:  # the readers of JSON and netCDF raise many types for damaged files
        raise InvalidProblem("is not a result saved by woundon, or is damaged") from None
    if schema != SCHEMA:
        text = f"{schema!r} is unknown; this version of woundon reads {SCHEMA}"
        raise InvalidProblem.at("schema", text)
    if not sealed:
        text = "missing; the file was not written by result.save, or has changed since"
        raise InvalidProblem.at(seals.NAME, text)
    return record


def _record_of_json(content: bytes) -> Record:
    """Return the record in a JSON file."""

    def refuse(word: str) -> None:  # called for NaN and Infinity, which Python writes into JSON
        raise ValueError(f"{word} is not JSON")

    record = json.loads(content, parse_constant=refuse)
    if record["format"] != FORMAT:
        raise ValueError("another format")
    return dict(record)


def _check_units(record: Record, result: Result) -> None:
    """Reject a file in which an output has another unit."""
    for place in outputs(result):
        expected = place.quantity.unit if place.quantity else "1"
        unit = record.get("units", {}).get(place.path, expected)
        if unit != expected:
            raise InvalidProblem.at(place.path, f"is in {unit!r:.40}; must be in {expected!r}")


def _verify(record: Record, result: Result) -> None:
    """Recompute the residuals, and compare the outputs with those of the fields.

    Raises
    ------
    InvalidProblem
        If the residuals exceed their limits, or outputs differ.
    """
    try:
        with np.errstate(all="ignore"):
            with contextlib.suppress(NotImplementedError):  # the kind has no certificate
                result.replace(residuals=result.certified()).checked()
            _check_scalars(record, result)
    except (NotConverged, ArithmeticError, LookupError, TypeError, ValueError) as fault:
        raise InvalidProblem(f"the contents of the file do not match: {fault}") from None


def _check_scalars(record: Record, result: Result) -> None:
    """Compare the outputs in the file with those computed from the arrays."""
    saved = record.get("outputs", {})
    # by name: number in the file, number computed from the arrays, absolute tolerance
    expected = {
        name: (number(saved[name], name, admits_nan=True), value_of(result, name), 0.0)
        for name in scalar_outputs(result)
        if name in saved
    }
    expected |= {
        name: (getattr(result, name), *computed) for name, computed in result.recomputed().items()
    }
    for name, (stored, computed_value, tolerance) in expected.items():
        if np.isinf(computed_value):  # files hold null for it
            computed_value = np.nan
        # other versions of NumPy may add in another order
        if not np.isclose(stored, computed_value, rtol=1e-9, atol=tolerance, equal_nan=True):
            raise InvalidProblem.at(name, f"{stored!r:.40}, but the arrays give {computed_value!r}")


# ---- JSON ---------------------------------------------------------------------------------------


def to_json(result: Result, sensitivity: Sensitivity | None = None) -> str:
    """Return the complete result as JSON text in SI units, with the units by name.

    A ``sensitivity`` adds derivatives and elasticities, by output and dotted name of the field.
    """
    record = to_record(result)
    if sensitivity is not None:
        record["sensitivity"] = _sensitivity_record(sensitivity)
    record[seals.NAME] = seals.of_record(record)
    return json.dumps(record, indent=1, allow_nan=False) + "\n"


def _sensitivity_record(sensitivity: Sensitivity) -> Record:
    """Return the derivatives and elasticities of a sensitivity, by output and field."""
    ordered = sensitivity.sorted()
    tables = {"derivatives": ordered.derivatives, "elasticities": ordered.elasticities}
    record: Record = {
        name: {
            output: dict(zip(ordered.parameters, plain(row), strict=True))
            for output, row in zip(ordered.outputs, table, strict=True)
        }
        for name, table in tables.items()
    }
    return record | {"zone_change": ordered.zone_change}


_WRITERS: dict[str, Callable[[Result], bytes]] = {
    ".nc": to_netcdf,
    ".json": lambda result: to_json(result).encode("utf-8"),
    ".csv": to_csv,
}
