"""
What do weight and torque change on a two-drum winder?
======================================================

Newsprint is wound to a diameter of 1.2 m on two drums with diameters of 0.6 m (rear) and 0.5 m
(front), with a rider roll on top. The web arrives on the rear drum.

**Answer:** under a constant rider load of 2.5 kN/m the load on the rear drum first falls from 2.3
to 1.7 kN/m, because the roll rises between the drums, and then grows to 3.9 kN/m with the square
of the radius; the front drum carries up to 6.5 kN/m. The wound-on tension follows the load. The
roll of newsprint is soft and its nips are wide: on the short arc between the drums friction cannot
hold the layer everywhere, and the front drum adds 50 to 85 N/m. More torque on the front drum
winds harder, by 2 % from a torque split of 0.7 to 0.3: the rear nip gains, and the front nip loses
most of it. Before the front drum the tension falls from 300 N/m to as little as 207 N/m. A rider
that is relieved until the weight takes over, at a radius of 0.51 m, keeps the load of the rear
drum at 2.2 kN/m; the wound-on tension then falls by 3 % in the mean.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

winding = wo.WindingProblem.example().replace(
    radius=0.6,
    core=wo.Core(radius=0.05, stiffness=1e9),
    web_tension=300.0,
    nip_load=None,
    torque_split=0.5,
    density=680.0,
    drum=wo.Rigid(radius=0.3),
    winder=wo.TwoDrums(front_drum=wo.Rigid(radius=0.25), gap=0.02, rider_load=2500.0),
)

# %%
# The loads follow from the balance of the roll. A rider load that is relieved as the roll grows
# keeps the load of the rear drum at 2.2 kN/m as long as the weight alone does not exceed it.
r = np.linspace(0.05, 0.6, 60)
loads = winding.drum_loads(r)
per_rider = np.sin(loads.front_angle) / np.sin(loads.front_arc)  # load of the rear drum per rider
needed = loads.rider_load + (2200.0 - loads.rear_load) / per_rider
relief = wo.Profile(radius=r, value=np.maximum(needed, 0.0), between="lines")
relieved = winding.replace(**{"winder.rider_load": relief})
light = r[needed > 0][-1]
print(f"rear drum {loads.rear_load[0]:.0f} to {loads.rear_load[-1]:.0f} N/m")
print(f"for 2200 N/m: rider {needed[0]:.0f} N/m at the core, none from {light:.2f} m on")

# %%
# The windings are solved with the nips of both drums.
cases = {f"torque split {s:g}": winding.replace(torque_split=s) for s in (0.7, 0.3)}
cases["0.5, rider relieved"] = relieved
wound = {name: wo.solve(case, rtol=0.01) for name, case in cases.items()}
for name, result in wound.items():
    print(
        f"{name}: WOT {result.mean_wound_on_tension:.0f} N/m, front drum "
        f"+{result.mean_front_added_tension:.0f} N/m, pressure halfway "
        f"{result.mid_pressure / 1e3:.0f} kPa, least tension {result.front.least_tension:.0f} N/m"
    )

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.5), layout="constrained")
for name, result in wound.items():
    left.plot(1e3 * result.radius, result.nip_load / 1e3, label=name)
    right.plot(1e3 * result.radius, result.wound_on_tension)
left.set(xlabel="radius [mm]", ylabel="load of the rear drum [kN/m]", ylim=(0, None))
right.set(xlabel="radius [mm]", ylabel="wound-on tension [N/m]", ylim=(0, None))
left.legend()
plt.show()

# %%
wound["torque split 0.3"].plot(panels=["winder", "between"])
plt.show()

# sphinx_gallery_start_ignore
driven, other, eased = wound.values()
assert 2230 < loads.rear_load[0] < 2280
assert 1650 < loads.rear_load.min() < 1760
assert 3900 < loads.rear_load[-1] < 3960
assert 6450 < loads.front_load[-1] < 6520
assert 0.50 < light < 0.52
for result in wound.values():
    assert 45 < result.mean_front_added_tension < 90
tensions = [result.mean_wound_on_tension for result in wound.values()]
assert 1.01 < tensions[1] / tensions[0] < 1.03
assert 200 < driven.front.least_tension < 215
middle = (tensions[0] + tensions[1]) / 2  # of a torque split of 0.5
assert 0.96 < tensions[2] / middle < 0.98
below = eased.nip_load[eased.radius < 0.5]
assert 2190 < below.min() < below.max() < 2210
# sphinx_gallery_end_ignore
