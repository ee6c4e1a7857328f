"""The procedure of the thesis (sec. 3.4, 3.6), a second solver independent of ``wo.solve``.

Evidence: values of an independent program; convergence order and its cause; ``wo.solve`` as
independent method; closed forms (Hertz, a roll that slips all over); invariance (winding theorem).
"""

from __future__ import annotations

import numpy as np
import pytest
from slow_cases import campaign_case, slow_case
from thesis_cases import newsprint_nip, paper_nip

import woundon as wo
from woundon.jorkama2001 import procedure
from woundon.jorkama2001.estimate import rig_tension, wound_on_tension_estimate
from woundon.jorkama2001.influence import coefficients, half_plane_constants, surface_strain

PAPER = wo.material("paper")
PROBLEM = paper_nip(roll=wo.HalfPlane(radius=0.3, material=PAPER))
LUMPED = {50: 111.0703, 100: 119.3863, 200: 125.2599, 400: 129.1584}
PRINTED = {50: 110.913, 100: 119.285, 200: 125.198, 400: 129.160}  # (121) as printed
EXACT_EDGE = {50: 136.4, 100: 135.5, 200: 135.05, 400: 134.85}  # by an independent program
LIMIT = 134.7534  # an independent program and wo.solve with 1025 nodes
COVER = wo.Isotropic(youngs_modulus=10e6, poissons_ratio=0.1)
# its exponents n + 1 and n - 1 meet a zero of the denominator of eta (48)
QUARTER = wo.Isotropic(youngs_modulus=1e6, poissons_ratio=0.25)
NIPS = {
    "half-plane roll": PROBLEM,
    "heavy": paper_nip(nip_load=4897.0),
    "surface winding": paper_nip(nip_load=1910.0, winding_force=-400.0),
    "roll friction above drum friction": paper_nip(nip_load=4897.0, roll_friction=0.5),
    "newsprint": newsprint_nip(),
    "drum cover": paper_nip(drum=wo.Cylinder(radius=0.5, core_radius=0.48, material=COVER)),
    "soft half-plane for a drum": paper_nip(drum=wo.HalfPlane(radius=0.5, material=COVER)),
}


@pytest.mark.parametrize("nodes", LUMPED)
def test_nip_of_table_1(nodes: int) -> None:
    """An independent program has 111.07, 119.39, 125.26 and 129.16 N/m."""
    result = procedure.solve(PROBLEM, nodes)
    assert result.nip_induced_tension == pytest.approx(LUMPED[nodes], abs=6e-5)


@pytest.mark.parametrize("nodes", PRINTED)
def test_printed_web_coefficients_change_little(nodes: int) -> None:
    result = procedure.solve(PROBLEM, nodes, web_tension="printed")
    assert result.nip_induced_tension == pytest.approx(PRINTED[nodes], abs=6e-4)
    assert result.nip_induced_tension == pytest.approx(LUMPED[nodes], rel=1.5e-3)


@pytest.mark.parametrize("nodes", [50, 100, 200])
def test_start_from_stick_everywhere_ends_in_the_same_state(nodes: int) -> None:
    """Step 2 as printed takes more systems, and the solution is unique."""
    cold, warm = (procedure.solve(PROBLEM, nodes, cold=cold) for cold in (True, False))
    assert cold.nip_induced_tension == pytest.approx(warm.nip_induced_tension, rel=1e-8)
    np.testing.assert_array_equal(cold.roll_zone, warm.roll_zone)
    np.testing.assert_array_equal(cold.drum_zone, warm.drum_zone)
    assert cold.iterations > warm.iterations


def test_no_convergence_is_an_error() -> None:
    """From stick everywhere, with the printed coefficients, the process does not end here."""
    with pytest.raises(wo.NotConverged, match="stick and slip not found after"):
        procedure.solve(PROBLEM, 200, web_tension="printed", cold=True)


