"""verify() accepts what is right, finds what is wrong, and says what it could not judge."""

from __future__ import annotations

import math
import re
import shutil
from collections.abc import Iterable
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

from symoro_elastic.codegen import compile as compiling
from symoro_elastic.codegen.compile import CompilationFailed, CompilerMissing, compile_package, find_compiler
from symoro_elastic.codegen.package import Package
from symoro_elastic.codegen.targets.c import render_c
from symoro_elastic.codegen.targets.c_batch import render_c_batch
from symoro_elastic.codegen.targets.numpy import render_numpy
from symoro_elastic.formats import read_machine
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import Base, Body, Joint, Kind, Machine, Parameter
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models import packaging
from symoro_elastic.models.packaging import package
from symoro_elastic.models.programs import catalogue
from symoro_elastic.models.programs.catalogue import trace, trace_scene
from symoro_elastic.numerics.evaluation.linear_systems import distance
from symoro_elastic.numerics.evaluation.values import NoValues, parameter_values
from symoro_elastic.numerics.verification import reference
from symoro_elastic.numerics.verification import verify as verifying
from symoro_elastic.numerics.verification.states import extreme_states, moderate_states
from symoro_elastic.numerics.verification.verify import Verification, verify
from symoro_elastic.symbolic.decimals import in_digits
from tests.references import multiprecision
from tests.references.random_machines import chain, first_joint_elastic, planar_2r, random_machine, two_children

pytestmark = pytest.mark.sampled(5)

FIVE = ("direct_dynamics", "inverse_dynamics", "inertia_matrix", "bias_forces", "geometric_model")
EVERYTHING = Scene(models=FIVE)
EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def cell(value: float | str) -> Formula:
    return Formula.parse(value)


def example(name: str) -> Machine:
    return read_machine(EXAMPLES / name)[0]


def without_values(machine: Machine) -> Machine:
    return replace(machine, parameters=tuple(replace(p, value=None) for p in machine.parameters))


GOOD = [
    pytest.param(example("rx90.par"), EVERYTHING, id="RX90"),
    pytest.param(example("two_axis.toml"), EVERYTHING, id="two-axis machine"),
    pytest.param(example("two_axis.toml"), Scene(models=FIVE, fold=ALL), id="two-axis machine, folded"),
    pytest.param(first_joint_elastic(symbolic=True), EVERYTHING, id="first joint elastic"),
    pytest.param(random_machine(7, joints=9, moving_base=True), EVERYTHING, id="tree on a moving base"),
    pytest.param(random_machine(8, joints=6, kinds=(Kind.PASSIVE, Kind.ELASTIC)), EVERYTHING, id="no motor"),
    pytest.param(Machine("frame", (Joint("tool", 0, Kind.FIXED, 2, d=cell(0.3)),)), EVERYTHING, id="fixed frame only"),
    pytest.param(
        two_children(symbolic=True),
        Scene(
            models=FIVE,
            locked={"joint3": cell("2*D3")},
            outputs={"direct_dynamics": ("joint4", "joint2"), "inverse_dynamics": ("joint1", "joint5")},
            fold=("M2", "D3"),
            gravity=False,
        ),
        id="part of a machine",
    ),
]


