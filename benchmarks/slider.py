"""Time from a moved slider of the page to the number in the browser, and where it goes.

    python benchmarks/slider.py                30 moves of the nip load of the first page
    python benchmarks/slider.py --moves 100

Medians of wall times in Chromium, by Playwright, against a server of its own.  The computation is
that of the server, which solves from the previous answer; the request is the computation with the
way to a worker and back; the rest is the page.  Each is also divided by the load of the machine.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from browser_session import browsing
from page_server import serving
from slider_moves import move_sliders, open_page


def main() -> int:
    """Move the slider and print the table."""
    options = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    options.add_argument("--moves", type=int, default=30)
    given = options.parse_args()
    with serving() as server, browsing() as browser:
        moves, load = move_sliders([open_page(browser, server.address)], given.moves)
    until_drawn, request, computation = moves.T
    times = {
        "slider to number": until_drawn,
        "computation in the server": computation,
        "way to the worker and back": request - computation,
        "page": until_drawn - request,
    }
    print(f"{given.moves} moves, load of the machine {load:.2f}\n")
    print("| time | ms, median | without load | 90 % | of slider to number |")
    print("|---|---|---|---|---|")
    for name, spent in times.items():
        median, late = np.median(spent), np.quantile(spent, 0.9)
        share = np.median(spent / until_drawn)
        print(f"| {name} | {median:.3g} | {median / load:.3g} | {late:.3g} | {share:.0%} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
