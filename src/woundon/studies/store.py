"""Store of a study: one SQLite file, to which every chunk is added when it is solved.

    DIR/study.sqlite
        study(record, sha256)                               base case, design, options as JSON
        chunk(number, outputs, failure, warnings, sha256)   the rows of a chunk

``outputs`` holds little-endian float64, case by case: as numbers SQLite would store nan as NULL and
-0.0 as 0.0.  ``failure`` and ``warnings`` are JSON lists of texts.  The SHA-256 of a chunk covers
its number, content, cases and the study, so that a chunk of another place or study is rejected.

Every chunk is one transaction with a rollback journal: after a kill -9 or a loss of power the file
contains the chunks that were solved.  Several processes may use the same folder; SQLite separates
their transactions.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
import sqlite3
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InvalidProblem
from .design import Design
from .evaluate import Block

__all__ = ["FILE", "Store", "open_store"]

FILE = "study.sqlite"
FORMAT = "woundon-study"
SCHEMA = 3
PROGRAM = {"version", "sources"}  # entries of the record that identify the program
RESUMABLE = "chunks in the file remain valid; resume continues the study"
PATIENCE = 60.0  # seconds to wait for another process's transaction, which takes milliseconds
# NORMAL waits for the disk three times a chunk, FULL four times.  On old file systems a loss of
# power at the wrong moment may then damage the file, which the hashes detect.
PRAGMAS = "PRAGMA journal_mode=DELETE; PRAGMA synchronous=NORMAL"
STUDY = "CREATE TABLE study (record TEXT, sha256 TEXT)"
CHUNK = (
    "CREATE TABLE chunk (number INTEGER PRIMARY KEY, outputs BLOB, failure TEXT, warnings TEXT, "
    "sha256 TEXT)"
)
# errors of the system; SQLite's other errors mean that the file is damaged
SYSTEM = {
    sqlite3.SQLITE_FULL: errno.ENOSPC,
    sqlite3.SQLITE_IOERR: errno.EIO,
    sqlite3.SQLITE_READONLY: errno.EROFS,
    sqlite3.SQLITE_CANTOPEN: errno.EACCES,
    sqlite3.SQLITE_PERM: errno.EACCES,
    sqlite3.SQLITE_BUSY: errno.EBUSY,
    sqlite3.SQLITE_NOMEM: errno.ENOMEM,
}


@contextmanager
def open_store(
    folder: str | Path,
    design: Design,
    chunks: Sequence[np.ndarray],
    outputs: tuple[str, ...],
    record: Mapping[str, Any],
    *,
    resume: bool,
) -> Iterator[Store]:
    """Open the store of a study, or create it.

    Parameters
    ----------
    folder : path
    design : Design
    chunks : sequence of int arrays
        Its cases by chunk.
    outputs : tuple of str
    record : mapping
        Everything else that the results depend on.
    resume : bool
        Continue the study in the folder; without it, the folder must not hold a study.

    Raises
    ------
    InvalidProblem
        If the folder contains a study and ``resume`` is not set, another study, other files, or a
        store that cannot be read.
    OSError
        If it cannot be read, or cannot be written and the study is not complete.
    """
    store = Store(Path(folder), design, chunks, outputs, record)
    try:
        with store.translated_errors():
            store.open(resume)
        yield store
    finally:
        store.close()


class Store:
    """The store of a study; see :func:`open_store`.

    Attributes
    ----------
    kept : dict of int to Block
        The chunks in the file that were verified, by number.
    messages : list of str
        Warnings about the file for the user.
    """

    def __init__(
        self,
        folder: Path,
        design: Design,
        chunks: Sequence[np.ndarray],
        outputs: tuple[str, ...],
        record: Mapping[str, Any],
    ) -> None:
        self.folder, self.path = folder, folder / FILE
        self.chunks, self.outputs = chunks, outputs
        self.study = {
            "format": FORMAT,
            "schema": SCHEMA,
            "design": design.record(),
            "outputs": list(outputs),
            **record,
        }
        self.text = json.dumps(self.study, sort_keys=True)
        self.sha256 = hashlib.sha256(self.text.encode()).hexdigest()
        self.kept, self.messages = dict[int, Block](), list[str]()
        self._connection: sqlite3.Connection | None = None

    def open(self, resume: bool) -> None:
        """Read the file or create it; from a damaged file the verified chunks are recovered."""
        if not os.path.lexists(self.path):
            if self.folder.is_dir() and any(self.folder.iterdir()):
                raise self._invalid("is not empty and contains no study")
            self.folder.mkdir(parents=True, exist_ok=True)
        elif not self.path.is_file():
            raise self._invalid(f"its {FILE} is not a regular file")
        writable = all(os.access(p, os.W_OK) for p in (self.folder, self.path) if p.exists())
        self._connect(writable)
        record = self._read_record()
        if record == {}:
            self._create(resume)
            return
        if record is not None:
            self._check(record, resume)
        elif not resume:
            raise self._invalid(f"its {FILE} is damaged; resume the study to repair it")
        damaged = self._read_chunks()
        if record is None and not self.kept:
            raise self._invalid(f"its {FILE} is damaged, and none of its chunks is of this study")
        missing = len(self.chunks) - len(self.kept)
        if missing and not writable:
            text = f"cannot be written, and {missing} of {len(self.chunks)} chunks are not in it"
            raise OSError(errno.EROFS, text, str(self.folder))
        if writable and (record is None or damaged or (missing and not self._is_sound())):
            self._replace()

    def close(self) -> None:
        """Close the file."""
        if self._connection is not None:
            self._connection.close()

    def write(self, block: Block) -> None:
        """Add a solved chunk.

        Raises
        ------
        OSError
            If it cannot be written, e.g. on a full disk; chunks in the file remain valid.
        """
        with self.translated_errors():
            self._insert(self.connection, block)

    # ---- the study ------------------------------------------------------------------------------

    def _read_record(self) -> dict[str, Any] | None:
        """Return the record of the study in the file: {} if it is empty, None if it is damaged."""
        try:
            if not self.connection.in_transaction:
                self.connection.executescript(PRAGMAS)
            if self.connection.execute("SELECT 1 FROM sqlite_master").fetchone() is None:
                return {}
            text, sha256 = self.connection.execute("SELECT record, sha256 FROM study").fetchone()
            if hashlib.sha256(text).hexdigest().encode() == sha256:
                return dict(json.loads(text))
        except sqlite3.DatabaseError as fault:
            _raise_if_of_the_system(fault)
        except (TypeError, ValueError, RecursionError):  # no row, or other values than texts
            pass
        return None

    def _check(self, record: Mapping[str, Any], resume: bool) -> None:
        """Reject another study, or a study if ``resume`` is not set."""
        if not resume:
            raise self._invalid("contains a study already; resume it, or use another folder")
        if (record.get("format"), record.get("schema")) != (FORMAT, SCHEMA):
            raise self._invalid(f"its {FILE} is not that of a study of this version")
        expected = json.loads(self.text)
        differs = [name for name in expected if record.get(name) != expected[name]]
        if differs and set(differs) <= PROGRAM:
            raise self._invalid(
                f"was solved by another program: {_program(record)}, this is {_program(expected)}; "
                "the results of two programs cannot be combined: solve the study in another "
                "folder, or resume it with the same program"
            )
        if differs:
            raise self._invalid(f"contains another study: {', '.join(differs)} differs")

    def _invalid(self, text: str) -> InvalidProblem:
        return InvalidProblem.at(str(self.folder), text)

    # ---- chunks ---------------------------------------------------------------------------------

    def _read_chunks(self) -> bool:
        """Read all chunks with a valid SHA-256; return True if there are invalid ones."""
        damaged = False
        for number in range(len(self.chunks)):
            try:
                row = self.connection.execute(
                    "SELECT outputs, failure, warnings, sha256 FROM chunk WHERE number = ?",
                    (number,),
                ).fetchone()
            except sqlite3.DatabaseError as fault:
                _raise_if_of_the_system(fault)
                damaged = True
                continue
            if row is not None:
                block = self._verify_chunk(number, *row)
                damaged |= block is None
                self.kept |= {} if block is None else {number: block}
        return damaged

    def _verify_chunk(
        self, number: int, outputs: Any, failure: Any, warnings: Any, sha256: Any
    ) -> Block | None:
        """Return a chunk; None if its SHA-256 is wrong."""
        cases = self.chunks[number]
        try:
            if self._hash(number, outputs, failure, warnings).encode() != sha256:
                return None
        except TypeError:  # neither texts nor bytes
            return None
        values = np.frombuffer(outputs, "<f8").reshape(len(cases), len(self.outputs))
        reasons, notes = (np.array(json.loads(t), dtype=object) for t in (failure, warnings))
        return Block(number, cases, values, reasons, notes)

    def _insert(self, connection: sqlite3.Connection, block: Block) -> None:
        """Write a chunk, as one transaction."""
        values = block.values.astype("<f8").tobytes()
        texts = [json.dumps(list(part)) for part in (block.failure, block.warnings)]
        sha256 = self._hash(block.number, values, *(text.encode() for text in texts))
        connection.execute(
            "INSERT OR REPLACE INTO chunk VALUES (?, ?, ?, ?, ?)",
            (block.number, values, *texts, sha256),
        )

    def _hash(self, number: int, *content: bytes) -> str:
        """Return the SHA-256 of the study and a chunk with its content."""
        digest = hashlib.sha256(f"{self.sha256} {number} ".encode())
        for part in (self.chunks[number].astype("<i8").tobytes(), *content):
            digest.update(f"{len(part)} ".encode() + part)
        return digest.hexdigest()

    # ---- the file -------------------------------------------------------------------------------

    @property
    def connection(self) -> sqlite3.Connection:
        """The open file."""
        assert self._connection is not None
        return self._connection

    def _connect(self, writable: bool) -> None:
        """Open the file; on read-only media without locks, which may be unavailable there."""
        journals = [self.path.with_name(f"{FILE}-{end}") for end in ("journal", "wal")]
        if not writable and any(os.path.lexists(journal) for journal in journals):
            text = "cannot be written, and a write to it was interrupted; copy the folder to resume"
            raise OSError(errno.EROFS, text, str(self.folder))
        mode = "mode=rwc" if writable else "mode=ro&immutable=1"
        self._connection = _connect_file(self.path, mode)

    def _create(self, resume: bool) -> None:
        """Create the tables, unless another process was faster."""
        self.connection.execute("BEGIN IMMEDIATE")
        with self.connection:  # ends the transaction
            record = self._read_record()
            if record == {}:
                self._insert_study(self.connection)
            else:
                self._check(record or {}, resume)

    def _insert_study(self, connection: sqlite3.Connection) -> None:
        """Create the tables and insert the record of the study."""
        for table in (STUDY, CHUNK):
            connection.execute(table)
        connection.execute("INSERT INTO study VALUES (?, ?)", (self.text, self.sha256))

    def _is_sound(self) -> bool:
        """Return True if SQLite finds no damage; reading does not detect all damage."""
        try:
            return bool(self.connection.execute("PRAGMA quick_check(1)").fetchone() == (b"ok",))
        except sqlite3.DatabaseError as fault:
            _raise_if_of_the_system(fault)
            return False

    def _replace(self) -> None:
        """Back up the damaged file, and write the verified chunks to a new one."""
        self.close()
        backup = self.path.with_name(f"damaged-{time.time_ns()}.sqlite")
        repaired = self.path.with_name(f"repaired-{os.getpid()}.sqlite")
        shutil.copyfile(self.path, backup)
        repaired.unlink(missing_ok=True)
        with closing(_connect_file(repaired, "mode=rwc")) as connection:
            connection.execute("BEGIN")
            with connection:
                self._insert_study(connection)
                for block in self.kept.values():
                    self._insert(connection, block)
        os.replace(repaired, self.path)
        self._connect(writable=True)
        missing = len(self.chunks) - len(self.kept)
        self.messages.append(
            f"{self.path}: damaged, a copy is in {backup.name}; {len(self.kept)} of its chunks are "
            f"intact, the other {missing} are solved again"
        )

    @contextmanager
    def translated_errors(self) -> Iterator[None]:
        """Raise OSError or InvalidProblem in place of errors of SQLite."""
        try:
            yield
        except sqlite3.Error as fault:
            number = SYSTEM.get(_code(fault))
            if number is None:
                text = f"its {FILE} is damaged ({fault}); resume the study to repair it"
                raise self._invalid(text) from None
            raise OSError(number, f"{fault}; {RESUMABLE}", str(self.folder)) from None


def _connect_file(path: Path, mode: str) -> sqlite3.Connection:
    """Open a file in autocommit mode; texts are returned as bytes."""
    address = f"{path.absolute().as_uri()}?{mode}"
    connection = sqlite3.connect(address, timeout=PATIENCE, isolation_level=None, uri=True)
    connection.text_factory = bytes
    return connection


def _code(fault: sqlite3.Error) -> int:
    """Return SQLite's primary error code."""
    return getattr(fault, "sqlite_errorcode", 0) & 0xFF


def _raise_if_of_the_system(fault: sqlite3.Error) -> None:
    if _code(fault) in SYSTEM:
        raise fault


def _program(study: Mapping[str, Any]) -> str:
    return f"woundon {study.get('version')} with sources {study.get('sources', 'not recorded')}"
