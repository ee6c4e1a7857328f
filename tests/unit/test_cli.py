"""The command line as its user meets it: what is printed, where, and with which exit code."""

from __future__ import annotations

import inspect
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from slow_cases import slow_case

import woundon as wo
from woundon import kinds
from woundon.cli import commands as cli
from woundon.io.case_files import template
from woundon.io.case_texts import to_toml
from woundon.studies.study_file import load_study

EXAMPLE = str(Path(__file__).parents[2] / "examples" / "newsprint_table2.toml")
ALONE = ["--set", "roll_wrap=0"]
QUICK = ["solve", EXAMPLE, *ALONE, "--nodes", "33"]
WRAPPED = ["solve", EXAMPLE, "--nodes", "33"]

Capture = pytest.CaptureFixture[str]


def test_rolls_have_no_sensitivity(tmp_path, capsys: Capture):
    case = tmp_path / "roll.toml"
    case.write_text(to_toml(wo.RollProblem.example()), encoding="utf-8")
    assert cli.main(["solve", str(case), "--sensitivity"]) == 2
    said = "error: --sensitivity: not available for the kind 'roll', but for "
    assert said in capsys.readouterr().err


def test_sensitivity_is_in_the_json_too(tmp_path, capsys: Capture):
    assert cli.main([*QUICK, "--sensitivity", "--json"]) == 0
    text = capsys.readouterr().out
    record = json.loads(text)["sensitivity"]
    exact = wo.solve(wo.load_case(EXAMPLE, ALONE[1:]), nodes=33).sensitivity()
    for output in exact.outputs:
        for name in exact.parameters:
            assert record["derivatives"][output][name] == exact.derivative(output, name)
    assert next(iter(record["elasticities"]["half_width"])) == "web_tension"
    assert record["zone_change"] == ""
    saved = tmp_path / "nip.json"
    saved.write_text(text, encoding="utf-8")
    assert wo.load_result(saved).problem == wo.load_case(EXAMPLE, ALONE[1:])


@pytest.mark.parametrize("kind", ["nip", slow_case("rollers")])
def test_every_kind_is_made_solved_saved_and_drawn(kind, tmp_path, capsys: Capture):
    assert cli.main(["new", kind]) == 0
    case, saved, drawn = (tmp_path / name for name in ("case.toml", "case.nc", "case.png"))
    case.write_text(capsys.readouterr().out, encoding="utf-8")
    args = ["solve", str(case), "--nodes", "25", "--save", str(saved), "--json"]
    assert cli.main([*args, "--plot", str(drawn)]) == 0
    printed = tmp_path / "printed.json"
    printed.write_text(capsys.readouterr().out, encoding="utf-8")
    assert wo.load_result(saved) == wo.load_result(printed)
    assert wo.load_result(saved).problem == wo.load_case(case)
    assert drawn.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "kind",
    [  # whose sweeps take long
        slow_case(kind) if kind.name == "roll" else kind for kind in kinds.every()
    ],
    ids=lambda kind: kind.name,
)
def test_every_kind_has_a_study_that_runs_as_it_is(kind, tmp_path, capsys: Capture):
    assert cli.main(["new", kind.name]) == 0
    assert capsys.readouterr().out == template(kind.name)
    assert cli.main(["new", "--study", kind.name]) == 0
    study = tmp_path / "study.toml"
    study.write_text(capsys.readouterr().out, encoding="utf-8")
    loaded = load_study(study)
    assert loaded.problem == kind.problem.example()
    assert len(loaded.over) == 2
    if kind.name == "winding":
        return  # ten of them take a minute; tests/unit/test_winding.py sweeps one
    out = tmp_path / "results"
    assert cli.main(["sweep", str(study), "--out", str(out), "--workers", "1"]) == 0
    assert "10 cases" in (said := capsys.readouterr().out)
    assert " 0 failed" in said
    assert all((out / f"{output}.png").exists() for output in loaded.outputs)


class Pressed:
    """An output at whose last flush Ctrl-C is pressed once more."""

    def flush(self) -> None:
        raise KeyboardInterrupt


