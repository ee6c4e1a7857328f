r"""Several nips on the outer layer of a roll: the nips of a two-drum winder.

The web is laid on the roll in nip 1 and runs with it through the nips 2 ... K, each at an angle
downstream of the one before.  Per unit of the roll's speed the unstrained web and the unstrained
surface of the roll are equally fast everywhere in a steady state: there is one strain of the laid
web relative to the roll's surface for all nips,

    v+ = eps - eps+ - E,      E = c11 W/2h - c12 W/R - eps_closed(W/R),

W the tension of the closed layer (:func:`.outputs.roll_wound_on_tension`), eps_closed the strain of
the surface under it.  Nip k has the equations of a single nip (:mod:`.equations`) on its own mesh,
with its arc as the roll wrap, and these couplings:

    tension    T_k(first node) = T_in + sum_(j<k) int (q+ + q-) dx over nip j with its arc
    laid web   E for k < K;  nip K is a wrapped nip, at the end of which (eps - eps+) is its own
    roll       slope, curvature and strain on the face of nip k include those by the other nips

An arc ends at the leading edge of the next nip, that of its contact without friction, whose half
width also places the loads of a nip on the roll for the deformation of the other faces.

Unknowns u = (u_1 | ... | u_K), residuals and Jacobian, with J_k those of nip k alone:

    J = diag(J_1 ... J_K) + sum_k dR_k/dT_k (dT_k/du) - sum_(k<K) dR_k/dv+ (dE_k/du)
      + derivatives of the deformations by other nips,

E_k = E - c11 T_k(end)/2h, because slips are evaluated relative to the tension at the end.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import exp

import numpy as np

from ..contact.newton import Iterate, Jacobian
from ..elasticity.surface import Deformation, SurfaceTangent
from ..problems.nip import NipProblem
from .contact_equations import DIFFERENCE
from .equations import Assembly, Fields, Geometry, NipState
from .nip_fields import NipFields
from .outputs import NipSystem, drum_creepage, evaluation_weights, roll_wound_on_tension
from .single_nips import single_nips

__all__ = ["SeveralNips", "SeveralState", "system_of"]

Array = np.ndarray

# Step of a tension for difference quotients, relative to the load or to the tension.
STEP = 1e-4
# Distance between the end of an arc and the leading edge of the next nip, relative to its half
# width: nodes of a result ascend.
BETWEEN = 1e-9
# Outputs of a further nip whose error is estimated.
OF_CONTACT = "inlet_tension", "outlet_tension", "nip_width", "peak_pressure", "drum_creepage"
# Arrays of a result along the web.
ARRAYS = (
    *("x", "slip_x", "drum_pressure", "roll_pressure", "hoop_pressure", "curvature"),
    *("roll_traction", "drum_traction", "roll_slip", "drum_slip", "roll_zone", "drum_zone"),
    *("tension", "roll_strain"),
)


def system_of(problem: NipProblem, size: int) -> NipSystem | SeveralNips:
    """Return the equations of a problem without air on a mesh of ``size`` nodes in each nip."""
    return SeveralNips(problem, size) if problem.next_nips else NipSystem(problem, size)


@dataclass(frozen=True, eq=False)
class SeveralState(Iterate):
    """An iterate of all nips with its residuals.

    Attributes
    ----------
    nips : tuple of NipState
    """

    nips: tuple[NipState, ...]


@dataclass(frozen=True, eq=False)
class _Coupling:
    """Derivatives that couple the nips.

    Attributes
    ----------
    by_inlet_tension : list of Jacobian
        dR_k/dT_k, one column each; that of nip 1, whose T_k is given, is not used.
    laid_by_closed, laid_by_tension : float
        dE/dW, and dE/dT_K at fixed u_K.
    inlet_tensions : (K+1, size) array
        dT_k/du; the last row is that of the tension at the end of nip K.
    laid_strain : (size,) array
        dE/du.
    """

    by_inlet_tension: list[Jacobian]
    laid_by_closed: float
    laid_by_tension: float
    inlet_tensions: Array
    laid_strain: Array


class SeveralNips:
    """Residual and Jacobian of several nips of one web, each with ``size`` nodes in the nip.

    Parameters
    ----------
    problem : NipProblem
        With ``next_nips``, without air.
    size : int
    nips : list of NipSystem, optional
        The equations of each nip, by default those on its own mesh.
    """

    def __init__(self, problem: NipProblem, size: int, nips: list[NipSystem] | None = None) -> None:
        self.problem, self.size = problem, size
        alone, self._half_widths = single_nips(problem)
        self.nips = nips or [
            NipSystem(each, size, is_last=each is alone[-1], is_alone=False) for each in alone
        ]
        nips = self.nips
        web = problem.web
        self.stretch = web.compliance.c11 / web.thickness  # strain of the web by its tension, m/N
        # parts of the unknowns, the equilibrium equations and the traction nodes of each nip; the
        # tractions q are its last unknowns, and there are as many equilibrium equations as others
        self.unknowns = _parts([nip.layout.size for nip in nips])
        self.equilibrium = _parts([nip.layout.q.start for nip in nips])
        self.tractions = _parts([nip.layout.traction_count for nip in nips])
        self.coupling: _Coupling | None = None

    # ---- interface of the semismooth Newton method ---------------------------------------------

    @cached_property
    def scales(self) -> Array:
        """Scales of the unknowns, (size,)."""
        return np.concatenate([nip.scales for nip in self.nips])

    @cached_property
    def traction_unknowns(self) -> Array:
        """Indices of the tractions in u."""
        return self._indices(self.unknowns, [nip.traction_unknowns for nip in self.nips])

    @cached_property
    def ln_a(self) -> Array:
        """Indices of ln a of each nip in u."""
        return self._indices(self.unknowns, [nip.ln_a for nip in self.nips])

    @cached_property
    def load_rows(self) -> Array:
        """Indices of the load equations."""
        return self._indices(self.equilibrium, [nip.load_rows for nip in self.nips])

    @cached_property
    def largest_ln_a(self) -> Array:
        """ln of the largest half width of each nip."""
        return np.concatenate([nip.largest_ln_a for nip in self.nips])

    @cached_property
    def creepage_nodes(self) -> list[Array]:
        """Traction nodes on each drum, whose slip velocity contains its creepage."""
        return [
            part.start + nodes
            for part, nip in zip(self.tractions, self.nips, strict=True)
            for nodes in nip.creepage_nodes
        ]

    @staticmethod
    def _indices(parts: list[slice], each: list[Array]) -> Array:
        """Return the indices of each nip's parts among those of all nips."""
        return np.concatenate([p.start + own for p, own in zip(parts, each, strict=True)])

    def for_problem(self, problem: NipProblem) -> SeveralNips:
        """Return the equations of a neighbouring problem with the same numbers of cells."""
        pairs = zip(self.nips, single_nips(problem).problems, strict=True)
        return SeveralNips(problem, self.size, [nip.for_problem(each) for nip, each in pairs])

    def node_names(self, tractions: Array) -> list[str]:
        """Return the names of traction nodes (indices among those of all nips) for messages."""
        names = []
        for k, (part, nip) in enumerate(zip(self.tractions, self.nips, strict=True)):
            own = tractions[(tractions >= part.start) & (tractions < part.stop)] - part.start
            names += [f"nip {k + 1}, {name}" for name in nip.node_names(own)]
        return names

    def initial_guess(self) -> tuple[Array, Array]:
        """Return unknowns u with zero fields, the half widths without friction, and full stick.

        Shapes (size,) and (traction nodes,).
        """
        u = np.zeros(self.scales.size)
        u[self.ln_a] = np.log(self._half_widths)
        return u, np.zeros(self.traction_unknowns.size, dtype=np.int8)

    def prolong(
        self, state: SeveralState, active: Array, coarse: SeveralNips
    ) -> tuple[Array, Array]:
        """Return the initial guess on this mesh from the solution on another mesh.

        Parameters and arrays returned as of :meth:`.NipEquations.prolong`, of all nips.
        """
        guesses = [
            nip.prolong(own, active[part], other)
            for nip, own, part, other in zip(
                self.nips, state.nips, coarse.tractions, coarse.nips, strict=True
            )
        ]
        u, zones = (np.concatenate(each) for each in zip(*guesses, strict=True))
        return u, zones

    # ---- deformations by other nips ------------------------------------------------------------

    @cached_property
    def _far_tangents(self) -> dict[tuple[int, int], SurfaceTangent]:
        """Slope and strain at the points of face i by p and q at the nodes of face j, (n+1, m).

        By (i, j), i != j; for meshes with the half widths without friction.
        """
        halves, out = self._half_widths, {}
        centres = self.centres(halves)
        faces = [nip.mesh(a).roll_face for nip, a in zip(self.nips, halves, strict=True)]
        for j, (face, a) in enumerate(zip(faces, halves, strict=True)):
            surface = self.problem.roll.surface(face, a, self.nips[j].problem.rolling_speed)
            others = [i for i in range(len(faces)) if i != j]
            points = [centres[i] - centres[j] + halves[i] * faces[i].points for i in others]
            tangent = surface.tangent_outside(np.concatenate(points))
            for i, part in zip(others, _parts([each.size for each in points]), strict=True):
                out[i, j] = SurfaceTangent(*(matrix[part] for matrix in tangent))
        return out

    def _scaled(self, j: int, a: float) -> float:
        """Return the factor of the loads on face j for another half width: that of its length."""
        return a / self._half_widths[j]

    def _deformed(self, fields: list[Fields]) -> list[Fields]:
        """Return the fields with the deformations by the loads on the other faces."""
        out = []
        for i, f in enumerate(fields):
            slope, strain = np.zeros((2, f.roll.strain.size))
            for j, other in enumerate(fields):
                if j != i:
                    far, (p, q) = self._far_tangents[i, j], other.on_roll
                    factor = self._scaled(j, other.geometry.a)
                    slope += factor * (far.slope_p @ p + far.slope_q @ q)
                    strain += factor * (far.strain_p @ p + far.strain_q @ q)
            out.append(f.deformed(Deformation(slope, strain)))
        return out

    # ---- residual ------------------------------------------------------------------------------

    def evaluate(self, u: Array, tolerance: float = 0.0) -> SeveralState:
        """Return the state of the unknowns u, (size,).

        ``tolerance`` is the relative error of interpolated responses that is accepted; by default
        they are exact.
        """
        halves = [exp(value) for value in u[self.ln_a]]
        pairs = zip(self.nips, halves, strict=True)
        return self.state(u, [nip.geometry(a, tolerance) for nip, a in pairs])

    def state(self, u: Array, geometries: list[Geometry]) -> SeveralState:
        """Evaluate residuals, slip velocities and friction bounds of the unknowns u, (size,).

        The inlet tension of a nip is the tension at the end of the one before; the last nip comes
        before the others, because its tension determines the laid strain.
        """
        T, fields = self.problem.web_tension, []
        for nip, part, geometry in zip(self.nips, self.unknowns, geometries, strict=True):
            fields.append(nip.fields(u[part], geometry, T))
            T = float(fields[-1].tension[-1])
        fields = self._deformed(fields)
        last = self.nips[-1].state_of(u[self.unknowns[-1]], fields[-1])
        E = self.laid_strain(roll_wound_on_tension(self.nips[-1], last))
        states = [
            nip.state_of(u[part], f, E - self.stretch * float(f.tension[-1]))
            for nip, part, f in zip(self.nips[:-1], self.unknowns, fields, strict=False)
        ]
        return self._joined(u, (*states, last))

    def _joined(self, u: Array, states: tuple[NipState, ...]) -> SeveralState:
        """Return the state of all nips; pressures and slips are in the units of their nip."""
        names = "equilibrium", "slip", "traction", "bound"
        joined = {name: np.concatenate([getattr(s, name) for s in states]) for name in names}
        return SeveralState(u, **joined, nips=states)

    def laid_strain(self, W: float) -> float:
        """Return E of a closed layer with the tension W [N/m]."""
        R, roll = self.problem.roll.radius, self.problem.roll
        c12 = self.problem.web.compliance.c12
        pressure = (W - self.problem.centrifugal_tension) / R
        return float(self.stretch * W - c12 * pressure - roll.uniform_strain(pressure))

    # ---- Jacobian ------------------------------------------------------------------------------

    def jacobian(self, state: SeveralState) -> Jacobian:
        """Return the derivatives of equilibrium, slip and bound by u."""
        size = self.unknowns[-1].stop
        n, k = self.equilibrium[-1].stop, self.tractions[-1].stop
        out = Jacobian(*(np.zeros((rows, size)) for rows in (n, k, k)))
        assemblies = [Assembly(nip, own) for nip, own in zip(self.nips, state.nips, strict=True)]
        for index, assembly in enumerate(assemblies):
            for block, own in zip(self._blocks(out, index), assembly.jacobian(), strict=True):
                block[:, self.unknowns[index]] = own
        self.coupling = self._coupling(state, assemblies[-1])
        self._add_far_deformations(out, assemblies)
        for index in range(len(self.nips)):
            self._couple(out, index, slice(0, size))
        self.fill_half_width_column(out, state)
        return out

    def _add_far_deformations(self, jacobian: Jacobian, assemblies: list[Assembly]) -> None:
        """Add the derivatives by the loads on other faces: those on face j deform face i.

        Their slopes v+' enter the gap slope, their curvatures -v+'' the normal equilibrium of the
        roll wrap, and their strains eps+ the slip v+ = eps - eps+ - E.  In the last nip, eps - eps+
        at the end of its face stands for E; its eps+ at the evaluation of W changes the E of all
        others.

        How the tension upstream of a nip changes the hoop pressure in it is neglected.
        """
        assert self.coupling is not None
        # weights of eps+ at the points of the last face, with which W is evaluated
        _, weights_of_strain = evaluation_weights(self.nips[-1], assemblies[-1].fields)
        for (i, j), far in self._far_tangents.items():
            source, target = assemblies[j], assemblies[i]
            nip, columns = self.nips[i], self.unknowns[j]
            # at the points of face i by the unknowns of nip j, (points, unknowns) each
            slope, strain = (
                self._scaled(j, source.a) * source.by_loads_on_roll(by_p, by_q)
                for by_p, by_q in ((far.slope_p, far.slope_q), (far.strain_p, far.strain_q))
            )
            blocks = self._blocks(jacobian, i)
            # the face of the roll begins at the leading edge: the cells of the nip come first
            nip_cells = nip.layout.last - nip.layout.first
            blocks.equilibrium[:nip_cells, columns] += slope[:nip_cells] / nip.slope_scale
            # the rows of the roll wrap are the last ones but those of force and load
            T = target.fields.hoop_tension[nip.layout.roll_wrap_nodes, None]
            face = target.fields.geometry.roll.face
            curvature = face.curvature_change(slope, target.a, ends=False)
            on_wrap = T * curvature[nip_cells:]
            blocks.equilibrium[-2 - len(T) : -2, columns] -= on_wrap / nip.pressure_scale
            n = nip.layout.roll_count
            relative_strain = strain[:n]
            if nip.is_last:
                relative_strain = relative_strain - strain[-1]
                # dE = dE/dW dW, and dW = -(2h/c11) d eps+
                by_strain = self.coupling.laid_by_closed / self.stretch
                self.coupling.laid_strain[columns] -= by_strain * (weights_of_strain @ strain)
            blocks.slip[:n, columns] -= relative_strain / nip.slope_scale

    def _blocks(self, jacobian: Jacobian, index: int) -> Jacobian:
        """Return the rows of nip ``index`` in the Jacobian of all nips, as views."""
        rows, nodes = self.equilibrium[index], self.tractions[index]
        return Jacobian(jacobian.equilibrium[rows], jacobian.slip[nodes], jacobian.bound[nodes])

    def _couple(self, jacobian: Jacobian, index: int, columns: slice | int) -> None:
        """Add the derivatives by the inlet tension and the laid strain to the rows of a nip.

        Parameters
        ----------
        jacobian : Jacobian
            Of all nips.
        index : int
            Number of the nip, from 0.
        columns : slice or int
            Unknowns by which the inlet tension and the laid strain are differentiated.
        """
        coupling = self.coupling
        assert coupling is not None
        nip, blocks = self.nips[index], self._blocks(jacobian, index)
        if index:  # the inlet tension of the first nip is given
            tension = coupling.inlet_tensions[index, columns]
            for block, own in zip(blocks, coupling.by_inlet_tension[index], strict=True):
                block[:, columns] += np.multiply.outer(own, tension)
        if not nip.is_last:
            # dE_k: E less the strain c11 T_k(end)/2h, to which the slips of the nip are relative
            laid = coupling.laid_strain[columns]
            laid = laid - self.stretch * coupling.inlet_tensions[index + 1, columns]
            blocks.slip[: nip.layout.roll_count, columns] -= laid / nip.slope_scale

    def _coupling(self, state: SeveralState, last: Assembly) -> _Coupling:
        """Return the derivatives that couple the nips, by all unknowns but ln a.

        Those by a tension are difference quotients: each nip is evaluated for an inlet tension that
        is larger by a step.  ``last`` is the assembly of the last nip.
        """
        size, step = self.unknowns[-1].stop, STEP * self.problem.nip_load
        tensions, by_tension = np.zeros((len(self.nips) + 1, size)), []
        shifted_last = state.nips[-1]
        for index, (nip, own, part) in enumerate(
            zip(self.nips, state.nips, self.unknowns, strict=True)
        ):
            f = nip.fields(own.u, own.geometry, float(own.fields.tension[0]) + step)
            f = f.deformed(own.fields.far)
            shifted_last = nip.state_of(own.u, f, None if nip.is_last else own.laid_strain)
            by_tension.append(
                Jacobian(
                    (shifted_last.equilibrium - own.equilibrium) / step,
                    (shifted_last.slip - own.slip) / step,
                    (shifted_last.bound - own.bound) / step,
                )
            )
            # T_(k+1) = T_k + int (q+ + q-) dx
            tensions[index + 1] = tensions[index]
            weights = own.geometry.a * own.geometry.mesh.weights
            tensions[index + 1, part][nip.layout.roll_q] = weights[nip.layout.roll_nodes]
            tensions[index + 1, part][nip.layout.drum_q] = weights[nip.layout.drum_nodes]
        W = roll_wound_on_tension(self.nips[-1], state.nips[-1])
        by_W = (self.laid_strain(W * (1 + STEP)) - self.laid_strain(W * (1 - STEP))) / (
            2 * STEP * W
        )
        W_by_tension = (roll_wound_on_tension(self.nips[-1], shifted_last) - W) / step
        laid = np.zeros(size)
        laid[self.unknowns[-1]] = by_W * self._closed_tension_row(last)
        laid += by_W * W_by_tension * tensions[-2]
        return _Coupling(by_tension, by_W, by_W * W_by_tension, tensions, laid)

    def _closed_tension_row(self, last: Assembly) -> Array:
        """Return dW/du_K at a fixed inlet tension, without that by ln a, (unknowns of nip K,).

        W = T + (2h/c11) (eps_closed(T) - eps+), T and eps+ at the point of evaluation.
        """
        nip, f, roll = self.nips[-1], last.fields, self.problem.roll
        layout, R = nip.layout, roll.radius
        nodes, points = evaluation_weights(nip, f)
        T = float(nodes @ f.tension)
        low, high = ((T * (1 + k) - self.problem.centrifugal_tension) / R for k in (-STEP, STEP))
        # change of eps_closed from T (1 - STEP) to T (1 + STEP)
        closed = roll.uniform_strain(high) - roll.uniform_strain(low)
        dT = last.a * (nodes @ last.mesh.integral_to_nodes)
        by_T = np.zeros(layout.size)
        by_T[layout.roll_q], by_T[layout.drum_q] = dT[layout.roll_nodes], dT[layout.drum_nodes]
        strain = last.chain_p_roll((points @ last.roll.strain_p)[None])[0]
        strain[layout.roll_q] += (points @ last.roll.strain_q)[1:-1]
        return np.asarray(
            by_T * (1 + closed / (2 * STEP * T) / self.stretch) - strain / self.stretch
        )

    def fill_half_width_column(self, jacobian: Jacobian, state: SeveralState) -> None:
        """Write the derivatives by each ln a, by difference quotients, into their columns.

        A half width also changes how its nip deforms the faces of the other nips.  This is
        neglected here: it only slows the convergence.
        """
        coupling = self.coupling
        assert coupling is not None
        W = roll_wound_on_tension(self.nips[-1], state.nips[-1])
        for index, (nip, own) in enumerate(zip(self.nips, state.nips, strict=True)):
            column = int(self.ln_a[index])
            shifted = nip.shifted(own)
            change = float(shifted.fields.tension[-1] - own.fields.tension[-1]) / DIFFERENCE
            coupling.inlet_tensions[index + 1 :, column] = change
            coupling.laid_strain[column] = (
                coupling.laid_by_tension * coupling.inlet_tensions[-2, column]
            )
            if nip.is_last:
                dW = (roll_wound_on_tension(nip, shifted) - W) / DIFFERENCE
                coupling.laid_strain[column] = coupling.laid_by_closed * dW
            # its own rows first, at a fixed inlet tension and laid strain; then the coupling
            for block in jacobian:
                block[:, column] = 0.0
            for name, block in self._blocks(jacobian, index)._asdict().items():
                block[:, column] = (getattr(shifted, name) - getattr(own, name)) / DIFFERENCE
            for each in range(len(self.nips)):
                self._couple(jacobian, each, column)

    # ---- outputs -------------------------------------------------------------------------------

    def main_outputs(self, state: SeveralState) -> dict[str, float]:
        """Return the tensions whose error estimates end the mesh refinement [N/m]."""
        each = [nip.main_outputs(own) for nip, own in zip(self.nips, state.nips, strict=True)]
        return {
            "wound_on_tension": each[-1]["wound_on_tension"],
            "nip_induced_tension": sum(tensions["nip_induced_tension"] for tensions in each),
        }

    def outputs(
        self, state: SeveralState, active: Array, names: Collection[str] = ()
    ) -> dict[str, float]:
        """Return all outputs whose discretisation error is estimated, by name, in SI units.

        Those of the first nip, of the whole web, and ``contacts.k.name`` of the further nips.
        Parameters as of :meth:`.NipSystem.outputs`, with the zones of all nips.
        """
        each = [
            nip.outputs(own, active[part], names)
            for nip, own, part in zip(self.nips, state.nips, self.tractions, strict=True)
        ]
        out = each[0] | self.main_outputs(state)
        out["roll_wound_on_tension"] = each[-1]["roll_wound_on_tension"]
        out["peak_pressure"] = max(one["peak_pressure"] for one in each)
        # the friction of the roll downstream of the first nip
        by_drums = sum(nip.winding_force for nip in self.problem.next_nips)
        out["roll_wrap_traction"] = out["wound_on_tension"] - out["outlet_tension"] - by_drums
        if self.problem.viscoelastic:
            for name in ("rolling_resistance", "dissipated_power"):
                out[name] = sum(one.get(name, 0.0) for one in each)
        for k, one in enumerate(each[1:], 1):
            out |= {f"contacts.{k}.{name}": one[name] for name in OF_CONTACT}
        return out

    def arrays(self, state: SeveralState, active: Array) -> dict[str, Array]:
        """Return the fields along the web by the names of the results, one nip after the other.

        In addition half width, position, offset and creepage of the further nips.  ``active`` are
        the zones of the traction nodes of all nips, (k,).
        """
        halves = [own.geometry.a for own in state.nips]
        centres = self.centres(halves)
        each = [
            nip.arrays(own, active[part])
            for nip, own, part in zip(self.nips, state.nips, self.tractions, strict=True)
        ]
        for arrays, centre in zip(each, centres, strict=True):
            arrays["x"], arrays["slip_x"] = arrays["x"] + centre, arrays["slip_x"] + centre
        out = {name: np.concatenate([arrays[name] for arrays in each]) for name in each[0]}
        further = list(zip(self.nips, state.nips, strict=True))[1:]
        return out | {
            "next_positions": np.array(centres[1:]),
            "next_half_widths": np.array(halves[1:]),
            "next_offsets": np.array(
                [own.u[nip.layout.shift] * nip.problem.contact_radius for nip, own in further]
            ),
            "next_creepages": np.array([drum_creepage(nip, own) for nip, own in further]),
        }

    def centres(self, half_widths: Sequence[float]) -> list[float]:
        """Return the centre of each contact along the roll, from that of the first one [m].

        The leading edge of a further nip is just downstream of the end of the arc before it.
        """
        R, out = self.problem.roll.radius, [0.0]
        for nip, a in zip(self.nips[:-1], half_widths[1:], strict=True):
            out.append(out[-1] + nip.roll_wrap * R + a * (1 + BETWEEN))
        return out

    def parts_of(self, result: NipFields) -> list[NipFields]:
        """Return the arrays and scalars of each nip in a result of all, with x from its centre.

        Raises
        ------
        ValueError
            If the numbers of nodes or of further nips are not those of the meshes.
        """
        sizes = [nip.layout.end + 1 for nip in self.nips]
        further = len(sizes) - 1
        if result.x.size != sum(sizes):
            raise ValueError(f"{result.x.size} nodes; the meshes have {sum(sizes)}")
        scalars = {
            "half_width": (result.half_width, *result.next_half_widths),
            "offset": (result.offset, *result.next_offsets),
            "drum_creepage": (result.drum_creepage, *result.next_creepages),
            "centre": (0.0, *result.next_positions),
        }
        if any(len(values) != further + 1 for values in scalars.values()):
            raise ValueError(f"not all values of {further} further nips")
        parts = []
        for k, (nip, nodes) in enumerate(zip(self.nips, _parts(sizes), strict=True)):
            own = {name: getattr(result, name)[nodes] for name in ARRAYS}
            own |= {name: float(values[k]) for name, values in scalars.items()}
            centre = own.pop("centre")
            own["x"], own["slip_x"] = own["x"] - centre, own["slip_x"] - centre
            parts.append(result.replace(problem=nip.problem, **own))
        return parts


def _parts(sizes: list[int]) -> list[slice]:
    """Return consecutive slices of given sizes."""
    ends = np.cumsum([0, *sizes]).tolist()
    return [slice(start, stop) for start, stop in pairwise(ends)]
