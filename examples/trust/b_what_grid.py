"""
What mesh do I need?
====================

By default the mesh is refined until the estimated error of the wound-on tension is below 0.1 %,
and that of the nip-induced tension below 2 %. ``nodes=`` sets the last mesh, ``rtol=`` the
relative error. What do finer meshes cost, and what do they gain?

**Answer:** 49 nodes are accurate to about 0.1 % and take some milliseconds; the error decreases
about fourfold with each doubling. The estimated error is larger than the true one in most
cases, so that the program refines further than this example requires.
"""

# %%
from time import perf_counter

import matplotlib.pyplot as plt
import numpy as np

import woundon as wo

problem = wo.NipProblem.example().replace(roll_wrap=0.0)
exact = wo.solve(problem, nodes=1025).nip_induced_tension
meshes = [41, 73, 129, 257, 513]
errors, estimates, times = [], [], []
for nodes in meshes:
    start = perf_counter()
    result = wo.solve(problem, nodes=nodes)
    times.append(perf_counter() - start)
    errors.append(abs(result.nip_induced_tension / exact - 1))
    estimates.append(result.nip_induced_tension_error / exact)
    print(
        f"{nodes:4d} nodes: error {errors[-1]:.1e}, estimated {estimates[-1]:.1e}, "
        f"{1e3 * times[-1]:.0f} ms"
    )
free = wo.solve(problem)
print(f"by default: {free.nodes} nodes, error {abs(free.nip_induced_tension / exact - 1):.1e}")

# %%
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.5), layout="constrained")
left.loglog(meshes, errors, "o-", label="error")
left.loglog(meshes, estimates, "s--", label="estimated error")
left.set(xlabel="nodes", ylabel="relative error of NIT")
left.legend()
right.loglog(meshes, 1e3 * np.array(times), "o-")
right.set(xlabel="nodes", ylabel="time [ms]")
for axes in (left, right):
    axes.set_xticks(meshes, map(str, meshes))
    axes.minorticks_off()
plt.show()

# sphinx_gallery_start_ignore
assert errors[0] < 3e-3
assert errors[-1] < 1e-4
assert abs(free.nip_induced_tension / exact - 1) < 1e-3
# sphinx_gallery_end_ignore
