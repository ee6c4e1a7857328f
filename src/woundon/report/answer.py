"""The answer of a result: the first lines of every report, page and terminal output."""

from __future__ import annotations

from collections.abc import Iterable
from math import floor, isnan, log10
from typing import Any

from .. import kinds, quantities
from ..errors import InvalidProblem, NoSteadyState, NotConverged, unwarned
from ..nip.result import NipResult
from ..nip.roller_result import RollerResult
from ..problems.description import is_unset
from ..problems.problem import Problem
from ..quantities import in_chosen_units, walk
from ..results import Result
from ..roll.result import RollResult
from ..winding.result import WindingResult
from .contacts_report import contact_sentences
from .outputs_report import LEAST_FRICTION
from .report_parts import Line, Section, output_row, quantity_of, value_row

__all__ = [
    "answer",
    "answer_lines",
    "assumptions_section",
    "defaults_section",
    "main_outputs",
]


def answer(result: Result) -> str:
    """Return the answer in one line: the main outputs, or the verdict on a wound roll."""
    return answer_lines(result)[0].text


def answer_lines(result: Result, full: bool = True) -> list[Line]:
    """Return the answer as lines; ``full`` adds the effect of entrained air, which solves a nip."""
    if isinstance(result, NipResult):
        lines = [Line(_tensions(result), "answer")]
        if full and result.air is not None:
            lines += map(Line, _air(result))
        return [*lines, *map(Line, contact_sentences(result))] if full else lines
    if isinstance(result, WindingResult):
        from .margins_report import verdict_lines
        from .winder_report import drum_sentences

        names = [name for name in result.MAIN if name != "least_hoop_stress"]  # it is a margin
        if result.problem.core_removed:
            names = ["mean_wound_on_tension", *OFF_CORE]
        further = map(Line, drum_sentences(result))
        return [*verdict_lines(result.margins), Line(_values(result, names)), *further]
    main = main_outputs(result)
    return [Line(_values(result, main), "answer")] if main else []


def main_outputs(result: Result) -> dict[str, str]:
    """Return outputs in words, such as "nip width", by name: those that the answer states.

    Empty for a nip, whose answer is a sum, and for a winding, whose answer is a verdict.
    """
    if isinstance(result, NipResult | WindingResult):
        return {}
    names = result.MAIN
    if isinstance(result, RollerResult):
        names = _of_rollers(result)
    elif isinstance(result, RollResult) and result.problem.core_removed:
        names = OFF_CORE
    known = quantities.scalar_outputs(result)
    return _words(
        result,
        [name for name in names if name in known and not isnan(quantities.value_of(result, name))],
    )


# ---- a nip --------------------------------------------------------------------------------------


def _tensions(result: NipResult) -> str:
    """Return the wound-on tension as the sum of web tension and nip-induced tension."""
    quantity = quantity_of(result, "wound_on_tension")
    tensions = (result.wound_on_tension, result.nip_induced_tension, result.problem.web_tension)
    total, added, web = (float(quantity.shown(value)) for value in tensions)
    size = abs(added) or abs(total) or 1.0
    digits = min(3, max(0, 2 - floor(log10(size))))  # three digits of the nip-induced tension
    # The difference of the rounded values: the printed sum is exact.
    total_shown, web_shown = round(total, digits), round(web, digits)
    unit = quantity.display
    texts = [
        f"{value:.{digits}f} {unit}" for value in (total_shown, web_shown, total_shown - web_shown)
    ]
    return f"Wound-on tension {texts[0]} = web tension {texts[1]} + nip-induced tension {texts[2]}"


