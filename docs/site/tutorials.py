"""Tutorials as pages: notebooks in `docs/tutorials`, kept as Python text, executed while the site is built."""

from __future__ import annotations

import base64
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.documented_pages import beside_examples
from tests.golden import ROOT

FOLDER = ROOT / "docs" / "tutorials"


def tutorials(work: Path) -> Iterator[tuple[str, str | bytes]]:
    """Yield the page, the notebook and the pictures of each tutorial; they run in the folder of the examples."""
    import jupytext
    import nbformat
    from nbclient import NotebookClient

    for path in sorted(FOLDER.glob("*.py")):
        folder = work / path.stem
        folder.mkdir(parents=True)
        notebook = jupytext.read(path)
        with beside_examples(folder):
            NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
        pictures: dict[str, bytes] = {}
        yield f"tutorials/{path.stem}.md", _page(notebook, path.stem, pictures)
        yield from ((f"tutorials/{name}", content) for name, content in pictures.items())
        yield f"tutorials/{path.stem}.ipynb", nbformat.writes(notebook)


def _page(notebook: Any, stem: str, pictures: dict[str, bytes]) -> str:
    parts: list[str] = []
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts += [cell.source, ""]
            continue
        parts += ["```python", cell.source, "```", ""]
        for shown in cell.outputs:
            parts += [*_output(shown, cell.source, stem, pictures), ""]
    return "\n".join([*parts, f"[This page as a notebook]({stem}.ipynb)", ""])


def _output(shown: Any, source: str, stem: str, pictures: dict[str, bytes]) -> Iterator[str]:
    """What a cell shows: a picture, markup of a result, or text."""
    data = shown.get("data", {})
    html = data.get("text/html", "")
    svg = data.get("image/svg+xml") or (html if html.startswith("<svg") else "")
    if svg or "image/png" in data:
        name = f"{stem}_{len(pictures) + 1}.{'svg' if svg else 'png'}"
        pictures[name] = svg.encode() if svg else base64.b64decode(data["image/png"])
        what = re.sub(r"[\[\]]", "", source.strip().splitlines()[-1])
        yield f"![What {what} shows]({name})"
    elif html:
        yield from ('<div style="overflow-x: auto">', re.sub(r"\n\s*\n", "\n", html), "</div>")
    else:
        text = data.get("text/plain", shown.get("text", ""))
        yield from ("```text", text.rstrip(), "```") if text.strip() else ()
