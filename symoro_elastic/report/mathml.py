"""The LaTeX that `codegen.latex` writes, as MathML: that much of LaTeX and no more."""

from __future__ import annotations

import re
from collections.abc import Iterator
from html import escape

_TOKEN = re.compile(r"\\[a-zA-Z]+|\\.|[0-9]+(?:\.[0-9]+)?|[+-] |[{}^_&]|[^\s{}^_&\\]")
_BREAK = re.compile(r"[{}]| (?=[+-] )")
LETTERS = {
    "alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "epsilon": "ϵ", "zeta": "ζ", "eta": "η", "theta": "θ",
    "kappa": "κ", "mu": "μ", "nu": "ν", "xi": "ξ", "pi": "π", "rho": "ρ", "sigma": "σ", "tau": "τ", "phi": "ϕ",
    "chi": "χ", "psi": "ψ", "omega": "ω",
}  # fmt: skip
CAPITALS = {
    "Gamma": "Γ", "Delta": "Δ", "Theta": "Θ", "Lambda": "Λ", "Xi": "Ξ", "Sigma": "Σ", "Phi": "Φ", "Psi": "Ψ",
    "Omega": "Ω",
}  # fmt: skip
ACCENTS = {"dot": "˙", "ddot": "¨", "bar": "¯", "overline": "¯"}
FONTS = {"mathit": "it", "mathrm": "rm", "mathbf": "bf", "operatorname": "rm"}
SIGNS = {
    "=": "<mo>=</mo>",
    "*": "<mo>∗</mo>",
    "-": '<mo form="prefix">−</mo>',
    "+ ": '<mo form="infix">+</mo>',
    "- ": '<mo form="infix">−</mo>',
}


def mathml(latex: str) -> str:
    """One `<math>` element; raises `ValueError` for LaTeX beyond what equations use."""
    return f'<math displaystyle="true">{_Reader(latex).everything()}</math>'


def pieces(latex: str) -> Iterator[str]:
    """`<math>` elements of the terms of a sum, so that a page can break the line between them."""
    depth, start = 0, 0
    for found in _BREAK.finditer(latex):
        depth += (found[0] == "{") - (found[0] == "}")
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
        row = self.row("")
        if self.position < len(self.tokens):
            raise self.unexpected()
        return row

    def unexpected(self) -> ValueError:
        return ValueError(f"{self.peek()!r} is not expected in {self.latex!r}")

    def peek(self) -> str:
        return self.tokens[self.position] if self.position < len(self.tokens) else ""

    def take(self, wanted: str = "") -> str:
        token = self.peek()
        if not token or (wanted and token != wanted):
            raise self.unexpected()
        self.position += 1
        return token

    def row(self, *ends: str) -> str:
        items = []
        while self.peek() and self.peek() not in ends:
            items.append(self.scripted())
        return "".join(items)

    def scripted(self) -> str:
        """An item with what stands above and below to its right."""
        base = self.item()
        scripts: dict[str, str] = {}
        while self.peek() in ("^", "_"):
            scripts[self.take()] = self.group()
        if len(scripts) == 2:
            return f"<msubsup>{base}{scripts['_']}{scripts['^']}</msubsup>"
        if scripts:
            (kind, script), = scripts.items()
            tag = "msub" if kind == "_" else "msup"
            return f"<{tag}>{base}{script}</{tag}>"
        return base

    def group(self) -> str:
        """What is in braces, as one element."""
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
        if token in "()[],":
            return f'<mo stretchy="false">{token}</mo>'
        if token in SIGNS:
            return SIGNS[token]
        self.position -= 1
        raise self.unexpected()

    def command(self, name: str) -> str:
        if name == ",":
            return '<mspace width="0.17em"/>'
        if name in LETTERS or name in CAPITALS:
            return f"<mi>{LETTERS[name]}</mi>" if name in LETTERS else f'<mi class="rm">{CAPITALS[name]}</mi>'
        if name in ACCENTS:
            return f'<mover accent="true">{self.group()}<mo>{ACCENTS[name]}</mo></mover>'
        if name in FONTS:
            return f'<mi class="{FONTS[name]}">{self.word()}</mi>'
        if name == "boldsymbol":
            return f'<mrow class="bf">{self.group()}</mrow>'
        if name in ("sin", "cos"):
            return f'<mi class="rm">{name}</mi>'
        if name == "cdot":
            return "<mo>·</mo>"
        if name == "frac":
            return f"<mfrac>{self.group()}{self.group()}</mfrac>"
        if name == "sqrt":
            return f"<msqrt>{self.group()}</msqrt>"
        if name == "begin":
            return self.table()
        self.position -= 1
        raise self.unexpected()

    def table(self) -> str:
        """A matrix in brackets."""
        self.word()
        rows = [[]]
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
