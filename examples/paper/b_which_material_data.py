"""
Which material data must I measure?
===================================

A nip needs four moduli of the paper, two friction coefficients and the thickness of the web.
Which of them deserve a careful measurement?

``result.sensitivity()`` returns the derivatives of the outputs of a nip with respect to every
field. An *elasticity* of 0.5 means that 1 % more of the input changes the output by 0.5 %. Here
the nip has no wraps (``roll_wrap=0``).

**Answer:** the thickness of the web and its modulus along the web, the shear modulus and the
radial modulus of the roll. The coupling modulus (``cross``), the friction of the drum and the
core have little influence.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

result = wo.solve(wo.NipProblem.example().replace(roll_wrap=0.0))
sensitivity = result.sensitivity(outputs=["nip_induced_tension"]).sorted()
elasticities = dict(zip(sensitivity.parameters, sensitivity.elasticities[0], strict=True))
for name, value in elasticities.items():
    print(f"{name:25} {value:+.3f}")

# %%
shown = {name: value for name, value in elasticities.items() if np.isfinite(value) and value}
figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
axes.barh(list(shown), list(shown.values()))
axes.invert_yaxis()
axes.axvline(0, color="black", linewidth=0.8)
axes.set_xlabel("change of the nip-induced tension for 1 % of the input [%]")
plt.show()

# sphinx_gallery_start_ignore
leading = set(list(elasticities)[1:5])
assert leading == {
    "web.thickness",
    "web.material.tangential",
    "roll.material.shear",
    "roll.material.radial",
}
minor = ("roll.material.cross", "web.material.cross", "drum_friction", "roll.core_radius")
assert max(abs(elasticities[name]) for name in minor) < 0.03
# sphinx_gallery_end_ignore
