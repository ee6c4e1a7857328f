"""Cylinders of layers against finite elements, published digits of another program, and limits.

The elements are of high order in the radius, one set for each harmonic: they minimise

    int [A_rr e_r^2 + 2 A_rt e_r e_t + A_tt e_t^2 + G g^2] r dr/2 - S U(R) - T V(R)
    e_r = U',   e_t = (U + n V)/r,   g = V' - (V + n U)/r

and know nothing of exponentials, doubling or star products.
"""

from __future__ import annotations

import itertools
from math import log
from typing import Any

import numpy as np
import pytest
from derivatives import check_sensitivity
from elastic_cases import Stiffness, isotropic
from numpy.polynomial import legendre
from scipy.linalg import lu_factor, lu_solve

import woundon as wo
from woundon.elasticity.cylinder import asymptotic_compliance, layered_kernels, surface_kernels
from woundon.elasticity.layers import Layers, stacked_compliance

Array = np.ndarray
ORDER = 16


STEEL, SOFT, HARD = isotropic(206e9, 0.3), isotropic(10e6, 0.49), isotropic(60e6, 0.45)
PAPER: Stiffness = (20e6, 3e9, 5e6, 10e6)
FELT: Stiffness = (2e6, 30e6, 1e6, 5e6)

# radius, (thickness, stiffness) outermost first
BODIES: dict[str, tuple[float, list[tuple[float, Stiffness]]]] = {
    "three-layer drum": (0.24, [(0.015, SOFT), (0.005, HARD), (0.02, STEEL)]),
    "hard on soft on hard": (0.24, [(0.001, STEEL), (0.015, SOFT), (0.02, HARD)]),
    "paper on a core shell": (0.3, [(0.25, PAPER), (0.01, isotropic(3e9, 0.3))]),
    "orthotropic layers": (0.2, [(0.01, FELT), (0.03, PAPER), (0.05, FELT)]),
    "thin layers": (0.2, [(1e-5, HARD), (2e-3, SOFT), (1e-6, FELT), (0.02, STEEL)]),
    "incompressible layers": (0.2, [(0.01, isotropic(1e6, 0.4999)), (0.03, isotropic(1e7, 0.49))]),
    "one layer": (0.2, [(0.05, HARD)]),
}
bodies = pytest.mark.parametrize("body", BODIES.values(), ids=BODIES)


def stacked(R: float, layers: list[tuple[float, Stiffness]]) -> Layers:
    """Return the layers as the program takes them."""
    made, outside = [], R
    for thickness, stiffness in layers:
        made.append((-np.log1p(-thickness / outside), *stiffness))
        outside -= thickness
    return tuple(made)


def cells(R: float, layers: list[tuple[float, Stiffness]], n: float) -> list[Any]:
    """Return elements (inner radius, height, stiffness), from the core, finer near the surface.

    What lies deeper than forty waves is not felt.
    """
    depths = np.cumsum([0.0] + [h for h, _ in layers])
    depth = min(depths[-1], 120 * R / max(n, 1))
    cuts = [min(R / max(n, 1), depth / 8) / 2]
    while cuts[-1] < depth:  # no element is higher than half the radius below it
        cuts.append(min(2 * cuts[-1], cuts[-1] + (R - cuts[-1]) / 3))
    marks = np.unique(np.concatenate([depths, cuts]))
    marks = marks[marks <= max(depth, marks[1])]
    found = []
    for top, bottom in itertools.pairwise(marks):
        k = int(np.searchsorted(depths, (top + bottom) / 2)) - 1
        found.append((R - bottom, bottom - top, layers[k][1]))
    return found[::-1]


