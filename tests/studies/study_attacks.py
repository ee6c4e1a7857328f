"""Attacks on studies: damaged files, kill -9, Ctrl-C, two processes on one folder, full disks.

    python tests/studies/study_attacks.py --cases 500 --seed 0    prints how the trials ended

damaged    one to three faults are put into the file of a finished study: bytes are changed,
           overwritten or cut off, rows or tables edited, exchanged, deleted or taken from another
           study, the file is replaced by something else, or a journal is put next to it.  Resumed,
           it is rejected in one line and left as it is, or its table is bit for bit what it was.
killed     `woundon sweep`, with one worker or two, is killed (kill -9) at a random moment, and so
           is every second resume; resumed once more, its table is compared.
together   the same with two processes on one folder; every second pair is not killed.
stopped    Ctrl-C at a random moment, soon a second one: no process is left.
full       the same on a file system of random size, which is then made larger (a tmpfs where it may
           be mounted, and in every second trial a limit on the size of files).

The seed determines the trial.  A trial returns how it ended, or raises an exception.
"""

from __future__ import annotations

import argparse
import faulthandler
import multiprocessing
import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from shutil import rmtree
from tempfile import mkdtemp
from typing import Any

import numpy as np
from study_models import stored

import woundon as wo
from woundon.cli import commands as cli
from woundon.quantities import Quantity, pure
from woundon.studies.cases import make_cases
from woundon.studies.model import Answer
from woundon.studies.run import Table, Workers, run_study
from woundon.studies.store import FILE

# ---- damage: a model that answers at once -------------------------------------------------------


@dataclass(frozen=True)
class Wave:
    """y = sin a + slope b; fails at some a, warns at others."""

    slope: float = 1.0
    outputs: tuple[str, ...] = ("y", "z")

    def run(self, inputs: Mapping[str, Any], start: Any | None) -> Answer:
        a, b = inputs["a"], inputs["b"]
        if a == 3:
            raise ZeroDivisionError("a is 3")
        warning = "a is large" if a > 7 else ""
        return Answer((float(np.sin(a)) + self.slope * b, a / 3), warning, None)

    def quantity(self, name: str) -> Quantity | None:
        return None if name == "word" else pure(name, name)

    def record(self) -> dict[str, Any]:
        return {"slope": self.slope}


CASES = make_cases({"a": range(10), "b": [0.1, 0.7], "word": ["one", "two"]})


def table_of(out: Path | None, slope: float = 1.0, **how: Any) -> Table:
    return run_study(Wave(slope), CASES, Workers(1), out=out, chunk=4, **how)


def same(one: Table, other: Table) -> bool:
    """Return whether two tables are equal to the last bit."""
    numbers = all(
        one.outputs[name].tobytes() == other.outputs[name].tobytes() for name in one.outputs
    )
    texts = (one.failure.tolist(), one.warnings.tolist())
    return numbers and texts == (other.failure.tolist(), other.warnings.tolist())


Fault = Callable[[Path, Path, random.Random], None]  # study, another study, dice


def _file(study: Path) -> Path:
    return study / FILE


def _content(study: Path) -> bytearray:
    """Return the bytes of the file, if it still is one."""
    path = _file(study)
    return bytearray(path.read_bytes() if path.is_file() and not path.is_symlink() else b"nothing")


def _put(path: Path, content: bytes) -> None:
    if path.is_dir() and not path.is_symlink():
        path.rmdir()
    else:
        path.unlink(missing_ok=True)
    path.write_bytes(content)


def _changed(study: Path, *statements: str) -> None:
    """Change rows by another program, where an earlier fault lets it."""
    if not _file(study).is_file() or _file(study).is_symlink():
        return
    with (
        suppress(sqlite3.Error, UnicodeDecodeError),
        closing(sqlite3.connect(_file(study))) as connection,
        connection,
    ):
        for statement in statements:
            connection.execute(statement)


def cut(study: Path, other: Path, dice: random.Random) -> None:
    content = _content(study)
    _put(_file(study), content[: dice.choice([0, 1, 4096, dice.randrange(len(content) + 1)])])


def flipped(study: Path, other: Path, dice: random.Random) -> None:
    content = _content(study)
    for _ in range(dice.choice([1, 1, 8, 100])):
        if content:
            content[dice.randrange(len(content))] ^= 1 << dice.randrange(8)
    _put(_file(study), content)


