"""Sphinx math renderer that writes MathML: formulas need no script and no network to be read."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util.math import get_node_equation_number

# marks that stand as close as TeX sets them, and not as relations do
_CLOSE = re.compile(r"<mo([^>]*)>(/|\||&#x0002F;|&#x0007C;|&#x02223;)</mo>")


def _formula(node: nodes.Node, display: str = "inline") -> str:
    return _CLOSE.sub(
        r'<mo\1 lspace="0" rspace="0">\2</mo>', convert(node.astext(), display=display)
    )


def _inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(_formula(node))
    raise nodes.SkipNode


def _display(translator: Any, node: nodes.math_block) -> None:
    translator.body.append(translator.starttag(node, "div", CLASS="math notranslate"))
    if node.get("number"):
        number = get_node_equation_number(translator, node)
        translator.body.append(f'<span class="eqno">({number})')
        translator.add_permalink_ref(node, "Link to this equation")
        translator.body.append("</span>")
    translator.body.append(f"{_formula(node, 'block')}</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer; choose it with ``html_math_renderer = "mathml"``."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
