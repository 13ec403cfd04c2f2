"""The functions of a model as C text: heads and bodies for the templates."""

from __future__ import annotations

import itertools
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from symoro_elastic.codegen.c.function import SINCOS, Array, CFunction, PartText
from symoro_elastic.codegen.c.lines import INDENT, comment, statement, with_arguments
from symoro_elastic.codegen.guaranteed import Guaranteed, conditions
from symoro_elastic.codegen.outlined import NUMBERS, SPILL, Call, Outline, Outlined, Pointer
from symoro_elastic.codegen.package_context import function_context
from symoro_elastic.symbolic.program import Section, by_section

LONGEST_NAME = 24

LARGE_STACK = 64_000


@dataclass(frozen=True)
class Routine:
    """A function of C: its head without `static`, its body, lines of the preprocessor before and after it."""

    head: str
    body: str
    is_static: bool = False
    opening: str = ""
    closing: str = ""


@dataclass(frozen=True)
class FunctionText:
    """A model: its comment, the heads of the functions that users call, and all functions in order of definition.

    `constants` is the macro that counts what `_prepare` computes, empty where no work depends on parameters only.
    """

    name: str
    title: str
    counts: str
    documented: tuple[str, ...]
    prototype: str
    constants: str
    constant_count: int
    prepare: str
    prepared: str
    in_box: Routine | None
    routines: tuple[Routine, ...]


def function_text(function: CFunction, in_lanes: CFunction | None = None) -> FunctionText:
    """Return the C text of a model for one state; `in_lanes` is the variant for compilers with vectors."""
    about, stack = function_context(function.function), function.stack()
    main = head(function.name, function.signature, function.form.states)
    guaranteed = function.function.guaranteed.get(function.precision.name)
    working_name = f"{function.name}_prepared" if function.c else function.name
    in_two_steps = (Routine(main, _in_two_steps(function)),) if function.c else ()
    return FunctionText(
        name=function.name,
        title=f"{about['title']} {about['equations']}.",
        counts=about["counts"] + (f"; {stack // 1000} kB of stack" if stack > LARGE_STACK else ""),
        documented=(*about["documented"], *(guaranteed.lines if guaranteed else ())),
        prototype=main,
        constants=function.c[0].size if function.c else "",
        constant_count=len(function.constants),
        prepare=head(f"{function.name}_prepare", of_preparing(function)),
        prepared=head(f"{function.name}_prepared", function.arrays, function.form.states),
        in_box=in_box(function, guaranteed) if guaranteed else None,
        routines=(*preparing(function), *_either(function, in_lanes, working_name), *in_two_steps),
    )


def _either(function: CFunction, in_lanes: CFunction | None, name: str) -> list[Routine]:
    """The C functions of a model; under #ifdef, the variant with vectors replaces them."""
    routines, vectors = working(function, name), working(in_lanes, name) if in_lanes else []
    if not vectors:
        return routines
    vectors[0] = replace(vectors[0], opening="#ifdef CONGRUENT_IN_LANES")
    routines[0] = replace(routines[0], opening="#else")
    routines[-1] = replace(routines[-1], closing="#endif")
    return [*vectors, *routines]


def in_box(function: CFunction, guaranteed: Guaranteed) -> Routine:
    """The C function that tests whether arguments are in the operating range of a guarantee."""
    arrays = [*function.inputs, function.p]
    unused = [f"{INDENT}(void){array.name};" for array in arrays if array.name not in guaranteed.arguments]
    cast = "" if function.precision.state == "double" else "(double)"
    joined = f"\n{INDENT * 2}&& ".join(conditions(guaranteed.ranges, cast)) or "1"
    main = with_arguments(f"int {function.name}_in_box", [array.declared() for array in arrays])
    return Routine(main, "\n".join([*unused, f"{INDENT}return {joined};"]))


def head(name: str, arrays: Sequence[Array], states: str = "") -> str:
    """Head of a C function without the end of its last line; batch functions begin with the number of states."""
    declared = [f"size_t {states}", *(a.pointer() for a in arrays)] if states else [a.declared() for a in arrays]
    return with_arguments(f"void {name}", declared)


