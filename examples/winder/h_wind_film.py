"""
Centre or surface winding for film?
===================================

Polyester film of 25 um is wound with a covered lay-on roll. The drive can act at the core
(centre winding), at the lay-on roll (surface winding), or at both. How hard are the rolls?

**Answer:** in centre winding the whole web tension is wound in, and the nip adds to it. In
surface winding only the force that friction transmits in the nip is wound in, about mu P = 120
N/m for every web tension: a quarter less than in centre winding, with half the pressure. The
torque split sets the hardness without a change of web tension and nip load. A taper of the web
tension has no effect in surface winding: use a taper of the nip load.

The constants of the film stack and of the cover are illustrative, and entrained air is not
included. The shear modulus of a film stack is rarely known: between 10 and 100 MPa the tension
of the centre-wound roll varies from 160 to 171 N/m.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

film = wo.WindingProblem(
    web=wo.Web(
        thickness=25e-6,
        material=wo.Orthotropic(radial=200e6, tangential=4.5e9, cross=20e6, shear=100e6),
    ),
    stack=wo.Stack(
        radial=wo.Pfeiffer(K1=5e3, K2=150.0), tangential=4.5e9, poissons_ratio=0.01, shear=30e6
    ),
    core=wo.Core(radius=0.0762, stiffness=5e9),
    drum=wo.Cylinder(
        radius=0.1,
        core_radius=0.085,
        material=wo.Isotropic(youngs_modulus=20e6, poissons_ratio=0.4),
    ),
    radius=0.3,
    roll_friction=0.3,
    drum_friction=0.5,
    web_tension=wo.Taper(start=150.0, taper=0.25),
    nip_load=400.0,
    roll_wrap=np.pi,
    density=1390.0,
)
splits = (0.0, 0.5, 1.0)
coarse = {"nodes": 33, "rtol": 5e-3, "coupling_rtol": 1e-3}
runs = [wo.solve(film.replace(torque_split=split), **coarse) for split in splits]
for split, run in zip(splits, runs, strict=True):
    print(
        f"torque split {split:.1f}: {run.mean_wound_on_tension:5.1f} N/m wound on, "
        f"{run.mid_pressure / 1e3:5.0f} kPa halfway, {run.roll.layer_count:.0f} layers"
    )

# %%
# The same centre-wound roll with the smallest and the largest plausible shear modulus of the
# stack:
spread = [
    wo.solve(film.replace(torque_split=0.0, **{"stack.shear": G}), **coarse) for G in (10e6, 100e6)
]
for run in spread:
    print(
        f"G = {run.problem.stack.shear / 1e6:3.0f} MPa: {run.mean_wound_on_tension:5.1f} N/m wound "
        f"on, {run.mid_pressure / 1e3:5.0f} kPa halfway"
    )

# %%
figure, panels = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
for split, run in zip(splits, runs, strict=True):
    r = np.linspace(run.radius[0], run.radius[-1], 400)
    panels[0].plot(run.radius * 1e3, run.wound_on_tension, label=f"torque split {split:.1f}")
    panels[1].plot(r * 1e3, run.roll.at_radius(r)["pressure"] / 1e3)
panels[0].plot(runs[0].radius * 1e3, runs[0].web_tension, "k:", label="web tension")
panels[0].set(xlabel="radius [mm]", ylabel="wound-on tension [N/m]", ylim=(0, None))
panels[1].set(xlabel="radius [mm]", ylabel="pressure between the layers [kPa]", ylim=(0, None))
panels[0].legend()
plt.show()

# sphinx_gallery_start_ignore
centre, hybrid, surface = runs
assert centre.mean_wound_on_tension > hybrid.mean_wound_on_tension
assert hybrid.mean_wound_on_tension > surface.mean_wound_on_tension
assert 0.9 * 120 < surface.wound_on_tension.min() < surface.wound_on_tension.max() < 1.05 * 120
assert 0.7 < surface.mean_wound_on_tension / centre.mean_wound_on_tension < 0.77
assert 0.5 < surface.mid_pressure / centre.mid_pressure < 0.6
assert (centre.wound_on_tension >= centre.web_tension).all()
soft, stiff = spread
assert 159 < soft.mean_wound_on_tension < centre.mean_wound_on_tension
assert centre.mean_wound_on_tension < stiff.mean_wound_on_tension < 172
assert hybrid.mean_wound_on_tension < soft.mean_wound_on_tension  # the order of the drives remains
# sphinx_gallery_end_ignore
