"""Descriptions as values: immutable, equal by content, picklable, readable, varied by replace."""

from __future__ import annotations

import copy
import pickle
from dataclasses import FrozenInstanceError
from fractions import Fraction
from types import GeneratorType
from typing import Any

import numpy as np
import pytest
from thesis_cases import newsprint_nip

import woundon as wo
from woundon import kinds
from woundon.problems.paths import counterpart
from woundon.problems.permitted import requirement
from woundon.quantities import members_of


def rollers() -> wo.RollerProblem:
    """Return two steel rollers."""
    body = wo.HalfPlane(radius=0.25, material="steel")
    return wo.RollerProblem(upper=body, lower=body, load=89e3, friction=0.5, tangential_load=8.4e3)


DESCRIPTIONS = [
    wo.material("steel"),
    wo.material("newsprint"),
    wo.Web(thickness=66e-6, material="paper"),
    wo.Rigid(radius=0.3),
    wo.HalfPlane(radius=0.3, material="steel"),
    wo.Cylinder(radius=0.3, core_radius=0.05, material="rubber"),
    newsprint_nip(),
    newsprint_nip().replace(roll_wrap=np.pi, wrap_friction=0.3),
    rollers(),
]
each = pytest.mark.parametrize("value", DESCRIPTIONS, ids=lambda d: type(d).__name__)


# ---- values -------------------------------------------------------------------------------------


@each
def test_it_does_not_change(value: Any) -> None:
    name = next(iter(type(value).model_fields))
    before = copy.deepcopy(value)
    with pytest.raises(FrozenInstanceError, match=rf"is immutable.*replace\({name}="):
        setattr(value, name, getattr(value, name))
    with pytest.raises(FrozenInstanceError, match="is immutable"):
        value.note = "mine"
    with pytest.raises(FrozenInstanceError, match=f"is immutable; {name} cannot be deleted"):
        delattr(value, name)
    assert value == before


@each
def test_copies_are_equal_and_hash_alike(value: Any) -> None:
    copies = [copy.copy(value), copy.deepcopy(value), value.model_copy(), value.replace()]
    copies += [pickle.loads(pickle.dumps(value, level)) for level in range(2, 6)]
    assert all(other == value and hash(other) == hash(value) for other in copies)
    assert len({value, *copies}) == 1


@each
def test_its_repr_builds_it_again(value: Any) -> None:
    names = {name: getattr(wo, name) for name in wo.__all__}
    assert eval(repr(value), names) == value
    assert "kind" not in repr(value)


@pytest.mark.parametrize(
    "number",
    [
        3500,
        Fraction(7000, 2),
        np.float64(3500),
        np.float32(3500),
        np.float16(3500),
        np.int64(3500),
        np.uint16(3500),
        np.array(3500),
        np.array(3500.0, dtype=np.float32),
        np.ma.array(3500.0, mask=False),
        np.longdouble(3500),
    ],
    ids=lambda n: f"{type(n).__name__} {getattr(n, 'dtype', '')}",
)
def test_numbers_of_any_make_become_plain_ones(number: Any) -> None:
    problem = newsprint_nip(nip_load=number)
    assert type(problem.nip_load) is float
    assert problem.nip_load == 3500.0


# ---- variants -----------------------------------------------------------------------------------


def test_replace_leaves_the_original_and_shares_what_stays() -> None:
    problem = newsprint_nip()
    variant = problem.replace(nip_load=5e3, **{"web.thickness": 57e-6, "roll.material.shear": 2e7})
    assert (variant.nip_load, variant.web.thickness) == (5e3, 57e-6)
    assert variant.roll.material.stiffness.shear == 2e7
    assert variant.web.material.stiffness.shear == 1e7  # the roll's alone was changed
    assert problem == newsprint_nip()
    back = variant.replace(nip_load=3502, **{"web.thickness": 66e-6, "roll.material.shear": 1e7})
    assert back == problem


def test_replace_checks_what_belongs_together() -> None:
    problem = newsprint_nip(winding_force=600.0)
    with pytest.raises(wo.NoSteadyState):
        problem.replace(nip_load=2000.0)
    assert problem.replace(nip_load=2000.0, winding_force=-100.0).nip_load == 2000.0


