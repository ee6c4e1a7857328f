"""
What does the friction of the drum change?
==========================================

A worn, polished drum has less friction than a new, coated one. Does this change the roll?

**Answer:** not for friction coefficients of 0.2 and more. There the web sticks to the drum over
most of the nip, and more friction changes nothing. On a smoother drum the web slips backward,
and a few percent of the tension are lost. Friction determines how much torque the drum can
transmit.
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
