"""Compilers, flags and precisions to compile with."""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain, product
from pathlib import Path

from symoro_elastic.codegen.compile import CompilationFailed, compile_library, find_compiler
from symoro_elastic.codegen.precision import DOUBLE, DOUBLE_DOUBLE, MIXED, PRECISIONS, SINGLE, Precision
from symoro_elastic.foundation.output_files import temporary_folder

QUICK, USUAL, EXHAUSTIVE = "quick", "usual", "all"

Flags = tuple[str, ...]
PLAIN: Flags = ("-O2",)
NATIVE: Flags = ("-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math")
SEPARATE, FAST_MATH = "-ffp-contract=off", "-ffast-math"
WITH_LIBM = "-DNAME_LIBM"
PAIRED = "-DVECTOR_BYTES=128"
"""Batches compute two vectors of AVX-512 side by side."""
CONTRACTED = {"gcc": "-ffp-contract=fast", "clang": "-ffp-contract=on"}
FLAG_NAMES = {
    "-O2": "O2", "-O3": "O3", "-march=native": "native", SEPARATE: "no FMA", FAST_MATH: "fast-math", WITH_LIBM: "libm",
    PAIRED: "vectors in pairs",
}  # fmt: skip
"""Names of flags in tables; other flags are not shown."""

PROBE = "int probe(void);\nint probe(void) { return 0; }\n"
HAS_LONG_VECTORS = '#ifndef __AVX512F__\n#error "not here"\n#endif\n' + PROBE
IS_CLANG = '#ifndef __clang__\n#error "not clang"\n#endif\n' + PROBE


@dataclass(frozen=True)
class Build:
    """One way to compile a formulation."""

    compiler: Flags
    flags: Flags
    precision: Precision = field(hash=False)

    @property
    def words(self) -> str:
        """Compiler and flags as text for a table."""
        return " ".join([Path(self.compiler[0]).name, *(FLAG_NAMES[flag] for flag in self.flags if flag in FLAG_NAMES)])

    def options(self, package: str) -> Flags:
        """Return the flags for the files of a package, whose macros begin with its name."""
        libm = f"-D{(package + self.precision.suffix).upper()}_LIBM"
        return tuple(libm if flag == WITH_LIBM else flag for flag in self.flags)

    @property
    def is_safe(self) -> bool:
        """Whether NaN, infinities and the order of operations are respected."""
        return FAST_MATH not in self.flags


def compilers() -> list[Flags]:
    """Return the compilers to try: $CC alone where it is set, else gcc and clang. Raises `CompilerMissing`."""
    if os.environ.get("CC", "").strip():
        return [find_compiler()]
    return [(name,) for name in ("gcc", "clang") if shutil.which(name)] or [find_compiler()]


def takes(compiler: Flags, flags: Sequence[str], text: str = PROBE) -> bool:
    """Return whether a compiler accepts flags, with a source text."""
    with temporary_folder() as folder:
        try:
            compile_library({"probe.c": text}, Path(folder), compiler, flags)
        except CompilationFailed:
            return False
    return True


@dataclass(frozen=True)
class FlagSets:
    """Sets of flags of a compiler: `best` is recommended by the generated source, `variants` differ from it."""

    best: Flags
    variants: tuple[Flags, ...]
    every: tuple[Flags, ...]


def flag_sets(compiler: Flags) -> tuple[FlagSets, list[str]]:
    """Return the flags to try, and notes on those that the compiler lacks."""
    kind = "clang" if takes(compiler, (), IS_CLANG) else "gcc"
    wanted = (*NATIVE, CONTRACTED[kind], SEPARATE, FAST_MATH)
    lacking = [flag for flag in wanted if not takes(compiler, (flag,))]
    notes = [f"{compiler[0]} has no {flag}: builds without it only" for flag in lacking]
    native = tuple(flag for flag in NATIVE if flag not in lacking)
    contracted, separate, fast = ((flag,) * (flag not in lacking) for flag in (CONTRACTED[kind], SEPARATE, FAST_MATH))
    best = (*native, *contracted)
    paired = ((*best, PAIRED),) if takes(compiler, native, HAS_LONG_VECTORS) else ()
    varied = (*paired, PLAIN, (*native, *separate), (*best, *fast), (*best, WITH_LIBM), (*best, *fast, WITH_LIBM))
    choices = product(dict.fromkeys((contracted, separate)), dict.fromkeys(((), fast)), ((), (WITH_LIBM,)))
    every = [PLAIN, (*PLAIN, WITH_LIBM), *paired, *((*native, *chain.from_iterable(some)) for some in choices)]
    variants = tuple(flags for flags in dict.fromkeys(varied) if flags != best)
    return FlagSets(best, variants, tuple(dict.fromkeys(every))), notes


def builds(compiler: Flags, sets: FlagSets, effort: str, is_first: bool, is_other_way: bool) -> list[Build]:
    """Return the builds of a formulation with one compiler, most informative first; more if it `is_first`."""
    if effort == EXHAUSTIVE:
        sets_of_flags = dict.fromkeys((sets.best, *sets.every))
        every = [(precision, flags) for precision in PRECISIONS.values() for flags in sets_of_flags]
        own = {WITH_LIBM, FAST_MATH}  # sums of two doubles have their own sines, and depend on the order of operations
        return [Build(compiler, flags, x) for x, flags in every if not (x.is_pair and own.intersection(flags))]
    precisions = (DOUBLE, SINGLE) if is_other_way or (effort == QUICK and not is_first) else (DOUBLE, SINGLE, MIXED)
    chosen = [Build(compiler, sets.best, precision) for precision in precisions]
    if not is_first or effort == QUICK:
        return chosen
    chosen += [Build(compiler, flags, DOUBLE) for flags in sets.variants]
    chosen += [Build(compiler, flags, SINGLE) for flags in sets.variants if FAST_MATH in flags or flags == PLAIN]
    fused = tuple(flag for flag in sets.best if flag == "-march=native")
    return [*chosen, Build(compiler, (*PLAIN, *fused), DOUBLE_DOUBLE)]
