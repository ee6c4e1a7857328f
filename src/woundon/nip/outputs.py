r"""Scalar outputs of a state of the nip equations whose discretisation error is estimated.

The web slips on the roll as far as friction permits and then follows the strain of its surface.
Between there and the closed layer of a wound roll without nip, its tension changes by

    T_closed - T = (2h/c11) (eps_closed - eps_1),

eps_1 the strain of the roll's surface under nip and wrap and eps_closed that under the pressure
(T - m V^2)/R of a closed layer.  T_closed is the wound-on tension of the roll.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from ..contact.refinement import Refinement
from ..problems.nip import NipProblem
from .energy import viscoelastic_outputs, work_on_bodies
from .equations import Fields, Geometry, NipEquations, NipState
from .nip_fields import NipFields
from .zones import LEAST_OFFSET_ERROR, cusp_excess, has_traction_jump, slip_lengths

__all__ = [
    "SLIP_RATIOS",
    "NipSystem",
    "approach",
    "error_estimates",
    "evaluation_weights",
    "roll_wound_on_tension",
    "slip_ratios",
    "strain_rounding",
    "web_arrays",
]

Array = np.ndarray

# Angle downstream of the nip at which the wound-on tension of the roll is evaluated [rad]: beyond
# the slip zone and the strains of the nip, and before the end of the wrap, where the hoop pressure
# ends.
EVALUATION_ANGLE = 1.5

# Rounding of a sum of some hundred terms, in units of the largest one.
ROUNDING = 50 * float(np.finfo(float).eps)

SLIP_RATIOS = ("leading_roll", "trailing_roll", "dual")


def roll_wound_on_tension(equations: NipEquations, state: NipState) -> float:
    """Return the wound-on tension reduced to the closed layer of a wound roll [N/m].

    T_closed = T + (2h/c11) (eps_closed - eps_1) with T and eps_1 at EVALUATION_ANGLE downstream of
    the centre of the nip, or at the end of a shorter wrap.
    """
    f, problem = state.fields, equations.problem
    at_nodes, at_points = evaluation_weights(equations, f)
    T, strain = float(at_nodes @ f.tension), float(at_points @ f.roll.strain)
    hoop_tension = T - problem.centrifugal_tension
    closed_strain = problem.roll.uniform_strain(hoop_tension / problem.roll.radius)
    return T + problem.web.thickness / problem.web.compliance.c11 * (closed_strain - strain)


def evaluation_weights(equations: NipEquations, f: Fields) -> tuple[Array, Array]:
    """Return the weights with which T and eps_1 are interpolated at EVALUATION_ANGLE.

    The first are those of T at the nodes of the mesh, (nodes,), the second those of eps_1 at the
    points of the roll's face, (points,); only two of each are not zero.
    """
    mesh, a, face = f.geometry.mesh, f.geometry.a, f.geometry.roll.face
    at_nodes, at_points = np.zeros(mesh.nodes.size), np.zeros(face.points.size)
    s = EVALUATION_ANGLE * equations.problem.roll.radius / a  # in units of the half width
    if s >= mesh.points[-1]:  # a shorter wrap: at its end
        at_nodes[-1] = at_points[-1] = 1.0
        return at_nodes, at_points
    for weights, positions in ((at_nodes, mesh.nodes), (at_points, face.points[:-2])):
        k = int(np.searchsorted(positions, s)) - 1
        weights[k + 1] = (s - positions[k]) / (positions[k + 1] - positions[k])
        weights[k] = 1.0 - weights[k + 1]
    return at_nodes, at_points


def approach(equations: NipEquations, state: NipState) -> float:
    """Return the mutual approach of the centres, from the indentation at the trailing edge [m].

    Thesis eq. 82: the gap closes there, v+ + v- + change of the web's thickness + Delta a/R* =
    a^2/(2 R*) - delta.
    """
    layout, f, problem = equations.layout, state.fields, equations.problem
    a, _, roll, drum = f.geometry
    v = roll.surface.end_displacement(*f.on_roll) + drum.surface.end_displacement(*f.on_drum)
    v += problem.web.compliance.c12 * f.tension[layout.last]
    v -= problem.web.thinned(f.p_roll[layout.last : layout.last + 1])[0][0]
    return float(a**2 / (2 * problem.contact_radius) - v - state.u[layout.shift] * a)


def _extend_to_nodes(values: Array, first: int, size: int) -> Array:
    """Return values in the cells of a face as those of all nodes, (size,).

    A node has the value of the cell upstream of it, the first node of the face that of its cell;
    nodes outside of the face have nan.

    Parameters
    ----------
    values : (cells,) array
    first : int
        First node of the face.
    size : int
        Number of all nodes.
    """
    out = np.full(size, np.nan)
    out[first + 1 : first + 1 + values.size] = values
    out[first] = values[0]
    return out


def web_arrays(equations: NipEquations, state: NipState, active: Array) -> dict[str, Array]:
    """Return the fields along the web at all nodes, by the names of the results, in SI units.

    Slips and strains, which belong to cells, are those of the cell upstream of each node; the
    points at which they are evaluated are ``slip_x``.  ``active`` are the zones of the traction
    nodes, (k,).
    """
    layout, f = equations.layout, state.fields
    a, mesh, n = f.geometry.a, f.geometry.mesh, layout.end + 1
    roll_slip, drum_slip = equations.slip_velocities(
        float(state.u[layout.xi]), f, state.laid_strain
    )
    roll_zone, drum_zone = _zones_at_nodes(equations, active)
    # where a face ends at the trailing edge, p = q = 0 and the friction law permits either zone:
    # the sign of the slip tells whether a slip zone shorter than the last cell ends there
    rounding = strain_rounding(equations, state)
    drum_zone[layout.last] = _slip_direction(drum_slip[-1], rounding)
    if not equations.roll_wrap:
        roll_zone[layout.last] = _slip_direction(roll_slip[-1], rounding)
    slip_x = np.append(mesh.points[:1], mesh.points)
    slip_x[layout.first] = slip_x[layout.first + 1]
    kappa = np.zeros(n)
    if f.drum_curvature.size:
        kappa[: layout.last + 1] = -f.drum_curvature
    if f.roll_curvature.size:
        kappa[layout.last :] = f.roll_curvature[layout.last - layout.first :]
    wrapped = slice(None) if equations.problem.is_wrapped else slice(0, 0)
    return {
        "x": a * mesh.nodes,
        "slip_x": a * slip_x,
        "drum_pressure": f.p_drum,
        "roll_pressure": f.p_roll,
        "hoop_pressure": (f.p_roll - f.p_drum)[wrapped],
        "curvature": kappa[wrapped],
        "roll_traction": f.q_roll,
        "drum_traction": f.q_drum,
        "roll_slip": _extend_to_nodes(roll_slip, layout.first, n),
        "drum_slip": _extend_to_nodes(drum_slip, 0, n),
        "roll_zone": roll_zone,
        "drum_zone": drum_zone,
        "tension": f.tension,
        "roll_strain": _extend_to_nodes(f.roll.strain[:-2], layout.first, n),
    }


def _zones_at_nodes(equations: NipEquations, active: Array) -> tuple[Array, Array]:
    """Return the zones on roll and drum at all N nodes, (N,) each, from ``active``, (k,).

    ``active`` are the zones of the traction nodes.
    The first node of a face, which has no cell upstream, and the node at which the web is held to
    the roll have the zone of their neighbour; nodes outside of a face have 0.
    """
    layout = equations.layout
    roll, drum = np.zeros((2, layout.end + 1), dtype=np.int8)
    k = layout.roll_count
    roll[layout.roll_nodes], drum[layout.drum_nodes] = active[:k], active[k:]
    roll[layout.first], roll[-1], drum[0] = roll[layout.first + 1], roll[-2], drum[1]
    return roll, drum


def _slip_direction(slip: float, rounding: float) -> int:
    """Return the sign of a slip velocity, 0 if it is due to rounding."""
    return int(np.sign(slip)) if abs(slip) > rounding else 0


def strain_rounding(equations: NipEquations, state: NipState) -> float:
    """Return the rounding error of a slip velocity, which is a difference of strains."""
    f, web = state.fields, equations.problem.web
    strain = web.compliance.c11 / web.thickness * float(np.abs(f.tension).max())
    return ROUNDING * (strain + abs(drum_creepage(equations, state)))


def drum_creepage(equations: NipEquations, state: NipState) -> float:
    """Return the creepage between web and drum, both unstrained: xi of the equations - c11 T/2h."""
    web = equations.problem.web
    xi, T_end = state.u[equations.layout.xi], state.fields.tension[-1]
    return float(xi - web.compliance.c11 / web.thickness * T_end)


def slip_ratios(problem: NipProblem, arrays: Mapping[str, Array], nip: slice) -> dict[str, float]:
    """Return the signed slip lengths over the nip width (thesis eq. 172), by name.

    Parameters
    ----------
    problem : NipProblem
    arrays : mapping
        As :func:`web_arrays` returns them.
    nip : slice
        The nodes of the nip.
    """
    x, lengths = arrays["x"][nip], []
    for face, pressure, friction in (
        ("roll", arrays["roll_pressure"], problem.roll_friction),
        ("drum", arrays["drum_pressure"], problem.drum_friction),
    ):
        zone, slip, q = (arrays[f"{face}_{name}"][nip] for name in ("zone", "slip", "traction"))
        lengths.append(slip_lengths(x, zone, slip, friction * pressure[nip] - np.abs(q)))
    (leading_roll, trailing_roll), (_, trailing_drum) = lengths
    # dual slip: both faces slip in the same direction at the trailing edge
    same_direction = trailing_roll * trailing_drum > 0
    dual = min(trailing_roll, trailing_drum, key=abs) if same_direction else 0.0
    values = np.array([leading_roll, trailing_roll, dual]) / (x[-1] - x[0])
    return dict(zip(SLIP_RATIOS, values.tolist(), strict=True))


def error_estimates(refinement: Refinement, arrays: Mapping[str, Array]) -> dict[str, float]:
    """Return the estimated discretisation errors of all outputs.

    Richardson's estimate of order two, with exceptions where the fields are not smooth within a
    cell:

    - A slip length has at least the error of half a cell.
    - The dual slip length is zero if a face slips in the opposite direction at the trailing edge,
      however short that zone is.  It may be zero where the slip, extrapolated from the last two
      cells to the edge, changes its direction there.
    - The pressure may have a cusp at a zone boundary, which exceeds the nodal values
      (:func:`.zones.cusp_excess`).
    - Where a traction jumps, a quadrature over the cell is of order one, and so it is next to the
      leading edge if the web sticks to the drum up to it: the traction is singular there, or its
      slip zone is shorter than a cell.  The creepage, which is determined by the resultant of the
      tractions, then converges with order one.
    - Where the roll wrap ends, so does the hoop pressure, in a step.  The strain of the roll is
      singular there, and the traction in the last cell is known to its size only.
    - At the start of a drum wrap the pressure T/R begins within a length of about T C, C the
      compliance of the drum.  A longer cell does not resolve the strain there, on which the
      creepage depends; the error is then the change of this strain under T/R.

    Parameters
    ----------
    refinement : Refinement
    arrays : mapping
        As :func:`web_arrays` returns them, of the last mesh.
    """
    last = refinement.last
    first_nip, geometry = last.system.nips[0], last.state.nips[0].geometry
    errors, mesh = refinement.errors(), geometry.mesh
    half_cell = float(mesh.cells[mesh.nip_cells].max()) / 2  # relative to the nip width
    least_error = LEAST_OFFSET_ERROR * last.outputs["half_width"]
    errors["offset"] = max(errors["offset"], least_error)
    for name in SLIP_RATIOS:
        errors[name] = max(errors[name], half_cell)
    nip = mesh.nip_nodes
    if any(_reverses_at_edge(arrays, name, nip) for name in ("roll_slip", "drum_slip")):
        errors["dual"] = max(errors["dual"], abs(last.outputs["dual"]))
    zones, pressure = (arrays["roll_zone"], arrays["drum_zone"]), arrays["drum_pressure"]
    errors["peak_pressure"] = max(errors["peak_pressure"], cusp_excess(pressure, *zones))
    sticks_at_edge = arrays["drum_zone"][0] == 0
    if sticks_at_edge or any(has_traction_jump(zone) for zone in zones):
        errors["drum_creepage"] = refinement.errors(order=1)["drum_creepage"]
    if "roll_wrap_traction" in errors:
        last_change = abs(float(np.diff(arrays["tension"][-2:])[0]))
        errors["roll_wrap_traction"] = max(errors["roll_wrap_traction"], last_change)
    unresolved_strain = _unresolved_wrap_strain(first_nip, geometry)
    errors["drum_creepage"] = max(errors["drum_creepage"], unresolved_strain)
    return errors


def _reverses_at_edge(arrays: Mapping[str, Array], name: str, nip: slice) -> bool:
    """Return True if the slip, extrapolated linearly to the trailing edge, changes its sign.

    ``name`` is that of the slip among the arrays, ``nip`` are the nodes of the nip.
    """
    (x1, x2), (v1, v2) = arrays["slip_x"][nip][-2:], arrays[name][nip][-2:]
    v_edge = v2 + (v2 - v1) * (arrays["x"][nip][-1] - x2) / (x2 - x1)
    return bool(v2 * v_edge < 0)


def _unresolved_wrap_strain(equations: NipEquations, geometry: Geometry) -> float:
    """Return the change of the drum strain under T/R at the start of its wrap.

    It is zero if the first cell resolves this change, which extends over a length of about T C.
    """
    drum, T = equations.problem.drum, equations.problem.hoop_tension
    first_cell = geometry.a * float(geometry.mesh.cells[0])
    if not equations.drum_wrap or first_cell <= T * drum.compliance:
        return 0.0
    return abs(drum.uniform_strain(T / drum.radius))


class NipSystem(NipEquations):
    """The equations of a nip with their outputs, as mesh refinement needs them."""

    def arrays(self, state: NipState, active: Array) -> dict[str, Array]:
        """Return the fields along the web by the names of the results (:func:`web_arrays`)."""
        return web_arrays(self, state, active)

    def parts_of(self, result: NipFields) -> list[NipFields]:
        """Return the arrays and scalars of each nip in a result: the result itself."""
        return [result]

    def main_outputs(self, state: NipState) -> dict[str, float]:
        """Return the tensions whose error estimates end the mesh refinement [N/m]."""
        f, mesh = state.fields, state.fields.geometry.mesh
        return {
            "wound_on_tension": float(f.tension[-1]),
            # an integral of tractions: the difference of tensions loses digits at high web tension
            "nip_induced_tension": float(f.geometry.a * mesh.weights @ (f.q_roll + f.q_drum)),
        }

    def outputs(
        self, state: NipState, active: Array, names: Collection[str] = ()
    ) -> dict[str, float]:
        """Return all outputs whose discretisation error is estimated, by name, in SI units.

        Parameters
        ----------
        state : NipState
        active : (k,) int array
            Zones of the traction nodes.
        names : collection of str
            Those that are needed, if not all: others that take longer are left out.
        """
        layout, f = self.layout, state.fields
        a, mesh, T = f.geometry.a, f.geometry.mesh, f.tension
        out = {
            **self.main_outputs(state),
            "roll_wound_on_tension": roll_wound_on_tension(self, state),
            "inlet_tension": float(T[layout.first]),
            "outlet_tension": float(T[layout.last]),
            "half_width": a,
            "nip_width": 2 * a,
            "peak_pressure": float(f.p_drum.max()),
            "drum_creepage": drum_creepage(self, state),
            "offset": float(state.u[layout.shift] * self.problem.contact_radius),
        }
        if not names or "approach" in names:
            out["approach"] = approach(self, state)
        if not names or any(name in names for name in SLIP_RATIOS):
            out |= slip_ratios(self.problem, web_arrays(self, state, active), mesh.nip_nodes)
        if self.roll_wrap:
            out["roll_wrap_traction"] = float(T[-1] - T[layout.last])
        if self.drum_wrap:
            out["drum_wrap_traction"] = float(T[layout.first] - T[0])
        if self.problem.viscoelastic:
            nip, work = mesh.nip_nodes, work_on_bodies(state)
            x = a * mesh.nodes[nip]
            out |= viscoelastic_outputs(self.problem, work, x, f.p_drum[nip], out["offset"])
        return out
