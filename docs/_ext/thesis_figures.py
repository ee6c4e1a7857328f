"""Figures of the thesis with their verdicts, computed before the pages are read."""

from __future__ import annotations

import hashlib
from pathlib import Path

from sphinx.errors import ExtensionError

HERE = Path(__file__).parent
SOURCES = HERE.parent.parent / "src"


def make(app) -> None:
    """Compute every figure, unless the program has not changed since."""
    from woundon.jorkama2001.catalogue import NAMES
    from woundon.jorkama2001.exhibits import listed
    from woundon.jorkama2001.publication import publish, summary

    folder = Path(app.srcdir) / "thesis" / "figures"
    stamp, state = folder / "made_by.txt", _state()
    if stamp.exists() and stamp.read_text() == state:
        return
    figures = list(publish(NAMES, folder, dpi=100))
    known = listed()
    changed = [
        figure.name for figure in figures if figure.judged.counts != known[figure.name].counts
    ]
    if changed:
        raise ExtensionError(
            f"the number of statements that hold has changed: {', '.join(changed)}"
        )
    for figure in figures:
        page = folder / f"{figure.name}.md"
        page.write_text(page.read_text("utf-8") + _downloads(figure), encoding="utf-8")
    pages = "\n".join(f"figures/{name}" for name in NAMES)
    contents = f"\n```{{toctree}}\n:hidden:\n\n{pages}\n```\n"
    text = summary(figures, "figures/") + contents
    (folder / "summary.md").write_text(text, encoding="utf-8")
    stamp.write_text(state)


def _downloads(figure) -> str:
    kinds = [path.name for path in figure.files if path.suffix in (".csv", ".svg")]
    return "\nDownload: " + ", ".join(f"{{download}}`{name}`" for name in kinds) + "\n"


def _state() -> str:
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for path in sorted(SOURCES.rglob("*")):
        if path.suffix in (".py", ".csv", ".toml"):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def setup(app) -> dict[str, bool]:
    app.connect("builder-inited", make)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
