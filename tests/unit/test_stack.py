"""Stacks: their laws against derivatives, quadrature and closed forms; what is refused."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import woundon as wo
from woundon.problems.radial_laws import RadialLaw
from woundon.problems.stack import Stack

MEASURED_P = np.linspace(0, 8e5, 20)
MEASURED_E = np.log1p(MEASURED_P / 2e4) / 30

LAWS: dict[str, Any] = {
    "Pfeiffer": wo.Pfeiffer(K1=10e3, K2=40),
    "quadratic": wo.Polynomial(coefficients=[1e6, 40, 1e-5]),
    "softening": wo.Polynomial(coefficients=[1e6, 40, -1e-5]),
    "no square": wo.Polynomial(coefficients=[1e5, 300, 0, 1e-9]),
    "falling at first": wo.Polynomial(coefficients=[2e6, -4, 1e-5]),
    "a number": wo.Polynomial(coefficients=[2e6]),
    "power": wo.PowerLaw(E0=1e6, k=2e7, m=0.7),
    "power without E0": wo.PowerLaw(E0=0, k=2e7, m=0.7),
    "power, a third": wo.PowerLaw(E0=1e4, k=2e7, m=1 / 3),
    "power 1": wo.PowerLaw(E0=1e5, k=2e7, m=1),
    "power 2": wo.PowerLaw(E0=1e5, k=2e7, m=2),
    "measured": wo.StackTest(
        pressure=MEASURED_P, strain=MEASURED_E + 0.01 * np.sin(MEASURED_P / 4e5)
    ),
}
laws = pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())


def stack(**changes: Any) -> Stack:
    paper = wo.Stack(
        radial=LAWS["Pfeiffer"], tangential=3.38e9, poissons_ratio=0.01, shear=10e6
    )  # fmt: skip
    return paper.replace(**changes)


def pressures(law: RadialLaw, n: int = 41) -> np.ndarray:
    """Return pressures over the range met, and some that pull."""
    top = min(3e6, 0.999 * law.max_pressure)
    return np.concatenate([-np.geomspace(10, 1e6, 7), np.geomspace(10, top, n)])


@laws
def test_strain_is_the_integral_of_the_compliance(law: RadialLaw) -> None:
    for P in (2e3, 9e4, min(2e6, 0.99 * law.max_pressure)):
        with mpmath.workdps(20):
            ends = [0.0, *np.geomspace(1e-4, P, 20)]
            if isinstance(law, wo.StackTest):  # between the knots of its spline
                K1, spline = law._fit
                ends += [p for p in K1 * np.expm1(spline.t) if 1e-4 < p < P]
            computed = mpmath.quad(
                lambda p: 1 / mpmath.mpf(float(law.modulus(float(p)))), sorted(ends)
            )
        assert law.strain_at(P) == pytest.approx(float(computed), rel=1e-11)  # mpmath.quad's own
    assert law.strain_at(0.0) == 0.0


@laws
def test_derivatives_by_differences(law: RadialLaw) -> None:
    P = pressures(law)
    h = 1e-5 * np.abs(P)
    E = 2 * h / (law.strain_at(P + h) - law.strain_at(P - h))
    # differences: rounding of 1e-16/1e-5 and h^2; of strains that no longer grow more
    lost = 1e-15 * np.abs(law.strain_at(P)) / np.abs(2 * h / law.modulus(P))
    assert np.all(np.abs(E / law.modulus(P) - 1) < 1e-8 + 10 * lost)
    slope = (law.modulus(P + h) - law.modulus(P - h)) / (2 * h)
    size = np.maximum(np.abs(law.modulus_slope(P)), law.modulus(P) / np.abs(P))
    assert np.max(np.abs(slope - law.modulus_slope(P)) / size) < 1e-7


@laws
def test_pressure_is_the_inverse_of_strain(law: RadialLaw) -> None:
    P = np.concatenate([pressures(law), [0.0], [1.5 * law.max_pressure] * (law.max_pressure < 1e9)])
    back = law.pressure_at(law.strain_at(P))
    # rounding of the strain, as a pressure
    rounding = 1e-14 * np.abs(P) + 2e-14 * law.modulus(P) * np.abs(law.strain_at(P))
    assert np.all(np.abs(back - P) <= rounding)
    assert law.pressure_at(law.strain_at(5e4)) == pytest.approx(5e4, rel=1e-9)  # a number too


@laws
def test_a_law_keeps_a_modulus_wherever_it_is_asked(law: RadialLaw) -> None:
    P = np.concatenate([-np.geomspace(1e-3, 1e9, 50), np.geomspace(1e-3, 1e9, 50)])
    E = law.modulus(P)
    assert np.all(E > 0)
    assert np.all(np.diff(law.strain_at(np.sort(P))) >= 0)


@laws
def test_a_law_reaches_a_modulus_for_the_first_time(law: RadialLaw) -> None:
    modulus = 1.7 * float(law.modulus(1e4))
    P = law.pressure_at_modulus(modulus)
    below = np.linspace(0, min(P, 1e7), 1000)[:-1]
    assert np.all(law.modulus(below) < modulus)
    assert np.isinf(P) or law.modulus(P) == pytest.approx(modulus, rel=1e-9)
    assert law.pressure_at_modulus(0.99 * float(law.modulus(0.0))) == 0.0


@given(
    nu=st.floats(0.001, 0.3), beta=st.floats(0, 1.5), P=st.floats(1e3, 1e6), P0=st.floats(1e3, 1e6),
    stress=st.tuples(st.floats(-1e6, 1e6), st.floats(-3e5, 3e5)),
)  # fmt: skip
def test_strains_are_derivatives_of_one_energy(
    nu: float, beta: float, P: float, P0: float, stress: tuple[float, float]
) -> None:
    paper = stack(poissons_ratio=nu, shear_exponent=beta)
    assume(paper.limit > 1.1 * P)
    along, tau = stress
    K1, K2, E_t = 10e3, 40.0, 3.38e9

    def energy(P: Any, along: Any, tau: Any) -> Any:
        G = paper.shear * ((K1 + P) / (K1 + P0)) ** beta
        compressed = ((K1 + P) * mpmath.log(1 + P / K1) - P) / K2  # int F dP
        return compressed + nu / E_t * P * along + along**2 / (2 * E_t) + tau**2 / (2 * G)

    with mpmath.workdps(40):
        at = tuple(map(mpmath.mpf, (P, along, tau)))
        first = [float(mpmath.diff(energy, at, order)) for order in np.eye(3, dtype=int).tolist()]
        rr, tt, rt = (
            float(mpmath.diff(energy, (*at[:2], mpmath.mpf(0)), order))
            for order in ((2, 0, 0), (0, 2, 0), (1, 1, 0))
        )
    G, slope = paper.shear_modulus(P, P0), paper.shear_slope(P, P0)
    F = paper.radial.strain_at(P)
    assert first[0] == pytest.approx(
        F + nu / E_t * along - slope * tau**2 / (2 * G**2), rel=1e-9, abs=1e-9 * F
    )
    assert first[2] == pytest.approx(tau / G, rel=1e-12, abs=1e-20)
    # -P is the stress: the sign of the cross compliance turns round
    A = paper.tangent(P, P0)
    inverse = np.linalg.inv([[A.rr, A.rt], [A.rt, A.tt]])
    np.testing.assert_allclose(inverse, [[rr, -rt], [-rt, tt]], rtol=1e-9)
    assert A.shear == G


def test_table_2_as_a_stack() -> None:
    rr, tt, rt, G, _ = wo.material("newsprint").stiffness
    nu, E_t = rt / rr, tt - rt**2 / rr
    E_r = rr * (1 - rt**2 / (rr * tt))
    paper = stack(radial=E_r, tangential=E_t, poissons_ratio=nu, shear=G)
    assert nu == pytest.approx(5 / 27)
    for P in (0.0, 1e6):
        np.testing.assert_allclose(paper.tangent(P)[:4], (rr, tt, rt, G), rtol=1e-14)


def test_a_stack_ends_where_its_energy_does() -> None:
    paper = stack(poissons_ratio=0.2)
    # K2 (K1 + P) = E_t/nu^2
    assert paper.limit == pytest.approx(3.38e9 / 0.04 / 40 - 10e3, rel=1e-14)
    for P in np.array([0.5, 0.999, 1.0, 2.0]) * paper.limit:
        rr, tt, rt, _, _ = paper.tangent(P)
        assert rr * tt > rt**2 > 0
        assert rr > 0
    assert stack(poissons_ratio=0.0).limit == np.inf
    assert stack(radial=LAWS["measured"]).limit == 8e5
    falls = LAWS["softening"]
    assert stack(radial=falls).limit == falls.max_pressure
    assert falls.modulus(falls.max_pressure) == pytest.approx(1e4)  # 1 % of c_0


@laws
def test_without_lateral_contraction_every_modulus_is_admissible(law: RadialLaw) -> None:
    """The energy is definite for E_r < E_t/nu^2, which is infinite."""
    assert stack(radial=law, poissons_ratio=0.0).limit == law.max_pressure


def test_the_shear_modulus_is_that_of_the_wound_stack() -> None:
    paper = stack(shear_exponent=0.5)
    P = np.array([50e3, 200e3, 800e3])
    assert paper.shear_modulus(P).tolist() == [10e6] * 3
    np.testing.assert_allclose(
        paper.shear_modulus(P, 200e3), 10e6 * np.sqrt((10e3 + P) / 210e3), rtol=1e-14
    )
    h = 1e-5 * P
    slope = (paper.shear_modulus(P + h, 200e3) - paper.shear_modulus(P - h, 200e3)) / (2 * h)
    np.testing.assert_allclose(paper.shear_slope(P, 200e3), slope, rtol=1e-8)
    assert stack().shear_modulus(P, 200e3).tolist() == [10e6] * 3
    assert stack().shear_slope(P, 200e3).tolist() == [0.0] * 3


# ---- measured stacks ----------------------------------------------------------------------------


def test_a_measured_stack_of_pfeiffers_law_is_pfeiffers_law() -> None:
    law = wo.StackTest(pressure=MEASURED_P, strain=MEASURED_E + 0.3)  # measured from anywhere
    P = np.linspace(1e3, 8e5, 50)
    # the fit's K1 is found to the square root of rounding; the spline takes up the rest
    np.testing.assert_allclose(law.modulus(P), 30 * (2e4 + P), rtol=1e-5)
    assert law.misfit < 1e-8


def test_noise_does_not_make_the_modulus_jump() -> None:
    rng = np.random.default_rng(5)
    P = np.linspace(5e3, 8e5, 40)
    e = np.log1p(P / 2e4) / 30
    law = wo.StackTest(pressure=P, strain=np.maximum.accumulate(e + rng.normal(0, 1e-4, 40))
                       + np.linspace(0, 1e-9, 40))  # fmt: skip
    E = law.modulus(P) / (30 * (2e4 + P))
    assert 0.85 < E.min() < E.max() < 1.2  # neighbouring points would tell moduli 2 times off
    assert 1e-4 / e[-1] < law.misfit < 5e-4 / e[-1]
