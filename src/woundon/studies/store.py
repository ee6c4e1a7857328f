"""A study on disk: Parquet parts written as they finish, and a manifest that guards the design.

    DIR/manifest.json                            what is studied; its hash
    DIR/parts/000042-0123456789abcdef.parquet    the rows of chunk 42; its seal
    DIR/set_aside/                               what was damaged, or of another study

A part takes its name when its content is on disk: whatever stops the program, even kill -9 or a
loss of power, only the chunks being solved are lost.  The seal is a hash of the study, of the
chunk's number, cases and inputs, and of the part's bytes.  A part that is cut, edited, exchanged
with another or comes from another study does not meet it; it is set aside, and its chunk is
solved again.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from glob import escape
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InvalidProblem
from ..io.files import read_whole, write_whole
from .design import Design
from .evaluate import Block
from .lock import HIDDEN, locked

__all__ = ["Store", "opened", "write_parquet"]

FORMAT = "woundon-study"
SCHEMA = 2
LARGEST = 1_000_000_000  # bytes of a manifest or part; usually some thousands
PROGRAM = {"version", "sources"}  # what a study records of the program that solves it
GOES_ON = "what is written stays valid, resume goes on from there"


@contextmanager
def opened(
    folder: str | Path, design: Design, chunks: Sequence[np.ndarray], outputs: tuple[str, ...],
    record: Mapping[str, Any], *, resume: bool,
) -> Iterator[Store]:  # fmt: skip
    """Provide the folder of a study, which no other process may work in meanwhile.

    Parameters
    ----------
    folder : path
    design : Design
    chunks : sequence of int arrays
        Its cases by chunk.
    outputs : tuple of str
    record : mapping
        What else the numbers depend on.
    resume : bool
        Go on with what the folder holds; without it, it must hold no study.

    Raises
    ------
    InvalidProblem
        If the folder holds a study and ``resume`` is not asked for, or another study than this, or
        another process is at work in it.
    OSError
        If it cannot be written.
    """
    store = Store(Path(folder), design, chunks, outputs, record)
    store.check(resume)  # before anything is written to it
    if resume and store.is_complete():
        yield store  # nothing is written, since the folder may be on a read-only medium
        return
    store.folder.mkdir(parents=True, exist_ok=True)
    with locked(store.folder) as died:
        store.check(resume)  # another process may have been faster
        if died:
            store.told.append(f"{folder}: {died}")
        store.prepare()
        yield store


class Store:
    """The folder of a study; see :func:`opened`.

    Attributes
    ----------
    kept : dict of int to Path
        The parts that this study has written, by chunk.
    told : list of str
        What the user should know of the folder.
    """

    def __init__(
        self, folder: Path, design: Design, chunks: Sequence[np.ndarray], outputs: tuple[str, ...],
        record: Mapping[str, Any],
    ) -> None:  # fmt: skip
        self.folder, self.parts, self.manifest = folder, folder / "parts", folder / "manifest.json"
        self.design, self.chunks, self.outputs = design, chunks, outputs
        self.study = {"design": design.record(), "outputs": list(outputs), **record}
        self.digest = _digest(self.study)
        self.kept, self.told = dict[int, Path](), list[str]()

    # ---- whose folder it is ---------------------------------------------------------------------

    def check(self, resume: bool) -> None:
        """Refuse the folder unless it is new, or holds this study and that is to go on."""
        where = str(self.folder)
        if not self.folder.is_dir() or not self._used():
            return
        if self.manifest.exists() and not resume:
            text = "holds a study already; resume it, or take another folder"
            raise InvalidProblem.at(where, text)
        there = _read_manifest(self.manifest)
        if there is None:
            # what is known of the study is in the seals too
            if resume and any(self._is_own(path) for path in self._found()):
                return
            text = "is not empty and holds no study"
            if self.manifest.exists():
                text = "its manifest.json is damaged, and none of its parts is of this study"
            raise InvalidProblem.at(where, text)
        if (there.pop("format"), there.pop("schema")) != (FORMAT, SCHEMA):
            text = "its manifest.json is not that of a study of this version"
            raise InvalidProblem.at(where, text)
        if _digest(there) != self.digest:
            here = json.loads(json.dumps(self.study))
            differs = [name for name in here if there.get(name) != here[name]]
            text = f"holds another study than this: {', '.join(differs)} differs"
            if set(differs) <= PROGRAM:
                text = (
                    f"was solved by another program: {_program(there)}, this is "
                    f"{_program(here)}; the numbers of two programs are not mixed: solve the "
                    "study in another folder, or resume it by the program that began it"
                )
            raise InvalidProblem.at(where, text)

    def _used(self) -> bool:
        """Tell whether there is more than a process leaves that was killed at its first steps."""
        own = {*HIDDEN, "parts"}
        return any(self._found()) or any(
            path.name not in own and not path.name.startswith((".manifest.json.", ".owner.json."))
            for path in self.folder.iterdir()
        )

    def is_complete(self) -> bool:
        """Find the parts; return whether all are intact and nothing needs to be written.

        What an interrupted process left behind needs to be cleared away if the folder is writable.
        """
        found = {self._number(path): path for path in self._found() if self._is_own(path)}
        if len(found) < len(self.chunks):
            return False
        folders = (self.folder, self.parts)
        left = [path for folder in folders for path in folder.glob(".*") if path.name != HIDDEN[0]]
        tidy = not left and len(self._found()) == len(found) and _read_manifest(self.manifest)
        if not tidy and all(os.access(folder, os.W_OK) for folder in folders):
            return False
        self.kept = found
        return True

    def prepare(self) -> None:
        """Write the manifest, find the parts that count, and set the others aside."""
        self.parts.mkdir(exist_ok=True)
        for leftover in self.parts.glob(".*.part"):
            leftover.unlink()
        bad = []
        if _read_manifest(self.manifest) is None:
            bad = [self.manifest] if self.manifest.exists() else []
        for path in self._found():
            if self._is_own(path) and self._number(path) not in self.kept:
                self.kept[self._number(path)] = path
            else:
                bad.append(path)
        self._set_aside(bad)
        if not self.manifest.exists():
            head = {"format": FORMAT, "schema": SCHEMA, "sha256": self.digest}
            text = json.dumps(head | self.study, indent=1) + "\n"
            write_whole(self.manifest, text.encode("utf-8"))

    def _set_aside(self, paths: Sequence[Path]) -> None:
        if not paths:
            return
        aside = self.folder / "set_aside"
        aside.mkdir(exist_ok=True)
        for path in paths:
            os.replace(path, aside / f"{time.time_ns()}-{path.name}")
        names = ", ".join(path.name for path in paths[:3]) + ", ..." * (len(paths) > 3)
        self.told.append(
            f"{self.folder}: {len(paths)} damaged or of another study, moved to {aside.name} and "
            f"made again: {names}"
        )

    # ---- parts ----------------------------------------------------------------------------------

    def _found(self) -> list[Path]:
        return sorted(self.parts.glob("*.parquet"))

    def _number(self, path: Path) -> int:
        """Return the chunk that a part is named for, -1 if it is named otherwise."""
        digits = path.name.partition("-")[0]
        return int(digits) if digits.isascii() and digits.isdecimal() and len(digits) < 10 else -1

    def _is_own(self, path: Path) -> bool:
        """Tell whether a part is what this study wrote of its chunk."""
        number = self._number(path)
        if not 0 <= number < len(self.chunks):
            return False
        try:
            return path.name == self._name(number, read_whole(path, LARGEST))
        except InvalidProblem:  # no file, or one that cannot be read
            return False

    def _name(self, number: int, content: bytes) -> str:
        cases = self.chunks[number]
        seal = hashlib.sha256(f"{self.digest} {number} ".encode())
        seal.update(cases.astype("<i8").tobytes())
        for name, labels in self.design.labels(cases).items():
            numeric = labels.dtype.kind == "f"
            text = labels.astype("<f8").tobytes() if numeric else repr(labels.tolist()).encode()
            seal.update(name.encode() + b"\0" + text)
        seal.update(content)
        return f"{number:06d}-{seal.hexdigest()[:16]}.parquet"

    @cached_property
    def _connection(self) -> Any:
        import duckdb

        connection = duckdb.connect()
        # one thread: the others are busy solving
        connection.execute("SET threads = 1")
        return connection

    def write(self, block: Block) -> None:
        """Write a chunk's rows.

        Raises
        ------
        OSError
            If they cannot be written, e.g. on a full disk; what was written before stays valid.
        """
        rows = {"case": block.cases, **self.design.labels(block.cases)}
        rows |= dict(zip(self.outputs, block.values.T.copy(), strict=True))
        rows |= {"failure": block.failure, "warnings": block.warnings}
        aside = self.parts / f".rows.{os.getpid()}.part"
        try:
            write_parquet(self._connection, rows, aside)
            content = aside.read_bytes()
            write_whole(self.parts / self._name(block.number, content), content)
        except OSError as fault:
            raise OSError(
                fault.errno, f"{fault.strerror or fault}; {GOES_ON}", str(self.folder)
            ) from None
        finally:
            aside.unlink(missing_ok=True)

    def blocks(self) -> Iterator[Block]:
        """Yield the chunks on disk in one go."""
        # DuckDB takes every name of a file for a pattern
        files = [escape(str(path)) for path in self.kept.values()]
        if not files:
            return
        names = [*self.outputs, "case", "failure", "warnings"]
        chosen = ", ".join('"' + name.replace('"', '""') + '"' for name in names)
        with _faults_of(self.parts):
            found = self._connection.execute(
                f"SELECT {chosen} FROM read_parquet(?)", [files]
            ).fetchnumpy()  # fmt: skip
        values = np.column_stack([np.ma.filled(found[name], np.nan) for name in self.outputs])
        failure, warnings = (np.asarray(found[n], dtype=object) for n in ("failure", "warnings"))
        yield Block(0, np.asarray(found["case"], dtype=np.intp), values, failure, warnings)


def write_parquet(connection: Any, rows: Mapping[str, np.ndarray], path: Path) -> None:
    """Write columns to a Parquet file; DuckDB finds ``rows`` by its name.

    Raises
    ------
    OSError
        If it cannot be written.
    KeyboardInterrupt
        After Ctrl-C.
    """
    target = str(path).replace("'", "''")
    with _faults_of(path):
        connection.execute(f"COPY (SELECT * FROM rows) TO '{target}' (FORMAT parquet)")


@contextmanager
def _faults_of(path: Path) -> Iterator[None]:
    """Raise what Python would in place of DuckDB's errors of its own."""
    import duckdb

    try:
        yield
    except duckdb.IOException as fault:
        number = errno.ENOSPC if os.strerror(errno.ENOSPC) in str(fault) else errno.EIO
        raise OSError(number, str(fault).splitlines()[0], str(path)) from None
    except RuntimeError as fault:
        if "interrupted" in str(fault):  # it answers Ctrl-C by this
            raise KeyboardInterrupt from None
        raise


def _program(study: Mapping[str, Any]) -> str:
    return f"woundon {study.get('version')} with sources {study.get('sources', 'not recorded')}"


def _digest(study: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(study, sort_keys=True).encode("utf-8")).hexdigest()


def _read_manifest(path: Path) -> dict[str, Any] | None:
    """Return what an intact manifest says, without its hash; None if it is damaged or missing."""
    try:
        there = json.loads(read_whole(path, LARGEST))
        said = there.pop("sha256")
        study = {name: value for name, value in there.items() if name not in ("format", "schema")}
        intact = {"format", "schema"} <= there.keys() and said == _digest(study)
    except (ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return None
    return there if intact else None
