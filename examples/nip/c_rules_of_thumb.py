"""
How accurate are the usual rules of thumb?
==========================================

Three formulas are common for the tension that a nip adds: friction, µ *P*; Jalkanen's kinematic
formula; and the dual-slip formula with a known length of slip.

**Answer:** µ *P* is accurate below about 300 N/m and too high for heavier nips, at 6 kN/m by
more than a factor of two, because the web sticks in a part of the nip. Jalkanen's formula is a
third too high at light load and twice too high at heavy load. The dual-slip formula is close to
the tension generated inside the nip, but requires the length of slip, which only a solution
provides.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

problem = wo.NipProblem.example().replace(roll_wrap=np.pi)
loads = np.geomspace(200, 6000, 9)
rows = []
for load in loads:
    case = problem.replace(nip_load=load)
    result = wo.solve(case)
    rows.append(
        {
            "solved: added to the web tension": result.nip_induced_tension,
            "solved: inside the nip": result.outlet_tension - result.inlet_tension,
            "µ P": wo.theories.friction_limit(case),
            "Jalkanen": wo.theories.jalkanen(case, result.approach),
            "dual slip": float(wo.theories.dual_slip(case, result.dual)),
        }
    )
for load, row in zip(loads, rows, strict=True):
    print(f"P = {load:4.0f} N/m:", ", ".join(f"{name} {T:.0f}" for name, T in row.items()))

# %%
for name in rows[0]:
    style = "-" if name.startswith("solved") else "--"
    plt.plot(loads / 1e3, [row[name] for row in rows], style, label=name)
plt.xlabel("nip load [kN/m]")
plt.ylabel("tension added by the nip [N/m]")
plt.legend()
plt.show()

# sphinx_gallery_start_ignore
ratios = np.array(
    [[T / row["solved: added to the web tension"] for T in row.values()] for row in rows]
)
assert abs(ratios[0, 2] - 1) < 0.1
assert ratios[-1, 2] > 2
assert 1.2 < ratios[0, 3] < 1.4
assert 1.9 < ratios[-1, 3] < 2.1
assert all(abs(row["dual slip"] / row["solved: inside the nip"] - 1) < 0.09 for row in rows)
# sphinx_gallery_end_ignore
