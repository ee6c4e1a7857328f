"""
What friction coefficient does my load cell imply?
==================================================

A load cell behind the nip reads the wound-on tension. At light load it is friction between the
layers that limits what the nip adds; so readings at light load should tell the coefficient. The
readings are those that Jorkama (2001, Table 3) took on newsprint at 350 and 876 N/m, for three
web tensions.

**Answer:** at least about 0.2. The best fit is 0.3, but anything from 0.25 on fits as well: the
misfit is flat there, at 12 N/m, which is the scatter of the readings. To know the coefficient
better, measure it on a friction tester, or read the load cell at lighter loads and more often.
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
fit = wo.fit(problem, readings, {"roll_friction": (0.05, 0.6)}, nodes=25, starts=1, profiles=False)
print(*fit.lines(), sep="\n")

# %%
# The root mean square of reading less computed value, over the friction coefficient.
frictions = np.array([0.06, 0.1, 0.15, 0.2, 0.25, 0.35, 0.5])
loads, tensions, measured = (np.array(column) for column in readings.values())
over = {"nip_load": [350, 876], "web_tension": [175, 263, 350], "roll_friction": frictions}
computed = wo.sweep(problem, over, ["wound_on_tension"], nodes=25, workers=1).wound_on_tension
misses = measured[:, None] - computed.values.reshape(6, -1)
misfits = np.sqrt(np.mean(misses**2, axis=0))
plt.plot(frictions, misfits, "o-")
plt.axvline(fit.problem.roll_friction, color="grey", linestyle=":", label="best fit")
plt.ylim(0)
plt.xlabel("friction between the layers")
plt.ylabel("misfit, root mean square [N/m]")
plt.legend()
plt.show()

# sphinx_gallery_start_ignore
assert 0.25 < fit.problem.roll_friction < 0.35
assert np.all(misfits[frictions < 0.2] > 2 * misfits.min())
assert np.all(misfits[frictions >= 0.25] < 1.1 * misfits.min())
# sphinx_gallery_end_ignore
