#!/usr/bin/env bash
# npTDMS: a frame of channels of two rates pairs samples of different instants, and with the time as index an instant is there
# twice.
#
# Guess: group.as_dataframe() of a fast and a slow channel has a row for each instant; with time_index=True the instants at which
#   both channels have a sample are one row with both values.
# Version: npTDMS 1.13.0.
# Behaviour: without time_index the rows are sample numbers: the slow channel fills the first rows. With time_index=True the union
#   of the floating-point times is the index. k * 0.001 and m * 0.1 differ in the last bit for some k = 100 m, and such an
#   instant has two rows, each with one value. With absolute_time=True times are rounded to nanoseconds and instants are unique.
# Output: tension at 1000 Hz and speed at 10 Hz, both equal to the time, 4 s. By number: tension 0.039 next to speed 3.9. By time:
#   4008 rows instead of 4000; 8 of 40 samples of the speed have no tension in their row. By absolute time: 4000 rows.
# Why it matters: a winder's log has the tension at a kilohertz and the radius at 10 Hz. dropna() after the join loses a fifth of
#   the samples, those of certain instants always, and the first form gives tensions at wrong radii without a sign of it.
# Remedy: absolute_time=True, or pandas.merge_asof with half a period as tolerance.
. "$(dirname "$0")/environment" npTDMS==1.13.0 pandas==3.1.1 numpy==2.4.6
python -W ignore - <<'EOF'
import numpy as np
from nptdms import ChannelObject, TdmsFile, TdmsWriter


def channel(name, rate, count):
    properties = {
        "wf_start_time": np.datetime64("2026-01-01T00:00:00"),
        "wf_start_offset": 0.0,
        "wf_increment": 1 / rate,
        "wf_samples": count,
    }
    return ChannelObject("log", name, np.arange(count) / rate, properties=properties)


with TdmsWriter("log.tdms") as file:
    file.write_segment([channel("tension", 1000.0, 4000), channel("speed", 10.0, 40)])
log = TdmsFile.read("log.tdms")["log"]
by_number, by_time = log.as_dataframe(), log.as_dataframe(time_index=True)
absolute = log.as_dataframe(time_index=True, absolute_time=True)
observed = (
    by_number.iloc[39].tolist(),
    len(by_time),
    len(by_time.dropna()),
    int((np.diff(by_time.index) < 1e-9).sum()),
    len(absolute),
    len(absolute.dropna()),
)
print(observed)
if observed != ([0.039, 3.9], 4008, 32, 8, 4000, 40):
    raise SystemExit(f"changed: {observed}")
print("as stated")
EOF
