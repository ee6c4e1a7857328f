"""Messages for invalid input: one golden file, ``tests/golden/messages.txt``.

Each entry is an expression, which is evaluated here, and the message of its exception.  The same
input gives the same message in Python, in a case file and on the command line.
"""

from __future__ import annotations

import os
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden_text import assert_golden, read_golden
from nip_study import nip_study

import woundon as wo
from woundon.cli.commands import main
from woundon.io.case_files import apply_settings, make_problem, to_toml
from woundon.problems.units import parse
from woundon.studies.api import study_of
from woundon.studies.column_names import columns_of, measurable_outputs
from woundon.studies.measured_tables import read_measured
from woundon.studies.study_file import load_study

EXAMPLE = Path(__file__).parents[2] / "examples" / "newsprint_table2.toml"
INDENT = "    "
NIP = wo.NipProblem.example()
PAIR = wo.RollerProblem.example()
ORTHOTROPIC = {"radial": 20e6, "tangential": 3e9, "cross": 5e6, "shear": 10e6}
CYLINDER = {"radius": 0.1, "core_radius": 0.05, "material": "steel"}


def nip(**changes: Any) -> Any:
    """Construct the example of a nip with some fields changed."""
    return wo.NipProblem(**{name: getattr(NIP, name) for name in type(NIP).model_fields} | changes)


def rollers(**changes: Any) -> Any:
    """Construct the example of two rollers with some fields changed."""
    given = {name: getattr(PAIR, name) for name in type(PAIR).model_fields}
    return wo.RollerProblem(**given | changes)


def variant(**changes: Any) -> Any:
    """Change fields of the example of a nip; "__" stands for a dot."""
    return NIP.replace(**{name.replace("__", "."): value for name, value in changes.items()})


def solve(problem: Any, **options: Any) -> Any:
    return wo.solve(problem, **options)


def next_nips(*changed: Any, **fields: Any) -> Any:
    """Return the example of a nip with further nips: each a table of changed fields."""
    front = {"angle": 1.5, "drum": wo.Rigid(radius=0.25), "nip_load": 2000.0}
    return NIP.replace(next_nips=[front | one for one in changed], **fields)


ROLL, WINDING = wo.RollProblem.example(), wo.WindingProblem.example()
WINDER = WINDING.replace(
    winder=wo.TwoDrums(front_drum=wo.Rigid(radius=0.25), gap=0.02, rider_load=2500.0),
    drum=wo.Rigid(radius=0.3), nip_load=None, torque_split=0.5,
)  # fmt: skip
RUBBER = wo.Isotropic(youngs_modulus=5e6, poissons_ratio=0.45, prony=[(3e6, 1e-3)])
WOUND = wo.WoundRoll(radius=0.1, core_radius=0.0445, stack=ROLL.stack, pressure=2e5)
PROFILE = wo.ThicknessProfile(position=[0, 1, 2], thickness=["66 um", "66.4 um", "65.6 um"])
DRUM = wo.DrumBending(flexural_rigidity=3e6, bearing_distance=0.2)


def plan(unknown: Any, *candidates: Any, **options: Any) -> Any:
    return wo.next_experiment(NIP, unknown, candidates, draws=0, **options)


def fit(measured: Any, **options: Any) -> Any:
    return wo.fit(NIP, measured, ["roll_friction"], **options)


def case(setting: str) -> Any:
    """Load the example of a case file with a setting."""
    return wo.load_case(EXAMPLE, [setting])


def written(text: str, name: str) -> str:
    """Write a file into the folder of the test."""
    Path(name).write_text(text, "utf-8")
    return name


def measured(text: str) -> Any:
    """Read measured values of a nip."""
    return read_measured(written(text, "rig.csv"), columns_of(NIP), measurable_outputs(NIP))


def cases(text: str) -> Any:
    """Sweep over the cases of a table."""
    return wo.sweep(NIP, written(text, "cases.csv"))


STUDY = nip_study(EXAMPLE)


def study(old: str, new: str) -> Any:
    """Prepare a study from a file with one text replaced by another."""
    return study_of(**load_study(written(STUDY.replace(old, new), "study.toml")).arguments)