def stiffness_matrix(elements: list[Any], n: float) -> Array:
    """Return the elements' matrix in extended precision; rows 2 i and 2 i + 1 for U and V."""
    x, w = (np.asarray(part, dtype=np.longdouble) for part in legendre.leggauss(ORDER + 4))
    # integrated Legendre polynomials between two linear functions
    modes = [np.array([0.5, -0.5]), np.array([0.5, 0.5])]
    modes += [legendre.legint(np.eye(k + 1)[k], lbnd=-1) for k in range(1, ORDER)]
    shape = np.array([legendre.legval(x, c) for c in modes])
    slope = np.array([legendre.legval(x, legendre.legder(c)) for c in modes])
    per = len(modes) - 1
    size = 2 * (per * len(elements) + 1)
    K = np.zeros((size, size), dtype=np.longdouble)
    for e, (inner, h, (A_rr, A_tt, A_rt, G)) in enumerate(elements):
        r = inner + h * (x + 1) / 2
        N, D, zero = shape, slope * 2 / h, np.zeros_like(shape)
        weight = w * r * h / 2
        e_r, e_t = np.concatenate([D, zero]), np.concatenate([N / r, n * N / r])
        g = np.concatenate([-n * N / r, D - N / r])
        k = (e_r * weight) @ (A_rr * e_r + A_rt * e_t).T
        k += (e_t * weight) @ (A_tt * e_t + A_rt * e_r).T + (g * weight) @ (G * g).T
        nodes = [per * e, per * (e + 1), *range(per * e + 1, per * (e + 1))]
        dofs = np.array([2 * i for i in nodes] + [2 * i + 1 for i in nodes])
        K[np.ix_(dofs, dofs)] += k
    last = 2 * per * len(elements)  # the surface's rows come last
    order = np.concatenate([np.delete(np.arange(size), [last, last + 1]), [last, last + 1]])
    return K[np.ix_(order, order)]


def finite_elements(R: float, layers: list[Any], n: float, free: bool) -> Array:
    """Return Y_n of the surface by elements of high order in the radius."""
    K = stiffness_matrix(cells(R, layers, n), n)
    loads = np.eye(len(K))[:, -2:]
    if not free:
        K, loads = K[2:, 2:], loads[2:]
    elif n < 2:  # no rigid turn (n = 0), no shift on average (n = 1): U = V on the bore
        K[0] += (n == 1) * K[1]
        K[:, 0] += (n == 1) * K[:, 1]
        kept = np.delete(np.arange(len(K)), 1)
        K, loads = K[np.ix_(kept, kept)], loads[kept]
    scale = 1 / np.sqrt(np.diag(K))
    K *= np.outer(scale, scale)
    loads = loads * scale[:, None]
    factor = lu_factor(K.astype(float))
    Y = np.zeros(loads.shape, dtype=np.longdouble)
    for _ in range(8):  # refined to extended precision
        Y += lu_solve(factor, (loads - K @ Y).astype(float))
    return np.array(loads.T @ Y, dtype=float)


def difference(found: Array, expected: Array) -> float:
    """Return the largest difference of entries relative to the largest entry."""
    return float(np.max(np.abs(found - expected)) / np.max(np.abs(expected)))


@pytest.mark.parametrize("free", [False, True], ids=["rigid core", "open bore"])
@bodies
def test_finite_elements(body: Any, free: bool) -> None:
    R, layers = body
    for n in (0, 1, 2, 3, 7, 30, 200, 3000, 1e5):
        expected = finite_elements(R, layers, n, free)
        found = stacked_compliance(np.array([n]), stacked(R, layers), free)[..., 0]
        assert difference(found, expected) < 1e-10, n


def test_values_of_another_program() -> None:
    """A steel shell under two rubbers, 8 digits each, computed elsewhere; n C_11 in 1/Pa."""
    n = np.array([2, 10, 300])
    layers = (
        (log(0.24 / 0.225), *SOFT), (log(0.225 / 0.22), *HARD),
        (log(0.22 / 0.20), *isotropic(206e9, 0.3)),
    )  # fmt: skip
    computed = [1.11005143e-9, 2.05737028e-8, 1.51971755e-7]
    np.testing.assert_allclose(n * stacked_compliance(n, layers)[0, 0], computed, rtol=5e-9)


@pytest.mark.parametrize("free", [False, True], ids=["rigid core", "open bore"])
@bodies
def test_splitting_layers_changes_nothing(body: Any, free: bool) -> None:
    R, layers = body
    n = np.concatenate([np.arange(40), np.geomspace(40, 1e5, 30).round()])
    whole = stacked_compliance(n, stacked(R, layers), free)
    pieces = [
        (h * share, stiffness) for h, stiffness in layers for share in (0.1, 0.45, *[0.05] * 7, 0.1)
    ]
    parts = stacked_compliance(n, stacked(R, pieces), free)
    size = np.max(np.abs(whole), axis=(0, 1))
    # rounding of the radii between: 1e-16 R of a layer of 1e-6 m
    assert np.max(np.abs(parts - whole) / size) < 1e-12 + 1e-15 * R / min(h for h, _ in pieces)


