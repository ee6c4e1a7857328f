"""
What friction coefficient does my load cell imply?
==================================================

A load cell downstream of the nip measures the wound-on tension. At light load friction between
the layers limits the tension that the nip adds, so measurements at light load should determine
the friction coefficient. The values are those of Jorkama (2001, Table 3) for newsprint at 350
and 876 N/m and three web tensions.

**Answer:** at least about 0.2. The best fit is 0.3, but all values from 0.25 on fit as well:
the RMS deviation is constant there, 12 N/m, which is the scatter of the measurements. For a
better value use a friction tester, or measure at lighter loads and more often.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

problem = wo.NipProblem.example().replace(roll_wrap=np.pi)
readings = {
    "nip_load [N/m]": [350, 350, 350, 876, 876, 876],
    "web_tension [N/m]": [175, 263, 350, 175, 263, 350],
    "wound_on_tension [N/m]": [266, 327, 410, 316, 416, 482],
}
vary = {"roll_friction": (0.05, 0.6)}
fit = wo.fit(problem, readings, vary, nodes=25, starts=1, profiles=False)
print(*fit.lines(), sep="\n")

# %%
# RMS deviation of measured and computed values over the friction coefficient:
frictions = np.array([0.06, 0.1, 0.15, 0.2, 0.25, 0.35, 0.5])
loads, tensions, measured = (np.array(column) for column in readings.values())
over = {"nip_load": [350, 876], "web_tension": [175, 263, 350], "roll_friction": frictions}
computed = wo.sweep(problem, over, ["wound_on_tension"], nodes=25, workers=1).wound_on_tension
deviations = measured[:, None] - computed.values.reshape(6, -1)
rms = np.sqrt(np.mean(deviations**2, axis=0))
plt.plot(frictions, rms, "o-")
plt.axvline(fit.problem.roll_friction, color="grey", linestyle=":", label="best fit")
plt.ylim(0)
plt.xlabel("friction between the layers")
plt.ylabel("RMS deviation [N/m]")
plt.legend()
plt.show()

# sphinx_gallery_start_ignore
assert 0.25 < fit.problem.roll_friction < 0.35
assert np.all(rms[frictions < 0.2] > 2 * rms.min())
assert np.all(rms[frictions >= 0.25] < 1.1 * rms.min())
# sphinx_gallery_end_ignore
