"""The equations of a model as a document: LaTeX or a web page."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from html import escape
from itertools import groupby
from typing import Any

from symoro_elastic.codegen.closed_form import closed_equations
from symoro_elastic.codegen.latex import Equation, Solution, Stretch, number, solution
from symoro_elastic.codegen.notation import GREEK
from symoro_elastic.codegen.package import Function, Package, ParameterValue
from symoro_elastic.codegen.package_context import count_text
from symoro_elastic.codegen.templates import render
from symoro_elastic.symbolic.program import Section

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
INNER = re.compile(r'<math displaystyle="true">(.*)</math>', re.DOTALL)
TAG = re.compile(r"<(/?)m\w+[^>]*?(/?)>")
COMPOSED = re.compile(r"<(msub|msup|msubsup|mover|mrow)\b.*</\1>", re.DOTALL)

ONCE, RESULTS = "Once for each parameter set", "Results"
CONVENTIONS = (
    "Equation numbers are those of Khalil and Gautier. Components of vectors, wrenches and inertias of body j are "
    "given in frame j, so the paper's left superscript j is left out. Screws and wrenches have their linear part "
    "first: component k runs from 1 to 6. A raised letter marks a part of a quantity that is used more than once; "
    "what is overlined is one product, computed once."
)
OF_LOOPS = " Equations (L1) to (L42) are those of couplings and closed loops: docs/loop_equations.md."


def mathml(latex: str) -> str:
    """Return one `<math>` element; raise `ValueError` for LaTeX that `codegen.latex` does not write."""
    return f'<math displaystyle="true">{_Reader(latex).everything()}</math>' if latex else ""


def pieces(latex: str) -> Iterator[str]:
    """Return `<math>` elements of the terms of a sum, between which a page can break the line."""
    depth, start = 0, 0
    for match in _BREAK.finditer(latex):
        depth += (match[0] in ("{", r"\begin")) - (match[0] in ("}", r"\end"))
        if match[0] == " " and depth == 0:
            yield mathml(latex[start : match.start()])
            start = match.end()
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


@dataclass(frozen=True)
class Markup:
    """Rules of a kind of document for text, formulas, and right-hand sides."""

    text: Callable[[str], str]
    math: Callable[[str], str]
    sum: Callable[[str], str]
    formula: Callable[[str], str]
    power: str


_TEX_SIGNS = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    **{c: "\\" + c for c in "#$%&_{}"},
}


def tex_text(text: str) -> str:
    """Return text escaped for LaTeX; characters without a glyph in its usual fonts become question marks."""
    return "".join(_TEX_SIGNS.get(c, c if c.isprintable() and ord(c) < 0x180 else "?") for c in text)


TEX = Markup(tex_text, str, str, "${}$".format, r"\textsuperscript{{{}}}")
HTML = Markup(escape, mathml, lambda latex: "<wbr>".join(pieces(latex)), mathml, "<sup>{}</sup>")


def latex_document(package: Package, *functions: Function) -> str:
    """Return a standalone LaTeX document with the equations of functions; it needs amsmath and geometry."""
    return _document("latex/equations.tex.j2", "latex/equation_parts.tex.j2", package, functions, TEX)


def latex_equations(package: Package, function: Function) -> str:
    """Return the equations as one array of LaTeX for notebooks, written out if they are short."""
    solved = solution(package, function)
    steps = [e for stretch in (*solved.once, *solved.steps) for e in stretch.equations]
    lines = closed_equations(package, function, solved.notation) or [*steps, *solved.results]
    rows = " \\\\\n".join(f"{e.left} &= {e.right}" for e in lines)
    return f"$\\displaystyle \\begin{{aligned}}\n{rows}\n\\end{{aligned}}$"


def html_page(package: Package, *functions: Function, picture: str = "") -> str:
    """Return a standalone web page with the equations of functions, as MathML, below a picture in SVG."""
    return _document("html/equations.html.j2", "html/equation_parts.html.j2", package, functions, HTML, picture=picture)


def _document(
    template: str, parts: str, package: Package, functions: Sequence[Function], markup: Markup, **more: str
) -> str:
    """Return a document with the parts of functions; names of places begin with the function's name if several."""
    prefixes = [f"{function.name}-" for function in functions] if len(functions) > 1 else [""]
    models = [content(package, function, markup, p) for function, p in zip(functions, prefixes, strict=True)]
    written = [{**model, "parts": render(parts, **model).strip("\n")} for model in models]
    titles = ", ".join(function.title for function in functions)
    return render(template, title=markup.text(f"{package.name}: {titles}"), models=written, **more)


