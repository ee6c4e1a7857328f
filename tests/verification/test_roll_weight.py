"""The weight of a roll: balance of forces, Hertz, and a hardening roll on a plane."""

from __future__ import annotations

import numpy as np
import pytest

import woundon as wo

GRAVITY = 9.80665
ROLL = wo.RollProblem.example().replace(radius=0.6, **{"core.radius": 0.05})


@pytest.fixture(scope="module")
def result() -> wo.RollResult:
    return wo.solve(ROLL)


def test_the_pressure_of_the_weight_is_that_of_the_mass(result):
    weight = GRAVITY * result.wound_mass
    assert result.weight_pressure == pytest.approx(weight / 0.1, rel=1e-12)


def test_the_first_harmonic_of_the_pressure_carries_the_weight(result):
    """The force of p_1 cos(theta) on each cylinder is at least the weight outside it."""
    r = np.linspace(0.05, 0.599, 2000)
    outside = GRAVITY * result.wound_mass * (0.36 - r**2) / (0.36 - 0.0025)
    theta = np.linspace(0, 2 * np.pi, 4001)
    share = result.weight_share
    P = result.at_radius(r)["pressure"]
    # vertical force of the change share * P cos(theta), upwards on the roll: at least the weight
    carried = share * P * r * np.trapezoid(np.cos(theta) ** 2, theta)
    # between the 400 radii at which the ratio is evaluated it is larger by 1e-5
    assert np.min(carried / outside) == pytest.approx(1, rel=1e-4)


def test_a_loose_heavy_roll_separates_below_its_core(result):
    """Twice the density, twice the ratio: the pressure as wound does not depend on the weight."""
    heavy = wo.solve(ROLL.replace(density=2 * 680.0))
    assert heavy.weight_share == pytest.approx(2 * result.weight_share, rel=1e-9)


@pytest.mark.slow
def test_the_flat_width_against_a_hardening_roll_on_a_plane(result):
    """Equilibrium of the roll by finite elements; a plane is a drum of 50 m: 1 % of the curvature.

    The effective modulus at one pressure is an estimate: 5 % below here.
    """
    keep = np.linspace(0, result.radius.size - 1, 50).astype(int)
    profile = wo.Profile(radius=result.radius[keep], value=np.maximum(result.pressure[keep], 0.0))
    body = wo.WoundRoll(radius=0.6, core_radius=0.05, stack=ROLL.stack, pressure=profile)
    pair = wo.RollerProblem(
        upper=body, lower=wo.Rigid(radius=50.0), load=GRAVITY * result.wound_mass, friction=0.3,
        tangential_load=0.0,
    )  # fmt: skip
    assert result.flat_width == pytest.approx(wo.solve(pair).nip_width, rel=0.1)


def test_the_flat_width_of_a_linear_stack_is_that_of_hertz():
    """Constant moduli, so that no pressure matters: wo.theories.hertz of the pair."""
    stack = wo.Stack(radial=40e6, tangential=4e9, poissons_ratio=0.0, shear=1e7)
    result = wo.solve(ROLL.replace(stack=stack))
    material = wo.Orthotropic(radial=40e6, tangential=4e9, cross=0.0, shear=1e7)
    pair = wo.RollerProblem(
        upper=wo.HalfPlane(radius=0.6, material=material), lower=wo.Rigid(radius=50.0),
        load=GRAVITY * result.wound_mass, friction=0.3, tangential_load=0.0,
    )  # fmt: skip
    width = 2 * wo.theories.hertz(pair).half_width
    # a plane in place of a drum of 50 m: R in place of 1/(1/R + 1/50)
    assert result.flat_width == pytest.approx(width * (1 + 0.6 / 50) ** 0.5, rel=1e-6)


def test_without_density_or_core_there_is_no_weight_on_it():
    light = wo.solve(ROLL.replace(density=None), rtol=1e-2)
    assert np.isnan([light.weight_pressure, light.weight_share, light.flat_width]).all()
    released = wo.solve(ROLL.replace(core_removed=True), rtol=1e-2)
    assert np.isnan([released.weight_pressure, released.weight_share]).all()
    assert released.flat_width > 0
