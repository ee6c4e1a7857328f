r"""The winding nip: from a problem to a certified result (thesis ch. 3).

    NipProblem --> for a half width a: influence matrices        equations.NipMatrices
                   normal problem        p = p0 + K q            equations.NipEquations
                   stick-slip problem    q+, q-, xi              contact.stick_slip
               --> secant on a until int p = P, mesh after mesh  contact.loop
               --> NipResult with its certificate                certificate

Where ``rtol`` asks for more than the first meshes give, the mesh is graded anew towards the borders
of the zones and doubled; on such meshes NIT falls cleanly with the square of the cells, so the last
two are extrapolated.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import nan
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np

from ..arguments import check_type, nodes_or_rtol, tolerance, whole_number
from ..contact.loop import ALGORITHMS, Before, Ladder, Level, Start, Widths, halved
from ..contact.response import padded
from ..contact.schemes import ELEMENTS, Scheme, scheme_of
from ..contact.told import ORDER, Foreseen
from ..contact.zones import Runs
from ..errors import InvalidProblem, NotConverged, did_you_mean
from ..problems.nip import NipProblem, WrappedNipProblem
from ..results import Residuals, measured
from ..threads import one_thread
from ..two_bodies import SLIP_RATIOS, PairContact, PairEquations, PairState, approach, mesh_of
from .borders import OnElements
from .certificate import certificate, matrices_of
from .equations import NipEquations, NipMatrices, gained, jointly
from .result import NipResult
from .scatter import by_borders, by_cells, rest_of_borders, unseen_stick
from .validity import nip_warnings, web_far_outside

__all__ = [
    "NipContact", "check_options", "most_beyond", "recomputed", "slip_ratios", "solve_nip",
    "taken_by", "told_by",
]  # fmt: skip

Array = np.ndarray

# where neither nodes nor rtol are given: until the error of NIT is below so much, but on so many
# nodes at most; the error is told in any case.  Bodies that are not linear cost more
DEFAULT, DEFAULT_HARDENING = (1e-3, 257), (3e-3, 129)
CHOSEN = (41, 49, 65, 81, 97, 129, 161, 193, 257)  # nodes that it is solved on
COARSE_NODES = 17  # of the mesh that tells how many
# rtol from which elements are tried, with a rigid drum and an elastic one: from there they cost
# less than meshes on half of random nips and more
ON_ELEMENTS, ON_ELASTIC = 3e-5, 2e-4
CAREFUL = 3e-6  # rtol from which they are tried twice: for a larger one, meshes cost less than that
MOST_NODES = 1100  # of the meshes that rtol asks for
BY_LOAD = 0.7  # NIT goes like this power of the load: random nips' like 0.5 to 1, creeps like 0
EDGE = 4  # of so many nodes one at either edge is supposed to slip first; 5 does as well


@one_thread
def solve_nip(
    problem: NipProblem,
    *,
    scheme: Scheme | str = "graded",
    nodes: int | None = None,
    rtol: float | None = None,
    algorithm: str = "pivoting",
    start: NipResult | None = None,
) -> NipResult:
    """Solve the winding nip: where the web sticks and slips, and what tension the nip adds.

    Parameters
    ----------
    problem : NipProblem
    scheme : {"graded", "thesis", "thesis-printed"} or Scheme
        ``graded``: edge-graded nodes, exact kernel integrals (default).  ``thesis``: even nodes and
        backward differences (thesis sec. 3.4) with the web tension lumped; ``thesis-printed`` with
        the web's coefficients (121) as printed.
    nodes : int, optional
        Number M of nodes, 7 to 4000.  By default 41 to 257, as many as it takes until the estimated
        error of NIT is below 0.1 %; with bodies that are not linear 65 to 129, for 0.3 % (200 for
        the thesis's scheme).  NIT is corrected for where borders of stick and jumps of the
        tractions lie within their cells, and for what cells miss at the trailing edge
        (``extrapolation``).
    rtol : float, optional
        In place of nodes: refine until the estimated error of NIT is below ``rtol`` times the
        larger of |NIT| and 1 % of mu+ P; 1e-10 to 0.1; graded scheme only.  From 2e-4 down, on a
        rigid drum from 3e-5, and for linear elastic bodies, Chebyshev elements between zone
        borders take over (``scheme`` is then ``"elements"``).  Else, or where zones collide, meshes
        are fitted to the zones and NIT is extrapolated from them (``extrapolation``); the arrays
        are those of the finest.
    algorithm : {"pivoting", "panagiotopoulos"}
        How stick and slip are found; the latter is the thesis's process (sec. 3.6).
    start : NipResult, optional
        A solved neighbouring case; its half width and zones start this one, which saves the
        coarsest meshes.  The answer does not depend on it beyond the tolerance of the load, and
        the correction of NIT to a hundredth of itself.

    Returns
    -------
    NipResult

    Raises
    ------
    InvalidProblem
        For options out of range.
    NotConverged
        If a law is not satisfied to 1e-8, or ``rtol`` not reached; carries the best result.
    """
    check_type("problem", problem, NipProblem)
    M = check_options(scheme=scheme, nodes=nodes, rtol=rtol, algorithm=algorithm)
    if start is not None:
        check_type("start", start, NipResult)
    chosen = scheme_of(scheme)
    cold = chosen.starts_cold and algorithm == "panagiotopoulos"
    ladder = Ladder(
        NipContact(problem), chosen, "nip_induced_tension", ALGORITHMS[algorithm], scatters=True
    )
    begun = None if start is None else _started(start, problem)
    asked = DEFAULT if problem.linear else DEFAULT_HARDENING
    chooses = chosen.refines and nodes is None and rtol is None
    if begun is not None and chosen.refines and rtol is None:
        if chooses:
            M = ladder.enough([n for n in CHOSEN if n <= asked[1]], begun, asked[0])
        ladder.beside(halved(M, chosen.coarsest)[-2:], begun, *asked if chooses else ())
    elif chooses and problem.linear:
        ladder.choose(COARSE_NODES, [n for n in CHOSEN if n <= asked[1]], asked[0])
    else:
        counts = [M] if cold else halved(M, chosen.coarsest)[-2 if start else 0 :]
        # elements ask for borders alone, which the mesh before the last tells well enough mostly
        for last in (counts[:-1], counts) if _asks_for_elements(problem, rtol) else (counts,):
            ladder.climb(last, begun)
            found = _on_elements(ladder, problem, rtol, algorithm, careful=last is counts)
            if found is not None:
                return found.warned()
    if chooses:
        ladder.double(*asked, between=CHOSEN)
    if rtol is not None:
        ladder.fit(rtol, MOST_NODES)
    result = _result(ladder, problem, algorithm).checked()
    if rtol is not None and not ladder.reached(rtol):
        raise ladder.not_reached(rtol, "NIT", result)
    return result.warned()


def _asks_for_elements(problem: NipProblem, rtol: float | None) -> bool:
    fine = rtol is not None and rtol <= (ON_ELEMENTS if problem.drum.rigid else ON_ELASTIC)
    return fine and problem.linear and not problem.viscoelastic


def _on_elements(
    climbed: Ladder, problem: NipProblem, rtol: float | None, algorithm: str, careful: bool
) -> NipResult | None:
    """Return the result on Chebyshev elements; None without, or where borders are not found."""
    if rtol is None or not _asks_for_elements(problem, rtol) or (careful and rtol > CAREFUL):
        return None
    for turning in (False, True) if careful else (False,):
        try:
            ladder = OnElements(climbed, careful, turning)
            ladder.refine(rtol)
            return _result(ladder, problem, algorithm).checked()
        except (ArithmeticError, np.linalg.LinAlgError, NotConverged):
            continue
    return None


def check_options(
    *,
    scheme: Any = "graded",
    nodes: Any = None,
    rtol: Any = None,
    algorithm: Any = "pivoting",
) -> int:
    """Check the options of :func:`solve_nip`; return the number of nodes.

    Raises
    ------
    InvalidProblem
        For an option out of range.
    """
    chosen = scheme_of(scheme)
    if chosen is ELEMENTS:
        text = f"{ELEMENTS.name!r} is not admissible: a fine rtol chooses it by itself"
        raise InvalidProblem.at("scheme", text)
    if not isinstance(algorithm, str) or algorithm not in ALGORITHMS:
        text = f"{algorithm!r} is unknown{did_you_mean(str(algorithm), ALGORITHMS)}"
        raise InvalidProblem.at("algorithm", text)
    if rtol is not None:
        tolerance("rtol", rtol, 1e-10, 0.1)
        if not chosen.refines:
            raise InvalidProblem.at("rtol", f"{rtol!r} is not admissible with scheme {scheme!r}")
    nodes_or_rtol(nodes, rtol)
    return chosen.nodes if nodes is None else whole_number("nodes", nodes, 7, 4000)


def _started(start: NipResult, problem: NipProblem) -> Start:
    """Start from another case's result; without its widths, a Hertzian nip's go by the root."""
    zones = np.concatenate([start.roll_zone[1:-1], start.drum_zone[1:-1]])
    nodes = start.x[1:-1] / start.half_width
    known: Widths = start.widths or Widths(2.0, {})
    share = problem.nip_load / start.problem.nip_load
    guess = start.half_width * share ** (1 / known.power)
    tractions = (start.roll_traction[1:-1], start.drum_traction[1:-1])
    loads = NipMatrices.loads(start.pressure[1:-1], np.concatenate(tractions))
    runs = known.runs
    if runs is None and scheme_of(start.scheme).refines:
        runs = _runs(start.problem, vars(start), start.half_width)
    return Start(
        guess, (nodes, nodes), zones, known.power, widths=known.at(share),
        before=Before(nodes, loads), runs=runs,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class NipContact(PairContact):
    """A nip as the loop sees it."""

    equations_of: ClassVar[type[PairEquations]] = NipEquations

    @property
    def order(self) -> float:
        """By which power of the cells errors fall: two, as jumps are found within their cells."""
        return ORDER if jointly(self.problem) else super().order

    @property
    def outside(self) -> str:
        """What of the problem lies far outside the model, and what to change."""
        web = web_far_outside(self.problem, 2 * self.guess())
        return "; ".join(filter(None, (*web, super().outside)))

    def zones(self, start: Start, equations: NipEquations) -> Array:
        """Return the zones to begin with, their borders found within the cells before.

        From mesh to mesh a rigid body's end where slips are taken: its tractions may jump, so that
        the laws hardly tell where in a cell, and a short zone that is lost is not found again.
        """
        mesh, before, told = equations.mesh, start.level, start.runs
        if told is not None:
            runs = told
        elif before is not None and before.mesh.border_share is None:
            runs = _runs_of(self.problem, before)
        else:
            return super().zones(start, equations)
        found = [run.on(mesh.columns, mesh.middle[:-1]) for run in runs]
        if told is None and before is not None:
            nodes = before.mesh.middle[1:-1].searchsorted(mesh.columns, side="right")
            for face, body in enumerate(self.problem.bodies):
                if body.rigid:
                    found[face] = start.zones[face * before.mesh.unknowns :].take(nodes)
        return np.concatenate(found)

    def first_zones(self, equations: NipEquations) -> Array:
        """Return the zones to begin with where nothing is known: slip at the edges of the nip.

        Pressure slides a body that deforms and the web apart, most in the middle.  Held back there,
        they slip that way behind it and the other way before it.  The drum takes the winding force
        by slip behind a zone of stick, longer the more of the friction it asks for.
        """
        n, slips = equations.mesh.unknowns, equations.matrices.through_pressure
        zones, edge = np.zeros((2, n), dtype=np.int8), n // EDGE
        for face, body in enumerate(self.problem.bodies):
            if not body.rigid:
                way = 1 if slips[face * n + n // 2].sum() > 0 else -1
                zones[face, :edge], zones[face, n - edge :] = -way, way
        zones[1, n - taken_by(self.problem, n) :] = 1 if self.problem.winding_force >= 0 else -1
        return zones.ravel()

    def scalars(self, level: Level) -> Mapping[str, float]:
        """Return the outputs whose errors are told."""
        whole = _whole(level)
        found = {
            **super().scalars(level),
            "nip_induced_tension": whole * level.share**BY_LOAD,
            "drum_creep": _drum_creep(self.problem, level.state, whole),
            **_ratios(_runs_of(self.problem, level)),
        }
        for name, change in rest_of_borders(self.problem, level).items():
            found[name] += change
        found["tension_behind_nip"] = self.problem.web_tension + found["nip_induced_tension"]
        return found

    def foreseen(self, level: Level, scalars: Mapping[str, float]) -> Mapping[str, Foreseen]:
        """Return by how much outputs scatter on such a mesh, by what its borders leave open."""
        found = by_borders(self.problem, level, super().foreseen(level, scalars))
        if scalars.keys().isdisjoint(SLIP_RATIOS):
            return found
        return found | by_cells(level.mesh.nodes, _runs_of(self.problem, level))

    def grains(self, level: Level) -> dict[str, float]:
        """Return what a mesh leaves of outputs that changes between meshes need not show."""
        grains = super().grains(level)
        if grains:
            unseen = unseen_stick(level.mesh.nodes, _runs_of(self.problem, level))
            grains.update((name, grains[name] + unseen) for name in SLIP_RATIOS)
        return grains


def taken_by(problem: NipProblem | WrappedNipProblem, nodes: int) -> int:
    """Return how many nodes of a nip slip at the drum, about, to take the winding force."""
    asked = abs(problem.winding_force) / (problem.drum_friction * problem.nip_load)
    return round(nodes * (0.1 + min(asked, 1.0) / 2))


# ---- from a solved mesh to a result -------------------------------------------------------------


def _result(ladder: Ladder, problem: NipProblem, algorithm: str) -> NipResult:
    """Return the result of the last mesh, its certificate measured on what it reports."""
    level, scheme = ladder.level, ladder.scheme
    state, made = level.state, level.equations.matrices
    arrays = along_nip(level)
    gain = gained(
        problem, level.mesh, *(arrays[k] for k in ("x", "roll_traction", "drum_traction"))
    )
    whole, T_in = _whole(level), problem.web_tension
    NIT = ladder.values["nip_induced_tension"]
    ratios: dict[str, Any] = {name: ladder.history[-1][name] for name in SLIP_RATIOS}
    result = NipResult(
        problem=problem,
        nip_induced_tension=NIT,
        extrapolation=NIT - whole,
        half_width=state.half_width,
        approach=approach(
            problem, made, state, problem.web.compliance.c12 * (T_in + whole)
        ),
        offset=state.shift * problem.contact_radius,
        drum_creep=_drum_creep(problem, state, whole),
        **ratios,
        **arrays,
        web_tension=T_in + gain,
        residuals=Residuals(),
        scheme=scheme.name,
        algorithm=algorithm,
        iterations=ladder.solves,
        series_terms=max(r.terms for r in made.responses),
        series_error=max(r.truncation_error for r in made.responses),
        mesh=level.mesh,
        widths=ladder.widths._replace(runs=_runs_of(problem, level)),
        rolling_resistance=ladder.history[-1].get("rolling_resistance", nan),
    )  # fmt: skip
    return measured(
        result,
        errors=ladder.errors_of(result),
        residuals=certificate(result, level.equations.anew(state)),
        warnings=nip_warnings(result),
    )


def along_nip(level: Level) -> dict[str, Any]:
    """Return what a solved mesh has along the nip, by the names of the result, (M,) each."""
    if "along" not in level.kept:  # asked for by outputs, zones of the next mesh and result
        level.kept["along"] = _along(level)
    return dict(level.kept["along"])


def _along(level: Level) -> dict[str, Any]:
    state, mesh, n = level.state, level.mesh, level.mesh.unknowns
    a, slips, zones = state.half_width, state.solution.slip, state.solution.state
    last = level.equations.last_slips(state)
    return {
        "x": a * mesh.nodes,
        "slip_x": a * _on_nodes(mesh.middle[:-1], mesh.middle[-1]),
        "pressure": padded(state.pressure),
        "roll_traction": padded(state.traction[:n]),
        "drum_traction": padded(state.traction[n:]),
        "roll_slip": _on_nodes(slips[:n], last[0]),
        "drum_slip": _on_nodes(slips[n:], last[1]),
        "roll_zone": _on_nodes(zones[:n], zones[n - 1]),
        "drum_zone": _on_nodes(zones[n:], zones[-1]),
    }


def _on_nodes(values: Array, last: Any) -> Array:
    """Return values of the cells before the interior nodes on all nodes, the last one given."""
    out = np.empty(values.size + 2, dtype=values.dtype)
    out[0], out[1:-1], out[-1] = values[0], values, last
    return out


def slip_ratios(
    problem: Any, arrays: Mapping[str, Array], share: float | None = None
) -> dict[str, Any]:
    """Return the signed slip lengths over the nip width (thesis eq. 172) by name.

    Parameters
    ----------
    problem : NipProblem or WrappedNipProblem
    arrays : mapping
        x, slip_x, pressures, tractions, zones and slips of both faces, in the nip.
    share : float, optional
        Where borders are from the node before them to the next; else slip and slack tell it.
    """
    x = arrays["x"]
    return _ratios(_runs(problem, arrays, float(x[-1] - x[0]) / 2, share))


def _ratios(runs: Sequence[Runs]) -> dict[str, Any]:
    """Return the signed slip lengths over the nip width by name, of zones in units of a."""
    (leading, trailing), (_, drum) = (face.slip_lengths(-1.0, 1.0) for face in runs)
    dual = min(trailing, drum, key=abs) if trailing * drum > 0 else 0.0
    return dict(zip(SLIP_RATIOS, (leading / 2, trailing / 2, dual / 2), strict=True))


def _faces(problem: Any, arrays: Mapping[str, Array]) -> Iterator[dict[str, Any]]:
    """Yield what tells the zones of roll and drum, from arrays as ``slip_ratios`` takes them."""
    for face, friction in (("roll", problem.roll_friction), ("drum", problem.drum_friction)):
        p, q = arrays.get(f"{face}_pressure", arrays["pressure"]), arrays[f"{face}_traction"]
        yield {
            "x": arrays["x"], "slip_x": arrays["slip_x"],
            "zones": arrays[f"{face}_zone"], "slip": arrays[f"{face}_slip"],
            "slack": friction * p - np.abs(q), "rigid": getattr(problem, face).rigid,
        }  # fmt: skip


def _runs(
    problem: Any, arrays: Mapping[str, Array], a: float, share: float | None = None
) -> list[Runs]:
    """Return the zones of both faces, in units of a."""
    arrays = {**arrays, "x": arrays["x"] / a, "slip_x": arrays["slip_x"] / a}
    return [Runs.of(**face, share=share) for face in _faces(problem, arrays)]


def _runs_of(problem: Any, level: Level) -> list[Runs]:
    """Return the zones of both faces of a solved mesh, in units of a."""
    if "runs" not in level.kept:  # asked for by outputs, the next mesh and the next case
        arrays, share = along_nip(level), level.mesh.border_share
        level.kept["runs"] = _runs(problem, arrays, level.state.half_width, share)
    return list(level.kept["runs"])


def _drum_creep(problem: NipProblem, state: PairState, whole: float) -> float:
    """Return xi- (thesis eq. 93): the solved rigid slip holds the web's strain behind the nip."""
    c11 = problem.web.compliance.c11
    T_out = problem.web_tension + whole
    return float(state.solution.creep - c11 / problem.web.thickness * T_out)


def _whole(level: Level) -> float:
    """Return the integral of q+ + q-, the NIT of this mesh [N/m]."""
    weights, q = level.equations.matrices.weights, level.state.traction
    n, problem, a = weights.size, level.equations.problem, level.state.half_width
    roll, drum = (level.mesh.facing(body.rigid) for body in problem.bodies)
    if roll is drum:
        return float(weights @ (q[:n] + q[n:]))
    return float(a * (roll.grid.weights @ q[:n] + drum.grid.weights @ q[n:]))


# ---- from a result's arrays ---------------------------------------------------------------------


def recomputed(result: NipResult) -> dict[str, tuple[float, float]]:
    """Return the scalars that no law tells, by name: as the arrays give them, how exactly."""
    problem, inside = result.problem, slice(1, -1)
    state: Any = SimpleNamespace(  # as much of one as the approach asks for
        half_width=result.half_width, pressure=result.pressure[inside],
        traction=np.concatenate([result.roll_traction[inside], result.drum_traction[inside]]),
        shift=result.offset / problem.contact_radius,
    )  # fmt: skip
    behind = problem.web.compliance.c12 * float(result.web_tension[-1])
    delta = approach(problem, matrices_of(result), state, behind)
    slips = slip_ratios(problem, vars(result), mesh_of(result).border_share)
    return {"extrapolation": (0.0, most_beyond(result)), **told_by(delta, slips, result.x)}


def most_beyond(result: Any) -> float:
    """Return what a tension may have beyond the integral of the tractions, at most [N/m].

    Where borders lie within their cells leaves up to 9/N^2 of mu+ P on coarse meshes of 3000 random
    nips; fitted meshes leave thousandths.
    """
    P, mu = result.problem.nip_load, result.problem.roll_friction
    return float(max(0.02, 12 / (result.nodes - 1) ** 2) * mu * P)


def told_by(delta: float, slips: Mapping[str, float], x: Array) -> dict[str, tuple[float, float]]:
    """Return approach and slip ratios with how exactly the arrays give them, at any version.

    0.1 placed borders half-way between nodes, and summed the series of the approach less far.
    """
    cell = float(np.max(np.diff(x))) / float(x[-1] - x[0])
    return {
        "approach": (delta, 1e-5 * abs(delta)),
        **{name: (value, cell) for name, value in slips.items()},
    }
