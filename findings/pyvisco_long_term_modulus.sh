#!/usr/bin/env bash
# pyvisco: the default Prony fit of a solid is that of a fluid: no modulus is left after relaxation.
#
# Guess: the series fitted to the exact storage and loss moduli of a solid that lies within the measured frequencies follows
#   both within a few per cent, and E_0 (1 - sum of alpha) is the long-term modulus.
# Version: pyvisco 2.1.3.
# Behaviour: the collocation of prony.fit without opt=True divides the moduli by E_0 - E_inf and asks for a sum of 1; the
#   coefficients are used with E_0 afterwards. Their sum is 1, so that E_inf = 0, and every term is too large by
#   E_0/(E_0 - E_inf). opt=True, which the default serves as the initial guess, corrects it.
# Output: E_inf = 100 of E_0 = 1000 MPa: the storage modulus at the lowest frequency is 30 instead of 100 MPa, the loss modulus
#   48 instead of 1.3. E_inf = 500 of 1400 MPa: 159 instead of 500 MPa, 1033 instead of 940 in the middle. With opt=True the sums
#   are 0.900 and 0.643, and the moduli are exact to four digits.
# Why it matters: a rubber cover is a solid with half or more of its modulus left. The list (tau, alpha) goes to a finite
#   element or a contact program unchanged, where the cover flows under a steady load and dissipates at low frequencies.
# Remedy: opt=True; check that the sum of alpha is below 1.
. "$(dirname "$0")/environment" pyvisco==2.1.3 numpy==2.4.6 pandas==3.1.1 scipy==1.17.1
python -W ignore - <<'EOF'
import matplotlib
import numpy as np

matplotlib.use("Agg")
from pyvisco import load, master, prony

f = np.logspace(-3, 6, 91)
terms = ((200.0, 1.0), (300.0, 1e-2), (400.0, 1e-4))


def fitted(long_term, opt):
    """Return sum of alpha, and E' and E'' of the fit at the lowest and the middle frequency, then the exact ones."""
    exact = long_term + sum(E * 2j * np.pi * f * t / (1 + 2j * np.pi * f * t) for E, t in terms)
    rows = "\n".join(f"{x},{E.real},{E.imag}" for x, E in zip(f, exact))
    curve, _ = load.user_master(f"f,E_stor,E_loss\nHz,MPa,MPa\n{rows}".encode(), "freq", 20, "E")
    curve = master.smooth(curve, 1)
    found = next(part for part in prony.fit(prony.discretize(curve), curve, opt=opt) if isinstance(part, dict))
    alpha, tau = (found["df_terms"][name].to_numpy() for name in ("alpha_i", "tau_i"))
    w = 2j * np.pi * f[:, None] * tau
    E = found["E_0"] * (1 - alpha.sum() + (w / (1 + w)) @ alpha)
    print(long_term, opt, alpha.sum(), E[[0, 45]], exact[[0, 45]])
    return alpha.sum(), E[[0, 45]], exact[[0, 45]]


for long_term, wrong in ((100.0, 30.0), (500.0, 159.0)):
    total, E, _ = fitted(long_term, opt=False)
    if not (abs(total - 1) < 1e-9 and abs(E[0].real - wrong) < 1 and E[0].imag > 30):
        raise SystemExit(f"changed: sum {total}, modulus {E[0]}")
    total, E, exact = fitted(long_term, opt=True)
    if not (total < 0.91 and np.allclose(E, exact, rtol=1e-3)):
        raise SystemExit(f"changed: with opt=True sum {total}, moduli {E}")
print("as stated")
EOF
