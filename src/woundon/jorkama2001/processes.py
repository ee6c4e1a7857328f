"""The pool of processes of woundon, the one name that the reproduction takes from within."""

from woundon.parallel import in_processes

__all__ = ["in_processes"]
