r"""Several nips of one outer layer as one coupled system, independent of the solver in the package.

A web is laid on a roll in a first nip, and runs with it through further nips between the roll (+)
and drums (-), hard ones or linear bodies.  p, q are pressure and traction of the web on the bodies;
s runs along the surface of the roll in the direction of travel, nip k lies at s_k - a_k to
s_k + a_k.  Between the nips and downstream of the last one are arcs on which the web touches the
roll only.

    gap slope     v+' + v-' + c12 (q+ + q-) - 2h c22 p+' + Delta_k/R* - (s - s_k)/R* = 0
                  in the cells of nip k
    equilibrium   p+ = p- - T kappa- in nip k, p+ = T kappa+ on arcs and at the edges of nips;
                  p+ = 0 at the leading edge of nip 1, p- = 0 at all edges
    resultants    int q- ds = F_k, int p- ds = P_k over nip k
    tension       T = T_in + int (q+ + q-) ds
    slip          v+ = eps - eps+ - E, E = (eps - eps+)(end);  v- = eps - eps- + xi_k
    friction      stick v = 0, |q| <= mu p;  slip q = s mu p, s v >= 0

kappa+ = 1/R - v'' - v/R^2, and kappa- = 1/R_k - v-''; the product T kappa- is linearised about the
iterate before.  Per unit of the roll's speed the unstrained web and the unstrained surface of the
roll are equally fast everywhere, so that there is one E for all nips.

The tractions are linear between nodes, and slopes and slips are collocated once in each cell, the
slip of a node in the cell upstream of it.  All half widths are unknowns; the active set changes
one iteration after the other.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

import woundon as wo
from woundon.elasticity.kernels import singular

Array = np.ndarray

GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(4)
GROWTH, LONGEST = 1.3, 0.06  # ratio of neighbouring cells of an arc, and its longest cell [rad]
END = 0.1  # last part of the last arc, with the curvature at its start: the pressure ends abruptly
DIFFERENCE = 1e-6  # step of ln a
# The columns by ln a are renewed after a change of ln a, and after so many iterations.
CHANGED, RENEWED = 0.01, 12
TOLERANCE = 1e-9  # of the last Newton step, in the units of the unknowns


@dataclass(frozen=True)
class Nip:
    """A nip: position s_k [rad], drum radius [m], P and F [N/m]; a hard drum without a body."""

    angle: float
    drum_radius: float
    load: float
    force: float = 0.0
    drum: Any = None


@dataclass(frozen=True)
class Solution:
    """Fields along the roll at the nodes, and the mesh."""

    system: Any
    u: Array
    active: Array
    half_width: Array
    tension: Array
    p_roll: Array
    q_roll: Array
    slip: Array  # v+ in the cells

    @property
    def wound_on_tension(self) -> float:
        """T at the end of the last arc [N/m]."""
        return float(self.tension[-1])

    @property
    def closed_tension(self) -> float:
        """Tension of the closed layer [N/m]: it has the strain with which it was laid."""
        system, case, T = self.system, self.system.case, self.wound_on_tension
        closed = case.roll.uniform_strain(T / case.roll.radius)
        return float(T + (closed - system.end_roll_strain(self.u)) / system.stretch)

    def on_arc(self, k: int) -> Array:
        """Tensions from the trailing edge of nip k to the leading edge of the next [N/m]."""
        system = self.system
        stop = system.first[k + 1] if k + 1 < len(system.first) else system.n
        return self.tension[system.first[k] + system.cells : stop + 1]


def graded(length: float, shortest: float, longest: float, both: bool) -> Array:
    """Return relative positions 0 ... 1 of the nodes of an arc, graded to one or both ends."""
    half = length / 2 if both else length
    sizes, total = [], 0.0
    while total < half:
        sizes.append(min(shortest * GROWTH ** len(sizes), longest))
        total += sizes[-1]
    cells = np.array([*sizes, *sizes[::-1]] if both else sizes)
    return np.append(0.0, np.cumsum(cells)) / cells.sum()


def influence(roll: Any, points: Array, nodes: Array) -> Array:
    """Return slope and strain by p and q: (4, points, nodes) [1/Pa] x hat functions.

    Order: slope by p, slope by q, strain by p, strain by q.  Singular parts are integrated in
    closed form on each cell, the smooth part by Gauss's rule with four points.
    """
    kernels = roll.kernels()
    return _integrated(kernels.gradients, kernels.smooth, roll, points, nodes)


def displacement(roll: Any, points: Array, nodes: Array) -> Array:
    """Return v by p and q at points, (2, points, nodes) [m/Pa] x hat functions."""
    kernels = roll.kernels()
    which = kernels.normal_p, kernels.normal_q
    return _integrated(which, kernels.normal_smooth, roll, points, nodes)


def _integrated(which: Any, smooth: Any, roll: Any, points: Array, nodes: Array) -> Array:
    """Integrate influence functions against the hats of the nodes."""
    h, left = np.diff(nodes), nodes[:-1]
    t0, t1 = points[:, None] - left, points[:, None] - nodes[1:]  # t = y - s at the ends of cells
    ln0, ln1 = (np.log(np.maximum(np.abs(t), 1e-300)) for t in (t0, t1))
    # integrals over a cell of k(t) and of k(t) (s - left)/h, s = y - t
    L = ln0 - ln1
    one = {"inverse": L, "log": t0 * ln0 - t1 * ln1 - h, "sign": np.abs(t0) - np.abs(t1)}
    square = (t0**2 * (ln0 - 0.5) - t1**2 * (ln1 - 0.5)) / 2  # int t ln|t| dt
    odd = (t0 * np.abs(t0) - t1 * np.abs(t1)) / 2  # int |t| dt
    by_s = {
        "inverse": (t0 * L - h) / h,
        "log": (t0 * one["log"] - square) / h,
        "sign": (t0 * one["sign"] - odd) / h,
    }
    out = np.zeros((len(which), points.size, nodes.size))
    for matrix, kernel in zip(out, which, strict=True):
        whole = sum(getattr(kernel, name) * value for name, value in one.items())
        right = sum(getattr(kernel, name) * value for name, value in by_s.items())
        matrix[:, :-1] += whole - right
        matrix[:, 1:] += right
        cell = np.clip(np.searchsorted(nodes, points) - 1, 0, h.size - 1)
        fraction = (points - nodes[cell]) / h[cell]
        row = np.arange(points.size)
        matrix[row, cell] += kernel.delta * (1 - fraction)
        matrix[row, cell + 1] += kernel.delta * fraction
    if smooth is None:
        return out
    fraction = (GAUSS + 1) / 2
    sources = (left[:, None] + h[:, None] * fraction).ravel()
    t = points[:, None] - sources
    turn = 2 * np.pi * roll.radius if roll.curvature else np.inf
    far = np.abs(t) > turn / 2
    short = np.where(far, t - np.sign(t) * turn, t) if np.isfinite(turn) else t
    values = smooth(short)
    if far.any():
        values[:, far] += singular(which, short[far]) - singular(which, t[far])
    values = values.reshape(len(which), points.size, h.size, GAUSS.size)
    weight = h[:, None] * WEIGHTS / 2
    out[:, :, :-1] += (values * (weight * (1 - fraction))).sum(axis=-1)
    out[:, :, 1:] += (values * (weight * fraction)).sum(axis=-1)
    return out


class System:
    """The operators for given half widths; all fields are linear in the unknowns.

    u = (p_1 ... p_n | Delta_k/R*, xi_k, ln a_k for each nip k | q+_1 ... q+_(n-1) | q- in the nips)
    """

    def __init__(self, case: Case, a: Array) -> None:
        self.case, self.a = case, a
        roll, web, M = case.roll, case.web, case.cells
        R, self.T_in, self.cells, K = roll.radius, case.tension, M, len(case.nips)
        nodes, points, self.first = [], [], []
        centres = np.array([nip.angle * R for nip in case.nips])
        x = -np.cos(np.pi * np.arange(2 * M + 1) / (2 * M))
        for k in range(K):
            self.first.append(sum(part.size for part in nodes))
            edge = centres[k] + a[k]
            arc = (centres[k + 1] - a[k + 1] if k + 1 < K else case.end * R) - edge
            whole = case.arcs[k]
            grid = np.interp(np.arange(2 * whole.size - 1) / 2, np.arange(whole.size), whole) * arc
            nodes += [centres[k] + a[k] * x[0:-1:2], edge + grid[0:-1:2]]
            points += [centres[k] + a[k] * x[1::2], edge + grid[1::2]]
        self.s = s = np.append(np.concatenate(nodes), case.end * R)
        self.y = y = np.concatenate(points)
        self.n = n = s.size - 1
        h = np.diff(s)
        self.inside = [np.arange(f + 1, f + M) for f in self.first]
        inner = np.concatenate(self.inside)
        self.q_start, self.m_start = n + 3 * K, n + 3 * K + n - 1
        self.size = self.m_start + inner.size
        size = self.size
        # the fields at all nodes as matrices on u, and constants
        p = np.zeros((n + 1, size))
        p[np.arange(1, n + 1), np.arange(n)] = 1.0
        q_roll, q_drum = np.zeros((n + 1, size)), np.zeros((n + 1, size))
        q_roll[np.arange(1, n), self.q_start + np.arange(n - 1)] = 1.0
        q_drum[inner, self.m_start + np.arange(inner.size)] = 1.0
        q = q_roll + q_drum
        weights = (np.append(h, 0.0) + np.append(0.0, h)) / 2
        lumped = np.cumsum(weights[:, None] * q, axis=0)
        self.T = lumped - q * np.append(h, 0.0)[:, None] / 2  # T - T_in at the nodes
        self.p_roll, self.p0 = p.copy(), np.zeros(n + 1)
        self.p_drum = np.zeros((n + 1, size))
        for nodes_of in self.inside:
            self.p_drum[nodes_of] = p[nodes_of]
        self.q_roll, self.q_drum = q_roll, q_drum
        self.drums = [self._drum(k) for k in range(K)]
        # p+ = p- - T kappa-, with T kappa- = T0 kappa- + kappa0 (T - T0)
        for nip, nodes_of, (slope, _) in zip(case.nips, self.inside, self.drums, strict=True):
            flat = np.full(M - 1, 1 / nip.drum_radius)
            T0, kappa0 = case.latest.get(nip, (np.full(M - 1, self.T_in), flat))
            start = int(nodes_of[0]) - 1
            bent = -np.diff(slope, axis=0) / np.diff(y[start : start + M])[:, None]
            self.p_roll[nodes_of] -= T0[:, None] * bent + kappa0[:, None] * self.T[nodes_of]
            self.p0[nodes_of] = -T0 * flat - kappa0 * (self.T_in - T0)
        targets = np.append(y, s[-1] - 1e-9 * h[-1])
        slope_p, slope_q, strain_p, strain_q = influence(roll, targets, s)
        slope = slope_p @ self.p_roll + slope_q @ q_roll
        slope0 = slope_p @ self.p0
        strain = strain_p @ self.p_roll + strain_q @ q_roll
        strain0 = strain_p @ self.p0
        at = (y - s[:-1]) / h

        def at_points(values: Array) -> Array:
            weight = at if values.ndim == 1 else at[:, None]
            return values[:-1] * (1 - weight) + values[1:] * weight

        c11, c12, c22 = (getattr(web.compliance, name) for name in ("c11", "c12", "c22"))
        self.stretch = c11 / web.thickness
        # gap slope in the cells of the nips
        gap, gap0 = [], []
        for k, (nip, f) in enumerate(zip(case.nips, self.first, strict=True)):
            cells = np.arange(f, f + M)
            curvature = 1 / R + 1 / nip.drum_radius
            rows = slope[cells] + self.drums[k][0] + c12 * at_points(q)[cells]
            rows -= web.thickness * c22 * (np.diff(self.p_roll, axis=0) / h[:, None])[cells]
            rows[:, n + 3 * k] += 1.0
            gap.append(rows)
            gap0.append(
                slope0[cells]
                - web.thickness * c22 * (np.diff(self.p0) / h)[cells]
                - (y[cells] - centres[k]) * curvature
            )
        self.gap, self.gap0 = np.concatenate(gap), np.concatenate(gap0)
        # slip in the cells: T lumped
        strain_web = self.stretch * lumped[:-1] - c12 * at_points(self.p_roll)
        strain_web0 = -c12 * at_points(self.p0)
        self.end = self.stretch * self.T[-1] - c12 * self.p_roll[-1] - strain[-1]
        self.end0 = -c12 * self.p0[-1] - strain0[-1]
        self.v_roll = strain_web - strain[:-1] - self.end
        self.v_roll0 = strain_web0 - strain0[:-1] - self.end0
        self.v_drum, self.v_drum0 = strain_web.copy(), strain_web0
        for k, f in enumerate(self.first):
            self.v_drum[f : f + M, n + 3 * k + 1] += 1.0
            self.v_drum[f : f + M] -= self.drums[k][1]
        # resultants
        self.load = np.array([self._over(k, weights, self.p_drum) for k in range(K)])
        self.force = np.array([self._over(k, weights, q_drum) for k in range(K)])
        # curvature at the nodes of arcs
        self.arc = np.setdiff1d(np.arange(1, n + 1), inner)
        self.kappa, self.kappa0 = self._curvature(roll, slope[:-1], slope0[:-1], h)

    def _drum(self, k: int) -> tuple[Array, Array]:
        """Return slope and strain of drum k in the cells of its nip, as matrices on u."""
        drum, f, M = self.case.nips[k].drum, self.first[k], self.cells
        if drum is None:
            return np.zeros((M, self.size)), np.zeros((M, self.size))
        cells, nodes = slice(f, f + M), slice(f, f + M + 1)
        slope_p, slope_q, strain_p, strain_q = influence(drum, self.y[cells], self.s[nodes])
        p, q = self.p_drum[nodes], self.q_drum[nodes]
        return slope_p @ p + slope_q @ q, strain_p @ p + strain_q @ q

    def tensions_and_curvatures(self, u: Array) -> dict[Nip, tuple[Array, Array]]:
        """Return T and kappa- at the inner nodes of the nips."""
        out = {}
        parts = zip(self.case.nips, self.first, self.inside, self.drums, strict=True)
        for nip, f, nodes, (slope, _) in parts:
            distances = np.diff(self.y[f : f + self.cells])
            kappa = 1 / nip.drum_radius - np.diff(slope @ u) / distances
            out[nip] = self.T_in + self.T[nodes] @ u, kappa
        return out

    def _over(self, k: int, weights: Array, values: Array) -> Array:
        """Return the integral over nip k."""
        nodes = self.inside[k]
        return weights[nodes] @ values[nodes]

    def _curvature(self, roll: Any, slope: Array, slope0: Array, h: Array) -> tuple[Array, Array]:
        """Return kappa+ at all nodes as a matrix on u and constants."""
        n, R = self.n, roll.radius
        kappa, kappa0 = np.zeros((n + 1, self.size)), np.full(n + 1, 1 / R)
        if not self.case.solved_curvature:
            return kappa, kappa0
        distance = np.diff(self.y)
        kappa[1:-1] = -np.diff(slope, axis=0) / distance[:, None]
        kappa0[1:-1] -= np.diff(slope0) / distance
        if roll.curvature:
            edge = self.first[0] + self.cells
            by_p, by_q = displacement(roll, self.s[edge, None], self.s)
            v_edge, v_edge0 = (by_p @ self.p_roll + by_q @ self.q_roll)[0], (by_p @ self.p0)[0]
            v = np.concatenate([np.zeros((1, self.size)), np.cumsum(slope * h[:, None], axis=0)])
            v0 = np.append(0.0, np.cumsum(slope0 * h))
            kappa -= (v - v[edge] + v_edge) / R**2
            kappa0 -= (v0 - v0[edge] + v_edge0) / R**2
        # at the edges of nips: from the side of the arc, extrapolated linearly
        for f in self.first:
            for edge, step in ((f, -1), (f + self.cells, 1)):
                if edge == 0:
                    continue
                x1, x2 = self.s[edge + step] - self.s[edge], self.s[edge + 2 * step] - self.s[edge]
                for each in (kappa, kappa0):
                    each[edge] = (x2 * each[edge + step] - x1 * each[edge + 2 * step]) / (x2 - x1)
        last_edge = self.s[self.first[-1] + self.cells]
        start = int(np.searchsorted(self.s, self.s[-1] - END * (self.s[-1] - last_edge)))
        kappa[start:], kappa0[start:] = kappa[start - 1], kappa0[start - 1]
        return kappa, kappa0

    def end_roll_strain(self, u: Array) -> float:
        """Return eps+ at the end of the last arc."""
        web = self.stretch * (self.T[-1] @ u) - self.case.web.compliance.c12 * (
            self.p_roll[-1] @ u + self.p0[-1]
        )
        return float(web - (self.end @ u + self.end0))

    def parts(self, u: Array) -> tuple[Array, Array, Array, Array]:
        """Return the equations of equilibrium, slip, traction and bound, dimensionless."""
        case, scale = self.case, self.case.pressure
        T = self.T_in + self.T @ u
        kappa = self.kappa @ u + self.kappa0
        arc = self.arc
        equilibrium = np.concatenate(
            [
                (self.gap @ u + self.gap0) / case.slope,
                ((self.p_roll @ u + self.p0) - T * kappa)[arc] / scale,
                [(self.force[k] @ u - nip.force) / nip.load for k, nip in enumerate(case.nips)],
                [self.load[k] @ u / nip.load - 1 for k, nip in enumerate(case.nips)],
            ]
        )
        inner = np.concatenate(self.inside)
        slip = (
            np.append(
                (self.v_roll @ u + self.v_roll0)[: self.n - 1],
                (self.v_drum @ u + self.v_drum0)[inner - 1],
            )
            / case.slope
        )
        p = np.append((self.p_roll @ u + self.p0)[1 : self.n], (self.p_drum @ u)[inner])
        return equilibrium, slip, u[self.q_start :] / scale, self.friction() * p / scale

    def friction(self) -> Array:
        """Return mu at the nodes of q+ and of q-."""
        case, mu = self.case, np.full(self.n - 1, self.case.arc_friction)
        for f in self.first:
            mu[max(f - 1, 0) : f + self.cells - 1] = case.roll_friction
        return np.append(mu, np.full(sum(part.size for part in self.inside), case.drum_friction))

    def jacobian(self, u: Array) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives of ``parts`` for fixed half widths."""
        case, scale, arc = self.case, self.case.pressure, self.arc
        T, kappa = self.T_in + self.T @ u, self.kappa @ u + self.kappa0
        rows = self.p_roll - T[:, None] * self.kappa - kappa[:, None] * self.T
        loads = np.array([nip.load for nip in case.nips])[:, None]
        equilibrium = np.concatenate(
            [self.gap / case.slope, rows[arc] / scale, self.force / loads, self.load / loads]
        )
        inner = np.concatenate(self.inside)
        slip = np.concatenate([self.v_roll[: self.n - 1], self.v_drum[inner - 1]]) / case.slope
        bound = (
            self.friction()[:, None]
            * np.concatenate([self.p_roll[1 : self.n], self.p_drum[inner]])
            / scale
        )
        traction = np.zeros((bound.shape[0], self.size))
        traction[np.arange(bound.shape[0]), self.q_start + np.arange(bound.shape[0])] = 1 / scale
        return equilibrium, slip, traction, bound


