"""The search for the half width: powers, loads that rise at once, loads that jump."""

from __future__ import annotations

from collections.abc import Callable
from math import log, tanh

import pytest

from woundon.contact.width import WidthNotFound, width_for_load


def counted(load: Callable[[float], float]) -> tuple[Callable[[float], tuple[float, float]], list]:  # type: ignore[type-arg]
    """Return what evaluates a load [N/m] by the width [m], and the widths that it was asked for."""
    asked: list[float] = []

    def evaluate(a: float) -> tuple[float, float]:
        asked.append(a)
        return a, load(a)

    return evaluate, asked


@pytest.mark.parametrize("power", [2.0, 3.3, 5.0])
def test_a_power_is_known_after_one_step(power: float) -> None:
    evaluate, asked = counted(lambda a: 1e3 * (a / 4e-3) ** power)
    a, found = width_for_load(evaluate, 2e3, 3e-3, 1e-10)
    assert a == pytest.approx(4e-3 * 2 ** (1 / power), rel=1e-10)
    assert found == pytest.approx(power, rel=1e-6)  # by differences
    assert len(asked) <= 4


def test_a_load_that_hardly_grows_with_the_width_is_met() -> None:
    """As that of a tube that is flattened; taken for a power of 0.7 it took 60 steps and more."""
    evaluate, asked = counted(lambda a: 1e3 * (a / 4e-3) ** 0.1)
    a, _ = width_for_load(evaluate, 1.1e3, 3e-3, 1e-9)
    assert a == pytest.approx(4e-3 * 1.1**10, rel=1e-7)  # ten times what the load may be off by
    assert len(asked) < 20


def test_a_load_that_rises_by_a_percent_at_once_is_met() -> None:
    """Steeper than any power that is taken for one, steps went from one side to the other."""

    def load(a: float) -> float:
        return 1e3 * (a / 4e-3) ** 2 * (1 + 5e-3 * tanh(1e6 * log(a / 4e-3)))

    evaluate, asked = counted(load)
    a, _ = width_for_load(evaluate, 1e3, 3e-3, 1e-8)
    assert load(a) == pytest.approx(1e3, rel=1e-8)
    assert a == pytest.approx(4e-3, rel=1e-8)  # the rise is a millionth of it long
    assert len(asked) < 50


def test_a_load_that_jumps_past_the_one_asked_is_told() -> None:
    evaluate, _ = counted(lambda a: 1e3 * (a / 4e-3) ** 2 * (1.01 if a > 4e-3 else 0.99))
    with pytest.raises(WidthNotFound, match=r"did not settle: last 0\.004 m, off by -?0\.01"):
        width_for_load(evaluate, 1e3, 3e-3, 1e-8)
