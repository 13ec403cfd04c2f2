"""Generated time steps: C against numpy, batches against single calls, precisions, warnings, and no branch on data."""

from __future__ import annotations

import ctypes
import re
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from symoro_elastic.codegen.c.steps import CSteps, StepText
from symoro_elastic.codegen.compile import compile_library
from symoro_elastic.codegen.integration.tableaus import METHODS
from symoro_elastic.codegen.local_names import with_own_results
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.precision import DOUBLE, PRECISIONS, Precision
from symoro_elastic.codegen.targets.c import render_c, source_text
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.drives import CurrentControl, Drive, Drives, LowPass, Notch
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.joints import Electrics
from symoro_elastic.machine.machine import Floating, Friction, Joint, Kind, KnownOfBase, Machine, Orientation
from symoro_elastic.machine.resolve import resolve
from symoro_elastic.machine.restrict import under_forces
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.verification.implementations import import_package
from symoro_elastic.quantities.time_steps import TimeStep
from tests.benchmarks.instructions import available, counted
from tests.closed_chains.machines import machine as of_loops
from tests.closed_chains.machines import situations
from tests.generated_code import COMPILERS
from tests.models.test_creep import creeping
from tests.models.test_floating_base import on
from tests.references.random_machines import planar_2r, random_machine

