"""Stresses below the surface of a roll, against closed forms, equilibrium and finite elements."""

from __future__ import annotations

from math import log, pi

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from thesis_cases import newsprint_nip

import woundon as wo
from woundon.elasticity.hardening import HardeningLaw
from woundon.elasticity.interior_stress import (
    _HalfPlaneRoots,
    _Interpolation,
    _sampled_harmonics,
    cylinder_sections,
    half_plane_sections,
    traction_harmonics,
)
from woundon.elasticity.layers import traction_transfers
from woundon.elasticity.ring_elements import Fineness
from woundon.elasticity.ring_equilibrium import RingPair
from woundon.nip.layer_slip import interior_stress

NEWSPRINT = tuple(wo.material("newsprint").stiffness[:4])
ISOTROPIC = tuple(wo.Isotropic(youngs_modulus=10e6, poissons_ratio=0.3).stiffness[:4])
# roots of thesis eq. (43) that are real and apart, equal, and complex
MATERIALS = {
    "newsprint": NEWSPRINT,
    "isotropic": ISOTROPIC,
    "complex roots": (30e6, 30e6, 9e6, 40e6),
}
R, A, PEAK = 0.1, 2.5e-3, 1e6


def hertz(nodes: int = 401) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes graded towards the edges and Hertz's pressure with the peak 1 MPa."""
    x = -A * np.cos(np.linspace(0, pi, nodes))
    return x, PEAK * np.sqrt(np.maximum(1 - (x / A) ** 2, 0.0))


