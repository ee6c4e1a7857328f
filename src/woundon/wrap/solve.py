r"""The winding nip with its wraps: from a problem to a certified result (thesis sec. 3.5).

WrappedNipProblem --> for a half width a and a known T0, kappa0:   equations.WrapEquations
normal problem       z = z0 + Z q            p+, p-, Delta
stick-slip problem   q+, q-, xi              contact.stick_slip
--> T, kappa of the solution take the place of T0, kappa0, while a secant moves
a until int p- = P: both settle together     contact.loop
--> WrappedNipResult with its certificate        certificate
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from ..arguments import check_type, nodes_or_rtol, tolerance, whole_number
from ..contact.certificate import ROUNDING
from ..contact.loop import Before, Ladder, Level, Start, Tolerance, Widths, halved
from ..contact.meshes import Mesh
from ..contact.response import Tractions
from ..contact.schemes import Graded
from ..contact.told import NOTHING, Foreseen
from ..errors import InvalidProblem, NoSteadyState, NotConverged
from ..losses import Surface
from ..nip.solve import BY_LOAD, CHOSEN, COARSE_NODES, EDGE, taken_by
from ..nip.validity import web_far_outside
from ..problems.nip import NipProblem, WrappedNipProblem
from ..threads import one_thread
from ..two_bodies import PairContact
from .equations import Known, WrapEquations, WrapState
from .grid import WrapGrid, grid_for
from .outcome import creep, ratios, result_of
from .result import WrappedNipResult
from .scatter import by_borders, rest_of_borders

__all__ = ["check_options", "solve_wrapped_nip"]

Array = np.ndarray

FINE = Tolerance(load=6e-9, balance=3e-9)  # the certificate allows 1e-8
NODES = 65
ROLL_CELLS, DRUM_CELLS, RIGID_CELLS = 1 / 2, 3 / 4, 1 / 4  # on the arcs, of those in the nip
# where neither nodes nor rtol are given: the error of WOT below which, and the nodes up to which
# meshes are refined; bodies that are not linear cost more
DEFAULT, DEFAULT_HARDENING = (1e-3, 257), (3e-3, 129)
MOST_NODES = 1025
# of the drum's strain by the hoop pressure, over the square of the cells: 99 % of 80 random creeps
# are within 1.5 errors, which are 4.5 times the true ones in the middle
ENTRY = 40.0
# times what outputs scatter by without wraps, in the middle of 80 random nips with them
WITH_WRAPS = {"offset": 2.5, "half_width": 0.7, "nip_width": 0.7}


@one_thread
def solve_wrapped_nip(
    problem: WrappedNipProblem | NipProblem,
    *,
    nodes: int | None = None,
    wrap_nodes: int | None = None,
    rtol: float | None = None,
    roll_wrap: float | None = None,
    drum_wrap: float | None = None,
    wrap_friction: float | None = None,
    winding_force: float | None = None,
    start: WrappedNipResult | None = None,
) -> WrappedNipResult:
    """Solve the winding nip with the web wrapped on the roll behind it and on the drum before it.

    Parameters
    ----------
    problem : WrappedNipProblem or NipProblem
    nodes : int, optional
        Number of nodes in the nip, 17 to 1025.  By default 41 to 257, as many as it takes until the
        estimated error of the wound-on tension is below 0.1 %.
    wrap_nodes : int, optional
        Number of cells on each arc, 12 to 2048; by default half of those in the nip, on the drum
        three quarters, or a quarter where it is rigid.
    rtol : float, optional
        In place of nodes: double them until the estimated error of the wound-on tension is below
        rtol of it, 1e-6 to 0.1.
    roll_wrap, drum_wrap, wrap_friction, winding_force
        Of a NipProblem only: the wraps that it is given, by default half a turn on the roll, and
        the force on nip and drum wrap together; see
        :class:`~woundon.problems.nip.WrappedNipProblem`.
    start : WrappedNipResult, optional
        A solved neighbouring case; its half width, zones, tension and curvature start this one,
        which saves the coarsest meshes.  The answer does not depend on it, beyond the tolerance of
        the load: one that leads nowhere is put aside.

    Returns
    -------
    WrappedNipResult

    Raises
    ------
    InvalidProblem
        For angles or options out of range, or a wrap on the drum without web tension.
    NoSteadyState
        If the drum slides under nip and wrap, or the web would be slack on a wrap.
    NotConverged
        If a law is not satisfied to 1e-8, or ``rtol`` not reached; carries the best result.
    """
    check_type("problem", problem, WrappedNipProblem, NipProblem)
    problem = _wrapped(
        problem, roll_wrap=roll_wrap, drum_wrap=drum_wrap, wrap_friction=wrap_friction,
        winding_force=winding_force,
    )  # fmt: skip
    count, cells = check_options(nodes=nodes, wrap_nodes=wrap_nodes, rtol=rtol)
    if start is not None:
        check_type("start", start, WrappedNipResult)
    asked = DEFAULT if problem.linear else DEFAULT_HARDENING
    chooses = nodes is None and rtol is None
    ladder = _climbed(WrapContact(problem, cells, count), start, asked if chooses else None)
    if rtol is not None:
        ladder.double(rtol, MOST_NODES)
    elif chooses:
        ladder.double(*asked, between=CHOSEN)
    result = result_of(ladder, problem).checked()
    if rtol is not None and not ladder.reached(rtol):
        raise ladder.not_reached(rtol, "the wound-on tension", result)
    return result.warned()


def _wrapped(problem: WrappedNipProblem | NipProblem, **wraps: float | None) -> WrappedNipProblem:
    """Return the wrapped problem that a plain one and the wraps' arguments describe."""
    given: dict[str, Any] = {name: value for name, value in wraps.items() if value is not None}
    if isinstance(problem, NipProblem):
        return problem.wrapped(**given)
    for name, value in given.items():
        text = f"{value!r} is given beside a WrappedNipProblem, whose field it is; use "
        raise InvalidProblem.at(name, f"{text}problem.replace({name}=...)")
    return problem


