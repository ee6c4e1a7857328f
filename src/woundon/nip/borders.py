r"""A nip on Chebyshev elements: the borders of its zones and its half width are the unknowns.

Between given borders stick and slip are known, so that for a given half width the equations are
linear.  Every run of stick keeps a slip of its own, its level, which is free, and closes by a
condition at one of its ends; so tractions stay bounded whatever the borders are:

                       on an elastic body                     on a rigid body
    closed by          q = s mu p where stick ends            v = level where stick begins

With s the way of the slip, these are left for Newton's method, one for each border and for a:

    stick begins       d(q - s mu p)/dr = 0 at its side       q = s mu p at its side
    stick ends         level = 0 at the roll; at the drum int q- = F, and all levels = xi
    slip turns         (never, on an elastic body)             v = 0
    half width         int p = P

On an elastic body a traction is continuous, and where material leaves a stick zone it goes like the
root of the distance; where material enters one it must go like its power 3/2, or the slip before it
would be the wrong way.  On a rigid body nothing but the web holds a traction: it may jump where
stick ends, and is continuous where stick begins, as v there has no kink.

The conditions are few, so their Jacobian is taken once by differences and kept up by Broyden's
formula, from one order to the next.
"""

from __future__ import annotations

from math import exp, log

import numpy as np

from ..contact.loop import Ladder
from ..contact.schemes import ELEMENTS
from ..results import ACCEPTED_RESIDUAL
from .layout import Face, Layout, Unsettled, faces_of

__all__ = ["OnElements"]

Array = np.ndarray

ORDERS = (10, 14, 20, 28)  # cells of an element
FLOOR = 1e-8  # relative: what interpolated kernels leave, whatever the order
RATE = 5  # coefficients of t ln t, the worst that leaves a border, fall like order^-5
COARSE, CLOSE = 2e-8, 2e-9  # of the conditions, on the first order and others; a law's is 1e-8
MISSED, APART = 3e-3, 1e-6  # of a law, on the first order and on others: zones are missing
MOST_CHANGES = 4  # of the zones on one order
MOST_STEPS = 12  # of Newton on one order
STEP = 1e-4  # for the Jacobian, of the way to the next border
LEAST_GAIN, RENEWED = 0.8, 1e-7  # a step that leaves more asks for a new Jacobian, but near the end


class OnElements(Ladder):
    """Solves a nip on elements of one order after another, from a solved mesh.

    Parameters
    ----------
    ladder : Ladder
        That solved the mesh; it is left as it is.
    """

    def __init__(self, ladder: Ladder) -> None:
        self.__dict__.update(ladder.__dict__)
        self.scheme, self.history = ELEMENTS, []
        self.problem = ladder.contact.problem  # type: ignore[attr-defined]
        self.faces: list[Face]
        self._unknowns: Array
        self._jacobian: Array | None
        self._begin(faces_of(ladder.level), ladder.level.half_width)

    def refine(self, rtol: float) -> None:
        """Raise the order until the target's told error is below rtol.

        Raises
        ------
        Unsettled
            Where borders are not found, or the last order does not reach rtol.
        """
        for k, order in enumerate(ORDERS):
            layout = self._agreed(order, fine=k > 0)
            self.level = layout.level(self.contact, self.level.power)
            self.history.append(self.contact.scalars(self.level))
            if k:
                self._tell_by(ORDERS[k - 1] / order)
                if self.reached(rtol) and layout.broken < ACCEPTED_RESIDUAL:
                    return
        raise Unsettled("the last order does not reach rtol")

    def _tell_by(self, share: float) -> None:
        """Take the values of the last order, and tell their errors from the change."""
        self.values = dict(self.history[-1])
        left = share**RATE / (1 - share**RATE)
        for name, value in self.values.items():
            change = abs(value - self.history[-2][name])
            self.errors[name] = left * change + FLOOR * self.contact.scale(name, value)

    def _layout(self, unknowns: Array, order: int) -> Layout:
        cuts = np.cumsum([face.borders.size for face in self.faces])
        parts = np.split(unknowns[:-1], cuts[:-1])
        faces = [Face(face.zones, part) for face, part in zip(self.faces, parts, strict=True)]
        self.solves += 1
        made = Layout.between(self.problem, faces, exp(unknowns[-1]), order)
        made.refuse()
        return made

    def _agreed(self, order: int, fine: bool) -> Layout:
        """Return the layout of this order whose zones are those that the laws ask for."""
        before, tolerated = np.empty(0), APART if fine else MISSED
        for _ in range(MOST_CHANGES):
            layout = self._settled(order, CLOSE if fine else COARSE)
            if layout.broken < tolerated or _same(before, self._unknowns):
                return layout
            before = self._unknowns
            self._begin(layout.asked(), layout.half_width)
        raise Unsettled("zones appear and vanish")

    def _begin(self, faces: list[Face], half_width: float) -> None:
        """Take zones and a half width to begin with."""
        self.faces, self._jacobian = faces, None
        self._unknowns = np.array([*(b for face in faces for b in face.borders), log(half_width)])

    def _settled(self, order: int, close: float = CLOSE) -> Layout:
        """Return the layout of this order whose conditions are kept."""
        here = self._layout(self._unknowns, order)
        left = here.left
        for _ in range(MOST_STEPS):
            if np.max(np.abs(left)) < close:
                return here
            if self._jacobian is None:
                self._jacobian = self._differences(left, order)
            step = -np.linalg.solve(self._jacobian, left)
            step *= min(1.0, float(np.min(self._room() / np.maximum(np.abs(step), 1e-300))))
            here = self._layout(self._unknowns + step, order)
            new = here.left
            self._unknowns = self._unknowns + step
            if np.max(np.abs(new)) > max(LEAST_GAIN * np.max(np.abs(left)), RENEWED):
                self._jacobian = None
            else:
                miss = new - left - self._jacobian @ step
                self._jacobian = self._jacobian + np.outer(miss, step) / (step @ step)
            left = new
        raise Unsettled("the borders of the zones did not settle")

    def _differences(self, left: Array, order: int) -> Array:
        made, steps = np.empty((self._unknowns.size,) * 2), STEP * self._room()
        for k in range(made.shape[0]):
            moved = self._unknowns.copy()
            moved[k] += steps[k]
            made[:, k] = (self._layout(moved, order).left - left) / steps[k]
        return made

    def _room(self) -> Array:
        """Return how far each unknown may go in one step: elements shrink to a tenth at most."""
        borders = self._unknowns[:-1]
        at = np.argsort(borders)
        gaps = np.diff(np.concatenate([[-1.0], borders[at], [1.0]]))
        room = np.full(self._unknowns.size, 0.3)
        room[at] = 0.45 * np.minimum(gaps[1:], gaps[:-1])
        return room


def _same(one: Array, two: Array) -> bool:
    return one.size == two.size and bool(np.max(np.abs(one - two)) < 1e-6)
