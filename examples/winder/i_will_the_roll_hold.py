"""
Will the roll hold?
===================

A newsprint roll of 0.6 m diameter is wound with a usual schedule: a web tension of 350 N/m that
decreases by 30 %, and a nip load of 2 kN/m. Do its layers slip when the winder stops, does it
star or block, does the core collapse, or the web break? Each defect has a limit, and the
margins state how near the roll is to it, where, and what the criterion neglects.

**Answer:** the roll is too hard. The nip adds as much tension as the web tension, and near the
core the pressure and the compression along the web exceed the limits of this example. With a
third of the nip load the roll keeps all limits. Slip is no danger in either case: friction
could carry more than ten times the torque of a stop.

The stack constants and the limits are illustrative; the limits of your own product come from
rolls that failed and rolls that did not.
"""

# %%
import matplotlib.pyplot as plt

import woundon as wo

limits = wo.Limits(
    torque_share=0.5,  # a safety factor of two against slip
    acceleration=1.0,  # of the web at a stop by the core brake [m/s^2]
    compression=400e3,
    blocking_pressure=600e3,
    core_pressure=1e6,  # given by the maker of the core
    web_strength=1500.0,
    slack_tension=50.0,
)
problem = wo.WindingProblem.example().replace(radius=0.3, limits=limits)

# %%
# The winding solves the nip as the roll grows, and the finished roll. A margin without a limit
# is listed as not checked.
hard = wo.solve(problem, rtol=5e-3)
print(hard.margins)

# %%
# Reserves are the distances from the limits. A negative reserve means that a limit is violated.
hard.plot(panels=["reserves", "hoop_disc"])
plt.show()

# %%
# A third of the nip load:
soft = wo.solve(problem.replace(nip_load=700.0), rtol=5e-3)
for margin in soft.margins:
    print(f"{margin.name:12} {margin.verdict:10} {100 * margin.reserve:6.0f} % reserve")

# %%
wo.plot([hard, soft], panels=["tension", "pressure"], labels=["2000 N/m", "700 N/m"])
plt.show()

# sphinx_gallery_start_ignore
assert set(hard.margins.violated) == {"compression", "blocking"}
assert soft.margins.violated == ()
assert hard.torque_share < 0.1
assert soft.torque_share < 0.1
# sphinx_gallery_end_ignore
