"""A rigid cylinder on a thin layer bonded to a rigid base, frictionless, plane strain.

The layer is a :class:`woundon.Cylinder` whose core is the base, pressed by a rigid one of the same
radius Rc; it is flat only in the limit h/Rc -> 0, so every comparison carries a curvature error of
the order h/Rc, which must shrink with it.  Reference numbers were derived independently from the
flat layer's compliance

    u/p = 2 L(kh)/(E* k),   L = (2 k' sinh 2s - 4 s)/(2 k' cosh 2s + 1 + k'^2 + 4 s^2),
    s = kh, k' = 3 - 4 nu, E* = E/(1 - nu^2).
"""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from slow_cases import slow_case

import woundon as wo

H, E = 0.01, 10e6
# a/h: (P over Hertz's of the same a, p(0) over E* a/2R)
FLAT = {
    0.3: {
        0.5: (1.16613442, 1.17217454),
        1.0: (1.55564006, 1.60976882),
        2.0: (2.51851650, 2.75602275),
        5.0: (5.59581921, 6.41260799),
    },
    0.5: {
        0.5: (1.24748398, 1.25756983),
        1.0: (1.90329916, 2.00232706),
        2.0: (4.04781601, 4.60414243),
        5.0: (18.2833054, 22.7522081),
    },
}
FLATTEST = 1900.0  # Rc/h; the program takes layers down to Rc/2000


def press(nu: float, load: float, flatness: float, friction: float = 1e-6) -> wo.RollerResult:
    """Press a rigid cylinder of radius Rc = flatness h on a layer of the same radius."""
    R = flatness * H
    layer = wo.Cylinder(
        radius=R,
        core_radius=R - H,
        material=wo.Isotropic(youngs_modulus=E, poissons_ratio=nu),
    )
    problem = wo.RollerProblem(upper=wo.Rigid(radius=R), lower=layer, load=load, friction=friction)
    return wo.solve(problem)


def test_the_incompressible_layer_itself_meets_the_reference() -> None:
    """nu = 0.5 is admitted: what is left is the curvature's h/Rc and the grid's, as above."""
    errors = [np.abs(misses(0.5, a_h, FLATTEST)) for a_h in FLAT[0.5]]
    assert np.all(errors <= 0.3 / FLATTEST + np.array([1e-4, 5e-4]))


@pytest.mark.parametrize("a_h", [slow_case(0.5), 5.0])
def test_the_incompressible_limit_is_neared_to_the_last_digit(a_h: float) -> None:
    """Every digit of 1/2 - nu counts alike: nothing is formed by cancellation.

    The answer's change goes like 1 - 2 nu down to rounding, 1e-11 by the width's own tolerance.
    """
    flatness = 200.0  # takes a tenth of the terms that the flattest does
    whole = np.array(misses(0.5, a_h, flatness))
    away = [np.abs(misses(0.5 - 10.0**-k, a_h, flatness) - whole) for k in range(3, 17)]
    for k, miss in enumerate(away, start=3):
        assert np.all(miss <= 1.2 * away[0] * 10.0 ** (3 - k) + 1e-10)


def misses(nu: float, a_h: float, flatness: float, friction: float = 1e-6) -> tuple[float, float]:
    """Return the relative errors of half width and peak pressure under the reference's load."""
    load_ratio, peak_ratio = FLAT[0.5 if nu > 0.45 else nu][a_h]
    a, R, modulus = a_h * H, flatness * H / 2, E / (1 - nu**2)
    result = press(nu, load_ratio * pi * modulus * a**2 / (4 * R), flatness, friction)
    assert result.residuals.largest <= 1e-8
    peak = np.interp(0.0, result.x, result.pressure)
    return result.half_width / a - 1, float(peak / (peak_ratio * modulus * a / (2 * R)) - 1)


