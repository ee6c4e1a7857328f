#!/usr/bin/env bash
# asammdf and mdfreader: a sensor that failed or was switched off goes on measuring in the table.
#
# Guess: in to_dataframe(raster=...) a channel is NaN after its last sample and where its samples are marked invalid, and the
#   reader mdfreader shows the same samples as asammdf.
# Versions: asammdf 8.8.28, mdfreader 4.3.
# Behaviour: asammdf removes invalid samples and then interpolates, with a straight line across the gap of any length, and with
#   the first and the last value outside of the measured time. The table has no NaN. interpolate_outwards_with_nan=True concerns
#   only the ends. mdfreader 4.3 returns invalid samples as values, with the bits in a channel of their own, and no mask.
# Output: tension of 100 s, invalid (0 N/m written) from 20 to 40 s, speed until 50 s. raster=0.5: at 30 s 201.2 N/m (between
#   the last valid and the next), at 100 s 60 m/s; no NaN. mdfreader: 199 of 1001 samples are the invalid 0 N/m. The product of
#   both signals in asammdf ends at 50 s.
# Documented: the option interpolate_outwards_with_nan is (issue 281, 2019), the straight line across invalid samples was not
#   found.
# Why it matters: the export to CSV, parquet and MAT with a raster goes the same way. A winding with a failed tension sensor has
#   a steady tension there, and its scatter is too small; by the other reader its mean is 20 % too low.
# Remedy: use_interpolation=False and join by the nearest time; or raster with the option for the ends, and get(name,
#   ignore_invalidation_bits=True).invalidation_bits to leave out rows.
. "$(dirname "$0")/environment" asammdf==8.8.28 mdfreader==4.3 numpy==2.4.6 pandas==3.1.1
python -W ignore - <<'EOF'
import mdfreader
import numpy as np
from asammdf import MDF, Signal

t, short = np.arange(0, 100.05, 0.1), np.arange(0, 50.05, 0.25)
invalid = (t > 20.05) & (t < 39.95)
values = np.where(invalid, 0.0, 200 + 10 * np.sin(t / 5))
tension = Signal(values, t, name="tension", unit="N/m", invalidation_bits=invalid)
speed = Signal(10 + short, short, name="speed", unit="m/s")
with MDF(version="4.10") as file:
    file.append([tension])
    file.append([speed])
    file.save("log.mf4")
with MDF("log.mf4") as file:
    table = file.to_dataframe(raster=0.5)
    ends = file.to_dataframe(raster=0.5, interpolate_outwards_with_nan=True)
    separate = file.to_dataframe(use_interpolation=False)
    valid = len(file.get("tension"))
    last = (file.get("tension") * file.get("speed")).timestamps[-1]
before, after = (200 + 10 * np.sin(time / 5) for time in (20, 40))
other = mdfreader.Mdf("log.mf4").get_channel_data("tension")
observed = (
    len(table),
    int(table.isna().sum().sum()),
    round(float(table.tension.loc[30.0] - (before + after) / 2), 6),
    float(table.speed.loc[100.0]),
    ends.isna().sum().tolist(),
    valid,
    int(separate.tension.isna().sum()),
    len(other),
    int((np.asarray(other) == 0).sum()),
    float(last),
)
print(observed)
if observed != (201, 0, 0.0, 60.0, [0, 100], 802, 299, 1001, 199, 50.0):
    raise SystemExit(f"changed: {observed}")
print("as stated")
EOF
