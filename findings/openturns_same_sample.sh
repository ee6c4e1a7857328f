#!/usr/bin/env bash
# OpenTURNS: every new process draws the same sample, also the parallel workers of one study.
#
# Guess: without a seed, two processes draw different samples, as with Python's random and numpy.
# Versions: openturns 1.27.post1, loky 3.7.0.
# Behaviour: the generator starts with seed 0 in every process. Within a process samples differ; workers of a pool repeat each
#   other, as long as each draws equally often. RandomGenerator.SetSeed is necessary for independent samples, not for
#   repeatable ones.
# Output: two processes print the same sample; mean friction coefficients of 4 replicates of 1000, one per worker: scatter
#   exactly 0, with numpy about 0.001.
# Why it matters: the scatter of Monte Carlo replicates is the usual estimate of the sampling error of a failure probability or
#   a Sobol index. Spread over processes it is zero, and pooling n replicates does not reduce the error, silently.
# Remedy: RandomGenerator.SetSeed(replicate number) at the start of each task.
. "$(dirname "$0")/environment" openturns==1.27.post1 loky==3.7.0 numpy==2.4.6
cat > draw.py <<'EOF'
import time

import numpy as np
import openturns as ot


def replicate(number, seeded=False):
    """Return the mean friction coefficient of a sample, and that of a sample by numpy."""
    if seeded:
        ot.RandomGenerator.SetSeed(number)
    time.sleep(2)  # every task finds a worker of its own
    mean = ot.TruncatedNormal(0.25, 0.06, 0.1, 0.5).getSample(1000).computeMean()[0]
    return mean, np.random.default_rng().normal(0.25, 0.06, 1000).mean()
EOF
printf '%s\n' 'import openturns as ot' 'print(ot.Normal().getSample(3).asPoint())' > sample.py
first=$(python sample.py) second=$(python sample.py)
echo "$first $second"
[ "$first" = "$second" ] || { echo "changed: two processes draw different samples"; exit 1; }
cat > study.py <<'EOF'
import numpy as np
from draw import replicate
from loky import ProcessPoolExecutor

scatter = []
for seeded in (False, True):
    with ProcessPoolExecutor(4) as pool:
        scatter.append(np.std(list(pool.map(replicate, range(4), [seeded] * 4)), axis=0))
print(scatter)
if scatter[0][0] != 0 or scatter[0][1] == 0 or scatter[1][0] == 0:
    raise SystemExit(f"changed: scatter of the means {scatter}")
print("as stated")
EOF
python study.py
