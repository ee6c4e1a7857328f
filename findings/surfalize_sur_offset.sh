#!/usr/bin/env bash
# surfalize and SurfaceTopography: heights in a .sur file lose their zero, and wear between two files comes out wrong.
#
# Guess: a surface saved as .sur by surfalize and read by SurfaceTopography has the same heights, as .sdf and .x3p files have.
# Versions: surfalize 0.19.2, SurfaceTopography 1.27.1.
# Behaviour: surfalize maps the range of heights to integers symmetrical to zero and stores the middle of the range in the field
#   "offset of Z" of the header. Its own reader adds the offset; SurfaceTopography reads the field into its metadata and does not
#   use it. All heights are off by the middle of the range, which is another one for each file.
# Output: a rough surface of -1 to 1 um, and the same with a worn patch 5 um lower. Difference outside and inside the patch by
#   surfalize 0 and -5 um, by SurfaceTopography 2.5 and -2.5 um from .sur files, 0 and -5 um from .sdf and .x3p files.
# Why it matters: wear of a roll cover or a drum is measured as a difference of two surfaces. Mean-free quantities (Sq, slopes) do
#   not show the error, volumes and depths do: material seems to have been added next to the patch.
# Remedy: exchange .x3p or .sdf files, or add info["raw_metadata"]["data_offset"].
. "$(dirname "$0")/environment" surfalize==0.19.2 SurfaceTopography==1.27.1 numpy==2.4.6
python -W ignore - <<'EOF'
import numpy as np
from surfalize import Surface
from SurfaceTopography import read_topography

rough = np.random.default_rng(0).uniform(-1, 1, (40, 60))
for depth in (5, 2):
    worn = rough.copy()
    worn[10:20, 10:30] -= depth
    for extension, metre in (("sur", 1), ("sdf", 1), ("x3p", 1e-6)):
        read, own = [], []
        for name, heights in (("before", rough), ("after", worn)):
            file = f"{name}.{extension}"
            Surface(heights, 1.0, 1.0).save(file)
            topography = read_topography(file)
            read.append(np.array(topography.heights(), float).T / metre)
            own.append(Surface.load(file).data)
        observed = [(pair[1] - pair[0])[index] for pair in (own, read) for index in ((0, 0), (15, 20))]
        shift = depth / 2 if extension == "sur" else 0
        print(depth, extension, observed)
        if not np.allclose(observed, [0, -depth, shift, shift - depth], atol=0.01):
            raise SystemExit(f"changed: .{extension}, depth {depth}: {observed}")
print("as stated")
EOF
