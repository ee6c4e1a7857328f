"""The wrapped nip where something simpler is known: no wrap, no friction behind, a sliding drum."""

from __future__ import annotations

from itertools import pairwise
from math import exp, pi
from typing import Any

import numpy as np
import pytest
from slow_cases import slow_case
from thesis_cases import newsprint_nip, paper_nip
from wrapped_nips import solve_wrapped

import woundon as wo
from woundon.contact.refinement import refine
from woundon.elasticity.half_plane import coefficients
from woundon.nip.outputs import NipSystem

FOAM = wo.Isotropic(youngs_modulus=10e6, poissons_ratio=0.1)
RUBBER = wo.Isotropic(youngs_modulus=10e6, poissons_ratio=0.45)
PAPER = paper_nip(web_tension=300.0)
FOAM_DRUM = wo.Cylinder(radius=0.5, core_radius=0.48, material=FOAM)
NIPS = {
    "paper": PAPER,
    "surface winding": PAPER.replace(winding_force=-300.0),
    "newsprint": newsprint_nip(),
    "foam cover": PAPER.replace(drum=FOAM_DRUM),
    "rubber cover": PAPER.replace(drum=wo.Cylinder(radius=0.5, core_radius=0.48, material=RUBBER)),
    "half-plane roll": PAPER.replace(roll=wo.HalfPlane(radius=0.3, material=PAPER.roll.material)),
    "rigid roll": PAPER.replace(roll=wo.Rigid(radius=0.3), drum=FOAM_DRUM),
}


def added_in_nip(result: wo.NipResult) -> float:
    """Return the tension added between the edges of the nip [N/m]."""
    return result.outlet_tension - result.inlet_tension


def _held_far_away(problem: wo.NipProblem) -> float:
    """Solve a plain nip whose web is held to the roll half a turn away (96), no load between.

    That is eq. (97) with the slips on the roll referred to the strain of the far side: a term that
    is the same for all nodes.
    """

    class HeldFarAway(NipSystem):
        def slip_velocities(self, xi: float, f: Any, laid_strain: float) -> tuple[Any, Any]:
            roll, drum = super().slip_velocities(xi, f, laid_strain)
            return roll + self._far(f), drum

        def _far(self, f: Any) -> float:
            on_roll = f.p_roll[self.layout.first :], f.q_roll[self.layout.first :]
            far = np.array([pi * self.problem.roll.radius * (1 - 1e-12)])
            roll: Any = self.problem.roll.surface(f.geometry.mesh.roll_face, f.geometry.a)
            strain = roll.strain_outside(*on_roll, far)
            return float(strain[0] - f.roll.strain[-1])

        def jacobian(self, state: Any) -> Any:
            made, at = super().jacobian(state), self.layout
            u, base, T_in = state.u, self._far(state.fields), self.problem.web_tension
            k = at.roll_count
            for column, scale in enumerate(self.scales):
                if column in self.ln_a:
                    continue
                moved = u.copy()
                moved[column] += scale
                # linear in pressures and tractions
                change = self._far(self.fields(moved, state.fields.geometry, T_in)) - base
                made.slip[:k, column] += change / scale / self.slope_scale
            return made

    meshes = refine(lambda size: HeldFarAway(problem, size), nodes=65)
    return float(meshes.last.main_outputs["nip_induced_tension"])


def test_without_hoop_pressure_and_its_friction_the_nip_is_alone() -> None:
    """T_in -> 0 with little friction anywhere: tension, and with it hoop pressure, all but vanish.

    What is left is the plain nip with the web held half a turn away (96).  The trailing edge (97)
    gives less: there the roll is compressed, and the web held to it at once is pressed together.
    """
    problem = PAPER.replace(
        web_tension=0.0, winding_force=0.0, roll_friction=2e-4, drum_friction=4e-4
    )
    wrapped = solve_wrapped(problem, wrap_friction=1e-6, nodes=65)
    alone, unit = _held_far_away(problem), problem.roll_friction * problem.nip_load
    # the hoop pressure left is T/R = 1 Pa next to 300 kPa
    assert added_in_nip(wrapped) == pytest.approx(alone, abs=2e-5 * unit)
    assert wrapped.wound_on_tension == pytest.approx(wrapped.outlet_tension, abs=2e-6)