def header(study: Path, other: Path, dice: random.Random) -> None:
    """Change a byte of the header of the file or of a page."""
    content = _content(study)
    for _ in range(dice.choice([1, 3])):
        place = dice.choice([0, 4096, 8192, 12288]) + dice.randrange(100)
        if place < len(content):
            content[place] = dice.choice([0, 1, 2, 255, dice.randrange(256)])
    _put(_file(study), content)


def overwritten(study: Path, other: Path, dice: random.Random) -> None:
    content = dice.choice([b"", b"SQLite format 3\0", b"null", b"[" * 20_000, bytes(8192)])
    _put(_file(study), content or dice.randbytes(dice.randrange(5000)))


def pages(study: Path, other: Path, dice: random.Random) -> None:
    """Blank a page, or exchange two."""
    content = _content(study)
    one, two = (4096 * dice.randrange(len(content) // 4096 + 1) for _ in range(2))
    first, second = content[one : one + 4096], content[two : two + 4096]
    content[one : one + 4096] = second if one != two else bytes(len(first))
    if one != two:
        content[two : two + 4096] = first
    _put(_file(study), content)


def swapped(study: Path, other: Path, dice: random.Random) -> None:
    """Exchange the numbers of two chunks."""
    one, two = dice.randrange(10), dice.randrange(10)
    swap = f"CASE number WHEN {one} THEN -{two} - 1 WHEN {two} THEN -{one} - 1 ELSE number END"
    _changed(study, f"UPDATE chunk SET number = {swap}",
             "UPDATE chunk SET number = -number - 1 WHERE number < 0")  # fmt: skip


def foreign(study: Path, other: Path, dice: random.Random) -> None:
    """Take a chunk or the record of another study of the same cases, or its whole file."""
    number = dice.randrange(10)
    rows = [
        f"INSERT OR REPLACE INTO chunk SELECT * FROM other.chunk WHERE number = {number}",
        "INSERT INTO study SELECT * FROM other.study",
        "UPDATE study SET record = (SELECT record FROM other.study)",
    ]
    chosen = dice.choice([*rows, ""])
    if chosen:
        _changed(study, f"ATTACH '{_file(other)}' AS other", chosen)
    else:
        _put(_file(study), _file(other).read_bytes())


def edited(study: Path, other: Path, dice: random.Random) -> None:
    """Change what a row holds."""
    number = dice.randrange(10)
    column = dice.choice(["outputs", "failure", "warnings", "sha256", "number"])
    value = dice.choice([
        "NULL", "7", "-7", "0.5", "''", "'[]'", "x'ff'", "zeroblob(64)", "zeroblob(0)",
        f"(SELECT {column} FROM chunk WHERE number = {dice.randrange(10)})",
    ])  # fmt: skip
    _changed(study, f"UPDATE OR REPLACE chunk SET {column} = {value} WHERE number = {number}")


def record_edited(study: Path, other: Path, dice: random.Random) -> None:
    _changed(study, dice.choice([
        "UPDATE study SET record = '{}'", "UPDATE study SET record = NULL", "DELETE FROM study",
        "INSERT INTO study SELECT * FROM study",
        "UPDATE study SET record = replace(record, '1', '2')", "DROP TABLE study",
        "ALTER TABLE study ADD COLUMN more TEXT", "ALTER TABLE study RENAME TO studies",
    ]))  # fmt: skip


def missing(study: Path, other: Path, dice: random.Random) -> None:
    _changed(study, dice.choice([
        f"DELETE FROM chunk WHERE number = {dice.randrange(10)}", "DELETE FROM chunk",
        "DROP TABLE chunk", "ALTER TABLE chunk DROP COLUMN warnings",
        "CREATE TRIGGER t AFTER INSERT ON chunk BEGIN DELETE FROM chunk; END",
    ]))  # fmt: skip


def tables(study: Path, other: Path, dice: random.Random) -> None:
    """Add a view, an index or a table; replace a table by a view; drop both tables."""
    _changed(study, *dice.choice([
        ("CREATE VIEW more AS SELECT number FROM chunk",),
        ("CREATE INDEX more ON chunk (sha256)",),
        ("CREATE TABLE more (number INTEGER)",),
        ("ALTER TABLE chunk RENAME TO rows", "CREATE VIEW chunk AS SELECT * FROM rows"),
        ("DROP TABLE chunk", "DROP TABLE study"),
        ("DROP TABLE chunk", "DROP TABLE study", "CREATE TABLE notes (text TEXT)", "VACUUM"),
    ]))  # fmt: skip


def no_file(study: Path, other: Path, dice: random.Random) -> None:
    """Put a folder, a pipe, a link to nowhere, to itself or to a device in the file's place."""
    path = _file(study)
    _put(path, b"")
    path.unlink()
    kind = dice.choice(["folder", "pipe", "/dev/zero", "nowhere/at/all", path.name, "nothing"])
    if kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind != "nothing":
        path.symlink_to(kind)


def journal(study: Path, other: Path, dice: random.Random) -> None:
    """Put a journal next to the file: of nothing, of a transaction cut off here or in another."""
    path = study / f"{FILE}-{dice.choice(['journal', 'journal', 'wal', 'shm'])}"
    if dice.random() < 0.3:
        _put(path, dice.randbytes(dice.randrange(5000)))
        return
    source = dice.choice([study, other])
    content, found = bytes(_content(source)), b""
    with (
        suppress(sqlite3.Error, UnicodeDecodeError),
        closing(sqlite3.connect(_file(source))) as connection,
    ):
        connection.execute("PRAGMA cache_size=1")
        connection.execute("BEGIN")
        connection.execute("UPDATE chunk SET outputs = zeroblob(9000)")
        left = source / f"{FILE}-journal"
        found = left.read_bytes() if left.exists() else b""
        if source == study:
            content = bytes(_content(source))  # with a part of the transaction in it
        connection.rollback()
    if source == study:
        _put(_file(study), content)
    _put(path, found[: dice.choice([len(found), dice.randrange(len(found) + 1)])])


FAULTS: tuple[Fault, ...] = (
    cut, flipped, header, overwritten, pages, swapped, foreign, edited, record_edited, missing,
    tables, no_file, journal,
)  # fmt: skip


class Wrong(Exception):
    """Wrong data were accepted, or the rejection is not one line."""


def damaged(seed: int, folder: Path, whole: Undisturbed | None = None) -> str:
    """Damage a study, resume it; return how it ended."""
    dice, study, other = random.Random(seed), folder / "study", folder / "other"
    undamaged = table_of(study)
    table_of(other, slope=2.0)
    faults = [dice.choice(FAULTS) for _ in range(dice.choice([1, 1, 2, 3]))]
    for fault in faults:
        fault(study, other, dice)
    names = " and ".join(fault.__name__ for fault in faults)
    before = bytes(_content(study))
    try:
        resumed = table_of(study, resume=True)
    except (wo.InvalidProblem, OSError) as refusal:
        if "\n" in str(refusal) or str(study) not in str(refusal):
            raise Wrong(f"{names}: rejected without name or in lines: {refusal}") from None
        # SQLite undoes a transaction that a journal describes
        if journal not in faults and bytes(_content(study)) != before:
            raise Wrong(f"{names}: rejected, and the file was changed") from None
        return "rejected in one line, the file is the same"
    if not same(undamaged, resumed):
        raise Wrong(f"{names}: accepted, and the table differs")
    return "accepted, the table is the same"


# ---- kill -9 and full disks: the command, on nips -----------------------------------------------

CASE = """
schema = 1
outputs = ["nip_induced_tension", "half_width"]
[over]
nip_load = { from = "1 kN/m", to = "4 kN/m", count = 60 }
[solver]
nodes = 17
[case]
roll_friction = 0.3
drum_friction = 0.3
nip_load = 2000
winding_force = 0
web_tension = 200
roll_wrap = 0
[case.web]
thickness = "66 um"
material = "newsprint"
[case.roll]
radius = "0.5 m"
material = "newsprint"
[case.drum]
radius = "0.5 m"
"""


HEAVY = [
    "woundon.cli.commands", "woundon.cli.studies", "woundon.studies.study_file",
    "woundon.nip.solve", "woundon.nip.result", "woundon.report.study_plots",
    "woundon.studies.export", "sqlite3", "pandas", "xarray", "matplotlib.backends.backend_agg",
    "rich.progress", "scipy.optimize",
]  # fmt: skip
FORKS = multiprocessing.get_context("forkserver")
FORKS.set_forkserver_preload(HEAVY)  # imported once, not in every trial


class Command:
    """``woundon sweep`` in a process and a group of its own; with ``largest`` no file is larger."""

    def __init__(self, folder: Path, out: Path, workers: int, largest: int = 0) -> None:
        study = folder / "study.toml"
        study.write_text(CASE, encoding="utf-8")
        self.complaints = folder / f"complaints-{time.time_ns()}.txt"
        self.arguments = (
            "sweep", str(study), "--out", str(out), "--chunk", "3", "--export", "csv",
            "--workers", str(workers), "--resume",
        )  # fmt: skip
        self.process: Any = FORKS.Process(
            target=_woundon, args=(self.arguments, self.complaints, largest)
        )
        self.process.start()

    def kill(self) -> None:
        self.process.kill()

    def stacks(self) -> str:
        """Kill it; return where its threads were."""
        os.kill(self.process.pid, signal.SIGUSR1)
        self.ended(1)  # it does not, but writes
        self.kill()
        return self.complaints.read_text("utf-8")

    def interrupt(self) -> None:
        """Press Ctrl-C: a terminal tells the whole group."""
        while not self.ended(0):
            try:
                os.killpg(self.process.pid, signal.SIGINT)
                return
            except ProcessLookupError:  # it has not made its group yet
                time.sleep(0.01)

    def ended(self, patience: float) -> bool:
        self.process.join(patience)
        return self.process.exitcode is not None

    def end(self) -> tuple[int, str]:
        """Wait; return the exit code, and what was complained of, which must be no traceback."""
        if not self.ended(300):
            self.kill()
            raise Wrong("does not end")
        said = self.complaints.read_text("utf-8") if self.complaints.exists() else ""
        if "Traceback" in said:
            raise Wrong(said)
        return self.process.exitcode, said


def _woundon(arguments: Sequence[str], complaints: Path, largest: int) -> None:
    """Run the command line in a process that was made for it."""
    # an interpreter that is interrupted before the program begins is no fault of the program
    signal.signal(signal.SIGINT, lambda *_: os._exit(cli.INTERRUPTED))
    os.setsid()
    for name, descriptor in ((os.devnull, 1), (complaints, 2)):
        os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT), descriptor)
    sys.stdout, sys.stderr = os.fdopen(1, "w"), os.fdopen(2, "w")
    faulthandler.register(signal.SIGUSR1, file=2)
    if largest:
        import resource

        sys.dont_write_bytecode = True  # half of a module would be kept
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest, largest))
    signal.signal(signal.SIGINT, signal.default_int_handler)
    sys.exit(cli.main(arguments))