def bump(nodes: int = 201) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return nodes, a pressure and a traction without symmetry."""
    x = np.linspace(-A, A, nodes)
    t = x / A
    return x, PEAK * (1 - t**2) * (1 + 0.4 * t), 0.2 * PEAK * (1 - t**2) * (t + 0.3)


def test_harmonics_between_the_sampled_ones():
    """B of a cylinder at all harmonics against those interpolated in ln n, of the largest B."""
    y = 0.01
    layers = (y, *NEWSPRINT), (log(2) - y, *NEWSPRINT)
    n = np.arange(3000)
    sampled = _sampled_harmonics(n.size - 1)
    assert sampled.size < n.size / 10
    half_plane = _HalfPlaneRoots.of(layers[0][1:]).transfer(n * y)
    (cylinder,) = traction_transfers(n, layers)
    difference = cylinder - half_plane
    found = _Interpolation(sampled).values(difference[:, :, sampled], n.size - 1)
    # six points with a spacing of 6 % of n: 1e-10 measured
    assert np.abs(found - difference).max() < 1e-9 * np.abs(cylinder).max()
    np.testing.assert_array_equal(found[:, :, sampled], difference[:, :, sampled])


def test_the_harmonics_are_integrals_of_the_piecewise_linear_function():
    # Closed form: cell by cell with Gauss's rule; a jump at one end, zero at the other
    x, f = np.array([-2.0, -0.5, 0.1, 1.5]) * 1e-3, np.array([0.0, 3.0, -1.0, 2.0])
    found = traction_harmonics(x, f, 2 * pi * R, 3000)
    points, weights = np.polynomial.legendre.leggauss(80)
    half = np.diff(x)[:, None] / 2
    at = x[:-1, None] + half * (1 + points)
    for n in (0, 1, 7, 100, 3000):
        wave = np.exp(-1j * n / R * at)
        exact = np.sum(half * weights * np.interp(at, x, f) * wave)
        assert found[n] == pytest.approx(exact, abs=1e-12)


def test_hertz_contact_has_its_largest_orthogonal_shear_at_half_the_half_width():
    # Johnson, Contact Mechanics, sec. 4.2: 0.2500 p0 at z = 0.5 a, |x| = 0.866 a
    x, p = hertz()
    depths = A * np.linspace(0.3, 0.7, 41)
    sections = half_plane_sections(x, p, 0 * p, depths, R, ISOTROPIC)
    largest = [np.abs(s.shear).max() for s in sections]
    deepest = sections[int(np.argmax(largest))]
    assert max(largest) == pytest.approx(0.25 * PEAK, rel=2e-4)
    assert deepest.depth == pytest.approx(0.5 * A, rel=0.03)
    assert abs(deepest.x[np.argmax(np.abs(deepest.shear))]) == pytest.approx(0.866 * A, rel=0.01)


@pytest.mark.parametrize("depth", [0.02, 0.1, 0.5, 2.0, 10.0])
def test_hertz_contact_everywhere(depth):
    # McEwen's closed form (Johnson, eqs. 4.49); tau here acts on the inside along +x
    x, p = hertz(801)
    (s,) = half_plane_sections(x, p, 0 * p, np.array([depth * A]), R, ISOTROPIC)
    z, own = s.depth, np.abs(s.x) < 20 * A
    b = A**2 - s.x**2 + z**2
    root = np.hypot(b, 2 * s.x * z)
    m, n = np.sqrt((root + b) / 2), np.sign(s.x) * np.sqrt((root - b) / 2)
    normal = -PEAK / A * m * (1 - (z**2 + n**2) / (m**2 + n**2))
    shear = PEAK / A * n * (m**2 - z**2) / (m**2 + n**2)
    assert s.normal[own] == pytest.approx(normal[own], abs=5e-4 * PEAK)
    assert s.shear[own] == pytest.approx(shear[own], abs=5e-4 * PEAK)


@pytest.mark.parametrize("material", MATERIALS)
def test_a_line_load_gives_the_radial_field_of_an_orthotropic_half_plane(material):
    # Lekhnitskii's closed form, of a hat as narrow as a hundredth of the depth
    stiffness, z = MATERIALS[material], 2e-3
    A_rr, A_tt, A_rt, G = stiffness
    det = A_rr * A_tt - A_rt**2
    product = np.sqrt(A_tt / A_rr)
    total = np.sqrt((1 / G - 2 * A_rt / det) * det / A_rr + 2 * product)
    x, hat = np.array([-1, 0, 1]) * 1e-2 * z, np.array([0.0, 1.0, 0.0]) / (1e-2 * z)
    (p,) = half_plane_sections(x, hat, 0 * hat, np.array([z]), R, stiffness)
    (q,) = half_plane_sections(x, 1e-9 * hat, hat, np.array([z]), R, stiffness)
    own = np.abs(p.x) < 20 * z
    t = p.x[own]
    N = t**4 + (total**2 - 2 * product) * t**2 * z**2 + product**2 * z**4
    by_p, by_q = product * total / pi * z**2 / N, total / pi * z * t / N
    scale = by_p.max() * z
    assert p.normal[own] == pytest.approx(-by_p * z, abs=2e-3 * scale)
    assert p.shear[own] == pytest.approx(by_p * t, abs=2e-3 * scale)
    scale = np.abs(by_q * t).max()
    assert q.normal[own] == pytest.approx(-by_q * z, abs=3e-3 * scale)
    assert q.shear[own] == pytest.approx(by_q * t, abs=3e-3 * scale)


@pytest.mark.parametrize("material", MATERIALS)
def test_every_section_of_a_half_plane_carries_the_load(material):
    # Equilibrium; what is beyond x = +- pi R is about z/R of the load on a radius of 100 a
    x, p, q = bump()
    sections = half_plane_sections(x, p, q, A * np.array([0.1, 1.0, 3.0]), R, MATERIALS[material])
    for s in sections:
        step = s.x[1] - s.x[0]
        assert step * s.normal.sum() == pytest.approx(-np.trapezoid(p, x), rel=2e-3)
        assert step * s.shear.sum() == pytest.approx(np.trapezoid(q, x), rel=0.2 * s.depth / A)


def resultants(x, normal, shear, radius):
    """Return the force across and along, and the torque, of stresses on a circle, per width."""
    theta, arc = x / R, x * radius / R
    across = np.trapezoid(normal * np.cos(theta) - shear * np.sin(theta), arc)
    along = np.trapezoid(normal * np.sin(theta) + shear * np.cos(theta), arc)
    return across, along, radius * np.trapezoid(shear, arc)


@pytest.mark.parametrize("material", MATERIALS)
@pytest.mark.parametrize("layers", [1, 2])
def test_every_circle_of_a_cylinder_carries_force_and_torque(material, layers):
    # Equilibrium
    x, p, q = bump()
    given = resultants(x, -p, q, R)
    stack = ((log(2) / layers, *MATERIALS[material]),) * layers
    for s in cylinder_sections(x, p, q, A * np.array([0.1, 1.0, 15.0]), R, stack):
        # the circle is closed
        found = resultants(
            np.append(s.x, -s.x[0]), *(np.append(f, f[0]) for f in (s.normal, s.shear)),
            R - s.depth,
        )  # fmt: skip
        assert found == pytest.approx(given, rel=1e-5)


def test_a_cylinder_cut_into_layers_of_one_material_is_the_same():
    # Invariance.  The harmonics whose difference from the half-plane is neglected are 1e-5
    x, p, q = bump()
    depths = A * np.array([0.05, 0.4, 1.0, 3.0])
    whole = cylinder_sections(x, p, q, depths, R, ((log(2), *NEWSPRINT),))
    cut = cylinder_sections(x, p, q, depths, R, tuple((f * log(2), *NEWSPRINT) for f in (0.1, 0.9)))
    for one, other in zip(whole, cut, strict=True):
        assert one.shear == pytest.approx(other.shear, abs=1e-4 * PEAK)
        assert one.normal == pytest.approx(other.normal, abs=1e-4 * PEAK)


def test_a_large_cylinder_is_a_half_plane():
    # Limit: the difference falls as a/R
    x, p, q = bump()
    depths, differences = A * np.array([0.5, 1.0]), []
    for radius in (0.5, 2.5):
        flat = half_plane_sections(x, p, q, depths, radius, ISOTROPIC)
        round_ = cylinder_sections(x, p, q, depths, radius, ((log(2), *ISOTROPIC),))
        differences.append(max(
            np.abs(c.shear - CubicSpline(f.x, f.shear)(c.x)).max()
            for c, f in zip(round_, flat, strict=True)
        ))  # fmt: skip
    assert differences[0] < 5e-3 * PEAK
    assert differences[1] < 0.3 * differences[0]


def test_a_uniform_pressure_gives_lames_stresses():
    # Closed form: u = a r + b/r, held at the core; sigma_r = s a - 2 G b/r^2, s = A_rr + A_rt
    core, r = 0.04, 0.07
    A_rr, _, A_rt, G = ISOTROPIC
    a = 1 / ((A_rr + A_rt) + 2 * G * core**2 / R**2)
    sigma = (A_rr + A_rt) * a + 2 * G * a * core**2 / r**2
    layers = (log(R / r), *ISOTROPIC), (log(r / core), *ISOTROPIC)
    B = traction_transfers(np.zeros(1), layers)[0, :, :, 0]
    assert B[0, 0] * R / r == pytest.approx(sigma, rel=1e-12)
    # torsion: r^2 tau is the same on every circle
    assert B[1, 1] == pytest.approx(R / r, rel=1e-12)
    assert B[[0, 1], [1, 0]] == pytest.approx([0, 0])


def test_finite_elements_of_a_linear_cylinder():
    # Independent method: quadratic elements, at their quadrature points below the nip
    nip = wo.solve(newsprint_nip(), nodes=65)
    x, p, q, a = nip.x, nip.roll_pressure, nip.roll_traction, nip.half_width
    A_rr, A_tt, A_rt, G = NEWSPRINT
    nu = A_rt / A_rr
    law = HardeningLaw(
        wo.Stack(
            radial=A_rr - A_rt**2 / A_tt, tangential=A_tt - A_rt**2 / A_rr,
            poissons_ratio=nu * (1 - A_rt**2 / A_rr / A_tt), shear=G,
        ).radial,
        A_tt - A_rt**2 / A_rr, nu, G,
    )  # fmt: skip
    ring = RingPair(0.1, 0.0445, law, np.zeros_like)
    mesh = ring.mesh(Fineness(32, 16, 24), a)
    hats = mesh.hat_forces(x)
    u = ring.linear_displacements(mesh, np.stack([-hats @ p, hats @ q]))
    rr, tt, rt, shear = ring.stiffness
    moduli = np.array([[rr, rt, 0], [rt, tt, 0], [0, 0, shear]])
    stress = mesh.strain(u) @ moduli
    grid_x, grid_r = mesh.quadrature_grid
    own, rows = np.abs(grid_x) < 2 * a, np.nonzero((grid_r < 0.0999) & (grid_r > 0.09))[0][::4]
    layers = ((log(0.1 / 0.0445), *ring.stiffness),)
    sections = cylinder_sections(x, p, q, 0.1 - grid_r[rows], 0.1, layers)
    for row, s in zip(rows, sections, strict=True):
        for k, found in ((0, s.normal), (2, s.shear)):
            elements = mesh.on_quadrature_grid(stress[..., k])[row, own]
            exact = np.interp(grid_x[own], s.x, found)
            assert elements == pytest.approx(exact, abs=0.01 * p.max())


@pytest.mark.slow
def test_a_hardening_roll_without_hardening_is_a_cylinder():
    # Limit: a constant modulus through the stack
    stack = wo.Stack(radial=38e6, tangential=3.38e9, poissons_ratio=0.01, shear=10e6)
    roll = wo.WoundRoll(radius=0.1, core_radius=0.0445, stack=stack, pressure=2e5)
    nip = wo.solve(newsprint_nip(roll=roll), nodes=33)
    z = np.array([1e-4, 1e-3, 1e-2])
    direct = interior_stress(nip, z)
    linear = cylinder_sections(
        nip.x, nip.roll_pressure, nip.roll_traction, z, 0.1,
        ((log(0.1 / 0.0445), *stack.tangent(2e5, 2e5)[:4]),),
    )  # fmt: skip
    for one, other in zip(direct, linear, strict=True):
        assert one.shear == pytest.approx(other.shear, abs=1e-6 * nip.peak_pressure)
        assert one.normal == pytest.approx(other.normal, abs=1e-6 * nip.peak_pressure)


def hardening_nip(nodes: int) -> wo.NipResult:
    stack = wo.Stack(
        radial=wo.Pfeiffer(K1=1e5, K2=127.0), tangential=3.38e9, poissons_ratio=0.01, shear=10e6
    )
    roll = wo.WoundRoll(radius=0.1, core_radius=0.0445, stack=stack, pressure=2e5)
    return wo.solve(newsprint_nip(roll=roll), nodes=nodes)


@pytest.mark.slow
def test_every_circle_of_a_hardening_roll_carries_force_and_torque():
    # Equilibrium, of stresses interpolated between quadrature points
    nip = hardening_nip(65)
    given = resultants(nip.x, -nip.roll_pressure, nip.roll_traction, R)
    for s in interior_stress(nip, np.array([1e-4, 5e-4, 2e-3, 1e-2])):
        assert resultants(s.x, s.normal, s.shear, R - s.depth) == pytest.approx(given, rel=5e-3)


@pytest.mark.slow
def test_the_stresses_of_a_hardening_roll_converge():
    # Convergence of the largest shear: finite elements follow the mesh of the nip
    z = 66e-6 * np.array([1, 4, 16, 60])
    coarse, fine = (
        [np.abs(s.shear).max() for s in interior_stress(hardening_nip(nodes), z)]
        for nodes in (33, 129)
    )
    assert coarse == pytest.approx(fine, rel=0.025)
