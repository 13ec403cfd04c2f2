"""The target `c-batch`: the C of the target `c`, and functions that compute many states a call."""

from __future__ import annotations

from dataclasses import dataclass, replace

from symoro_elastic.codegen.c.function import Array, CFunction
from symoro_elastic.codegen.c.lines import INDENT, with_arguments, wrap_lines
from symoro_elastic.codegen.c.printers import FUNCTIONS, Form
from symoro_elastic.codegen.c.rows import Rows
from symoro_elastic.codegen.c.steps import CSteps
from symoro_elastic.codegen.c.text import Routine, working
from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import DOUBLE, PRECISIONS, Precision
from symoro_elastic.codegen.target import Target, words
from symoro_elastic.codegen.targets.c import OWN as C_WORDS
from symoro_elastic.codegen.targets.c import (
    C,
    banner,
    digest_in,
    files_of,
    functions_of,
    in_words_of_c,
    scalar_form,
    text_of,
)
from symoro_elastic.codegen.templates import render, with_digest

LARGE_STACK = 64_000
OWN = words(
    """
    LOAD LOAD_ANGLE STORE NARROW WIDTH VECTOR VECTOR_BYTES INLINE NOINLINE EXACT_TYPES LARGEST_ANGLE numbers angles bits
    ROW PIECE share number_bits states stored load_lanes sincos_near sincos_lanes sincos_large_angles
    """
) | {f"{name}_lanes" for name in FUNCTIONS}
"""Macros and identifiers of the templates."""


@dataclass(frozen=True)
class BatchFunction:
    """A model for batches: heads and bodies of public functions, and functions for a state, vectors and rows.

    `of_range` is the head of the function for some of the states, by which the others are computed.
    """

    title: str
    stack: str
    prototype: str
    in_threads: str
    of_range: str
    whole_call: str
    share_call: str
    name: str
    constants: str
    in_vectors: tuple[Routine, ...]
    vector_call: str
    rows: tuple[Routine, ...]
    row_calls: tuple[str, ...]
    one: Routine
    one_call: str


@dataclass(frozen=True)
class BatchText:
    """Template data of a batch file; `called` are the functions that statements call, by operation and name."""

    name: str
    macro: str
    banner: str
    precision: Precision
    real: str
    functions: tuple[BatchFunction, ...]
    called: dict[str, str]
    has_angles: bool
    has_vectors: bool
    has_rows: bool
    steps: CSteps


def vector_form(package: Package, precision: Precision) -> Form:
    """Form of the numbers of C functions for many states, in vectors; without vectors that of a single state."""
    form = scalar_form(package, precision)
    if precision.is_pair:
        return form
    load, place = "LOAD({array} + {k}*states)", "{array} + {k}*states"
    return replace(
        form,
        number="numbers",
        angle="angles",
        load=load,
        load_angle="LOAD_ANGLE({array} + {k}*states)" if precision.is_mixed else load,
        store=f"STORE({place}, {{value}});",
        narrow="NARROW({})" if precision.is_mixed else "{}",
        functions={name: f"{name}_lanes" for name in FUNCTIONS},
        sincos=lambda angles, _: (f"sincos_lanes({len(angles)}U, angle, sine, cosine);",),
        states="states",
        outlined=2,
        leaves_rows=True,
        near_use=True,
    )


def render_c_batch(package: Package, precision: Precision = DOUBLE) -> Files:
    """Return `<name>_batch.h` and `<name>_batch.c`, with the files of the target `c`."""
    plain, package = in_words_of_c(package), with_local_names(with_own_results(package), OWN | C_WORDS)
    one_by_one = functions_of(plain, precision)
    form, name = vector_form(package, precision), package.name + precision.suffix
    twins = zip(package.functions, one_by_one, strict=True)
    functions = [CFunction(package, f, precision, form, twin) for f, twin in twins if f.arguments]
    texts = tuple(map(_function, functions))
    called = sorted({operation for function in functions for operation in function.printer.called})
    text = BatchText(
        name=name,
        macro=name.upper(),
        banner=banner(package, precision),
        precision=precision,
        real=form.real,
        functions=texts,
        called={} if precision.is_pair else {f: precision.functions.get(f, f) for f in called},
        has_angles=any(function.angles for function in functions),
        has_vectors=not precision.is_pair,
        has_rows=any(function.rows for function in functions),
        steps=CSteps(package, precision, functions, many=True),
    )
    of_one = files_of(text_of(plain, precision, one_by_one))
    context = {**vars(text), "digest_of_one": digest_in(of_one[f"{name}.h"])}
    names = {f"{name}_batch{suffix}": f"c/batch{suffix}.j2" for suffix in (".h", ".c")}
    return of_one | with_digest({file: wrap_lines(render(template, **context)) for file, template in names.items()})