NAMES = {
    "wo": wo, "np": np, "nan": float("nan"), "inf": float("inf"), "Decimal": Decimal, "nip": nip,
    "rollers": rollers, "variant": variant, "solve": solve, "NIP": NIP, "PAIR": PAIR,
    "ORTHOTROPIC": ORTHOTROPIC, "CYLINDER": CYLINDER, "ROLL": ROLL, "WINDING": WINDING,
    "STACK": ROLL.stack, "WOUND": WOUND, "RUBBER": RUBBER, "WINDER": WINDER,
    "PROFILE": PROFILE, "DRUM": DRUM,
    "COVER": wo.Cylinder(radius=0.25, core_radius=0.235, material=RUBBER),
    "plan": plan, "next_nips": next_nips,
    "fit": fit, "case": case, "study": study, "parse": parse, "written": written,
    "measured": measured, "cases": cases, "to_toml": to_toml, "make_problem": make_problem,
    "apply_settings": apply_settings,
}  # fmt: skip


def message(expression: str) -> str:
    """Return the message with which the input of an expression is rejected."""
    with pytest.raises(wo.InvalidProblem) as report:
        eval(expression, dict(NAMES))
    assert "pydantic" not in str(report.value)
    assert report.value.__cause__ is None  # nothing of pydantic in the traceback
    return str(report.value)


def test_messages_of_the_golden_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # where entries write their files
    entries = [
        line for line in read_golden("messages.txt").splitlines() if not line.startswith(INDENT)
    ]
    assert len(entries) > 100
    assert_golden(
        "messages.txt",
        "".join(
            f"{entry}\n{INDENT}" + message(entry).replace("\n", f"\n{INDENT}") + "\n"
            for entry in entries
        ),
    )


@pytest.mark.parametrize(
    "bad",
    [
        {"nip_load": -1}, {"nip_load": "3 kN"}, {"web.thickness": "66 s"}, {"nip_laod": 5},
        {"winding_force": 701.0}, {"roll.core_radius": 0.2}, {"web.material": "steeel"},
    ],
)  # fmt: skip
def test_a_case_file_and_the_command_line_give_the_same_message(
    bad: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(wo.InvalidProblem) as report:
        NIP.replace(**bad)
    ((name, value),) = bad.items()
    path = tmp_path / "case.toml"
    path.write_text(to_toml(NIP), encoding="utf-8")
    with pytest.raises(wo.InvalidProblem) as other:
        wo.load_case(path, [f"{name}={value}"])
    assert str(other.value) == str(report.value)
    assert main(["solve", str(path), "--set", f"{name}={value}"]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err == f"error: {report.value}\n"


def test_sliding_is_no_steady_state() -> None:
    for change in ({"winding_force": -701.0}, {"winding_force": 701.0}):
        with pytest.raises(wo.NoSteadyState):
            nip(**change)
        with pytest.raises(wo.NoSteadyState):
            NIP.replace(**change)
    with pytest.raises(wo.NoSteadyState):
        rollers(tangential_load=44500.0)


def test_an_output_is_rejected_before_anything_is_solved(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_solving(*_: object, **__: object) -> None:
        raise AssertionError("solved first")

    monkeypatch.setattr("woundon.kinds.solve", no_solving)
    case = tmp_path / "case.toml"
    case.write_text(to_toml(NIP), encoding="utf-8")
    # root may write anywhere, so the answer of the system replaces the permissions
    monkeypatch.setattr("os.access", lambda _, mode: mode != os.W_OK)
    for option, ending in (("--save", "nc"), ("--plot", "png")):
        for name, text in (
            ("no/where/x." + ending, "the folder"), ("x.xyz", "the ending"),
            ("x." + ending, "cannot be written: no permission"),
        ):  # fmt: skip
            target = str(tmp_path / name)
            assert main(["solve", str(case), option, target]) == 2
            error = capsys.readouterr().err
            assert error.startswith(f"error: {target}: ")
            assert text in error
    assert [path.name for path in tmp_path.iterdir()] == ["case.toml"]  # nothing was written


def test_options_may_be_numpy_numbers() -> None:
    assert wo.solve(NIP.replace(roll_wrap=0.0), nodes=np.int64(17)).nodes == 17
    assert max(wo.solve(PAIR, rtol=np.float32(0.1)).errors.values()) > 0
