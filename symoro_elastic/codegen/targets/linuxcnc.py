"""The target `linuxcnc`: components for LinuxCNC, torques of motors, sampled controllers, kinematics in closed form."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

from symoro_elastic.codegen.c.lines import in_comment, with_arguments
from symoro_elastic.codegen.hal_function import HalFunction
from symoro_elastic.codegen.local_names import with_local_names, with_own_results
from symoro_elastic.codegen.package import Axis, Function, Package
from symoro_elastic.codegen.package_context import Files
from symoro_elastic.codegen.precision import DOUBLE, Precision
from symoro_elastic.codegen.target import Target, words
from symoro_elastic.codegen.targets.c import C, sentences
from symoro_elastic.codegen.templates import LINE, render
from symoro_elastic.foundation.errors import InputError, without_value

TORQUES, FORWARD = "inverse_dynamics", "geometric_model"
CONTROL, START = "control", "control_start"
INVERSES = ("inverse_geometric_model", "inverse_position_model")
LONGEST_NAME = 24
"""Maximum length of a machine's name: pins have 47 characters."""
DEGREE, MILLIMETRE = math.pi / 180, 1e-3
OWN = words(
    "period q qd qdd tau branch fperiod T P found singularity joint k way tried best wanted inst comp_id enable u "
    "measured speed r rd rdd states is_running"
)
"""Identifiers of the templates, and macros of pins."""
CALLED = (
    "Call it in a thread with the period of the drives, after the positions are read and before torques are written."
)
UNITS = "Joints are in degrees or mm, as LinuxCNC has them; their velocities and accelerations likewise."


@dataclass(frozen=True)
class Pins:
    """An argument as pins: names in HAL and in C, entries, meaning, and units of entries in SI units."""

    pin: str
    name: str
    size: int
    meaning: str
    units: tuple[str, ...]


def render_linuxcnc(package: Package, precision: Precision = DOUBLE) -> Files:
    """Return components by name: `_ff` of the inverse dynamic model, `_control` of sampled controllers, `_kins`.

    The last one is of geometric and inverse models. Raises `InputError` for a package with none of them, or with models
    that no component can call.
    """
    source = package.source or package.name
    if len(package.name) > LONGEST_NAME:
        what = f"{package.name} is too long for names of pins: at most {LONGEST_NAME} characters"
        raise InputError(source, "--target linuxcnc, name", what)
    named = with_local_names(with_own_results(package), OWN)
    functions = {function.name: function for function in named.functions}
    inverse = next((functions[name] for name in INVERSES if name in functions), None)
    files: Files = {}
    if TORQUES in functions:
        files[f"{package.name}_ff.comp"] = _feed_forward(named, functions[TORQUES], source)
    if CONTROL in functions and START in functions:
        files[f"{package.name}_control.comp"] = _controllers(named, functions[CONTROL], functions[START], source)
    if inverse and FORWARD in functions:
        files[f"{package.name}_kins.comp"] = _kinematics(named, functions[FORWARD], inverse, source)
    if not files:
        what = f"a component needs {TORQUES}, {CONTROL}, or {FORWARD} with {' or '.join(INVERSES)}: --model"
        raise InputError(source, "--target linuxcnc", what)
    return files


def _refuse_missing(package: Package, functions: Sequence[Function], source: str) -> None:
    """Raise `InputError` for parameters without a value."""
    used = frozenset().union(*(function.program.used for function in functions))
    missing = [p.name for p in package.parameters if math.isnan(p.value) and p.symbol in used]
    if missing:
        raise InputError(source, "--target linuxcnc", without_value(missing))


def unit_of(axis: Axis) -> float:
    """Return the unit of a joint in LinuxCNC in SI units: a degree or a millimetre."""
    return MILLIMETRE if axis.unit.endswith(", m") else DEGREE


# Torques


def _feed_forward(package: Package, function: Function, source: str) -> str:
    """HAL component that computes the feed-forward torques."""
    _refuse_missing(package, [function], source)
    model = HalFunction(package, function)
    pins = [_pins(package, a.name, a.size, a.meaning) for a in function.arguments if a.size]
    results = [{"name": r.name, "size": math.prod(r.shape)} for r in function.results]
    call = [f"given_{pin.name}" for pin in pins] + [f"found_{r['name']}" for r in results]
    torques = next(math.prod(r.shape) for r in function.results if r.name == "tau")
    about = [
        "Entries are by joint:",
        f"q, qd: {', '.join(axis.name for axis in package.axes)};",
        f"qdd, tau: {', '.join(package.motor_names)}.",
        f"{UNITS} Torques are in N m, forces in N.",
    ]
    return render(
        "linuxcnc/feed_forward.comp.j2",
        name=package.name,
        described=_description(package, about),
        inputs=pins,
        results=results,
        torques=torques,
        called=model.called,
        own=model.own,
        model=model.text(),
        call=with_arguments(f"    {model.name}", call).lstrip(),
    )


