"""The mutation test: what it changes, what it draws, what it makes of the tests' answers."""

from __future__ import annotations

import ast
import shutil
from collections.abc import Iterator
from pathlib import Path

import mutants
import pytest
from mutant_sites import certificate_sites, find_sites
from mutant_table import Mutant, read_table, summary, write_tables
from mutants import Processes, Reached

ROOT = Path(__file__).parents[2]


def faults(expression: str, operator: str, returns: str = "object") -> set[str]:
    """What may stand in place of ``expression``, without the faults of its parts."""
    source = f"def f(x) -> {returns}:\n    return {expression}\n"
    return {
        text.removeprefix("(").removesuffix(")") if text.startswith("(") else text
        for site in find_sites(source)
        for text in site.texts
        if site.operator == operator and site.old(source) == expression
    }


@pytest.mark.parametrize(
    ("operator", "expression", "expected"),
    [
        ("arithmetic", "a + b", {"a - b", "a", "b"}),
        ("arithmetic", "a - b", {"a + b", "a", "-b"}),
        ("arithmetic", "a * b", {"a / b", "a", "b"}),
        ("arithmetic", "a / b", {"a * b", "a"}),
        ("arithmetic", "a ** b", {"a * b", "a"}),
        ("arithmetic", "a @ b", {"b @ a", "-(a @ b)"}),
        ("arithmetic", "a // b", {"-(-a // b)"}),
        ("arithmetic", "a & b", {"a | b", "a", "b"}),
        ("arithmetic", "'text' + b", set()),
        ("sign", "-a", {"a"}),
        ("sign", "~a", {"a"}),
        ("comparison", "a < b", {"a <= b", "a > b"}),
        ("comparison", "a == b", {"a != b"}),
        ("comparison", "a < b <= c", {"a <= b <= c", "a > b <= c", "a < b < c", "a < b > c"}),
        ("comparison", "a is None", {"a is not None"}),
        ("comparison", "a not in b", {"a in b"}),
        ("logic", "a and b", {"a or b", "a", "b"}),
        ("logic", "not a", {"a"}),
        ("number", "3", {"4", "2"}),
        ("number", "0", {"1", "-1"}),
        ("number", "0.5", {"0.0", "2 * 0.5"}),
        ("number", "0.0", {"1.0"}),
        ("number", "1e-10", {"1e-10 * 1000", "1e-10 / 1000"}),
        ("number", "True", {"False"}),
        ("number", "None", set()),
        ("number", "'text'", set()),
        ("number", "f'{1}'", set()),
        ("function", "min(a, b)", {"max(a, b)", "a", "b"}),
        ("function", "np.maximum(a, b)", {"np.minimum(a, b)", "a", "b"}),
        ("function", "np.sin(a)", {"np.cos(a)"}),
        ("function", "abs(a)", {"a"}),
        ("function", "np.where(a > 0, b, c)", {"np.where(a > 0, c, b)"}),
        ("function", "np.max(a, axis=0)", {"np.min(a, axis=0)", "np.max(a)"}),
        ("function", "own(a, b, word=0)", set()),
        ("function", "[a, b]", {"[b, a]"}),
        ("function", "[a, b[0]]", set()),
        ("slice", "i:j", set()),
    ],
)
def test_the_faults_of_an_expression(operator, expression, expected):
    if operator == "slice":
        source = "x = y[i:j]"
        found = {site.old(source): set(site.texts) for site in find_sites(source)}
        assert found == {"i": {"(i + 1)", "(i - 1)"}, "j": {"(j + 1)", "(j - 1)"},
                         "i:j": {":j", "i:"}}  # fmt: skip
    else:
        assert faults(expression, operator) == expected


@pytest.mark.parametrize(
    ("returns", "expected"),
    [
        ("float", {"-g(x)", "0 * g(x)"}),
        ("np.ndarray | None", {"-g(x)", "0 * g(x)", "None"}),
        ("bool", {"not g(x)"}),
        ("str", set()),
    ],
)
def test_the_faults_of_what_is_returned(returns, expected):
    assert faults("g(x)", "return", returns) == expected


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("a += b", {"a -= b", "pass"}),
        ("a **= b", {"a *= b", "pass"}),
        ("check(a)", {"pass"}),
        ("raise ValueError(f'{a + 1} is more than {2}')", {"pass"}),
        ("'''A docstring, 1 + 1.'''", set()),
        ("import a", set()),
        ("__all__ = ['a', 'b']", set()),
        ("a: Annotated[float, 1]", set()),
        ("warn('too small', Warning, 2)", {"pass"}),
    ],
)
def test_the_faults_of_a_statement(statement, expected):
    source = f"def f():\n    {statement}\n"
    found = {text for site in find_sites(source) for text in site.texts}
    assert found == expected


