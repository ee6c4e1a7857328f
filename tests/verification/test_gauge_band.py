"""A thick lane of a wound roll: the closed form, its limits, complete rolls, and its margin."""

from __future__ import annotations

from functools import cache
from math import isnan

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from slow_cases import slow_case

import woundon as wo
from woundon.io.chosen_units import units_of
from woundon.theories import gauge_band

NEWSPRINT = {"K1": 10e3, "tangential": 3.38e9, "thickness": 66e-6, "tension": 350.0}
PET = {"K1": 2e3, "K2": 200.0, "tangential": 4.8e9, "thickness": 50e-6, "tension": 175.0}


@pytest.mark.parametrize(
    ("roll", "closed_form", "strips"),
    [
        (NEWSPRINT | {"K2": 40.0}, ((374.5, 1.13), (436.6, 1.49)), (373.9, 434.3)),
        (NEWSPRINT | {"K2": 127.0}, ((419.8, 1.41), (625.9, 3.06)), (420.2, 628.4)),
        (PET, ((232.5, 1.74), (432.8, 5.9)), (232.6, 433.7)),
    ],
    ids=["newsprint, K2 40", "newsprint, K2 127", "PET"],
)
def test_lone_bands_of_three_rolls(roll, closed_form, strips):
    """Independent evaluation of the closed form, and rolls of strips wound layer by layer."""
    for excess, (tension, ratio), strip in zip((0.003, 0.01), closed_form, strips, strict=True):
        band = gauge_band(**roll, excess=excess)
        assert band.tension == pytest.approx(tension, abs=0.1)  # the last digit
        digits = 0.05 if ratio == 5.9 else 0.005
        assert band.pressure / band.mean_pressure == pytest.approx(ratio, abs=digits)
        # The strips have the curvature of the layers, and layers of finite thickness: 0.54 % at
        # most.  A closed form with all of the excess in compression is 0.4 to 11.7 % too high.
        assert band.tension == pytest.approx(strip, rel=0.006)
        # the equations themselves
        K1, K2, E_t, h = (roll[name] for name in ("K1", "K2", "tangential", "thickness"))
        lead = (band.tension - roll["tension"]) / h / E_t
        assert band.lead == pytest.approx(lead)
        assert band.strain == pytest.approx(band.tension / h / E_t)
        hardening = ((1 + excess) / (1 + lead)) ** K2
        assert (K1 + band.pressure) / (K1 + band.mean_pressure) == pytest.approx(hardening)
        for WOT, P in ((roll["tension"], band.mean_pressure), (band.tension, band.pressure)):
            work = (WOT / h) ** 2 * K2 / (2 * E_t)
            assert work == pytest.approx(P - K1 * np.log1p(P / K1), rel=1e-9)


def test_an_even_web_has_no_band():
    band = gauge_band(**PET, excess=0.0)
    assert band.tension == pytest.approx(175.0, rel=1e-14)
    assert band.lead == 0
    assert band.pressure == band.mean_pressure


def test_thick_and_thin_lanes_are_symmetric_to_first_order():
    thick, thin = (gauge_band(**PET, excess=d).tension - 175.0 for d in (1e-6, -1e-6))
    assert thick == pytest.approx(-thin, rel=1e-3)


def test_a_much_thinner_lane_is_slack():
    band = gauge_band(**PET, excess=-0.05)
    assert (band.tension, band.pressure) == (0, 0)
    assert band.lead == pytest.approx(-175.0 / 50e-6 / 4.8e9)


def test_the_thickness_at_which_a_lane_becomes_slack():
    """Closed form: the lane without pressure fills ln((1 + d)/(1 - T/E_t)) = -F(P)."""
    K1, K2, T_E = PET["K1"], PET["K2"], PET["tension"] / PET["thickness"] / PET["tangential"]
    P = gauge_band(**PET, excess=0.0).mean_pressure
    slack = (1 - T_E) * (1 + P / K1) ** (-1 / K2) - 1
    assert gauge_band(**PET, excess=slack * (1 + 1e-6)).tension == 0
    barely_taut = gauge_band(**PET, excess=slack * (1 - 1e-6)).tension
    # At low pressure T_b = h (E_r E_t)^(1/2) F(P_b), and F(P_b) = 1e-6 |d|/(1 + d), except for
    # the part P_b/T_b = (E_r/E_t)^(1/2) = 0.9 % that the larger radius takes up.
    compression = 1e-6 * abs(slack) / (1 + slack)
    stiffness = 50e-6 * np.sqrt(K1 * K2 * 4.8e9)
    assert barely_taut == pytest.approx(stiffness * compression, rel=0.02)


def test_a_constant_modulus():
    """Closed form: P = q T with q^2 = E_r/E_t, and to first order q T_b + E_r lead = q T + E_r d.

    Hence T_b - T = E_r d/(q + q^2); the rest is of the order of d and T/E_t relative to it.
    """
    stack = wo.Stack(radial=40e6, tangential=3.38e9, poissons_ratio=0.01, shear=10e6)
    q, d = np.sqrt(40e6 / 3.38e9), 1e-5
    band = gauge_band(stack=stack, thickness=66e-6, tension=350.0, excess=d)
    assert band.mean_pressure == pytest.approx(q * 350 / 66e-6)
    assert band.pressure == pytest.approx(q * band.tension / 66e-6)
    assert band.tension - 350 == pytest.approx(66e-6 * 40e6 * d / (q + q**2), rel=2e-3)


