"""The import contract of pyproject.toml, imports that import-linter does not see, and Any.

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
from collections import defaultdict
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


# Signatures between packages whose types a plug-in may supply (docs/architecture.md).
OF_PLUGINS = {
    # equations and problems of a kind with its own contact
    *("System.evaluate", "System.jacobian", "System.fill_half_width_column"),
    *("SemismoothNewton.solve", "refine", "neighbouring_solution"),
    # functions, problems and results of a kind
    *("solve", "NotConverged.__init__"),
    # the value of a field or an output by its name, and the default of a field of any type
    *("get_field", "field_or_none", "value_of", "default"),
    # the options of a figure, and the number or array that a function was given
    *("figure_of", "as_given"),
}


def signatures_with_any(folder: Path) -> Iterator[str]:
    """Yield the names of public functions and methods with Any that another package uses.

    Values by name, ``Mapping[str, Any]`` and ``**options: Any``, do not count: fields of problems,
    options of solvers and contents of files depend on the kind.
    """
    trees = {path: ast.parse(path.read_text("utf-8")) for path in folder.rglob("*.py")}
    packages = {path: path.relative_to(folder).parts[0] for path in trees}
    users: dict[str, set[str]] = defaultdict(set)  # packages that use "module.name" or ".name"
    for path, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.level:
                module = str(node.module).rpartition(".")[2]
                for alias in node.names:
                    users[f"{module}.{alias.name}"].add(packages[path])
            elif isinstance(node, ast.Attribute):
                users[f".{node.attr}"].add(packages[path])
                users[f"{getattr(node.value, 'id', '')}.{node.attr}"].add(packages[path])
    for path, tree in trees.items():
        for name, used_as, function in _public_functions(tree, path.stem):
            if users[used_as] - {packages[path]} and _has_any(function):
                yield name


def _public_functions(
    tree: ast.Module, module: str
) -> Iterator[tuple[str, str, ast.FunctionDef | ast.AsyncFunctionDef]]:
    """Yield name, name by which it is used, and node of public functions and methods.

    Of an overloaded function the overloads, which callers see.
    """
    for owner in tree.body:
        is_class = isinstance(owner, ast.ClassDef)
        functions = [node for node in (owner.body if is_class else tree.body)
                     if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]  # fmt: skip
        overloads = [
            node for node in functions if "overload" in map(ast.unparse, node.decorator_list)
        ]
        overloaded = {node.name for node in overloads}
        for function in functions if is_class else set(functions) & {owner}:
            name = f"{owner.name}.{function.name}" if is_class else function.name
            hidden = any(
                part.startswith("_") for part in name.replace("__init__", "new").split(".")
            )
            if hidden or (function.name in overloaded and function not in overloads):
                continue
            if is_class and function.name != "__init__":
                yield name, f".{function.name}", function
            else:
                yield name, f"{module}.{owner.name}", function


def _has_any(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Tell whether an argument or the returned value is Any, or holds Any, except by name."""
    given = function.args
    arguments = [*given.posonlyargs, *given.args, *given.kwonlyargs, given.vararg]
    hints = [each.annotation for each in arguments if each is not None] + [function.returns]
    by_name = r"(Mapping|dict)\[str, Any\]|Kind\[Any, Any\]"
    texts = (re.sub(by_name, "", ast.unparse(hint)) for hint in hints if hint is not None)
    return any(re.search(r"\bAny\b", text) for text in texts)


def test_any_stands_only_where_a_plug_in_may_supply_the_type() -> None:
    found = set(signatures_with_any(ROOT / "src" / "woundon"))
    assert found == OF_PLUGINS