def _function(function: CFunction) -> BatchFunction:
    lanes = f"{function.name}_lanes"
    pair = function.precision.is_pair
    c = function.c[0] if function.c else None
    arguments = ["size_t states", *(a.pointer() for a in function.signature)]
    ranged = ["size_t states", "size_t start", "size_t end", *(a.pointer() for a in function.arrays)]
    return BatchFunction(
        title=function.function.title,
        stack=_stack(function),
        prototype=with_arguments(f"void {function.name}_batch", arguments),
        in_threads=with_arguments(f"void {function.name}_batch_threads", arguments),
        of_range=with_arguments(f"static void {_of_range(function)}", ranged),
        whole_call=_range_call(function, INDENT, "0", "states"),
        share_call=_range_call(function, INDENT * 3, "start", "end"),
        name=function.name,
        constants=c.size if c else "",
        in_vectors=() if pair else tuple(working(function, lanes)),
        vector_call=_moved_call(function, lanes),
        rows=tuple(_on_rows(function, rows) for rows in function.rows),
        row_calls=tuple(_row_call(function, rows) for rows in function.rows),
        one=_one(function),
        one_call=_moved_call(function, f"{function.name}_one"),
    )


def _of_range(function: CFunction) -> str:
    return f"{function.name}_from_to"


def _range_call(function: CFunction, indent: str, start: str, end: str) -> str:
    """Call of the function for a range of states, from `start` to `end`."""
    arguments = ["states", start, end, *(a.name for a in function.arrays)]
    return with_arguments(f"{indent}{_of_range(function)}", arguments, ");")


def _moved_call(function: CFunction, name: str) -> str:
    """Call of a function with all arrays advanced to the state `first`."""
    of_states = {a.name for a in (*function.inputs, *function.results) if a.entries}
    arguments = [f"{a.name} + first" if a.name in of_states else a.name for a in function.arrays]
    return with_arguments(f"{INDENT * 2}{name}", ["states", *arguments], ");")


def _on_rows(function: CFunction, rows: Rows) -> Routine:
    """The C function that fills the entries of a result that vectors leave out, for `count` states."""
    array = next(a for a in function.results if a.name == rows.result)
    head = with_arguments(f"void {_of_rows(function, rows)}", ["size_t states", "size_t count", array.pointer()])
    return Routine(head, "\n".join(rows.lines(array.type)))


def _row_call(function: CFunction, rows: Rows) -> str:
    arguments = ["states", "first - whole", f"{rows.result} + whole"]
    return with_arguments(f"{INDENT * 3}{_of_rows(function, rows)}", arguments, ");")


def _of_rows(function: CFunction, rows: Rows) -> str:
    return f"{function.name}_rows_of_{rows.result}"


def _one(function: CFunction) -> Routine:
    """The C function that computes one state of a batch by the function for single states."""
    prepared = f"{function.name}_prepared" if function.c else function.name
    lines, arguments = [], []
    for array in function.arrays:
        is_of_states = array.entries and array not in (function.p, *function.c)
        arguments.append(f"{array.name}_one" if is_of_states else array.name)
        lines += [f"{INDENT}{array.type} {array.name}_one[{array.size}];"] if is_of_states else []
    lines += [line for array in function.inputs for line in _copies(array)]
    lines.append(with_arguments(f"{INDENT}{prepared}", arguments, ");"))
    lines += [line for array in function.results for line in _copies(array)]
    pointers = [a.pointer() for a in function.arrays]
    name = with_arguments(f"void {function.name}_one", ["size_t states", *pointers])
    empty = [f"{INDENT}(void)states;"]
    return Routine(name, "\n".join([*empty, *lines]), True)


def _copies(array: Array) -> list[str]:
    """Lines that copy the entries of a state between a batch and an array of one state."""
    if not array.entries:
        return []
    single, batch = f"{array.name}_one[k]", f"{array.name}[k*states]"
    target, source = (batch, single) if array.is_written else (single, batch)
    loop = f"{INDENT}for (size_t k = 0; k < {array.size}; k++) {{"
    return [loop, f"{INDENT * 2}{target} = {source};", f"{INDENT}}}"]


def _stack(function: CFunction) -> str:
    """Note on the size of the work arrays of a batch in kB; empty if they are small."""
    sizes = {"double": 8, "float": 4}
    single = sum(a.entries for a in (*function.inputs, *function.results)) * sizes[function.precision.state]
    size = max(function.stack() * function.precision.widest, single + function.stack())
    return f"{size // 1000} kB of stack" if size > LARGE_STACK else ""


C_BATCH = Target(
    name="c-batch",
    title="C, and many states a call, in vectors with GCC and Clang",
    suffixes=(".h", ".c", "_batch.h", "_batch.c"),
    precisions=tuple(PRECISIONS.values()),
    reserved=C.reserved,
    files=render_c_batch,
)
