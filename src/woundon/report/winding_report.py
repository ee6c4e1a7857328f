"""The report of a winding: set points, wound-on tension, wound roll and margins."""

from __future__ import annotations

from collections.abc import Iterator

from ..problems.paths import field_or_none
from ..problems.winding import SCHEDULES
from ..winding.margins import TITLES
from ..winding.result import WindingResult
from .drives_report import DRIVE_OUTPUTS, drive_parts
from .lanes_report import WORST_LANE, lanes_sections
from .margins_report import margins_part
from .outputs_report import not_applicable, rows_of
from .report_parts import (
    Line,
    Part,
    Row,
    Section,
    field_row,
    output_row,
    rows_of_given,
    schedule_rows,
)
from .roll_report import (
    OFF_CORE,
    ROLL,
    changes_sections,
    layers_note,
    off_core_sections,
)
from .trade_rule import winding_trade_rule
from .winder_report import winder_parts

__all__ = ["winding_report"]

# in other rows, or among the margins
LEFT_OUT = frozenset(
    {
        "residual",
        "air_film",
        "mass",
        "mean_wound_on_tension",
        "mean_nip_induced_tension",
        "torque_share",
        "largest_compression",
        "largest_core_pressure",
        "largest_tension",
        "least_tension",
        "least_reserve",
        "band_strain",
        "face_strain",
        "ridge_height",
        "drum_friction_used",
        "mean_front_added_tension",
        "mean_rider_added_tension",
        *(
            f"{drum}.{name}"
            for drum in ("front", "rider")
            for name in ("least_tension", "largest_tension", "largest_added_tension")
        ),
        *(f"margins.{name}" for name in TITLES),
        "lane_count",
        "even_crown",
        "bore_hoop_stress",
        "bore_displacement",
        *OFF_CORE,
        *WORST_LANE,
        *DRIVE_OUTPUTS,
        *WindingResult.ESTIMATES,
    }
)
LAWS = {
    "friction": "Wound-on tension T_in + F + mu P: slip in the complete nip.",
    "fixed": "Wound-on tension T_in + NIT with the prescribed NIT.",
}
BODIES = {
    "effective": "In the nip the roll is linear, with E_r at the pressure of wound roll and nip "
    "(estimate); roll_body = 'direct' solves the hardening roll.",
    "direct": "",
    "linear": "In the nip the roll has the moduli of the web, whatever its pressure.",
}


def winding_report(result: WindingResult) -> list[Part]:
    """Return the report of a winding."""
    problem, nips = result.problem, result.nip_radius.size
    summary = (
        f"{nips} radii, {result.nips_solved} nips of {result.nodes} nodes solved" if nips else ""
    )
    law = problem.tension_law if isinstance(problem.tension_law, str) else "table"
    text = LAWS.get(law, "") if law != "nip" else BODIES[problem.roll_body]
    if law == "friction" and problem.winder is not None:
        text = "Wound-on tension of slip in all nips."
    if law == "table":
        text = "Wound-on tension as prescribed over the radius."
    if law in ("nip", "friction") and not problem.has_nip:
        text = "The web is wound without a nip: the wound-on tension is the web tension."
    means = ["mean_wound_on_tension", *(["mean_nip_induced_tension"] if problem.has_nip else [])]
    means += [f"mean_{drum}_added_tension" for drum in ("front", "rider") if getattr(result, drum)]
    errors = ["interpolation_error", "core_interpolation_error"] if nips else []
    mass = ["mass"] if problem.density is not None else []
    air = ["air_film"] if problem.air is not None else []
    ridge = ["ridge_height"] if problem.gauge_excess else []
    without = not_applicable(problem)
    left_out = LEFT_OUT | without
    of_bore = ["bore_hoop_stress", "bore_displacement"] if problem.is_changed else []
    of_roll = [name for name in (*ROLL, *of_bore) if name not in without]
    return [
        *([Line(summary, "quiet")] if summary else []),
        Section(
            "Winding",
            (
                field_row(problem.core, "radius"),
                field_row(problem, "radius"),
                *rows_of_given(problem, "caliper_pressure", "web_speed"),
                *_schedules(result),
            ),
        ),
        *winder_parts(result),
        *drive_parts(result),
        Section("Tension", tuple(output_row(result, name) for name in means + errors), text),
        *([winding_trade_rule(result)] if problem.has_nip else []),
        Section(
            "Wound roll",
            rows_of(result, of_roll + mass + air + ridge, leave=left_out),
            layers_note(result.roll),
        ),
        *changes_sections(problem),
        *off_core_sections(result, result.roll),
        *lanes_sections(result),
        margins_part(result.margins),
    ]


def _schedules(result: WindingResult) -> Iterator[Row]:
    """Yield the set points: a number, or the values at core and surface."""
    problem = result.problem
    for name in SCHEDULES:
        # the winding force follows from the torque split; without a nip there is none
        if name == "winding_force" and (problem.torque_split is not None or not problem.has_nip):
            continue
        # the law is in the text on the tension
        if name != "tension_law" and field_or_none(problem, name) is not None:
            yield from schedule_rows(problem, name, problem.at(name, problem.ends))
