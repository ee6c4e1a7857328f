"""
What does the weight of the roll change on a two-drum winder?
=============================================================

Newsprint is wound to a diameter of 1.2 m on two drums with diameters of 0.6 m (rear) and 0.5 m
(front), with a rider roll on top. The web arrives on the rear drum, so the load on the rear
drum is the nip load of the winding.

**Answer:** under a constant rider load of 2.5 kN/m the load on the rear drum first falls from
2.5 to 1.8 kN/m, because the roll rises between the drums, and then grows to 4.0 kN/m with the
square of the radius. The roll becomes harder towards the outside: the pressure rises from 0.75
MPa at a radius of 0.2 m to 1.1 MPa at 0.45 m. The front drum carries more, 6.5 kN/m at the end.
To keep the nip load at 2.5 kN/m the rider load must decrease from 2.5 kN/m to zero at a radius
of 0.53 m; beyond this radius the weight alone gives more, 3.0 kN/m at the end. The roll is then
hardest at the core. The tension follows the simple law T_in + mu N, which is an upper bound, in
order to show the effect of the loads.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo
from woundon.problems.two_drums import drum_loads, rider_load_for, roll_weight

density, core, gap = 680.0, 0.05, 0.02
rear, front = drums = 0.3, 0.25  # radii; the web arrives on the rear drum
r = np.linspace(core, 0.6, 60)
weight = roll_weight(r, core, density)

constant = drum_loads(r, weight, drums, gap, rider_load=2500.0).rear
rider = rider_load_for(2500.0, r, weight, drums, gap, drum="rear")
relieved = drum_loads(r, weight, drums, gap, rider_load=np.maximum(rider, 0.0)).rear

winding = wo.WindingProblem.example().replace(
    radius=0.6,
    core=wo.Core(radius=core, stiffness=1e9),
    tension_law="friction",
    density=density,
    drum=wo.Rigid(radius=rear),
)
wound = {}
for name, loads in (("constant rider", constant), ("rider relieved", relieved)):
    schedule = wo.Profile(radius=r, value=loads)
    wound[name] = wo.solve(winding.replace(nip_load=schedule))
    print(
        f"{name}: nip {loads[0]:.0f} to {loads.max():.0f} N/m, pressure halfway "
        f"{wound[name].roll.mid_pressure / 1e3:.0f} kPa"
    )
light = r[rider > 0][-1]
print(f"for 2.5 kN/m: rider {rider[0]:.0f} N/m at the core, none from {light:.2f} m on")

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.5), layout="constrained")
for name, loads in (("constant rider", constant), ("rider relieved", relieved)):
    left.plot(1e3 * r, loads / 1e3, label=name)
    roll = wound[name].roll
    right.plot(1e3 * roll.radius, roll.pressure / 1e3, label=name)
left.set(xlabel="radius [mm]", ylabel="load of the rear nip [kN/m]", ylim=(0, None))
right.set(xlabel="radius [mm]", ylabel="pressure [kPa]", ylim=(0, None))
left.legend()
right.legend()
plt.show()

# sphinx_gallery_start_ignore
assert rear > front
assert 2520 < constant[0] < 2540
assert 1800 < constant.min() < 1830
assert 3950 < constant[-1] < 4020
assert 6.5e3 < drum_loads(r, weight, drums, gap, rider_load=2500.0).front[-1] < 6.6e3
assert 2450 < rider[0] < 2490
assert 0.52 < light < 0.55
for run in wound.values():
    assert run.problem.drum.radius == rear
inner, outer = (
    {name: run.roll.at_radius(place)["pressure"] for name, run in wound.items()}
    for place in (0.2, 0.45)
)
assert 0.72e6 < inner["constant rider"] < 0.78e6
assert 1.05e6 < outer["constant rider"] < 1.15e6
assert inner["rider relieved"] > 1.2 * outer["rider relieved"]
assert 2950 < relieved[-1] < 3030
# sphinx_gallery_end_ignore
