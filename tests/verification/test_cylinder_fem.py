"""The cylinder's surface against finite elements (scikit-fem): two independent roads to one answer.

The elements know nothing of Fourier series, characteristic roots or the Riccati equation.  They
solve the plane problem in the coordinates (theta, r), where an orthotropic cylinder is a rectangle
and the material axes are straight: minimise

    int [A_rr e_r^2 + 2 A_rt e_r e_t + A_tt e_t^2 + G g^2]/2 r dr dtheta - int (q u - p v) R dtheta
    e_r = v_r,   e_t = (v + u_theta)/r,   g = v_theta/r + u_r - u/r,     u = v = 0 at the core

with v outward and u along theta.  Layers have their own moduli; an open bore has neither tractions
nor, on average, displacements as a whole, which multipliers hold.  A patch |theta| < beta carries a
pressure or a traction of the shape cos^2; by symmetry half the circle is enough.  Biquadratic
elements converge in L2 with the third power of the element size for displacements and the second
for strains.
"""

from __future__ import annotations

from math import log, log2, pi
from typing import Any, NamedTuple

import numpy as np
import pytest
from scipy import sparse
from scipy.integrate import quad
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad2,
    ElementVector,
    FacetBasis,
    LinearForm,
    MeshQuad,
    condense,
    solve,
)
from skfem.helpers import grad

from woundon.elasticity.cylinder import surface_kernels
from woundon.elasticity.kernels import Kernel
from woundon.elasticity.layers import stacked_compliance

Array = np.ndarray

R, R0 = 1.0, 0.5
STIFFNESS = (2.0, 9.0, 1.0, 1.5)  # A_rr, A_tt, A_rt, G: moderately anisotropic
BETA = 0.3
LINES = R - (R - R0) * np.linspace(1, 0, 5) ** 1.5  # radii between elements


class Tube(NamedTuple):
    """Layers, outermost first: their inner radii, on lines between elements, and stiffness."""

    inner: tuple[float, ...]
    stiffness: tuple[tuple[float, float, float, float], ...]
    free: bool

    def moduli(self, r: Array) -> list[Array]:
        """Return A_rr, A_tt, A_rt, G at radii."""
        where = [r > inner for inner in self.inner]
        return [np.select(where, values) for values in zip(*self.stiffness, strict=True)]

    def compliance(self, n: Array) -> Array:
        """Return R Y_n by the program."""
        radii = (R, *self.inner)
        layers = (
            (log(outer / inner), *stiffness)
            for outer, inner, stiffness in zip(radii, self.inner, self.stiffness, strict=False)
        )
        return R * stacked_compliance(n, tuple(layers), self.free)


TUBES = {
    "one layer": Tube((R0,), (STIFFNESS,), False),
    "two layers, open bore": Tube((float(LINES[3]), R0), (STIFFNESS, (12.0, 8.0, 3.0, 5.0)), True),
}
tubes = pytest.mark.parametrize("tube", TUBES.values(), ids=TUBES)


class Zeroth(NamedTuple):
    """Compliances of a constant pressure and a constant traction around."""

    gamma_1: float
    chi_2: float


class Surface(NamedTuple):
    """Displacements and strain of the surface at the angles theta."""

    v: Array
    u: Array
    strain: Array


def patch(theta: Array) -> Array:
    """Return the load's shape, cos^2 on |theta| < beta; its slope is continuous."""
    return np.where(np.abs(theta) < BETA, np.cos(pi * theta / (2 * BETA)) ** 2, 0.0)


def patch_harmonics(n: Array) -> Array:
    """Return the cosine coefficients (thesis eq. 51) of the patch, n >= 1."""
    w = pi / BETA
    return np.sin(n * BETA) / pi * (1 / n - 0.5 / (n + w) - 0.5 / (n - w))


