"""Kinds of problem: registered in one place, found by name, by class, by the fields of a file."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any

import pytest

import woundon as wo
from woundon import kinds, plugins
from woundon.problems.fields import Number
from woundon.problems.paths import find_places
from woundon.quantities import length, line_load, output
from woundon.report.outputs_report import outputs_report
from woundon.report.result_panels import PANELS
from woundon.report.result_report import report_of

OWN = {
    "nip": (wo.NipProblem, wo.NipResult),
    "rollers": (wo.RollerProblem, wo.RollerResult),
    "roll": (wo.RollProblem, wo.RollResult),
}
KINDS = (*OWN, "winding")
# an option of each out of range
WRONG = dict.fromkeys(OWN, ("nodes", 3)) | {"roll": ("rtol", 3)}


class HammockProblem(wo.Problem):
    """A web that hangs between two rollers.

    It sags.
    """

    span: Annotated[Number, length("L", "span between the rollers")]
    web_tension: Annotated[Number, line_load("T", "web tension")]
    weight: Annotated[Number, line_load("w", "weight")] = 1.0


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class HammockResult(wo.Result):
    sag: Annotated[float, length("s", "sag")]


def solve_hammock(problem: HammockProblem, *, terms: int = 1) -> HammockResult:
    sag = problem.weight * problem.span**2 / (8 * problem.web_tension) * terms
    return HammockResult(problem=problem, residuals=wo.Residuals(balance=0.0), sag=sag)


@pytest.fixture
def registry(monkeypatch: pytest.MonkeyPatch) -> dict[str, kinds.Kind]:
    """The registry with three of woundon's kinds alone; it is restored afterwards."""
    known = {name: kind for name, kind in kinds._KINDS.items() if name in OWN}
    monkeypatch.setattr(kinds, "_KINDS", known)
    monkeypatch.setattr(plugins, "load", lambda: None)
    return known


HAMMOCK = HammockProblem(span=2.0, web_tension=100.0)


# ---- woundon's own ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", OWN)
def test_a_kind_is_its_problem_its_solver_and_its_result(name: str) -> None:
    kind, (problem, result) = kinds.named(name), OWN[name]
    assert (kind.name, kind.problem, kind.result) == (name, problem, result)
    assert kind.about.endswith(".")
    assert report_of(kind) is not outputs_report
    assert name in PANELS
    assert callable(kind.check)
    option, value = WRONG[name]
    solved = wo.solve(problem.example(), **({"nodes": 33} if option == "nodes" else {}))
    assert type(solved) is result
    for thing in (problem, result, problem.example(), solved):
        assert kinds.of(thing) is kind
    # options are refused before anything is solved
    with pytest.raises(wo.InvalidProblem, match=f"{option}: 3 is out of range"):
        kind.check(**{option: value})


@pytest.mark.parametrize(
    ("names", "kind"),
    [
        (["web", "roll", "drum", "nip_load", "roll_friction", "drum_friction"], "nip"),
        (["web", "roll", "drum", "nip_load", "roll_friction", "drum_friction", "wrap"],
         "nip"),
        (["web", "roll", "drum", "nip_load", "drum_wrap"], "nip"),
        (["nip_load", "web_speed", "air"], "nip"),
        (["upper", "lower", "load", "friction"], "rollers"),
        (["upper", "lower"], "rollers"),
        (["uper", "lower", "load", "friction", "motion"], "rollers"),  # a slip of the pen
        (["nip_load", "web_tension"], "nip"),
    ],
)  # fmt: skip
def test_the_fields_of_a_file_give_its_kind_away(
    names: list[str], kind: str, registry: Any
) -> None:
    assert kinds.for_fields(names).name == kind


# ---- one from outside ---------------------------------------------------------------------------


def test_a_kind_needs_three_things(registry: dict[str, kinds.Kind]) -> None:
    with pytest.raises(wo.InvalidProblem):
        kinds.of(HAMMOCK)
    about = "A web that hangs between two rollers."
    kinds.register(HammockProblem, solve_hammock, HammockResult, about=about)
    kind = kinds.named("hammock")
    assert [k.name for k in kinds.every()] == [*OWN, "hammock"]
    assert (kind.name, kind.about) == ("hammock", about)
    result = wo.solve(HAMMOCK)
    assert result.sag == pytest.approx(5e-3)
    assert wo.solve(HAMMOCK, terms=2).sag == pytest.approx(1e-2)
    assert kinds.of(result) is kinds.of(HAMMOCK) is kind
    assert kinds.for_fields(["span", "web_tension"]) is kind
    # what it did not bring is a default: it can be reported and drawn
    assert "sag" in str(result)
    assert kind.check is None
    with pytest.raises(wo.InvalidProblem, match="RollProblem or HammockProblem"):
        wo.solve("hammock.toml")


@pytest.mark.parametrize("kind", kinds.every(), ids=lambda kind: kind.name)
def test_every_option_of_a_solver_has_a_help_text(kind: kinds.Kind) -> None:
    for name, option in kind.solver_options().items():
        assert option.help.endswith("."), name


# ---- plug-ins -----------------------------------------------------------------------------------


def test_plug_ins_are_imported_once_before_the_first_look_up(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    loaded: list[str] = []

    class EntryPoint:
        name = "hammock"

        def load(self) -> None:
            loaded.append(self.name)
            kinds.register(HammockProblem, solve_hammock, HammockResult)

    class Broken(EntryPoint):
        name = "broken"

        def load(self) -> None:
            raise ImportError("No module named 'elsewhere'")

    monkeypatch.setattr(kinds, "_KINDS", dict(kinds._KINDS))
    monkeypatch.setattr(plugins, "load", cache(plugins.load.__wrapped__))
    monkeypatch.setattr(
        plugins.metadata, "entry_points",
        lambda group: [Broken(), EntryPoint()] if group == "woundon.plugins" else [],
    )  # fmt: skip
    with pytest.warns(RuntimeWarning, match=r"plug-in broken cannot be loaded: .*'elsewhere'"):
        assert kinds.named("hammock").problem is HammockProblem
    assert wo.solve(HAMMOCK).sag == pytest.approx(5e-3)
    assert kinds.named("hammock") is kinds.of(HAMMOCK)
    assert loaded == ["hammock"]


@pytest.mark.parametrize("name", KINDS)
def test_a_field_of_another_kind_is_rejected_with_its_counterpart(name: str) -> None:
    """Every field of every other kind: a field or output in its place, or the kind that has it."""
    model, result = kinds.named(name).problem, kinds.named(name).result
    classes = {kinds.named(other).problem.__name__: kinds.named(other).problem for other in KINDS}
    foreign = {f for other in classes.values() for f in other.model_fields} - set(
        model.model_fields
    )
    assert len(foreign) > 10
    for field in foreign:
        with pytest.raises(wo.InvalidProblem) as report:
            model.example().replace(**{field: 1.0})
        (text,) = (text for path, text in report.value.faults if path == field)
        assert "known:" not in text, (field, text)
        words = re.findall(r"[\w.]+", text.removeprefix(f"no such field in {model.__name__}"))
        named = [classes[word] for word in words if word in classes]
        assert all(field in other.model_fields for other in named), text
        own = [word for word in words if find_places(model, word) or output(result, word)]
        assert named or own or "it is an output" in text, (field, text)
        if text.endswith("it is an output"):
            assert output(result, field), text
