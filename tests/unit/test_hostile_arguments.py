"""Arguments that no user means: misspelt fields to leave out, very deep or long names, folders.

Evidence: every such argument is rejected with exit code 2 and short lines, within seconds.
"""

from __future__ import annotations

import io
import random
import time
from pathlib import Path

import click
import pytest
from thesis_cases import newsprint_nip

import woundon as wo
from woundon.cli import commands as cli
from woundon.io.case_files import template
from woundon.studies.study_texts import study_template

LONG = "a" * 5000
DEEP = ".".join("a" * 2000)
DIGITS = "9" * 5000
LONGEST_LINE = 1100  # characters of an error line that a terminal still shows readably

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def case(tmp_path: Path) -> str:
    path = tmp_path / "case.toml"
    path.write_text(template("nip"), encoding="utf-8")
    return str(path)


# ---- fields to leave out ------------------------------------------------------------------------

MISSPELT = (
    "misspelt", "nip_laod", "web.misspelt", "drum.misspelt", "drum.misspelt.deeper",
    "web.material.sheer", "wrap.rol_wrap", "nip_load.deeper", "web.thickness.deeper",
    "misspelt.web", "drum.layers.0.misspelt", "misspelt.0", "roll.layers.\N{SUPERSCRIPT TWO}",
)  # fmt: skip


@pytest.mark.parametrize("name", MISSPELT)
@pytest.mark.parametrize("none", ["none", "None", " NONE "])
def test_an_unknown_field_cannot_be_left_out(case: str, name: str, none: str):
    with pytest.raises(wo.InvalidProblem) as fault:
        wo.load_case(case, [f"{name}={none}"])
    assert fault.value.faults[0][0] == name


# ---- deep and long names ------------------------------------------------------------------------


@pytest.mark.parametrize("value", ["5", "none", "5 mm"])
@pytest.mark.parametrize("name", [DEEP, f"web.{DEEP}", f"drum.layers.{'.'.join('0' * 2000)}"])
def test_a_very_deep_name_is_rejected_at_once(case: str, name: str, value: str, capsys: Capture):
    start = time.perf_counter()
    assert cli.main(["solve", case, "--set", f"{name}={value}"]) == 2
    assert time.perf_counter() - start < 60.0  # of a regular 0.1 s; it would end in no case
    assert len(capsys.readouterr().err) < LONGEST_LINE


@pytest.mark.parametrize("item", [DIGITS, "\N{SUPERSCRIPT TWO}", "-1", "1e3"])
def test_an_item_that_a_list_does_not_have_is_rejected(item: str):
    layer = wo.Layer(thickness=1e-3, material=wo.material("rubber"))
    problem = newsprint_nip()
    layered = problem.replace(drum=wo.Layered(radius=0.1, core="rigid", layers=(layer,)))
    with pytest.raises(wo.InvalidProblem):
        layered.replace(**{f"drum.layers.{item}.thickness": 2e-3})
    with pytest.raises(wo.InvalidProblem):
        wo.sweep(layered, {f"drum.layers.{item}.thickness": [2e-3]}, nodes=17, workers=1)


