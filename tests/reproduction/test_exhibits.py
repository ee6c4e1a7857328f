"""Every figure and table: as many statements of the thesis hold, and fail, as are known to.

Why a statement fails is reported next to it in the exhibit.  The figures are not drawn here.
"""

from __future__ import annotations

import io

import numpy as np
import pandas as pd
import pytest
from slow_cases import campaign_case

from woundon.jorkama2001.catalogue import NAMES, made_by, modules
from woundon.jorkama2001.exhibits import Exhibit, listed
from woundon.jorkama2001.verdicts import Outcome

# The documentation build, which CI runs too, computes all figures and compares these numbers; the
# tests of a second and more are for who changes a figure.
LONG = {"fig5", "fig16_18", "fig19", "fig21_22", "fig23_24", "fig26", "fig27", "fig28_29", "fig33",
        "table3"}  # fmt: skip


@pytest.mark.parametrize("module", [campaign_case(m) if m in LONG else m for m in modules(NAMES)])
def test_as_many_statements_hold_as_are_known_to(module: str) -> None:
    made = made_by(module, "accurate")
    assert [exhibit.name for exhibit in made] == [n for n in NAMES if listed()[n].module == module]
    for exhibit in made:
        failing = [v.statement for v in exhibit.verdicts if v.outcome is Outcome.FAILS]
        found = tuple(exhibit.count(outcome) for outcome in Outcome)
        assert found == listed()[exhibit.name].counts, failing
        _check_data(exhibit)


def _check_data(exhibit: Exhibit) -> None:
    """The CSV file has a unit in every header and leaves out nothing but what has no unit."""
    table = pd.read_csv(io.StringIO(exhibit.csv()))
    assert all(head.endswith("]") for head in table)
    names = {name for name, of in exhibit.data.variables.items() if "units" in of.attrs}
    assert {head.rpartition(" [")[0] for head in table} == names
    assert set(exhibit.data.data_vars) <= names
    assert not table.isna().all(axis=None)


def test_computing_times_are_those_that_were_measured() -> None:
    """Fig. 33 is the same whenever it is drawn: no clock is read for it."""
    from woundon.jorkama2001.fig33 import _converging, _times

    times = _times()
    first, again = (_converging("accurate", times["accurate"]) for _ in range(2))
    assert first.identical(again)
    assert (np.diff(times["thesis"]) > 0).all()


def test_a_false_statement_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fig. 15 with the wrong friction: the pattern that the text tells is not there."""
    from woundon.jorkama2001 import fig15

    base = fig15.paper_nip
    monkeypatch.setattr(fig15, "paper_nip", lambda **c: base(roll_friction=0.5, **c))
    for solver in ("accurate", "thesis"):
        (made,) = fig15.exhibits(solver)
        assert made.count(Outcome.FAILS) >= 2
