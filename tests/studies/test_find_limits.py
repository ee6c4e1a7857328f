"""``wo.find`` near limits of existence, against scans of random problems of all kinds."""

from __future__ import annotations

import pytest
from find_questions import KINDS, Question, random_question
from slow_cases import slow_case

import woundon as wo

RANGE = 1e-3  # the stated accuracy of a range, of its end or of the target
# Of a solution: Brent's method stops at 1e-7 of the target.
TARGET = 1e-5
# 17 of the scan and of a sparse range, two limits of 31, two extreme values of 17, two roots of 10
MOST_SOLVES = 150


def assert_right(question: Question) -> tuple[str, int]:
    """Assert that a target is found if the scan reaches it, and the range if it does not.

    Returns the outcome and the number of solves.
    """
    solves: list[float] = []
    answer = question.ask(progress=lambda done, expected: solves.append(done))
    scan, target = question.scan, question.target
    smallest, largest = scan.extremes()
    size = max(abs(target), abs(smallest), abs(largest))
    # rolls and windings choose their meshes themselves
    adaptive = 0.0 if "nodes" in scan.options else 2 * max(scan.errors.values())
    assert len(solves) <= MOST_SOLVES, len(solves)
    if isinstance(answer, wo.NoSolution):
        slack = TARGET * size + adaptive
        assert not smallest + slack < target < largest - slack, "denied"
        if question.between is not None:
            for stated, true in zip(answer.reachable, (smallest, largest), strict=True):
                close = RANGE * max(abs(true), abs(target)) + adaptive
                assert stated == pytest.approx(true, abs=close), "range"
        return "no solution", len(solves)
    for value, result in answer.solutions:
        slack = TARGET * size + 2 * result.errors.get(question.output, 0.0)
        assert getattr(result, question.output) == pytest.approx(target, abs=slack), "target"
        # without a neighbour's solution
        assert scan.at(value) == pytest.approx(target, abs=slack), "not reproduced"
    return f"{len(answer.solutions)} found", len(solves)


@pytest.mark.parametrize(
    ("kind", "seed"),
    [("rollers", 17), ("rollers", 19), ("nip", 1), slow_case("rollers", 11),
     slow_case("rollers", 24), slow_case("nip", 18), slow_case("roll", 1)],
)  # fmt: skip
def test_no_solution_next_to_a_limit_is_denied_and_ranges_are_right(kind: str, seed: int) -> None:
    question = random_question(kind, seed)
    assert question is not None
    assert_right(question)


@pytest.mark.campaign
@pytest.mark.parametrize("kind", KINDS)
def test_fifty_random_questions(kind: str) -> None:
    asked, seed = 0, 0
    while asked < 50:
        question, seed = random_question(kind, seed), seed + 1
        if question is not None:
            assert_right(question)
            asked += 1