@bodies
def test_the_response_is_symmetric_and_positive(body: Any) -> None:
    R, layers = body
    n = np.concatenate([np.arange(200), np.geomspace(200, 1e5, 30)])
    for free in (False, True):
        Y = np.moveaxis(stacked_compliance(n, stacked(R, layers), free), -1, 0)
        size = np.abs(Y).max(axis=(1, 2), keepdims=True)
        assert np.max(np.abs(Y - Y.swapaxes(1, 2)) / size) < 1e-10  # Betti
        assert np.all(np.linalg.eigvalsh((Y + Y.swapaxes(1, 2)) / size) > 0)
    rigid = np.moveaxis(stacked_compliance(n[2:], stacked(R, layers)), -1, 0)
    # a bore that gives way makes every harmonic softer, or equally soft
    softer = np.linalg.eigvalsh((Y[2:] - rigid) / size[2:])
    assert np.all(softer > -1e-12)


@bodies
def test_short_waves_feel_the_outermost_layer_alone(body: Any) -> None:
    R, layers = body
    thickness, stiffness = layers[0]
    n = 40 * R / thickness
    tail = asymptotic_compliance(6, *stiffness)
    powers = sum(a / n**j for j, a in enumerate(tail))
    found = stacked_compliance(np.array([n]), stacked(R, layers))[..., 0]
    assert difference(found, powers) < 1e-10


def test_an_open_bore_turns_and_shifts_with_nothing() -> None:
    """Torsion of a ring held at its bore: u = T (1/R0^2 - 1/R^2) R/(2 G) by hand."""
    R, R0, (_, _, _, G) = 0.2, 0.15, HARD
    Y = stacked_compliance(np.array([0, 1]), ((log(R / R0), *HARD),), True)
    # t = R tau; torque 2 pi R^2 tau
    assert Y[1, 1, 0] == pytest.approx(R**2 * (1 / R0**2 - 1 / R**2) / (2 * G), rel=1e-13)
    # Lame: a ring under outer pressure with a free bore, plane strain
    E, nu = 60e6, 0.45
    lame = (1 + nu) / E * ((1 - 2 * nu) * R**2 + R0**2) / (R**2 - R0**2)
    assert Y[0, 0, 0] == pytest.approx(lame, rel=1e-12)