def working(function: CFunction, name: str) -> list[Routine]:
    """The C function that computes a model, preceded by static functions for its parts if it is long."""
    parts, states = function.part_texts(), function.form.states
    unused = [*([states] if states else []), *function.unused_arrays()]
    first = [f"{INDENT}(void){name};" for name in unused] + _angles(function)
    if len(parts) == 1:
        return [Routine(head(name, function.arrays, states), "\n".join([*first, parts[0].body]))]
    spill = [_declaration(function.form.number, SPILL, str(function.slots))] if function.slots else []
    routines, calls = _in_parts(name, parts, states)
    if function.outline:
        routines, calls = _routines(function, function.outline, routines, calls)
    return [*routines, Routine(head(name, function.arrays, states), "\n".join([*first, *spill, *calls]))]


def _routines(
    function: CFunction, outline: Outline, routines: Sequence[Routine], calls: Sequence[str]
) -> tuple[list[Routine], list[str]]:
    """Functions for repeated blocks and for the parts between them, and the calls of both in order."""
    text, of_parts = COutline(function, outline), iter(calls)
    own = [Routine(routine.head, routine.body, True) for routine in text.texts]
    in_order = [text.call(piece) if isinstance(piece, Call) else next(of_parts) for piece in outline.pieces]
    return [*own, *routines], [*text.tables(), *in_order]


def _in_parts(name: str, parts: Sequence[PartText], states: str = "") -> tuple[list[Routine], list[str]]:
    """Static functions for the parts of a model, and the calls of these functions."""
    names = [f"{name}_part{k}" for k in range(1, len(parts) + 1)]
    unused = [f"{INDENT}(void){states};\n"] if states else []
    routines = [
        Routine(head(n, p.arrays, states), "".join([*unused, p.body]), True) for n, p in zip(names, parts, strict=True)
    ]
    return routines, [call(n, p.arrays, states) for n, p in zip(names, parts, strict=True)]


def _angles(function: CFunction) -> list[str]:
    """Lines that compute the sines and cosines of joint variables, their multiples and sums."""
    angles, type_ = function.angle_texts(), function.form.angle
    if not angles:
        return []
    return [
        statement(f"{INDENT}const {type_} angle[{len(angles)}] = ", f"{{{', '.join(angles)}}};"),
        *(_declaration(type_, name, str(len(angles))) for name in SINCOS),
        *(statement("", INDENT + line) for line in function.form.sincos(angles, len(function.steps))),
        "",
    ]


def _declaration(type_: str, name: str, size: str) -> str:
    return f"{INDENT}{type_} {name}[{size}];"


def call(name: str, arrays: Sequence[Array], states: str = "") -> str:
    """Text of a call that passes on arrays of the calling function by name."""
    return with_arguments(f"{INDENT}{name}", [*([states] if states else []), *(a.name for a in arrays)], ");")


def of_preparing(function: CFunction) -> list[Array]:
    """The arrays of the function that computes parameter-only values."""
    return [function.p, *function.c_written]


def preparing(function: CFunction) -> list[Routine]:
    """The function that computes parameter-only values, after its parts; empty without such values."""
    if not function.c:
        return []
    name, parts = f"{function.name}_prepare", function.once_texts()
    main = head(name, of_preparing(function))
    if len(parts) == 1:
        return [Routine(main, parts[0].body)]
    spill = [_declaration(function.form.real, SPILL, str(function.once_slots))] if function.once_slots else []
    routines, calls = _in_parts(name, parts)
    return [*routines, Routine(main, "\n".join([*spill, *calls]))]


def _in_two_steps(function: CFunction) -> str:
    """Body of the function that computes parameter-only values, then calls the function that uses them."""
    c = function.c[0]
    return "\n".join(
        [
            _declaration(c.type, c.name, c.size),
            call(f"{function.name}_prepare", of_preparing(function)),
            call(f"{function.name}_prepared", function.arrays),
        ]
    )


# Repeated blocks of a long model as static functions of C, and the calls of them.
@dataclass(frozen=True)
class OutlinedText:
    """A static function for repeated blocks: name, head, body, pointers by argument, if it needs the state count."""

    name: str
    head: str
    body: str
    pointers: dict[str, Pointer]
    has_states: bool


