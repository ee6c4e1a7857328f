"""
What tension gives a target pressure?
=====================================

A newsprint roll is to have the same pressure at the core and halfway, 200 kPa, and less towards
the surface, where the pressure is zero.

**Answer:** the first layers must be wound with 43 N/m, and the tension must reach 330 N/m
within 5 mm. Then it is constant, and decreases where the pressure is to decrease.
``wo.design_tension`` computes it without a search; the roll wound with this tension has the
target pressure within 0.1 %. The stack constants are illustrative.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

roll = wo.RollProblem.example()
target = wo.Profile(radius=[0.0445, 0.1, 0.13, 0.15], value=[200e3, 200e3, 160e3, 0.0])
design = wo.design_tension(roll, target)
wound = wo.solve(design.problem)
constant = wo.solve(roll)

tension, radius = np.array(design.tension.value), np.array(design.tension.radius)
deviation = np.abs(wound.at_radius(design.radius)["pressure"] - design.target_pressure).max()
print(
    f"{tension[0]:.0f} N/m at the core, at most {tension.max():.0f} N/m at r = "
    f"{1e3 * radius[tension.argmax()]:.1f} mm, {tension[-1]:.0f} N/m at the surface"
)
print(f"largest deviation {deviation / 200e3:.2%} of 200 kPa")

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.5), layout="constrained")
left.plot(1e3 * radius, tension, label="designed")
left.axhline(350, color="0.6", label="constant")
left.set(xlabel="radius [mm]", ylabel="wound-on tension [N/m]", ylim=(0, None))
right.plot(1e3 * design.radius, design.target_pressure / 1e3, label="target")
right.plot(1e3 * wound.radius, wound.pressure / 1e3, "--", label="wound with this tension")
right.plot(1e3 * constant.radius, constant.pressure / 1e3, color="0.6", label="at 350 N/m")
right.set(xlabel="radius [mm]", ylabel="pressure [kPa]", ylim=(0, None))
left.legend()
right.legend()
plt.show()

# sphinx_gallery_start_ignore
assert deviation < 1e-3 * 200e3
assert 41 < tension[0] < 46
assert 325 < np.interp(0.0495, radius, tension) < tension.max() < 350
# sphinx_gallery_end_ignore
