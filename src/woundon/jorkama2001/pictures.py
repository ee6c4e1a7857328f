"""Figures of the thesis for the page of woundon: their list, and each one drawn.

The list is read in the functions, since each process of woundon loads this module.
"""

from __future__ import annotations

__all__ = ["drawn", "known"]


def known() -> list[dict[str, str]]:
    """Return name, label and title of each figure; nothing is computed, nothing else imported."""
    from .exhibits import listed

    return [
        {"name": name, "label": entry.label, "title": entry.title}
        for name, entry in listed().items()
        if name.startswith("fig")
    ]


def drawn(name: str) -> bytes:
    """Compute a figure by the accurate solver and return it as SVG.

    Raises
    ------
    InvalidProblem
        For a name that is none.
    """
    from ..report.figures import figure_bytes
    from .catalogue import chosen, made_by
    from .exhibits import listed

    (name,) = chosen([name])
    made = {one.name: one for one in made_by(listed()[name].module, "accurate")}
    return figure_bytes(made[name].figure(), ".svg")
