"""Plug-in of woundon: ``woundon thesis``, further outputs of nips, figures of the page."""

from __future__ import annotations

import woundon as wo

from . import outputs
from .command import thesis
from .pictures import drawn, known

wo.plugins.register_command(thesis)
for output in outputs.OUTPUTS:
    wo.plugins.register_output("nip", output, on_request=True)
wo.plugins.register_figures(known, drawn)
