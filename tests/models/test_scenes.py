"""A scene is the whole machine, asked for less: the same numbers, never more operations."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import generate, is_part
from symoro_elastic.generation.views import models_json
from symoro_elastic.machine.machine import Base, Kind, Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import ALL, Scene
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.packaging import summary
from symoro_elastic.models.programs.catalogue import TracedModel, trace_scene
from symoro_elastic.symbolic.arithmetic import FLOATS, Arithmetic, evaluate, multiprecision
from symoro_elastic.symbolic.expression import Expression
from symoro_elastic.symbolic.program import OperationCount
from tests.compiled_models import cell as f
from tests.generated_code import c_functions, c_work, imported, recount, rendered
from tests.references import multiprecision as reference
from tests.references.numbers_of_machine import numbers_of
from tests.references.random_machines import chain, planar_2r, random_machine, random_state, two_children

pytestmark = pytest.mark.sampled(5)

FIVE = ("direct_dynamics", "inverse_dynamics", "inertia_matrix", "bias_forces", "geometric_model")
EVERYTHING = Scene(models=FIVE)
CONTRACT = 1e-12
SAME = mpmath.mpf(10) ** -40
Array = np.ndarray[Any, Any]


@cache
def machines() -> tuple[Machine, ...]:
    trees = [
        random_machine(seed, joints=3 + seed % 6, symbolic=seed % 2 == 0, moving_base=seed % 3 == 0)
        for seed in range(8)
    ]
    return (*trees, chain(4, elastic=(2,), prismatic=(3,)), planar_2r(), two_children(symbolic=True))


VARIOUS = [pytest.param(machine, id=f"{k}-{machine.name}") for k, machine in enumerate(machines())]


def traces(machine: Machine, scene: Scene = EVERYTHING) -> dict[str, TracedModel]:
    return {model.model.name: model for model in trace_scene(machine, replace(scene, models=scene.models or FIVE))}


def symbols(machine: Machine, state: Mapping[int, tuple[Any, Any, Any]], arithmetic: Arithmetic) -> dict[str, Any]:
    """Values of every variable: `state` holds q, qd and tau (or motor acceleration) by joint number."""
    bound = Bound(machine)
    values = {p.name: bound.cell(p.value) if p.value else math.nan for p in machine.parameters}
    of = evaluate(values.values(), {}, arithmetic)
    found = {name: of(x) if isinstance(x, Expression) else arithmetic.number(x) for name, x in values.items()}
    for j, (q, qd, drive) in state.items():
        found |= {str(machine.joints[j - 1].variable): arithmetic.number(q), f"qd{j}": arithmetic.number(qd)}
        found |= {f"tau{j}": arithmetic.number(drive), f"qdd{j}": arithmetic.number(drive)}
    return found


def results(model: TracedModel, values: Mapping[str, Any], arithmetic: Arithmetic = FLOATS) -> dict[str, Array]:
    """The results of a traced model, from its graph."""
    entries = [x for output in model.program.outputs for x in output.entries]
    of = evaluate(entries, values, arithmetic)
    return {
        output.name: np.array([of(x) for x in output.entries], dtype=object).reshape(output.shape)
        for output in model.program.outputs
    }


def state_of(machine: Machine, seed: int) -> dict[int, tuple[float, float, float]]:
    q, qd, drives = random_state(machine, seed)
    drive = dict(zip((j for j in machine.independent if is_motor(machine, j)), drives, strict=True))
    return {j: (q[k], qd[k], drive.get(j, 0.0)) for k, j in enumerate(machine.independent)}


def is_motor(machine: Machine, j: int) -> bool:
    return machine.joints[j - 1].kind == Kind.MOTOR


def worst(found: Any, wanted: Any) -> float:
    """Largest difference over the largest entry, or over 1."""
    found, wanted = (np.asarray(x, dtype=object).ravel() for x in (found, wanted))
    assert found.shape == wanted.shape
    scale = max([1.0, *map(abs, wanted)])
    return float(max([0.0, *(abs(a - b) / scale for a, b in zip(found, wanted, strict=True))]))


def counts(model: TracedModel) -> tuple[int, int, int]:
    count = model.program.count
    return count.products, count.add, count.sincos


# Some outputs


@pytest.mark.sampled(6)
@pytest.mark.parametrize("machine", VARIOUS)
def test_some_outputs_are_those_of_the_whole(machine: Machine) -> None:
    """In the order asked; bit by bit, since the graph and its values are the same."""
    picks = (machine.independent[::2][::-1], machine.independent[-1:], machine.independent)
    whole = traces(machine)
    values = symbols(machine, state_of(machine, 4), FLOATS)
    for asked in picks:
        names = tuple(machine.joints[j - 1].name for j in asked)
        part = traces(machine, Scene(outputs=dict.fromkeys(FIVE, names)))
        for name, model in part.items():
            full, some = results(whole[name], values), results(model, values)
            assert full.keys() == some.keys()
            for output, entries in some.items():
                rows = [whole[name].rows[output].index(j) for j in model.rows[output]]
                wanted = full[output][rows][:, rows] if name == "inertia_matrix" else full[output][rows]
                assert (entries == wanted).all(), (name, output)
            assert all(less <= all_ for less, all_ in zip(counts(model), counts(whole[name]), strict=True)), name


@pytest.mark.parametrize("machine", VARIOUS)
def test_the_inverse_model_gives_what_is_asked_of_each_joint(machine: Machine) -> None:
    """Torques of motors; accelerations of the others, which nobody prescribes."""
    for j in machine.independent:
        asked = Scene(("inverse_dynamics",), outputs={"inverse_dynamics": (machine.joints[j - 1].name,)})
        (model,) = trace_scene(machine, asked)
        if len(machine.independent) > 1:
            assert model.rows == ({"tau": (j,), "qdd": ()} if is_motor(machine, j) else {"tau": (), "qdd": (j,)})


@pytest.mark.thorough
def test_no_outputs_means_all() -> None:
    machine = machines()[2]
    empty = traces(machine, Scene(outputs=dict.fromkeys(FIVE, ())))
    for name, model in traces(machine).items():
        assert (empty[name].rows, empty[name].program.count) == (model.rows, model.program.count)
    assert rendered(machine, Scene(outputs=dict.fromkeys(FIVE, ()))) == rendered(machine)


@pytest.mark.parametrize("machine", VARIOUS)
def test_frames_are_asked_by_name_fixed_ones_too(machine: Machine) -> None:
    names = tuple(joint.name for joint in machine.joints[::-1])
    scene = Scene(("geometric_model",), outputs={"geometric_model": names})
    (model,) = trace_scene(machine, scene)
    q = [x for x, _, _ in state_of(machine, 1).values()]
    wanted = reference.geometric_model(machine, q)[::-1]
    assert model.rows == {"T": tuple(range(len(names), 0, -1))}
    assert worst(results(model, symbols(machine, state_of(machine, 1), FLOATS))["T"], wanted) < CONTRACT


def test_rows_of_results_are_named_in_the_package(tmp_path: Path) -> None:
    scene = Scene(FIVE, outputs={"direct_dynamics": ("joint4", "joint1"), "geometric_model": ("frame7",)})
    machine = two_children()
    generate(machine, scene, ["numpy"], tmp_path)
    module = imported(tmp_path / "two_children")
    assert module.OUTPUTS["direct_dynamics"] == {"qdd": ("joint4", "joint1")}
    assert module.OUTPUTS["geometric_model"] == {"T": ("frame7",)}
    q, qd, tau = random_state(machine, 0)
    whole = [float(x) for x in reference.direct_dynamics(machine, q, qd, tau)]
    assert worst(module.direct_dynamics(q, qd, tau), [whole[3], whole[0]]) < CONTRACT
    assert module.geometric_model(q).shape == (1, 4, 4)
    assert module.inertia_matrix(q).shape == (6, 6)


# Locked joints


def constrained(machine: Machine, held: dict[int, Fraction], seed: int) -> dict[str, Any]:
    """The models of the whole machine with some joints held: A and H of the whole, rows and columns struck out."""
    state = state_of(machine, seed)
    q = [held.get(j, state[j][0]) for j in machine.independent]
    qd = [0.0 if j in held else state[j][1] for j in machine.independent]
    A = np.array(reference.inertia_matrix(machine, q), dtype=object)
    H = np.array(reference.bias_forces(machine, q, qd), dtype=object)
    free = [k for k, j in enumerate(machine.independent) if j not in held]
    motors = [k for k in free if is_motor(machine, machine.independent[k])]
    soft = [k for k in free if k not in motors]
    springs = numbers_of(machine)
    with mpmath.workdps(50):
        gamma = np.zeros(len(q), dtype=object)
        for k in free:
            row, (_, _, drive) = springs.joints[machine.independent[k] - 1], state[machine.independent[k]]
            law = -row.stiffness * (q[k] - row.neutral) - row.damping * qd[k]
            gamma[k] = drive if k in motors else law if row.kind == Kind.ELASTIC else 0
        qdd = np.zeros(len(q), dtype=object)
        qdd[free] = solved(A[np.ix_(free, free)], (gamma - H)[free])
        driven = np.zeros(len(q), dtype=object)
        for k in motors:
            driven[k] = state[machine.independent[k]][2]
        driven[soft] = solved(A[np.ix_(soft, soft)], (gamma - H - A @ driven)[soft])
        tau = (A @ driven + H)[motors]
    return {
        "direct_dynamics": {"qdd": qdd[free]},
        "inverse_dynamics": {"tau": tau, "qdd": driven[free]},
        "inertia_matrix": {"A": A[np.ix_(free, free)]},
        "bias_forces": {"H": H[free]},
        "geometric_model": {"T": np.array(reference.geometric_model(machine, q), dtype=object)},
    }


def solved(matrix: Array, right: Array) -> Array:
    if not len(right):
        return right
    return np.array(list(mpmath.lu_solve(mpmath.matrix(matrix.tolist()), mpmath.matrix(right.tolist()))), dtype=object)


@pytest.mark.thorough
@pytest.mark.parametrize("machine", VARIOUS)
def test_a_locked_joint_is_the_whole_machine_constrained(machine: Machine) -> None:
    """Each joint in turn, then two at once, against the 50-digit reference of the whole machine."""
    values = (Fraction(3, 10), Fraction(0), Fraction(-7, 4))
    cases = [{j: values[k % 3]} for k, j in enumerate(machine.independent)]
    cases.append({j: Fraction(1, 5) for j in machine.independent[:2]})
    whole = traces(machine)
    for held in cases:
        scene = Scene(FIVE, locked={machine.joints[j - 1].name: f(value) for j, value in held.items()})
        wanted = constrained(machine, held, 7)
        kept = restrict(machine, scene)
        assert kept.independent == tuple(j for j in machine.independent if j not in held)
        numbers = symbols(kept, {j: x for j, x in state_of(machine, 7).items() if j not in held}, FLOATS)
        for name, model in traces(machine, scene).items():
            for output, entries in results(model, numbers).items():
                assert worst(entries, wanted[name][output]) < CONTRACT, (name, output, held)
            assert model.program.count.products <= whole[name].program.count.products, (name, held)


def test_a_joint_is_locked_at_a_formula(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "examples" / "planar_2r.toml").read_text(encoding="utf-8")
    machine = toml.read(text + '\n[scene]\nlocked = { elbow = "pi/2 - l1/l2" }\n', "planar_2r.toml")
    assert machine.asked.scene
    generate(machine, machine.asked.scene, ["numpy"], tmp_path)
    module = imported(tmp_path / "planar_2r")
    assert module.JOINTS == ("shoulder",) and module.MOTORS == (0,)
    whole = machine.asking(scene=None)
    elbow = math.pi / 2 - 4 / 3
    A = reference.inertia_matrix(whole, [0.3, elbow])
    H = reference.bias_forces(whole, [0.3, elbow], [0.7, 0])
    assert worst(module.direct_dynamics([0.3], [0.7], [5.0]), [(5 - H[0]) / A[0][0]]) < CONTRACT


@pytest.mark.parametrize("length", ["pi/10", "2*pi", "D3*pi"])
def test_lengths_may_hold_pi(length: str) -> None:
    """A slide locked at a multiple of pi, as a lead of a screw is one."""
    machine = chain(3, prismatic=(2,))
    scene = Scene(FIVE, locked={"joint2": f(length)})
    value = f(length).value({p.name: p.value.value() for p in machine.parameters if p.value})
    wanted = constrained(machine, {2: Fraction(value)}, 3)
    kept = restrict(machine, scene)
    numbers = symbols(kept, {j: x for j, x in state_of(machine, 3).items() if j != 2}, FLOATS)
    for name, model in traces(machine, scene).items():
        for output, entries in results(model, numbers).items():
            assert worst(entries, wanted[name][output]) < CONTRACT, name


def test_all_joints_locked_leaves_the_frames(tmp_path: Path) -> None:
    machine = two_children()
    locked = {machine.joints[j - 1].name: f("0.25") for j in machine.independent}
    generate(machine, Scene(FIVE, locked=locked), ["numpy", "c"], tmp_path)
    module = imported(tmp_path / "two_children")
    assert module.JOINTS == module.MOTORS == () and len(module.FRAMES) == 7
    assert module.direct_dynamics([], [], []).shape == (0,)
    assert module.inertia_matrix(np.zeros((5, 0))).shape == (5, 0, 0)
    wanted = reference.geometric_model(machine, [Fraction(1, 4)] * 6)
    assert worst(module.geometric_model([]), wanted) < CONTRACT


# Gravity and folded parameters


@pytest.mark.thorough
@pytest.mark.parametrize("machine", VARIOUS)
def test_without_gravity(machine: Machine) -> None:
    weightless = replace(machine, base=replace(machine.base, gravity=Base().gravity))
    q, qd, drives = random_state(machine, 2)
    wanted = {
        "direct_dynamics": {"qdd": reference.direct_dynamics(weightless, q, qd, drives)},
        "bias_forces": {"H": reference.bias_forces(weightless, q, qd)},
        "inverse_dynamics": dict(
            zip(("tau", "qdd"), reference.inverse_dynamics(weightless, q, qd, drives), strict=True)
        ),
    }
    whole = traces(machine)
    values = symbols(machine, state_of(machine, 2), FLOATS)
    for name, model in traces(machine, Scene(gravity=False)).items():
        for output, entries in results(model, values).items():
            if name in wanted:
                assert worst(entries, wanted[name][output]) < CONTRACT, (name, output)
        assert all(less <= more for less, more in zip(counts(model), counts(whole[name]), strict=True)), name


def test_at_rest_without_gravity_nothing_pushes() -> None:
    machine = random_machine(5, joints=7, wrenches=False)
    (model,) = trace_scene(machine, Scene(("bias_forces",), gravity=False))
    still = {j: (q, 0.0, 0.0) for j, (q, _, _) in state_of(machine, 5).items()}
    assert not results(model, symbols(machine, still, FLOATS))["H"].any()


@pytest.mark.parametrize("machine", [p for p in VARIOUS if p.values[0].parameters])
@pytest.mark.parametrize("which", ["all", "some"])
def test_folding_changes_no_value(machine: Machine, which: str) -> None:
    """In 50 digits the same as with the parameters at their defaults.

    Hardly ever more operations: what is factored out depends on which factors are constants.
    """
    scene = Scene(fold=ALL if which == "all" else tuple(p.name for p in machine.parameters[::3]))
    many = multiprecision(50)
    values = symbols(machine, state_of(machine, 3), many)
    whole, part = traces(machine), traces(machine, scene)
    for name, model in part.items():
        full = results(whole[name], values, many)
        for output, entries in results(model, values, many).items():
            assert worst(entries, full[output]) < SAME, (name, output)
        assert sum(counts(model)) <= 1.03 * sum(counts(whole[name])), name
        assert which == "some" or model.program.count_once == OperationCount()
        assert not model.program.used & set(machine_names(machine, scene))


def machine_names(machine: Machine, scene: Scene) -> tuple[str, ...]:
    return tuple(p.name for p in machine.parameters) if scene.fold == ALL else tuple(scene.fold)


def test_folded_code_gives_the_numbers_of_the_defaults(tmp_path: Path) -> None:
    machine = random_machine(8, joints=8, symbolic=True)
    q, qd, tau = random_state(machine, 1)
    generate(machine, Scene(FIVE), ["numpy"], tmp_path / "whole")
    generate(machine, Scene(FIVE, fold=ALL), ["numpy"], tmp_path / "folded")
    whole, folded = (imported(tmp_path / kind / machine.name) for kind in ("whole", "folded"))
    assert folded.PARAMETERS == () and len(whole.PARAMETERS) > 20
    for name, arguments in (("direct_dynamics", (q, qd, tau)), ("bias_forces", (q, qd)), ("inertia_matrix", (q,))):
        exact = getattr(reference, name)(machine, *arguments)
        errors = [worst(getattr(module, name)(*arguments), exact) for module in (whole, folded)]
        assert max(errors) < 1e-14, (name, errors)


def test_values_may_be_formulas_when_they_are_folded() -> None:
    machine = planar_2r()
    valued = replace(machine, parameters=tuple(replace(p, value=f("sqrt(2)*sin(pi/3)/3")) for p in machine.parameters))
    assert all(
        model.program.used <= {"q1", "q2", "qd1", "qd2", "tau1", "tau2", "qdd1", "qdd2"}
        for model in traces(valued, Scene(fold=ALL)).values()
    )


def test_constants_of_formulas_are_exact() -> None:
    """No float creeps in where functions of constants are divided by each other."""
    bound = Bound(planar_2r())
    third = Fraction(1, 3)
    for text in (
        "1/3 + tan(0)",
        "1/3 + sin(0)/cos(0)",
        "cos(0)/(3*cos(2*pi))",
        "L1/L1/3",
        "sqrt(4)/6",
        "sin(pi/6)/1.5",
    ):
        value = bound.cell(f(text))
        assert value == third and isinstance(value, Fraction), text
    assert bound.cell(f("L1 - L1")) == bound.cell(f("tan(pi)")) == 0
    assert bound.cell(f("tan(pi/4)*L1")) is bound.cell(f("L1"))


# What cannot be given


@pytest.mark.parametrize("model", [name for name in FIVE if name != "geometric_model"])
def test_joints_that_do_not_move_have_no_part_in_joint_models(model: str, tmp_path: Path) -> None:
    machine = replace(two_children(), source="machine.toml")
    fixed = Scene((model,), outputs={model: ("joint1", "frame7")})
    with pytest.raises(InputError) as caught:
        generate(machine, fixed, ["c"], tmp_path / "out")
    assert str(caught.value).startswith(f"machine.toml: scene, outputs, {model}: joint 7 (frame7) is a fixed frame ")
    locked = Scene((model,), outputs={model: ("joint2",)}, locked={"joint2": f(0)})
    with pytest.raises(InputError, match=rf"machine\.toml: scene, outputs, {model}: joint 2 \(joint2\) is locked"):
        generate(machine, locked, ["c"], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_locked_joint_keeps_its_frame() -> None:
    machine = two_children()
    scene = Scene(("geometric_model",), outputs={"geometric_model": ("joint2",)}, locked={"joint2": f("1/3")})
    (model,) = trace_scene(machine, scene)
    q = [0.1, Fraction(1, 3), 0.2, 0.3, 0.4, 0.5]
    state = {j: (x, 0, 0) for j, x in enumerate(q, start=1) if j != 2}
    found = results(model, symbols(restrict(machine, scene), state, FLOATS))["T"]
    assert worst(found, [reference.geometric_model(machine, q)[1]]) < CONTRACT


def test_a_parameter_without_value_cannot_be_folded(tmp_path: Path) -> None:
    machine = planar_2r()
    machine = replace(machine, parameters=(replace(machine.parameters[0], value=None), *machine.parameters[1:]))
    name = machine.parameters[0].name
    with pytest.raises(InputError, match=f"planar_2r: scene, fold: {name} has no value"):
        generate(machine, Scene(fold=(name,)), ["c"], tmp_path / "out")
    assert not (tmp_path / "out").exists()
    made = generate(machine, Scene(fold=ALL), ["numpy"], tmp_path)
    assert (name,) == imported(made.written[0].parent).PARAMETERS


# The figures


@pytest.mark.parametrize(
    "scene",
    [
        Scene(gravity=False),
        Scene(fold=ALL),
        Scene(locked={"joint2": f("0.3")}),
        Scene(outputs={"direct_dynamics": ("joint1",)}),
        Scene(("bias_forces", "inertia_matrix"), fold=("IA1",), gravity=False),
    ],
    ids=["no gravity", "fold", "locked", "outputs", "several"],
)
def test_operations_saved_are_those_of_the_texts(scene: Scene, tmp_path: Path) -> None:
    """whole, asked and saved, each counted again in the C text of the whole machine and of the part."""
    machine = chain(4, elastic=(3,))
    made = generate(machine, scene, ["c"], tmp_path)
    found = models_json(made.models, made.whole)
    assert is_part(scene) and list(found) == list(scene.models or ("direct_dynamics", "inverse_dynamics"))
    part = (tmp_path / "chain4" / "chain4.c").read_text(encoding="utf-8")
    whole = rendered(machine, Scene(tuple(found)), ["c"])["chain4.c"]
    for name, figures in found.items():
        asked, full = (json_counts(text, f"chain4_{name}") for text in (part, whole))
        assert {key: figures[key] for key in asked} == asked
        assert figures["whole"] == full
        assert figures["saved"] == {key: full[key] - asked[key] for key in full}
    assert sum(sum(figures["saved"].values()) for figures in found.values()) > 0


def json_counts(text: str, function: str) -> dict[str, int]:
    _, each = c_work(c_functions(text), function)
    count = recount(each)
    return {"mul": count.mul, "add": count.add, "div": count.div, "sincos": count.sincos}


def test_the_whole_machine_saves_nothing(tmp_path: Path) -> None:
    machine = planar_2r()
    made = generate(machine, Scene(), ["c"], tmp_path)
    assert made.whole is made.models
    assert all(
        figures.keys() == {"mul", "add", "div", "sincos", "once"}
        for figures in models_json(made.models, made.whole).values()
    )


def test_scenes_in_words() -> None:
    assert summary(Scene(fold=ALL)) == ""
    said = summary(Scene(locked={"a": f("0.3"), "b": f("L/2")}, gravity=False))
    assert said == "a held at 0.3, b held at L/2, without gravity"
    header = rendered(planar_2r(), Scene(("bias_forces",)), ["c"])["planar_2r.h"]
    assert header.startswith("/* planar_2r: generated models.\n")
