#!/usr/bin/env bash
# fastparquet: half of the times of a log are wrong, by thousands of years, if it was written in the newer version of the format.
#
# Guess: a Parquet file of writer version 2 is read as the same numbers, or refused (as fastparquet does for its other new
#   encodings).
# Versions: fastparquet 2026.9.0, arro3-io 0.9.1 and pyarrow 26.0.1 as writers.
# Behaviour: in a data page of version 2 that is encoded DELTA_BINARY_PACKED, 64-bit integers and time stamps are unpacked as
#   32-bit ones: two values share one row, and the second half of the page is what memory held before. No message. 32-bit
#   integers, floating-point numbers, pages of version 1 and columns with null (AssertionError) do not have the error.
# Output: 300 000 rows at 100 Hz, written by arro3-io (the Rust library of Parquet) with writer_version="parquet_2_0": it starts
#   with a dictionary and changes to the delta encoding when the dictionary is full, so that the first 46.7 % of the times and of
#   the pulse counts are right, and the rest are not. A column of few distinct numbers (reel) and the tension are right. By
#   pyarrow with data_page_version="2.0" and this encoding: 203500, 203501 becomes 874030139906796 (203500 + 203501 * 2**32).
# Documented: not found. Related: fastparquet issues 766 (wrong values of delta-encoded columns, 2022, closed) and 911 (the
#   encoding in pages of version 1, closed).
# Why it matters: a converter decides on the format of a log, the analyst on the reader. The head of the table is right, and the
#   tension always is; what is wrong are times, web length counters and pulse counts from the middle on.
# Remedy: engine="pyarrow"; or write version 1.
. "$(dirname "$0")/environment" \
    fastparquet==2026.9.0 arro3-io==0.9.1 arro3-core==0.9.1 pyarrow==26.0.1 pandas==3.1.1 numpy==2.4.6
python -W ignore - <<'EOF'
import arro3.io
import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

n = 300_000
written = pd.DataFrame(
    {
        "time": pd.date_range("2026-01-01", periods=n, freq="10ms"),
        "pulses": np.arange(n) * 13 + 5_000_000_000,
        "reel": np.arange(n) // 1000,
        "tension": np.random.default_rng(0).normal(200.0, 5.0, n),
    }
)
stated = {"time": 0.467, "pulses": 0.467, "reel": 1.0, "tension": 1.0}
for version, right in (("parquet_1_0", dict.fromkeys(stated, 1.0)), ("parquet_2_0", stated)):
    arro3.io.write_parquet(pa.Table.from_pandas(written), "log.parquet", writer_version=version)
    if not pd.read_parquet("log.parquet", engine="pyarrow").equals(written):
        raise SystemExit("changed: pyarrow reads other numbers")
    read = pd.read_parquet("log.parquet", engine="fastparquet")
    observed = {name: float((read[name] == written[name]).mean()) for name in written}
    print(version, observed, read.iloc[-1].tolist())
    if any(abs(observed[name] - right[name]) > 0.01 for name in right):
        raise SystemExit(f"changed: {version}: {observed}")

numbers = np.arange(203_500, 204_500)
for page, kind in (("1.0", "i8"), ("2.0", "i4"), ("2.0", "i8")):
    table = pa.table({"x": numbers.astype(kind)})
    options = {"use_dictionary": False, "column_encoding": {"x": "DELTA_BINARY_PACKED"}}
    pq.write_table(table, "x.parquet", data_page_version=page, **options)
    read = pd.read_parquet("x.parquet", engine="fastparquet").x.to_numpy()
    expected = numbers[::2] + numbers[1::2] * 2**32 if (page, kind) == ("2.0", "i8") else numbers
    print(page, kind, read[:2])
    if not np.array_equal(read[: expected.size], expected):
        raise SystemExit(f"changed: page {page}, {kind}: {read}")
print("as stated")
EOF
