"""
Where does the web slip, and how fast?
======================================

In the nip the web sticks to the roll and to the drum in some zones and slips in others. The
solution contains these zones, the slip speeds relative to the web speed, and the *creepage* of
web and drum.

**Answer:** on the roll the web slips backward over the first eighth of the nip, then sticks,
then slips forward over more than half of the nip. The slip speeds are at most 0.2 % of the web
speed; at 20 m/s this is 4 cm/s, enough to smear ink.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

result = wo.solve(wo.NipProblem.example().replace(roll_wrap=np.pi))
print(
    f"slip on the roll: first {abs(result.leading_roll):.0%} "
    f"and last {result.trailing_roll:.0%} of the nip"
)
print(f"both faces slip over the last {result.dual:.0%}")
print(f"slip continues downstream of the nip for {np.degrees(result.slip_angle):.1f} degrees")
fastest = np.abs(result.roll_slip).max()
print(
    f"largest slip speed on the roll: {fastest:.2%} of the web speed, "
    f"at 20 m/s {2000 * fastest:.1f} cm/s"
)
print(f"creepage of web and drum {result.drum_creepage:.3%}")

# %%
# Tractions with their friction bounds (the web slips where a line meets the edge of the shaded
# area), slip speeds, tension, and the zones of stick and slip. On the right: the web on the
# roll downstream of the nip.
result.plot()
plt.show()

# sphinx_gallery_start_ignore
assert 0.11 < abs(result.leading_roll) < 0.14
assert 0.55 < result.trailing_roll < 0.65
assert 0.0015 < fastest < 0.0025
# sphinx_gallery_end_ignore