def _finished(folder: Path, out: Path) -> tuple[bytes, dict[int, bytes]]:
    """Resume the study to its end; return its table, and the outputs of its chunks."""
    before = stored(out)
    code, said = Command(folder, out, workers=1).end()
    if code:
        raise Wrong(f"does not resume: {said}")
    chunks = stored(out)
    if not before.items() <= chunks.items():
        raise Wrong("solved chunks were lost or changed")
    return (out / "study.csv").read_bytes(), chunks


class Undisturbed:
    """The study that every trial is compared with, and how long it takes."""

    def __init__(self, folder: Path) -> None:
        self.content = _finished(folder, folder / "whole")
        began = time.monotonic()  # the first had to import everything
        self.compare(folder, folder / "again")
        self.seconds = time.monotonic() - began

    def moment(self, dice: random.Random) -> None:
        """Wait for a random part of what the study takes; two workers take longer to start."""
        time.sleep(dice.uniform(0, 1.3 * self.seconds))

    def compare(self, folder: Path, out: Path) -> None:
        if _finished(folder, out) != self.content:
            raise Wrong("the table differs")


def killed(seed: int, folder: Path, whole: Undisturbed) -> str:
    dice, out, count = random.Random(seed), folder / "out", 0
    while count == 0 or dice.random() < 0.5:
        command = Command(folder, out, dice.choice([1, 2]))
        whole.moment(dice)
        command.kill()
        command.ended(300)  # a worker that was just starting complains that its parent is gone
        count += 1
    begun = (out / FILE).exists()
    whole.compare(folder, out)
    return "killed before it had a file" if not begun else "killed, resumed, the table is the same"