# ---- kernels ------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["three-layer drum", "hard on soft on hard"])
def test_interpolated_harmonics_are_the_computed_ones(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    from woundon.elasticity import cylinder

    R, layers = BODIES[name]
    made = stacked(R, layers)
    N = 6000
    exact = stacked_compliance(np.arange(N + 1.0), made)
    found = cylinder._interpolated_compliance(N, made, open_bore=False, moduli=None)
    n = np.arange(N + 1)
    assert np.max(np.abs((found - exact) * n)) < 1e-13 * np.max(np.abs(exact * n))
    asked: list[int] = []

    def counted(at: Array, *rest: Any) -> Array:
        asked.append(np.size(at))
        return stacked_compliance(at, *rest)

    monkeypatch.setattr(cylinder, "stacked_compliance", counted)
    cylinder._interpolated_compliance(N, made, open_bore=False, moduli=None)
    assert sum(asked) < N / 8


def test_equal_layers_have_the_kernels_of_one() -> None:
    depth = log(0.24 / 0.225)
    one = surface_kernels(0.24, 0.225, *SOFT)
    many = layered_kernels(0.24, ((depth / 500, *SOFT),) * 500)
    t = np.geomspace(1e-4, 0.7, 60)
    for name in ("slope_p", "slope_q", "strain_p", "strain_q", "normal_p", "tangent_q"):
        a, b = getattr(one, name), getattr(many, name)
        assert (a.inverse, a.delta) == pytest.approx((b.inverse, b.delta), rel=1e-14)
        size = np.abs(a.singular(t) + a.smooth(t)) + np.abs(a.smooth(t)).max()
        # the tables' errors: of unequal numbers of terms
        assert np.max(np.abs(a.smooth(t) - b.smooth(t)) / size) < 1e-10, name
    assert many.terms < 2 * one.terms
    assert many.length == pytest.approx(one.length, rel=0.7)


def drum(*layers: tuple[float, Any], core: str = "rigid", R: float = 0.24) -> wo.Layered:
    return wo.Layered(
        radius=R, layers=[wo.Layer(thickness=h, material=m) for h, m in layers], core=core
    )


RUBBER = wo.Isotropic(youngs_modulus=10e6, poissons_ratio=0.49)
EXAMPLE = wo.NipProblem.example().replace(roll_wrap=0.0)


def outputs(body: wo.Body) -> Array:
    result = wo.solve(EXAMPLE.replace(drum=body), nodes=49)
    return np.array([result.nip_induced_tension, result.half_width, result.approach])


def test_a_nip_with_one_layer_is_that_with_a_cylinder() -> None:
    one = wo.Cylinder(radius=0.24, core_radius=0.225, material=RUBBER)
    np.testing.assert_allclose(outputs(drum((0.24 - 0.225, RUBBER))), outputs(one), rtol=1e-10)


def test_a_nip_does_not_see_how_a_cover_is_split() -> None:
    whole = outputs(drum((0.015, RUBBER), (0.02, wo.material("steel"))))
    split = drum(*[(0.0005, RUBBER)] * 30, (0.02, wo.material("steel")))
    np.testing.assert_allclose(outputs(split), whole, rtol=1e-10)


@pytest.mark.slow
def test_a_coating_far_thinner_than_the_nip_wears_off() -> None:
    """What a coating changes falls with its thickness, down to a thousandth of a millimetre."""
    shell = (0.02, wo.material("steel"))
    bare = outputs(drum((0.015, RUBBER), shell))
    soft = wo.Isotropic(youngs_modulus=2e6, poissons_ratio=0.3)
    change = [
        np.abs(outputs(drum((h, soft), (0.015, RUBBER), shell)) / bare - 1)
        for h in (1e-4, 1e-5, 1e-6)
    ]
    for thick, thin in itertools.pairwise(change):
        assert np.all(thin[1:] < 0.2 * thick[1:])  # the tension's own error is some 1e-3
    assert np.all(change[-1] < 2e-3)


# ---- layers in all that is done with bodies -----------------------------------------------------

SHELL = (0.02, wo.material("steel"))
THREE = EXAMPLE.replace(
    drum=drum((0.015, RUBBER), (0.005, RUBBER.replace(youngs_modulus=60e6)), SHELL, core="free")
)


def test_sensitivities_reach_into_every_layer() -> None:
    result = wo.solve(THREE, nodes=49)
    names = [
        "drum.radius", "drum.layers.0.thickness", "drum.layers.0.material.youngs_modulus",
        "drum.layers.0.material.poissons_ratio", "drum.layers.1.thickness",
        "drum.layers.1.material.youngs_modulus", "drum.layers.2.thickness",
    ]  # fmt: skip
    assert set(names) <= set(result.sensitivity().parameters)
    # loads are met to 3e-9: what that leaves of a small change
    check_sensitivity(result, names, ["half_width"], rtol=1e-4, atol=5e-6)


def test_five_hundred_different_layers() -> None:
    felt = wo.Orthotropic(radial=5e6, tangential=50e6, cross=1e6, shear=3e6)
    plies = [(4e-5 * (1 + k % 3), (RUBBER, felt)[k % 2]) for k in range(499)]
    result = wo.solve(EXAMPLE.replace(drum=drum((1e-6, felt), *plies, SHELL)))
    assert result.residuals.largest <= 1e-8
    # between two plies as one: their stiffness in series and in parallel bound them
    one = [
        wo.solve(EXAMPLE.replace(drum=drum((0.04, m), SHELL))).half_width for m in (RUBBER, felt)
    ]
    assert min(one) < result.half_width < max(one)


def test_layers_between_rollers() -> None:
    pair = wo.RollerProblem(
        upper=drum((0.015, RUBBER), SHELL, core="free"), lower=wo.Rigid(radius=0.2), load=5e3,
        friction=0.3, tangential_load=300.0,
    )  # fmt: skip
    rolling, static = (
        wo.solve(pair.replace(motion=motion), nodes=49) for motion in ("rolling", "static")
    )
    assert max(rolling.residuals.largest, static.residuals.largest) <= 1e-8


# ---- thin tubes ---------------------------------------------------------------------------------


def test_the_load_that_flattens_a_thin_tube() -> None:
    """4 pi B/(3 R R*) of a ring with B = E' h^3/12; thick ones and rigid cores are no rings."""
    R, R_star, E = 0.2, 0.06, 2e9 / (1 - 0.3**2)
    plastic, missed = wo.Isotropic(youngs_modulus=2e9, poissons_ratio=0.3), []
    for h in (4e-3, 2e-3):
        tube = wo.Layered(radius=R, layers=[wo.Layer(thickness=h, material=plastic)], core="free")
        mean = R - h / 2
        ring = 4 * np.pi * E * h**3 / 12 / (3 * mean * R_star)
        missed.append(tube.bending_load(R_star) / ring - 1)
    assert abs(missed[1]) < 0.02
    assert missed[0] == pytest.approx(2 * missed[1], rel=0.2)  # of first order in h/R
    assert tube.replace(core="rigid").bending_load(R_star) == np.inf
    # two halves are one
    half = wo.Layer(thickness=h / 2, material=plastic)
    assert tube.replace(layers=[half, half]).bending_load(R_star) == pytest.approx(
        tube.bending_load(R_star), rel=1e-9
    )


def test_a_load_that_flattens_a_tube_is_rejected() -> None:
    """A little below what a ring bears it is solved, above it is reported how much is borne."""
    tube = drum((2e-3, wo.Isotropic(youngs_modulus=2e9, poissons_ratio=0.3)), core="free")
    problem = THREE.replace(drum=tube, winding_force=0.0, web_tension=0.0)
    borne = tube.bending_load(problem.contact_radius)
    assert wo.solve(problem.replace(nip_load=0.7 * borne), nodes=33).residuals.largest <= 1e-8
    for nip in (problem, problem.replace(roll_wrap=np.pi)):
        heavy = nip.replace(nip_load=1.5 * borne)
        computed = (
            r"nip_load: .* must be <= \S+ \[N/m\], about: the drum is a tube, 0.002 m thick in all"
        )
        with pytest.raises(wo.InvalidProblem, match=computed) as refused:
            wo.solve(heavy)
        ((_, text),) = refused.value.faults
        limit = float(text.partition("must be <= ")[2].split()[0])
        assert 0.7 * borne < limit < 1.2 * borne
    pair = wo.RollerProblem(upper=wo.Rigid(radius=0.1), lower=tube, load=5 * borne, friction=0.2)
    with pytest.raises(wo.InvalidProblem, match=r"load: .* the lower is a tube"):
        wo.solve(pair)


def flattened(nip_load: float) -> wo.NipProblem:
    """Return a roll and a drum on open bores, whose contact widens quickly with the load."""
    paper = wo.Orthotropic(radial=13.5e6, tangential=9.2e9, cross=2.6e6, shear=14.6e6)
    bodies = {}
    for name, radius, layers in (
        ("roll", 0.061, [(0.052, paper), (1.2e-3, (206e9, 0.3))]),
        ("drum", 0.133, [(4e-3, (531e6, 0.185)), (3.1e-3, (8e6, 0.16)), (3e-6, (40e9, 0.49))]),
    ):
        made = [
            {"thickness": h, "material": m if m is paper
             else wo.Isotropic(youngs_modulus=m[0], poissons_ratio=m[1])}
            for h, m in layers
        ]  # fmt: skip
        bodies[name] = wo.Layered(radius=radius, layers=made, core="free")
    return wo.NipProblem(
        web=wo.Web(thickness=113e-6, material=paper), **bodies, roll_friction=0.152,
        drum_friction=0.49, nip_load=nip_load, winding_force=-0.27 * nip_load, web_tension=65.4,
        roll_wrap=0,
    )  # fmt: skip


def test_a_contact_that_is_too_wide_in_passing_only_is_solved() -> None:
    """With the first active sets the contact would be wider than the radius of the roll."""
    cold = wo.solve(flattened(7000.0), nodes=65)
    start = wo.solve(flattened(5000.0), nodes=65)
    warm = wo.solve(flattened(7000.0), nodes=65, start=start)
    assert cold.half_width < 0.7 * 0.061
    # the solver's tolerance is 1e-11 in the unit of each unknown
    assert cold.half_width == pytest.approx(warm.half_width, rel=1e-8)
    assert cold.wound_on_tension == pytest.approx(warm.wound_on_tension, rel=1e-7)


def test_a_tube_that_friction_flattens_is_explained() -> None:
    """Without friction 11.4 kN/m would be possible."""
    says = "the drum is a tube on an open bore, and the load is 99% of the largest one"
    with pytest.raises(wo.NotConverged, match=says):
        wo.solve(flattened(11_300.0))
