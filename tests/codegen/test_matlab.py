"""The target matlab: its functions and MEX in GNU Octave, all calls in one process."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

import numpy as np
import pytest

from symoro_elastic.analysis.vibration.export import save_linearization
from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.codegen.integration.tableaus import METHODS, nodes_of
from symoro_elastic.codegen.matlab_function import CONSTANTS, KEYWORDS, OWN, matlab_name
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.targets.matlab import render_matlab
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats import read_machine
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.models.packaging import trace_models
from symoro_elastic.numerics.verification.implementations import import_package
from symoro_elastic.numerics.verification.states import moderate_states
from tests.analysis.vibration.machines import drive, linearized
from tests.closed_chains.machines import without_closed_form
from tests.codegen.test_local_names import arm
from tests.models.test_creep import creeping
from tests.octave import (
    Answer,
    Array,
    Call,
    as_argument,
    calls_of,
    needs_mkoctfile,
    needs_octave,
    octave,
    ulps,
    written,
)  # fmt: skip

ROOT = Path(__file__).parents[2]
STATES = 3
LONG = "a" * 61
VARIABLES = ("end", "function", f"end_{'c' * 59}", f"{LONG}_1", f"{LONG}_2")
PARAMETERS = (
    *(
        "i",
        "j",
        "e",
        f"end_{'d' * 59}",
        "persistent",
        "otherwise",
        "parfor",
        "until",
        "endif",
        "ans",
        "eps",
        "arguments",
        "p",
        "states",
    ),
    *("checked", "zeros", "reshape", "real_sqrt", "nargin", f"{LONG}_3", f"{LONG}_4", "constants", "parameters"),
)
"""Names that MATLAB, GNU Octave or the templates use, and names of 63 characters."""


def hostile() -> Machine:
    """Five joints of a machine that is called as a keyword."""
    return replace(arm(VARIABLES, PARAMETERS), name="end")


PENDULUM = """
name = "pendulum"
gravity = [0, 0, -9.81]
joints = [{ name = "swing", kind = "passive", sigma = 0, alpha = "pi/2", theta = "q1" }]
[bodies]
swing = { mass = 1, center_of_mass = [1, 0, 0], inertia = [0, 0, 0.1] }
"""


def example(name: str) -> Machine:
    return read_machine(ROOT / "examples" / name)[0]


@cache
def linearization() -> Linearization:
    return linearized(drive(d=3.0), None, ["motor", "load.fz"], ["motor", "load.vz"])


CASES: dict[str, tuple[Callable[[], Machine], Scene]] = {
    "hostile names": (hostile, Scene(models=("direct_dynamics", "inertia_matrix", "geometric_model"))),
    "time steps": (
        lambda: example("planar_2r.toml"),
        Scene(models=("geometric_model", "inverse_position_model"), steps=("w3",)),
    ),
    "loops": (lambda: creeping(without_closed_form()), Scene(models=("direct_dynamics", "assemble"), steps=("rk4",))),
    "neither motors nor parameters": (
        lambda: toml.read(PENDULUM, "pendulum.toml"),
        Scene(models=("inverse_dynamics", "direct_dynamics_derivatives", "jacobian", "base_parameters")),
    ),
    "floating base": (lambda: example("floating_arm.toml"), Scene(models=("velocities",), steps=("rk4",))),
}


@dataclass(frozen=True, repr=False)
class Case:
    """A machine's package, its numpy module, calls of `.m` and MEX with what numpy makes of them, time steps."""

    package: Package
    module: ModuleType
    own: list[Call]
    mex: list[Call]
    wanted: list[list[Array]]
    steps: list[Call]
    after: list[list[Array]]

    @property
    def name(self) -> str:
        """The package of functions in MATLAB."""
        return matlab_name(self.package.name)

    @property
    def calls(self) -> list[Call]:
        """All calls."""
        return [*self.own, *self.mex, *self.steps]


def case(machine: Machine, scene: Scene, folder: Path) -> Case:
    found = trace_models(machine, scene)
    module = import_package(render_numpy(found.package), folder)
    own, mex, wanted = calls_of(found.package, found.machine, module, STATES)
    taken = [*steps(found.package, found.machine, module)]
    return Case(found.package, module, own, mex, wanted, [one for one, _ in taken], [after for _, after in taken])


