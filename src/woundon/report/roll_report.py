"""The report of a wound roll."""

from __future__ import annotations

from collections.abc import Iterator
from math import isnan

import numpy as np

from ..errors import InvalidProblem
from ..problems.finished_roll import FinishedRollProblem
from ..problems.free_strains import FREE_STRAINS
from ..problems.radial_laws import Pfeiffer
from ..quantities import in_chosen_units, length, line_load, strain, stress, value_of
from ..roll.gauge_band import gauge_band_over
from ..roll.result import RollResult
from ..roll.theories import plateau_pressure
from ..winding.result import WindingResult
from .lanes_report import WORST_LANE, lanes_sections
from .outputs_report import not_applicable, rows_of
from .report_parts import (
    Line,
    Part,
    Row,
    Section,
    field_row,
    output_row,
    quantity_of,
    row_of,
    rows_of_given,
    schedule_rows,
)

__all__ = [
    "OFF_CORE",
    "ROLL",
    "changes_sections",
    "layers_note",
    "off_core_sections",
    "roll_report",
]

# in other rows
WEIGHT = ["weight_pressure", "weight_share", "flat_width"]
OFF_CORE = [
    "core_gap",
    "separation_radius",
    "sliding_collapse_load",
    "bonded_collapse_load",
]
LEFT_OUT = frozenset(
    {"residual", "steps", "compressed_share", "lane_count", *OFF_CORE, *WEIGHT, *WORST_LANE}
)
BAND = "Thickest lane across the width (closed form)"
# of a roll alone, and of the roll of a winding
ROLL = [
    "core_pressure",
    "mid_pressure",
    "peak_pressure",
    "least_hoop_stress",
    "length",
    "wound_length",
]
NAMES = [
    *ROLL,
    "bore_hoop_stress",
    "bore_displacement",
    "layer_count",
    "mass",
    "wound_mass",
    "mean_density",
    "surface_slope",
    "finite_layer_effect",
]
OF_DENSITY = frozenset({"mass", "wound_mass", "mean_density"})


def roll_report(result: RollResult) -> list[Part]:
    """Return the report of a wound roll."""
    problem, r, hoop = result.problem, result.radius, result.hoop_stress
    stages, nodes = result.stage_radius.size - 1, r.size
    cost = f"{stages} stages, {nodes} nodes, {result.steps} linear systems"
    without = not_applicable(problem)
    if problem.density is None:
        without |= OF_DENSITY
    names, left_out = [name for name in NAMES if name not in without], LEFT_OUT | without
    # a stress at core and surface, as a tension per width
    tensions = problem.tension_curve.at(r[[0, -1]]) * problem.web_thickness
    notes = {
        "peak_pressure": _location(r[np.argmax(result.pressure)]),
        "least_hoop_stress": _location(r[np.argmin(hoop)]),
    }
    return [
        Line(cost, "quiet"),
        Section(
            "Winding",
            (
                field_row(problem.core, "radius"),
                *(field_row(problem, name) for name in ("radius", "web_thickness")),
                *rows_of_given(problem, "caliper_pressure", "web_speed"),
                *schedule_rows(problem, "wound_on_tension", tensions),
            ),
        ),
        Section(
            "Wound roll",
            rows_of(result, names, leave=left_out, **notes),
            layers_note(result) + _compression_note(result),
        ),
        *changes_sections(problem),
        *off_core_sections(result, result),
        *_weight(result),
        *_gauge_band(result),
        *lanes_sections(result),
        *_other_theories(result),
    ]


def _location(radius: float) -> str:
    """Return a radius [m] as a note behind a value."""
    return f", at r = {quantity_of(RollResult, 'radius').text(radius)}"


def layers_note(roll: RollResult) -> str:
    """Return a remark on the layers to which pressures and stresses refer."""
    of_roll = "The roll is at rest. " if roll.problem.centrifugal_stress else ""
    return (
        f"{of_roll}The thickness of the layers changes the pressure by "
        f"{100 * roll.finite_layer_effect:+.3g} % of the largest, which is included; the hoop "
        "stress is the mean across a layer."
    )


def _compression_note(result: RollResult) -> str:
    """Return a remark on hoop compression, which makes rolls buckle and star; '' without it."""
    share = result.compressed_share
    return f" Hoop compression on {100 * share:.3g} % of the build-up." if share else ""


