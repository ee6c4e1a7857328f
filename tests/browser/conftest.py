"""The page in a browser: Playwright drives the system's Chromium against a server of its own."""

from __future__ import annotations

import base64
import itertools
import json
import re
import time
import zlib
from pathlib import Path

import pytest

pytest.importorskip("playwright", reason="needs playwright (pip install 'woundon[dev]')")

from browser_session import browsing, chromium

HERE = Path(__file__).parent
PATIENCE = 120_000  # [ms] for what takes seconds on an idle machine
# said by the browser of every refusal, which the page tells at its field
REFUSED = re.compile(r"Failed to load resource: the server responded with a status of (4\d\d)")


def pytest_collection_modifyitems(items):
    """Mark all of them; skip them only where there is no browser."""
    for item in items:
        if HERE in Path(item.path).parents:
            item.add_marker(pytest.mark.browser)
            if chromium() is None:
                item.add_marker(pytest.mark.skip(reason="no chromium is installed"))


@pytest.fixture(scope="session")
def address(process):
    """The address of a server."""
    return process.address


@pytest.fixture(scope="session")
def browser():
    """A browser."""
    with browsing() as found:
        yield found


# The answer has come, and what is drawn after it as well: effects and canvases take two frames.
# Looked at now and then: whoever waits for frames has the browser draw sixty a second.
RESTING = """async () => {
    const end = performance.now() + 120_000
    for (let frames = 0; frames < 3; frames++) {
        while (!document.querySelector(".working:not(.busy):not(.rough)")) {
            if (performance.now() > end) throw new Error("something is solved for two minutes")
            await new Promise((again) => setTimeout(again, 20))
            frames = 0
        }
        await new Promise(requestAnimationFrame)
    }
}"""


@pytest.fixture(scope="session")
def desk(browser):
    """Pages by number, each of a context of its own, for one test after the other.

    A new context and a new renderer cost twice what a new document in these does.
    """
    pages = []

    def numbered(k):
        while len(pages) <= k:
            pages.append(browser.new_context().new_page())
            pages[-1].set_default_timeout(PATIENCE)
        return pages[k]

    yield numbered
    for page in pages:
        page.context.close()


def state_of(code):
    """Return the state that the fragment of an address holds."""
    return json.loads(zlib.decompress(base64.urlsafe_b64decode(code + "=" * (-len(code) % 4))))


class Seen:
    """A page, with what tests ask of it again and again."""

    documents = itertools.count()

    def __init__(self, page, address):
        self.page = page
        self.address = address
        self.faults = []
        page.on("pageerror", self._fault)
        page.on("console", self._console)

    def _fault(self, fault):
        self.faults.append(str(fault))

    def _console(self, message):
        if message.type == "error" and not REFUSED.match(message.text):
            self.faults.append(message.text)

    def open(self, fragment=""):
        """Open the page as who never saw it and wait for its first picture."""
        if self.page.url.startswith(self.address):
            self.page.evaluate("() => localStorage.clear()")
        self.page.mouse.move(0, 0)
        # another address each time: where the fragment alone is new, the document stays
        self.page.goto(f"{self.address}/?{next(self.documents)}{fragment}")
        return self.rest()

    def leave(self):
        """Hear no more of what the page says."""
        self.page.remove_listener("pageerror", self._fault)
        self.page.remove_listener("console", self._console)

    def drawn(self, within):
        """Return what a canvas shows, read at once: panels may be drawn again at any time."""
        shown = "within => document.querySelector(within + ' canvas')?.toDataURL()"
        return self.page.wait_for_function(shown, arg=within).json_value()

    def redrawn(self, within, before):
        """Wait until a canvas shows something else."""
        shown = "document.querySelector(within + ' canvas')?.toDataURL()"
        asked = f"([within, before]) => ![undefined, before].includes({shown})"
        self.page.wait_for_function(asked, arg=[within, before])

    def winding_without_nips(self):
        """Choose a winding whose tension law needs no nip, and wait for its margins."""
        self.page.click("#tab-winding")
        self.page.wait_for_selector(".schedule-plot")
        self.page.select_option(".kind", "winding")
        self.page.wait_for_selector("[id='f-tension_law']")
        self.page.select_option("[id='f-tension_law']", label="friction")
        self.page.wait_for_selector(".margins", timeout=120_000)

    def read(self, panel):
        """Return the number under the cursor of a panel as soon as it is there."""
        place = f"[data-panel={panel}] [data-value='0']"
        shown = "place => document.querySelector(place)?.innerText.match(/\\d/)"
        self.page.wait_for_function(shown, arg=place)
        return float(self.page.inner_text(place))

    def rest(self):
        """Wait until nothing is solved any more, and all of it is drawn."""
        self.page.evaluate(RESTING)
        return self

    def held(self, is_held):
        """Return the state in the address as soon as `is_held` of it: it follows a change later."""
        end = time.monotonic() + 120
        while time.monotonic() < end:
            code = self.page.evaluate("() => location.hash")[1:]
            if code and is_held(state := state_of(code)):
                assert len(code) < 4000
                return state
            self.page.wait_for_timeout(50)
        raise AssertionError("the address does not follow for two minutes")

    def output(self, name):
        """Return what an output's card holds, in SI."""
        return float(self.page.get_attribute(f"[data-output={name}] .value", "data-si"))

    def card(self, name):
        """Return the text of an output's card."""
        return self.page.inner_text(f"[data-output={name}]")

    def put(self, path, text):
        """Type into a field's box, and leave it."""
        box = self.page.locator(f"[data-path='{path}'] .box")
        box.fill(text)
        box.blur()
        return self.rest()

    def box(self, path):
        """Return what stands in a field's box."""
        return self.page.input_value(f"[data-path='{path}'] .box")

    def from_menu(self, words):
        """Choose an entry of the menu."""
        self.page.click(".menu summary")
        self.page.click(f".menu-list >> text={words}")

    def saved(self, words):
        """Return the bytes that an entry of the menu saves."""
        with self.page.expect_download(timeout=60_000) as waiting:
            self.from_menu(words)
        return Path(waiting.value.path()).read_bytes()

    def offer(self, name, content):
        """Open a case file; what becomes of it comes later."""
        computed = {"name": name, "mimeType": "text/plain", "buffer": content}
        self.page.set_input_files("input[type=file]", [computed])


@pytest.fixture
def look(desk, address):
    """Open pages; whatever their consoles say is a fault."""
    pages = []

    def opened(fragment="", *, width=1280, height=800, **media):
        page = desk(len(pages))
        page.set_viewport_size({"width": width, "height": height})
        page.emulate_media(**{"color_scheme": "light", "reduced_motion": "no-preference"} | media)
        pages.append(Seen(page, address))
        return pages[-1].open(fragment)

    yield opened
    for page in pages:
        page.leave()
    assert not [fault for page in pages for fault in page.faults]


@pytest.fixture
def look_with(browser, address):
    """Open pages in contexts of their own that run a script before those of the page."""
    pages = []

    def opened(script, *, width=1280, height=800):
        context = browser.new_context(viewport={"width": width, "height": height})
        context.add_init_script(script)
        context.set_default_timeout(PATIENCE)
        pages.append(Seen(context.new_page(), address))
        return pages[-1].open()

    yield opened
    for one in pages:
        one.page.context.close()
    assert not [fault for one in pages for fault in one.faults]
