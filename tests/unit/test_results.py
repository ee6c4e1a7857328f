"""Results: immutable, equal to their copies, small when pickled."""

from __future__ import annotations

import copy
import math
import pickle
from dataclasses import FrozenInstanceError, fields
from typing import Any

import numpy as np
import pytest
from thesis_cases import newsprint_nip

import woundon as wo
from woundon.nip.entrained_air import AirFilm
from woundon.quantities import outputs
from woundon.roll.result import WithRoll

KINDS = ("nip", "wrapped", "rollers")
AIR = AirFilm(
    thickness=np.zeros(3), roll_friction=0.2, wrap_friction=0.2, friction_share=1.0,
    foil_film=1e-6, nip_film=1e-6, film=1e-6, film_in_nip=1e-6, gradient=1e7, inlet_length=1e-4,
)  # fmt: skip


@pytest.fixture(scope="module")
def results() -> dict[str, wo.Result]:
    return {
        "nip": wo.solve(newsprint_nip(), nodes=33),
        "wrapped": wo.solve(newsprint_nip(roll_wrap=np.pi), nodes=33),
        "rollers": wo.solve(wo.RollerProblem.example(), nodes=33),
    }


def test_a_roll_is_the_roll_of_its_result() -> None:
    """Scripts take ``result.roll`` of a roll and of a winding; it is no output."""
    result = wo.solve(wo.RollProblem.example(), rtol=0.01)
    assert result.roll is result
    assert "roll" not in [place.path.partition(".")[0] for place in outputs(result)]
    shared = {place.path: place for place in outputs(wo.WindingResult)}
    of_both = [place for place in outputs(result) if place.path in vars(WithRoll)]
    assert len(of_both) == 15
    for place in of_both:
        assert shared[place.path].quantity == place.quantity


def arrays(result: wo.Result) -> dict[str, np.ndarray]:
    values = {part.name: getattr(result, part.name) for part in fields(result)}
    return {
        name: value for name, value in values.items()
        if isinstance(value, np.ndarray) and value.size
    }  # fmt: skip


def as_sent(result: Any) -> Any:
    return pickle.loads(pickle.dumps(result))


# ---- immutable ----------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("made", [lambda r: r, copy.copy, copy.deepcopy, as_sent,
                                  lambda r: r.replace(warnings=())])  # fmt: skip
def test_nothing_of_a_result_can_be_written_to(results, kind: str, made) -> None:  # type: ignore[no-untyped-def]
    result = made(results[kind])
    assert len(arrays(result)) >= 6
    for name, values in arrays(result).items():
        with pytest.raises(ValueError, match="read-only"):
            values[0] = values[1]
        with pytest.raises(FrozenInstanceError):
            setattr(result, name, values)
    with pytest.raises(FrozenInstanceError):
        result.half_width = 1.0
    with pytest.raises(TypeError):
        result.errors["half_width"] = 0.0
    with pytest.raises(AttributeError):
        result.residuals.stick = 0.0  # type: ignore[misc]
    with pytest.raises(AttributeError):
        result.residuals.new_law = 0.0  # type: ignore[misc]


# ---- equal --------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("made", [copy.copy, copy.deepcopy, as_sent, lambda r: r.replace()])
def test_copies_are_equal(results, kind: str, made) -> None:  # type: ignore[no-untyped-def]
    result, again = results[kind], made(results[kind])
    assert again is not result
    assert again == result
    assert result == again
    assert dict(again.errors) == pytest.approx(dict(result.errors), nan_ok=True, abs=0)


@pytest.mark.parametrize("kind", KINDS)
def test_every_field_counts(results, kind: str) -> None:
    result = results[kind]
    assert result != 3
    assert result != results[KINDS[KINDS.index(kind) - 1]]
    assert result == wo.solve(result.problem, nodes=33)  # the same bits in every run
    changed: dict[str, Any] = {
        "problem": type(result.problem).example().replace(**_other_load(result.problem)),
        "residuals": result.residuals.replace(stick=1e-3),
        "errors": {**result.errors, "half_width": 1.0},
        "warnings": ("other",),
    }
    for part in fields(result):
        if not part.compare:
            continue
        value = getattr(result, part.name)
        if part.name in changed:
            other = changed[part.name]
        elif isinstance(value, np.ndarray):
            other = np.append(value, 7) if value.size == 0 else value.copy()
            other[3 % other.size] = 7
        elif isinstance(value, float):
            other = 1.0 if math.isnan(value) else math.nextafter(value, math.inf)
        elif value is None:
            other = AIR
        else:
            other = f"{value}x" if isinstance(value, str) else value + 1
        assert result.replace(**{part.name: other}) != result, part.name


def _other_load(problem: Any) -> dict[str, float]:
    return {"load": 88e3} if isinstance(problem, wo.RollerProblem) else {"nip_load": 3000.0}


def test_nan_is_equal_to_nan(results) -> None:  # type: ignore[no-untyped-def]
    rollers = results["rollers"]
    assert math.isnan(rollers.shift)  # rolling
    assert rollers == rollers.replace(shift=float("nan"))
    assert rollers != rollers.replace(shift=0.0)
    wrapped = results["wrapped"]
    assert np.isnan(wrapped.drum_slip).any()
    assert wrapped == wrapped.replace(drum_slip=wrapped.drum_slip.copy())
    assert wrapped != wrapped.replace(drum_slip=np.nan_to_num(wrapped.drum_slip))


# ---- sent elsewhere -----------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
def test_a_pickle_holds_what_a_file_does_and_no_matrices(results, kind: str) -> None:
    result = results[kind]
    numbers = sum(values.nbytes for values in arrays(result).values())
    # the arrays, and a few thousand bytes of problem and names; the mesh alone would be 140 kB
    assert len(pickle.dumps(result)) < numbers + 8000
    again = as_sent(result)
    assert again.refinement is None
    # made again from the nodes where it is asked for; these are known to rounding
    laws = dict(again.certified().items())
    assert laws == pytest.approx(dict(result.certified().items()), abs=1e-10)
    assert again.checked() is again


def test_what_needs_the_mesh_works_on_what_was_sent(results) -> None:  # type: ignore[no-untyped-def]
    result, again = results["nip"], as_sent(results["nip"])
    slopes, theirs = result.sensitivity(), again.sensitivity()
    # central differences with steps of 1e-4 leave rounding of 1e-12 over that
    np.testing.assert_allclose(theirs.elasticities, slopes.elasticities, rtol=1e-7, atol=1e-8)
    assert str(again) == str(result)


# ---- certificates -------------------------------------------------------------------------------


def test_nothing_is_passed_off_as_solved(results) -> None:  # type: ignore[no-untyped-def]
    result = results["nip"]
    assert result.checked() is result
    broken = result.replace(residuals=result.residuals.replace(stick=2e-8, slip_velocity=math.nan))
    with pytest.raises(wo.NotConverged, match=r"1e-8: stick 2e-08, slip_velocity nan$") as stop:
        broken.checked()
    assert stop.value.best is broken
    with pytest.raises(wo.NotConverged, match="no condition was evaluated"):
        result.replace(residuals=wo.Residuals()).checked()
    with pytest.raises(NotImplementedError, match="a Result does not evaluate its residuals"):
        wo.Result(problem=None, residuals=wo.Residuals()).certified()
