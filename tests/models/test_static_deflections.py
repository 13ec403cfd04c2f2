"""Deflections of springs that are left out of the motion, against the rows of A qdd + H of the whole machine."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.formats import read_machine, read_scene
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.frames import with_base_coordinates
from symoro_elastic.machine.machine import Body, Floating, Kind, KnownOfBase, Machine, Orientation
from symoro_elastic.machine.resolve import resolve
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.static_springs import held_positions
from symoro_elastic.models.loops.plan import plan_of
from symoro_elastic.models.programs.catalogue import trace, trace_scene
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from symoro_elastic.numerics.verification.verify import verify
from symoro_elastic.symbolic.arithmetic import FLOATS, multiprecision
from tests.closed_chains.machines import machine as closed_chain
from tests.compiled_models import cell as f
from tests.models.test_scenes import is_motor, results, state_of, symbols, worst
from tests.references import multiprecision as reference
from tests.references.random_machines import chain, random_machine, two_children

pytestmark = pytest.mark.sampled(5)

EXAMPLES = Path(__file__).parents[2] / "examples"
MODELS = ("static_deflections", "geometric_model_with_deflections")
EXACT = 1e-40
HELD = ("0.013", "-1/7", "0.21")


@cache
def machines() -> tuple[Machine, ...]:
    trees = [
        random_machine(seed, joints=4 + seed % 5, symbolic=seed % 2 == 0, moving_base=seed % 3 == 0)
        for seed in range(8)
    ]
    return tuple(
        m for m in (*trees, chain(5, elastic=(2, 4), prismatic=(4,)), two_children(symbolic=True)) if m.elastic
    )


WITH_MODES = [
    ("flexible_arm.toml", ("shoulder_y2", "elbow_y1", "elbow_y2")),
    ("flexible_gantry.toml", ("bridge_y2", "bridge_z3", "bridge_torsion2", "shoe_rx")),
]


@pytest.mark.parametrize(("example", "names"), WITH_MODES)
def test_modes_balance_the_rows_of_the_whole_machine(example: str, names: tuple[str, ...]) -> None:
    """-q_E k = (A qdd + H)_E with modes E held at drawn deflections; interfaces and a carriage follow them."""
    rng, (machine, _) = np.random.default_rng(0), read_machine(EXAMPLES / example)
    place = {name: float(x) for name, x in zip(names, 0.01 * rng.normal(size=len(names)), strict=True)}
    kept = restrict(machine, Scene(static={name: f(x) for name, x in place.items()}))
    joints = [joint.name for joint in machine.independent_joints]
    R, E = ([k for k, name in enumerate(joints) if (name in names) == chosen] for chosen in (False, True))
    q, qd, qdd = np.array([[0.2], [1.0], [1.0]])[:, :, None] * rng.normal(size=(3, 1, len(joints)))
    q[:, E], qd[:, E], qdd[:, E] = [place[joints[k]] for k in E], 0.0, 0.0
    model = se.load(machine, ["inertia_matrix", "bias_forces"], fold=["all"])
    Gamma = model.inertia_matrix(q[0]) @ qdd[0] + model.bias_forces(q[0], qd[0])
    stiffness = np.array([machine.independent_joints[k].spring.stiffness.value() for k in E])
    found = se.load(kept, "static_deflections", fold=["all"]).static_deflections(*(x[0, R] for x in (q, qd, qdd)))
    assert found == pytest.approx(-Gamma[E] / stiffness, rel=1e-9, abs=1e-12 * np.abs(found).max())


VARIOUS = [pytest.param(machine, id=f"{k}-{machine.name}") for k, machine in enumerate(machines())]


def positions(machine: Machine, held: bool) -> dict[str, Formula | None]:
    """Some of the elastic joints, at positions or where their springs are neutral."""
    chosen = machine.elastic[:3]
    return {machine.joint(j).name: f(HELD[k % 3]) if held else None for k, j in enumerate(chosen)}


@pytest.mark.parametrize("held", [True, False], ids=["held", "neutral"])
@pytest.mark.parametrize("machine", VARIOUS)
def test_deflections_balance_the_rows_of_the_whole_machine(machine: Machine, held: bool) -> None:
    """k (q0 - q_E) = (A qdd + H)_E, in 50 digits, where the joints E stand still."""
    static, state = positions(machine, held), state_of(machine, 3)
    kept, arithmetic = restrict(machine, Scene(static=static)), multiprecision(50)
    given = symbols(kept, {j: state[j] for j in kept.independent}, arithmetic)
    E = [j for j in machine.independent if machine.joint(j).name in static]
    with mpmath.workdps(50):
        springs = {j: machine.joint(j).spring for j in E}
        neutral = {j: value(springs[j].neutral, given) for j in E}
        place = {j: value(static[machine.joint(j).name], given) for j in E} if held else neutral
        q = [place.get(j, state[j][0]) for j in machine.independent]
        qd = [0.0 if j in E else state[j][1] for j in machine.independent]
        qdd = [0.0 if j in E else 1.5 - 0.7 * k for k, j in enumerate(machine.independent)]
        Gamma = reference.generalized_forces(machine, q, qd, qdd)
        deflections = {j: -Gamma[machine.independent.index(j)] / value(springs[j].stiffness, given) for j in E}
        given |= {f"qdd{j}": arithmetic.number(x) for j, x in zip(machine.independent, qdd, strict=True)}
        (model,) = trace_scene(machine, Scene(MODELS[:1], static=static))
        found = results(model, given, arithmetic)["q_static"]
        assert worst(found, [neutral[j] + deflections[j] for j in E]) < EXACT


def value(formula: Formula | None, given: dict[str, Any]) -> Any:
    """The value of a cell in mpmath's precision."""
    assert formula is not None
    functions = {name: getattr(mpmath, name) for name in ("sin", "cos", "tan", "sqrt", "atan2")}
    return formula.evaluate({**given, "pi": mpmath.pi}, functions, lambda x: mpmath.mpf(x.numerator) / x.denominator)


