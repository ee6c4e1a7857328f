"""``woundon thesis``: what is written, what is said, how it is stopped."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest

from woundon import plugins
from woundon.cli import commands as cli
from woundon.jorkama2001 import catalogue, plugin, publication
from woundon.jorkama2001.command import thesis

PROJECT = Path(__file__).parents[2] / "pyproject.toml"
# a process of its own that has the command, whether or not the package has been installed
WOUNDON = (
    "import sys; from woundon.jorkama2001.command import thesis; "
    "from woundon.cli import commands as cli; "
    "cli.commands.add_command(thesis); sys.exit(cli.main())"
)

Capture = pytest.CaptureFixture[str]
posix = pytest.mark.skipif(os.name == "nt", reason="signals and terminals of POSIX")


def test_the_project_declares_its_plug_in():
    declared = tomllib.loads(PROJECT.read_text("utf-8"))["project"]["entry-points"]
    assert declared == {plugins.GROUP: {"jorkama2001": plugin.__name__}}
    assert plugins.commands()["thesis"] is thesis


def test_the_command_line_alone_does_not_import_the_reproduction():
    code = "import sys; import woundon.cli.commands; sys.exit('jorkama2001' in sys.modules)"
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


@pytest.mark.slow
def test_two_processes_do_the_same(tmp_path, capsys: Capture):
    names = ["table4", "fig5"]
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
    monkeypatch.delattr(publication, "in_processes")  # one process is this one
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


def _children(pid: int) -> list[int]:
    """Return the processes that a process has started and that live."""
    found = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rpartition(")")[2].split()
        except OSError:  # it has just ended
            continue
        if int(fields[1]) == pid and fields[0] != "Z":
            found.append(int(status.parent.name))
    return found


def _hear_ctrl_c() -> None:
    """Undo what a shell does to jobs in its background: there Ctrl-C is ignored, and inherited."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@pytest.mark.slow
@posix
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="looks for processes in /proc")
@pytest.mark.parametrize("jobs", ["1", "2"])
def test_ctrl_c_stops_it_at_once_and_leaves_nobody_behind(tmp_path, jobs: str):
    # two modules of many seconds each, and a quick one before whose end nothing is stopped
    names = ["table4", "fig28", "table3"]
    command = [sys.executable, "-c", WOUNDON, "thesis", *names, "--jobs", jobs]
    with subprocess.Popen(
        [*command, "--out", str(tmp_path)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, start_new_session=True, preexec_fn=_hear_ctrl_c,
    ) as process:  # fmt: skip
        limit, workers = time.monotonic() + 60, list[int]()
        while time.monotonic() < limit and process.poll() is None:
            workers = _children(process.pid)
            # they have begun to work when the resource tracker and both have their libraries
            if len(workers) >= (3 if jobs == "2" else 0) and _used(process.pid, workers) > 2.0:
                break
            time.sleep(0.05)
        assert process.poll() is None
        begun = time.monotonic()
        os.killpg(process.pid, signal.SIGINT)  # as a terminal's Ctrl-C does: to the whole group
        said = process.communicate(timeout=30)[1]
    assert time.monotonic() - begun < 3  # a module's work takes ten and more
    assert process.returncode == 130
    assert f"stopped; 0 of 3 are in {tmp_path}" in said
    assert "Traceback" not in said
    limit = time.monotonic() + 3
    while time.monotonic() < limit and any(Path(f"/proc/{pid}").exists() for pid in workers):
        time.sleep(0.02)
    assert [pid for pid in workers if Path(f"/proc/{pid}").exists()] == []


def _used(*found: int | list[int]) -> float:
    """Return the processor time that processes have used [s]."""
    ticks = 0
    for pid in (p for group in found for p in (group if isinstance(group, list) else [group])):
        try:
            fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        ticks += int(fields[11]) + int(fields[12])
    return ticks / os.sysconf("SC_CLK_TCK")