# ---- results and errors on their way between processes ------------------------------------------


@pytest.mark.parametrize("kind", [wo.InvalidProblem, wo.NoSteadyState])
def test_errors_survive_pickling_with_their_faults(kind: type[wo.InvalidProblem]) -> None:
    error = kind([("web.thickness", "66 is out of range"), ("", "odd")]).under("case")
    other = pickle.loads(pickle.dumps(error))
    assert type(other) is kind
    assert other.faults == (("case.web.thickness", "66 is out of range"), ("case", "odd"))
    assert str(other) == str(error) == "case.web.thickness: 66 is out of range\ncase: odd"


# ---- required and optional fields ----------------------------------------------------------------

RUBBER = wo.Isotropic(youngs_modulus=5e6, poissons_ratio=0.45, prony=[(3e6, 1e-3)])
STACK = wo.RollProblem.example().stack
PFEIFFER = wo.Pfeiffer(K1=1e4, K2=40.0)
TABLE = wo.Profile(radius=[0.05, 0.6], value=[300.0, 400.0])
COVER = wo.HalfPlane(radius=0.1, material=RUBBER)
WINDING = wo.WindingProblem.example()
WINDER = wo.TwoDrums(front_drum=wo.Rigid(radius=0.25), gap=0.02, rider_load=2500.0)
# Every class, and each way to meet a condition.
RELATIVE = wo.RelativeProny(
    instantaneous_modulus=1e7, poissons_ratio=0.45, prony_relative=[(0.3, 1e-3)]
)
EXAMPLES = [
    *DESCRIPTIONS, RUBBER, RUBBER.prony[0], STACK, PFEIFFER, TABLE,
    STACK.replace(radial=2e7).radial,
    wo.LossAngle(youngs_modulus=5e6, poissons_ratio=0.45, loss_angle=0.1, frequency=100.0),
    wo.DynamicTest(
        poissons_ratio=0.45, frequency=[1.0, 10.0, 100.0],
        storage_modulus=[5e6, 5.5e6, 6e6], loss_modulus=[5e5, 5e5, 5e5]),
    wo.DynamicTest(
        poissons_ratio=0.45, frequency=[1.0, 10.0, 100.0],
        storage_modulus=[5e6, 5.5e6, 6e6], tan_delta=[0.1, 0.1, 0.1]),
    wo.RelaxationTest(poissons_ratio=0.45, time=[1e-3, 0.1, 1.0], modulus=[6e6, 5e6, 4.5e6]),
    RELATIVE, RELATIVE.prony_relative[0],
    wo.Polynomial(coefficients=[1e6, 40.0]), wo.PowerLaw(E0=1e6, k=2e7, m=0.9),
    wo.StackTest(pressure=[1e3, 1e4, 1e5, 1e6], strain=[0.002, 0.02, 0.07, 0.13]),
    wo.AirBetween(law=PFEIFFER, film=2e-6, web_thickness=66e-6),
    wo.Layer(thickness=0.01, material=RUBBER),
    wo.Layered(radius=0.1, layers=[wo.Layer(thickness=0.01, material="rubber")]),
    wo.WoundRoll(radius=0.1, core_radius=0.0445, stack=STACK, pressure=2e5),
    wo.Taper(start=350.0, taper=0.3), wo.Taper(start=350.0, law="power", exponent=0.5),
    wo.Steps(value=[400.0, 300.0], depth=[0.02]), wo.Limits(blocking_pressure=1e6),
    wo.Air(roughness=3e-6), wo.Inertia(core=0.5),
    wo.Core(radius=0.05, stiffness=1e9),
    wo.Core(radius=0.05, inner_radius=0.04, material="steel"),
    newsprint_nip(air=wo.Air(roughness=3e-6), web_speed=10.0),
    rollers().replace(upper=COVER, speed=10.0),
    wo.RollProblem.example(), WINDING, WINDING.replace(drum=COVER, web_speed=10.0),
    WINDING.replace(nip_load=0.0),
    WINDING.replace(tension_law="fixed", nip_induced_tension=50.0),
    WINDING.replace(**{"limits.acceleration": 1.0}), WINDER,
    WINDING.replace(winder=WINDER, drum=wo.Rigid(radius=0.3), nip_load=None, torque_split=0.5),
    wo.NextNip(angle=1.5, drum=wo.Rigid(radius=0.25), nip_load=2000.0),
    wo.ThicknessProfile(position=[0.0, 0.5, 1.0], thickness=[1.0, 1.01, 1.0]),
    wo.Bending(flexural_rigidity=1e6),
    wo.DrumBending(flexural_rigidity=1e6),
]  # fmt: skip


