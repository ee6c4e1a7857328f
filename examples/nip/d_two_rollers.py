"""
How do two rollers without a web roll on each other?
====================================================

Two steel rollers of 0.25 m radius transmit a tangential load. How large is the creepage, and
which part of the contact slips? This is Carter's problem, which has a closed form.

**Answer:** the creepage grows faster than the load, and has a vertical tangent at the friction
limit. The solution agrees with the closed form within 0.1 %.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

roller = wo.HalfPlane(radius=0.25, material="steel")
pair = wo.RollerProblem(upper=roller, lower=roller, load=89e3, tangential_load=8.4e3, friction=0.5)
limit = pair.friction * pair.load
ratios = np.array([0.1, 0.3, 0.5, 0.7, 0.9, 0.98])
cases = [pair.replace(tangential_load=ratio * limit) for ratio in ratios]
solved = np.array([wo.solve(case).creepage for case in cases])
carter = np.array([wo.theories.carter(case).creepage for case in cases])
for ratio, xi, exact in zip(ratios, solved, carter, strict=True):
    print(
        f"{ratio:.0%} of the friction limit: creepage {1e3 * xi:.4f} ‰, Carter {1e3 * exact:.4f} ‰"
    )

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 3.5), layout="constrained")
left.plot(ratios, 1e3 * carter, label="Carter 1926")
left.plot(ratios, 1e3 * solved, "o", label="solved")
left.set(xlabel="tangential load / friction limit", ylabel="creepage [‰]")
left.legend()
result = wo.solve(pair.replace(tangential_load=0.5 * limit))
bound = pair.friction * result.pressure / 1e6
right.fill_between(1e3 * result.x, bound, alpha=0.2, label="friction bound")
right.plot(1e3 * result.x, result.traction / 1e6, label="traction at half the limit")
right.set(xlabel="position [mm]", ylabel="traction [MPa]")
right.legend(loc="lower center")
plt.show()

# sphinx_gallery_start_ignore
assert np.allclose(solved, carter, rtol=1e-3)
# sphinx_gallery_end_ignore
