"""Hardening rolls as users have them: case files, sweeps, derivatives, faults, random nips."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from derivatives import check_sensitivity
from hardening_cases import linear, nip, roll
from slow_cases import campaign_case, slow_case

import woundon as wo


@pytest.mark.parametrize(
    "name",
    [*map(slow_case, ("roll.stack.radial.K2", "roll.pressure")), campaign_case("roll.stack.shear")],
)
def test_sensitivities_are_the_derivatives(name: str) -> None:
    """Of the implicit function; a tangent may be one part in ten thousand old."""
    result = wo.solve(nip(roll(shear_exponent=0.5)), nodes=17)
    check_sensitivity(result, [name], ["nip_induced_tension", "half_width"], step=2e-3, rtol=1e-3)


# ---- refusals -----------------------------------------------------------------------------------


def test_a_stack_pressed_beyond_its_law_is_rejected() -> None:
    """A test measured up to 400 kPa, a nip of more than 1 MPa."""
    P = np.linspace(0, 400e3, 9)
    test = wo.StackTest(pressure=P, strain=np.log1p(P / 10e3) / 127.0)
    stack = wo.Stack(radial=test, tangential=3.38e9, poissons_ratio=0.185, shear=10e6)
    body = wo.WoundRoll(radius=0.1, core_radius=0.0445, stack=stack, pressure=90e3)
    with pytest.raises(wo.InvalidProblem, match=r"roll: the pressure in it reaches .* \(4e\+05 "):
        wo.solve(nip(body), nodes=17)


def test_a_stack_that_becomes_stiffer_than_its_energy_allows_is_rejected() -> None:
    """E_r = E_t/nu^2 at 0.5 MPa."""
    body = roll(tangential=2e9, poissons_ratio=5.6)
    assert 4e5 < body.stack.limit < 6e5
    with pytest.raises(wo.InvalidProblem, match=r"poissons_ratio = 5\.6 must be <"):
        wo.solve(nip(body), nodes=17)


FALLS = wo.Polynomial(coefficients=(27e6, -60.0))  # negative from 450 kPa on


@pytest.mark.parametrize("where", [slow_case("roll"), "web"])
def test_a_modulus_that_turns_negative_is_rejected(where: str) -> None:
    """Where it has fallen to 1 %, of the roll or of the web; before, it is solved."""
    body = roll().replace(**{"stack.radial": FALLS})
    web = nip(linear(roll(), 90e3)).replace(**{"web.material": body.stack}).replace(roll_wrap=pi)
    problem, computed = {
        "roll": (nip(body), "roll: the pressure in it"),
        "web": (web, "web.material.radial: the pressure"),
    }[where]
    with pytest.raises(wo.InvalidProblem, match=rf"{computed}.*stack law.*4.455e\+05 "):
        wo.solve(problem, nodes=17)
    light = wo.solve(problem.replace(nip_load=300.0), nodes=17)
    assert light.residuals.largest <= 1e-8
