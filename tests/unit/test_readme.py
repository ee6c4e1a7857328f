"""The README says what the program does: its Python block and its command are run and compared.

To renew the README after a change of the program, copy what the failing test shows.
"""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path

import pytest

from woundon import cli

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)


def same_on_any_machine(text: str) -> str:
    """Strip what rounding on another processor may change: effort and the size of a residual."""
    text = re.sub(r"\d+ linear systems", "N linear systems", text)
    text = re.sub(r"residual is .*", "residual is R", text)
    return "\n".join(line.rstrip() for line in text.strip().splitlines())


def test_python_block_prints_what_the_readme_says():
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(blocks("python")[0], "README.md", "exec"), {})
    assert same_on_any_machine(said.getvalue()) == same_on_any_machine(blocks("text")[0])


def test_python_block_is_about_ten_lines():
    lines = [line for line in blocks("python")[0].splitlines() if line.strip()]
    assert len(lines) <= 13


def test_command_prints_what_the_readme_says(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    command = "./run nip examples/newsprint_table2.toml"
    assert f"\n{command}\n" in README
    monkeypatch.chdir(ROOT)
    monkeypatch.setenv("PYTHONIOENCODING", "utf-8")
    assert cli.main(command.split()[1:]) == 0
    assert same_on_any_machine(capsys.readouterr().out) == same_on_any_machine(blocks("text")[1])


def test_pictures_and_files_that_the_readme_names_exist():
    named = re.findall(r"\]\((\S+?)\)|`((?:docs|tests|examples)/\S*?|[A-Z]+\.(?:md|cff))`", README)
    paths = [a or b for a, b in named]
    assert paths
    assert [path for path in paths if not (ROOT / path).exists()] == []