def _air(result: NipResult) -> list[str]:
    """Return sentences on the reduction of friction and nip-induced tension by entrained air."""
    air, problem = result.air, result.problem
    assert air is not None
    # where, friction coefficient with air and without it
    places = [("in the nip", air.roll_friction, problem.roll_friction)]
    if problem.roll_wrap:
        places.append(("on the roll wrap", air.wrap_friction, problem.friction_on_wrap))
    reduced = [(place, mu, dry) for place, mu, dry in places if mu < dry]
    if not reduced:
        return ["The entrained air reduces neither the friction nor the nip-induced tension."]
    shares = " and ".join(f"{place} {_reduction(mu, dry)}" for place, mu, dry in reduced)
    text = f"The entrained air reduces the friction between web and roll: {shares}"
    try:
        with unwarned():
            without_air: Any = kinds.solve(problem.without_air(), nodes=result.nodes)
    except (InvalidProblem, NoSteadyState, NotConverged):
        return [f"{text}.", "The same nip without air was not solved."]
    NIT_dry = without_air.nip_induced_tension
    row = output_row(result, "nip_induced_tension")
    row_dry = output_row(result, "nip_induced_tension", NIT_dry)
    change = result.nip_induced_tension - NIT_dry
    word = "reduces" if change < 0 else "increases"
    share = f" ({abs(change / NIT_dry):.1%})" if NIT_dry else ""
    return [
        f"{text}.",
        f"It {word} the nip-induced tension from {row_dry.value:.4g} to "
        f"{row.value:.4g} {row.unit}{share}.",
    ]


def _reduction(friction: float, dry: float) -> str:
    """Return the reduction of a friction coefficient by air, as text.

    One that is practically zero is given as such, not as a reduction by 100.0 %.
    """
    return f"by {1 - friction / dry:.1%}" if friction >= LEAST_FRICTION else "to 0"


# ---- other kinds --------------------------------------------------------------------------------

# shorter than the meaning of the quantity
WORDS = {
    "tangential_load": "tangential load",
    "mean_wound_on_tension": "mean wound-on tension",
    "mid_pressure": "halfway to the surface",  # next to the pressure on the core
    "least_hoop_stress": "minimum hoop stress",
    "bore_hoop_stress": "hoop stress at the bore",
}
OFF_CORE = ("peak_pressure", "bore_hoop_stress")  # of a roll without a core


def _of_rollers(result: RollerResult) -> tuple[str, ...]:
    """Return the names of the main outputs of rollers: the one that is not prescribed first."""
    problem = result.problem
    free = problem.motion == "rolling" and problem.creepage is None
    return ("creepage" if free else "tangential_load", "nip_width", "peak_pressure")


def _words(result: Result, names: Iterable[str]) -> dict[str, str]:
    """Return outputs in words without explanations, the first one with a capital, by name."""
    words = {
        name: WORDS.get(name, quantity_of(result, name).meaning.partition(",")[0]) for name in names
    }
    for first in list(words)[:1]:  # there may be none
        words[first] = words[first][:1].upper() + words[first][1:]
    return words


def _values(result: Result, names: Iterable[str]) -> str:
    """Return outputs with their words and units, separated by commas."""
    return ", ".join(
        f"{words} {quantity_of(result, name).text(quantities.value_of(result, name))}"
        for name, words in _words(result, names).items()
    )


# ---- assumptions and defaults -------------------------------------------------------------------


def assumptions_section(result: Result) -> list[Section]:
    """Return the section of the assumptions of the model, if any are known."""
    texts = result.assumptions
    return [Section("Assumptions", (), in_chosen_units(" ".join(texts)))] if texts else []


def defaults_section(problem: Problem) -> list[Section]:
    """Return the section of the fields whose default values are used; none if there are none."""
    texts: list[str] = []
    # with a dot after the name, "web" does not exclude "web_tension"
    unused = tuple(f"{name}." for name in problem.unused)
    for place in walk(problem):
        if f"{place.path}.".startswith(unused):
            continue
        default = getattr(place.field, "default", None)
        value = place.value
        # of the same type: True equals 1
        if is_unset(value) or type(value) is not type(default) or value != default:
            continue
        if place.quantity is None or isinstance(value, str | int | float):
            texts.append(f"{place.path} = {value_row(place.quantity, value).text}")
    return [Section("Defaults used", (), ", ".join(texts))] if texts else []
