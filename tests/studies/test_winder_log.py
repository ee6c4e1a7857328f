"""Logs of a winder: means over the radius, their scatter, and what is left out.

Evidence: logs with a known tension over the radius and known noise; the errors of the means of
correlated noise from their closed form.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tomllib
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas
import pytest

import woundon as wo
from woundon.cli.commands import main
from woundon.errors import InputWarning, InvalidProblem
from woundon.io.case_texts import template
from woundon.io.logs import binned

WINDING = wo.WindingProblem.example()
CORE, SURFACE = 0.05, 0.6  # of the example


def growing(n: int) -> np.ndarray:
    """Return the radius of a roll that grows by the same area with each row."""
    return np.sqrt(np.linspace(CORE**2, SURFACE**2, n))


def tension(radius: np.ndarray) -> np.ndarray:
    """Return a tension that falls along a straight line from 400 N/m to 300 N/m."""
    return 400.0 - 100.0 * (radius - CORE) / (SURFACE - CORE)


def written(path: Path, columns: dict[str, np.ndarray], decimals: int = 4) -> Path:
    """Write columns as a German spreadsheet does."""
    frame = pandas.DataFrame(columns)
    frame.to_csv(path, sep=";", decimal=",", index=False, float_format=f"%.{decimals}f")
    return path


def toml(tables: dict, name: str = "") -> str:
    """Return tables as TOML: values first, then the tables in them."""
    lines = [f"[{name}]"] if name else []
    for key, value in tables.items():
        if not isinstance(value, dict):
            lines.append(f"{key} = {json.dumps(value)}")
    for key, value in tables.items():
        if isinstance(value, dict):
            lines.append(toml(value, f"{name}.{key}" if name else key))
    return "\n".join(lines)


# ---- means, scatter and errors ------------------------------------------------------------------


def test_single_precision_and_whole_numbers_are_averaged_in_double_precision():
    """Recorders store float32 and whole millimetres; float32 sums are 1e-6 off for these rows.

    The means of the bins, weighted with their rows, are the mean of all rows; double sums in
    another order differ by less than 1e-12.
    """
    n = 400_000
    noise = np.random.default_rng(3).normal(0, 5, n)
    diameter = np.round(2000 * growing(n)).astype("i4")
    tensions = (tension(growing(n)) + noise).astype("f4")
    rows = {"diameter [mm]": diameter, "web_tension [N/m]": tensions}
    bins = wo.read_log(rows, WINDING, bins=2).bins
    assert bins.rows.sum() == n
    exact = tensions.mean(dtype="f8")
    assert float(bins.mean[0] @ bins.rows) / n == pytest.approx(exact, rel=1e-12)
    assert float(bins.radius @ bins.rows) / n == pytest.approx(diameter.mean() / 2000, rel=1e-12)
    assert abs(np.add.accumulate(tensions)[-1] / n / exact - 1) > 5e-7  # what is excluded


def test_means_over_the_radius_are_those_of_the_tension(tmp_path: Path):
    """The mean of a straight line over a bin is its value at the mean radius of the bin."""
    radius = growing(4000)
    path = written(
        tmp_path / "log.csv",
        {"Zeit [s]": np.arange(4000.0), "Durchmesser [mm]": 2000 * radius,
         "Bahnzugkraft [N/m]": tension(radius)},
    )  # fmt: skip
    log = wo.read_log(path, WINDING, bins=9)
    assert log.bins.names == ("web_tension",)
    assert log.bins.rows.sum() == 4000
    # the table has four decimals
    np.testing.assert_allclose(log.bins.mean[0], tension(log.bins.radius), atol=1e-4)
    np.testing.assert_allclose(log.bins.scatter[0], 0.0, atol=1e-3)
    profile = log.problem.web_tension
    assert isinstance(profile, wo.Profile)
    assert profile.at(0.3) == pytest.approx(tension(np.array(0.3)), abs=1e-3)


def test_scatter_is_the_noise_about_the_falling_tension():
    rng = np.random.default_rng(1)
    radius = growing(20_000)
    noisy = tension(radius) + rng.normal(0, 8.0, radius.size)
    log = wo.read_log({"radius": radius, "web_tension": noisy}, WINDING, bins=10)
    # a standard deviation of 200 rows and more: 5 % is one standard error of the smallest bin
    np.testing.assert_allclose(log.bins.scatter[0], 8.0, rtol=0.15)


@pytest.mark.parametrize("correlation", [0.0, 0.8])
def test_the_standard_errors_of_means_are_those_of_correlated_rows(correlation: float):
    """var(mean) = s^2/n (1 + rho)/(1 - rho) of a first-order autoregressive noise."""
    rng, bins, n = np.random.default_rng(2), 40, 40_000
    noise = rng.normal(0, 1.0, n)
    for k in range(1, n):
        noise[k] = correlation * noise[k - 1] + np.sqrt(1 - correlation**2) * noise[k]
    log = binned(np.linspace(0.1, 0.5, n), noise[None, :], ["web_tension"], [], bins)
    exact = np.sqrt(bins / n * (1 + correlation) / (1 - correlation))
    # 40 variances of 9 degrees of freedom: their mean has a standard error of 7 %
    assert np.mean(log.error[0] ** 2) ** 0.5 == pytest.approx(exact, rel=0.12)
    # a standard deviation of 40 means scatters by 1/sqrt(2 (40 - 1)) = 11 % (chi-squared)
    assert np.std(log.mean[0], ddof=1) == pytest.approx(exact, rel=2 / np.sqrt(2 * (bins - 1)))


def test_few_rows_have_few_bins_and_no_error_of_batches():
    log = wo.read_log({"radius": [0.1, 0.2, 0.3, 0.4], "nip_load": [1e3, 1e3, 2e3, 2e3]}, WINDING)
    assert log.bins.rows.tolist() == [2, 2]
    assert np.isnan(log.bins.scatter).all()


# ---- what is left out ---------------------------------------------------------------------------


def test_stops_and_rows_without_a_radius_are_left_out_with_a_count():
    radius = growing(2000)
    values = tension(radius)
    speed = np.full(2000, 20.0)
    speed[700:800], values[700:790] = 0.3, 2.0  # it creeps, and the load cell has an offset
    radius[5:8] = np.nan
    table = {"radius": radius, "web_tension": values, "web_speed": speed}
    log = wo.read_log(table, WINDING)
    assert log.bins.left_out == {"no radius": 3, "the web stands still": 100}
    assert log.bins.rows.sum() == 1897
    assert "left out: 3 (no radius), 100 (the web stands still)" in str(log)
    np.testing.assert_allclose(log.bins.mean[0], tension(log.bins.radius), rtol=1e-3)


OUTSIDE, SPIKE = "radius outside of core and roll", "radius jumps to and fro"


@pytest.mark.parametrize(
    ("n", "wrong", "left_out"),
    [
        (20_000, {7000: 32.8}, {OUTSIDE: 1}),  # 65535 mm, the largest number of a sensor
        (20_000, {7000: 0.5, 7001: 0.5, 7002: 0.5}, {SPIKE: 3}),
        (20_000, {12_000: 0.03}, {SPIKE: 1}),
        (20_000, {0: 0.55, 19_999: 0.06}, {SPIKE: 2}),
        (2001, {300: 49.95}, {OUTSIDE: 1}),
        (2001, {1900: 0.1}, {SPIKE: 1}),
        (50, {20: 0.55}, {SPIKE: 1}),
        (30, {12: 0.6}, {SPIKE: 1}),
    ],
)
def test_rows_with_a_wrong_radius_are_left_out_with_a_count(n, wrong, left_out):
    """The other rows have the bins and means of the log without the wrong rows."""
    radius = growing(n)
    values = tension(radius)
    rows = list(wrong)
    radius[rows] = list(wrong.values())
    log = wo.read_log({"radius": radius, "web_tension": values}, WINDING)
    without = {"radius": np.delete(radius, rows), "web_tension": np.delete(values, rows)}
    assert log.bins.left_out == left_out
    assert np.flatnonzero(~log.bins.is_used).tolist() == rows
    np.testing.assert_array_equal(log.bins.mean, wo.read_log(without, WINDING).bins.mean)


def test_a_spike_is_left_out_without_a_roll():
    """The radius of a nip has no limits."""
    nip, radius = wo.NipProblem.example(), growing(2001)
    radius[300] = 49.95
    log = wo.read_log({"radius": radius, "wound_on_tension": tension(radius)}, nip)
    assert log.bins.left_out == {SPIKE: 1}


@pytest.mark.parametrize("noise", [1e-4, 0.01, 0.03])
@pytest.mark.parametrize("n", [20, 200, 20_000])
def test_no_row_of_a_noisy_radius_is_a_spike(n, noise):
    """Noise of 0.03 m is a twentieth of the build-up."""
    radius = growing(n)
    measured = np.abs(radius + np.random.default_rng(3).normal(0, noise, n))
    nip = wo.NipProblem.example()
    log = wo.read_log({"radius": measured, "wound_on_tension": tension(radius)}, nip)
    assert log.bins.left_out == {}


@pytest.mark.parametrize("n", [4, 8, 50, 300])
@pytest.mark.parametrize("step", [1e-6, 0.01, 0.05])
def test_no_row_of_a_coarse_radius_is_a_spike(n, step):
    """A sensor with steps, also in a log that begins with thick layers."""
    radius = np.maximum(step, step * np.round(growing(n) / step))
    log = wo.read_log({"radius": radius, "web_tension": tension(radius)}, WINDING)
    assert log.bins.left_out == {}


def test_a_log_with_all_rows_left_out_states_why():
    table = {"radius": np.linspace(50, 600, 99), "web_tension": [300.0] * 99}  # mm, not m
    with pytest.raises(InvalidProblem, match=r"has 0 rows .*left out: 99 .radius outside of core"):
        wo.read_log(table, WINDING)


def test_a_log_of_two_rolls_is_rejected_by_its_row():
    radius = np.concatenate([growing(500), growing(500)])
    with pytest.raises(InvalidProblem, match="has 2 rolls: the radius falls back near row 501"):
        wo.read_log({"radius": radius, "web_tension": tension(radius)}, WINDING)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"web_tension": [1.0] * 5}, "needs a column of the radius or the diameter"),
        ({"radius": [0.1, 0.2, 0.3, 0.4], "diameter": [0.2] * 4, "web_tension": [1.0] * 4},
         "has radius and diameter; must have one"),
        ({"radius": [0.1, 0.2, 0.3, 0.4], "x": [1.0] * 4}, "its columns are 'radius', 'x'"),
        ({"radius": [0.1, 0.2, 0.3, 0.4], "x": [1.0] * 4},
         "no column of web_tension, nip_load, web_speed, winding_force, torque_split, "),
        ({"radius": [0.1] * 9, "web_tension": [1.0] * 9}, "at different radii"),
    ],
)  # fmt: skip
def test_a_log_that_is_none_is_rejected(table, words):
    with pytest.raises(InvalidProblem, match=words):
        wo.read_log(table, WINDING)


# ---- units, names -------------------------------------------------------------------------------


def test_totals_are_divided_by_the_width_of_the_problem(tmp_path: Path):
    radius = growing(3000)
    path = written(
        tmp_path / "log.csv", {"Säde [mm]": 1e3 * radius, "Rataveto [N]": 2.5 * tension(radius)}
    )
    log = wo.read_log(path, WINDING.replace(width=2.5))
    np.testing.assert_allclose(log.bins.mean[0], tension(log.bins.radius), rtol=1e-5)
    with pytest.raises(InvalidProblem, match="is a force; expected a force per width"):
        wo.read_log(path, WINDING)


def test_a_column_with_another_name_is_assigned():
    radius = growing(100)
    table = {"radius": radius, "Z1 [kN/m]": tension(radius) / 1e3}
    log = wo.read_log(table, WINDING, columns={"Z1": "web_tension"})
    np.testing.assert_allclose(log.bins.mean[0], tension(log.bins.radius))


# ---- use in case files, fits and comparisons ----------------------------------------------------


def test_a_case_file_takes_a_field_from_a_log(tmp_path: Path):
    radius = growing(2000)
    stopped = tension(radius)
    stopped[100:150] = 0.0
    written(tmp_path / "winder.csv", {"Halkaisija [mm]": 2e3 * radius, "Veto [kN]": 2e-3 * stopped})
    case = tomllib.loads(template("winding")) | {"width": 2.0}
    case["web_tension"] = {"log": "winder.csv", "columns": {"Veto": "web_tension"}, "bins": 8}
    (tmp_path / "case.toml").write_text(toml(case), encoding="utf-8")
    account = "2000 rows in 8 bins over the radius; left out: 50 .the web stands still."
    with pytest.warns(InputWarning, match=account):
        problem = wo.load_case(tmp_path / "case.toml")
    assert len(problem.web_tension.radius) == 8 + 2  # and the ends
    assert problem.web_tension.at(0.3) == pytest.approx(tension(np.array(0.3)), rel=2e-3)


@pytest.mark.parametrize("bins", ["50", [1, 2], 2.5, 1, 1001, True])
def test_the_number_of_bins_is_checked(tmp_path: Path, bins):
    radius = growing(2000)
    text = r"bins: .* is out of range; must be a whole number, 2 to 1000"
    with pytest.raises(InvalidProblem, match=f"^{text}"):
        wo.read_log({"radius": radius, "web_tension": tension(radius)}, WINDING, bins=bins)
    written(tmp_path / "winder.csv", {"radius [m]": radius, "web_tension [N/m]": tension(radius)})
    case = tomllib.loads(template("winding"))
    case["web_tension"] = {"log": "winder.csv", "bins": bins}
    (tmp_path / "case.toml").write_text(toml(case), encoding="utf-8")
    with pytest.raises(InvalidProblem, match=f"web_tension.{text}"):
        wo.load_case(tmp_path / "case.toml")


def test_a_header_may_be_called_log(tmp_path: Path):
    """The headers in ``columns`` are no names of files."""
    radius = growing(99)
    written(tmp_path / "winder.csv", {"csv": radius, "log": tension(radius)})
    case = tomllib.loads(template("winding"))
    columns = {"csv": "radius [m]", "log": "web_tension [N/m]"}
    case["web_tension"] = {"log": "winder.csv", "columns": columns}
    (tmp_path / "case.toml").write_text(toml(case), encoding="utf-8")
    with pytest.warns(wo.InputWarning, match="99 rows"):
        problem = wo.load_case(tmp_path / "case.toml")
    assert float(problem.web_tension.at(0.3)) == pytest.approx(float(tension(0.3)), rel=1e-3)


@pytest.mark.parametrize("name", ["", 3, ["winder.csv"]])
def test_a_log_without_a_name_is_rejected(tmp_path: Path, name):
    case = tomllib.loads(template("winding")) | {"web_tension": {"log": name}}
    (tmp_path / "case.toml").write_text(toml(case), encoding="utf-8")
    with pytest.raises(InvalidProblem, match=r"^web_tension\.log: .* must be the name of a file"):
        wo.load_case(tmp_path / "case.toml")


def test_a_log_stands_only_where_a_profile_may(tmp_path: Path):
    written(tmp_path / "winder.csv", {"radius [m]": growing(50), "x [m]": growing(50)})
    text = template("roll") + '\n[core]\nlog = "winder.csv"\n'
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    assert main(["solve", str(tmp_path / "case.toml")]) == 2


def test_the_scatter_of_a_log_weights_a_comparison_and_a_fit():
    """Of a nip on rolls of growing radius: the wound-on tension is an output with its errors."""
    nip = wo.NipProblem.example()
    rng = np.random.default_rng(4)
    radius = np.repeat([0.1, 0.2, 0.3], 400)
    exact = {
        r: wo.solve(nip.replace(**{"roll.radius": r})).wound_on_tension for r in (0.1, 0.2, 0.3)
    }
    wot = np.array([exact[r] for r in radius.tolist()]) + rng.normal(0, 6.0, radius.size)
    log = wo.read_log({"radius": radius, "wound_on_tension": wot}, nip, bins=3)
    check = wo.compare(nip, log)
    np.testing.assert_allclose(check.deviation, log.bins.error[0])
    # three means with their standard errors, which ten batches give to 24 %
    assert np.all(np.abs(check.residual) < 4 * check.deviation)
    found = wo.fit(nip, log, {"roll_friction": (0.1, 0.4)}, starts=1, profiles=False)
    assert found.weighted
    error = found.estimates[0] - nip.roll_friction
    assert abs(error) < 4 * found.standard_errors[0]


def sparse_log(rows_of_the_last: int, noise: float = 6.0) -> wo.WinderLog:
    """Return a log with 300 rows in each of two bins and few in a third one."""
    radius = np.repeat([0.1, 0.2, 0.3], [300, 300, rows_of_the_last])
    wot = 600.0 + noise * np.random.default_rng(5).normal(size=radius.size)
    table = {"radius": radius, "wound_on_tension": wot}
    return wo.read_log(table, wo.NipProblem.example(), bins=3)


def test_a_bin_of_two_rows_has_the_scatter_of_a_row_as_its_error():
    log = sparse_log(2)
    assert np.isnan(log.bins.error[0]).tolist() == [False, False, True]
    table = log.measured()
    assert table["wound_on_tension +-"][:2].tolist() == log.bins.error[0, :2].tolist()
    pooled = np.sqrt(np.mean(log.bins.scatter[0, :2] ** 2))
    assert table["wound_on_tension +-"][2] == pytest.approx(pooled, rel=1e-12)
    assert wo.compare(wo.NipProblem.example(), log).deviation.tolist() == pytest.approx(
        table["wound_on_tension +-"].tolist()
    )
    remark = "wound_on_tension: 1 bin of less than 3 rows has the scatter of the rows of the others"
    assert any(text.startswith(remark) for text in log.remarks())
    assert "has the scatter" in str(log)
    assert not sparse_log(300).remarks()


def test_a_bin_of_equal_rows_has_the_error_of_the_others():
    """A meter with few digits shows equal numbers; their mean is not exact."""
    radius = np.repeat([0.1, 0.2, 0.3], 300)
    wot = 600.0 + np.random.default_rng(5).normal(size=900)
    wot[600:] = 600.0
    table = {"radius": radius, "wound_on_tension": wot}
    log = wo.read_log(table, wo.NipProblem.example(), bins=3)
    errors = log.measured()["wound_on_tension +-"]
    assert errors[2] == pytest.approx(np.sqrt(np.mean(log.bins.error[0, :2] ** 2)), rel=1e-12)
    assert any("1 bin of equal values" in text for text in log.remarks())


def test_a_log_without_any_standard_error_says_so():
    log = wo.read_log(
        {"radius": [0.1, 0.2, 0.3, 0.4], "wound_on_tension": [600.0, 610.0, 620.0, 640.0]},
        wo.NipProblem.example(),
    )
    assert list(log.measured()) == ["roll.radius", "wound_on_tension"]
    assert any("wound_on_tension: no standard errors" in text for text in log.remarks())


def test_numbers_without_a_unit_have_no_blank_in_its_place():
    table = {"radius": [0.1, 0.2, 0.3, 0.4], "roll_friction": [0.2, 0.2, 0.3, 0.3]}
    _, line = wo.read_log(table, WINDING, bins=2).answer()
    assert line.startswith("roll_friction: 0.2 to 0.3; scatter of the rows ")


def test_a_log_of_inputs_only_is_no_measured_table():
    log = wo.read_log({"radius": growing(99), "web_tension": tension(growing(99))}, WINDING)
    with pytest.raises(InvalidProblem, match="has web_tension only, which are inputs"):
        wo.compare(WINDING, log)


def test_the_figure_shows_rows_means_and_rows_left_out():
    radius, speed = growing(9000), np.full(9000, 20.0)
    speed[:10] = 0
    table = {"radius": radius, "web_tension": tension(radius), "web_speed": speed}
    figure = wo.read_log(table, WINDING).plot()
    labels = {line.get_label() for line in figure.axes[0].lines}
    assert {"rows", "rows left out"} <= labels
    sizes = {line.get_label(): line.get_xdata().size for line in figure.axes[0].lines}
    assert sizes["rows"] <= 4000
    assert sizes["rows left out"] == 10


def test_rows_left_out_far_away_do_not_stretch_the_axes():
    radius, T, speed = growing(3000), tension(growing(3000)), np.full(3000, 20.0)
    speed[[10, 20, 30]] = 0  # left out
    T[[10, 20]] = 410.0, 1e5
    radius[30] = 55.0
    figure = wo.read_log({"radius": radius, "web_tension": T, "web_speed": speed}, WINDING).plot()
    (first,) = [axes for axes in figure.axes if "web tension" in axes.get_ylabel()]
    assert 500 < first.get_xlim()[1] < 900  # mm; the roll ends at 600 mm
    assert 400 < first.get_ylim()[1] < 450  # N/m; the tension begins at 400 N/m
    shown = {line.get_label(): line.get_ydata() for line in first.lines}
    assert shown["rows left out"].tolist() == [410.0]
    plt.close(figure)


def test_the_legend_names_what_any_quantity_shows():
    radius, T, load = growing(3000), tension(growing(3000)), np.full(3000, 2000.0)
    speed = np.full(3000, 20.0)
    speed[:10], load[:10] = 0, np.nan  # left out, and without a nip load
    table = {"radius": radius, "web_tension": T, "web_speed": speed, "nip_load": load}
    figure = wo.read_log(table, WINDING).plot()
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == [
        "rows",
        "rows left out",
        "mean of a bin, with the standard deviation of its rows",
    ]
    plt.close(figure)


@pytest.mark.slow
def test_a_million_rows_are_read_in_a_gigabyte(tmp_path: Path):
    """The memory is the largest of a process of its own; it takes 7 to 8 s of processor time."""
    n = 1_000_000
    radius = growing(n)
    text = "Radius [m];Bahnzug [N/m];Linienlast [kN/m];Geschwindigkeit [m/min];Alarm\n"
    rows = (
        f"{r:.4f};{t:.2f};3,012;1500,0;OK\n" for r, t in zip(radius, tension(radius), strict=True)
    )
    (tmp_path / "log.csv").write_text(text + "".join(rows).replace(".", ","), encoding="utf-8")
    code = """
import woundon as wo
log = wo.read_log("log.csv", wo.WindingProblem.example())
# of this program alone: ru_maxrss contains that of the process that started it
status = dict(line.split(":", 1) for line in open("/proc/self/status"))
kilobytes = int(status["VmHWM"].split()[0])
print(kilobytes, log.bins.rows.sum())
"""
    command = [sys.executable, "-c", code]
    out = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout
    kilobytes, rows_used = map(float, out.split())
    assert kilobytes < 1e6
    assert rows_used == n