def changes_sections(problem: FinishedRollProblem) -> Iterator[Section]:
    """Yield the section of the changes of the finished roll that are not zero.

    A change of temperature or moisture is followed by its coefficients that are not zero, with the
    grade from which they come.
    """
    ends = np.array([problem.core.radius, problem.radius])
    changes: list[Row] = []
    for name, strain_by in zip(FREE_STRAINS, problem.free_strains, strict=True):
        if not getattr(problem, name):
            continue
        changes += schedule_rows(problem, name, strain_by.change.at(ends))
        changes += [
            field_row(problem, coefficient, note=_grade_note(problem, coefficient))
            for coefficient in problem.coefficients_of(name)
            if getattr(problem, coefficient)
        ]
    changes += rows_of_given(problem, "core_shrinkage")
    if changes:
        yield Section("Changes of the finished roll", tuple(changes))


def _grade_note(problem: FinishedRollProblem, name: str) -> str:
    """Return a note behind the value of a field that its grade states; '' for others."""
    grade = problem.named_grade
    if grade is None or getattr(grade, name, None) != getattr(problem, name):
        return ""
    return f", of the grade {grade.name!r}"


def off_core_sections(result: RollResult | WindingResult, roll: RollResult) -> Iterator[Section]:
    """Yield the section of a roll that has left its core, or whose layers have separated.

    ``result`` is the roll or its winding, whose outputs are shown.
    """
    has_open_layers = bool((roll.opening > 0).any())
    if not (roll.is_off_core or has_open_layers):
        return
    known = [name for name in OFF_CORE if not isnan(value_of(result, name))]
    texts = [
        "Layers that are relieved follow the law of the stack back: hysteresis is neglected.",
    ]
    if "bonded_collapse_load" in known:
        texts.append(
            "The inner layers do not collapse if the ratio of freely sliding layers is below 1, "
            "and collapse without slip if that of bonded layers exceeds 1; in between, friction "
            "decides."
        )
    title = "Off the core" if roll.is_off_core else "Separated layers"
    rows = tuple(output_row(result, name) for name in known)
    yield Section(title, rows, " ".join(texts))


def _weight(result: RollResult) -> Iterator[Section]:
    """Yield the section of the weight of a roll whose density is known."""
    known = [name for name in WEIGHT if not isnan(value_of(result, name))]
    if known:
        note = (
            "The flattened width is that of a line contact with the moduli of the stack at its "
            "pressure below the surface."
        )
        if "weight_share" in known:
            on_core = (
                "Without friction the weight changes the pressure between the layers by the ratio; "
                "above 1 they separate below the core. "
            )
            note = on_core + note
        yield Section("Weight", tuple(output_row(result, name) for name in known), note)


def _gauge_band(result: RollResult) -> Iterator[Section]:
    """Yield the section of the gauge band, if there is one."""
    problem = result.problem
    if not problem.gauge_excess:
        return
    rows = [field_row(problem, "gauge_excess")]
    try:
        band = gauge_band_over(problem, result.radius[-1:])  # arrays of one value, at the surface
    except InvalidProblem as fault:
        yield Section(BAND, tuple(rows), f"Not computed: {in_chosen_units(str(fault))}")
        return
    ridge = float(band.lead[0] * result.radius[-1])
    rows += [
        row_of(line_load("WOT_b", "wound-on tension of the lane at the surface"), band.tension[0]),
        row_of(stress("P_b", "plateau pressure of the lane"), band.pressure[0]),
        row_of(strain("eps_b", "hoop strain of the lane"), band.strain[0]),
        row_of(length("dR", "height of the ridge over the lane", "um"), ridge),
    ]
    yield Section(BAND, tuple(rows))


def _other_theories(result: RollResult) -> Iterator[Section]:
    """Yield the plateau pressure for a roll with Pfeiffer's law and constant tension.

    The theory has neither later changes of the roll nor centrifugal force.
    """
    problem = result.problem
    if result.is_changed or problem.centrifugal_stress:
        return
    tension, law = problem.wound_on_tension, problem.stack.radial
    if not isinstance(tension, float) or not isinstance(law, Pfeiffer):
        return
    try:
        plateau = plateau_pressure(problem.stack, tension / problem.web_thickness)
    except InvalidProblem:  # no plateau is wound at this tension
        return
    label = "plateau pressure of thin layers, curvature neglected"
    yield Section("Other theories", (output_row(result, "mid_pressure", plateau, meaning=label),))
