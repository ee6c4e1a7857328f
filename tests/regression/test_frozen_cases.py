"""The frozen cases against version 0.1's numbers, all but the longest in five seconds.

Bound: 1e-8 of each number, three times what two solves differ by that meet their load to 3e-9; what
0.1 itself cannot give again so nearly has its own bound (``frozen.NOISE``).  A number that may
vanish is compared in absolute terms below a floor: 1 % of mu+ P for tensions, which rounding of the
tractions moves; 1e-3 of the half width for the offset; an elasticity of one for derivatives; the
norm of an array for its sums and end values.

``python benchmarks/frozen.py compare --tight`` compares to 1e-11, all loads met to 1e-13.
"""

from __future__ import annotations

from copy import deepcopy

import frozen
import pytest
from frozen_cases import Measured, frozen_cases

CASES = {case.name: case for case in frozen_cases()}


def test_the_set_is_complete() -> None:
    assert len(CASES) == 95
    kinds = [case.kind for case in CASES.values()]
    counts = {kind: kinds.count(kind) for kind in dict.fromkeys(kinds)}
    assert counts == {"nip": 41, "wrap": 20, "rollers": 15, "sensitivity": 9, "sweep": 5, "fit": 5}


LONG = [name for name in CASES if name.startswith(("fit 3:", "fit 5:"))]  # a second


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow) if n in LONG else n for n in CASES]
)
def test_the_numbers_of_version_0_1(name: str) -> None:
    case = CASES[name]
    found = list(frozen.differences(case, frozen.kept(case, "own"), frozen.measure(case)))
    assert len(found) > 10
    assert [d for d in found if d.miss] == []


def _misses(name: str, quantity: str, change: float, way: str = "own", place: int | None = None):
    """Return the quantities that miss where a stored number is changed by a share of itself."""
    case = next(case for case in CASES.values() if case.name.startswith(name))
    before = frozen.kept(case, way)
    now: Measured = deepcopy(before)
    if place is None:
        now[quantity] *= 1 + change
    else:
        now[quantity][place] *= 1 + change
    return [d.quantity for d in frozen.differences(case, before, now, way) if d.miss]


@pytest.mark.parametrize(
    ("name", "quantity", "place", "label"),
    [
        ("nip 1:", "nip_induced_tension", None, "nip_induced_tension"),
        ("nip 1:", "pressure", 0, "pressure.norm"),
        ("nip 2:", "half_width", None, "half_width"),
        ("rollers 1:", "creepage", None, "creepage"),
        ("sweep 1:", "half_width", 3, "half_width[3]"),
    ],
)
def test_a_change_is_found(name: str, quantity: str, place: int | None, label: str) -> None:
    assert _misses(name, quantity, 2e-8, place=place) == [label]
    assert _misses(name, quantity, 5e-9, place=place) == []
    assert _misses(name, quantity, 2e-11, "tight", place=place) == [label]


def test_a_change_of_a_wrapped_nip_is_found() -> None:
    """Kernels between nip and arc are not those of 0.1 to 1e-8."""
    assert _misses("wrap 2:", "wound_on_tension", 8e-8) == ["wound_on_tension"]
    assert _misses("wrap 2:", "wound_on_tension", 2e-8) == []


def test_a_change_that_was_meant_is_no_miss() -> None:
    assert _misses("nip 1:", "slip_ratios.dual", 0.1) == []


def test_a_missing_number_is_a_miss() -> None:
    case = CASES[next(iter(CASES))]
    before = frozen.kept(case, "own")
    now = {name: value for name, value in before.items() if name not in ("offset", "x")}
    missing = {d.quantity.split(".")[0] for d in frozen.differences(case, before, now) if d.miss}
    assert missing == {"offset", "x"}


def test_one_node_in_another_zone_is_a_miss() -> None:
    """Both sums of the zones' numbers tell a node that came to another zone."""
    case = CASES[next(iter(CASES))]
    before = frozen.kept(case, "own")
    now = deepcopy(before)
    now["roll_zone"][1] += 1  # the sum
    missed = [d.quantity for d in frozen.differences(case, before, now) if d.miss]
    assert missed == ["roll_zone.sum"]
