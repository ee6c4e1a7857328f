"""
Which inputs do the margins feel?
=================================

Stack constants, friction and the core's stiffness are never known well. Which of them must be, to
know whether the roll holds? The margins are outputs like any other, so ``wo.global_sensitivity``
tells the share of their variance that each uncertain input explains.

**Answer:** the friction between the layers, which makes the tension that the nip adds and holds
the laps besides. How the stack hardens (K2) comes next, and matters as much for the pressure. The
core's stiffness, within a factor of three, matters for the pressure at the core alone.

With sixteen base samples the shares are good to about 0.3: enough to say what to measure first.
With ``woundon sensitivity`` the same is done from a file, over all processors, and can be resumed.
"""

# %%
import matplotlib.pyplot as plt

import woundon as wo

# a small roll, its tension by the rule T_in + mu P, so that a case takes no time
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
