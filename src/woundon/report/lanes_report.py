"""The section of a report on the lanes across the width of the web."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import nan
from typing import Any

import numpy as np

from ..problems.thickness_profile import ThicknessProfile
from ..quantities import share
from ..roll.lane_roll import LANE_QUANTITIES, NIP_LOADS, POSITION, edges_of_lanes, slack_lanes
from .lane_panels import DRUMS
from .outputs_report import not_applicable
from .report_parts import Row, Section, field_row, quantity_of, row_of

__all__ = ["WORST_LANE", "lanes_sections"]

Array = np.ndarray
NAMES = (
    "tension",
    "least_tension",
    "pressure",
    "core_pressure",
    "compression",
    "strain",
    "ridge_height",
)
# outputs that the section shows; the rest is in its text
WORST_LANE = frozenset(f"worst_lane.{name}" for name in (*NAMES, "slack_share"))


def lanes_sections(result: Any) -> Iterator[Section]:
    """Yield the section of the lanes, if the problem has a thickness profile.

    Parameters
    ----------
    result : RollResult or WindingResult
    """
    lanes, problem = result.lanes, result.problem
    if lanes is None:
        return
    excess, without = lanes.thickness_excess.values, not_applicable(problem)
    rows = [
        *_range("thickness of the lanes relative to the mean", "d", excess),
        *_spread(problem.thickness_profile),
        *([field_row(problem, "oscillation")] if problem.oscillation else []),
        *(_worst(result, name) for name in NAMES if f"worst_lane.{name}" not in without),
        *_deflections(result),
    ]
    texts = [
        f"{lanes.position.size} lanes across the width.",
        _nip_loads(lanes),
        _slack_lanes(lanes),
        _neglected(result.problem),
    ]
    yield Section("Lanes across the width", tuple(rows), " ".join(filter(None, texts)))


def _range(meaning: str, symbol: str, excess: Array) -> list[Row]:
    """Return the rows of the smallest and the largest deviation of the thickness."""
    return [
        row_of(share(symbol, f"{word} {meaning}"), float(value))
        for word, value in (("smallest", excess.min()), ("largest", excess.max()))
    ]


def _worst(result: Any, name: str) -> Row:
    """Return the row of a value of the worst lane, with its error estimate."""
    output = f"worst_lane.{name}"
    error = result.errors.get(output, nan)
    return row_of(quantity_of(type(result), output), getattr(result.worst_lane, name), error)


def _deflections(result: Any) -> list[Row]:
    """Return the rows of the deflections of drums and core, and of the crown of an even load."""
    lanes = result.lanes
    rows = []
    for name in LANE_QUANTITIES:
        if not name.endswith("_deflection") or name not in lanes:
            continue
        quantity, deflection = LANE_QUANTITIES[name], lanes[name].values[-1]
        meaning = quantity.meaning.replace("deflection", "range of the deflection", 1)
        rows.append(row_of(replace(quantity, meaning=meaning), float(np.ptp(deflection))))
    if "drum_deflection" in lanes:
        rows.append(row_of(quantity_of(type(result), "even_crown"), result.even_crown))
    return rows


def _spread(profile: ThicknessProfile) -> list[Row]:
    """Return the row of the largest standard deviation between scans, if several were taken."""
    if profile.spread is None:
        return []
    meaning = "largest standard deviation between the scans, of the mean"
    return [row_of(share("s_h", meaning), max(profile.spread) / profile.mean)]


def _nip_loads(lanes: Any) -> str:
    """Return a sentence on the loads of the nips on the lanes; "" without solved nips."""
    names = [name for name in NIP_LOADS if name in lanes]
    if np.isnan(lanes.nip_load.values).any():
        return ""
    ranges = []
    for name in names:
        quantity, load = LANE_QUANTITIES[name], lanes[name].values
        low, high = quantity.text(float(load.min())), quantity.text(float(load.max()))
        drum = f"of the {DRUMS[name][1]} " if len(names) > 1 else ""
        ranges.append(f"{drum}between {low} and {high}")
    text = ", ".join(ranges)
    return f"The nip load on a lane is {text}; the ridges are those under the nip."


def _slack_lanes(lanes: Any) -> str:
    """Return a sentence on lanes without tension; "" if there is none."""
    slack = slack_lanes(lanes.share.values, lanes.wound_on_tension.values.T)
    if not slack.any():
        return "No lane is slack."
    edges = edges_of_lanes(lanes.position.values)
    # ends of the runs of slack lanes
    changes = np.flatnonzero(np.diff(np.concatenate([[False], slack, [False]])))
    places = [
        " to ".join(POSITION.text(edge) for edge in run.tolist())
        for run in edges[changes.reshape(-1, 2)]
    ]
    share = 100 * float(lanes.share.values[slack].sum())
    where = ", ".join(places)
    return f"Slack, without tension at some radius: {where} across the web, {share:.3g} % of it."


def _neglected(problem: Any) -> str:
    """Return a sentence on the shear between the lanes."""
    build_up = POSITION.text(problem.radius - problem.core.radius)
    return (
        "Shear between the lanes is neglected: stresses and ridges are upper bounds, and too large "
        f"for ridges narrower than about the build-up of the roll, {build_up}."
    )
