"""
How fast can film be wound?
===========================

The faster a winder runs, the more air remains between the layers. It reduces their friction and
makes the roll light and soft, until at some speed the layers cannot carry the torque of the
roll: the slip margin is lost, and the roll telescopes.

**Answer:** 23 um polyester under a lay-on roll with 300 N/m loses the slip margin slightly
above 2 m/s. At this speed the friction in the nip is a third of its dry value and the roll is 4
% lighter, but the nip-induced tension is only 10 % lower. At 3 m/s it is zero. Roughness, cover
and stack constants are illustrative; the shear modulus of a film stack is rarely known.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

problem = wo.NipProblem(
    web=wo.Web(thickness=23e-6, material=wo.Isotropic(youngs_modulus=5e9, poissons_ratio=0.3)),
    roll=wo.HalfPlane(radius=0.2, material=wo.Isotropic(youngs_modulus=100e6, poissons_ratio=0.3)),
    drum=wo.HalfPlane(  # a lay-on roll covered with rubber
        radius=0.1, material=wo.Isotropic(youngs_modulus=3e6, poissons_ratio=0.48)
    ),
    roll_friction=0.25,
    drum_friction=0.4,
    nip_load=300.0,
    web_tension=100.0,
    roll_wrap=np.pi,
    web_speed=1.0,
    air=wo.Air(roughness=0.3e-6),
)
stack = wo.Stack(
    radial=wo.Pfeiffer(K1=5e3, K2=100.0), tangential=5e9, poissons_ratio=0.01, shear=10e6
)
core = wo.Core(radius=0.05, stiffness=2e9)
speeds = np.arange(0.0, 4.5, 0.5)
nips = [wo.solve(problem.replace(web_speed=V), nodes=33) for V in speeds]

# %%
# The rolls wound with these tensions, and their density: mass / volume.
rolls = [
    wo.solve(
        nip.wound(
            wo.RollProblem(
                core=core,
                radius=0.2,
                stack=stack,
                web_thickness=23e-6,
                density=1390.0,
                wound_on_tension=nip.wound_on_tension,
            )
        )
    )
    for nip in nips
]
density = np.array([roll.mass for roll in rolls]) / (np.pi * (0.2**2 - 0.05**2))

# %%
# Complete windings slightly below and above the critical speed. The outermost layers have the
# smallest pressure, T/R, and lose their friction first.
winding = wo.WindingProblem(
    web=problem.web,
    stack=stack,
    core=core,
    radius=0.2,
    drum=problem.drum,
    roll_friction=0.25,
    drum_friction=0.4,
    web_tension=100.0,
    nip_load=300.0,
    roll_wrap=np.pi,
    density=1390.0,
    air=problem.air,
    web_speed=2.0,
)
coarse = {"nodes": 33, "rtol": 0.05, "coupling_rtol": 1e-2}
held, lost = (wo.solve(winding.replace(web_speed=V), **coarse) for V in (2.0, 2.25))
for run in (held, lost):
    slip = run.margins["slip"]
    print(
        f"{run.problem.web_speed:.2f} m/s: torque / slip capacity {slip.value:.2g} "
        f"at {1e3 * slip.radius:.0f} mm; the nips add "
        f"{run.nip_induced_tension.mean():.0f} N/m"
    )

# %%
panels = {
    "film between the layers [um]": [1e6 * nip.air.film for nip in nips],
    "friction": [nip.air.roll_friction for nip in nips],
    "nip-induced tension [N/m]": [nip.nip_induced_tension for nip in nips],
    "density of the roll [kg/m3]": density,
}
figure, axes = plt.subplots(2, 2, figsize=(8, 5.6), layout="constrained", sharex=True)
for axis, (label, values) in zip(axes.flat, panels.items(), strict=True):
    axis.plot(speeds, values, label="in the nip")
    axis.axvspan(2.0, 2.25, color="0.85")
    axis.set(ylabel=label)
layer = problem.web_tension / problem.roll.radius
axes[0, 1].plot(
    speeds, [nip.layer_friction(layer) for nip in nips], "--", label="in the outer layer"
)
axes[0, 1].legend(frameon=False)
axes[0, 0].annotate("margin lost", (2.3, 0.05))
for axis in axes[1]:
    axis.set(xlabel="web speed [m/s]")
plt.show()

# sphinx_gallery_start_ignore
assert held.margins["slip"].value < 1 < lost.margins["slip"].value
assert lost.margins["slip"].radius > 0.19
assert np.all(np.diff(density) < 0)
assert 0.03 < 1 - np.interp(2.0, speeds, density) / density[0] < 0.05
friction = [nip.air.roll_friction for nip in nips]
assert 0.3 < np.interp(2.0, speeds, friction) / friction[0] < 0.4
added = [nip.nip_induced_tension for nip in nips]
assert 0.85 < np.interp(2.0, speeds, added) / added[0] < 0.95
assert np.interp(3.0, speeds, added) < 0.01 * added[0]
# sphinx_gallery_end_ignore
