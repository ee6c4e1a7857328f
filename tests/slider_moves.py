"""Moves of a slider of the page in a browser, and the time until its answer is drawn.

Measured in the browser from the slider's event to the frame after the numbers are drawn, and within
it the time of the request and the seconds that the server states in its answer.  The load of the
machine is the wall time over the processor time of a dense solve, measured at the same time.
"""

from __future__ import annotations

import statistics
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

__all__ = ["move_sliders", "open_page"]

MOVE = """async moves => {
    const slider = document.querySelector("[data-path=nip_load] .slider")
    const number = document.querySelector(".number-card .value")
    const fetched = window.fetch
    let request, seconds
    window.fetch = async (...call) => {
        const start = performance.now()
        const answer = await fetched(...call)
        if (String(call[0]).startsWith("/api/solve?")) {
            request = performance.now() - start
            seconds = answer.clone().json().then(solved => solved.seconds)
        }
        return answer
    }
    const times = []
    for (let k = 0; k < moves; k++) {
        const drawn = new Promise(done => {
            const watch = new MutationObserver(() => {
                watch.disconnect()
                requestAnimationFrame(() => setTimeout(() => done(performance.now())))
            })
            watch.observe(number, { attributes: true, attributeFilter: ["data-si"] })
        })
        slider.value = 300 + 5 * (k % 80)
        const start = performance.now()
        slider.dispatchEvent(new Event("input", { bubbles: true }))
        const spent = await drawn - start
        times.push([spent, request, 1e3 * await seconds])
    }
    window.fetch = fetched
    return times
}"""


@contextmanager
def measured_load() -> Iterator[list[float]]:
    """Collect ratios of wall to processor time of a dense solve; 1 on an idle machine."""
    matrix = np.random.default_rng(1).normal(size=(400, 400))
    over, ratios = threading.Event(), list[float]()

    def measure() -> None:
        while not over.wait(0.25):
            wall, own = time.perf_counter(), time.thread_time()
            np.linalg.solve(matrix, matrix)
            ratios.append((time.perf_counter() - wall) / (time.thread_time() - own))

    thread = threading.Thread(target=measure)
    thread.start()
    yield ratios
    over.set()
    thread.join()


def open_page(browser: Browser, address: str) -> Page:
    """Return a page with the example of a nip, at rest."""
    page = browser.new_context(viewport={"width": 1280, "height": 800}).new_page()
    page.goto(address)
    page.wait_for_selector(".number-card", timeout=120_000)
    page.wait_for_timeout(2000)  # background requests of the first page are complete
    page.evaluate(MOVE, 5)
    return page


def move_sliders(pages: Sequence[Page], moves: int) -> tuple[np.ndarray, float]:
    """Move the sliders of all pages at once.

    Returns
    -------
    (len(pages)*moves, 3) array
        Until the number is drawn, of the request, and of the computation in the server [ms].
    float
        Load of the machine.
    """
    with measured_load() as ratios:
        for page in pages:
            page.evaluate(f"moves => {{ window.moving = ({MOVE})(moves) }}", moves)
        times = [one for page in pages for one in page.evaluate("() => window.moving")]
    return np.array(times), statistics.median(ratios)
