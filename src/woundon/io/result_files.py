"""Results to files and back: netCDF (labelled, for xarray), JSON (complete), CSV (the arrays).

A result's fields are read off its dataclass; what they mean and their units come from
:mod:`woundon.quantities`, so that a new field needs no change here.  A file is written aside and
then moved into place: an interrupted write leaves the old file as it was.
"""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Callable
from dataclasses import fields
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import __version__
from .errors import InvalidProblem
from .problems import NipProblem, RollerProblem
from .quantities import QUANTITIES, Quantity
from .results import NipResult, Residuals, RollerResult, Sensitivity, SlipRatios
from .wrap import WrappedNipResult, WrappedResiduals

if TYPE_CHECKING:
    import xarray

__all__ = ["load_result", "result_to_dataset", "result_to_json", "save_result", "writer_for"]

FORMAT = "woundon-result"
SCHEMA = 1

Result = NipResult | RollerResult | WrappedNipResult

_KINDS: dict[str, tuple[type[Any], type[Any]]] = {
    "nip": (NipProblem, NipResult),
    "rollers": (RollerProblem, RollerResult),
    "wrapped_nip": (NipProblem, WrappedNipResult),
}


def save_result(result: Result, path: str | Path) -> None:
    """Write a result to ``.nc``, ``.json`` or ``.csv``, by the path's ending.

    Raises
    ------
    InvalidProblem
        For another ending.
    OSError
        If the file cannot be written.
    """
    path = Path(path)
    content = writer_for(path)(result)
    # written aside: a result is whole or not there
    aside = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        aside.write_bytes(content)
        os.replace(aside, path)
    except OSError as fault:
        raise OSError(fault.errno, fault.strerror, str(path)) from None
    finally:
        aside.unlink(missing_ok=True)


def load_result(path: str | Path) -> Result:
    """Return the result saved in a ``.nc`` or ``.json`` file.

    Raises
    ------
    InvalidProblem
        If the file is no saved result, or of a later format.
    OSError
        If the file cannot be read.
    """
    path = Path(path)
    content = path.read_bytes()
    try:
        record = _record_of_netcdf(content) if path.suffix == ".nc" else json.loads(content)
        if record["format"] != FORMAT or record["schema"] != SCHEMA:
            raise KeyError("format")
        return _from_record(record)
    except InvalidProblem as fault:
        raise fault.under(str(path)) from None
    except (KeyError, TypeError, ValueError):
        raise InvalidProblem(
            [(str(path), f"is no result saved by this version of woundon (schema {SCHEMA})")]
        ) from None


def writer_for(path: str | Path) -> Callable[[Result], bytes]:
    """Return what turns a result into the bytes of the format that the path's ending names.

    Raises
    ------
    InvalidProblem
        For an ending other than .nc, .json, .csv.
    """
    ending = Path(path).suffix
    if ending not in _WRITERS:
        raise InvalidProblem(
            [(str(path), f"the ending {ending!r} names no format; must be {', '.join(_WRITERS)}")]
        )
    return _WRITERS[ending]


# ---- the record: plain dictionaries, lists, numbers and text ----------------------------------


def _to_record(result: Result) -> dict[str, Any]:
    kind = next(name for name, (_, of) in _KINDS.items() if isinstance(result, of))
    record: dict[str, Any] = {
        "format": FORMAT,
        "schema": SCHEMA,
        "version": __version__,
        "kind": kind,
        "problem": result.problem.model_dump(),
    }
    values = {f.name: getattr(result, f.name) for f in fields(result) if f.name != "problem"}
    if isinstance(result, NipResult):
        values["wound_on_tension"] = result.wound_on_tension
    return record | {name: _plain(value) for name, value in values.items()}


def _plain(value: Any) -> Any:
    """Return a field as JSON knows it; what is not a number becomes null."""
    if isinstance(value, (str, int)):
        return value
    if isinstance(value, np.ndarray):
        if np.isnan(value).any():  # slips where the web touches nothing
            return [v if np.isfinite(v) else None for v in value.tolist()]
        return value.tolist()
    if isinstance(value, tuple):
        return list(value)
    if isinstance(value, (SlipRatios, Residuals)):
        return {f.name: _plain(getattr(value, f.name)) for f in fields(value)}
    return float(value) if np.isfinite(value) else None


def _from_record(record: dict[str, Any]) -> Result:
    problem_type, result_type = _KINDS[record["kind"]]
    parts = {
        "slip_ratios": SlipRatios,
        "residuals": WrappedResiduals if result_type is WrappedNipResult else Residuals,
    }
    values = {
        f.name: _restored(f.name, record[f.name], parts)
        for f in fields(result_type)
        if f.name != "problem"
    }
    return result_type(problem=problem_type(**record["problem"]), **values)


