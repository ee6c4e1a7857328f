"""A solved nip as text for the terminal: what matters with units, zones, rivals, certificate."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from . import theories
from .bodies import HalfPlane
from .quantities import QUANTITIES
from .results import NipResult, Sensitivity, Zone
from .wrap import WrappedNipResult
from .zones import zone_runs

__all__ = ["print_report", "print_sensitivity", "zone_line"]

Array = np.ndarray

_ZONES_WIDTH = 60
_MARKS = {Zone.BACKWARD: "◀", Zone.STICK: "·", Zone.FORWARD: "▶"}
_ASCII_MARKS = {Zone.BACKWARD: "<", Zone.STICK: ".", Zone.FORWARD: ">"}
_STYLES = {Zone.BACKWARD: "yellow", Zone.STICK: "dim", Zone.FORWARD: "blue"}


def print_report(result: NipResult | WrappedNipResult, console: Console) -> None:
    """Print the report of a solved nip, with its wraps if it has any."""
    ascii_only = console.options.ascii_only
    plus_minus, marks = ("+-", _ASCII_MARKS) if ascii_only else ("±", _MARKS)
    nip = result if isinstance(result, NipResult) else result.nip
    solved = f"{nip.scheme} scheme, {result.nodes} nodes, {result.iterations} linear systems"
    console.print(Text(solved, style="dim"))
    console.print(_load_table(result))
    if isinstance(result, NipResult):
        console.print(_main_table(result, plus_minus))
    else:
        console.print(_wrap_table(result, plus_minus))
        console.print(_main_table(nip, plus_minus, inner=True))
    console.print(_zones(nip, marks))
    if isinstance(result, NipResult):
        console.print(_rivals(result))
        console.print()
    if result.warnings:
        lines = "\n".join(f"warning: {warning}" for warning in result.warnings)
        console.print(Text(f"{lines}\n", style="bold yellow"))
    console.print(Text(_certificate(result), style="green"))


def _table(title: str) -> Table:
    table = Table(
        title=title, title_justify="left", title_style="bold", box=None, show_header=False
    )
    table.add_column(min_width=53)
    table.add_column(min_width=6, style="dim")
    table.add_column(justify="right", min_width=10)
    table.add_column(style="dim")
    return table


def _row(
    table: Table, name: str, value: float, *, note: str = "", label: str = "", symbol: str = ""
) -> None:
    quantity = QUANTITIES[name]
    text = f"{quantity.shown(value):.5g}"
    unit = f"{quantity.display}{note}"
    table.add_row(label or quantity.description, symbol or quantity.symbol, text, unit)


def _load_table(result: NipResult | WrappedNipResult) -> Table:
    table = _table("\nLoads")
    _row(table, "nip_load", result.problem.nip_load)
    _row(table, "winding_force", result.problem.winding_force)
    _row(table, "incoming_tension", result.problem.web_tension)
    return table


def _wrap_table(result: WrappedNipResult, plus_minus: str) -> Table:
    table = _table("\nWraps")
    note = f"  {plus_minus} {result.wound_on_tension_error:.2g}"
    _row(table, "roll_wrap", result.roll_wrap)
    _row(table, "wound_on_tension", result.wound_on_tension, note=note, symbol="WOT")
    _row(table, "tension_behind_nip", result.tension_behind_nip)
    _row(table, "roll_wrap_traction", result.roll_wrap_traction)
    way = {Zone.STICK: "", Zone.FORWARD: ", web faster", Zone.BACKWARD: ", web slower"}
    _row(table, "slip_angle", result.slip_angle, note=way[result.slip_zone])
    if result.drum_wrap:
        _row(table, "drum_wrap", result.drum_wrap)
        _row(table, "tension_before_nip", result.tension_before_nip)
        _row(table, "drum_wrap_traction", result.drum_wrap_traction)
    return table


def _main_table(result: NipResult, plus_minus: str, *, inner: bool = False) -> Table:
    """Tabulate the nip; ``inner`` is one between wraps, which tell its tensions themselves."""
    slips = result.slip_ratios
    table = _table("\nWinding nip")
    error = result.nip_induced_tension_error
    note = f"  {plus_minus} {error:.2g}" if np.isfinite(error) and not inner else ""
    _row(table, "nip_induced_tension", result.nip_induced_tension, note=note)
    if not inner:
        _row(table, "wound_on_tension", result.wound_on_tension)
    _row(table, "nip_width", 2 * result.half_width)
    _row(table, "peak_pressure", float(result.pressure.max()))
    _row(table, "approach", result.approach)
    _row(table, "offset", result.offset)
    _row(table, "drum_creep", result.drum_creep)
    _row(table, "leading_roll", slips.leading_roll)
    _row(table, "trailing_roll", slips.trailing_roll)
    _row(table, "dual", slips.dual)
    return table


def _zones(result: NipResult, marks: dict[Zone, str]) -> Text:
    text = Text("\nZones, leading edge on the left\n", style="")
    text.stylize("bold")
    for side, zones in (("roll", result.roll_zone), ("drum", result.drum_zone)):
        text.append(f" {side}  ")
        for zone, length in zone_line(result.x, zones, _ZONES_WIDTH):
            text.append(marks[zone] * length, style=_STYLES[zone])
        text.append("\n")
    words = {"stick": Zone.STICK, "web faster": Zone.FORWARD, "web slower": Zone.BACKWARD}
    legend = "   ".join(f"{marks[zone]} {word}" for word, zone in words.items())
    text.append(f"       {legend}\n", style="dim")
    return text


def zone_line(x: Array, zones: Array, width: int) -> list[tuple[Zone, int]]:
    """Return runs (zone, characters) that draw the zones over ``width`` characters.

    A run is as long as its share of the nip but never nothing: a short slip zone at an edge stays
    in sight.
    """
    runs = [
        (zone, max(1, round((right - left) / (x[-1] - x[0]) * width)))
        for zone, left, right in zone_runs(x, zones)
    ]
    # rounding is made up for where it shows least
    longest = max(range(len(runs)), key=lambda i: runs[i][1])
    surplus = sum(length for _, length in runs) - width
    runs[longest] = (runs[longest][0], max(1, runs[longest][1] - surplus))
    return runs


def _rivals(result: NipResult) -> Table:
    """Compare with the closed forms; those of the tension take the solved approach and zones."""
    problem = result.problem
    table = _table("Other theories")
    for label, value in _rival_tensions(result):
        _row(table, "nip_induced_tension", value, label=label)
    contact = theories.hertz(problem)
    _row(table, "nip_width", 2 * contact.half_width, label="Hertz (half-planes, no web)")
    _row(table, "peak_pressure", contact.peak_pressure, label="Hertz (half-planes, no web)")
    return table


def _rival_tensions(result: NipResult) -> Iterator[tuple[str, float]]:
    problem = result.problem
    yield "friction limit mu+ P + F (upper bound)", theories.friction_limit(problem)
    dual = float(theories.dual_slip(problem, result.slip_ratios.dual))
    yield "dual-slip formula, with the solved dual slip", dual
    if not any(isinstance(body, HalfPlane) for body in (problem.roll, problem.drum)):
        # a half-plane's approach holds up to a constant only
        jalkanen = theories.jalkanen(problem, result.approach)
        yield "Jalkanen, with the solved approach", jalkanen


def _certificate(result: NipResult | WrappedNipResult) -> str:
    law, value = max(result.residuals.items(), key=lambda item: item[1])
    count = sum(1 for _ in result.residuals.items())
    return (
        f"Certificate: all {count} contact laws hold; the largest residual is {value:.1e} "
        f"({law.replace('_', ' ')})"
    )


def print_sensitivity(sensitivity: Sensitivity, console: Console) -> None:
    """Print elasticities, what matters most for the nip-induced tension first."""
    ordered = sensitivity.sorted()
    title = "\nElasticities: percent of output per percent of field"
    table = Table(title=title, title_justify="left", title_style="bold", box=None)
    table.add_column("", min_width=32)
    table.add_column("value [SI]", justify="right", style="dim")
    for output in ordered.outputs:
        table.add_column(QUANTITIES[output].symbol, justify="right", min_width=9)
    for name, field, column in zip(
        ordered.parameters, ordered.fields, ordered.elasticities.T, strict=True
    ):
        if field != 0:
            table.add_row(
                name, f"{field:.5g}", *(f"{round(value, 4) + 0:+.4f}" for value in column)
            )
    console.print(table)
    for name, field in zip(ordered.parameters, ordered.fields, strict=True):
        if field == 0:  # no percent of it; what it does all the same
            slope = ordered.derivative("nip_induced_tension", name)
            console.print(Text(f"{name} is 0: NIT changes by {slope:+.4g} N/m per SI unit of it"))
    if ordered.zone_change:
        text = f"warning: at a zone change ({ordered.zone_change}): one-sided derivatives differ"
        console.print(Text(text, style="bold yellow"))
