"""Structured Text in tests: what blocks declare, an interpreter in Python, and two compilers where they are there.

`STRUCPP` and `MATIEC` name the folders of checkouts that are built: `dist/node/cli.js`, and `iec2c`.
"""

from __future__ import annotations

import ctypes
import math
import os
import re
import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

Array = NDArray[Any]
REALS = {"lreal": np.float64, "real": np.float32}
STRUCPP, MATIEC = (Path(os.environ.get(name, "/nonexistent")) for name in ("STRUCPP", "MATIEC"))
needs_strucpp = pytest.mark.skipif(
    not (STRUCPP / "dist/node/cli.js").is_file() or not shutil.which("node") or not shutil.which("g++"),
    reason="needs STruCpp: its built checkout in STRUCPP, node, g++",
)
needs_matiec = pytest.mark.skipif(
    not (MATIEC / "iec2c").is_file() or not shutil.which("gcc"),
    reason="needs matiec: its built checkout in MATIEC, gcc",
)


def of_library(name: str, x: float) -> float:
    """Return what a function of the C library gives, NaN where it has no value."""
    try:
        return float(getattr(math, name)(x))
    except ValueError:
        return math.nan


# What a file declares


@dataclass(frozen=True)
class Block:
    """A function or function block: sections of (name, type, initial value), and the text of its body."""

    kind: str
    name: str
    type: str
    sections: Mapping[str, list[tuple[str, str, str]]]
    body: str

    def variables(self) -> Iterator[tuple[str, str, str]]:
        """Yield all that it declares."""
        for section in self.sections.values():
            yield from section


@dataclass(frozen=True)
class File:
    """The array types of a file (length, element) and its functions and blocks, all in lower case.

    `wanted` are the names that blocks would have if they were not cut.
    """

    types: Mapping[str, tuple[int, str]]
    blocks: Mapping[str, Block]
    wanted: Mapping[str, str]

    def length(self, type_: str) -> int:
        """Return the entries of a variable; 0 for one that is not an array."""
        return self.types[type_][0] if type_ in self.types else 0


def without_comments(text: str) -> str:
    """Return a text without its comments."""
    return re.sub(r"\(\*.*?\*\)", " ", text, flags=re.DOTALL)


def parsed(text: str) -> File:
    """Return what a file declares; case does not matter in it."""
    cut = re.findall(r"\(\* (\w+) is called (\w+) here. \*\)", text)
    text = without_comments(text).lower()
    types = {
        name: (int(last) + 1, element)
        for name, last, element in re.findall(r"(\w+) : array\[0\.\.(\d+)\] of (\w+);", text)
    }
    blocks = {}
    for kind, name, of, inside in re.findall(
        r"^(function_block|function) (\w+)(?: : (\w+))?\n(.*?)^end_\1", text, re.DOTALL | re.MULTILINE
    ):
        sections: dict[str, list[tuple[str, str, str]]] = {}
        for section, lines in re.findall(r"^  (var\w*)\s*\n(.*?)^  end_var", inside, re.DOTALL | re.MULTILINE):
            for names, type_, value in re.findall(r"([\w, ]+) : (\w+)(?: := ([^;]+))?;", lines):
                found = [(one.strip(), type_, value) for one in names.split(",")]
                sections.setdefault(section, []).extend(found)
        blocks[name] = Block(kind, name, of, sections, inside.rpartition("end_var")[2])
    return File(types, blocks, {name.lower(): wanted for wanted, name in cut})


# The interpreter: statements as Python


KEYWORDS = {
    "if",
    "then",
    "elsif",
    "else",
    "not",
    "true",
    "false",
    "for",
    "to",
    "do",
    "sin",
    "cos",
    "sqrt",
    "abs",
    "atan",
}


