"""Arguments of wrong types: every one is rejected with its name, the value and what is permitted.

Evidence: each argument of the studies is given each wrong value; none ends in another exception,
and nothing is solved before.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

import woundon as wo

PAIR, ROLL = wo.RollerProblem.example(), wo.RollProblem.example()
WINDING = wo.WindingProblem.example().replace(limits=wo.Limits(web_strength=700.0))
ROWS = {"load [kN/m]": [50, 89, 120], "half_width [um]": [265, 354, 411]}
WIDTH = wo.Measurement("half_width", {}, "1 %")


def planned(
    *, quantity: Any, at: Any, standard_deviation: Any, cost: Any, problem: Any, fields: Any,
    label: Any,
) -> wo.NextExperiment:  # fmt: skip
    """Plan a measurement: its arguments are checked when it is made, and in the plan."""
    candidate = wo.Measurement(quantity, at, standard_deviation, cost, problem, fields, label)
    return wo.next_experiment(PAIR, {"upper.radius": "5 %"}, [candidate], draws=0)


STUDIES: dict[str, Callable[..., Any]] = {
    "fit": partial(wo.fit, problem=PAIR, measured=ROWS, vary={"upper.radius": (0.1, 1.0)}),
    "compare": partial(wo.compare, problem=PAIR, measured=ROWS),
    "next_experiment": partial(
        wo.next_experiment, problem=PAIR, unknown={"upper.radius": "5 %"}, candidates=[WIDTH]
    ),
    "optimise_schedule": partial(
        wo.optimise_schedule, problem=ROLL, over={"wound_on_tension": (200.0, 400.0)},
        limits=wo.Limits(core_pressure="1 MPa"),
    ),
    "global_sensitivity": partial(
        wo.global_sensitivity, problem=PAIR, over={"load": (5e4, 1e5), "friction": (0.3, 0.5)},
        outputs=["half_width"],
    ),
    "sweep": partial(wo.sweep, problem=PAIR, over={"load": [5e4]}, outputs=["half_width"]),
    "solve_table": partial(wo.solve_table, table={"load": [5e4]}, case=PAIR, outputs="half_width"),
    "find": partial(wo.find, PAIR, "load", half_width=3e-4),
    "operating_window": partial(
        wo.operating_window, problem=WINDING, web_tension=(200.0, 500.0), nip_load=(1e3, 4e3),
        uncertain={"roll_friction": 0.3},
    ),
    "Measurement": partial(
        planned, quantity="half_width", at={}, standard_deviation="1 %", cost=1.0, problem=PAIR,
        fields={}, label="",
    ),
}  # fmt: skip
PERMITTED = r"must be|expected|known: |nothing to vary|meaning|write \(low, high\)|together with"
WRONG = (-1.5, b"x", object(), [1], {1: 1}, float("nan"), np.ones(2))


def arguments() -> list[tuple[str, str]]:
    """Return every argument of every study."""
    return [
        (name, argument)
        for name, study in STUDIES.items()
        for argument in inspect.signature(study).parameters
    ]


@pytest.mark.parametrize(("study", "argument"), arguments())
def test_a_wrong_type_is_rejected_with_the_permitted_kind(
    study: str, argument: str, monkeypatch: pytest.MonkeyPatch
):
    def no_solving(*_: object, **__: object) -> None:
        raise AssertionError("solved first")

    monkeypatch.setattr("woundon.studies.model.KindModel.solve", no_solving)
    for value in WRONG:
        with pytest.raises(wo.InvalidProblem) as report:
            STUDIES[study](**{argument: value})
        assert argument in str(report.value)
        assert re.search(PERMITTED, str(report.value))