STRICT = ("-O0", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror")
STATES, H = 19, 1e-4
"""More states than a batch takes side by side, and no multiple of it."""
CASES = {
    "random": tuple(TimeStep),
    "planar": ("w3",),
    "pushed": ("w2", "rodas4", "midpoint"),
    "ring": ("w2",),
    "delta": ("w2", "rk4"),
    "ring driven at link_3": ("w2",),
    "gantry_rigid": ("w2",),
    "ball_screw": ("w2",),
    "on_base": ("w3", "rk4", "midpoint"),
    "body": ("w2",),
    "drives": ("w3", "rk4"),
    "loaded": ("w3",),
}

pytestmark = [pytest.mark.skipif(not COMPILERS, reason="no C compiler"), pytest.mark.sampled(6)]


def machine(name: str) -> Machine:
    if name == "random":
        kinds = (Kind.MOTOR, Kind.ELASTIC, Kind.PASSIVE)
        return creeping(random_machine(3, joints=4, kinds=kinds, symbolic=True, massless=0))
    if name == "planar":
        return planar_2r(elastic=[2])
    if name == "pushed":
        return under_forces(planar_2r(elastic=[2]), [planar_2r().joints[-1].name])
    if name == "on_base":
        kinds = (Kind.MOTOR, Kind.ELASTIC, Kind.PASSIVE)
        return on(creeping(random_machine(3, joints=3, kinds=kinds, massless=0)), turned=Orientation.QUATERNION)
    if name == "body":
        return on(Machine("body", (Joint("tip", 0, Kind.FIXED, 2),)))
    if name == "loaded":
        return loaded(creeping(two_motors()))
    if name == "drives":
        return with_limits(creeping(two_motors()))
    stem, _, driven = name.partition(" driven at ")
    found = creeping(of_loops(stem))
    return driven_at(found, driven) if driven else found


def two_motors() -> Machine:
    return random_machine(1, joints=4, kinds=(Kind.MOTOR, Kind.ELASTIC), massless=0)


def loaded(machine: Machine, coulomb: str = "0.3", share: str = "0.2") -> Machine:
    """The machine with friction of its motors that rises with load, on a bristle or creeping in turn."""
    keys = ("viscous", "coulomb", "load", "creep", "bristle", "bristle_damping")
    laws = (("0.1", coulomb, share, "0.01", "0", "0"), ("0.1", coulomb, share, "0", "300", "1"))
    known = [Friction(**dict(zip(keys, map(Formula.parse, law), strict=True))) for law in laws]
    places = {joint.name: known[k % 2] for k, joint in enumerate(machine.motor_joints, start=1)}
    rows = (replace(joint, friction=places.get(joint.name, joint.friction)) for joint in machine.joints)
    return replace(machine, joints=tuple(rows))


def with_limits(machine: Machine) -> DescribedMachine:
    """The machine with drives whose limits act at some of the states: a lag and a notch, a winding, a plain gain."""
    volts = Electrics(*map(Formula.parse, ("0.5", "2e-3", "0.2", "0.15")))
    joints = tuple(replace(row, electrics=volts) for row in machine.joints)
    gains, notch = (Formula.parse("20"), Formula.parse("2")), Notch(*map(Formula.parse, ("30", "0.1", "0.7")))
    few, tn, lag = Formula.parse("15"), Formula.parse("0.02"), Formula.parse("2e-4")
    smooth = LowPass(Formula.parse("60"), 2)
    current = CurrentControl(Formula.parse("4"), Formula.parse("3e-3"))
    kinds = (
        Drive(*gains, tn, lag, filters=(notch,), torque_limit=few, set_point=smooth),
        Drive(*gains, tn, current=current, current_limit=few, voltage_limit=few),
        Drive(*gains),
    )
    by_motor = {joint.name: kind for joint, kind in zip(machine.motor_joints, kinds, strict=False)}
    assert len(by_motor) > 1
    return replace(DescribedMachine.of(replace(machine, joints=joints)), drives=Drives(by_motor))


def driven_at(machine: Machine, name: str) -> Machine:
    """The machine with its motor on a joint that follows from a loop."""
    joints = (replace(row, kind=Kind.PASSIVE) if row.kind is Kind.MOTOR else row for row in machine.joints)
    moved = tuple(replace(row, kind=Kind.MOTOR) if row.name == name else row for row in joints)
    loops = (
        replace(loop, dependent=tuple(machine.joint(j).name for j in machine.dependent_in(loop)))
        for loop in machine.loops
    )
    return replace(machine, joints=moved, loops=tuple(loops))


@dataclass(frozen=True)
class Generated:
    """Steps of a machine in numpy and in C, and the states they are taken from."""

    package: Package
    module: ModuleType
    library: ctypes.CDLL
    steps: tuple[StepText, ...]
    state: dict[str, Array]


@cache
def generated(name: str) -> Generated:
    package = trace_models(machine(name), Scene(models=("direct_dynamics",), steps=CASES[name])).package
    with TemporaryDirectory() as folder:
        library = ctypes.CDLL(str(compile_library(render_c_batch(package), Path(folder) / "c", flags=STRICT)))
        module = import_package(render_numpy(package), Path(folder) / "numpy")
    steps = tuple(source_text(with_own_results(package), DOUBLE).steps.steps)
    return Generated(package, module, library, steps, state_of(name, package, module))


def state_of(name: str, package: Package, module: ModuleType) -> dict[str, Array]:
    """q, qd and, where loops are assembled, q_dep of some states."""
    rng, n = np.random.default_rng(1), len(package.axes)
    if package.base:
        joints = {"q": 0.1 * rng.normal(size=(STATES, n)), "qd": rng.normal(size=(STATES, n))}
        turned = Rotation.random(STATES, random_state=1)
        by_matrix = package.base[0].name == "R0"
        first = turned.as_matrix().reshape(STATES, 9) if by_matrix else turned.as_quat()
        others = {"P0": rng.normal(size=(STATES, 3)), "V0": rng.normal(size=(STATES, 6))}
        return joints | {package.base[0].name: first} | others
    if package.dependent is None:
        moved = {"q": 0.1 * rng.normal(size=(STATES, n)), "qd": rng.normal(size=(STATES, n))}
        return moved | ({"z": rng.normal(size=(STATES, len(package.states)))} if package.states else {})
    first = situations(name.split(maxsplit=1)[0])[0].state
    q = np.array(first.u) + 1e-3 * rng.normal(size=(STATES, n))
    if not package.assembled:
        return {"q": q, "qd": rng.normal(size=(STATES, n))}
    variables = {row.name: str(row.variable) for row in machine(name).joints}
    guess = np.array([float(first.guess[variables[axis.name]]) for axis in package.dependent or ()])
    return {"q": q, "qd": rng.normal(size=(STATES, n)), "q_dep": module.assemble(q, np.tile(guess, (STATES, 1)))[0]}


def parameters(package: Package) -> Array:
    return np.array([*(p.value for p in package.parameters), 0.0])


def given(step: StepText, package: Package, q: Array) -> dict[str, Array]:
    """What a step is given of the motors, (states, entries)."""
    rng = np.random.default_rng(2)
    found = {array.name: rng.normal(size=(STATES, array.entries)) for array in step.read}
    if "y" in found:
        found["y"] = (
            np.tile(q[:, list(package.motors)], (1, len(step.method.nodes_of(step.variant)))) + 1e-3 * found["y"]
        )
    return {name: 100 * abs(x) if name in ("kp", "kd") else x for name, x in found.items()}


def pointers(arrays: Any) -> list[ctypes.c_void_p]:
    return [array.ctypes.data_as(ctypes.c_void_p) for array in arrays]


def by_c(of: Generated, step: StepText) -> list[Array]:
    """Results of calls, one for each state."""
    p, read = parameters(of.package), given(step, of.package, of.state["q"])
    written = [of.state[a.name].copy() if a.name in of.state else np.zeros((STATES, a.entries)) for a in step.written]
    for s in range(STATES):
        arguments = pointers(np.ascontiguousarray(x[s]) for x in read.values())
        rows = pointers(x[s] for x in written)
        getattr(of.library, step.name)(*arguments, ctypes.c_double(H), *pointers([p]), *rows)
    return written


def by_batch(of: Generated, step: StepText) -> list[Array]:
    """Results of one call for all states."""
    read = given(step, of.package, of.state["q"])
    written = [of.state.get(a.name, np.zeros((STATES, a.entries))).T.copy() for a in step.written]
    columns = [np.ascontiguousarray(x.T) for x in read.values()]
    tail = [ctypes.c_double(H), *pointers([parameters(of.package)]), *pointers(written)]
    getattr(of.library, f"{step.name}_batch")(ctypes.c_size_t(STATES), *pointers(columns), *tail)
    return [x.T for x in written]


def by_numpy(of: Generated, step: StepText) -> tuple[Array, ...]:
    """Results for all states at once."""
    motors = len(of.package.motor_names)
    read = given(step, of.package, of.state["q"])
    widths = dict.fromkeys(step.variant.of_nodes, motors) | {"f0": 6, "f_ext": of.package.external}
    nodes = len(step.method.nodes_of(step.variant))
    rows = [x.reshape(STATES, nodes, widths[name]) if name in widths else x for name, x in read.items()]
    function = getattr(of.module, step.name.removeprefix(f"{of.package.name}_"))
    carried = [of.state[array.name] for array in step.written if array.name in of.state]
    found: tuple[Array, ...] = function(*rows, H, *carried, parameters(of.package)[:-1])
    return found


@pytest.mark.sampled(12)
@pytest.mark.sampled(6)
@pytest.mark.parametrize("name", CASES)
def test_c_is_numpy_and_batches_are_single_calls(name: str) -> None:
    """Every method, servo, prescribed motion and error: rounding apart, which dense systems of rodas4 magnify."""
    of = generated(name)
    assert {step.method.name for step in of.steps} == {*CASES[name]}
    for step in of.steps:
        one, many = by_c(of, step), by_numpy(of, step)
        rounding = 1e-10 if step.method.kind == "rosenbrock" else 1e-12
        for array, ours, other in zip(step.written, one, many, strict=True):
            if not ours.size:
                continue
            assert np.abs(ours).max() > 0, step.name
            np.testing.assert_allclose(ours, other, rtol=0, atol=rounding * np.abs(ours).max(), err_msg=step.name)
            moved = array.name == "error" or np.abs(ours - of.state[array.name]).max() > 1e-7
            assert moved, (step.name, array.name)
        if step.method.kind != "rosenbrock":
            for ours, other in zip(one, by_batch(of, step), strict=True):
                np.testing.assert_array_equal(ours, other, err_msg=step.name)


@pytest.mark.thorough
def test_loads_of_each_state_settle_apart() -> None:
    """Torques that are no numbers are those of one state: loads of the others settle as they do without it."""
    of = generated("loaded")
    step = next(step for step in of.steps if step.name.endswith("w3"))
    read = given(step, of.package, of.state["q"])
    rows = [x.reshape(STATES, 4, -1) for x in read.values()]
    state = [of.state[name].copy() for name in ("q", "qd", "z")]
    _, wanted, _ = of.module.step_w3(*rows, H, *state)
    rows[0][3] = np.nan
    _, qd, _ = of.module.step_w3(*rows, H, *state)
    assert np.isnan(qd[3]).all()
    np.testing.assert_array_equal(np.delete(qd, 3, axis=0), np.delete(wanted, 3, axis=0))


def test_drives_with_bristles_and_loads(tmp_path: Path) -> None:
    """A short step in numpy moves as the closed machine does under the loads that it passes then."""
    package = trace_models(
        with_limits(loaded(creeping(two_motors()))), Scene(models=("direct_dynamics",), steps=("rk4",))
    ).package
    module, rng, h = import_package(render_numpy(package), tmp_path), np.random.default_rng(8), 1e-7
    (q, qd), z, rows = rng.normal(size=(2, 4)), rng.normal(size=len(package.states)), rng.normal(size=(4, 2))
    z[0], load = 5e-4, np.zeros(2)
    for _ in range(200):
        qdd, zd, tau = module.closed_dynamics(q, qd, z, *rows, load)
        load, _ = module.passed_torques(q, qd, z[:1], qdd, tau, load)
    _, v, bent = module.step_rk4_drives(*(np.tile(row, (3, 1)) for row in rows), h, q, qd, z)
    np.testing.assert_allclose((v - qd) / h, qdd, rtol=0, atol=1e-3 * np.abs(qdd).max())
    np.testing.assert_allclose((bent - z)[0] / h, zd[0], rtol=1e-3)


@pytest.mark.thorough
def test_the_same_in_two_calls() -> None:
    """`prepare`, then `_prepared`: what depends on parameters only is computed once."""
    of = generated("random")
    step = next(step for step in of.steps if step.name.endswith("w3"))
    p, read, n = parameters(of.package), given(step, of.package, of.state["q"]), len(of.package.axes)
    q, qd, c = of.state["q"][0].copy(), of.state["qd"][0].copy(), np.empty(1000)
    of.library[f"{of.package.name}_step_prepare"](*pointers([p, c]))
    rows = pointers(np.ascontiguousarray(x[0]) for x in read.values())
    of.library[f"{step.name}_prepared"](*rows, ctypes.c_double(H), *pointers([p, c, q, qd]))
    wanted = by_c(of, step)
    np.testing.assert_array_equal([*q, *qd], [*wanted[0][0], *wanted[1][0]])
    assert n == len(q)


@pytest.mark.thorough
@pytest.mark.parametrize("precision", [p for p in PRECISIONS.values() if p is not DOUBLE], ids=lambda p: p.name)
def test_other_precisions(precision: Precision, tmp_path: Path) -> None:
    """A step of w3 in single, mixed and double-double is that in double, to the digits that its state has."""
    of = generated("planar")
    library = ctypes.CDLL(str(compile_library(render_c_batch(of.package, precision), tmp_path, flags=STRICT)))
    dtype = np.float32 if precision.state == "float" else np.float64
    step = next(step for step in of.steps if step.name.endswith("w3"))
    read = given(step, of.package, of.state["q"])
    q, qd, *rows = (np.array(x[0], dtype=dtype) for x in (of.state["q"], of.state["qd"], *read.values()))
    p = parameters(of.package).astype(dtype)
    h = ctypes.c_float(H) if dtype is np.float32 else ctypes.c_double(H)
    name = f"{of.package.name}{precision.suffix}_step_w3"
    library[name](*pointers(rows), h, *pointers([p, q, qd]))
    wanted = by_c(of, step)
    few = precision.name in ("single", "mixed")
    np.testing.assert_allclose(q, wanted[0][0], rtol=0, atol=(1e-6 if few else 1e-14) * np.abs(wanted[0][0]).max())
    np.testing.assert_allclose(qd, wanted[1][0], rtol=0, atol=(1e-4 if few else 1e-13) * np.abs(wanted[1][0]).max())


def test_no_branch_depends_on_data() -> None:
    """Steps hold loops of fixed length only; the functions that they call are straight lines."""
    package = generated("random").package
    text = CSteps(package, DOUBLE, functions_of(package)).source()
    code = re.sub(r"/\*.*?\*/", " ", text, flags=re.DOTALL)
    assert not re.search(r"\b(if|while|switch|goto|do)\b|\?", code)
    bounds = set(re.findall(r"for \([^;]*; ([^;]*);", code))
    assert bounds and all(re.fullmatch(r"\w+ < (\d+U(\*\d+U)?|i)|i-- > 0U", bound) for bound in bounds)


def functions_of(package: Package) -> Any:
    return list(source_text(with_own_results(package), DOUBLE).steps.by_name.values())


@pytest.mark.thorough
@pytest.mark.skipif(not available(), reason="no valgrind")
@pytest.mark.parametrize(("which", "words"), [("random", "0134"), ("on_base", "04")])
def test_a_step_takes_the_same_instructions_at_every_state(which: str, words: str, tmp_path: Path) -> None:
    """Moderate angles: those beyond the range of the generated sine are another path of it."""
    package = generated(which).package
    name, n, m = package.name, len(package.axes), len(package.motor_names)
    base = [f"b{k}" for k in range(len(package.base))]
    sizes = dict(zip(base, (one.size for one in package.base), strict=True))
    arrays = "".join(f", {b}[{size}]" for b, size in sizes.items()) + (f", f0[{4 * 6}]" if base else "")
    filled = "".join(
        f"for (int k = 0; k < {size}; ++k) {b}[k] = 0.3 + 0.1*x*k;\n        " for b, size in sizes.items()
    ) + (f"for (int k = 0; k < {4 * 6}; ++k) f0[k] = x*k;\n        " if base else "")
    p = f"{name}_defaults" if package.parameters else "0"
    program = f"""
#include "{name}.h"

int main(int count, char **words)
{{
    double tau[{4 * m}], q[{n}], qd[{n}]{arrays};
    const double x = 0.43*(words[count - 1][0] - '2');
    for (int call = 0; call < 20; call++) {{
        for (int k = 0; k < {4 * m}; ++k) tau[k] = 0.3*k*x;
        for (int k = 0; k < {n}; ++k) q[k] = 0.1*k + 0.2*x;
        for (int k = 0; k < {n}; ++k) qd[k] = 0.4 - x*k;
        {filled}{name}_step_w3({", ".join(["tau", *(["f0"] if base else []), "1e-4", p, "q", "qd", *base])});
    }}
    return 0;
}}
"""
    files = render_c(package) | {"main.c": program}
    counts = {counted(files, COMPILERS[0], word) for word in words}
    assert len(counts) == 1


@pytest.mark.sampled(12)
@pytest.mark.parametrize("taken", ["g", "kp", "r_q", "factors", "handed", "torque", "z_v"])
def test_names_of_users_give_way_to_those_of_steps(taken: str, tmp_path: Path) -> None:
    """A length that is called as an argument of implicit systems: the same numbers."""
    described = planar_2r(elastic=[2])
    first = described.parameters[0].name
    text = toml.write(described)
    renamed = toml.read(re.sub(rf"\b{first}\b", taken, text), "planar.toml")
    found = []
    for k, one in enumerate((described, renamed)):
        package = trace_models(one, Scene(models=("direct_dynamics",), steps=("w2",))).package
        module = import_package(render_numpy(package), tmp_path / f"numpy{k}")
        library = ctypes.CDLL(str(compile_library(render_c(package), tmp_path / f"c{k}", flags=STRICT)))
        q, qd, tau, p = np.array([0.3, 0.01]), np.array([1.0, -2.0]), np.ones(2), 1 + np.arange(20.0)
        rows = [tau, tau, tau, np.full(1, 50.0), np.full(1, 5.0)]
        wanted = module.step_w2_servo(
            *(x[:, None] for x in rows[:3]), *rows[3:], H, q, qd, p[: len(package.parameters)]
        )
        library[f"{package.name}_step_w2_servo"](*pointers(rows), ctypes.c_double(H), *pointers([p, q, qd]))
        np.testing.assert_allclose([q, qd], wanted, rtol=1e-12)
        found.append([*q, *qd])
    assert found[0] == found[1]


# Refusals


def refused(described: Machine, *names: str) -> str:
    with pytest.raises(InputError) as caught:
        trace_models(described, Scene(models=("direct_dynamics",), steps=names))
    return str(caught.value)


@pytest.mark.thorough
def test_motors_on_dependent_joints_have_no_rodas4() -> None:
    assert "rodas4 is not offered where the motor is on a joint that follows by loops" in refused(
        creeping(of_loops("delta")), "rodas4"
    )


def test_dry_friction_that_jumps_is_refused() -> None:
    assert "friction, link_2: coulomb friction jumps at rest" in refused(of_loops("ring"), "w3")


def test_a_machine_without_moving_joints_has_no_steps() -> None:
    still = planar_2r()
    rows = tuple(row for row in still.joints if row.kind is Kind.FIXED)
    described = type(still)("still", tuple(type(row)(row.name, 0, row.kind, row.sigma) for row in rows))
    assert "no joint moves" in refused(described, "w3")


def test_a_base_of_known_acceleration_has_no_steps() -> None:
    driven = replace(planar_2r(), floating=Floating(known=KnownOfBase.ACCELERATION))
    assert "base, known: the acceleration of the base is given, so it is not a state" in refused(driven, "w3")


def test_a_floating_base_has_no_rodas4() -> None:
    assert "rodas4 needs exact derivatives" in refused(replace(planar_2r(), floating=Floating()), "rodas4")


@pytest.mark.parametrize(("names", "says"), [(("w3", "w5"), "no time step 'w5'"), (("w3", "w3"), "w3 is given twice")])
def test_steps_are_known_and_differ(names: tuple[str, ...], says: str) -> None:
    with pytest.raises(InputError, match=f"scene, steps: {says}"):
        resolve(Scene(steps=names), planar_2r())


def test_every_method_is_offered() -> None:
    assert {*TimeStep} == {*METHODS}
