"""``woundon thesis``: what is written, what is said, how it is stopped."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import woundon as wo
from woundon import plugins
from woundon.cli import commands as cli
from woundon.jorkama2001 import catalogue, plugin
from woundon.jorkama2001.command import thesis

PROJECT = Path(__file__).parents[2] / "pyproject.toml"

Capture = pytest.CaptureFixture[str]


def test_the_project_declares_its_plug_in():
    declared = tomllib.loads(PROJECT.read_text("utf-8"))["project"]["entry-points"]
    assert declared == {plugins.GROUP: {"jorkama2001": plugin.__name__}}
    assert plugins.commands()["thesis"] is thesis


def test_the_command_line_alone_does_not_import_the_reproduction():
    code = "import sys; import woundon.cli.commands; sys.exit('woundon.jorkama2001' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_figure_is_drawn_and_judged(tmp_path, capsys: Capture):
    out = tmp_path / "made" / "here"
    assert cli.main(["thesis", "fig15", "--out", str(out)]) == 0
    said = capsys.readouterr()
    assert "Fig. 15: " in said.out
    assert said.out.count("- holds: ") == said.out.count("\n- ")  # every statement of sec. 4.2
    assert said.err == ""  # no bar where there is no terminal
    assert sorted(path.name for path in out.iterdir()) == [
        "fig15.csv", "fig15.md", "fig15.png", "fig15.svg"
    ]  # fmt: skip
    assert (out / "fig15.png").read_bytes().startswith(b"\x89PNG")
    header, *rows = (out / "fig15.csv").read_text().splitlines()
    assert header.startswith("x [m],pressure [Pa],roll_traction [Pa]")
    assert len(rows) == 257
    assert (
        "- **holds**: before C it falls a little: **-4.77 N/m**" in (out / "fig15.md").read_text()
    )


@pytest.mark.campaign
def test_two_processes_do_the_same(tmp_path, capsys: Capture):
    names = ["fig15", "fig35"]
    for jobs in ("1", "2"):
        out = str(tmp_path / jobs)
        assert cli.main(["thesis", *names, "--jobs", jobs, "--out", out]) == 0
    first, second = (sorted((tmp_path / jobs).iterdir()) for jobs in ("1", "2"))
    assert [path.name for path in first] == [path.name for path in second]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()


@pytest.mark.slow
def test_all_are_summed_up(tmp_path, capsys: Capture, monkeypatch):
    monkeypatch.setattr(catalogue, "NAMES", ("fig5", "table4"))
    monkeypatch.delattr(wo.parallel, "in_processes")  # one process is this one
    assert cli.main(["thesis", "--all", "--jobs", "1", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "Table 4  5 statements: 5 hold" in said
    assert "2 figures and tables, 18 statements: 17 hold, 1 do not hold" in said
    assert said.count("DOES NOT HOLD: ") == 1
    assert "| [Table 4](table4.md) |" in (tmp_path / "index.md").read_text()


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["fgi15"], "error: fgi15: unknown; did you mean 'fig15'?"),
        ([], "error: name figures or tables, or ask for --all; there are fig"),
        (["fig15", "--all"], "error: name figures or tables, or ask for --all; there are fig"),
        (["fig15", "--solver", "exact"], "error: Invalid value for '--solver'"),
        (["fig15", "--jobs", "0"], "error: Invalid value for '--jobs'"),
    ],
)
def test_faults(args, said, tmp_path, monkeypatch, capsys: Capture):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["thesis", *args]) == 2
    output = capsys.readouterr()
    assert output.err.startswith(said)
    assert list(tmp_path.iterdir()) == []
