"""Pictures appear: in a notebook, once each; in a script by plt.show(); none where they are saved.

The notebook is run by a real kernel, the scripts by a Python of their own.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot as plt
from thesis_cases import newsprint_nip

import woundon as wo
from woundon.io.case_files import template
from woundon.report.figures import axis_label, formulas
from woundon.report.panels import Axis

NODES = 17
SOURCE = Path(wo.__file__).parents[1]

# a backend that tells what is shown, as a window would be
BACKEND = """
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backend_bases import FigureManagerBase
from matplotlib import _pylab_helpers


class FigureManager(FigureManagerBase):
    @classmethod
    def pyplot_show(cls, *, block=None):
        print("shown", len(_pylab_helpers.Gcf.get_all_fig_managers()))


class FigureCanvas(FigureCanvasAgg):
    manager_class = FigureManager
"""
START = f"""
import woundon as wo
nip = wo.solve(wo.NipProblem.example(), nodes={NODES})
other = wo.solve(wo.NipProblem.example().replace(nip_load=2000.0), nodes={NODES})
"""


@pytest.fixture(scope="module")
def nips() -> list[wo.NipResult]:
    return [wo.solve(newsprint_nip(nip_load=P), nodes=NODES) for P in (2000.0, 4000.0)]


# ---- notebooks


def images(outputs: list[Any]) -> int:
    return sum("image/png" in output.get("data", {}) for output in outputs)


@pytest.mark.campaign
def test_a_notebook_shows_each_picture_once(tmp_path: Path) -> None:
    import nbclient
    import nbformat

    cells = {
        START: 0,
        "nip.plot()": 1,  # the last line of the first cell that draws anything
        "nip.plot();": 1,
        "figure = nip.plot()": 1,  # as plt.subplots() does
        "figure": 1,  # again, for it is asked for
        "for result in (nip, other):\n    result.plot()": 2,
        "display(nip.plot())\nprint('then')": 1,
        "wo.plot([nip, other])": 1,
        "nip.plot('saved.png');": 0,
        "for result in (nip, other):\n    result.plot('saved.svg')": 0,
        "nip.plot('saved.png')": 1,
        "import matplotlib.pyplot as plt\nplt.show()\nprint(plt.get_fignums())": 0,
        "axes = plt.subplots(1, 2)[1]\nnip.plot(ax=axes[0])\nother.plot(ax=axes[1])": 1,
        "plt.show()": 0,
        "nip.plot()\nplt.show()": 1,
        "nip": 0,
    }
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    env = {**os.environ, "PYTHONPATH": str(SOURCE)}
    env.pop("MPLBACKEND", None)  # the kernel's own
    place = {"metadata": {"path": str(tmp_path)}}
    nbclient.NotebookClient(book, timeout=300, resources=place).execute(env=env)
    assert {path.name for path in tmp_path.iterdir()} == {"saved.png", "saved.svg"}
    shown = {cell.source: images(cell.outputs) for cell in book.cells}
    assert shown == cells
    assert book.cells[11].outputs[0].text == "[]\n"  # nothing is left open


# ---- scripts


def said(script: str, folder: Path, backend: str) -> str:
    (folder / "telling.py").write_text(BACKEND, encoding="utf-8")
    (folder / "script.py").write_text(START + script, encoding="utf-8")
    env = {**os.environ, "PYTHONPATH": f"{SOURCE}{os.pathsep}{folder}", "MPLBACKEND": backend}
    command = [sys.executable, "script.py"]
    run = subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    return run.stdout


@pytest.mark.slow
def test_a_script_shows_what_it_drew_and_did_not_save(tmp_path: Path) -> None:
    """What it saves needs no pyplot; from the command line neither."""
    script = """
import sys
import warnings
nip.plot("saved.png", panels="zones")
from woundon.cli.commands import main
sys.stdout.write(str(main(["solve", "case.toml", "--plot", "case.png", "--nodes", "17"])))
print("", "matplotlib.pyplot" in sys.modules)
import matplotlib
matplotlib.use("module://telling")
import matplotlib.pyplot as plt
warnings.simplefilter("error")
plt.rcParams["figure.max_open_warning"] = 2  # of pyplot's, which what is saved is not
nip.plot()
wo.plot([nip, other])
for k in range(2):
    nip.plot("saved.png", panels="zones")
