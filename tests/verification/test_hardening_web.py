"""A web that hardens under the nip: linear limits, a closed form, its tangent, every roll and use.

The strip's law is F(p) through it and linear along it (elasticity/strip.py), from the stack's one
potential, whose derivatives tests/unit/test_stack.py takes.
"""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from coarse_solutions import coarse_solution
from derivatives import check_sensitivity
from hardening_cases import E_T, NEWSPRINT, NU, nip, roll
from slow_cases import slow_case

import woundon as wo

LINEAR = wo.NipProblem.example().replace(roll_wrap=0.0)
# 1/c22 of newsprint
E_R = NEWSPRINT.radial - NEWSPRINT.cross**2 / NEWSPRINT.tangential


def stack(radial: Any) -> wo.Stack:
    """Return newsprint with a radial law."""
    return wo.Stack(radial=radial, tangential=E_T, poissons_ratio=NU, shear=10e6)


def hardened(problem: Any, K1: float = 10e3, K2: float = 127.0) -> Any:
    """Return a nip whose web hardens."""
    return problem.replace(**{"web.material": stack(wo.Pfeiffer(K1=K1, K2=K2))})


def layered() -> wo.Layered:
    """Return a roll over a steel shell."""
    shell = wo.Layer(thickness=0.01, material="steel")
    return wo.Layered(
        radius=0.1, layers=(wo.Layer(thickness=0.0555, material=NEWSPRINT), shell), core="free"
    )


ROLLS: dict[str, wo.Body] = {
    "cylinder": LINEAR.roll,
    "half-plane": wo.HalfPlane(radius=0.1, material=NEWSPRINT),
    "layered": layered(),
    "hardening": roll(),
    "frozen": roll().replace(hardening="frozen"),
}
WRAPS: dict[str, dict[str, float]] = {
    "plain": {}, "wrapped": {"roll_wrap": pi / 2}, "both": {"roll_wrap": pi, "drum_wrap": 1.0},
}  # fmt: skip


# ---- linear limits ------------------------------------------------------------------------------


@pytest.mark.parametrize("wraps", WRAPS.values(), ids=WRAPS)
def test_a_constant_law_is_the_orthotropic_web(wraps: Any) -> None:
    problem = LINEAR.replace(**wraps)
    constant = problem.replace(**{"web.material": stack(E_R)})
    assert constant.linear
    found, wanted = (wo.solve(one, nodes=33) for one in (constant, problem))
    for name in ("nip_induced_tension", "half_width", "approach", "drum_creepage", "peak_pressure"):
        assert getattr(found, name) == pytest.approx(getattr(wanted, name), rel=1e-10)


@pytest.mark.parametrize("wraps", WRAPS.values(), ids=WRAPS)
def test_stiff_from_the_start_it_is_linear(wraps: Any) -> None:
    """K1 K2 kept and K1 -> infinity: by 1/K1, through the equations that are not linear."""
    problem = LINEAR.replace(**wraps)
    wanted, missed = wo.solve(problem, nodes=33).nip_induced_tension, []
    for K1 in (1e8, 1e9):
        found = wo.solve(hardened(problem, K1=K1, K2=E_R / K1), nodes=33)
        missed.append(abs(found.nip_induced_tension / wanted - 1))
    assert missed[0] < 2e-3
    assert missed[0] == pytest.approx(10 * missed[1], rel=0.05)


# ---- a closed form ------------------------------------------------------------------------------


def winkler(load: float, K1: float, K2: float, bed: float) -> tuple[float, Any]:
    """Return half width and pressure of a hardening web between rigid bodies.

    2h F(p) = (a^2 - x^2)/(2 R*), hence p = K1 (exp(K2 (a^2 - x^2)/bed) - 1) with bed = 4h R*.
    """
    x, w = np.polynomial.legendre.leggauss(60)

    def pressure(s: Any, a: float) -> Any:
        return K1 * np.expm1(K2 * np.maximum(a**2 - s**2, 0.0) / bed)

    low, high = 0.0, np.sqrt(bed / K2 * 20)
    for _ in range(200):
        a = (low + high) / 2
        low, high = (a, high) if a * (w @ pressure(a * x, a)) < load else (low, a)
    return a, lambda s: pressure(s, a)


