"""The report on the drives of a winder, and their panels: torque and power over the radius."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..problems.paths import quantity_of_field
from ..winding.drives import DRIVES, Drive
from ..winding.result import WindingResult
from .panels import Axis, Curve, Panel
from .report_parts import (
    Part,
    Row,
    Section,
    TableRow,
    output_row,
    quantity_of,
    values_row,
    values_table,
)
from .roll_panels import over_radius

__all__ = ["DRIVE_OUTPUTS", "drive_parts", "power_panel", "torque_panel"]

Array = np.ndarray
RADII = 5  # that the table shows
# scalar outputs, which the section below the table has
DRIVE_OUTPUTS = tuple(f"{drive}.largest_{what}" for drive in DRIVES for what in ("torque", "power"))
COLOURS = dict(zip(DRIVES, ("roll", "drum", "green"), strict=True))
# of the power, which two drums may share equally
LINES = {"front_drive": "dashed"}


def _named_drives(result: WindingResult) -> dict[str, tuple[str, Drive]]:
    """Return the drives of a winding with their names in words, by the name of the output."""
    drum = "drum" if result.problem.winder is None else "rear drum"
    words = dict(zip(DRIVES, ("core", drum, "front drum"), strict=True))
    drives = {name: getattr(result, name) for name in DRIVES}
    return {name: (words[name], drive) for name, drive in drives.items() if drive is not None}


def drive_parts(result: WindingResult) -> list[Part]:
    """Return the table of the drives at some radii; nothing without the width or the speed."""
    drives = _named_drives(result)
    if not drives:
        return []
    r = np.linspace(*result.problem.ends, RADII)
    rows = [values_row("radius of the roll", quantity_of(result, "radius"), r)]
    largest: list[Row] = []
    for name, (words, drive) in drives.items():
        rows += _rows_of_drive(result, name, words, drive, r)
        for what in ("torque", "power"):
            meaning = f"largest {what} of the {words} drive"
            largest.append(output_row(result, f"{name}.largest_{what}", meaning=meaning))
    return [
        values_table("Drives", [""] * r.size, rows, _note(result)),
        Section("Largest torque and power of the drives", tuple(largest), _limits_of_use(result)),
    ]


def _rows_of_drive(
    result: WindingResult, name: str, words: str, drive: Drive, r: Array
) -> Iterator[TableRow]:
    """Yield the rows of a drive at radii [m]; that of the acceleration only if there is one."""
    labels = {
        "speed": f"speed of the {words}",
        "torque": f"torque of the {words}",
        "acceleration_torque": "additional torque for the acceleration",
        "power": f"power of the {words}",
    }
    for output, label in labels.items():
        values = getattr(drive, output)
        if output != "acceleration_torque" or values.any():
            at_radii = np.interp(r, result.drive_radius, values)
            yield values_row(label, quantity_of(result, f"{name}.{output}"), at_radii)


def _note(result: WindingResult) -> str:
    """Return the note below the table: signs, and which drive moves the inertia of the roll."""
    problem = result.problem
    text = "At constant web speed and for the whole width; > 0: it drives, < 0: it brakes."
    if problem.density is None:
        return f"{text} The inertia of the web is neglected, as its density is not given."
    mover = "drums move" if problem.winder is not None else "drum moves"
    if problem.winder is None and result.core_drive is not None:
        mover = "core drive moves"
    return f"{text} The {mover} the inertia of the roll."


def _limits_of_use(result: WindingResult) -> str:
    """Return the acceleration that the largest values include, and what they neglect."""
    problem = result.problem
    acceleration = problem.limits.acceleration
    quantity = quantity_of_field(problem, "limits.acceleration")
    text = "At constant web speed (limits.acceleration is 0)."
    if acceleration:
        speed = f"speeding up and slowing down by {quantity.text(acceleration)}"
        text = f"At constant web speed, and {speed} at this speed."
    text = f"{text} Gears, bearings and rolling resistance are not included."
    losses = [nip.result.rolling_resistance for nip in result.nips]
    if losses and not np.isnan(losses).all():
        assert problem.width is not None  # required for the drives, like the speed
        loss = problem.width * (problem.web_speed or 0.0) * max(losses)
        power = quantity_of(result, "core_drive.power" if result.core_drive else "drum_drive.power")
        text += f" The viscoelastic cover takes up to {power.text(loss)} more from the drives."
    return text


def torque_panel(result: WindingResult) -> Panel:
    """Return the panel of the torque of the drives, with that of the acceleration dashed."""
    drives, curves = _named_drives(result), []
    for name, (words, drive) in drives.items():
        output = f"{name}.torque"
        curves.append(Curve.of_output(result, output, result.drive_radius, words, COLOURS[name]))
        if drive.acceleration_torque.any():
            faster = drive.torque + drive.acceleration_torque
            label = f"{words}, accelerating"
            curves.append(
                Curve("", result.drive_radius, faster, "M", label, COLOURS[name], line="dashed")
            )
    y = Axis("Torque", quantity_of(result, f"{next(iter(drives))}.torque"), from_zero=True)
    return over_radius(result.radius, "torque", "Torque of the drives", y, curves, legend="right")


def power_panel(result: WindingResult) -> Panel:
    """Return the panel of the power of the drives at constant web speed."""
    drives = _named_drives(result)
    curves = [
        Curve.of_output(
            result,
            f"{name}.power",
            result.drive_radius,
            words,
            COLOURS[name],
            LINES.get(name, "solid"),
        )
        for name, (words, _) in drives.items()
    ]
    y = Axis("Power", quantity_of(result, f"{next(iter(drives))}.power"), from_zero=True)
    return over_radius(result.radius, "power", "Power of the drives", y, curves, legend="right")
