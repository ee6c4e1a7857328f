"""
What nip load do I need?
========================

A web arrives with 350 N/m, and the roll is to be wound with 600 N/m. Which nip load achieves
this?

**Answer:** about 2.2 kN/m, for this newsprint on this drum.
"""

# %%
# The case in full. All values are in SI units: m, N/m, Pa, rad.
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

newsprint = wo.Orthotropic(radial=27e6, tangential=3.38e9, cross=5e6, shear=10e6)
problem = wo.NipProblem(
    web=wo.Web(thickness=66e-6, material=newsprint),
    roll=wo.Cylinder(radius=0.1, core_radius=0.0445, material=newsprint),
    drum=wo.Rigid(radius=0.0762),
    roll_friction=0.19,
    drum_friction=0.2,
    nip_load=3502,
    web_tension=350,
    roll_wrap=np.pi,
)

# %%
# ``wo.find`` varies a field until an output reaches its target.
target = 600.0
found = wo.find(problem, "nip_load", wound_on_tension=target)
print(f"nip load {found.value:.0f} N/m: wound-on tension {found.result.wound_on_tension:.0f} N/m")

# %%
loads = np.linspace(250, 6000, 12)
tensions = [wo.solve(problem.replace(nip_load=load)).wound_on_tension for load in loads]
plt.plot(loads / 1e3, tensions)
plt.plot(found.value / 1e3, target, "o", label=f"{found.value / 1e3:.2f} kN/m")
plt.axhline(
    problem.web_tension, color="grey", linestyle=":", label="web tension upstream of the nip"
)
plt.xlabel("nip load [kN/m]")
plt.ylabel("wound-on tension [N/m]")
plt.legend()
plt.show()

# sphinx_gallery_start_ignore
assert 2100 < found.value < 2250
# sphinx_gallery_end_ignore
