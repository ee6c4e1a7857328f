"""Sphinx configuration; build with ``sphinx-build -W -b html docs docs/_build/html``.

No network is needed to build or to read the pages: formulas are MathML with a font that is
included.  Cells and examples are executed; a failing one makes the build fail.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "_ext"), str(HERE.parent / "src")]
# the kernels that run the cells of the pages are processes of their own
os.environ["PYTHONPATH"] = os.pathsep.join(
    filter(None, [str(HERE.parent / "src"), os.environ.get("PYTHONPATH")])
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
    "sphinx_gallery.gen_gallery",
    "thesis_figures",
    "mathml",
    "tables",
]
exclude_patterns = ["_build", "thesis/figures/summary.md", "gallery/**/*.ipynb"]
source_suffix = {".md": "myst-nb", ".rst": "restructuredtext"}

myst_enable_extensions = ["attrs_inline", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
numfig = True  # equations are numbered by page: (3.1)
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 600  # a winding takes a few seconds, on a busy machine ten times as long
nb_merge_streams = True

# the examples are executed; each page offers its script and its notebook
sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "subsection_order": [
        f"../examples/{name}" for name in ("winder", "paper", "nip", "trust", "data")
    ],
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "show_signature": False,
    "write_computation_times": False,
    "min_reported_time": 1000,
    "remove_config_comments": True,
    "matplotlib_animations": False,
}

autodoc_typehints = "none"  # the docstrings give types with units and shapes
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
python_use_unqualified_type_names = True
# a parameter's name may be that of an attribute of several classes: it needs no link
suppress_warnings = ["ref.python"]

html_theme = "pydata_sphinx_theme"
html_title = f"woundon {release}"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["woundon.css"]
html_show_sourcelink = False
html_sidebars = {name: [] for name in ("index", "genindex", "py-modindex", "search")}
html_context = {"default_mode": "auto"}  # light or dark, as the reader's system
html_theme_options = {
    "header_links_before_dropdown": 7,
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
