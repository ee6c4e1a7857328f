"""
How hard does a newsprint roll become?
======================================

A roll of 1.2 m diameter is wound on a hard drum at 2 kN/m. What does the nip add to the web
tension as the roll grows, which stresses result, and what does a taper change?

**Answer:** the nip adds about 250 N/m to a web tension of 350 N/m, 10 % less for a large roll
than for a small one. At constant tension all layers but the outer ones are compressed along the
web, by about the pressure between them (the plateau of a wound roll). A taper of 40 % reduces
both by a quarter halfway to the surface. With the rule T_in + mu P the pressure would be 50 %
higher.

The web is that of the thesis's Table 2; the stack constants K1 and K2 are illustrative.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

problem = wo.WindingProblem.example()
constant = wo.solve(problem.replace(web_tension=350.0), rtol=5e-3)
taper = wo.solve(problem.replace(web_tension=wo.Taper(start=350.0, taper=0.4)), rtol=5e-3)
slipping = wo.solve(problem.replace(web_tension=350.0, tension_law="friction"), rtol=5e-3)
print(taper)

# %%
cases = {"constant": constant, "taper of 40 %": taper, "constant, T_in + mu P": slipping}
figure, panels = plt.subplots(1, 3, figsize=(12, 3.8), layout="constrained")
for name, run in cases.items():
    r = np.linspace(run.radius[0], run.radius[-1], 400)
    roll = run.roll.at_radius(r)
    (line,) = panels[0].plot(run.radius * 1e3, run.wound_on_tension, label=name)
    panels[0].plot(run.radius * 1e3, run.web_tension, ":", color=line.get_color())
    panels[1].plot(r * 1e3, roll["pressure"] / 1e3)
    panels[2].plot(r * 1e3, roll["hoop_stress"] / 1e3)
panels[0].set(xlabel="radius [mm]", ylabel="wound-on and web (dotted) tension [N/m]")
panels[1].set(xlabel="radius [mm]", ylabel="pressure between the layers [kPa]")
panels[2].set(xlabel="radius [mm]", ylabel="hoop stress [kPa]", ylim=(-1200, 600))
panels[0].set_ylim(bottom=0)
panels[0].legend()
plt.show()

# %%
# The nip-induced tension decreases as the roll grows, because the contact becomes wider.
for r in (0.07, 0.1, 0.2, 0.4, 0.6):
    added = np.interp(r, constant.radius, constant.nip_induced_tension)
    print(f"{2 * r:4.2f} m diameter: {added:5.1f} N/m added")

# sphinx_gallery_start_ignore
assert 230 < constant.mean_nip_induced_tension < 270
assert 0.87 < constant.nip_induced_tension[-1] / constant.nip_induced_tension.max() < 0.93
half = {name: run.mid_pressure for name, run in cases.items()}
assert 0.72 < half["taper of 40 %"] / half["constant"] < 0.82
assert 1.4 < half["constant, T_in + mu P"] / half["constant"] < 1.6
inside = constant.roll.at_radius(0.3)
assert abs(inside["hoop_stress"] + inside["pressure"]) < 0.1 * inside["pressure"]
# sphinx_gallery_end_ignore
