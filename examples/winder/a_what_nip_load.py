"""
What nip load do I need?
========================

A roll is to be wound at 350 N/m of web tension, and to keep 600 N/m. Which nip load does that?
The wound-on tension grows with the nip load without a jump, so that a root finder gives the
answer.

**Answer:** about 2.2 kN/m, for this newsprint on this drum.
"""

# %%
# The case in full. All values are in SI units: m, N/m, Pa, rad.
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import brentq

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
# ``replace`` makes a variant, ``solve`` solves it.
wanted = 600.0


def wound_on_tension(nip_load):
    return wo.solve(problem.replace(nip_load=nip_load)).wound_on_tension


answer = brentq(lambda load: wound_on_tension(load) - wanted, 500, 5000, xtol=1.0)
print(f"a nip load of {answer:.0f} N/m winds {wound_on_tension(answer):.0f} N/m into the roll")

# %%
loads = np.linspace(250, 6000, 12)
plt.plot(loads / 1e3, [wound_on_tension(load) for load in loads])
plt.plot(answer / 1e3, wanted, "o", label=f"{answer / 1e3:.2f} kN/m")
plt.axhline(problem.web_tension, color="grey", linestyle=":", label="web tension before the nip")
plt.xlabel("nip load [kN/m]")
plt.ylabel("wound-on tension [N/m]")
plt.legend()
plt.show()

# sphinx_gallery_start_ignore
assert 2100 < answer < 2250
# sphinx_gallery_end_ignore
