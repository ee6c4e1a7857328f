"""What the mutation test (mutants.py) does inside pytest, each in a process of its own.

    python benchmarks/mutant_tests.py reach request.json    which test executes which line
    python benchmarks/mutant_tests.py run request.json      chosen tests, the fastest first

Both are called in the folder of a copy of the project, with the sources meant first in PYTHONPATH,
and report as lines of JSON on the standard output; what pytest prints goes to the standard error.
"""

from __future__ import annotations

import importlib
import json
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TextIO

import pytest


class Reach:
    """Tells for every passed test its seconds and the lines that it executes.

    So that neither depends on the tests before, all of the package is imported first, and what its
    functions (and those of the test's file) remember is forgotten before every test.  What a
    fixture of several tests executes counts for each of them.  Child processes are not seen.
    """

    def __init__(self, request: dict[str, Any], events: TextIO) -> None:
        from coverage import Coverage

        self.events, self.package = events, request["package"]
        self.coverage = Coverage(
            data_file=None, include=request["include"], config_file=False, messages=False
        )
        self.seconds: dict[str, float] = {}
        self.passed: dict[str, bool] = {}
        self.fixtures: dict[str, set[str]] = {}
        self.context = ""

    def pytest_sessionstart(self) -> None:
        self.coverage.start()
        root = Path(str(importlib.import_module(self.package).__file__)).parent
        for file in sorted(root.rglob("*.py")):
            if not file.stem.startswith("__"):
                parts = file.relative_to(root.parent).with_suffix("").parts
                importlib.import_module(".".join(parts))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        self._forget(item)
        shared = getattr(item, "_fixtureinfo").name2fixturedefs.values()  # noqa: B009
        last = [definitions[-1] for definitions in shared]
        self.fixtures[_name(item)] = {_key(d) for d in last if d.scope != "function"}
        self._switch(_name(item))
        yield
        self._switch("")

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Iterator[object]:
        before = self.context
        if fixturedef.scope != "function":
            self._switch(_key(fixturedef))
        result = yield
        self._switch(before)
        return result

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        name = _name(report)
        self.seconds[name] = self.seconds.get(name, 0.0) + report.duration
        self.passed[name] = self.passed.get(name, True) and report.passed

    def pytest_sessionfinish(self) -> None:
        self.coverage.stop()
        data, lines = self.coverage.get_data(), {}
        for file in sorted(data.measured_files()):
            for line, contexts in data.contexts_by_lineno(file).items():
                for context in contexts:
                    lines.setdefault(context, {}).setdefault(os.path.relpath(file), []).append(line)
        for name, passed in self.passed.items():
            parts = [lines.get(key, {}) for key in (name, *self.fixtures[name])]
            files = {file for part in parts for file in part}
            reached = {f: sorted({n for part in parts for n in part.get(f, ())}) for f in files}
            seconds = round(self.seconds[name], 4)
            _tell(self.events, test=name, passed=passed, seconds=seconds, lines=reached)

    def _switch(self, context: str) -> None:
        self.context = context
        self.coverage.switch_context(context)

    def _forget(self, item: pytest.Item) -> None:
        modules = [m for name, m in sys.modules.items() if name.split(".")[0] == self.package]
        for module in [*modules, getattr(item, "module", None)]:
            for thing in list(vars(module).values()) if module else ():
                if callable(getattr(thing, "cache_clear", None)):
                    thing.cache_clear()


class Run:
    """Runs chosen tests in a given order until the first fails, telling what it does."""

    def __init__(self, request: dict[str, Any], events: TextIO) -> None:
        self.events, self.sources = events, request["sources"]
        self.package = request["package"]
        self.order = {name: k for k, name in enumerate(request["tests"])}

    @pytest.hookimpl(trylast=True)
    def pytest_configure(self) -> None:
        from hypothesis import Phase, settings

        module = importlib.import_module(self.package)
        if not Path(str(module.__file__)).is_relative_to(self.sources):
            raise pytest.UsageError(f"{self.package} is not that of {self.sources}")
        # one failing example is enough: the smallest one is of no interest, and takes long to find
        quick = settings(phases=(Phase.explicit, Phase.generate))
        settings.register_profile("first failure", quick)
        settings.load_profile("first failure")

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Keep the chosen tests, in their order; those that share a fixture stay together."""
        chosen = [item for item in items if _name(item) in self.order]
        chosen.sort(key=lambda item: self.order[_name(item)])
        first: dict[object, int] = {}
        for k, item in enumerate(chosen):
            first.setdefault(_block(item), k)
        items[:] = sorted(chosen, key=lambda item: first[_block(item)])
        _tell(self.events, collected=len(items))

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            _tell(self.events, failed=f"import of {_name(report)}", why=_last_line(report))

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        _tell(self.events, test=_name(item))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            _tell(self.events, failed=_name(report), why=_last_line(report))

    def pytest_sessionfinish(self, exitstatus: int) -> None:
        _tell(self.events, finished=int(exitstatus))


def _name(test: pytest.Item | pytest.CollectReport | pytest.TestReport) -> str:
    """Return a test's name, without the addresses of objects in it: they change from run to run."""
    return re.sub(r"\b0x[0-9a-f]+", "0x", test.nodeid)


def _key(fixture: Any) -> str:
    return f"fixture {fixture.baseid}::{fixture.argname}"


def _block(item: pytest.Item) -> object:
    """Return what tests have in common that must not be torn apart: a costly fixture's file."""
    definitions = getattr(item, "_fixtureinfo").name2fixturedefs.values()  # noqa: B009
    scopes = {d[-1].scope for d in definitions if d[-1].baseid.endswith(".py")}
    return item.nodeid.split("::")[0] if scopes - {"function"} else _name(item)


def _last_line(report: pytest.CollectReport | pytest.TestReport) -> str:
    """Return the error in a line."""
    crash = getattr(report.longrepr, "reprcrash", None)
    text = crash.message if crash else str(report.longrepr).strip().rpartition("\n")[2]
    return text.strip().partition("\n")[0][:200]


def _tell(events: TextIO, **event: object) -> None:
    print(json.dumps(event), file=events, flush=True)


def main() -> int:
    task, request = sys.argv[1], json.loads(Path(sys.argv[2]).read_text(encoding="utf-8"))
    events = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    options = ["-q", "--rootdir=.", "-p", "no:cacheprovider", "--tb=short"]
    if task == "run":
        options.append("-x")
    plugin = {"reach": Reach, "run": Run}[task](request, events)
    return int(pytest.main([*options, *request["arguments"]], plugins=[plugin]))


if __name__ == "__main__":
    sys.exit(main())
