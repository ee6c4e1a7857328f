"""
What does speed change for a film roll?
=======================================

The web entrains air. A lay-on roll excludes most of it: the faster the winder, the thicker the
film between the layers, the lower their friction, and the less tension the nip adds.

**Answer:** this polyester film with a roughness of 0.3 um loses its friction between 1 and 5
m/s under 300 N/m, and at higher speed under a heavier nip or a harder cover. Faster rolls are
soft and can telescope. Newsprint is not affected, because the air escapes through the paper.
Roughness, cover and stack constants are illustrative.
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
speeds = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0])


def wound(**changes):
    """Return the nip at every speed."""
    return [wo.solve(problem.replace(web_speed=V, **changes), nodes=33) for V in speeds]


cases = {
    "300 N/m": wound(),
    "900 N/m": wound(nip_load=900.0),
    "300 N/m, cover of 9 MPa": wound(**{"drum.material.youngs_modulus": 9e6}),
}
for V, result in zip(speeds, cases["300 N/m"], strict=True):
    print(
        f"{V:4.2f} m/s: film {result.air.film * 1e6:4.2f} um, friction in the nip "
        f"{result.air.roll_friction:.2f}, {result.wound_on_tension - 100:5.2f} N/m added"
    )

# %%
# The softness of the roll: layers and air in series, with the same wound-on tension.
roll = wo.RollProblem(
    core=wo.Core(radius=0.05, stiffness=2e9),
    radius=0.2,
    web_thickness=23e-6,
    wound_on_tension=100.0,
    stack=wo.Stack(
        radial=wo.Pfeiffer(K1=5e3, K2=100.0), tangential=5e9, poissons_ratio=0.01, shear=10e6
    ),
)
rolls = [wo.solve(result.wound(roll)) for result in cases["300 N/m"][::4]]

figure, panels = plt.subplots(1, 3, figsize=(12, 3.8), layout="constrained")
for name, results in cases.items():
    panels[0].plot(speeds, [r.air.film * 1e6 for r in results], label=name)
    panels[1].plot(speeds, [r.wound_on_tension - 100 for r in results], label=name)
for V, pressed in zip(speeds[::4], rolls, strict=True):
    panels[2].plot(pressed.radius * 1e3, pressed.pressure / 1e3, label=f"{V:.0f} m/s")
panels[0].set(xlabel="web speed [m/s]", ylabel="film between the layers [um]")
panels[1].set(xlabel="web speed [m/s]", ylabel="tension added [N/m]")
panels[2].set(xlabel="radius [mm]", ylabel="pressure between the layers [kPa]")
panels[0].legend()
panels[2].legend()
plt.show()

# sphinx_gallery_start_ignore
light, heavy, hard = cases.values()
assert light[0].air.friction_share == 1
assert light[-1].air.friction_share < 0.01
assert heavy[-1].air.film < light[-1].air.film
assert hard[-1].air.film < light[-1].air.film
assert rolls[-1].mid_pressure < 0.5 * rolls[0].mid_pressure
# sphinx_gallery_end_ignore
