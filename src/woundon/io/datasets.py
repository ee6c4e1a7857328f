"""Results as xarray Datasets, and the netCDF files of these.

A Dataset has the parts of a record (:mod:`.records`): numbers and arrays are variables with unit,
name and symbol; texts and tuples are attributes, the latter as JSON.
"""

from __future__ import annotations

import io
import json
from math import nan
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import kinds
from ..quantities import Quantity, outputs, value_of
from ..results import Result
from . import seals
from .json_texts import plain
from .records import Record, saved_fields, to_record

if TYPE_CHECKING:
    import xarray

__all__ = ["record_of_netcdf", "to_dataset", "to_netcdf"]

# The parts of a record that are attributes of a Dataset: as they are, and as JSON.  The names of
# the error estimates are a further attribute, their values are variables.
AS_THEY_ARE = ("format", "schema", "version", "kind")
AS_JSON = ("problem", "warnings")


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

    record = to_record(result)
    known = {place.path: place.quantity for place in outputs(result)}
    attributes = {name: record[name] for name in AS_THEY_ARE}
    attributes |= {name: json.dumps(record[name]) for name in AS_JSON}
    attributes["errors"] = json.dumps(list(record["errors"]))
    variables: dict[str, Any] = {}
    for name, value in (record["fields"] | record["outputs"]).items():
        dims = record["dimensions"].get(name, ())
        if isinstance(value, str):
            attributes[name] = value
        elif isinstance(value, list) and not dims:  # a tuple
            attributes[name] = json.dumps(value)
        else:
            # arrays of the result itself keep their type; a number that is None in JSON is nan
            number = nan if value is None else value
            values = np.asarray(value_of(result, name)) if dims else number
            variables[name] = (dims, values, _labels(known.get(name)))
    for name, error in result.errors.items():
        variables.setdefault(f"{name}_error", ((), error, _error_labels(known.get(name))))
    residuals = list(record["residuals"].values())
    variables["residual"] = ("condition", residuals, _labels(known["residual"]))
    dimensions = {dim for dims in record["dimensions"].values() for dim in dims}
    coordinates = {name: variables.pop(name) for name in list(variables) if name in dimensions}
    coordinates["condition"] = list(record["residuals"])
    return xarray.Dataset(variables, coordinates, attributes)


def _labels(quantity: Quantity | None) -> dict[str, str]:
    """Return unit, meaning and symbol of a quantity as attributes."""
    return quantity.attributes if quantity else {}


def _error_labels(quantity: Quantity | None) -> dict[str, str]:
    """Return unit, meaning and symbol of the error estimate of an output as attributes."""
    if quantity is None:
        return {}
    meaning = f"estimated discretisation error: {quantity.meaning}"
    return quantity.attributes | {"long_name": meaning, "symbol": f"{quantity.symbol} error"}


def to_netcdf(result: Result) -> bytes:
    """Return a result as the bytes of a netCDF file with its SHA-256."""
    # the classic format can be read everywhere, needs SciPy only and is reproducible
    dataset = to_dataset(result).assign_attrs({seals.NAME: seals.BLANK})
    return seals.sealed_bytes(bytes(dataset.to_netcdf(engine="scipy")))


def record_of_netcdf(content: bytes) -> Record:
    """Return the record from which a netCDF file was made, with the units of the variables.

    Raises
    ------
    Exception
        Of any type, if the content is not such a file.
    """
    import xarray

    # without decoding, a unit of time would become a date
    with xarray.open_dataset(io.BytesIO(content), engine="scipy", decode_times=False) as dataset:
        variables = dict(dataset.variables)
        attributes = {str(name): plain(value) for name, value in dataset.attrs.items()}
    attributes.pop(seals.NAME, None)
    values = {str(name): plain(variable.values) for name, variable in variables.items()}
    record: Record = {name: attributes.pop(name) for name in AS_THEY_ARE}
    record |= {name: json.loads(attributes.pop(name)) for name in AS_JSON}
    record["dimensions"] = {name: list(variables[name].dims) for name in values}
    record["units"] = {name: variables[name].attrs.get("units", "1") for name in values}
    record["residuals"] = dict(zip(values.pop("condition"), values.pop("residual"), strict=True))
    # an output may be named like the error estimate of another one, so its variable remains
    errors = {name: f"{name}_error" for name in json.loads(attributes.pop("errors"))}
    record["errors"] = {name: values[variable] for name, variable in errors.items()}
    # the other variables are fields, or outputs that are computed from the fields
    result_class = kinds.named(str(record["kind"])).result
    saved = saved_fields(result_class)
    computed = {place.path for place in outputs(result_class)} - saved.keys()
    record["outputs"] = {name: values[name] for name in computed & values.keys()}
    record["fields"] = {
        name: value
        for name, value in values.items()
        if name in saved or name not in computed | set(errors.values())
    }
    # the other attributes are fields that are texts, or tuples as JSON
    for name, text in attributes.items():
        is_text = name in saved and saved[name].hint is str
        record["fields"][name] = text if is_text else json.loads(text)
    return record
