"""Machine code as objdump lists it: functions, instructions, targets of branches, source lines."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from enum import Enum, auto

FORMAT = re.compile(r"file format (\S+)")
SYMBOL = re.compile(r"^[0-9a-f]+ .{6}F \S+\s+([0-9a-f]+) (?:\.\w+ )?(\S+)$", re.MULTILINE)
FUNCTION = re.compile(r"([0-9a-f]+) <(.+)>:")
LINE = re.compile(r".*?([^/\s]+\.c):(\d+)(?: \(discriminator \d+\))?")
RELOCATION = re.compile(r"\s+[0-9a-f]+: R_\w+\s+(\S+)")
INSTRUCTION = re.compile(r"\s+([0-9a-f]+):\s+(\S+)\s*(.*)")
TARGET = re.compile(r"([0-9a-f]+) <([^>+]+)(\+0x[0-9a-f]+)?>")
SECTION = ".text."
ADDEND = re.compile(r"[-+]0x[0-9a-f]+$")


class Kind(Enum):
    """Effect of an instruction on the control flow."""

    PLAIN = auto()
    CALL = auto()
    BRANCH = auto()
    JUMP = auto()
    RETURN = auto()
    MAY_RETURN = auto()
    UNKNOWN = auto()
    """A jump to an address that is computed."""


@dataclass(frozen=True)
class Instruction:
    """An instruction: address, kind, line of the C file, jump target in the function, called function."""

    address: int
    kind: Kind
    line: int
    target: int = -1
    callee: str = ""


@dataclass(frozen=True)
class Code:
    """Machine code of a function: its size in bytes, and its instructions by address."""

    name: str
    size: int
    instructions: tuple[Instruction, ...]


@dataclass(frozen=True)
class Processor:
    """Mnemonics of a processor family, as patterns; `may_return` matches a conditional return."""

    call: str
    jump: str
    branch: str
    returns: str
    computed: str
    may_return: str = r"(?!)"


CONDITION = "(eq|ne|cs|cc|hs|lo|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)"
PROCESSORS = {
    "elf64-x86-64": Processor(
        r"callq? [0-9a-f].*", r"jmpq? [0-9a-f].*", r"j[a-z]+ .*", r"(repz |bnd )?retq?\b.*", r"(jmp|call)q? .*"
    ),
    "elf32-littlearm": Processor(
        r"blx? [0-9a-f].*",
        r"b(\.[nw])? .*",
        rf"(b{CONDITION}(\.[nw])?|cbn?z) .*",
        r"bx lr|(pop|ldm\S*) .*\bpc\}|mov pc, lr|ldr(\.w)? pc, \[sp\], #4",
        r"(tb[bh]|bx|blx|(mov|ldr|add)(\.w)? pc,).*",
        rf"bx{CONDITION} lr|(pop|ldm\w*){CONDITION}\S* .*\bpc\}}",
    ),
}
"""Processors by the format of object files."""


class UnknownProcessor(Exception):
    """The machine code is of an unsupported processor; the message is its file format."""


def functions(listing: str) -> tuple[dict[str, Code], str]:
    """Return the functions in the output of objdump by name, and the file format; raises `UnknownProcessor`."""
    match = FORMAT.search(listing)
    name = match[1] if match else "nothing"
    if name not in PROCESSORS:
        raise UnknownProcessor(name)
    codes = {code.name: code for code in _functions(listing, PROCESSORS[name])}
    return {x: replace(y, instructions=tuple(_name_callees(y.instructions, codes))) for x, y in codes.items()}, name


def _functions(listing: str, processor: Processor) -> Iterator[Code]:
    sizes = {name: int(size, 16) for size, name in SYMBOL.findall(listing)}
    for text in re.split(r"\n(?=[0-9a-f]+ <.+>:\n)", listing)[1:]:
        head, *lines = text.split("\n")
        match = FUNCTION.match(head)
        assert match
        instructions = tuple(_instructions(match[2], lines, processor))
        yield Code(match[2], sizes.get(match[2], 0), instructions)


def _instructions(function: str, lines: list[str], processor: Processor) -> Iterator[Instruction]:
    """The instructions of a function, without data words (`.word`) and their relocations."""
    line: int = 0
    last: Instruction | None = None
    for text in lines:
        if found := RELOCATION.fullmatch(text):
            last = _to_symbol(last, ADDEND.sub("", found[1])) if last else None
        elif found := INSTRUCTION.match(text):
            if last:
                yield last
            last = None
            if found[2].startswith("."):
                continue
            last = _instruction(function, int(found[1], 16), f"{found[2]} {found[3]}".strip(), line, processor)
        elif found := LINE.fullmatch(text):
            line = int(found[2])
    if last:
        yield last


def _instruction(function: str, address: int, text: str, line: int, processor: Processor) -> Instruction:
    text = " ".join(re.split(r"\s*(?:[;#@]|//) ", text)[0].split()) if "<" not in text else " ".join(text.split())
    kind = next((kind for kind, pattern in _patterns(processor) if re.fullmatch(pattern, text)), Kind.PLAIN)
    target = TARGET.search(text)
    if kind not in (Kind.CALL, Kind.JUMP, Kind.BRANCH) or not target:
        return Instruction(address, kind, line)
    if kind is Kind.CALL or target[2] != function:
        return Instruction(address, kind, line, callee=target[2])
    return Instruction(address, kind, line, int(target[1], 16))


def _name_callees(instructions: Iterable[Instruction], names: Collection[str]) -> Iterator[Instruction]:
    """The instructions with names of callees for section symbols; unknown if a section has several functions."""
    for instruction in instructions:
        name = instruction.callee.removeprefix(SECTION)
        if not instruction.callee.startswith(SECTION.rstrip(".")):
            yield instruction
        elif name in names:
            yield replace(instruction, callee=name)
        else:
            yield replace(instruction, kind=Kind.UNKNOWN, callee="")


def _patterns(processor: Processor) -> Iterator[tuple[Kind, str]]:
    yield Kind.RETURN, processor.returns
    yield Kind.MAY_RETURN, processor.may_return
    yield Kind.CALL, processor.call
    yield Kind.JUMP, processor.jump
    yield Kind.UNKNOWN, processor.computed
    yield Kind.BRANCH, processor.branch


def _to_symbol(instruction: Instruction, symbol: str) -> Instruction:
    """The instruction with the symbol to which the linker resolves its target."""
    if instruction.kind in (Kind.CALL, Kind.JUMP, Kind.BRANCH):
        return replace(instruction, target=-1, callee=symbol)
    return instruction
