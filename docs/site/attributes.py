"""What pages of Python's functions leave out: texts of a value's type in the place of an attribute's own."""

from __future__ import annotations

import inspect
from typing import Any

import griffe


class OwnTexts(griffe.Extension):
    """Attributes whose value has the text of its type (`bool(x) -> bool ...`) have none."""

    def on_attribute_instance(self, *, node: Any, attr: griffe.Attribute, **_: Any) -> None:
        """Drop the text that griffe finds by inspection."""
        if isinstance(node, griffe.ObjectNode) and attr.docstring:
            inherited = inspect.getdoc(type(node.obj))
            if inherited and inspect.cleandoc(attr.docstring.value) == inherited:
                attr.docstring = None
