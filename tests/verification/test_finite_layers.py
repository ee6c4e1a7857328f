"""Laps of finite thickness: a roll of rings, laid one by one, against the limit of thin layers.

The rings know nothing of sources, of stages or of a limit: each is a thick ring of the stack's law
(or several thinner ones), with the tension it is laid with as its own, on which all later ones
press.
"""

from __future__ import annotations

import numpy as np
import pytest
from rings import Rings
from slow_cases import slow_case

import woundon as wo

NEWSPRINT = wo.RollProblem.example()
TAPER = wo.Taper(start=350.0, taper=0.4)


def thick(problem: wo.RollProblem, times: float) -> wo.RollProblem:
    """Return the same roll of thicker laps under the same stress, a whole number of them."""
    core, h = problem.core.radius, times * problem.web_thickness
    T = problem.wound_on_tension
    more = T.replace(start=times * T.start) if isinstance(T, wo.Taper) else times * T
    laps = round((problem.radius - core) / h)
    return problem.replace(web_thickness=h, wound_on_tension=more, radius=core + laps * h)


def of(problem: wo.RollProblem, parts: int = 2) -> tuple[wo.RollResult, Rings, np.ndarray]:
    """Return the roll of thin laps, that of rings, and by how much the second's P is larger."""
    result, rings = wo.solve(problem, rtol=1e-4), Rings(problem, parts)
    r = np.minimum(rings.r, problem.radius)
    return result, rings, rings.P - result.at_radius(r)["pressure"]


def test_the_rings_of_constant_moduli_are_a_sum():
    """Each lap adds T h/s F(r)/F(s) to all below, F the closed form: no equations are solved."""
    stack = wo.Stack(radial=4e7, tangential=4e9, poissons_ratio=0.0, shear=1e7)
    problem = wo.RollProblem(
        core=wo.Core(radius=0.05, stiffness=2e9), radius=0.09, stack=stack, web_thickness=4e-4,
        wound_on_tension=800.0,
    )  # fmt: skip
    g, r = 10.0, 0.05 + 4e-4 * np.arange(100)
    A = (g - 4e9 / 2e9) / (g + 4e9 / 2e9)
    F = (r / 0.05) ** (g - 1) + A * (r / 0.05) ** (-g - 1)
    laid = 2e6 * 4e-4 / r / F
    P = F * np.cumsum(laid[::-1])[::-1]
    # the rings' own discretisation, of order two in their thickness
    one, two = (np.max(np.abs(Rings(problem, parts).P[:-1] - P)) for parts in (2, 4))
    assert one < 1e-3 * P.max()
    assert one / two == pytest.approx(4, rel=0.2)


@pytest.mark.parametrize(
    "problem",
    [
        slow_case(thick(NEWSPRINT, 4)), slow_case(thick(NEWSPRINT, 2)),
        thick(NEWSPRINT.replace(wound_on_tension=TAPER), 4),
        thick(NEWSPRINT.replace(**{"core.stiffness": 1e8}), 4),
        thick(NEWSPRINT.replace(stack=NEWSPRINT.stack.replace(radial=40e6)), 4),
        thick(NEWSPRINT.replace(wound_on_tension=TAPER,
                                stack=NEWSPRINT.stack.replace(radial=1e9), radius=0.06), 6),
    ],
    ids=["newsprint, 264 um", "132 um", "taper", "soft core", "constant", "few stiff laps"],
)  # fmt: skip
def test_what_finite_layers_change_is_reported(problem: wo.RollProblem):
    """To 1.3 % of it here; the estimates add terms of higher order, up to 6 %."""
    result, rings, change = of(problem)
    found = np.interp(rings.r, result.radius, result.finite_layer_change)
    largest = np.max(np.abs(change))
    assert np.max(np.abs(found - change)) < 0.02 * largest
    assert result.finite_layer_effect == pytest.approx(
        change[np.argmax(np.abs(change))] / result.peak_pressure, rel=0.02
    )
    for name, by in (("core_pressure", abs(change[0])), ("peak_pressure", largest)):
        assert 0.98 * by < result.errors[name] < 1.12 * by + 1e-4 * result.peak_pressure
    shallow = np.min(rings.P) - np.min(result.pressure)
    assert abs(shallow) <= result.errors["peak_pressure"]