def test_between_hard_bodies_it_is_pressed_point_by_point() -> None:
    """Without Poisson's ratio, a roll of 1e13 Pa: what is left falls with the cells, squared."""
    K1, K2, h2 = 20e3, 30.0, 2e-3
    soft = wo.Stack(radial=wo.Pfeiffer(K1=K1, K2=K2), tangential=3e9, poissons_ratio=0, shear=1e7)
    hard = wo.Isotropic(youngs_modulus=1e13, poissons_ratio=0.0)
    problem: Any = LINEAR.replace(
        web=wo.Web(thickness=h2, material=soft), roll=wo.HalfPlane(radius=0.1, material=hard),
        web_tension=0.0,
    )  # fmt: skip
    a, exact = winkler(problem.nip_load, K1, K2, 2 * h2 * problem.contact_radius)
    errors = []
    for nodes in (33, 65):
        found = wo.solve(problem, nodes=nodes)
        assert found.residuals.largest <= 1e-8
        peak = float(exact(0.0))
        assert peak > 10 * K1
        errors.append(np.max(np.abs(found.drum_pressure - exact(found.x - found.offset))) / peak)
        assert found.half_width == pytest.approx(a, rel=2e-3)
    assert errors[1] < 1e-3
    assert errors[0] > 3 * errors[1]


# ---- every roll, every use ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wraps", "name"),
    [(slow_case if name == "hardening" and wraps != "wrapped" else pytest.param)(WRAPS[wraps], name,
     id=f"{wraps}-{name}") for wraps in WRAPS for name in ROLLS],
)  # fmt: skip
def test_every_roll_takes_it(name: str, wraps: Any) -> None:
    problem = nip(ROLLS[name]).replace(**wraps)
    linear, found = (coarse_solution(one, 17) for one in (problem, hardened(problem)))
    assert found.residuals.largest <= 1e-8
    # soft at the edges, it makes the nip wider and the confined NIT larger, by some percent
    assert 1.01 < found.half_width / linear.half_width < 1.2
    if not wraps:
        assert found.nip_induced_tension > linear.nip_induced_tension


@pytest.mark.slow
def test_what_it_does_to_table_2() -> None:
    """Confined NIT some 12 % more at heavy load, the wrapped tension between -5 and 1 % other."""
    problem = nip(roll())
    around: Any = problem.replace(roll_wrap=pi / 2)
    one, two = (wo.solve(p, nodes=33).nip_induced_tension for p in (problem, hardened(problem)))
    assert two / one == pytest.approx(1.112, abs=0.01)
    one, two = (coarse_solution(p, 17).wound_on_tension - 350.0 for p in (around, hardened(around)))
    assert two / one == pytest.approx(1.004, abs=0.01)


def test_sensitivities_are_the_derivatives() -> None:
    names = ("K1", "K2")
    fields = [*(f"web.material.radial.{name}" for name in names), "web.material.tangential"]
    check_sensitivity(wo.solve(hardened(LINEAR), nodes=33), [*fields, "web.thickness"], rtol=1e-3)


# ---- refusals -----------------------------------------------------------------------------------


@pytest.mark.parametrize("wrapped", [False, True])
def test_a_pressure_beyond_its_law_is_rejected(wrapped: bool) -> None:
    """A test measured up to 400 kPa, a nip of 0.9 MPa."""
    P = np.linspace(0, 400e3, 9)
    test = wo.StackTest(pressure=P, strain=np.log1p(P / 10e3) / 127.0)
    problem: Any = LINEAR.replace(**{"web.material": stack(test)})
    text = r"web.material.radial: the pressure reaches .* the stack law, which ends at 4e\+05 "
    with pytest.raises(wo.InvalidProblem, match=text):
        wo.solve(problem.replace(roll_wrap=pi) if wrapped else problem, nodes=17)


def test_only_a_web_may_be_of_a_stack() -> None:
    with pytest.raises(wo.InvalidProblem, match=r"roll.material: .* LossAngle or RelativeProny"):
        LINEAR.replace(**{"roll.material": stack(E_R)})
    with pytest.raises(wo.InvalidProblem, match=r"web.material: .*\bStack\b"):
        LINEAR.replace(**{"web.material": 3.0})
