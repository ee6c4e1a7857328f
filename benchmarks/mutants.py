"""Do the tests notice a fault?  Random mutants of the solvers, each against the tests it reaches.

    python benchmarks/mutants.py --jobs 2                 80 mutants and every law of a certificate
    python benchmarks/mutants.py --again                  the survivors once more, after new tests
    python benchmarks/mutants.py --rooms contact --count 20 --out out/contact

A mutant is the program with one small fault (mutant_sites.py lists them), drawn at random: every
place in the given rooms (folders or files of the package) that at least one test executes has the
same chance, then each of its faults.  To these come the certificates: the residual of every law
replaced by zero, one law at a time and all at once.

First the tests run once under coverage.py, which tells the tests that execute each line and how
long they take (out/mutants/reach.json; later calls run only test files that have changed).  What
is executed in child processes is not seen, and what a test reads from the cache of a body or
problem that its file keeps is not either: a survivor may yet be killed by a test not run.  Then
the tests run on the program itself (row 0), which must survive; and every mutant gets a copy of the
sources, and its tests run, the fastest first, until one fails:

    killed      a test failed, or could not be imported, or the process died
    timeout     a test took three times what the slowest of its file takes, and half a minute
    survived    none did: a test is missing, or the mutant is equivalent to the program
    error       the tests could not be run, or were stopped; the next call tries again

out/mutants/mutants.csv holds the rows and mutants.md shows them; a call that was stopped goes on
where it was.  The work tree is copied when the call begins and not touched.
"""

from __future__ import annotations

import argparse
import ast
import compileall
import contextlib
import hashlib
import importlib.util
import json
import os
import queue
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from mutant_sites import Site, certificate_sites, find_sites
from mutant_table import Mutant, read_table, summary, write_tables

PROJECT = Path(__file__).resolve().parents[1]
PACKAGE = "woundon"
ROOMS = ("contact", "nip")
CERTIFICATES = r"Laws|\w*Residuals"
# runners start worker processes, whose lines are not seen; what they compute others test
SKIPPED = ("tests/studies/test_runners.py",)
START_UP = 120.0  # seconds until the first test begins
SLACK, TIMES = 30.0, 3.0  # a test may take 3 times its file's slowest, and half a minute
STOPPED = (-signal.SIGKILL, -signal.SIGTERM)  # from outside: says nothing about the mutant

Event = dict[str, Any]


@dataclass(frozen=True)
class Reached:
    """A test: how long it takes, and the lines of each file that it executes."""

    seconds: float
    lines: dict[str, frozenset[int]]