@pytest.mark.parametrize(
    "args",
    [
        [LONG],
        [f"\x1b[31m{LONG}"],
        ["new", LONG],
        ["solve", LONG],
        ["report", LONG],
        ["sweep", LONG, "--out", "out"],
        ["solve", "CASE", f"--{LONG}"],
        ["solve", "CASE", "--nodes", LONG],
        ["solve", "CASE", "--nodes", DIGITS],
        ["solve", "CASE", "--unit", LONG],
        ["solve", "CASE", "--unit", f"nip_load={LONG}"],
        ["solve", "CASE", "--unit", f"{DEEP}=mm"],
        ["solve", "CASE", "--save", f"{LONG}.nc"],
        ["solve", "CASE", "--save", f"x.{LONG}"],
        ["solve", "CASE", "--plot", f"{LONG}/x.png"],
        ["solve", "CASE", "--set", LONG],
        ["solve", "CASE", "--set", f"{LONG}=5"],
        ["solve", "CASE", "--set", f"{LONG}={LONG}"],
        ["solve", "CASE", "--set", f"nip_load={LONG}"],
        ["solve", "CASE", "--set", f"nip_load={DIGITS} N/m"],
        ["solve", "CASE", "--set", f"nip_load=5 {LONG}"],
        ["solve", "CASE", "--set", f"web.material={LONG}"],
        ["solve", "CASE", "--set", f"drum={LONG}"],
        ["report", "CASE", "--out", f"{LONG}.html"],
    ],
    ids=lambda args: " ".join(arg[:12] for arg in args),
)
def test_error_lines_are_short_whatever_they_quote(args: list[str], case: str, capsys: Capture):
    assert cli.main([case if arg == "CASE" else arg for arg in args]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert max(map(len, said.splitlines())) < LONGEST_LINE
    assert said.replace("\n", "").isprintable()


# ---- folders in place of files ------------------------------------------------------------------


@pytest.mark.parametrize("folder", [".", "..", "/", "", "./", "../."])
@pytest.mark.parametrize("out", [[], ["--out", "report.html"]])
def test_a_report_of_a_folder_is_rejected(
    folder: str, out: list[str], capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["report", folder, *out]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert len(said.err.splitlines()) == 1
    assert not list(tmp_path.iterdir())


# ---- random command lines -----------------------------------------------------------------------

COMMANDS = cli.commands.commands
FILES = (
    "nip.toml", "rollers.toml", "study.toml", "data.csv", "empty.toml", "binary.toml", "folder",
    "missing.toml", "/dev/null", "-",
)  # fmt: skip
WORDS = (
    "", "-", "--", "nan", "-inf", "1e999", "-1", "0", "9" * 400, "none", "\x07", "\x1b[31m",
    "\N{GRINNING FACE}", "../../etc", "=", "nip_load=", "nip_load=nan", "nip_load=5 kg", "1:2:3",
    "nip_load=2:1", "web.thickness=1e-30", "web=1", "drum.material=unob", "mill", "x.png",
    "folder/x.nc", "/proc/x.csv", "[]", "{}", "'", "%s", "*", "wound_on_tension=1e9", "newsprint",
)  # fmt: skip


def random_arguments(draw: random.Random) -> list[str]:
    """Return a command with random arguments and options that it has, and words anywhere."""
    name = draw.choice(sorted({*COMMANDS, "nosuch"} - {"app"}))  # the server does not end
    args, command = [name], COMMANDS.get(name)
    # a command keeps its help option, whose names are those of the group
    group = click.Context(cli.commands, **cli.commands.context_settings)
    for part in command.get_params(click.Context(command, parent=group)) if command else ():
        if isinstance(part, click.Argument):
            args += draw.choices(FILES if draw.random() < 0.8 else WORDS, k=draw.choice([0, 1, 2]))
        elif draw.random() < 0.3:
            args += [draw.choice(part.opts), draw.choice(WORDS + FILES)]
    for _ in range(draw.choice([0, 0, 1])):
        args.insert(draw.randint(0, len(args)), draw.choice(WORDS))
    return args


@pytest.mark.parametrize(
    "seeds",
    [range(15), pytest.param(range(15, 515), marks=pytest.mark.slow)],
)
def test_random_command_lines_end_with_a_known_code(
    seeds: range, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    Path("folder").mkdir()
    for kind in ("nip", "rollers"):
        Path(f"{kind}.toml").write_text(template(kind), encoding="utf-8")
    Path("study.toml").write_text(study_template("rollers"), encoding="utf-8")
    Path("data.csv").write_text("nip_load [kN/m],wound_on_tension [N/m]\n2,600\n3,650\n")
    Path("empty.toml").touch()
    Path("binary.toml").write_bytes(bytes(range(256)))
    for seed in seeds:
        args = random_arguments(random.Random(seed))
        monkeypatch.setattr("sys.stdin", io.StringIO("garbage = ["))
        start = time.process_time()
        code, said = cli.main(args), capsys.readouterr()
        assert code in (0, 2, 3), args
        assert code == 0 or said.err, args
        assert max(map(len, said.err.splitlines()), default=0) < LONGEST_LINE, args
        assert time.process_time() - start < 15.0, args
