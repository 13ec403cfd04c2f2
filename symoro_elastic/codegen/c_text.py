"""The functions of a model as C text: heads and bodies, which the templates are given."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.c_function import SINCOS, Array, CFunction, PartText
from symoro_elastic.codegen.c_lines import INDENT, statement, with_arguments
from symoro_elastic.codegen.c_outlined import COutline
from symoro_elastic.codegen.described import described
from symoro_elastic.codegen.outlined import SPILL, Call, Outline

LARGE_STACK = 64_000


@dataclass(frozen=True)
class Routine:
    """A function of C: its head without `static`, its body."""

    head: str
    body: str
    is_static: bool = False


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
    routines: tuple[Routine, ...]


def function_text(function: CFunction) -> FunctionText:
    """Return the text of a model for one state."""
    about = described(function.function)
    main = head(function.name, function.signature, function.form.states)
    in_two_steps = (Routine(main, _in_two_steps(function)),) if function.c else ()
    return FunctionText(
        name=function.name,
        title=f"{about['title']} {about['equations']}.",
        counts=about["counts"] + _stack(function),
        documented=tuple(about["documented"]),
        prototype=main,
        constants=function.c[0].size if function.c else "",
        constant_count=len(function.constants),
        prepare=head(f"{function.name}_prepare", of_preparing(function)),
        prepared=head(f"{function.name}_prepared", function.arrays, function.form.states),
        routines=(*preparing(function), *working(function, _working_name(function)), *in_two_steps),
    )


def head(name: str, arrays: Sequence[Array], states: str = "") -> str:
    """The head of a function without its last line's end; functions on many states take their number first."""
    declared = [f"size_t {states}", *(a.pointer() for a in arrays)] if states else [a.declared() for a in arrays]
    return with_arguments(f"void {name}", declared)


def working(function: CFunction, name: str) -> list[Routine]:
    """The function that does the work of a call, after the parts of it where it is long."""
    parts, states = function.part_texts(), function.form.states
    unused = [*([states] if states else []), *function.unused()]
    first = [f"{INDENT}(void){name};" for name in unused] + _angles(function)
    if len(parts) == 1:
        return [Routine(head(name, function.arrays, states), "\n".join([*first, parts[0].body]))]
    spill = [_declaration(function.form.number, SPILL, str(function.slots))] if function.slots else []
    routines, calls = _in_parts(name, parts, states)
    if function.outline:
        routines, calls = _outlined(function, function.outline, routines, calls)
    return [*routines, Routine(head(name, function.arrays, states), "\n".join([*first, *spill, *calls]))]


def _outlined(
    function: CFunction, outline: Outline, routines: Sequence[Routine], calls: Sequence[str]
) -> tuple[list[Routine], list[str]]:
    """Functions for blocks that repeat and for the parts between, and the calls of both in order."""
    text, of_parts = COutline(function, outline), iter(calls)
    own = [Routine(one.head, one.body, True) for one in text.texts]
    in_order = [text.call(piece) if isinstance(piece, Call) else next(of_parts) for piece in outline.pieces]
    return [*own, *routines], [*text.tables(), *in_order]


def _in_parts(name: str, parts: Sequence[PartText], states: str = "") -> tuple[list[Routine], list[str]]:
    """Static functions for the parts, and the calls of them."""
    names = [f"{name}_part{k}" for k in range(1, len(parts) + 1)]
    unused = [f"{INDENT}(void){states};\n"] if states else []
    routines = [
        Routine(head(n, p.arrays, states), "".join([*unused, p.body]), True) for n, p in zip(names, parts, strict=True)
    ]
    return routines, [call(n, p.arrays, states) for n, p in zip(names, parts, strict=True)]


def _angles(function: CFunction) -> list[str]:
    """Lines that find the sines and cosines of joint variables, their multiples and sums."""
    count, type_ = len(function.angles), function.form.angle
    if not count:
        return []
    return [
        statement(f"{INDENT}const {type_} angle[{count}] = ", f"{{{', '.join(function.angle_texts())}}};"),
        *(_declaration(type_, name, str(count)) for name in SINCOS),
        *(INDENT + line.format(count=count) for line in function.form.sincos),
        "",
    ]


def _declaration(type_: str, name: str, size: str) -> str:
    return f"{INDENT}{type_} {name}[{size}];"


def call(name: str, arrays: Sequence[Array], states: str = "") -> str:
    """The call of a function with the arrays of that which calls it."""
    return with_arguments(f"{INDENT}{name}", [*([states] if states else []), *(a.name for a in arrays)], ");")


def _working_name(function: CFunction) -> str:
    return f"{function.name}_prepared" if function.c else function.name


def of_preparing(function: CFunction) -> list[Array]:
    """The arrays of the function that computes what depends on parameters only."""
    return [function.p, *function.c_written]


def preparing(function: CFunction) -> list[Routine]:
    """The function that computes what depends on parameters only, after its parts; none where there is no such work."""
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
    """The body of the function that computes anew what depends on parameters only."""
    c = function.c[0]
    return "\n".join(
        [
            _declaration(c.type, c.name, c.size),
            call(f"{function.name}_prepare", of_preparing(function)),
            call(f"{function.name}_prepared", function.arrays),
        ]
    )


def _stack(function: CFunction) -> str:
    size = function.stack()
    return f"; {size // 1000} kB of stack" if size > LARGE_STACK else ""