def content(package: Package, function: Function, markup: Markup, prefix: str = "") -> dict[str, Any]:
    """Return the data of a function for the templates; names of places on a page begin with `prefix`."""
    solved = solution(package, function)
    chapters = _chapters(solved, package, markup, prefix)
    short = closed_equations(package, function, solved.notation)
    context = {
        "prefix": prefix,
        "title": markup.text(f"{package.name}: {function.title}"),
        "summary": [markup.text(line) for line in _summary(package, function)],
        "conventions": markup.text(CONVENTIONS + (OF_LOOPS if package.dependent is not None else "")),
        "joints": _joints(package, solved, chapters, markup),
        "symbols": _symbols(function, solved, markup),
        "parameters": _parameters(package, function, solved, markup),
        "short": _lines(short, markup),
        "cost": markup.text(f"Computed by the equations below: {_counts(function)}."),
        "chapters": chapters,
    }
    return with_links(context, prefix) if markup is HTML else context


def _summary(package: Package, function: Function) -> list[str]:
    lines = [f"Equations {function.equations}. {_counts(function)} (x products and divisions, + sums and differences)."]
    return lines + ([package.scene] if package.scene else [])


def _counts(function: Function) -> str:
    """Operations of a call, and those of the parameter sets."""
    program = function.program
    once = f"; {count_text(program.count_once)} once for each parameter set" if program.once else ""
    return f"{count_text(program.count)} a call{once}"


def _lines(equations: Sequence[Equation], markup: Markup) -> list[dict[str, str]]:
    return [{"left": markup.math(e.left), "right": markup.sum(e.right)} for e in equations]


def _chapters(solved: Solution, package: Package, markup: Markup, prefix: str) -> list[dict[str, Any]]:
    """Group sections by title; those of parameters only come first, results last."""
    chapters: list[tuple[str, list[dict[str, Any]]]] = []
    if solved.once:
        chapters.append((ONCE, [_stretch(s, f"{s.section.title}, ", package, markup) for s in solved.once]))
    for title, group in groupby(solved.steps, key=lambda stretch: stretch.section.title):
        chapters.append((title, [_stretch(stretch, "", package, markup) for stretch in group]))
    if solved.results:
        chapters.append((RESULTS, [_stretch(Stretch(Section(""), solved.results), "", package, markup)]))
    for k, (_, stretches) in enumerate(chapters, start=1):
        for m, stretch in enumerate(stretches, start=1):
            stretch["anchor"] = f"{prefix}part{k}-{m}"
    return [
        {"title": markup.text(title), "anchor": f"{prefix}part{k}", "stretches": stretches}
        for k, (title, stretches) in enumerate(chapters, start=1)
    ]


def _stretch(stretch: Stretch, before: str, package: Package, markup: Markup) -> dict[str, Any]:
    joint = stretch.section.joint
    title = f"{before}joint {joint}, {package.joint_names[joint - 1]}" if joint else before.removesuffix(", ")
    return {
        "joint": joint,
        "title": markup.text(title[:1].upper() + title[1:]),
        "equations": markup.text(stretch.section.equations),
        "lines": _lines(stretch.equations, markup),
    }


def _joints(
    package: Package, solved: Solution, chapters: Sequence[dict[str, Any]], markup: Markup
) -> list[dict[str, Any]]:
    """Numbers, names, kinds and variables of the joints, with links to their equations."""
    axes = {axis.name: axis for axis in (*package.axes, *(package.dependent or ()))}
    kinds = dict(package.following) | {axis.name: axis.kind for axis in package.axes}
    kinds |= {axis.name: f"{axis.kind}, given by a loop" for axis in package.dependent or ()}
    joints = []
    for number_, name in enumerate(package.joint_names, start=1):
        axis = axes.get(name)
        variable, _, unit = (axis.unit if axis else "").partition(", ")
        links = [[s for s in chapter["stretches"] if s["joint"] == number_] for chapter in chapters]
        joints.append(
            {
                "number": number_,
                "name": markup.text(name),
                "kind": markup.text(kinds.get(name, "fixed")),
                "variable": markup.math(solved.notation[variable]) if axis else "",
                "unit": unit,
                "links": [
                    {"anchor": x[0]["anchor"], "count": sum(len(s["lines"]) for s in x)} if x else {} for x in links
                ],
            }
        )
    return joints