@pytest.mark.parametrize("code", [0, 3, 130])
def test_ctrl_c_when_all_is_reported_is_no_fault(code, monkeypatch):
    monkeypatch.setattr(cli, "_run", lambda args: code)
    monkeypatch.setattr(sys, "stderr", Pressed())
    assert cli.main([]) == code


def test_ctrl_c_while_a_class_is_defined_is_an_interrupt(monkeypatch, capsys: Capture):
    class Interrupted:
        def __set_name__(self, owner: type, name: str) -> None:
            raise KeyboardInterrupt

    def import_a_module(*_: object, **__: object) -> None:
        type("Imported", (), {"member": Interrupted()})  # Python 3.11 raises a RuntimeError

    monkeypatch.setattr(kinds, "solve", import_a_module)
    assert cli.main(QUICK) == 130
    assert "Traceback" not in capsys.readouterr().err


def test_not_converged_has_its_own_code(monkeypatch, capsys: Capture):
    def give_up(*_: object, **__: object) -> None:
        raise wo.NotConverged("the estimated error of NIT is 0.3 N/m")

    monkeypatch.setattr(kinds, "solve", give_up)
    assert cli.main(QUICK) == 3
    said = capsys.readouterr()
    assert said.err == "error: not converged: the estimated error of NIT is 0.3 N/m\n"
    assert said.out == ""


# ---- wraps, fields and outputs of each kind -----------------------------------------------------


@pytest.mark.parametrize("kind", kinds.every(), ids=lambda kind: kind.name)
def test_describe_lists_fields_outputs_and_options(kind, capsys: Capture):
    assert cli.main(["describe", kind.name]) == 0
    lines = capsys.readouterr().out.splitlines()
    rows = {tuple(line.split()[:2]) for line in lines if line.startswith(" ")}
    text = " ".join(" ".join(lines).split())
    for place in wo.quantities.walk(kind.problem.example()):
        quantity = place.quantity
        if quantity and place.owner is not wo.Taper and " " not in quantity.symbol:
            assert (place.name, quantity.symbol) in rows
        else:
            assert place.name in {row[0] for row in rows}
    for place in wo.quantities.outputs(kind.result):
        assert (place.path, place.quantity.symbol.split()[0]) in rows
    for name in kind.solver_options():
        assert f"--{name.replace('_', '-')} " in text
    # the range of friction: rollers may have none; of a roll that of its expansion
    ranges = {"rollers": "(0 to 10)", "roll": "(-0.01 to 0.01)"}
    assert ranges.get(kind.name, "(1e-08 to 10)") in text


@pytest.mark.parametrize(
    ("command", "hint"),
    [
        (["report", "x.toml", "-o", "y.html"], "'-o'; did you mean --out?"),
        (
            ["solve", "x.toml", "-o", "y.html"],
            "'-o'; known: --coupling-rtol, --decimal-comma",
        ),
        (["sweep", "--otu", "x"], "'--otu'; did you mean '--out'?"),
    ],
)
def test_an_unknown_option_names_the_right_one(command, hint, capsys: Capture):
    assert cli.main(command) == 2
    assert capsys.readouterr().err.startswith(f"error: No such option {hint}")


@pytest.mark.parametrize(
    ("command", "function"),
    [
        ("compare", wo.compare),
        ("find", wo.find),
        ("fit", wo.fit),
        ("plan", wo.next_experiment),
        ("sobol", wo.global_sensitivity),
        ("table", wo.solve_table),
        ("window", wo.operating_window),
    ],
)
def test_options_are_those_of_the_public_function(command, function):
    """Evidence: consistency. A command passes options on by name, and states the same defaults."""
    params = cli.commands.commands[command].params
    used = inspect.signature(cli.commands.commands[command].callback).parameters
    passed = [p for p in params if p.expose_value and p.name not in used]
    known = inspect.signature(function).parameters
    assert passed
    for option in passed:
        if not option.name.startswith("tab_"):  # they make a pull tab
            assert option.name in known
            if isinstance(option.default, (bool, int, float)):
                assert option.default == known[option.name].default


# ---- options that are given twice ---------------------------------------------------------------