@dataclass
class Interpreter:
    """Blocks of a file as Python; numbers are those of numpy, in the precision of the file."""

    file: File
    real: Callable[[Any], Any]
    _code: dict[str, Any] = field(default_factory=dict)

    def instance(self, name: str) -> SimpleNamespace:
        """Return the variables of a block, or one value of a type, as they are at the start."""
        made = SimpleNamespace()
        for variable, type_, value in self.file.blocks[name].variables():
            setattr(made, variable, self._initial(type_, value))
        return made

    def call(self, name: str, variables: SimpleNamespace) -> SimpleNamespace:
        """Carry out the body of a block on its variables."""
        if name not in self._code:
            self._code[name] = compile(self._python(self.file.blocks[name]), name, "exec")
        exec(self._code[name], {"v": variables, "f": self._functions()})
        return variables

    def _initial(self, type_: str, value: str) -> Any:
        if type_ in self.file.types:
            return [self.real(0)] * self.file.types[type_][0]
        if type_ in self.file.blocks:
            return self.instance(type_)
        if type_ in REALS:
            return self.real(value.replace("real#", "") or 0)
        return {"int": 0, "bool": value == "true"}[type_]

    def _functions(self) -> SimpleNamespace:
        """The functions that expressions may call, and what statements need."""
        made = SimpleNamespace(real=self.real, call=self.call, block=self._block)
        for name in ("sin", "cos", "sqrt", "atan"):
            setattr(made, name, lambda x, of=name: self.real(of_library(of, x)))
        made.abs = abs
        for name, block in self.file.blocks.items():
            if block.kind == "function":
                setattr(made, name, lambda *x, of=block: self._function(of, x))
        return made

    def _function(self, block: Block, given: Sequence[Any]) -> Any:
        variables = SimpleNamespace(
            **{name: x for (name, _, _), x in zip(block.sections["var_input"], given, strict=True)}
        )
        return getattr(self.call(block.name, variables), block.name)

    def _block(self, caller: SimpleNamespace, instance: str, type_: str, given: Mapping[str, Any]) -> None:
        """Call a block: arrays are copied in, and those of VAR_IN_OUT are the caller's own."""
        own = {name for name, _, _ in self.file.blocks[type_].sections.get("var_in_out", ())}
        inside = getattr(caller, instance)
        for name, x in given.items():
            assert hasattr(inside, name)
            setattr(inside, name, x if name in own or not isinstance(x, list) else [*x])
        self.call(type_, inside)

    def _python(self, block: Block) -> str:
        types = {name: type_ for name, type_, _ in block.variables()} | ({block.name: block.type} if block.type else {})
        lines, depth = [], 0
        for text in re.findall(r"[^;]+?(?:\bthen\b|\bdo\b|\belse\b|;)", block.body, re.DOTALL):
            made, before, after = self._statement(" ".join(text.split()).rstrip(";"), types)
            depth += before
            lines += [f"{'    ' * depth}{made}"] if made else []
            depth += after
        assert depth == 0
        return "\n".join(lines)

    def _statement(self, text: str, types: Mapping[str, str]) -> tuple[str, int, int]:
        """A statement as Python, and how much deeper it and those after it are."""
        if text in ("end_if", "end_for"):
            return "", -1, 0
        if text == "else":
            return "else:", -1, 1
        if found := re.fullmatch(r"(if|elsif) (.*) then", text):
            return f"{found[1].replace('elsif', 'elif')} {self._value(found[2], types)}:", -(found[1] == "elsif"), 1
        if found := re.fullmatch(r"for (\w+) := (\d+) to (\d+) do", text):
            return f"for v.{found[1]} in range({found[2]}, {found[3]} + 1):", 0, 1
        if found := re.fullmatch(r"(\w+)\( ?(.*)\)", text):
            given = dict(one.split(" := ") for one in found[2].split(", "))
            pairs = ", ".join(f"'{name}': {self._value(x, types)}" for name, x in given.items())
            return f"f.block(v, '{found[1]}', '{types[found[1]]}', {{{pairs}}})", 0, 0
        to, right = text.split(" := ")
        value = self._value(right, types)
        return (
            f"{self._value(to, types)} = {f'[*{value}]' if to in types and types[to] in self.file.types else value}",
            0,
            0,
        )

    def _value(self, text: str, types: Mapping[str, str]) -> str:
        """An expression as Python."""

        def of(found: re.Match[str]) -> str:
            word = found[0]
            if word[0].isdigit() or word.startswith("real#"):
                return f"f.real({word.removeprefix('real#')})" if "." in word else word
            if word in ("not", "true", "false"):
                return word.capitalize() if word != "not" else word
            if word in types:
                return f"v.{word}"
            assert hasattr(self._functions(), word), f"{word} is not declared"
            return f"f.{word}"

        return re.sub(r"real#[\d.]+(?:e-?\d+)?|\d+\.\d+(?:e-?\d+)?|\d+|(?<![.\w])[a-z_]\w*", of, text)


def interpreted(text: str, block: str, states: Mapping[str, Array]) -> dict[str, Array]:
    """Return the results (N, entries) of a block, and the arrays that it changes, at N states."""
    file, name = parsed(text), block.lower()
    sections = file.blocks[name].sections
    real = REALS[next(iter(file.types.values()))[1]]
    runs = Interpreter(file, real)
    instance = runs.instance(name)
    written = [x for x, _, _ in (*sections.get("var_output", ()), *sections.get("var_in_out", ()))]
    found: dict[str, list[Array]] = {x: [] for x in written}
    with np.errstate(all="ignore"):
        for k in range(len(next(iter(states.values())))):
            for x, type_, _ in (*sections.get("var_input", ()), *sections.get("var_in_out", ())):
                given = [real(one) for one in np.atleast_1d(states[x][k])]
                setattr(instance, x, given if file.length(type_) else given[0])
            runs.call(name, instance)
            for x in written:
                found[x].append(np.array(getattr(instance, x)))
    return {x: np.array(arrays) for x, arrays in found.items()}


