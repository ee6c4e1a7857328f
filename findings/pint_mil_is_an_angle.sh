#!/usr/bin/env bash
# pint: "mil" is an angle, "pli" and "ply" are lengths, "Nm" is a yarn count and "mPas" a pressure.
#
# Guess: mil is 0.001 inch, as in film gauges; pli (pounds per linear inch) is a line load or undefined; Nm and mPas are
#   the moment and the viscosity of data sheets, or undefined.
# Versions: pint 0.25.3, unyt 3.2.0, cf-units 3.3.1.
# Behaviour: mil is the angular mil of artillery, pi / 32 000 rad, dimensionless like every angle in pint; the length is called
#   thou. A name that is not defined is split into prefix, unit and plural s: p + li (a surveyor's link) is a picolink, p + ly a
#   picolight-year (9461 m), m + Pa + s a millipascal. Nm is defined: numero metrico, 1000 m/kg. "N/15mm" (tensile tests of
#   paper) is read from left to right as (N/15) mm.
# Output: 2 mil * 3 lbf/in is accepted as 6 lbf mil/in, to_base_units() 0.103 kg/s^2 instead of 0.0267 N; 1 mil to m and 1 pli
#   to N/m: DimensionalityError. unyt: mil is 2.54e-5 m and pli 175.1 N/m. UDUNITS (cf-units): mil is 2.54e-5 m.
# Why it matters: American data of webs are in mil and pli; because an angle is dimensionless, thickness in mil spoils
#   products (tension per thickness) and only a conversion to a length notices it.
# Remedy: thou, lbf/inch, N*m, mPa*s, N/(15 mm).
. "$(dirname "$0")/environment" pint==0.25.3 unyt==3.2.0 cf-units==3.3.1 numpy==2.4.6
python - <<'EOF'
import math

import cf_units
import pint
import unyt

units = pint.UnitRegistry()
pli = 4.4482216152605 / 0.0254


def check(observed, stated):
    print(observed)
    if not math.isclose(observed, stated, rel_tol=1e-6):
        raise SystemExit(f"changed: {observed} instead of {stated}")


def base(text):
    return units.Quantity(text).to_base_units().magnitude


for text in ("mil", "mrad"):
    if not units.Quantity(1, text).dimensionless:
        raise SystemExit(f"changed: {text} has a dimension")
check(base("1 mil"), math.pi / 32000)
check(base("2 mil * 3 lbf/inch"), 6 * math.pi / 32000 * pli)
check(base("1 thou"), 2.54e-5)
check(units.Quantity(1, "pli").to("m").magnitude, 1e-12 * 0.66 * 1200 / 3937)
check(units.Quantity(1, "ply").to("m").magnitude, 9460.730472580799)
check(units.Quantity(1, "Nm").to("m/kg").magnitude, 1000)
check(units.Quantity(1, "mPas").to("Pa").magnitude, 1e-3)
check(units.Quantity("20 N/15mm").to("N*mm").magnitude, 20 / 15)
check(float(unyt.unyt_quantity(1, "mil").to("m").value), 2.54e-5)
check(float(unyt.unyt_quantity(1, "pli").to("N/m").value), pli)
check(cf_units.Unit("mil").convert(1.0, "m"), 2.54e-5)
print("as stated")
EOF