def single_options() -> Iterator[tuple[list[str], str]]:
    """Yield command, with arguments, and name of all options, except flags and repeatable ones."""
    # a command keeps its help option, whose names are those of the group
    group = click.Context(cli.commands, **cli.commands.context_settings)
    for name in cli.commands.list_commands(group):  # plug-ins too
        command = cli.commands.get_command(group, name)
        params = command.get_params(click.Context(command, parent=group))
        arguments = ["x" for p in params if isinstance(p, click.Argument) and p.required]
        for option in params:
            if isinstance(option, click.Option) and not (option.is_flag or option.multiple):
                yield [name, *arguments], option.opts[-1]


@pytest.mark.parametrize(("command", "option"), list(single_options()))
def test_an_option_given_twice_is_rejected_with_both_values(command, option, capsys: Capture):
    assert cli.main([*command, option, "5", option, "7"]) == 2
    message = f"error: {option}: is given twice, '5' and '7'; must be given once\n"
    assert capsys.readouterr() == ("", message)


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["solve", "--set", "nip_load=1", "--set", "nip_load=2"],
         "nip_load: is given twice, 'nip_load=1' and 'nip_load=2'"),
        (["solve", "--set", "wrap.roll_wrap=1", "--roll-wrap", "2"],
         "wrap.roll_wrap: is given twice, 'wrap.roll_wrap=1' and 'roll_wrap=2'"),
        (["solve", "--set", "roll.radius=0.1", "--set", "roll.diameter=0.3"],
         "roll.radius: is given twice, 'roll.radius=0.1' and 'roll.diameter=0.3'"),
        (["solve", "--unit", "nip_load=pli", "--unit", "nip_load=kN/m"],
         "nip_load: is given twice, 'pli' and 'kN/m'"),
        (["solve", "--unit", "mill", "--unit", "SI"],
         "system of units: is given twice, 'mill' and 'SI'"),
        (["find", "--vary", "nip_load", "--tie", "a=b", "--tie", "a=c"],
         "--tie a: is given twice, 'b' and 'c'"),
        (["fit", "no.csv", "--vary", "nip_load", "--vary", "nip_load=1:2"],
         "--vary nip_load: is given twice, None and (1.0, 2.0)"),
        (["compare", "no.csv", "--column", "a=b", "--column", "a="],
         "--column a: is given twice, 'b' and None"),
        (["compare", "no.csv", "--spread", "nip_load=3 N/m", "--spread", "nip_load=2"],
         "--spread nip_load: is given twice, '3 N/m' and 2.0"),
        (["sweep", "--out", "x", "--export", "csv", "--export", "csv"],
         "--export csv: is given twice, 'csv' and 'csv'"),
        (["window", "--uncertain", "roll_friction=1 %", "--uncertain", "roll_friction=2 %"],
         "--uncertain roll_friction: is given twice, '1 %' and '2 %'"),
    ],
)  # fmt: skip
def test_a_name_given_twice_is_rejected_with_both_values(args, message, capsys: Capture):
    command, *rest = args
    assert cli.main([command, EXAMPLE, *rest]) == 2
    assert capsys.readouterr() == ("", f"error: {message}; must be given once\n")


def test_fields_of_one_table_and_flags_may_be_repeated(capsys: Capture):
    settings = ["--set", "drum.kind=cylinder", "--set", "drum.core_radius=70 mm"]
    command = [*QUICK, *settings, "--set", "drum.material=soft-cover", "--json", "--json"]
    assert cli.main(command) == 0
    assert json.loads(capsys.readouterr().out)["problem"]["drum"]["core_radius"] == 0.07


# ---- units --------------------------------------------------------------------------------------


def test_units_are_of_names_of_the_case(tmp_path, capsys: Capture):
    case = tmp_path / "roll.toml"
    case.write_text(template("roll"), encoding="utf-8")
    study = tmp_path / "study.toml"
    over = 'schema = 1\ncase = "roll.toml"\n[over]\nradius = [0.1, 0.15]\n'
    study.write_text(over, encoding="utf-8")
    for command in (
        ["solve", str(case)],
        ["report", str(case)],
        ["sweep", str(study), "--out", "none"],
        ["table", "cases.csv", "--kind", "roll", "-o", str(tmp_path / "solved.csv")],
    ):
        assert cli.main([*command, "--unit", "nip_load=kN/m"]) == 2  # a field of nips
        message = capsys.readouterr().err
        assert message.startswith("error: nip_load: no field or output; known: bending_strain, ")


