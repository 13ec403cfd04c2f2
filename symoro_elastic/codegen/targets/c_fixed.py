"""The target `c-fixed`: C99 on integers of 32 bits, whose scales are proven; one header and one source."""

from __future__ import annotations

from symoro_elastic.codegen.c.fixed_function import FixedFunction
from symoro_elastic.codegen.c.lines import wrap_lines
from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import Precision
from symoro_elastic.codegen.target import Target, words
from symoro_elastic.codegen.targets.c import C, banner
from symoro_elastic.codegen.templates import render, with_digest

FIXED = Precision("fixed-point", "fixed point of 32 bits", "int32_t", "int32_t", "uint32_t", 31, short="fixed")
"""The fixed-point precision, which needs proven ranges; it is not among those of floating point."""
OWN = words("int32_t uint32_t int64_t angle sine cosine k INT32_MAX UINT32_MAX INT32_MIN")
"""Identifiers of the templates that a user's name could hide."""
NEEDS = {"sine": ("sincos",), "cosine": ("sincos",)}
"""Which functions of the file need which."""


def render_c_fixed(package: Package, precision: Precision = FIXED) -> Files:
    """Return `<name>_fixed.h` and `<name>_fixed.c`; raises `ValueError` for a package without scales."""
    named, name = with_local_names(with_own_results(package), OWN), f"{package.name}_fixed"
    functions = [FixedFunction(named, function, name).text() for function in named.functions]
    called = {name_called for function in functions for name_called in function.called}
    for name_called in [*called]:
        called |= {*NEEDS.get(name_called, ())}
    context = {
        "name": name,
        "macro": name.upper(),
        "banner": banner(package, precision),
        "summary": package.scene,
        "axes": package.axes,
        "dependent": package.dependent,
        "motor_names": package.motor_names,
        "functions": functions,
        "called": called,
    }
    names = {f"{name}{suffix}": f"c_fixed/model{suffix}.j2" for suffix in (".h", ".c")}
    return with_digest({file: wrap_lines(render(template, **context)) for file, template in names.items()})


C_FIXED = Target(
    name="c-fixed",
    title="C99 in fixed point of 32 bits, with scales proven for the [limits]",
    suffixes=(".h", ".c"),
    precisions=(FIXED,),
    reserved=C.reserved,
    files=render_c_fixed,
)
