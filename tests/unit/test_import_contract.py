"""The import contract of pyproject.toml, and imports that import-linter does not see.

Evidence: a deliberate violation of each form is detected in a copy of the sources.  import-linter
finds imports at module level, inside functions and for type checking.  Imports through strings and
of public names from the root package, which loads them lazily, are found here.
"""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
USERS_EXTRAS = ("app", "excel", "instruments", "parquet", "dask")
IMPORTERS = {"import_module", "__import__", "find_spec", "load_module"}
MODULE_NAME = r"woundon(\.\w+)+(:[\w.]+)?|\.+\w+(\.\w+)*"


def hidden_imports(folder: Path, pattern: str = "**/*.py") -> Iterator[str]:
    """Yield "file:line: import" for imports through strings and through the root package.

    ``jorkama2001`` is meant to use the root package.
    """
    public = set(re.findall(r"import \w+ as (\w+)", (folder / "__init__.pyi").read_text("utf-8")))
    packages = {path.stem for path in folder.iterdir()}
    for path in sorted(folder.glob(pattern)):
        file = path.relative_to(folder)
        if file == Path("__init__.py"):
            continue  # declares the lazy names
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            place = f"{file.as_posix()}:{getattr(node, 'lineno', 0)}"
            if isinstance(node, ast.Call) and _imports_by_text(node):
                yield f"{place}: through a string"
            elif file.parts[0] != "jorkama2001":
                names = _names_of_root(node, len(file.parts))
                yield from (f"{place}: {n} of the root" for n in names & public - packages)


def _imports_by_text(call: ast.Call) -> bool:
    """Tell whether a call imports a module of woundon, or one that is not known, by its name."""
    name = getattr(call.func, "attr", getattr(call.func, "id", ""))
    if name not in IMPORTERS or not call.args:
        return False
    text = call.args[0]
    if not isinstance(text, ast.Constant):
        return True
    return bool(re.fullmatch(MODULE_NAME, str(text.value)))


def _names_of_root(node: ast.AST, depth: int) -> set[str]:
    """Return the names that a node imports from the root package, or uses of it."""
    if isinstance(node, ast.ImportFrom):
        if (node.module == "woundon" and not node.level) or (
            node.module is None and node.level == depth
        ):
            return {alias.name for alias in node.names}
    elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
        return {node.attr} if node.value.id in ("wo", "woundon") else set()
    return set()


def test_every_imported_package_is_declared() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    extras = project["optional-dependencies"]
    of_extras = [one for name in USERS_EXTRAS for one in extras[name]]
    given = [*project["dependencies"], *of_extras]
    names = [re.split(r"[>=<\[]", one)[0].lower().replace("-", "_") for one in given]
    declared = {name.replace("scikit_fem", "skfem") for name in names}
    imported = {name for path in (ROOT / "src").rglob("*.py") for name in absolute_imports(path)}
    assert imported - {"woundon", *sys.stdlib_module_names} == declared
    assert len(project["dependencies"]) <= 12


def absolute_imports(path: Path) -> Iterator[str]:
    """Yield the packages that a file imports."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name.partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and not node.level:
            yield str(node.module).partition(".")[0]


def test_no_module_is_imported_through_a_string_or_the_root_package() -> None:
    assert list(hidden_imports(ROOT / "src" / "woundon")) == []


@pytest.fixture(scope="module")
def copied(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the sources and of the contract."""
    folder = tmp_path_factory.mktemp("copy")
    ignored = shutil.ignore_patterns("__pycache__", "static", "*.csv")
    shutil.copytree(ROOT / "src" / "woundon", folder / "src" / "woundon", ignore=ignored)
    shutil.copy(ROOT / "pyproject.toml", folder)
    return folder


HIDDEN = {
    "importlib": "from importlib import import_module\nsolve = import_module('woundon.nip.solve')",
    "a relative name": "import importlib as i\nf = lambda: i.import_module('.solve', __package__)",
    "a name that is composed": "def f(name):\n    return __import__('woundon.' + name)",
    "the root package": "from woundon import NipResult",
    "the root package, relative": "def f():\n    from .. import NipResult",
    "an attribute of the root package": "import woundon as wo\nresult = lambda: wo.NipResult",
}


@pytest.mark.parametrize("form", HIDDEN)
def test_a_hidden_import_is_detected(form: str, copied: Path) -> None:
    path = copied / "src" / "woundon" / "elasticity" / "violation.py"
    path.write_text(f"{HIDDEN[form]}\n", "utf-8")
    found = list(hidden_imports(copied / "src" / "woundon", "elasticity/violation.py"))
    path.unlink()
    assert [line.partition(":")[0] for line in found] == ["elasticity/violation.py"]


VISIBLE = {
    "at module level": "from ..nip.solve import solve_nip",
    "inside a function": "def f():\n    from ..nip.solve import solve_nip",
    "for type checking": "from typing import TYPE_CHECKING\n"
    "if TYPE_CHECKING:\n    from ..nip.result import NipResult",
}


@pytest.mark.slow  # 5 s each
@pytest.mark.parametrize("form", [None, *VISIBLE])
def test_the_contract_is_kept_and_a_violation_is_detected(form: str | None, copied: Path) -> None:
    pytest.importorskip("importlinter")
    path = copied / "src" / "woundon" / "elasticity" / "violation.py"
    path.write_text(VISIBLE.get(form, ""), "utf-8")
    command = [sys.executable, "-c", "from importlinter.cli import lint_imports_command as c; c()"]
    run = subprocess.run(
        [*command, "--no-cache"],
        cwd=copied,
        env={"PYTHONPATH": str(copied / "src"), "PATH": ""},
        capture_output=True,
        text=True,
        timeout=120,
    )
    path.unlink()
    assert run.returncode == (0 if form is None else 1), run.stdout + run.stderr
    if form is not None:
        assert "woundon.elasticity.violation -> woundon.nip" in run.stdout
