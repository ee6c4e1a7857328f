r"""A nip on Chebyshev elements: the borders of its zones and its half width are the unknowns.

Between given borders stick and slip are known, so that for a given half width the equations are
linear.  Every run of stick keeps a slip of its own, its level, which is free, and closes by a
condition at one of its ends; so tractions stay bounded whatever the borders are:

                       on an elastic body                     on a rigid body
    closed by          q = s mu p where stick ends            v = level where stick begins

With s the way of the slip, these are left for Newton's method, one for each border and for a:

    stick begins       d(q - s mu p)/dr = 0 at its side       q = s mu p at its side
    stick ends         level = 0 at the roll; at the drum int q- = F, and all levels = xi
    slip turns         (never, on an elastic body)             v = 0; of a drum that slips all along
                                                               this tells xi, and int q- = F is left
    half width         int p = P

On an elastic body a traction is continuous, and where material leaves a stick zone it goes like the
root of the distance; where material enters one it must go like its power 3/2, or the slip before it
would be the wrong way.  On a rigid body nothing but the web holds a traction: it may jump where
stick ends, and is continuous where stick begins, as v there has no kink.

The conditions are few, so their Jacobian is taken once by differences and kept up by Broyden's
formula, from one order to the next.  Steps are bounded by the zones' lengths, face by face, and
damped by Deuflhard's test; a short zone that a step would turn inside out is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, hypot, log

import numpy as np

from ..contact.loop import Ladder
from ..contact.schemes import ELEMENTS
from ..results import ACCEPTED_RESIDUAL
from .layout import Face, Layout, Unsettled, faces_of

__all__ = ["OnElements", "scales"]

Array = np.ndarray

ORDERS = (10, 14, 20, 28)  # cells of an element
FLOOR = 1e-8  # relative: what interpolated kernels leave, whatever the order
RATE = 5  # coefficients of t ln t, the worst that leaves a border, fall like order^-5
# what hangs on where borders are loses two orders; a pressure may be largest on a kink
RATES = {"peak_pressure": 1} | dict.fromkeys(
    ("offset", "drum_creep", "leading_roll", "trailing_roll", "dual"), RATE - 2
)
CHANCE = 0.1  # relative, of order^-RATE: two orders may err alike
# what conditions may leave: before zones are judged, then of rtol on the first order, on others
ROUGH, COARSE, CLOSE = 1e-3, 0.5, 2e-9  # a law's is 1e-8
MISSED, APART = 3e-3, 1e-6  # of a law, on the first order and on others: zones are missing
MOST_CHANGES = 4  # of the zones on one order
MOST_STEPS = 12  # of Newton on one order and the same zones
MOST_CELLS, MOST_CAREFUL = 7500, 20000  # of all layouts together: 3 and 8 times what is usual
SHRUNK, WIDENED = 0.7, 0.3  # by one step: of a zone's length, of ln a
MOST_HALVINGS = 3  # of a step
VANISHING = 0.01  # length of a zone that is left out if a step takes it away
NUDGE = 1e-3  # of the way to the next border, from a border of the other face
LOWER = 0.7  # of the order: where the first Jacobian is taken, later ones on the order itself
STEP = 1e-4  # for the Jacobian, of the way to the next border
ROUNDING = 1e-6  # of that way: steps that are no better than rounding
LEAST_GAIN = 0.8  # of a step: if the next is longer, a new Jacobian is asked for


class OnElements(Ladder):
    """Solves a nip on elements of one order after another, from a solved mesh.

    Parameters
    ----------
    ladder : Ladder
        That solved the mesh; it is left as it is.
    careful : bool
        Whether to begin with borders from a mesh fitted to them, and with short elements about
        them, not only where laws that stay broken ask for these.
    turning : bool
        Whether what one node of the mesh holds is taken for a point where slip turns.

    Raises
    ------
    Unsettled
        Where no such node is.
    """

    def __init__(self, ladder: Ladder, careful: bool = False, turning: bool = False) -> None:
        self.__dict__.update(ladder.__dict__)
        self.history, self.values, self.errors = [], {}, {}
        self.cells, self._by_nodes = list(self.cells), dict(self._by_nodes)
        self._scatters = dict(self._scatters)
        if careful:
            self._step(self._fitted(self.level.mesh.nodes.size), self.level.start)
        self.scheme, self.history = ELEMENTS, []
        self.problem = ladder.contact.problem  # type: ignore[attr-defined]
        self.faces: list[Face]
        self._unknowns: Array
        self._jacobian: Array | None
        self._cells = 0
        self._layered, self._most = careful, MOST_CAREFUL if careful else MOST_CELLS
        faces = faces_of(self.level)
        self._begin(self._met(faces) if turning else faces, self.level.half_width)

    def refine(self, rtol: float) -> None:
        """Raise the order until the target's told error is below rtol.

        Raises
        ------
        Unsettled
            Where borders are not found, or the last order does not reach rtol.
        """
        for k, order in enumerate(ORDERS):
            layout = self._lawful(order) if k else self._first(order, COARSE * rtol)
            self.level = layout.level(self.contact, self.level.power)
            self.history.append(self.contact.scalars(self.level))
            if k:
                self._tell_by(ORDERS[k - 1] / order, CHANCE * order**-RATE)
                if self.reached(rtol) and layout.broken < ACCEPTED_RESIDUAL:
                    return
        raise Unsettled("the last order does not reach rtol")

    def _tell_by(self, share: float, chance: float) -> None:
        """Take the values of the last order, and tell their errors from the change."""
        self.values = dict(self.history[-1])
        for name, value in self.values.items():
            change, left = abs(value - self.history[-2][name]), share ** RATES.get(name, RATE)
            scale = self.contact.scale(name, value)
            self.errors[name] = hypot(left / (1 - left) * change, chance * scale) + FLOOR * scale

    # ---- zones -----------------------------------------------------------------------------------

    def _first(self, order: int, close: float) -> Layout:
        """Return the first layout: zones are judged as soon as their borders are roughly known."""
        for _ in range(MOST_CHANGES):
            layout = self._settled(order, ROUGH)
            if layout.broken < MISSED:
                return self._settled(order, close, layout)
            self._begin(layout.asked(), layout.half_width)
        raise Unsettled("zones appear and vanish")

    def _lawful(self, order: int) -> Layout:
        """Return the layout of this order whose zones are those that the laws ask for.

        What breaks a law may also be an element too long where stick begins.
        """
        before = np.empty(0)
        for _ in range(MOST_CHANGES):
            layout = self._settled(order, CLOSE)
            if layout.broken >= ACCEPTED_RESIDUAL and not self._layered:
                self._layered = True
                layout = self._settled(order, CLOSE)
            if layout.broken < APART or _same(before, self._unknowns):
                return layout
            before = self._unknowns
            self._begin(layout.asked(), layout.half_width)
        raise Unsettled("zones appear and vanish")

    def _begin(self, faces: Sequence[Face], half_width: float) -> None:
        """Take zones and a half width to begin with, no border of a face on one of the other."""
        roll, drum = faces
        self.faces = [roll, Face(drum.zones, _apart(drum.borders, roll.borders))]
        borders = np.concatenate([face.borders for face in self.faces])
        self._unknowns, self._jacobian = np.append(borders, log(half_width)), None

    def _faces(self, unknowns: Array) -> list[Face]:
        """Return the zones between borders among the unknowns."""
        cut = self.faces[0].borders.size
        parts = unknowns[:cut], unknowns[cut:-1]
        return [Face(face.zones, part) for face, part in zip(self.faces, parts, strict=True)]

    def _vanished(self, step: Array) -> list[Face] | None:
        """Return the zones without a short one that a step takes away; None where it takes none."""
        here, moves = self._faces(self._unknowns), self._faces(step)
        for f, (zones, at) in enumerate(here):
            gone = (np.diff(at) < VANISHING) & (np.diff(at + moves[f].borders) < 0)
            for k in np.nonzero(gone)[0].tolist():
                if zones[k] == zones[k + 2] or self.problem.bodies[f].rigid:
                    here[f] = _without(here[f], k + 1)
                    return here
        return None

    def _met(self, faces: Sequence[Face]) -> list[Face]:
        """Return the zones of a mesh, slip both ways meeting where stick is short."""
        found = list(faces)
        for f, (zones, at) in enumerate(found):
            short = (np.diff(at) < VANISHING) & (np.diff(zones[:-1]) * np.diff(zones[1:]) == 1)
            if self.problem.bodies[f].rigid and short.any():
                found[f] = _without(found[f], int(short.argmax()) + 1)
                return found
        raise Unsettled("no stick is short")

    # ---- Newton's method -------------------------------------------------------------------------

    def _layout(self, unknowns: Array, order: int) -> Layout:
        faces, a = self._faces(unknowns), exp(unknowns[-1])
        made = Layout.between(self.problem, faces, a, order, self._layered)
        made.refuse()
        self.solver.solves += 1
        self._cells += made.mesh.unknowns + 1
        if self._cells > self._most:
            raise Unsettled("the borders of the zones did not settle")
        return made

    def _settled(self, order: int, close: float, here: Layout | None = None) -> Layout:
        """Return the layout of this order whose conditions are kept, on fewer zones if some go."""
        here, steps = here or self._layout(self._unknowns, order), 0
        while np.max(np.abs(here.left)) >= close:
            if self._jacobian is None:
                self._jacobian = self._differences(order if steps else round(LOWER * order))
            step = -np.linalg.solve(self._jacobian, here.left)
            faces = self._vanished(step)
            if faces is not None:
                self._begin(faces, here.half_width)
                here, steps = self._layout(self._unknowns, order), 0
                continue
            if steps == MOST_STEPS:
                raise Unsettled("the borders of the zones did not settle")
            room, before, steps = scales(self._unknowns), here.left, steps + 1
            full, (step, here) = step, self._damped(step, order)
            self._unknowns = self._unknowns + step
            tiny, gain = np.max(np.abs(step) / room), np.max(np.abs(before)) / 2
            if tiny < ROUNDING and np.max(np.abs(here.left)) > gain:
                break
            self._learn(step, not np.array_equal(step, full), before, here.left)
        return here

    def _damped(self, step: Array, order: int) -> tuple[Array, Layout]:
        """Return as much of a step as makes the next shorter (Deuflhard), and where it leads."""
        room, jacobian, taken = scales(self._unknowns), self._jacobian, self._bounded(step)
        assert jacobian is not None
        for _ in range(MOST_HALVINGS):
            here = self._layout(self._unknowns + taken, order)
            then = float(np.linalg.norm(np.linalg.solve(jacobian, here.left) / room))
            if then <= max(float(np.linalg.norm(step / room)), ROUNDING):
                return taken, here
            taken = taken / 2
        return taken, self._layout(self._unknowns + taken, order)

    def _learn(self, step: Array, cut: bool, before: Array, left: Array) -> None:
        """Keep the Jacobian up by what a step did (Broyden), or drop it if it tells too little."""
        assert self._jacobian is not None
        miss, room = left - before - self._jacobian @ step, scales(self._unknowns)
        learnt = self._jacobian + np.outer(miss, step) / (step @ step)
        then = float(np.linalg.norm(np.linalg.solve(learnt, left) / room))
        useless = then > max(LEAST_GAIN * float(np.linalg.norm(step / room)), ROUNDING)
        stuck = cut and np.max(np.abs(left)) > LEAST_GAIN * np.max(np.abs(before))
        self._jacobian = None if useless or stuck else learnt

    def _differences(self, order: int) -> Array:
        made, steps = np.empty((self._unknowns.size,) * 2), STEP * scales(self._unknowns)
        left = self._layout(self._unknowns, order).left
        for k in range(made.shape[0]):
            moved = self._unknowns.copy()
            moved[k] += steps[k]
            made[:, k] = (self._layout(moved, order).left - left) / steps[k]
        return made

    def _bounded(self, step: Array) -> Array:
        """Return a step that leaves each zone a third of its length, each face apart."""
        made = step * (WIDENED / max(WIDENED, abs(float(step[-1]))))
        for (_, at), (_, moves) in zip(self._faces(self._unknowns), self._faces(made), strict=True):
            lengths = np.diff(np.concatenate([[-1.0], at, [1.0]]))
            lost = -np.diff(np.concatenate([[0.0], moves, [0.0]]))
            moves *= np.min(SHRUNK * lengths / np.maximum(lost, SHRUNK * lengths))  # in place
        return made


def _without(face: Face, zone: int) -> Face:
    """Return a face without a zone: those beside it are one, or meet in its middle."""
    zones, at = face
    same = zones[zone - 1] == zones[zone + 1]
    meeting = [] if same else [float(at[zone - 1 : zone + 1].mean())]
    left = (*zones[:zone], *zones[zone + 1 + same :])
    return Face(left, np.array([*at[: zone - 1], *meeting, *at[zone + 1 :]]))


def scales(unknowns: Array) -> Array:
    """Return the scale of borders and ln a: about half the way to the next border."""
    borders = unknowns[:-1]
    at = np.argsort(borders)
    gaps = np.diff(np.concatenate([[-1.0], borders[at], [1.0]]))
    made = np.full(unknowns.size, 0.3)
    made[at] = 0.45 * np.minimum(gaps[1:], gaps[:-1])
    return made


def _apart(borders: Array, others: Array) -> Array:
    """Return borders moved off others that they lie on, by little of the way to the next."""
    way = np.diff(np.append(borders, 1.0))
    on = np.abs(borders[:, None] - others).min(1, initial=2.0) < NUDGE * way
    return np.asarray(borders + np.where(on, 2 * NUDGE * way, 0.0))


def _same(one: Array, two: Array) -> bool:
    return one.size == two.size and bool(np.max(np.abs(one - two)) < 1e-6)
