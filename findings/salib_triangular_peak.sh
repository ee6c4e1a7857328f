#!/usr/bin/env bash
# SALib: the peak of a triangular distribution is a fraction of the width, and a friction coefficient is taken for one.
#
# Guess: bounds of "triang" are lower bound, upper bound and peak, in the unit of the parameter, as in random.triangular, numpy,
#   OpenTURNS and chaospy.
# Versions: SALib 1.6.0, openturns 1.27.post1 for comparison.
# Behaviour: the third bound is the position of the peak between the bounds, from 0 to 1. A peak above 1 (a modulus) raises an
#   error; one between 0 and 1 (friction coefficient, Poisson's ratio, gap in mm) is accepted as a fraction.
# Output: friction coefficient from 0.2 to 0.6, peak 0.3: mean 0.373 (peak at 0.2 + 0.3 * 0.4 = 0.32) instead of 0.3667; from 0.1
#   to 0.2, peak 0.12: 0.137 instead of 0.140; Poisson's ratio from 0 to 0.5, peak 0.45: 0.242 instead of 0.317. A modulus
#   from 2e9 to 6e9 with the peak 3e9: ValueError.
# Why it matters: within one problem the parameters of order 1e9 are noticed and corrected, those of order 0.1 are not, and the
#   indices belong to another distribution.
# Remedy: (peak - lower) / (upper - lower).
. "$(dirname "$0")/environment" salib==1.6.0 openturns==1.27.post1 numpy==2.4.6
python - <<'EOF'
import numpy as np
import openturns as ot
from SALib.sample import latin, sobol


def mean(sampler, lower, upper, peak):
    problem = {"num_vars": 1, "names": ["x"], "bounds": [[lower, upper, peak]], "dists": ["triang"]}
    return sampler.sample(problem, 4096, seed=1).mean()


for lower, upper, peak in ((0.2, 0.6, 0.3), (0.1, 0.2, 0.12), (0.0, 0.5, 0.45)):
    fraction = lower + peak * (upper - lower)
    usual = ot.Triangular(lower, peak, upper).getMean()[0]
    for sampler in (latin, sobol):
        observed = mean(sampler, lower, upper, peak)
        print(lower, upper, peak, sampler.__name__, observed, "usual", usual)
        if not np.isclose(observed, (lower + upper + fraction) / 3, rtol=2e-3) or np.isclose(observed, usual, rtol=1e-2):
            raise SystemExit(f"changed: mean {observed}")
try:
    mean(latin, 2e9, 6e9, 3e9)
except ValueError as error:
    print(error)
else:
    raise SystemExit("changed: a peak above 1 is accepted")
print("as stated")
EOF
