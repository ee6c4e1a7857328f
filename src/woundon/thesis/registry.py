"""Which module makes which figure or table of the thesis.

A module has a function ``figures(scheme)`` that returns its figures; a new one is a line here.
"""

from __future__ import annotations

from importlib import import_module

from ..errors import InvalidProblem, did_you_mean
from .frame import Figure, Scheme

__all__ = ["NAMES", "chosen", "figures", "modules"]

# in the order of the thesis
_MODULES = {
    "fig5": "fig5",
    "fig15": "fig15",
    "fig16": "fig16_18",
    "fig17": "fig16_18",
    "fig18": "fig16_18",
    "fig19": "fig19",
    "fig20": "fig20",
    "fig21": "fig21_22",
    "fig22": "fig21_22",
    "fig23": "fig23_24",
    "fig24": "fig23_24",
    "fig25": "fig25",
    "fig26": "fig26",
    "fig27": "fig27",
    "fig28": "fig28_29",
    "fig29": "fig28_29",
    "fig30": "fig30",
    "fig33": "fig33",
    "fig34": "fig34",
    "fig35": "fig35",
    "table3": "chapter5",
    "fig37": "chapter5",
    "table4": "table4",
}
NAMES = tuple(_MODULES)

# the ones that take longest, longest first: a pool of processes that starts with them ends sooner
_LONG = ("fig28_29", "chapter5", "fig16_18", "fig19", "fig23_24", "fig21_22", "fig33", "fig26")


def chosen(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names, checked, in the order of the thesis.

    Raises
    ------
    InvalidProblem
        For a name that is no figure or table here.
    """
    for name in names:
        if name not in _MODULES:
            text = f"unknown{did_you_mean(name, NAMES)}; there are {', '.join(NAMES)}"
            raise InvalidProblem([(name, text)])
    return tuple(name for name in NAMES if name in names)


def modules(names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the modules that make these figures, the longest first."""
    needed = dict.fromkeys(_MODULES[name] for name in names)
    return tuple(sorted(needed, key=lambda m: _LONG.index(m) if m in _LONG else len(_LONG)))


def figures(module: str, scheme: Scheme) -> tuple[Figure, ...]:
    """Compute all figures of a module."""
    made: tuple[Figure, ...] = import_module(f".{module}", __package__).figures(scheme)
    return made
