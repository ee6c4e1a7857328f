#!/usr/bin/env bash
# tsfile (Apache TsFile, the file of the historian IoTDB): one of its encodings keeps two decimals of a double.
#
# Guess: encodings reduce the size of a file and return the numbers bit by bit, as GORILLA, CHIMP and PLAIN; TS_2DIFF,
#   differences of differences, is one of them.
# Version: tsfile 2.5.0.
# Behaviour: with TS_2DIFF floating-point numbers are multiplied by 100 and rounded to whole numbers first. The writer accepts
#   the encoding for FLOAT and DOUBLE without a message, and the Python package has no parameter for the number of decimals.
#   PLAIN, GORILLA, CHIMP, SPRINTZ and RLBE return all numbers unchanged, CAMEL to 1e-12.
# Output: caliper 0.0532 mm is read as 0.05, the nip load 2.035 kN/m as 2.03 or 2.04, and all strains of 0.1 to 0.4 % as 0. The
#   file is an eighth of that of PLAIN, which makes it the choice for long logs.
# Documented: in the pages of the IoTDB server (two decimals by default, MAX_POINT_NUMBER of a time series); in the Python
#   package not found.
# Why it matters: the loss depends on the unit in which a quantity is logged. Means over many rows hide it where the scatter
#   exceeds 0.01; where it does not, a profile of the caliper is flat.
# Remedy: GORILLA or CHIMP; log in a unit in which 0.01 does not matter.
. "$(dirname "$0")/environment" tsfile==2.5.0 numpy==2.4.6
python - <<'EOF'
import os

import numpy as np
from tsfile import Compressor, Tablet, TimeseriesSchema, TSDataType, TSEncoding, TsFileReader, TsFileWriter

ROWS = 20_000


def written_and_read(values, encoding):
    """Return the values that come back from a file, and its size."""
    name = f"{encoding.name}.tsfile"
    writer = TsFileWriter(name)
    schema = TimeseriesSchema("value", TSDataType.DOUBLE, encoding, Compressor.UNCOMPRESSED)
    writer.register_timeseries("root.winder", schema)
    tablet = Tablet(["value"], [TSDataType.DOUBLE], ROWS)
    tablet.set_table_name("root.winder")
    for row, value in enumerate(values):
        tablet.add_timestamp(row, 100 * row)
        tablet.add_value_by_name("value", row, float(value))
    writer.write_tablet(tablet)
    writer.close()
    reader = TsFileReader(name)
    records = reader.query_timeseries("root.winder", ["value"], 0, 100 * ROWS)
    found = []
    while records.next():
        found.append(records.get_value_by_index(2))
    records.close()
    reader.close()
    size = os.path.getsize(name)
    os.remove(name)
    return np.array(found), size


random = np.random.default_rng(0)
channels = {
    "caliper [mm]": np.round(random.normal(0.0532, 0.0004, ROWS), 5),
    "nip load [kN/m]": np.round(random.normal(2.035, 0.05, ROWS), 4),
    "strain": np.linspace(0.001, 0.004, ROWS),
}
for name, values in channels.items():
    plain, large = written_and_read(values, TSEncoding.PLAIN)
    gorilla, _ = written_and_read(values, TSEncoding.GORILLA)
    rounded, small = written_and_read(values, TSEncoding.TS_2DIFF)
    print(name, values[:3], "TS_2DIFF", rounded[:3], "sizes", large, small)
    if not (
        np.array_equal(plain, values)
        and np.array_equal(gorilla, values)
        and np.allclose(rounded * 100, np.round(rounded * 100), atol=1e-9)
        and 0.0019 < abs(rounded - values).max() <= 0.00501
        and small < 0.2 * large
    ):
        raise SystemExit(f"changed: {name}: {plain[:3]}, {gorilla[:3]}, {rounded[:3]}, {small} of {large} bytes")
print("as stated")
EOF
