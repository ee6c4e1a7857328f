"""Surface response of a hardening roll: tangents, linear limits, the law's range, the Jacobian."""

from __future__ import annotations

from math import exp, pi
from typing import Any

import numpy as np
import pytest
from hardening_cases import constant_rings, law_of, linear, nip, roll

import woundon as wo
from woundon.contact.newton import SemismoothNewton
from woundon.elasticity import cylinder, ring_equilibrium
from woundon.elasticity.hardening import HardeningLaw
from woundon.elasticity.hardening_surface import HardeningSurface
from woundon.elasticity.influence import InfluenceSurface
from woundon.elasticity.mesh import Face, Wrap, nip_mesh
from woundon.elasticity.ring_elements import Fineness
from woundon.nip.outputs import NipSystem
from woundon.problems.radial_laws import Constant
from woundon.problems.wound_roll import ring_of

Array = np.ndarray

A = 2.5e-3
WRAP = Wrap(20.0, 40.0)
MESH = nip_mesh(17, WRAP, WRAP)
FACES = {
    "nip": nip_mesh(17, Wrap(), Wrap()).roll_face,
    "roll wrap": MESH.roll_face,
    "drum wrap": MESH.drum_face,
}


@pytest.fixture(autouse=True)
def new_rings() -> None:
    """Forget the rings of other tests: tangents may use factorisations of neighbouring states."""
    ring_of.cache_clear()


def loads(face: Face, peak: float = 1e6) -> tuple[Array, Array]:
    """Return pressures and tractions in the nip, and lower ones on a wrap."""
    x = face.nodes
    p = peak * np.sqrt(np.maximum(1 - x**2, 0.0)) + 5e-3 * peak * (np.abs(x) > 1)
    p[[0, -1]] = 0.0
    return p, 0.15 * p * np.sin(2 * x)


def deviation(values: Any, wanted: Any) -> float:
    """Return the largest difference relative to the largest value."""
    return float(np.max(np.abs(np.subtract(values, wanted))) / np.max(np.abs(wanted)))


# ---- derivatives --------------------------------------------------------------------------------


@pytest.mark.parametrize("face", FACES.values(), ids=FACES)
@pytest.mark.parametrize("shear_exponent", [0.0, 0.5])
def test_the_tangent_is_the_derivative(face: Face, shear_exponent: float) -> None:
    surface = roll(shear_exponent=shear_exponent).surface(face, A)
    p, q = loads(face)
    rng = np.random.default_rng(0)
    dp, dq = 1e-4 * p * rng.normal(size=(2, p.size))
    slope_p, slope_q, strain_p, strain_q = surface.tangent(p, q)
    end_p, end_q = surface.end_tangent(p, q)
    forward, backward = (
        (*surface.deform(p + s * dp, q + s * dq), surface.end_displacement(p + s * dp, q + s * dq))
        for s in (1, -1)
    )
    tangents = (slope_p @ dp + slope_q @ dq, strain_p @ dp + strain_q @ dq, end_p @ dp + end_q @ dq)
    for one, other, tangent in zip(forward, backward, tangents, strict=True):
        assert deviation((one - other) / 2, tangent) < 1e-6