@pytest.mark.parametrize(
    "problem", [PAPER, PAPER.replace(nip_load=10e3, roll_friction=0.7), slow_case(newsprint_nip())]
)
def test_the_less_the_web_pulls_the_nearer_is_the_nip_alone(problem: wo.NipProblem) -> None:
    """With T_in the nip's hoop pressure falls in proportion; that of T_out is left."""
    alone = _held_far_away(problem)
    far = [
        solve_wrapped(problem.replace(web_tension=T), wrap_friction=1e-6, nodes=65)
        for T in (800.0, 400.0, 200.0, 100.0)
    ]
    differences = [added_in_nip(r) - alone for r in far]
    assert all(abs(b) < abs(a) for a, b in pairwise(differences))
    # linear in the tension between T_in and T_out
    between = [(r.inlet_tension + r.outlet_tension) / 2 for r in far]
    assert differences[0] / differences[3] == pytest.approx(between[0] / between[3], rel=0.4)
    # trailing edge (97) against far side (96): most of what the wrap changes in the nip
    held = wo.solve(problem, nodes=65).nip_induced_tension
    assert abs(differences[3]) < 0.15 * abs(alone - held)


def test_friction_downstream_of_the_nip_vanishes() -> None:
    for mu in (1e-2, 1e-4, 1e-6):
        added = solve_wrapped(PAPER, wrap_friction=mu).roll_wrap_traction
        # at most mu T theta, the whole arc slipping one way
        assert 0 < abs(added) < mu * pi * 500


def test_a_large_roll_does_not_hold_the_web_near_the_nip() -> None:
    """R1 -> large: the hoop pressure T/R1 goes to zero, so does what friction adds near the nip."""
    half_plane = NIPS["half-plane roll"]
    results = [solve_wrapped(half_plane.replace(**{"roll.radius": R})) for R in (0.6, 2.4, 9.6)]
    added = [r.roll_wrap_traction for r in results]
    assert added[0] > added[1] > added[2] > 0
    # slipping length and gain both go with the root of the radius
    assert added[2] < 0.7 * added[1]
    hoop = [r.hoop_pressure[-2] * r.problem.roll.radius / r.wound_on_tension for r in results]
    assert hoop == pytest.approx([1.0] * 3, rel=1e-2)


