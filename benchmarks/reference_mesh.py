"""Reference solutions of wrapped nips on another family of meshes, extrapolated to zero cell size.

The default meshes have the largest cells in the middle of a wrap, and grade the drum wrap only to
its far end.  Those of the reference are graded to both ends of each wrap alike,

    d/L = t^3 (10 - 15 t + 6 t^2),     0 <= t <= 1 in even steps, as many as in the nip,

so that cells at a distance from the edges shrink in another proportion to those of the nip.  Each
output is extrapolated from the last two meshes with the order two of the discretisation.
"""

from __future__ import annotations

from unittest.mock import patch

import numpy as np

import woundon as wo
from woundon.elasticity.mesh import Mesh, Wrap, cosine_nodes
from woundon.nip import equations

__all__ = ["extrapolated", "reference_mesh"]


def reference_mesh(size: int, drum_wrap: Wrap, roll_wrap: Wrap, like: Mesh | None = None) -> Mesh:
    """Return a mesh of the other family; parameters as of :func:`~woundon.elasticity.nip_mesh`.

    The numbers of cells depend on the size only, so that ``like`` is not needed.
    """
    t = np.linspace(0, 1, 2 * size - 1)
    graded = t**3 * (10 - 15 * t + 6 * t**2)
    upstream, downstream = (
        wrap.length * graded if wrap.length else np.zeros(1) for wrap in (drum_wrap, roll_wrap)
    )
    nodes_and_points = np.concatenate(
        [-1 - upstream[:0:-1], cosine_nodes(size), 1 + downstream[1:]]
    )
    first = upstream.size // 2
    return Mesh(nodes_and_points[0::2], nodes_and_points[1::2], first, first + size - 1)


def extrapolated(problem: wo.NipProblem, nodes: int = 257) -> dict[str, float]:
    """Return the outputs of a wrapped nip, extrapolated from the meshes of the other family."""
    with patch.object(equations, "nip_mesh", reference_mesh):
        coarse, fine = wo.solve(problem, nodes=nodes).refinement.meshes[-2:]
    ratio = (fine.size / coarse.size) ** 2
    return {
        name: (ratio * value - coarse.outputs[name]) / (ratio - 1)
        for name, value in fine.outputs.items()
    }
