#!/usr/bin/env bash
# scipp: a caliper of 53 um in whole numbers is 0 mm.
#
# Guess: a conversion of units keeps the quantity: 53 um becomes 0.053 mm, as in pint, also for integers, or is refused.
# Versions: scipp 26.8.0, pint 0.25.3 for comparison.
# Behaviour: to(unit=) keeps the type and rounds to whole numbers of the new unit, without a message; with dtype="float64" in
#   the same call the conversion is exact. Sums and products of the rounded quantity then have the right unit.
# Output: 53, 78 and 499 um are 0, 0 and 0 mm, 501 um is 1 mm; 1749 ms is 2 s; web tension of 203 N/m is 0 kN/m. pint: 0.053 mm.
# Documented: the type is kept on purpose for times (pull request 2533); a warning about rounding was not found.
# Why it matters: profile scanners and counters deliver whole numbers. Stack height from the count of layers and the caliper in
#   mm is 0, and a time axis in s has steps.
# Remedy: to(unit="mm", dtype="float64").
. "$(dirname "$0")/environment" scipp==26.8.0 pint==0.25.3 numpy==2.4.6
python - <<'EOF'
import numpy as np
import pint
import scipp as sc


def converted(values, unit, new):
    """Return the values by scipp as they are, by scipp with a type, and by pint."""
    quantity = sc.array(dims=["row"], values=values, unit=unit)
    by_pint = pint.UnitRegistry().Quantity(np.array(values), unit).to(new).magnitude
    return quantity.to(unit=new).values.tolist(), quantity.to(unit=new, dtype="float64").values, by_pint


cases = {
    ("um", "mm"): ([53, 78, 499, 501], [0, 0, 0, 1]),
    ("ms", "s"): ([1249, 1749], [1, 2]),
    ("N/m", "kN/m"): ([203], [0]),
}
for (unit, new), (values, stated) in cases.items():
    observed, typed, by_pint = converted(values, unit, new)
    print(values, unit, observed, typed, by_pint, new)
    if observed != stated or not np.allclose(typed, by_pint) or not np.allclose(by_pint, np.array(values) / 1000):
        raise SystemExit(f"changed: {values} {unit} are {observed} {new}; with a type {typed}; pint {by_pint}")
print("as stated")
EOF
