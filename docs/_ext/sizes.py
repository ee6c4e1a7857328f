"""How large the program is, counted when the pages are built, beside version 0.1."""

from __future__ import annotations

import ast
import io
import tokenize
from collections.abc import Iterable, Iterator
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

SOURCES = Path(__file__).parents[2] / "src"
# files, lines and lines of code of 0.1, counted likewise
_BEFORE = {
    "quantities, kinds, problems": (7, 953, 558),
    "contact, elasticity, solvers, results": (30, 5206, 3163),
    "theories": (1, 403, 170),
    "case files, result files, units": (3, 718, 473),
    "command line, reports, figures": (3, 735, 529),
    "studies": (23, 3695, 2347),
    "the rest": (3, 148, 94),
}
_THESIS_BEFORE = (33, 4041, 2867)
_GROUPS = {
    "quantities, kinds, problems": ("quantities.py", "kinds.py", "arguments.py", "problems"),
    "contact, elasticity, solvers, results": (
        "contact", "elasticity", "two_bodies.py", "results.py", "nip", "rollers", "wrap",
    ),
    "theories": ("theories.py",),
    "case files, result files, units": ("io",),
    "command line, reports, figures": ("cli.py", "solve_command.py", "show"),
    "studies": ("studies",),
}  # fmt: skip
# what 0.1 did not do, by the beginnings of paths
_SINCE = {
    "wound rolls, windings, air": (
        "roll/", "winding/", "air/", "problems/air", "problems/limits", "problems/roll.",
        "problems/schedules", "problems/two_drums", "problems/winding", "problems/wound_roll",
        "design_command", "show/design", "show/margin", "show/winding", "show/wound_roll",
        "studies/derivatives",
    ),
    "layered, hardening and viscoelastic bodies": (
        "elasticity/layers", "elasticity/hardening", "elasticity/ring_elements", "elasticity/lag",
        "elasticity/relaxation", "elasticity/rolling", "losses", "problems/direct",
        "problems/graded", "problems/radial_laws", "problems/stack", "problems/viscoelastic",
    ),
    "the page, reports in HTML": ("app/", "show/html", "show/report_file"),
    "six digits, and speed": (
        "contact/elements", "contact/joint", "contact/follow", "contact/action", "contact/told",
        "nip/layout", "nip/borders", "nip/laws", "threads",
    ),
    "damaged files, shared folders, workbooks, units of one's own": (
        "io/seals", "io/sheets", "io/chosen_units", "io/results_0_1", "io/columns", "studies/lock",
        "studies/processes", "studies/schedule", "studies/study_texts",
    ),
    "sensitivities of wrapped nips": ("wrap/sensitivity",),
}  # fmt: skip
_NONE = (0, 0, 0)
_NO_CODE = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT,
    tokenize.ENDMARKER,
}  # fmt: skip


def _code_lines(text: str) -> int:
    """Return how many lines hold code: neither docstring, comment nor blank."""
    told: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        documented = isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
        if documented and ast.get_docstring(node, clean=False) is not None:
            told.update(range(node.body[0].lineno, node.body[0].end_lineno + 1))
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    held = {line for token in tokens if token.type not in _NO_CODE
            for line in range(token.start[0], token.end[0] + 1)}  # fmt: skip
    return len(held - told)


def _counted(files: Iterable[Path]) -> tuple[int, int, int]:
    texts = [path.read_text("utf-8") for path in files]
    return len(texts), sum(t.count("\n") for t in texts), sum(map(_code_lines, texts))


def _rows() -> Iterator[tuple[str, tuple[int, ...], tuple[int, ...]]]:
    package = SOURCES / "woundon"
    every = set(package.rglob("*.py"))
    left, apart = set(every), {}
    for name, beginnings in _SINCE.items():
        own = {p for p in left if p.relative_to(package).as_posix().startswith(beginnings)}
        left -= own
        apart[name] = _counted(own)
    same = _counted(left)
    for name, parts in _GROUPS.items():
        own = {path for path in left if path.relative_to(package).parts[0] in parts}
        left -= own
        yield name, _BEFORE[name], _counted(own)
    yield "the rest", _BEFORE["the rest"], _counted(left)
    total = tuple(sum(column) for column in zip(*_BEFORE.values(), strict=True))
    yield "**the work of 0.1**", total, same
    for name, counts in apart.items():
        yield name, _NONE, counts
    yield "**core and studies**", total, _counted(every)
    thesis = _counted((SOURCES / "jorkama2001").rglob("*.py"))
    yield "reproduction of the thesis", _THESIS_BEFORE, thesis


class Sizes(SphinxDirective):
    """``{sizes}``: files, lines and lines of code of 0.1 and of this version."""

    def run(self) -> list[nodes.Node]:
        self.env.note_reread()
        lines = ["| | files | lines | of code | files | lines | of code |",
                 "| --- | --: | --: | --: | --: | --: | --: |",
                 "| | *0.1* | | | *now* | | |"]  # fmt: skip
        for name, before, now in _rows():
            lines.append(f"| {name} | " + " | ".join(f"{n:d}" for n in (*before, *now)) + " |")
        return self.parse_text_to_nodes("\n".join(lines))


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("sizes", Sizes)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
