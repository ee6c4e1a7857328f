"""
What does the roll's own weight do on a two-drum winder?
========================================================

Newsprint wound to 1.2 m diameter on two drums of 0.5 m, a rider roll on top. The roll lies on both
nips, and its weight grows with the square of its radius.

**Answer:** under a constant rider of 2.5 kN/m the load of the front nip falls from 2.5 to 1.9 kN/m,
for the roll comes to lie higher between the drums, and then grows to 5.2 kN/m with the weight: the
roll gets harder outwards, from 0.8 to 1.4 MPa. To keep the nip at 3 kN/m the
rider must be relieved from 3 kN/m to nothing at a radius of 0.52 m; from there on the roll is
heavier than wanted, 3.9 kN/m at last. Then it is hard at the core and softer outwards, as it should
be. The tension is here by the simple law T_in + mu N, which tells too much, to see what the loads
do.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo
from woundon.problems.two_drums import drum_loads, rider_load_for, roll_weight

density, core, drums, gap = 680.0, 0.05, 0.25, 0.02
r = np.linspace(core, 0.6, 60)
weight = roll_weight(r, core, density)

constant = drum_loads(r, weight, drums, gap, rider_load=2500.0).front
rider = rider_load_for(3000.0, r, weight, drums, gap, drum="front")
relieved = drum_loads(r, weight, drums, gap, rider_load=np.maximum(rider, 0.0)).front

winding = wo.WindingProblem.example().replace(
    radius=0.6, core=wo.Core(radius=core, stiffness=1e9), tension_law="friction", density=density
)
wound = {}
for name, loads in (("constant rider", constant), ("rider relieved", relieved)):
    schedule = wo.Profile(radius=r, value=loads)
    wound[name] = wo.solve(winding.replace(nip_load=schedule))
    print(
        f"{name}: nip {loads[0]:.0f} to {loads.max():.0f} N/m, pressure half-way "
        f"{wound[name].roll.mid_pressure / 1e3:.0f} kPa"
    )
light = r[rider > 0][-1]
print(f"for 3 kN/m: rider {rider[0]:.0f} N/m at the core, none from {light:.2f} m on")

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.5), layout="constrained")
for name, loads in (("constant rider", constant), ("rider relieved", relieved)):
    left.plot(1e3 * r, loads / 1e3, label=name)
    roll = wound[name].roll
    right.plot(1e3 * roll.radius, roll.pressure / 1e3, label=name)
left.set(xlabel="radius [mm]", ylabel="load of the front nip [kN/m]", ylim=(0, None))
right.set(xlabel="radius [mm]", ylabel="pressure [kPa]", ylim=(0, None))
left.legend()
right.legend()
plt.show()

# sphinx_gallery_start_ignore
assert 2500 < constant[0] < 2510
assert 5200 < constant[-1] < 5300
assert 2980 < rider[0] < 3000
assert 0.51 < light < 0.54
inner, outer = (
    {name: run.roll.at_radius(place)["pressure"] for name, run in wound.items()}
    for place in (0.1, 0.5)
)
assert 0.75e6 < inner["constant rider"] < 0.9e6
assert 1.35e6 < outer["constant rider"] < 1.5e6
assert inner["rider relieved"] > 1.2 * outer["rider relieved"]
assert 3900 < relieved[-1] < 3960
# sphinx_gallery_end_ignore
