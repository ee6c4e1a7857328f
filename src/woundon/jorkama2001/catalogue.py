"""Figures and tables of the thesis computed by name.

A module ``fig15``, ``fig16_18``, ... has a function ``exhibits(solver)`` that returns its figures
and tables.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from difflib import get_close_matches

import woundon as wo

from .exhibits import Exhibit, listed

__all__ = ["NAMES", "chosen", "made_by", "modules"]

NAMES = tuple(listed())

# the ones that take longest, longest first: processes that start with them end sooner
_LONG = ("fig28_29", "table3", "fig19", "fig16_18", "fig21_22", "fig23_24", "fig26", "fig33")


def chosen(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names, checked, in the order of the thesis.

    Raises
    ------
    InvalidProblem
        For a name that is no figure or table here.
    """
    for name in names:
        if name not in NAMES:
            near = get_close_matches(name, NAMES, 1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            text = f"unknown{hint}; there are {', '.join(NAMES)}"
            raise wo.InvalidProblem([(name, text)])
    return tuple(name for name in NAMES if name in names)


def modules(names: Sequence[str]) -> tuple[str, ...]:
    """Return the modules that make these figures and tables, the longest first."""
    needed = dict.fromkeys(listed()[name].module for name in names)
    return tuple(sorted(needed, key=lambda m: _LONG.index(m) if m in _LONG else len(_LONG)))


def made_by(module: str, solver: str) -> tuple[Exhibit, ...]:
    """Compute all figures of a module, "accurate" or by the procedure of the "thesis"."""
    # the names are needed without the modules, which import xarray and SciPy
    from . import (  # noqa: F401  found below by their names
        fig5,
        fig15,
        fig16_18,
        fig19,
        fig20,
        fig21_22,
        fig23_24,
        fig25,
        fig26,
        fig27,
        fig28_29,
        fig30,
        fig33,
        fig34,
        fig35,
        fig37,
        table3,
        table4,
    )

    made: tuple[Exhibit, ...] = sys.modules[f"{__package__}.{module}"].exhibits(solver)
    return made
