"""Numbering of the unknowns of a web nip:  u = ( p | Delta/R*, xi, ln a | q+ | q- ).

Each node has one unknown pressure: p- on the drum wrap and in the nip, p+ on the roll wrap.  In the
nip p+ = p- + T kappa is explicit.
"""

from __future__ import annotations

import numpy as np

from ..elasticity.mesh import Mesh

__all__ = ["Layout"]


class Layout:
    """Nodes of the unknowns, and their indices in u.

    Parameters
    ----------
    mesh : Mesh
    roll_wrap, drum_wrap : bool
        True if there is such a wrap.

    Attributes
    ----------
    first, last, end : int
        Nodes at the leading and trailing edge of the nip, and the last node.
    p_nodes, roll_nodes, drum_nodes : int arrays
        Nodes of p, q+ and q-.
    p, roll_q, drum_q, q : slices; shift, xi, ln_a : int
        Indices in u.
    drum_p, wrap_p : slices
        Indices in u of p- and, on the roll wrap, of p+.
    size : int
    """

    def __init__(self, mesh: Mesh, roll_wrap: bool, drum_wrap: bool) -> None:
        self.first, self.last, self.end = mesh.first, mesh.last, mesh.nodes.size - 1
        start = 0 if drum_wrap else self.first + 1
        stop = self.end + 1 if roll_wrap else self.last
        self.p_nodes = np.arange(start, stop)
        self.roll_nodes = np.arange(self.first + 1, self.end)
        self.drum_nodes = np.arange(1, self.last)
        n, k, m = self.p_nodes.size, self.roll_nodes.size, self.drum_nodes.size
        self.p = slice(0, n)
        self.drum_p, self.wrap_p = slice(0, self.last - start), slice(self.last - start, n)
        self.shift, self.xi, self.ln_a = n, n + 1, n + 2
        self.roll_q, self.drum_q = slice(n + 3, n + 3 + k), slice(n + 3 + k, n + 3 + k + m)
        self.q, self.size = slice(n + 3, n + 3 + k + m), n + 3 + k + m