def together(seed: int, folder: Path, whole: Undisturbed) -> str:
    dice, out = random.Random(seed), folder / "out"
    commands = []
    for _ in range(2):
        commands.append(Command(folder, out, dice.choice([1, 2])))
        time.sleep(dice.choice([0, dice.uniform(0, whole.seconds / 2)]))
    is_killed = dice.random() < 0.5
    if is_killed:
        whole.moment(dice)
        dice.shuffle(commands)
        for command in commands:
            command.kill()
            time.sleep(dice.choice([0, dice.uniform(0, 0.3)]))
    ends = [command.end() for command in commands]
    if not is_killed and any(code for code, _ in ends):
        raise Wrong(f"one of two processes failed: {ends}")
    whole.compare(folder, out)
    return f"{'both killed, resumed' if is_killed else 'both finished'}, the table is the same"


def _empty(group: int, patience: float = 5.0) -> bool:
    """Tell whether all processes of a group have ended, within some time; end those that have not.

    The standard library's tracker of resources ends a moment after the process that it belongs to.
    """
    limit = time.monotonic() + patience
    try:
        while time.monotonic() < limit:
            os.killpg(group, 0)
            time.sleep(0.02)
        os.killpg(group, signal.SIGKILL)
    except ProcessLookupError:
        return True
    return False


