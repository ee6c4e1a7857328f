"""
How uncertain is my wound-on tension?
=====================================

The inputs are not known exactly. Sixty samples of them are drawn from their ranges and solved.
The correlation of the result with each input shows which input to measure better.

**Answer:** with moduli and friction known within 20 %, the wound-on tension is known within
about 5 %. The three moduli of the paper cause most of the spread, friction the least.
``wo.global_sensitivity`` computes Sobol indices with more solutions.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

ranges = {
    "roll_friction": (0.15, 0.23),
    "roll.material.radial": (22e6, 32e6),
    "roll.material.tangential": (2.7e9, 4.1e9),
    "roll.material.shear": (8e6, 12e6),
}
drawn = wo.sweep(
    wo.NipProblem.example().replace(roll_wrap=np.pi),
    ranges,
    design="latin-hypercube",
    samples=60,
    seed=1,
    tie={"web.material": "roll.material"},  # web and roll are the same paper
    nodes=33,
)
wound = drawn.wound_on_tension.values
low, high = np.quantile(wound, [0.05, 0.95])
print(f"mean {np.mean(wound):.0f} N/m, 90 % between {low:.0f} and {high:.0f} N/m")

correlations = {name: np.corrcoef(drawn[name], wound)[0, 1] for name in ranges}
for name, correlation in correlations.items():
    print(f"{name:25} correlation {correlation:+.2f}")

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.5), layout="constrained")
left.hist(wound, bins=12)
left.axvspan(low, high, alpha=0.15, label="90 %")
left.set(xlabel="wound-on tension [N/m]", ylabel="cases")
left.legend()
right.barh(list(correlations), list(correlations.values()))
right.axvline(0, color="black", linewidth=0.8)
right.set(xlabel="correlation with the wound-on tension")
plt.show()

# sphinx_gallery_start_ignore
assert 0.03 < (high - low) / 2 / np.mean(wound) < 0.06
assert min(correlations, key=lambda name: abs(correlations[name])) == "roll_friction"
# sphinx_gallery_end_ignore
