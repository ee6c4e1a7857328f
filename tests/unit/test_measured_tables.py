"""Measured tables that are ambiguous or of a wrong type: each is rejected, none is guessed at.

Evidence: the error names the table or the column, as it does for the same table in a file.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas
import pytest
from thesis_cases import newsprint_nip

import woundon as wo

NIP = newsprint_nip()
LOADS, WIDTHS = [2000.0, 3000.0], [4e-3, 5e-3]
GOOD = {"nip_load": LOADS, "half_width": WIDTHS}
VARY = {"roll_friction": (0.1, 0.3)}


def fit(measured, vary=VARY, **options):
    return wo.fit(NIP, measured, vary, nodes=17, starts=1, profiles=False, **options)


def rejected(measured, **options) -> list[tuple[str, str]]:
    with pytest.raises(wo.InvalidProblem) as fault:
        fit(measured, **options)
    return list(fault.value.faults)


# ---- two columns of one name --------------------------------------------------------------------


def twice(first: str, second: str) -> pandas.DataFrame:
    frame = pandas.DataFrame([[1.0, 2000.0, 4e-3], [2.0, 3000.0, 5e-3]])
    frame.columns = pandas.Index([first, second, "half_width"])
    return frame


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("nip_load", "nip_load"),
        ("nip_load", "nip load"),
        ("nip_load", " nip_load"),
        ("nip_load", "P"),
        ("nip_load [N/m]", "nip_load [kN/m]"),
        ("nip_load", "Nip-Load [kN/m]"),
    ],
)
def test_two_columns_of_one_quantity_are_rejected_in_memory_as_in_a_file(
    first: str, second: str, tmp_path: Path
):
    frame = twice(first, second)
    (_, text), *_ = rejected(frame)
    assert "two columns" in text
    assert "nip_load" in text
    frame.columns = pandas.Index(
        [name if "[" in name else f"{name} [N/m]" for name in (first, second)] + ["half_width [m]"]
    )
    frame.to_csv(tmp_path / "rig.csv", index=False)
    assert "two columns" in rejected(tmp_path / "rig.csv")[0][1]


# ---- wrong types --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "measured",
    [
        None, 5, 5.0, True, b"x", bytearray(b"x"), b"", [], [[1.0, 2.0]], (1.0,), {1.0}, object(),
        np.ones((2, 2)), np.float64(3), pandas.Series(LOADS, name="nip_load"),
        pandas.Index(LOADS), pandas.DataFrame, dict, len, iter(LOADS), 1j,
    ],
    ids=lambda given: type(given).__name__,
)  # fmt: skip
def test_what_is_no_table_is_rejected(measured):
    assert rejected(measured)[0][0].startswith("measured")


@pytest.mark.parametrize(
    "cells",
    [
        [2000.0, None], [2000.0, []], [2000.0, "x"], [2000.0, b"1"], [2000.0, 1j],
        [2000.0, {"a": 1}], [2000.0, object()], [2000.0, 10**5000], [2000.0, -(10**5000)],
        [2000.0, np.ones(2)], [2000.0, True], [2000.0, pandas.NaT], [2000.0, "9" * 5000],
        [2000.0, "1" * 100_000 + "x"], [2000.0, f"{'9' * 5000} N/m"], [2000.0, np.inf],
        [2000.0, pandas.DataFrame({"a": [1]})],
    ],
    ids=lambda cells: repr(type(cells[1])),
)  # fmt: skip
def test_a_cell_that_is_no_number_is_rejected_by_row_and_column(cells):
    where, text = rejected({**GOOD, "nip_load": cells})[0]
    assert where == "measured"
    assert "row 2, column 'nip_load'" in text
    assert len(text) < 1000