def reachable() -> set[type]:
    """Return the classes of all descriptions that a case of any kind may contain."""
    waiting: list[type] = [
        k.problem for k in kinds.every() if k.problem.__module__[:7] == "woundon"
    ]
    for model in waiting:  # grows in the loop
        members = {m for f in model.model_fields.values() for m in members_of(f.annotation)}
        waiting += [member for member in members if member not in waiting]
    return {model for model in waiting if model.__module__.startswith("woundon")}


@pytest.mark.parametrize("model", sorted(reachable(), key=lambda m: m.__name__))
def test_described_as_required_is_what_the_constructor_demands(model: Any) -> None:
    examples = [example for example in EXAMPLES if type(example) is model]
    assert examples
    for name, field in model.model_fields.items():
        note, can_be_omitted = requirement(field), set()
        for example in examples:
            others = {n: getattr(example, n) for n in model.model_fields if n != name}
            try:
                model(**others)
            except wo.InvalidProblem as error:
                # without tension_law = "fixed" it is nip_induced_tension that is not permitted
                is_conditional = note.startswith("required")
                can_be_omitted.add(not is_conditional and name not in dict(error.faults))
            else:
                can_be_omitted.add(True)
        if note.startswith("required"):
            assert can_be_omitted == {True, False}, name
        else:
            assert can_be_omitted == {note != ""}, name


# ---- wrong types --------------------------------------------------------------------------------

WRONG = [
    {1: 2}, {None: 1}, {"material": {1: 2}}, {"kind": ["cylinder"]}, {"\ud800": 1}, [{1: 2}],
    [None], [[1.0, 2.0]], (), {1.0, 2.0}, range(3), np.eye(2), np.array(["a"]), np.array([None]),
    np.datetime64("2020-01-01"), np.ma.masked, (x for x in [1.0]), b"1", 1j, len, int, wo.Rigid,
    wo.Web(thickness=66e-6, material="paper"), ValueError("x"), 10**400, "\ud800", True, ...,
]  # fmt: skip


def is_rejected_with_its_name(model: type[wo.Problem], fields: dict[str, Any]) -> bool:
    """Return True if the constructor rejects a field by name; any other error is raised."""
    try:
        model(**fields)
    except wo.InvalidProblem as error:
        return all(field and text for field, text in error.faults)
    return False


@pytest.mark.parametrize("model", sorted(reachable(), key=lambda m: m.__name__))
def test_values_of_a_wrong_type_are_rejected_with_the_name_of_the_field(model: Any) -> None:
    example = next(example for example in EXAMPLES if type(example) is model)
    fields = {name: getattr(example, name) for name in model.model_fields}
    diameters = {counterpart(name, "radius") for name in fields} - {""}
    graded = {"grade"} if getattr(model, "graded", ()) else set()
    for name in sorted({*fields, *diameters, *graded}):
        others = {n: v for n, v in fields.items() if n != counterpart(name, "diameter")}
        for value in WRONG:
            # a generator that was read before is an empty list
            permitted = (str, range, tuple, np.ndarray, bytes, wo.Web, GeneratorType)
            is_flag = name in fields and model.model_fields[name].annotation is bool
            may_be_permitted = isinstance(value, (bool, str) if is_flag else permitted)
            is_rejected = is_rejected_with_its_name(model, {**others, name: value})
            assert is_rejected or may_be_permitted, (name, value)
