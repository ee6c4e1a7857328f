"""Every kind, command, extra and package is documented on the page where readers look for it.

Evidence: consistency.  The lists come from the program: the registry of kinds, the group of
commands, ``pyproject.toml`` and the package directories.  The pages are read as text.
"""

from __future__ import annotations

import dataclasses
import importlib
import pkgutil
import re
import tomllib
from pathlib import Path

import pytest

import woundon
from woundon import kinds
from woundon.cli import commands as cli
from woundon.jorkama2001.command import thesis
from woundon.quantities import outputs

ROOT = Path(__file__).parents[2]

PROSE = ("*.md", "docs/**/*.md", "docs/*.py", "docs/_ext/*.py", "examples/**/*.*")

KINDS = [kind for kind in kinds.every() if kind.problem.__module__.startswith("woundon.")]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
# the plug-in of this project is documented too
COMMANDS = {*cli.commands.commands, thesis.name}
MODULES = {
    f"{module.name}/" if module.ispkg else f"{module.name}.py"
    for module in pkgutil.iter_modules(woundon.__path__)
    if not module.name.startswith("__")
}


def page(path: str) -> str:
    return (ROOT / path).read_text("utf-8")


def first_column(path: str, heading: str) -> list[str]:
    """Return the names in code type in the first column of the table with this heading."""
    lines = page(path).splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith(f"| {heading} |"))
    names: list[str] = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        names += re.findall(r"`([^`]+)`", line.split("|")[1])
    return names


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_every_kind_is_documented(kind: kinds.Kind) -> None:
    name = kind.problem.__name__
    assert f"wo.{name}" in page("docs/howto/python.md")
    assert f".{name}\n" in page("docs/reference/problems.md")
    assert f".{kind.result.__name__}\n" in page("docs/reference/results.md")
    assert f"wo.{name}" in page("docs/start/faq.md")


def members_of(name: str) -> set[str]:
    """Return the members of a class that the page of results lists."""
    listed = re.search(
        rf"autoclass:: [\w.]+\.{name}\n((?: {{3}}.*\n)*)", page("docs/reference/results.md")
    )
    assert listed
    return set(re.findall(r"\w+", listed[1].replace(":members:", "")))


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_every_output_of_a_result_is_listed(kind: kinds.Kind) -> None:
    """Fields are listed in the docstring of the class, outputs of its parts at the parts."""
    in_docstring = {field.name for field in dataclasses.fields(kind.result)}
    names = {place.path for place in outputs(kind.result) if "." not in place.path}
    assert not names - in_docstring - members_of(kind.result.__name__) - members_of("Result")


def test_the_command_line_page_lists_the_kinds() -> None:
    listed = first_column("docs/howto/command_line.md", "kind")
    assert sorted(listed) == sorted(kind.name for kind in KINDS)


def test_the_command_line_page_lists_the_commands() -> None:
    listed = first_column("docs/howto/command_line.md", "command")
    assert sorted(listed) == sorted(f"woundon {name}" for name in COMMANDS)


def test_the_installation_page_lists_the_extras() -> None:
    assert sorted(first_column("docs/start/installation.md", "extra")) == sorted(EXTRAS)


def test_the_packages_are_listed() -> None:
    assert sorted(first_column("docs/architecture.md", "package")) == sorted(MODULES)


def test_the_test_folders_are_listed() -> None:
    folders = {f"tests/{found.parent.name}" for found in ROOT.glob("tests/*/test_*.py")}
    assert sorted(first_column("CONTRIBUTING.md", "folder")) == sorted(folders)


def test_the_gallery_header_names_the_cases_of_the_examples() -> None:
    scripts = "\n".join(path.read_text("utf-8") for path in ROOT.glob("examples/*/*.py"))
    used = {kind.problem.__name__ for kind in KINDS if f"wo.{kind.problem.__name__}" in scripts}
    header = page("examples/GALLERY_HEADER.rst")
    assert {name for name in used if f"wo.{name}" not in header} == set()


def test_the_names_that_pages_and_examples_import_exist() -> None:
    """The documentation build executes them too, which takes minutes."""
    for pattern in PROSE:
        for path in ROOT.glob(pattern):
            text = path.read_text("utf-8") if path.suffix in {".md", ".py"} else ""
            for module, names in re.findall(
                r"^ *from (woundon[\w.]*) import ([\w, ]+)$", text, re.M
            ):
                for name in names.replace(" ", "").split(","):
                    found = importlib.import_module(module)
                    assert hasattr(found, name) or importlib.import_module(f"{module}.{name}"), path


WIDEST_CODE_LINE = 100  # characters that a column of the documentation shows without scrolling


def visible_code(text: str) -> list[str]:
    """Return the code lines of a Markdown page that its readers see."""
    lines: list[str] = []
    for kind, block in re.findall(r"^```(\S*).*\n((?:(?!```).*\n)*)```", text, re.M):
        directive = kind.startswith("{") and kind != "{code-cell}"
        hidden = re.match(r":tags: \[(?:remove|hide)-input\]", block)
        if not directive and not hidden:
            lines += block.splitlines()
    return lines


@pytest.mark.parametrize("path", sorted(ROOT.glob("docs/**/*.md")), ids=lambda path: path.stem)
def test_code_fits_into_the_column_of_a_page(path):
    if "_build" in path.parts:
        pytest.skip("built")
    wide = [line for line in visible_code(path.read_text("utf-8")) if len(line) > WIDEST_CODE_LINE]
    assert not wide
