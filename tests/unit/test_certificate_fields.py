"""No field of a result can be wrong without notice: it is corrupted, field by field.

Every field of every kind of result, and of its air film, is replaced by NaN, by the other sign, by
a value that is 0.1 % larger, or by a shorter array. Then either the certificate fails, or the field
is declared an estimate. Evidence: error injection.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import fields, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from slow_cases import campaign_case, slow_case
from thesis_cases import film_nip, newsprint_nip, paper_nip

import woundon as wo
from woundon import kinds

ACCEPTED = 1e-8
RUBBER = wo.Isotropic(youngs_modulus=3e6, poissons_ratio=0.48, prony=[(1e6, 1e-3)])
ROLLERS = wo.RollerProblem(
    upper=wo.HalfPlane(radius=0.25, material="steel"),
    lower=wo.HalfPlane(radius=0.2, material="soft-cover"), load=2e3, tangential_load=150.0,
    friction=0.3,
)  # fmt: skip
WINDING = wo.WindingProblem.example().replace(radius=0.08)
COARSE: dict[str, Any] = {"nodes": 25, "rtol": 5e-2, "coupling_rtol": 1e-6}
CASES: dict[str, tuple[wo.Problem, dict[str, Any]]] = {
    "nip": (newsprint_nip(), {"nodes": 33}),
    "nip, viscoelastic drum": (
        paper_nip(drum=wo.HalfPlane(radius=0.25, material=RUBBER), web_speed=2.0), {"nodes": 33}
    ),
    "nip with wraps": (newsprint_nip(roll_wrap=np.pi, drum_wrap=1.0), {"nodes": 33}),
    "nip with air": (film_nip(), {"nodes": 33}),
    "nip with wraps, air and a viscoelastic drum": (
        paper_nip(
            drum=wo.HalfPlane(radius=0.25, material=RUBBER), web_speed=2.0,
            air=wo.Air(roughness=1e-6), roll_wrap=np.pi, drum_wrap=1.0, wrap_friction=0.15,
        ),
        {"nodes": 33},
    ),
    "rollers": (ROLLERS, {"nodes": 41}),
    "rollers, static": (ROLLERS.replace(motion="static"), {"nodes": 41}),
    "rollers, viscoelastic": (
        ROLLERS.replace(lower=wo.HalfPlane(radius=0.2, material=RUBBER), speed=2.0), {"nodes": 41}
    ),
    "rollers, creepage": (ROLLERS.replace(tangential_load=None, creepage=1e-3), {"nodes": 41}),
    "roll": (wo.RollProblem.example(), {}),
    "roll with lanes": (
        wo.RollProblem.example().replace(
            thickness_profile=wo.ThicknessProfile(position=[0, 1, 2], thickness=[1, 1.005, 1])
        ),
        {"lanes": 4},
    ),
    "winding": (WINDING, COARSE),
    "winding with air": (
        WINDING.replace(web_speed=20.0, air=wo.Air(roughness=0.3e-6)), COARSE
    ),
    "winding without nips": (WINDING.replace(tension_law="friction", winding_force=-50.0), {}),
}  # fmt: skip
# every nip is solved again for every field; test_air.py corrupts what a film adds to a winding
LONG = {"winding": slow_case, "winding with air": campaign_case}
HEADS = {"problem", "residuals", "errors", "warnings"}


@cache
def solved(case: str) -> Any:
    problem, options = CASES[case]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wo.ResolutionWarning)  # the meshes are coarse
        return wo.solve(problem, **options)


def is_certified(result: Any) -> bool:
    """Tell whether the certificate holds, evaluated from the fields of the result."""

    def agrees(again: dict[str, tuple[Any, Any]]) -> bool:
        return all(
            np.isclose(getattr(result, name), value, rtol=1e-9, atol=within).all()
            for name, (value, within) in again.items()
        )

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # of the logarithm of a negative radius
            if not result.certified().largest <= ACCEPTED or not agrees(result.recomputed()):
                return False
            # last, because every nip is solved again
            return not isinstance(result, wo.WindingResult) or agrees(result.recomputed_nips())
    except (wo.InvalidProblem, ValueError, ArithmeticError, LookupError):
        return False  # it cannot be evaluated


def corrupted(result: Any, name: str) -> Iterator[tuple[str, Any]]:
    """Yield wrong values of a field with a description; none for text and what is not reported."""
    value = getattr(result, name)
    if getattr(value, "part_of_result", False):
        for part in fields(value):
            for how, wrong in corrupted(value, part.name):
                yield f"{part.name} {how}", replace(value, **{part.name: wrong})
    if isinstance(value, np.ndarray) and value.size:
        if value.dtype.kind == "f":
            everywhere = np.full_like(value, np.nan)
            yield "nan everywhere", everywhere
            for k in {0, 1, value.size // 2, value.size - 1} & set(range(value.size)):
                if value[k] == value[k]:
                    one = value.copy()
                    one[k] = np.nan
                    yield f"nan at {k}", one
            if np.nan_to_num(value).any():
                yield "0.1 % larger", 1.001 * value
        if np.nan_to_num(value).any():
            yield "reversed sign", -value
        yield "without the last value", value[:-1]
    elif isinstance(value, (int, float)) and value == value:
        if isinstance(value, float):
            yield "nan", float("nan")
            if value:
                yield "0.1 % larger", 1.001 * value
        if value:
            yield "reversed sign", -value


@pytest.mark.parametrize("case", [LONG[case](case) if case in LONG else case for case in CASES])
def test_a_corrupted_field_is_noticed(case: str) -> None:
    result = solved(case)
    assert is_certified(result)
    unnoticed = [
        f"{part.name}: {how}"
        for part in fields(result)
        if part.name not in HEADS | result.ESTIMATES and part.metadata.get("saved", True)
        for how, value in corrupted(result, part.name)
        if is_certified(result.replace(**{part.name: value}))
    ]
    assert unnoticed == []


@pytest.mark.slow
@pytest.mark.campaign
def test_the_nips_of_a_direct_winding_are_solved_again() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wo.ResolutionWarning)
        result = wo.solve(WINDING.replace(roll_body="direct"), **COARSE)
    again = result.recomputed_nips()
    assert set(again) == {
        f"nip_{name}"
        for name in ("wound_on_tension", "half_width", "peak_pressure", "air_film", "friction")
    }
    for name, (value, within) in again.items():
        np.testing.assert_array_less(np.abs(getattr(result, name) - value) - within, 1e-12)


def test_a_film_that_is_missing_or_not_of_the_problem_is_noticed() -> None:
    with_air, without = solved("nip with air"), solved("nip")
    assert not is_certified(with_air.replace(air=None))
    assert not is_certified(without.replace(air=with_air.air))


def test_every_kind_of_result_is_corrupted() -> None:
    own = {kind.result for kind in kinds.every() if kind.result.__module__.startswith("woundon.")}
    assert own == {kinds.of(problem).result for problem, _ in CASES.values()}


def test_main_outputs_are_no_estimates() -> None:
    for kind in kinds.every():
        result = kind.result
        assert {part.name for part in fields(result)} >= result.ESTIMATES
        assert not result.ESTIMATES & set(result.MAIN)


def test_a_nip_with_air_is_certified_after_it_was_loaded(tmp_path: Any) -> None:
    """The residuals of a loaded result are evaluated from its arrays."""
    for options in ({}, {"nodes": 33}):
        result = wo.solve(film_nip(), **options)
        path = tmp_path / "air.json"
        result.save(path)
        assert wo.load_result(path) == result
        loaded = wo.load_result(path)
        assert is_certified(loaded)
        for name in ("roll_wound_on_tension", "half_width", "drum_creepage"):
            for wrong in (-getattr(loaded, name), float("nan")):
                assert not is_certified(loaded.replace(**{name: wrong})), name
        for name in ("film", "gradient", "roll_friction", "wrap_friction"):
            for wrong in (2 * getattr(loaded.air, name), float("nan")):
                air = replace(loaded.air, **{name: wrong})
                assert not is_certified(loaded.replace(air=air)), name