def test_printed_coefficients_make_the_traction_oscillate_upstream_of_the_slip_zone() -> None:
    """In stick, neighbouring rows of (121) give q_l + 4 q_(l-1) + q_(l-2) = rhs, root -3.73.

    Upstream of C, where the drum starts to slip, the tractions alternate about their smooth
    course by tens of kPa and decay by a factor of 3.73 a node.  With the tension lumped they do
    not.
    """

    def steps(web_tension: str) -> np.ndarray:
        result = procedure.solve(PROBLEM, 200, web_tension=web_tension)
        last = int(np.nonzero(result.drum_zone == 0)[0][-1])
        return np.diff((result.drum_traction + result.roll_traction)[last - 4 : last + 1])

    printed, lumped = steps("printed"), steps("lumped")
    # three steps away the smooth course, 25 Pa a node, is 4 % of the oscillation
    np.testing.assert_allclose(printed[1:] / printed[:-1], -(2 + np.sqrt(3)), rtol=0.06)
    assert np.all(lumped > 0)
    # the last step is that of the slip zone, the last but one shows the oscillation alone
    assert abs(printed[-2]) > 500 * lumped[-2]


# ---- against wo.solve ----------------------------------------------------------------------------


def test_strain_of_the_last_cell_makes_it_converge_slowly() -> None:
    """Half a cell upstream of the edge p varies as the root of the distance: order 1/2 to 1."""
    errors = np.array([LIMIT - LUMPED[nodes] for nodes in LUMPED])
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all((orders > 0.5) & (orders < 0.8))
    assert errors[2] == pytest.approx(0.07 * LIMIT, rel=0.02)


@pytest.mark.parametrize("nodes", EXACT_EDGE)
def test_strain_at_the_edge_itself_removes_the_cause(nodes: int) -> None:
    result = procedure.solve(PROBLEM, nodes, exact_edge=True)
    assert result.nip_induced_tension == pytest.approx(EXACT_EDGE[nodes], abs=0.06)


@pytest.mark.parametrize(
    "name",
    [slow_case(name) if name in ("heavy", "newsprint", "drum cover") else campaign_case(name)
     for name in NIPS],
)  # fmt: skip
def test_both_solvers_have_one_limit(name: str) -> None:
    """NIT is extrapolated by 1/M and 1/M^2 from M - 1 = 100, 200 and 400; measured: 0.1 %.

    The roll's traction has a kink and the drum's a jump at zone boundaries, which lie anywhere
    in a cell, so that the extrapolation is good to some thousandths only.
    """
    problem = NIPS[name]
    accurate = wo.solve(problem, nodes=257)
    cells = np.array([100, 200, 400])
    found = [procedure.solve(problem, int(N) + 1, exact_edge=True) for N in cells]
    powers = 1.0 / cells[:, None] ** np.arange(3)
    limit = np.linalg.solve(powers, [one.nip_induced_tension for one in found])[0]
    assert limit == pytest.approx(accurate.nip_induced_tension, rel=4e-3)
    finest = found[-1]
    assert finest.half_width == pytest.approx(accurate.half_width, rel=2e-4)
    largest = accurate.drum_pressure.max()
    for name in ("drum_pressure", "roll_traction"):
        ours = np.interp(finest.x[::8], accurate.x, getattr(accurate, name))
        np.testing.assert_allclose(getattr(finest, name)[::8], ours, atol=0.01 * largest)
    # the thesis's own condition has the same limit, from below or above, more slowly
    slower = procedure.solve(problem, 401).nip_induced_tension
    assert abs(slower - limit) > abs(finest.nip_induced_tension - limit)


# ---- closed forms and invariances ----------------------------------------------------------------


def test_hertz_without_friction_to_speak_of() -> None:
    """Half-planes, thin web: (103), (104)."""
    drum = wo.HalfPlane(radius=0.5, material=PAPER)
    problem = paper_nip(
        roll=wo.HalfPlane(radius=0.3, material=PAPER), drum=drum, winding_force=0.0,
        roll_friction=1e-6, drum_friction=1e-6, **{"web.thickness": 1e-6},
    )  # fmt: skip
    result = procedure.solve(problem, 201)
    C = half_plane_constants(PAPER.stiffness)[2]
    a = 2 * np.sqrt(problem.nip_load / (1 / 0.3 + 1 / 0.5) * C / np.pi)
    assert result.half_width == pytest.approx(a, rel=2e-3)
    hertz = 2 * problem.nip_load / (np.pi * a) * np.sqrt(np.clip(1 - (result.x / a) ** 2, 0, None))
    np.testing.assert_allclose(result.drum_pressure, hertz, atol=0.015 * hertz.max())