plt.show()
"""
    (tmp_path / "case.toml").write_text(template("rollers"), encoding="utf-8")
    # a window system that is not there, as of a worker or a service
    computed = said(script, tmp_path, "module://missing").splitlines()
    assert computed[-2:] == ["0 False", "shown 2"]


# ---- panels


def test_one_panel_goes_into_the_users_axes(nips) -> None:
    figure, axes = plt.subplots()
    axes.set_title("mine")
    assert nips[0].plot(ax=axes) is axes
    assert axes.get_title() == "mine"
    assert axes.get_ylabel() == "Tangential traction $q$ [kPa]"
    np.testing.assert_allclose(axes.get_lines()[0].get_ydata(), 1e-3 * nips[0].roll_traction)
    assert len(figure.axes) == 1
    assert plt.get_fignums() == [figure.number]
    again = plt.figure().add_subplot()
    nips[0].plot(ax=again, panels="pressure")
    np.testing.assert_allclose(again.get_lines()[0].get_ydata(), 1e-3 * nips[0].drum_pressure)


def test_panels_are_chosen_by_name_in_the_order_asked_for(nips) -> None:
    above, below = nips[0].plot(panels=["slips", "tractions"]).axes[:2]
    assert above.get_ylabel().startswith("Relative slip speed")
    assert below.get_ylabel().startswith("Tangential traction")
    assert not above.get_xlabel()
    assert below.get_xlabel() == "Position along the nip $x$ [mm]"
    assert above.get_title(loc="right") == "(a)"
    (alone,) = nips[0].plot(panels="roll_zone").axes  # any array has a panel of its name
    np.testing.assert_array_equal(alone.get_lines()[0].get_ydata(), nips[0].roll_zone)


# ---- several results


def names(legend: Any) -> list[str]:
    return [text.get_text() for text in legend.get_texts()]


def test_several_results_are_distinguished_by_what_differs(nips) -> None:
    figure = wo.plot(nips)
    assert names(figure.legends[0]) == ["nip load = 2000 N/m", "nip load = 4000 N/m"]
    tractions, _, zones = figure.axes[:3]
    lines = tractions.get_lines()
    for k, nip in enumerate(nips):
        roll, drum = lines[2 * k : 2 * k + 2]
        np.testing.assert_allclose(roll.get_ydata(), 1e-3 * nip.roll_traction)
        np.testing.assert_allclose(drum.get_ydata(), 1e-3 * nip.drum_traction)
        assert roll.get_color() == drum.get_color()
    assert lines[0].get_color() != lines[2].get_color()
    assert names(tractions.get_legend()) == ["$q^{+}$ on roll", "$q^{-}$ on drum"]
    assert [text.get_text() for text in zones.get_yticklabels()] == ["roll", "drum"] * 2
    assert zones.get_xlim()[1] == pytest.approx(1.03e3 * nips[1].half_width)


def test_results_share_the_panels_they_have_in_common(nips) -> None:
    wrapped = wo.solve(nips[0].problem.replace(roll_wrap=np.pi), nodes=NODES)
    figure = wo.plot([nips[0], wrapped])
    assert len(figure.axes) == 4  # the nip's three, and the tension on the right
    assert names(figure.legends[0]) == ["roll wrap = 0 deg", "roll wrap = 180 deg"]
    rollers = wo.solve(wo.RollerProblem.example(), nodes=NODES)
    with pytest.raises(wo.InvalidProblem, match="results of nip and rollers have no panel in comm"):
        wo.plot([nips[0], rollers])
    static = wo.solve(rollers.problem.replace(motion="static"), nodes=NODES)
    with pytest.raises(wo.InvalidProblem, match="'slip' has no common unit"):
        wo.plot([rollers, static])
    assert names(wo.plot([rollers, static], panels="tractions").legends[0]) == [
        "motion = rolling", "motion = static",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("label", "printed"),
    [
        ("temperature change -36 degF", "temperature change -36 °F"),
        ("from 20 degC to 40 degC", "from 20 °C to 40 °C"),
        ("scale: 5 um", "scale: 5 µm"),
        ("inertia 3 kg*m^2, density 40 lb/ft^3", "inertia 3 kg·m², density 40 lb/ft³"),
        ("slope 2 Pa/m**0.5", "slope 2 Pa/√m"),
        ("3 aluminium drums, degF", "3 aluminium drums, degF"),  # no units
    ],
)
def test_units_within_words_are_printed_as_on_axes(label: str, printed: str) -> None:
    assert formulas(label) == printed
    assert axis_label(Axis(label)) == printed
