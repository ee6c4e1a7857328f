#!/usr/bin/env bash
# mastercurves: isotherms given from hot to cold are not shifted at all, without a message.
#
# Guess: superpose() finds the shift factors of smooth, overlapping isotherms in either order; the reference is the first curve.
# Version: mastercurves 0.2.3.
# Behaviour: Multiply() restricts the factor between neighbouring curves to bounds=(0.01, 1). In rising order with the frequency
#   as abscissa the factors are below 1 and found. In falling order they exceed 1; the result is the bound itself, factor 1,
#   with an uncertainty of a few per cent. Steps of more than two decades end at 0.01 in the same way.
# Output: storage modulus of one relaxation time, 20, 40, 60 degC, one decade apart: rising 1, 0.095, 0.0095 (exact 1, 0.1,
#   0.01); falling 1, 1, 1 (exact 1, 10, 100); falling with bounds=(0.01, 100) 1, 9.9, 105. 2.5 decades apart: 1, 0.01 (exact
#   0.0032).
# Why it matters: a table that lists the hottest isotherm first is as valid as any. The master curve of a roll cover is then only
#   as wide as one isotherm, the kHz range of a nip is not reached, and the uncertainties say that the factors are right.
# Remedy: Multiply(bounds=...) that contain 1, and curves sorted by temperature.
. "$(dirname "$0")/environment" mastercurves==0.2.3 numpy==2.4.6 scipy==1.17.1
python -W ignore - <<'EOF'
import numpy as np
from mastercurves import MasterCurve
from mastercurves.transforms import Multiply


def storage(w):
    return 1 + 5 * w**2 / (1 + w**2)


def shifts(exact, temperatures, **bounds):
    """Return the shift factors of isotherms with the exact factors, relative to the first."""
    frequency = np.logspace(-1, 2, 20)
    curve = MasterCurve()
    curve.add_htransform(Multiply(**bounds))
    curve.add_data([np.log(frequency)] * len(exact), [np.log(storage(a * frequency)) for a in exact], temperatures)
    curve.superpose()
    observed, scatter = np.array(curve.hparams[0], float), np.array(curve.huncertainties[0], float)
    print(temperatures, bounds, observed, "exact", np.divide(exact, exact[0]), "uncertainty", scatter)
    return observed, scatter


rising, _ = shifts([10, 1, 0.1], [20, 40, 60])
falling, scatter = shifts([0.1, 1, 10], [60, 40, 20])
free, _ = shifts([0.1, 1, 10], [60, 40, 20], bounds=(0.01, 100))
wide, _ = shifts([10, 10**-1.5], [20, 60])
if not (
    np.allclose(rising, [1, 0.1, 0.01], rtol=0.2)
    and np.allclose(falling, 1, rtol=1e-3)
    and scatter.max() < 0.2
    and np.allclose(free, [1, 10, 100], rtol=0.2)
    and np.allclose(wide[1], 0.01, rtol=1e-3)
):
    raise SystemExit(f"changed: {rising}, {falling}, {free}, {wide}")
print("as stated")
EOF