@pytest.mark.thorough
@pytest.mark.optimised
@pytest.mark.parametrize(("machine", "scene"), GOOD)
def test_good_machines_pass(machine: Machine, scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each kind of extreme states twice. Only the C of the two-axis machine is optimised, as `check` does."""
    if machine.name != "two_axis":
        monkeypatch.setattr(compiling, "optimisation", lambda package: "-O0")
    seen: list[tuple[int, int]] = []
    found = verify(machine, scene, states=(4, 16), progress=lambda done, total: seen.append((done, total)))
    assert found.ok and not found.missing and found.disagreement < 1e-40
    assert [model.name for model in found.models] == list(FIVE)
    assert seen == [(k, found.states) for k in range(1, found.states + 1)]
    for model in found.models:
        assert model.moderate + model.extreme + len(model.unjudged) == found.states
        assert not model.unjudged
        assert model.c is not None
        for worst in (model.numpy, model.c, model.equations):
            assert worst.moderate < 1e-13 and worst.extreme < 1e-12 and worst.ok


@pytest.mark.thorough
def test_default_models_and_equal_results() -> None:
    first, second = (verify(planar_2r(), states=(3, 8), seed=5) for _ in range(2))
    assert first == second and first.ok
    assert [model.name for model in first.models] == ["direct_dynamics", "inverse_dynamics"]
    assert first.states == 11
    assert verify(planar_2r(), states=(3, 8), seed=6) != first


@pytest.mark.thorough
def test_thirty_joint_tree() -> None:
    models = ("direct_dynamics", "inverse_dynamics")
    found = verify(random_machine(3, joints=30, symbolic=True), Scene(models=models), states=(2, 8))
    assert found.ok and found.models[0].numpy.error < 1e-12


@pytest.mark.thorough
def test_more_joints_than_are_solved_for(monkeypatch: pytest.MonkeyPatch) -> None:
    """Then the traced models are the reference, and one state is solved."""
    monkeypatch.setattr(verifying, "MOST_SOLVED", 3)
    found = verify(chain(5, elastic=(2,)), EVERYTHING, states=(2, 8))
    assert found.ok and 0 < found.disagreement < 1e-40


# What is wrong


def spoiled(text: str, line: int) -> str:
    """The text with one sign turned: in the statement of this number, counted over those that compute with one."""
    lines = text.splitlines(keepends=True)
    signed = re.compile(r"    (?:const (?:double|numbers) )?\w+ = (?!LOAD).*\w [-+] \w")
    candidates = [k for k, x in enumerate(lines) if signed.match(x)]
    k = candidates[line % len(candidates)]
    lines[k] = re.sub(r"(\w) ([-+]) (\w)", lambda m: f"{m[1]} {'-' if m[2] == '+' else '+'} {m[3]}", lines[k], count=1)
    return "".join(lines)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("file", ["chain3.c", "chain3_batch.c"])
@pytest.mark.parametrize("line", [0, 7, 23, 41, 60])
def test_wrong_c_is_found(line: int, file: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def render(described: Package) -> dict[str, str]:
        files = render_c_batch(described)
        return files | {file: spoiled(files[file], line)}

    monkeypatch.setattr(verifying, "render_c_batch", render)
    found = verify(chain(3, elastic=(2,)), EVERYTHING, states=(2, 8))
    assert not found.ok
    assert all(model.numpy.ok and model.equations.ok for model in found.models)
    wrong = [model.c for model in found.models if model.c and not model.c.ok]
    assert wrong and all(worst.error > 1e-6 and worst.at.startswith("state ") for worst in wrong)


@pytest.mark.parametrize("module", ["_direct_dynamics.py", "_inverse_dynamics.py", "_bias_forces.py"])
def test_wrong_numpy_is_found(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def render(described: Package) -> dict[str, str]:
        return {name: spoiled(text, 30) if name == module else text for name, text in render_numpy(described).items()}

    monkeypatch.setattr(verifying, "render_numpy", render)
    found = verify(chain(3, elastic=(2,)), EVERYTHING, states=(2, 8))
    assert [model.name for model in found.models if not model.ok] == [module[1:-3]]
    assert all(model.c and model.c.ok for model in found.models)


def changed_by(machine: Machine, **changed: Any) -> Machine:
    """Joint 2 as given."""
    joints = list(machine.joints)
    joints[1] = replace(joints[1], **changed)
    return replace(machine, joints=tuple(joints))


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("changed", "wrong"),
    [
        ({"rotor_inertia": cell("1e-9*M2")}, set(FIVE) - {"bias_forces", "geometric_model"}),
        ({"alpha": cell("AL2 + 1e-9")}, set(FIVE)),
        ({"theta": cell("1e-10")}, set(FIVE)),
        (
            {"spring": replace(chain(3, elastic=(2,)).joints[1].spring, damping=ZERO)},
            {"direct_dynamics", "inverse_dynamics"},
        ),
    ],
)
def test_wrong_models_are_found(changed: dict[str, Any], wrong: set[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Programs traced from another machine: code and equations agree, the reference does not."""
    monkeypatch.setattr(
        packaging, "trace_scene", lambda machine, *rest: trace_scene(changed_by(machine, **changed), *rest)
    )
    found = verify(chain(3, elastic=(2,)), EVERYTHING, states=(2, 8))
    assert {model.name for model in found.models if not model.ok} == wrong
    assert all(not worst.ok for m in found.models if not m.ok for worst in (m.c, m.numpy, m.equations) if worst)


@pytest.mark.thorough
def test_wrong_inertia_matrix_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """A is compared with itself in more digits, and with the recursive Newton-Euler algorithm."""
    right = catalogue.MODELS["inertia_matrix"]

    def without_coupling(bound: Any, asked: Any) -> Any:
        results = right.run(bound, asked)
        entries = list(results["A"].entries)
        entries[1] = entries[1] + entries[1]
        return {"A": replace(results["A"], entries=tuple(entries))}

    monkeypatch.setitem(catalogue.MODELS, "inertia_matrix", replace(right, run=without_coupling))
    found = verify(chain(3), Scene(models=("inertia_matrix", "geometric_model")), states=(2, 2))
    assert all(model.ok for model in found.models)
    assert found.disagreement > 1e-3 and not found.ok


@pytest.mark.thorough
def test_not_a_number_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(verifying, "equations_on_floats", lambda values: nan_everywhere)
    found = verify(planar_2r(), states=(2, 2))
    assert all(model.equations.error == math.inf and not model.ok for model in found.models)


def nan_everywhere(traced: Any, states: Any) -> dict[str, Any]:
    return {o.name: np.full((len(states), *o.shape), np.nan) for o in traced.program.outputs}


# What cannot be judged


def wrist() -> Machine:
    """Two massless bodies, then one with mass: the first and the third axis meet at q2 = 0."""
    alphas = ("0", "pi/2", "-pi/2")
    mass = Body(cell(2), inertia=(cell(0.1), ZERO, ZERO, cell(0.2), ZERO, cell(0.3)))
    bodies = (Body(), Body(), mass)
    joints = (
        Joint(f"joint{j}", j - 1, Kind.MOTOR, 0, f"q{j}", alpha=cell(alpha), body=body)
        for j, (alpha, body) in enumerate(zip(alphas, bodies, strict=True), start=1)
    )
    return Machine("wrist", tuple(joints), base=Base(gravity=(ZERO, ZERO, cell(-10))))


@pytest.mark.thorough
def test_singular_states_are_reported() -> None:
    found = verify(wrist(), Scene(models=("direct_dynamics", "inertia_matrix")))
    direct, inertia = found.models
    assert found.ok
    assert any("everything zero" in line and "singular" in line for line in direct.unjudged)
    assert any("quarter turns" in line for line in direct.unjudged)
    assert direct.extreme == 32 - len(direct.unjudged) and not inertia.unjudged


def test_no_state_judged_is_no_success() -> None:
    never = verifying.ModelVerification("m", verifying.Worst(), None, verifying.Worst(), 0, 0, 1e-12)
    assert not never.ok and not Verification((never,), 0, 0.0).ok


# Compilers


def described() -> Package:
    machine = planar_2r()
    return package(machine, [trace(machine, "direct_dynamics"), trace(machine, "inverse_dynamics")], ())


@pytest.mark.thorough
@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("machine", [example("two_axis.toml"), example("puma560.par"), two_children(symbolic=True)])
def test_compilers_have_nothing_to_say(compiler: str, machine: Machine, tmp_path: Path) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    models = [trace(machine, name) for name in FIVE]
    compiled = compile_package(package(machine, models, ()), tmp_path, compiler=(compiler,))
    assert compiled.call("geometric_model", q=np.zeros(len(machine.independent)))["T"].shape == (
        len(machine.joints),
        4,
        4,
    )


@pytest.mark.thorough
def test_compiler_of_the_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("CC", "gcc -O1")
    assert find_compiler() == ("gcc", "-O1")
    compiled = compile_package(described(), tmp_path)
    assert compiled.call("direct_dynamics", q=[0, 0], qd=[0, 0], tau=[0, 0])["qdd"].shape == (2,)


def test_a_missing_compiler_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(CompilerMissing, match=r"CC is 'no-such-compiler'.*unset it"):
        find_compiler()
    found = verify(planar_2r(), states=(2, 2))
    assert found.ok and "no-such-compiler" in found.missing
    assert all(model.c is None and model.numpy.ok for model in found.models)
    for open_quotation in ('"gcc', "gcc 'x"):
        monkeypatch.setenv("CC", open_quotation)
        with pytest.raises(CompilerMissing, match=r"CC is .*, with an unmatched quotation mark: close it"):
            find_compiler()
    monkeypatch.delenv("CC")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(CompilerMissing, match=r"gcc, clang, cc.*install one.*CC"):
        find_compiler()


@pytest.mark.thorough
def test_a_refused_text_is_quoted(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    files = {name: text.replace("const double", "const duoble", 1) for name, text in render_c(described()).items()}
    with pytest.raises(CompilationFailed, match=r": \w+: planar_2r\.[ch]:\d+:\d+: error: .*duoble") as caught:
        compile_package(described(), tmp_path, files)
    assert "\n" not in str(caught.value)
    unused = {
        n: text.replace("#include <math.h>", "#include <math.h>\nstatic int idle;")
        for n, text in render_c(described()).items()
    }
    with pytest.raises(CompilationFailed, match="idle"):
        compile_package(described(), tmp_path, unused)


@pytest.mark.thorough
@pytest.mark.optimised
def test_long_functions_are_not_optimised() -> None:
    assert compiling.optimisation(described()) == "-O2"
    machine = chain(40)
    assert compiling.optimisation(package(machine, [trace(machine, "direct_dynamics")], ())) == "-O0"


# Values and states


@pytest.mark.parametrize("machine", [chain(5, elastic=(2,), prismatic=(3,)), two_children(symbolic=True), planar_2r()])
def test_drawn_values_are_physical(machine: Machine) -> None:
    """A is positive definite; what must be positive is; the machine's own values stay."""
    bare = without_values(machine)
    for seed in range(5):
        values = parameter_values(bare, seed)
        assert values == parameter_values(bare, seed)
        assert list(values) == [p.name for p in machine.parameters]
        assert all(value > 0 for name, value in values.items() if re.match(r"(M|XX|YY|ZZ|IA|K|DA|FV|FS)\d", name))
        q = moderate_states(bare, 1, seed, values).q[0]
        inertia = np.array(multiprecision.inertia_matrix(bare, q.tolist(), values)).astype(float)
        assert np.linalg.eigvalsh(inertia)[0] > 0
        given = replace(bare, parameters=(Parameter(machine.parameters[0].name, cell(0.125)), *bare.parameters[1:]))
        assert parameter_values(given, seed)[machine.parameters[0].name] == 0.125


def test_values_follow_the_cell_and_not_the_name() -> None:
    body = Body(cell("apple"), (cell("pear"), ZERO, ZERO), (cell("fig"), ZERO, ZERO, cell("fig"), ZERO, cell("fig")))
    joint = Joint(
        "one", 0, Kind.MOTOR, 0, "q1", alpha=cell("sqrt(1 - plum^2)"), body=body, rotor_inertia=cell("2*kiwi")
    )
    names = ("apple", "pear", "fig", "plum", "kiwi", "lime")
    machine = Machine("fruit", (joint,), tuple(Parameter(n) for n in names), Base(gravity=(ZERO, ZERO, cell("-lime"))))
    for seed in range(20):
        values = parameter_values(machine, seed)
        assert 1 <= values["apple"] <= 5 and abs(values["pear"]) <= 0.1 * values["apple"]
        assert values["fig"] * values["apple"] > values["pear"] ** 2
        assert 0 < values["plum"] <= 1 and 0.1 < values["kiwi"] < 2 and 5 <= values["lime"] <= 10


def test_values_that_cannot_be_found() -> None:
    joint = Joint("one", 0, Kind.MOTOR, 0, "q1", body=Body(cell(1)), d=cell("sqrt(-1 - L^2)"))
    with pytest.raises(NoValues, match=r"joint 1 \(one\), sqrt.*give them values"):
        parameter_values(Machine("m", (joint,), (Parameter("L"),)))


def test_states_cover_the_extremes() -> None:
    machine = chain(4, elastic=(2,), prismatic=(3,))
    moderate, extreme = moderate_states(machine, 10), extreme_states(machine, 64)
    assert moderate.q.shape == (10, 4) and moderate.tau.shape == (10, 3) and len(moderate) == 10
    assert np.array_equal(extreme.q, extreme_states(machine, 64).q)
    assert np.abs(moderate.q).max() <= math.pi and np.abs(moderate.qd).max() <= 2
    turns = extreme.q[:, [0, 3]] / (math.pi / 2)
    assert np.abs(extreme.q[:, 0]).max() > 1e6 and np.abs(extreme.q[:, 2]).max() <= 10
    assert np.any((extreme.q[:, 0] != 0) & (turns[:, 0] == np.round(turns[:, 0])))
    off = np.abs(extreme.q[:, [0, 3]] - np.round(turns) * (math.pi / 2))
    assert np.any((off > 0) & (off < 1e-15))
    speeds = np.abs(extreme.qd)
    assert speeds.max() > 1e5 and speeds[speeds > 0].min() < 1e-5 and np.any(np.all(speeds == 0, axis=1))
    assert np.abs(extreme.tau).max() > 1e6
    stiffness = next(p.value.value() for p in machine.parameters if p.name == "K2" and p.value)
    assert np.abs(extreme.q[:, 1]).max() * stiffness < 1.001e6


@in_digits(50)
def test_reference_solves_exactly() -> None:
    """Against the other derivation, in 50 digits."""
    machine = two_children(symbolic=True)
    values = parameter_values(machine)
    point = reference.Reference(machine, values, (), solved=True).at(moderate_states(machine, 1)[0].blocks)
    state = moderate_states(machine, 1)[0].blocks
    q, qd, tau, qdd_motor = (state[name].tolist() for name in ("q", "qd", "tau", "qdd_motor"))
    wanted = _decimals(multiprecision.direct_dynamics(machine, q, qd, tau, values))
    assert distance(point.model(trace(machine, "direct_dynamics"))["qdd"], wanted) < 1e-45
    torques, accelerations = map(_decimals, multiprecision.inverse_dynamics(machine, q, qd, qdd_motor, values))
    found = point.model(trace(machine, "inverse_dynamics"))
    assert distance(found["tau"], torques) < 1e-45
    assert distance(found["qdd"], accelerations) < 1e-45
    frames = [x for frame in multiprecision.geometric_model(machine, q, values) for row in frame for x in row]
    assert distance(point.model(trace(machine, "geometric_model"))["T"], _decimals(frames)) < 1e-45


def _decimals(numbers: Iterable[Any]) -> list[Decimal]:
    return [Decimal(mpmath.nstr(x, 60)) for x in numbers]