def _controllers(package: Package, function: Function, start: Function, source: str) -> str:
    """HAL component of the sampled controllers with their states."""
    _refuse_missing(package, [function, start], source)
    models = [HalFunction(package, model) for model in (function, start)]
    pins = [_pins(package, a.name, a.size, a.meaning) for a in function.arguments if a.name != "zc"]
    states = next((a.size for a in function.arguments if a.name == "zc"), 0)
    arguments = {a.name: "states" if a.name == "zc" else f"given_{a.name}" for a in function.arguments if a.size}
    begin = [arguments[a.name] for a in start.arguments if a.size] + ["states"] * bool(states)
    about = [f"Entries are by motor: {', '.join(package.motor_names)}.", UNITS, "Torques are in N m, forces in N."]
    return render(
        "linuxcnc/control.comp.j2",
        name=package.name,
        described=_description(package, [*about, CALLED]),
        inputs=pins,
        motors=len(package.motor_names),
        states=max(states, 1),
        has_states=bool(states),
        called=set().union(*(model.called for model in models)),
        own=models[0].own,
        model=models[0].text(),
        start=models[1].text() if states else "",
        begin=with_arguments(f"        {models[1].name}", begin).lstrip(),
        call=with_arguments(
            f"    {models[0].name}", [*arguments.values(), "found_u", *["found_zc"] * bool(states)]
        ).lstrip(),
    )


def _pins(package: Package, name: str, size: int, meaning: str) -> Pins:
    """The pins of an argument: joints in units of LinuxCNC, everything else in SI units."""
    motors = package.driven or [package.axes[k] for k in package.motors]
    of_joints = dict.fromkeys(("measured", "speed", "r", "rd", "rdd"), motors) | {
        "q": package.axes,
        "qd": package.axes,
        "qdd_motor": motors,
        "q_dep": package.dependent or (),
    }
    units = tuple(map(unit_of, of_joints[name])) if name in of_joints else (1.0,) * size
    short = "qdd" if name == "qdd_motor" else name
    about = meaning.partition(",")[0] if name in of_joints else meaning
    stem = short.replace("_", "-")
    pin = f"{stem}-#" if short[-1].isdigit() else f"{stem}#"
    return Pins(pin, short, size, about.replace('"', "'"), tuple(map(repr, units)))


def _description(package: Package, about: Sequence[str]) -> list[str]:
    """Lines of the description of a component."""
    lines = [line for text in (*sentences(package, DOUBLE), *about) for line in textwrap.wrap(text, LINE)]
    return [in_comment(line).replace("\\", "/").replace('"', "'") for line in lines]


# Kinematics


def _kinematics(package: Package, forward: Function, inverse: Function, source: str) -> str:
    """HAL component of the kinematics."""
    _refuse_kinematics(package, forward, inverse, source)
    solutions, joints = inverse.results[0].shape
    models = [HalFunction(package, function, static=True) for function in (forward, inverse)]
    entries, placed = math.prod(forward.results[0].shape), forward.results[0].rows.index(inverse.placed)
    return render(
        "linuxcnc/kinematics.comp.j2",
        name=package.name,
        described=_description(package, _about_kinematics(package, inverse.placed)),
        solutions=solutions,
        last_branch=solutions - 1,
        joints=joints,
        found=solutions * joints,
        units=[repr(unit_of(axis)) for axis in package.axes],
        turns=["360.0" if unit_of(axis) == DEGREE else "0.0" for axis in package.axes],
        degree=repr(DEGREE),
        frames=entries,
        placed=16 * placed,
        forward=models[0].text(),
        forward_name=models[0].name,
        inverse=models[1].text(),
        inverse_name=models[1].name,
        by_position=inverse.name == "inverse_position_model",
        called=set().union(*(model.called for model in models)),
        own=models[0].own,
    )


def _about_kinematics(package: Package, placed: str) -> list[str]:
    return [
        f"Joints, in degrees or mm: {', '.join(axis.name for axis in package.axes)}.",
        f"World: the frame {placed} in the base, x y z in mm, a b c in degrees, R = Rz(c) Ry(b) Rx(a).",
        "Angles of joints are turned by whole turns to where the joints are.",
        "The pin branch chooses a solution; -1 takes the nearest.",
    ]


def _refuse_kinematics(package: Package, forward: Function, inverse: Function, source: str) -> None:
    """Raise `InputError` unless the models give the pose of a frame that all joints move."""
    _refuse_missing(package, [forward, inverse], source)
    place = f"--target linuxcnc, {inverse.name}"
    if inverse.placed not in forward.results[0].rows:
        what = f"it places {inverse.placed}, which {FORWARD} does not give: ask both for the same frame"
        raise InputError(source, place, what)
    if inverse.results[0].columns or package.motor_names != tuple(axis.name for axis in package.axes):
        what = f"joints without a motor, or that do not move {inverse.placed}, have no place in kinematics: lock them"
        raise InputError(source, place, what)
    if [a.name for a in forward.arguments] != ["q"]:
        names = ", ".join(a.name for a in forward.arguments if a.name != "q")
        raise InputError(source, place, f"{FORWARD} takes {names} beside q, which LinuxCNC does not know")


LINUXCNC = Target(
    name="linuxcnc",
    title="components for LinuxCNC: torques, sampled controllers, kinematics",
    suffixes=("_ff.comp", "_control.comp", "_kins.comp"),
    precisions=(DOUBLE,),
    reserved=C.reserved,
    files=lambda package, _: render_linuxcnc(package),
)
