"""
What does speed change on a rubber-covered drum?
================================================

A drum with a cover of 15 mm at 100 to 3000 m/min. The rubber was measured at 20 °C (its
compound is not known); a Prony series is fitted to its master curve. It is ten times stiffer in
a microsecond than in ten seconds.

**Answer:** the cover becomes stiffer, so that the nip becomes narrower and its pressure higher;
the wound-on tension increases by a few percent. The dissipated power in the cover grows almost
in proportion to the speed. The temperature of the cover is not computed.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

rubber = wo.Isotropic(
    youngs_modulus=5.47e6,
    poissons_ratio=0.48,
    prony=[
        (1.43e6, 10.0),
        (1.20e6, 1.0),
        (1.60e6, 0.1),
        (2.33e6, 1e-2),
        (3.14e6, 1e-3),
        (4.71e6, 1e-4),
        (8.12e6, 1e-5),
        (15.6e6, 1e-6),
    ],
)
drum = wo.Cylinder(radius=0.25, core_radius=0.235, material=rubber)
problem = wo.NipProblem.example().replace(roll_wrap=np.pi, drum=drum, web_speed="100 m/min")
print(wo.solve(problem))

# %%
# Over speed, compared with elastic covers that have the relaxed modulus, which a slow test
# measures, and the instantaneous modulus.
speeds = np.geomspace(100, 3000, 8) / 60
table = wo.sweep(
    problem,
    over={"web_speed": speeds},
    outputs=[
        "wound_on_tension",
        "nip_induced_tension",
        "nip_width",
        "rolling_resistance",
        "dissipated_power",
        "pressure_shift",
    ],
    workers=1,
).to_dataframe()
elastic = {
    name: wo.solve(
        problem.replace(
            web_speed=None,
            drum=drum.replace(material=wo.Isotropic(youngs_modulus=E, poissons_ratio=0.48)),
        )
    )
    for name, E in (("relaxed", 5.47e6), ("instantaneous", 43.6e6))
}
for speed, row in table.iterrows():
    print(
        f"{60 * speed:5.0f} m/min: {row.wound_on_tension:.0f} N/m wound on, nip "
        f"{1e3 * row.nip_width:.1f} mm wide, shift {-1e3 * row.pressure_shift:.2f} mm, "
        f"{row.dissipated_power:.0f} W/m"
    )

# %%
figure, (left, middle, right) = plt.subplots(1, 3, figsize=(9.5, 3.3), layout="constrained")
minutes = 60 * speeds
left.semilogx(minutes, table["wound_on_tension"], label="wound on")
left.semilogx(minutes, table["nip_induced_tension"], label="nip-induced")
left.set(ylabel="tension [N/m]", ylim=(0, None))
left.legend(frameon=False)
middle.semilogx(minutes, 1e3 * table["nip_width"])
for name, result in elastic.items():
    middle.axhline(1e3 * result.nip_width, color="0.5", linestyle=":")
    middle.annotate(name, (110, 1e3 * result.nip_width), va="bottom", color="0.4")
middle.set(ylabel="nip width [mm]", ylim=(0, 15))
right.loglog(minutes, table["dissipated_power"])
right.set(ylabel="dissipated power [W/m]")
for axes in (left, middle, right):
    axes.set(xlabel="speed [m/min]")
plt.show()

# sphinx_gallery_start_ignore
assert np.all(np.diff(table["nip_width"]) < 0)
assert np.all(np.diff(table["dissipated_power"]) > 0)
assert np.ptp(table["wound_on_tension"]) < 0.05 * table["wound_on_tension"].max()
# sphinx_gallery_end_ignore