def series(load: str, theta: Array, tube: Tube = TUBES["one layer"]) -> Surface:
    """Return the surface by the program's sequences (thesis eq. 59)."""
    # coefficients fall as n^-3 and the sequences as 1/n: beyond 1500 the strain has 1e-7 left
    n = np.arange(1, 1501)
    c, c0 = patch_harmonics(n), BETA / (2 * pi)
    (gamma_1, gamma_2), (chi_1, chi_2) = (
        tube.compliance(n) * np.array([[1, -1], [-1, 1]])[..., None]
    )
    zero = Zeroth(*np.diag(tube.compliance(np.array(0))))
    cos, sin = np.cos(np.outer(theta, n)), np.sin(np.outer(theta, n))
    if load == "pressure":
        v = -zero.gamma_1 * c0 - cos @ (gamma_1 * c)
        return Surface(v, sin @ (chi_1 * c), (v + cos @ (n * chi_1 * c)) / R)
    v = sin @ (gamma_2 * c)
    return Surface(v, zero.chi_2 * c0 + cos @ (chi_2 * c), (v - sin @ (n * chi_2 * c)) / R)


def energy_density(u: Any, w: Any, x: Any, tube: Tube) -> Any:
    """Twice the elastic energy's density; component 0 is v, 1 is u; x = (theta, r)."""
    r = x.x[1]
    A_rr, A_tt, A_rt, G = tube.moduli(r)

    def strains(a: Any) -> tuple[Any, Any, Any]:
        d = grad(a)
        return d[0][1], (a[0] + d[1][0]) / r, d[0][0] / r + d[1][1] - a[1] / r

    e_r, e_t, g = strains(u)
    f_r, f_t, h = strains(w)
    return r * (A_rr * e_r * f_r + A_rt * (e_r * f_t + e_t * f_r) + A_tt * e_t * f_t + G * g * h)


def mesh(level: int) -> MeshQuad:
    """Return a tensor grid of [0, pi] x [R0, R], finer at the patch, halved ``level`` times."""
    theta = np.concatenate(
        (
            np.linspace(0, BETA, 4),
            np.linspace(BETA, 3 * BETA, 5)[1:],
            np.linspace(3 * BETA, pi, 6)[1:],
        )
    )
    r = LINES
    for _ in range(level):
        theta, r = (np.sort(np.append(s, (s[1:] + s[:-1]) / 2)) for s in (theta, r))
    return MeshQuad.init_tensor(theta, r)


def finite_elements(load: str, level: int, tube: Tube) -> tuple[FacetBasis, Array]:
    """Return the surface's facet basis and the solved displacements."""
    basis = Basis(mesh(level), ElementVector(ElementQuad2()), intorder=5)

    def side(at: float) -> FacetBasis:
        facets = basis.mesh.facets_satisfying(lambda x: np.abs(x[1] - at) < 1e-9)
        return FacetBasis(basis.mesh, basis.elem, facets=facets, intorder=9)

    surface = side(R)

    @LinearForm
    def work(w: Any, x: Any) -> Any:
        return patch(x.x[0]) * R * (-w[0] if load == "pressure" else w[1])

    stiffness = BilinearForm(lambda u, w, x: energy_density(u, w, x, tube)).assemble(basis)
    forces = work.assemble(surface)
    # pressure is even in theta: u = 0 on the axis; traction along theta: v = 0 there
    odd = "u^2" if load == "pressure" else "u^1"
    fixed = basis.get_dofs(lambda x: (x[0] < 1e-9) | (x[0] > pi - 1e-9)).all([odd])
    if not tube.free:
        core = basis.get_dofs(lambda x: x[1] < R0 + 1e-9).all()
        return surface, solve(*condense(stiffness, forces, D=np.union1d(core, fixed)))
    # a shift along the axis; or one across it, and a turn
    motions = {
        "pressure": [lambda w, x: w[0] * np.cos(x.x[0]) - w[1] * np.sin(x.x[0])],
        "traction": [lambda w, x: w[0] * np.sin(x.x[0]) + w[1] * np.cos(x.x[0]), lambda w, x: w[1]],
    }[load]
    held = sparse.csr_matrix([LinearForm(motion).assemble(side(R0)) for motion in motions])
    whole = sparse.bmat([[stiffness, held.T], [held, None]]).tocsr()
    right = np.append(forces, np.zeros(len(motions)))
    return surface, solve(*condense(whole, right, D=fixed))[: forces.size]


