#!/usr/bin/env bash
# hdf5plugin: the zfp filter with an error bound replaces missing values by numbers such as 512.
#
# Guess: with Zfp(accuracy=0.05) every reading is kept within 0.05, and NaN stays NaN, or the writer refuses it.
# Versions: hdf5plugin 7.1.0, h5py 3.16.0.
# Behaviour: no message. Each NaN comes back as a number of the size of a power of two, of either sign; the other readings keep
#   the bound. Of the other filters with a bound, SZ keeps NaN, and SZ3 refuses the data (OSError). zfp aligns the numbers of a
#   block of four to a common exponent, which a NaN does not have.
# Output: tension 203.5 N/m with a scatter of 1.0 N/m, 1 % of the readings missing: no NaN is left, the gaps are +512 or -512
#   N/m. Mean of the log 201.6 N/m, scatter 54 N/m. Largest error of the other readings 0.02 N/m.
# Documented: zfp states that NaN and infinity are not supported except in the reversible mode; in the page of the filter not
#   found.
# Why it matters: gaps of a log are marked by NaN. They become tensions of a plausible size that no later test for NaN finds.
# Remedy: Zfp(reversible=True), SZ, or a mask of its own.
. "$(dirname "$0")/environment" hdf5plugin==7.1.0 h5py==3.16.0 numpy==2.4.6
python - <<'EOF'
import h5py
import hdf5plugin
import numpy as np

random = np.random.default_rng(0)
tension = random.normal(203.5, 1.0, 100_000)
missing = random.choice(tension.size, 1000, replace=False)
tension[missing] = np.nan


def written_and_read(filter):
    with h5py.File("log.h5", "w") as file:
        file.create_dataset("tension", data=tension, chunks=(10_000,), compression=filter)
    with h5py.File("log.h5") as file:
        return file["tension"][:]


lossy, exact = written_and_read(hdf5plugin.Zfp(accuracy=0.05)), written_and_read(hdf5plugin.Zfp(reversible=True))
other = written_and_read(hdf5plugin.SZ(absolute=0.05))
valid = np.isfinite(tension)
observed = int(np.isnan(lossy).sum()), int(np.isnan(exact).sum()), int(np.isnan(other).sum())
sizes, counts = np.unique(np.round(lossy[missing]), return_counts=True)
largest = abs(lossy - tension)[valid].max()
print(observed, dict(zip(sizes.tolist(), counts.tolist())), "error elsewhere", largest)
print("mean", lossy.mean(), np.nanmean(tension), "scatter", lossy.std(), np.nanstd(tension))
if observed != (0, 1000, 1000) or largest > 0.05 or lossy.std() < 10 or abs(lossy[missing]).max() > 513:
    raise SystemExit(f"changed: {observed}, {sizes}, {largest}")
print("as stated")
EOF
