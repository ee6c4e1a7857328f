"""Plug-in of woundon: the command ``woundon thesis``, and the figures of the thesis on the page."""

from __future__ import annotations

import woundon as wo

from .command import thesis
from .pictures import drawn, known

wo.plugins.register_command(thesis)
wo.plugins.register_figures(known, drawn)