def test_conditions_are_turned_round():
    source = "while a:\n    x = 0 if b else 0\nif c > 0:\n    pass\nelif d():\n    break\n"
    found = {text for site in find_sites(source) for text in site.texts}
    assert {"(not a)", "(not b)", "(c >= 0)", "(not d())", "continue"} <= found
    assert "(not c > 0)" not in found  # c < 0 and c >= 0 say more


def test_types_only_read_by_checkers_are_left_alone():
    assert not find_sites("if TYPE_CHECKING:\n    A = max(1, 2)\n@cache(maxsize=3)\ndef f(): ...\n")


def test_a_place_is_reached_by_its_statement_its_function_or_its_file():
    source = (
        "LIMIT = 1\n"
        "class A:\n"
        "    field: int = 2\n"
        "    def f(self, n=3):\n"
        "        if n > 4:\n"
        "            return g(\n"
        "                5)\n"
        "        x = 6\n"
    )
    reach = {site.old(source): site.reach for site in find_sites(source)}
    assert {number: reach[number] for number in "123456"} == {
        "1": (1, 8), "2": (1, 8), "3": (5, 8), "4": (5, 5), "5": (6, 7), "6": (8, 8),
    }  # fmt: skip


@pytest.mark.slow
def test_every_fault_of_a_solver_is_another_program():
    source = (ROOT / "src" / "woundon" / "contact" / "newton.py").read_text(encoding="utf-8")
    sites, original = find_sites(source), ast.dump(ast.parse(source))
    assert len(sites) > 150
    for site in sites[::9]:
        for text in site.texts:
            assert ast.dump(ast.parse(site.applied(source, text))) != original


def test_places_are_counted_in_bytes():
    source = "name = 'ν±'; x = 1 + y\n"
    [site] = [site for site in find_sites(source) if site.operator == "arithmetic"]
    assert site.old(source) == "1 + y"
    assert site.applied(source, "y") == "name = 'ν±'; x = y\n"


def test_a_certificate_is_made_blind_law_by_law():
    source = "r = Residuals(\n    stick=a / b,\n    load=abs(c),\n)\n"
    changed = [
        ast.unparse(ast.parse(site.applied(source, site.texts[0])))
        for site in certificate_sites(source, r"Laws|\w*Residuals")
    ]
    assert changed == [
        "r = Residuals(stick=0.0, load=abs(c))",
        "r = Residuals(stick=a / b, load=0.0)",
        "r = Residuals(stick=0.0, load=0.0)",
    ]
    assert not certificate_sites(source, "Laws")


SOURCES = {"src/woundon/a.py": "def f(x):\n    return x + 1\n\ndef g(x):\n    return x - 2\n"}
REACH = {
    "t.py::slow": Reached(9.0, {"src/woundon/a.py": frozenset({2, 5})}),
    "t.py::fast": Reached(0.5, {"src/woundon/a.py": frozenset({2})}),
    "u.py::other": Reached(0.1, {}),
}


def test_only_places_that_a_test_reaches_are_drawn_and_the_seed_decides():
    reach = {"t.py::fast": REACH["t.py::fast"]}
    drawn = mutants.draw(SOURCES, reach, 50, seed=1)
    assert [m.line for m in drawn] == [2, 2]  # the sum and the number, each once
    assert drawn == mutants.draw(SOURCES, reach, 50, seed=1)
    draws = [mutants.draw(SOURCES, REACH, 1, seed)[0] for seed in range(20)]
    assert {m.line for m in draws} == {2, 5}


def test_the_fastest_tests_run_first_within_the_limit():
    [mutant] = [m for m in mutants.draw(SOURCES, REACH, 9, 1) if m.line == 2 and m.old == "1"]
    tests = mutants.reaching(mutant, REACH)
    assert tests == ["t.py::fast", "t.py::slow"]
    assert mutants.within(tests, REACH, 20.0) == (tests, "")
    assert mutants.within(tests, REACH, 5.0) == (tests[:1], "the fastest 1 of 2 tests")
    assert mutants.patience(REACH)["t.py::fast"] == 3 * 9.0 + 30


@pytest.mark.parametrize(
    ("events", "status", "by"),
    [
        ([{"collected": 2}, {"test": "a"}, {"test": "b"}, {"finished": 0}, {"ended": 0}],
         "survived", ""),
        ([{"collected": 2}, {"test": "a"}, {"failed": "a", "why": "assert 0"}], "killed", "a"),
        ([{"failed": "import of t.py", "why": "NameError"}], "killed", "import of t.py"),
        ([{"collected": 2}, {"test": "a"}, {"ended": -11}], "killed", "a"),
        ([{"collected": 2}, {"test": "a"}, {"ended": -9}], "error", ""),
        ([{"collected": 2}, {"test": "a"}, None], "timeout", "a"),
        ([{"ended": 4}], "error", ""),
        ([{"collected": 0}, {"finished": 5}, {"ended": 5}], "error", ""),
    ],
)  # fmt: skip
def test_the_verdict(events, status, by):
    # no time at all is allowed: the first silence is too long
    found = mutants.verdict(events, {"a": -1.0, "b": -1.0}, 2)
    assert (found["status"], found.get("by", "")) == (status, by)


