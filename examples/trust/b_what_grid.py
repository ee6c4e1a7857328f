"""
What grid do I need?
====================

Usually you need not care: without options the grid is refined until the estimated error is
below 0.1 %. ``nodes=`` fixes the grid, ``rtol=`` asks for a relative accuracy. What do finer
grids cost, and bring?

**Answer:** 33 nodes are good to a tenth of a percent and take some milliseconds; the error
falls about fourfold with each doubling. The told error is meant to be on the safe side, so that
the program goes on to 49 nodes here, and elsewhere to more.
"""

# %%
from time import perf_counter

import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

problem = wo.NipProblem.example()
exact = wo.solve(problem, rtol=2e-5).nip_induced_tension
grids = [9, 17, 33, 65, 129, 257]
errors, told, times = [], [], []
for nodes in grids:
    start = perf_counter()
    result = wo.solve(problem, nodes=nodes)
    times.append(perf_counter() - start)
    errors.append(abs(result.nip_induced_tension / exact - 1))
    told.append(result.nip_induced_tension_error / exact)
    print(
        f"{nodes:4d} nodes: off by {errors[-1]:.1e}, told {told[-1]:.1e}, {1e3 * times[-1]:.0f} ms"
    )
free = wo.solve(problem)
print(
    f"without options: {free.nodes} nodes, off by {abs(free.nip_induced_tension / exact - 1):.1e}"
)

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.5), layout="constrained")
left.loglog(grids, errors, "o-", label="error")
left.loglog(grids, told, "s--", label="error that the result tells")
left.set(xlabel="nodes", ylabel="relative error of NIT")
left.legend()
right.loglog(grids, 1e3 * np.array(times), "o-")
right.set(xlabel="nodes", ylabel="time [ms]")
plt.show()

# sphinx_gallery_start_ignore
assert errors[3] < 1e-3
assert errors[-1] < 1e-4
assert abs(free.nip_induced_tension / exact - 1) < 1e-3
# sphinx_gallery_end_ignore