def stopped(seed: int, folder: Path, whole: Undisturbed) -> str:
    dice, out = random.Random(seed), folder / "out"
    command, pressed = Command(folder, out, dice.choice([1, 2])), 0
    whole.moment(dice)
    for patience in (dice.choice([0.0, dice.uniform(0, 1)]), 10):
        if not command.ended(0):
            command.interrupt()
            pressed += 1
            command.ended(patience)
    if not command.ended(0):
        raise Wrong(f"two Ctrl-C do not stop it:\n{command.stacks()}")
    if not _empty(command.process.pid):
        raise Wrong("processes were left")
    command.end()
    whole.compare(folder, out)
    times = {0: "finished before", 1: "stopped by one Ctrl-C", 2: "stopped by two"}[pressed]
    return f"{times}, resumed, the table is the same"


def full(seed: int, folder: Path, whole: Undisturbed) -> str:
    dice, disk = random.Random(seed), folder / "disk"
    disk.mkdir()
    size = dice.randrange(4096, 200_000)
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(disk)], capture_output=True
    )
    try:
        is_limited = mounted.returncode != 0 or dice.random() < 0.5
        largest = dice.randrange(1, 30_000) if is_limited else 0
        command = Command(folder, disk / "out", dice.choice([1, 2]), largest)
        if dice.random() < 0.5:
            whole.moment(dice)
            command.kill()
        code, said = command.end()
        ended = "killed" if code == -signal.SIGKILL else "in one line"
        if code == 2 and said.strip().splitlines()[-1].count("error:") != 1:
            raise Wrong(said)
        if mounted.returncode == 0:
            subprocess.run(["mount", "-o", "remount,size=64m", str(disk)], check=True)
        whole.compare(folder, disk / "out")
        if code == 0:
            return "the disk was large enough"
        return f"ended {ended}, resumed, the table is the same"
    finally:
        if mounted.returncode == 0:
            subprocess.run(["umount", "-l", str(disk)], check=True)


# ---- all trials ---------------------------------------------------------------------------------

KINDS: tuple[Callable[[int, Path, Undisturbed], str], ...] = (
    damaged, killed, together, stopped, full,
)  # fmt: skip


def attacked(seed: int, folder: Path, whole: Undisturbed) -> tuple[str, str]:
    """Return the kind of trial of a seed, and how the trial ended."""
    kind = KINDS[seed % len(KINDS)]
    folder.mkdir()
    return kind.__name__, kind(seed, folder, whole)


def main() -> int:
    """Run many trials; print how many of each kind ended in which way, and the seeds of faults."""
    parser = argparse.ArgumentParser(description="Attack studies and print how the trials ended.")
    parser.add_argument("--cases", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0, help="of the first trial")
    given = parser.parse_args()
    place = Path(mkdtemp(prefix="attacks-"))
    whole, ends, faults = Undisturbed(place), Counter[tuple[str, str]](), list[str]()
    # a shell lets jobs in its background ignore Ctrl-C; here it prints the trials so far
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    with suppress(KeyboardInterrupt):
        for seed in range(given.seed, given.seed + given.cases):
            folder = place / str(seed)
            try:
                ends[attacked(seed, folder, whole)] += 1
            except Exception as fault:
                name = KINDS[seed % len(KINDS)].__name__
                ends[name, "FAULT"] += 1
                faults.append(f"{name}, seed {seed}: {type(fault).__name__}: {fault}")
                print(faults[-1], file=sys.stderr, flush=True)
            rmtree(folder, ignore_errors=True)
    for (name, end), count in sorted(ends.items()):
        print(f"{name:<10}{count:>5}  {end}")
    print(f"{ends.total()} trials from seed {given.seed}, {len(faults)} with faults")
    print(*faults, sep="\n")
    rmtree(place, ignore_errors=True)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
