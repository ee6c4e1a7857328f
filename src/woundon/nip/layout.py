"""Numbering of the unknowns of a contact:  u = ( p | Delta/R*, xi, ln a | q )."""

from __future__ import annotations

from ..elasticity.mesh import Mesh

__all__ = ["Layout", "Unknowns"]


class Unknowns:
    """Indices of the unknowns in u.

    Parameters
    ----------
    pressures, tractions : int
        Numbers of unknown pressures n and tractions k.

    Attributes
    ----------
    p, q : slices
        Pressures and tractions.
    shift, xi, ln_a : int
        Delta/R*, the creepage and ln a.
    size, traction_count : int
        n + 3 + k and k.
    """

    def __init__(self, pressures: int, tractions: int) -> None:
        n, self.size, self.traction_count = pressures, pressures + 3 + tractions, tractions
        self.p, self.q = slice(0, n), slice(n + 3, self.size)
        self.shift, self.xi, self.ln_a = n, n + 1, n + 2


class Layout(Unknowns):
    """Nodes of the unknowns of a web nip, and their indices in  u = ( p | ... | q+ | q- ).

    Each node has one unknown pressure: p- on the drum wrap and in the nip, p+ on the roll wrap.  In
    the nip p+ = p- + T kappa is explicit.

    Parameters
    ----------
    mesh : Mesh
    roll_wrap, drum_wrap : bool
        True if there is such a wrap.

    Attributes
    ----------
    first, last, end : int
        Nodes at the leading and trailing edge of the nip, and the last node.
    drum_wrap_nodes, roll_wrap_nodes : slices
        Nodes of the wraps, with the edge of the nip.
    p_nodes, roll_nodes, drum_nodes : slices
        Nodes of p, q+ and q-.
    roll_count : int
        Number of tractions on the roll, which come first.
    drum_p, wrap_p : slices
        Indices in u of p- and, on the roll wrap, of p+.
    drum_p_nodes, wrap_p_nodes : slices
        Their nodes.
    roll_q, drum_q : slices
        Indices in u of q+ and q-.
    """

    def __init__(self, mesh: Mesh, roll_wrap: bool, drum_wrap: bool) -> None:
        self.first, self.last, self.end = mesh.first, mesh.last, mesh.nodes.size - 1
        self.drum_wrap_nodes = slice(0, self.first + 1)
        self.roll_wrap_nodes = slice(self.last, self.end + 1)
        start = 0 if drum_wrap else self.first + 1
        stop = self.end + 1 if roll_wrap else self.last
        self.p_nodes = slice(start, stop)
        self.drum_p_nodes, self.wrap_p_nodes = slice(start, self.last), slice(self.last, stop)
        self.roll_nodes, self.drum_nodes = slice(self.first + 1, self.end), slice(1, self.last)
        self.roll_count = self.end - self.first - 1
        super().__init__(stop - start, self.roll_count + self.last - 1)
        self.drum_p = slice(0, self.last - start)
        self.wrap_p = slice(self.last - start, self.p.stop)
        first_drum_q = self.q.start + self.roll_count
        self.roll_q, self.drum_q = slice(self.q.start, first_drum_q), slice(first_drum_q, self.size)
