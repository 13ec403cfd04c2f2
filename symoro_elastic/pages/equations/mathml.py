"""Convert the LaTeX that `codegen.latex` writes to MathML."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape

from symoro_elastic.codegen.notation import GREEK

_TOKEN = re.compile(r"\\[a-zA-Z]+|\\.|[0-9]+(?:\.[0-9]+)?|[+-] |[{}^_&]|[^\s{}^_&\\]")
_BREAK = re.compile(r"\\begin|\\end|[{}]| (?=[+-] )")
ACCENTS = {"dot": "&dot;", "ddot": "&Dot;", "bar": "&oline;"}
ROWS = {"boldsymbol": "bf", "overline": "over"}
FONTS = {"mathit": "it", "mathrm": "rm", "mathbf": "bf", "operatorname": "rm"}
SPACE = '<mspace width="0.17em"/>'
SIGNS = {
    "=": "<mo>=</mo>",
    "*": "<mo>&lowast;</mo>",
    "-": '<mo form="prefix">&minus;</mo>',
    "+ ": '<mo form="infix" lspace="0.22em" rspace="0.22em">+</mo>',
    "- ": '<mo form="infix" lspace="0.22em" rspace="0.22em">&minus;</mo>',
    ",": '<mo lspace="0em" rspace="0.1em">,</mo>',
    "/": "<mo>/</mo>",
}


def mathml(latex: str) -> str:
    """Return one `<math>` element; raise `ValueError` for LaTeX that `codegen.latex` does not write."""
    return f'<math displaystyle="true">{_Reader(latex).everything()}</math>' if latex else ""


def pieces(latex: str) -> Iterator[str]:
    """Return `<math>` elements of the terms of a sum, so that a page can break the line between them."""
    depth, start = 0, 0
    for found in _BREAK.finditer(latex):
        depth += (found[0] in ("{", r"\begin")) - (found[0] in ("}", r"\end"))
        if found[0] == " " and depth == 0:
            yield mathml(latex[start : found.start()])
            start = found.end()
    yield mathml(latex[start:])


class _Reader:
    def __init__(self, latex: str) -> None:
        self.latex = latex
        self.tokens = _TOKEN.findall(latex)
        self.position = 0

    def everything(self) -> str:
        row = self.row()
        if self.position < len(self.tokens):
            raise self.error_here()
        return row

    def error_here(self) -> ValueError:
        return ValueError(f"{self.peek()!r} is not expected in {self.latex!r}")

    def peek(self) -> str:
        return self.tokens[self.position] if self.position < len(self.tokens) else ""

    def take(self, wanted: str = "") -> str:
        token = self.peek()
        if not token or (wanted and token != wanted):
            raise self.error_here()
        self.position += 1
        return token

    def row(self, *ends: str) -> str:
        items = []
        while self.peek() and self.peek() not in ends:
            items.append(self.with_scripts())
        return "".join(items)

    def with_scripts(self) -> str:
        """Return an item with its superscript and subscript."""
        applied = self.peek() in (r"\sin", r"\cos")
        base = self.item()
        scripts: dict[str, str] = {}
        while self.peek() in ("^", "_"):
            place = self.take()
            scripts[place] = self.group()
        gap = SPACE if applied and self.peek() != "(" else ""
        if not scripts:
            return base + gap
        tag = "msubsup" if len(scripts) == 2 else "msub" if "_" in scripts else "msup"
        return f"<{tag}>{base}{scripts.get('_', '')}{scripts.get('^', '')}</{tag}>{gap}"

    def group(self) -> str:
        """Return the group in braces, as one element."""
        self.take("{")
        content = self.row("}")
        self.take("}")
        return f"<mrow>{content}</mrow>"

    def word(self) -> str:
        """Letters in braces."""
        self.take("{")
        letters = []
        while self.peek() != "}":
            letters.append(self.take().removeprefix("\\"))
        self.take("}")
        return escape("".join(letters))

    def item(self) -> str:
        if self.peek() == "{":
            return self.group()
        token = self.take()
        if token[0].isdigit():
            return f"<mn>{token}</mn>"
        if token[0].isalpha():
            return f"<mi>{token}</mi>"
        if token[0] == "\\":
            return self.command(token[1:])
        if token in "()[]":
            return f'<mo stretchy="false">{token}</mo>'
        if token in SIGNS:
            return SIGNS[token]
        self.position -= 1
        raise self.error_here()

    def command(self, name: str) -> str:
        if name == ",":
            return SPACE
        if name in GREEK or name == "pi":
            return f'<mi class="rm">&{name};</mi>' if name[0].isupper() else f"<mi>&{name};</mi>"
        if name in ACCENTS:
            return f'<mover accent="true">{self.group()}<mo>{ACCENTS[name]}</mo></mover>'
        if name in FONTS:
            return f'<mi class="{FONTS[name]}">{self.word()}</mi>'
        if name == "mathcal":
            return f"<mi>&{self.word()}scr;</mi>"
        if name in ROWS:
            return f'<mrow class="{ROWS[name]}">{self.group()}</mrow>'
        if name in ("sin", "cos", "min", "max"):
            return f'<mi class="rm">{name}</mi>'
        if name == "cdot":
            return "<mo>&middot;</mo>"
        if name == "partial":
            return "<mi>&part;</mi>"
        if name == "frac":
            return f"<mfrac>{self.group()}{self.group()}</mfrac>"
        if name == "sqrt":
            return f"<msqrt>{self.group()}</msqrt>"
        if name == "begin":
            return self.table()
        self.position -= 1
        raise self.error_here()

    def table(self) -> str:
        """Return a matrix in brackets."""
        self.word()
        rows: list[list[str]] = [[]]
        while True:
            rows[-1].append(self.row("&", r"\\", r"\end"))
            mark = self.take()
            if mark == r"\end":
                break
            if mark == r"\\":
                rows.append([])
        self.word()
        cells = "".join("<mtr>" + "".join(f"<mtd>{cell}</mtd>" for cell in row) + "</mtr>" for row in rows)
        return f"<mrow><mo>(</mo><mtable>{cells}</mtable><mo>)</mo></mrow>"