@pytest.mark.parametrize("machine", VARIOUS[::2])
def test_frames_with_deflections_are_those_of_the_whole_machine(machine: Machine) -> None:
    static = positions(machine, held=True)
    _, model = trace_scene(machine, Scene(MODELS, static=static))
    given = symbols(machine, state_of(machine, 5), multiprecision(50))
    q = [state_of(machine, 5)[j][0] for j in machine.independent]
    found = results(model, given, multiprecision(50))["T"]
    assert worst(found, reference.geometric_model(machine, q)) < EXACT
    kept = restrict(machine, Scene(static=static))
    assert [len(argument.symbols) for argument in model.program.inputs] == [len(kept.independent), len(static)]


@pytest.mark.parametrize("at", [{}, {"motor_x": 0.3, "motor_y": 0.1}], ids=["zero", "away"])
def test_springs_held_at_their_equilibrium_stay_there(at: dict[str, float]) -> None:
    """The sag that Newton's method finds for all springs together."""
    machine, _ = read_machine(EXAMPLES / "two_axis.toml")
    sagging = replace(machine, base=replace(machine.base, gravity=tuple(f(x) for x in ("3", "-9", "2"))))
    motion = motion_of(sagging)
    state = equilibrium(motion, at)
    rest = dict(zip(motion.names, state.q.tolist(), strict=True))
    static = {name: f(repr(rest[name])) for name in ("bed_yaw", "cart_y", "ram", "sensor_head")}
    kept = restrict(sagging, Scene(static=static))
    (model,) = trace_scene(sagging, Scene(MODELS[:1], static=static))
    given = symbols(kept, {j: (rest[kept.joint(j).name], 0.0, 0.0) for j in kept.independent}, multiprecision(50))
    found = results(model, given, multiprecision(50))["q_static"]
    wanted = np.array([rest[joint.name] for joint in kept.static.values()])
    assert np.abs(wanted).max() > 1e-7
    assert np.abs(found.astype(float) - wanted).max() < 1e-9 * np.abs(wanted).max()


def test_a_static_joint_that_follows_others() -> None:
    """The nut slides with the screw, and yields: rows of A qdd + H of the whole machine with the nut at rest."""
    machine, _ = read_machine(EXAMPLES / "ball_screw.toml")
    static = {name: f("2e-6") for name in ("nut", "encoder")}
    kept = restrict(machine, Scene(static=static))
    arithmetic = multiprecision(50)
    found = trace_scene(machine, Scene(MODELS[:1], static=static))[0]
    A, H = trace_scene(machine, Scene(("inertia_matrix", "bias_forces")))
    given = symbols(machine, {j: (0.1 * j, 0.3 - 0.1 * j, 0.7 * j) for j in machine.independent}, arithmetic)
    E = [j for j in machine.independent if machine.joint(j).name in static]
    for j in E:
        given |= {str(machine.joint(j).variable): value(f("2e-6"), {}), f"qd{j}": 0, f"qdd{j}": 0}
    assert {kept.joint(j).kind for j in E} == {Kind.COUPLED, Kind.FIXED}
    with mpmath.workdps(50):
        qdd = np.array([given[f"qdd{j}"] for j in machine.independent], dtype=object)
        Gamma = results(A, given, arithmetic)["A"] @ qdd + results(H, given, arithmetic)["H"]
        wanted = [-Gamma[machine.independent.index(j)] / value(machine.joint(j).spring.stiffness, given) for j in E]
        assert abs(wanted[0]) > 1e-9
        assert worst(results(found, given, arithmetic)["q_static"] / wanted[0], np.array(wanted) / wanted[0]) < EXACT


