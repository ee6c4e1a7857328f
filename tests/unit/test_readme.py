"""The README states what the program prints: its Python block and its command are run and compared.

After a change of the program, ``python tests/unit/test_readme.py`` updates answers and picture.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import woundon

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
COMMAND = "./run solve examples/newsprint_table2.toml"
PICTURE = "docs/_static/nip_newsprint.png"


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)


def same_on_any_machine(text: str) -> str:
    """Strip what rounding on another processor may change: effort and the size of a residual."""
    text = re.sub(r"\d+ linear systems", "N linear systems", text)
    text = re.sub(r"residual .*", "residual R", text)
    return "\n".join(line.rstrip() for line in text.strip().splitlines())


def answer_in_python() -> str:
    said = io.StringIO()
    with contextlib.redirect_stdout(said):
        exec(compile(blocks("python")[0], "README.md", "exec"), {})
    return said.getvalue()


def answer_on_the_command_line(*more: str) -> str:
    command = [sys.executable, "-m", "woundon", *COMMAND.split()[1:], *more]
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join(sys.path),
        "PYTHONIOENCODING": "utf-8",
    }
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, check=True)
    return done.stdout.decode("utf-8")


def test_python_block_prints_what_the_readme_says():
    assert same_on_any_machine(answer_in_python()) == same_on_any_machine(blocks("text")[0])


def start_of_report(answer: str) -> str:
    """Return the first line of a report and its section of results; "..." for those between."""
    first, _, results = answer.split("\n\n")[:3]
    return f"{first.splitlines()[0]}\n...\n\n{results}\n"


def test_command_prints_what_the_readme_says():
    assert f"\n{COMMAND}\n" in README
    report = start_of_report(answer_on_the_command_line())
    assert same_on_any_machine(report) == same_on_any_machine(blocks("text")[1])


def test_pictures_and_files_that_the_readme_names_exist():
    pattern = r'\]\((\S+?)\)|src="(\S+?)"|`((?:docs|tests|examples)/\S*?|[A-Z]+\.(?:md|cff))`'
    paths = ["".join(found) for found in re.findall(pattern, README)]
    assert PICTURE in paths
    assert [path for path in paths if not (ROOT / path).exists()] == []


def test_the_citation_names_the_version_of_the_program():
    said = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert re.findall(r"^version: (\S+)$", said, re.MULTILINE) == [woundon.__version__]


def renew() -> None:
    report = start_of_report(answer_on_the_command_line("--plot", PICTURE))
    answers = iter([answer_in_python(), report])

    def renewed(_: re.Match[str]) -> str:
        lines = [line.rstrip() for line in next(answers).strip("\n").splitlines()]
        return "\n".join(["```text", *lines, "```"])

    text = re.sub(r"^```text\n.*?^```$", renewed, README, flags=re.MULTILINE | re.DOTALL)
    (ROOT / "README.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    renew()
