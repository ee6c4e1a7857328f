"""
What does a soft drum cover change?
===================================

The drum gets a cover 20 mm thick, of foam (Poisson's ratio 0.1) or of rubber (0.45), from hard
to soft.

**Answer:** the softer the cover, the wider the nip, the lower the pressure, and the less
tension the nip adds. For the same modulus the tension is higher with rubber than with foam,
because rubber bulges along the web where foam is compressed.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

problem = wo.NipProblem.example().replace(roll_wrap=np.pi)
hard = wo.solve(problem)
moduli = np.geomspace(3e6, 1e9, 8)


def covered(modulus, poissons_ratio):
    cover = wo.Isotropic(youngs_modulus=modulus, poissons_ratio=poissons_ratio)
    return wo.Cylinder(radius=0.0762, core_radius=0.0562, material=cover)


covers = {"foam": 0.1, "rubber": 0.45}
results = {
    name: [wo.solve(problem.replace(drum=covered(modulus, nu))) for modulus in moduli]
    for name, nu in covers.items()
}
for name, solved in results.items():
    for modulus, result in zip(moduli, solved, strict=True):
        print(
            f"{name:6} {modulus / 1e6:6.0f} MPa: nip {1e3 * result.nip_width:5.2f} mm, "
            f"{result.peak_pressure / 1e3:4.0f} kPa, {result.wound_on_tension:.0f} N/m wound on"
        )

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.5), layout="constrained")
for name, solved in results.items():
    left.semilogx(moduli / 1e6, [r.wound_on_tension for r in solved], label=name)
    right.semilogx(moduli / 1e6, [r.peak_pressure / 1e3 for r in solved], label=name)
left.axhline(hard.wound_on_tension, color="grey", linestyle=":", label="bare steel drum")
right.axhline(hard.peak_pressure / 1e3, color="grey", linestyle=":")
left.set(xlabel="modulus of the cover [MPa]", ylabel="wound-on tension [N/m]")
right.set(xlabel="modulus of the cover [MPa]", ylabel="largest pressure [kPa]")
left.legend()
plt.show()

# sphinx_gallery_start_ignore
foam, rubber = (np.array([r.wound_on_tension for r in results[name]]) for name in covers)
assert np.all(rubber > foam)
assert np.all(np.diff(foam) > 0)
assert np.all(np.diff([r.nip_width for r in results["foam"]]) < 0)
# sphinx_gallery_end_ignore
