"""
Is the wrap on the roll important?
==================================

The model of the thesis ends at the trailing edge of the nip and holds the web to the roll there
(``roll_wrap=0``). In reality the web lies on the roll downstream of the nip, by default for
half a turn (``roll_wrap=pi``), and continues to slip for a few degrees. How much do the
wound-on tensions differ?

**Answer:** solve the nip with the roll wrap. Without it there are two values: the tension at
the trailing edge, which is too low, and the estimate of thesis eq. (183), in which the web
sticks to the roll downstream of the nip, which is too high. The solution with the wrap lies
between them.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo
from woundon.jorkama2001.estimate import wound_on_tension_estimate

wrapped = wo.NipProblem.example().replace(roll_wrap=np.pi)
unwrapped = wrapped.replace(roll_wrap=0.0)  # the web is held at the trailing edge
loads = np.geomspace(300, 8000, 9)
table = []
for load in loads:
    far = wo.solve(wrapped.replace(nip_load=load)).wound_on_tension
    nip = wo.solve(unwrapped.replace(nip_load=load))
    table.append((nip.outlet_tension, far, wound_on_tension_estimate(nip)))
    print("P = {:4.0f} N/m: edge {:.0f}, wrapped {:.0f}, (183) {:.0f} N/m".format(load, *table[-1]))
edge, wound_on, estimate = np.array(table).T

# %%
plt.fill_between(loads / 1e3, edge, estimate, alpha=0.2, label="trailing edge to estimate")
plt.plot(loads / 1e3, wound_on, label="wrapped: wound-on tension")
plt.xlabel("nip load [kN/m]")
plt.ylabel("tension [N/m]")
plt.legend()
plt.show()

# sphinx_gallery_start_ignore
assert np.all((edge < wound_on) & (wound_on < estimate))
# sphinx_gallery_end_ignore
