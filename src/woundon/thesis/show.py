"""What the command line says of the thesis's figures as they are written."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import click

from .frame import Outcome
from .publication import Published

__all__ = ["show", "summary"]


def show(figures: Iterable[Published], folder: Path, *, brief: bool) -> None:
    """Tell of each figure as it is done: its report, or only what does not hold."""
    done = []
    for figure in figures:
        done.append(figure)
        if brief:
            click.echo(f"{figure.label:9}{figure.tally}  ({figure.seconds:.1f} s)")
            for line in figure.failures:
                click.echo(f"    - {line}")
        else:
            click.echo(figure.report)
    held, failed, untested = (sum(figure.counts[k] for figure in done) for k in range(3))
    if brief:
        click.echo(
            f"{len(done)} figures and tables, {held + failed + untested} statements: {held} hold, "
            f"{failed} do not hold, {untested} cannot be tested"
        )
        (folder / "index.md").write_text(summary(done), encoding="utf-8")
    click.echo(f"written to {folder}: {_endings(done)}")


def _endings(figures: list[Published]) -> str:
    paths = [path.name for figure in figures for path in figure.files]
    return ", ".join(paths) if len(paths) <= 8 else f"{len(paths)} files"


def summary(figures: Iterable[Published], folder: str = "") -> str:
    """Return a Markdown table of the figures with how many of their statements hold.

    ``folder``, ending in a slash, is where the pages lie, seen from the table.
    """
    words = [outcome.value for outcome in Outcome]
    lines = [
        f"| | shows | {' | '.join(words)} |",
        "|---|---|---|---|---|",
    ]
    for figure in sorted(figures, key=_order):
        counts = " | ".join(str(count) for count in figure.counts)
        lines.append(f"| [{figure.label}]({folder}{figure.name}.md) | {figure.title} | {counts} |")
    return "\n".join(lines) + "\n"


def _order(figure: Published) -> int:
    from .registry import NAMES

    return NAMES.index(figure.name)
