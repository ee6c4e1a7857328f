"""
Will the roll hold?
===================

A newsprint roll of 0.6 m diameter is wound with an ordinary schedule: 350 N/m of web tension that
falls by 30 %, 2 kN/m of nip load. Will its laps slip when the winder stops, will it star, block,
crush its core, or break the web? Each way to fail has a limit, and the result says how near the
roll is to it, where, and what the criterion does not know of.

**Answer:** it is wound too hard. The nip adds as much tension as the web brings, and near the core
the laps are pressed on each other, and along themselves, by more than the limits here allow. With a
third of the nip load the roll keeps all its limits. Slipping is no danger in either: friction could
carry more than ten times the torque of a stop.

The stack's constants are illustrative, and so are the limits: those of your own product come from
rolls that failed and rolls that did not.
"""

# %%
import matplotlib.pyplot as plt

import woundon as wo

limits = wo.Limits(
    torque_share=0.5,  # a safety of two against slipping
    acceleration=1.0,  # of the web at a stop by the core's brake [m/s^2]
    compression=400e3,
    blocking_pressure=600e3,
    core_pressure=1e6,  # as the core's maker gives it
    web_strength=1500.0,
    slack_tension=50.0,
)
problem = wo.WindingProblem.example().replace(radius=0.3, limits=limits)

# %%
# The winding solves the nip as the roll grows, and the roll that it leaves. A margin without a
# limit would be in the table too, as not checked.
hard = wo.solve(problem, rtol=5e-3)
print(hard.margins)

# %%
# Reserves are what is left of each limit. Below zero it is not kept.
hard.plot(panels=["reserves", "hoop_disc"])
plt.show()

# %%
# A third of the nip load:
soft = wo.solve(problem.replace(nip_load=700.0), rtol=5e-3)
for margin in soft.margins:
    print(f"{margin.name:12} {margin.verdict:10} {100 * margin.reserve:6.0f} % to spare")

# %%
wo.plot([hard, soft], panels=["tension", "pressure"], labels=["2000 N/m", "700 N/m"])
plt.show()

# sphinx_gallery_start_ignore
assert set(hard.margins.violated) == {"compression", "blocking"}
assert soft.margins.violated == ()
assert hard.torque_share < 0.1
assert soft.torque_share < 0.1
# sphinx_gallery_end_ignore