def steps(package: Package, machine: Machine, module: ModuleType) -> Iterator[tuple[Call, list[Array]]]:
    """Calls of all time steps from moderate states, under random torques, and where numpy's lead."""
    rng, states = np.random.default_rng(1), moderate_states(machine, STATES)
    for name in (name for name in dir(module) if name.startswith("step_")):
        nodes = len(nodes_of(METHODS[name.split("_")[1]], driven="_driven" in name))
        given: dict[str, Array] = {"h": np.full(STATES, 1e-3)}
        for argument in [*inspect.signature(getattr(module, name)).parameters][:-1]:
            entries = 6 if argument == "f0" else len(package.motor_names)
            if argument in ("tau", "r", "rd", "y", "yd", "ydd", "f0"):
                given[argument] = rng.uniform(-1, 1, (STATES, nodes, entries))
            elif argument in ("kp", "kd"):
                given[argument] = rng.uniform(0, 1, (STATES, entries))
            elif argument != "h":
                given[argument] = getattr(states, argument)
        order = [*inspect.signature(getattr(module, name)).parameters][:-1]
        after = getattr(module, name)(**given)
        changed = [*(key for key in order if key in ("q", "qd", "q_dep", "R0", "P0", "V0")), "error"]
        call = Call(f"{package.name}_mex('{name}', ", [as_columns(key, given[key]) for key in order], len(after))
        yield call, [as_columns(key, x) for key, x in zip(changed, after, strict=False)]


def as_columns(name: str, x: Array) -> Array:
    """States (N, ...) as MATLAB has them, a column for each; of arrays with rows of nodes a column for each node."""
    if x.ndim == 1:
        return x.reshape(1, -1)
    return as_argument(name, x) if x.ndim == 2 else x.transpose(2, 1, 0)


ZEROS = {5: np.zeros((5, 1)), 4: np.zeros((4, 1))}
WRONG = {
    "q is 1 x 5: 5 x 1, or 5 x N for N states, is expected": (np.zeros((1, 5)), ZEROS[5], ZEROS[4]),
    "qd is 4 x 1: 5 x 1, or 5 x N for N states, is expected": (ZEROS[5], ZEROS[4], ZEROS[4]),
    "tau is 4 x 3 x 2: 4 x 1, or 4 x N for N states, is expected": (ZEROS[5], ZEROS[5], np.zeros((4, 3, 2))),
    "tau is of 3 states, an argument before it of 2": (np.zeros((5, 2)), ZEROS[5], np.zeros((4, 3))),
    "q is of class single: real numbers of class double are expected": (np.zeros((5, 1), "f4"), ZEROS[5], ZEROS[4]),
    "qd is complex: real numbers of class double are expected": (ZEROS[5], np.full((5, 1), 1j), ZEROS[4]),
}
"""Arguments of the direct dynamic model that are refused, by the message."""
OTHERS = {
    "defaults": Call("end_.parameters(", []),
    "by name": Call("end_.parameters('j', ", [np.array([[7.0]])]),
    "unknown": Call("end_.parameters('zz', ", [np.array([[7.0]])]),
    "odd": Call("end_.parameters('j', ", []),
    "names": Call("getfield(end_.constants(), 'PARAMETERS', ", []),
    "motors": Call("getfield(end_.constants(), 'MOTORS', ", []),
    "too few": Call("end_.direct_dynamics(", [ZEROS[5]]),
    "too few for mex": Call("end_mex('direct_dynamics', ", [ZEROS[5]]),
    "no function": Call("end_mex('dynamics', ", [ZEROS[5]]),
    "no compiler": Call("deal(no_compiler, ", []),
    "keywords": Call("deal(words, ", []),
    "no package control": Call("drive_linear(", []),
    "wrong word": Call("drive_linear('matrix', ", []),
}
FIELDS = [name for name in linearization().arrays() if name != "notes"]
DIRECT = "end_.direct_dynamics(", "end_mex('direct_dynamics', "
BEFORE = """
setenv('CC', 'no_such_compiler');
try, end_.build(); catch e, no_compiler = e.message; end_try_catch
setenv('CC', '');
setenv('CFLAGS', '-O0 -fPIC -Wall -Wextra -Werror');
words = iskeyword();
linear = drive_linear('matrices');
"""


class Session(NamedTuple):
    """The cases, and what Octave answers: to their calls, to wrong calls, others, fields of a linearization."""

    cases: dict[str, Case]
    answers: dict[str, Answer]


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """Everything in one process of Octave."""
    folder = tmp_path_factory.mktemp("octave")
    cases = {name: case(make(), scene, folder / "numpy" / name) for name, (make, scene) in CASES.items()}
    code = [written(render_matlab(case.package), folder / case.package.name) for case in cases.values()]
    linear = folder / "linear"
    linear.mkdir()
    save_linearization(linearization(), linear / "drive_linear.m")
    calls = {f"{name}, {k}": call for name, case in cases.items() for k, call in enumerate(case.calls)}
    for message, arrays in WRONG.items():
        calls |= {f"{head}{message}": Call(f"{head}", arrays) for head in DIRECT}
    calls |= OTHERS | {f"linear.{name}": Call(f"getfield(linear, '{name}', ", []) for name in FIELDS}
    before = BEFORE + "\n".join(f"{case.name}.build();" for case in cases.values())
    answers = octave([*calls.values()], folder / "calls", [*code, linear], before)
    return Session(cases, dict(zip(calls, answers, strict=True)))