def test_roll_that_slips_all_over() -> None:
    """NIT = mu+ P + F at light load and large -F."""
    result = procedure.solve(paper_nip(nip_load=1300.0, winding_force=-500.0), 100)
    assert result.nip_induced_tension == pytest.approx(0.2 * 1300.0 - 500.0, abs=1e-5)
    assert np.all(result.roll_zone == 1)


def test_winding_theorem() -> None:
    """(171): NIT and tractions do not depend on T_in; approach and creepage change as estimated."""
    slack, taut = (procedure.solve(paper_nip(web_tension=T), 60) for T in (400.0, 900.0))
    assert taut.nip_induced_tension == pytest.approx(slack.nip_induced_tension, rel=1e-8)
    np.testing.assert_allclose(taut.drum_traction, slack.drum_traction, rtol=1e-6, atol=1e-3)
    A_rr, A_tt, A_rt, *_ = PAPER.stiffness
    det = A_rr * A_tt - A_rt**2
    change = taut.approach - slack.approach, taut.drum_creepage - slack.drum_creepage
    assert change[0] == pytest.approx(500.0 * A_rt / det, rel=1e-4)
    assert change[1] == pytest.approx(-500.0 * A_rr / det / 66e-6, rel=1e-6)


def test_contact_conditions() -> None:
    """Every condition from the result's own arrays: equilibrium, friction, directions of slip."""
    result = procedure.solve(paper_nip(nip_load=11000.0), 200)
    problem, inside = result.problem, slice(1, -1)
    dx = result.x[1] - result.x[0]
    assert dx * result.drum_pressure.sum() == pytest.approx(problem.nip_load, rel=1e-8)
    assert dx * result.drum_traction.sum() == pytest.approx(problem.winding_force, rel=1e-8)
    gain = dx * (result.roll_traction + result.drum_traction).sum()
    assert gain == pytest.approx(result.nip_induced_tension, rel=1e-8)
    assert result.tension[-1] == pytest.approx(result.outlet_tension, rel=1e-12)
    for face, friction in (("roll", problem.roll_friction), ("drum", problem.drum_friction)):
        q, v, zone = (
            getattr(result, f"{face}_{name}")[inside] for name in ("traction", "slip", "zone")
        )
        bound = friction * result.drum_pressure[inside]
        assert np.all(np.abs(q) <= bound * (1 + 1e-6) + 1e-6)
        np.testing.assert_allclose(q[zone != 0], (zone * bound)[zone != 0], rtol=1e-9)
        assert np.all(v[zone == 0] == 0)
        assert np.all((zone * v)[zone != 0] >= -1e-9 * np.abs(v).max())


@pytest.mark.parametrize("nodes", [200, 400])
def test_load_far_below_those_of_the_figures(nodes: int) -> None:
    """1 N/m, where the web is a quarter as thick as the nip is wide (fig. 16)."""
    result = procedure.solve(paper_nip(winding_force=0.0, nip_load=1.0), nodes)
    assert 0.8 < result.nip_induced_tension / 0.2 < 0.87


# ---- influence coefficients ----------------------------------------------------------------------


def test_isotropic_half_plane() -> None:
    """(30): C = 2 (1 - nu^2)/E."""
    C = half_plane_constants(wo.Isotropic(youngs_modulus=1e6, poissons_ratio=0.3).stiffness)[2]
    assert pytest.approx(2 * (1 - 0.3**2) / 1e6, rel=1e-12) == C


def test_thick_cylinder_is_a_half_plane_near_the_load() -> None:
    """Strains but for v/R, differences of displacements along the nip."""
    M, a = 60, 1e-3
    thick = coefficients(wo.Cylinder(radius=20.0, core_radius=0.1, material=PAPER), M, a)
    flat = coefficients(wo.HalfPlane(radius=20.0, material=PAPER), M, a)
    for name in ("A", "B"):
        ours, exact = (np.diff(getattr(c, name), axis=0) for c in (thick, flat))
        np.testing.assert_allclose(ours, exact, atol=2e-3 * np.abs(exact).max())


