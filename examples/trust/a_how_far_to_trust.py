"""
How far can I trust the number?
===============================

Every result carries three things beside the number: the estimated error of the discretisation,
a certificate that measures anew whether every law of the contact holds, and warnings where the
case leaves the model.

**Answer:** the equations are solved to better than 0.1 % of the wound-on tension, and the
certificate shows every law held to eight digits. What remains is the model and the data: moduli
of paper known to ten percent make a wound-on tension that is known to a few percent.
"""

# %%
from math import pi

import matplotlib.pyplot as plt

import woundon as wo

problem = wo.NipProblem.example().replace(roll_wrap=pi)
result = wo.solve(problem)
print(f"{result.wound_on_tension:.1f} ± {result.wound_on_tension_error:.1f} N/m from the grid")
print(f"largest violation of any law: {result.residuals.largest:.1e} ({result.residuals.worst})")
print("warnings:", result.warnings or "none")

# %%
# A check that does not rely on the estimate: the same case on a grid five times as fine.
fine = wo.solve(problem, nodes=257)
error = abs(result.wound_on_tension - fine.wound_on_tension)
print(f"against the finer grid {error:.2f} N/m, told {result.wound_on_tension_error:.2f} N/m")

# %%
# What the data do: each of them ten percent up and down.
paper = problem.web.material
spans = {}
for name in ("tangential", "shear", "radial"):
    low, high = (
        wo.solve(
            problem.replace(**{f"{body}.material.{name}": value for body in ("web", "roll")})
        ).wound_on_tension
        for value in (0.9 * getattr(paper, name), 1.1 * getattr(paper, name))
    )
    spans[f"{name} modulus ± 10 %"] = (low, high)
for name in ("roll_friction", "drum_friction"):
    value = getattr(problem, name)
    low, high = (
        wo.solve(problem.replace(**{name: f * value})).wound_on_tension for f in (0.9, 1.1)
    )
    spans[f"{name.replace('_', ' ')} ± 10 %"] = (low, high)
told = result.wound_on_tension_error
spans["discretisation"] = (result.wound_on_tension - told, result.wound_on_tension + told)
for name, ends in spans.items():
    print(f"{name:24} {min(ends):.1f} to {max(ends):.1f} N/m")

# %%
figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
axes.use_sticky_edges = False  # leaves room beside the longest bar
axes.barh(
    list(spans),
    [high - low for low, high in spans.values()],
    left=[low for low, _ in spans.values()],
)
axes.axvline(result.wound_on_tension, color="black", linewidth=0.8)
axes.invert_yaxis()
axes.set_xlabel("wound-on tension [N/m]")
plt.show()

# sphinx_gallery_start_ignore
assert error < 2 * told < 2e-3 * result.wound_on_tension
assert result.residuals.largest < 1e-8
assert 5 < max(abs(high - low) for low, high in spans.values()) < 40
# sphinx_gallery_end_ignore
