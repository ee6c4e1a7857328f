"""Save and load results: netCDF (labelled, for xarray), JSON (complete), CSV (export only).

The record of a result (:mod:`.records`) is saved; labels and units come from the quantities, so
that a new field, output or kind needs no change here.
"""

from __future__ import annotations

import contextlib
import csv
import io
import json
from collections.abc import Callable
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import __version__, kinds
from ..errors import InvalidProblem, NotConverged
from ..quantities import Quantity, outputs, scalar_outputs, value_of, walk
from ..results import Result
from . import seals
from .files import read_whole, write_whole
from .records import (
    FORMAT,
    SCHEMA,
    Record,
    from_record,
    number,
    plain,
    saved_hints,
    saved_values,
    to_record,
)
from .spreadsheets import as_csv_cell

if TYPE_CHECKING:
    import xarray

    from ..sensitivity import Sensitivity

__all__ = ["load_result", "save_result", "to_dataset", "to_json", "writer_for"]

MAX_BYTES = 1_000_000_000


def save_result(result: Result, path: str | Path) -> None:
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


def load_result(path: str | Path) -> Any:
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


def writer_for(path: str | Path) -> Callable[[Result], bytes]:
    """Return the function that converts a result to the file format of the suffix of a path.

    Raises
    ------
    InvalidProblem
        For a suffix other than .nc, .json, .csv.
    """
    ending = Path(path).suffix
    if ending not in _WRITERS:
        text = f"the ending {ending!r} is not a known format; must be {', '.join(_WRITERS)}"
        raise InvalidProblem.at(str(path), text)
    return _WRITERS[ending]


# ---- reading ------------------------------------------------------------------------------------


def _read(content: bytes) -> Record:
    """Return the record in the content of a file after checking its SHA-256."""
    try:
        if content[:3] == b"CDF":
            sealed = seals.check_bytes(content)
            record = _record_of_netcdf(content)
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

    def refuse(word: str) -> None:
        raise ValueError(f"{word} is not JSON")

    record = json.loads(content, parse_constant=refuse)
    if record["format"] != FORMAT:
        raise ValueError("another format")
    return dict(record)


def _check_units(record: Record, result: Result) -> None:
    """Reject a file in which an output has another unit."""
    for name, quantity in _quantities(result).items():
        unit = record.get("units", {}).get(name, quantity.unit)
        if unit != quantity.unit:
            raise InvalidProblem.at(name, f"is in {unit!r:.40}; must be in {quantity.unit!r}")


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
    expected = {
        name: (number(saved[name], name, True), value_of(result, name), 0.0)
        for name in scalar_outputs(result)
        if name in saved
    }
    expected |= {
        name: (getattr(result, name), *computed) for name, computed in result.recomputed().items()
    }
    for name, (stored, computed_value, tolerance) in expected.items():
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
    record["units"] = {name: quantity.unit for name, quantity in _quantities(result).items()}
    record[seals.NAME] = seals.of_record(record)
    return json.dumps(record, indent=1, allow_nan=False) + "\n"


def _sensitivity_record(sensitivity: Sensitivity) -> Record:
    """Return the derivatives and elasticities of a sensitivity for JSON."""
    ordered = sensitivity.sorted()

    def named(table: np.ndarray) -> dict[str, dict[str, float | None]]:
        """Return a table with the names of outputs and fields."""
        return {
            output: dict(zip(ordered.parameters, plain(row, output), strict=True))
            for output, row in zip(ordered.outputs, table, strict=True)
        }

    return {
        "derivatives": named(ordered.derivatives),
        "elasticities": named(ordered.elasticities),
        "zone_change": ordered.zone_change,
    }


def _quantities(result: Result) -> dict[str, Quantity]:
    return {place.path: place.quantity for place in outputs(result) if place.quantity is not None}


# ---- CSV ----------------------------------------------------------------------------------------


def _csv(result: Result) -> bytes:
    """Return scalars as comments, ``# name [unit],value``, followed by the arrays in columns.

    Fields of the problem come first, then outputs and their error estimates.  Arrays of another
    length than the first one are omitted; ``pandas.read_csv(path, comment="#")`` reads the columns.
    """
    known = _quantities(result)
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([f"# woundon {__version__}", kinds.of(result).name])
    for place in walk(result.problem):
        if place.value is not None:
            _write_scalar(table, place.path, place.quantity, place.value)
    for name, quantity in scalar_outputs(result).items():
        _write_scalar(table, name, quantity, value_of(result, name))
    for name, error in result.errors.items():
        if f"{name}_error" not in known:
            _write_scalar(table, f"{name}_error", known.get(name), error)
    for note in result.warnings:
        table.writerow(["# warning", as_csv_cell(note)])
    arrays = {
        name: value for name, value in saved_values(result).items() if isinstance(value, np.ndarray)
    }
    first = next(iter(arrays.values()), np.empty(0))
    columns = {name: array for name, array in arrays.items() if array.shape == first.shape[:1]}
    cells = [_in_table(name, known.get(name), array) for name, array in columns.items()]
    table.writerow(header for header, _ in cells)
    table.writerows(zip(*(array.tolist() for _, array in cells), strict=True))
    return text.getvalue().encode("utf-8")


def _write_scalar(table: Any, name: str, quantity: Quantity | None, value: Any) -> None:
    """Write a number or a text as a comment."""
    header, converted = _in_table(name, quantity, value)
    table.writerow([f"# {header}", as_csv_cell(converted)])