@pytest.mark.parametrize("wraps", [{}, {"roll_wrap": pi / 2}, {"roll_wrap": 1.0, "drum_wrap": 0.5}])
def test_the_jacobian_is_the_derivative(
    wraps: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The web hardens too.  The column by ln a is a forward difference of 1e-5."""
    # in use, factorisations of the rings at neighbouring states are accurate enough
    monkeypatch.setattr(ring_equilibrium, "ACCURATE_RATE", 0.0)
    monkeypatch.setattr(ring_equilibrium, "REUSE_DISTANCE", 0.0)
    problem: Any = nip(roll())
    problem = problem.replace(**{"web.material": roll().stack})
    problem = problem.replace(**wraps)
    system: Any = NipSystem(problem, 13)
    u, active = system.initial_guess()
    solution, _ = SemismoothNewton(system).solve(u, active, 1e-6)
    system = NipSystem(problem, 13)  # without the surfaces of a neighbouring half width
    state = system.evaluate(solution.u)
    jacobian = system.jacobian(state)
    rng = np.random.default_rng(0)
    step = rng.normal(size=u.size) * system.scales * 1e-6
    forward, backward = (system.evaluate(state.u + s * step) for s in (1, -1))
    for name, matrix in jacobian._asdict().items():
        change = (getattr(forward, name) - getattr(backward, name)) / 2
        assert deviation(change, matrix @ step) < 1e-4


# ---- linear limits ------------------------------------------------------------------------------


@pytest.mark.parametrize("face", FACES.values(), ids=FACES)
def test_a_stack_that_does_not_harden_is_the_linear_cylinder(face: Face) -> None:
    """And every stack is one at rest."""
    p, q = loads(face)
    hard = roll()
    constant = hard.replace(stack=hard.stack.replace(radial=27e6))
    for body, (on_p, on_q) in ((constant, (p, q)), (hard, (0 * p, 0 * q))):
        surface, wanted = (one.surface(face, A) for one in (body, linear(body, 90e3)))
        parts = zip(surface.tangent(on_p, on_q), wanted.tangent(on_p, on_q), strict=True)
        assert all(deviation(*pair) < 1e-9 for pair in parts)
        if on_p.any():
            pairs = zip(surface.deform(on_p, on_q), wanted.deform(on_p, on_q), strict=True)
            assert all(deviation(*pair) < 1e-9 for pair in pairs)
        else:
            assert np.max(np.abs(surface.deform(on_p, on_q))) < 1e-12


def test_the_elements_supply_the_difference_of_two_moduli() -> None:
    """Closed form: influence functions of 27 MPa are those of 18 MPa plus the difference."""
    wanted_kernels, kernels = (
        cylinder.surface_kernels(0.1, 0.0445, *law_of(E).stiffness(0.0)) for E in (27e6, 18e6)
    )
    errors = []
    for nodes in (17, 33):
        face = nip_mesh(nodes, Wrap(), Wrap()).roll_face
        p, q = loads(face)
        given = InfluenceSurface(kernels, 0.1, True, face, A)
        wanted = InfluenceSurface(wanted_kernels, 0.1, True, face, A)
        surface = HardeningSurface(constant_rings(27e6, 18e6), given, face, A, np.inf)
        found, exact, first = (one.deform(p, q) for one in (surface, wanted, given))
        assert deviation(first.strain, exact.strain) > 0.05
        errors.append(max(deviation(*pair) for pair in zip(found, exact, strict=True)))
        assert deviation(surface.end_displacement(p, q), wanted.end_displacement(p, q)) < 2e-3
        u = (one.end_tangential_displacement(p, q) for one in (surface, wanted))
        assert deviation(*u) < 0.02
    assert errors[1] < 0.01
    assert errors[0] > 1.5 * errors[1]


def test_an_estimated_roll_has_no_response() -> None:
    with pytest.raises(wo.InvalidProblem, match="hardening"):
        roll().replace(hardening="estimate").surface(FACES["roll wrap"], A)


# ---- states -------------------------------------------------------------------------------------


def test_the_response_does_not_depend_on_earlier_states() -> None:
    face, body = FACES["roll wrap"], roll()
    p, q = loads(face)
    first = body.surface(face, A).deform(p, q)
    for a, share in ((2 * A, 0.3), (0.5 * A, 2.0), (A * exp(1e-5), 1.0)):
        body.surface(face, a).deform(share * p, -q)
    body.surface(nip_mesh(25, Wrap(), WRAP).roll_face, A)
    again = body.surface(face, A).deform(p, q)
    assert deviation(again.slope, first.slope) < 1e-9
    assert deviation(again.strain, first.strain) < 1e-9


def test_the_ring_is_in_equilibrium_and_inside_its_law() -> None:
    face = FACES["nip"]
    p, q = loads(face)
    surface: Any = roll().surface(face, A)
    assert surface.residual(p, q) < 1e-8
    assert surface.range_message(p, q) == ""


def test_rounding_does_not_prevent_the_equilibrium_of_a_large_roll_under_a_light_load() -> None:
    """Nodal forces of elements of 0.2 um next to rows of 0.3 m are rounded to 1e-8 of this load."""
    law = HardeningLaw(Constant(youngs_modulus=4e6), 4e9, 0.1, 5e6)
    ring = ring_equilibrium.RingPair(0.54, 0.113, law, lambda r: 1e4 + 0 * r)
    mesh = ring.mesh(Fineness(33, 16, 16), 0.1e-3)
    face = nip_mesh(65, Wrap(), Wrap()).roll_face
    p = 1e5 * np.sqrt(1 - face.nodes**2)
    forces = np.stack([-(mesh.hat_forces(face.nodes * 0.1e-3) @ p), np.zeros(mesh.nodes.size)])
    state = ring.equilibrium(mesh, forces)
    unbalanced = -mesh.forces(state.stress_state.stress)
    unbalanced[mesh.topology.surface] += forces
    assert np.abs(unbalanced).max() > 1e-9 * np.abs(forces).sum()  # a residual that cannot vanish
    assert state.residual < ring_equilibrium.TOLERANCE


def test_a_torn_stack_is_reported() -> None:
    """A load that is large next to the wound pressure lifts the stack next to the contact."""
    face = FACES["nip"]
    p, _ = loads(face, 1e6)
    surface: Any = roll(K1=1e3, P0=0.5e3).surface(face, A)
    assert "torn" in surface.range_message(p, 0.2 * p)


# ---- the rings ----------------------------------------------------------------------------------


def test_a_ring_under_even_pressure_is_compressed_evenly() -> None:
    """Closed form: v = A (r/R)^m + B (r/R)^-m with m^2 = A_tt/A_rr, of both rings."""
    R, R0, p = 0.1, 0.0445, 1e4
    pair = constant_rings(27e6, 18e6)
    errors = []
    for rows in (12, 24):
        mesh = pair.mesh(Fineness(8, 8, rows), A)
        inward = mesh.hat_forces(np.linspace(-pi * R, pi * R, 400)).sum(axis=1)
        forces = np.stack([-p * inward, 0 * inward])
        state = pair.equilibrium(mesh, forces)
        for stiffness, moved in (
            (pair.law.stiffness(0.0), state.u[mesh.topology.surface][0]),
            (pair.stiffness, pair.linear(mesh, forces)[0]),
        ):
            A_rr, A_tt, A_rt, _ = stiffness
            m, t = np.sqrt(A_tt / A_rr), R0 / R
            # v = C ((r/R)^m - t^2m (r/R)^-m) is 0 at R0; -p = A_rr v' + A_rt v/R at R
            v = -p * R / (A_rr * m * (1 + t ** (2 * m)) / (1 - t ** (2 * m)) + A_rt)
            assert np.ptp(moved) < 1e-8 * abs(v)
            errors.append(abs(moved[0] / v - 1))
    assert max(errors[2:]) < 3e-5
    assert min(errors[:2]) > 8 * max(errors[2:])  # order 4


def test_a_ring_without_equilibrium_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ring_equilibrium, "MAX_ITERATIONS", 2)
    face = FACES["nip"]
    with pytest.raises(ring_equilibrium.NoEquilibrium, match="residual"):
        roll().surface(face, A).deform(*loads(face))


def test_the_linear_ring_has_no_rounding_errors_of_its_factors() -> None:
    """With factors of its own half width and of another one; the rounding of K is below 1e-13."""
    pair = constant_rings(27e6, 18e6)
    mesh, near = (pair.mesh(Fineness(16, 16, 24), a) for a in (A, 1.02 * A))
    x = np.linspace(-A, A, 33)
    hats = mesh.hat_forces(x) @ np.sqrt(np.maximum(A**2 - x**2, 0.0))
    f, forces = np.zeros(mesh.topology.size), np.stack([-hats, 0.2 * hats])
    f[mesh.topology.surface] = forces
    for reference in (mesh, near):
        pair._linear_factors(reference, 0.0)
        u = pair.linear_displacements(mesh, forces)
        left = f - mesh.forces(mesh.strain(u) @ pair._moduli)
        correction = pair._linear_factors(mesh, 0.0)[1].solve(left)
        assert np.max(np.abs(correction)) < 1e-13 * np.max(np.abs(u))


def test_a_linear_ring_that_is_not_solved_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    """Conjugate gradients that stop at once leave the displacements of the factors for 3 a.

    Those of the factors for a are exact up to rounding errors, and are accepted.
    """
    pair = constant_rings(27e6, 18e6)
    mesh, other = (pair.mesh(Fineness(8, 8, 12), a) for a in (A, 3 * A))
    x = np.linspace(-A, A, 33)
    hats = mesh.hat_forces(x) @ np.sqrt(np.maximum(A**2 - x**2, 0.0))
    forces = np.stack([-hats, 0 * hats])
    expected = pair.linear_displacements(mesh, forces)
    iterations = 0

    def stopped(K: Any, f: Any, guess: Any, **options: Any) -> tuple[Any, int]:
        nonlocal iterations
        iterations += 1
        return guess, 1

    monkeypatch.setattr(ring_equilibrium, "cg", stopped)
    u = pair.linear_displacements(mesh, forces)
    assert iterations == 1  # not repeated with the same factors
    assert np.max(np.abs(u - expected)) < 1e-9 * np.max(np.abs(expected))  # sqrt of TOLERANCE
    factors = pair._linear_factors(other, 0.0)
    monkeypatch.setattr(pair, "_linear_factors", lambda mesh, distance: factors)
    with pytest.raises(ring_equilibrium.NoEquilibrium, match="linear ring"):
        pair.linear_displacements(mesh, forces)