@pytest.mark.parametrize("orientation", [None, *Orientation])
def test_code_is_within_rounding(orientation: Orientation | None) -> None:
    """numpy, C, C in batches; on a fixed and on a floating base."""
    machine, _ = read_machine(EXAMPLES / ("floating_arm.toml" if orientation else "two_axis.toml"))
    if machine.floating and orientation:
        machine = replace(machine, floating=replace(machine.floating, orientation=orientation))
        elastic = [j for j in machine.independent if not is_motor(machine, j)] or list(machine.independent[-1:])
        joints = list(machine.joints)
        spring = replace(joints[0].spring, stiffness=f(4e4))
        joints[elastic[-1] - 1] = replace(joints[elastic[-1] - 1], kind=Kind.ELASTIC, spring=spring)
        machine = replace(machine, joints=tuple(joints))
    scene = Scene(MODELS, static={machine.joint(machine.elastic[-1]).name: None})
    assert verify(machine, scene, states=(6, 8)).ok


def test_static_springs_leave_the_other_models_as_locking_does() -> None:
    machine, _ = read_machine(EXAMPLES / "two_axis.toml")
    static, locked = ({"cart_y": f("1e-6")}, {"cart_y": f("1e-6")})
    models = trace_scene(machine, Scene(static={**static}))
    assert [model.model.name for model in models] == ["direct_dynamics", "inverse_dynamics", "static_deflections"]
    for one, other in zip(models, trace_scene(machine, Scene(locked=locked)), strict=False):
        assert one.program.count == other.program.count


@pytest.mark.parametrize(
    ("example", "scene", "place", "reason"),
    [
        ("two_axis.toml", Scene(static={"motor_x": None}), "motor_x", "the joint is motor: only elastic joints"),
        ("two_axis.toml", Scene(static={"tool": None}), "tool", "the joint is fixed: only elastic joints"),
        ("all_keys.toml", Scene(static={"pendulum": None}), "pendulum", "the joint is passive: only elastic joints"),
        ("two_axis.toml", Scene(static={"ram": None}, locked={"ram": f(0)}), "ram", "locked too"),
        ("ball_screw.toml", Scene(static={"bearing": None}), "bearing", "nut follows its variable"),
        (
            "linkage.toml",
            Scene(static={"crank": None}),
            "crank",
            "part of loop parallelogram, whose forces are not part",
        ),
    ],
)
def test_springs_that_cannot_be_static(example: str, scene: Scene, place: str, reason: str) -> None:
    machine, _ = read_machine(EXAMPLES / example)
    with pytest.raises(InputError) as caught:
        restrict(machine, resolve(scene, machine))
    said = str(caught.value)
    assert said.startswith(f"{EXAMPLES / example}: scene, static, {place}: ") and reason in said
    assert "\n" not in said


@pytest.mark.parametrize(
    ("static", "place", "reason"),
    [
        ("{ ram = 0, 11 = 0 }", "scene, static", "a joint is given twice"),
        ('"ram"', "static", "list of texts"),
        ("[1]", "static", "list of texts"),
        ('["rm"]', "scene, static", "did you mean 'ram'"),
        ('{ ram = "x9" }', "scene, static, ram", "not declared"),
        ("{ ram = nan }", "static, ram", "not finite"),
    ],
)
def test_bad_lists_of_static_springs(static: str, place: str, reason: str, tmp_path: Path) -> None:
    machine, _ = read_machine(EXAMPLES / "two_axis.toml")
    path = tmp_path / "scene.toml"
    path.write_text(f"static = {static}\n")
    with pytest.raises(InputError) as caught:
        read_scene(path, machine)
    said = str(caught.value)
    assert said.startswith(f"{path}: {place}: ") and reason in said and "\n" not in said


def test_positions_are_of_all_static_joints_or_of_none() -> None:
    """Completed by those where springs are neutral, on the machine that is held already, too."""
    machine, _ = read_machine(EXAMPLES / "all_keys.toml")
    with pytest.raises(ValueError, match="of all static joints, or of none"):
        Scene(static={"gear": None, "other": f(0)})
    static = {"gear": None}
    for one in (machine, restrict(machine, Scene(static=static))):
        assert held_positions(one, static) == {"gear": f("0.002")}


