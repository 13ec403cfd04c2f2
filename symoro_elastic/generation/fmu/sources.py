"""The C sources of an FMU: the generated functions, and the interface of FMI around them."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

from symoro_elastic.codegen.c.lines import wrap_lines
from symoro_elastic.codegen.local_names import with_own_results
from symoro_elastic.codegen.package import EXTERNAL, Function, Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import DOUBLE
from symoro_elastic.codegen.targets.c import SourceText, banner, c_text, files_of
from symoro_elastic.codegen.templates import render
from symoro_elastic.codegen.time_steps import (
    Literals,
    MethodText,
    blocks_carried,
    method_text,
    rows_of_nodes,
    settling_of,
)
from symoro_elastic.generation.fmu.programs import Given, Programs
from symoro_elastic.generation.fmu.scalar_variables import Layout
from symoro_elastic.generation.fmu.start import Start
from symoro_elastic.models.drives.control import CONTROL, START
from symoro_elastic.models.drives.drive_states import SET_POINTS
from symoro_elastic.models.steps.time_steps import MOTOR_COORDINATES, PASSED, PASSED_TORQUES, TERMS

TOLERANCE, FINEST = "1e-10", "1e-14"
"""Relative tolerance of co-simulation: unless the importer gives one, and at least."""
MOST_STEPS = 1_000_000
"""Inside one communication step, those that are taken again among them."""
STATE = {"q": "Q", "qd": "QD", "z": "Z", "p": "P"}
RESULTS = {"qdd": "DER_QD", "zd": "DER_Z", "tau_m": "TAU_M", "y": "Y"}
LOCAL = {"q_dep_out": "closed", "residual": "residual", "u": "m->sampled", "zc": "m->zc", "zc_next": "m->zc"}
LOCAL |= {"q_motor": "measured", "qd_motor": "speed"}
LOCAL |= {f"{of}{name}": local for of in ("", "d") for name, local in ((PASSED, "passed"), (TERMS, "terms"))}
RATES = ("direct_dynamics", "closed_dynamics")
KNOWN_ALONG = (*RATES, "outputs", PASSED_TORQUES)
CALLED = (*KNOWN_ALONG, *(f"{name}_directional" for name in KNOWN_ALONG), "assemble")
OF_SAMPLES = (CONTROL, START, MOTOR_COORDINATES)
"""Functions that an instance calls between time steps."""
PER_LINE = 6


@dataclass(frozen=True)
class _Constants:
    """Numbers that depend on parameters only: array in an instance, macro of its size, call that computes them."""

    array: str
    macro: str
    prepare: str


def sources_of(programs: Programs, layout: Layout, start: Start, version: int, token: str) -> Files:
    """Return the sources of an FMU by name; `token` is the identifier in its description."""
    text = c_text(programs.package)
    return {**files_of(text), interface_file(version): _interface(programs, text, layout, start, version, token)}


def interface_file(version: int) -> str:
    """Return the name of the file with the interface; its hyphen keeps it apart from names of machines."""
    return f"interface-fmi{version}.c"


def _interface(programs: Programs, text: SourceText, layout: Layout, start: Start, version: int, token: str) -> str:
    package, method = programs.package, programs.method
    method_texts = method_text(method, package, DOUBLE)
    constants = _constants(text, package)
    prepared = {variable.array for variable in constants}
    functions = {f.name: f for f in with_own_results(package).functions}
    calls = {name: _call(programs, functions[name], prepared) for name in (*CALLED, *OF_SAMPLES) if name in functions}
    rates = next(name for name in RATES if name in functions)
    calls |= {"rates": calls[rates], "rates_directional": calls[f"{rates}_directional"]}
    calls["step"] = _step(programs, method_texts, "c_step" in prepared)
    variables = layout.variables
    return wrap_lines(
        render(
            f"fmu/fmi{version}.c.j2",
            name=package.name,
            banner=banner(package, DOUBLE),
            prefix=f"FMI{version}_FUNCTION_PREFIX",
            token=token,
            blocks=layout.blocks,
            values=len(variables),
            n=len(package.axes),
            states=len(layout.states),
            further=len(programs.states),
            **_of_inputs(programs, functions),
            parameters=len(package.parameters),
            bounded=[variable for variable in layout.block("P") if variable.minimum is not None],
            dependent=sum(block.size for block in package.assembled),
            outputs=len(layout.block("Y")),
            constants=constants,
            start=list(_numbers([variable.start or "0.0" for variable in variables])),
            loads=settling_of(package, Literals(DOUBLE)),
            nominal=list(_numbers([variable.nominal or "1.0" for variable in layout.states])),
            start_dep=[repr(x) for x in start.q_dep.tolist()],
            calls=calls,
            method=method_texts,
            exponent=f"{method.order}.0",  # of the step in the error: that of the embedded method, plus one
            fastest=f"{start.fastest:.2e}",
            tolerance=TOLERANCE,
            most_steps=MOST_STEPS,
            finest=FINEST,
        )
    )


def _of_inputs(programs: Programs, functions: Mapping[str, Function]) -> dict[str, Any]:
    """Return the template data on inputs, in rows of motors, and on samples; `fed` is the index where torques begin."""
    package, rows, sampling = programs.package, list(programs.inputs.values()), programs.sampling
    return {
        "motors": len(package.motor_names),
        "inputs": sum(rows),
        "given": sum(rows),
        "forces": package.external,
        "rows": rows[: -1 if package.external else None],
        "sampling": sampling,
        "kept": len(functions[CONTROL].columns) if sampling else 0,
        "fed": sum(programs.inputs[name] for name in SET_POINTS) if sampling else 0,
    }


def _constants(text: SourceText, package: Package) -> list[_Constants]:
    """Return the arrays of constants that depend on parameters, of functions that are called and of time steps."""
    by_name = {function.name.removeprefix(f"{package.name}_"): function for function in text.functions}
    called = [(name, by_name[name]) for name in (*CALLED, *OF_SAMPLES) if name in by_name]
    arrays = [
        _Constants(f"c_{name}", function.constants, f"{function.name}_prepare(&m->value[P], m->c_{name})")
        for name, function in called
        if function.constants
    ]
    if text.steps.constants:
        prepare = f"{package.name}_step_prepare(&m->value[P], m->c_step)"
        arrays.append(_Constants("c_step", f"{text.macro}_STEP_CONSTANTS", prepare))
    return arrays


def _call(programs: Programs, function: Function, prepared: Collection[str]) -> str:
    """Return the call of a function on an instance `m`; seeds and derivatives are in `along`."""
    firsts = accumulate(programs.inputs.values(), initial=0)
    of_inputs = {name: f"INPUT + {k}U" if k else "INPUT" for name, k in zip(programs.inputs, firsts, strict=False)}
    package, blocks = programs.package, STATE | of_inputs
    places = {key: f"&m->value[{block}]" for key, block in blocks.items()}
    places |= {block.name: f"m->{block.name}" for block in package.assembled}
    places |= {f"seed_{key}": f"&along[{block}]" for key, block in blocks.items()}
    places |= {"load": "m->load", "seed_load": "load"}
    if function.name.startswith(PASSED_TORQUES):
        places |= {"qdd": "&m->value[DER_QD]", "seed_qdd": "&along[DER_QD]"}
        torques = "INPUT" if programs.given is Given.TORQUES else "TAU_M"
        places |= {"tau": f"&m->value[{torques}]", "seed_tau": f"&along[{torques}]"}
    if function.name in OF_SAMPLES:
        places |= {name: place.replace("m->value[INPUT", "given[0U") for name, place in places.items()} | {
            "zc": "m->zc"
        }
    elif programs.sampling and not function.name.startswith(PASSED_TORQUES):
        places |= {"tau": "m->held", "seed_tau": "still"}
    array = "along" if function.name.endswith("_directional") else "m->value"
    along = array == "along"
    inputs = [places.get(a.name, a.name) for a in function.arguments]
    results = [
        LOCAL.get(r.name) or f"&{array}[{RESULTS[r.name.removeprefix('d') if along else r.name]}]"
        for r in function.results
    ]
    has_constants = f"c_{function.name}" in prepared
    c = [f"m->c_{function.name}"] if has_constants else []
    suffix = "_prepared" if has_constants else ""
    return f"{package.name}_{function.name}{suffix}({', '.join([*inputs, _parameters(package), *c, *results])})"


def _parameters(package: Package) -> str:
    """Return the place of the parameters, NULL for a package without any."""
    return "&m->value[P]" if package.parameters else "NULL"


def _step(programs: Programs, method: MethodText, has_constants: bool) -> str:
    """Return the call of a time step with its error; inputs are in `u`, rows of torques before those of wrenches."""
    package, variant = programs.package, method.variants[0]
    nodes, motors = len(method.nodes), len(package.motor_names)
    firsts = accumulate(programs.inputs.values(), initial=0)
    places = {name: f"&u[{nodes * k}U]" if k else "u" for name, k in zip(programs.inputs, firsts, strict=False)}
    rates = {"taud": "m->input_rate", f"{EXTERNAL}d": f"&m->input_rate[{motors}U]"}
    rows = [places[name] for name in rows_of_nodes(variant, package)]
    changing = [rates[name] for name in variant.of_rate] if method.kind == "rosenbrock" else []
    c = ["m->c_step"] if has_constants else []
    blocks = {"q": "&m->value[Q]", "qd": "&m->value[QD]", "z": "&m->value[Z]"}
    state = [*(blocks.get(block.name, f"m->{block.name}") for block in blocks_carried(variant, package)), "error"]
    suffix = "_prepared" if has_constants else ""
    arguments = [*rows, *changing, "h", _parameters(package), *c, *state]
    return f"{package.name}_step_{method.name}{variant.suffix}_error{suffix}({', '.join(arguments)})"


def _numbers(texts: Sequence[str]) -> Iterator[str]:
    """Yield the lines of the C initializer of an array, several numbers a line."""
    lines = [texts[k : k + PER_LINE] for k in range(0, len(texts), PER_LINE)]
    for k, line in enumerate(lines):
        yield ", ".join(line) + ("," if k < len(lines) - 1 else "")