@dataclass
class Processes:
    """The processes that run, each the leader of a group, so that none is left behind."""

    running: set[subprocess.Popen[str]] = field(default_factory=set)

    def events(self, tree: Path, task: str, request: Event, log: Path) -> Iterator[Event | None]:
        """Yield what mutant_tests.py tells; None each second in which it tells nothing."""
        asked = log.with_suffix(".json")
        asked.write_text(json.dumps(request), encoding="utf-8")
        command = [sys.executable, str(tree / "benchmarks" / "mutant_tests.py"), task, str(asked)]
        environment = {
            **os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1",
            "COVERAGE_CORE": "ctrace", "PYTHONPATH": request["sources"],
        }  # fmt: skip
        with log.open("w", encoding="utf-8") as errors:
            process = subprocess.Popen(
                command, cwd=tree, env=environment, text=True, stdout=subprocess.PIPE,
                stderr=errors, start_new_session=True,
            )  # fmt: skip
        self.running.add(process)
        lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        reader = threading.Thread(target=_read, args=(process, lines), daemon=True)
        reader.start()
        try:
            while True:
                try:
                    line = lines.get(timeout=1.0)
                except queue.Empty:
                    yield None
                    continue
                if not line:
                    break
                yield json.loads(line)
            yield {"ended": process.wait()}
        finally:
            self.stop(process)
            reader.join(timeout=10.0)

    def stop(self, process: subprocess.Popen[str]) -> None:
        """End a process and its children."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        self.running.discard(process)


def _read(process: subprocess.Popen[str], lines: queue.SimpleQueue[str]) -> None:
    assert process.stdout is not None
    with process.stdout as told:
        for line in told:
            lines.put(line)
    lines.put("")


# the copy of the project, and what it is known by


def copy_project(target: Path) -> Path:
    """Copy the files of the work tree, compiled, and return where they are."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(command, cwd=PROJECT, check=True, capture_output=True, text=True).stdout
    for name in filter(None, names.split("\0")):
        if (PROJECT / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(PROJECT / name, target / name)
    compileall.compile_dir(target / "src", quiet=2)
    return target.resolve()


def digest(files: Iterable[Path], *more: str) -> str:
    """Return a short digest of files."""
    whole = hashlib.sha256("\0".join(more).encode())
    for file in sorted(files):
        whole.update(file.read_bytes())
    return whole.hexdigest()[:12]


def room_files(tree: Path, rooms: Iterable[str]) -> list[str]:
    """Return the source files of the rooms, relative to the project."""
    found = []
    for room in rooms:
        place = tree / "src" / PACKAGE / room
        files = sorted(place.rglob("*.py")) if place.is_dir() else [place.with_suffix(".py")]
        if not all(file.exists() for file in files):
            sys.exit(f"there is no {room} in the package")
        found.extend(str(file.relative_to(tree)) for file in files)
    return found


# which test reaches which line


def measure_reach(
    tree: Path, files: list[str], out: Path, skip: Iterable[str], processes: Processes
) -> dict[str, Reached]:
    """Return the tests by name; only those of changed files are run again."""
    tests = sorted({*(tree / "tests").rglob("test_*.py")} - {tree / name for name in skip})
    helpers = [*(tree / "tests").rglob("*.py"), *(tree / "benchmarks").glob("*.py")]
    known = digest((tree / "src").rglob("*.py"), *files), digest(set(helpers) - set(tests))
    states = {str(t.relative_to(tree)): f"{digest([t])} {' '.join(known)}" for t in tests}
    store = out / "reach.json"
    kept = json.loads(store.read_text(encoding="utf-8")) if store.exists() else {}
    kept = {t: part for t, part in kept.items() if states.get(t) == part["state"]}
    stale = sorted(set(states) - set(kept))
    if stale:
        print(f"running {len(stale)} test files under coverage.py ...", flush=True)
        for event in _measured(tree, files, stale, out / "logs" / "reach.log", processes):
            file = event["test"].split("::")[0]
            part = kept.setdefault(file, {"state": states[file], "tests": {}})
            part["tests"][event["test"]] = event
        store.write_text(json.dumps(kept), encoding="utf-8")
    events = [event for part in kept.values() for event in part["tests"].values()]
    left_out = sum(not event["passed"] for event in events)
    if left_out:
        print(f"{left_out} tests that failed or were skipped are left out: see logs/reach.log")
    return {
        e["test"]: Reached(e["seconds"], {f: frozenset(n) for f, n in e["lines"].items()})
        for e in events
        if e["passed"]
    }


def _measured(
    tree: Path, files: list[str], tests: list[str], log: Path, processes: Processes
) -> Iterator[Event]:
    request = {
        "package": PACKAGE, "sources": str(tree / "src"), "arguments": tests,
        "include": [str(tree / file) for file in files],
    }  # fmt: skip
    for event in processes.events(tree, "reach", request, log):
        if event and "test" in event:
            yield event
        elif event and event["ended"] not in (0, 1):
            sys.exit(f"the tests could not be run; the reason stands in {log}")


def reaching(mutant: Mutant, reach: dict[str, Reached]) -> list[str]:
    """Return the tests that execute a line of the mutant's statement, the fastest first."""
    lines = range(mutant.first, mutant.last + 1)
    found = [t for t, known in reach.items() if known.lines.get(mutant.file, set()) & {*lines}]
    return sorted(found, key=lambda test: reach[test].seconds)


# drawing


def draw(sources: dict[str, str], reach: dict[str, Reached], count: int, seed: int) -> list[Mutant]:
    """Draw mutants: each place that a test reaches has the same chance, then each of its faults."""
    places = [(file, site) for file, text in sources.items() for site in find_sites(text)]
    rng, drawn = random.Random(seed), []
    rng.shuffle(places)
    for file, site in places:
        if len(drawn) == count:
            break
        new = rng.choice(site.texts)
        mutant = _mutant(str(len(drawn) + 1), file, sources[file], site, new)
        if reaching(mutant, reach) and _differs(sources[file], site.applied(sources[file], new)):
            drawn.append(mutant)
    return drawn


def blind_certificates(sources: dict[str, str], pattern: str) -> list[Mutant]:
    """Return the mutants whose certificates do not see a law, or any."""
    places = [(f, site) for f, text in sources.items() for site in certificate_sites(text, pattern)]
    return [
        _mutant(f"c{k}", file, sources[file], site, site.texts[0])
        for k, (file, site) in enumerate(places, start=1)
    ]


def _mutant(id: str, file: str, source: str, site: Site, new: str) -> Mutant:
    place = site.line(source), site.operator, site.old(source), new, site.start, site.end
    return Mutant(id, file, *place, *site.reach)


def _differs(source: str, changed: str) -> bool:
    return ast.dump(ast.parse(source)) != ast.dump(ast.parse(changed))


# the trial of a mutant


def control(file: str) -> Mutant:
    """Return the program itself as a row: it must survive, or the tests' failures mean nothing."""
    return Mutant("0", file, 1, "none", "", "", 0, 0, 0, 0)


def tried(
    mutant: Mutant, tests: list[str], tree: Path, allowed: dict[str, float], log: Path,
    processes: Processes,
) -> Mutant:  # fmt: skip
    """Return the mutant with what the tests said."""
    if not tests:
        return replace(mutant, status="survived", note="no test executes it")
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        sources = Path(folder).resolve() / "src"
        shutil.copytree(tree / "src", sources)
        file = sources.parent / mutant.file
        file.write_text(mutant.site.applied(file.read_text("utf-8"), mutant.new), "utf-8")
        Path(importlib.util.cache_from_source(str(file))).unlink(missing_ok=True)
        request = {
            "package": PACKAGE, "sources": str(sources), "tests": tests,
            "arguments": sorted({test.split("::")[0] for test in tests}),
        }  # fmt: skip
        events = processes.events(tree, "run", request, log)
        said = verdict(events, allowed, len(tests))
        events.close()
    return replace(mutant, **said, seconds=round(time.perf_counter() - start, 1))


def within(tests: list[str], reach: dict[str, Reached], limit: float) -> tuple[list[str], str]:
    """Return as many tests as fit into the limit of seconds, and a note where some do not."""
    whole, kept = 0.0, []
    for test in tests:
        whole += reach[test].seconds
        if whole > limit and kept:
            return kept, f"the fastest {len(kept)} of {len(tests)} tests"
        kept.append(test)
    return kept, ""


def patience(reach: dict[str, Reached]) -> dict[str, float]:
    """Return the seconds that each test may take: any of a file may set up what they share."""
    slowest: dict[str, float] = {}
    for test, known in reach.items():
        file = test.split("::")[0]
        slowest[file] = max(slowest.get(file, 0.0), known.seconds)
    return {test: TIMES * slowest[test.split("::")[0]] + SLACK for test in reach}


def verdict(events: Iterable[Event | None], allowed: dict[str, float], count: int) -> Event:
    """Return status, by, why, tests and note from what the process tells."""
    test, begun, ran, note = "", 0, 0, ""
    deadline = time.monotonic() + START_UP
    for event in events:
        if event is None:
            if time.monotonic() > deadline:
                return {"status": "timeout", "by": test or "start", "tests": begun, "note": note}
        elif "collected" in event:
            if event["collected"] < count:
                note = f"{count - event['collected']} tests are not there"
        elif "test" in event:
            test, begun = event["test"], begun + 1
            deadline = time.monotonic() + allowed[test]
        elif "failed" in event:
            by = {"by": event["failed"], "why": event["why"]}
            return {"status": "killed", **by, "tests": begun, "note": note}
        elif "finished" in event:
            ran = begun if event["finished"] == 0 else 0
        elif event["ended"] < 0 and event["ended"] not in STOPPED and not ran:
            why = f"the process died of signal {-event['ended']}"
            return {"status": "killed", "by": test, "why": why, "tests": begun, "note": note}
    return {"status": "survived" if ran else "error", "tests": ran, "note": note}


def rows(
    arguments: argparse.Namespace, tree: Path, files: list[str], reach: dict[str, Reached]
) -> tuple[str, list[Mutant]]:
    """Return the table's head and its rows: those of an earlier call, or new ones."""
    drawn = f"{' '.join(arguments.rooms)}, {arguments.count} by seed {arguments.seed}"
    head = f"# sources {digest((tree / 'src').rglob('*.py'))}, {drawn}"
    sources = {file: (tree / file).read_text(encoding="utf-8") for file in files}
    mutants = read_table(arguments.out / "mutants.csv", head) or [
        control(files[0]),
        *draw(sources, reach, arguments.count, arguments.seed),
        *blind_certificates(sources, arguments.certificates),
    ]
    again = {"survived", "error"} if arguments.again else {"error"}
    cleared = [replace(m, status="", by="", why="", tests=0, note="") for m in mutants]
    return head, [c if m.status in again else m for c, m in zip(cleared, mutants, strict=True)]


def run(arguments: argparse.Namespace, folder: Path, processes: Processes) -> list[Mutant]:
    """Run what is left to run and return all rows."""
    out: Path = arguments.out
    (out / "logs").mkdir(parents=True, exist_ok=True)
    tree = copy_project(folder / "tree")
    files = room_files(tree, arguments.rooms)
    reach = measure_reach(tree, files, out, arguments.skip, processes)
    head, mutants = rows(arguments, tree, files, reach)
    allowed, lock = patience(reach), threading.Lock()

    def trial(k: int, tests: list[str], note: str = "") -> None:
        log = out / "logs" / f"{mutants[k].id}.log"
        done = tried(mutants[k], tests, tree, allowed, log, processes)
        with lock:
            mutants[k] = replace(done, note="; ".join(filter(None, [note, done.note])))
            write_tables(out / "mutants.csv", head, mutants)
            print(f"{done.id:>4} {done.place} {done.operator}: {done.status} {done.by} "
                  f"{done.seconds:.0f} s", flush=True)  # fmt: skip

    def trial_of_mutant(k: int) -> None:
        trial(k, *within(reaching(mutants[k], reach), reach, arguments.seconds))

    write_tables(out / "mutants.csv", head, mutants)
    if not mutants[0].status:
        trial(0, sorted((t for t in reach if reach[t].lines), key=lambda t: reach[t].seconds))
    if mutants[0].status != "survived":
        sys.exit(f"the program itself: {mutants[0].status} {mutants[0].by} {mutants[0].why}")
    chosen = [k for k, m in enumerate(mutants) if not m.status]
    if arguments.only is not None:
        chosen = [k for k in chosen if mutants[k].id in arguments.only]
    with ThreadPoolExecutor(arguments.jobs) as pool:
        try:
            list(pool.map(trial_of_mutant, chosen))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in list(processes.running):
                processes.stop(process)
            raise
    return mutants


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    add = parser.add_argument
    add("--rooms", nargs="+", default=ROOMS, help="folders or files of the package")
    add("--count", type=int, default=80, help="random mutants (80)")
    add("--seed", type=int, default=1, help="of the draw (1)")
    add("--jobs", type=int, default=1, help="mutants at once (1)")
    add("--seconds", type=float, default=900.0, help="of tests for a mutant, at most (900)")
    add("--skip", nargs="*", default=SKIPPED, help=f"test files left out ({' '.join(SKIPPED)})")
    add("--certificates", default=CERTIFICATES, help="pattern of the classes of residuals")
    add("--only", nargs="*", help="ids: run these alone; without any, only draw")
    add("--again", action="store_true", help="run those that survived once more")
    add(
        "--out",
        type=lambda text: Path(text).resolve(),
        default=PROJECT / "out" / "mutants",
        help="folder (out/mutants)",
    )
    arguments = parser.parse_args()
    # as Ctrl-C: what has been started must be ended
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    with tempfile.TemporaryDirectory() as folder:
        mutants = run(arguments, Path(folder), Processes())
    print(summary(mutants))
    print(f"{arguments.out / 'mutants.md'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
