"""Viscoelastic data as tables and programs give them: relative lists, tan delta, relaxation."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from thesis_cases import newsprint_nip
from viscoelastic_cases import cover

import woundon as wo
from woundon.elasticity.prony_fit import complex_modulus, usable_range
from woundon.io.case_texts import to_toml

Array = np.ndarray

HZ = np.logspace(0, 4, 25)
TERMS = ((2e6, 3e-2), (4e6, 1e-4))
E_INF = 5e6


def exact(frequency: Array) -> Array:
    """E(i omega) of a Prony series, complex [Pa]."""
    w = 2j * pi * frequency
    return np.asarray(E_INF + sum(E * w * tau / (1 + w * tau) for E, tau in TERMS))


def dynamic_test(**changes: Any) -> wo.DynamicTest:
    """A test of that material, with the columns changed or left out (None)."""
    E = exact(HZ)
    columns = {"frequency": HZ, "storage_modulus": E.real, "loss_modulus": E.imag} | changes
    return wo.DynamicTest(poissons_ratio=0.48, **columns)


def nip(material: wo.Material, **changes: Any) -> wo.NipProblem:
    return newsprint_nip(drum=cover(material), web_speed=5.0, **changes)


# ---- relative lists -----------------------------------------------------------------------------


def test_a_relative_list_is_that_of_absolute_moduli() -> None:
    """E_k = g_k E_0 and E_inf = E_0 (1 - sum g): conversion."""
    relative = wo.RelativeProny(
        instantaneous_modulus=10e6, poissons_ratio=0.45, prony_relative=[(0.3, 1e-3), (0.1, 1e-2)]
    )
    absolute = wo.Isotropic(
        youngs_modulus=6e6, poissons_ratio=0.45, prony=[(3e6, 1e-3), (1e6, 1e-2)]
    )
    one, two = (wo.solve(nip(each), nodes=17) for each in (relative, absolute))
    assert one.rolling_resistance > 1
    assert one.rolling_resistance == pytest.approx(two.rolling_resistance, rel=1e-10)
    assert one.wound_on_tension == pytest.approx(two.wound_on_tension, rel=1e-10)


# ---- dynamic tests ------------------------------------------------------------------------------


def test_tan_delta_takes_the_place_of_the_loss_modulus() -> None:
    E = exact(HZ)
    by_loss = dynamic_test()
    by_tangent = dynamic_test(loss_modulus=None, tan_delta=E.imag / E.real)
    np.testing.assert_allclose(by_tangent.prony_series, by_loss.prony_series, rtol=1e-6)
    # instruments write all three, with a few digits
    both = dynamic_test(tan_delta=np.round(E.imag / E.real, 3))
    assert both.prony_series == by_loss.prony_series


def test_rows_are_sorted_whatever_their_order() -> None:
    """Instruments sweep down, and some at random."""
    E, order = exact(HZ), np.random.default_rng(0).permutation(HZ.size)
    shuffled = dynamic_test(
        frequency=HZ[order], storage_modulus=E.real[order], loss_modulus=E.imag[order]
    )
    assert shuffled == dynamic_test()
    falling = dynamic_test(
        frequency=HZ[::-1], storage_modulus=E.real[::-1], loss_modulus=E.imag[::-1]
    )
    assert falling.measured_frequencies == (HZ[0], HZ[-1])


def test_angular_frequencies_are_converted() -> None:
    angular = dynamic_test(frequency=[f"{2 * pi * f!r} rad/s" for f in HZ.tolist()])
    np.testing.assert_allclose(angular.frequency, HZ, rtol=1e-14)


def test_a_table_with_tan_delta_in_a_case_file(tmp_path: Path) -> None:
    E = exact(HZ)
    rows = zip(2 * pi * HZ[::-1], E.real[::-1] / 1e6, (E.imag / E.real)[::-1], strict=True)
    table = "frequency [rad/s],storage_modulus [MPa],tan_delta\n"
    table += "".join(f"{f:.9g},{storage:.9g},{tangent:.9g}\n" for f, storage, tangent in rows)
    (tmp_path / "rubber.csv").write_text(table)
    text = to_toml(nip(dynamic_test(), roll_wrap=pi))
    head, _, tail = text.partition("[drum.material]")
    following = tail.partition("\n[")[2]
    case = f"{head}[drum.material]\nkind = 'dynamic_test'\npoissons_ratio = 0.48\n"
    case += "csv = 'rubber.csv'\n" + (f"[{following}" if following else "")
    (tmp_path / "case.toml").write_text(case)
    drum: Any = wo.load_case(tmp_path / "case.toml").drum
    assert len(drum.material.tan_delta) == HZ.size
    f = np.array([3.0, 300.0])
    np.testing.assert_allclose(complex_modulus(drum.material._fit, f), exact(f), rtol=0.01)


def contradictory_table() -> tuple[Array, Array, Array]:
    """A master curve of 26 decades with losses four times too high outside 1 to 1e5 Hz."""
    f = np.logspace(-12, 14, 206)
    tau, E = np.logspace(-16, 14, 121), 1e6 + np.zeros(f.size, dtype=complex)
    for t in tau:
        E += 2e6 * 2j * pi * f * t / (1 + 2j * pi * f * t)
    loss = np.where((f < 1) | (f > 1e5), 4.0, 1.0) * E.imag
    return f, E.real, loss


def test_a_master_curve_of_many_decades_is_rejected_with_the_range_that_can_be_used() -> None:
    f, storage, loss = contradictory_table()
    columns = {"frequency": f, "storage_modulus": storage, "loss_modulus": loss}
    with pytest.raises(wo.InvalidProblem) as rejected:
        dynamic_test(**columns)
    text = str(rejected.value)
    assert "frequency_range = [1, 100000]" in text
    assert "from 1e" in text  # the bias by decade
    assert "two decades below V/2a" in text
    accepted = dynamic_test(**columns, frequency_range=["1 Hz", "100 kHz"])
    assert accepted.misfit < 0.05
    low, high = accepted.measured_frequencies
    assert 1 <= low < 2
    assert 5e4 < high <= 1e5


def test_no_range_of_an_inconsistent_table_is_offered() -> None:
    f = np.logspace(0, 5, 61)
    loss = np.where(np.arange(61) % 2, 1e7, 1e5)  # no decade is causal
    assert usable_range(f, np.full(61, 1e7), loss, 0.05) is None


# ---- relaxation tests ---------------------------------------------------------------------------


def relaxation(t: Array) -> Array:
    """E(t) of 30 decades of relaxation times [Pa]."""
    tau = np.logspace(-4, 28, 65)
    return np.asarray(1e6 + 3e7 * np.exp(-t[:, None] / tau).sum(axis=1))


def test_a_relaxation_test_over_thirty_decades_with_scatter() -> None:
    """A modulus that rises by its scatter is no error."""
    t = np.logspace(np.log10(2.8e-3), 28, 481)
    scatter = np.random.default_rng(1).normal(size=t.size)
    modulus = relaxation(t) * (1 + 1e-3 * scatter)
    assert (np.diff(modulus) > 0).any()
    test = wo.RelaxationTest(time=t, modulus=modulus, poissons_ratio=0.48)
    assert test.misfit < 1.2e-3  # the scatter, and the fit's own error of 1e-4
    with np.errstate(under="ignore"):
        series = sum(E * np.exp(-t / tau) for E, tau in test.prony_series)
    fitted = test.long_term_modulus + series
    np.testing.assert_allclose(fitted, relaxation(t), rtol=2e-3)  # twice the scatter


def test_relaxation_and_dynamic_test_of_one_material_agree() -> None:
    t = np.logspace(-6, 1, 60)
    modulus = E_INF + sum(E * np.exp(-t / tau) for E, tau in TERMS)
    test = wo.RelaxationTest(time=t[::-1], modulus=modulus[::-1], poissons_ratio=0.48)
    assert test.measured_frequencies == pytest.approx((1 / (2 * pi * 10), 1 / (2 * pi * 1e-6)))
    one, two = (wo.solve(nip(each), nodes=17) for each in (test, dynamic_test()))
    # both series follow their table to 0.5 %
    assert one.rolling_resistance == pytest.approx(two.rolling_resistance, rel=0.02)
    assert one.nip_width == pytest.approx(two.nip_width, rel=0.002)


def test_a_nip_beyond_the_times_of_a_relaxation_test_is_reported() -> None:
    t = np.logspace(-2, 3, 30)
    test = wo.RelaxationTest(time=t, modulus=5e6 + 5e6 * t**-0.1, poissons_ratio=0.48)
    with pytest.warns(wo.ValidityWarning, match="from 0.000159 to 15.9 Hz"):
        wo.solve(nip(test), nodes=17)