# ---- written files ------------------------------------------------------------------------------

FIND = ["find", EXAMPLE, *ALONE, "--nodes", "17", "--vary", "nip_load=1000:4000", "--points", "3"]
FOUND = [*FIND, "--target", "wound_on_tension=600"]


@pytest.mark.parametrize(
    ("command", "files"),
    [
        ([*QUICK], {"--save": "a.csv", "--plot": "b.svg"}),
        (FOUND, {"--case": "a.toml", "--plot": "b.svg"}),
        (["schedule", "roll.toml", "--pressure", "200 kPa", "--rtol", "1e-3"],
         {"--out": "a.csv", "--case": "b.toml"}),
    ],
)  # fmt: skip
def test_written_files_are_named(command, files, tmp_path, monkeypatch, capsys: Capture):
    monkeypatch.chdir(tmp_path)
    Path("roll.toml").write_text(template("roll"), encoding="utf-8")
    options = [part for option in files.items() for part in option]
    assert cli.main([*command, *options]) == 0
    expected = f"written: {', '.join(files.values())}"
    assert capsys.readouterr().out.splitlines()[-1] == expected
    assert all(Path(file).stat().st_size for file in files.values())


def test_next_to_json_written_files_are_named_on_the_error_channel(
    tmp_path, monkeypatch, capsys: Capture
):
    monkeypatch.chdir(tmp_path)
    assert cli.main([*FOUND, "--case", "a.toml", "--json"]) == 0
    printed = capsys.readouterr()
    assert json.loads(printed.out)["output"] == "wound_on_tension"
    assert printed.err.splitlines()[-1] == "written: a.toml"


@pytest.mark.parametrize(("encoding", "sign", "name"), [
    ("utf-8", "±", "\N{LATIN SMALL LETTER L WITH STROKE}.toml"),
    ("latin-1", "+-", "\\u0142.toml"),
])  # fmt: skip
def test_a_terminal_gets_characters_that_it_can_show(encoding, sign, name, tmp_path):
    """Solve and find write an error in the same way."""
    file = tmp_path / "\N{LATIN SMALL LETTER L WITH STROKE}.toml"
    for command in (QUICK, [*FOUND, "--case", str(file)]):
        done = run_apart("-m", "woundon", *command, PYTHONIOENCODING=encoding)
        assert f" {sign} " in done.stdout.decode(encoding)
    assert done.stdout.decode(encoding).splitlines()[-1] == f"written: {tmp_path / name}"


def test_a_coarse_mesh_is_reported_in_terms_of_all_interfaces(capsys: Capture):
    """Neither nodes=33 of Python nor --nodes 33 of the command line."""
    assert cli.main(["solve", EXAMPLE, *ALONE, "--set", "nip_load=1000", "--nodes", "17"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "the ends of which are known to 0.17 mm; use 33 nodes" in text


def test_an_unknown_name_of_the_package_names_those_like_it():
    with pytest.raises(AttributeError, match=r"'load'; did you mean load_case or load_result\?"):
        wo.load  # noqa: B018
    assert not hasattr(wo, "xyzzy")


# ---- processes of its own ------------------------------------------------------------------------


def run_apart(*args: str, **environment: str) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run(
        [sys.executable, *args],
        capture_output=True,
        check=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), **environment},
    )


@pytest.mark.parametrize("args", [["--version"], ["--help"]])
def test_cheap_commands_load_nothing_heavy(args):
    heavy = ("numpy", "scipy", "matplotlib", "pint", "xarray", "pydantic", "rich")
    code = (
        f"import sys; from woundon.cli import commands as cli; code = cli.main({args});"
        f"print(code, [name for name in {heavy} if name in sys.modules])"
    )
    assert run_apart("-c", code).stdout.decode().splitlines()[-1] == "0 []"


