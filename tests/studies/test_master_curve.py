"""Master curves: shifts and moduli of known materials, tables, what is rejected."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from slow_cases import campaign_case
from study_master_curves import FREQUENCIES, Rubber, campaign
from thesis_cases import newsprint_nip
from viscoelastic_cases import cover

import woundon as wo

Array = np.ndarray

TEMPERATURES = (10.0, 25.0, 40.0, 55.0)


def rubber() -> Rubber:
    return Rubber.random(np.random.default_rng(3))


def exact_isotherms() -> dict[float, dict[str, Array]]:
    """Isotherms without scatter."""
    tables = {}
    for T in TEMPERATURES:
        E = rubber().modulus(10 ** float(rubber().shift(np.array(T))) * FREQUENCIES)
        tables[T] = {
            "frequency": FREQUENCIES, "storage_modulus": E.real, "loss_modulus": E.imag
        }  # fmt: skip
    return tables


def one_table(columns: tuple[str, str, str, str], loss: str = "loss_modulus") -> pd.DataFrame:
    """Return all isotherms below each other, the hottest first, frequencies falling."""
    frames = []
    drift = np.random.default_rng(0).uniform(-0.3, 0.3, FREQUENCIES.size)
    for T, table in sorted(exact_isotherms().items(), reverse=True):
        values = table[loss] if loss in table else table["loss_modulus"] / table["storage_modulus"]
        cells = (T + drift, 2 * np.pi * table["frequency"], table["storage_modulus"] / 1e6, values)
        frames.append(pd.DataFrame(dict(zip(columns, cells, strict=True))).iloc[::-1])
    return pd.concat(frames)


# ---- known materials ----------------------------------------------------------------------------


@pytest.mark.parametrize("shifts", ["free", "wlf"])
def test_shifts_and_moduli_without_scatter(shifts: Any) -> None:
    """The law by which the isotherms were made comes back: known solution."""
    curve = wo.master_curve(exact_isotherms(), "40 degC", shifts=shifts)
    exact = rubber().shift(np.array(TEMPERATURES))
    np.testing.assert_allclose(curve.shifts, exact, atol=2e-3)  # the series' own error, 0.1 %
    assert curve.misfit < 2e-3
    E = rubber().modulus(curve.frequency)
    np.testing.assert_allclose(curve.storage_modulus, E.real, rtol=5e-3)
    if shifts == "wlf":
        assert curve.wlf == pytest.approx((rubber().C1, rubber().C2), rel=0.05)
        assert float(curve.shift_at(32.5)) == pytest.approx(float(rubber().shift(32.5)), abs=2e-3)


@pytest.mark.parametrize(
    ("shifts", "cases"),
    [("free", 6), ("wlf", 6), campaign_case("free", 200), campaign_case("wlf", 200)],
)
def test_random_rubbers_with_a_scatter_of_three_percent(shifts: Any, cases: int) -> None:
    """Asked: moduli at V/2a within 5 %, shifts within 0.1 decades.  Found: 4 % and 0.06."""
    errors = campaign(cases, 0, shifts)
    assert max(error.shift for error in errors) <= 0.1
    assert max(error.modulus for error in errors) <= 0.05
    # standard errors are right: three of them are exceeded by one of 370 shifts
    assert np.mean([error.in_errors > 3 for error in errors]) <= 0.05


def test_the_master_curve_serves_a_nip_that_one_isotherm_does_not() -> None:
    """The warning on frequencies names the remedy, and disappears with it."""
    isotherms = exact_isotherms()
    alone = wo.DynamicTest(**isotherms[40.0], poissons_ratio=0.48)
    curve = wo.master_curve(isotherms, 40.0)
    results = []
    for material in (alone, curve.material(0.48)):
        problem = newsprint_nip(drum=cover(material), web_speed=20.0)
        with pytest.warns(wo.ValidityWarning) if material is alone else no_warning():
            results.append(wo.solve(problem, nodes=17))
    extrapolated, known = (
        [text for text in result.warnings if "V/2a" in text] for result in results
    )
    frequency = f"{20 / results[0].nip_width:.3g} Hz"
    assert len(extrapolated) == 1
    assert "wo.master_curve" in extrapolated[0]
    assert frequency in extrapolated[0]
    assert "from 0.1 to 100 Hz" in extrapolated[0]
    assert known == []
    # the loss that the series of one isotherm lacks
    assert results[1].rolling_resistance > 2 * results[0].rolling_resistance


def no_warning() -> Any:
    import warnings

    context = warnings.catch_warnings()
    warnings.simplefilter("error", wo.ValidityWarning)
    return context


# ---- tables -------------------------------------------------------------------------------------


@pytest.mark.parametrize("loss", ["loss_modulus", "tan_delta"])
def test_one_table_with_drifting_temperatures(tmp_path: Path, loss: str) -> None:
    """Instruments hold a temperature within tenths of a kelvin and sweep down, in rad/s."""
    unit = " [Pa]" if loss == "loss_modulus" else ""
    headers = ("temperature [degC]", "frequency [rad/s]", "storage_modulus [MPa]", loss + unit)
    one_table(headers, loss).to_csv(tmp_path / "sweeps.csv", index=False)
    curve = wo.master_curve(tmp_path / "sweeps.csv", 40.0)
    np.testing.assert_allclose(curve.temperatures, TEMPERATURES, atol=0.2)
    other = wo.master_curve(exact_isotherms(), 40.0)
    # the mean temperature of the isotherm at 40 degC is another one by 0.05 K
    np.testing.assert_allclose(curve.shifts - curve.shifts[0], other.shifts - other.shifts[0],
                               atol=1e-3)  # fmt: skip


def test_a_file_for_each_temperature(tmp_path: Path) -> None:
    files = {}
    for T, table in exact_isotherms().items():
        files[f"{T:g} degC"] = tmp_path / f"{T:g}.csv"
        frame = pd.DataFrame(table)
        frame.columns = ["f [Hz]", "E' [Pa]", "E'' [Pa]"]
        frame.to_csv(files[f"{T:g} degC"], index=False)
    curve = wo.master_curve(files, "25 degC")
    np.testing.assert_allclose(curve.shifts, wo.master_curve(exact_isotherms(), 25.0).shifts)


def test_the_saved_curve_is_read_by_a_case_file(tmp_path: Path) -> None:
    curve = wo.master_curve(exact_isotherms(), 40.0)
    curve.save(tmp_path / "cover.csv")
    (tmp_path / "case.toml").write_text(CASE)
    drum: Any = wo.load_case(tmp_path / "case.toml").drum
    assert drum.material == curve.material(0.48)


CASE = """
schema = 1
roll_friction = 0.19
drum_friction = 0.2
nip_load = "3.5 kN/m"
web_tension = "350 N/m"
web_speed = "10 m/s"
web = { thickness = "66 um", material = "newsprint" }
roll = { radius = "100 mm", core_radius = "44.5 mm", material = "newsprint" }
drum.radius = "250 mm"
drum.core_radius = "235 mm"
drum.material = { kind = "dynamic_test", csv = "cover.csv", poissons_ratio = 0.48 }
"""


# ---- what is rejected and remarked on -----------------------------------------------------------


def test_isotherms_that_do_not_overlap_are_rejected() -> None:
    tables = exact_isotherms()
    short = {
        T: {name: values[:4] for name, values in tables[T].items()} for T in (10.0, 55.0)
    }  # 0.3 decades each, at a shift of 3
    with pytest.raises(wo.InvalidProblem, match="measure at a temperature between them"):
        wo.master_curve(short, 10.0)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"reference_temperature": 90.0}, "reference_temperature: 90 is out of range"),
        ({"shifts": "arrhenius"}, "shifts"),
        ({"isotherms": {10.0: exact_isotherms()[10.0]}}, "1 given; must be at least 2"),
        ({"isotherms": exact_isotherms()[10.0]}, "has no column temperature"),
        ({"isotherms": {10.0: {"frequency": [1.0], "storage_modulus": [1e6]},
                        20.0: {"frequency": [1.0], "storage_modulus": [1e6]}}},
         "has no column loss_modulus or tan_delta"),
        ({"isotherms": {T: {name: np.repeat(values, 2) for name, values in table.items()}
                        for T, table in exact_isotherms().items()}}, "measured twice"),
    ],
)  # fmt: skip
def test_rejected_arguments(changes: dict[str, Any], text: str) -> None:
    arguments = {"isotherms": exact_isotherms(), "reference_temperature": 40.0} | changes
    with pytest.raises(wo.InvalidProblem, match=text):
        wo.master_curve(**arguments)


WARM, HOT = (exact_isotherms()[T] for T in (10.0, 25.0))


@pytest.mark.parametrize(
    ("isotherms", "reference", "text"),
    [
        ({"40 degF": WARM, "70 degF": HOT}, 40.0, "isotherms: '40 degF' is in degF; must be in"),
        ({10.0: WARM, 25.0: HOT}, "60 \N{DEGREE SIGN}F", "reference_temperature: '60 .F' is in .F"),
        ({"10 degC": WARM, 15: HOT, "303 K": HOT}, 12.0, "isotherms: temperatures are in K and"),
        ({"10 degC": WARM, "25 degC": HOT}, "290 K", "are in K and degC; must be in one scale"),
        ({float("nan"): WARM, 25.0: HOT}, 20.0, "isotherms: nan is not a temperature; must be in"),
        ({"zero": WARM, 25.0: HOT}, 20.0, "isotherms: 'zero' is not a temperature; must be in"),
        ({"zero": WARM, "ten": HOT}, 20.0, "isotherms: 'zero' is not a temperature; must be in"),
        ({"10": WARM, 25.0: HOT}, 20.0, "isotherms: '10' has no unit; must be in degC or K"),
        ({"25 degC": WARM, 25: HOT}, 25.0, "isotherms: 25 is given twice"),
        ({10.0: WARM, 25.0: HOT}, None, "reference_temperature: None is not a temperature"),
    ],
)
def test_temperatures_of_other_scales_are_rejected(
    isotherms: Any, reference: Any, text: str
) -> None:
    """40 degF is 4.44 degC, not 22.2: scales differ by their zeros, which no factor converts."""
    with pytest.raises(wo.InvalidProblem, match=text) as caught:
        wo.master_curve(isotherms, reference)
    assert "difference" not in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("in_cells", [False, True])
@pytest.mark.parametrize(("unit", "text"), [("degF", "is in degF"), ("K", "are in K and degC")])
def test_scales_of_a_file(tmp_path: Path, unit: str, text: str, in_cells: bool) -> None:
    header = "temperature" if in_cells else f"temperature [{unit}]"
    frame = one_table((header, "frequency [rad/s]", "storage_modulus [MPa]", "loss_modulus [Pa]"))
    if in_cells:
        frame[header] = [f"{T} {unit}" for T in frame[header]]
    frame.to_csv(tmp_path / "sweeps.csv", index=False)
    with pytest.raises(wo.InvalidProblem, match=text):
        wo.master_curve(tmp_path / "sweeps.csv", "40 degC")


@pytest.mark.parametrize(
    ("path", "text"),
    [
        (None, "path: None is out of place"),
        ("cover.json", "the ending '.json' is not a known format; must be .csv"),
        ("nodir/cover.csv", "the folder '.*nodir' does not exist"),
    ],
)
def test_paths_of_no_table_are_rejected(tmp_path: Path, path: Any, text: str) -> None:
    curve = wo.master_curve(exact_isotherms(), 40.0)
    with pytest.raises(wo.InvalidProblem, match=text):
        curve.save(path and tmp_path / path)
    assert list(tmp_path.iterdir()) == []


def test_vertical_shifts_are_remarked_on() -> None:
    """Moduli that fall by a third from one isotherm to the next as well: no superposition."""
    tables = {
        T: table | {"storage_modulus": table["storage_modulus"] * (1 - 0.1 * k)}
        for k, (T, table) in enumerate(exact_isotherms().items())
    }
    remarks = wo.master_curve(tables, 40.0).remarks()
    assert any("vertical shifts are not applied" in text for text in remarks)
    assert wo.master_curve(exact_isotherms(), 40.0).remarks() == []


def test_answer_and_figure() -> None:
    curve = wo.master_curve(exact_isotherms(), 40.0, shifts="wlf")
    assert [line for line in curve.answer() if line.startswith("T = 25 degC:")]
    figure = curve.plot()
    moduli, shifts = figure.axes[:2]
    assert moduli.get_xscale() == moduli.get_yscale() == "log"
    points = [line for line in moduli.get_lines() if line.get_linestyle() == "None"]
    assert sum(len(line.get_xdata()) for line in points) == 2 * curve.frequency.size
    assert len(shifts.get_lines()) >= 2  # isotherms and law
    plt.close(figure)


@pytest.mark.parametrize("scale", ["degC", "K"])
def test_temperatures_are_shown_in_their_scale(scale: str) -> None:
    tables = {f"{T:g} {scale}": table for T, table in exact_isotherms().items()}
    curve = wo.master_curve(tables, f"40 {scale}")
    assert curve.scale == scale
    assert f"Hz at 40 {scale} from" in curve.answer()[0]
    figure, printed = curve.plot(), scale.replace("deg", "°")
    moduli, shifts = figure.axes[:2]
    assert moduli.get_ylabel() == f"Moduli at 40 {printed} [MPa]"
    assert shifts.get_xlabel() == f"Temperature $T$ [{printed}]"
    assert f"$T$ = 25 {printed}" in {line.get_label() for line in moduli.get_lines()}
    plt.close(figure)


def test_the_moduli_are_found_below_a_longer_block_of_an_instrument(tmp_path):
    """By the names of the columns, as in logs and compression tests."""
    f = np.logspace(-1, 2, 13)
    rows = [f"{T},{x},{1e7 * (a * x) ** 0.2},0.325" for T, a in ((20, 10.0), (40, 1.0)) for x in f]
    specimen = ["length,width,height,mass", *(["12,5,2,3"] * 60), ""]
    header = "temperature [degC],frequency [Hz],storage_modulus [Pa],tan_delta"
    (tmp_path / "moduli.csv").write_text("\n".join([*specimen, header, *rows]), encoding="utf-8")
    with pytest.warns(wo.InputWarning, match="above the header"):
        curve = wo.master_curve(tmp_path / "moduli.csv", 40)
    assert curve.temperatures.tolist() == [20, 40]
    assert curve.frequency.size == 26
