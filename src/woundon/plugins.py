"""Plug-ins: modules of other packages that add kinds, bodies, outputs, commands and figures.

An installed package names a module in the entry-point group ``woundon.plugins``:

    [project.entry-points."woundon.plugins"]
    mattress = "mattress"

The module is imported once, before the first case is read, in worker processes too.  It adds

    a kind of problem    wo.kinds.register(MyProblem, my_solver, MyResult)
    a body, a material   class MyBody(wo.Body): ...
    an output            wo.plugins.register_output("nip", my_output)
    a command            wo.plugins.register_command(my_command)
    figures of the page  wo.plugins.register_figures(list_figures, draw_figure)

>>> import click
>>> import woundon as wo
>>> @click.command("basis-weight")
... @click.argument("thickness", type=float)
... @click.argument("density", type=float)
... def basis_weight(thickness, density):
...     click.echo(f"{1e3 * thickness * density:g} g/m^2")
>>> wo.plugins.register_command(basis_weight)
>>> "basis-weight" in wo.plugins.commands()
True
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from importlib import metadata
from typing import TYPE_CHECKING, Any, NamedTuple

from . import quantities

if TYPE_CHECKING:
    import click

__all__ = [
    "GROUP",
    "Figures",
    "commands",
    "figures",
    "load",
    "register_command",
    "register_figures",
    "register_output",
    "take_outputs",
]

GROUP = "woundon.plugins"

_COMMANDS: dict[str, click.Command] = {}
_FIGURES: dict[Callable[[str], bytes], Figures] = {}  # by the function that draws them
# kind, name and property of the outputs that their classes of results do not have yet
_OUTPUTS: list[tuple[str, str, property | quantities.on_request]] = []


class Figures(NamedTuple):
    """Figures that a plug-in shows on the page: functions that list and draw them.

    They are the arguments of :func:`register_figures`.
    """

    list: Callable[[], Sequence[Mapping[str, str]]]
    draw: Callable[[str], bytes]


@cache
def load() -> None:
    """Import the modules of the entry-point group, once.

    Warns
    -----
    RuntimeWarning
        If a module cannot be imported.  The other plug-ins are not affected.
    """
    for entry in metadata.entry_points(group=GROUP):
        try:
            entry.load()
        except ImportError as fault:
            text = f"the plug-in {entry.name} cannot be loaded: {fault}"
            warnings.warn(text, RuntimeWarning, stacklevel=2)


def register_output(kind: str, output: Callable[[Any], Any], *, on_request: bool = False) -> None:
    """Add an output to the results of a kind of problem.

    Parameters
    ----------
    kind : str
        Name of the kind.  Its classes are not imported by this call.
    output : callable
        (result) -> value, with the :class:`~woundon.quantities.Quantity` of the value in its return
        annotation.  The output has the name of the function.
    on_request : bool
        Whether the output is computed only where it is named, and is not part of reports and files.
    """
    descriptor = quantities.on_request(output) if on_request else property(output)
    _OUTPUTS.append((kind, output.__name__, descriptor))


def take_outputs() -> Iterator[tuple[str, str, property | quantities.on_request]]:
    """Yield kind, name and property of the outputs that the results do not have yet.

    Each is yielded once: the caller adds it to the class of the results of the kind.
    """
    load()
    while _OUTPUTS:
        yield _OUTPUTS.pop(0)


def register_command(command: click.Command) -> None:
    """Add a command to the command line.

    >>> import click
    >>> @click.command("greet")
    ... def greet():
    ...     click.echo("good day")
    >>> register_command(greet)
    >>> commands()["greet"] is greet
    True

    Parameters
    ----------
    command : click.Command
        Its name is that of the command: ``woundon NAME``.  The module should import libraries that
        take long inside the command: ``woundon --help`` loads it.
    """
    if command.name is None:
        raise ValueError("a command needs a name")
    _COMMANDS[command.name] = command


def commands() -> Mapping[str, click.Command]:
    """Return the commands of all plug-ins by name."""
    load()
    return dict(sorted(_COMMANDS.items()))


def register_figures(
    list_figures: Callable[[], Sequence[Mapping[str, str]]], draw_figure: Callable[[str], bytes]
) -> None:
    """Add figures to the page.

    Parameters
    ----------
    list_figures : callable
        Returns ``name``, ``label`` and ``title`` of each figure, without computing it.
    draw_figure : callable
        Computes the figure of a name, and returns it as SVG.
    """
    _FIGURES[draw_figure] = Figures(list_figures, draw_figure)


def figures() -> tuple[Figures, ...]:
    """Return the figures of all plug-ins."""
    load()
    return tuple(_FIGURES.values())