def errors(load: str, level: int, tube: Tube) -> Array:
    """Return the relative L2 errors on the surface of v, u and the strain."""
    basis, solution = finite_elements(load, level, tube)
    field = basis.interpolate(solution)
    found = Surface(field[0], field[1], (field[0] + grad(field)[1][0]) / R)
    theta = basis.global_coordinates()[0]
    exact = [e.reshape(theta.shape) for e in series(load, theta.ravel(), tube)]
    return np.array(
        [
            np.sqrt(((f - e) ** 2 * basis.dx).sum() / (e**2 * basis.dx).sum())
            for f, e in zip(found, exact, strict=True)
        ]
    )


@pytest.mark.slow
@pytest.mark.parametrize("load", ["pressure", "traction"])
@tubes
def test_elements_converge_to_the_series(load: str, tube: Tube) -> None:
    """Halving the elements divides displacement errors by 8 and strain errors by 4."""
    coarse, middle, fine = (errors(load, level, tube) for level in (1, 2, 3))
    # what the order leaves on this mesh: measured 5e-6 to 1.7e-5 and 6e-4
    assert np.all(fine[:2] < 3e-5)
    assert fine[2] < 1e-3
    for quantity, order in zip(range(3), (3, 3, 2), strict=True):
        last = log2(middle[quantity] / fine[quantity])
        # the measured orders, 2.95 to 3.22 (a tube's bending, at first) and 1.92 to 1.95, still
        # approach theirs
        assert order - 0.12 < last < order + 0.3, (quantity, coarse, middle, fine)


def convolved(kernel: Kernel, at: float) -> float:
    """Integrate a kernel against the patch at the angle ``at`` by adaptive quadrature."""
    smooth = kernel.smooth
    assert smooth is not None

    def shape(s: float) -> float:
        return float(patch(np.array(s / R)))

    def near(t: float) -> float:
        return kernel.sign * np.sign(t) + float(smooth(np.array(t)))

    x, edge, total = at * R, BETA * R, kernel.delta * shape(at * R)
    if abs(x) < edge:
        # the Cauchy weight is 1/(s - x), the kernel's 1/(x - s)
        total -= kernel.inverse * quad(shape, -edge, edge, weight="cauchy", wvar=x)[0]
        for a, b, end in ((-edge, x, "alg-logb"), (x, edge, "alg-loga")):
            total += quad(lambda s: shape(s) * near(x - s), a, b)[0]
            total += kernel.log * quad(shape, a, b, weight=end, wvar=(0.0, 0.0))[0]
        return total
    return (
        total
        + quad(
            lambda s: (
                shape(s)
                * (kernel.inverse / (x - s) + kernel.log * np.log(abs(x - s)) + near(x - s))
            ),
            -edge,
            edge,
        )[0]
    )


@pytest.mark.parametrize("at", [0.0, 0.17, -0.25, 0.8, pi / 2])
def test_kernels_convolve_to_the_series(at: float) -> None:
    """The kernels in closed and tabulated form, integrated over the patch, give the same surface.

    Under the patch, next to it and a quarter turn away.
    """
    k = surface_kernels(R, R0, *STIFFNESS)
    for load, suffix in (("pressure", "p"), ("traction", "q")):
        exact = series(load, np.array([at]))
        for name, value in (("normal", exact.v), ("tangent", exact.u), ("strain", exact.strain)):
            found = convolved(getattr(k, f"{name}_{suffix}"), at)
            # the series' truncation; quadrature and tables are below 1e-9
            assert found == pytest.approx(float(value[0]), abs=2e-8), (name, load)