@pytest.mark.parametrize("a_h", FLAT[0.3])
@pytest.mark.parametrize("nu", [0.3, slow_case(0.4999)])
def test_the_layer_flattens_to_the_reference(nu: float, a_h: float) -> None:
    """The error is the curvature's, 0.02 to 0.3 times h/Rc (measured), and shrinks like it."""
    flatness = [20.0, 100.0, 500.0, FLATTEST]
    errors = np.abs([misses(nu, a_h, k) for k in flatness])
    # what 101 nodes leave: 1e-4 in the width, 5e-4 in a pressure between two nodes; the distance of
    # nu = 0.4999 to 0.5 adds 7e-4 and 1e-3 on the widest contact
    left = np.array([1e-4, 5e-4]) + (nu > 0.45) * np.array([7e-4, 8e-4]) * (a_h / 5) ** 2
    for k, error in zip(flatness, errors, strict=True):
        assert np.all(error <= 0.3 / k + left)
    assert np.all(errors[-1] < errors[0] / 5)


@pytest.mark.parametrize("a_h", [slow_case(2.0), 5.0])
def test_the_incompressible_limit_is_neared_in_proportion(a_h: float) -> None:
    """1/K = (1+nu)(1-2nu)/(E(1-nu)) is the whole difference of a nearly incompressible layer."""
    errors = [abs(misses(nu, a_h, FLATTEST)[0]) for nu in (0.49, 0.499, 0.4999)]
    assert errors[0] > 7 * errors[1] > 7 * 4 * errors[2]


def test_the_frictionless_limit_is_neared_in_proportion() -> None:
    width = {mu: misses(0.3, 2.0, FLATTEST, mu)[0] for mu in (1e-2, 1e-3, 1e-4, 1e-6)}
    shift = [abs(width[mu] - width[1e-6]) for mu in (1e-2, 1e-3, 1e-4)]
    assert shift[0] > 5 * shift[1] > 5 * 5 * shift[2]
    assert shift[2] < 1e-5


def press_thin(nu: float, a_h: float) -> tuple[float, float]:
    """Return half width and peak pressure over those of a bed of springs under the same load.

    P = 2 K a^3/(3 R h), p(0) = K a^2/(2 R h), K = E(1-nu)/((1+nu)(1-2nu)).
    """
    K = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    R, a = FLATTEST * H / 2, a_h * H
    result = press(nu, 2 * K * a**3 / (3 * R * H), FLATTEST)
    assert result.residuals.largest <= 1e-8
    peak = float(np.interp(0.0, result.x, result.pressure))
    return result.half_width / a, peak / (K * a**2 / (2 * R * H))


@pytest.mark.parametrize(
    "nu",
    [slow_case(0.0), 0.3, slow_case(0.45)],
)
def test_a_thin_compressible_layer_is_a_bed_of_springs(nu: float) -> None:
    """As a/h -> infinity; the edges take up a fixed share of h, so the error falls like h/a.

    Measured share: 0.18, 0.12 and -0.55.
    """
    ratios = {a_h: press_thin(nu, a_h) for a_h in (5.0, 10.0, 20.0)}
    shares = [a_h * (1 - width) for a_h, (width, _) in ratios.items()]
    assert np.max(np.abs(shares)) < 0.6
    assert shares[-1] == pytest.approx(shares[-2], rel=0.05)
    for a_h, (_, peak) in ratios.items():
        assert peak == pytest.approx(1, abs=0.4 / a_h)


@pytest.mark.parametrize(("nu", "a_h"), [(0.45, 40.0), (0.3, 80.0)])
def test_the_thinnest_layers(nu: float, a_h: float) -> None:
    width, peak = press_thin(nu, a_h)
    assert width == pytest.approx(1, abs=0.6 / a_h)
    assert peak == pytest.approx(1, abs=0.4 / a_h)


def test_a_layer_thinner_than_the_cells() -> None:
    """A half width of 22 layers on 13 nodes: coarse, but as far as the cells go right.

    The creep of slip that is next to none needs more of them.
    """
    nearly = wo.Isotropic(youngs_modulus=1e6, poissons_ratio=0.49)
    layer = wo.Cylinder(radius=0.5, core_radius=0.4997, material=nearly)
    problem = wo.RollerProblem(
        upper=wo.Rigid(radius=0.5), lower=layer, load=3e4, friction=0.01, tangential_load=90.0
    )
    coarse, middle, fine = (wo.solve(problem, nodes=nodes) for nodes in (13, 51, 201))
    assert max(r.residuals.largest for r in (coarse, middle, fine)) <= 1e-8
    assert coarse.half_width == pytest.approx(fine.half_width, rel=0.01)
    assert middle.creepage == pytest.approx(fine.creepage, rel=0.1)
