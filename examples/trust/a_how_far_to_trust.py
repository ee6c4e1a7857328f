"""
How accurate is the result?
===========================

Every result contains an estimate of the discretisation error, a certificate with the residuals
of all contact conditions, and warnings if the case is outside the validity of the model.

**Answer:** the discretisation error is below 0.1 % of the wound-on tension, and all contact
conditions are satisfied to eight digits. The uncertainty of the input is larger: moduli of
paper that are known to 10 % make the wound-on tension uncertain by a few percent.
"""

# %%
from math import pi

import matplotlib.pyplot as plt

import woundon as wo

problem = wo.NipProblem.example().replace(roll_wrap=pi)
result = wo.solve(problem)
print(f"{result.wound_on_tension:.1f} ± {result.wound_on_tension_error:.1f} N/m (discretisation)")
print(f"largest residual: {result.residuals.largest:.1e} ({result.residuals.worst})")
print("warnings:", result.warnings or "none")

# %%
# An independent check of the estimate: the same case on a finer mesh.
fine = wo.solve(problem, nodes=257)
error = abs(result.wound_on_tension - fine.wound_on_tension)
print(
    f"difference to the finer mesh {error:.2f} N/m, "
    f"estimated error {result.wound_on_tension_error:.2f} N/m"
)

# %%
# The effect of 10 % in each input:
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
estimate = result.wound_on_tension_error
spans["discretisation"] = (result.wound_on_tension - estimate, result.wound_on_tension + estimate)
for name, ends in spans.items():
    print(f"{name:24} {min(ends):.1f} to {max(ends):.1f} N/m")

# %%
figure, axes = plt.subplots(figsize=(7, 3.5), layout="constrained")
axes.use_sticky_edges = False  # a margin at the end of the longest bar
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
assert error < 2 * estimate < 2e-3 * result.wound_on_tension
assert result.residuals.largest < 1e-8
assert 5 < max(abs(high - low) for low, high in spans.values()) < 40
# sphinx_gallery_end_ignore
