"""
What schedule is best?
======================

A roll should be as tight as it may be, and keep its limits. Which taper of the web tension, and
which nip load, does that? ``wo.optimise_schedule`` winds one roll after the other, and moves the
schedule to where the goal is best with all limits kept.

**Answer:** far less nip load than the start has, and hardly a taper. What holds the tension back is
the compression of the laps alone; the goal is flat along a valley, for a little less nip load and
a little more tension wind the same roll.

So that it is quick, the tension is taken by the old rule T_in + mu P here (``tension_law``). The
rule does not know that the nip's tension changes with the radius, so a tenth of the limit that
binds is left to it, and the answer is wound once more with the nip solved.
"""

# %%
import matplotlib.pyplot as plt

import woundon as wo

limits = wo.Limits(
    torque_share=0.5,
    acceleration=1.0,
    compression=400e3,
    blocking_pressure=600e3,
    core_pressure=1e6,
    web_strength=1500.0,
    slack_tension=50.0,
)
problem = wo.WindingProblem.example().replace(radius=0.3, limits=limits)
by_rule = problem.replace(tension_law="friction", **{"limits.compression": 0.9 * 400e3})

# %%
best = wo.optimise_schedule(
    by_rule,
    {"web_tension.taper": (0.0, 0.6), "nip_load": (500.0, 4000.0)},
    maximise="mean_wound_on_tension",
    evaluations=30,
    options={"rtol": 5e-3},
)
print(best)

# %%
best.plot(panels=["tension", "hoop_stress", "reserves"])
plt.show()

# %%
# With the nip solved, by the limits as they are:
wound = wo.solve(best.problem.replace(tension_law="nip", limits=limits))
print(wound.margins)

# sphinx_gallery_start_ignore
assert best.feasible
assert best.binding == ("compression",)
assert wound.margins.violated == ()
# sphinx_gallery_end_ignore