def test_a_nip_is_solved_without_what_is_slow_to_import():
    # of SciPy, only scipy.linalg is needed; the others take a quarter of a second
    heavy = (
        *("pint", "dask", "pandas", "xarray", "matplotlib", "openpyxl", "threadpoolctl"),
        *("scipy.interpolate", "scipy.optimize", "scipy.special", "scipy.sparse"),
    )
    code = (
        "import sys; from woundon.cli import commands as cli; "
        f"cli.main({QUICK}); cli.main({WRAPPED}); "
        f"print([name for name in {heavy} if name in sys.modules])"
    )
    assert run_apart("-c", code).stdout.decode().splitlines()[-1] == "[]"


def test_the_objects_of_modules_are_not_searched_for_unused_ones():
    # a quarter of the time of a solution; functions registered first are called last
    code = (
        "import atexit, gc; from woundon.cli import commands as cli; kept = gc.get_freeze_count; "
        "atexit.register(lambda: print(*good, kept() > after_first)); "
        f"cli.main({QUICK}); after_first = kept(); good = [after_first > 50_000, gc.isenabled()]; "
        f"cli.main({QUICK}); good.append(kept() <= after_first)"
    )
    assert run_apart("-c", code).stdout.decode().splitlines()[-1] == "True True True True"


def in_shell(command: str) -> subprocess.CompletedProcess[bytes]:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    shell = ["bash", "-o", "pipefail", "-c", f"{sys.executable} -m woundon {command}"]
    return subprocess.run(shell, capture_output=True, env=environment, check=False)


SLOW = pytest.mark.slow  # each is a process


@pytest.mark.parametrize(
    ("reader", "more"),
    [
        ("head -c 10", "--json"),
        *(slow_case(*row) for row in [("true", "--json"), ("head -n 1", "")]),
    ],
)  # fmt: skip
def test_a_reader_that_leaves_is_no_fault(reader, more):
    done = in_shell(f"{' '.join(WRAPPED)} {more} | {reader}")
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize(
    ("args", "code"),
    [
        ("--help", 0), ("new", 0), ("nap", 2), ("", 2),
        *(pytest.param(*case, marks=SLOW) for case in
          [("--version", 0), ("solve --help", 0), ("materials", 0), ("solve none.toml", 2)]),
    ],
)  # fmt: skip
@pytest.mark.parametrize("channel", ["", pytest.param("2>&1", marks=SLOW)])
def test_nobody_reads_what_any_command_says(args, code, channel):
    """Neither a traceback nor "Exception ignored"; the exit code is that of what happened."""
    done = in_shell(f"{args} {channel} | true")
    assert done.returncode == code
    assert b"Traceback" not in done.stderr
    assert b"ignored" not in done.stderr


@SLOW
def test_a_study_goes_on_though_nobody_reads_its_progress(tmp_path, capsys: Capture):
    assert cli.main(["new", "--study", "rollers"]) == 0
    (tmp_path / "study.toml").write_text(capsys.readouterr().out, encoding="utf-8")
    done = in_shell(f"sweep {tmp_path}/study.toml --out {tmp_path}/out --workers 1 2>&1 | true")
    assert (done.returncode, done.stderr) == (0, b"")
    assert len((tmp_path / "out" / "study.csv").read_text("utf-8").splitlines()) == 11


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a disk that is always full, of Linux")
def test_a_full_disk_is_one_line_or_a_code():
    done = in_shell(f"{' '.join(QUICK)} > /dev/full")
    assert (done.returncode, done.stderr) == (2, b"error: No space left on device\n")
    assert in_shell("nap 2> /dev/full").returncode == 2


def test_the_report_of_a_saved_result_is_that_of_its_case(tmp_path: Path):
    result = wo.solve(wo.RollerProblem.example(), nodes=33)
    for name in ("rollers.json", "rollers.nc"):
        result.save(tmp_path / name)
        out = tmp_path / f"{name}.html"
        assert cli.main(["report", str(tmp_path / name), "--out", str(out)]) == 0
        assert "354" in out.read_text()  # the half width [um]
    assert cli.main(["report", str(tmp_path / "rollers.json"), "--set", "friction=0.1"]) == 2
