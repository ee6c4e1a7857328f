r"""Two bodies pressed together: what nip, wrapped nip and rollers have in common.

For a half width a the surfaces of the bodies 1 and 2 close the gap, and slip where friction allows:

    slope_p p + slope_q q + Delta/R* = gap                 N cells
    v = offset + direct q + through_pressure p + moves xi  slips

The first is solved for p and Delta once, p = p0 + K q (the normal problem); put into the second it
leaves the stick-slip problem in q.  What q is, one face or two, and what v is made of, the web or
no web, is the business of the rooms above.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Self

import numpy as np

from .contact.loop import Before, Level, Start
from .contact.meshes import Mesh
from .contact.normal import solve_normal
from .contact.response import Response, Tractions, on_columns, padded
from .contact.schemes import Graded, scheme_of
from .contact.stick_slip import StickSlip, StickSlipSolution
from .contact.told import ORDER, Foreseen
from .contact.width import WidthNotFound, width_for_load
from .errors import InvalidProblem
from .losses import Surface, lost, surfaces
from .problems.bodies import Body, ContactProblem, half_width_guess

__all__ = [
    "About", "Matrices", "PairContact", "PairEquations", "PairState", "approach", "far_outside",
    "frictionless_load", "mesh_of", "within",
]  # fmt: skip

Array = np.ndarray
# what loads body 1 and body 2; those that are not linear are linearised about it
About = tuple[Tractions, Tractions] | None

SHARE = (
    0.3  # of the largest pressure, under which a linear body is about as stiff as a hardening one
)
SLACK = 0.5  # of the load that flattens a thin tube, from which a contact's is looked at
PARTED = 0.05  # of the largest pressure: less of it in the middle, friction may take away
GRAIN = 0.02  # of the widest cell: 96 to 100 % of random nips' slip ratios are within 1.5 estimates
SLIP_RATIOS = ("leading_roll", "trailing_roll", "dual")
# what outputs of random nips scatter by in the middle, relative and on one cell, and as how many
# changes that counts: widths and pressures err much alike, not so what borders of zones matter to,
# but for the offset, which errs at the edges too, and there least on coarse meshes
USUAL = {
    "nip_induced_tension": Foreseen(1.0, 0.5), "tension_behind_nip": Foreseen(1.0, 0.5),
    "drum_creep": Foreseen(0.35, 0.5), "offset": Foreseen(2.0, 2.0),
    "wound_on_tension": Foreseen(0.3, 1.0), "half_width": Foreseen(0.15, 2.0),
    "nip_width": Foreseen(0.15, 2.0), "peak_pressure": Foreseen(0.8, 2.0),
}  # fmt: skip
# errors fall from mesh to mesh by order two in the middle of random nips, by 1.3 to 1.6 in the
# worst twentieth of those with rigid drums
JUMPING = 1.75


@dataclass(frozen=True, eq=False)
class PairState:
    """A solved contact on one mesh, for one half width."""

    half_width: float
    solution: StickSlipSolution
    pressure: Array  # (n,) [Pa]
    shift: float  # Delta/R*
    known: About

    @property
    def traction(self) -> Array:
        """The tractions of all faces, (m,) [Pa]."""
        return self.solution.traction


@dataclass(frozen=True, eq=False)
class Matrices:
    """Every matrix of a contact's equations for one half width a, nothing solved yet.

    N cells, n = N - 1 unknown nodes, m tractions of all faces; the first m slips belong to them.
    """

    half_width: float
    slope_p: Array  # (N, n)
    slope_q: Array  # (N, m)
    gap: Array  # (N,) slope of the gap, x/R*, less what a linearised body has at zero tractions
    top: float  # largest slope of the gap alone
    direct: Array  # (m + ..., m) slips by tractions
    through_pressure: Array  # (m + ..., n) slips by pressures
    offset: Array  # (m + ...,) slips that a linearised body has at zero tractions
    moves: Array  # (m + ...,) slips by the creep
    weights: Array  # (n,) integrate a traction over the contact [m]
    responses: tuple[Response, Response]

    @classmethod
    def at(cls, problem: Any, mesh: Mesh, a: float, about: About = None) -> Self:
        """Assemble for the half width ``a`` [m], bodies that are not linear about their loads."""
        loads = about or (None, None)
        pairs = zip(problem.bodies, loads, strict=True)
        one, two = (problem.respond(body, mesh, a, load) for body, load in pairs)
        return cls.of(problem, mesh, a, one, two, about)

    @classmethod
    def of(
        cls, problem: Any, mesh: Mesh, a: float, one: Response, two: Response, about: About = None
    ) -> Self:
        """Assemble for the half width ``a`` [m] and given responses of the bodies."""
        raise NotImplementedError

    @staticmethod
    def loads(p: Array, q: Array) -> tuple[Tractions, Tractions]:
        """Return what loads the two bodies."""
        raise NotImplementedError

    def indentation(self, p: Array, q: Array, shift: float) -> Array:
        """Return what pressures, tractions and shift leave of the gap's slope, (N,)."""
        return np.asarray(self.slope_p @ p + self.slope_q @ q + shift - self.gap)

    def laws(self, p: Array, q: Array, shift: float, creep: float) -> tuple[Array, Array]:
        """Return what is left of the gap's slope, and all slips."""
        return self.indentation(p, q, shift), self.slips(p, q, creep)

    def slips(self, p: Array, q: Array, creep: float) -> Array:
        """Return all slips."""
        v = self.offset + self.direct @ q + self.through_pressure @ p
        return np.asarray(v + self.moves * creep)