pytestmark = [needs_octave, needs_mkoctfile, pytest.mark.sampled(5)]


@pytest.mark.thorough
@pytest.mark.parametrize("name", CASES)
def test_functions_and_mex_have_the_numbers_of_numpy(session: Session, name: str) -> None:
    """To the last bit: vectors, matrices, pages of frames, at several states a call."""
    case = session.cases[name]
    wanted = [*case.wanted, *case.wanted]
    for k, (call, results) in enumerate(zip([*case.own, *case.mex], wanted, strict=True)):
        answer = session.answers[f"{name}, {k}"]
        assert not answer.error, call.function + answer.error
        assert [ulps(x, y) for x, y in zip(answer.results, results, strict=True)] == [0] * len(results), call.function
        assert all(not x.size or np.isfinite(x).any() for x in answer.results), call.function


@pytest.mark.sampled(1000)
@pytest.mark.parametrize("name", [name for name, (_, scene) in CASES.items() if scene.steps])
def test_time_steps_of_mex_lead_where_those_of_numpy_lead(session: Session, name: str) -> None:
    """To rounding: sums of stages are formed in another order."""
    case = session.cases[name]
    assert case.steps
    for k, (call, wanted) in enumerate(zip(case.steps, case.after, strict=True), start=len(case.own) * 2):
        answer = session.answers[f"{name}, {k}"]
        assert not answer.error, call.function + answer.error
        for x, y in zip(answer.results, wanted, strict=True):
            np.testing.assert_allclose(x, y, rtol=0, atol=1e-14 * np.abs(y).max(), err_msg=call.function)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("message", WRONG)
def test_wrong_arguments_are_named_with_their_size(session: Session, message: str) -> None:
    by_m, by_mex = (session.answers[head + message].error for head in DIRECT)
    assert by_m == message and by_mex in (message, f"end_mex: {message}")


def test_parameters_are_given_by_name(session: Session) -> None:
    (defaults,), (changed,) = session.answers["defaults"].results, session.answers["by name"].results
    names = [str(x[0]) for x in session.answers["names"].results[0].ravel()]
    case = session.cases["hostile names"]
    assert names == [p.name for p in case.package.parameters] and {*PARAMETERS} <= {*names}
    assert defaults.ravel().tolist() == [p.value for p in case.package.parameters]
    assert np.flatnonzero(changed != defaults).tolist() == [names.index("j")] and changed[names.index("j")] == 7.0
    assert session.answers["unknown"].error == "end has no parameter zz"
    assert session.answers["odd"].error == "parameters takes names and values, in turn"
    assert session.answers["motors"].results[0].ravel().tolist() == [k + 1 for k in case.package.motors]


def test_calls_that_are_incomplete_say_what_is_missing(session: Session) -> None:
    assert session.answers["too few"].error == "direct_dynamics takes q, qd, tau and, unless it is the default, p"
    assert "direct_dynamics takes q, qd, tau, p" in session.answers["too few for mex"].error
    assert session.answers["no function"].error.endswith("a function: direct_dynamics, inertia_matrix, geometric_model")


def test_a_missing_compiler_is_named(session: Session) -> None:
    (message,) = session.answers["no compiler"].results
    assert "the C compiler no_such_compiler is missing" in str(message[0])


def test_all_keywords_of_octave_are_known(session: Session) -> None:
    words = {str(x[0]) for x in session.answers["keywords"].results[0].ravel()}
    assert {word for word in words if not word.startswith("__")} <= KEYWORDS


def test_no_name_is_one_of_matlab_or_longer_than_it_tells_apart(session: Session) -> None:
    text = render_matlab(session.cases["hostile names"].package)["+end_/direct_dynamics.m"]
    targets = set(re.findall(r"^    (\w+) = ", text, re.MULTILINE))
    assert max(map(len, targets)) <= 63 and not targets & (KEYWORDS | CONSTANTS | OWN - {"p", "states"})
    assert any(name.startswith("sin_aaa") for name in targets)


def test_a_linearization_is_a_function(session: Session) -> None:
    """The arrays of the linearization to the last bit, without a toolbox; without one no object of ss."""
    for name, x in linearization().arrays().items():
        if name == "notes":
            continue
        (found,) = session.answers[f"linear.{name}"].results
        if isinstance(x, list):
            assert [str(y[0]) for y in found.ravel()] == x
        else:
            np.testing.assert_array_equal(found, x if x.ndim == 2 else x.reshape(-1, 1))
    assert "ss is missing: install the Control System Toolbox" in session.answers["no package control"].error
    assert session.answers["wrong word"].error == "drive_linear takes 'matrices' or nothing"
