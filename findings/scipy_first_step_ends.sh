#!/usr/bin/env bash
# SciPy: a least-squares fit of values in Pa ends at its start, with success.
#
# Guess: a linear fit with its exact Jacobian takes one step of Gauss and Newton, from any start and in any units; success
#   means that no better parameters are near.
# Version: SciPy 1.17.1.
# Behaviour: the first trust region of "trf" and "dogbox" has the length of the start, 1 if the start is zero, in the units of
#   x_scale; with x_scale="jac" these are changes of the residuals by 1. Where the residuals are 3e9 Pa, the first step lowers
#   their squared sum by less than ftol of it, and the fit ends after two evaluations with success, status 2. The steps that
#   follow would double the region each time. Without x_scale it ends so for moduli of steel; from a start of the right
#   order of magnitude, or in GPa, the same fit is right.
# Output: E = 0.17 Pa at 0 degC in place of 3.018e9 Pa ("trf"), 0.22 Pa ("dogbox"), success after 2 evaluations.
# Documented: the tolerance ftol, relative to the sum; the length of the first region is not in the documentation of the
#   function.
# Why it matters: moduli of film, paper and steel, and pressures in rolls, are large numbers in SI units, and fits of a change
#   (of temperature, of moisture) start at zero. The estimate looks like "no effect", and the standard error is finite.
# Remedy: unknowns between 1 and 2 over their bounds, or residuals divided by the size of the measured values.
. "$(dirname "$0")/environment" numpy==2.4.6 scipy==1.17.1
python - <<'EOF'
import numpy as np
from scipy.optimize import least_squares

temperature = np.linspace(20, 120, 20)  # degC


def fit(E, unit, **options):
    """Fit E(T) = a + b T by its exact Jacobian, from a = b = 0; return a [Pa], and how it ended."""
    measured = E * (1 - 3e-4 * (temperature - 20)) / unit
    columns = np.stack([np.ones_like(temperature), temperature], axis=1)
    end = least_squares(lambda p: columns @ p - measured, [0.0, 0.0], lambda p: columns, **options)
    return end.x[0] * unit, end.success, end.status, end.nfev


film, steel, failed = 3e9, 2.1e11, []
for method in ("trf", "dogbox"):
    for E, scale in ((film, "jac"), (steel, 1.0)):
        found, success, status, evaluations = fit(E, 1, method=method, x_scale=scale)
        print(f"{method:7} x_scale={scale!s:4} {E * 1.006:.4g} Pa: {found:.3g} Pa", success, status, evaluations)
        if not (success and status == 2 and evaluations == 2 and found < 10):
            failed.append((method, scale))
    in_GPa = fit(film, 1e9, method=method, x_scale="jac")
    print(f"{method:7} the film in GPa: {in_GPa[0]:.5g} Pa")
    if not (in_GPa[1] and np.isclose(in_GPa[0], 1.006 * film, rtol=1e-6)):
        failed.append((method, "GPa"))
if failed:
    raise SystemExit(f"changed: {failed}")
print("as stated")
EOF
