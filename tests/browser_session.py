"""The system's Chromium, driven by Playwright."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Browser

__all__ = ["browsing", "chromium"]

CHROMIUMS = ("chromium", "chromium-browser", "google-chrome")


def chromium() -> str | None:
    """Return where it is; None without."""
    return next(filter(None, map(shutil.which, CHROMIUMS)), None)


@contextmanager
def browsing() -> Iterator[Browser]:
    """Provide a browser."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as browsers:
        # as root, which containers are, Chromium has no sandbox
        browser = browsers.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        yield browser
        browser.close()
