"""Arguments of the wrong type are rejected with their name, value and what is permitted."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import woundon as wo

PAIR, NIP, WINDING = (
    kind.example() for kind in (wo.RollerProblem, wo.NipProblem, wo.WindingProblem)
)
LOADS = {"load": [5e4, 1e5]}
OF_STUDIES = [
    ("tie", 5), ("tie", ["friction"]), ("options", 5), ("options", ["nodes"]), ("options", "nodes"),
    ("progress", 5), ("progress", "yes"), ("nodes", "many"), ("rtol", []), ("workers", "all"),
    ("workers", 2.0),
]  # fmt: skip
OF_STORES = [("out", 5), ("out", b"out"), ("scheduler", 5), ("scheduler", ("tcp", 9))]
OF_SWEEPS = [
    ("outputs", 5), ("outputs", [5]), ("outputs", [["half_width"]]), ("columns", 5),
    ("columns", ["load"]), ("chunk", "10"), ("chunk", 2.0), ("chunk", True), ("chunk", -3),
    ("design", 5), ("design", ["grid"]), ("over", 5), ("over", None),
    ("over", {"load": range(10**12)}),
]  # fmt: skip
OF_FINDS = [
    ("between", 5), ("between", "1 N/m"), ("between", (1e4, [])), ("between", (None, 1e4)),
    ("points", 5.0), ("half_width", None), ("half_width", [1e-4]), ("half_width", True),
]  # fmt: skip


def sweep(**given: Any) -> Any:
    return wo.sweep(PAIR, **{"over": LOADS, "outputs": ["half_width"], **given})


def drawn(**given: Any) -> Any:
    ranges = {"load": (5e4, 1e5)}
    usual = {"outputs": ["half_width"], "design": "latin-hypercube", "samples": 2}
    return wo.sweep(PAIR, ranges, **{**usual, **given})


def table(**given: Any) -> Any:
    return wo.solve_table(LOADS, PAIR, **{"outputs": ["half_width"], **given})


def find(**given: Any) -> Any:
    return wo.find(PAIR, "load", **{"half_width": 3e-4, **given})


def sobol(**given: Any) -> Any:
    ranges = {"load": (5e4, 1e5), "friction": (0.3, 0.5)}
    return wo.global_sensitivity(PAIR, ranges, ["half_width"], **{"samples": 16, **given})


def window(**given: Any) -> Any:
    problem = WINDING.replace(limits=wo.Limits(web_strength=700.0))
    usual = {"web_tension": (200, 500), "nip_load": (1e3, 4e3), "uncertain": {"roll_friction": 0.3}}
    return wo.operating_window(problem, **{**usual, **given})


# how a message states what is permitted
PERMITTED = (
    "must be", "did you mean", "known:", "write (", "nothing to vary", "more than", "expected",
)  # fmt: skip
CASES = [
    *((sweep, *given) for given in [*OF_STUDIES, *OF_STORES, *OF_SWEEPS]),
    *((drawn, "samples", value) for value in ("2", 2.0, True, None)),
    *((drawn, "seed", value) for value in ("1", 1.0, True, None, -1)),
    *((table, *given) for given in [*OF_STUDIES, ("outputs", 5), ("chunk", 2.0), ("columns", 5)]),
    *((find, *given) for given in [*OF_STUDIES[:-2], *OF_FINDS]),
    *((sobol, *given) for given in [*OF_STUDIES, *OF_STORES]),
    *((window, *given) for given in [*OF_STUDIES[:7], *OF_STUDIES[-2:], *OF_STORES]),
    *((window, "seed", value) for value in ("1", 1.0, None, -1)),
]  # fmt: skip


@pytest.mark.parametrize(("study", "name", "value"), CASES)
def test_arguments_of_the_wrong_type_are_named_before_the_work(
    study: Callable[..., Any], name: str, value: Any, tmp_path: Path
):
    given = {"out": tmp_path / "out"} if study in (sweep, drawn, sobol, window) else {}
    with pytest.raises(wo.InvalidProblem) as fault:
        study(**{**given, name: value})
    (field, text), *_ = fault.value.faults
    assert name in field.split(": ")
    assert any(word in text for word in PERMITTED)
    assert not (tmp_path / "out").exists()
