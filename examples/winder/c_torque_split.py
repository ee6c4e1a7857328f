"""
How should I split the torque between core and drum?
====================================================

The roll can be driven at its core (centre winding), by the drum (surface winding), or by both.
The force that the drum exerts on the web is the winding force *F*: zero in centre winding,
minus the web tension in surface winding, positive if the drum brakes.

**Answer:** the more the drum drives, the lower is the wound-on tension: from centre to surface
winding it decreases by about a quarter. A braking drum increases it. At a given nip load the
winding force has the largest influence on the wound-on tension of all settings.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

problem = wo.NipProblem.example().replace(roll_wrap=np.pi)
limit = problem.drum_friction * problem.nip_load  # beyond it the web slips on the whole drum
print(f"friction lets the drum transmit up to {limit:.0f} N/m")

for drive, force in (("surface", -problem.web_tension), ("half and half", -175.0), ("centre", 0.0)):
    result = wo.solve(problem.replace(winding_force=force))
    print(f"{drive:14} F = {force:5.0f} N/m: {result.wound_on_tension:.0f} N/m wound on")

# %%
forces = np.linspace(-0.9, 0.9, 13) * limit
results = [wo.solve(problem.replace(winding_force=force)) for force in forces]
plt.plot(forces, [result.wound_on_tension for result in results], label="wound-on tension")
plt.plot(forces, [result.outlet_tension for result in results], "--", label="at the trailing edge")
for name, force in (("surface\nwinding", -problem.web_tension), ("centre\nwinding", 0.0)):
    plt.axvline(force, color="grey", linestyle=":")
    plt.text(force + 8, 380, name)
plt.xlabel("winding force F [N/m]   (drum drives < 0 < drum brakes)")
plt.ylabel("tension of the web [N/m]")
plt.legend()
plt.show()

# sphinx_gallery_start_ignore
centre, surface = (
    wo.solve(problem.replace(winding_force=F)).wound_on_tension for F in (0.0, -350.0)
)
assert 0.2 < 1 - surface / centre < 0.3
# sphinx_gallery_end_ignore
