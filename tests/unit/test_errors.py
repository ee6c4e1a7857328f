"""Errors: a line a fault, whatever is in the names and values that they tell."""

from __future__ import annotations

import pytest

import woundon as wo


@pytest.mark.parametrize(
    ("field", "shown"),
    [
        ("a\nb", r"a\nb: is wrong"),
        ("\x1b[31m\x00", r"\x1b[31m\x00: is wrong"),
        ("a\u2028\u202e\x85", r"a\u2028\u202e\x85: is wrong"),
        ("Breite [µm] é 幅", "Breite [µm] é 幅: is wrong"),
        ("x" * 100_000, f"{'x' * 100} ... {'x' * 99}: is wrong"),
    ],
)
def test_a_fault_is_one_line_that_any_terminal_shows(field, shown):
    fault = wo.InvalidProblem.at(field, "is wrong")
    assert str(fault) == shown
    assert fault.faults == ((field, "is wrong"),)
    assert str(fault.under("web")).startswith(f"web.{shown[:90]}")


def test_faults_by_the_thousand_are_counted():
    fault = wo.InvalidProblem([(f"f{k}", "is wrong") for k in range(1000)])
    lines = str(fault).splitlines()
    assert lines[0] == "f0: is wrong"
    assert lines[50:] == ["and 950 more"]
    assert len(fault.faults) == 1000
    assert "more" not in str(wo.InvalidProblem([("f", "is wrong")] * 50))
    assert str(wo.InvalidProblem([("f", "is wrong")] * 51)).endswith("\nand 1 more")
