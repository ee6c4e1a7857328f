"""A solve leaves nothing that leads to itself: its matrices are given back when it ends.

What leads to itself waits for the garbage collector, of some nips megabytes of matrices, and each
next solve then fills memory that the processor does not have at hand.
"""

from __future__ import annotations

import gc
from collections import Counter
from collections.abc import Iterator
from math import pi

import pytest
from slow_cases import slow_case
from thesis_cases import newsprint_nip

import woundon as wo

NIP = newsprint_nip()
COVERED = NIP.replace(
    drum=wo.Cylinder(radius=0.25, core_radius=0.23, material=wo.Isotropic(
        youngs_modulus=1e7, poissons_ratio=0.4))
)  # fmt: skip
CASES = {
    "wraps on a cover": (COVERED.replace(roll_wrap=pi, drum_wrap=1.0), {}),
    "rollers": (wo.RollerProblem.example(), {}),
    "wound roll": (wo.RollProblem.example(), {}),
}


@pytest.fixture
def found() -> Iterator[list[object]]:
    """What the garbage collector finds."""
    gc.collect()
    gc.disable()
    gc.set_debug(gc.DEBUG_SAVEALL)
    gc.garbage.clear()
    yield gc.garbage
    gc.set_debug(0)
    gc.garbage.clear()
    gc.enable()


def own(found: list[object]) -> Counter[str]:
    """Return what of it is the program's, or arrays."""
    types = (type(one) for one in found)
    return Counter(t.__name__ for t in types if t.__module__.split(".")[0] in ("woundon", "numpy"))


@pytest.mark.parametrize(
    "name", ["wraps on a cover", slow_case("rollers"), slow_case("wound roll")]
)
def test_a_solve_leaves_nothing_to_the_garbage_collector(name: str, found: list[object]) -> None:
    problem, options = CASES[name]
    wo.solve(problem, **options)  # what is kept is made
    gc.collect()
    found.clear()
    wo.solve(problem, **options)
    gc.collect()
    assert own(found) == {}


@pytest.mark.slow
def test_nor_do_warm_starts_and_derivatives(found: list[object]) -> None:
    problem = COVERED.replace(roll_wrap=pi)
    start = wo.solve(problem)
    for _ in range(2):
        gc.collect()
        found.clear()
        near = wo.solve(problem.replace(nip_load=1.01 * problem.nip_load), start=start)
        near.sensitivity("roll_friction")
        del near
    gc.collect()
    assert own(found) == {}