@dataclass(frozen=True, eq=False)
class PairEquations:
    """The equations for one half width; made by :meth:`at`."""

    problem: Any
    mesh: Mesh
    matrices: Any

    made_of: ClassVar[type[Matrices]]
    face_count: ClassVar[int] = 1

    @classmethod
    def at(cls, problem: Any, mesh: Mesh, a: float, about: About = None) -> Self:
        """Assemble the equations for the half width ``a`` [m]."""
        return cls(problem, mesh, cls.made_of.at(problem, mesh, a, about))

    @cached_property
    def normal(self) -> Array:
        """Rows p and shift by the gap, and by unit tractions: the normal problem, (N, 1 + m)."""
        made = self.matrices
        return solve_normal(made.slope_p, made.gap, made.slope_q)

    @property
    def pressure(self) -> Array:
        """p0, (n,) [Pa]."""
        return self.normal[:-1, 0]

    @property
    def pressure_response(self) -> Array:
        """K, (n, m)."""
        return self.normal[:-1, 1:]

    @property
    def faces(self) -> tuple[Array, ...]:
        """Where the tractions of each face are, in units of a."""
        return (self.mesh.columns,) * self.face_count

    @property
    def places(self) -> Array:
        """Where the loads of the bodies are given, in units of a."""
        return self.mesh.columns

    def stick_slip(self) -> StickSlip:
        """Return the stick-slip problem, the normal problem put in."""
        raise NotImplementedError

    def state(self, solution: StickSlipSolution) -> PairState:
        """Return the state that belongs to solved tractions."""
        q = solution.traction
        solved = self.normal[:, 0] + self.normal[:, 1:] @ q
        known = self.matrices.loads(solved[:-1], q)
        return PairState(
            self.matrices.half_width, solution, solved[:-1], float(solved[-1]), known
        )  # fmt: skip

    def carried(self, state: PairState) -> float:
        """Return the integral of the pressure [N/m]."""
        return float(self.matrices.weights @ state.pressure)

    def frictionless(self) -> float | None:
        """Return the integral of the pressure without tractions [N/m]; linear bodies tell it."""
        if not self.problem.linear:
            return None
        return frictionless_load(self.problem, self.mesh, self.matrices.half_width)

    def imbalance(self, state: PairState) -> float:
        """Return the largest change of slopes and slips by a linearisation anew, relative."""
        if self.problem.linear:
            return 0.0
        p, q, now, anew = state.pressure, state.traction, self.matrices, self.anew(state)
        slope = now.indentation(p, q, 0.0) - anew.indentation(p, q, 0.0)
        slip = now.slips(p, q, 0.0) - anew.slips(p, q, 0.0)
        return float(max(np.max(np.abs(slope)), np.max(np.abs(slip)))) / anew.top

    def anew(self, state: PairState) -> Matrices:
        """Return the matrices for the same half width about a state; the same where linear."""
        if self.problem.linear:
            return self.matrices
        return self.made_of.at(self.problem, self.mesh, self.matrices.half_width, state.known)


