"""Pages of the documentation that are made of the program, and links of pages that leave their folder."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

from symoro_elastic.pages.models_page import models_page

ROOT = Path(__file__).parents[1]
PICTURE = re.compile(r"\]\(\.\./examples/(\w+\.svg)\)")
OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./([^)]+)\)")


def on_files(files: Files, config: Any) -> Files:
    """Add the page of models, and pictures of examples."""
    files.append(File.generated(config, "models.md", content=models_page()))
    for picture in (ROOT / "examples").glob("*.svg"):
        files.append(File.generated(config, picture.name, abs_src_path=str(picture)))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return a page with the names of files of the repository in the place of links to them; pictures stay."""
    markdown = PICTURE.sub(r"](\1)", markdown)
    return OUTSIDE.sub(lambda link: link[1] if link[1].strip("`") == link[2] else f"{link[1]} (`{link[2]}`)", markdown)
