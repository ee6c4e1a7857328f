"""Check every built page in a browser, at the width of a laptop and of a telephone.

    python docs/check_pages.py docs/_build/html [--pictures DIR] [--width 1280 --width 390]

It reports pages that scroll horizontally, text that is cut off or exceeds its column, dead links,
missing images, formulas that are not typeset, messages on the console of the browser, and requests
to the network.  ``--pictures`` saves every page as a PNG.  Requires Playwright
(``pip install 'woundon[dev]'``) and a Chromium, of the system or of Playwright.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote, urlsplit

from playwright.sync_api import Browser, sync_playwright

WIDTHS = (1280, 390)
CHROMIUMS = ("chromium", "chromium-browser", "google-chrome")

# faults of a single page, each a line of text
LOOK = """() => {
    const faults = [], wide = document.documentElement.clientWidth
    const name = e => [e.tagName.toLowerCase(), ...e.classList].slice(0, 2).join('.')
    const start = e => (e.textContent || e.src || '').trim().slice(0, 50).replace(/\\s+/g, ' ')
    if (document.scrollingElement.scrollWidth > wide)
        faults.push(`scrolls sideways: ${document.scrollingElement.scrollWidth} of ${wide} px`)
    const scrolls = e => {
        for (; e && e !== document.body; e = e.parentElement)
            if (/auto|scroll/.test(getComputedStyle(e).overflowX)) return true
        return false
    }
    for (const e of document.querySelectorAll('main *')) {
        const box = e.getBoundingClientRect()
        if (box.width && box.right > wide + 1 && !scrolls(e) && !e.closest('svg, math'))
            faults.push(`beyond the right edge: ${name(e)} "${start(e)}"`)
    }
    for (const e of document.querySelectorAll('main pre, main table, main div.math'))
        if (wide > 1000 && e.scrollWidth > e.clientWidth + 1)
            faults.push(`cut off, ${e.scrollWidth} of ${e.clientWidth} px: "${start(e)}"`)
    for (const e of document.querySelectorAll('main div.math math'))
        if (e.getBoundingClientRect().left < e.parentElement.getBoundingClientRect().left - 1)
            faults.push(`begins outside its column: "${start(e)}"`)
    for (const e of document.querySelectorAll('main div.math .eqno')) {
        const number = e.getBoundingClientRect()
        const formula = e.parentElement.querySelector('math').getBoundingClientRect()
        if (number.left < formula.right && number.top < formula.bottom
            && number.right > formula.left && number.bottom > formula.top)
            faults.push(`number over its equation: "${start(e)}"`)
    }
    for (const image of document.images)
        if (!image.complete || !image.naturalWidth) faults.push(`no picture: ${image.src}`)
    for (const image of document.querySelectorAll('main img:not([alt])'))
        faults.push(`picture without a text: ${image.src}`)
    for (const e of document.querySelectorAll('div.math'))
        if (!e.querySelector('math')) faults.push(`no formula: "${start(e)}"`)
    for (const e of document.querySelectorAll('merror'))
        faults.push(`formula with an error: "${start(e)}"`)
    if (document.querySelector('math') && !document.fonts.check('16px "STIX Two Math"'))
        faults.push('the font of the formulas is missing')
    return faults
}"""
LINKS = "() => [...document.querySelectorAll('a[href]')].map(a => a.href)"
IDS = "() => [...document.querySelectorAll('[id]')].map(e => e.id)"


def main() -> int:
    """Check all pages; return 0 without faults, else 1."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("html", type=Path, help="folder of the built pages")
    parser.add_argument("--pictures", type=Path, help="folder for a picture of every page")
    parser.add_argument("--width", type=int, action="append", help="in pixels; 1280 and 390")
    options = parser.parse_args()
    root = options.html.resolve()
    # HTML files in _static belong to the theme
    pages = sorted(path for path in root.rglob("*.html") if "_static" not in path.parts)
    if not pages:
        parser.error(f"no pages in {options.html}")
    with sync_playwright() as browsers:
        system = next(filter(None, map(shutil.which, CHROMIUMS)), None)
        browser = browsers.chromium.launch(executable_path=system, args=["--no-sandbox"])
        widths = options.width or list(WIDTHS)
        seen = Seen(root)
        faults = list(_look(browser, seen, pages, widths, options.pictures))
        faults += _dead_links(seen)
    print(*faults, sep="\n")
    print(f"{len(pages)} pages at {', '.join(map(str, widths))} px: {len(faults)} faults")
    return 1 if faults else 0


class Seen:
    """Links and places of the pages below a folder."""

    def __init__(self, root: Path):
        self.root = root
        self.links: dict[Path, list[str]] = {}
        self.ids: dict[Path, set[str]] = {}


def _look(
    browser: Browser, seen: Seen, pages: list[Path], widths: list[int], pictures: Path | None
) -> Iterator[str]:
    """Yield the faults of all pages, each loaded once, and note their links and places."""
    page = browser.new_page(viewport={"width": widths[0], "height": 900})
    said: list[str] = []

    def note(message: str, when: bool = True) -> None:
        if when:
            said.append(message)

    page.on("console", lambda m: note(f"console: {m.text}", m.type in ("error", "warning")))
    page.on("pageerror", lambda fault: note(f"script: {fault}"))
    page.on("requestfailed", lambda r: note(f"not loaded: {r.url}"))
    page.on("request", lambda r: note(f"request to the network: {r.url}", r.url.startswith("http")))
    for path in pages:
        name = path.relative_to(seen.root).with_suffix("")
        page.goto(path.as_uri())
        page.evaluate("document.fonts.ready.then(() => true)")
        seen.links[path], seen.ids[path] = page.evaluate(LINKS), set(page.evaluate(IDS))
        for width in widths:
            page.set_viewport_size({"width": width, "height": 900})
            faults = page.evaluate(LOOK)
            yield from (f"{name} at {width}: {fault}" for fault in [*said, *faults])
            said.clear()
            if pictures:
                target = pictures / str(width) / f"{'_'.join(name.parts)}.png"
                page.screenshot(path=target, full_page=True)
    page.close()


def _dead_links(seen: Seen) -> Iterator[str]:
    """Yield the links within the pages whose file, or place in it, does not exist."""
    for path, targets in seen.links.items():
        for target in sorted(set(targets)):
            url = urlsplit(target)
            file, place = Path(unquote(url.path)), unquote(url.fragment)
            if url.scheme != "file":
                continue
            if not file.is_file():
                yield f"{path.relative_to(seen.root)}: dead link to {target}"
            elif place and file in seen.ids and place not in seen.ids[file]:
                yield f"{path.relative_to(seen.root)}: no such place: {target}"


if __name__ == "__main__":
    sys.exit(main())
