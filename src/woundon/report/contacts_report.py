"""The nips of a web on a roll, one after the other: table and sentences."""

from __future__ import annotations

from collections.abc import Iterator
from math import isnan

import numpy as np

from ..nip.result import NipResult
from ..quantities import Quantity, angle, line_load, share
from .report_parts import Part, TableRow, quantity_of, values_row, values_table

__all__ = ["FORCE", "LOAD", "TENSION", "USED", "contact_sentences", "contacts_parts"]

LOAD, FORCE = line_load("P", "nip load"), line_load("F", "winding force")
TENSION, ANGLE = line_load("T", "tension"), angle("theta", "angle")
USED = share("|F|/mu P", "friction used")
ADDED = line_load("WOT_k", "part of the wound-on tension")


def contact_sentences(result: NipResult) -> Iterator[str]:
    """Yield a sentence on what each further nip adds to the wound-on tension."""
    for k, contact in enumerate(result.contacts[1:], 2):
        if contact.sticks_upstream:
            yield f"Nip {k} adds nothing: the layer sticks to the roll between the nips."
            continue
        if isnan(contact.added_tension):
            yield f"What nip {k} adds is not known: the nips before it have no solution alone."
            continue
        added = ADDED.text(contact.added_tension, ".3g")
        yield f"Nip {k} adds {added}: the web slips on the whole arc before it."


def contacts_parts(result: NipResult) -> list[Part]:
    """Return the table of all nips; nothing without further ones."""
    contacts = result.contacts
    if len(contacts) == 1:
        return []

    def row(label: str, quantity: Quantity, name: str) -> TableRow:
        """Return the row of an attribute of all nips; empty cells where it is not known."""
        values = np.array([float(getattr(contact, name)) for contact in contacts])
        cells = values_row(label, quantity, values).cells
        return TableRow(tuple("" if cell == "nan" else cell for cell in cells))

    rows = [
        row("angle from the first nip", ANGLE, "angle"),
        row("nip load", LOAD, "nip_load"),
        row("winding force of the drum", FORCE, "winding_force"),
        row("friction used by the drum", USED, "friction_ratio"),
        row("nip width", quantity_of(result, "nip_width"), "nip_width"),
        row("largest pressure", quantity_of(result, "peak_pressure"), "peak_pressure"),
        row("creepage between web and drum", quantity_of(result, "drum_creepage"), "drum_creepage"),
        row("smallest tension on the arc before it", TENSION, "least_tension"),
        row("largest tension on the arc before it", TENSION, "largest_tension"),
        row("angle of slip before it", ANGLE, "slip_angle"),
        TableRow(
            (
                "web on the arc before it",
                "",
                *("sticks" if each.sticks_upstream else "slips" for each in contacts[1:]),
                "",
            )
        ),
        row("web tension at the leading edge", TENSION, "inlet_tension"),
        row("web tension at the trailing edge", TENSION, "outlet_tension"),
        row("part of WOT_r that it adds", ADDED, "added_tension"),
    ]
    heads = [f"nip {k + 1}" for k in range(len(contacts))]
    text = (
        "A winding force < 0 drives the web. A nip downstream of a web that sticks to the roll "
        "adds nothing: the strain with which the layer was laid is the strain with which it leaves "
        "the nip; the nip only squeezes the roll."
    )
    return [values_table("Nips of the web on the roll", heads, rows, text)]
