#!/usr/bin/env bash
# differint: of three algorithms for a fractional derivative one has always the order 1/2, and one repeats the history.
#
# Guess: the derivative of order 0.5 of the ramp t by GL is 2/sqrt(pi) at t = 1 within 1 % (it is, but not before), and the other
#   algorithms agree with it.
# Version: differint 1.0.0.
# Behaviour: GLI computes its coefficients for the order 0.5 and uses the given order only as the power of the step. GL multiplies
#   Fourier transforms of equal length without zeros after the history: the convolution is circular, and the end of the strain
#   acts before its start. With an odd number of points GL in addition returns one value fewer. RL is right.
# Output: strain of 1 % in 1 s, held until 10 s; springpot of order 0.2, 1000 points. Stress (in units of the springpot constant
#   times 1e-3) at 0.5, 0.9, 2, 5 and 10 s: exact and RL 6.17, 9.88, 7.95, 6.36, 5.48; GL 1.75, 6.52, 5.90, 5.56, 5.48,
#   and -19.6 at the start; GLI 1.97, 2.66, 1.18, 0.67, 0.46. With the order 0.5 GLI is right within 2 %.
# Documented: issue 21 (closed) calls the values of GL at the left end a side effect of the method. GLI: not found; the examples
#   in its docstring have the orders 0.5 and -0.5.
# Why it matters: paper and covers relax by a power of time with an exponent of 0.05 to 0.2. The stress by GL is right at the end
#   of the record and 72 % too small in the ramp; GLI passes each check that takes the order from the example.
# Remedy: RL; or scipy.signal.convolve with the coefficients of GLcoeffs.
. "$(dirname "$0")/environment" differint==1.0.0 numpy==2.4.6 scipy==1.17.1
python - <<'EOF'
from math import gamma

import numpy as np
from differint.differint import GL, GLI, RL, GLcoeffs
from scipy.signal import convolve

n = 1000
time = np.linspace(0, 10, n)
strain = 0.01 * np.minimum(time, 1.0)
rows = np.searchsorted(time, (0.5, 0.9, 2.0, 5.0, 10.0))


def stress(order):
    """Return the stress by each algorithm, divided by the exact one, at the rows, and all values of GL."""
    exact = 0.01 * (time ** (1 - order) - np.maximum(time - 1, 0) ** (1 - order)) / gamma(2 - order)
    linear = convolve(strain, GLcoeffs(order, n - 1))[:n] * time[1] ** -order
    found = {"GL": GL(order, strain, 0, 10, n), "GLI": GLI(order, strain, 0, 10, n)}
    found |= {"RL": RL(order, strain, 0, 10, n), "convolve": linear}
    print("order", order, "exact", 1e3 * exact[rows])
    for name, values in found.items():
        found[name] = np.ravel(values)
        print("  ", name, 1e3 * found[name][rows], "start", 1e3 * found[name][0])
    return {name: values[rows] / exact[rows] for name, values in found.items()}, found["GL"]


slow, circular = stress(0.2)
half, _ = stress(0.5)
odd = len(GL(0.2, strain[:-1], 0, time[-2], n - 1))
if not (
    np.allclose(slow["GL"], [0.283, 0.661, 0.742, 0.874, 1.0], atol=0.005)
    and np.allclose(slow["GLI"], [0.318, 0.269, 0.149, 0.105, 0.084], atol=0.005)
    and np.allclose(half["GLI"], 1, atol=0.03)
    and abs(circular[0] + 0.0196) < 1e-3
    and odd == n - 2
):
    raise SystemExit(f"changed: {slow}, {half}, {circular[0]}, {odd}")
if any(not np.allclose(ratios[name], 1, atol=0.01) for ratios in (slow, half) for name in ("RL", "convolve")):
    raise SystemExit(f"changed: RL or convolution: {slow}, {half}")
print("as stated")
EOF
