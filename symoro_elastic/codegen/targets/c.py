"""The target `c`: C99 for one state a call, one header and one source for each precision."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

from symoro_elastic.codegen.c.function import OUTLINED_FROM, CFunction
from symoro_elastic.codegen.c.lanes import in_lanes
from symoro_elastic.codegen.c.lines import INDENT, in_comment, wrap_lines
from symoro_elastic.codegen.c.printers import FUNCTIONS, OWN_FUNCTIONS, Form
from symoro_elastic.codegen.c.steps import CSteps
from symoro_elastic.codegen.c.text import FunctionText, function_text
from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.package import Axis, Package, ParameterValue
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import DOUBLE, DOUBLE_DOUBLE_TYPE, PRECISIONS, Precision
from symoro_elastic.codegen.target import Target, words
from symoro_elastic.codegen.templates import DIGEST, render, with_digest

NEEDS: dict[str, tuple[str, ...]] = {
    "make": (),
    "negative": ("make",),
    "exact_sum": ("make",),
    "ordered_sum": ("make",),
    "exact_product": ("make",),
    "sum": ("exact_sum", "ordered_sum"),
    "difference": ("sum", "negative"),
    "product": ("exact_product", "ordered_sum"),
    "quotient": ("difference", "product", "ordered_sum", "sum", "make"),
    "sqrt": ("exact_product", "difference", "ordered_sum", "make"),
    "sign": ("make",),
    "minimum": ("sum",),
    "maximum": ("sum",),
    "sincos": ("make", "exact_product", "difference", "product", "sum", "negative"),
    "sin": ("sincos",),
    "cos": ("sincos",),
    "atan2": ("sincos", "make", "difference", "product", "sum", "quotient"),
}

KEYWORDS = words(
    """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char char8_t char16_t char32_t class compl
    concept const consteval constexpr constinit const_cast continue co_await co_return co_yield decltype default delete
    do double dynamic_cast else enum explicit export extern false float for friend goto if inline int long mutable
    namespace new noexcept not not_eq nullptr operator or or_eq private protected public register reinterpret_cast
    requires restrict return short signed sizeof static static_assert static_cast struct switch template this
    thread_local throw true try typedef typeid typename typeof union unsigned using virtual void volatile wchar_t while
    xor xor_eq
    """
)
"""Keywords of C and C++, as headers serve both."""
LIBRARY = words(
    """
    I NULL NAN INFINITY EOF HUGE RAND_MAX BUFSIZ CHAR_BIT EXIT_SUCCESS EXIT_FAILURE DOMAIN SING OVERFLOW UNDERFLOW PLOSS
    TLOSS complex imaginary errno stdin stdout stderr offsetof isnan isinf isfinite isnormal isless isgreater
    islessequal isgreaterequal islessgreater isunordered signbit fpclassify math_errhandling linux unix near far huge
    interrupt main printf malloc free memcpy size_t sin cos tan sqrt atan2 fabs pow copysign fmin fmax exp log hypot
    fma nan
    """
)
"""Functions and macros of the standard library, and keywords and macros of compilers."""
OWN = words("p c place spill sine cosine angle sign torque q_s v_s w_q w_v force_rate pushed qdd_pushed lanes2 lanes4")
"""Identifiers of the templates that a user's name could hide."""


MOST_SIDE_BY_SIDE, MOST_STATEMENTS = 40, 20_000
"""Numbers of angles and statements up to which angles have lines of their own, without a loop."""


@dataclass(frozen=True)
class PackageText:
    """Template data of a package in a precision of C."""

    name: str
    macro: str
    banner: str
    summary: str
    axes: tuple[Axis, ...]
    dependent: tuple[Axis, ...] | None
    motor_names: tuple[str, ...]
    frames: int
    parameters: tuple[ParameterValue, ...]
    defaults: tuple[str, ...]
    precision: Precision
    has_angles: bool
    real: str
    own: Mapping[str, str]


@dataclass(frozen=True)
class SourceText(PackageText):
    """Template data of a C header and source; `called` are the helper functions that statements need."""

    functions: tuple[FunctionText, ...]
    called: frozenset[str]
    pair: str
    has_lanes: bool
    is_long: bool
    advances: bool
    steps: CSteps


def scalar_form(package: Package, precision: Precision) -> Form:
    """Form of the numbers of C functions for a single state."""
    real, name = precision.type_of_real(package.name), package.name + precision.suffix
    functions = {f: precision.functions.get(f, f) for f in FUNCTIONS} | {f: f"{name}_{f}" for f in OWN_FUNCTIONS}
    load = "{array}[{k}]"
    if precision.is_pair:
        pair = f"{package.name}_{DOUBLE_DOUBLE_TYPE}_"
        of = f"{pair}make({load}, 0.0)"
        return Form(
            real, real, real, of, of, f"{load} = {{value}}.high;", "{}", functions, of,
            lambda angles, _: _in_a_loop(f"{pair}sincos", angles), pair,
        )  # fmt: skip
    narrow = f"({real}){{}}" if precision.is_mixed else "{}"
    narrowed = narrow.format(load)
    sincos = partial(lines_of_sines, name)
    return Form(
        real, precision.angle, real, narrowed, load, f"{load} = {{value}};", narrow, functions, narrowed, sincos
    )


