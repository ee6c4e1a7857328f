"""Store of a study: one SQLite file, to which every chunk is added when it is solved.

    DIR/study.sqlite
        study(record)                                       version, cases and settings as JSON
        chunk(number, outputs, failure, warnings, sha256)   the results of a chunk of cases

``outputs`` holds little-endian float64, case by case: as numbers SQLite would store nan as NULL and
-0.0 as 0.0.  ``failure`` and ``warnings`` are JSON lists of texts.  The SHA-256 of a chunk covers
its number, its results and the record, so that a damaged, exchanged or foreign chunk is noticed.

Every chunk is one transaction with a rollback journal: after a kill -9 or a loss of power the file
contains the chunks that were solved; a file of zero bytes is a study that was killed before its
first transaction.  Several processes may use the same folder; SQLite separates their transactions.
A damaged file, and one with other tables than a study has, is rejected and left as it is.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from .. import __version__
from ..errors import InvalidProblem
from .cases import Solved

__all__ = ["FILE", "Store", "open_store"]

FILE = "study.sqlite"
RESUMABLE = "chunks in the file remain valid; resume continues the study"
PATIENCE = 60.0  # seconds to wait for another process's transaction, which takes milliseconds
CREATE = (
    "CREATE TABLE study (record TEXT)",
    "CREATE TABLE chunk (number INTEGER PRIMARY KEY, outputs BLOB, failure TEXT, warnings TEXT, "
    "sha256 TEXT)",
)


class Store:
    """The open file of a study; see :func:`open_store`.

    Attributes
    ----------
    kept : dict of int to Solved
        The chunks that were in the file when it was opened, by number.
    """

    def __init__(self, connection: sqlite3.Connection, record: str) -> None:
        self.connection, self.record = connection, record
        self.kept: dict[int, Solved] = {}

    def write(self, number: int, solved: Solved) -> None:
        """Add a solved chunk, as one transaction."""
        texts = (json.dumps(solved.failure), json.dumps(solved.warnings))
        row = (number, solved.values.astype("<f8").tobytes(), *texts)
        self.connection.execute(
            "INSERT OR REPLACE INTO chunk VALUES (?, ?, ?, ?, ?)", (*row, self._sha256(row))
        )

    def create(self) -> None:
        """Create the tables with the record."""
        for statement in CREATE:
            self.connection.execute(statement)
        self.connection.execute("INSERT INTO study VALUES (?)", (self.record,))

    def read_record(self) -> dict[str, Any]:
        """Return the record of the study in the file.

        Raises
        ------
        sqlite3.DatabaseError
            If the file has not exactly the tables of a study, or the record cannot be read.
        """
        # before anything is read: a view of this name may contain any computation
        names = self.connection.execute("SELECT type, name FROM sqlite_master").fetchall()
        if sorted(names) != [("table", "chunk"), ("table", "study")]:
            raise sqlite3.DatabaseError("its tables are not those of a study")
        rows = self.connection.execute("SELECT record FROM study").fetchall()
        try:
            [(text,)] = rows
            record = json.loads(text)
        except (TypeError, ValueError, RecursionError):
            record = None
        if not isinstance(record, dict):
            raise sqlite3.DatabaseError("its record cannot be read")
        return record

    def read_chunks(self) -> None:
        """Read all chunks.

        Raises
        ------
        sqlite3.DatabaseError
            If the tables have other columns, a page is damaged, or the SHA-256 of a chunk is wrong.
        """
        statements = self.connection.execute("SELECT sql FROM sqlite_master").fetchall()
        if {sql for (sql,) in statements} != set(CREATE):
            raise sqlite3.DatabaseError("its tables have other columns than those of a study")
        (state,) = self.connection.execute("PRAGMA quick_check(1)").fetchone()
        if state != "ok":
            raise sqlite3.DatabaseError(state)
        for *row, sha256 in self.connection.execute(
            "SELECT number, outputs, failure, warnings, sha256 FROM chunk"
        ):
            if self._sha256(tuple(row)) != sha256:
                raise sqlite3.DatabaseError(f"chunk {row[0]} was changed")
            number, outputs, failure, warnings = row
            reasons = json.loads(failure)
            values = np.frombuffer(outputs, "<f8").reshape(len(reasons), -1)
            self.kept[number] = Solved(values, reasons, json.loads(warnings))

    def _sha256(self, row: tuple[Any, ...]) -> str:
        """Return the SHA-256 of the record and a row; the row may have values of any type.

        The row is (number, outputs, failure, warnings), as it is stored.
        """
        return hashlib.sha256(repr((self.record, *row)).encode()).hexdigest()


@contextmanager
def open_store(
    folder: str | Path, record: Mapping[str, Any], chunks: int, *, resume: bool
) -> Iterator[Store]:
    """Open the store of a study, or create it.

    Parameters
    ----------
    folder : path
    record : mapping
        Everything that the results depend on, with the version of the program.
    chunks : int
        Number of chunks of the study.
    resume : bool
        Continue the study in the folder; without it, the folder must not hold a study.

    Raises
    ------
    InvalidProblem
        If the folder contains a study and ``resume`` is not set, a study of another version or with
        other settings, other files, or a damaged store.
    OSError
        If it cannot be read, or cannot be written and the study is not complete.
    """
    folder = Path(folder)
    path = folder / FILE
    if not os.path.lexists(path):
        # looked for again: another process may have created it since
        if folder.is_dir() and any(folder.iterdir()) and not os.path.lexists(path):
            raise InvalidProblem.at(str(folder), "is not empty and contains no study")
        folder.mkdir(parents=True, exist_ok=True)
    elif not path.is_file():
        raise InvalidProblem.at(str(folder), f"its {FILE} is not a regular file")
    is_writable = all(os.access(p, os.W_OK) for p in (folder, path) if p.exists())
    with (
        _errors_of_sqlite_translated(folder, is_writable),
        closing(_connect(path, is_writable)) as connection,
    ):
        store = Store(connection, json.dumps(record, sort_keys=True))
        # If two processes create the file, the second one waits here, and reads that of the first.
        connection.execute("BEGIN IMMEDIATE" if is_writable else "BEGIN")
        if is_writable and not path.stat().st_size:
            store.create()
        else:
            try:
                _check_study(folder, store.read_record(), json.loads(store.record), resume)
                store.read_chunks()
            except UnicodeDecodeError:  # Python reads the text of an error, which quotes the file
                raise sqlite3.DatabaseError("a name in it is not UTF-8") from None
        connection.execute("COMMIT")
        missing = chunks - len(store.kept)
        if missing and not is_writable:
            text = f"cannot be written, and {missing} of {chunks} chunks are not in it"
            raise OSError(errno.EROFS, text, str(folder))
        yield store


def _connect(path: Path, is_writable: bool) -> sqlite3.Connection:
    """Return a connection on which every statement is a transaction, unless BEGIN starts one.

    Raises
    ------
    sqlite3.DatabaseError
        If the file has a write-ahead log, which SQLite would write into it; a store has none.
    """
    if path.exists():
        with path.open("rb") as file:
            header = file.read(20)
        # bytes 18 and 19, the versions of the format, are 2 with a write-ahead log
        if header.startswith(b"SQLite format 3\0") and 2 in header[18:]:
            raise sqlite3.DatabaseError("it has a write-ahead log, and a study has none")
    address = f"{path.absolute().as_uri()}?mode={'rwc' if is_writable else 'ro'}"
    return sqlite3.connect(address, timeout=PATIENCE, isolation_level=None, uri=True)


def _check_study(
    folder: Path, present: Mapping[str, Any], expected: Mapping[str, Any], resume: bool
) -> None:
    """Reject the study in a folder if it is another one, or if it is not to be resumed."""
    where = str(folder)
    if not resume:
        raise InvalidProblem.at(where, "contains a study already; resume it, or use another folder")
    differs = [name for name in expected if present.get(name) != expected[name]]
    if "version" in differs:
        raise InvalidProblem.at(
            where,
            f"was solved by another program: woundon {present.get('version')}, this is woundon "
            f"{__version__}; the results of two programs cannot be combined: solve the study in "
            "another folder, or resume it with the same program",
        )
    if differs:
        raise InvalidProblem.at(where, f"contains another study: {', '.join(differs)} differs")


@contextmanager
def _errors_of_sqlite_translated(folder: Path, is_writable: bool) -> Iterator[None]:
    """Raise InvalidProblem if SQLite finds the file damaged, and OSError for its other errors.

    The others are those of the disk, of permissions and of another process, which leave the store
    valid: OperationalError, except with the code SQLITE_ERROR, which is that of a statement for
    which the file has no table or column.
    """
    try:
        yield
    except sqlite3.Error as fault:
        # The low byte is the primary code.  Errors raised in this module have none.
        code = getattr(fault, "sqlite_errorcode", sqlite3.SQLITE_ERROR) & 0xFF
        is_damaged = not isinstance(fault, sqlite3.OperationalError) or code == sqlite3.SQLITE_ERROR
        if is_damaged:
            reason = " ".join(str(fault).split())  # SQLite reports each damaged page on a line
            text = f"its {FILE} is damaged or not a study ({reason}) and is left as it is"
            raise InvalidProblem.at(
                str(folder), f"{text}; solve the study in another folder"
            ) from None
        # SQLite writes the state before an interrupted transaction back before it reads the file
        if code == sqlite3.SQLITE_READONLY and not is_writable:
            text = "cannot be written, and a write to it was interrupted; copy the folder to resume"
            raise OSError(errno.EROFS, text, str(folder)) from None
        number = errno.ENOSPC if code == sqlite3.SQLITE_FULL else errno.EIO
        raise OSError(number, f"{fault}; {RESUMABLE}", str(folder)) from None