def test_the_drum_takes_force_by_nip_first_then_by_the_wrap_to_the_capstan_bound() -> None:
    mu, T_in, angle = PAPER.drum_friction, PAPER.web_tension, pi / 2
    nip_limit = mu * PAPER.nip_load
    below = solve_wrapped(PAPER, drum_wrap=angle, winding_force=0.98 * nip_limit)
    assert abs(below.drum_wrap_traction) < 0.2
    above = solve_wrapped(PAPER, drum_wrap=angle, winding_force=nip_limit + 100)
    # the nip slides wholly; the last cell before it is shared by hats of nip and wrap
    assert above.drum_wrap_traction == pytest.approx(100, abs=0.1)
    assert np.all(above.drum_zone[above.in_nip] == wo.Zone.FORWARD)
    # capstan on the undeformed drum: exp over the slipping arc, from its border to the nip
    slipping = np.nonzero(above.drum_zone[: above.in_nip.start] == wo.Zone.FORWARD)[0]
    at = slipping[len(slipping) // 2 :]
    x, T = above.x[at], above.tension[at]
    np.testing.assert_allclose(
        np.log(T[-1] / T[0]), mu * (x[-1] - x[0]) / PAPER.drum.radius, rtol=2e-3
    )
    bound = nip_limit + T_in * (exp(mu * angle) - 1)
    nearly = solve_wrapped(PAPER, drum_wrap=angle, winding_force=0.995 * bound)
    assert nearly.inlet_tension < wo.theories.capstan(T_in, mu, angle)
    with pytest.raises(wo.NoSteadyState, match="the drum slips"):
        solve_wrapped(PAPER, drum_wrap=angle, winding_force=1.0001 * bound)


def test_on_a_hard_drum_the_web_sticks_up_to_the_nip() -> None:
    """Its strain cannot change where the drum has none: all but the last cells before the nip."""
    for angle in (pi / 6, pi / 2, pi):
        result = solve_wrapped(PAPER, drum_wrap=angle)
        before = slice(0, result.in_nip.start)
        slipping = result.x[before][result.drum_zone[before] != 0]
        assert slipping.size == 0 or slipping[0] > -1.5 * result.half_width
        stuck = result.drum_zone[before] == 0
        np.testing.assert_allclose(result.tension[before][stuck][:-1], 300.0, rtol=1e-12)
        # what it brings to the nip differs by what slips there at the leading edge
        assert result.inlet_tension == pytest.approx(300.0, abs=0.2)


def test_capstan_downstream_of_the_nip() -> None:
    """Where the web slips behind the nip T grows as exp(mu int kappa ds) (thesis eq. 178)."""
    result = solve_wrapped(newsprint_nip(), nodes=65)
    first = result.in_nip.stop - 1
    last = first + np.nonzero(result.roll_zone[first:] != wo.Zone.FORWARD)[0][0] - 1
    x, kappa = result.x[first : last + 1], result.curvature[first : last + 1]
    turned = float(np.trapezoid(kappa, x))
    gained = float(np.log(result.tension[last] / result.tension[first]))
    # exact but for the rule of integration; measured 2e-6
    assert gained == pytest.approx(0.19 * turned, rel=1e-4)
    assert result.roll_pressure[last] == pytest.approx(result.tension[last] * kappa[-1])


# ---- short wraps ---------------------------------------------------------------------------------


def test_roll_wraps_are_solved_from_the_trailing_edge_on() -> None:
    """The smallest value that a rejection states is solved, 1 % less is rejected."""
    problem = newsprint_nip()
    edge = wo.solve(problem.replace(roll_wrap=1.0), nodes=41).half_width / problem.roll.radius
    with pytest.raises(wo.InvalidProblem, match=r"roll_wrap: 1e-09 is out of range") as fault:
        wo.solve(problem.replace(roll_wrap=1e-9))
    smallest = float(str(fault.value).split(">= ")[1].split()[0])
    # 1.02 a/R1, and the nip of a short wrap is wider by 1 % at most
    assert 1.02 * edge < smallest < 1.03 * edge
    with pytest.raises(wo.InvalidProblem, match=f">= {smallest:g} "):
        wo.solve(problem.replace(roll_wrap=0.99 * smallest))
    tensions = []
    for wrap in (smallest, 1.1 * edge, 2 * edge, 4 * edge):
        result = wo.solve(problem.replace(roll_wrap=wrap), nodes=41)
        assert result.x[-1] == pytest.approx(wrap * problem.roll.radius, rel=1e-12)
        tensions.append(result.wound_on_tension)
    # the surface recovers along the web, the more of it the longer the wrap
    assert tensions == sorted(tensions)


def test_the_shortest_wrap_is_another_model_than_no_wrap() -> None:
    """Closed form: hoop pressure in the nip and at the end, where the web is held (wraps.md)."""
    problem = newsprint_nip()
    held = wo.solve(problem.replace(roll_wrap=0.0), nodes=81)
    short = wo.solve(problem.replace(roll_wrap=0.0256), nodes=81)
    T, web = short.wound_on_tension, problem.web
    in_nip = problem.roll_friction * short.nip_width * T / problem.drum.radius
    m, p_end = problem.roll.material, short.roll_pressure[-1]
    A, *_ = coefficients(m.radial, m.tangential, m.cross, m.shear)  # local strain -A p
    at_end = web.thickness / web.compliance.c11 * A * p_end
    assert p_end > 3 * T / problem.roll.radius
    # at most, because the strain of the roll follows the tension
    drop = held.wound_on_tension - T
    assert 0.25 * (in_nip + at_end) < drop < in_nip + at_end


@pytest.mark.parametrize("name", ["paper", "foam cover"])
def test_a_vanishing_drum_wrap_is_no_drum_wrap(name: str) -> None:
    problem = NIPS[name].replace(roll_wrap=pi)
    none = wo.solve(problem, nodes=41)
    for wrap in (1e-9, 1e-5):
        result = wo.solve(problem.replace(drum_wrap=wrap), nodes=41)
        # the arc adds cells, whose lengths change with the root of the arc
        assert result.wound_on_tension == pytest.approx(
            none.wound_on_tension, abs=0.2 * none.error("wound_on_tension")
        )


# ---- the end of slip on the roll -----------------------------------------------------------------


@pytest.mark.parametrize("load", [800.0, 4700.0])
def test_the_slip_angle_ends_between_the_last_node_that_slips_and_the_first_that_sticks(
    load: float,
) -> None:
    """Consistency with the zones; and first-order convergence, to one cell of the wrap."""
    problem = newsprint_nip(nip_load=load).replace(roll_wrap=pi)
    fine = wo.solve(problem, nodes=257)
    for nodes in (33, 65):
        result = wo.solve(problem, nodes=nodes)
        behind = (result.x - result.half_width) / problem.roll.radius
        wrap = behind > 0
        angle, zone = behind[wrap], result.roll_zone[wrap]
        first = int(np.argmax(zone != zone[0]))
        cell = angle[first] - angle[first - 1]
        inside = (result.slip_angle - angle[first - 1]) / cell
        assert 1e-3 < inside < 1 - 1e-3
        assert abs(result.slip_angle - fine.slip_angle) < cell