def test_tests_that_are_not_there_are_told():
    events = [{"collected": 1}, {"test": "a"}, {"finished": 0}, {"ended": 0}]
    assert mutants.verdict(events, {"a": 1.0}, 3)["note"] == "2 tests are not there"


def test_a_table_is_read_as_it_was_written(tmp_path: Path):
    rows = [
        Mutant("1", "src/woundon/contact/a.py", 7, "logic", "a |\n b", "a", 1, 2, 7, 8,
               "killed", "t.py::a", "assert, not", 3, 1.5, "note"),
        Mutant("c1", "src/woundon/nip.py", 9, "law stick of Laws", "b", "0.0", 1, 2, 9, 9),
    ]  # fmt: skip
    file = tmp_path / "mutants.csv"
    write_tables(file, "# head", rows)
    assert read_table(file, "# head") == rows
    shown = file.with_suffix(".md").read_text(encoding="utf-8")
    assert "| 1 | contact/a.py:7 | logic | `a \\| b` | `a` | killed by t.py::a (note) |" in shown
    assert summary(rows) == "1 random mutants: 1 killed; 1 certificates made blind: 1 to do"
    with pytest.raises(SystemExit, match=r"another program or another draw"):
        read_table(file, "# other")


@pytest.fixture
def toy(tmp_path: Path) -> Path:
    """A project of one function and three tests, one of which knows only half of it."""
    for name in ("src/woundon", "tests", "benchmarks"):
        (tmp_path / name).mkdir(parents=True)
    source = "from functools import cache\n@cache\ndef double(x):\n    return x + x\n"
    (tmp_path / "src/woundon/__init__.py").write_text("")
    (tmp_path / "src/woundon/a.py").write_text(source)
    (tmp_path / "pyproject.toml").write_text("[tool.pytest.ini_options]\n")
    (tmp_path / "tests/test_a.py").write_text(
        "import pytest\n"
        "from woundon.a import double\n"
        "@pytest.fixture(scope='module')\n"
        "def four(): return double(2)\n"
        "def test_two(): assert double(2) == 4\n"
        "def test_fixture(four): assert four == 4\n"
        "def test_nothing(): assert 1 + 1 == 2\n"
        "def test_zero(): assert double(0) == 0\n"
    )
    shutil.copy(ROOT / "benchmarks" / "mutant_tests.py", tmp_path / "benchmarks")
    return tmp_path


@pytest.fixture
def processes() -> Iterator[Processes]:
    started = Processes()
    yield started
    assert not started.running  # none is left behind


@pytest.mark.slow
def test_tests_are_run_on_the_mutant(toy: Path, tmp_path: Path, processes: Processes):
    source = (toy / "src/woundon/a.py").read_text()
    [site] = find_sites(source)
    place = (site.line(source), site.operator, "x + x", "(x - x)", site.start, site.end)
    mutant = Mutant("1", "src/woundon/a.py", *place, *site.reach)

    def found(*names: str) -> tuple[str, str, int]:
        tests = [f"tests/test_a.py::{name}" for name in names]
        allowed = dict.fromkeys(tests, 60.0)
        done = mutants.tried(mutant, tests, toy, allowed, tmp_path / "log", processes)
        return done.status, done.by, done.tests

    assert found("test_zero", "test_nothing") == ("survived", "", 2)
    assert found("test_zero", "test_two") == ("killed", "tests/test_a.py::test_two", 2)
    assert (toy / "src/woundon/a.py").read_text() == source


@pytest.mark.slow
def test_what_tests_reach_is_measured(toy: Path, tmp_path: Path, processes: Processes):
    pytest.importorskip("coverage")
    files, out = ["src/woundon/a.py"], tmp_path / "out"
    (out / "logs").mkdir(parents=True)
    reach = mutants.measure_reach(toy, files, out, (), processes)
    # what is remembered from a test before is computed anew, and a fixture's lines are its tests'
    names = {name.split("::")[1]: known.lines for name, known in reach.items()}
    executed = {"src/woundon/a.py": frozenset({4})}
    assert names == {
        "test_two": executed, "test_fixture": executed, "test_zero": executed, "test_nothing": {},
    }  # fmt: skip
    store = out / "reach.json"
    before = store.stat().st_mtime_ns
    assert mutants.measure_reach(toy, files, out, (), processes) == reach
    assert store.stat().st_mtime_ns == before  # nothing has changed: nothing is run
