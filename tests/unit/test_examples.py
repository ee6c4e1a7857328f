"""Examples: each asks a question, answers it in its text, and checks the answer when it is run.

They are run when the documentation is built.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*/*.py"))


def test_there_are_examples():
    assert len(EXAMPLES) >= 12


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_has_a_question_and_an_answer_that_is_checked(path):
    source = path.read_text(encoding="utf-8")
    tree = ast.parse(source)
    title, _, text = (ast.get_docstring(tree) or "").partition("\n")
    assert title.endswith("?")
    assert "**Answer:**" in text
    checks = source.partition("# sphinx_gallery_start_ignore")[2]
    assert "assert " in checks, "the answer is not checked"
    assert "plt." in source, "there is no picture"
