"""LaTeX of the names in a program, from the table of quantities; other names as a user writes them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from symoro_elastic.quantities import COEFFICIENT, DERIVATIVE, FUNCTIONS, INTERMEDIATES, Intermediate, citation
from symoro_elastic.symbolic.program import Program

_LETTERS = """
    alpha beta gamma delta epsilon zeta eta theta kappa lambda mu nu xi rho sigma tau phi chi psi omega
    Gamma Delta Theta Lambda Xi Sigma Phi Psi Omega
"""
GREEK = frozenset(_LETTERS.split())


@dataclass(frozen=True)
class Meaning:
    """An entry of the list of symbols."""

    symbol: str
    paper: str
    equations: str
    meaning: str


class Notation:
    """LaTeX of the names of a program; symbols are unique."""

    def __init__(self, program: Program) -> None:
        self.outputs = {output.name for output in program.outputs}
        self.used: set[Intermediate] = set()
        self.parts = False
        self.symbols: dict[str, str] = {}
        arguments = [name for argument in program.inputs for name in argument.symbols]
        assigned = [s.name for s in (*program.once, *program.statements)]
        self._users, self._assigned = {*arguments, *program.used}, set(assigned)
        self._claim({name: self.quantity(name) for name in (*assigned, *arguments)})
        self._claim({name: user_symbol(name) for name in (*arguments, *sorted(program.used), *assigned)})

    def __getitem__(self, name: str) -> str:
        if name not in self.symbols:
            self._claim({name: self.quantity(name) or user_symbol(name)})
        return self.symbols[name]

    def _claim(self, wanted: Mapping[str, str]) -> None:
        used = set(self.symbols.values())
        for name, symbol in wanted.items():
            if symbol and name not in self.symbols:
                self.symbols[name] = literal(name) if symbol in used else symbol
                used.add(self.symbols[name])

    def quantity(self, name: str) -> str:
        """Symbol of a quantity of the table; empty for any other name."""
        function, _, argument = name.partition("_")
        if function in FUNCTIONS and argument in self._users | self._assigned:
            return f"{FUNCTIONS[function]}_{{{self.quantity(argument) or user_symbol(argument)}}}"
        if function == DERIVATIVE:
            return self._derivative(argument)
        if function == COEFFICIENT:
            return self._coefficient(argument)
        for row in self._rows(name):
            match = row.match(name)
            if match:
                self.used.add(row)
                self.parts |= bool(match["part"])
                return row.symbol(match["j"], match.groupdict().get("c") or "", match["part"])
        return ""

    def _rows(self, name: str) -> Iterator[Intermediate]:
        """Entries of the table of quantities that apply to this program and match the beginning of a name."""
        letters = re.match("[A-Za-z]*", name, re.ASCII)[0]  # type: ignore[index]
        for row in INTERMEDIATES:
            if row.name == letters and (not row.of_results or self.outputs & {*row.of_results}):
                yield row

    def _derivative(self, name: str) -> str:
        """Symbol of a derivative, variable first: `q2_f3_6` is the derivative of `f3_6` by q2."""
        for variable in self._users:
            quantity = self.quantity(name.removeprefix(f"{variable}_")) if name.startswith(f"{variable}_") else ""
            if quantity:
                return rf"\partial_{{{self.quantity(variable) or user_symbol(variable)}}}{quantity}"
        return ""

    def _coefficient(self, name: str) -> str:
        """Symbol of a coefficient of t^k, k first: `2_f3_6` is the coefficient of t^2 of f3_6."""
        order, _, of = name.partition("_")
        quantity = self.quantity(of) or user_symbol(of)
        return rf"[{quantity}]_{{t^{{{order}}}}}"

    def meanings(self) -> Iterator[Meaning]:
        """The quantities that occur in the program, in the order of the table."""
        for row in INTERMEDIATES:
            if row in self.used:
                yield Meaning(row.symbol(), row.definition, citation(row.equations), row.meaning)


def user_symbol(name: str) -> str:
    r"""LaTeX symbol of a user's name: t1 is t_{1}, RL4 \mathit{RL}_{4}, k_tool k_{\mathrm{tool}}."""
    match = re.fullmatch("([A-Za-z]+)(?:_?([0-9]+)|_([A-Za-z]+[0-9]*))?", name, re.ASCII)
    if not match:
        return literal(name)
    letters, number, word = match.groups()
    base = letters if len(letters) == 1 else rf"\{letters}" if letters in GREEK else rf"\mathit{{{letters}}}"
    below = number or (rf"\mathrm{{{word}}}" if word else "")
    return base + (f"_{{{below}}}" if below else "")


def literal(name: str) -> str:
    """LaTeX of a name exactly as in the machine's file."""
    escaped = name.replace("_", r"\_")
    return rf"\mathit{{{escaped}}}"
