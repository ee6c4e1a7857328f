r"""Procedure of the thesis for the winding nip, written to be read next to sections 3.4 and 3.6.

M equidistant nodes, backward differences for the strains, the modified Panagiotopoulos process for
stick and slip, and a secant method for the half width.  It is a second solver, independent of
``woundon.solve``, and less accurate: NIT converges as M^(-1/2) to M^(-1), because the wound-on
condition takes the strain of the roll in the last cell, where the pressure varies as the root of
the distance to the edge.

Unknowns p_m, q+_m, q-_m (m = 2 ... M-1), delta, Delta, T_out, xi-; the half width a is given:

    normal problem (126)      [A_1 + A_2 - 2 c22 h] p - delta + Delta x/R* = x^2/(2 R*)
                                    - (B+- + B_1) q+ - (B+- + B_2) q- - c12 T_in      M equations
    stick at the roll (131)   v+ = eps - eps_1 + eps_1(x_M) - D T_out = 0             D = c11/2h
    stick at the drum (131)   v- = eps - eps_2 + xi- = 0
    slip (132)                q+- = mu+- sgn(v+-) p
    equilibrium (135)         dx sum q- = F,  T_out - dx sum (q+ + q-) = T_in

with the web's strain eps = D T - c12 p (118) and 1/R* = 1/R_1 + 1/R_2.  Corrections of the printed
text: (82), (98), (126) print epsilon for Delta; for those of the coefficients see ``influence``.

Departures from the text, each for a reason given where it is made: the web tension is lumped (an
option); zones of a coarser mesh (an option) and of the last half width are the initial guess; one
node moves at a time where the process repeats itself; one node of the drum is kept in stick; the
load is met to less than 1 N/m.  With ``exact_edge`` the cause of the slow convergence is removed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log, pi, sqrt
from typing import Any, Literal, NamedTuple

import numpy as np
from scipy.linalg import lu_factor, lu_solve

import woundon as wo

from .influence import (
    Coefficients,
    coefficients,
    edge_strain,
    half_plane_constants,
)

__all__ = ["ProcedureResult", "solve"]

Array = np.ndarray

TOLERANCE = 1e-9  # of the largest bound and slip, from which on a contact condition is violated
SETTLED = 1e-11  # change of the tractions at which Step 9 stops, relative
LOAD_TOLERANCE = 1e-9  # of P; the thesis: 1 N/m
COARSEST = 25  # nodes of the first mesh, at least
SYSTEMS = 2000  # linear systems at one half width, at most


@dataclass(frozen=True, eq=False)
class ProcedureResult:
    """A nip solved by the procedure of the thesis.  Names and signs are those of ``NipResult``.

    Attributes
    ----------
    problem : NipProblem
    half_width : float
        a [m].
    nip_induced_tension : float
        NIT = Q+ + Q- = T_out - T_in [N/m].
    drum_creepage : float
        xi-, creepage of web and drum (92).
    approach, offset : float
        -delta > 0 and Delta (82) [m].
    x : (M,) array
        Nodes [m].
    drum_pressure, roll_traction, drum_traction : (M,) arrays
        p, q+, q- at the nodes [Pa].
    slip_x : (M,) array
        Middle of the cell before each node, where the slips are taken [m]; the first is repeated.
    roll_slip, drum_slip : (M,) arrays
        v+, v- (133); the first is repeated.
    roll_zone, drum_zone : (M,) int arrays
        0 stick, 1 slip with the web faster, -1 slower; the edges have those of their neighbours.
    tension : (M,) array
        T(x) [N/m].
    iterations : int
        Linear systems of the tangential problem that were solved.
    """

    problem: wo.NipProblem
    half_width: float
    nip_induced_tension: float
    drum_creepage: float
    approach: float
    offset: float
    x: Array
    drum_pressure: Array
    roll_traction: Array
    drum_traction: Array
    slip_x: Array
    roll_slip: Array
    drum_slip: Array
    roll_zone: Array
    drum_zone: Array
    tension: Array
    iterations: int

    def __post_init__(self) -> None:
        for value in vars(self).values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @property
    def nodes(self) -> int:
        """Number of nodes M."""
        return int(self.x.size)

    @property
    def in_nip(self) -> slice:
        """All nodes."""
        return slice(0, self.nodes)

    @property
    def nip_width(self) -> float:
        """2a [m]."""
        return 2 * self.half_width

    @property
    def outlet_tension(self) -> float:
        """T_out [N/m]."""
        return float(self.problem.web_tension + self.nip_induced_tension)


def solve(
    problem: wo.NipProblem,
    nodes: int = 200,
    *,
    web_tension: Literal["lumped", "printed"] = "lumped",
    exact_edge: bool = False,
    cold: bool = False,
    load_tolerance: float = LOAD_TOLERANCE,
) -> ProcedureResult:
    """Solve a nip as the thesis did.

    Parameters
    ----------
    problem : NipProblem
        With a roll and a drum that are rigid, half-planes or cylinders of one elastic material.
    nodes : int
        M, at least 8.
    web_tension : {"lumped", "printed"}
        Tension in a cell of the web: without the traction of the node that ends it, or by (121).
        With (121) the stick equations of neighbouring nodes differ by q_l + 4 q_(l-1) + q_(l-2),
        whose root -3.73 makes the tractions oscillate upstream of the slip zone.
    exact_edge : bool
        Whether the wound-on condition takes the strain of the roll at x = a itself, instead of that
        of the last cell (130); NIT then converges as 1/M.
    cold : bool
        Whether the process begins with stick everywhere, as Step 2 has it.  By default it begins
        with the zones of a solution on half as many nodes: with a rigid drum the zone boundary
        moves by one node in each linear system, so that a cold start takes some hundred of them.
    load_tolerance : float
        Accepted relative difference of the nip load.

    Raises
    ------
    InvalidProblem
        If a body, the web or an option is not possible.
    NotConverged
        If the process or the search for the half width does not converge.

    Examples
    --------
    >>> from woundon.jorkama2001.cases import paper_nip
    >>> roll = wo.HalfPlane(radius=0.3, material=wo.material("paper"))
    >>> round(solve(paper_nip(roll=roll), nodes=50).nip_induced_tension, 1)
    111.1
    """
    _check(problem, nodes, web_tension, load_tolerance)
    P, a = problem.nip_load, _hertz_half_width(problem)
    zones, systems = np.zeros(2 * (nodes - 2), dtype=int), 0
    if not cold and nodes >= 2 * COARSEST:
        coarse = solve(
            problem, nodes // 2, web_tension=web_tension, exact_edge=exact_edge, load_tolerance=1e-3
        )
        a, systems = coarse.half_width, coarse.iterations
        nearest = np.rint(np.linspace(0, coarse.nodes - 1, nodes)[1:-1]).astype(int)
        zones = np.concatenate([coarse.roll_zone[nearest], coarse.drum_zone[nearest]])
    # secant method on ln P against ln a, which are nearly proportional, by 2 for half-planes
    power, last = 2.0, None
    for _ in range(40):
        nip = _Nip(problem, nodes, a, web_tension, exact_edge)
        state = _panagiotopoulos(nip, zones)
        # the next half width is close: its zones are, too, and Step 2 would start far from them
        zones, systems = state.zones, systems + nip.systems
        carried = nip.dx * float(state.p.sum())  # (134)
        # of ln P; a negative load has no logarithm and counts as much too low
        missed = log(carried / P) if carried > 0 else -2.0
        if abs(missed) <= load_tolerance:
            return _result(nip, state, systems)
        if last is not None and abs(log(a / last[0])) > 1e-9:
            power = min(max((missed - last[1]) / log(a / last[0]), 0.7), 12.0)
        last = a, missed
        a *= exp(-min(max(missed / power, -1.5), 1.5))
    raise wo.NotConverged(f"the half width did not converge: {a:.6g} m")


def _check(problem: Any, nodes: Any, web_tension: Any, load_tolerance: Any) -> None:
    """Reject problems and options for which the procedure is not defined."""
    if not isinstance(problem, wo.NipProblem):
        text = f"{type(problem).__name__} is not possible; must be a NipProblem"
        raise wo.InvalidProblem([("problem", text)])
    for name in ("roll_wrap", "drum_wrap"):
        if angle := getattr(problem, name):
            text = f"{angle:.6g} is not possible; must be 0 [rad], the procedure has no wraps"
            raise wo.InvalidProblem([(name, text)])
    if problem.air is not None:
        raise wo.InvalidProblem([("air", "is not possible; must be left out")])
    for name in ("roll", "drum"):
        body = getattr(problem, name)
        if type(body) not in (wo.Rigid, wo.HalfPlane, wo.Cylinder) or body.viscoelastic:
            text = f"{body!r} is not possible; must be Rigid, or an elastic HalfPlane or Cylinder"
            raise wo.InvalidProblem([(name, text)])
    if not problem.web.linear:
        raise wo.InvalidProblem([("web.material", "the web hardens; its moduli must be constant")])
    if problem.roll.rigid and problem.drum.rigid:
        raise wo.InvalidProblem([("drum", "roll and drum are rigid; one must be elastic")])
    if isinstance(nodes, bool) or not isinstance(nodes, int) or nodes < 8:
        raise wo.InvalidProblem([("nodes", f"{nodes!r} is out of range; must be a number >= 8")])
    if web_tension not in ("lumped", "printed"):
        text = f"{web_tension!r} is unknown; known: lumped, printed"
        raise wo.InvalidProblem([("web_tension", text)])
    if not (isinstance(load_tolerance, float) and 1e-12 <= load_tolerance <= 1e-2):
        text = f"{load_tolerance!r} is out of range; must be >= 1e-12 and <= 0.01"
        raise wo.InvalidProblem([("load_tolerance", text)])


def _hertz_half_width(problem: wo.NipProblem) -> float:
    """Return the half width of the contact of half-planes without friction (101)-(103)."""
    curvature = 1 / problem.roll.radius + 1 / problem.drum.radius
    compliance = 0.0  # 1/E*
    for body in problem.bodies:
        if isinstance(body, wo.HalfPlane | wo.Cylinder):
            _, _, C = half_plane_constants(body.material.stiffness)
            compliance += C / 2  # 1/E_i = C_i/2
    return 2 * sqrt(problem.nip_load * compliance / (pi * curvature))


def _web_constants(web: wo.Web) -> tuple[float, float, float]:
    """Return D = c11/(2h), c12 and 2h c22 (120), (121), of the inverse of the stiffness (63)."""
    A_rr, A_tt, A_rt, *_ = web.material.stiffness
    det = A_rr * A_tt - A_rt**2
    return A_rr / det / web.thickness, -A_rt / det, web.thickness * A_tt / det


# ---- discretized equations, section 3.4 ---------------------------------------------------------


class _State(NamedTuple):
    """Unknowns of a nip: zones are 0 in stick, the sign of the slip else; roll first, then drum."""

    zones: Array  # (2n,)
    p: Array  # (n,) [Pa]
    q: Array  # (2n,) [Pa]
    T_out: float  # [N/m]
    xi: float  # xi-, creepage of web and drum
    v: Array  # (2n,) slips of the nodes in slip, 0 in stick
    delta: float  # [m]
    shift: float  # Delta [m]


class _Nip:
    """The discretized equations for a given half width a, of n = M - 2 interior nodes."""

    def __init__(
        self, problem: wo.NipProblem, M: int, a: float, web_tension: str, exact_edge: bool
    ) -> None:
        self.problem, self.a, self.n, self.systems = problem, a, M - 2, 0
        self.x, self.dx = np.linspace(-a, a, M), 2 * a / (M - 1)
        self.curvature = 1 / problem.roll.radius + 1 / problem.drum.radius  # 1/R*
        self.friction = np.repeat([problem.roll_friction, problem.drum_friction], self.n)
        roll, drum = (coefficients(body, M, a) for body in problem.bodies)
        self._normal(roll, drum)
        edge = edge_strain(problem.roll, M, a) if exact_edge else (roll.C[-1], roll.D[-1])
        self._tangential(roll, drum, edge, web_tension)

    def _normal(self, roll: Coefficients, drum: Coefficients) -> None:
        """Assemble the normal problem (126)."""
        n, x, (_, c12, thinning) = self.n, self.x, _web_constants(self.problem.web)
        matrix = np.column_stack([roll.A + drum.A, -np.ones(n + 2), self.curvature * x])
        inside = np.arange(n)
        matrix[inside + 1, inside] -= thinning  # A of (120)
        # B+- of (120): all tractions upstream, half of the node's own
        upstream = np.tri(n + 2, n, -1) - 0.5 * np.eye(n + 2, n, -1)
        B = c12 * self.dx * upstream
        self.by_q = np.hstack([B + roll.B, B + drum.B])
        self.gap = self.curvature * x**2 / 2 - c12 * self.problem.web_tension
        self.normal_factors = lu_factor(matrix, check_finite=False)

    def _tangential(
        self, roll: Coefficients, drum: Coefficients, edge: tuple[Array, Array], web_tension: str
    ) -> None:
        """Assemble v = K (q+, q-, T_out, xi-) + K_p p + v_0 of both faces (131), (133).

        Those of the cells that end at the nodes 2 ... M-1 are the slips of these nodes.  The last
        cell belongs to no unknown.  K and the rows of (136) are scaled as (122) does, with A_t of
        the web: q/A_t and T_out/(h A_t).  ``edge`` holds the coefficients of eps_1(x_M) by p and q.
        """
        n, dx, (D, c12, _) = self.n, self.dx, _web_constants(self.problem.web)
        # rows: cells; the node that ends a cell, and the one that begins it
        own, before = np.eye(n + 1, n), np.eye(n + 1, n, -1)
        # D+- of (121): all tractions upstream of the cell, at its two nodes 5/6 and 1/6 of them
        D_web = D * dx * np.tri(n + 1, n, -1)
        if web_tension == "printed":
            D_web += D * dx / 6 * (own - before)
        C_web = -c12 / 2 * (own + before)  # C+- of (121)
        A_t, self.h = self.problem.web.material.stiffness[1], self.problem.web.thickness / 2
        K = np.zeros((2, n + 1, 2 * n + 2))
        K[0, :, :n] = D_web - roll.D + edge[1]
        K[0, :, n:-2] = K[1, :, :n] = D_web
        K[1, :, n:-2] = D_web - drum.D
        K[0, :, -2] = -D * self.h
        K[1, :, -1] = 1 / A_t
        K_p = np.stack([C_web - roll.C + edge[0], C_web - drum.C])
        self.K, self.K_p = A_t * K[:, :-1].reshape(2 * n, -1), K_p[:, :-1].reshape(2 * n, -1)
        self.last_K, self.last_K_p = A_t * K[:, -1], K_p[:, -1]
        self.A_t, self.v_0 = A_t, D * self.problem.web_tension
        self.equilibrium = np.zeros((2, 2 * n + 2))  # (136)
        self.equilibrium[0, n:-2] = 1.0
        self.equilibrium[1, :-2], self.equilibrium[1, -2] = -1.0, self.h / dx
        self.factors: dict[bytes, tuple[Array, Array]] = {}

    def pressure(self, q: Array) -> tuple[Array, float, float]:
        """Solve the normal problem for given tractions: p, delta, Delta."""
        solution = lu_solve(self.normal_factors, self.gap - self.by_q @ q, check_finite=False)
        return solution[:-2], float(solution[-2]), float(solution[-1])

    def tractions(self, zones: Array, p: Array) -> _State:
        """Solve the tangential problem for given zones and pressures (131), (132), (136)."""
        n, stick = self.n, np.flatnonzero(zones == 0)
        bound = self.friction * np.tile(p, 2)
        z = np.append(zones * bound / self.A_t, [0.0, 0.0])  # (132)
        # at another load than P the winding force is the same share of it: |F| < mu- P throughout
        F = self.problem.winding_force * float(p.sum()) * self.dx / self.problem.nip_load
        T_in = self.problem.web_tension
        given = self.K_p @ p + self.v_0
        right = np.concatenate(
            [
                -given[stick] - self.K[stick] @ z,
                np.array([F, T_in]) / (self.dx * self.A_t) - self.equilibrium @ z,
            ]
        )
        unknown = np.append(stick, [2 * n, 2 * n + 1])
        key = zones.tobytes()
        if key not in self.factors:
            rows = np.vstack([self.K[stick], self.equilibrium])
            self.factors[key] = lu_factor(rows[:, unknown], check_finite=False)
            self.systems += 1
        z[unknown] = lu_solve(self.factors[key], right, check_finite=False)
        v = self.K @ z + given
        v[stick] = 0.0
        T_out = float(z[-2] * self.h * self.A_t)
        return _State(zones, p, z[:-2] * self.A_t, T_out, float(z[-1]), v, 0.0, 0.0)


# ---- modified Panagiotopoulos process, section 3.6 -----------------------------------------------


def _panagiotopoulos(nip: _Nip, zones: Array) -> _State:
    """Solve normal and tangential problem in turn, from given zones (Step 2: stick everywhere)."""
    q = np.zeros(2 * nip.n)  # Step 0
    for _ in range(200):
        p, delta, shift = nip.pressure(q)  # Step 1
        state = _tangential_problem(nip, zones, p)  # Steps 2 to 8
        change = float(np.max(np.abs(state.q - q)))
        q, zones = state.q, state.zones
        if change <= SETTLED * float(np.max(np.abs(q))):  # Step 9
            return state._replace(delta=delta, shift=shift)
    raise wo.NotConverged(f"pressures and tractions did not converge: last change {change:.3g} Pa")


def _tangential_problem(nip: _Nip, zones: Array, p: Array) -> _State:
    """Move nodes from stick to slip, and back, until all contact conditions hold (Steps 4 to 8)."""
    bound = nip.friction * np.tile(p, 2)
    seen: set[bytes] = set()
    single = False
    for _ in range(SYSTEMS):
        state = nip.tractions(zones, p)  # Step 4
        excess = np.abs(state.q) - bound
        leave = (zones == 0) & (excess > TOLERANCE * np.max(np.abs(bound)))  # Step 5
        back = (zones != 0) & (zones * state.v < -TOLERANCE * np.max(np.abs(state.v)))  # Step 7
        moved = leave if leave.any() and not single else leave | back  # Step 6 goes first
        if not moved.any():
            return state
        # the process may repeat itself forever; Murty's rule, to move the last node alone, ends
        # for every matrix whose principal minors are positive
        single = single or zones.tobytes() in seen
        seen.add(zones.tobytes())
        if single:
            moved[: np.flatnonzero(moved)[-1]] = False
        zones = np.where(moved, np.where(zones == 0, np.sign(state.q).astype(int), 0), zones)
        zones = _keep_drum_in_stick(nip, zones, state)
    raise wo.NotConverged(f"stick and slip not found after {SYSTEMS} linear systems")


def _keep_drum_in_stick(nip: _Nip, zones: Array, state: _State) -> Array:
    """Keep one node of the drum in stick: if all slip, no equation determines xi- for a given F."""
    drum = slice(nip.n, 2 * nip.n)
    if np.any(zones[drum] == 0):
        return zones
    # the tractions of the nodes that leave stick tell which way the drum is to slip as a whole;
    # the node kept is the one that slips least among those that slip the other way
    before, v = state.zones[drum], np.abs(state.v[drum])
    wanted = np.sign(zones[drum][before == 0].sum())
    against = (before != 0) & (zones[drum] * wanted <= 0)
    candidates = against if against.any() else before != 0
    kept = np.argmin(np.where(candidates, v, np.inf)) if candidates.any() else 0
    zones = zones.copy()
    zones[nip.n + kept] = 0
    return zones


def _result(nip: _Nip, state: _State, systems: int) -> ProcedureResult:
    """Assemble the result of the procedure from its last state."""
    problem, n = nip.problem, nip.n
    edges = [(0, 0), (1, 1)]  # np.pad: a value at either edge of the nip for both faces
    p, (roll_q, drum_q) = np.pad(state.p, 1), np.pad(state.q.reshape(2, n), edges)
    total = roll_q + drum_q
    z = np.append(state.q / nip.A_t, [state.T_out / (nip.h * nip.A_t), state.xi])
    last = nip.last_K @ z + nip.last_K_p @ state.p + nip.v_0  # slips in the last cell
    slips = np.pad(state.v.reshape(2, n), edges, mode="edge")
    slips[:, -1] = last
    zones = np.pad(state.zones.reshape(2, n), edges, mode="edge")
    middle = (nip.x[1:] + nip.x[:-1]) / 2
    return ProcedureResult(
        problem=problem,
        half_width=nip.a,
        nip_induced_tension=state.T_out - problem.web_tension,
        drum_creepage=state.xi,
        approach=-state.delta,
        offset=state.shift,
        x=nip.x,
        drum_pressure=p,
        roll_traction=roll_q,
        drum_traction=drum_q,
        slip_x=np.append(middle[:1], middle),  # the first is repeated: one for each node
        roll_slip=slips[0],
        drum_slip=slips[1],
        roll_zone=zones[0],
        drum_zone=zones[1],
        tension=problem.web_tension
        + np.append(0.0, np.cumsum((total[1:] + total[:-1]) / 2) * nip.dx),
        iterations=systems,
    )
