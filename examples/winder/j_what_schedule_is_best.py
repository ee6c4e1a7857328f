"""
What schedule is best?
======================

A roll is to be as tight as its limits permit. Which taper of the web tension, and which nip
load, achieve this? ``wo.optimise_schedule`` computes one winding after the other and improves
the schedule.

**Answer:** a much lower nip load than the initial one, and hardly any taper. The compression
along the web limits the tension; the objective is flat along a combination of nip load and web
tension.

To save time, the tension follows the rule T_in + mu P here (``tension_law``). This rule
neglects that the nip-induced tension changes with the radius, so 10 % of the binding limit is
reserved for it, and the result is computed once more with the nip solved.
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
# With the nip solved and the original limits:
wound = wo.solve(best.problem.replace(tension_law="nip", limits=limits))
print(wound.margins)

# sphinx_gallery_start_ignore
assert best.feasible
assert best.binding == ("compression",)
assert wound.margins.violated == ()
# sphinx_gallery_end_ignore
