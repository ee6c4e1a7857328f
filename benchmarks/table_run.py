"""A table with one row a seed, computed in parallel and written part by part.

What is written stays: a run that was interrupted goes on where it stopped.  The first line names
the program's sources, so that rows of different programs never mix.
"""

from __future__ import annotations

import csv
import hashlib
import io
import multiprocessing
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from functools import cache
from pathlib import Path

Row = dict[str, object]
Work = Callable[[int], Row]

PART = 25  # seeds a task: about half a second


def run_table(
    path: Path, columns: Sequence[str], seeds: range, work: Work, workers: int
) -> list[dict[str, str]]:
    """Return the table's rows for ``seeds``, as text, by seed; those not yet in the file are made.

    Parameters
    ----------
    path : Path
        CSV file.
    columns : sequence of str
        The first is ``seed``.
    seeds : range
    work : callable
        seed -> row; a function of a module, so that other processes find it.
    workers : int
        Processes; 1 computes in this one.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    done = _kept(path, columns)
    missing = [seed for seed in seeds if seed not in done]
    if done:
        print(f"{path}: {len(seeds) - len(missing)} of {len(seeds)} rows are there already")
    start, made = time.perf_counter(), 0
    with path.open("a", encoding="utf-8", newline="") as file:
        for rows in _parts(missing, work, workers):
            file.write(_as_csv(columns, rows))
            file.flush()
            made += len(rows)
            _progress(made, len(missing), time.perf_counter() - start)
    kept = _kept(path, columns)
    return [kept[seed] for seed in seeds]


def _parts(seeds: list[int], work: Work, workers: int) -> Iterator[list[Row]]:
    parts = [seeds[k : k + PART] for k in range(0, len(seeds), PART)]
    if workers == 1:
        yield from (_part(work, part) for part in parts)
        return
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=spawn) as pool:
        running = [pool.submit(_part, work, part) for part in parts]
        try:
            for task in as_completed(running):
                yield task.result()
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _part(work: Work, seeds: list[int]) -> list[Row]:
    return [{"seed": seed, **work(seed)} for seed in seeds]


def _progress(made: int, whole: int, seconds: float) -> None:
    left = seconds / made * (whole - made)
    text = f"{made} of {whole}, {seconds:.0f} s, {left:.0f} s to go"
    if sys.stderr.isatty():
        print(f"\r{text}   ", end="\n" if made == whole else "", file=sys.stderr, flush=True)
    elif made == whole or made % (40 * PART) == 0:
        print(text, file=sys.stderr, flush=True)


def _as_csv(columns: Sequence[str], rows: list[Row]) -> str:
    text = io.StringIO()
    csv.DictWriter(text, columns, extrasaction="ignore", lineterminator="\n").writerows(rows)
    return text.getvalue()


def _kept(path: Path, columns: Sequence[str]) -> dict[int, dict[str, str]]:
    """Return the file's complete rows; make the file or cut a half-written line off."""
    head = f"# woundon sources {sources()}\n{','.join(columns)}\n"
    text = path.read_text(encoding="utf-8") if path.exists() else ""
    if text and not text.startswith(head):
        sys.exit(f"{path} is of another version of the program; move it away to begin again")
    whole = text[: text.rfind("\n") + 1]
    if whole != text or not text:
        aside = path.with_suffix(".part")
        aside.write_text(whole or head, encoding="utf-8")
        os.replace(aside, path)
    rows = csv.DictReader(whole.splitlines()[1:])
    return {int(row["seed"]): row for row in rows}


@cache
def sources() -> str:
    """Return a short digest of the program's source files, as they were when first asked."""
    import woundon

    digest = hashlib.sha256()
    for file in sorted(Path(woundon.__file__).parent.rglob("*.py")):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:12]
