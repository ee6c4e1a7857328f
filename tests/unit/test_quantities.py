"""Quantities: what the one walk yields of descriptions and results, and how a name is found."""

from __future__ import annotations

import numpy as np
import pytest
from coarse_solutions import coarse_solution

from woundon import kinds, quantities
from woundon.problems.paths import find_places, get_field
from woundon.quantities import OF_FIELD, walk

# woundon's own, whatever other tests have registered
OWN = [kind for kind in kinds.every() if kind.problem.__module__.startswith("woundon.")]
each_kind = pytest.mark.parametrize("kind", OWN, ids=lambda kind: kind.name)


# ---- a quantity ---------------------------------------------------------------------------------


def test_a_stored_text_has_the_complete_unit() -> None:
    """Only the unit of a pure number is left out, not the 1 of "1/K"."""
    expansion = quantities.Quantity("alpha", "1/K", "thermal expansion")
    assert expansion.stored_text(1e-5) == "1e-05 1/K"
    assert quantities.pure("mu", "friction").stored_text(0.3) == "0.3"


def test_every_shown_unit_is_its_unit_and_every_range_an_admissible_one() -> None:
    """Units are parsed by what reads case files: no factor here is another than there."""
    from woundon.problems.units import parse

    seen = 0
    for kind in OWN:
        for place in (*walk(kind.problem), *quantities.outputs(kind.result)):
            quantity = place.quantity
            if quantity is None:
                continue
            seen += 1
            assert quantity.symbol
            assert quantity.meaning
            assert not quantity.meaning.endswith(".")
            if quantity.shown_unit:
                one = parse(f"1 {quantity.shown_unit}", quantity.unit)
                assert quantity.shown(one) == pytest.approx(1.0, rel=1e-14)
            else:
                assert quantity.shown(1.0) == 1.0
            if quantity.typical is not None:
                low, high = quantity.typical
                assert low < high
                limits = {"ge": float.__ge__, "gt": float.__gt__, "le": float.__le__,
                          "lt": float.__lt__}  # fmt: skip
                for part in place.field.metadata:
                    for name, keeps in limits.items():
                        end = low if name[0] == "g" else high
                        limit = getattr(part, name, None)
                        assert limit is None or keeps(float(end), float(limit)), place.path
    assert seen > 100


# ---- descriptions -------------------------------------------------------------------------------


@each_kind
def test_every_number_of_every_problem_is_a_quantity(kind: kinds.Kind) -> None:
    example = kind.problem.example()
    places = list(walk(example))
    assert len({place.path for place in places}) == len(places)
    for place in places:
        assert get_field(example, place.path) == place.value
        assert example.replace(**{place.path: place.value}) == example
        in_class = find_places(kind.problem, place.path)
        assert place.field in [other.field for other in in_class]
        assert place.quantity in [None, *(other.quantity for other in in_class)]
        assert place.name == place.path.split(".")[-1]
        nested = ("core.material", "air", "next_nips", "winder", "thickness_profile", "inertia",
                  "drum_bending", "core_bending")  # fmt: skip
        none_given = place.path in nested or place.name == "prony"
        is_word = isinstance(place.value, str | bool)
        assert (place.quantity is None) == (is_word or none_given), place.path
        assert place.name in place.owner.model_fields


@each_kind
def test_fields_of_different_names_have_different_meanings(kind: kinds.Kind) -> None:
    names: dict[str, set[str]] = {}
    for place in walk(kind.problem):
        if place.quantity and place.field and OF_FIELD not in place.field.metadata:
            names.setdefault(place.quantity.meaning, set()).add(place.name)
    names.pop("web thickness", None)  # of the web, and of a roll of this web
    assert [shared for shared in names.values() if len(shared) > 1] == []


# ---- results ------------------------------------------------------------------------------------


@each_kind
def test_every_output_of_every_kind_can_be_reported(kind: kinds.Kind) -> None:
    result = coarse_solution(kind.problem.example(), 33)
    names = set()
    for place in walk(result):
        names.add(place.path)
        assert place.quantity is not None
        number = isinstance(place.value, (float, int))
        assert number or isinstance(place.value, np.ndarray), place.path
        assert (place.path in quantities.scalar_outputs(result)) == number
    assert set(result.errors) <= names
    assert set(result.MAIN) <= set(quantities.scalar_outputs(result))
    # what is looked for in vain is no output
    assert not set(result.REPLACED) & names