def test_springs_without_a_stiffness_of_their_own_are_not_static() -> None:
    machine, _ = read_machine(EXAMPLES / "two_axis.toml")
    (ram,) = (joint for joint in machine.joints if joint.name == "ram")
    for stiffness, reason in (("0", "has no stiffness"), ("1e6 + q10", "its stiffness changes with q10")):
        soft = replace(ram, spring=replace(ram.spring, stiffness=f(stiffness)))
        other = replace(machine, joints=tuple(soft if joint is ram else joint for joint in machine.joints))
        with pytest.raises(InputError, match=reason):
            restrict(other, Scene(static={"ram": None}))


@pytest.mark.parametrize("model", MODELS)
def test_models_of_static_springs_need_some(model: str) -> None:
    machine, _ = read_machine(EXAMPLES / "two_axis.toml")
    with pytest.raises(InputError, match=f"{model}: no spring is static"):
        trace_scene(machine, Scene((model,)))


COUPLED = {
    "parallelogram": "wrist",
    "coaxial_geared": "hand",
    "coupled_wrist": "link_2",
    "parallelogram_loop": "wrist",
    "two_jack_arm": "bucket",
    "press": "die",
    "five_bar": "tool",
    "wedge": "load",
}


@pytest.mark.parametrize(("name", "joint"), COUPLED.items())
def test_static_springs_beside_couplings_and_loops(name: str, joint: str) -> None:
    """Rows of A qdd + H of the whole machine, whose loops run past the spring."""
    machine = closed_chain(name)
    (E,) = (j for j in machine.elastic if machine.joint(j).name == joint)
    arithmetic, variable = multiprecision(30), str(machine.joint(E).variable)
    given = {n: arithmetic.number(Fraction(x)) for n, x in assembled(machine).items()}
    static = {joint: f(repr(float(given[variable])))}
    for j in machine.independent:
        given |= {
            f"qd{j}": arithmetic.number((j != E) * 0.3 * j),
            f"qdd{j}": arithmetic.number((j != E) * (2 - 0.7 * j)),
        }
    found = trace_scene(machine, Scene(MODELS[:1], static=static))[0]
    A, H = trace_scene(machine, Scene(("inertia_matrix", "bias_forces")))
    with mpmath.workdps(30):
        qdd = np.array([given[f"qdd{j}"] for j in machine.independent], dtype=object)
        Gamma = results(A, given, arithmetic)["A"] @ qdd + results(H, given, arithmetic)["H"]
        spring = machine.joint(E).spring
        sag = -Gamma[machine.independent.index(E)] / value(spring.stiffness, given)
        deflection = results(found, given, arithmetic)["q_static"] - value(spring.neutral, given)
        assert abs(sag) > 1e-12
        assert worst(deflection / sag, np.array([1])) < 1e-15


def assembled(machine: Machine) -> dict[str, float]:
    """Values of parameters and variables at an assembled position."""
    plan = plan_of(machine)
    return plan.assembly.symbols(next(iter(plan.positions)))


def test_a_floating_base_as_joints_has_the_same_deflections() -> None:
    """The base as six joints, whose rows are renumbered, its acceleration that of these joints."""
    machine, _ = read_machine(EXAMPLES / "floating_arm.toml")
    last = machine.independent[-1]
    spring = replace(machine.joint(last).spring, stiffness=f(4e4), neutral=f("0.02"))
    rows = [replace(r, kind=Kind.ELASTIC, spring=spring) if j == last else r for j, r in enumerate(machine.joints, 1)]
    floating = Floating(Orientation.ROTATION, KnownOfBase.ACCELERATION, Body())
    soft = replace(machine, joints=tuple(rows), floating=floating)
    kept = restrict(soft, Scene(static={machine.joint(last).name: f("0.01")}))
    as_joints = with_base_coordinates(replace(kept, floating=replace(floating, known=KnownOfBase.WRENCH)))
    before = len(as_joints.joints) - len(kept.joints)
    rates = {j: (0.1 * j, 0.5 - 0.2 * j, 1.5 - 0.4 * j) for j in kept.independent}
    of_base = {f"A0_{m}{n}": float(m == n) for m in range(1, 4) for n in range(1, 4)}
    of_base |= {f"{x}0_{k}": 0.3 * k * (x == "Vd") for x in ("V", "Vd") for k in range(1, 7)}
    slides = {k: (0.0, 0.0, 0.3 * k) for k in range(1, 7)}
    given = [
        symbols(kept, rates, FLOATS) | of_base,
        symbols(as_joints, slides | {j + before: x for j, x in rates.items()}, FLOATS),
    ]
    models = [trace(one, MODELS[0]) for one in (kept, as_joints)]
    found, wanted = (results(*pair)["q_static"] for pair in zip(models, given, strict=True))
    assert abs(wanted[0] - 0.02) > 1e-6
    assert abs(found[0] - wanted[0]) < 1e-13
