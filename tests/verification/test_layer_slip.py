"""The index of slip between the layers of the roll: Table 2, limits, and the pressure wound in."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq
from thesis_cases import newsprint_nip

import woundon as wo
from woundon.elasticity.interior_stress import half_plane_sections
from woundon.nip.layer_slip import interior_stress, wound_in_pressure

H, R = 66e-6, 0.1
NEWSPRINT = wo.material("newsprint")
FLAT = wo.HalfPlane(radius=R, material=NEWSPRINT)


def test_the_shear_below_the_nip_of_table_2():
    # Independent program, which took the tractions of the cylinder and the stresses of the
    # half-plane: 330, 404, 298, 129 and 70 kPa; 399 kPa at layer 4 with the wrap
    nip = wo.solve(newsprint_nip())
    z = H * np.array([1, 4, 16, 61, 121])
    sections = half_plane_sections(
        nip.x, nip.roll_pressure, nip.roll_traction, z, R, NEWSPRINT.stiffness
    )
    shear = [np.abs(s.shear).max() for s in sections]
    assert shear == pytest.approx([330e3, 404e3, 298e3, 129e3, 70e3], rel=3e-3)
    # less what friction carries, P0 limited to 210 kPa: 292, 349, 224, 58, 12 kPa
    P0 = np.minimum(wound_in_pressure(nip, z), 210e3)
    excess = [
        (np.abs(s.shear) - 0.19 * (P - s.normal)).max() for s, P in zip(sections, P0, strict=True)
    ]
    assert excess == pytest.approx([292e3, 349e3, 224e3, 58e3, 12e3], rel=0.01)
    wrapped = wo.solve(newsprint_nip(roll_wrap=np.pi))
    (section,) = half_plane_sections(
        wrapped.x, wrapped.roll_pressure, wrapped.roll_traction, z[1:2], R, NEWSPRINT.stiffness
    )
    assert np.abs(section.shear).max() == pytest.approx(399e3, rel=3e-3)


@pytest.mark.parametrize(
    ("roll", "ratio", "layers"), [(FLAT, 2.39, 72), (newsprint_nip().roll, 2.43, 75)]
)
def test_the_index_of_table_2(roll, ratio, layers):
    # Independent program: 2.4, to about layer 70
    slip = wo.solve(newsprint_nip(roll=roll)).layer_slip
    assert slip.ratio == pytest.approx(ratio, abs=0.01)
    assert slip.layers == pytest.approx(layers, abs=1)
    assert slip.depth == pytest.approx(slip.layers * H)
    assert 3.7 < slip.width / 5e-3 < 8
    assert f"{slip.ratio:.3g} times" in slip.warning


def test_the_index_is_the_largest_ratio_of_its_curves():
    # Consistency, and evaluation of every layer in place of interpolation
    nip = wo.solve(newsprint_nip())
    slip = nip.layer_slip
    assert slip.ratio == (slip.largest_shear / slip.friction_limit).max()
    z = H * np.arange(60, 90)
    sections, P0 = interior_stress(nip, z), wound_in_pressure(nip, z)
    excess = np.array([
        (np.abs(s.shear) - 0.19 * (P - s.normal)).max() for s, P in zip(sections, P0, strict=True)
    ])  # fmt: skip
    assert slip.layers == pytest.approx(59 + (excess > 0).sum(), abs=1)


def test_a_wrap_slips_no_layers_at_its_far_end():
    # Invariance: the length of the wrap hardly matters
    for angle in (0.5, 3.0):
        slip = wo.solve(newsprint_nip(roll_wrap=angle)).layer_slip
        assert slip.width < 0.04
        assert slip.ratio == pytest.approx(2.39, abs=0.01)


def test_the_index_does_not_depend_on_the_mesh():
    # Convergence
    coarse, fine = (wo.solve(newsprint_nip(), nodes=nodes).layer_slip for nodes in (33, 257))
    assert coarse.ratio == pytest.approx(fine.ratio, rel=2e-3)
    assert coarse.layers == pytest.approx(fine.layers, abs=1)


def test_friction_that_carries_the_shear_gives_no_warning():
    # Limit: with a friction of 10 the layers hold everywhere, and the index says nothing
    nip = wo.solve(newsprint_nip(roll_friction=10.0, drum_friction=0.01, roll_wrap=np.pi))
    assert nip.layer_slip.ratio < 1
    assert nip.layer_slip.layers == 0
    assert nip.layer_slip.warning == ""
    assert "n_slip" not in str(nip)


def test_layers_that_slip_where_the_pressure_is_low_give_a_warning():
    # Definition: the ratio is that of largest values, the count that of every point
    nip = wo.solve(newsprint_nip(roll_friction=1.0, drum_friction=0.01), nodes=33)
    slip = nip.layer_slip
    assert slip.ratio < 1 < slip.layers
    assert f"({slip.layers} layers), where the pressure is low" in slip.warning
    report = " ".join(str(nip).split())
    assert slip.warning in report
    assert "exceeds friction anywhere along the nip, also at S_tau < 1" in report


def nip_with_air(speed: float, roughness: float = 1e-6, **changes: object) -> wo.NipResult:
    return wo.solve(
        wo.NipProblem(
            grade="pet-36",
            roll=wo.HalfPlane(radius=0.2, material=wo.grade("pet-36").web().material),
            drum=wo.Cylinder(radius=0.1, core_radius=0.085, material="soft-cover"),
            nip_load=300.0,
            web_tension=150.0,
            web_speed=speed,
            air=wo.Air(roughness=roughness),
            **changes,
        ),
        nodes=33,
    )


def test_air_between_the_layers_reduces_their_friction():
    # Independent evaluation at all interfaces: the film of ambient pressure, compressed by P0 + p
    nip = nip_with_air(15.0)
    slip, h = nip.layer_slip, nip.problem.web.thickness
    z = h * np.arange(1, 100)
    sections = interior_stress(nip, z)
    dry_friction, p_a, film = nip.problem.roll_friction, 101325.0, nip.air.film
    excess, ratio, dry_ratio = [], [], []
    pressing = nip.wound_on_tension - nip.centrifugal_tension
    for section, P0 in zip(sections, pressing / h * z / 0.2, strict=True):
        shear, p = np.abs(section.shear), -section.normal
        # full friction up to a film of one roughness, none from three roughnesses on
        share = np.clip((3 - film * p_a / (p_a + P0 + p) / 1e-6) / 2, 0, 1)
        carried = dry_friction * share * (P0 + p)
        excess.append((shear - carried).max())
        ratio.append(shear.max() / carried[p.argmax()])
        dry_ratio.append(shear.max() / (dry_friction * (P0 + p.max())))
    # about every tenth interface is evaluated far below the surface: 0.1 % of the ratio, one layer
    assert slip.ratio == pytest.approx(max(ratio), rel=1e-3)
    assert slip.layers == pytest.approx((np.array(excess) > 0).sum(), abs=1)
    assert slip.ratio > 1.2 * max(dry_ratio)  # the film is 3.3 roughnesses thick
    assert slip.friction.min() < 0.85 * dry_friction


def test_layers_on_a_film_thicker_than_the_roughness_have_no_friction():
    # Limit: 30 m/s, roughness 0.3 um: without friction any shear makes the layers slip
    nip = nip_with_air(30.0, roughness=0.3e-6)
    slip = nip.layer_slip
    assert slip.ratio == np.inf
    assert slip.friction.min() == 0
    assert "no friction" in slip.warning
    report = str(nip)
    assert "inf" not in report.replace("infinit", "")
    assert "no friction" in report


def test_a_roll_without_interior_stresses_has_no_index():
    soft = wo.Cylinder(radius=0.1, core_radius=0.08, material="soft-cover")
    nip = wo.solve(newsprint_nip(roll=wo.Rigid(radius=0.1), drum=soft), nodes=33)
    assert nip.layer_slip is None
    assert "n_slip" not in str(nip)


@pytest.mark.slow
def test_the_index_is_an_output_of_studies():
    # Consistency: a sweep has the values of the results, find inverts them; nan without an index
    names = ("ratio", "layers", "depth", "width")
    loads = [876.0, 3502.0]
    data = wo.sweep(
        newsprint_nip(), {"nip_load": loads}, [f"layer_slip.{name}" for name in names], nodes=33
    )
    slips = [wo.solve(newsprint_nip(nip_load=P), nodes=33).layer_slip for P in loads]
    for name in names:
        expected = [getattr(slip, name) for slip in slips]
        # sweeps start from the neighbouring load: the tolerance of the solver
        np.testing.assert_allclose(data[f"layer_slip.{name}"], expected, rtol=1e-6)
    width = float(data["layer_slip.width"].mean())
    target = {"layer_slip.width": width}
    load = wo.find(newsprint_nip(), "nip_load", between=tuple(loads), nodes=33, **target).value
    found = wo.solve(newsprint_nip(nip_load=load), nodes=33).layer_slip
    assert found.width == pytest.approx(width, rel=1e-4)  # find ends at 1e-6 of the load
    rigid = newsprint_nip(roll=wo.Rigid(radius=0.1), drum=wo.Cylinder(
        radius=0.1, core_radius=0.08, material="newsprint"))  # fmt: skip
    none = wo.sweep(rigid, {"nip_load": [3502.0]}, ["layer_slip.ratio"], nodes=33)
    assert np.isnan(none["layer_slip.ratio"]).all()


def stack(radial: object) -> wo.Stack:
    return wo.Stack(radial=radial, tangential=3.38e9, poissons_ratio=0.01, shear=10e6)


def test_the_plateau_of_pfeiffers_law():
    # Closed form: T^2 K2/(2 E_t) = P - K1 ln(1 + P/K1)
    T = 350 / H
    for K1, K2 in ((10e3, 40.0), (1.0, 127.0), (1e6, 200.0)):
        wanted = T**2 * K2 / (2 * 3.38e9)
        exact = brentq(lambda P: P - K1 * np.log1p(P / K1) - wanted, 1e-6, 1e9, xtol=1e-6)  # noqa: B023
        assert stack(wo.Pfeiffer(K1=K1, K2=K2)).plateau_pressure(T) == pytest.approx(
            exact, rel=1e-9
        )


def test_the_plateau_of_a_constant_modulus():
    # Closed form: P = T sqrt(E_r/E_t)
    T = 350 / H
    assert stack(40e6).plateau_pressure(T) == pytest.approx(T * np.sqrt(40e6 / 3.38e9))
    assert stack(40e6).plateau_pressure(0.0) == 0


def test_the_work_of_compression():
    # Quadrature of SciPy
    law = wo.PowerLaw(E0=1e6, k=20e6, m=0.9)
    work, _ = quad(lambda P: P / law.modulus(P), 0, 3e5, epsabs=0, epsrel=1e-10)
    assert stack(law).compression_energy(3e5) == pytest.approx(work, rel=1e-9)


def test_the_pressure_wound_in():
    # Definition: T z/R, limited by the plateau and by the pressure given
    soft = stack(wo.Pfeiffer(K1=10e3, K2=40.0))
    for pressure, limit in ((1e5, 1e5), (4e5, None)):
        roll = wo.WoundRoll(radius=R, core_radius=0.0445, stack=soft, pressure=pressure)
        nip = wo.solve(newsprint_nip(roll=roll, nip_load=500.0), nodes=33)
        T = nip.outlet_tension / H
        P0 = wound_in_pressure(nip, np.array([H, 0.05]))
        assert P0[0] == pytest.approx(T * H / R)
        assert P0[1] == pytest.approx(limit or soft.plateau_pressure(T))


def test_air_lowers_the_pressure_wound_in():
    # Closed form: T^2/(2 E_t) = int P (1/E_r + (h/t) p_a/(p_a + P)^2) dP, constant E_r
    E_t, E_r, t, p_a = 3.38e9, 40e6, 20e-6, 101325.0
    web = wo.Web(thickness=t, material=wo.Stack(
        radial=E_r, tangential=E_t, poissons_ratio=0.01, shear=10e6))  # fmt: skip
    nip = nip_with_air(10.0, web=web)
    T, film = (nip.wound_on_tension - nip.centrifugal_tension) / t, nip.air.film

    def defect(P: float) -> float:
        air = film / t * p_a * (np.log1p(P / p_a) - P / (p_a + P))
        return P**2 / (2 * E_r) + air - T**2 / (2 * E_t)

    exact = brentq(defect, 0.0, T * np.sqrt(E_r / E_t))
    (P0,) = wound_in_pressure(nip, np.array([0.15]))
    assert exact < 0.9 * T * np.sqrt(E_r / E_t)
    assert pytest.approx(exact, rel=1e-6) == P0
