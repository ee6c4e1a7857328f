r"""The one loop of every contact here: coarse grids to fine ones, on each the width for the load.

    Contact --> on each mesh of a ladder: stick, slip and the width for the load     one_mesh
              --> zones, width and what is known carried to the next mesh
            --> scalars of every mesh, whose changes tell the discretisation error   told

What is nip, wrap or rollers hides behind :class:`Contact`; what is half-plane, cylinder or a body
that is not linear, behind the equations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from math import exp, inf, nan
from typing import Any

import numpy as np

from ..errors import NoSteadyState, NotConverged
from .contracts import Contact, Equations, State
from .levels import Before, Level, Scalars, Start, Widths
from .meshes import Mesh
from .one_mesh import ALGORITHMS, COARSE, COARSEST, FINE, LOOSE, FindZones, OneMesh, Tolerance
from .pivoting import solve_stick_slip
from .schemes import Graded, Scheme
from .told import (
    CHANCE,
    CHANGE_WEIGHT,
    ERROR_WEIGHTS,
    NOTHING,
    ORDER,
    REMEMBERED,
    Foreseen,
    Scatter,
    by_changes,
)

__all__ = [
    "ALGORITHMS", "COARSE", "FINE", "LOOSE", "Before", "Contact", "Equations", "Ladder", "Level",
    "Start", "State", "Tolerance", "Widths", "halved",
]  # fmt: skip

Array = np.ndarray

MOST_UNCHECKED = 7  # neighbours in a row whose errors are told by other cases alone
LIKELY = 1.0  # times the scatter that a coarse mesh foresees is what a finer one then tells, mostly
SURELY = 0.9  # of the error asked, that neighbours must foresee of a mesh that is to be enough
NEAR = 0.03  # of the nodes change their zone from one case to the next: it scatters alike
EXTRAPOLATED_WEIGHTS = (0.35, 0.05)  # once three values are extrapolated on fitted meshes
# there errors are regular: by order two a third of the last change, a twelfth of the one before
FITTED_WEIGHTS = (0.5, 0.1)


class Ladder:
    """Solves a contact on one mesh after another, and tells the errors from their changes.

    ``level`` is the last mesh, ``before`` the one before it, ``history`` the scalars of all and
    ``cells`` their numbers of cells, ``values`` and ``errors`` the best values and their told
    errors, ``solves`` the linear systems, ``widths`` the half widths of all meshes.

    Parameters
    ----------
    contact : Contact
    scheme : Scheme
    find_zones : callable
        The algorithm that finds stick and slip.
    target : str
        The scalar that refinement is for.
    tolerance : Tolerance, optional
        Of the meshes that count; ``FINE`` without.
    scatters : bool
        Whether errors are told by the scatter of all meshes, not by the last two changes.
    """

    def __init__(
        self,
        contact: Contact,
        scheme: Scheme,
        target: str,
        find_zones: FindZones = solve_stick_slip,
        tolerance: Tolerance | None = None,
        scatters: bool = False,
    ) -> None:
        self.scatters = scatters
        self._scatters: dict[str, Scatter] = {}
        self._scattered: Mapping[str, Scatter] = {}  # a neighbouring case
        self.contact, self.scheme, self.target = contact, scheme, target
        self.solver, self.tolerance = OneMesh(contact, find_zones), tolerance or FINE
        self.level: Level
        self.before: Level | None = None
        self.history: list[Scalars] = []
        self.cells: list[int] = []
        self.values: dict[str, float] = {}
        self.errors: dict[str, float] = {}
        self._weights = ERROR_WEIGHTS
        self._by_nodes: dict[int, float] = {}
        self._expected: Mapping[int, float] = {}  # half widths, from a neighbouring case
        self._unchecked = 0  # neighbours in a row, this one included
        self._missed = 0.0  # by how much a width carried to the last mesh missed, ln of loads

    # ---- ladders -------------------------------------------------------------------------------

    def climb(self, counts: Sequence[int], start: Start | None = None) -> None:
        """Solve on the scheme's own meshes, the last one to tolerance; tell errors from them.

        One between the first and the last may have no answer, where the load jumps with the width.
        """
        self._forget()
        self._take_over(start)
        tolerances = [COARSEST] * (len(counts) - 2) + [COARSE, self.tolerance]
        for count, tolerance in zip(counts, tolerances[-len(counts) :], strict=True):
            try:
                self._step(self.scheme.mesh(count), start, tolerance)
            except NotConverged:
                if count in (counts[0], counts[-1]):
                    raise
                continue
            if count != counts[-1]:
                start = self.level.start
        if self.contact.settles_apart:  # there the coarsest mesh is but a start
            self._forget(2)
        self._tell()

    def choose(self, first: int, counts: Sequence[int], rtol: float) -> None:
        """Solve on a mesh of ``first`` nodes, then on the first of others likely to be enough.

        That is where what the first one foresees of the target falls below rtol.
        """
        self._forget()
        try:
            self._step(self.scheme.mesh(first), None, LOOSE)
        except (NotConverged, NoSteadyState):
            # about a width that is not it, what is linearised may go on for ever, or a web be slack
            self._step(self.scheme.mesh(first), None, COARSE)
        values, name = self.history[-1], self.target
        foreseen = self.contact.foreseen(self.level, {name: values[name]})[name].size
        size = LIKELY * foreseen / self.contact.scale(name, values[name]) * (first - 1) ** ORDER
        likely = (n for n in counts if size <= rtol * (n - 1) ** ORDER)
        self._step(self.scheme.mesh(next(likely, counts[-1])), self.level.start)
        self._tell()

    def _forget(self, kept: int = 0) -> None:
        """Leave out all meshes but the last ones."""
        del self.history[: len(self.history) - kept], self.cells[: len(self.cells) - kept]

    def beside(self, counts: Sequence[int], start: Start, rtol: float = inf, most: int = 0) -> None:
        """Solve near a neighbouring case, on the last mesh; tell errors by how that one scatters.

        On the mesh before it too where the neighbours alone do not tell enough: every eighth case,
        where much has changed, or where the target is not known to rtol on less than ``most``.
        """
        self._take_over(start)
        told = self._scattered.get(self.target)
        unchecked = 1 + (start.widths.unchecked if start.widths else MOST_UNCHECKED)
        tells = told is not None and told.tells and unchecked <= MOST_UNCHECKED
        if not tells and self.contact.settles_apart:  # on the coarser mesh that costs less
            self.climb(counts, start)
            return
        self._step(self.scheme.mesh(counts[-1]), start)
        if not self._in_order():  # other zones scatter otherwise: where all slips, not at all
            self._scattered = {}
        self._tell()
        self._unchecked = unchecked
        tells = tells and self._alike() and (counts[-1] >= most or self.reached(rtol))
        if not tells and len(counts) > 1:
            self._check(counts[-2])

    def _alike(self) -> bool:
        """Tell whether the zones are those taken over but for a few nodes."""
        was, now = self.solver.begun, self.level.state.solution.state
        return self._in_order() and np.count_nonzero(was != now) <= NEAR * now.size

    def _in_order(self) -> bool:
        """Tell whether the zones are those taken over in their order, however long."""
        was, now = self.solver.begun, self.level.state.solution.state
        if was is None:
            return False
        return np.array_equal(*(z[(z[1:] != z[:-1]).nonzero()[0]] for z in (was, now)))

    def _take_over(self, start: Start | None) -> None:
        if start is not None and start.widths is not None:
            self._expected, self._scattered = start.widths.by_nodes, start.widths.scatters

    def _check(self, nodes: int) -> None:
        """Solve on a coarser mesh than the last one, for its change alone."""
        fine = self.level
        self._step(self.scheme.mesh(nodes), fine.start, COARSE)
        self.level, self.before = fine, self.level
        self.history[-2:], self.cells[-2:] = self.history[:-3:-1], self.cells[:-3:-1]
        self._unchecked, self._missed = 0, 0.0
        self._tell()

    def climb_fitted(self, counts: Sequence[int], coarse: Tolerance) -> None:
        """Solve on meshes ever better fitted to the zone borders found before.

        A coarse one that fails is passed over: it was too coarse for a layer much thinner than the
        contact.
        """
        start = None
        for k, count in enumerate(counts):
            last = k + 1 == len(counts)
            mesh = self.scheme.mesh(count) if start is None else self._fitted(count)
            try:
                self._step(mesh, start, self.tolerance if last else coarse)
            except NotConverged:
                if last:
                    raise
                continue
            if not last:
                start = self.level.start
        self._weights = FITTED_WEIGHTS
        self._tell()

    def double(self, rtol: float, most: int, between: Sequence[int] = ()) -> None:
        """Double the mesh until the target's told error is below rtol, up to so many nodes.

        Or take the first number of nodes ``between`` that does, by what is known of the scatter.
        """
        while (nodes := self.level.mesh.nodes.size) < most and not self.reached(rtol):
            finer = min(2 * nodes - 1, most)
            told, less = self._scatters.get(self.target), (n for n in between if nodes < n < finer)
            finer = next((n for n in less if told and told.error(n - 1, 1.0) <= rtol), finer)
            self._step(self.scheme.mesh(finer), self.level.start)
            self._tell()

    def fit(self, rtol: float, most: int) -> None:
        """Refine to rtol on meshes fitted to the zone borders, and extrapolate.

        There errors fall regularly, by order two, and are extrapolated to zero cells.
        """
        nodes, before = self.level.mesh.nodes.size, list(self.history)
        fitted: list[Scalars] = []
        while not self.reached(rtol) and nodes <= most:
            for _ in range(1 if fitted else 2):  # the first fit is to borders of an unfitted mesh
                self._step(self._fitted(nodes), self.level.start)
            fitted.append(self.history[-1])
            nodes = 2 * nodes - 1
            if len(fitted) > 1:  # one alone tells nothing of its own error
                self._extrapolate(before, fitted)

    @property
    def solves(self) -> int:
        """Linear systems solved so far."""
        return self.solver.solves

    @property
    def widths(self) -> Widths:
        """What a neighbouring case may begin with."""
        expected, found = self._expected, self._by_nodes
        factor = next((a / expected[nodes] for nodes, a in found.items() if nodes in expected), 1.0)
        by_nodes = {nodes: a * factor for nodes, a in expected.items()} | found
        return Widths(self.level.power, by_nodes, self._scatters, self._unchecked)

    def enough(self, counts: Sequence[int], start: Start, rtol: float) -> int:
        """Return the first of these nodes on which a neighbouring case reaches rtol, or the last.

        The first where it tells nothing.  What its own borders leave may be more than foreseen, and
        a mesh that is not enough costs three times one that is.
        """
        told = start.widths.scatters.get(self.target) if start.widths else None
        if told is None:
            return counts[0]
        told = told._replace(changes=REMEMBERED + 1)  # as it would be known after a check
        return next((n for n in counts if told.error(n - 1, 1.0) <= SURELY * rtol), counts[-1])

    def reached(self, rtol: float) -> bool:
        """Tell whether the target's told error is below rtol of its scale."""
        name = self.target
        return self.errors[name] <= rtol * self.contact.scale(name, self.values[name])

    def errors_of(self, result: Any) -> dict[str, float]:
        """Return the told errors of a result's outputs.

        One that is not itself extrapolated is farther off by what the extrapolation would add.
        """
        grains = self.contact.grains(self.level)
        return {
            name: error + abs(getattr(result, name) - self.values[name]) + grains.get(name, 0.0)
            for name, error in self.errors.items()
        }

    def not_reached(self, rtol: float, what: str, result: Any) -> NotConverged:
        """Return the error that says that the target is not known to rtol."""
        nodes, error = self.level.mesh.nodes.size, self.errors[self.target]
        return NotConverged(
            f"rtol={rtol:g} is not reached with {nodes} nodes: the estimated error of {what} is "
            f"{error:.3g} N/m", result
        )  # fmt: skip

    # ---- told errors ---------------------------------------------------------------------------

    def _tell(self) -> None:
        """Take the values of the last mesh, and tell their errors from the changes so far."""
        self.values = dict(self.history[-1])
        if not self.scheme.refines:
            self.errors = dict.fromkeys(self.values, nan)
            return
        foreseen: Mapping[str, Foreseen] = {}
        if self.scatters:
            foreseen = self.contact.foreseen(self.level, self.values)
        order = self.contact.order
        for name in self.values:
            values = [scalars[name] for scalars in self.history]
            self.errors[name] = self._told(name, values, order, foreseen.get(name, NOTHING))

    def _told(self, name: str, values: Sequence[float], order: float, foreseen: Foreseen) -> float:
        cells = self.level.mesh.nodes.size - 1
        if self.scatters:
            largest = max([self.contact.scale(name, value) for value in values])
            known = Scatter.of(values, self.cells, largest, order, foreseen)
            known = self._scatters[name] = known.after(self._scattered.get(name))
            if known.tells:
                return known.error(cells, largest)
        if len(values) == 2:
            chance, scale = CHANCE * (64 / cells) ** 1.6, self.contact.scale(name, values[-1])
            return CHANGE_WEIGHT * abs(values[1] - values[0]) + chance * scale
        return by_changes(values, self._weights)

    def _extrapolate(self, before: list[Scalars], fitted: list[Scalars]) -> None:
        for name in self.values:
            told = [scalars[name] for scalars in fitted]
            values = [told[0], *(b + (b - a) / 3 for a, b in pairwise(told))]
            weights = ERROR_WEIGHTS if len(values) < 4 else EXTRAPOLATED_WEIGHTS
            self.values[name] = values[-1]
            self.errors[name] = by_changes([*(s[name] for s in before), *values], weights)

    # ---- one mesh ------------------------------------------------------------------------------

    def _fitted(self, nodes: int) -> Mesh:
        assert isinstance(self.scheme, Graded)
        self._missed = 0.0  # of a mesh that is no finer one of the same kind
        return self.scheme.fitted(self.level.borders(), nodes)

    def _step(self, mesh: Mesh, start: Start | None, tolerance: Tolerance | None = None) -> None:
        solved = self._solved(mesh, start, tolerance or self.tolerance)
        self.before = getattr(self, "level", None)
        self.level = solved
        self._by_nodes.setdefault(mesh.nodes.size, solved.half_width)
        self.history.append(self.contact.scalars(self.level))
        self.cells.append(mesh.nodes.size - 1)

    def _solved(self, mesh: Mesh, start: Start | None, tolerance: Tolerance) -> Level:
        """Solve on one mesh, from a half width carried over."""
        a = None if start is None else self._carried_over(start, mesh)
        solved = self.solver.solved(mesh, start, a, tolerance)
        carried_over = start is not None and start.level is not None
        # what the frictionless contact left, the share of it included that was foreseen
        self._missed = self.solver.missed + self._missed / 4 if carried_over else 0.0
        return solved

    def _carried_over(self, start: Start, mesh: Mesh) -> float:
        """Return the half width to begin with: on each mesh the same load needs a little another.

        By how much, a neighbouring case tells if there is one, or a contact without friction to a
        tenth, at a tenth of the cost.  What that missed falls with the square of the cells.
        """
        expected = self._expected.get(mesh.nodes.size)
        if expected is not None:
            if start.level is None:
                return expected
            before = self._expected.get(start.level.mesh.nodes.size, start.half_width)
            return start.half_width * expected / before
        ratio = exp(-self._missed / 4)
        if start.frictionless is not None:
            a, before = start.frictionless
            now = self.contact.frictionless_load(mesh, a)
            ratio *= before / now if min(before, now) > 0 else 1.0
        return float(start.half_width * ratio ** (1 / start.power))


def halved(nodes: int, coarsest: int) -> list[int]:
    """Return the numbers of nodes of a ladder, coarse first, that ends at ``nodes``."""
    counts = [nodes]
    while counts[0] > coarsest:
        counts.insert(0, (counts[0] + 1) // 2)
    return counts
