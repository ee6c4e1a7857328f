#!/usr/bin/env bash
# tsdownsample: with times, a log with a stop is reduced to far fewer points than were asked for.
#
# Guess: downsample(time, values, n_out=1000) returns 1000 indices, whatever the spacing of the times.
# Version: tsdownsample 0.1.5.1.
# Behaviour: with times the bins have equal duration; bins in a stop are empty and return nothing, and the runs
#   fall into the few bins that remain. Without times the bins have equal numbers of records. LTTB alone has bins of equal
#   numbers in both cases. MinMaxLTTB selects extremes in bins of equal duration first.
# Output: two runs of 1000 s with 10 000 records each, n_out = 1000: stop of 10 s: 996 to 1000; of 10 000 s: 670 (MinMaxLTTB) and
#   168 (MinMax, M4); of 11 days: 10 (MinMaxLTTB), 4 (MinMax) and 8 (M4). LTTB, and all without times: 1000.
# Why it matters: a plot of a week of winder logs shows straight lines where the tension varies, and the error grows with the
#   length of stops and not with the number of records.
# Remedy: give no times, and index the times with the result.
. "$(dirname "$0")/environment" tsdownsample==0.1.5.1 numpy==2.4.6
python - <<'EOF'
import numpy as np
import tsdownsample

values = np.random.default_rng(0).normal(size=20_000)
names = ("MinMaxLTTBDownsampler", "MinMaxDownsampler", "M4Downsampler", "LTTBDownsampler")
stated = {10: [1000, 996, 1000, 1000], 1e4: [670, 168, 168, 1000], 1e6: [10, 4, 8, 1000]}
for stop, counts in stated.items():
    run = np.arange(10_000) * 0.1
    times = np.r_[run, 1000 + stop + run]
    samplers = [getattr(tsdownsample, name)() for name in names]
    observed = [len(sampler.downsample(times, values, n_out=1000)) for sampler in samplers]
    plain = [len(sampler.downsample(values, n_out=1000)) for sampler in samplers]
    print(stop, dict(zip(names, observed)), plain)
    if observed != counts or plain != [1000] * 4:
        raise SystemExit(f"changed: stop {stop} s: {observed}, without times {plain}")
print("as stated")
EOF
