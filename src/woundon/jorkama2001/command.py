"""``woundon thesis``: recompute figures and tables, and print the verdict on each."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from .publication import Published

__all__ = ["thesis"]


@click.command(
    help="Recompute figures and tables of the thesis and test its statements: fig16, table3, ...",
    short_help="Recompute figures and tables of the thesis.",
)
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option("--all", "everything", is_flag=True, help="Every figure and table.")
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("thesis"),
    show_default=True,
    help="Folder for PNG, SVG, CSV and the verdict.",
)
@click.option(
    "--solver",
    type=click.Choice(["accurate", "thesis"]),
    default="accurate",
    show_default=True,
    help="The accurate solver, or the procedure of the thesis.",
)
@click.option("--jobs", type=click.IntRange(min=1), help="Processes; by default one a processor.")
def thesis(
    names: tuple[str, ...], everything: bool, out: Path, solver: str, jobs: int | None
) -> None:
    """Publish the figures and tables, and print their verdicts."""
    from ..studies.progress import progress_reporter
    from .catalogue import NAMES, chosen
    from .publication import publish, summary

    if bool(names) == everything:
        raise click.UsageError(
            f"name figures or tables, or ask for --all; there are {', '.join(NAMES)}"
        )
    wanted = NAMES if everything else chosen(names)
    done: list[Published] = []
    # a bar prints what goes to the terminal above itself; a file or a pipe gets it unchanged
    channel = None if sys.stdout.isatty() else sys.stdout
    try:
        with (
            progress_reporter(sys.stderr.isatty(), "figures and tables") as report,
            closing(publish(wanted, out, solver, jobs=jobs)) as parts,
        ):
            for one in parts:
                done.append(one)
                text = "\n".join(_brief(one)) if everything else one.judged.report()
                click.echo(text, file=channel)
                report(len(done), len(wanted))
    except KeyboardInterrupt:
        text = f"interrupted; {len(done)} of {len(wanted)} are in {out}"
        raise click.Abort(text) from None
    if everything:
        click.echo(_total(done))
        (out / "index.md").write_text(summary(done), encoding="utf-8")
    click.echo(f"written to {out}: {_files(done)}")


def _brief(one: Published) -> list[str]:
    """Return the number of statements that hold, and the failed statements."""
    label = one.judged.exhibit.label
    failures = (f"    - {line}" for line in one.judged.failures)
    return [f"{label:9}{one.judged.tally}  ({one.seconds:.1f} s)", *failures]


def _total(done: Iterable[Published]) -> str:
    """Return the numbers of all statements that hold and fail."""
    counts = [one.judged.counts for one in done]
    held, failed, untested = map(sum, zip(*counts, strict=True))
    return (
        f"{len(counts)} figures and tables, {held + failed + untested} statements: {held} hold, "
        f"{failed} do not hold, {untested} cannot be tested"
    )


def _files(done: Iterable[Published]) -> str:
    """Return the names of the files, or their number if they are many."""
    paths = [path.name for one in done for path in one.files]
    return ", ".join(paths) if len(paths) <= 8 else f"{len(paths)} files"
