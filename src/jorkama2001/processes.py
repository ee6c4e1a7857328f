"""Processes, apart from ``inside``: who waits for figures needs nothing that draws."""

from woundon.studies.processes import in_processes

__all__ = ["in_processes"]
