"""Figures of the thesis for the page of woundon: their list, and each one drawn."""

from __future__ import annotations

import ast
from importlib import resources

from .catalogue import NAMES, chosen, made_by, modules

__all__ = ["drawn", "known"]


def known() -> list[dict[str, str]]:
    """Return name, label and title of each figure; nothing is computed, nothing imported."""
    entries = []
    for name in (name for name in NAMES if name.startswith("fig")):
        (module,) = modules([name])
        source = resources.files(__package__).joinpath(f"{module}.py").read_text(encoding="utf-8")
        about = (ast.get_docstring(ast.parse(source)) or "").partition("\n")[0]
        title = about.partition(": ")[2].rstrip(".") or about
        label = f"Fig. {name.removeprefix('fig')}"
        entries.append({"name": name, "label": label, "title": title})
    return entries


def drawn(name: str) -> bytes:
    """Compute a figure by the accurate solver and return it as SVG.

    Raises
    ------
    InvalidProblem
        For a name that is none.
    """
    from .drawing import figure_bytes  # here, because ``known`` draws nothing

    (module,) = modules(chosen([name]))
    exhibit = next(one for one in made_by(module, "accurate") if one.name == name)
    assert exhibit.draw is not None  # of figures, which are all that is known here
    return figure_bytes(exhibit.draw(), "svg")