def frictionless_pressure(problem: Any, mesh: Mesh, a: float) -> Array:
    """Return the pressure of a frictionless contact of half width ``a`` at the nodes, (n,) [Pa]."""
    slope_p = problem.thinning / a * mesh.slope[:-1]
    for body in problem.bodies:
        if not body.rigid:
            slope_p += problem.respond(body, mesh, a).pressure_slope()
    gap = mesh.middle * (a / problem.contact_radius)
    return solve_normal(slope_p, gap, np.empty((gap.size, 0)))[:-1, 0]


def frictionless_load(problem: Any, mesh: Mesh, a: float) -> float:
    """Return the load that a frictionless contact of half width ``a`` carries [N/m]."""
    return float(a * mesh.grid.weights @ frictionless_pressure(problem, mesh, a))


def far_outside(problem: ContactProblem, load: float) -> Iterator[str]:
    """Yield which bodies a load presses by more than their own stiffness, and what to change."""
    p = load / (2 * half_width_guess(load, *problem.bodies))
    for name, body in zip(problem.pair, problem.bodies, strict=True):
        if body.surface_material is not None:
            modulus = min(body.surface_material.stiffness[:2])
            if p > modulus:
                yield (
                    f"this is far outside the model: a mean pressure of about {p:.2g} Pa is more "
                    f"than the {name}'s stiffness, {modulus:.2g} Pa; take a smaller load or a "
                    f"stiffer {name}"
                )


def approach(problem: ContactProblem, made: Matrices, state: PairState, v: float = 0.0) -> float:
    """Return the mutual approach -delta > 0, from the indentation (82) at the trailing edge [m].

    ``v`` is what the web between the bodies adds there.
    """
    a = state.half_width
    loads = made.loads(state.pressure, state.traction)
    for body, response, (p, q) in zip(problem.bodies, made.responses, loads, strict=True):
        if body.rigid:
            continue
        by_p, by_q = response.normal()
        v += float((by_p @ p)[0]) + float((by_q @ q)[0]) + float(response.rest()[0][0])
    return float(a**2 / (2 * problem.contact_radius) - v - state.shift * a)


def within(problem: ContactProblem, responses: Iterable[Response | None]) -> dict[str, float]:
    """Return the law of equilibrium inside bodies that had to find one, for the certificate.

    Raises
    ------
    InvalidProblem
        If a body's state is outside the range of its law.
    """
    found = {}
    for name, response in zip(problem.pair, responses, strict=True):
        if response is not None and response.outside:
            raise InvalidProblem.at(name, response.outside)
        if response is not None and response.imbalance is not None:
            found[f"{name}_equilibrium"] = response.imbalance
    return found


def mesh_of(result: Any) -> Mesh:
    """Return the mesh of a result: that of its solution, or one restored from a file's arrays."""
    return restored_mesh(result) if result.mesh is None else result.mesh


def restored_mesh(result: Any) -> Mesh:
    """Return the mesh that a result's arrays tell, before and after a file the same."""
    own, a = result.in_nip, result.half_width
    points = np.append(result.slip_x[own][1:] / a, 1.0)
    return scheme_of(result.scheme).restored(result.x[own] / a, points)


