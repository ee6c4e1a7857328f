"""Sphinx math renderer that writes MathML: formulas need no script and no network to be read."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util.math import get_node_equation_number

MATHML = "http://www.w3.org/1998/Math/MathML"
PRIMES = ("\u2032", "\u2033", "\u2034")
CLOSE = ("/", "|")
ElementTree.register_namespace("", MATHML)


def _formula(node: nodes.Node, display: str = "inline") -> str:
    """Return TeX as MathML, spaced as TeX spaces it.

    Raises
    ------
    ExtensionError
        For a command that is not understood, which would be shown as it is written.
    """
    tree = ElementTree.fromstring(convert(node.astext(), display=display))
    for element in list(tree.iter()):
        _set(element)
    text = ElementTree.tostring(tree, encoding="unicode")
    if "\\" in text:
        raise ExtensionError(f"formula not understood: {node.astext()}")
    return text


def _set(element: ElementTree.Element) -> None:
    """Put one element right where latex2mathml leaves it to the browser."""
    tag, text = element.tag.partition("}")[2], element.text or ""
    if tag == "mo" and text in CLOSE:
        element.attrib |= {"lspace": "0", "rspace": "0"}
    elif tag == "mi" and len(text) > 1 and text.isalpha():
        # the name of a function
        element.tag = f"{{{MATHML}}}mo"
        element.attrib |= {"lspace": "0.17em", "rspace": "0.17em", "form": "prefix"}
    elif tag in ("msup", "msubsup") and element[-1].text in PRIMES:
        # the sign is raised by itself; as an exponent it would be tiny
        prime = element[-1]
        element.remove(prime)
        prime.tag, prime.attrib = f"{{{MATHML}}}mo", {"lspace": "0", "rspace": "0"}
        inner = ElementTree.Element(f"{{{MATHML}}}{'msub' if len(element) > 1 else 'mrow'}")
        inner.extend(list(element))
        element.clear()
        element.tag = f"{{{MATHML}}}mrow"
        element.extend([inner, prime])


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
