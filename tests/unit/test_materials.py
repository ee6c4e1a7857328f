"""Materials: plane-strain stiffness against its inverse relations, and the library's sources."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import woundon as wo
from woundon.elasticity.strip import compliance
from woundon.problems.materials import MATERIALS

ratio = st.floats(0, 0.499)
modulus = st.floats(1e4, 1e12)


@given(E=modulus, nu=ratio)
def test_isotropic_stiffness_inverts_plane_strain_hookes_law(E: float, nu: float) -> None:
    # eps_x = (1 - nu^2)/E (s_x - nu/(1 - nu) s_y), gamma = 2 (1 + nu)/E tau
    material = wo.Isotropic(youngs_modulus=E, poissons_ratio=nu)
    rr, tt, rt, shear, _ = material.stiffness
    direct = (1 - nu**2) / E
    law = np.array([[direct, -nu * (1 + nu) / E], [-nu * (1 + nu) / E, direct]])
    # cancellation in A_rr^2 - A_rt^2 grows like 1/(1 - 2 nu)
    rounding = 1e-15 / (1 - 2 * nu)
    np.testing.assert_allclose(law @ [[rr, rt], [rt, tt]], np.eye(2), atol=8 * rounding)
    assert shear == pytest.approx(E / (2 * (1 + nu)), rel=1e-15)
    # an isotropic solid has one modulus less: A_rr - A_rt = 2 G
    assert rr - rt == pytest.approx(2 * shear, rel=8 * rounding)
    c = compliance(rr, tt, rt)
    assert c.c11 == pytest.approx(direct, rel=8 * rounding)
    assert c.c12 == pytest.approx(-nu * (1 + nu) / E, rel=8 * rounding, abs=1e-15 / E)
    assert c.c22 == c.c11


@given(radial=modulus, tangential=modulus, share=st.floats(0, 0.999), shear=modulus)
def test_orthotropic_stiffness_is_as_given_and_positive(
    radial: float, tangential: float, share: float, shear: float
) -> None:
    cross = share * sqrt(radial * tangential)
    material = wo.Orthotropic(radial=radial, tangential=tangential, cross=cross, shear=shear)
    assert material.stiffness[:4] == (radial, tangential, cross, shear)
    rr, tt, rt, *_ = material.stiffness
    assert np.linalg.eigvalsh([[rr, rt], [rt, tt]]).min() > 0
    c = compliance(rr, tt, rt)
    product = np.array([[rr, rt], [rt, tt]]) @ [[c.c22, c.c12], [c.c12, c.c11]]
    # the entries differ by the square root of the stiffnesses' ratio; rounding by 1/(1 - share^2)
    balance = sqrt(tt / rr)
    np.testing.assert_allclose(
        product * [[1, balance], [1 / balance, 1]], np.eye(2), atol=1e-14 / (1 - share**2)
    )


def test_the_bound_of_the_cross_stiffness_is_sharp() -> None:
    fields = {"radial": 20e6, "tangential": 3e9, "shear": 10e6}
    limit = sqrt(20e6 * 3e9)
    wo.Orthotropic(cross=limit * (1 - 1e-8), **fields)
    for cross in (limit * (1 - 1e-10), limit, 1.5 * limit):
        with pytest.raises(wo.InvalidProblem, match=r"cross: .*sqrt\(radial \* tangential\)"):
            wo.Orthotropic(cross=cross, **fields)


def test_the_library_is_what_its_sources_say() -> None:
    # Jorkama 2001: Table 1, Table 2, ch. 1.2 (Fig. 5) and ch. 4.6 (Figs 25, 26)
    table_1, table_2 = wo.material("paper"), wo.material("newsprint")
    assert table_1.stiffness[:4] == (20e6, 3e9, 5e6, 10e6)
    assert table_2.stiffness[:4] == (27e6, 3.38e9, 5e6, 10e6)
    isotropic = {
        "steel": (206e9, 0.3),
        "hard-drum": (211e9, 0.3),
        "soft-cover": (10e6, 0.1),
        "rubber": (1e6, 0.499),
        "cellular-elastomer": (1e6, 0.1),
    }
    for name, (E, nu) in isotropic.items():
        assert wo.material(name) == wo.Isotropic(youngs_modulus=E, poissons_ratio=nu)
    thesis = {name for name, known in MATERIALS.items() if "Jorkama 2001, " in known.source}
    assert thesis == {"paper", "newsprint", *isotropic}
    assert all(known.spread for name, known in MATERIALS.items() if name not in thesis)


@pytest.mark.parametrize("name", MATERIALS)
def test_every_named_material_works_as_web_roll_and_drum(name: str) -> None:
    problem = wo.NipProblem(
        web=wo.Web(thickness=66e-6, material=name),
        roll=wo.Cylinder(radius=0.3, core_radius=0.05, material=name),
        drum=wo.HalfPlane(radius=0.5, material=name),
        roll_friction=0.2,
        drum_friction=0.3,
        nip_load=500.0,
        roll_wrap=0.0,
    )
    assert problem.web.material is problem.roll.material is wo.material(name)
    assert wo.solve(problem, nodes=13).residuals.largest < 1e-8
