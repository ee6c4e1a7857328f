"""Viscoelastic materials and problems: what is admitted, read, written and reported."""

from __future__ import annotations

from math import atan, pi, tan
from typing import Any

import numpy as np
import pytest
from derivatives import check_sensitivity
from thesis_cases import newsprint_nip
from viscoelastic_cases import cover, rubber

import woundon as wo
from woundon.elasticity.mesh import Wrap, nip_mesh
from woundon.elasticity.relaxation import modulus_ratio

# a measured rubber, compound unknown
HZ = [1.0, 10.0, 100.0, 968.0, 7030.0]
STORAGE = [8.93e6, 9.94e6, 12.3e6, 15.0e6, 18.8e6]
LOSS = [1.21e6, 1.61e6, 2.13e6, 3.38e6, 5.35e6]


def nip(**changes: Any) -> wo.NipProblem:
    return newsprint_nip(drum=cover(rubber()), web_speed=5.0, **changes)


def dynamic_test(**known: Any) -> wo.DynamicTest:
    table = {"frequency": HZ, "storage_modulus": STORAGE, "loss_modulus": LOSS}
    return wo.DynamicTest(**table | known, poissons_ratio=0.48)


# ---- materials ----------------------------------------------------------------------------------


def test_a_loss_angle_is_that_at_its_frequency_and_the_largest() -> None:
    material = wo.LossAngle(
        youngs_modulus=5e6, poissons_ratio=0.45, loss_angle=0.2, frequency=100.0
    )

    def loss(hertz: float) -> float:
        E = modulus_ratio(material.relaxation(1.0), np.array([2 * pi * hertz]))[0]
        return float(E.imag / E.real)

    assert loss(100.0) == pytest.approx(tan(0.2), rel=1e-12)
    assert max(loss(90.0), loss(110.0)) < loss(100.0)


def test_a_dynamic_test_is_followed() -> None:
    """A table of a Prony series comes back from the series fitted to it."""
    E, w = 5e6, 2j * pi * np.logspace(0, 4, 30)
    exact = E + sum(e * w * t / (1 + w * t) for e, t in ((2e6, 3e-2), (4e6, 1e-4)))
    material = dynamic_test(
        frequency=np.logspace(0, 4, 30), storage_modulus=exact.real, loss_modulus=exact.imag
    )
    assert material.misfit < 0.01
    found = material.long_term_modulus * modulus_ratio(material.relaxation(1.0), (w / 1j).real)
    assert np.max(np.abs(found / exact - 1)) < 0.01
    assert all(modulus > 0 for modulus, _ in material.prony_series)


def test_a_poor_fit_is_reported_with_every_result() -> None:
    poor = dynamic_test(loss_modulus=[1.25 * value for value in LOSS])
    assert 0.05 < poor.misfit < 0.1
    with pytest.warns(
        wo.ValidityWarning, match="the drum: its Prony series deviates from the measured"
    ):
        result = wo.solve(nip(**{"drum.material": poor}), nodes=17)
    assert any(f"{poor.misfit:.1%}" in text for text in result.warnings)
    assert dynamic_test().misfit < 0.05
    assert dynamic_test().validity_warning == ""


@pytest.mark.parametrize(("highest", "is_known"), [(10.0, False), (1e5, True)])
def test_a_nip_beyond_the_measured_frequencies_is_reported(highest: float, is_known: bool) -> None:
    """A constant loss angle, E* = E_1 (i f)^n: tan(n pi/2) = 0.15 and |E*| = 4 MPa at 1 Hz."""
    n = 2 * atan(0.15) / pi
    f = np.logspace(-1, np.log10(highest), 31)
    modulus = 4e6 * (1j * f) ** n
    material = dynamic_test(frequency=f, storage_modulus=modulus.real, loss_modulus=modulus.imag)
    problem = nip(**{"drum.material": material}).replace(web_speed=30.0)
    result = wo.solve(problem, nodes=17)
    text = f"V/2a = {30 / result.nip_width:.3g} Hz on"
    assert 1e3 < 30 / result.nip_width < 5e3
    assert any(text in warning for warning in result.warnings) is not is_known
    # the loss at V/2a, which the series of the short table lacks
    assert (result.rolling_resistance > 10) is is_known


