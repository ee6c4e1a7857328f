#!/usr/bin/env bash
# pyuff: the time axis of a universal file (dataset 58) has six digits, also in double precision.
#
# Guess: with ord_data_type=4 (double precision) times and ordinates come back to at least ten digits.
# Version: pyuff 2.5.8.
# Behaviour: ordinates have 12 digits, but the increment of even spacing and every time of uneven spacing are written in the
#   format E13.5 of the file format's definition, with six digits. The increment that the caller gives (abscissa_inc) is ignored
#   and computed from the first two times.
# Output: 51 200 Hz: the increment 1.953125e-5 s is read as 1.95313e-5 s, half a sample in 200 000, 9 ms in an hour; 3 Hz:
#   0.2 samples in 200 000 the other way; 1000 Hz: exact. Uneven times of a log at 10 Hz: a resolution of 0.1 s from 10 000 s
#   on, so that times are off by up to half a sample, and some occur twice at 20 Hz.
# Why it matters: channels of two recorders that are matched by time drift apart, and speed or radius differences divided by
#   time differences are zero or infinite where times repeat. The ordinates look perfect.
# Remedy: keep start time and rate in the text fields id1 to id5 and compute times from them.
. "$(dirname "$0")/environment" pyuff==2.5.8 numpy==2.4.6
python - <<'EOF'
import numpy as np
import pyuff


def read(times, even):
    data = np.sin(times)
    entry = pyuff.prepare_58(
        binary=0,
        func_type=1,
        x=times,
        data=data,
        abscissa_spacing=even,
        abscissa_min=0.0,
        abscissa_inc=float(times[1] - times[0]),
        num_pts=times.size,
        ord_data_type=4,
        rsp_node=1,
        rsp_dir=1,
        ref_node=1,
        ref_dir=1,
        id1="tension",
        abscissa_spec_data_type=17,
        ordinate_spec_data_type=9,
        orddenom_spec_data_type=0,
        z_axis_spec_data_type=0,
    )
    pyuff.UFF("log.uff").write_sets(entry, mode="overwrite")
    result = pyuff.UFF("log.uff").read_sets(0)
    if np.abs(result["data"] - data).max() > 1e-11:
        raise SystemExit("changed: the ordinates are not exact")
    return result["x"]


drifts = []
for rate in (51_200, 3, 1000):
    times = np.arange(200_000) / rate
    drifts.append((read(times, even=1)[-1] - times[-1]) * rate)
random = np.random.default_rng(1)
errors, repeated = [], []
for rate in (10, 20):
    times = (np.arange(300_000) + random.uniform(0, 0.5, 300_000)) / rate
    result = read(times, even=0)
    errors.append(np.abs(result - times).max())
    repeated.append(times.size - np.unique(result).size)
print("drift in samples", drifts, "error in s", errors, "repeated times", repeated)
if not (
    np.allclose(drifts, [0.512, -0.2, 0], atol=1e-3)
    and np.allclose(errors, 0.05, rtol=0.01)
    and repeated[1] > 10_000
):
    raise SystemExit(f"changed: {drifts}, {errors}, {repeated}")
print("as stated")
EOF