def _climbed(
    contact: WrapContact, start: WrappedNipResult | None, asked: tuple[float, int] | None
) -> Ladder:
    """Return the ladder up to the nodes asked, beside a neighbour or afresh.

    Where nodes are to be chosen, ``asked`` are the error of WOT and the nodes at most: up to those
    that a neighbour, or a coarse mesh, tells to be likely enough.
    """
    (rtol, most), counts = asked or (inf, 0), [contact.nodes]
    if asked:
        counts = [n for n in CHOSEN if n <= most]

    def ladder(contact: WrapContact) -> Ladder:
        return Ladder(contact, Graded(), "wound_on_tension", tolerance=FINE, scatters=True)

    if start is not None:
        near = _started(start, contact.problem)
        climbing = ladder(replace(contact, near=near))
        nodes = climbing.enough(counts, near, rtol)
        # from far away the linearised web may be slack where the true one is not
        with suppress(NotConverged, NoSteadyState, ArithmeticError):
            climbing.beside(halved(nodes, Graded.coarsest)[-2:], near, rtol, most)
            return climbing
    afresh = ladder(contact)
    if asked and contact.problem.linear:
        afresh.choose(COARSE_NODES, counts, rtol)
    else:
        afresh.climb(halved(contact.nodes, Graded.coarsest))
    return afresh


def _started(start: WrappedNipResult, problem: WrappedNipProblem) -> Start:
    """Start from another case's result, at the load asked."""
    places, was = start.x / start.half_width, start.problem
    on_roll, on_drum = places > -1, places < 1
    on_roll[-1] = on_drum[0] = False  # each face's outermost nodes have no tractions of their own
    load = problem.nip_load / was.nip_load
    known: Widths = (start.widths or Widths(2.0, {})).at(load)
    zones = np.concatenate([start.roll_zone[on_roll], start.drum_zone[on_drum]])
    # what the nip adds goes like its load, what comes to it like T_in; the web bends with the radii
    T, T_in = start.web_tension, problem.web_tension
    coming = T[np.minimum(np.arange(T.size), start.in_nip.start)]
    tension = T_in * (coming / was.web_tension if was.web_tension else 1.0) + load * (T - coming)
    drum, roll = (1 / getattr(problem, name).radius - 1 / getattr(was, name).radius
                  for name in ("drum", "roll"))  # fmt: skip
    loads = Known(
        tension, start.curvature + np.where(places < 1, -drum, roll),
        Tractions(start.roll_pressure, start.roll_traction),
        Tractions(start.pressure, start.drum_traction),
    )  # fmt: skip
    return Start(
        start.half_width * load ** (1 / known.power), (places[on_roll], places[on_drum]), zones,
        known.power, widths=known, before=Before(places, loads),
    )  # fmt: skip


