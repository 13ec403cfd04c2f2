"""Names of local variables that do not clash with names of the generated code."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

from symoro_elastic.codegen.package import Function, Package
from symoro_elastic.symbolic.program import rename_variables


def with_local_names(package: Package, own: Collection[str]) -> Package:
    """Return the package with other local names for variables and parameters whose names are reserved (`own`).

    `own` are the identifiers of a target's templates; arrays of functions, and functions and macros of the machine, are
    used too. Users see the names of parameters and joints as they are: only local variables are renamed, `c` to `c_`.
    """
    used = {*own}
    for function in package.functions:
        used |= {a.name for a in function.arguments} | {r.name for r in function.results}
    prefixes = (f"{package.name}_", f"{package.name.upper()}_")
    symbols = {*_symbols(package)}
    reserved = used | symbols | {s.name for f in package.functions for s in (*f.program.once, *f.program.statements)}
    names: dict[str, str] = {}
    for name in sorted(symbols):
        if name in used or name.startswith(prefixes):
            names[name] = _free(name, prefixes, reserved)
            reserved.add(names[name])
    if not names:
        return package
    return replace(
        package,
        parameters=tuple(replace(p, local=names.get(p.symbol, p.symbol)) for p in package.parameters),
        functions=tuple(replace(f, program=rename_variables(f.program, names)) for f in package.functions),
        congruent=tuple(tuple(names.get(name, name) for name in cycle) for cycle in package.congruent),
    )


def with_own_results(package: Package) -> Package:
    """Return the package with result names that differ from all arguments: `q_dep_out` for q_dep.

    In C both are parameters of the same function.
    """
    return replace(package, functions=tuple(map(of_own_results, package.functions)))


def of_own_results(function: Function) -> Function:
    """Return the function with result names that differ from all its arguments."""
    shared = {a.name for a in function.arguments} & {r.name for r in function.results}
    if not shared:
        return function
    names = {name: f"{name}_out" for name in shared}
    outputs = tuple(replace(o, name=names.get(o.name, o.name)) for o in function.program.outputs)
    results = tuple(replace(r, quantity=replace(r.quantity, name=names.get(r.name, r.name))) for r in function.results)
    return replace(function, results=results, program=replace(function.program, outputs=outputs))


def _symbols(package: Package) -> Iterator[str]:
    """Names of parameters and of the entries of arguments."""
    yield from (p.symbol for p in package.parameters)
    for function in package.functions:
        for argument in function.program.inputs:
            yield from argument.symbols


def _free(name: str, prefixes: tuple[str, ...], taken: Collection[str]) -> str:
    """A free name: the name with an underscore after it, then with a number, and with one before it if needed."""
    stem = f"of_{name}" if name.startswith(prefixes) else name
    number, found = 1, f"{stem.rstrip('_')}_"
    while found in taken:
        number, found = number + 1, f"{stem.rstrip('_')}_{number}"
    return found
