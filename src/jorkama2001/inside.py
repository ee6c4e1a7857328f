"""What the reproduction takes from within woundon, for want of a public name.

All of it is here, but for the processes (``processes``).
"""

from woundon.show.figures import figure_bytes, save_figure, style

__all__ = ["figure_bytes", "save_figure", "style"]
