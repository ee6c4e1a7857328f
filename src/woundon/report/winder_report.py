"""The report on a two-drum winder: loads, forces and tensions between the drums over the radius."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..quantities import angle, share, value_of
from ..winding.drum_nips import DrumNips
from ..winding.result import WindingResult
from .contacts_report import FORCE, LOAD, TENSION, USED
from .report_parts import Part, TableRow, quantity_of, values_row, values_table

__all__ = ["drum_sentences", "winder_parts"]

Array = np.ndarray
RADII = 5  # that the table shows
NOTICEABLE = 5e-3  # of the tension: a squeeze of the roll that the first lines mention
ARC = angle("theta", "arc")
SHARE = share("T/T_in", "tension, relative to the web tension")


def drum_sentences(result: WindingResult) -> Iterator[str]:
    """Yield a sentence on the tension that the front drum adds, and one on the rider."""
    for drum_name, name, where in (
        ("front", "front drum", "between the drums"),
        ("rider", "rider", "between front drum and rider"),
    ):
        drum = getattr(result, drum_name)
        if drum is None:
            continue
        if drum.sticks.all():
            squeeze = drum.largest_added_tension
            remark = ""
            if squeeze > NOTICEABLE * result.mean_wound_on_tension:
                remark = f"; its load squeezes the roll, at most +{TENSION.text(squeeze, '.2g')}"
            yield f"The {name} adds nothing: the layer sticks {where}{remark}."
        else:
            slipping, count = int((~drum.sticks).sum()), drum.sticks.size
            at = "" if slipping == count else f" at {slipping} of {count} radii"
            mean = value_of(result, f"mean_{drum_name}_added_tension")
            yield (
                f"The {name} adds {TENSION.text(mean, '.3g')} in the mean, at most "
                f"{TENSION.text(drum.largest_added_tension, '.3g')}: the web slips on the whole "
                f"arc {where}{at}."
            )


def winder_parts(result: WindingResult) -> list[Part]:
    """Return the table of a two-drum winder at some radii; nothing without a winder."""
    problem = result.problem
    if problem.winder is None:
        return []
    r = _radii(result)
    loads, used = problem.drum_loads(r), problem.friction_used(r)
    rows = [
        values_row("radius of the roll", quantity_of(result, "radius"), r),
        values_row("load of the rear drum", LOAD, loads.rear_load),
        values_row("load of the front drum", LOAD, loads.front_load),
        values_row("load of the rider", LOAD, loads.rider_load),
        values_row("winding force of the rear drum", FORCE, loads.rear_force),
        values_row("winding force of the front drum", FORCE, loads.front_force),
        values_row("friction used by the rear drum", USED, used["drum"]),
        values_row("friction used by the front drum", USED, used["winder.front_drum"]),
        values_row("arc from the rear to the front drum", ARC, loads.front_arc),
        *_rows_of_nips(result, result.front, "front drum", r),
        *_rows_of_nips(result, result.rider, "rider", r),
    ]
    text = "A winding force < 0 drives the roll."
    return [values_table("Two-drum winder", [""] * r.size, rows, text)]


def _radii(result: WindingResult) -> Array:
    """Return the radii of the table, (k,): some of those of the solved nips, else even ones [m]."""
    even = np.linspace(*result.problem.ends, RADII)
    nips = result.nip_radius
    if not nips.size:
        return even
    nearest = np.abs(nips[:, None] - even).argmin(axis=0)
    return np.asarray(nips[np.unique(nearest)])


def _rows_of_nips(
    result: WindingResult, drum: DrumNips | None, name: str, r: Array
) -> Iterator[TableRow]:
    """Yield the rows on the web upstream of a drum at radii [m]; none without its nips."""
    if drum is None:
        return
    at = np.searchsorted(result.nip_radius, r)
    least = drum.arc_least_tension[at]
    yield values_row(f"smallest tension before the {name}", TENSION, least)
    yield values_row(
        "its share of the web tension", SHARE, least / result.problem.at("web_tension", r)
    )
    yield values_row(f"largest tension before the {name}", TENSION, drum.arc_largest_tension[at])
    yield values_row(f"angle of slip before the {name}", ARC, drum.slip_angle[at])
    yield values_row(f"tension added by the {name}", TENSION, drum.added_tension[at])
    words = ("sticks" if sticks else "slips" for sticks in drum.sticks[at])
    yield TableRow((f"web on the arc before the {name}", *words, ""))