# The compilers


Runs = Callable[[str, Mapping[str, Array]], dict[str, Array]]
"""From the name of a block and its arrays (N, entries) to its results."""


def by_strucpp(text: str, folder: Path) -> Runs:
    """Return the blocks of a file, compiled by STruCpp and g++."""
    made = _translated(["node", str(STRUCPP / "dist/node/cli.js"), "file.st", "-o", "file.cpp"], text, folder)
    file = parsed(text)
    lines = ['#include "file.cpp"', "#include <cstddef>", 'extern "C" {']
    for block in _function_blocks(file):
        lines += _driver(file, block, f"static strucpp::{block.name.upper()} b;", "b();", "b.{0}.at({1})", "b.{0}")
    (made / "driver.cpp").write_text("\n".join([*lines, "}"]))
    include = STRUCPP / "src/runtime/include"
    return _library(["g++", "-std=c++17", f"-I{include}", "driver.cpp"], file, made)


def by_matiec(text: str, folder: Path) -> Runs:
    """Return the blocks of a file, compiled by matiec and gcc."""
    made = _translated([str(MATIEC / "iec2c"), "-I", str(MATIEC / "lib"), "-T", ".", "file.st"], text, folder)
    file = parsed(text)
    lines = ['#include "POUS.h"', '#include "POUS.c"', "#include <stddef.h>"]
    lines += ["TIME __CURRENT_TIME;", "BOOL __DEBUG;"]
    for block in _function_blocks(file):
        name = block.name.upper()
        state = f"static {name} b; static int begun; if (!begun) {{ {name}_init__(&b, 0); begun = 1; }}"
        lines += _driver(file, block, state, f"{name}_body__(&b);", "b.{0}.value.table[{1}]", "b.{0}.value")
    (made / "driver.c").write_text("\n".join(lines))
    return _library(["gcc", "-w", f"-I{MATIEC / 'lib/C'}", "driver.c"], file, made)


def refused(compiler: str, text: str, folder: Path) -> bool:
    """Return whether a compiler refuses a file."""
    try:
        (by_strucpp if compiler == "strucpp" else by_matiec)(text, folder)
    except RuntimeError:
        return True
    return False


def _function_blocks(file: File) -> list[Block]:
    return [block for block in file.blocks.values() if block.kind == "function_block"]


def _translated(command: Sequence[str], text: str, folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "file.st").write_text(text)
    _run(command, folder)
    return folder


def _run(command: Sequence[str], folder: Path) -> None:
    run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if run.returncode or "error" in run.stdout.lower():
        raise RuntimeError((run.stdout + run.stderr)[-3000:])


def _driver(file: File, block: Block, state: str, call: str, entry: str, number: str) -> Iterator[str]:
    """C of a function that carries a block out at many states: all inputs of a state in a row, all results."""
    read = [*block.sections.get("var_input", ()), *block.sections.get("var_in_out", ())]
    written = [*block.sections.get("var_output", ()), *block.sections.get("var_in_out", ())]
    yield f"void run_{block.name}(size_t states, const double *x, double *y) {{ {state} while (states--) {{"
    for name, type_, _ in read:
        for k in range(file.length(type_)):
            yield f"{entry.format(name.upper(), k)} = *x++;"
        if not file.length(type_):
            yield f"{number.format(name.upper())} = *x++;"
    yield call
    for name, type_, _ in written:
        yield from (f"*y++ = {entry.format(name.upper(), k)};" for k in range(file.length(type_)))
    yield "} }"


def _library(command: Sequence[str], file: File, folder: Path) -> Runs:
    _run([*command, "-O1", "-ffp-contract=off", "-shared", "-fPIC", "-o", "blocks.so", "-lm"], folder)
    library = ctypes.CDLL(str(folder / "blocks.so"))

    def run(block: str, states: Mapping[str, Array]) -> dict[str, Array]:
        sections = file.blocks[block.lower()].sections
        read = [*sections.get("var_input", ()), *sections.get("var_in_out", ())]
        written = [*sections.get("var_output", ()), *sections.get("var_in_out", ())]
        count = len(next(iter(states.values())))
        x = np.ascontiguousarray(np.hstack([np.reshape(states[name], (count, -1)) for name, _, _ in read]), dtype=float)
        lengths = [file.length(type_) for _, type_, _ in written]
        y = np.full((count, sum(lengths)), np.nan)
        function = getattr(library, f"run_{block.lower()}")
        function.restype = None
        function(ctypes.c_size_t(count), *(a.ctypes.data_as(ctypes.c_void_p) for a in (x, y)))
        ends = np.cumsum(lengths)
        return {name: y[:, end - n : end] for (name, _, _), n, end in zip(written, lengths, ends, strict=True)}

    return run
