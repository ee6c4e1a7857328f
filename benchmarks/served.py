"""A server of the page for a while, as people start it, and a browser to look at it with."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from playwright.sync_api import Browser, sync_playwright

CHROMIUMS = ("chromium", "chromium-browser", "google-chrome")


@contextmanager
def served() -> Iterator[str]:
    """Yield the address of a server of its own on a free port."""
    command = [sys.executable, "-m", "woundon", "app", "--no-browser", "--port", "0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        found = re.search(r"http://\S+", line)
        assert found, line
        yield found[0].rstrip("/")
    finally:
        process.terminate()
        process.communicate(timeout=20)


def chromium() -> str | None:
    """Return where the system's Chromium is; None without."""
    return next(filter(None, map(shutil.which, CHROMIUMS)), None)


@contextmanager
def browsing() -> Iterator[Browser]:
    """Yield the system's Chromium."""
    with sync_playwright() as browsers:
        # as root, which containers are, Chromium has no sandbox
        browser = browsers.chromium.launch(executable_path=chromium(), args=["--no-sandbox"])
        yield browser
        browser.close()