def _symbols(function: Function, solved: Solution, markup: Markup) -> list[dict[str, str]]:
    """The quantities in the equations, then the results."""
    rows = [(row.symbol, row.paper, markup.text(row.meaning), row.equations) for row in solved.notation.meanings()]
    for result in function.results:
        rows.append((result.quantity.letter, "", _with_units(result.meaning, markup), function.equations))
    return [
        {
            "here": markup.math(here),
            "paper": markup.math(paper),
            "meaning": meaning,
            "equations": markup.text(equations),
        }
        for here, paper, meaning, equations in rows
    ]


def _parameters(package: Package, function: Function, solved: Solution, markup: Markup) -> list[dict[str, str]]:
    """Symbol, name, value and unit of the parameters in the equations."""
    return [
        {
            "symbol": markup.math(solved.notation[parameter.name]),
            "name": markup.text(parameter.name),
            "value": _value(parameter, markup),
        }
        for parameter in package.parameters
        if parameter.name in function.program.used
    ]


def _value(parameter: ParameterValue, markup: Markup) -> str:
    """Return ` = 2.5 kg`; without a value the unit alone, in brackets."""
    unit = _with_units(parameter.unit, markup)
    if math.isnan(parameter.value):
        return f" ({unit})" if unit else ""
    return f" = {markup.formula(number(Fraction(repr(parameter.value))).signed())} {unit}".rstrip()


def _with_units(text: str, markup: Markup) -> str:
    """Text in which the 2 of `rad/s2` is raised."""
    parts = re.split(r"(?<=[A-Za-z])([0-9])(?![A-Za-z0-9])", text)
    return "".join(markup.power.format(part) if k % 2 else markup.text(part) for k, part in enumerate(parts))


Content = dict[str, Any]


# Symbols of printed equations linked to where they are defined.
def with_links(content: Content, prefix: str) -> Content:
    """Return the content of a page with names for its lines and parameters, and symbols linked to them."""
    lines = [*_equation_lines(content)]
    for k, line in enumerate(lines, start=1):
        line["anchor"] = f"{prefix}line{k}"
    for k, line in enumerate(content["short"], start=1):
        line["anchor"] = f"{prefix}written{k}"
    for k, parameter in enumerate(content["parameters"], start=1):
        parameter["anchor"] = f"{prefix}parameter{k}"
    defined = {symbol: x["anchor"] for x in content["parameters"] if (symbol := _symbol(x["symbol"]))}
    defined |= {symbol: line["anchor"] for line in lines if (symbol := _symbol(line["left"]))}
    for line in (*lines, *content["short"]):
        line["right"] = link_symbols(line["right"], defined)
    return content


def link_symbols(formula: str, defined: Mapping[str, str]) -> str:
    """Return a formula in MathML whose symbols link to the elements that define them; the outermost symbols only."""
    parts, end = [], 0
    for start, stop in _elements(formula):
        if start >= end and (anchor := defined.get(formula[start:stop])):
            parts += [formula[end:start], f'<mrow data-of="{anchor}">', formula[start:stop], "</mrow>"]
            end = stop
    return "".join([*parts, formula[end:]])


def _elements(formula: str) -> list[tuple[int, int]]:
    """Begin and end of elements, in order of their begin."""
    elements: list[tuple[int, int]] = []
    opened: list[int] = []
    for tag in TAG.finditer(formula):
        if tag[1]:
            elements.append((opened.pop(), tag.end()))
        elif not tag[2]:
            opened.append(tag.start())
    return sorted(elements)


def _equation_lines(content: Content) -> Iterator[dict[str, str]]:
    chapters: Sequence[Content] = content["chapters"]
    for chapter in chapters:
        for stretch in chapter["stretches"]:
            yield from stretch["lines"]


def _symbol(math: str) -> str:
    """The inner MathML of a <math> element if it is a single symbol, to find it within formulas; else empty."""
    match = INNER.fullmatch(math)
    return match[1] if match and COMPOSED.fullmatch(match[1]) else ""
