#!/usr/bin/env bash
# netCDF4 and xarray: records that were never written are missing in one reader and 9.97e36 in the other.
#
# Guess: a channel with fewer records than the others along an unlimited dimension ends with missing values in both readers.
# Versions: netCDF4 1.7.5.1, xarray 2026.9.0, scipy 1.17.1 (as engine of xarray).
# Behaviour: the library fills unwritten records with the default fill value of the type (9.969e36 for floats, -2147483647
#   for 32-bit integers) and writes no attribute _FillValue. netCDF4 masks the default fill value all the same, xarray masks
#   only what an attribute names. The attribute valid_range, too, is obeyed by netCDF4 and ignored by xarray.
# Output: mean of a channel with 5 of 10 records: 3.0 by netCDF4, 5.0e36 by xarray, with its engines
#   netcdf4 and scipy; with a reading of 50
#   outside valid_range = -10..10: 2.5 and 5.0e36; the counter shows -2147483647.
# Why it matters: a log whose slow channel (roll diameter) has fewer records than the fast one (tension) is usual, and integer
#   counters keep a plausible type: there is no NaN that a later check would find.
. "$(dirname "$0")/environment" netCDF4==1.7.5.1.post1 xarray==2026.9.0 scipy==1.17.1 numpy==2.4.6
python - <<'EOF'
import netCDF4
import numpy as np
import xarray as xr

for layout, engine in (("NETCDF4", "netcdf4"), ("NETCDF3_CLASSIC", "netcdf4"), ("NETCDF3_CLASSIC", "scipy")):
    with netCDF4.Dataset("log.nc", "w", format=layout) as file:
        file.createDimension("record", None)
        tension = file.createVariable("tension", "f8", ("record",))
        diameter = file.createVariable("diameter", "f8", ("record",))
        voltage = file.createVariable("voltage", "f8", ("record",))
        counter = file.createVariable("counter", "i4", ("record",))
        voltage.valid_range = np.array([-10.0, 10.0])
        tension[:] = np.arange(10.0)
        diameter[:5] = [1, 2, 3, 4, 5]
        voltage[:5] = [1, 2, 3, 4, 50]
        counter[:5] = [1, 2, 3, 4, 5]
    with netCDF4.Dataset("log.nc") as file:
        masked = [float(file[name][:].mean()) for name in ("diameter", "voltage", "counter")]
    data = xr.load_dataset("log.nc", engine=engine)
    print(layout, engine, masked, [float(data[name].mean()) for name in ("diameter", "voltage", "counter")])
    if masked != [3.0, 2.5, 3.0]:
        raise SystemExit(f"changed: means by netCDF4 {masked}")
    if not (
        data.diameter.mean() > 1e36
        and data.voltage.values[4] == 50
        and data.counter.dtype.kind == "i"
        and data.counter.values[-1] == -2147483647
    ):
        raise SystemExit(f"changed: by xarray with {layout}, {engine}: {data}")
print("as stated")
EOF
