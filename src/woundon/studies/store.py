"""A study on disk: Parquet parts written as they finish, and a manifest that guards the design.

    DIR/manifest.json          what is studied; its hash
    DIR/parts/000042.parquet   the rows of one chunk, moved into place when complete

A part is whole or absent: whatever stops the program, even kill -9, only the chunks being solved
are lost, and a study resumed fills in exactly the parts that are missing.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from glob import escape
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InvalidProblem
from .design import Design
from .evaluate import Block

__all__ = ["Store", "write_parquet"]

FORMAT = "woundon-study"
SCHEMA = 1


class Store:
    """The folder of a study.

    Parameters
    ----------
    folder : path
    design : Design
    outputs : tuple of str
    record : mapping
        What else the numbers depend on.
    resume : bool
        Go on with what the folder holds; without it, it must hold no study.

    Raises
    ------
    InvalidProblem
        If the folder holds a study and ``resume`` is not asked for, or another study than this.
    """

    def __init__(
        self, folder: str | Path, design: Design, outputs: tuple[str, ...],
        record: Mapping[str, Any], *, chunk: int | None, resume: bool,
    ) -> None:  # fmt: skip
        import duckdb

        self.folder, self.parts = Path(folder), Path(folder) / "parts"
        self.design, self.outputs = design, outputs
        self.manifest = {
            "design": design.record(),
            "outputs": list(outputs),
            "chunk": chunk,
            **record,
        }
        self._open(resume)
        self.connection = duckdb.connect()
        # one thread: the others are busy solving
        self.connection.execute("SET threads = 1")

    def _open(self, resume: bool) -> None:
        path = self.folder / "manifest.json"
        if path.exists():
            _same_study(path, self.manifest, resume)
        elif self.folder.exists() and any(self.folder.iterdir()):
            raise InvalidProblem([(str(self.folder), "is not empty and holds no study")])
        self.parts.mkdir(parents=True, exist_ok=True)
        for leftover in self.parts.glob(".*.part"):
            leftover.unlink()
        if not path.exists():
            head = {"format": FORMAT, "schema": SCHEMA, "sha256": _digest(self.manifest)}
            _replace(path, (json.dumps(head | self.manifest, indent=1) + "\n").encode("utf-8"))

    def done(self) -> set[int]:
        """Return the numbers of the chunks that are on disk."""
        return {int(path.stem) for path in self._parts()}

    def write(self, block: Block) -> None:
        """Write a chunk's rows: aside, then into place."""
        rows = {"case": block.cases, **self.design.labels(block.cases)}
        rows |= dict(zip(self.outputs, block.values.T.copy(), strict=True))
        rows |= {"failure": block.failure, "warnings": block.warnings}
        path = self.parts / f"{block.number:06d}.parquet"
        aside = path.with_name(f".{path.name}.{os.getpid()}.part")
        write_parquet(self.connection, rows, aside)
        os.replace(aside, path)

    def blocks(self) -> Iterator[Block]:
        """Yield the chunks on disk in one go."""
        # DuckDB takes every name of a file for a pattern
        files = [escape(str(path)) for path in self._parts()]
        if not files:
            return
        names = [*self.outputs, "case", "failure", "warnings"]
        chosen = ", ".join('"' + name.replace('"', '""') + '"' for name in names)
        found = self.connection.execute(
            f"SELECT {chosen} FROM read_parquet(?)", [files]
        ).fetchnumpy()  # fmt: skip
        values = np.column_stack([np.ma.filled(found[name], np.nan) for name in self.outputs])
        failure, warnings = (np.asarray(found[n], dtype=object) for n in ("failure", "warnings"))
        yield Block(0, np.asarray(found["case"], dtype=np.intp), values, failure, warnings)

    def _parts(self) -> list[Path]:
        return sorted(self.parts.glob("[0-9]*.parquet"))


def write_parquet(connection: Any, rows: Mapping[str, np.ndarray], path: Path) -> None:
    """Write columns to a Parquet file; DuckDB finds ``rows`` by its name."""
    target = str(path).replace("'", "''")
    connection.execute(f"COPY (SELECT * FROM rows) TO '{target}' (FORMAT parquet)")


def _digest(manifest: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(manifest, sort_keys=True).encode("utf-8")).hexdigest()


def _same_study(path: Path, manifest: Mapping[str, Any], resume: bool) -> None:
    """Raise InvalidProblem unless the study at ``path`` is to be resumed and is this one."""
    where = str(path.parent)
    try:
        there = json.loads(path.read_text("utf-8"))
        known = there["format"] == FORMAT and there["schema"] == SCHEMA
        digest = there["sha256"]
    except (OSError, ValueError, KeyError, TypeError):
        known, digest, there = False, "", {}
    if not known:
        raise InvalidProblem([(where, "its manifest.json is not that of a study of this version")])
    if not resume:
        raise InvalidProblem([(where, "holds a study already; resume it, or take another folder")])
    if digest != _digest(manifest):
        here = json.loads(json.dumps(manifest))
        differs = [name for name in here if there.get(name) != here[name]]
        raise InvalidProblem(
            [(where, f"holds another study than this: {', '.join(differs)} differs")]
        )


def _replace(path: Path, content: bytes) -> None:
    aside = path.with_name(f".{path.name}.{os.getpid()}.part")
    aside.write_bytes(content)
    os.replace(aside, path)
