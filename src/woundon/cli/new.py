"""The command ``woundon new``: print a commented case or study file."""

from __future__ import annotations

import click

from . import options

__all__ = ["new"]


@options.command(
    """\
    Write a case file to start from, or a study file.

    'woundon new > case.toml' writes a case of a nip. KIND is nip (the default), rollers, roll,
    winding or the kind of a plug-in. The file contains every field with its range; with --grade it
    is short: the grade supplies paper or film, and only the values of the winder are left to enter.
    """
)
@click.argument("kind", type=options.KindName(), default="nip", metavar="KIND")
@click.option(
    "--grade",
    metavar="NAME",
    help="A short case of a grade of 'woundon grades', for nip and winding.",
)
@click.option("--grades", "file", metavar="FILE", help="A TOML file with your own grades.")
@click.option("--study", is_flag=True, help="Write a study file with such a case for 'sweep'.")
def new(kind: str, grade: str | None, file: str | None, study: bool) -> None:
    """Write a case file to start from, or a study file."""
    from ..io.case_texts import grade_template, template
    from ..studies.study_texts import study_template

    if grade:
        text = grade_template(kind, grade, file)
    else:
        text = study_template(kind) if study else template(kind)
    click.echo(text, nl=False)
