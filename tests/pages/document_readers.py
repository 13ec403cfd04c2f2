"""Printed equations and pages, read back without the code that printed them."""

import math
import re
from html.parser import HTMLParser


class Reader:
    """Computes what a printed formula says, given the values of the symbols it uses."""

    FUNCTIONS = {  # noqa: RUF012
        r"\sin": math.sin,
        r"\cos": math.cos,
        r"\operatorname{sign}": lambda x: math.copysign(1.0, x) if x else 0.0,
        r"\operatorname{atan2}": math.atan2,
    }

    def __init__(self, symbols):
        words = [*symbols, *self.FUNCTIONS, r"\frac", r"\sqrt", r"\pi", r"\cdot"]
        longest_first = "|".join(map(re.escape, sorted(words, key=len, reverse=True)))
        self.token = re.compile(rf"\\,|{longest_first}|[0-9]+(?:\.[0-9]+)?|[-+(){{}},^]")
        self.symbols = set(symbols)

    def value(self, latex, values):
        self.tokens = self.token.findall(latex)
        assert "".join(self.tokens).replace(" ", "") == latex.replace(" ", ""), latex
        self.values = values
        self.tokens.append("")
        result = self.sum()
        assert self.tokens == [""], latex
        return result

    def take(self, wanted=None):
        token = self.tokens.pop(0)
        assert wanted in (None, token)
        return token

    def sum(self):
        negative = self.tokens[0] == "-" and self.take()
        total = self.product() * (-1 if negative else 1)
        while self.tokens[0] in ("+", "-"):
            total += self.product() if self.take() == "+" else -self.product()
        return total

    def product(self):
        result = self.power()
        while self.tokens[0] not in ("", "+", "-", ")", "}", ","):
            if self.tokens[0] in (r"\,", r"\cdot"):
                self.take()
            result *= self.power()
        return result

    def power(self):
        base = self.atom()
        return base ** self.exponent() if self.tokens[0] == "^" else base

    def exponent(self):
        self.take("^")
        return self.group()

    def group(self):
        self.take("{")
        value = self.sum()
        self.take("}")
        return value

    def arguments(self):
        self.take("(")
        values = [self.sum()]
        while self.tokens[0] == ",":
            self.take()
            values.append(self.sum())
        self.take(")")
        return values

    def atom(self):
        token = self.tokens[0]
        if token == "(":
            (value,) = self.arguments()
            return value
        self.take()
        if token in self.symbols:
            return self.values[token]
        if token in self.FUNCTIONS:
            exponent = self.exponent() if self.tokens[0] == "^" else 1
            arguments = self.arguments() if self.tokens[0] == "(" else [self.atom()]
            return self.FUNCTIONS[token](*arguments) ** exponent
        if token == r"\frac":
            return self.group() / self.group()
        if token == r"\sqrt":
            return math.sqrt(self.group())
        return math.pi if token == r"\pi" else float(token)


class Page(HTMLParser):
    """Open tags, identifiers and references of a page."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.references, self.text = [], [], [], []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attributes):
        if tag not in ("meta", "wbr", "img"):
            self.open.append(tag)
        for key, value in attributes:
            if key == "id":
                self.ids.append(value)
            if key in ("href", "src", "data", "action", "srcset"):
                self.references.append(value)

    def handle_startendtag(self, tag, attributes):
        assert tag == "mspace"

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)