@pytest.mark.parametrize("core_radius", [0.05, 0.28])
@pytest.mark.parametrize("material", [PAPER, COVER, QUARTER])
def test_strain_is_the_limit_of_backward_differences(
    material: wo.Orthotropic | wo.Isotropic, core_radius: float
) -> None:
    """Smooth pressure and traction, smaller and smaller cells: first order."""
    body, a, errors = wo.Cylinder(radius=0.3, core_radius=core_radius, material=material), 0.01, []
    for M in (101, 201, 401):
        x = np.linspace(-a, a, M)
        p = 1e5 * (1 - (x / a) ** 2) ** 2
        q = p * (x / a)
        made = coefficients(body, M, a)
        differences = made.C @ p[1:-1] + made.D @ q[1:-1]
        exact = surface_strain(body, x, p, q, x[1:])
        errors.append(np.abs(differences - exact).max() / np.abs(exact).max())
    assert errors[1] / errors[2] > 1.9
    assert errors[2] < 0.02


def test_mean_pressure_on_a_whole_cylinder() -> None:
    """Lame: a pressure all round moves the surface by -gamma_0 p; its strain is the same over R."""
    nu, E, R, R0 = 0.3, 1e6, 0.3, 0.2
    body = wo.Cylinder(
        radius=R, core_radius=R0, material=wo.Isotropic(youngs_modulus=E, poissons_ratio=nu)
    )
    x = np.linspace(-np.pi * R, np.pi * R, 41)
    p = np.full(x.size, 1e3)
    strain = surface_strain(body, x, p, 0.0 * p, np.array([0.0, 0.1]))
    # u = A r + B/r, u(R0) = 0, sigma_r(R) = -p in plane strain
    lame, G = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    A = -1e3 / (2 * (lame + G) + 2 * G * R0**2 / R**2)
    np.testing.assert_allclose(strain, A * (1 - R0**2 / R**2), rtol=1e-9)


@pytest.mark.parametrize("problem", [paper_nip(nip_load=1e4), newsprint_nip(), PROBLEM])
def test_tension_far_downstream(problem: wo.NipProblem) -> None:
    """(183) from the tractions of either solver: the strains of both are those of one roll."""
    accurate = wo.solve(problem, nodes=129)
    x, p, q = accurate.x, accurate.drum_pressure, accurate.roll_traction
    points = np.array([np.pi * problem.roll.radius / 2, accurate.half_width])
    far, edge = surface_strain(problem.roll, x, p, q, points)
    A_rr, A_tt, A_rt, *_ = problem.web.material.stiffness
    stiffness = problem.web.thickness * (A_tt - A_rt**2 / A_rr)
    estimate = accurate.outlet_tension + stiffness * (far - edge)
    assert estimate == pytest.approx(wound_on_tension_estimate(accurate, np.pi / 2), rel=1e-6)
    rough = procedure.solve(problem, 200, exact_edge=True)
    assert rig_tension(rough) == pytest.approx(rig_tension(accurate), rel=5e-3)


# ---- what is rejected ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("changes", "options", "names"),
    [
        ({}, {"nodes": 7}, "nodes"),
        ({}, {"nodes": 50.0}, "nodes"),
        ({}, {"nodes": True}, "nodes"),
        ({}, {"web_tension": "exact"}, "web_tension"),
        ({}, {"load_tolerance": 0.0}, "load_tolerance"),
        ({}, {"load_tolerance": float("nan")}, "load_tolerance"),
        ({}, {"load_tolerance": "1 N/m"}, "load_tolerance"),
        ({"roll": wo.Rigid(radius=0.3)}, {}, "drum"),
        (
            {"drum": wo.Layered(radius=0.5, layers=[wo.Layer(thickness=0.1, material=COVER)])},
            {}, "drum",
        ),
    ],
)  # fmt: skip
def test_invalid_input_is_rejected(changes: dict, options: dict, names: str) -> None:
    with pytest.raises(wo.InvalidProblem, match=names):
        procedure.solve(paper_nip(**changes), **options)