@dataclass(frozen=True, eq=False)
class PairContact:
    """Two bodies as the loop sees them; subclasses say which equations, and what to tell."""

    problem: Any

    equations_of: ClassVar[type[PairEquations]]
    load_field: ClassVar[str] = "nip_load"

    @property
    def load(self) -> float:
        """What the pressure must carry [N/m]."""
        return float(getattr(self.problem, self.load_field))

    def __post_init__(self) -> None:
        for name, body in zip(self.problem.pair, self.problem.bodies, strict=True):
            if body.unresolved:
                raise InvalidProblem.at(name, body.unresolved)
            flattens = SLACK * body.bending_load(self.problem.contact_radius)
            if self.problem.linear and self.load > flattens:  # else its linear stand-in tells
                self._refuse_flattened(name, body)

    def _refuse_flattened(self, name: str, body: Body) -> None:
        """Refuse a load that flattens an open tube, so that one contact does not carry it.

        Without friction, which changes little of it.
        """
        mesh, load = Graded().mesh(33), self.load

        def evaluate(a: float) -> tuple[bool, float]:
            p = frictionless_pressure(self.problem, mesh, a)
            middle = p[np.abs(mesh.columns) < 0.5]
            return bool(middle.min() > PARTED * p.max()), float(a * mesh.grid.weights @ p)

        try:
            in_one = width_for_load(evaluate, load, self.guess(), 1e-2, widest=self.widest)[0]
        except WidthNotFound:
            in_one = False
        if in_one:
            return
        tried = [evaluate(a) for a in np.geomspace(1e-3, 1.0, 60) * self.widest]
        most = max((carried for one, carried in tried if one and carried < load), default=0.0)
        raise InvalidProblem.at(
            self.load_field,
            f"{load:.6g} is out of range; must be < {most:.3g} [N/m], about: the {name} is a tube, "
            f"{body.thickness:.4g} m thick in all on an open bore, which more load bends instead "
            "of being carried by one contact; a rigid core or stiffer or thicker layers are needed",
        )

    @cached_property  # asked for with every width that is tried
    def widest(self) -> float:
        """The smaller radius, or what a body's response is resolved for [m]."""
        return float(min(min(body.radius, body.widest) for body in self.problem.bodies))

    @property
    def beyond(self) -> str:
        """What is wrong with a wider one, and what to change."""
        named = zip(self.problem.pair, self.problem.bodies, strict=True)
        name, body = min(named, key=lambda pair: min(pair[1].radius, pair[1].widest))
        if body.radius <= body.widest:
            return "the load is too large, or the bodies are too soft"
        return (
            f"beyond, the elastic layer of the {name}, {body.thickness:.3g} m, is too thin for so "
            f"wide a contact: take a smaller load, a thicker or stiffer layer, or a Rigid {name}"
        )

    @property
    def outside(self) -> str:
        """What of the problem lies far outside the model, and what to change; '' where nothing."""
        return "; ".join(far_outside(self.problem, self.load))

    @property
    def settles_apart(self) -> bool:
        """Whether a body, or the web between them, is not linear."""
        return not self.problem.linear

    def stand_in(self, peak: float | None) -> Self | None:
        """Return the contact of linear bodies as stiff as these are under a largest pressure."""
        pressure = SHARE * (peak or self.load / half_width_guess(self.load, *self.problem.bodies))
        linear = self.problem.stand_in(pressure)
        return None if linear is None else replace(self, problem=linear)

    def guess(self) -> float:
        """Return a half width to start from [m]."""
        return half_width_guess(self.load, *self.problem.bodies)

    def frictionless_load(self, mesh: Mesh, a: float) -> float:
        """Return the load that a frictionless contact of half width a carries [N/m]."""
        return frictionless_load(self.problem, mesh, a)

    def about(self, mesh: Mesh, a: float, before: Before | None) -> Any:
        """Return the loads about which bodies that are not linear are linearised."""
        if before is None or self.problem.linear:
            return None
        return tuple(on_columns(before.places, mesh.columns, load) for load in before.about)

    def equations(self, mesh: Mesh, a: float, about: Any, last: Any = None) -> Any:
        """Return the equations for the half width a [m]."""
        return self.equations_of.at(self.problem, mesh, a, about)

    def zones(self, start: Start, equations: Any) -> Array:
        """Return the zones to begin with: each node takes that of the nearest one before."""
        return np.concatenate(start.zones_on(equations.faces))

    def first_zones(self, equations: Any) -> Array | None:
        """Return the zones to begin with where nothing is known: all in stick."""
        return None

    def refuse(self, equations: Any, state: Any) -> None:
        """Refuse nothing: whatever has no steady state was refused with the problem."""

    def scalars(self, level: Level) -> Mapping[str, float]:
        """Return the outputs whose errors are told, those that every contact has."""
        return {
            "half_width": level.half_width,
            "nip_width": 2 * level.half_width,
            "peak_pressure": level.at_load(level.mesh.peak(level.state.pressure)),
            "offset": level.state.shift * self.problem.contact_radius,
            **self.losses(level),
        }

    def losses(self, level: Level) -> dict[str, float]:
        """Return the rolling resistance by its name; nothing of elastic bodies."""
        if not self.problem.viscoelastic:
            return {}
        # it goes like load times width
        share = level.share ** (1 + 1 / level.power)
        return {"rolling_resistance": lost(self.problem, self.surfaces(level)) * share}

    def surfaces(self, level: Level) -> tuple[Surface, Surface]:
        """Return the surfaces of both bodies on a solved mesh."""
        made, state = level.equations.matrices, level.state
        loads = made.loads(state.pressure, state.traction)
        return surfaces(self.problem, made.responses, level.mesh, state.half_width, loads)

    def scale(self, name: str, value: float) -> float:
        """Return what relative errors of an output are measured by."""
        if name == "tension_behind_nip":  # T_in is given: it errs by what the nip adds
            value -= self.problem.web_tension
        return max(abs(value), self._least_tension) if "tension" in name else abs(value)

    @cached_property  # asked for with every output of every mesh
    def _least_tension(self) -> float:
        return 0.01 * float(self.problem.roll_friction * self.problem.nip_load)

    @property
    def order(self) -> float:
        """By which power of the cells errors fall: less where tractions jump, on rigid bodies."""
        return JUMPING if any(body.rigid for body in self.problem.bodies) else ORDER

    def foreseen(self, level: Level, scalars: Mapping[str, float]) -> Mapping[str, Foreseen]:
        """Return by how much outputs scatter usually on such a mesh."""
        cells = level.mesh.nodes.size - 1
        return {
            name: Foreseen(size * self.scale(name, scalars[name]) / cells**ORDER, changes)
            for name, (size, changes) in USUAL.items()
            if name in scalars
        }

    def grains(self, level: Level) -> dict[str, float]:
        """Return what a mesh leaves of outputs that changes between meshes need not show.

        A zone may be shorter than the cells at the edge, and borders may fall alike between the
        nodes of two meshes: without this a tenth of slip ratios is off by more than 1.5 estimates.
        Pressure has a cusp at a border of stick, from which it falls like the root of the distance.
        """
        if level.mesh.border_share == 0:  # nodes lie on the borders of an element mesh
            return {}
        peak = level.at_load(_above_nodes(padded(level.state.pressure)))
        ends = GRAIN * float(level.mesh.grid.cells.max()) / 2
        return {"peak_pressure": peak, **dict.fromkeys(SLIP_RATIOS, ends)}


def _above_nodes(p: Array) -> float:
    """Return by how much a cusp of the pressure may rise above the largest nodal one.

    By how much a second difference there stands out of those on both sides.
    """
    bend = p[2:] - 2 * p[1:-1] + p[:-2]
    cusp = np.abs(bend[1:-1] - (bend[2:] + bend[:-2]) / 2)
    return max(float((p[2:-2] + cusp).max()) - float(p.max()), 0.0)