def _restored(name: str, value: Any, parts: dict[str, type[Any]]) -> Any:
    if name in parts:
        return parts[name](**{part: _restored(part, v, parts) for part, v in value.items()})
    if name == "warnings":
        return tuple(value)
    if isinstance(value, list):
        array = _numbers(value)
        if array.dtype.kind not in "iuf":
            raise TypeError("not numbers")
        if array.dtype.kind == "i":  # zones
            array = array.astype(np.int8)
        array.setflags(write=False)
        return array
    return nan if value is None else value


def _numbers(values: list[Any]) -> Any:
    """Return a list as an array, null as nan."""
    return np.asarray([nan if v is None else v for v in values])


def result_to_json(result: Result, sensitivity: Sensitivity | None = None) -> str:
    """Return the complete result as JSON text, SI units, with a table of the units.

    With a ``sensitivity``: its derivatives and elasticities too, by output and dotted field name.
    """
    record = _to_record(result)
    if sensitivity:
        record["sensitivity"] = _sensitivity_record(sensitivity)
    record["units"] = {name: _quantity(result, name).unit for name in record if name in QUANTITIES}
    return json.dumps(record, indent=1, allow_nan=False) + "\n"


def _sensitivity_record(sensitivity: Sensitivity) -> dict[str, Any]:
    ordered = sensitivity.sorted()

    def named(table: np.ndarray) -> dict[str, dict[str, float | None]]:
        return {
            output: dict(zip(ordered.parameters, map(_plain, row), strict=True))
            for output, row in zip(ordered.outputs, table, strict=True)
        }

    return {
        "derivatives": named(ordered.derivatives),
        "elasticities": named(ordered.elasticities),
        "zone_change": ordered.zone_change,
    }


# ---- CSV ----------------------------------------------------------------------------------------


def _csv(result: Result) -> bytes:
    arrays = [f.name for f in fields(result) if isinstance(getattr(result, f.name), np.ndarray)]
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([f"{name} [{_quantity(result, name).unit}]" for name in arrays])
    table.writerows(zip(*(getattr(result, name).tolist() for name in arrays), strict=True))
    return text.getvalue().encode("utf-8")


# ---- netCDF -------------------------------------------------------------------------------------


def result_to_dataset(result: Result) -> xarray.Dataset:
    """Return the result as an xarray Dataset along ``x``, every variable with unit and symbol.

    The problem is the attribute ``problem`` (JSON); the certificate is the variable ``residual``
    along ``law``.
    """
    import xarray

    record = _to_record(result)
    variables: dict[str, Any] = {}
    for name, value in record.items():
        if isinstance(value, list) and name in QUANTITIES:
            variables[name] = ("x", _numbers(value), _labels(_quantity(result, name)))
        elif name in QUANTITIES:
            variables[name] = (
                (),
                nan if value is None else value,
                _labels(_quantity(result, name)),
            )
        elif name == "slip_ratios":
            for part, inner in value.items():
                variables[f"slip_ratio_{part}"] = ((), inner, _labels(_quantity(result, part)))
    variables["residual"] = (
        "law",
        list(record["residuals"].values()),
        _labels(_quantity(result, "residual")),
    )
    coordinates = {"x": variables.pop("x"), "law": list(record["residuals"])}
    texts = {name: record[name] for name in record if isinstance(record[name], str)}
    attributes = texts | {
        "schema": SCHEMA,
        "problem": json.dumps(record["problem"]),
        "warnings": json.dumps(record["warnings"]),
    }
    return xarray.Dataset(variables, coordinates, attributes)


def _quantity(result: Result, name: str) -> Quantity:
    """Return what a field means: static rollers slip by a length, rolling ones at a speed."""
    if name == "slip" and isinstance(result, RollerResult) and result.problem.motion == "static":
        name = "static_slip"
    return QUANTITIES[name]


def _labels(quantity: Quantity) -> dict[str, str]:
    return {
        "units": quantity.unit,
        "long_name": quantity.description,
        "symbol": quantity.symbol,
    }


def _netcdf(result: Result) -> bytes:
    # the classic format: read everywhere, written by SciPy alone, the same bytes every time
    return bytes(result_to_dataset(result).to_netcdf(engine="scipy"))


def _record_of_netcdf(content: bytes) -> dict[str, Any]:
    import xarray

    with xarray.open_dataset(io.BytesIO(content), engine="scipy") as data:
        record: dict[str, Any] = {
            str(name): variable.values.tolist() for name, variable in data.variables.items()
        }
        record |= data.attrs
    laws = record.pop("law")
    record["residuals"] = dict(zip(laws, record.pop("residual"), strict=True))
    record["slip_ratios"] = {
        name.removeprefix("slip_ratio_"): value
        for name, value in record.items()
        if name.startswith("slip_ratio_")
    }
    for name in ("problem", "warnings"):
        record[name] = json.loads(record[name])
    return record


_WRITERS: dict[str, Callable[[Result], bytes]] = {
    ".nc": _netcdf,
    ".json": lambda result: result_to_json(result).encode("utf-8"),
    ".csv": _csv,
}
