"""Numbers in C by their names in the machine, declared where they are first used."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.c.lines import INDENT, WIDTH, in_comment
from symoro_elastic.codegen.c.lines import comment as written_as_comment
from symoro_elastic.codegen.package import Constant
from symoro_elastic.codegen.printers import Text
from symoro_elastic.symbolic.expression import Operand


@dataclass(frozen=True)
class Literal:
    """A named number: the text of its magnitude, its name and its meanings."""

    name: str
    text: str
    meanings: tuple[str, ...]


@dataclass(frozen=True)
class _Number:
    """A named number of the machine, or its negative, whose magnitude occurs in equations."""

    constant: Constant
    negative: bool

    @property
    def name(self) -> str:
        return f"minus_{self.constant.name}" if self.negative else self.constant.name


Key = tuple[int | None, str]


class Literals:
    """The named numbers of a function, by joint and by the text of their magnitude."""

    def __init__(
        self,
        constants: Sequence[Constant],
        written: Callable[[Operand], Text | None],
        taken: Collection[str],
        joints: Sequence[str],
        antecedents: Sequence[int],
    ) -> None:
        """Collect the numbers; `written` prints a number in the function's form; names in `taken` are reserved.

        `antecedents` are those of the joints: a joint's equations may contain numbers of joints that it carries.
        """
        self._found: dict[Key, Literal] = {}
        self._carried: dict[int | None, list[int]] = {}
        for joint, antecedent in enumerate(antecedents, start=1):
            self._carried.setdefault(antecedent, []).append(joint)
        groups: dict[Key, list[_Number]] = {}
        for constant in constants:
            text = written(constant.value)
            if text:
                groups.setdefault((constant.joint, text.text), []).append(_Number(constant, text.negative))
        owners: dict[str, Key] = dict.fromkeys(taken, (None, ""))
        for key, group in groups.items():
            ordered = sorted(group, key=lambda number: number.negative)
            free = [number.name for number in ordered if owners.setdefault(number.name, key) == key]
            if free:
                self._found[key] = Literal(free[0], key[1], _meanings(key[0], group, joints))

    def find(self, joint: int | None, text: str) -> Literal | None:
        """The named number with this text: of a joint, else of the machine, else of a joint carried by the joint."""
        for owner in (joint, None, *self._carried.get(joint, ())):
            if (owner, text) in self._found:
                return self._found[owner, text]
        return None


def _meanings(joint: int | None, group: Sequence[_Number], joints: Sequence[str]) -> tuple[str, ...]:
    """Meanings of a number as text; the unit follows the meanings that share it."""
    by_unit: dict[str, dict[str, None]] = {}
    for number in group:
        by_unit.setdefault(number.constant.unit, {}).setdefault(number.constant.meaning)
    texts = [", ".join([*words, unit] if unit else words) for unit, words in by_unit.items()]
    owner = f"{joints[joint - 1]}: " if joint else ""
    reversed_ = ["sign reversed"] if all(number.negative for number in group) else []
    return (owner + texts[0], *texts[1:], *reversed_)


def declaration(literal: Literal, type_: str) -> list[str]:
    """Lines that declare a named number, with its meanings as a comment after it or, if long, above it."""
    line = f"{INDENT}const {type_} {literal.name} = {literal.text};"
    meaning = in_comment("; ".join(literal.meanings))
    if len(line) + len(meaning) + len(" /*  */") <= WIDTH:
        return [f"{line} /* {meaning} */"]
    return [*written_as_comment(meaning, INDENT).split("\n"), line]
