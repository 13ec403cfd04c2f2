"""Compilers of reports on the cost of C, by option: a command with its options, or a processor by its name."""

from __future__ import annotations

from collections.abc import Sequence

from symoro_elastic.api.checked_calls import COMMAND
from symoro_elastic.api.options import Generating
from symoro_elastic.codegen.compile import CompilerMissing
from symoro_elastic.codegen.embedded.processors import CONTROLLERS
from symoro_elastic.codegen.embedded.tool_chain import ToolChain, tool_chain
from symoro_elastic.codegen.targets import SCALED_TARGETS
from symoro_elastic.codegen.targets.c import C
from symoro_elastic.codegen.targets.c_batch import C_BATCH
from symoro_elastic.foundation.errors import InputError, among

OF_C = "concerns the C code: add --target c, or leave it out"


def reporting(options: Generating, targets: Sequence[str]) -> ToolChain | None:
    """Return the compiler for the report on C code, None if none is requested; raises `InputError`."""
    compiler, flags = options.compiler, options.compiler_flags
    named = {"--processor": options.processor, "--compiler": compiler, "--compiler-flags": flags}
    places = [place for place, value in named.items() if value]
    if not options.report:
        if places:
            raise InputError(COMMAND, places[0], "belongs to the report: add --report, or leave it out")
        return None
    if not {C.name, C_BATCH.name, *SCALED_TARGETS} & {*targets}:
        raise InputError(COMMAND, "--report", OF_C)
    if options.processor:
        if len(places) > 1:
            raise InputError(COMMAND, "--processor", f"names a compiler and its options: leave out {places[1]}")
        return tools_of(options.processor)
    try:
        return tool_chain(compiler, flags)
    except CompilerMissing as error:
        raise InputError(COMMAND, "--compiler" if compiler else "--report", error.what) from None
    except ValueError as error:
        place = "--compiler-flags" if str(error) == flags else "--compiler"
        raise InputError(COMMAND, place, f"{str(error)!r} has an unmatched quotation mark") from None


def tools_of(processor: str) -> ToolChain:
    """Return the compiler of a processor by its name; raises `InputError`."""
    among((processor,), CONTROLLERS, "--processor")
    try:
        return tool_chain(CONTROLLERS[processor].compiler, CONTROLLERS[processor].flags)
    except CompilerMissing as error:
        raise InputError(COMMAND, "--processor", error.what) from None
