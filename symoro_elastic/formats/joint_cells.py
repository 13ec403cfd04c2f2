"""Cells of a table: formulas, and the joint variable with its offset."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import ZERO, Formula, FormulaError
from symoro_elastic.machine.joints import SELECTED, Joint
from symoro_elastic.machine.names import quote

__all__ = ["OTHER", "SELECTED", "cell_of", "formula", "not_alone", "offset_of", "rows_by_name", "split", "whole"]

OTHER = {0: "r", 1: "theta"}

_TOKEN = re.compile(r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[A-Za-z_]\w*|\S", re.ASCII)


def formula(written: str | int, source: str, place: str) -> Formula:
    """Return the formula in a cell of a file; raises `InputError`."""
    try:
        return Formula.parse(" ".join(written.split()) if isinstance(written, str) else written)
    except FormulaError as error:
        prefix = f"{quote(written)}: " if isinstance(written, str) else ""
        raise InputError(source, place, f"{prefix}{error}") from None


def whole(written: str | int, source: str, place: str) -> int:
    """Return the integer in a cell of a file; raises `InputError`."""
    text = str(written) if isinstance(written, str) or abs(written) < 10**6 else "far too large"
    if not text.strip().removeprefix("-").isdecimal() or not text.isascii() or len(text) > 7:
        raise InputError(source, place, f"{quote(text)} is not a whole number, or is too large")
    return int(text)


def rows_by_name(names: Mapping[int, Iterable[str]]) -> dict[str, list[int]]:
    """The rows whose cells hold a name, by name, from the names by row."""
    rows: dict[str, list[int]] = {}
    for j, held in names.items():
        for name in held:
            rows.setdefault(name, []).append(j)
    return rows


def offset_of(cell: Formula, variable: str) -> Formula | None:
    """Return the offset of the joint variable in `cell`: a constant, or a formula of other joints' variables.

    None if the variable is not in it once, as a term of its sum and without a factor.
    """
    text = _without_parentheses(cell)
    before, is_there, after = _around(text, variable)
    if not is_there:
        return None
    if before and not before.endswith("+"):
        return None
    if after and after[0] not in "+-":
        return None
    before = before.removesuffix("+").rstrip()
    if before.startswith("-"):
        before = "-" + before[1:].lstrip()
    if not before and not after:
        return ZERO
    if not before:
        after = after[1:].lstrip() if after[0] == "+" else "-" + after[1:].lstrip()
    return _valid(f"{before} {after}".strip(), variable)


def cell_of(variable: str | None, offset: Formula) -> str:
    """Return the cell with this joint variable and offset, the inverse of `offset_of`."""
    if variable is None:
        return offset.text
    if offset == ZERO:
        return variable
    if offset.text.startswith("-"):
        return f"{variable} - {offset.text[1:]}"
    return f"{variable} + {offset.text}"


def split(joint: Joint, variable: str, source: str, place: str) -> Joint:
    """Return the joint with its variable removed from the cell that sigma selects; raises `InputError`."""
    offset = offset_of(joint.selected, variable)
    if offset is None:
        raise InputError(source, f"{place}, {SELECTED[joint.sigma]}", not_alone(joint.selected, variable))
    return replace(joint.with_selected(offset), variable=variable)


def not_alone(cell: Formula, variable: str) -> str:
    """Return why a joint variable with a factor, or with two occurrences, is invalid."""
    allowed = "alone or plus a constant or a formula of the variables of other joints"
    return f"{quote(cell)} must be the joint variable {variable!r}, {allowed}"


def no_variable(cell: Formula, sigma: int, elsewhere: Collection[str]) -> str:
    """Return the message about a cell without joint variable; `elsewhere` are names in the other cell."""
    what = f"no joint variable in {quote(cell)}, where sigma = {sigma} expects it"
    hint = f"; {min(elsewhere)!r} is in {OTHER[sigma]}, which is for sigma = {1 - sigma}" if elsewhere else ""
    return what + hint


def _without_parentheses(cell: Formula) -> str:
    text = cell.text
    while text.startswith("(") and text.endswith(")"):
        try:
            if Formula.parse(text[1:-1]).tree != cell.tree:
                break
        except FormulaError:
            break
        text = text[1:-1].strip()
    return text


def _around(text: str, variable: str) -> tuple[str, bool, str]:
    """Text before the first `variable` outside parentheses, whether it occurs, and the text after it."""
    depth = 0
    for token in _TOKEN.finditer(text):
        depth += {"(": 1, ")": -1}.get(token[0], 0)
        if token[0] == variable and depth == 0:
            return text[: token.start()].rstrip(), True, text[token.end() :].lstrip()
    return text, False, ""


def _valid(text: str, variable: str) -> Formula | None:
    """Return the formula in `text`, an offset; None if it is invalid, or contains the variable."""
    try:
        offset = Formula.parse(text)
    except FormulaError:
        return None
    return None if variable in offset.names else offset
