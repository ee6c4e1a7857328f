"""The process pool of woundon, the only internal name that the reproduction uses."""

from woundon.parallel import in_processes

__all__ = ["in_processes"]