@pytest.mark.parametrize(("share", "is_known"), [(0.02, False), (0.5, True), (50.0, False)])
def test_a_loss_angle_far_from_the_nip_is_reported(share: float, is_known: bool) -> None:
    """The loss of its single relaxation time is less than that of a rubber there."""
    material = wo.LossAngle(
        youngs_modulus=5e6, poissons_ratio=0.45, loss_angle=0.2, frequency=share * 450.0
    )  # V/2a is 450 Hz within a third
    result = wo.solve(nip(**{"drum.material": material}), nodes=17)
    assert 300 < 5.0 / result.nip_width < 600
    assert any("V/2a" in text for text in result.warnings) is not is_known


# ---- cases, studies, reports, files -------------------------------------------------------------


def test_a_sweep_over_speed() -> None:
    table = wo.sweep(
        nip(), over={"web_speed": [1.0, 30.0]},
        outputs=["nip_width", "rolling_resistance", "dissipated_power", "pressure_shift"], nodes=17,
    ).to_dataframe()  # fmt: skip
    assert table["nip_width"].iloc[0] > table["nip_width"].iloc[1]  # stiffer in a hurry
    np.testing.assert_allclose(
        table["dissipated_power"], table["rolling_resistance"] * [1.0, 30.0], rtol=1e-12
    )
    assert (table["pressure_shift"] < 0).all()


@pytest.mark.parametrize("kind", ["nip", "rollers", "wrapped"])
def test_the_balance_of_power_converges_with_the_mesh(kind: str) -> None:
    """The power put in by the loads is that dissipated by slip and in the covers: conservation."""
    rollers = wo.RollerProblem(
        upper=wo.Rigid(radius=0.2), lower=cover(rubber()), load=2e3, friction=0.3,
        tangential_load=300.0, speed=5.0,
    )  # fmt: skip
    plain = nip(winding_force=-200.0)
    cases = {
        "nip": plain,
        "rollers": rollers,
        "wrapped": plain.replace(roll_wrap=pi, drum_wrap=0.5),
    }
    left = []
    for nodes in (33, 129):
        result: Any = wo.solve(cases[kind], nodes=nodes)
        left.append(dict(result.consistency.items())["power_balance"])
        wrong = result.replace(rolling_resistance=1.01 * result.rolling_resistance)
        assert result.residuals.largest <= 1e-8
        computed, tolerance = wrong.recomputed().get("rolling_resistance", (float("nan"), 0.0))
        found = (
            wrong.certified().largest > 1e-8
            or not abs(computed - wrong.rolling_resistance) <= tolerance
        )
        assert found
    # meshes four times as fine: of first order or better, with room for moving zone boundaries
    assert left[1] < 0.4 * left[0]
    assert left[1] < 1e-3


@pytest.mark.parametrize(
    "name", ["web_speed", "drum.material.prony.0.modulus", "drum.material.prony.1.time"]
)
@pytest.mark.parametrize("wrapped", [False, True])
def test_exact_sensitivities(wrapped: bool, name: str) -> None:
    problem = nip().replace(roll_wrap=pi) if wrapped else nip()
    check_sensitivity(wo.solve(problem, nodes=33), [name], rtol=2e-4)


def test_bodies_without_a_speed_answer_relaxed() -> None:
    face = nip_mesh(17, Wrap(), Wrap()).roll_face
    none = np.zeros(17)
    one, two = (cover(m).surface(face, 0.005).tangent(none, none) for m in (rubber(), rubber(None)))
    for x, y in zip(one, two, strict=True):
        assert np.array_equal(x, y)
