"""
Does slippery paper wind softer?
================================

Friction between the layers transmits the tension that the nip adds. Does less friction mean
less tension?

**Answer:** only below a coefficient of about 0.2. Above this the web sticks to the roll over a
growing part of the nip, and the wound-on tension becomes constant and even decreases slightly.
The rule of thumb NIT = µ *P* continues to grow and is twice too high at 0.4.
"""

# %%
import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

problem = wo.NipProblem.example().replace(roll_wrap=np.pi)
frictions = np.array([0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5])
cases = [problem.replace(roll_friction=mu) for mu in frictions]
added = np.array([wo.solve(case).wound_on_tension - case.web_tension for case in cases])
rule = np.array([wo.theories.friction_limit(case) for case in cases])
for mu, solved, thumb in zip(frictions, added, rule, strict=True):
    print(f"friction {mu:.2f}: {solved:.0f} N/m added, by the rule of thumb {thumb:.0f} N/m")

# %%
plt.plot(frictions, added, "o-", label="solved")
plt.plot(frictions, rule, "--", label="rule of thumb, µ P")
plt.ylim(0, 1000)
plt.xlabel("friction between the layers")
plt.ylabel("tension added by the nip [N/m]")
plt.legend()
plt.show()

# sphinx_gallery_start_ignore
assert 0.2 <= frictions[added.argmax()] <= 0.25
assert rule[6] > 2 * added[6]
# sphinx_gallery_end_ignore
