#!/usr/bin/env bash
# historian-data-compression: the swinging door does not keep its deviation, by a factor of 70.
#
# Guess: straight lines between the archived points of swinging_door_compression(deviation=e) differ from the readings by at
#   most e (or 2 e, if e is meant as the whole width); this bound is what the algorithm is for.
# Version: historian-data-compression 0.0.14.
# Behaviour: each reading moves only one of the two doors: the second comparison is an "elif". On a curve on which every reading
#   raises the slope of the upper door the lower door stays where the first reading after an archived point has put it, wide
#   open, and the curve may turn without closing the doors. What is archived is then the intersection of a line with this door,
#   and not a reading.
# Output: tension 200 + 20 sin(t / 200 s) N/m, one reading a second for an hour. e = 0.5: 15 points, error up to 34 N/m; e = 2:
#   8 points, up to 33 N/m. Swinging door after its definition (in the script): 31 and 14 points, 0.5 and 2.0 N/m.
# Documented: not found.
# Why it matters: the number of points is plausible, even small, and so is the curve. A tension taper read from the archive has
#   errors of the size of the taper itself.
# Remedy: dead_band_compression, which archives readings; or check the archive against the readings.
. "$(dirname "$0")/environment" historian-data-compression==0.0.14 pandas==3.1.1 numpy==2.4.6
python -W ignore - <<'EOF'
import numpy as np
from historian_data_compression import swinging_door_compression


def swinging_door(points, deviation):
    """Yield readings such that lines between them differ from the others by at most the deviation."""
    start = held = points[0]
    yield start
    upper, lower = -np.inf, np.inf
    for time, value in points[1:]:
        slope = (value - start[1]) / (time - start[0])
        up, low = (max(upper, slope - deviation / (time - start[0])), min(lower, slope + deviation / (time - start[0])))
        if not up <= slope <= low:
            start = held
            yield start
            slope = (value - start[1]) / (time - start[0])
            up, low = slope - deviation / (time - start[0]), slope + deviation / (time - start[0])
        upper, lower, held = up, low, (time, value)
    yield held


def error(archive, points):
    """Return the number of archived points and the largest deviation of the readings from the lines."""
    archive, points = np.array(list(archive)), np.array(points)
    return len(archive), float(abs(np.interp(points[:, 0], *archive.T) - points[:, 1]).max())


t = np.arange(0.0, 3600.0)
points = list(zip(t.tolist(), (200 + 20 * np.sin(t / 200)).tolist()))
for deviation in (0.5, 2.0):
    count, package = error(swinging_door_compression(iter(points), deviation=deviation), points)
    own_count, own = error(swinging_door(points, deviation), points)
    print(deviation, "package", count, package, "definition", own_count, own)
    if not (package > 30 and count < 20 and own <= deviation * (1 + 1e-9)):
        raise SystemExit(f"changed: deviation {deviation}: {package} with {count} points; by definition {own}")
print("as stated")
EOF