@dataclass
class Case:
    """Web, roll and nips; ``end`` is the angle at which the last arc ends [rad]."""

    roll: Any
    web: Any
    nips: tuple[Nip, ...]
    end: float
    tension: float
    roll_friction: float
    drum_friction: float
    arc_friction: float
    cells: int = 32
    solved_curvature: bool = True
    pressure: float = 0.0
    slope: float = 0.0
    arcs: list[Array] = field(default_factory=list)
    latest: dict[Nip, tuple[Array, Array]] = field(default_factory=dict)

    def solve(self) -> Solution:
        """Solve: Newton steps, and after each of them the active set changes."""
        a = np.array([self._single(nip) for nip in self.nips])
        R = self.roll.radius
        self.pressure = float(
            max(2 * nip.load / (np.pi * b) for nip, b in zip(self.nips, a, strict=True))
        )
        self.slope = float(a.max() * (1 / R + 1 / self.nips[0].drum_radius))
        shortest = a.min() * (1 - np.cos(np.pi / self.cells))
        angles = [nip.angle for nip in self.nips]
        self.arcs = [
            graded((stop - start) * R, shortest, LONGEST * R * 32 / max(self.cells, 32), both)
            for start, stop, both in zip(
                angles, [*angles[1:], self.end], [True] * (len(angles) - 1) + [False], strict=True
            )
        ]
        system = System(self, a)
        u = np.zeros(system.size)
        ln_a = system.n + 3 * np.arange(len(a)) + 2
        u[ln_a] = np.log(a)
        active = np.zeros(system.friction().size, dtype=int)
        visits: dict[bytes, int] = {}
        columns: list[tuple[Array, ...]] = []
        size, differentiated = np.inf, np.full(len(a), np.inf)
        for number in range(400):
            if np.abs(u[ln_a] - differentiated).max() > CHANGED or number % RENEWED == 0:
                columns, differentiated = self._columns(system, u), u[ln_a]
            step = self._step(system, u, active, ln_a, columns)
            step[ln_a] = np.clip(step[ln_a], -0.5, 0.5)
            u = u + step
            self.latest = system.tensions_and_curvatures(u)
            system = System(self, np.exp(u[ln_a]))
            units = np.full(u.size, self.pressure)
            units[system.n : system.q_start] = np.tile([self.slope, self.slope, 1.0], len(a))
            size = np.abs(step / units).max()
            _, slip, traction, bound = system.parts(u)
            wrong = np.where(active == 0, np.abs(traction) > bound + 1e-12, active * slip < -1e-12)
            if not wrong.any() and size < TOLERANCE:
                return self._solution(system, u, active)
            if wrong.any():
                key = active.tobytes()
                visits[key] = visits.get(key, 0) + 1
                if visits[key] > 2:
                    wrong[: np.nonzero(wrong)[0][-1]] = False
                active = np.where(
                    wrong, np.where(active == 0, np.sign(traction).astype(int), 0), active
                )
        raise ArithmeticError(f"not converged: {size:.1e}, {int(wrong.sum())} nodes")

    def _columns(self, system: System, u: Array) -> list[tuple[Array, ...]]:
        """Return the derivatives of ``parts`` by each ln a, by differences."""
        parts, columns = system.parts(u), []
        for k in range(len(self.nips)):
            a = system.a.copy()
            a[k] *= np.exp(DIFFERENCE)
            changed = System(self, a).parts(u)
            columns.append(
                tuple((new - old) / DIFFERENCE for new, old in zip(changed, parts, strict=True))
            )
        return columns

    def _step(
        self,
        system: System,
        u: Array,
        active: Array,
        ln_a: Array,
        columns: list[tuple[Array, ...]],
    ) -> Array:
        """Return the Newton step for an active set."""
        matrix = self._chosen(*system.jacobian(u), active)
        for column, by_ln_a in zip(ln_a, columns, strict=True):
            matrix[:, column] += self._chosen(*by_ln_a, active)
        residual = self._chosen(*system.parts(u), active)
        scale = np.abs(matrix).max(axis=0)
        return np.asarray(-np.linalg.solve(matrix / scale, residual) / scale)

    @staticmethod
    def _chosen(
        equilibrium: Array, slip: Array, traction: Array, bound: Array, active: Array
    ) -> Array:
        """Return the equilibrium and, for each traction, its slip or its friction law."""
        sign = active if slip.ndim == 1 else active[:, None]
        return np.concatenate([equilibrium, np.where(sign == 0, slip, traction - sign * bound)])

    def _single(self, nip: Nip) -> float:
        """Return the half width of a plain nip as the initial guess."""
        problem = wo.NipProblem(
            web=self.web,
            roll=self.roll,
            drum=nip.drum or wo.Rigid(radius=nip.drum_radius),
            roll_friction=self.roll_friction,
            drum_friction=self.drum_friction,
            nip_load=nip.load,
            winding_force=0.0,
            web_tension=self.tension,
            roll_wrap=0.0,
        )
        return float(wo.solve(problem, nodes=25).half_width)

    def _solution(self, system: System, u: Array, active: Array) -> Solution:
        """Return the fields."""
        return Solution(
            system,
            u,
            active,
            system.a,
            self.tension + system.T @ u,
            system.p_roll @ u + system.p0,
            system.q_roll @ u,
            system.v_roll @ u + system.v_roll0,
        )
