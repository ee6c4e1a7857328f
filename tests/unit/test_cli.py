"""The command line as its user meets it: what is printed, where, and with which exit code."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import woundon as wo
from woundon import cli
from woundon.materials import MATERIALS
from woundon.report import zone_line
from woundon.results import Zone

EXAMPLE = str(Path(__file__).parents[2] / "examples" / "newsprint_table2.toml")
QUICK = ["nip", EXAMPLE, "--nodes", "25"]

Capture = pytest.CaptureFixture[str]


def test_report_says_what_matters_with_units(capsys: Capture):
    assert cli.main(QUICK) == 0
    said = capsys.readouterr()
    result = wo.solve_nip(wo.load_case(EXAMPLE), nodes=25)
    lines = {" ".join(line.split()) for line in said.out.splitlines()}
    error = result.nip_induced_tension_error
    NIT, T_out = result.nip_induced_tension, result.wound_on_tension
    assert f"nip-induced tension NIT {NIT:.5g} N/m ± {error:.2g}" in lines
    assert f"wound-on tension T_out {T_out:.5g} N/m" in lines
    assert f"nip width 2a {2e3 * result.half_width:.5g} mm" in lines
    assert f"largest pressure p_max {result.pressure.max() / 1e3:.5g} kPa" in lines
    limit = wo.theories.friction_limit(result.problem)
    assert f"friction limit mu+ P + F (upper bound) NIT {limit:.5g} N/m" in lines
    assert "all 9 contact laws hold; the largest residual is" in said.out
    assert said.err == ""


def test_settings_and_options_reach_the_solver(capsys: Capture):
    options = ["--set", "nip_load=17 pli", "--set", "web.thickness=57 um", "--scheme", "thesis"]
    assert cli.main([*QUICK, *options, "--json"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert round(record["problem"]["nip_load"]) == 2977
    assert record["problem"]["web"]["thickness"] == 57e-6
    assert (record["scheme"], len(record["x"])) == ("thesis", 25)


def test_sensitivity_lists_what_matters_first(capsys: Capture):
    assert cli.main([*QUICK, "--sensitivity"]) == 0
    said = capsys.readouterr().out
    table = said[said.index("Elasticities: percent of output per percent of field") :]
    rows = [line.split() for line in table.splitlines()[2:-1]]
    assert rows[0][:2] == ["nip_load", "3502"]
    assert [row[0] for row in rows][1:3] == ["web.thickness", "web.material.tangential"]
    of_nit = [abs(float(row[2])) for row in rows]
    assert of_nit == sorted(of_nit, reverse=True)
    assert table.splitlines()[-1].startswith("winding_force is 0: NIT changes by +0.3")


def test_sensitivity_is_in_the_json_too(tmp_path, capsys: Capture):
    assert cli.main([*QUICK, "--sensitivity", "--json"]) == 0
    text = capsys.readouterr().out
    record = json.loads(text)["sensitivity"]
    exact = wo.solve_nip(wo.load_case(EXAMPLE), nodes=25).sensitivity()
    for output in exact.outputs:
        for name in exact.parameters:
            assert record["derivatives"][output][name] == exact.derivative(output, name)
    assert next(iter(record["elasticities"]["half_width"])) == "nip_load"
    assert record["zone_change"] == ""
    saved = tmp_path / "nip.json"
    saved.write_text(text, encoding="utf-8")
    assert wo.load_result(saved).problem == wo.load_case(EXAMPLE)


def test_files_are_written(tmp_path, capsys: Capture):
    saved, drawn = tmp_path / "nip.nc", tmp_path / "nip.png"
    assert cli.main([*QUICK, "--save", str(saved), "--plot", str(drawn)]) == 0
    assert wo.load_result(saved).problem == wo.load_case(EXAMPLE)
    assert drawn.read_bytes().startswith(b"\x89PNG")


def test_new_case_runs(tmp_path, capsys: Capture):
    assert cli.main(["new"]) == 0
    case = tmp_path / "case.toml"
    case.write_text(capsys.readouterr().out, encoding="utf-8")
    assert cli.main(["nip", str(case), "--nodes", "25"]) == 0


def test_materials_are_listed_as_a_case_file_takes_them(capsys: Capture):
    assert cli.main(["materials"]) == 0
    said = capsys.readouterr().out
    for name, (_, source) in MATERIALS.items():
        assert name in said
        assert source in said
    values = next(line.strip() for line in said.splitlines() if "3.38 GPa" in line)
    import tomllib

    from woundon.casefile import apply_settings, make_problem, read_case

    case = apply_settings(read_case(EXAMPLE), [])
    case["web"]["material"] = tomllib.loads(f"material = {values}")["material"]
    assert make_problem(case).web.material == wo.material("newsprint")


@pytest.mark.parametrize(
    ("args", "code", "said"),
    [
        (["nip", "none.toml"], 2, ["error: none.toml: cannot be read: No such file"]),
        ([*QUICK, "--set", "nip_laod=3"], 2, ["error: nip_laod: no such field; did you mean"]),
        (
            [*QUICK, "--set", "nip_load=-1", "--set", "web.thickness=0"],
            2,
            ["error: web.thickness: 0", "error: nip_load: -1"],
        ),
        ([*QUICK, "--set", "winding_force=-800 N/m"], 2, ["error: winding_force: -800"]),
        ([*QUICK, "--nodes", "3"], 2, ["error: nodes: 3"]),
        ([*QUICK, "--nodes", "many"], 2, ["error: Invalid value for '--nodes': 'many'"]),
        ([*QUICK, "--rtol", "0.5"], 2, ["error: rtol: 0.5"]),
        ([*QUICK, "--scheme", "grade"], 2, ["error: scheme: 'grade'"]),
        ([*QUICK, "--algorithm", "newton"], 2, ["error: algorithm: 'newton'"]),
        ([*QUICK, "--save", "nip.xls"], 2, ["error: nip.xls: the ending '.xls'"]),
        ([*QUICK, "--plot", "nip.gif"], 2, ["error: nip.gif: the ending '.gif'"]),
        ([*QUICK, "--save", "no/where/nip.nc"], 2, ["error: no/where/nip.nc: the folder"]),
        (["nap"], 2, ["error: No such command 'nap'"]),
        (["nip"], 2, ["error: Missing argument 'CASE'"]),
    ],
)
def test_a_fault_is_one_line_and_no_traceback(
    args, code, said, capsys: Capture, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert cli.main(args) == code
    output = capsys.readouterr()
    lines = output.err.splitlines()
    assert output.out == ""
    assert len(lines) == len(said)
    for line, start in zip(lines, said, strict=True):
        assert line.startswith(start)
    assert list(tmp_path.iterdir()) == []


def test_not_converged_has_its_own_code(monkeypatch, capsys: Capture):
    def give_up(*_: object, **__: object) -> None:
        raise wo.NotConverged("the estimated error of NIT is 0.3 N/m")

    monkeypatch.setattr("woundon.nip.solve_nip", give_up)
    assert cli.main(QUICK) == 3
    said = capsys.readouterr()
    assert said.err == "error: not converged: the estimated error of NIT is 0.3 N/m\n"
    assert said.out == ""


def test_an_unwritable_file_is_one_line(tmp_path, capsys: Capture):
    (tmp_path / "nip.nc").mkdir()
    assert cli.main([*QUICK, "--save", str(tmp_path / "nip.nc")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_without_a_command_the_help_is_shown(capsys: Capture):
    assert cli.main([]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith("Usage: woundon [OPTIONS] COMMAND")
    assert "..." not in said.err.partition("Commands:")[2]  # no sentence is cut short


def test_a_wrap_that_is_not_asked_for_is_none(capsys: Capture):
    assert cli.main(["nip", EXAMPLE, "--drum-wrap", "90 deg", "--nodes", "17"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "theta+ 0 deg" in said
    assert "theta- 90 deg" in said


def run_apart(*args: str, **environment: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, *args],
        capture_output=True,
        check=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **environment},
    )


def test_plain_ascii_where_the_terminal_knows_no_more():
    said = run_apart("-m", "woundon", *QUICK, PYTHONIOENCODING="ascii").stdout.decode("ascii")
    assert " roll  <<<<<" in said
    assert "+-" in said


def test_cheap_commands_load_nothing_heavy():
    heavy = ("numpy", "scipy", "matplotlib", "pint", "xarray", "pydantic")
    code = (
        "import sys; from woundon import cli; code = cli.main(['--version']);"
        f"print(code, [name for name in {heavy} if name in sys.modules])"
    )
    assert run_apart("-c", code).stdout.decode().splitlines()[-1] == "0 []"


def test_a_reader_that_leaves_is_no_fault():
    command = f"{sys.executable} -m woundon nip {EXAMPLE} --nodes 25 --json | head -c 10"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(command, shell=True, capture_output=True, env=environment, check=True)
    assert done.stderr == b""


def test_zones_are_drawn_in_proportion_and_short_ones_stay_in_sight():
    import numpy as np

    x = np.linspace(-1.0, 1.0, 101)
    zones = np.zeros(101, dtype=np.int8)
    zones[0] = -1  # half a cell: 1/200 of the nip
    zones[51:] = 1
    runs = zone_line(x, zones, 60)
    assert [zone for zone, _ in runs] == [Zone.BACKWARD, Zone.STICK, Zone.FORWARD]
    assert sum(length for _, length in runs) == 60
    assert runs[0][1] == 1
    assert abs(runs[2][1] - 30) <= 1
