"""Computing time of thesis Fig. 33 against the number of nodes, in dense solves of 398 x 398.

    python benchmarks/fig33.py [--write src/woundon/jorkama2001/computing_time.csv]

The figure draws what is written, so that it is the same wherever it is drawn.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from speed import Baseline

from woundon.jorkama2001 import procedure
from woundon.jorkama2001.fig33 import NODES, PROBLEM
from woundon.jorkama2001.nips import solved

HEAD = (
    "# processor time over that of a dense solve of 398 x 398 (benchmarks/fig33.py):",
    "# by the procedure of the thesis, by the accurate solver",
)


def main() -> int:
    """Print the rows, or write them."""
    given = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    given.add_argument("--write", type=Path, help="file")
    path, baseline, lines = given.parse_args().write, Baseline(), list(HEAD)
    for M in NODES.tolist():
        spent = [
            baseline.ratio(lambda: procedure.solve(PROBLEM, M), 5),  # noqa: B023
            baseline.ratio(lambda: solved(PROBLEM, nodes=M), 9),  # noqa: B023
        ]
        lines.append(f"{M},{spent[0]:.2f},{spent[1]:.2f}")
    text = "\n".join(lines) + "\n"
    print(text)
    if path:
        path.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