def test_another_law_of_the_stack():
    # Quadrature and root search of SciPy: T^2/(2 E_t) = int P d eps
    law = wo.PowerLaw(E0=1e6, k=20e6, m=0.7)
    stack = wo.Stack(radial=law, tangential=3.38e9, poissons_ratio=0.01, shear=10e6)

    def work(P):
        return quad(lambda p: p / law.modulus(p), 0, P, epsabs=0, epsrel=1e-11)[0]

    T = 350 / 66e-6
    P = brentq(lambda P: work(P) - T**2 / (2 * 3.38e9), 1e3, 1e7, rtol=1e-12)

    def excess(P_b):
        lead = (np.sqrt(2 * 3.38e9 * work(P_b)) - T) / 3.38e9
        return np.exp(law.strain_at(P_b) - law.strain_at(P)) * (1 + lead) - 1

    P_b = brentq(lambda P: excess(P) - 0.005, P, 1e8, rtol=1e-12)
    band = gauge_band(stack=stack, thickness=66e-6, tension=350.0, excess=0.005)
    assert (band.mean_pressure, band.pressure) == pytest.approx((P, P_b), rel=1e-8)
    assert band.tension == pytest.approx(66e-6 * np.sqrt(2 * 3.38e9 * work(P_b)), rel=1e-8)


@cache
def growth(tension: float, K2: float) -> float:
    """Return by how much of the web's thickness a complete roll grows with a layer."""
    stack = wo.Stack(
        radial=wo.Pfeiffer(K1=10e3, K2=K2), tangential=3.38e9, poissons_ratio=0.0, shear=10e6
    )
    roll = wo.RollProblem(
        core=wo.Core(radius=0.05, stiffness=1e9), radius=0.5, stack=stack, web_thickness=66e-6,
        wound_on_tension=tension,
    )  # fmt: skip
    result = wo.solve(roll)
    return 1 - (1 + float(result.growth[-1])) * tension / 66e-6 / 3.38e9


@pytest.mark.parametrize("K2", [40.0, slow_case(127.0)])
def test_complete_rolls_that_grow_alike(K2):
    """Independent method: complete rolls of the lane and of the mean web on radii s_b and s.

    A layer of the lane adds 1 + lead of what a layer of the roll adds: with the radius the strain
    of the web grows in proportion.  The plateau neglects the curvature of the layers.
    """
    mean = growth(350.0, K2)
    for excess in (0.001, 0.01):

        def surplus(WOT, excess=excess):
            lead = (WOT - 350.0) / 66e-6 / 3.38e9
            return (1 + excess) * growth(WOT, K2) - (1 + lead) * mean

        tension = brentq(surplus, 350.0, 900.0, xtol=0.5)
        closed = gauge_band(**NEWSPRINT, K2=K2, excess=excess).tension
        assert tension == pytest.approx(closed, rel=0.02)


# ---- rolls and windings --------------------------------------------------------------------------


def roll(**changes):
    return wo.solve(wo.RollProblem.example().replace(**changes))


def test_the_field_changes_no_stress():
    even, uneven = roll(), roll(gauge_excess=0.01)
    assert np.array_equal(even.pressure, uneven.pressure)
    assert "Thickest lane" not in str(even)
    assert "436.56 N/m" in " ".join(str(uneven).split())


def test_the_margin_of_a_roll():
    uneven = roll(gauge_excess=0.01)
    margin = wo.margins(uneven)["gauge_band"]
    band = gauge_band(**NEWSPRINT, K2=40.0, excess=0.01)
    assert margin.value == pytest.approx(band.strain)
    assert margin.ok is None
    assert f"ridge of {band.lead * 0.15 * 1e6:.3g} um" in margin.note
    for limit, ok in ((0.0019, False), (0.002, True)):
        assert wo.margins(uneven, wo.Limits(yield_strain=limit))["gauge_band"].ok is ok
    assert wo.margins(roll())["gauge_band"].value == pytest.approx(350 / 66e-6 / 3.38e9)


def test_the_outputs_of_a_winding():
    winding = wo.WindingProblem.example().replace(
        radius=0.1, tension_law="fixed", nip_induced_tension=50.0, web_tension=300.0
    )
    even = wo.solve(winding)
    uneven = wo.solve(winding.replace(gauge_excess=0.01, limits={"yield_strain": 0.001}))
    assert even.ridge_height == 0
    assert even.band_strain == pytest.approx(350 / 66e-6 / 3.38e9, rel=1e-6)
    band = gauge_band(**NEWSPRINT, K2=40.0, excess=0.01)
    assert uneven.band_strain == pytest.approx(band.strain, rel=1e-6)
    assert uneven.ridge_height == pytest.approx(band.lead * 0.1, rel=1e-6)
    assert "gauge_band" in uneven.margins.violated
    assert "height of the ridge" in str(uneven)


def test_a_law_that_ends_leaves_the_margin_unchecked():
    strain = np.linspace(0, 0.09, 10)
    test = wo.StackTest(strain=strain, pressure=10e3 * np.expm1(40 * strain))
    stack = wo.Stack(radial=test, tangential=3.38e9, poissons_ratio=0.01, shear=10e6)
    uneven = roll(stack=stack, wound_on_tension=300.0, gauge_excess=0.03)
    margin = wo.margins(uneven, wo.Limits(yield_strain=0.01))["gauge_band"]
    assert isnan(margin.value)
    assert margin.ok is None
    assert "the law ends" in margin.note
    assert "Not computed: stack.radial" in str(uneven)
    assert "[Pa]" in str(uneven)
    with units_of(["mill"]):
        assert "[psi]" in str(uneven)
        assert "[Pa]" not in str(uneven)
