#!/usr/bin/env bash
# pandas, numpy: the scatter of a float32 log of ten million rows is four times too large, next to the right mean.
#
# Guess: mean and standard deviation of ten million float32 values of the same size are right to 1e-4, since sums are pairwise or
#   in double precision; whether an optional package for speed is installed does not change them.
# Versions: pandas 3.1.1, bottleneck 1.6.0, numpy 2.4.6.
# Behaviour: if bottleneck is installed (pandas[performance] does it), pandas uses it for std and var, not for mean and sum.
#   bottleneck adds float32 numbers one after the other; from 2**31 on the sum moves in steps of 256. So std refers to a mean of
#   its own, which is 9 % off, while mean is right. numpy adds pairwise only along the contiguous axis: mean(axis=0) of an array
#   of rows and channels has the same error without bottleneck.
# Output: tension 203.5 N/m with a scatter of 5 N/m, 10 million rows. pandas: mean 203.50, std 19.92, describe() the same;
#   without bottleneck 5.00, and sem() is right in both. numpy, array of two columns: mean(axis=0) 222.8, std(axis=0) 19.9; of one
#   column alone 203.5. 40 million rows: bottleneck.nanmean 107.4, std by pandas 83.
# Documented: for means in bottleneck issues 193 and 462 (open) and numpy issue 29772; xarray (1346) does not use bottleneck any
#   more unless asked to. The right mean next to the wrong scatter in pandas: not found; issue 25307 (closed) is on the mean.
# Why it matters: recorders store float32, and at 1 kHz ten million rows are three hours. The scatter decides the weights of a fit
#   and the limits of control charts. The mean next to it, which is what one checks, is right, and on a shorter log so is the
#   scatter.
# Remedy: astype("float64"), or pandas.set_option("compute.use_bottleneck", False).
. "$(dirname "$0")/environment" pandas==3.1.1 bottleneck==1.6.0 numpy==2.4.6
python - <<'EOF'
import bottleneck
import numpy as np
import pandas as pd

random = np.random.default_rng(0)
rows = random.standard_normal((10_000_000, 2), dtype="f4")
rows *= 5
rows += 203.5
tension = rows[:, 0].copy()
series = pd.Series(tension)
observed = {
    "exact": [tension.mean(dtype="f8"), tension.std(dtype="f8")],
    "pandas": [series.mean(), series.std(), series.describe()["std"], series.sem() * len(series) ** 0.5],
    "numpy": [rows.mean(axis=0)[0], rows.std(axis=0)[0], tension.mean(), tension.std()],
    "short": [series[:100_000].mean(), series[:100_000].std()],
}
with pd.option_context("compute.use_bottleneck", False):
    observed["without bottleneck"] = [series.mean(), series.std()]
long = np.resize(tension, 40_000_000)
observed["long"] = [bottleneck.nanmean(long), pd.Series(long).mean(), pd.Series(long).std()]
stated = {
    "exact": [203.5, 5.0],
    "pandas": [203.5, 19.92, 19.92, 5.0],
    "numpy": [222.8, 19.92, 203.5, 5.0],
    "short": [203.5, 5.0],
    "without bottleneck": [203.5, 5.0],
    "long": [107.4, 203.5, 82.9],
}
for name, values in observed.items():
    print(name, [float(value) for value in values])
for name, values in stated.items():
    if not np.allclose(observed[name], values, rtol=0.02):
        raise SystemExit(f"changed: {name}: {observed[name]} instead of {values}")
print("as stated")
EOF
