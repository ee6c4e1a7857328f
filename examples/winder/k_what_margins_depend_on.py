"""
Which inputs do the margins depend on?
======================================

Stack constants, friction and the stiffness of the core are never known exactly. Which of them
must be known to decide whether the roll holds? The margins are outputs, so
``wo.global_sensitivity`` computes the share of their variance that each uncertain input
explains.

**Answer:** the friction between the layers, which determines the tension that the nip adds and
the slip capacity. The hardening of the stack (K2) is next, and equally important for the
pressure. The stiffness of the core, within a factor of three, matters only for the pressure on
the core.

With sixteen base samples the indices are accurate to about 0.3, which is enough to decide what
to measure first. ``woundon sobol`` does the same for a study file, on all cores, and can
be resumed.
"""

# %%
import matplotlib.pyplot as plt

import woundon as wo

# a small roll with the rule T_in + mu P, to save time
problem = wo.WindingProblem.example().replace(radius=0.15, tension_law="friction")
ranges = {
    "stack.radial.K2": (30.0, 50.0),
    "roll_friction": (0.15, 0.23),
    "core.stiffness": (5e8, 1.5e9, "log"),
}
indices = wo.global_sensitivity(
    problem,
    ranges,
    ["torque_share", "largest_compression", "peak_pressure"],
    samples=16,
    workers=1,
    options={"rtol": 3e-2, "nodes": 33},
)
print(indices)

# %%
indices.plot()
plt.show()

# sphinx_gallery_start_ignore
total = {
    output: dict(zip(indices.inputs, row, strict=True))
    for output, row in zip(indices.outputs, indices.total_order, strict=True)
}
assert all(min(shares, key=shares.get) == "core.stiffness" for shares in total.values())
assert max(total["torque_share"], key=total["torque_share"].get) == "roll_friction"
# sphinx_gallery_end_ignore
