"""
How does the wound-on tension change as the roll grows?
=======================================================

At constant web tension and nip load, the diameter of the roll grows from 120 mm to 1.5 m.

**Answer:** the wound-on tension decreases slowly, by less than 10 % in total, because the same
load strains the surface of a larger roll less. For a constant wound-on tension increase the nip
load slightly as the roll grows.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

problem = wo.NipProblem.example().replace(roll_wrap=np.pi)
radii = np.geomspace(0.06, 0.75, 9)
results = [wo.solve(problem.replace(**{"roll.radius": radius})) for radius in radii]
wound = np.array([result.wound_on_tension for result in results])
width = np.array([result.nip_width for result in results])
for radius, T, nip in zip(radii, wound, width, strict=True):
    print(f"roll of {2e3 * radius:5.0f} mm: {T:.0f} N/m wound on, nip {1e3 * nip:.1f} mm wide")
print(f"in total {wound[-1] / wound[0] - 1:+.1%}")

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.5), layout="constrained")
left.plot(2 * radii, wound)
left.set(xlabel="diameter of the roll [m]", ylabel="wound-on tension [N/m]")
right.plot(2 * radii, 1e3 * width)
right.set(xlabel="diameter of the roll [m]", ylabel="nip width [mm]")
plt.show()

# sphinx_gallery_start_ignore
assert np.all(np.diff(wound[1:]) < 0)
assert 0.9 < wound[-1] / wound[0] < 0.95
# sphinx_gallery_end_ignore
