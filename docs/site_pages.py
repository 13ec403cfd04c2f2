"""Pages of the documentation that are made of the program, and links of pages that leave their folder."""

from __future__ import annotations

import re
from typing import Any

from mkdocs.structure.files import File, Files

from symoro_elastic.reports.models_page import models_page

OUTSIDE = re.compile(r"\[([^\]]+)\]\(\.\./([^)]+)\)")


def on_files(files: Files, config: Any) -> Files:
    """Add the page of models."""
    files.append(File.generated(config, "models.md", content=models_page()))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return a page with the names of files of the repository in the place of links to them."""
    return OUTSIDE.sub(lambda link: link[1] if link[1].strip("`") == link[2] else f"{link[1]} (`{link[2]}`)", markdown)
