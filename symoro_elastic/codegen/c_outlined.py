"""Repeated blocks of a long model as static functions of C, and the calls of them."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.c_function import SINCOS, CFunction
from symoro_elastic.codegen.c_lines import INDENT, comment, statement, with_arguments
from symoro_elastic.codegen.outlined import NUMBERS, SPILL, Call, Outline, Outlined, Pointer
from symoro_elastic.symbolic.program import Section, by_section

LONGEST_NAME = 24


@dataclass(frozen=True)
class OutlinedText:
    """A static function: its name, head, body, and the names of its arguments."""

    name: str
    head: str
    body: str
    pointers: dict[str, Pointer]


class COutline:
    """The functions of an outline and the calls of them, as text."""

    def __init__(self, function: CFunction, outline: Outline) -> None:
        self.function, self.outline = function, outline
        self.texts = [self._text(k, one) for k, one in enumerate(outline.functions)]

    def call(self, call: Call) -> str:
        """A call, below a comment that says whose work it is."""
        text, block = self.texts[call.function], self.outline.functions[call.function].blocks[call.number]
        work = comment(f"{self._work(self._sections(block.first, block.size))}.", INDENT)
        arguments = [self._place(text, pointer, call.number) for pointer in text.pointers.values()]
        return f"{work}\n{with_arguments(f'{INDENT}{text.name}', arguments, ');')}"

    def tables(self) -> Iterator[str]:
        """Lines that define the numbers of all calls."""
        for text, outlined in zip(self.texts, self.outline.functions, strict=True):
            numbers = [self.function.literals[name].text for row in outlined.numbers for name in row]
            if numbers:
                head = f"{INDENT}static const {self.function.form.real} {text.name}_numbers[{len(numbers)}] = "
                yield statement(head, f"{{{', '.join(numbers)}}};")

    def _place(self, text: OutlinedText, pointer: Pointer, number: int) -> str:
        start = pointer.starts[number]
        if pointer.array == "p":
            return f"p + {list(self.function.indices.values())[start]}"
        array = f"{text.name}_numbers" if pointer.array == NUMBERS else pointer.array
        return f"{array} + {start}" if start else array

    def _sections(self, first: int, size: int) -> list[Section]:
        steps = self.function.steps[first : first + size]
        return [section for section, _ in by_section(step.statement for step in steps)]

    def _text(self, position: int, outlined: Outlined) -> OutlinedText:
        first, function = outlined.blocks[0], self.function
        sections = self._sections(first.first, first.size)
        name = f"{function.name}_{_short(sections[0].title)}_{position + 1}"
        pointers = self._named((*outlined.read, outlined.written))
        types = {SPILL: function.form.number, **{a.name: a.type for a in function.read}}
        declared = [f"const {types.get(p.array, function.form.real)} *{n}" for n, p in pointers.items()]
        declared[-1] = declared[-1].removeprefix("const ")
        times = len(outlined.blocks)
        about = f"{self._work(sections)}. Called {times} times: names are those of the first call."
        lines = [comment(about, INDENT), *self._lines(outlined, pointers)]
        return OutlinedText(name, with_arguments(f"void {name}", declared), "\n".join(lines), pointers)

    def _named(self, pointers: Sequence[Pointer]) -> dict[str, Pointer]:
        """Pointers by names of their own: that of the array, or of the first variable among those handed on."""
        arrays = {array.name for array in self.function.read}
        times = Counter(pointer.array for pointer in pointers)
        named: dict[str, Pointer] = {}
        for pointer in pointers:
            name = pointer.array
            if name not in arrays or times[name] > 1:
                name = _first(pointer, "to" if pointer is pointers[-1] else "from")
            while name in named or name in self.function.operands:
                name += "_"
            named[name] = pointer
        return named

    def _lines(self, outlined: Outlined, pointers: dict[str, Pointer]) -> list[str]:
        """Entries read, statements, entries written."""
        function, first = self.function, outlined.blocks[0]
        *read, (target, written) = pointers.items()
        lines = [line for name, pointer in read for line in self._read(name, pointer)]
        steps = function.steps[first.first : first.first + first.size]
        lines += function.writer.statements([step.statement for step in steps], outlined.numbers[0])
        angles = {entry: f"{n}[{k}]" for n, p in read if p.array in SINCOS for entry, k in p.entries.items()}
        lines = [re.sub(r"\b(?:sine|cosine)\[\d+\]", lambda found: angles[found[0]], line) for line in lines]
        return [*lines, "", *(f"{INDENT}{target}[{k}] = {name};" for name, k in written.entries.items())]

    def _read(self, name: str, pointer: Pointer) -> list[str]:
        if pointer.array in SINCOS:
            return []
        form = self.function.form
        own = {SPILL: "{array}[{k}]", NUMBERS: "{array}[{k}]", "p": form.load_parameter, "c": form.load_parameter}
        entries = {entry: str(k) for entry, k in sorted(pointer.entries.items(), key=lambda entry: entry[1])}
        return self.function.writer.unpack({name: entries}, entries, {name: own.get(pointer.array, form.load)})

    def _work(self, sections: Sequence[Section]) -> str:
        """`Forward recursion: velocities, joints 4 to 6 [7], [14]`."""
        groups = itertools.groupby(sections, lambda section: (section.title, section.equations))
        texts = []
        for (title, equations), group in groups:
            joints = [section.joint for section in group if section.joint is not None]
            texts.append(f"{title}{_joints(joints)} {equations}".rstrip())
        return "; ".join(dict.fromkeys(texts))


def _first(pointer: Pointer, word: str) -> str:
    """A name after the first entry: `from_w5_x`."""
    if pointer.array == NUMBERS:
        return NUMBERS
    first = min(pointer.entries, key=lambda name: pointer.entries[name])
    return f"{word}_{re.sub(r'[^0-9A-Za-z]+', '_', first).rstrip('_')}"


def _joints(joints: Sequence[int]) -> str:
    if not joints:
        return ""
    return f", joint {joints[0]}" if joints[0] == joints[-1] else f", joints {joints[0]} to {joints[-1]}"


def _short(title: str) -> str:
    """A title as part of a name: `forward_velocities`."""
    words = re.split(r",| and ", title.replace("recursion: ", ""))[0]
    return re.sub(r"\W+", "_", words.lower())[:LONGEST_NAME].strip("_")
