#!/usr/bin/env bash
# pyuff: in mode "overwrite" all binary datasets of a universal file are lost.
#
# Guess: write_sets([a, b], mode="overwrite") makes a file with two datasets, binary or not.
# Version: pyuff 2.5.8.
# Behaviour: with binary=1 no message appears, and no dataset can be read from the file. After the binary data of the first
#   dataset the writer opens the file again in text mode "wt" to add the end mark, which deletes header and data. The end
#   mark stays as the first line; since datasets are found as pairs of marks, the text between the following datasets, which
#   are written completely, is taken for datasets (of type 0). In mode "add" the writer appends.
# Output: channels read from files of 1, 2 and 3 written in mode "overwrite": text 1, 2, 3; binary 0, 0, 0. Mode "add": all.
# Why it matters: binary is what long runs need, and "overwrite" is what a conversion script uses that may run twice. The size
#   of the file is nearly right for many channels, and the originals may be deleted before anyone opens it.
# Remedy: delete the file and write in mode "add".
. "$(dirname "$0")/environment" pyuff==2.5.8 numpy==2.4.6
python - <<'EOF'
import pathlib

import numpy as np
import pyuff


def entry(channel, binary):
    times = np.arange(1000) * 0.001
    return pyuff.prepare_58(
        binary=binary,
        func_type=1,
        x=times,
        data=np.sin(channel * times),
        abscissa_spacing=1,
        abscissa_min=0.0,
        abscissa_inc=0.001,
        num_pts=times.size,
        ord_data_type=4,
        rsp_node=channel,
        rsp_dir=1,
        ref_node=1,
        ref_dir=1,
        id1="tension",
        abscissa_spec_data_type=17,
        ordinate_spec_data_type=9,
        orddenom_spec_data_type=0,
        z_axis_spec_data_type=0,
    )


def channels(number, binary, mode):
    """Return the channels in a new file to which a number of channels was written."""
    pathlib.Path("log.uff").unlink(missing_ok=True)
    pyuff.UFF("log.uff").write_sets([entry(k + 1, binary) for k in range(number)], mode=mode)
    file = pyuff.UFF("log.uff")
    entries = [file.read_sets(k) for k in range(file.get_n_sets())]
    return [entry["rsp_node"] for entry in entries if entry["type"] == 58]


for number in (1, 2, 3):
    for binary, mode in ((0, "overwrite"), (0, "add"), (1, "add"), (1, "overwrite")):
        stated = [] if binary and mode == "overwrite" else list(range(1, number + 1))
        observed = channels(number, binary, mode)
        print(number, "binary" if binary else "text", mode, observed)
        if observed != stated:
            raise SystemExit(f"changed: {number} channels, binary={binary}, {mode}: {observed}")
print("as stated")
EOF
