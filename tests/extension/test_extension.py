"""The sets are open: a body, an output and a kind of problem from outside get all there is.

``plugin/`` is an installed package in miniature, a module and the entry point that names it; the
tests run processes that find it as any process would.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
PLUGIN = HERE / "plugin"

STIFF = "wo.HalfPlane(radius=1.0, material=wo.Isotropic(youngs_modulus=1e13, poissons_ratio=0.3))"
CASE = """
schema = 1
nip_load = "3.5 kN/m"
web_tension = "350 N/m"
roll_friction = 0.19
drum_friction = 0.2
roll_wrap = 0

[web]
thickness = "66 um"
material = "newsprint"

[roll]
radius = "100 mm"
core_radius = "44.5 mm"
material = "newsprint"

[drum]
radius = "76.2 mm"
hardening_pressure = "100 kPa"

[[drum.layers]]
thickness = "6 mm"
modulus = "3 MPa"

[[drum.layers]]
thickness = "4 mm"
modulus = "2.5 MPa"
"""
CAPSTAN = """
schema = 1
web_tension = "200 N/m"
friction = "20 %"
wrap = "90 deg"
radius = "50 mm"
"""


# runs commands and code, a line of JSON each, as long as somebody sends any
RUNNER = """
import contextlib, io, json, os, sys, traceback
import woundon as wo
from woundon.cli import commands as cli
channel, sys.stdout = sys.stdout, sys.stderr
for line in sys.stdin:
    folder, words, code = json.loads(line)
    os.chdir(folder)
    said, ended = io.StringIO(), 0
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        try:
            ended = exec(code, {"wo": wo}) if code else cli.main(words)
        except Exception:
            traceback.print_exc()
            ended = 1
    print(json.dumps([ended or 0, said.getvalue()]), file=channel, flush=True)
"""


def start_python(*words: str, cwd: Path, **more: object) -> subprocess.Popen[str]:
    """Start Python with the plug-in installed."""
    source = HERE.parents[1] / "src"
    path = os.pathsep.join(map(str, (source, PLUGIN)))
    return subprocess.Popen(
        [sys.executable, *words], cwd=cwd, env=os.environ | {"PYTHONPATH": path}, text=True,
        stdout=subprocess.PIPE, **more,
    )  # fmt: skip


def run_python(*words: str, cwd: Path) -> str:
    """Run Python with the plug-in installed, in a process for this alone; return its output."""
    with start_python(*words, cwd=cwd) as process:
        said = process.communicate(timeout=120)[0]
    assert process.returncode == 0
    return said


@pytest.fixture(scope="module")
def runner(tmp_path_factory):
    """A process in which the plug-in is installed, for all that needs none of its own."""
    folder = tmp_path_factory.mktemp("runner")
    with start_python("-c", RUNNER, cwd=folder, stdin=subprocess.PIPE) as process:
        yield process
        process.stdin.close()


@pytest.fixture
def run(runner, tmp_path):
    """Run a command, or ``code``; return what is reported."""

    def run(*words: str, code: str = "") -> str:
        runner.stdin.write(json.dumps([str(tmp_path), words, code]) + "\n")
        runner.stdin.flush()
        ended, said = json.loads(runner.stdout.readline())
        assert ended == 0, said
        return said

    return run


@pytest.fixture
def case(tmp_path: Path) -> Path:
    (tmp_path / "case.toml").write_text(CASE, "utf-8")
    (tmp_path / "capstan.toml").write_text(CAPSTAN, "utf-8")
    return tmp_path


# ---- a body -------------------------------------------------------------------------------------


def test_a_body_that_is_not_linear_meets_its_closed_form(run) -> None:
    """A stiff roller on a hardening Winkler foundation: c K1 ln(1 + p/K1) = (a^2 - x^2)/(2R).

    Second order in the nodes: 1.6e-4 of the largest pressure at 201 nodes.
    """
    said = run(
        code=f"""
import mattress, numpy as np
drum = mattress.Mattress(radius=1.0, hardening_pressure=20e3,
                         layers=[dict(thickness=0.01, modulus=1e6),
                                 dict(thickness=0.005, modulus=2e6)])
problem = wo.RollerProblem(upper={STIFF}, lower=drum, load=2e3, friction=0)
for nodes in (101, 201):
    r = wo.solve(problem, nodes=nodes)
    yields = (r.half_width**2 - r.x**2) / (2 * 0.5)
    exact = 20e3 * np.expm1(yields / (drum.c * 20e3))
    print(np.max(np.abs(r.pressure - exact)) / exact.max(), r.certified().largest)
"""
    )
    (coarse, _), (fine, residual) = (map(float, line.split()) for line in said.splitlines())
    assert fine < 2e-4
    assert coarse / fine == pytest.approx(4.0, rel=0.1)
    assert residual <= 1e-8


def test_a_body_rolls_in_every_nip(run) -> None:
    # warnings are not of interest; the last line: an inconsistent strain leaves 8e-4
    said = run(
        code="""