def test_the_effect_is_of_order_one_in_the_thickness():
    """Half as thick, half as much; the published scheme has half of it, by its own first order."""
    effects = [wo.solve(thick(NEWSPRINT, times)).finite_layer_effect for times in (1, 0.5, 0.25)]
    assert effects[0] == pytest.approx(0.049, abs=0.001)  # rings: 4.81 to 5.00 % by 6 and 1 a lap
    orders = np.log2(np.array(effects[:-1]) / effects[1:])
    assert (np.abs(orders - 1) < 0.08).all()  # 0.94 and 0.95


@pytest.mark.slow
def test_one_ring_a_lap_or_three_make_no_difference_of_first_order():
    """So it does not matter where in a lap, or between two, the stack gives way."""
    apart, effect = [], 0.0
    for times in (4, 2, 1):
        one, three = (of(thick(NEWSPRINT, times), parts)[2][0] for parts in (1, 3))
        apart.append(one - three)
        effect = one
    ratios = np.array(apart[:-1]) / apart[1:]
    assert (ratios > 2.6).all()  # 2.8 and 3.1: tends to four, where the effect halves
    assert ratios[1] > ratios[0]
    assert apart[-1] < 0.05 * effect


def test_a_stage_has_its_own_number_of_layers():
    stage = wo.solve(NEWSPRINT, rtol=1e-4).at(0.1)
    alone = wo.solve(stage.problem, rtol=1e-4)
    r = np.linspace(0.0446, 0.099, 50)
    one, two = (np.interp(r, part.radius, part.finite_layer_change) for part in (stage, alone))
    # one step of Newton's method at different stages
    np.testing.assert_allclose(one, two, atol=0.05 * np.max(alone.finite_layer_change))


# ---- few thick laps: every output with an error estimate ----------------------------------------


def random_roll(seed: int) -> wo.RollProblem:
    """Return a roll of 10 to 100 laps: foam, board, nonwovens, rubber; all laws and schedules."""
    rng = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(low * (high / low) ** rng.random())

    laps, h = int(rng.integers(10, 101)), between(50e-6, 10e-3)
    core, E_t = h * between(3, 300), between(1e5, 1e10)
    surface = core + laps * h
    T = E_t * between(3e-4, 1e-2)
    E_r, scale = E_t / between(2, 3000), T * between(1e-3, 1)
    # E_r(0) of each law, and its first or only increase on the scale of the pressure
    law = [
        E_r,
        wo.Pfeiffer(K1=scale, K2=E_r / scale),
        wo.PowerLaw(E0=max(E_r * between(0.01, 1), 1.0), k=E_r * (1e5 / scale) ** 0.7, m=0.7),
        wo.Polynomial(coefficients=(E_r, E_r / scale, 0.1 * E_r / scale**2)),
    ][rng.integers(4)]
    WOT, taper, ends = T * h, float(rng.uniform(0, 0.6)), rng.uniform(0.6, 1.2, 2)
    tension = [
        WOT,
        wo.Taper(start=WOT, taper=taper),
        wo.Taper(start=WOT, taper=taper, law="hyperbolic"),
        wo.Profile(
            radius=[core, (core + surface) / 2, surface], value=[WOT, *(WOT * ends).tolist()]
        ),
    ][rng.integers(4)]
    changes = {}
    if rng.random() < 0.3:
        radial, along, shrinkage = T / E_t * rng.uniform([-0.3, -0.02, -0.1], [0.3, 0.02, 0.1])
        changes = {
            "temperature_change": 10.0, "radial_expansion": min(max(radial / 10, -0.01), 0.01),
            "tangential_expansion": along, "core_shrinkage": shrinkage,
        }  # fmt: skip
    stack = wo.Stack(
        radial=law, tangential=E_t, poissons_ratio=float(rng.uniform(0, 0.2)), shear=1e5
    )
    return wo.RollProblem(
        core=wo.Core(radius=core, stiffness=E_t * between(0.1, 100)), radius=surface, stack=stack,
        web_thickness=h, wound_on_tension=tension, **changes,
    )  # fmt: skip


