"""The command ``woundon new``: print a commented case or study file."""

from __future__ import annotations

import click

from .options import KindName

__all__ = ["new"]


@click.command(
    help="""\
    Write a commented template case file with every field: woundon new > case.toml.

    KIND is nip (the default), rollers, roll, winding or the kind of a plug-in.
    """,
    short_help="Write a commented template case file, or a study file.",
)
@click.argument("kind", type=KindName(), default="nip", metavar="KIND")
@click.option("--study", is_flag=True, help="Write a study file with such a case for 'sweep'.")
def new(kind: str, study: bool) -> None:
    """Print a commented case or study file of a kind of problem."""
    from ..io.case_texts import template
    from ..studies.study_texts import study_template

    click.echo(study_template(kind) if study else template(kind), nl=False)
