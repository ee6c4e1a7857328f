"""The table of a mutation test (mutants.py): its rows, as a file and to read."""

from __future__ import annotations

import csv
import os
import sys
from collections import Counter
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from mutant_sites import Site


@dataclass(frozen=True)
class Mutant:
    """A row of the table: a fault, and what the tests said.

    Attributes
    ----------
    id : str
        A number, 0 for the program itself; "c" and a number where a certificate is made blind.
    file, line : str, int
        Where; the file as seen from the project's folder.
    operator, start, end, first, last : str, int, int, int, int
        The site (mutant_sites.Site).
    old, new : str
        What stands there, and what the mutant has.
    status : str
        "" as long as it has not been tried.
    by, why : str
        The test that failed or ran out of time, and its error.
    tests : int
        How many ran.
    seconds : float
        How long it took.
    note : str
    """

    id: str
    file: str
    line: int
    operator: str
    old: str
    new: str
    start: int
    end: int
    first: int
    last: int
    status: str = ""
    by: str = ""
    why: str = ""
    tests: int = 0
    seconds: float = 0.0
    note: str = ""

    @property
    def blind(self) -> bool:
        """Whether it is a certificate without a law."""
        return self.id.startswith("c")

    @property
    def site(self) -> Site:
        return Site(self.operator, self.start, self.end, (self.first, self.last), (self.new,))

    @property
    def place(self) -> str:
        return f"{self.file.split('/', 2)[-1]}:{self.line}"


def read_table(file: Path, head: str) -> list[Mutant]:
    """Return the rows of an earlier call, none if there is none."""
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as text:
        if text.readline().rstrip("\n") != head:
            sys.exit(f"{file} is of another program or another draw; move it away to begin anew")
        types = {f.name: {"int": int, "float": float}.get(str(f.type), str) for f in fields(Mutant)}
        return [Mutant(**{k: types[k](v) for k, v in row.items()}) for row in csv.DictReader(text)]


def write_tables(file: Path, head: str, mutants: list[Mutant]) -> None:
    """Write the rows as CSV, and to read as Markdown."""
    aside = file.with_suffix(".part")
    with aside.open("w", encoding="utf-8", newline="") as text:
        text.write(f"{head}\n")
        rows = csv.DictWriter(text, [f.name for f in fields(Mutant)], lineterminator="\n")
        rows.writeheader()
        rows.writerows(asdict(mutant) for mutant in mutants)
    os.replace(aside, file)
    lines = [
        f"{summary(mutants)}\n",
        "| | place | fault | was | is | outcome | tests | s |",
        "|---|---|---|---|---|---|---|---|",
        *(_shown(mutant) for mutant in mutants if mutant.status),
    ]
    file.with_suffix(".md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _shown(mutant: Mutant) -> str:
    texts = [" ".join(text.split()).replace("|", "\\|") for text in (mutant.old, mutant.new)]
    was, now = (f"`{t}`" if len(t) < 72 else f"`{t[:68]} ...`" for t in texts)
    ways = {"killed": f"killed by {mutant.by}", "timeout": f"timeout in {mutant.by}"}
    outcome = ways.get(mutant.status, f"**{mutant.status}**")
    noted = f"{outcome} ({mutant.note})" if mutant.note else outcome
    cells = (mutant.id, mutant.place, mutant.operator, was, now, noted, mutant.tests)
    return f"| {' | '.join(map(str, cells))} | {mutant.seconds:.0f} |"


def summary(mutants: list[Mutant]) -> str:
    """Return how many there are of each outcome, random ones and certificates apart."""
    parts = []
    for name, certificate in (("random mutants", False), ("certificates made blind", True)):
        group = [m for m in mutants if m.blind == certificate and m.id != "0"]
        counts = Counter(m.status or "to do" for m in group)
        found = ", ".join(f"{number} {status}" for status, number in sorted(counts.items()))
        if group:
            parts.append(f"{len(group)} {name}: {found}")
    return "; ".join(parts)
