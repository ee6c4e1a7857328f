#!/usr/bin/env bash
# zarr and xarray: the zeros of a log become NaN if it was written in zarr format 2, and stay zero in format 3.
#
# Guess: the same numbers in zarr format 2 and 3 are read by xarray as the same numbers.
# Versions: zarr 3.1.6, xarray 2026.9.0.
# Behaviour: zarr's fill_value is what unwritten chunks contain, by default 0. For format 2 xarray takes it as the netCDF
#   attribute _FillValue and replaces equal values by NaN, also in chunks that were written; integers become floats. For
#   format 3 it does not. use_zarr_fill_value_as_mask=False does not switch it off: the backend
#   accepts the argument and passes None on.
# Output: tension 0, 0, 5, -1: nan, nan, 5, -1 in format 2; 0, 0, 5, -1 in format 3. With fill_value=-1 the -1 is lost
#   instead, with fill_value=None or NaN nothing is. Counter 0, 1, 2 in format 2: float64.
# Why it matters: zero tension is a stop of the winder. As NaN it disappears from sums and means without a message: the mean
#   tension of a winder at rest in half of the records doubles. Recorders write format 2 for old readers.
# Remedy: fill_value=None (or NaN) when format 2 is written.
. "$(dirname "$0")/environment" zarr==3.1.6 xarray==2026.9.0 numpy==2.4.6
python -W ignore - <<'EOF'
import numpy as np
import xarray as xr
import zarr


def read(layout, values, dtype="f8", mask=None, **fill):
    group = zarr.open_group("log", mode="w", zarr_format=layout)
    names = {"dimension_names": ["time"]} if layout == 3 else {}
    array = group.create_array("tension", shape=(len(values),), chunks=(2,), dtype=dtype, **names, **fill)
    array[:] = values
    if layout == 2:
        array.attrs["_ARRAY_DIMENSIONS"] = ["time"]
    data = xr.open_zarr("log", consolidated=False, use_zarr_fill_value_as_mask=mask).tension.load()
    return data.values


def check(observed, *stated):
    print(observed)
    if not np.array_equal(observed, stated, equal_nan=True):
        raise SystemExit(f"changed: {observed} instead of {stated}")


values, nan = [0, 0, 5, -1], float("nan")
check(read(2, values), nan, nan, 5, -1)
check(read(2, values, mask=False), nan, nan, 5, -1)
check(read(2, values, fill_value=-1.0), 0, 0, 5, nan)
check(read(2, values, fill_value=None), *values)
check(read(2, values, fill_value=nan), *values)
check(read(3, values), *values)
check(read(3, values, fill_value=-1.0), *values)
counter = read(2, [0, 1, 2, 3], dtype="i4")
check(counter, nan, 1, 2, 3)
print("as stated")
EOF