def check_options(
    *, nodes: Any = None, wrap_nodes: Any = None, rtol: Any = None
) -> tuple[int, int | None]:
    """Check the options of :func:`solve_wrapped_nip`; return the nodes and the cells on an arc.

    None where these are not told.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    count = NODES if nodes is None else whole_number("nodes", nodes, 17, 1025)
    if rtol is not None:
        tolerance("rtol", rtol, 1e-6, 0.1)
    nodes_or_rtol(nodes, rtol)
    cells = None if wrap_nodes is None else whole_number("wrap_nodes", wrap_nodes, 12, 2048)
    return count, cells


@dataclass(frozen=True, eq=False)
class WrapContact(PairContact):
    """A wrapped nip as the loop sees it.

    ``cells`` on each arc belong to ``nodes`` in the nip; None: as many as each arc needs.

    ``near`` is what a neighbouring case hands over.
    """

    cells: int | None
    nodes: int
    near: Start | None = None

    def zones(self, start: Start, equations: WrapEquations) -> Array:
        """Return the zones to begin with: a neighbour's own where it had as many nodes."""
        if self._near_is_finer(start.before, equations.grid):
            assert self.near is not None
            start = self.near
        return super().zones(start, equations)

    def first_zones(self, equations: WrapEquations) -> Array | None:
        """Return the zones to begin with where nothing is known: a plain nip's.

        What slips at its edges goes on along a part of the arcs.
        """
        joint, grid, problem = equations.joint, equations.grid, self.problem
        if joint is None:
            return None
        slips, zones = joint.matrix[joint.unknowns + 2 :], np.zeros(joint.friction.size, np.int8)
        n, before = grid.last - grid.first - 1, grid.first  # nodes within the nip, and ahead of it
        n_p, n_q, edge = equations.roll_nodes.size, equations.roll_q.size, (n + 1) // EDGE
        for body, p, q, ahead, behind in (  # its first pressure and traction within the nip
            (problem.roll, 1, 0, 0, n_q - n),
            (problem.drum, n_p + equations.drum_nodes.size - n, n_q + before, before, 0),
        ):
            if not body.rigid:
                way = 1 if slips[q + n // 2, p : p + n].sum() > 0 else -1
                zones[q - ahead // EDGE : q + edge] = -way
                zones[q + n - edge : q + n + behind // EDGE] = way
        zones[zones.size - taken_by(problem, n) :] = 1 if problem.winding_force >= 0 else -1
        return zones

    def _near_is_finer(self, before: Before | None, grid: WrapGrid) -> bool:
        """Tell whether a neighbouring case has as many nodes, but the mesh before has not."""
        near = None if self.near is None else self.near.before
        few = before is None or before.places.size < grid.size
        return few and near is not None and near.places.size >= grid.size

    def grid(self, mesh: Mesh, a: float, like: WrapGrid | None = None) -> WrapGrid:
        """Return the grid for a half width: the arcs' ends stay where they are in space.

        A rigid drum's arc carries the web's tension alone; a soft one bends beside the nip.
        """
        made = vars(self).get("_made")  # what is known is put on the same grid as the equations
        if made is not None and made[:3] == (mesh, a, like):
            kept: WrapGrid = made[3]
            return kept
        count = mesh.nodes.size - 1
        if self.cells is not None:
            drum = roll = self.cells * count // (self.nodes - 1)
        else:
            drum = int((RIGID_CELLS if self.problem.drum.rigid else DRUM_CELLS) * count)
            roll = int(ROLL_CELLS * count)
        grid = grid_for(self.problem, mesh.grid, a, max(8, drum), max(8, roll), like)
        vars(self)["_made"] = mesh, a, like, grid
        return grid

    def about(self, mesh: Mesh, a: float, before: Before | None) -> Known:
        """Return tension and curvature to begin with: guessed, or those of the mesh before."""
        problem, grid = self.problem, self.grid(mesh, a)
        if self._near_is_finer(before, grid):
            assert self.near is not None
            before = self.near.before
        if before is not None:
            places, known = before.places, before.about
            tension, bend = (
                np.interp(grid.nodes, places, part) for part in (known.tension, known.bend)
            )
            loads = (
                None if load is None
                else Tractions(*(np.interp(grid.nodes, places, part) for part in load))
                for load in (known.roll, known.drum)
            )  # fmt: skip
            return Known(tension, bend, *loads)
        upstream = np.arange(grid.size) <= grid.last
        gained = max(problem.winding_force, 0.0) + 0.2 * problem.roll_friction * problem.nip_load
        tension = problem.web_tension + np.where(upstream, 0.0, gained)
        bend = np.where(upstream, -1 / problem.drum.radius, 1 / problem.roll.radius)
        return Known(tension, bend)

    def equations(
        self, mesh: Mesh, a: float, about: Known, last: WrapEquations | None = None
    ) -> WrapEquations:
        """Return the equations for the half width a [m]; for the same, with the last matrices."""
        if last is not None and last.half_width == a:
            return last.linearised(about)
        like = None if last is None else last.grid
        return WrapEquations(self.problem, self.grid(mesh, a, like), a, about)

    def refuse(self, equations: WrapEquations, state: WrapState) -> None:
        """Raise where the web is slack on a wrap: then nothing presses it on."""
        grid, T = equations.grid, state.along.tension
        for name, arc, present in (
            ("behind the nip", T[grid.last :], equations.roll_arc),
            ("before the nip", T[: grid.first + 1], equations.drum_arc),
        ):
            T_in, least = self.problem.web_tension, float(np.min(arc))
            if present and least <= 0:
                raise NoSteadyState.at(
                    "web_tension",
                    f"{T_in:.6g} leaves the web slack {name}: its tension falls to {least:.4g} "
                    f"[N/m]; more is needed, about {T_in - least:.4g}",
                )

    @property
    def outside(self) -> str:
        """What of the problem lies far outside the model, and what to change."""
        problem, width = self.problem, 2 * self.guess()
        if problem.web_tension:  # a taut web alone carries the load where it turns, P = T/R* 2a
            turn = problem.nip_load * problem.contact_radius / problem.web_tension
            width = min(width, turn)
        return "; ".join(filter(None, (*web_far_outside(problem, width), super().outside)))

    def surfaces(self, level: Level) -> tuple[Surface, Surface]:
        """Return the surfaces of roll and drum on a solved mesh, in nip and arcs."""
        along = level.state.along
        return level.equations.laws.surfaces(along.roll_loads, along.drum_loads)

    def scalars(self, level: Level) -> Mapping[str, float]:
        """Return the outputs whose errors are told."""
        state, grid = level.state, level.equations.grid
        T_in, more = self.problem.web_tension, level.share**BY_LOAD
        before, behind, far = (
            T_in + more * (float(state.along.tension[k]) - T_in)
            for k in (grid.first, grid.last, -1)
        )
        found = {
            **super().scalars(level),
            "wound_on_tension": far,
            "nip_induced_tension": behind - before,
            "tension_behind_nip": behind,
            "drum_creep": creep(level.equations, state),
            **ratios(level),
        }
        for name, change in rest_of_borders(level).items():
            found[name] += change
        return found

    def foreseen(self, level: Level, scalars: Mapping[str, float]) -> Mapping[str, Foreseen]:
        """Return by how much outputs scatter usually; with a wrap on the drum the grain tells."""
        usual = dict(super().foreseen(level, scalars))
        for name in usual.keys() & WITH_WRAPS:
            size, changes = usual[name]
            usual[name] = Foreseen(WITH_WRAPS[name] * size, max(changes, 1.0))
        if self.problem.drum_wrap:
            usual["drum_creep"] = NOTHING
        return by_borders(level, usual)

    def grains(self, level: Level) -> dict[str, float]:
        """Return what a mesh leaves of outputs that changes between meshes need not show.

        The drum's creep is fixed where the web comes onto the drum: there its hoop pressure and
        traction set in at once, on the drum's strain by which the cells there leave a little.
        """
        problem, grains = self.problem, super().grains(level)
        if not problem.drum_wrap:
            return grains
        hoop = problem.drum.compliance * problem.web_tension / problem.drum.radius
        own = problem.web.compliance.c11 / problem.web.thickness * problem.web_tension
        entry = ENTRY / (level.mesh.nodes.size - 1) ** 2
        return {**grains, "drum_creep": float(entry * hoop + ROUNDING * own)}