from woundon.io.case_files import make_problem
import tomllib, math, warnings
warnings.simplefilter("ignore")
problem = make_problem(tomllib.loads(open('case.toml').read()))
plain = wo.solve(problem)
wrapped = wo.solve(problem.replace(roll_wrap=math.pi, drum_wrap=math.pi / 2))
print(type(problem.drum).__name__, plain.residual, wrapped.residual)
print(plain.outlet_tension, plain.wound_on_tension)
print(problem.replace(**{"drum.layers.1.thickness": 0.005}).drum.layers[1].thickness)
print(plain.consistency.power_balance)
""".replace("open('case.toml').read()", repr(CASE))
    ).split()
    assert said[0] == "Mattress"
    assert float(said[1]) <= 1e-8
    assert float(said[2]) <= 1e-8
    plain, unwrapped = map(float, said[3:5])
    assert unwrapped == plain  # held at the trailing edge
    assert said[5] == "0.005"
    assert float(said[6]) < 1e-4


@pytest.mark.slow
def test_a_body_in_case_files_studies_files_and_reports(case: Path, run) -> None:
    out = run("solve", "case.toml", "--set", "drum.layers.0.thickness=5 mm",
               "--save", "nip.nc", "--plot", "nip.png")  # fmt: skip
    assert "nip-induced tension" in out
    assert (case / "nip.png").stat().st_size > 10_000
    thickness = "wo.load_result('nip.nc').problem.drum.layers[0].thickness"
    assert (
        run_python("-c", f"import woundon as wo; print({thickness})", cwd=case).strip() == "0.005"
    )
    (case / "study.toml").write_text(
        """
schema = 1
case = "case.toml"
outputs = ["nip_induced_tension", "mean_pressure"]

[over]
"drum.layers.0.thickness" = ["4 mm", "6 mm"]
nip_load = { from = "2 kN/m", to = "4 kN/m", count = 3 }
""",
        "utf-8",
    )
    run("sweep", "study.toml", "--out", "study", "--workers", "1", "--export", "csv")
    head, *rows = (case / "study" / "study.csv").read_text("utf-8").splitlines()
    assert "drum.layers.0.thickness [m]" in head
    assert "mean_pressure [Pa]" in head
    assert len(rows) == 6
    assert all(row.rstrip(",").count(",") >= 4 for row in rows)


# ---- an output ----------------------------------------------------------------------------------


def test_an_output_is_known_everywhere(tmp_path: Path, run) -> None:
    said = run(
        code="""
problem = wo.NipProblem.example()
result = wo.solve(problem, nodes=33)
print(result.mean_pressure == problem.nip_load / result.nip_width)
print("mean pressure" in str(result))
swept = wo.sweep(problem, {"nip_load": [2e3]}, ["mean_pressure"], nodes=33)
print(float(swept.mean_pressure[0]) > 0)
both = wo.sweep(problem.replace(roll_wrap=0.0), {"nip_load": [2e3, 3e3]},
                ["mean_pressure", "rig_tension"], nodes=33, workers=2, chunk=1)
print(bool((both.mean_pressure > 0).all()), bool((both.rig_tension > 350).all()))
result.save("nip.json")
"""
    )
    assert said.split() == ["True"] * 5
    record = json.loads((tmp_path / "nip.json").read_text("utf-8"))
    assert "rig_tension" not in record["outputs"]  # only on request
    assert record["outputs"]["mean_pressure"] > 0
    assert record["units"]["mean_pressure"] == "Pa"
    assert "mean pressure" in run("describe", "nip")


# ---- a kind -------------------------------------------------------------------------------------


def test_a_kind_has_all_that_woundons_have(case: Path, run) -> None:
    assert "\nwrap  " in run_python("-m", "woundon", "new", "capstan", cwd=case)
    help_text = run("describe", "capstan")
    for word in ("web_tension", "angle of wrap", "tension_behind_bar", "--nodes"):
        assert word in help_text
    out = run("solve", "capstan.toml", "--save", "c.json", "--plot", "c.png")
    assert "web tension behind the bar" in out
    assert "273.8" in out  # 200 exp(0.2 pi/2)
    assert "all 2 conditions are satisfied" in out
    assert (case / "c.png").stat().st_size > 5_000
    again = run(code="r = wo.load_result('c.json'); print(r.tension_behind_bar, r.residual)")
    assert float(again.split()[0]) == pytest.approx(
        200 * 2.718281828459045 ** (0.1 * 3.141592653589793), abs=1e-9
    )


def test_a_kind_is_swept_and_fitted(run) -> None:
    said = run(
        code="""
import mattress
problem = mattress.CapstanProblem.example()
swept = wo.sweep(problem, {"wrap": [1.0, 2.0], "friction": [0.1, 0.3]}, ["tension_behind_bar"])
print(float(swept.tension_behind_bar.sel(wrap=2.0, friction=0.3)))
data = {"wrap": [1.0, 2.0], "tension_behind_bar [N/m]": [250.0, 312.5]}
print(wo.fit(problem, data, {"friction": (0.01, 1.0)}, profiles=False, starts=2).estimates[0])
"""
    )
    tension, friction = map(float, said.split())
    assert tension == pytest.approx(200 * 2.718281828**0.6, rel=1e-8)
    assert friction == pytest.approx(0.22314, abs=1e-4)  # ln(1.25)


# ---- a command and figures ----------------------------------------------------------------------


def test_a_command_stands_next_to_woundons(run, tmp_path: Path) -> None:
    assert run("capstan-table", "--friction", "0.2").splitlines()[-1] == "180 deg  1.874"
    listed = run_python("-m", "woundon", "--help", cwd=tmp_path)
    assert (
        "capstan-table  Print the tension ratios of a capstan." in listed.partition("Plug-ins")[2]
    )


@pytest.mark.slow
def test_a_figure_is_on_the_page(run) -> None:
    said = run(
        code="""
from woundon.app.input_forms import catalogue
from woundon.app.documents import exhibit
print([one["label"] for one in catalogue()["exhibits"] if one["name"] == "capstan"])
print(b"<svg" in exhibit("capstan"))
"""
    )
    assert said.split() == ["['Capstan']", "True"]