def lines_of_sines(name: str, angles: Sequence[str], statements: int) -> Iterator[str]:
    """Lines that compute sines and cosines, those of large angles separately.

    A loop over few angles, or their array, would leave it to compilers whether to load numbers as vectors that were
    stored one by one, which costs more than all the rest. After a call that may replace them, sines are loaded; where a
    branch leads around it, GCC computes them a second time, one by one (7R arm, inverse model: 73 ns, 57 ns). Very
    long models have a loop: GCC looks at the calls of all their functions for each sine that is stored side by side
    (derivatives of the direct model of 30 joints: 24 s to compile, 7 s with a loop), which is a small part of them.
    """
    if len(angles) <= MOST_SIDE_BY_SIDE and statements <= MOST_STATEMENTS:
        yield from (f"{name}_sincos({angle}, &sine[{k}], &cosine[{k}]);" for k, angle in enumerate(angles))
    else:
        yield from _in_a_loop(f"{name}_sincos", angles)
    yield f"{name}_sincos_large({len(angles)}U, angle, sine, cosine);"


def _in_a_loop(function: str, angles: Sequence[str]) -> Iterator[str]:
    """Lines that compute sines and cosines one by one, in a loop."""
    yield f"for (size_t k = 0U; k < {len(angles)}U; k++) {{"
    yield f"{INDENT}{function}(angle[k], &sine[k], &cosine[k]);"
    yield "}"


def render_c(package: Package, precision: Precision = DOUBLE) -> Files:
    """Return `<name>.h` and `<name>.c`, the precision in their names unless it is double."""
    return files_of(c_text(package, precision))


def c_text(package: Package, precision: Precision = DOUBLE) -> SourceText:
    """Template data of the target `c`."""
    return source_text(in_words_of_c(package), precision)


def in_words_of_c(package: Package) -> Package:
    """The package with other names for those that the C templates use."""
    return with_local_names(with_own_results(package), OWN)


def files_of(text: SourceText) -> Files:
    """Return the header and the source of a text."""
    names = {f"{text.name}{suffix}": f"c/model{suffix}.j2" for suffix in (".h", ".c")}
    return with_digest({name: wrap_lines(render(template, **vars(text))) for name, template in names.items()})


def digest_in(header: str) -> str:
    """Return the digest in a header, for other files that need the header of the same generation."""
    return header.partition("_DIGEST ")[2][: len(DIGEST)]


def source_text(package: Package, precision: Precision) -> SourceText:
    """Template data of a source of a package."""
    return text_of(package, precision, functions_of(package, precision))


def functions_of(package: Package, precision: Precision) -> list[CFunction]:
    """The models of a package as C functions for one state."""
    form = replace(scalar_form(package, precision), outlined=int(not precision.is_pair))
    return [CFunction(package, function, precision, form) for function in package.functions]


def text_of(package: Package, precision: Precision, functions: Sequence[CFunction]) -> SourceText:
    """Template data of a source of a package with these functions."""
    form = scalar_form(package, precision)
    lanes = [in_lanes(function) for function in functions]
    texts = tuple(map(function_text, functions, lanes))
    has_angles = any(function.angles for function in functions)
    called = {name for function in functions for name in function.printer.called}
    return SourceText(
        **vars(package_text(package, precision, functions, form)),
        functions=texts,
        called=with_needed(called, has_angles) if precision.is_pair else frozenset(called),
        pair=form.pair,
        has_lanes=any(lanes),
        is_long=any(len(function.steps) >= OUTLINED_FROM for function in functions),
        advances=precision.state == "float" and any(f.name == "direct_dynamics" for f in package.functions),
        steps=CSteps(package, precision, functions),
    )


def package_text(package: Package, precision: Precision, functions: Sequence[CFunction], form: Form) -> PackageText:
    """Template data of a package with these functions."""
    name = package.name + precision.suffix
    return PackageText(
        name=name,
        macro=name.upper(),
        banner=banner(package, precision),
        summary=package.scene,
        axes=package.axes,
        dependent=package.dependent,
        motor_names=package.motor_names,
        frames=len(package.frames),
        parameters=package.parameters,
        defaults=default_lines(package, precision),
        precision=precision,
        has_angles=any(function.angles for function in functions),
        real=form.real,
        own={f: form.functions[f] for f in OWN_FUNCTIONS},
    )


def banner(package: Package, precision: Precision) -> str:
    """Comment at the beginning of every file."""
    return "\n * ".join(sentences(package, precision))


def sentences(package: Package, precision: Precision) -> tuple[str, ...]:
    """Return the sentences at the beginning of all files: origin, and that use is free."""
    source = f" from {in_comment(package.source)}" if package.source else ""
    return (
        f"Generated by symoro-elastic{source}: do not edit, generate it again.",
        f"Options: {in_comment('; '.join([precision.title, *package.options]))}.",
        "The licence of the generator does not cover this file: use it under any licence you like.",
    )


def default_lines(package: Package, precision: Precision) -> tuple[str, ...]:
    """Lines of the initializer of p with its default values."""
    last = len(package.parameters) - 1
    return tuple(_default(p, precision, k == last) for k, p in enumerate(package.parameters))


def _default(parameter: ParameterValue, precision: Precision, is_last: bool) -> str:
    """Line of the default value of a parameter."""
    value = "NAN" if math.isnan(parameter.value) else repr(parameter.value)
    value = f"(float){value}" if precision.state == "float" else value
    unit = f" [{in_comment(parameter.unit)}]" if parameter.unit else ""
    return f"{INDENT}{value}{'' if is_last else ','} /* {parameter.name}{unit} */"


# Functions on sums of two doubles in C: which of them need which.
def with_needed(called: Iterable[str], has_angles: bool) -> frozenset[str]:
    """Return the helper functions that are called, directly or by each other."""
    needed: set[str] = set()
    stack = [*called, *(["sincos"] if has_angles else [])]
    while stack:
        name = stack.pop()
        if name not in needed:
            needed.add(name)
            stack += NEEDS[name]
    return frozenset(needed)


C = Target(
    name="c",
    title="C99: one state a call",
    suffixes=(".h", ".c"),
    precisions=tuple(PRECISIONS.values()),
    reserved=KEYWORDS | LIBRARY,
    files=render_c,
)
