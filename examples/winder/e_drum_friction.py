"""
What does the drum's friction do?
=================================

A worn, polished drum grips less than a new, coated one. Does the roll notice?

**Answer:** not above some grip. From a friction coefficient of 0.2 on, the web sticks to the
drum over most of the nip, and more grip changes nothing. A smoother drum lets the web slip
back, and a few percent of the tension are lost. What friction does decide is how much torque
the drum can transmit.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

problem = wo.NipProblem.example().replace(roll_wrap=np.pi)
frictions = np.array([0.05, 0.075, 0.1, 0.125, 0.15, 0.175, 0.2, 0.3, 0.4, 0.6])
results = [wo.solve(problem.replace(drum_friction=mu)) for mu in frictions]
wound = np.array([result.wound_on_tension for result in results])
for mu, T in zip(frictions, wound, strict=True):
    print(
        f"drum friction {mu:.3f}: {T:.0f} N/m wound on, transmits {mu * problem.nip_load:.0f} N/m"
    )

# %%
plt.plot(frictions, wound, "o-")
plt.axvline(
    problem.roll_friction, color="grey", linestyle=":", label="friction between paper and paper"
)
plt.xlabel("friction between web and drum")
plt.ylabel("wound-on tension [N/m]")
plt.legend()
plt.show()

# sphinx_gallery_start_ignore
assert np.ptp(wound[frictions >= 0.2]) < 0.5 < wound[6] - wound[0]
# sphinx_gallery_end_ignore
