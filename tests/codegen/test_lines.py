"""Long lines of C are broken within their width, where it is read most easily, and hold the same text."""

from __future__ import annotations

import itertools
import re

import pytest

from symoro_elastic.codegen.c.lines import INDENT, WIDTH, comment, statement, with_arguments, wrap_lines

NAMES = [f"variable_{k}" for k in range(30)]
TEXTS = {
    "sum": " + ".join(NAMES),
    "difference": " - ".join(NAMES),
    "product": "*".join(NAMES),
    "quotient": "/".join(NAMES),
    "nested calls": "(".join(NAMES) + ")" * (len(NAMES) - 1),
    "indices": "[".join(NAMES) + "]" * (len(NAMES) - 1),
    "arguments": f"function({', '.join(NAMES)})",
    "products in a sum": " + ".join(f"{x}*({y} - {x})" for x, y in itertools.pairwise(NAMES)),
}


def squeezed(text: str) -> str:
    return re.sub(r"\s+", "", text)


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
@pytest.mark.parametrize("head", ["", "    const double x = ", "    " + "a_long_name_" * 7 + " = "])
def test_lines_are_within_the_width_and_hold_the_same_text(text: str, head: str) -> None:
    broken = statement(head, text)
    assert squeezed(broken) == squeezed(head + text)
    assert max(map(len, broken.split("\n"))) <= WIDTH
    assert wrap_lines(broken) == broken
    indent = head[: len(head) - len(head.lstrip())] + INDENT
    assert all(line.startswith(indent) and line[len(indent)] != " " for line in broken.split("\n")[1:])


def test_lines_are_broken_outside_of_brackets_where_that_suffices() -> None:
    terms = [f"({'*'.join(NAMES[:4])} + {x})" for x in "abc"]
    assert statement("x = ", " + ".join(terms)).split("\n") == [f"x = {terms[0]} + {terms[1]}", f"{INDENT}+ {terms[2]}"]
    assert [line.strip()[0] for line in statement("x = ", TEXTS["sum"]).split("\n")[1:]] == ["+"] * 3


def test_what_fits_stays() -> None:
    exact = "x" * (WIDTH - 5)
    assert statement("y = ", exact + ";") == f"y = {exact};"
    assert statement("y = ", f"{exact};;").startswith("y =\n")
    assert wrap_lines("#define X " + "y" * WIDTH) == "#define X " + "y" * WIDTH
    head, arguments = "void function", ["a" * 50, "b" * 50]
    assert with_arguments(head, arguments) == f"{head}({', '.join(arguments)})"
    assert with_arguments(head, [*arguments, "cc"]).split("\n") == [f"{head}(", f"{INDENT}{', '.join(arguments)}, cc)"]
    assert with_arguments(head, [*arguments, "c" * 50]).split("\n")[1:] == [
        f"{INDENT}{', '.join(arguments)},",
        f"{INDENT}{'c' * 50})",
    ]


def test_comments_are_broken_between_words() -> None:
    text = " ".join(NAMES)
    broken = comment(text, INDENT)
    assert re.sub(r"[\s*/]+", " ", broken).split() == NAMES
    assert max(map(len, broken.split("\n"))) <= WIDTH
    assert wrap_lines(f"x = y; /* {text} */").split("\n")[-1] == "x = y;"
