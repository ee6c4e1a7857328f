"""Sphinx configuration; build with ``sphinx-build -W -b html docs docs/_build/html``.

Needs no network: formulas become MathML, notebooks' cells run here, a failing cell fails the build.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "_ext"), str(HERE.parent / "src")]
# the kernels that run the pages' cells are processes of their own; some tables come from benchmarks
FOLDERS = [str(HERE.parent / name) for name in ("src", "benchmarks")]
os.environ["PYTHONPATH"] = os.pathsep.join(
    [*FOLDERS, *filter(None, [os.environ.get("PYTHONPATH")])]
)
os.environ.setdefault("OMP_NUM_THREADS", "1")

import woundon

project = "woundon"
author = "the woundon developers"
copyright = author
release = version = woundon.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "gallery",
    "mathml",
    "sizes",
    "tables",
]
exclude_patterns = ["_build", "tables", "requirements.in", "thesis/figures/summary.md"]
source_suffix = {".md": "myst-nb"}

myst_enable_extensions = ["dollarmath", "deflist", "attrs_inline"]
myst_heading_anchors = 3
numfig = True  # equations are numbered by page: (3.1)
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_merge_streams = True

autodoc_typehints = "none"  # the docstrings give types with units and shapes
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
python_use_unqualified_type_names = True

html_theme = "pydata_sphinx_theme"
html_title = f"woundon {release}"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["woundon.css"]
html_show_sourcelink = False
html_sidebars = {"*": []}  # pages of no section have no section to navigate in
html_theme_options = {
    "show_prev_next": True,
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "navbar_end": ["theme-switcher"],
    "footer_start": ["copyright"],
    "footer_end": [],
}


def _bars(app, what, name, obj, options, lines: list[str]) -> None:
    """Write |F| in docstrings with a bar that reStructuredText takes for no substitution."""
    lines[:] = [line.replace("|", "\N{DIVIDES}") for line in lines]


def setup(app) -> None:
    app.connect("autodoc-process-docstring", _bars, priority=400)  # before napoleon