class COutline:
    """The C functions for repeated blocks of an outline, and their calls, as text."""

    def __init__(self, function: CFunction, outline: Outline) -> None:
        self.function, self.outline = function, outline
        self.texts = [self._text(k, one) for k, one in enumerate(outline.functions)]

    def call(self, call: Call) -> str:
        """Text of a call, below a comment that names its section."""
        text, block = self.texts[call.function], self.outline.functions[call.function].blocks[call.number]
        work = comment(f"{self._work(self._sections(block.first, block.size))}.", INDENT)
        arguments = [self._place(text, pointer, call.number) for pointer in text.pointers.values()]
        arguments = [self.function.form.states, *arguments] if text.has_states else arguments
        return f"{work}\n{with_arguments(f'{INDENT}{text.name}', arguments, ');')}"

    def tables(self) -> Iterator[str]:
        """Lines that define tables of the numbers in all calls."""
        for text, outlined in zip(self.texts, self.outline.functions, strict=True):
            numbers = [self.function.literals[name].text for row in outlined.numbers for name in row]
            if numbers:
                head = f"{INDENT}static const {self.function.type_of(NUMBERS)} {text.name}_numbers[{len(numbers)}] = "
                yield statement(head, f"{{{', '.join(numbers)}}};")

    def _place(self, text: OutlinedText, pointer: Pointer, number: int) -> str:
        start = pointer.starts[number]
        if pointer.array == "p":
            return f"p + {list(self.function.indices.values())[start]}"
        array = f"{text.name}_numbers" if pointer.array == NUMBERS else pointer.array
        apart = f"{start}*{self.function.form.states}" if self._is_of_states(pointer) else f"{start}"
        return f"{array} + {apart}" if start else array

    def _is_of_states(self, pointer: Pointer) -> bool:
        """Whether the entries of a pointer's array are separated by the number of states."""
        return bool(self.function.form.states) and pointer.array in self.function.entries

    def _sections(self, first: int, size: int) -> list[Section]:
        steps = self.function.steps[first : first + size]
        return [section for section, _ in by_section(step.statement for step in steps)]

    def _text(self, position: int, outlined: Outlined) -> OutlinedText:
        first, function = outlined.blocks[0], self.function
        sections = self._sections(first.first, first.size)
        name = f"{function.name}_{_short(sections[0].title)}_{position + 1}"
        pointers = self._by_name((*outlined.read, outlined.written))
        declared = [f"const {function.type_of(p.array)} *{n}" for n, p in pointers.items()]
        declared[-1] = declared[-1].removeprefix("const ")
        has_states = any(map(self._is_of_states, pointers.values()))
        declared = [f"size_t {function.form.states}", *declared] if has_states else declared
        times = len(outlined.blocks)
        about = f"{self._work(sections)}. Called {times} times: names are those of the first call."
        lines = [comment(about, INDENT), *self._lines(outlined, pointers)]
        return OutlinedText(name, with_arguments(f"void {name}", declared), "\n".join(lines), pointers, has_states)

    def _by_name(self, pointers: Sequence[Pointer]) -> dict[str, Pointer]:
        """Pointers by unique names, derived from the array or from the first variable passed."""
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
        """Lines of a function's body: entries read, statements, entries written."""
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
        function, form = self.function, self.function.form
        own = {SPILL: "{array}[{k}]", NUMBERS: "{array}[{k}]", "p": form.load_parameter, "c": form.load_parameter}
        entries = {entry: str(k) for entry, k in sorted(pointer.entries.items(), key=lambda entry: entry[1])}
        writer = function.once_writer if pointer.array in (NUMBERS, "p", "c") else function.writer
        return writer.unpack({name: entries}, entries, {name: own.get(pointer.array, form.load)})

    def _work(self, sections: Sequence[Section]) -> str:
        """Description of sections: `Forward recursion: velocities, joints 4 to 6 [7], [14]`."""
        groups = itertools.groupby(sections, lambda section: (section.title, section.equations))
        texts = []
        for (title, equations), group in groups:
            joints = [section.joint for section in group if section.joint is not None]
            texts.append(f"{title}{_joints(joints)} {equations}".rstrip())
        return "; ".join(dict.fromkeys(texts))


def _first(pointer: Pointer, word: str) -> str:
    """Name of a pointer after its first entry: `from_w5_x`."""
    if pointer.array == NUMBERS:
        return NUMBERS
    first = min(pointer.entries, key=lambda name: pointer.entries[name])
    return f"{word}_{re.sub(r'[^0-9A-Za-z]+', '_', first).rstrip('_')}"


def _joints(joints: Sequence[int]) -> str:
    if not joints:
        return ""
    return f", joint {joints[0]}" if joints[0] == joints[-1] else f", joints {joints[0]} to {joints[-1]}"


def _short(title: str) -> str:
    """A section's title as part of a function name: `forward_velocities`."""
    words = re.split(r",| and ", title.replace("recursion: ", ""))[0]
    return re.sub(r"\W+", "_", words.lower())[:LONGEST_NAME].strip("_")