def _in_table(name: str, quantity: Quantity | None, value: Any) -> tuple[str, Any]:
    """Return the header of a column with its unit, and the values in this unit."""
    if quantity is None:
        return name, value
    unit, converted = quantity.in_table(value)
    return f"{name} [{unit}]", converted


# ---- netCDF -------------------------------------------------------------------------------------


def to_dataset(result: Result) -> xarray.Dataset:
    """Return the result as an xarray Dataset; all variables have unit, name and symbol.

    The dimension of the arrays is the first one (``x``); ``residual`` has the dimension
    ``condition``; error estimates are variables such as ``half_width_error``; the problem is the
    attribute ``problem`` (JSON).

    >>> import woundon as wo
    >>> to_dataset(wo.solve(wo.RollerProblem.example(), nodes=33)).half_width.attrs["units"]
    'm'

    """
    import xarray

    record, known = to_record(result), _quantities(result)
    variables: dict[str, Any] = {}
    attributes = {name: record[name] for name in ("format", "schema", "version", "kind")}
    attributes |= {name: json.dumps(record[name]) for name in ("problem", "warnings")}
    attributes["errors"] = json.dumps(list(record["errors"]))
    for name, value in (record["fields"] | record["outputs"]).items():
        dims = record["dimensions"].get(name, ())
        if isinstance(value, str):
            attributes[name] = value
            continue
        if isinstance(value, list) and not dims:  # a tuple
            attributes[name] = json.dumps(value)
            continue
        data = np.asarray(value_of(result, name)) if dims else nan if value is None else value
        variables[name] = (dims, data, _labels(known.get(name)))
    for name, error in result.errors.items():
        variables.setdefault(f"{name}_error", ((), error, _error(known.get(name))))
    variables["residual"] = (
        "condition",
        list(record["residuals"].values()),
        _labels(known["residual"]),
    )
    names = {dim for dims in record["dimensions"].values() for dim in dims}
    coordinates = {name: variables.pop(name) for name in list(variables) if name in names}
    return xarray.Dataset(
        variables, coordinates | {"condition": list(record["residuals"])}, attributes
    )


def _labels(quantity: Quantity | None) -> dict[str, str]:
    """Return unit, meaning and symbol of a quantity as attributes."""
    if quantity is None:
        return {}
    return {"units": quantity.unit, "long_name": quantity.meaning, "symbol": quantity.symbol}


def _error(quantity: Quantity | None) -> dict[str, str]:
    """Return the labels of the error estimate of an output."""
    if quantity is None:
        return {}
    meaning = f"estimated discretisation error: {quantity.meaning}"
    return {"units": quantity.unit, "long_name": meaning, "symbol": f"{quantity.symbol} error"}


def _netcdf(result: Result) -> bytes:
    """Return a result as the bytes of a netCDF file."""
    # the classic format can be read everywhere, needs SciPy only and is reproducible
    data = to_dataset(result).assign_attrs({seals.NAME: seals.BLANK})
    return seals.sealed_bytes(bytes(data.to_netcdf(engine="scipy")))


def _record_of_netcdf(content: bytes) -> Record:
    """Return the record in a netCDF file, in the form of that in a JSON file."""
    import xarray

    # without decoding, a unit of time would become a date
    with xarray.open_dataset(io.BytesIO(content), engine="scipy", decode_times=False) as data:
        values = {str(name): _null(v.values.tolist()) for name, v in data.variables.items()}
        dimensions = {str(name): list(v.dims) for name, v in data.variables.items()}
        units = {
            str(name): v.attrs["units"] for name, v in data.variables.items() if "units" in v.attrs
        }
        attributes = {str(name): _item(value) for name, value in data.attrs.items()}
    if attributes["format"] != FORMAT:
        raise ValueError("another format")
    attributes.pop(seals.NAME, None)
    heads = ("format", "schema", "version", "kind")
    record: Record = {name: attributes.pop(name) for name in heads}
    record |= {name: json.loads(attributes.pop(name)) for name in ("problem", "warnings")}
    record["residuals"] = dict(zip(values.pop("condition"), values.pop("residual"), strict=True))
    record["units"] = units
    cls = kinds.named(str(record["kind"])).result
    hints = saved_hints(cls)
    known = {place.path for place in outputs(cls)}
    errors = {str(name): f"{name}_error" for name in json.loads(attributes.pop("errors"))}
    restored = {
        name: value
        for name, value in values.items()
        if name in hints or name not in known | set(errors.values())
    }
    restored |= {
        name: text if hints.get(name) in ("str", str) else json.loads(text)
        for name, text in attributes.items()
    }
    return record | {
        "fields": restored,
        "dimensions": dimensions,
        "outputs": {name: values[name] for name in known - set(restored) if name in values},
        "errors": {name: values[error_name] for name, error_name in errors.items()},
    }


def _item(value: Any) -> Any:
    """Return an attribute as a Python type."""
    return value.item() if isinstance(value, np.generic) else value


def _null(value: Any) -> Any:
    """Return nan as None, as in a record."""
    if isinstance(value, list):
        return [_null(item) for item in value]
    return None if value != value else value


_WRITERS: dict[str, Callable[[Result], bytes]] = {
    ".nc": _netcdf,
    ".json": lambda result: to_json(result).encode("utf-8"),
    ".csv": _csv,
}
