"""
Does nip load or web tension matter more?
=========================================

Both make a roll harder. How much does the wound-on tension change if one of them increases by
10 %?

**Answer:** in this case they matter about equally: 10 % more of either adds 3 to 5 %. They act
in different ways. The web tension is wound in completely, and the nip adds a tension that
hardly depends on the web tension.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

problem = wo.NipProblem.example().replace(roll_wrap=np.pi)
wound = wo.solve(problem).wound_on_tension
for name in ("nip_load", "web_tension"):
    more = problem.replace(**{name: 1.1 * getattr(problem, name)})
    change = wo.solve(more).wound_on_tension / wound - 1
    print(f"10 % more {name:12} changes the wound-on tension by {change:+.1%}")
    # sphinx_gallery_start_ignore
    assert 0.03 < change < 0.055
    # sphinx_gallery_end_ignore

# %%
# Over a range of both: the lines are straight and parallel, with a slope of one.
tensions = np.linspace(150, 600, 4)
for nip_load in (500, 1500, 3500, 6000):
    cases = [problem.replace(nip_load=nip_load, web_tension=T) for T in tensions]
    wound_on = [wo.solve(case).wound_on_tension for case in cases]
    plt.plot(tensions, wound_on, "o-", label=f"nip load {nip_load / 1e3:.1f} kN/m")
    slope = np.polyfit(tensions, wound_on, 1)[0]
    print(f"nip load {nip_load} N/m: {slope:.3f} N/m wound on for each N/m of web tension")
    # sphinx_gallery_start_ignore
    assert abs(slope - 1) < 0.05
    # sphinx_gallery_end_ignore
plt.xlabel("web tension upstream of the nip [N/m]")
plt.ylabel("wound-on tension [N/m]")
plt.legend()
plt.show()
