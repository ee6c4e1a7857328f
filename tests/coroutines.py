"""Coroutines run to their end, whatever else runs in this thread."""

import asyncio
from concurrent.futures import ThreadPoolExecutor


def run(coroutine):
    """Run a coroutine in a thread of its own.

    Where a browser test came before, Playwright's loop still runs in this one, and asyncio.run
    refuses to begin another.
    """
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, coroutine).result()
