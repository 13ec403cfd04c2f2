"""Code in fixed point, compiled with checks of overflows, beside numpy in double precision."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

import symoro_elastic as se
from symoro_elastic.codegen.c.fixed_function import FixedFunction, FixedText
from symoro_elastic.codegen.compile import find_compiler
from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.codegen.targets.c_fixed import render_c_fixed
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.machine.limits import Limits
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.numerics.guarantees.fixed_point import with_scales

CHECKED = ("-std=c99", "-O1", "-Wall", "-Wextra", "-Werror", "-pedantic", "-fsanitize=undefined",
           "-fno-sanitize-recover=all")  # fmt: skip
"""Overflows of signed integers and bad shifts end the program."""
DRIVER = """
#include <stdio.h>
#include "@NAME@.h"
int main(void)
{
    static int32_t x[@READ@], y[@WRITTEN@];
    while (fread(x, sizeof *x, @READ@, stdin) == @READ@) {
        const int32_t in_box = @IN_BOX@;
        @CALL@;
        fwrite(&in_box, sizeof in_box, 1, stdout);
        fwrite(y, sizeof *y, @WRITTEN@, stdout);
    }
    return 0;
}
"""


@dataclass(frozen=True)
class FixedCase:
    """A model of a machine in fixed point within its limits."""

    machine: Machine
    limits: Limits
    model: str

    @cached_property
    def package(self) -> Package:
        return with_scales(programs(self.machine, Scene((self.model,), fold=ALL)), self.limits)

    @cached_property
    def function(self) -> Function:
        (function,) = self.package.functions
        return function

    @cached_property
    def name(self) -> str:
        return f"{self.package.name}_fixed"

    @cached_property
    def text(self) -> FixedText:
        return FixedFunction(self.package, self.function, self.name).text()

    def states(self, count: int, rng: np.random.Generator) -> Array:
        """Whole numbers within the box, by argument and entry; in half of the states at ends, and at quarter turns."""
        ranges = {(one.argument, one.entry): one for one in self.function.guaranteed["fixed-point"].ranges}
        corner = rng.random(count) < 0.5
        columns = []
        for array in self.text.arguments:
            for k, (bits, turns) in enumerate(zip(array.bits, array.turns, strict=True)):
                one, unit = ranges.get((array.name, k)), float(array.units[k])
                low, high = (np.ceil(one.low / unit), np.floor(one.high / unit)) if one and bits is not None else (0, 0)
                ends = [low, high] if not turns else [low, high, *(x for x in _quarters() if low <= x <= high)]
                drawn = rng.integers(int(low), int(high), count, endpoint=True)
                columns.append(np.where(corner, rng.choice(np.array(ends, np.int64), count), drawn))
        return np.stack(columns, axis=1).astype(np.int64).astype(np.uint32).view(np.int32)

    def run(self, states: Array, folder: Path, flags: tuple[str, ...] = CHECKED) -> tuple[Array, Array]:
        """Whether each state is in the box, and the results as whole numbers, by the code."""
        for name, text in (render_c_fixed(self.package) | {"main.c": self._driver()}).items():
            (folder / name).write_text(text)
        command = [*find_compiler(), *flags, "main.c", f"{self.name}.c", "-o", "main"]
        subprocess.run(command, cwd=folder, check=True)
        made = subprocess.run([str(folder / "main")], input=states.tobytes(), capture_output=True, check=True)
        rows = np.frombuffer(made.stdout, np.int32).reshape(len(states), -1)
        return rows[:, 0].astype(bool), rows[:, 1:]

    def _driver(self) -> str:
        text, places = self.text, {}
        for variable, arrays in (("x", text.arguments), ("y", text.results)):
            offset = 0
            for array in arrays:
                places[array.name] = f"{variable} + {offset}"
                offset += len(array.bits)
        read, written = (sum(len(a.bits) for a in arrays) for arrays in (text.arguments, text.results))
        given = ", ".join(places[a.name] for a in text.arguments)
        words = {
            "NAME": self.name,
            "READ": str(read),
            "WRITTEN": str(written),
            "IN_BOX": f"{text.name}_in_box({given})",
            "CALL": f"{text.name}({given}, {', '.join(places[a.name] for a in text.results)})",
        }
        return re.sub(r"@(\w+)@", lambda found: words[found[1]], DRIVER)

    def exact(self, states: Array) -> Array:
        """The results in double precision at these states."""
        given, start = {}, 0
        for array in self.text.arguments:
            size = len(array.bits)
            given[array.name] = states[:, start : start + size] * np.array(list(map(float, array.units)))
            start += size
        with se.load(self.machine, self.model) as model:
            found = getattr(model, self.model)(**given)
        parts = found if isinstance(found, tuple) else (found,)
        return np.concatenate([np.reshape(part, (len(states), -1)) for part in parts], axis=1)

    @cached_property
    def argument_units(self) -> Array:
        """The unit of each entry of the arguments."""
        return np.array([float(unit) for array in self.text.arguments for unit in array.units])

    @cached_property
    def units(self) -> Array:
        """The unit of each entry of the results."""
        return np.array([float(unit) for array in self.text.results for unit in array.units])

    @cached_property
    def proven(self) -> Array:
        """The proven error of each entry of the results: from the header, which rounds upwards."""
        said = "\n".join(self.function.guaranteed["fixed-point"].sentences)
        entries = re.findall(r"^\w+\[[^\]]*\]: .*?(?:error at most (\S+), proven|exact, proven)$", said, re.MULTILINE)
        return np.array([float(error or 0) for error in entries])


def _quarters() -> list[float]:
    return [k * 2.0**29 for k in range(-4, 4)]