def misses(problem: wo.RollProblem) -> dict[str, float] | None:
    """Return the largest difference to the sum over laps of each output, in error estimates.

    The hoop stress of a lap is compared on the average and at both faces.  None without a result.
    """
    try:
        result = wo.solve(problem)
    except wo.InvalidProblem:  # the energy of the stack is indefinite at the pressure reached
        return None
    rings = Rings(problem, 6)
    middle = (problem.core.radius + problem.radius) / 2
    laps = {
        "core_pressure": [rings.P[0]],
        "peak_pressure": [rings.P.max()],
        "mid_pressure": [np.interp(middle, rings.r, rings.P)],
        "least_hoop_stress": [hoop.min() for hoop in (rings.mean_hoop, *rings.face_hoop)],
    }
    assert laps.keys() == result.errors.keys()
    return {
        name: max(abs(value - getattr(result, name)) for value in values) / result.errors[name]
        for name, values in laps.items()
    }


# 12: a soft core; 30: 19 laps, 3.5 times the pressure of thin ones; 59: a kink of the tension; 417:
# the least stress at a kink inside a lap; 450: a change that is zero near the middle
@pytest.mark.filterwarnings("ignore:the web is bent", "ignore:the layers are compressed")
@pytest.mark.parametrize("seed", [12, 30, 59, 417, 450])
def test_few_thick_laps_are_covered_by_the_error_estimates(seed: int):
    found = misses(random_roll(seed))
    assert found is not None
    assert max(found.values()) <= 1.25


@pytest.mark.campaign
@pytest.mark.filterwarnings("ignore")
def test_a_hundred_rolls_of_few_thick_laps():
    found = [miss for seed in range(110) if (miss := misses(random_roll(seed))) is not None]
    assert len(found) >= 100
    for name in found[0]:
        assert max(miss[name] for miss in found) <= 1.25, name


def test_the_hoop_stress_of_a_roll_of_foam():
    """44 laps of constant moduli: each subtracts T h/s (F + r F')/F(s) below it, a closed form."""
    h, E_t, E_r, E_c = 5e-3, 1e6, 0.8e6, 0.2e6
    problem = wo.RollProblem(
        core=wo.Core(radius=0.05, stiffness=E_c), radius=0.05 + 44 * h, web_thickness=h,
        stack=wo.Stack(radial=E_r, tangential=E_t, poissons_ratio=0.0, shear=1e5),
        wound_on_tension=1e4 * h,
    )  # fmt: skip
    g, T = np.sqrt(E_t / E_r), 1e4
    A = (g - E_t / E_c) / (g + E_t / E_c)
    s = 0.05 + h * np.arange(44)

    def growing_and_decaying(r: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return (r / 0.05) ** (g - 1), A * (r / 0.05) ** (-g - 1)

    laid = T * h / s / np.sum(growing_and_decaying(s), axis=0)
    later = np.append(np.cumsum(laid[::-1])[::-1], 0.0)[1:]  # laps outside a lap
    result = wo.solve(problem)
    for face in (s, s + h):
        grows, decays = growing_and_decaying(face)
        hoop = T - (g * grows - g * decays) * later
        miss = abs(np.min(hoop) - result.least_hoop_stress)
        assert 0.02 * T < miss <= 1.25 * result.errors["least_hoop_stress"]
